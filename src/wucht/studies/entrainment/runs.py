"""The full equations: runs from the start at a value of the parameter, with the verdict whether the rotors are taken along."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import Any

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, operating_speed, sense_of
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.results.outcomes import Outcome
from wucht.studies.entrainment.swept_parameter import SweptParameter
from wucht.studies.locking import locked, motion_of
from wucht.studies.release_events import release_event
from wucht.studies.run_up.prepare import placed_at_start

_SAMPLES = 24  # a period
_PERIODS = 200  # of a run, if nothing says how long
_TIMES = 25.0  # decay times of the slowest disturbance
_MOST_PERIODS = 20_000
_DOUBLINGS = 5
_STILL = 1e-4  # rad: a phase that moves more than this in the last quarter has not come to rest
_NEAR = 0.01  # of the mean speed: a rotor so near the frequency may be beating very slowly
_SLIPPED = 4 * math.pi  # rad: after two turns of the phase in the last quarter it is clear that it slips
_CHANGING = 0.02  # of the mean speed: between the halves of the window, a run-up that goes on
_TAKEN_ALONG = (Outcome.ENTRAINED, Outcome.SYNCHRONISED)


@dataclass(frozen=True)
class RunFromStart:
    """A run from the start. until: how long it was asked to be. entrained: whether the rotors are taken along.

    mean_speed: of the main rotor over the window, with its sign. end_time, end_state (n,): where it ended. speeds, phases: as
    in ``Locked``, empty where the main rotor does not turn; drift: by how much the phase moved in the second half of the
    window, rad. free_speed: of the main rotor without vibration. Speeds are NaN where there are none.
    """

    value: float
    until: float
    entrained: bool
    mean_speed: float
    window: tuple[float, float]
    end_time: float
    end_state: np.ndarray
    speeds: Mapping[str, float] = field(default_factory=dict)
    phases: Mapping[str, float] = field(default_factory=dict)
    drift: float = math.nan
    free_speed: float = math.nan
    failure: str | None = None


@dataclass(frozen=True)
class RunsFromStart:
    """Runs of a machine from its start along a parameter.

    until: how long they go on at least, None for as long as the rate of the slowest disturbance (1/time) asks. senses: in which
    rotors must turn to count as taken along; None: in any.
    """

    machine: Machine
    swept: SweptParameter
    start: Mapping[str, Any]
    until: float | None = None
    rate: float | None = None
    senses: Mapping[str, float] | None = None

    @cached_property
    def flow(self) -> CompiledSystem:
        """The equations without the balance of energy, which nothing here asks for."""
        events = tuple(release_event(self.machine, b) for b in self.machine.bodies if b.release is not None)
        return compile_system(replace(self.machine.system, quadratures=(), outputs=()), events=events)

    @cached_property
    def period(self) -> float:
        """Of the vibration, or of the fastest rotor."""
        return 2 * math.pi / (self.machine.shaking_frequency or operating_speed(self.machine))

    @property
    def duration(self) -> float:
        """How long a run goes on at least."""
        if self.until is not None:
            return self.until
        wanted = _PERIODS * self.period + (_TIMES / self.rate if self.rate else 0.0)
        return min(wanted, _MOST_PERIODS * self.period) + self.machine.breakpoints[-1]

    def __call__(self, value: float, progress: Callable[[float], None]) -> RunFromStart:
        """The run with a value of the parameter, prolonged while it cannot be decided. progress: called with the time reached.

        Raises ``KeyboardInterrupt`` where the user has stopped it.
        """
        machine, start = placed_at_start(self.swept.at(self.machine, value), self.start)
        integrator, step = self.flow.engine.integrator(), self.period / _SAMPLES

        def leg(begin: float, end: float, state: np.ndarray, parameters: Any) -> Trajectory:
            grid = np.linspace(begin, end, max(2, math.ceil((end - begin) / step)) + 1)
            part = integrate(self.flow, state, parameters, grid, progress, integrator=integrator)
            if part.interrupted:
                raise KeyboardInterrupt
            return part

        trajectory = leg(0.0, self.duration, start, machine.system.values(machine.values))
        for _ in range(_DOUBLINGS):
            if trajectory.failure is not None or self._decided(machine, trajectory):
                break
            end = trajectory.end_time
            trajectory = trajectory.joined(leg(end, 2 * end, trajectory.end_state, trajectory.parameters))
        return self._judged(machine, value, trajectory)

    def _judged(self, machine: Machine, value: float, trajectory: Trajectory) -> RunFromStart:
        time, nothing, end = trajectory.time, (math.nan, math.nan), machine.breakpoints[-1]
        free = free_speed(machine.at(end), machine.rotor, end)
        run = RunFromStart(value, self.duration, False, math.nan, nothing, trajectory.end_time, trajectory.end_state)
        run = replace(run, free_speed=math.nan if free is None else free, failure=trajectory.failure)
        if run.failure is not None:
            return run
        means = locked(machine, trajectory)
        if means is None:
            window = float(time[0] + time[-1]) / 2, float(time[-1])
            return replace(run, window=window, mean_speed=_mean(machine, trajectory, machine.rotor, window))
        entrained = means.evidence.outcome() in _TAKEN_ALONG
        if entrained and self.senses is not None:
            entrained = all(self.senses[r.name] * means.speeds[r.name] > 0 for r in machine.rotors)
        mean = means.mean_speed if entrained else _mean(machine, trajectory, machine.rotor, means.window)
        return replace(
            run, entrained=entrained, mean_speed=mean, window=means.window, speeds=means.speeds, phases=means.phases,
            drift=means.evidence.drift,
        )  # fmt: skip

    def _decided(self, machine: Machine, trajectory: Trajectory) -> bool:
        means = locked(machine, trajectory)
        if means is None or trajectory.end_time >= _MOST_PERIODS * self.period:
            return True
        evidence, (begin, end) = means.evidence, means.window
        if evidence.outcome() in _TAKEN_ALONG:
            return evidence.drift < _STILL
        reference = evidence.frequency if evidence.frequency is not None else evidence.speeds[0]
        others = evidence.speeds[:1] if evidence.frequency is not None else evidence.speeds[1:]
        if all(abs(w - reference) < _NEAR * reference for w in others) and evidence.drift < _SLIPPED:
            return False
        halves = (begin, (begin + end) / 2), ((begin + end) / 2, end)
        changes = [[_mean(machine, trajectory, r, half) for half in halves] for r in machine.rotors]
        return max(abs(first - second) for first, second in changes) < _CHANGING * max(*evidence.speeds, reference)


def _mean(machine: Machine, trajectory: Trajectory, body: RotatingBody, window: tuple[float, float]) -> float:
    """The mean speed over a window, weighted so that what beats at its ends does not count.

    J. Laskar, Physica D 67 (1993) 257-281; S. Das, Y. Saiki, E. Sander, J. A. Yorke, Nonlinearity 30 (2017) 4111-4140.
    """
    inside = (trajectory.time >= window[0]) & (trajectory.time <= window[1])
    share = (trajectory.time[inside] - window[0]) / max(window[1] - window[0], 1e-300)
    with np.errstate(all="ignore"):
        weight = np.nan_to_num(np.exp(-1 / (share * (1 - share))))
    _, speed = motion_of(machine, trajectory, body)
    return float(np.sum(weight * speed[inside]) / np.sum(weight)) if weight.any() else float(speed[-1])


def senses_of(machine: Machine, initial: np.ndarray, own: RunFromStart) -> dict[str, float]:
    """In which sense the bodies turn: as in the run that is taken along, as they start (n,), or as they are driven."""
    senses: dict[str, float] = {}
    for rotor in machine.rotors:
        speed = own.speeds[rotor.name] if own.entrained else 0.0
        speed = speed or float(initial[machine.row(rotor.coordinate.velocity)])
        senses[rotor.name] = math.copysign(1.0, speed) if speed else sense_of(machine, rotor)
    return {b.name: senses[machine.rotor_of(b).name] for b in machine.bodies}
