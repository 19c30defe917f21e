"""Certificate of a verdict: like bodies that move together must stay together.

Bodies that are alike can fall together, and move as one on a motion that real bodies leave: a difference of 1e-9 rad that grows
by 0.15 /s is a radian two minutes later. A record does not show it, the equations along the motion do.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.verdicts.judging import LONGER, open_verdict
from wucht.dynamics.verdicts.outcomes import LAG_TOLERANCE, Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.tree import RotatingBody
from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.transverse_growth import transverse_growth
from wucht.system import System

TOGETHER = 0.05  # rad: the difference of bodies that move together
_GROWS = 0.02  # logarithm over the time that is followed: less is what its smooth mean leaves of the periods
_NEARLY, _FURTHER = -0.5, 3.0  # logarithm of a growth that a remaining transient may hide: it is followed so many times longer
_TURNS = 20  # that are followed of a steady motion, at least
_CYCLES, _IRREGULAR_CYCLES = 10, 30  # of a modulation
_NO_PLACE = 1e-5  # rad: bodies that are nearer to each other are not at places of their own
TOLERANCE = 1e-9  # of the integration: a coarser one shows in the differences
_FINAL = (
    Outcome.COMPENSATED, Outcome.PASSED, Outcome.CAPTURED, Outcome.CAPTURED_MODULATED, Outcome.BALANCER_CAPTURED,
    Outcome.ENTRAINED, Outcome.NOT_ENTRAINED, Outcome.SYNCHRONISED, Outcome.NOT_SYNCHRONISED,
)  # fmt: skip
_STEADY = (Outcome.COMPENSATED, Outcome.PASSED, Outcome.CAPTURED, Outcome.ENTRAINED, Outcome.SYNCHRONISED)
_ROUNDING = float(np.finfo(float).eps)


@dataclass(frozen=True)
class LikePair:
    """Two bodies of one kind about the same body. states: the places of their states in a System, in the same order."""

    names: tuple[str, str]
    states: tuple[np.ndarray, np.ndarray]
    angle: int

    def difference(self, states: np.ndarray) -> np.ndarray:
        """The difference of their angles, wrapped, in states (n,) or (n, N)."""
        first, second = (rows[self.angle] for rows in self.states)
        return np.asarray(wrap_to_pi(states[first] - states[second]))


def like_pairs(machine: Machine, state_names: Sequence[str]) -> tuple[LikePair, ...]:
    """Return the pairs of like bodies that can move as one, with their places in a System with these states: of the machine,
    in the turning frame, or averaged."""
    pairs = list[LikePair]()
    for pair in itertools.combinations(machine.bodies, 2):
        first, second = (_states_of(body, state_names) for body in pair)
        angle = next((i for i, quantity in enumerate(first) if quantity in ("angle", "phase")), None)
        if angle is not None and first.keys() == second.keys() and _are_alike(machine, *pair):
            places = np.array(list(first.values())), np.array([second[quantity] for quantity in first])
            pairs.append(LikePair((pair[0].name, pair[1].name), places, angle))
    return tuple(pairs)


def _states_of(body: RotatingBody, state_names: Sequence[str]) -> dict[str, int]:
    """Return the places of a body's states, by quantity."""
    prefix = f"{body.name}."
    return {name.removeprefix(prefix): i for i, name in enumerate(state_names) if name.startswith(prefix)}


def _are_alike(machine: Machine, a: RotatingBody, b: RotatingBody) -> bool:
    """True if two bodies are free, of one kind, turn about the same body in one sense, and can pass each other."""
    is_free = a.coordinate.prescribed_velocity is None and b.coordinate.prescribed_velocity is None
    meet = any({a.name, b.name} <= {body.name for body in track.bodies} for track in machine.tracks)
    return is_free and not meet and a.kind == b.kind and a.about == b.about and sense_of(machine, a) == sense_of(machine, b)


@dataclass(frozen=True)
class MotionEnd:
    """The end of a motion of a System: parameter values (p,), state (n + m,), time. equations: returns its machine code."""

    system: System
    equations: Callable[[], CompiledSystem]
    parameter_values: np.ndarray
    state: np.ndarray
    time: float


