"""The full equations: runs from the start with the verdict whether the rotor is taken along, and the edges of their band."""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from wucht.machines.machine import Machine, Turning
from wucht.machines.vibration import operating_speed
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.results.outcomes import Outcome
from wucht.studies.entrainment.along import Along
from wucht.studies.locking import frequency_of, locked, motion_of
from wucht.studies.release import release_event
from wucht.studies.run_up.plan import SAMPLES_PER_TURN
from wucht.studies.run_up.study import RunUp, prepared

_PERIODS = 200  # of a run, if nothing says how long
_TIMES = 25.0  # decay times of the slowest disturbance
_MOST_PERIODS = 20_000
_DOUBLINGS = 5
_STILL = 1e-4  # rad: a phase that moves more than this in the last quarter has not come to rest
_NEAR = 0.01  # of the mean speed: a rotor so near the frequency may be beating very slowly
_PROBES = 8  # runs to each side of an edge, over the distance of two values that were tried
_SLIPPED = 4 * math.pi  # rad: after two turns of the phase in the last quarter it is clear that it slips
_CHANGING = 0.02  # of the mean speed: between the halves of the window, a run-up that goes on


@dataclass(frozen=True)
class RunAt:
    """A run from the start. until: how long it was asked to be. taken: whether the rotor is taken along.

    mean_speed: of the main rotor over the window, with its sign. end_time, end_state (n,): where it ended. speeds, phases: as
    in ``Locked``, empty where the main rotor does not turn; drift: by how much the phase moved in the second half of the
    window, rad.
    """

    value: float
    until: float
    taken: bool
    mean_speed: float
    window: tuple[float, float]
    end_time: float
    end_state: np.ndarray
    speeds: Mapping[str, float] = field(default_factory=dict)
    phases: Mapping[str, float] = field(default_factory=dict)
    drift: float = math.nan
    failure: str | None = None


class Runs:
    """Runs of a machine from its start along a parameter.

    watch: called now and then during a run. known: runs that need not be made again. rate: of the slowest disturbance
    (1/time): they go on as long as it asks. senses: in which rotors must turn to count as taken along; None: in any.
    """

    def __init__(
        self, machine: Machine, along: Along, question: RunUp, watch: Callable[[], None], known: Sequence[RunAt] = ()
    ) -> None:
        self.machine, self.along, self.question, self.watch = machine, along, question, watch
        self.known = {(r.value, r.until): r for r in known}
        self.rotors = [r for r in machine.rotors if r.coordinate.prescribed is None]
        self.rate: float | None = None
        self.senses: Mapping[str, float] | None = None

    @cached_property
    def flow(self) -> CompiledSystem:
        """The equations without the balance of energy, which nothing here asks for."""
        events = tuple(release_event(self.machine, b) for b in self.machine.bodies if b.release is not None)
        bare = replace(self.machine.system, quadratures=(), outputs=())
        return compile_system(bare, self.question.tolerance, events, self.question.engine)

    @cached_property
    def period(self) -> float:
        """Of the vibration, or of the fastest rotor."""
        return 2 * math.pi / (frequency_of(self.machine) or operating_speed(self.machine))

    @property
    def until(self) -> float:
        """How long a run goes on at least."""
        if self.question.until is not None:
            return self.question.until
        wanted = _PERIODS * self.period + (_TIMES / self.rate if self.rate else 0.0)
        return min(wanted, _MOST_PERIODS * self.period) + self.machine.corners[-1]

    def __call__(self, value: float) -> RunAt:
        """The run with a value of the parameter, prolonged while it cannot be decided."""
        until = self.until
        return self.known.get((value, until)) or self._made(value, until)

    def _made(self, value: float, until: float) -> RunAt:
        machine, start = prepared(self.along.at(self.machine, value), self.question)
        trajectory = self._extended(machine, start, None, until)
        for _ in range(_DOUBLINGS):
            if trajectory.failure is not None or self._decided(machine, trajectory):
                break
            trajectory = self._extended(machine, start, trajectory, 2 * trajectory.end_time)
        return self._judged(machine, value, until, trajectory)

    def _extended(self, machine: Machine, start: np.ndarray, so_far: Trajectory | None, end: float) -> Trajectory:
        begin = 0.0 if so_far is None else so_far.end_time
        step = self.period / SAMPLES_PER_TURN
        grid = np.linspace(begin, end, max(2, math.ceil((end - begin) / step)) + 1)
        state = start if so_far is None else so_far.end_state
        pars = machine.system.values(machine.values) if so_far is None else so_far.parameters
        found = integrate(self.flow, state, pars, grid, lambda _: self.watch())
        if found.interrupted:
            raise KeyboardInterrupt
        return found if so_far is None else so_far.joined(found)

    def _judged(self, machine: Machine, value: float, until: float, trajectory: Trajectory) -> RunAt:
        if trajectory.failure is not None:
            end, nothing = (trajectory.end_time, trajectory.end_state), (math.nan, math.nan)
            return RunAt(value, until, False, math.nan, nothing, *end, failure=trajectory.failure)
        found = locked(machine, trajectory)
        if found is None:
            half, end_time = float(trajectory.time[0] + trajectory.time[-1]) / 2, float(trajectory.time[-1])
            mean = _mean(machine, trajectory, machine.rotor, (half, end_time))
            return RunAt(value, until, False, mean, (half, end_time), trajectory.end_time, trajectory.end_state)
        taken = found.evidence.outcome() in (Outcome.ENTRAINED, Outcome.SYNCHRONISED)
        if taken and self.senses is not None:
            taken = all(self.senses[r.name] * found.speeds[r.name] > 0 for r in self.rotors)
        return RunAt(
            value,
            until,
            taken,
            found.mean_speed if taken else _mean(machine, trajectory, machine.rotor, found.window),
            found.window,
            trajectory.end_time,
            trajectory.end_state,
            found.speeds,
            found.phases,
            found.evidence.drift,
        )

    def _decided(self, machine: Machine, trajectory: Trajectory) -> bool:
        found = locked(machine, trajectory)
        if found is None or trajectory.end_time >= _MOST_PERIODS * self.period:
            return True
        evidence = found.evidence
        if evidence.outcome() in (Outcome.ENTRAINED, Outcome.SYNCHRONISED):
            return evidence.drift < _STILL
        reference = evidence.frequency if evidence.frequency is not None else evidence.speeds[0]
        others = evidence.speeds[:1] if evidence.frequency is not None else evidence.speeds[1:]
        if all(abs(w - reference) < _NEAR * reference for w in others) and evidence.drift < _SLIPPED:
            return False
        begin, end = found.window
        middle = (begin + end) / 2
        changes = [
            abs(_mean(self.machine, trajectory, r, (begin, middle)) - _mean(self.machine, trajectory, r, (middle, end)))
            for r in self.rotors
        ]
        return max(changes) < _CHANGING * max(*evidence.speeds, reference)


