"""Runs of the full equations from the start along a parameter, and the band in which they end with the rotors entrained."""

from __future__ import annotations

import math
from bisect import insort
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import chain
from typing import Any

import numpy as np

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase
from wucht.dynamics.run_ups.observed_integration import ObservedIntegration
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.dynamics.verdicts.locking import LockingAssessment, assess_locking
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver, Observation
from wucht.dynamics.work import Work
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, operating_speed, sense_of
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.zeros_and_peaks import stretches

_PERIODS = 200  # of a run, if nothing else determines its duration
_TIMES = 25.0  # decay times of the slowest disturbance
_MOST_PERIODS = 20_000
_DOUBLINGS = 5
_AT_ONCE = 1000  # samples that are stored
_STEADY = 1e-4  # rad: a phase that moves more than this in the last quarter is not yet steady
_CHANGING = 0.02  # of the mean speed: between the halves of the window, a run-up that continues
_PROBES = 8  # runs to each side of an edge, over the distance of two values of the scan
_BISECTIONS = 70  # expected, for the progress


@dataclass(frozen=True)
class RunFromStart:
    """Run from the start. until: the requested duration. end_time, end_state (n,): where it ended.

    free_speed: of the main rotor without vibration. mean_speed: of the main rotor over the window, with its sign. speeds,
    phases: as in ``Locked``, empty where the main rotor does not turn; creep: change of the phase in the second half
    of the window, rad. Speeds are NaN where there are none.
    """

    value: float
    until: float
    end_time: float
    end_state: np.ndarray
    free_speed: float | None = None
    failure: str | None = None
    is_entrained: bool = False
    mean_speed: float = math.nan
    window: tuple[float, float] = (math.nan, math.nan)
    speeds: Mapping[str, float] = field(default_factory=dict)
    phases: Mapping[str, float] = field(default_factory=dict)
    creep: float = math.nan


class RunsFromStart:
    """Runs of a machine from its start along a parameter.

    senses: in which rotors must turn to count as entrained; None: in any. rate: of the slowest disturbance (1/time). period:
    of the vibration, or of the fastest rotor. duration: least duration of a run, as requested, or as that disturbance needs.
    """

    def __init__(self, case: EntrainmentCase, senses: Mapping[str, float] | None = None, rate: float | None = None) -> None:
        machine = case.machine
        self.case, self.senses = case, senses
        # Without the energy balance, which is not used here.
        self.flow = compile_system(replace(machine.system, quadratures=(), outputs=()), events=release_events(machine))
        self.period = 2 * math.pi / (machine.shaking_frequency or operating_speed(machine))
        needed_time = _PERIODS * self.period + (_TIMES / rate if rate else 0.0)
        self.duration = case.until or min(needed_time, _MOST_PERIODS * self.period) + machine.breakpoints[-1]

    def __call__(self, value: float, progress: Callable[[float], None]) -> RunFromStart:
        """Run with a value of the parameter, prolonged while it cannot be decided. progress: called with the time reached.

        Raises ``KeyboardInterrupt`` where the user has stopped it.
        """
        machine, state = prepare_start(self.case.parameter.machine_at(self.case.machine, value), self.case.start)
        parameters: Any = machine.system.values(machine.values)
        observer = MotionObserver(machine, self.period, Noise.of(self.flow.tolerance))
        integration = ObservedIntegration(observer, self.flow, lambda motion: motion, 2 * math.pi / self.period, 1.0)
        leg, end = integration.begin(state, parameters), self.duration
        for _ in range(_DOUBLINGS + 1):
            for grid in self._grids(leg.trajectory.end_time, end):
                leg = integration.leg(leg, grid, progress)
            observation = integration.observation(leg)
            means = assess_locking(machine, observation) if leg.trajectory.failure is None else None
            if means is None or self._is_decided(leg.trajectory.end_time, means):
                break
            end = 2 * end
        return self._judge(machine, value, leg.trajectory, observation, means)

    def run(self, value: float, work: Work, share: float = 0.0) -> RunFromStart:
        """Make a run as a unit of work. share: of this part of the work, for the progress."""
        label = f"{self.case.parameter.name} = {value:.6g}"
        return work.unit(f"at {value!r} for {self.duration!r}", lambda: self(value, lambda _: work.report(share, label)))

    def search(
        self, nominal_run: RunFromStart, limits: tuple[float, float], resolution: float, work: Work
    ) -> Iterator[tuple[RunFromStart, ...]]:
        """Make runs evenly within limits and at the nominal value, then those that the search for the edges needs.

        Yields the runs so far, in increasing order of their value.
        """
        done, points = list[RunFromStart](), self.case.points
        scan = dict.fromkeys([*np.linspace(*limits, points).tolist(), nominal_run.value])
        for k, value in enumerate(chain(scan, values_to_run(done, nominal_run.value, resolution))):
            new_run = nominal_run if value == nominal_run.value else self.run(value, work, k / (points + _BISECTIONS))
            insort(done, new_run, key=lambda r: r.value)
            yield tuple(done)

    def _grids(self, begin: float, end: float) -> Iterator[np.ndarray]:
        """Yield the sample times of a run in portions, as their number is unlimited."""
        count = math.ceil((end - begin) / (_PERIODS * self.period))
        for first in range(0, count, _AT_ONCE):
            last = min(first + _AT_ONCE, count)
            grid = begin + (end - begin) / count * np.arange(first, last + 1)
            grid[-1] = end if last == count else grid[-1]
            yield grid

    def _judge(
        self, machine: Machine, value: float, last: Trajectory, observation: Observation, means: LockingAssessment | None
    ) -> RunFromStart:
        end, final_point = machine.breakpoints[-1], (last.end_time, last.end_state)
        run = RunFromStart(value, self.duration, *final_point, free_speed(machine.at(end), machine.rotor, end), last.failure)
        if run.failure is not None:
            return run
        if means is None:
            half = observation.main.last(0.5)
            window = float(half.time[0]), float(half.time[-1])
            return replace(run, window=window, mean_speed=float(half.angle[-1] - half.angle[0]) / (window[1] - window[0]))
        # A phase that creeps past a bottleneck beyond the band is not locked, even if no longer run is made.
        steady = means.evidence.is_locked is True and means.creep < _STEADY
        is_entrained = steady and (
            self.senses is None or all(self.senses[r.name] * means.speeds[r.name] > 0 for r in machine.rotors)
        )
        mean = (means.speeds if is_entrained else means.smooth_speeds)[machine.rotor.name]
        run = replace(run, is_entrained=is_entrained, mean_speed=mean, window=means.window, creep=means.creep)
        return replace(run, speeds=means.speeds, phases=means.phases)

    def _is_decided(self, end: float, means: LockingAssessment) -> bool:
        if end >= _MOST_PERIODS * self.period:
            return True
        if means.evidence.is_locked is None:
            return False
        return (
            means.creep < _STEADY
            if means.evidence.is_locked
            else means.change < _CHANGING * max(map(abs, means.speeds.values()))
        )


