"""Balancing bodies of a coast-down start in steady phases, or where it is said; and the answer says where."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht import CoastDown, load_machine, run

R1 = "drozdetskaya-2020/r1"


def phases(name: str, **asked: Any) -> dict[str, float]:
    """In degrees, from -180 to 180."""
    (case,), _ = CoastDown(**asked).prepare(load_machine(name))
    found = case.phases
    return {body: float((np.degrees(angle) + 180) % 360 - 180) for body, angle in found.items()}


def unbalance(machine: str, **asked: Any) -> float:
    """The mass moment of rotor and bodies together at the start, of that of the rotor."""
    values = load_machine(machine).values
    at = {body: np.exp(1j * np.radians(phase)) for body, phase in phases(machine, **asked).items()}
    bodies = sum(values[f"{body}.mass"] * values[f"{body}.length"] * direction for body, direction in at.items())
    own = values["drum.mass"] * values["drum.eccentricity"]
    return float(abs(own + bodies) / own)


def test_bodies_start_where_they_compensate() -> None:
    """By the force polygon, whatever the module for steady phases says."""
    assert unbalance(R1) == pytest.approx(0.0, abs=1e-12)
    assert unbalance(R1, bodies="held") > 2


@pytest.mark.parametrize("speed", [200.0, -200.0])
@pytest.mark.parametrize("angle", [0.0, 1.0])
def test_it_does_not_vibrate_until_it_is_slow(speed: float, angle: float) -> None:
    asked = {"until": 0.5, "start": {"drum": {"angle": angle, "speed": speed}}}
    steady, held = (run(CoastDown(**asked, **more), load_machine(R1)) for more in ({}, {"bodies": "held"}))
    assert steady.wucht.summary["peak_amplitude"] < 1e-4 * held.wucht.summary["peak_amplitude"]


def test_below_the_resonance_they_are_on_the_heavy_side() -> None:
    """The one steady configuration of 30 rad/s that is stable: bodies trail the unbalance by their drag in the vibration."""
    found = phases(R1, start={"drum": {"speed": 30.0}})
    assert found["p1"] == pytest.approx(found["p2"])
    assert -30 < found["p1"] < 0
    clockwise = phases(R1, start={"drum": {"speed": -30.0}})
    assert clockwise["p1"] == pytest.approx(-found["p1"])


def test_where_steady_phases_are_not_known_it_is_said_why() -> None:
    result = run(CoastDown(until=0.05, start={}), load_machine("sperling-vibration/figure-4"))
    assert any("b1 is locked to its rotor until it is released" in w for w in result.wucht.warnings)
    held = run(CoastDown(until=0.05, bodies="held"), load_machine("sperling-vibration/figure-4"))
    assert not any("locked" in w for w in held.wucht.warnings)


@pytest.mark.parametrize(
    ("start", "refusal"),
    [
        ({"p2": 0.1}, refused("study.bodies", "study.start.p2", "'held'", given="steady", code="not-allowed")),
        ({"psi": 0.1}, refused("study.bodies", "study.start.psi", "'held'", given="steady", code="not-allowed")),
        ({"drum": {"speed": 95.0}}, refused("study.bodies", "95 rad/s", "'held'", given="steady", code="no-stable-phases")),
    ],
)
def test_what_is_refused(start: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        CoastDown(bodies="steady", start=start).prepare(load_machine(R1))


def test_where_exciters_start_is_said() -> None:
    screen = load_machine("practice/screen")
    held = run(CoastDown(until=0.02, start={"e1": 0.5}, bodies="held"), screen)
    assert "rotors start at e1 28.65°, e2 0°" in held.wucht.assumed
    steady = run(CoastDown(until=0.02, start={"e1": 0.5}), screen)
    assert "rotors start in the stable synchronous configuration e2 269.6° (averaged equations)" in steady.wucht.assumed
    assert len(steady.wucht.summary["configurations"]) == 1 and "run_speed" not in steady
    assert "configuration" not in steady.attrs["sentence"]


@pytest.mark.parametrize(
    ("asked", "statement"),
    [
        ({}, "compensating, p1 112°, p2 248°"),
        ({"bodies": "held"}, "p1 0°, p2 0°"),
        ({"start": {"p1": 0.5}}, "p1 28.65°, p2 0°"),
    ],
)
def test_what_was_assumed_is_said(asked: dict[str, Any], statement: str) -> None:
    result = run(CoastDown(until=0.05, **asked), load_machine(R1))
    assert any(statement in one for one in result.wucht.assumed)
