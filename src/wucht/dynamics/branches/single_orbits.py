"""Orbits that are reported one by one: how they run, and their exponents, from integrated variational equations."""

from __future__ import annotations

import math
from collections.abc import Sequence
from contextlib import suppress
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.branches.first_orbits import SeedOrbit, cycles_of
from wucht.dynamics.branches.orbit_branches import StoredOrbit, peak, stored_orbit
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.errors import RunError
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import settled
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.floquet import across_flow, integrated_maps, logarithms

_PLACES = 400  # at which an orbit is drawn
_STEPS_THERE = 100  # from an orbit that was kept
_FINE = 6000  # at which its extremes are looked for


@dataclass(frozen=True)
class ReportedOrbit:
    """An orbit.

    shown, amplitude (P,): over a period, at even times; turned (P,): the rotor's angle by then, not numbers of a system.
    period_phi: the rotor's angle in a period. low, high: of what is drawn, least, largest: of the amplitude. exponents (n-1,):
    per unit of time, without the trivial one, the largest first. along: ln mu of the trivial one, as it was found. kind: of a
    special orbit.
    """

    value: float
    period: float
    period_phi: float
    low: float
    high: float
    least: float
    largest: float
    exponents: np.ndarray
    along: float
    shown: np.ndarray
    amplitude: np.ndarray
    turned: np.ndarray
    kind: str


def near(kept: Sequence[StoredOrbit], value: float) -> list[tuple[StoredOrbit, ...]]:
    """Of each passage of a branch through a value the orbits beside it, the nearest first."""
    values = np.array([k.value for k in kept])
    passed = np.flatnonzero((values[:-1] - value) * (values[1:] - value) < 0).tolist()
    beside = [sorted((kept[i], kept[i + 1]), key=lambda k: abs(k.value - value)) for i in passed]
    return [*((k,) for k in kept if k.value == value), *map(tuple, beside)]


def reported(subject: OrbitProblem, seed: SeedOrbit, beside: Sequence[StoredOrbit], value: float) -> ReportedOrbit:
    """The orbit at a value beside some that were kept. Raises ``RunError`` where it is not found."""
    cycles = cycles_of(subject, seed.winding, seed.scale, 2 * seed.longest)
    # At a special orbit the equations are singular, and it was located as well as it can be.
    found = beside[0] if beside[0].kind else stored_orbit(_at(cycles, beside, value))
    values, along = _exponents(subject, found, value)
    mesh, tau, fine = found.mesh, np.linspace(0.0, 1.0, _PLACES), np.linspace(0.0, 1.0, _FINE)
    shown, amplitude = subject.observables(mesh.at(found.states, tau).T, value)
    low, high, least, largest = (
        side * peak(fine, side * x) for x in subject.observables(mesh.at(found.states, fine).T, value) for side in (-1, 1)
    )
    speed = np.abs(shown) if subject.rotor else np.full(_PLACES, np.nan)
    turned = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(tau))]) * found.period
    pieces = mesh.pieces(subject.observables(found.states.T, value)[0][:, None])[..., 0]
    whole = abs(float((mesh.weights * (pieces @ mesh.basis.values.T)).sum())) * found.period if subject.rotor else np.nan
    return ReportedOrbit(
        value, found.period, whole, low, high, least, largest, values, along, shown, amplitude, turned, found.kind
    )


def _at(cycles: Cycles, beside: Sequence[StoredOrbit], value: float) -> Cycle:
    """The orbit at a value: by Newton's method from one that was kept, else by following the branch from there.

    Raises ``RunError``.
    """
    for way in (_corrected, _followed):
        for orbit in beside:
            with suppress(RunError):
                return way(cycles, orbit, value)
    raise RunError("neither Newton's method nor the branch leads to it from the orbits beside it")


def _corrected(cycles: Cycles, orbit: StoredOrbit, value: float) -> Cycle:
    return settled(cycles, orbit.mesh, orbit.states, orbit.period, value)


def _followed(cycles: Cycles, orbit: StoredOrbit, value: float) -> Cycle:
    start, up = _corrected(cycles, orbit, orbit.value), value > orbit.value
    bounds = (-math.inf, value) if up else (value, math.inf)
    to = replace(cycles, bounds=bounds, steps=replace(cycles.steps, points=_STEPS_THERE))
    start = replace(start, curve=to.curve(start.problem))
    *_, last = start, *to.walk(start if (start.point.tangent[-1] > 0) == up else to.backwards(start))
    if last.parameter != value:
        raise RunError("it lies beyond a fold")
    return last


def _exponents(subject: OrbitProblem, orbit: StoredOrbit, value: float) -> tuple[np.ndarray, float]:
    """Per unit of time, the largest first, and ln mu of the trivial multiplier."""
    parameters = {**subject.values, subject.path: value}
    at_edges = orbit.states[:: orbit.mesh.degree].T
    maps, flow = integrated_maps(subject.system, parameters, orbit.mesh.edges * orbit.period, at_edges)
    across, along = across_flow(maps, flow)
    values = logarithms(across)[0] / orbit.period
    return values[np.argsort(-values.real, kind="stable")], along
