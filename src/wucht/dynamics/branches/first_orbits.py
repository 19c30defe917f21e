"""First orbits of branches: by a run at a value of the parameter until it repeats itself, or at Hopf points."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.dynamics.branches.steady_states import Heartbeat
from wucht.dynamics.limit_sets.resting_states import decays, sign_of_growth
from wucht.errors import WuchtError
from wucht.numerics.collocation.mesh import Mesh
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equilibria import HOPF
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.jacobian import Jacobian
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.orbits import periodic_orbit
from wucht.numerics.periodic.branch_ends import significant_value
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_at_hopf, cycle_near
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.hopf_ends import equilibria_of
from wucht.numerics.recurrence import Recurrence, is_at_rest, recurrence
from wucht.system import System

LONGEST = 20.0  # times the first period
_FIRST_SPAN = 30.0  # times the time in which states change as much as they are large
_GROWS = 30.0  # largest ratio of a run to the one before: near a steady state rates do not indicate the time needed
_RUNS = 12  # one after another, until the motion has settled
_SAMPLES = 20_001  # of each of them, and of the orbit that Newton's method begins with
_REPEATS = 4  # least number of passages, in a run, of an orbit on which no angle turns
_LEAST_EXTENT = 1e-3  # relative to a state, and then absolute: smaller changes do not count
_PERIODS_AGREE = 0.05  # relative: of the run and of the orbit computed by Newton's method
_SCALES = 5.0  # in how many parts of the range the parameter changes much
_STEPS = Steps(most=0.3, turn=0.3, corrections=4, tolerance=1e-8, points=1500)
_TOLERANCE = 1e-10
_NEUTRAL = 1e-6  # a disturbance that changes less in a period neither grows nor decays
_FAMILY = "one of a family: disturbances neither grow nor decay"
_REST_SENTENCES = {
    True: "it settles in a steady state",
    False: "it rests at an unstable equilibrium: any disturbance leads away from it, as does another start",
    None: "it rests at an equilibrium about which disturbances neither grow nor decay",
}


@dataclass(frozen=True)
class SeedOrbit:
    """Orbit from which a branch is followed.

    states (K, n): at the nodes of its mesh. winding (n,). scale (n+1,): of states and parameter. towards: of all unknowns, the
    direction in which the branch is followed, empty for both ways. origin: of the orbit, as text. longest: the period up to
    which it is followed.
    """

    mesh: Mesh
    states: np.ndarray
    period: float
    value: float
    winding: np.ndarray
    scale: np.ndarray
    towards: np.ndarray
    origin: str
    longest: float

    @classmethod
    def from_cycle(cls, cycles: Cycles, cycle: Cycle, origin: str, both_ways: bool) -> SeedOrbit:
        """Return an orbit of a branch as a seed."""
        scale = np.delete(cycles.equations.scale, cycle.problem.n)
        towards = np.empty(0) if both_ways else cycle.point.tangent
        return cls(
            cycle.problem.mesh, cycle.states.T, cycle.period, cycle.parameter, cycles.winding, scale, towards, origin,
            cycles.periods[1],
        )  # fmt: skip


@dataclass(frozen=True)
class SettlingRun:
    """Result of a run at a value. orbit: None if it reaches none. sentence: what it reaches. is_steady: a steady state.

    is_family: a motion that is one of a family, or at rest among them, as of a conservative system.
    """

    value: float
    orbit: SeedOrbit | None
    sentence: str
    is_steady: bool = False
    is_family: bool = False


def cycles_of(subject: OrbitProblem, winding: np.ndarray, scale: np.ndarray, longest: float) -> Cycles:
    """Return the branches of orbits with a winding (n,). scale (n+1,): of states and parameter."""
    system, path = subject.system, subject.path
    sizes = dict(zip((*system.state_names, path), scale.tolist(), strict=True))
    return Cycles.of(
        system, path, subject.fixed_values(path), subject.bounds,
        winding=subject.turns(winding), scale=sizes, periods=(0.0, longest), steps=_STEPS,
    )  # fmt: skip


def orbit_of_run(
    subject: OrbitProblem, value: float, until: float | None, longest: float | None, report: Heartbeat
) -> SettlingRun:
    """Run at a value from the subject's start until the motion repeats itself. until: the longest time."""
    first = np.asarray(subject.initial(value), float)
    if until is None:
        return orbit_near(subject, value, first, report, longest=longest)
    return orbit_near(subject, value, first, report, lambda _: until / 3, longest, runs=2)


