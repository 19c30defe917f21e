"""How slowly a parameter is moved: from the times in which the machine answers."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np
import sympy as sp

from wucht.errors import InputError
from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.machine import Machine, Turning
from wucht.machines.vibration import Vibration, free_speed, group, net_torque
from wucht.studies.sweep.flow import with_value

if TYPE_CHECKING:
    from wucht.studies.sweep.study import Sweep

ANSWERS = 1000  # the default rate: the range takes a thousand times as long as the machine takes to answer
MOST_TURNS = 100_000  # of one ramp at the default rate
MOST_TURNS_ASKED = 10_000_000  # of one ramp at a rate that is asked for
_LEAST = 0.1  # of the time that the machine takes to answer: what a ramp takes at least
SAMPLES = 400  # of one ramp
_TURNS_A_SAMPLE = 3


@dataclass(frozen=True)
class Plan:
    """answer: the slowest decay of the machine's small motions, at least a turn.

    fastest, turn: the largest speed and the longest turn expected. driven: the largest speed that the drives reach.
    rate: of the parameter. samples: of a ramp. step: duration of one. warnings: what is doubtful.
    """

    answer: float
    fastest: float
    turn: float
    driven: float
    rate: float
    samples: int
    step: float
    warnings: tuple[str, ...]

    @classmethod
    def of(cls, machine: Machine, question: Sweep) -> Plan:
        """The plan of a sweep. Raises ``InputError`` for a rate that is far too low or too high."""
        low, high = question.range
        ends = [with_value(machine, question.along, v) for v in (low, (low + high) / 2, high)]
        speeds = [abs(free_speed(m, r) or 0.0) for m in ends for r in m.rotors]
        natural = [f for m in ends for f in natural_frequencies(m).values() if f > 0]
        shaken = [m.values.get("carrier.motion.frequency", 0.0) for m in ends]
        fastest = max([*speeds, *natural, *shaken]) or 1.0
        turn = 2 * math.pi / max(min([w for w in [*speeds, *natural] if w > 0], default=fastest), 0.02 * fastest)
        answers = [max(turn, _answer(m)) for m in ends]
        answer = max(answers)
        driven = max(speeds, default=0.0)
        duration, said = ANSWERS * answer, list[str]()
        most = MOST_TURNS * 2 * math.pi / fastest
        if question.rate is not None:
            longest, shortest = MOST_TURNS_ASKED * 2 * math.pi / fastest, min(_LEAST * min(answers), most)
            _check_rate(question.rate, (high - low) / longest, (high - low) / shortest, rate_unit(machine, question.along))
            duration = (high - low) / question.rate
        elif duration > most:
            duration = most
            said.append(_slow(answer, machine.units.time))
        samples = max(8, min(SAMPLES, int(duration / (_TURNS_A_SAMPLE * turn))))
        return cls(answer, fastest, turn, driven, (high - low) / duration, samples, duration / samples, tuple(said))


def _slow(answer: float, unit: str) -> str:
    """The warning for a machine that answers slowly."""
    return (
        f"the machine answers slowly (in {f'{answer:.3g} {unit}'.strip()}): the default rate is limited to {MOST_TURNS} turns "
        "a ramp; give a lower rate to be sure that the sweep is quasi-static"
    )


def rate_unit(machine: Machine, path: str) -> str:
    """What stands behind the number of a rate of a parameter: ``rad/s per s``."""
    unit, time = machine.parameters[path].unit, machine.units.time
    return f"{unit} {f'per {time}' if time else 'a unit of time'}".strip()


def _check_rate(rate: float, lowest: float, highest: float, unit: str) -> None:
    """Raises ``InputError`` where a ramp would take forever, or no time at all."""
    low, high = (float(f"{limit:.2g}") for limit in (lowest, highest))
    if not low <= rate <= high:
        raise InputError(
            "study.rate", rate,
            f"allowed is a rate from {low:g} to {high:g} {unit}: a lower one takes more than "
            f"{MOST_TURNS_ASKED} turns a ramp, a higher one less than a tenth of the time in which the machine answers",
        )  # fmt: skip


def _answer(machine: Machine) -> float:
    """The time constant of the slowest decay of the carrier's free vibration and of the drives' speed; 0 if none decays."""
    v = Vibration.of(machine)
    n, found = len(v.mass), [0.0]
    if n:
        inverse = np.linalg.inv(v.mass)
        matrix = np.block([[np.zeros((n, n)), np.eye(n)], [-inverse @ v.stiffness, -inverse @ v.damping]])
        values = np.linalg.eigvals(matrix)
        decays = -values.real[-values.real > 1e-9 * np.abs(values).max()]
        found += (1 / decays).tolist()
    for rotor in machine.rotors:
        speed = free_speed(machine, rotor)
        if rotor.coordinate.prescribed is not None or speed is None:
            continue
        torque, h = net_torque(machine, rotor), 1e-3 * (abs(speed) or 1.0)
        slope = (torque(speed - h) - torque(speed + h)) / (2 * h)
        if slope > 0:
            found.append(_inertia(machine, rotor) / slope)
    return max(found)


def _inertia(machine: Machine, rotor: Turning) -> float:
    """The inertia of a rotor with all bodies that turn with it."""
    at = {c.velocity: sp.S.Zero for c in machine.coordinates} | {c.position: sp.S.Zero for c in machine.coordinates}
    at |= {b.coordinate.velocity: sp.S.One for b in group(machine, rotor)}
    kinetic = sp.Add(*(e.kinetic for e in machine.energies)).xreplace(at).xreplace(machine.numbers)
    return 2 * float(kinetic)