def senses_of(machine: Machine, initial: np.ndarray, nominal_run: RunFromStart) -> dict[str, float]:
    """Return the sense in which each body turns: as in an entrained run, as in the initial state (n,), or as driven."""
    senses = {}
    for rotor in machine.rotors:
        speed = (nominal_run.is_entrained and nominal_run.speeds[rotor.name]) or float(
            initial[machine.row(rotor.coordinate.velocity)]
        )
        senses[rotor.name] = math.copysign(1.0, speed) if speed else sense_of(machine, rotor)
    return {b.name: senses[machine.rotor_of(b).name] for b in machine.bodies}


@dataclass(frozen=True)
class CaptureBand:
    """Band of values in which runs from the start end entrained.

    brackets: for the lower and the upper edge the last value within and its neighbour beyond, None for an edge beyond the
    examined range. islands: other such bands, (low, high) of values that were run.
    """

    brackets: tuple[tuple[float, float] | None, ...]
    islands: tuple[tuple[float, float], ...]

    @property
    def edges(self) -> tuple[float | None, ...]:
        """Lower and upper edge."""
        return tuple(None if b is None else sum(b) / 2 for b in self.brackets)


def capture_band(runs: Sequence[RunFromStart], nominal_value: float) -> CaptureBand | None:
    """Return the band around a value, else the widest one, of runs sorted by their values; None where none is entrained."""
    values = [r.value for r in runs]
    groups = [(begin, end - 1) for begin, end in stretches(np.array([r.is_entrained for r in runs], bool))]
    groups.sort(key=lambda g: (not values[g[0]] <= nominal_value <= values[g[1]], values[g[0]] - values[g[1]]))
    if not groups:
        return None
    neighbours = ((groups[0][0], groups[0][0] - 1), (groups[0][1], groups[0][1] + 1))
    brackets = tuple((values[i], values[k]) if 0 <= k < len(runs) else None for i, k in neighbours)
    return CaptureBand(brackets, tuple(sorted((values[i], values[k]) for i, k in groups[1:])))


def values_to_run(runs: Sequence[RunFromStart], nominal_value: float, resolution: float) -> Iterator[float]:
    """Yield the values to run after a scan of the range, until both edges of the band are known to the resolution.

    Each run is to be inserted before the next value is requested. Around the edges further values are run: the boundary of a
    basin often has gaps and islands.
    """

    def bisection(side: int) -> Iterator[float]:
        while (band := capture_band(runs, nominal_value)) is not None and (bracket := band.brackets[side]) is not None:
            middle = sum(bracket) / 2
            if abs(bracket[0] - bracket[1]) <= resolution or middle in bracket:
                return
            yield middle

    first, last = runs[0].value, runs[-1].value
    apart = (last - first) / max(len(runs) - 1, 1)
    for side in (0, 1):
        yield from bisection(side)
        band = capture_band(runs, nominal_value)
        edge = None if band is None else band.edges[side]
        for share in () if edge is None else (np.arange(_PROBES) + 0.5) / _PROBES:
            yield from (float(v) for v in (edge - share * apart, edge + share * apart) if first < v < last)
    for side in (0, 1):
        yield from bisection(side)
