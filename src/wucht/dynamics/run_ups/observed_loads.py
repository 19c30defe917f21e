"""The loads on a machine while it runs: a signal's turning points, duties of bearings, the largest forces and travels."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import Any, TypeVar

import numpy as np

from wucht.analysis.foundation_forces import FoundationForces, SupportDirection
from wucht.dynamics.run_ups.bearing_loads import Duties, DutyObserver
from wucht.dynamics.run_ups.machine_signals import MachineSignal
from wucht.dynamics.run_ups.observed_integration import Leg, ObservedIntegration
from wucht.dynamics.run_ups.run_up import RunUpCase, verdict_at_end
from wucht.dynamics.verdicts.observation import MotionObserver, Observation
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.fatigue.counting import TurningPoints
from wucht.machines.machine import Machine
from wucht.machines.parts.planar_carrier import PlanarCarrier
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

# The parabola through an extreme's neighbours is right to h^4/32 with the step h of a vibration's angle: 1e-5.
_PER_TURN = 48
_COURSE, _IN_A_PART = 200, 8  # intervals of time with their least and greatest value, and turning points in one
_SAMPLES_A_LEG = 100  # samples of a leg, for the course alone
KeyT = TypeVar("KeyT")


def mount_places(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return the places of the mounts on a carrier by name, in m; of one on springs at its centre of mass that is the place.

    Empty where the carrier does not translate freely.
    """
    if not {"x", "y"} & set(machine.free_labels):
        return {}
    carrier, values = machine.parts[0], machine.values
    if not isinstance(carrier, PlanarCarrier) or not carrier.mounts:
        return {"carrier": (0.0, 0.0)}
    keys = [f"carrier.mounts.{i}.at" for i in range(1, len(carrier.single_mounts) + 1)]
    return {f"mount {i}": (values[f"{key}.x"], values[f"{key}.y"]) for i, key in enumerate(keys, 1)}