def parting_pair(machine: Machine, end: MotionEnd, duration: float, *, is_steady: bool) -> tuple[LikePair, float] | None:
    """Return a pair of like bodies that move together at the end of a motion and leave each other, and the rate at which their
    difference grows; None if there is none. duration: the time over which it is followed, whole periods of the motion;
    is_steady: exactly so."""
    pairs = [p for p in like_pairs(machine, end.system.state_names) if abs(float(p.difference(end.state))) <= TOGETHER]
    clusters = list[set[str]]()
    for pair in pairs:
        if any(cluster & set(pair.names) for cluster in clusters):  # the differences of all bodies of a cluster grow alike
            continue
        compiled_system = end.equations()
        if compiled_system.tolerance > TOLERANCE:
            compiled_system = compile_system(end.system, TOLERANCE)
        growth_on_motion = partial(
            transverse_growth, compiled_system, end.parameter_values, end.state, parts=pair.states, repeats=is_steady
        )
        for time in (duration, _FURTHER * duration):
            span = end.time, end.time + time
            growth = growth_on_motion(span)
            if growth is None or not _NEARLY < growth.logarithm <= _GROWS:
                break
        if growth is None:
            continue
        if growth.logarithm > _GROWS:
            # Bodies that are apart by little may leave the motion as one only as far as that: there they stay.
            apart = None if abs(float(pair.difference(end.state))) <= _NO_PLACE else growth_on_motion(span, as_one=False)
            if apart is None or apart.logarithm > _GROWS:
                return pair, growth.rate
        clusters.append({name for p in pairs if pair.names[0] in p.names for name in p.names})
    return None


def certified_verdict(machine: Machine, verdict: Verdict, end: MotionEnd) -> Verdict:
    """Return a verdict on the motion of a machine; left open where like bodies that are together at its end part."""
    if verdict.outcome not in _FINAL or not verdict.speed:
        return verdict
    is_steady = verdict.outcome in _STEADY and verdict.modulation is None
    parting = parting_pair(machine, end, _followed_time(verdict), is_steady=is_steady)
    return verdict if parting is None else _left_open(machine, verdict, *parting, end)


def steady_time(speed: float) -> float:
    """The time over which differences are followed about a rotor that turns steadily at a speed."""
    return _TURNS * 2 * math.pi / abs(speed)


def _followed_time(verdict: Verdict) -> float:
    """The time over which differences are followed: whole periods of the motion."""
    modulation, turn = verdict.modulation, 2 * math.pi / abs(verdict.speed)
    if modulation is not None:
        return (_CYCLES if modulation.regular else _IRREGULAR_CYCLES) * modulation.period
    slips = [abs(low + high) / 2 for low, high in verdict.evidence.lags if max(abs(low), abs(high)) > LAG_TOLERANCE]
    period = turn / slips[0] if slips and slips[0] > 1 / _TURNS else turn
    return math.ceil(_TURNS * turn / period) * period


def _left_open(machine: Machine, verdict: Verdict, pair: LikePair, rate: float, end: MotionEnd) -> Verdict:
    """Leave a verdict open. The advice is the time after which the difference, as large as it is, will be a radian."""
    (first, second), state, verdict = pair.states, end.state, replace(verdict, growth_rate=rate)
    unit = f"/{machine.units.time}" if machine.units.time else "per unit of time"
    reason = (
        f"{' and '.join(pair.names)} are alike and move together, but any difference between them grows by {rate:.3g} {unit}"
    )
    if (state[first] == state[second]).all():
        return open_verdict(
            machine,
            verdict,
            f"{reason}, and here there is none left "
            "(start them at different angles, or give them masses that differ by a millionth)",
        )
    angles = np.abs(state[[first[pair.angle], second[pair.angle]]])
    size = max(abs(float(pair.difference(state))), _ROUNDING * max(1.0, float(angles.max())))
    return open_verdict(machine, verdict, reason, max(LONGER * end.time, end.time + math.log(1 / size) / rate))
