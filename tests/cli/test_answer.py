"""``wucht answer``: all that the designer of a machine asks, as one report."""

from __future__ import annotations

import json
import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import wucht as package
from wucht.machines.purpose import Purpose, purpose_of_parts

Command = Callable[..., Any]
Study = Callable[..., Path]
Refused = Callable[..., str]

PROGRAM = Path(sys.executable).with_name("wucht")
FAN = """\
title = "A fan"
[machine.carrier]
mass = "40 kg"
directions = "y"
stiffness = "60 kN/m"
damping = "200 N s/m"
[[machine.bodies]]
kind = "rotor"
name = "impeller"
mass = "8 kg"
unbalance = "2e-3 kg m"
inertia = "0.12 kg m^2"
[machine.drive]
kind = "linear"
slope = "0.4 N m s"
no_load_speed = "150 rad/s"
[[machine.loads]]
kind = "quadratic"
coefficient = "2e-4 N m s^2"
"""


@pytest.mark.slow
def test_a_fan_is_answered_in_one_report(wucht: Command, here: Path) -> None:
    Path("fan.toml").write_text(FAN, encoding="utf-8")
    done = wucht("answer", "fan.toml", "--json")
    assert done.code == 0, done.err
    document = done.document
    answered = ["run-up", "torque-balance", "response", "start-stop"]
    assert list(document["summary"]) == answered
    assert "voltage" in document["left_out"]["voltage-dip"], "its drive has no voltage that could dip"
    assert document["summary"]["run-up"]["outcome"] == "passed"
    # the slope of the motor is 0.4 (150 - w), its load 2e-4 w^2: they balance at the speed without vibration
    balance = -0.4 / (2 * 2e-4) + ((0.4 / (2 * 2e-4)) ** 2 + 0.4 * 150 / 2e-4) ** 0.5
    assert document["summary"]["torque-balance"]["operating_speed"] == pytest.approx(balance, rel=1e-3)
    report = Path(document["files"][0])
    assert report == Path("results/fan/report.html")
    page = report.read_text(encoding="utf-8")
    assert [f'href="#r{k}"' in page for k in range(1, 7)] == [True] * 4 + [False] * 2
    assert page.count("drawing of A fan") == 1
    assert all(Path(f"results/fan/{kind}/result.nc").is_file() for kind in answered)


