"""The signals that are counted: of a machine's motion, or of a record; each with its unit and name."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.dynamics.verdicts.observation import Observation, Watch
from wucht.errors import InputError
from wucht.fatigue.turning_points import TurningPoints
from wucht.machines.machine import Machine
from wucht.measurements.reading import read_recording
from wucht.measurements.recording import FULL_SCALE, Channel
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory
from wucht.quantities import Unit
from wucht.studies.load_spectrum.machine_or_records import Records
from wucht.studies.load_spectrum.spec import Record

# Of loads, in this order: loggers state accelerations in g, which elsewhere is a gram.
_SI = ("m/s^2", "N", "N m", "Pa", "m", "m/s", "rad", "rad/s", "V", "A", "W", "kg", "")
_VALUE = "value"


@dataclass(frozen=True)
class Signal:
    """What is counted: its name, and the unit of its values."""

    name: str
    unit: str


@dataclass(frozen=True)
class MachineSignal(Signal):
    """A signal of a machine's motion."""

    machine: Machine
    evaluator: Evaluator

    def __call__(self, motion: Trajectory) -> np.ndarray:
        """Its values (N,) over the machine's motion."""
        values = self.evaluator(motion.time, motion.states, motion.parameters)[_VALUE]
        return np.broadcast_to(values, motion.time.shape)


@dataclass(frozen=True)
class RecordSignal(Signal):
    """A recorded signal: a channel, in SI where its unit is known."""

    channel: Channel


@dataclass(frozen=True)
class Seen:
    """observation: of the machine's motion, for the verdict. points: the signal's, since they were last taken away."""

    observation: Observation
    points: TurningPoints


@dataclass(frozen=True)
class SignalWatch:
    """Watches a machine, and a signal of its motion."""

    watch: Watch
    signal: MachineSignal

    @property
    def machine(self) -> Machine:
        """What is watched."""
        return self.watch.machine

    @property
    def span(self) -> float:
        """See ``Watch``."""
        return self.watch.span

    def begin(self) -> Seen:
        """Before anything has been seen."""
        return Seen(self.watch.begin(), TurningPoints())

    def looked(self, seen: Seen, motion: Trajectory) -> Seen:
        """After a part of the machine's motion."""
        points = seen.points.after(motion.time, self.signal(motion), between=True)
        return Seen(self.watch.looked(seen.observation, motion), points)


def machine_signal(machine: Machine, name: str, direction: str | None, where: str = "study") -> MachineSignal:
    """A signal of the carrier's motion. Raises ``InputError`` for a machine without a carrier, or without that direction."""
    units, system = machine.units, machine.system
    allowed = machine.free_labels if name in ("acceleration", "spring-force") else machine.labels
    if not allowed:
        raise InputError(f"{where}.signal", name, "this machine's carrier does not move")
    if direction is not None and direction not in allowed:
        raise InputError(f"{where}.direction", direction, f"must be one of {', '.join(allowed)}")
    label = direction or allowed[0]
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
    named = {"bearing-force": f"bearing {kind}", "spring-force": f"{kind} of the springs"}
    what = named.get(name, f"{name} of the carrier")
    return MachineSignal(f"{what} in {label}", unit, machine, evaluator)


def _spring_force(machine: Machine, label: str) -> sp.Expr:
    """The force of the carrier's springs that answers its displacement, along a free direction: K q."""
    if label not in machine.free_labels:
        return sp.S.Zero
    row = machine.linear_carrier.stiffness.row(machine.free_labels.index(label))
    return sp.Add(*(c * q.position for c, q in zip(row, machine.free_carrier, strict=True)))


def record_signal(asked: Record, records: Records) -> RecordSignal:
    """A recorded signal. Raises ``InputError`` for a record that cannot be read, and a column that it does not have."""
    recording = read_recording(records.folder / asked.file)
    if asked.column is None and len(recording.names) != 1:
        known = ", ".join(recording.names)
        raise InputError("study.signal.column", None, f"this key is missing; the record has the columns {known}")
    channel = recording.channel(asked.column or recording.names[0]).corrected(asked.unit, asked.scale)
    channel = _in_si(channel)
    return RecordSignal(channel.name, channel.unit, channel)


def _in_si(channel: Channel) -> Channel:
    """In SI; one without a unit, in shares of full scale, or in a unit that we do not know stays as it is."""
    if channel.unit in ("", FULL_SCALE):
        return channel
    for si in _SI:
        try:
            return channel.in_si(Unit(si, "load"))
        except InputError:
            continue
    return channel
