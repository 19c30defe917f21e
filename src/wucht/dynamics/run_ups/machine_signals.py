"""Signals of a machine's motion, and their turning points over a run-up, leg by leg."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np
import sympy as sp

from wucht.analysis.bearing_forces import bearing_force
from wucht.dynamics.run_ups.bearing_loads import Duties, DutyObserver, has_bearing_forces
from wucht.dynamics.run_ups.observed_integration import Leg, ObservedIntegration
from wucht.dynamics.run_ups.run_up import RunUpCase, verdict_at_end
from wucht.dynamics.verdicts.observation import MotionObserver, Observation
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.errors import InputError, nearest
from wucht.fatigue.counting import TurningPoints
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

_VALUE = "value"
# The parabola through an extreme's neighbours is right to h^4/32 with the step h of a vibration's angle: 1e-5.
_PER_TURN = 48
_COURSE, _IN_A_PART = 200, 8  # intervals of time with their least and greatest value, and turning points in one


@dataclass(frozen=True)
class MachineSignal:
    """A signal of a machine's motion: its name, and the unit of its values."""

    name: str
    unit: str
    evaluator: Evaluator

    def __call__(self, motion: Trajectory) -> np.ndarray:
        """Return its values (N,) over the machine's motion."""
        values = self.evaluator(motion.time, motion.states, motion.final_parameter_values)[_VALUE]
        return np.broadcast_to(values, motion.time.shape)


@dataclass(frozen=True)
class SignalObservation:
    """An observation of the machine's motion, for the verdict, the signal's turning points since they were last taken, and the
    duties of the machine's bearings."""

    observation: Observation
    points: TurningPoints
    duties: Duties = field(default_factory=dict)


@dataclass(frozen=True)
class SignalObserver:
    """Observer of a machine, of a signal of its motion, and of its bearings, if they are observed."""

    motion_observer: MotionObserver
    signal: MachineSignal
    duty_observer: DutyObserver | None = None

    @property
    def machine(self) -> Machine:
        """The observed machine."""
        return self.motion_observer.machine

    @property
    def span(self) -> float:
        """The sampled span of time; see ``MotionObserver``."""
        return self.motion_observer.span

    def begin(self) -> SignalObservation:
        """Return the empty observation."""
        duties = {} if self.duty_observer is None else self.duty_observer.begin()
        return SignalObservation(self.motion_observer.begin(), TurningPoints(), duties)

    def update(self, previous: SignalObservation, motion: Trajectory) -> SignalObservation:
        """Return the observation after a further part of the machine's motion."""
        points = previous.points.update(motion.time, self.signal(motion), interpolate=True)
        duties = previous.duties if self.duty_observer is None else self.duty_observer.update(previous.duties, motion)
        return SignalObservation(self.motion_observer.update(previous.observation, motion), points, duties)


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


def signal_integration(
    case: RunUpCase, signal: MachineSignal, bearings_from: float | None = None
) -> ObservedIntegration[SignalObservation]:
    """Return the integration of a run-up in which a signal is sampled as densely as its turning points need.

    bearings_from: time from which on the machine's bearings are observed too.
    """
    [model], horizon, settings = case.models, case.horizon, case.settings
    compiled_system = compile_system(model.system, settings.tolerance, model.events(horizon.events), settings.engine)
    duty_observer = None if bearings_from is None else DutyObserver.of(case.machine, bearings_from)
    return ObservedIntegration(
        SignalObserver(case.observer, signal, duty_observer),
        compiled_system,
        model.machine_motion,
        horizon.vibration,
        horizon.energy,
        _PER_TURN,
    )


def load_histories(
    case: RunUpCase, signal: MachineSignal, work: Work, bearings_from: float | None = None
) -> Iterator[LoadHistory]:
    """Yield the turning points of a signal after each leg of a run-up, of whose motion nothing else is stored.

    bearings_from: time from which on the duties of the machine's bearings count.
    """
    [model], integration = case.models, signal_integration(case, signal, bearings_from)
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


