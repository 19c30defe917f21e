"""What the page computes beside the motion: marked speeds, the study file, links, measured files, sliders."""

from __future__ import annotations

import json
import math
import re
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.web.page_answers import answer, page_text

from wucht import load_machine
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.files.catalogue import load_document, names
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.studies.study_file import read_study

page_of = cache(page_text)
RELEASES = {"sperling-vibration/figure-4", "sperling-vibration/figure-4-y-blocked", "sperling-vibration/table-1"}


@pytest.mark.slow
@pytest.mark.parametrize(
    ("name", "paths"),
    [
        ("practice/screen", ["carrier.mounts.1.stiffness.x", "carrier.inertia", "e1.position.y", "drives.e2.rotor_resistance"]),
        ("practice/laundry-drum", ["carrier.stiffness.y", "drum.mass", "load.coefficient", "drive.armature_resistance"]),
        ("drozdetskaya-2020/table-5.1", ["s", "u"]),
    ],
)
def test_marked_speeds_move_as_in_python(tmp_path: Path, name: str, paths: list[str]) -> None:
    machine, generator = load_machine(name), np.random.default_rng(38)
    values = [{}, *({p: machine.values[p] * generator.uniform(0.5, 1.5) for p in paths} for _ in range(5))]
    for some, levels in zip(values, answer(tmp_path, page_of(name), "levels", values=values), strict=True):
        changed = machine.with_unchecked_values(some)
        changed = changed.at(changed.breakpoints[-1])
        natural = sorted(set(natural_frequencies(changed).values()))
        natural = [f for k, f in enumerate(natural) if k == 0 or f > natural[k - 1] * (1 + 1e-8)]
        assert [x["speed"] for x in levels if x["isNatural"]] == pytest.approx(natural, rel=1e-9)
        free = [free_speed(changed, r) for r in changed.rotors]
        assert [x["speed"] for x in levels if not x["isNatural"]] == pytest.approx(free, rel=1e-9)


def study_of(folder: Path, text: str) -> RunUpCase:
    (folder / "study.toml").write_text(text, encoding="utf-8")
    study_file = read_study(str(folder / "study.toml"))
    return RunUpCase.of(study_file.subject, study_file.spec.start, study_file.spec.settings)  # type: ignore[attr-defined]


def test_a_copied_study_file_is_the_machine_shown(tmp_path: Path) -> None:
    name = "drozdetskaya-2020/r1"
    original = study_of(tmp_path, answer(tmp_path, page_of(name), "study", scenario={}))
    machine = load_machine(name)
    assert original.machine.values == machine.values
    parameters = {"drive.slope": 0.1 + 0.2, "drum.eccentricity": 1.1e-3, "drive.switch": 0}
    start = {"p1.angle": 1 / 3, "drum.speed": 12.3, "carrier.x": 1e-3}
    states = [str(n) for n in machine.state_names]
    scenario = {
        "parameters": parameters,
        "start": start,
        "until": 5,
        "changes": [{"time": 2, "parameters": {"drive.slope": 1}}],
    }
    text = answer(tmp_path, page_of(name), "study", scenario=scenario)
    assert text.startswith("# the motor of drum was off from the start\n# from t = 2 on: drive.slope = 1\n")
    run = study_of(tmp_path, text)
    assert run.settings.until == 5
    expected = machine.values | {k: v for k, v in parameters.items() if k in machine.values}
    assert run.machine.values == expected
    state = dict(zip(states, original.models[0].initial.tolist(), strict=True)) | start
    assert dict(zip(states, run.models[0].initial.tolist(), strict=True)) == pytest.approx(state, rel=1e-14)


@pytest.mark.slow
@pytest.mark.parametrize("name", ["practice/angle-grinder", "sperling-vibration/figure-2a"])
def test_what_follows_from_other_numbers_stays_in_a_copied_study_file(tmp_path: Path, name: str) -> None:
    """Frequencies of contacts, reactances; frequencies with their unit."""
    machine = load_machine(name)
    path = next(p for p in machine.values if p.endswith("mass"))
    frequency = {p: 1.1 * v for p, v in machine.values.items() if p == "carrier.motion.frequency"}
    parameters = {path: 1.1 * machine.values[path]} | frequency
    run = study_of(tmp_path, answer(tmp_path, page_of(name), "study", scenario={"parameters": parameters}))
    case = {k: v for k, v in run.machine.values.items() if ".offset_" not in k}
    assert case == pytest.approx({k: v for k, v in (machine.values | parameters).items() if k in case}, rel=1e-14)


@pytest.mark.slow
def test_every_control_of_the_catalogue_is_a_key_of_its_file(tmp_path: Path) -> None:
    """With all of them moved, the copied study file is the machine with these values, and with all others as they were."""
    for name in names():
        if "machine" not in load_document(name)[0] or name in RELEASES:
            continue
        page = page_of(name)
        contents = json.loads(re.findall(r"^const page = (.*);$", page, re.MULTILINE)[0])
        entries = json.loads(re.findall(r"^parameters: (.*),$", page, re.MULTILINE)[0])
        controls = [
            (entries[i], control) for group in contents["groups"] for control in group["controls"] for i in control["indices"]
        ]
        # An inertia about the axis must be at least m e^2, whatever mass and eccentricity are.
        factors = {p["path"]: 1.0 if c["whole"] else 1.2 if "inertia" in c["name"] else 1.03 for p, c in controls}
        parameters = {p["path"]: p["value"] * factors[p["path"]] for p, _ in controls}
        run = study_of(tmp_path, answer(tmp_path, page, "study", scenario={"parameters": parameters}))
        expected = {p["path"]: p["value"] for p in entries if not p["path"].endswith(".switch")} | parameters
        assert {p: run.machine.values[p] for p in expected if ".offset_" not in p} == pytest.approx(
            {p: v for p, v in expected.items() if ".offset_" not in p}, rel=1e-12
        )