def _mean(machine: Machine, trajectory: Trajectory, body: Turning, window: tuple[float, float]) -> float:
    """The mean speed over a window, weighted so that what beats at its ends does not count.

    J. Laskar, Physica D 67 (1993) 257-281; S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111-4140.
    """
    inside = (trajectory.time >= window[0]) & (trajectory.time <= window[1])
    share = (trajectory.time[inside] - window[0]) / max(window[1] - window[0], 1e-300)
    with np.errstate(all="ignore"):
        weight = np.nan_to_num(np.exp(-1 / (share * (1 - share))))
    _, speed = motion_of(machine, trajectory, body)
    return float(np.sum(weight * speed[inside]) / np.sum(weight)) if weight.any() else float(speed[-1])


@dataclass(frozen=True)
class Band:
    """The values between which runs from the start end taken along; an edge is None where it lies beyond what was looked at.

    islands: other such bands that the scan met, (low, high) of values that were tried.
    """

    low: float | None
    high: float | None
    islands: tuple[tuple[float, float], ...] = ()


def band_from_start(
    runs: Callable[[float], RunAt], tried: list[RunAt], own: float, resolution: float, note: Callable[[RunAt], None]
) -> Band | None:
    """The band around the machine's own value, else the widest one; None where none of the runs is taken along.

    tried: runs in increasing order of their value. Both edges by bisection to ``resolution``; around them it is looked once
    more for gaps and islands, which the boundary of a basin often has. note: told of every run.
    """
    found, apart = list(tried), (tried[-1].value - tried[0].value) / max(len(tried) - 1, 1)

    def run(value: float) -> bool:
        made = runs(value)
        note(made)
        insort(found, made, key=lambda r: r.value)
        return made.taken

    if _chosen(found, own) is None:
        return None
    for side in (-1, 1):
        edge = _edge(found, own, side, resolution, run)
        for share in (np.arange(_PROBES) + 0.5) / _PROBES if edge is not None else ():
            for value in (edge - share * apart, edge + share * apart) if edge is not None else ():
                if tried[0].value < value < tried[-1].value:
                    run(float(value))
    low, high = (_edge(found, own, side, resolution, run) for side in (-1, 1))
    group = _chosen(found, own)
    islands = [g for g in _groups(found) if g != group]
    return Band(low, high, tuple((found[g[0]].value, found[g[-1]].value) for g in islands))


def _groups(tried: list[RunAt]) -> list[list[int]]:
    """Indices of neighbours that are taken along."""
    groups: list[list[int]] = []
    for k, run in enumerate(tried):
        if run.taken and groups and groups[-1][-1] == k - 1:
            groups[-1].append(k)
        elif run.taken:
            groups.append([k])
    return groups


def _chosen(tried: list[RunAt], own: float) -> list[int] | None:
    groups, values = _groups(tried), [r.value for r in tried]
    mine = next((g for g in groups if values[g[0]] <= own <= values[g[-1]]), None)
    return mine or max(groups, key=lambda g: values[g[-1]] - values[g[0]], default=None)


def _edge(tried: list[RunAt], own: float, side: int, resolution: float, run: Callable[[float], bool]) -> float | None:
    """Where the band ends below (-1) or above (+1); None where it was taken along at the last value that was tried."""
    group = _chosen(tried, own)
    assert group is not None
    inside = group[0] if side < 0 else group[-1]
    if not 0 <= inside + side < len(tried):
        return None
    good, bad = tried[inside].value, tried[inside + side].value
    while abs(good - bad) > resolution and (good + bad) / 2 not in (good, bad):
        middle = (good + bad) / 2
        good, bad = (middle, bad) if run(middle) else (good, middle)
    return (good + bad) / 2
