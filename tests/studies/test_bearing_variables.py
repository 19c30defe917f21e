"""The life of bearings in the summaries of run-ups and load spectra: m e w^2 on rigid bearings, and both studies alike."""

from __future__ import annotations

import math
from typing import Any

import pytest

import wucht as package
from wucht import LoadSpectrum, Machine, RunUp, parts

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


def test_a_balanced_rotor_does_not_load_its_bearing() -> None:
    drum = parts.Rotor(name="drum", mass=20.0, unbalance=0.0, inertia=0.5, bearing={"C": 45e3})
    still = Machine(parts.Carrier(mass=1.0, directions="fixed"), [drum], [parts.ConstantSpeed(speed=SPEED)])
    result = package.run(RunUp(until=1.0), still)
    assert result.wucht.summary["bearing_life"] == {"drum": None}
    assert "  bearing life drum has no load (ISO 281, nine of ten)" in package.report(result)
