"""What is swept to find where a rotor is taken along: a parameter, or the difference of two motors."""

from __future__ import annotations

import math
from dataclasses import dataclass

from wucht.errors import InputError
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.tree import RotatingBody
from wucht.studies.parameters import parameter_of

DETUNING = "detuning"
AMPLITUDE = "carrier.motion.amplitude"
_REACH = 50  # times the speeds of the machine: far beyond any band
_LARGEST_AMPLITUDE = 10  # times the machine's own


@dataclass(frozen=True)
class SweptParameter:
    """What is swept. paths: a parameter, or the no-load speeds of two motors whose mean stays (``detuning``).

    own: the machine's own value. means, shares: parameter = mean + share * value.
    """

    name: str
    unit: str
    what: str
    own: float
    paths: tuple[str, ...]
    means: tuple[float, ...] = (0.0,)
    shares: tuple[float, ...] = (1.0,)

    def values(self, value: float) -> dict[str, float]:
        """The parameters' values, by path."""
        return {p: m + s * value for p, m, s in zip(self.paths, self.means, self.shares, strict=True)}

    def at(self, machine: Machine, value: float) -> Machine:
        """The machine with this value."""
        return machine.with_unchecked(self.values(value))

    def refuse(self, machine: Machine, value: float, where: str) -> None:
        """Raises ``InputError`` where a part does not allow a value."""
        if self.name == AMPLITUDE and value < 0:
            raise InputError(where, value, "allowed is an amplitude from 0 on")
        for path, changed in self.values(value).items():
            check_values(machine.parts, {path: changed}, where, machine.values)

    def widest(self, machine: Machine) -> tuple[float, float] | None:
        """Limits far beyond any band, within which it is looked for; None where nothing tells how far that is."""
        if self.name == AMPLITUDE:
            return 0.0, _LARGEST_AMPLITUDE * self.own
        if self.name != DETUNING and not self.name.endswith(".no_load_speed"):
            return None
        reach = _REACH * max(abs(machine.shaking_frequency or 0.0), *map(abs, self.means), abs(self.own))
        return (-reach, reach) if math.isfinite(reach) and reach > 0 else None


def swept_parameter(machine: Machine, name: str | None = None) -> SweptParameter:
    """The parameter of a name, or that which is swept by default. Raises ``InputError``.

    By default the no-load speed of the main rotor's drive; of two exciters the difference of their motors; of a rotor without
    drive the amplitude of the vibration.
    """
    if name is None:
        name = _default(machine)
    if name == DETUNING:
        return _detuning(machine)
    p = parameter_of(machine, name)
    return SweptParameter(name, p.unit, p.what or name, p.value, (name,))


def no_load_speed(machine: Machine, rotor: RotatingBody) -> str | None:
    """The path of the no-load speed of a rotor's drive, None where it has no such key."""
    paths = [d.no_load_path() for d in machine.drives if d.on == rotor.name]
    scheduled = {s.parameter for s in machine.schedules}
    return next((p for p in paths if p is not None and p not in scheduled), None)


def _default(machine: Machine) -> str:
    if machine.shaken is None and _two_motors(machine) is not None:
        return DETUNING
    path = no_load_speed(machine, machine.rotor)
    if path is not None:
        return path
    if not machine.drives and AMPLITUDE in machine.parameters:
        return AMPLITUDE
    raise InputError(
        "study.along",
        None,
        "this key is missing; the main rotor's drive has no no_load_speed: needed is the path of a parameter",
    )


def _two_motors(machine: Machine) -> tuple[str, str] | None:
    free = [r for r in machine.rotors if r.coordinate.prescribed is None]
    paths = [p for p in (no_load_speed(machine, r) for r in free) if p is not None]
    return (paths[0], paths[1]) if len(free) == len(paths) == 2 else None


def _detuning(machine: Machine) -> SweptParameter:
    """The second motor's no-load speed less the first one's, in magnitude; their mean stays."""
    paths = _two_motors(machine)
    if paths is None:
        raise InputError("study.along", DETUNING, "allowed for a machine with two rotors on drives with a no_load_speed each")
    senses = [sense_of(machine, r) for r in machine.rotors if r.coordinate.prescribed is None]
    first, second = (s * machine.values[p] for s, p in zip(senses, paths, strict=True))
    mean = (first + second) / 2
    return SweptParameter(
        DETUNING, machine.units.speed, "difference of the no-load speeds", second - first, paths,
        (senses[0] * mean, senses[1] * mean), (-senses[0] / 2, senses[1] / 2),
    )  # fmt: skip
