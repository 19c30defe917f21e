"""The last line of ``wucht run``: a command that could follow, which is accepted for the file that was run."""

from __future__ import annotations

import shlex
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest

import wucht as package
from wucht.cli.options import parse_settings
from wucht.studies.machine_facts import facts_of_machine, motors_that_start
from wucht.studies.registry import studies
from wucht.studies.study_file import read_study

Command = Callable[..., Any]
Study = Callable[..., Path]

_NUMBERS = {"advised_time": 2.5}  # of a summary, that settings name
_HEAVY = {"starting_torque": {"drum": 2.0}, "weight_moment": {"drum": 3.0}, "load_torque": {"drum": 1.0}}
_EXCITERS = "practice/screen"
_DRIVEN_CAM = "practice/carton-pusher"  # with the shaft that a prediction needs


def _next(out: str) -> list[str]:
    """The words of the last line's command."""
    line = out.splitlines()[-1]
    assert line.startswith("next: wucht ")
    return shlex.split(line.removeprefix("next: "), comments=True)[1:]


@pytest.mark.slow
def test_every_proposed_question_is_accepted_for_a_file_of_its_study(here: Path) -> None:
    """Whatever the outcome was: with the machine and the keys of the file the next study prepares its plan."""
    file = here / "study.toml"
    for kind, study in studies().items():
        if not study.study.next_questions:
            continue
        file.write_text(study.template, encoding="utf-8")
        name, chosen = (_DRIVEN_CAM, {"study.kind": kind}) if kind.startswith("cam-") else (str(file), {})
        asked = read_study(name, chosen)
        for question in asked.spec.next_questions:
            summary = _NUMBERS | ({"outcome": question.outcomes[0]} if question.outcomes else {})
            has_rotors = "synchronised" in question.outcomes  # which ends so with several rotors only
            of_file, its = (_EXCITERS, read_study(_EXCITERS, {"study.kind": kind})) if has_rotors else (name, asked)
            known = its.spec.to_table() | facts_of_machine(its.subject)
            known["motors_that_start"] = motors_that_start(its.subject, _HEAVY)
            settings = question.settings_after(summary, known)
            assert settings is not None, kind
            following = read_study(of_file, parse_settings([f"{key}={value}" for key, value in settings.items()]))
            assert following.spec.kind == settings.get("study.kind", kind)
            following.spec.prepare(following.subject)


def test_outcomes_are_ones_that_there_are() -> None:
    from wucht.dynamics.limit_sets.limit_set import MotionKind
    from wucht.dynamics.verdicts.outcomes import Outcome

    named = {o for study in studies().values() for question in study.study.next_questions for o in question.outcomes}
    assert named <= {outcome.value for outcome in (*Outcome, *MotionKind)}


@pytest.mark.usefixtures("no_figures")
def test_the_command_of_a_run_can_be_run(wucht: Command, study: Study) -> None:
    kept = ["--set", "drive.slope=0.05", "--set", "study.tolerance=1e-10"]
    first = wucht("run", study('until = "0.5 s"', "settled = true"), *kept)
    assert "verdict: COMPENSATED" in first.out
    words = _next(first.out)
    assert words == ["run", "study.toml", *kept, "--set", "study.kind=coast-down"]
    second = wucht(*words, "--set", "study.until=0.2")
    assert second.code == 0
    assert _next(second.out)[-1] == "study.kind=response"


def _ends(wucht: Command, *words: str) -> tuple[str, list[str]]:
    """The outcome of a run, and the command that it proposes."""
    done = wucht(*words, "-o", "out")
    assert done.code == 0, done.err
    return package.load("out").wucht.summary["outcome"], _next(done.out)


