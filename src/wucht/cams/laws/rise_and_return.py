"""The motion over a turn of the cam: rise, dwell at the top, return, dwell at the bottom."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.cams.laws.standard_laws import StandardLaw
from wucht.errors import InputError

Arc = tuple[float, float]
_TURN = 2 * math.pi
_ROUNDING = 1e-12  # rad: angles nearer to the border of an arc stand on it
_SHORTEST = 1e-6  # rad


@dataclass(frozen=True, eq=False)
class RiseAndReturn:
    """From 0 up to ``stroke`` over the arc ``rise`` of the cam angle, and back over the arc ``back``; between them it rests.

    law: how it rises; it returns by the same law run backwards, psi = stroke s(1 - x). stroke: in the unit of the motion,
    negative for a motion downwards. rise, back: begin and end in rad, in the sense of the cam angle. An end below its begin is
    one turn later: (5.8, 0.5) passes through 2 pi. Where ``back`` is not given it is the mirror image of the rise about pi (and
    so about 0), and psi(-phi) = psi(phi).

    Raises ``InputError`` (law.stroke, law.rise, law.return): no stroke, an arc that is none, or a turn or longer, arcs
    that overlap. They may touch.
    """

    law: StandardLaw
    stroke: float
    rise: Arc
    back: Arc | None = None

    def __post_init__(self) -> None:
        if not math.isfinite(self.stroke) or self.stroke == 0:
            raise InputError("law.stroke", self.stroke, "must be a finite number other than 0")
        _check_arc("law.rise", self.rise)
        if self.back is not None:
            _check_arc("law.return", self.back)
        top, returns, bottom = self._borders
        if top <= returns < bottom:
            return
        if self.back is None:
            allowed = (
                f"its mirror image about 180 deg, {_shown(self._back)}, would overlap it: give law.return, or another rise"
            )
            raise InputError("law.rise", _shown(self.rise), allowed)
        raise InputError("law.return", _shown(self.back), f"must not overlap the rise, {_shown(self.rise)}")

    @property
    def _back(self) -> Arc:
        return (_TURN - self.rise[1], _TURN - self.rise[0]) if self.back is None else self.back

    @cached_property
    def _borders(self) -> tuple[float, float, float]:
        """From the begin of the rise on: where the top is reached, where the return begins, and where the bottom is reached."""
        begin = self.rise[0]
        top, returns, bottom = (float(_after(begin, angle)) for angle in (self.rise[1], *self._back))
        return top, top if abs(returns - top) < _ROUNDING else returns, bottom if bottom > _ROUNDING else _TURN

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles of any shape; where it jumps, of what begins there."""
        t, (top, returns, bottom) = _after(self.rise[0], phi), self._borders
        piece = np.searchsorted(np.array(self._borders) - _ROUNDING, t, side="right")
        up = self.law(np.clip(t / top, 0, 1), order) / top**order
        length = bottom - returns
        down = self.law(np.clip((bottom - t) / length, 0, 1), order, side="left") / (-length) ** order
        resting = float(order == 0)
        return np.asarray(self.stroke * np.choose(piece, [up, resting, down, 0.0]))

    def largest(self, order: int) -> float:
        """The largest magnitude of the derivative by phi of an order from 1 to 3, exactly."""
        return abs(self.stroke) * self.law.largest(order) / self._shorter**order

    @property
    def jump(self) -> float:
        """By how much the acceleration jumps, at most: where the rise or the return begins or ends."""
        ends = np.abs(self.law(np.array([0.0, 1.0]), 2)).max()
        return float(abs(self.stroke) * ends / self._shorter**2) if ends > _ROUNDING * self.law.Ca else 0.0

    @property
    def _shorter(self) -> float:
        """Of rise and return, in rad."""
        top, returns, bottom = self._borders
        return min(top, bottom - returns)


def _after(begin: float, angle: np.ndarray | float) -> np.ndarray:
    """How far an angle lies after another, in [0, 2 pi); 0 also where it is before it by no more than rounding."""
    t = np.mod(np.asarray(angle, float) - begin, _TURN)
    return np.asarray(np.where(t > _TURN - _ROUNDING, 0.0, t))


def _check_arc(key: str, arc: Arc) -> None:
    begin, end = arc
    if not abs(end - begin) > _SHORTEST:  # nor where they are no numbers
        raise InputError(key, _shown(arc), "must be two different angles, begin and end")
    if abs(end - begin) > _TURN - _SHORTEST:
        raise InputError(key, _shown(arc), "must be shorter than a turn of the cam")


def _shown(arc: Arc) -> str:
    return f"{math.degrees(arc[0]):.6g} ... {math.degrees(arc[1]):.6g} deg"
