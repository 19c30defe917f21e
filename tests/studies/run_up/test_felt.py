"""Force, stroke, throw and machine number at the end of a run: against the forced vibration by pencil and by other studies."""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests import refusals

import wucht as package
from wucht import Machine, RunUp, parts
from wucht.analysis.throw import GRAVITY

CARRIER, DRUM, STIFFNESS, DAMPING, UNBALANCE, SPEED = 5.0, 4.0, (1e5, 3e5), (400.0, 400.0), 4e-3, 210.0


def machine(directions: str = "xy") -> Machine:
    first = 0 if "x" in directions else 1
    both = (STIFFNESS, DAMPING) if directions == "xy" else (STIFFNESS[first], DAMPING[first])
    carrier = parts.Carrier(mass=CARRIER, stiffness=both[0], damping=both[1], directions=directions)
    drum = parts.Rotor(name="drum", mass=DRUM, eccentricity=UNBALANCE / DRUM, inertia=0.01)
    return Machine(carrier, [drum], [parts.ConstantSpeed(speed=SPEED)], title="M")


def by_pencil(k: float, c: float) -> complex:
    return UNBALANCE * SPEED**2 / (k - (CARRIER + DRUM) * SPEED**2 + 1j * c * SPEED)


def ended(m: Machine, **more: Any) -> dict[str, Any]:
    summary: dict[str, Any] = package.run(RunUp(until=1.5, **more), m).wucht.summary
    return summary


def test_an_ellipse_by_pencil() -> None:
    """x = Re[z_x e^(i w t)], y = Re[-i z_y e^(i w t)]: the ellipse's axes, and the force by which the carrier is driven."""
    x, y = by_pencil(STIFFNESS[0], DAMPING[0]), -1j * by_pencil(STIFFNESS[1], DAMPING[1])
    forward, backward = abs(x + 1j * y) / 2, abs(x - 1j * y) / 2
    actual = ended(machine(), deck="10 deg")
    assert actual["stroke"] == pytest.approx(2 * (forward + backward), rel=1e-4)
    assert actual["throw_ratio"] == pytest.approx(abs(forward - backward) / (forward + backward), rel=1e-3)
    assert actual["acceleration"] == pytest.approx((forward + backward) * SPEED**2, rel=1e-3)
    assert actual["machine_number"] == actual["acceleration"] / GRAVITY
    normal = abs(y * math.cos(math.radians(10)) - x * math.sin(math.radians(10))) * SPEED**2
    assert actual["throw_number"] == pytest.approx(normal / GRAVITY / math.cos(math.radians(10)), rel=1e-3)
    fx, fy = (z * (k - CARRIER * SPEED**2 + 1j * c * SPEED) for z, k, c in zip((x, y), STIFFNESS, DAMPING, strict=True))
    force = abs(fx + 1j * fy) / 2 + abs(fx - 1j * fy) / 2
    assert actual["bearing_force"] == pytest.approx(force, rel=1e-3)


@pytest.mark.parametrize(("direction", "angle"), [("x", 0.0), ("y", math.pi / 2)])
def test_a_line(direction: str, angle: float) -> None:
    k = 0 if direction == "x" else 1
    actual = ended(machine(direction))
    assert actual["throw_direction"] == pytest.approx(angle)
    assert actual["stroke"] == pytest.approx(2 * abs(by_pencil(STIFFNESS[k], DAMPING[k])), rel=1e-4)
    assert actual["throw_ratio"] == pytest.approx(0.0, abs=1e-12)
    assert "throw_number" not in actual


def told(result: Any) -> dict[str, str]:
    """The lines of the report by their headings."""
    return {line[2:15].strip(): line[15:] for line in package.report(result) if line.startswith("  ") and line[2:15].strip()}


@pytest.mark.parametrize(("share", "is_felt"), [(0.9, False), (1.1, True)])
def test_what_is_gentle_is_left_out_but_on_a_deck(share: float, is_felt: bool) -> None:
    """A twentieth of the acceleration of gravity, share times."""
    unbalance = share * 0.05 * GRAVITY / abs(by_pencil(STIFFNESS[0], DAMPING[0])) / SPEED**2 * UNBALANCE
    carrier = parts.Carrier(mass=CARRIER, stiffness=STIFFNESS[0], damping=DAMPING[0], directions="xy")
    drum = parts.Rotor(name="drum", mass=DRUM, unbalance=unbalance, inertia=0.01)
    gentle = Machine(carrier, [drum], [parts.ConstantSpeed(speed=SPEED)])
    assert ("stroke" in told(package.run(RunUp(until=1.5), gentle))) is is_felt
    assert "stroke" in told(package.run(RunUp(until=1.5, deck=0.1), gentle))


