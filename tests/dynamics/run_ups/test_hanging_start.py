"""The start of a machine for which none is given: under gravity it hangs at rest, as statics say."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from wucht import Basin, RunUp, run
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.run_ups.run_variations import varied_quantity
from wucht.dynamics.sampling.ensembles import initial_states
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.numerics.flow.program import Evaluator

MOUNTED = {"mass": 10.0, "stiffness": [2e4, 3e4], "damping": 50.0, "gravity": 9.81}
MOTOR = {"kind": "linear", "slope": 0.05, "no_load_speed": 100.0}
DRUM = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 0.02, "inertia": 0.1, "bearing_damping": 1e-3}
HANGS = "start: at rest, hanging"


def ball(name: str, **changed: Any) -> dict[str, Any]:
    table = {"kind": "pendulum", "name": name, "about": "drum", "mass": 0.1, "length": 0.1, "damping": 1e-3}
    return table | changed


def on_track(count: int, **changed: Any) -> dict[str, Any]:
    return ball("b", count=count, track="ring", diameter=0.02, **changed)


def machine(*bodies: dict[str, Any], **changed: Any) -> Machine:
    return machine_from({"carrier": MOUNTED, "bodies": [DRUM, *bodies], "drive": MOTOR} | changed)


def without_drive(*bodies: dict[str, Any]) -> Machine:
    return machine_from({"carrier": MOUNTED, "bodies": [DRUM, *bodies]})


def state_of(of: Machine, start: dict[str, Any] | None = None) -> dict[str, float]:
    """The state of a run-up at t = 0, by name."""
    case = RunUpCase.of(of, start or {}, RunSettings(until=1.0))
    return dict(zip(of.state_names, case.models[0].initial.tolist(), strict=True))


def angles(of: Machine, start: dict[str, Any] | None = None) -> dict[str, float]:
    """The absolute angles in degrees, from -180 to 180."""
    state = state_of(of, start)
    return {b.name: (math.degrees(state[f"{b.name}.angle"]) + 180) % 360 - 180 for b in of.bodies}


def near(**degrees: float) -> dict[str, Any]:
    return {name: pytest.approx(angle, abs=1e-6) for name, angle in degrees.items()}


def test_without_a_drive_nothing_moves() -> None:
    """In equilibrium: rotors, also with a pivot off the axis that weighs on them, pendulums, and the carrier in x and y."""
    bodies = ball("p1"), ball("p2", suspension=[0.03, 0.07], mass=0.5)
    state, undriven = state_of(machine(*bodies)), without_drive(*bodies)
    values = np.array([state[name] for name in undriven.state_names])
    rates = Evaluator.of_rates(undriven.system).array(np.zeros(1), values[:, None], undriven.system.values(undriven.values))
    assert np.abs(rates).max() < 1e-9
    assert abs(math.degrees(state["drum.angle"]) + 90.0) > 30.0  # the pivot turns it away from its own lowest place


@pytest.mark.parametrize("masses", [(0.1, 0.1, 0.1), (0.1, 0.25, 0.05), (0.1, 0.2)])
def test_balls_of_a_track_lie_side_by_side(masses: tuple[float, ...]) -> None:
    """Neighbours touch, and their common centre of mass is below the axis."""
    balls = [ball(f"b{k}", mass=m, track="ring", diameter=0.02) for k, m in enumerate(masses)]
    at = np.radians([a for n, a in angles(machine(*balls)).items() if n != "drum"])
    assert np.diff(at) == pytest.approx(2 * math.asin(0.02 / (2 * 0.1)), abs=1e-8)
    assert np.dot(masses, np.cos(at)) == pytest.approx(0.0, abs=1e-12) and (np.sin(at) < 0).all()


def test_what_names_a_place_keeps_it() -> None:
    """A start that names anything, angles that the machine states, a lock, and a balanced rotor."""
    free = machine(ball("p"))
    assert angles(free) == near(drum=-90.0, p=-90.0)
    for start in ({"p": 0.5}, {"carrier": {"x": 1e-3}}, {"drum": {"speed": 0.0}}):
        assert angles(free, start)["drum"] == 0.0
    assert angles(machine(on_track(3)))["b2"] == pytest.approx(-90.0)
    assert angles(machine(on_track(3, start="even"))) == near(drum=-90.0, b1=-90.0, b2=30.0, b3=150.0)
    assert angles(machine(on_track(3), carrier=MOUNTED | {"gravity": 0.0})) == near(drum=0.0, b1=0.0, b2=120.0, b3=-120.0)
    assert angles(machine(ball("p", release={"speed": 10.0}))) == near(drum=-90.0, p=-90.0)
    balanced = machine_from({"carrier": MOUNTED, "bodies": [DRUM | {"unbalance": 0.0}, ball("p")], "drive": MOTOR})
    assert angles(balanced) == near(drum=0.0, p=-90.0)
    assert angles(machine(carrier=MOUNTED | {"gravity": -9.81})) == near(drum=90.0)


def test_balls_beside_one_that_is_named_stand_in_an_even_ring() -> None:
    """One of several is moved, or all are given speeds: the others do not lie in one place."""
    ring = {"drum": 0, "b2": 90, "b3": -180, "b4": -90}
    assert angles(machine(on_track(4)), {"b1": 0.5}) == near(b1=math.degrees(0.5), **ring)
    speeds = {f"b{k}": {"speed": 1.0} for k in (1, 2, 3, 4)}
    assert angles(machine(on_track(4)), speeds) == near(b1=0, **ring)


@pytest.mark.parametrize(
    ("axes", "hangs"),
    [({"drum.unbalance": [0.01, 0.02, 2], "p1.mass": [0.1, 0.2, 2]}, True), ({"psi": [0, 1, 2], "delta": [0, 1, 2]}, False)],
)
def test_members_hang_unless_an_axis_is_a_start(axes: dict[str, Any], hangs: bool) -> None:
    of = machine(ball("p1"), ball("p2"))
    result = run(Basin.from_table({"axes": axes, "until": 0.5}), of)
    assert any(words.startswith(HANGS) for words in result.wucht.assumed) is hangs
    quantities = [varied_quantity(of, name, "axes") for name in axes]
    starts, _ = initial_states(of, {}, quantities, np.array([[0.01], [0.1]]), "axes")
    assert starts[of.state_names.index("drum.angle"), 0] == pytest.approx(-math.pi / 2 if hangs else 0.0)


def test_equal_bodies_that_can_pass_each_other_hang_a_little_apart() -> None:
    """To both sides of the lowest place: two and three, of which no two are at one place; different ones hang together."""
    half = math.degrees(5e-4)
    assert angles(machine(ball("p1"), ball("p2"))) == near(drum=-90.0, p1=-90 - half, p2=-90 + half)
    three = angles(machine(ball("p1"), ball("p2"), ball("p3")))
    assert three == near(drum=-90.0, p1=-90 - 2 * half, p2=-90.0, p3=-90 + 2 * half)
    assert angles(machine(ball("p1"), ball("p2", mass=0.1001))) == near(drum=-90.0, p1=-90.0, p2=-90.0)
    assert angles(machine(ball("p1"), ball("p2")), {"drum": 0.0}) == near(drum=0.0, p1=0.0, p2=0.0), "a start is what it says"


def test_two_equal_pendulums_without_a_start_have_an_outcome() -> None:
    """That of pendulums that a user starts 0.3 rad apart; from one place they move as one, and it says what to do."""
    balanced = {"mass": 0.05, "length": 0.08, "damping": 3.5e-3}  # 8e-3 kg m, more than the rotor's 5e-3 kg m
    drum = {"kind": "rotor", "name": "drum", "mass": 7.9, "unbalance": 5e-3, "inertia": 0.05}
    of = machine_from({
        "carrier": {"mass": 2.0, "stiffness": 1e4, "damping": 60.0, "gravity": 9.81},
        "bodies": [drum, ball("p1", **balanced), ball("p2", **balanced)], "drive": MOTOR,
    })  # fmt: skip
    default, apart, together = (
        run(RunUp(until=60.0, start=start), of)
        for start in ({}, {"drum": -math.pi / 2, "p1": -0.15, "p2": 0.15}, {"drum": -math.pi / 2})
    )
    outcomes = [result.wucht.summary["outcome"] for result in (default, apart, together)]
    assert outcomes == ["compensated", "compensated", "unidentified"]
    assert default.wucht.summary["start_state"] == "at rest, hanging, equal bodies 0.001 rad apart"
    assert any("start them at different angles" in warning for warning in together.wucht.warnings)
