"""What dry friction holds, the fastest stable working point, and what schedules have left."""

from __future__ import annotations

from typing import Any

import pytest

from wucht.analysis.working_points import is_held_at_rest
from wucht.dynamics.run_ups.operating_state import machine_after_schedules, state_at_working_point
from wucht.dynamics.run_ups.settled_operation import rest_events
from wucht.files.building import machine_from
from wucht.machines.machine import Machine


def two_rotors(torques: tuple[float, float], friction: tuple[float, float] = (4.0, 4.0), **more: Any) -> Machine:
    rotors = [{"kind": "rotor", "name": n, "mass": 1.0, "eccentricity": 0.0, "inertia": 0.1} for n in ("a", "b")]
    drives = [{"on": n, "kind": "constant-torque", "torque": t} for n, t in zip(("a", "b"), torques, strict=True)]
    loads = [{"on": n, "kind": "coulomb", "torque": t} for n, t in zip(("a", "b"), friction, strict=True)]
    return machine_from({"carrier": {"directions": "fixed"}, "bodies": rotors, "drives": drives, "loads": loads} | more)


@pytest.mark.parametrize(
    ("torques", "held"),
    [
        ((3.0, 3.0), True), ((-3.0, 3.0), True), ((3.0, -3.0), True), ((5.0, 3.0), False), ((3.0, -5.0), False),
        ((-5.0, -5.0), False),
    ],
)  # fmt: skip
def test_dry_friction_holds_a_machine_where_it_holds_all_rotors(torques: tuple[float, float], held: bool) -> None:
    machine = two_rotors(torques)
    assert is_held_at_rest(machine) is held
    assert len(rest_events(machine)) == held


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_fastest_stable_working_point(sense: float) -> None:
    """40 N m of friction, against a drive with 20 N m at standstill, 60 N m at 50 rad/s and none at 100 rad/s."""
    points = [[0.0, 20.0], [50.0, 60.0], [100.0, 0.0]]
    points = points if sense > 0 else [[-w, -torque] for w, torque in reversed(points)]
    machine = machine_from({
        "carrier": {"directions": "fixed"},
        "bodies": [{"kind": "rotor", "name": "a", "mass": 1.0, "unbalance": 0.0, "inertia": 1.0}],
        "drive": {"on": "a", "kind": "table", "points": points}, "loads": [{"on": "a", "kind": "coulomb", "torque": 40.0}],
    })  # fmt: skip
    placed = state_at_working_point(machine, {}, lambda: None)
    assert placed is not None
    state, speed = placed
    at = state[machine.row(machine.rotor.coordinate.velocity)]
    assert at == sense * speed and 50.0 < speed < 100.0 and is_held_at_rest(machine)
    assert state_at_working_point(machine.with_values({"load.torque": 70.0}), {}, lambda: None) is None


def test_schedules_end_as_they_are_at_a_time() -> None:
    ramp = {"parameter": "drives.b.torque", "points": [[0.0, 1.0], [2.0, 5.0]]}
    machine = two_rotors((3.0, 1.0), schedules=[ramp])
    for time, torque in ((None, 5.0), (0.5, 2.0), (9.0, 5.0)):
        steady = machine_after_schedules(machine, time=time)
        assert steady.values["drives.b.torque"] == pytest.approx(torque) and steady.schedules == ()
