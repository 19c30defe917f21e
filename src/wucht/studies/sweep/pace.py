"""How slowly a parameter is moved: from the times in which the machine answers."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.analysis.vibration import Vibration
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, net_torque
from wucht.machines.tree import RotatingBody

ANSWERS = 1000  # the default rate: the range takes a thousand times as long as the machine takes to answer
MOST_TURNS = 100_000  # of one ramp at the default rate
MOST_TURNS_ASKED = 10_000_000  # of one ramp at a rate that is asked for
_LEAST = 0.1  # of the time that the machine takes to answer: what a ramp takes at least
SAMPLES = 400  # of one ramp
_TURNS_A_SAMPLE = 3


@dataclass(frozen=True)
class Pace:
    """answer: the slowest decay of the machine's small motions, at least a turn.

    fastest, turn: the largest speed and the longest turn expected. driven: the largest speed that the drives reach.
    rate: of the swept parameter. samples: of a ramp. step: duration of one. warnings: what is doubtful.
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
    def of(cls, machine: Machine, swept: str, span: tuple[float, float], asked: float | None) -> Pace:
        """The pace of a sweep through a span at the rate that was asked for, if one was.

        Raises ``InputError`` for a rate that is far too low or too high.
        """
        low, high = span
        ends = [machine.with_unchecked({swept: v}) for v in (low, (low + high) / 2, high)]
        speeds = [abs(free_speed(m, r) or 0.0) for m in ends for r in m.rotors]
        natural = [f for m in ends for f in natural_frequencies(m).values() if f > 0]
        shaken = [(m.shaking_frequency or 0.0) for m in ends]
        fastest = max([*speeds, *natural, *shaken]) or 1.0
        turn = 2 * math.pi / max(min([w for w in [*speeds, *natural] if w > 0], default=fastest), 0.02 * fastest)
        answers = [max(turn, _answer(m)) for m in ends]
        answer, warnings = max(answers), tuple[str, ...]()
        duration, most = ANSWERS * answer, MOST_TURNS * 2 * math.pi / fastest
        if asked is not None:
            longest, shortest = MOST_TURNS_ASKED * 2 * math.pi / fastest, min(_LEAST * min(answers), most)
            _check_rate(asked, (high - low) / longest, (high - low) / shortest, rate_unit(machine, swept))
            duration = (high - low) / asked
        elif duration > most:
            duration, warnings = most, (_slow(answer, machine.units.time),)
        samples = max(8, min(SAMPLES, int(duration / (_TURNS_A_SAMPLE * turn))))
        driven = max(speeds, default=0.0)
        return cls(answer, fastest, turn, driven, (high - low) / duration, samples, duration / samples, warnings)


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
    poles = Vibration.of(machine).poles
    decays = -poles.real[-poles.real > 1e-9 * np.abs(poles).max(initial=0.0)]
    found = [0.0, *(1 / decays).tolist()]
    for rotor in machine.rotors:
        speed = free_speed(machine, rotor)
        if rotor.coordinate.prescribed is not None or speed is None:
            continue
        torque, h = net_torque(machine, rotor), 1e-3 * (abs(speed) or 1.0)
        slope = (torque(speed - h) - torque(speed + h)) / (2 * h)
        if slope > 0:
            found.append(_inertia(machine, rotor) / slope)
    return float(max(found))


def _inertia(machine: Machine, rotor: RotatingBody) -> float:
    """The inertia of a rotor with all bodies that turn with it."""
    at = {c.velocity: sp.S.Zero for c in machine.coordinates} | {c.position: sp.S.Zero for c in machine.coordinates}
    at |= {b.coordinate.velocity: sp.S.One for b in machine.group(rotor)}
    kinetic = sp.Add(*(e.kinetic for e in machine.energies)).xreplace(at).xreplace(machine.numbers)
    return 2 * float(kinetic)
