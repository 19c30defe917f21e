"""Machine in which rotors may be entrained: the swept parameter, its limits, and the start."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.dynamics.parameters import parameter_of
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.dynamics.verdicts.locking import is_locking
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.tree import RotatingBody

DETUNING = "detuning"
AMPLITUDE = "carrier.motion.amplitude"
_REACH = 50  # times the speeds of the machine: far beyond any band
_LARGEST_AMPLITUDE = 10  # times the nominal one


@dataclass(frozen=True)
class SweptParameter:
    """Swept quantity: a parameter, or the no-load speeds of two motors whose mean stays (``detuning``).

    nominal_value: of the machine. shares: of each parameter, by path, its value at 0, and its change with the swept value.
    """

    name: str
    unit: str
    description: str
    nominal_value: float
    shares: Mapping[str, tuple[float, float]]

    @property
    def size(self) -> float:
        """Largest of the nominal value and of the parameters at 0, in magnitude."""
        return max(abs(self.nominal_value), *(abs(mean) for mean, _ in self.shares.values()))

    def values(self, value: float) -> dict[str, float]:
        """Return the parameters' values, by path."""
        return {path: mean + share * value for path, (mean, share) in self.shares.items()}

    def machine_at(self, machine: Machine, value: float) -> Machine:
        """Return the machine with this value."""
        return machine.with_unchecked_values(self.values(value))

    def refuse(self, machine: Machine, value: float, location: str) -> None:
        """Raise ``InputError`` where a part does not allow a value."""
        if self.name == AMPLITUDE and value < 0:
            raise InputError(location, value, "must be an amplitude of at least 0")
        machine.check_values(self.values(value), location)

    def widest(self, machine: Machine) -> tuple[float, float] | None:
        """Return limits far beyond any band, within which it is searched; None where no scale is known."""
        if self.name == AMPLITUDE:
            return 0.0, _LARGEST_AMPLITUDE * self.nominal_value
        if self.name != DETUNING and not self.name.endswith(".no_load_speed"):
            return None
        reach = _REACH * max(abs(machine.shaking_frequency or 0.0), self.size)
        return (-reach, reach) if math.isfinite(reach) and reach > 0 else None


def swept_parameter(machine: Machine, name: str | None = None) -> SweptParameter:
    """Return the parameter of a name, or the one swept by default. Raises ``InputError``.

    By default the no-load speed of the main rotor's drive; of two exciters the difference of their motors; of a rotor without
    drive the amplitude of the vibration.
    """
    if name == DETUNING or (name is None and machine.shaken_coordinate is None and _two_motors(machine)):
        return _detuning(machine)
    name = name or no_load_speed(machine, machine.rotor)
    if name is None and not machine.drives and AMPLITUDE in machine.parameters:
        name = AMPLITUDE
    if name is None:
        requirement = "the main rotor's drive has no no_load_speed: give the path of a parameter"
        raise InputError("study.along", None, f"this key is missing; {requirement}", code="missing")
    p = parameter_of(machine, name)
    return SweptParameter(name, p.unit, p.full_name or name, p.value, {name: (0.0, 1.0)})


def no_load_speed(machine: Machine, rotor: RotatingBody) -> str | None:
    """Return the path of the no-load speed of a rotor's drive, None without such a key, or with a gear between."""
    paths = [d.no_load_path() for d in machine.drives if d.on == rotor.name and d.transmission is None]
    scheduled_paths = {s.parameter for s in machine.schedules}
    return next((p for p in paths if p is not None and p not in scheduled_paths), None)


def _two_motors(machine: Machine) -> dict[str, float]:
    """Return the paths of the no-load speeds of two motors and the senses of their rotors; empty unless there are just two."""
    senses = {
        no_load_speed(machine, r): sense_of(machine, r) for r in machine.rotors if r.coordinate.prescribed_velocity is None
    }
    paths = {path: sense for path, sense in senses.items() if path is not None}
    return paths if len(paths) == len(senses) == 2 else {}


def _detuning(machine: Machine) -> SweptParameter:
    """Return the second motor's no-load speed minus the first one's, in magnitude; their mean stays."""
    motors = _two_motors(machine)
    if not motors:
        raise InputError("study.along", DETUNING, "allowed for a machine with two rotors on drives with a no_load_speed each")
    first, second = (sense * machine.values[path] for path, sense in motors.items())
    mean, halves = (first + second) / 2, (-0.5, 0.5)
    shares = {path: (sense * mean, sense * half) for (path, sense), half in zip(motors.items(), halves, strict=True)}
    return SweptParameter(DETUNING, machine.units.speed, "difference of the no-load speeds", second - first, shares)


@dataclass(frozen=True)
class EntrainmentCase:
    """Definition of an entrainment study. machine: at its start; initial: its state (n,) there; start: as stated in the file.

    limits: within which bands are searched, the nominal value included. range: that is examined, None for the band of
    existence and a margin. points: runs from the start, evenly over it. resolution: of the edges, None for a share of it.
    until: least duration of a run, None for that which follows from the averaged equations.
    """

    machine: Machine
    initial: np.ndarray
    start: Mapping[str, Any]
    parameter: SweptParameter
    limits: tuple[float, float]
    range: tuple[float, float] | None
    resolution: float | None
    points: int
    until: float | None

    @classmethod
    def of(
        cls,
        machine: Machine,
        parameter: SweptParameter,
        start: Mapping[str, Any],
        points: int,
        range: tuple[float, float] | None = None,  # noqa: A002 - the key of a study file
        resolution: float | None = None,
        until: float | None = None,
    ) -> EntrainmentCase:
        """Set up the case of a machine. Raises ``InputError`` where nothing can be entrained, or a value is not allowed."""
        check_entrainable(machine)
        limits = range or parameter.widest(machine)
        if limits is None:
            raise InputError(
                "study.range",
                None,
                f"this key is missing; give a pair [low, high] for the {parameter.description}",
                code="missing",
            )
        for i, value in enumerate(range or ()):
            parameter.refuse(machine, value, f"study.range[{i}]")
        placed_machine, initial = prepare_start(machine, start)
        limits = min(limits[0], parameter.nominal_value), max(limits[1], parameter.nominal_value)
        case = cls(placed_machine, initial, start, parameter, limits, range, resolution, points, until)
        if range is None:  # the band of existence determines it
            try:
                averaged_equations_of(case.steady)
            except InputError as error:
                reason = f"a default follows only from averaged equations, and {error.explanation}"
                raise InputError(
                    "study.range", None, f"this key is missing, and has no default here: {reason}", code="not-chosen"
                ) from None
        return case

    @property
    def steady(self) -> Machine:
        """Machine after the end of its schedules."""
        return self.machine.at(self.machine.breakpoints[-1]).with_fields(schedules=())


def check_entrainable(machine: Machine) -> None:
    """Raise ``InputError`` for machines in which nothing can be entrained."""
    if not is_locking(machine):
        requirement = "a carrier.motion of amplitude and frequency, or two rotors or more whose speed no drive prescribes"
        raise InputError("machine", None, f"nothing can be entrained: give {requirement}")
    prescribed_rotor = next((r.name for r in machine.rotors if r.coordinate.prescribed_velocity is not None), None)
    if prescribed_rotor is not None:
        raise InputError(
            "machine.drive", None, f"the drive prescribes the speed of {prescribed_rotor!r}: it cannot be entrained"
        )
