"""Opening and closing in closed form against slow ramps of the speed; rigid pendulums and none in their place."""

import math
from collections.abc import Sequence

import numpy as np
import pytest

from wucht.analysis.switching import (
    switchable,
    switching,
    with_rigid_pendulums,
)
from wucht.analysis.vibration import unbalances
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.machines.structure import SPEED
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

M, R_I, R_O, FORCE = 0.25, 0.052, 0.104, 292.5
RAMP = 6.0


def ramped(stiffness: float, speeds: Sequence[float]) -> tuple[np.ndarray, np.ndarray, np.ndarray, Machine]:
    """The displacement and the pendulum's speed (N,) as the drum, on a fixed axis, goes slowly through these speeds."""
    pendulum = {
        "kind": "switchable-pendulum", "name": "p", "about": "drum", "mass": 0.5, "inertia": 0.05, "damping": 5.0,
        "moving_mass": M, "inner_stop": R_I, "outer_stop": R_O, "stiffness": stiffness, "preload": FORCE, "guide_damping": 5.0,
    }  # fmt: skip
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.0, "inertia": 0.03}
    drive = {"kind": "constant-speed", "on": "drum", "speed": speeds[0]}
    points = [[RAMP * k, w] for k, w in enumerate(speeds)]
    document = {"carrier": {"directions": "fixed"}, "bodies": [drum, pendulum], "drive": drive}
    machine = machine_from(document | {"schedules": [{"parameter": "drive.speed", "points": points}]})
    grid = np.linspace(0.0, RAMP * (len(points) - 1), 4001 * (len(points) - 1))
    run = integrate(compile_system(machine.system), initial_state(machine, {}), machine.values, grid)
    assert run.failure is None
    rows = dict(zip(machine.state_names, run.states, strict=True))
    return rows["p.displacement"], rows["p.speed"], grid, machine


def test_it_opens_and_closes_with_hysteresis_at_the_speeds_of_the_closed_form() -> None:
    """sqrt(F/(m r_i)) = 150 rad/s and sqrt((F + c d)/(m r_o)) = 119.37 rad/s; a strong damper keeps it at the drum's speed."""
    s, w, time, machine = ramped(1500.0, (140.0, 160.0, 110.0))
    at = switching(machine, switchable(machine)[0])
    assert at.opening == pytest.approx(math.sqrt(FORCE / (M * R_I)), rel=1e-15)
    assert at.opening == pytest.approx(150.0, rel=1e-12)
    assert at.closing == pytest.approx(math.sqrt((FORCE + 1500.0 * (R_O - R_I)) / (M * R_O)), rel=1e-15)
    assert at.snaps
    assert at.stays_open
    way_up = time <= RAMP
    lifted = w[way_up & (s <= 1e-4)]  # before it snaps
    assert lifted.max() == pytest.approx(at.opening, rel=1e-3)
    # It leaves the outer stop, which has given way, as soon as the force on it vanishes.
    fallen = w[(time > RAMP) & (s >= (R_O - R_I) - 1e-4)]
    assert fallen[-1] == pytest.approx(at.closing, rel=1e-3)
    assert s[-1] == pytest.approx(-(FORCE - M * R_I * w[-1] ** 2) / (M * (50 * 150.0) ** 2), rel=1e-2)


def test_a_stiff_spring_opens_gradually() -> None:
    """c r_i > F: between both speeds s = (m w^2 r_i - F)/(c - m w^2)."""
    s, w, _, machine = ramped(9000.0, (140.0, 190.0))
    at = switching(machine, switchable(machine)[0])
    assert not at.snaps
    assert at.closing == pytest.approx(171.1, abs=0.1)
    between = (w > at.opening + 1) & (w < at.closing - 1)
    expected = (M * w**2 * R_I - FORCE) / (9000.0 - M * w**2)
    assert np.count_nonzero(between) > 1000
    assert s[between] == pytest.approx(expected[between], abs=3e-4)


def test_the_speed_after_opening_keeps_the_angular_momentum() -> None:
    """Without a damper, and so slowly prepared that only the snap changes it: just above the opening speed."""
    machine = load_machine("drozdetskaya-2020/switchable-pendulums")
    p = switchable(machine)[0]
    before, after = 0.01 + M * R_I**2, 0.01 + M * R_O**2
    assert switching(machine, p).open_speed == pytest.approx(150.0 * before / after, rel=1e-12)
    free = machine.with_values({"p1.damping": 0.0})
    start = {"drum": {"speed": "150.5 rad/s"}, "p1": {"speed": "150.5 rad/s"}, "p2": {"speed": "150.5 rad/s"}}
    heavy = free.with_values({"carrier.stiffness": 1e9, "drum.mass": 1e6, "drum.unbalance": 0.0})  # an axis at rest
    run = integrate(compile_system(heavy.system), initial_state(heavy, start), heavy.values, np.linspace(0, 0.4, 4001))
    rows = dict(zip(heavy.state_names, run.states, strict=True))
    momentum = (0.01 + M * (R_I + rows["p1.displacement"]) ** 2) * rows["p1.speed"]
    assert momentum == pytest.approx(np.full(4001, momentum[0]), rel=1e-6)
    assert rows["p1.displacement"].max() > 0.052
    out = rows["p1.displacement"] >= 0.052
    assert rows["p1.speed"][out] == pytest.approx(150.5 * before / after, rel=5e-3)


def test_rigid_pendulums_have_the_masses_at_the_outer_stops() -> None:
    """As the machine's own with the masses there: mass, unbalance, and kinetic energy in operation."""
    machine = load_machine("drozdetskaya-2020/switchable-pendulums").with_values({"p1.moving_mass": 0.3, "drum.inertia": 0.05})
    rigid = with_rigid_pendulums(machine)
    assert [b.kind for b in rigid.bodies] == ["rotor", "pendulum", "pendulum"]
    assert not rigid.sliders
    assert rigid.values["drum.inertia"] == 0.05
    assert unbalances(rigid) == pytest.approx([9.75e-3, 0.3 * 0.052, 0.25 * 0.052], rel=1e-12)
    assert rigid.matrices[0] == pytest.approx(machine.matrices[0], rel=1e-12)
    open_energy = 0.05 + 0.01 * 2 + (0.3 + 0.25) * R_O**2
    assert 2 * rigid.evaluate(rigid.structure.kinetic_in_operation.xreplace({SPEED: 1.0}))[0] == pytest.approx(open_energy)
