"""How slowly a parameter of a machine is moved: by the time in which the machine answers."""

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
    rate: of the swept parameter, in rate_unit. samples: of a ramp. step: duration of one. warnings: what is doubtful.
    """

    answer: float
    fastest: float
    turn: float
    driven: float
    rate: float
    rate_unit: str
    samples: int
    step: float
    warnings: tuple[str, ...]


def pace_of(machine: Machine, swept: str, low: float, high: float, given: float | None = None) -> Pace:
    """The pace of a sweep at a given rate; None: at one that lets the machine answer.

    Raises ``InputError`` for a rate at which a ramp would take forever, or no time at all.
    """
    ends = [machine.with_unchecked({swept: v}) for v in (low, (low + high) / 2, high)]
    speeds = [abs(free_speed(m, r) or 0.0) for m in ends for r in m.rotors]
    natural = [f for m in ends for f in natural_frequencies(m).values() if f > 0]
    fastest = max([*speeds, *natural, *(m.shaking_frequency or 0.0 for m in ends)]) or 1.0
    turn = 2 * math.pi / max(min([w for w in [*speeds, *natural] if w > 0], default=fastest), 0.02 * fastest)
    answers = [max(turn, _answer(m)) for m in ends]
    answer, warnings, unit = max(answers), tuple[str, ...](), rate_unit(machine, swept)
    duration, most = ANSWERS * answer, MOST_TURNS * 2 * math.pi / fastest
    if given is not None:
        longest, shortest = MOST_TURNS_ASKED * 2 * math.pi / fastest, min(_LEAST * min(answers), most)
        lowest, highest = (float(f"{(high - low) / time:.2g}") for time in (longest, shortest))
        if not lowest <= given <= highest:
            raise InputError(
                "study.rate", given,
                f"must be a rate from {lowest:g} to {highest:g} {unit}: a lower one takes more than "
                f"{MOST_TURNS_ASKED} turns a ramp, a higher one less than a tenth of the time in which the machine answers",
            )  # fmt: skip
        duration = (high - low) / given
    elif duration > most:
        duration, time = most, f"{answer:.3g} {machine.units.time}".strip()
        warnings = (
            f"the machine answers slowly (in {time}): the default rate is limited to {MOST_TURNS} turns a ramp; "
            "give a lower rate to be sure that the sweep is quasi-static",
        )
    samples = max(8, min(SAMPLES, int(duration / (_TURNS_A_SAMPLE * turn))))
    driven, rate = max(speeds, default=0.0), (high - low) / duration
    return Pace(answer, fastest, turn, driven, rate, unit, samples, duration / samples, warnings)


def rate_unit(machine: Machine, path: str) -> str:
    """What stands behind the number of a rate of a parameter: ``rad/s per s``."""
    unit, time = machine.parameters[path].unit, machine.units.time
    return f"{unit} {f'per {time}' if time else 'a unit of time'}".strip()


def _answer(machine: Machine) -> float:
    """The time constant of the slowest decay of the carrier's free vibration and of the drives' speed; 0 if none decays."""
    poles = Vibration.of(machine).poles
    decays = -poles.real[-poles.real > 1e-9 * np.abs(poles).max(initial=0.0)]
    times = [0.0, *(1 / decays)]
    for rotor in machine.rotors:
        speed = free_speed(machine, rotor)
        if rotor.coordinate.prescribed is None and speed is not None:
            torque, h = net_torque(machine, rotor), 1e-3 * (abs(speed) or 1.0)
            slope = (torque(speed - h) - torque(speed + h)) / (2 * h)
            if slope > 0:
                times.append(_inertia(machine, rotor) / slope)
    return float(max(times))


def _inertia(machine: Machine, rotor: RotatingBody) -> float:
    """The inertia of a rotor with all bodies that turn with it."""
    at = dict.fromkeys((s for c in machine.coordinates for s in (c.velocity, c.position)), sp.S.Zero)
    at |= {b.coordinate.velocity: sp.S.One for b in machine.group(rotor)}
    return 2 * float(sp.Add(*(e.kinetic for e in machine.energies)).xreplace(at).xreplace(machine.numbers))
