"""Every catalogue file loads, its equations derive and can be evaluated at its start."""

from pathlib import Path

import pytest
from tests.refusals import refused

from wucht.files.catalogue import FOLDER, load_machine
from wucht.studies.study_file import read_study

SCHEDULED = """
[machine]
use = "practice/fan-on-belt"
[[machine.schedules]]
parameter = "load.coefficient"
points = [["0 s", 0.0], ["5 s", "4e-4 N m s^2"]]
"""
FASTER = """
[machine]
use = "scheduled.toml"
[[machine.schedules]]
parameter = "drive.frequency"
points = [["0 s", "0 Hz"], ["3 s", "50 Hz"]]
voltage = "proportional"
boost = "20 V"
"""


def test_schedules_are_added_to_those_of_the_machine_used(here):
    """Those of the same parameter are replaced, with what they say of the voltage; the title tells which it does not know."""
    Path("scheduled.toml").write_text(SCHEDULED)
    Path("faster.toml").write_text(FASTER)
    used, added, faster = (load_machine(n) for n in ("practice/fan-on-belt", "scheduled.toml", "faster.toml"))
    assert {s.parameter for s in added.schedules} == {"load.coefficient", *(s.parameter for s in used.schedules)}
    assert added.at(2.5).values["load.coefficient"] == pytest.approx(2e-4)
    assert added.at(3.0).values["drive.frequency"] == used.at(3.0).values["drive.frequency"]
    assert faster.at(1.5).values["drive.frequency"] == pytest.approx(faster.at(3.0).values["drive.frequency"] / 2)
    assert faster.at(0.0).values["drive.voltage"] == pytest.approx(20.0)
    assert faster.at(2.5).values["load.coefficient"] == pytest.approx(2e-4)
    assert faster.title == f"{used.title} (changed: drive.frequency = over time, load.coefficient = over time)"


@pytest.mark.parametrize(
    ("lines", "refusal"),
    [
        ("schedules = [1]", refused("machine.schedules", given=[1], file="own.toml")),
        (
            'schedules = [{ parameter = "load.coefficient", points = [[0, -1]] }]',
            refused("machine.schedules[0].points (t = 0)", given=-1.0, code="limits", file="own.toml"),
        ),
        (
            'schedules = [{ parameter = "drive.voltage", points = [[0, 1]] }]',
            refused("machine.schedules[1].parameter", given="drive.voltage", file="own.toml"),
        ),
        ("bodies = []", refused("machine.bodies", given=None, file="own.toml")),
    ],
)
def test_schedules_that_do_not_fit_the_machine_used(here, lines, refusal):
    Path("own.toml").write_text(f'[machine]\nuse = "practice/fan-on-belt"\n{lines}\n')
    with refusal:
        load_machine("own.toml")


@pytest.mark.parametrize(
    ("setting", "refusal"),
    [
        (
            '"p3.mass" = 1',
            refused("machine.set.p3.mass", "outer.toml", "p2", given=1, file="inner.toml", code="unknown-parameter"),
        ),
        (
            '"p1.mass" = -1',
            refused("machine.bodies[1] (p1).mass", "outer.toml", "0 kg", given=-1, code="limits", file="inner.toml"),
        ),
    ],
)
@pytest.mark.parametrize("titled", [True, False])
def test_a_wrong_setting_is_told_at_the_file_that_has_it(here, setting, refusal, titled):
    """It may be set right in a file that uses that one; then nothing is said."""
    machine = (FOLDER / "drozdetskaya-2020/r1.toml").read_text(encoding="utf-8")
    lines = [line for line in machine.splitlines() if titled or not line.startswith("title")]
    Path("used.toml").write_text("\n".join(lines), encoding="utf-8")
    Path("inner.toml").write_text(f'[machine]\nuse = "used.toml"\nset = {{ {setting} }}\n')
    Path("middle.toml").write_text('[machine]\nuse = "inner.toml"\nset = { "p2.mass" = 0.126 }\n')
    Path("outer.toml").write_text('[machine]\nuse = "middle.toml"\n')
    with refusal as caught:
        load_machine("outer.toml")
    assert caught.value.file == "inner.toml"
    if "p1" in setting:
        with refused("machine.set.p4.mass", given=1, file="outer.toml", code="unknown-parameter"):
            load_machine("outer.toml", {"p1.mass": 0.1, "p4.mass": 1})
        assert load_machine("outer.toml", {"p1.mass": 0.1}).values["p1.mass"] == 0.1


def test_a_missing_key_that_was_written_for_another_study_keeps_its_code(here):
    """The keys of a sweep are not taken for those of a probability; the sentence says so, and the error is the same."""
    question = '[machine]\nuse = "drozdetskaya-2020/r1"\n[study]\nkind = "sweep"\nalong = "drive.slope"\nrange = [0.01, 0.02]\n'
    Path("swept.toml").write_text(question, encoding="utf-8")
    with refused("study.along", "ignored", code="missing", file="swept.toml"):
        read_study("swept.toml", {"study.kind": "capture-probability"})


def test_a_key_above_its_table(here: Path) -> None:
    Path("a.toml").write_text("until = 3\n")
    with refused("until", "study", given=3):
        read_study("a.toml")
