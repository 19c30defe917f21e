"""The loads on a machine while it runs: a signal's turning points, the largest bearing forces, the travel of its mounts."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property, partial

import numpy as np

from wucht.dynamics.run_ups.machine_signals import MachineSignal
from wucht.dynamics.run_ups.observed_integration import ObservedIntegration
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

_PER_TURN = 48  # samples: see ``machine_signals``
_SAMPLES_A_LEG = 100  # samples of a leg, for the course alone


def mount_places(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return the places of the mounts on a carrier by name, in m; of one on springs at its centre of mass that is the place.

    Empty where the carrier does not translate freely.
    """
    if not {"x", "y"} & set(machine.free_labels):
        return {}
    carrier, values = machine.parts[0], machine.values
    if not isinstance(carrier, PlanarCarrier) or not carrier.mounts:
        return {"carrier": (0.0, 0.0)}
    keys = [f"carrier.mounts.{i}.at" for i in range(1, len(carrier.mounts) + 1)]
    return {f"mount {i}": (values[f"{key}.x"], values[f"{key}.y"]) for i, key in enumerate(keys, 1)}


@dataclass(frozen=True)
class LoadObservation:
    """An observation of a motion, the turning points of its signal, and largest values so far.

    bearing_forces: by rotor. travels: by mount, the largest distance from its position at rest.
    """

    observation: Observation
    points: TurningPoints = field(default_factory=TurningPoints)
    bearing_forces: Mapping[str, float] = field(default_factory=dict)
    travels: Mapping[str, float] = field(default_factory=dict)


@dataclass(frozen=True)
class LoadObserver:
    """Observer of a machine and of its loads. begin_time: of its motion, added to the time of the turning points."""

    motion_observer: MotionObserver
    signal: MachineSignal | None
    begin_time: float = 0.0

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
    def _places(self) -> dict[str, tuple[float, float]]:
        return mount_places(self.machine)

    def begin(self) -> LoadObservation:
        """Return the empty observation."""
        return LoadObservation(self.motion_observer.begin())

    def update(self, previous: LoadObservation, motion: Trajectory) -> LoadObservation:
        """Return the observation after a further part of the machine's motion."""
        return LoadObservation(
            self.motion_observer.update(previous.observation, motion),
            previous.points if self.signal is None else self._points(previous.points, self.signal, motion),
            _larger(previous.bearing_forces, self._largest_forces(motion)),
            _larger(previous.travels, self._largest_travels(motion)),
        )

    def _points(self, previous: TurningPoints, signal: MachineSignal, motion: Trajectory) -> TurningPoints:
        return previous.update(self.begin_time + motion.time, signal(motion), interpolate=True)

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


def _larger(first: Mapping[str, float], second: Mapping[str, float]) -> dict[str, float]:
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
    [model], horizon, settings = case.models, case.horizon, case.settings
    flow = compile_system(model.system, settings.tolerance, model.events(horizon.events), settings.engine)
    observer = LoadObserver(case.observer, signal, begin_time)
    integration = ObservedIntegration(observer, flow, model.machine_motion, horizon.vibration, horizon.energy, _PER_TURN)
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