def test_where_it_makes_no_sense() -> None:
    dimensionless = package.load_machine("drozdetskaya-2020/table-5.1")
    assert "stroke" not in package.run(RunUp(until=20.0), dimensionless).wucht.summary, "this machine has no units"
    for m, deck in ((package.load_machine("drozdetskaya-2020/table-3.1-carrier"), 0.1), (machine("x"), 0.1)):
        with refusals.refused("study.deck", given=deck):
            package.run(RunUp(until=1.0, deck=deck), m)


@pytest.mark.slow
def test_a_screen_throws_as_its_steady_configuration_does(wucht: Callable[..., Any]) -> None:
    run = wucht("run", "practice/screen", "-o", "a", "--json", "--set", "study.deck=-5 deg").document["summary"]
    words = ("--set", "study.kind=synchronous-states", "--set", f"study.speed={run['final_speed']}")
    states = wucht("run", "practice/screen", "-o", "b", "--json", *words).document["summary"]["states"]
    (steady,) = (s for s in states if s["verdict"].startswith("stable"))
    assert math.degrees(run["throw_direction"]) == pytest.approx(45.4, abs=0.3)
    assert run["throw_direction"] == pytest.approx(steady["throw_direction"], abs=math.radians(0.5))
    assert run["stroke"] == pytest.approx(steady["stroke"], rel=5e-3)
    assert run["machine_number"] == pytest.approx(steady["machine_number"], rel=2e-2)
    assert run["throw_number"] == pytest.approx(
        run["machine_number"] * math.sin(math.radians(50.5)) / math.cos(math.radians(5)), rel=1e-2
    )


def test_the_force_of_each_of_two_exciters() -> None:
    """Each carries round its unbalance, of which the centre hardly moves on a heavy carrier: U w^2."""
    exciters = [parts.Rotor(name=n, mass=2.0, unbalance=u, inertia=0.05) for n, u in (("e1", 0.03), ("e2", 0.01))]
    drives = [parts.ConstantSpeed(on=n, speed=w) for n, w in (("e1", 60.0), ("e2", -60.0))]
    heavy = Machine(parts.Carrier(mass=1e5, stiffness=1e5, damping=10.0), exciters, drives)
    result = package.run(RunUp(until=1.0), heavy)
    assert result.wucht.summary["bearing_forces"] == pytest.approx({"e1": 0.03 * 60**2, "e2": 0.01 * 60**2}, rel=1e-4)
    assert result.rotor_bearing_force.dims == ("rotor", "plane", "time")
    for key in ("steady_bearing_forces", "peak_bearing_forces"):
        assert result.wucht.summary[key] == pytest.approx({"e1": 108.0, "e2": 36.0}, rel=1e-3)
    assert "bearings" not in told(result), "it hardly moves"
    light = Machine(parts.Carrier(mass=10.0, stiffness=1e4, damping=100.0), exciters, drives)
    assert told(package.run(RunUp(until=1.0), light))["bearings"].startswith("e1 ")


def test_one_bearing_on_an_ellipse() -> None:
    """Of one rotor the force of all bodies is that of its bearing: the largest, and the mean along the ellipse."""
    actual = ended(machine())
    x, y = by_pencil(STIFFNESS[0], DAMPING[0]), -1j * by_pencil(STIFFNESS[1], DAMPING[1])
    fx, fy = (z * (k - CARRIER * SPEED**2 + 1j * c * SPEED) for z, k, c in zip((x, y), STIFFNESS, DAMPING, strict=True))
    turn = np.exp(2j * np.pi * np.arange(1000) / 1000)
    mean = np.hypot((fx * turn).real, (fy * turn).real).mean()
    assert list(actual["bearing_forces"].values()) == pytest.approx([actual["bearing_force"]], rel=1e-3)
    assert list(actual["steady_bearing_forces"].values()) == pytest.approx([mean], rel=1e-3)
    assert "bearing_life" not in actual


@pytest.mark.parametrize(("unbalance", "is_noise"), [(1e-10, True), (1e-5, False)])
def test_what_is_below_the_noise_is_rest(unbalance: float, is_noise: bool) -> None:
    """A rotor that is released from 1 mm and balanced but for a share of what would hold it there: U w^2 / k of 1 mm."""
    carrier = parts.Carrier(mass=CARRIER, stiffness=STIFFNESS, damping=(2000.0, 2000.0))
    drum = parts.Rotor(name="drum", mass=DRUM, unbalance=unbalance, inertia=0.01)
    m = Machine(carrier, [drum], [parts.ConstantSpeed(speed=SPEED)], title="M")
    summary = ended(m, start={"carrier": {"x": 1e-3}})
    assert summary["peak_amplitude"] == pytest.approx(1e-3, rel=0.05)
    numbers = [summary[key] for key in ("final_amplitude", "stroke", "acceleration", "machine_number")]
    directions = [summary[key] for key in ("throw_direction", "throw_ratio")]
    if is_noise:
        assert (numbers, directions) == ([0.0] * 4, [None] * 2)
    else:
        assert all(number > 0 for number in numbers)
        assert None not in directions