@dataclass(frozen=True)
class LoadObservation:
    """An observation of a motion, for the verdict, and of its loads so far.

    points: turning points of the signal, since they were last taken. duties: of the machine's rated bearings. bearing_forces:
    the largest, by rotor. travels: by mount, the largest distance from its position at rest. foundation_forces: the largest
    beyond those at rest.
    """

    observation: Observation
    points: TurningPoints = field(default_factory=TurningPoints)
    duties: Duties = field(default_factory=dict)
    bearing_forces: Mapping[str, float] = field(default_factory=dict)
    travels: Mapping[str, float] = field(default_factory=dict)
    foundation_forces: Mapping[SupportDirection, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LoadObserver:
    """Observer of a machine and of those of its loads that are asked for.

    signal: whose turning points are kept. begin_time: of the motion, added to their time. duty_observer: of its bearings.
    with_largest: its largest bearing forces and travels are kept, too.
    """

    motion_observer: MotionObserver
    signal: MachineSignal | None
    begin_time: float = 0.0
    duty_observer: DutyObserver | None = None
    with_largest: bool = False

    @property
    def machine(self) -> Machine:
        """The observed machine."""
        return self.motion_observer.machine

    @property
    def span(self) -> float:
        """The sampled span of time; see ``MotionObserver``."""
        return self.motion_observer.span

    @cached_property
    def _forces(self) -> Evaluator:
        """The bearing force of each rotor, with the bodies about it, by ``rotor_x`` and ``rotor_y``."""
        system, names = self.machine.system, [r.name for r in self.machine.rotors]
        outputs = {
            f"{name}_{d}": f"bearing_force[{name}]_{d}" if len(names) > 1 else f"bearing_force_{d}"
            for name in names
            for d in "xy"
            if d in self.machine.labels
        }
        return Evaluator.of(system, [system.output(n).expression for n in outputs.values()], list(outputs))

    @cached_property
    def _foundation(self) -> FoundationForces | None:
        return FoundationForces.of(self.machine)

    @cached_property
    def _places(self) -> dict[str, tuple[float, float]]:
        return mount_places(self.machine)

    def begin(self) -> LoadObservation:
        """Return the empty observation."""
        duties = {} if self.duty_observer is None else self.duty_observer.begin()
        return LoadObservation(self.motion_observer.begin(), duties=duties)

    def update(self, previous: LoadObservation, motion: Trajectory) -> LoadObservation:
        """Return the observation after a further part of the machine's motion."""
        points, duties, forces, travels = previous.points, previous.duties, previous.bearing_forces, previous.travels
        foundation = previous.foundation_forces
        if self.signal is not None:
            points = points.update(self.begin_time + motion.time, self.signal(motion), interpolate=True)
        if self.duty_observer is not None:
            duties = self.duty_observer.update(duties, motion)
        if self.with_largest:
            forces, travels = (
                joint_maxima(forces, self._largest_forces(motion)),
                joint_maxima(travels, self._largest_travels(motion)),
            )
            foundation = joint_maxima(foundation, largest_forces(self._foundation, motion))
        observation = self.motion_observer.update(previous.observation, motion)
        return LoadObservation(observation, points, duties, forces, travels, foundation)

    def _largest_forces(self, motion: Trajectory) -> dict[str, float]:
        ways = [d for d in "xy" if d in self.machine.labels]
        rows = self._forces(motion.time, motion.states, motion.final_parameter_values) if ways else {}
        names = [r.name for r in self.machine.rotors] if ways else []
        return {name: largest_magnitude(motion.time, [rows[f"{name}_{d}"] for d in ways]) for name in names}

    def _largest_travels(self, motion: Trajectory) -> dict[str, float]:
        machine = self.machine
        offsets = {
            label: motion.states[machine.row(c.position)] - rest
            for label, c, rest in zip(machine.labels, machine.carrier, machine.rest.tolist(), strict=True)
        }
        zero = np.zeros(len(motion.time))
        x, y, chi = (offsets.get(label, zero) for label in "xyr")
        return {
            name: largest_magnitude(motion.time, [x - b * chi, y + a * chi]) for name, (a, b) in self._places.items()
        }  # fmt: skip


def largest_forces(forces: FoundationForces | None, motion: Trajectory) -> dict[SupportDirection, float]:
    """Return the largest force on the foundation of each support and direction in a motion, beyond that at rest."""
    return {} if forces is None else {key: largest_magnitude(motion.time, [f]) for key, f in forces(motion).items()}


def joint_maxima(first: Mapping[KeyT, float], second: Mapping[KeyT, float]) -> dict[KeyT, float]:
    """Return the larger values of two mappings, of the keys of the second one."""
    return {name: max(first.get(name, 0.0), value) for name, value in second.items()}


def largest_magnitude(time: np.ndarray, components: list[np.ndarray]) -> float:
    """Return the largest magnitude of a sampled vector, between samples by the parabola of its square. time: (N,)."""
    square = np.add.reduce([c * c for c in components])
    i = int(square.argmax())
    if not 0 < i < len(square) - 1:
        return float(np.sqrt(square[i]))
    before, after = float(time[i] - time[i - 1]), float(time[i + 1] - time[i])
    if not before > 0 or not after > 0:
        return float(np.sqrt(square[i]))
    falls, rises = (square[i] - square[i - 1]) / before, (square[i + 1] - square[i]) / after
    curvature, slope = (rises - falls) / (before + after), (falls * after + rises * before) / (before + after)
    return float(np.sqrt(square[i] - (slope**2 / (4 * curvature) if curvature < 0 else 0.0)))


def load_integration(case: RunUpCase, signal: MachineSignal | None, **loads: Any) -> ObservedIntegration[LoadObservation]:
    """Return the integration of a run-up in which a signal is sampled as densely as its turning points need.

    loads: further ones that are observed, as of ``LoadObserver``.
    """
    [model], horizon, settings = case.models, case.horizon, case.settings
    flow = compile_system(model.system, settings.tolerance, model.events(horizon.events), settings.engine)
    observer = LoadObserver(case.observer, signal, **loads)
    return ObservedIntegration(observer, flow, model.machine_motion, horizon.vibration, horizon.energy, _PER_TURN)


@dataclass(frozen=True, eq=False)
class LoadedRun:
    """A run with its loads. trajectory: a few stored samples, for its course and its works. compiled_system: its equations."""

    case: RunUpCase
    trajectory: Trajectory
    loads: LoadObservation
    compiled_system: CompiledSystem

    @cached_property
    def verdict(self) -> Verdict:
        """The verdict on the run."""
        return verdict_at_end(self.case.machine, self.loads.observation, self.trajectory, self.compiled_system)


def loaded_runs(case: RunUpCase, signal: MachineSignal | None, begin_time: float, work: Work) -> Iterator[LoadedRun]:
    """Yield a run with its loads after each leg, of whose motion little is stored."""
    [model], horizon = case.models, case.horizon
    integration = load_integration(case, signal, begin_time=begin_time, with_largest=True)
    flow = integration.compiled_system
    last = integration.begin(model.initial, model.parameter_values)
    latest = LoadedRun(case, last.trajectory, integration.observation(last), flow)
    yield latest
    work = work.open_ended if horizon.until_settled else work
    for number, grid in enumerate(horizon.legs(), 1):
        if last.trajectory.has_ended:
            break
        # Where an event ends the run, its time is only a limit: what share of the run is done is not known.
        end = math.inf if any(event.terminal for event in horizon.events) else grid.end
        last = work.unit(f"leg {number}", partial(integration.leg, last, _few(grid.samples), partial(_report, work, end)))
        latest = LoadedRun(case, latest.trajectory.join(last.trajectory), integration.observation(last), flow)
        yield latest
        if grid.is_judged and horizon.is_decided(latest.verdict):
            break


def _few(samples: np.ndarray) -> np.ndarray:
    """Return few of the samples of a leg, the first and the last among them."""
    return np.asarray(samples[np.unique(np.linspace(0, len(samples) - 1, _SAMPLES_A_LEG).round().astype(int))])


def _report(work: Work, end: float, time: float) -> None:
    work.report(time / end)


@dataclass(frozen=True, eq=False)
class LoadHistory:
    """The turning points of a load from the start on: time, values (m,). end_time: of the motion so far. verdict: on the
    run-up, None of a record. failure: the reason of an early end. duties: of the machine's rated bearings."""

    time: np.ndarray
    values: np.ndarray
    end_time: float
    verdict: Verdict | None = None
    failure: str | None = None
    duties: Duties = field(default_factory=dict)

    def course(self) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
        """Return times, and mean, least and greatest value there (k,): in 200 intervals, or of all turning points if few.

        The mean is that of straight lines through the turning points, as only these are kept.
        """
        time, values = self.time, self.values
        if len(values) <= _COURSE * _IN_A_PART:
            return time, values, values, values
        edges = np.linspace(time[0], self.end_time, _COURSE + 1)
        part = np.clip(np.searchsorted(edges, time, side="right") - 1, 0, _COURSE - 1)
        low, high = np.full(_COURSE, np.inf), np.full(_COURSE, -np.inf)
        np.minimum.at(low, part, values)
        np.maximum.at(high, part, values)
        nonempty = np.isfinite(low)
        knots = np.union1d(time, edges)
        heights = np.interp(knots, time, values)
        integral = np.append(0.0, np.cumsum((heights[1:] + heights[:-1]) / 2 * np.diff(knots)))
        mean = np.diff(integral[np.searchsorted(knots, edges)]) / np.diff(edges)
        middles, mean, low, high = (x[nonempty] for x in ((edges[1:] + edges[:-1]) / 2, mean, low, high))
        return middles, mean, low, high


def load_histories(
    case: RunUpCase, signal: MachineSignal, work: Work, bearings_from: float | None = None
) -> Iterator[LoadHistory]:
    """Yield the turning points of a signal after each leg of a run-up, of whose motion nothing else is stored.

    bearings_from: time from which on the duties of the machine's bearings count.
    """
    duty_observer = None if bearings_from is None else DutyObserver.of(case.machine, bearings_from)
    [model], integration = case.models, load_integration(case, signal, duty_observer=duty_observer)
    last = integration.begin(model.initial, model.parameter_values)
    parts: list[tuple[np.ndarray, np.ndarray]] = []
    yield _history(case, integration, parts, last)
    work = work.open_ended if case.horizon.until_settled else work
    for number, grid in enumerate(case.horizon.legs(), 1):
        if last.trajectory.has_ended:
            break
        # Its ends alone are stored; in between it is observed as densely as its motion needs.
        ends, resumed_leg = (
            grid.samples[[0, -1]],
            replace(last, observation=replace(last.observation, points=last.observation.points.without_points())),
        )
        last = work.unit(f"leg {number}", partial(integration.leg, resumed_leg, ends, partial(_report, work, grid.end)))
        parts.append((last.observation.points.time, last.observation.points.values))
        history = _history(case, integration, parts, last)
        yield history
        if grid.is_judged and history.verdict is not None and case.horizon.is_decided(history.verdict):
            break


def _history(
    case: RunUpCase,
    integration: ObservedIntegration[LoadObservation],
    parts: list[tuple[np.ndarray, np.ndarray]],
    last: Leg[LoadObservation],
) -> LoadHistory:
    """Join the parts before the last leg, and that leg with the motion still to be observed."""
    latest, trajectory = integration.observation(last), last.trajectory
    time, values = (np.concatenate([part[k] for part in (*parts[:-1], latest.points.points_to_end())]) for k in (0, 1))
    verdict = verdict_at_end(case.machine, latest.observation, trajectory, integration.compiled_system)
    return LoadHistory(time, values, trajectory.end_time, verdict, trajectory.failure, latest.duties)
