"""Question and machine -> plan: where the bodies are, and the speeds to look at."""

from __future__ import annotations

from dataclasses import dataclass

from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies
from wucht.studies.response.spec import Response


@dataclass(frozen=True)
class Plan:
    """range: lowest and highest speed in rad/s. points: evenly spaced over it."""

    steady: SteadyPhases
    range: tuple[float, float]
    points: int


def prepare(spec: Response, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the start does not fit the machine, or nothing is free to vibrate."""
    if not machine.free_carrier:
        needed = "nothing here is free to vibrate: a response needs a carrier on springs, and this one is"
        how, code = ("fixed", "fixed") if machine.shaken is None else ("moved as prescribed", "prescribed")
        raise InputError("machine.carrier", None, f"{needed} {how}", code=code)
    steady = SteadyPhases.of(machine, spec.start, spec.bodies)
    return Plan(steady, spec.range or _speed_range(steady.machine), spec.points)


def _speed_range(machine: Machine) -> tuple[float, float]:
    """The default of ``range``."""
    natural = [f for f in natural_frequencies(machine).values() if f > 0]
    free = abs(free_speed(machine, machine.rotor) or 0.0)
    top = max([*natural, 0.0]) or free or 1.0
    return min(0.02 * top, 0.3 * min([*natural, top])), max(3 * top, 1.5 * free)
