"""What is changed to find where a rotor is taken along: a parameter, or the difference of two motors."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

from wucht.errors import InputError
from wucht.machines.machine import Machine, Turning
from wucht.machines.vibration import sense_of
from wucht.quantities import Unit
from wucht.studies.keys import allowed_value, parameter

DETUNING = "detuning"
MOTION = "carrier.motion.amplitude"


@dataclass(frozen=True)
class Along:
    """What is changed. paths: a parameter, or the no-load speeds of two motors whose mean stays (``detuning``).

    own: the machine's own value. middles, shares: parameter = middle + share * value.
    """

    name: str
    unit: str
    what: str
    own: float
    paths: tuple[str, ...]
    middles: tuple[float, ...] = (0.0,)
    shares: tuple[float, ...] = (1.0,)

    def values(self, value: float) -> dict[str, float]:
        """The parameters' values, by path."""
        return {p: m + s * value for p, m, s in zip(self.paths, self.middles, self.shares, strict=True)}

    def at(self, machine: Machine, value: float) -> Machine:
        """The machine with this value."""
        return machine.with_values(self.values(value))

    def allowed(self, machine: Machine, value: float, where: str) -> None:
        """Raises ``InputError`` where a part does not allow a value."""
        for path, found in self.values(value).items():
            allowed_value(machine, path, found, where)


def no_load_speed(machine: Machine, rotor: Turning) -> str | None:
    """The path of the no-load speed of a rotor's drive, None where it has no such key."""
    paths = [f"{d.path}.no_load_speed" for d in machine.drives if d.on == rotor.name]
    scheduled = {s.parameter for s in machine.schedules}
    return next((p for p in paths if p in machine.parameters and p not in scheduled), None)


def read_along(table: Mapping[str, Any], machine: Machine) -> str:
    """The key ``along``, or what is changed by default. Raises ``InputError``.

    By default the no-load speed of the main rotor's drive; of two exciters the difference of their motors; of a rotor without
    drive the amplitude of the vibration.
    """
    given = table.get("along")
    if given == DETUNING:
        if _detunable(machine) is None:
            raise InputError("study.along", given, "allowed for a machine with two rotors on drives with a no_load_speed each")
        return DETUNING
    if given is not None:
        return parameter(table, "along", machine).path
    if machine.shaken is None and _detunable(machine) is not None:
        return DETUNING
    found = no_load_speed(machine, machine.rotor)
    if found is not None:
        return found
    if not machine.drives and MOTION in machine.parameters:
        return MOTION
    raise InputError(
        "study.along",
        None,
        "this key is missing; the main rotor's drive has no no_load_speed: needed is the path of a parameter",
    )


def _detunable(machine: Machine) -> tuple[str, str] | None:
    free = [r for r in machine.rotors if r.coordinate.prescribed is None]
    paths = [p for p in (no_load_speed(machine, r) for r in free) if p is not None]
    return (paths[0], paths[1]) if len(free) == len(paths) == 2 else None


def along_of(machine: Machine, name: str) -> Along:
    """What ``along`` means for a machine.

    The detuning is the second motor's no-load speed less the first one's, in magnitude; their mean stays.
    """
    if name != DETUNING:
        p = machine.parameters[name]
        return Along(name, p.unit, p.what or name, p.value, (name,))
    paths = _detunable(machine)
    assert paths is not None
    senses = [sense_of(machine, r) for r in machine.rotors if r.coordinate.prescribed is None]
    first, second = (s * machine.values[p] for s, p in zip(senses, paths, strict=True))
    middle = (first + second) / 2
    return Along(
        DETUNING, machine.units.speed, "difference of the no-load speeds", second - first, paths,
        (senses[0] * middle, senses[1] * middle), (-senses[0] / 2, senses[1] / 2),
    )  # fmt: skip


def unit_of(machine: Machine, name: str) -> Unit:
    """How values of ``along`` are read."""
    found = along_of(machine, name)
    return Unit(found.unit, found.what)


def widest(machine: Machine, along: Along) -> tuple[float, float] | None:
    """Limits far beyond any band, within which it is looked for; None where nothing tells how far that is."""
    if along.name == MOTION:
        return 0.0, 10 * along.own
    speeds = [abs(machine.values.get("carrier.motion.frequency", 0.0)), *map(abs, along.middles), abs(along.own)]
    if along.name != DETUNING and not along.name.endswith(".no_load_speed"):
        return None
    reach = 50 * max(speeds)
    return (-reach, reach) if math.isfinite(reach) and reach > 0 else None
