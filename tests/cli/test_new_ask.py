"""``wucht new --ask`` as on a terminal: five questions, from whose answers a file follows that runs at once."""

from __future__ import annotations

import os
import select
import sys
import time
import tomllib
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import pytest

pty = pytest.importorskip("pty", reason="there are no pseudo-terminals")

Command = Callable[..., Any]
Refused = Callable[..., str]

PROGRAM = str(Path(sys.executable).with_name("wucht"))
CTRL_C, ENTER = "\x03", "\n"


def dialog(*answers: str, file: Sequence[str] = ()) -> tuple[int, str]:
    """Exit code and what the terminal showed; each answer is given once the program asks."""
    child, terminal = pty.fork()
    if child == 0:
        os.execv(PROGRAM, [PROGRAM, "new", "--ask", *file])
    shown = b""
    for answer in answers:
        end = time.monotonic() + 60
        while not shown.rstrip().endswith(b"]:") and time.monotonic() < end:
            if select.select([terminal], [], [], 1.0)[0]:
                shown += os.read(terminal, 65536)
        os.write(terminal, answer.encode())
        shown += b"\r\n"
    while True:
        try:
            part = os.read(terminal, 65536)
        except OSError:  # the end on Linux
            break
        if not part:
            break
        shown += part
    os.close(terminal)
    return os.waitstatus_to_exitcode(os.waitpid(child, 0)[1]), shown.decode()


OUTCOMES = {"screen": "synchronised", "drum": "compensated", "fan": "passed", "rig": "balancer-captured"}


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("purpose", "outcome"),
    [pytest.param(*case, marks=() if case[0] == "fan" else pytest.mark.slow) for case in OUTCOMES.items()],
)
def test_what_is_usual_runs_at_once(wucht: Command, here: Path, purpose: str, outcome: str) -> None:
    code, shown = dialog(f"{purpose}\n", ENTER, ENTER, ENTER, ENTER)
    assert code == 0, shown
    assert shown.count("]:") == 5
    assert f"my-{purpose}.toml: edit it" in shown
    done = wucht("run", f"my-{purpose}.toml", "--json")
    assert done.code == 0, done.err
    assert done.document["summary"]["outcome"] == outcome
    text = Path(f"my-{purpose}.toml").read_text(encoding="utf-8")
    assert tomllib.loads(text)["machine"]["purpose"] == purpose
    assert "# estimate" in text


@pytest.mark.usefixtures("no_figures")
def test_the_answers_stand_in_the_file_as_they_were_given(wucht: Command, here: Path) -> None:
    code, shown = dialog(
        ENTER, "2.4 t, 150 1/min, 0.04\n", "90 kg, 450 kg cm, 0.7 kg m^2\n", "4 kW, 1460 rpm, 690 V, 50 Hz, 3, 2.5\n",
        "voltage-dip\n", file=["plant.toml"],
    )  # fmt: skip
    assert code == 0, shown
    document = tomllib.loads(Path("plant.toml").read_text(encoding="utf-8"))
    machine = document["machine"]
    assert (machine["carrier"]["mass"], machine["carrier"]["frequency"]) == ("2.4 t", "150 1/min")
    assert [body["unbalance"] for body in machine["bodies"]] == ["450 kg cm"] * 2
    assert [drive.get("sense", 1) for drive in machine["drives"]] == [1, -1]
    assert machine["drives"][0]["nameplate"] == {
        "power": "4 kW", "speed": "1460 rpm", "voltage": "690 V", "frequency": "50 Hz", "breakdown_torque_ratio": 3,
        "starting_torque_ratio": 2.5,
    }  # fmt: skip
    assert document["study"] == {"kind": "voltage-dip", "depth": 1}
    # by hand: stroke 2 U sum/M with 4.5 kg m on each of two exciters and all masses
    summary = wucht("run", "plant.toml", "--json", "--set", "study.kind=run-up").document["summary"]
    assert summary["stroke"] == pytest.approx(2 * 2 * 4.5 / (2400 + 2 * 90), rel=0.03)


def test_a_wrong_answer_is_asked_for_again(here: Path) -> None:
    code, shown = dialog(
        "sieve\n", "fan\n", "120 kg, 5 Hz\n", "120, 5 Hz, 0.05\n", "120 kg, 5 kg, 0.05\n", "-120 kg, 5 Hz, 0.05\n", ENTER,
        "40 kg, 2 kg m, 0.01 kg m^2\n", ENTER, ENTER, "cam-law\n", ENTER,
    )  # fmt: skip
    assert code == 0, shown
    for sentence in (
        "one of screen, drum, fan, rig", "these are 2 values; needed are 3", "give 120 with its unit", "must be greater than 0",
        "moment of inertia: must be at least U^2/m = 0.1 kg m^2", "one of run-up",
    ):  # fmt: skip
        assert sentence in shown, sentence
    assert shown.count("Error:") == 7
    assert Path("my-fan.toml").is_file()


def test_ctrl_c_writes_nothing(here: Path) -> None:
    for answers in ([CTRL_C], ["fan\n", ENTER, ENTER, ENTER, CTRL_C]):
        code, shown = dialog(*answers)
        assert code == 130, shown
        assert "wucht: interrupted" in shown
    assert list(here.iterdir()) == []


def test_without_a_terminal_and_with_bad_names(refused: Refused, here: Path) -> None:
    refused("new", "--ask", says=("--ask", "need a terminal", "wucht new run-up"))
    refused("new", says=("NAME", "--ask"))
    refused("new", "--ask", "a.toml", "b.toml", says=("b.toml", "one name"))
    Path("mine.toml").write_text("", encoding="utf-8")
    code, shown = dialog(file=["mine.toml"])
    assert code == 2
    assert "exists already" in shown
