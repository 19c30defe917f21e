"""Branches of synchronous motions as orbits of the full equations: against relative equilibria, and orbits at given values."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.analysis.synchronous_motion import SynchronousMotion, SynchronousMotions
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.numerics.flow.integration import integrate

ROTOR = {"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 9.75e-4}
BALL = {"kind": "pendulum", "about": "drum", "mass": 0.125, "length": 0.104, "inertia": 1.69e-3, "damping": 0.169}
SLOPE = 9.75e-4


def drum(stiffness: Any, drive: dict[str, Any] | None = None) -> Machine:
    """R1 of the dissertation's errata at u = 1, with other stiffnesses: the motor cannot pass the resonance."""
    motor = {"kind": "linear", "slope": SLOPE, "no_load_speed": 200.0}
    bodies = [ROTOR, BALL | {"name": "p1"}, BALL | {"name": "p2"}]
    carrier = {"directions": "xy", "stiffness": stiffness, "damping": 200.0}
    return machine_from({"carrier": carrier, "bodies": bodies, "drive": drive or motor})


@cache
def captured(equal: bool) -> tuple[SynchronousMotions, SynchronousMotion]:
    """The motion in which a run from rest ends."""
    machine = drum(1e5 if equal else [1e5, 1.1e5])
    motions, start = SynchronousMotions.of(machine), np.zeros(len(machine.state_names))
    start[[machine.row(b.coordinate.position) for b in machine.bodies[1:]]] = 0.3, -0.5
    state = integrate(motions.flow, start, machine.values, np.array([0.0, 15.0])).states[:, -1]
    return motions, motions.find_near(state, float(state[machine.row(machine.rotor.coordinate.velocity)]))


@pytest.mark.slow
def test_orbits_of_an_isotropic_machine_fold_where_its_relative_equilibria_do() -> None:
    """Two formulations of the same: u1* = 1.833108 of table 5.1, times SLOPE."""
    motions, near = captured(True)
    assert motions.relative is not None and near.equilibrium is not None
    equilibria = motions.relative.branches_over("drive.slope", (SLOPE, 3 * SLOPE), near.equilibrium)
    (fold,) = equilibria.follow_branch(equilibria.start(near.equilibrium.state, SLOPE)).special
    cycles, first = motions.orbit_branch("drive.slope", (SLOPE, 3 * SLOPE), near)
    np.testing.assert_allclose(np.sort(first.logarithms.real)[-4:] / near.period, np.sort(near.exponents.real)[-4:], rtol=1e-6)
    (same,) = [c for c in cycles.walk(first) if c.kind]
    assert same.kind == "fold" and same.parameter == pytest.approx(fold.parameter, rel=1e-9)
    assert same.parameter == pytest.approx(1.8331080 * SLOPE, rel=5e-8)
    assert 2 * math.pi / same.period == pytest.approx(
        float(fold.x[equilibria.equations.state_names.index("drum.speed")]), rel=1e-7
    )


@pytest.mark.slow
def test_the_edge_of_capture_on_unequal_supports_is_a_fold_of_orbits() -> None:
    """The slowest rate vanishes there; a motor a little weaker keeps the rotor, a little stronger does not."""
    motions, near = captured(False)
    assert motions.relative is None and near.orbit is not None
    cycles, first = motions.orbit_branch("drive.slope", (SLOPE, 4 * SLOPE), near)
    branch = [first, *cycles.walk(first)]
    (fold,) = [c for c in branch if c.kind == "fold"]
    assert 1.2 * SLOPE < fold.parameter < 3 * SLOPE
    machine = motions.machine

    def at(slope: float) -> SynchronousMotions:
        return SynchronousMotions.of(machine.with_values({"drive.slope": slope}))

    def slowest(distance: float) -> float:
        """The rate of the slowest multiplier, of an orbit at a relative distance below the fold."""
        slope = fold.parameter * (1 - distance)
        stable = [c for c in branch if not c.unstable and not c.kind]
        start = min(stable, key=lambda c: abs(c.parameter - slope))
        orbit = at(slope).orbit(start.states[:, 0], 2 * math.pi / start.period)
        return float(np.log(np.abs(orbit.nontrivial(1))).max())

    rates = np.array([slowest(d) for d in (0.004, 0.016)])
    assert (rates < 0).all() and rates[1] / rates[0] == pytest.approx(2.0, rel=0.05), "it vanishes as the root of the distance"
    for share, stays in ((0.98, True), (1.02, False)):
        other = at(share * fold.parameter)
        run = integrate(other.flow, fold.states[:, 0], other.machine.values, np.linspace(0.0, 60.0, 601))
        highest = run.states[machine.row(machine.rotor.coordinate.velocity)].max()
        assert (highest < 1.05 * 2 * math.pi / fold.period) == stays


def test_a_branch_begins_at_the_motion_itself() -> None:
    """As an orbit by collocation it has the period and the slowest multipliers of Newton's method."""
    motions, near = captured(False)
    _, first = motions.orbit_branch("drive.slope", (SLOPE, 4 * SLOPE), near)
    assert (first.parameter, first.period) == pytest.approx((SLOPE, near.period), rel=1e-6)
    slowest = np.sort(first.logarithms.real)[-4:] / near.period
    np.testing.assert_allclose(slowest, np.sort(near.exponents.real)[-4:], rtol=1e-5)


def test_what_cannot_be_followed_is_told() -> None:
    motions, near = captured(False)
    with refused("parameter", given="drive.slop"):
        motions.orbit_branch("drive.slop", (0, 1), near)
    held = SynchronousMotions.of(drum([1e5, 1.1e5], {"kind": "constant-speed", "speed": 70.0}))
    with refused("machine", given=None):
        held.orbit_branch("carrier.damping", (100, 300), near)
