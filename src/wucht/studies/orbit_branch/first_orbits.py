"""First orbits: a run at a value of the parameter until it repeats itself, or the Hopf points of steady states."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError, WuchtError
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equilibria import HOPF, Equilibria, Equilibrium
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.periodic.branch_ends import equations_of
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_at_hopf, cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.recurrence import recurrence, rests
from wucht.studies.orbit_branch.orbit_subject import OrbitSubject
from wucht.studies.speed_curve.following import FollowedBranch

_FIRST_SPAN = 30.0  # times the time in which states change as much as they are large
_DOUBLINGS = 12  # of the run, until it has settled
_SAMPLES = 20_000  # of each half of a run
_PER_PERIOD = 2_000  # samples of the orbit that Newton's method begins with
_PERIODS_AGREE = 0.1  # relative: of the run and of the orbit that Newton's method finds
_SCALES = 5.0  # in how many parts of the range the parameter changes much
_LONGEST = 20.0  # times the first period
_STEPS = Steps(most=0.3, turn=0.3, corrections=4, tolerance=1e-8, points=1500)
_TOLERANCE = 1e-10


@dataclass(frozen=True)
class SeedOrbit:
    """An orbit from which a branch is followed.

    edges (N+1,): of its mesh, of a degree. states (K, n) at its nodes. period, value. winding (n,). scale (n+1,): of states and
    parameter. towards: of all unknowns, the direction in which the branch is followed, empty where both ways are. begun: where
    it is from. longest: the period up to which it is followed.
    """

    edges: np.ndarray
    degree: int
    states: np.ndarray
    period: float
    value: float
    winding: np.ndarray
    scale: np.ndarray
    towards: np.ndarray
    begun: str
    longest: float

    @property
    def mesh(self) -> Mesh:
        """Its mesh."""
        return Mesh(self.edges, self.degree)

    @classmethod
    def of(cls, cycles: Cycles, cycle: Cycle, begun: str, both_ways: bool) -> SeedOrbit:
        """An orbit as one."""
        mesh, n = cycle.problem.mesh, cycle.problem.n
        scale = np.delete(cycles.equations.scale, n)
        towards = np.empty(0) if both_ways else cycle.point.tangent
        return cls(
            mesh.edges, mesh.degree, cycle.states.T, cycle.period, cycle.parameter, cycles.winding, scale, towards, begun,
            cycles.periods[1],
        )  # fmt: skip


@dataclass(frozen=True)
class Tried:
    """What a run at a value came to. orbit: None where it is none. sentence: what was found instead."""

    value: float
    orbit: SeedOrbit | None
    sentence: str


def cycles_of(
    subject: OrbitSubject, bounds: tuple[float, float], winding: np.ndarray, scale: np.ndarray, longest: float
) -> Cycles:
    """The branches of a winding (n,). scale (n+1,): of states and parameter."""
    names = subject.system.state_names
    turns = {name: int(w) for name, w in zip(names, winding, strict=True) if w}
    sizes = dict(zip((*names, subject.path), scale.tolist(), strict=True))
    return Cycles.of(
        subject.system, subject.path, subject.fixed, bounds, winding=turns, scale=sizes, periods=(0.0, longest), steps=_STEPS
    )


def orbit_of_run(
    subject: OrbitSubject, bounds: tuple[float, float], value: float, until: float | None, longest: float | None,
    watch: Callable[[], None],
) -> Tried:  # fmt: skip
    """Run at a value until the motion repeats itself, twice as long each time."""
    at = f"{subject.path} = {value:.6g}"
    parameters = subject.system.values({**subject.values, subject.path: value})
    compiled, rates = compile_system(subject.system, _TOLERANCE), Evaluator.of_rates(subject.system)
    state = np.asarray(subject.initial(value), float)
    now, span = 0.0, until / 2 if until is not None else _span(rates, state, parameters)
    for _ in range(_DOUBLINGS if until is None else 2):
        watch()
        grid = np.linspace(now, now + span, _SAMPLES + 1)
        run = integrate(compiled, state, parameters, grid).uninterrupted()
        if run.failure is not None:
            return Tried(value, None, f"at {at} the run fails: {run.failure}")
        times, states = run.time, run.states
        if rests(states[:, len(times) // 2 :]):
            return Tried(value, None, f"at {at} it settles in a steady state")
        found = recurrence(times, states, subject.turning)
        if found is not None:
            seed = _settled(subject, bounds, value, times, states, found.period, found.turns, longest)
            if seed is not None:
                return Tried(value, seed, f"at {at} it settles on an orbit of period {seed.period:.6g}")
        now, state = float(times[-1]), states[:, -1]
        span = span if until is not None else max(now, _span(rates, state, parameters))
    return Tried(value, None, f"at {at} it has settled neither in a steady state nor on an orbit after {now:.4g}")


def _span(rates: Evaluator, state: np.ndarray, parameters: tuple[float, ...]) -> float:
    change = rates.array(np.zeros(1), state[:, None], parameters)[:, 0]
    fastest = float((np.abs(change) / np.maximum(np.abs(state), 1.0)).max())
    return _FIRST_SPAN / fastest if fastest > 0 else _FIRST_SPAN


def _settled(
    subject: OrbitSubject, bounds: tuple[float, float], value: float, times: np.ndarray, states: np.ndarray, period: float,
    turns: np.ndarray, longest: float | None,
) -> SeedOrbit | None:  # fmt: skip
    """The orbit near the last period of a run."""
    inside = np.linspace(times[-1] - period, times[-1], _PER_PERIOD + 1)
    last = np.array([np.interp(inside, times, x) for x in states])
    last -= (2 * np.pi * np.round(last[:, :1] / (2 * np.pi))) * subject.turning[:, None]
    extent = np.ptp(last, axis=1)
    sizes = np.where(subject.turning, 1.0, np.maximum(extent, 1e-3 * np.maximum(np.abs(last).max(axis=1), 1e-3)))
    scale = np.append(sizes, np.ptp(bounds) / _SCALES)
    cycles = cycles_of(subject, bounds, turns, scale, longest or _LONGEST * period)
    try:
        cycle = cycle_near(cycles, inside, last, value)
    except RunError:
        return None
    if abs(cycle.period / period - 1) > _PERIODS_AGREE:
        return None
    return SeedOrbit.of(cycles, cycle, f"a run at {subject.path} = {value:.6g}", both_ways=True)


def orbits_of_hopf_points(
    subject: OrbitSubject, bounds: tuple[float, float], branches: tuple[FollowedBranch, ...], sizes: np.ndarray,
    longest: float | None,
) -> tuple[SeedOrbit, ...]:  # fmt: skip
    """The first orbits at the Hopf points of steady states. sizes (n,): by how much states change when they change much."""
    seeds = list[SeedOrbit]()
    for branch in branches:
        for i in np.flatnonzero([kind == HOPF for kind in branch.kinds]).tolist():
            u, exponents = branch.u[:, i], branch.exponents[:, i]
            pair = exponents[exponents.imag > 0]
            period = 2 * np.pi / float(pair[np.abs(pair.real).argmin()].imag)
            scale = np.append(sizes, np.ptp(bounds) / _SCALES)
            cycles = cycles_of(subject, bounds, np.zeros(len(u) - 1, int), scale, longest or _LONGEST * period)
            try:
                cycle = cycle_at_hopf(cycles, _equilibrium(cycles, u))
            except WuchtError:
                continue
            seeds.append(SeedOrbit.of(cycles, cycle, f"the Hopf point at {subject.path} = {u[-1]:.6g}", both_ways=True))
    return tuple(seeds)


def _equilibrium(cycles: Cycles, u: np.ndarray) -> Equilibrium:
    """A Hopf point as ``cycle_at_hopf`` takes it."""
    equilibria = Equilibria(equations_of(cycles), cycles.bounds)
    return equilibria.seen(equilibria.start(u[:-1], float(u[-1])))
