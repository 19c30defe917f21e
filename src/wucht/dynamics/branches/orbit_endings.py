"""End of the modulated motion as a parameter changes, at one place of the plane of two others: the branch is followed to it.

Where the period grows, the orbit is examined at its slowest place. At a saddle, the branch ends at the connection to which
Newton's method converges from the orbit. At a fold ahead, where steady states will appear, the period has to grow as
1/sqrt|p - p*| towards that value.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.dynamics.branches.first_orbits import SeedOrbit, orbit_near
from wucht.dynamics.branches.modulated_motion import ModulatedMotion, lost_states
from wucht.dynamics.branches.orbit_branches import cycles_through
from wucht.dynamics.branches.plane_regions import Range
from wucht.dynamics.branches.steady_states import Heartbeat
from wucht.errors import RunError
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equilibria import FOLD, Equilibrium
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.periodic.branch_ends import (
    SADDLE_CONNECTION,
    SADDLE_NODE_ON_ORBIT,
    branch_end,
)
from wucht.numerics.periodic.connection import Connection
from wucht.numerics.periodic.connection_starts import connection_from_cycle, fold_at
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.saddle_connections import Connections
from wucht.numerics.recurrence import is_at_rest

NO_MOTION = "none"
_JUST_BEYOND = (0.01, 0.002)  # of the range: distance beyond a fold at which a run searches the orbit
_ASIDE = 1e-3  # of a state's size: how far beside a steady state that is unstable a run begins
_LONGEST = 8.0  # times the least period of the branch
_GROWN, _LATER = (
    2.5,
    1.25,
)  # times the least period, when an end is first searched; factor of growth until the next search
_NEAR = 0.02  # of the range: how far ahead the end is, at most
_BESIDE = 0.2  # of the orbit's size: how far the fold lies from the orbit's slowest place, at most
_STEPS = Steps(
    most=0.05, turn=0.3, corrections=4, tolerance=1e-7, predicts_correction=True
)  # so short that the curves look smooth
_SLOW, _PLACES = 0.3, 4  # of the largest speed; number of places that are examined
_STILL, _MOST_STILL = 1e-10, 8  # the parameter stays, in terms of its range, while the period grows: number of steps
_LONG = 4.0  # times the least period: shorter orbits do not distinguish a saddle-node from a saddle that emerges from it
_FIRST_SPAN = 50.0  # of a run: times of the fastest decay
_PERIODS, _SAMPLES, _TOLERANCE = 20.0, 4000, 1e-10  # of a run beyond that: duration, and number of samples
_DECAY_TIMES = 5.0  # by exp(-5) a deviation decays beyond both ends of the orbit from which a connection begins
_PAST = 1e-4  # of the range: distance beyond a fold at which the orbit is tested for survival
_LAW, _LOOSE = 0.02, 0.2  # relative: largest change of T sqrt|p - p*|; the same where the longest followed period is reached


@dataclass(frozen=True, eq=False)
class OrbitEnd:
    """End of a branch of orbits.

    kind: ``"none"`` where there is no motion. value: of the parameter. sentence: how it ends, or why there is none. last: the
    last orbit. equilibrium (n,): that it approaches, empty where there is none.
    """

    kind: str
    value: float
    sentence: str
    last: SeedOrbit | None = None
    equilibrium: np.ndarray = field(default_factory=lambda: np.empty(0))


@dataclass(frozen=True)
class OrbitEnding:
    """End of the motion at a place (x, y) of the plane. begins: its first value of the parameter that changes."""

    x: float
    y: float
    begins: float
    end: OrbitEnd

    @property
    def kind(self) -> str:
        """Kind of the end."""
        return self.end.kind


def ending_at(motion: ModulatedMotion, place: tuple[float, float], report: Heartbeat) -> OrbitEnding:
    """Return the motion after a stable steady state is lost as the parameter changes, and how that motion ends.

    motion: at the place, with the parameter that changes. Beyond each fold of stable states a run begins where they
    have vanished; the orbit on which it settles is followed on in the same sense.
    """
    (low, high), path = motion.subject.bounds, motion.subject.path
    losses = [(point, way) for point, way in lost_states(motion.steady_branches()) if low < point.parameter < high]
    if not losses:
        return OrbitEnding(*place, math.nan, OrbitEnd(NO_MOTION, math.nan, f"no stable state is lost in the range of {path}"))
    sentences = list[str]()
    for point, way in losses:
        seed = orbit_beyond_loss(motion, point, way, sentences, report)
        if seed is None:
            continue
        try:
            return OrbitEnding(*place, point.parameter, branch_to_end(motion, seed, way, report).end)
        except RunError as error:
            sentences.append(str(error))
    return OrbitEnding(*place, losses[0][0].parameter, OrbitEnd(NO_MOTION, math.nan, "; ".join(dict.fromkeys(sentences))))


def orbit_beyond_loss(
    motion: ModulatedMotion, point: Equilibrium, way: int, sentences: list[str], report: Heartbeat
) -> SeedOrbit | None:
    """Return the orbit that a run reaches just beyond a point at which a stable state is lost, on the way on which it is lost;
    else add a sentence on what the run reaches."""
    (low, high), span = motion.subject.bounds, _FIRST_SPAN / float(np.abs(point.eigenvalues).max())
    # Beside a Hopf point the steady state is still there.
    start = point.x if point.kind == FOLD else point.x + _ASIDE * motion.equilibria.equations.scale[:-1]
    for share in _JUST_BEYOND:
        value = point.parameter + way * share * (high - low)
        if not low < value < high:
            continue
        run = orbit_near(motion.subject, value, start, report, lambda _: span)
        if run.orbit is not None:
            return replace(run.orbit, longest=_LONGEST * run.orbit.period)
        sentences.append(run.sentence)
    return None


@dataclass(frozen=True, eq=False)
class BranchToEnd:
    """Branch of orbits that was followed one way to its end.

    cycles: the problem that they solve. orbits: the regular ones, from the first on; each has the direction of the way.
    """

    cycles: Cycles
    orbits: tuple[Cycle, ...]
    end: OrbitEnd


def branch_to_end(motion: ModulatedMotion, seed: SeedOrbit, way: int, report: Heartbeat) -> BranchToEnd:
    """Follow the branch through an orbit to its end, for growing values of the parameter (way 1) or the other way."""
    cycles, start = cycles_through(motion.subject, seed, draws=False)
    orbits = [start if way > 0 else cycles.backwards(start)]
    end = _end_of_branch(motion, cycles, orbits, way, report)
    return BranchToEnd(cycles, tuple(orbits), end)


def _end_of_branch(
    motion: ModulatedMotion, cycles: Cycles, orbits: list[Cycle], way: int, report: Heartbeat
) -> OrbitEnd:  # fmt: skip
    """Follow the branch from the first of the orbits, to which the next ones are added, and return its end."""
    path, size = motion.subject.path, motion.subject.width

    def orbit_end(kind: str, value: float, sentence: str, last: Cycle, at: np.ndarray) -> OrbitEnd:
        return OrbitEnd(kind, value, sentence, SeedOrbit.from_cycle(cycles, last, "the end of a branch", both_ways=True), at)

    def saddle_node_end(value: float, last: Cycle, at: np.ndarray) -> OrbitEnd:
        sentence = f"at {path} = {value:.7g} steady states appear on the orbit, a saddle-node"
        return orbit_end(SADDLE_NODE_ON_ORBIT, value, sentence, last, at)

    walk = cycles.walk(orbits[0])
    least, next_growth, law, still = orbits[0].period, _GROWN, math.nan, 0
    fold: tuple[np.ndarray, float] | None = None
    nearly = False
    for cycle in walk:
        report()
        if cycle.kind:
            continue
        orbits.append(cycle)
        least = min(least, cycle.period)
        only_longer = abs(cycle.parameter - orbits[-2].parameter) < _STILL * size and cycle.period > orbits[-2].period
        still = still + 1 if only_longer else 0
        stays = still > _MOST_STILL
        if cycle.period < next_growth * least and not stays:
            continue
        next_growth = cycle.period / least * _LATER
        places = _slow_places(cycles, cycle)
        for place in places:
            saddle_connection = _connection(motion, cycles, cycle, place, stays)
            if saddle_connection is not None:
                value, saddle = saddle_connection
                description = f"at {path} = {value:.7g} the orbit runs into a saddle"
                return orbit_end(SADDLE_CONNECTION, value, description, cycle, saddle)
        fold_ahead = next((f for f in (_fold_ahead(motion, cycle, p, way) for p in places) if f is not None), None)
        fold, before, law = fold_ahead or fold, law, math.nan
        if fold_ahead is not None:
            state, value = fold_ahead
            law = cycle.period * math.sqrt(abs(value - cycle.parameter))
            if abs(law / before - 1) < _LAW and cycle.period > _LONG * least:
                report()
                if not _survives(motion, cycle, state, value + way * _PAST * size):
                    return saddle_node_end(value, cycle, state)
                law = math.nan
                continue
        if stays:
            break
        nearly = abs(law / before - 1) < _LOOSE
    if fold is not None and nearly:
        state, value = fold
        if not _survives(motion, orbits[-1], state, value + way * _PAST * size):
            return saddle_node_end(value, orbits[-1], state)
    values, periods = np.array([[c.parameter, c.period] for c in orbits]).T
    end = branch_end(cycles, values, periods, orbits[-3:], walk.end)
    return orbit_end(end.kind, end.parameter, end.sentence, orbits[-1], end.equilibrium)


def _slow_places(cycles: Cycles, cycle: Cycle) -> list[np.ndarray]:
    """Return the states (n,) where an orbit is slow, the slowest first."""
    states, n = cycle.states[:, :-1], cycle.problem.n
    points = np.concatenate([states, np.tile([[1.0], [cycle.parameter]], states.shape[1])])
    speed = np.linalg.norm(cycles.equations.values(points)[0] / cycles.equations.scale[:n, None], axis=0)
    least = (speed < _SLOW * speed.max()) & (speed <= np.roll(speed, 1)) & (speed < np.roll(speed, -1))
    return [states[:, i] for i in sorted(np.flatnonzero(least).tolist(), key=lambda i: float(speed[i]))[:_PLACES]]


def _survives(motion: ModulatedMotion, cycle: Cycle, place: np.ndarray, value: float) -> bool:
    """True if the motion persists just beyond a fold that the orbit seemed to approach, beside the states that appear there."""
    s = motion.subject
    if not s.bounds[0] < value < s.bounds[1]:
        return False
    away = np.linalg.norm((cycle.states - place[:, None]) / np.ptp(cycle.states, axis=1)[:, None], axis=0)
    times = np.linspace(0.0, _PERIODS * cycle.period, _SAMPLES)
    run = integrate(compile_system(s.system, _TOLERANCE), cycle.states[:, int(away.argmax())], s.parameters_at(value), times)
    states = run.reraise_interrupt().states
    return not is_at_rest(states[:, -_SAMPLES // 4 :])


def connection_time(period: float, eigenvalues: np.ndarray) -> float:
    """Return the time in which a connection comes near to its saddle at both ends."""
    first, second = np.sort(eigenvalues.real)[::-1][:2].tolist()
    return float(period + _DECAY_TIMES * (1 / first - 1 / second))


def connections_of(
    motion: ModulatedMotion, paths: tuple[str, ...], bounds: tuple[tuple[float, float], ...], time: float, winding: np.ndarray,
    folds: tuple[bool, ...] = (False,),
) -> Connections:  # fmt: skip
    """Return connections over some parameters, with the scales of the map."""
    s = motion.subject
    widths = {p: b[1] - b[0] for p, b in zip(paths, bounds, strict=True)}
    # The time is fixed: where the curve ends at a saddle-node, so does its orbit, from which the next curve begins.
    return Connections.of(
        s.system, paths, s.fixed_values(*paths), bounds, time,
        folds=folds, winding=s.turns(winding), scale=motion.sizes(widths), steps=_STEPS, longest=time,
    )  # fmt: skip


def connections_at(
    motion: ModulatedMotion, path: str, bounds: Range, end: OrbitEnd, value: float
) -> tuple[Connections, Connection]:
    """Return connections over a second parameter too, and the one at the end of a branch. Raises ``RunError``.

    path, bounds: of the second parameter. value: of it there.
    """
    if end.last is None or not len(end.equilibrium):
        raise RunError("the orbit's end is not known well enough to start from it")
    s, (_, cycle) = motion.subject, cycles_through(motion.subject, end.last)
    rates = motion.equilibria.evaluate(motion.equilibria.start(end.equilibrium, end.value)).eigenvalues
    time = connection_time(cycle.period, rates)
    connections = connections_of(motion, (s.path, path), (s.bounds, bounds), time, end.last.winding)
    return connections, connection_from_cycle(connections, cycle, end.equilibrium, np.array([cycle.parameter, value]))


def _connection(
    motion: ModulatedMotion, cycles: Cycles, cycle: Cycle, slow: np.ndarray, stays: bool
) -> tuple[float, np.ndarray] | None:
    """Return the value at which an orbit becomes a connection of the saddle that it passes, and that saddle."""
    path, (low, high) = motion.subject.path, motion.subject.bounds
    try:
        saddle = motion.equilibria.evaluate(motion.equilibria.start(slow, cycle.parameter))
    except RunError:
        return None
    try:
        beside = np.linalg.norm((saddle.x - slow) / np.maximum(np.ptp(cycle.states, axis=1), 1e-12))
        if saddle.unstable != 1 or beside > _BESIDE:
            return None
        around = (2 * low - high, 2 * high - low)
        connections = connections_of(
            motion, (path,), (around,), connection_time(cycle.period, saddle.eigenvalues), cycles.winding
        )
        connection = connection_from_cycle(connections, cycle, saddle.x, np.array([cycle.parameter]))
    except RunError:
        # A parameter that stays as the period grows is known, even if the connection cannot be computed.
        return (cycle.parameter, saddle.x) if stays else None
    value, x = float(connection.parameter_values[0]), connection.equilibria[0]
    near = abs(value - cycle.parameter) < _NEAR * (high - low)
    return (value, x) if near and connection.eigenvalues[0, 0].real > 0 else None


def _fold_ahead(motion: ModulatedMotion, cycle: Cycle, slow: np.ndarray, way: int) -> tuple[np.ndarray, float] | None:
    """Return the fold of steady states ahead of an orbit, where that is slowest."""
    try:
        x, (value,) = fold_at(motion.equilibria.equations, slow, np.array([cycle.parameter]))
    except RunError:
        return None
    beside = np.linalg.norm((x - slow) / np.maximum(np.ptp(cycle.states, axis=1), 1e-12))
    ahead = 0 < way * (value - cycle.parameter) < _NEAR * motion.subject.width
    return (x, float(value)) if ahead and beside < _BESIDE else None