def _report(work: Work, end: float, time: float) -> None:
    work.report(time / end)


def _history(
    case: RunUpCase,
    integration: ObservedIntegration[SignalObservation],
    parts: list[tuple[np.ndarray, np.ndarray]],
    last: Leg[SignalObservation],
) -> LoadHistory:
    """Join the parts before the last leg, and that leg with the motion still to be observed."""
    latest, trajectory = integration.observation(last), last.trajectory
    time, values = (np.concatenate([part[k] for part in (*parts[:-1], latest.points.points_to_end())]) for k in (0, 1))
    verdict = verdict_at_end(case.machine, latest.observation, trajectory, integration.compiled_system)
    return LoadHistory(time, values, trajectory.end_time, verdict, trajectory.failure, latest.duties)


def rotor_signal(machine: Machine, rotor: str, direction: str | None, location: str = "study") -> MachineSignal:
    """Return the force of one rotor, with the bodies about it, on its bearing.

    direction: x by default, or y, whether the carrier moves there or not. Raises ``InputError`` for an unknown rotor, and
    where the machine's rotors have no forces in the plane.
    """
    names = [r.name for r in machine.rotors]
    if rotor not in names:
        raise InputError(f"{location}.rotor", rotor, f"must be a rotor of the machine; {nearest(rotor, names)}")
    if not has_bearing_forces(machine):
        raise InputError(f"{location}.rotor", rotor, "this machine's rotors have no bearing forces in newtons")
    if direction not in (None, "x", "y"):
        raise InputError(f"{location}.direction", direction, "must be one of x, y")
    label = direction or "x"
    evaluator = Evaluator.of(machine.system, [bearing_force(machine, rotor, label)], [_VALUE])
    return MachineSignal(f"bearing force of {rotor} in {label}", machine.units.force, evaluator)


def machine_signal(machine: Machine, name: str, direction: str | None, location: str = "study") -> MachineSignal:
    """Return a signal of the carrier's motion.

    name: ``"displacement"``, ``"spring-force"``, ``"bearing-force"`` (of the bodies on it) or ``"acceleration"``. direction: by
    default the first that the machine has. location: the table of the study file that requests it. Raises ``InputError`` for a
    machine without a carrier, or without that direction.
    """
    units, system = machine.units, machine.system
    directions = machine.free_labels if name in ("acceleration", "spring-force") else machine.labels
    if not directions:
        raise InputError(f"{location}.signal", name, "this machine's carrier does not move")
    if direction is not None and direction not in directions:
        raise InputError(f"{location}.direction", direction, f"must be one of {', '.join(directions)}")
    label = direction or directions[0]
    coordinate = dict(zip(machine.labels, machine.carrier, strict=True))[label]
    turns = label == "r"
    force = units.torque if turns else units.force
    expressions: Mapping[str, tuple[object, str]] = {
        "displacement": (coordinate.position, "rad" if turns and units.time else units.length),
        "spring-force": (_spring_force(machine, label), force),
        "bearing-force": (system.output(f"bearing_force_{label}").expression, force),
    }
    if name == "acceleration":
        rate = system.derivatives[machine.row(coordinate.velocity)]
        unit = f"{'rad' if turns else units.length}/{units.time}^2" if units.time else ""
    else:
        rate, unit = expressions[name]
    evaluator = Evaluator.of(system, [rate], [_VALUE])
    kind = "moment" if turns else "force"
    descriptions = {"bearing-force": f"bearing {kind}", "spring-force": f"{kind} of the springs"}
    description = descriptions.get(name, f"{name} of the carrier")
    return MachineSignal(f"{description} in {label}", unit, evaluator)


def _spring_force(machine: Machine, label: str) -> sp.Expr:
    """The force of the carrier's springs that answers its displacement, along a free direction: K q."""
    if label not in machine.free_labels:
        return sp.S.Zero
    row = machine.linear_carrier.stiffness.row(machine.free_labels.index(label))
    return sp.Add(*(c * q.position for c, q in zip(row, machine.free_carrier, strict=True)))