def test_a_link_restores_what_is_shown_bit_for_bit(tmp_path: Path) -> None:
    generator = np.random.default_rng(38)
    numbers = (generator.normal(size=20) * 10.0 ** generator.integers(-300, 300, 20)).tolist()
    machine = load_machine("drozdetskaya-2020/r1")
    size = len(machine.state_names)
    scenario: dict[str, Any] = {
        "parameters": dict(zip(["drive.slope", "drum.mass", "p1.length"], numbers, strict=False)),
        "start": dict(zip(machine.state_names, numbers[3:], strict=False)),
        "until": 1 / 3,
        "changes": [{"time": 0.1, "parameters": {"drive.switch": 0, "drum.mass": math.pi}, "state": numbers[:size]}],
    }  # fmt: skip
    result = answer(tmp_path, page_of("drozdetskaya-2020/r1"), "link", scenario=scenario, time=0.1 + 0.2)
    assert result["before"] == result["after"]
    assert result["strobe"]


def test_measured_files_are_read_with_their_units(tmp_path: Path) -> None:
    texts = [
        "time (s),speed (rpm),amplitude [mm]\n0,600,1\n1,,2\n",
        "Zeit in ms;speed in 1/min;note in s\n0;600,5;1\n500;601,5;2\n",
        "t,p1 (deg)\n0,90\n", "t,unbalance left (%),power of the motor (kW),displacement (mm)\n0,50,2,1\n",
        "speed,amplitude\n1,2\n", "time,height\n0,1\n", "time,speed (mph)\n0,1\n", "time,speed\n0,fast\n", "", "one\n2\n",
    ]  # fmt: skip
    english, german, phase, words, *refusals = answer(tmp_path, page_of("drozdetskaya-2020/r1"), "measured", texts=texts)
    assert [(c["name"], c["time"], c["values"]) for c in english] == [
        ("speed", [0], [pytest.approx(20 * math.pi)]),
        ("amplitude", [0, 1], [1e-3, 2e-3]),
    ]
    assert (german[0]["time"], german[0]["values"]) == ([0, 0.5], pytest.approx([600.5 * math.pi / 30, 601.5 * math.pi / 30]))
    assert (phase[0]["panel"], phase[0]["values"]) == (2, [pytest.approx(math.pi / 2)])
    assert [(c["panel"], c["values"]) for c in words] == [(3, [0.5]), (4, [2000]), (1, [1e-3])]
    parts = ['no column is named "time"', "has the name of a curve", '"mph", allowed: s', "no numbers", "no rows", "no table"]
    assert all(part in text for part, text in zip(parts, refusals, strict=True))


@pytest.mark.parametrize("name", ["practice/screen", "practice/angle-grinder"])
def test_a_slider_gives_values_that_are_allowed_and_shows_the_present_one(tmp_path: Path, name: str) -> None:
    for control in answer(tmp_path, page_of(name), "sliders"):
        assert control["refusals"] == [""] * 5, control
        assert sorted(control["values"]) == control["values"]
        assert control["values"][0] <= control["value"] * (1 + 1e-3) + 1e-12
        assert control["value"] <= control["values"][-1] * (1 + 1e-3) + 1e-12
        assert 0 <= control["place"] <= 1000


def test_a_start_in_which_balls_overlap_is_refused(tmp_path: Path) -> None:
    """On a ring whose balls lie beside each other, from the first one on clockwise; the last one is far from the first."""
    radians = {f"b{k}.angle": -math.radians(71 + 7.6 * (k - 1)) for k in range(1, 7)}
    starts = [{}, radians, {"b1.angle": radians["b1.angle"] + 0.5}, {"b1.angle": radians["b3.angle"]}, {"b2.angle": 1.0}]
    fine, same, apart, inside, beyond = answer(tmp_path, page_of("practice/laundry-drum"), "overlaps", starts=starts)
    assert (fine, same, apart) == ("", "", "")
    assert "b1" in inside and inside.endswith("the initial state stays as it was.")
    assert "b2" in beyond


def test_a_course_passes_through_its_changes(tmp_path: Path) -> None:
    """A change that changes nothing changes the course by rounding only; a state by hand is where the course goes on."""
    page = page_of("drozdetskaya-2020/r1")
    plain = answer(tmp_path, page, "course", scenario={"until": 2})
    machine = load_machine("drozdetskaya-2020/r1")
    same = [{"time": 1, "parameters": {"drum.mass": machine.values["drum.mass"]}}]
    idle = answer(tmp_path, page, "course", scenario={"until": 2, "changes": same})
    assert (plain["ending"], idle["ending"], plain["time"][-1]) == ("end", "end", 2)
    assert idle["time"].count(1) == 2
    assert idle["end"] == pytest.approx(plain["end"], abs=1e-4)
    state = [0.0] * len(machine.state_names)
    moved = answer(tmp_path, page, "course", scenario={"until": 1 + 1e-9, "changes": [{"time": 1, "state": state}]})
    assert np.abs(moved["end"]).max() < 1e-3
    off = answer(tmp_path, page, "course", scenario={"until": 2, "changes": [{"time": 1, "parameters": {"drive.switch": 0}}]})
    row = machine.row(machine.rotor.coordinate.velocity)
    assert abs(off["end"][row]) < 0.8 * abs(plain["end"][row])
