"""The life of bearings in the summaries of run-ups and load spectra: m e w^2 on rigid bearings, and both studies alike."""

from __future__ import annotations

import math
from typing import Any

import pytest
from tests.hand_made import titled

import wucht as package
from wucht import LoadSpectrum, Machine, RunUp, parts
from wucht.dynamics.run_ups.bearing_loads import BearingLife, BearingLoad
from wucht.results.report import report_of
from wucht.studies.answer import Answer
from wucht.studies.bearing_variables import force_text, state_lives, state_loads

SPEED, UNBALANCE = 1500 * math.pi / 30, 0.2
FORCE = UNBALANCE * SPEED**2
HOURS = (45e3 / FORCE) ** 3 * 1e6 / (60 * 1500)


def shaft(C: float = 45e3) -> Machine:
    drum = parts.Rotor(name="drum", mass=20.0, unbalance=UNBALANCE, inertia=0.5, bearing={"C": C})
    return Machine(parts.Carrier(mass=1.0, directions="fixed"), [drum], [parts.ConstantSpeed(speed=SPEED)])


@pytest.mark.parametrize("question", [RunUp(until=1.0), LoadSpectrum(until=1.0, signal="bearing-force", rotor="drum")])
def test_a_shaft_in_rigid_bearings(question: Any) -> None:
    result = package.run(question, shaft())
    s = result.wucht.summary
    assert s["equivalent_bearing_loads"] == pytest.approx({"drum": FORCE}, rel=1e-6)
    assert s["bearing_life"] == pytest.approx({"drum": HOURS}, rel=1e-5)
    assert f"  bearing life drum {HOURS:.4g} h under 4.935 kN (ISO 281, nine of ten)" in package.report(result)
    assert not any("ISO 281" in w for w in result.wucht.warnings)
    if question.kind == "load-spectrum":
        assert s["largest_range"] == pytest.approx(2 * FORCE, rel=1e-4)
        assert s["signal"] == "bearing force of drum in x"


@pytest.mark.parametrize("question", [RunUp(until=1.0), LoadSpectrum(until=1.0, signal="bearing-force", rotor="drum")])
def test_more_than_half_of_the_rating_is_a_warning(question: Any) -> None:
    (warning,) = (w for w in package.run(question, shaft(1.999 * FORCE)).wucht.warnings if "ISO 281" in w)
    assert "the bearing of 'drum', 4935 N, is more than half of its rating" in warning
    assert not any("ISO 281" in w for w in package.run(question, shaft(2.001 * FORCE)).wucht.warnings)


def test_ratings_are_varied_as_other_parameters() -> None:
    result = package.run(RunUp(until=1.0, along="drum.bearing.C", values=["45 kN", "90 kN"]), shaft())
    lives = [case["bearing_life"]["drum"] for case in result.wucht.summary["cases"]]
    assert lives == pytest.approx([HOURS, 8 * HOURS], rel=1e-5)


def test_each_rotor_has_its_bearing() -> None:
    """Exciters of 3 to 1 on a heavy carrier, of which one bearing is rated; the spectrum of each is that of its force."""
    exciters = [
        parts.Rotor(name="e1", mass=2.0, unbalance=0.03, inertia=0.05),
        parts.Rotor(name="e2", mass=2.0, unbalance=0.01, inertia=0.05, bearing={"C": 1000.0, "p": "10/3"}),
    ]
    drives = [parts.ConstantSpeed(on=n, speed=w) for n, w in (("e1", 60.0), ("e2", -60.0))]
    heavy = Machine(parts.Carrier(mass=1e6, stiffness=1e6, damping=10.0), exciters, drives)
    for rotor, force in (("e1", 108.0), ("e2", 36.0)):
        s = package.run(LoadSpectrum(until=2.0, signal="bearing-force", rotor=rotor, direction="y"), heavy).wucht.summary
        assert s["largest_range"] == pytest.approx(2 * force, rel=1e-3)
        assert s["bearing_life"] == pytest.approx({"e2": (1000 / 36) ** (10 / 3) * 1e6 * 2 * math.pi / 60 / 3600}, rel=1e-3)
    together = package.run(LoadSpectrum(until=2.0, signal="bearing-force", direction="y"), heavy).wucht.summary
    assert together["largest_range"] == pytest.approx(2 * (108 - 36), rel=1e-3)


def lines(loads: dict[str, BearingLoad], lives: dict[str, BearingLife], is_shown: bool = True) -> list[str]:
    a = Answer()
    state_loads(a, loads, is_shown)
    state_lives(a, lives)
    return report_of(titled(a.to_dataset().assign_attrs(study="run-up")))[2:]


def test_a_record_and_machines_without_ratings_have_no_life() -> None:
    assert lines({}, {}) == []
    assert (
        "bearing_life" not in package.run(LoadSpectrum(until=1.0), package.load_machine("drozdetskaya-2020/r1")).wucht.summary
    )


def test_forces_in_words() -> None:
    assert (force_text(999.96), force_text(1000.0), force_text(0.0)) == ("1000 N", "1 kN", "0 N")


def test_the_bearing_forces_of_many_rotors() -> None:
    steady = {f"r{k}": 100.0 * (1 + k % 4) for k in range(8)}
    loads = {name: BearingLoad(f, (f, 0.0), 1.1 * f, 2 * f) for name, f in steady.items()}
    listing = ", ".join(f"r{k} {f:.0f} N ({1.1 * f:.0f} N at most)" for k, f in enumerate(steady.values()) if k not in (0, 4))
    assert lines(loads, {}) == [f"  bearings     {listing} at the end; 2 smaller ones; 800 N at most in the whole run"]
    assert lines(loads, {}, is_shown=False) == []


@pytest.mark.parametrize(
    ("load", "hours", "text"),
    [
        (2600.0, 1234.56, "1235 h under 2.6 kN"),
        (1.0, 1e7, "more than 1e+07 h"),
        (0.0, None, "has no load"),
        (None, None, "does not turn"),
    ],
)
def test_a_life_in_words(load: float | None, hours: float | None, text: str) -> None:
    assert lines({}, {"r0": BearingLife(load, hours, 1e4)}) == [f"  bearing life r0 {text} (ISO 281, nine of ten)"]


def test_of_many_bearings_the_shortest_lives_are_listed() -> None:
    (line,) = lines({}, {f"r{k}": BearingLife(10.0, 900.0 - 100 * k, 1e4) for k in range(8)})
    assert "r0 " not in line and "r1 " not in line and "r2 700 h under 10 N, " in line and line.endswith("; 2 longer ones")