def _times_of_change(system: System, parameters: Sequence[float]) -> Callable[[np.ndarray], float]:
    """Return a function: state (n,) -> a multiple of the time in which states change by their size."""
    rates = Evaluator.of_rates(system)

    def span(state: np.ndarray) -> float:
        change = rates.array(np.zeros(1), state[:, None], parameters)[:, 0]
        fastest = float((np.abs(change) / np.maximum(np.abs(state), 1.0)).max())
        return _FIRST_SPAN / fastest if fastest > 0 else _FIRST_SPAN

    return span


def orbit_near(
    subject: OrbitProblem, value: float, state: np.ndarray, report: Heartbeat,
    span: Callable[[np.ndarray], float] | None = None, longest: float | None = None, runs: int = _RUNS,
) -> SettlingRun:  # fmt: skip
    """Run at a value of the parameter until the motion settles on an orbit or in a steady state.

    The run is continued, twice as long each time, until that is clear; where it repeats itself, Newton's method begins with
    one more run over that period alone, sampled as densely as its fast part needs.

    Parameters
    ----------
    state : ndarray, (n,)
        Start of the run.
    span : callable, optional
        State -> least duration of the run from there; by default a multiple of the time in which states change.
    longest : float, optional
        The period up to which the branch is to be followed; by default ``LONGEST`` times that of the orbit.
    runs : int
        Largest number of continuations.
    """
    at, done, last = f"at {subject.path} = {value:.6g}", 0.0, 0.0
    parameters = subject.parameters_at(value)
    span = span or _times_of_change(subject.system, parameters)
    compiled_system = compile_system(subject.system, _TOLERANCE)
    for _ in range(runs):
        report()
        last = max(2 * last, min(span(state), _GROWS * last)) if last else span(state)
        run = integrate(compiled_system, state, parameters, np.linspace(0.0, last, _SAMPLES)).reraise_interrupt()
        if run.failure is not None:
            return SettlingRun(value, None, f"{at} the run fails: {run.failure}")
        if is_at_rest(run.states[:, _SAMPLES // 2 :]):
            attracts = _rest_attracts(subject.system, parameters, run.states[:, -1])
            sentence = f"{at} {_REST_SENTENCES[attracts]}"
            return SettlingRun(value, None, sentence, is_steady=True, is_family=attracts is None)
        done, state = done + last, run.states[:, -1]
        state = state - np.where(subject.turning, 2 * np.pi * np.round(state / (2 * np.pi)), 0.0)
        repetition = recurrence(run.time, run.states, subject.turning)
        if repetition is None or not (repetition.turns.any() or repetition.period < last / _REPEATS):
            continue
        period = integrate(
            compiled_system, state, parameters, np.linspace(0.0, repetition.period, _SAMPLES)
        ).reraise_interrupt()
        if period.failure is not None:
            return SettlingRun(value, None, f"{at} the run fails: {period.failure}")
        least = _LEAST_EXTENT * np.maximum(np.abs(period.states).max(axis=1), _LEAST_EXTENT)
        scale = np.where(subject.turning, 1.0, np.maximum(np.ptp(period.states, axis=1), least))
        cycles = _first_cycles(subject, repetition.turns, scale, repetition.period, longest)
        try:
            cycle = cycle_near(cycles, period.time, period.states, value)
        except WuchtError:  # the run has not settled yet, or it never will
            if _is_of_a_family(compiled_system, parameters, state, repetition, subject.turning):
                sentence = f"{at} it is periodic with period {repetition.period:.6g}, {_FAMILY}"
                return SettlingRun(value, None, sentence, is_family=True)
            continue
        if abs(cycle.period / repetition.period - 1) < _PERIODS_AGREE:
            orbit = SeedOrbit.from_cycle(cycles, cycle, f"a run {at}", both_ways=True)
            return SettlingRun(value, orbit, f"{at} it settles on an orbit of period {cycle.period:.6g}")
    return SettlingRun(value, None, f"{at} it has settled neither in a steady state nor on an orbit after {done:.4g}")


@lru_cache(maxsize=8)
def _jacobian(system: System) -> Jacobian:
    return Jacobian.of(system)


def _rest_attracts(system: System, parameters: Sequence[float], state: np.ndarray) -> bool | None:
    """Return whether a state at rest attracts; None where motions oscillate about it that neither grow nor decay."""
    matrix = _jacobian(system).values_at(state, parameters)[1]
    eigenvalues = np.linalg.eigvals(matrix) if np.isfinite(matrix).all() else np.empty(0)
    attracts = decays(eigenvalues)
    return True if attracts is None and not eigenvalues[eigenvalues.real.argmax()].imag else attracts


def _is_of_a_family(
    compiled_system: CompiledSystem, parameters: Sequence[float], state: np.ndarray, repetition: Recurrence,
    turning: np.ndarray,
) -> bool:  # fmt: skip
    """True if the motion from a state is periodic, and disturbances of it neither grow nor decay."""
    rates = _jacobian(compiled_system.system).values_at(state, parameters)[0]
    phase_state = None if repetition.turns.any() else int(np.abs(np.where(turning, 0.0, rates)).argmax())
    try:
        orbit = periodic_orbit(
            compiled_system, parameters, state, repetition.period, 2 * np.pi * repetition.turns, phase_state=phase_state
        )
    except WuchtError:
        return False
    return sign_of_growth(np.abs(orbit.nontrivial(1)) - 1, _NEUTRAL) is None


def _first_cycles(
    subject: OrbitProblem, winding: np.ndarray, sizes: np.ndarray, period: float, longest: float | None
) -> Cycles:
    """Return ``cycles_of`` for a first orbit. sizes (n,): typical changes of the states."""
    scale = np.append(sizes, np.ptp(subject.bounds) / _SCALES)
    return cycles_of(subject, winding, scale, longest or LONGEST * period)


def orbits_of_hopf_points(
    subject: OrbitProblem, branches: tuple[EquilibriumBranch, ...], sizes: np.ndarray, longest: float | None
) -> tuple[SeedOrbit | str, ...]:
    """Return the first orbits at the Hopf points of steady states, or sentences why there is none.

    sizes (n,): typical changes of the states.
    """
    orbits = list[SeedOrbit | str]()
    for branch in branches:
        for i in np.flatnonzero([kind == HOPF for kind in branch.kinds]).tolist():
            unknowns, exponents = branch.unknowns[:, i], branch.exponents[:, i]
            pair = exponents[exponents.imag > 0]
            period = 2 * np.pi / float(pair[np.abs(pair.real).argmin()].imag)
            cycles = _first_cycles(subject, np.zeros(len(unknowns) - 1, int), sizes, period, longest)
            place = f"the Hopf point at {subject.path} = {significant_value(float(unknowns[-1]), subject.bounds):.6g}"
            equilibria = equilibria_of(cycles.equations)
            try:
                hopf = equilibria.evaluate(equilibria.start(unknowns[:-1], float(unknowns[-1])))
                orbits.append(SeedOrbit.from_cycle(cycles, cycle_at_hopf(cycles, hopf), place, both_ways=True))
            except WuchtError as error:
                orbits.append(f"the branch from {place} is not followed: {error}")
    return tuple(orbits)