HANGING = """\
[machine.carrier]
mass = "40 kg"
stiffness = "1e5 N/m"
damping = "400 N s/m"
gravity = "9.81 m/s^2"
[[machine.bodies]]
kind = "rotor"
name = "r"
mass = "10 kg"
unbalance = "0.3 kg m"
inertia = "0.05 kg m^2"
bearing_damping = "0.01 N m s"
"""
LINEAR = '[machine.drive]\nkind = "linear"\nslope = "0.004 N m s"\nno_load_speed = "150 rad/s"\n'
DC = '[machine.drive]\nkind = "dc"\nnominal_voltage = "24 V"\nstall_torque = "0.5 N m"\nno_load_speed = "1500 rpm"\n'
PLATE = """\
[machine.drive]
kind = "induction"
[machine.drive.nameplate]
power = "0.06 kW"
speed = "1400 rpm"
voltage = "400 V"
frequency = "50 Hz"
breakdown_torque_ratio = 2.8
starting_torque_ratio = 1.8
"""


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize("drive", [LINEAR, DC, PLATE])
def test_after_a_start_that_fails_a_motor_is_proposed_that_starts_it(wucht: Command, here: Path, drive: str) -> None:
    """The weight of 0.3 kg m takes 2.94 N m: 0.6 N m of a linear drive, 0.737 N m by the nameplate are too little."""
    Path("hanging.toml").write_text(HANGING + drive, encoding="utf-8")
    outcome, command = _ends(wucht, "run", "hanging.toml")
    assert outcome == "not-started"
    key, _, value = command[-1].partition("=")
    if drive is LINEAR:
        assert key == "drive.slope" and 1 <= float(value) / (0.3 * 9.81 / 150) <= 1.01
    elif drive is DC:
        assert key == "drive.stall_torque" and 1 <= float(value) / (0.3 * 9.81) <= 1.01
    else:  # 2.94 N m over 1.8 times 60 W/(1400 rpm) = 0.409 N m: 240 W, and the next preferred power is 250 W
        assert (key, value) == ("drive.nameplate.power", "0.25 kW")
    assert _ends(wucht, *command)[0] != "not-started"


@pytest.mark.usefixtures("no_figures")
def test_after_a_capture_the_curve_over_the_motor_is_proposed(wucht: Command, here: Path) -> None:
    captured = ("run", "drozdetskaya-2020/r1", "--set", "study.until=20")
    outcome, command = _ends(wucht, *captured)
    assert outcome == "captured-modulated"
    assert {"study.kind=speed-curve", "study.along=drive.slope", "study.range=[0.00975, 0.0585]"} <= set(command)
    assert wucht(*command, "-o", "curve").code == 0


@pytest.mark.usefixtures("no_figures")
def test_after_synchronised_exciters_the_failure_of_a_motor_is_proposed(wucht: Command, here: Path) -> None:
    outcome, command = _ends(wucht, "run", "practice/screen")
    assert outcome == "synchronised"
    assert command[-1] == "study.kind=drive-failure"
    done = wucht(*command, "-o", "failure")
    assert done.code == 0
    assert _next(done.out)[-1] == "study.kind=synchronous-states"


@pytest.mark.usefixtures("no_figures")
def test_a_run_too_short_is_proposed_again_for_long_enough(wucht: Command, study: Study) -> None:
    file = study('until = "0.5 s"', 'until = "0.2 s"')
    words = _next(wucht("run", file, "--set", "study.until=0.1", "--set", "study.tolerance=1e-10").out)
    assert words[:4] == ["run", str(file), "--set", "study.tolerance=1e-10"]
    assert float(words[-1].removeprefix("study.until=")) > 0.1
    assert wucht(*words).code == 0


UNTIL, START = 'until = "0.5 s"\n', 'start = { p1 = "0.3 rad", p2 = "-0.5 rad" }\n'
OWN = """
from wucht.extending import Answer, NextQuestion, Study, new_figure


class Counting(Study):
    \"\"\"Count the bodies of a machine.\"\"\"

    kind = "count"
    next_questions = (
        NextQuestion("not after this outcome", {{"study.until": "1"}}, ("captured",)),
        NextQuestion("a number that is missing", {{"study.until": "{{speed}}"}}),
        NextQuestion("a key that is refused", {{"study.no_such_key": "1"}}),
        {accepted}
    )

    def solve(self, machine, prepared, work):
        a = Answer(machine.units)
        a.number("bodies", len(machine.bodies), "number of bodies")
        a.sentence = "counted"
        yield a

    def draw(self, result):
        return new_figure(1, result.attrs["title"], result.attrs["sentence"], 2.0)[0]
"""


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    ("accepted", "line"),
    [
        (
            'NextQuestion("the answer", {"study.kind": "response", "study.bodies": "held"}),',
            "wucht run study.toml --set p1.mass=0.12 --set study.kind=response --set study.bodies=held "
            "--import {own}  # the answer",
        ),
        ("", "wucht report out -o report.html  # one file to send, with the figure, the machine and all numbers"),
    ],
)
def test_the_first_accepted_question_is_proposed(wucht: Command, study: Study, here: Path, accepted: str, line: str) -> None:
    name = f"own_of_{here.name}".replace("-", "_")
    own = Path(f"{name}.py")
    own.write_text(OWN.format(accepted=accepted), encoding="utf-8")
    file = study(UNTIL, "", START, "", 'kind = "run-up"', 'kind = "count"')
    try:
        done = wucht("run", file, "-o", "out", "--set", "p1.mass=0.12", "--import", own)
        assert done.code == 0, done.err
        assert done.out.splitlines()[-1] == f"next: {line.format(own=own)}", done.err
    finally:
        if name in sys.modules:
            sys.modules[name].Counting.kind = ""