@pytest.mark.usefixtures("no_figures")
def test_the_question_of_the_file_comes_first_and_settings_hold_for_all(wucht: Command, here: Path) -> None:
    question = '[study]\nkind = "coast-down"\nuntil = "2 s"\n'
    Path("fan.toml").write_text(FAN + question, encoding="utf-8")
    document = wucht("answer", "fan.toml", "--json", "-o", "out", "--set", "impeller.unbalance=1e-3").document
    assert next(iter(document["summary"])) == "coast-down"
    for kind in document["summary"]:
        result = package.load(f"out/{kind}")
        assert result.wucht.machine["parameters"]["impeller.unbalance"] == 1e-3, kind


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_resume_keeps_what_is_complete(wucht: Command, here: Path) -> None:
    Path("fan.toml").write_text(FAN, encoding="utf-8")
    assert wucht("answer", "fan.toml", "-o", "out").code == 0
    created = {kind: package.load(f"out/{kind}").attrs["created"] for kind in ("run-up", "response")}
    Path("out/response/result.nc").unlink()
    assert wucht("answer", "fan.toml", "-o", "out", "--resume").code == 0
    assert package.load("out/run-up").attrs["created"] == created["run-up"]
    assert package.load("out/response").attrs["created"] > created["response"]


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_one_that_fails_does_not_stop_the_others(wucht: Command, here: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    from wucht.errors import RunError
    from wucht.studies.torque_balance import TorqueBalance

    def fails(*_: object) -> Any:
        raise RunError("the integration stopped at t = 1 s")
        yield

    monkeypatch.setattr(TorqueBalance, "solve", fails)
    Path("fan.toml").write_text(FAN, encoding="utf-8")
    done = wucht("answer", "fan.toml", "-o", "out")
    assert done.code == 1
    assert "wucht: 1 of 5 questions failed: torque-balance: the integration stopped at t = 1 s" in done.err
    assert "  torque-balance       failed: the integration stopped" in done.out
    assert Path("out/report.html").is_file() and Path("out/response/result.nc").is_file()
    error = wucht("answer", "fan.toml", "-o", "out", "--json").document
    assert (error["exit_code"], list(error["failed"])) == (1, ["torque-balance"])


@pytest.mark.slow
def test_ctrl_c_leaves_a_report_of_what_there_is(here: Path) -> None:
    Path("fan.toml").write_text(FAN, encoding="utf-8")
    process = subprocess.Popen(
        [PROGRAM, "answer", "fan.toml", "-o", "out"], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True, env=os.environ
    )
    end = time.monotonic() + 120
    while not Path("out/run-up/result.nc").is_file() and time.monotonic() < end:
        time.sleep(0.02)
    process.send_signal(signal.SIGINT)
    out, err = process.communicate(timeout=120)
    assert process.returncode == 130, err
    assert "questions have an answer; --resume continues from there" in err
    assert "report: out/report.html" in out
    page = Path("out/report.html").read_text(encoding="utf-8")
    assert "run-up" in page
    completed = subprocess.run(
        [PROGRAM, "answer", "fan.toml", "-o", "out", "--resume", "--json"], capture_output=True, text=True, check=True
    )
    assert len(json.loads(completed.stdout)["summary"]) == 4


PURPOSES = {
    "practice/screen": "screen",
    "sperling-vibration/self-synchronisation-soft": "screen",
    "practice/laundry-drum": "drum",
    "practice/grinder-4-balls": "drum",
    "practice/fan-on-belt": "fan",
    "practice/exciter": "rig",
    "sperling-vibration/figure-5": None,
}


@pytest.mark.parametrize(("name", "purpose"), PURPOSES.items())
def test_purposes_are_told_by_the_parts(name: str, purpose: str | None) -> None:
    assert purpose_of_parts(package.load_machine(name)) == (None if purpose is None else Purpose(purpose))


@pytest.mark.slow
@pytest.mark.usefixtures("no_figures")
def test_a_purpose_that_a_file_states_holds_also_for_a_file_that_uses_it(wucht: Command, here: Path) -> None:
    Path("machine.toml").write_text('[machine]\npurpose = "rig"\n' + FAN.partition("\n")[2], encoding="utf-8")
    Path("using.toml").write_text('[machine]\nuse = "machine.toml"\n', encoding="utf-8")
    Path("other.toml").write_text('[machine]\nuse = "machine.toml"\npurpose = "fan"\n', encoding="utf-8")
    assert "speed-curve" in wucht("answer", "using.toml", "--json", "-o", "rig").document["summary"]
    assert "speed-curve" not in wucht("answer", "other.toml", "--json", "-o", "fan").document["summary"]


def test_bad_input(refused: Refused, here: Path) -> None:
    Path("bad.toml").write_text('[machine]\npurpose = "scren"\n' + FAN.partition("\n")[2], encoding="utf-8")
    Path("number.toml").write_text("[machine]\npurpose = 3\n" + FAN.partition("\n")[2], encoding="utf-8")
    Path("no-load.toml").write_text(FAN.partition("[[machine.loads]]")[0], encoding="utf-8")
    refused("answer", "bad.toml", says=("machine.purpose", "did you mean 'screen'"))
    refused("answer", "number.toml", says=("machine.purpose", "given 3", "drum, fan, rig, screen"))
    refused("answer", "no-load.toml", says=("no-load.toml", "machine.purpose", '"screen", "drum", "fan", "rig"'))
    refused("answer", "kaltofen-cam/dwell-and-return", says=("only of a machine", "wucht run"))
    refused("answer", "drozdetskaya-2020/figure-2.13", "--json", says=("only of a machine",))
    refused("answer", "practice/scren", says=("practice/screen",))
    refused("answer", "practice/screen", "--set", "e1.masss=3", says=("masss", "unknown"))
    Path("taken").write_text("", encoding="utf-8")
    refused("answer", "practice/fan-on-belt", "-o", "taken", "--json", says=("-o",))
