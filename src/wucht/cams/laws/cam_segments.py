"""Motions over a turn of the cam in segments: each moves by a standard law over its arc, or rests."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.cams.laws.standard_laws import ROUNDING, StandardLaw
from wucht.errors import InputError

Arc = tuple[float, float]
_TURN = 2 * math.pi
_SHORTEST = 1e-6  # rad
_LEAST_JUMP = 1e-9  # of the largest derivative: a smaller jump between two segments is rounding


@dataclass(frozen=True, eq=False)
class Segment:
    """Motion from a height on by a stroke over an arc, psi = height + stroke s(x); begin, end: from the motion's own begin.

    law: None where it rests. is_reversed: it moves back, psi = height + stroke s(1 - x).
    """

    law: StandardLaw | None
    begin: float
    end: float
    height: float
    stroke: float = 0.0
    is_reversed: bool = False

    @property
    def length(self) -> float:
        """Length of its arc in rad."""
        return self.end - self.begin

    def __call__(self, t: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative of an order at angles t from the motion's begin; outside its arc that at its nearer end."""
        at, height = np.asarray(t, float), self.height if order == 0 else 0.0
        if self.law is None:
            return np.full(at.shape, height)
        if self.is_reversed:
            share = self.law(np.clip((self.end - at) / self.length, 0, 1), order, side="left") / (-self.length) ** order
        else:
            share = self.law(np.clip((at - self.begin) / self.length, 0, 1), order) / self.length**order
        return np.asarray(height + self.stroke * share)

    def largest(self, order: int) -> float:
        """The largest magnitude of the derivative of an order from 1 to 3, exactly."""
        return 0.0 if self.law is None else abs(self.stroke) * self.law.largest(order) / self.length**order

    def inner_jumps(self, order: int) -> dict[float, float]:
        """Return by how much the derivative of an order jumps within its arc, by the angle from the motion's begin."""
        if self.law is None:
            return {}
        x = self.law.inner_jumps(order)
        steps = self.stroke * (self.law(x, order) - self.law(x, order, side="left")) / self.length**order
        return dict(zip((self.begin + self.length * x).tolist(), np.abs(steps).tolist(), strict=True))


@dataclass(frozen=True, eq=False)
class SegmentedMotion:
    """Motion over a turn: segments that follow each other from the cam angle ``begin`` on. The last one ends a turn later."""

    begin: float
    segments: Sequence[Segment]

    @cached_property
    def _ends(self) -> np.ndarray:
        return np.array([segment.end for segment in self.segments[:-1]])

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles of any shape; where it jumps, of what begins there."""
        t = angle_after(self.begin, phi)
        index = np.searchsorted(self._ends - ROUNDING, t, side="right")
        value = np.zeros(t.shape)
        for i, segment in enumerate(self.segments):
            value = np.where(index == i, segment(t, order), value)
        return np.asarray(value)

    def largest(self, order: int) -> float:
        """The largest magnitude of the derivative by phi of an order from 1 to 3, exactly."""
        return max(segment.largest(order) for segment in self.segments)

    def jumps(self, order: int) -> dict[float, float]:
        """Return by how much the derivative of an order jumps, by the cam angle in rad: between segments and within them."""
        rounding, steps = _LEAST_JUMP * self.largest(order), dict[float, float]()
        for before, segment in zip([self.segments[-1], *self.segments[:-1]], self.segments, strict=True):
            step = abs(float(segment(segment.begin, order) - before(before.end, order)))
            steps |= {segment.begin: step} if step > rounding else {}
            steps |= segment.inner_jumps(order)
        return {self.begin + t: step for t, step in steps.items()}


@dataclass(frozen=True, eq=False)
class RiseAndReturn:
    """Motion up to a stroke over an arc of the cam angle, and back over another; between them it rests.

    Parameters
    ----------
    law : StandardLaw
        Of the rise; it returns by the same law run backwards, psi = stroke s(1 - x).
    stroke : float
        In the unit of the motion, rad or m; negative for a motion downwards.
    rise : (float, float)
        Begin and end in rad, in the sense of the cam angle. An end below its begin is one turn later: (5.8, 0.5) passes through
        2 pi.
    back : (float, float), optional
        Likewise. Where it is not given it is the mirror image of the rise about pi (and so about 0), and psi(-phi) = psi(phi).

    Raises
    ------
    InputError
        (law.stroke, law.rise, law.return) No stroke, an arc that is none, or a turn or longer, arcs that overlap. They may
        touch.
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
            requirement = (
                f"its mirror image about 180 deg, {_format_arc(self._back)}, would overlap it: give law.return, or another rise"
            )
            raise InputError("law.rise", _format_arc(self.rise), requirement)
        raise InputError("law.return", _format_arc(self.back), f"must not overlap the rise, {_format_arc(self.rise)}")

    @property
    def _back(self) -> Arc:
        return (_TURN - self.rise[1], _TURN - self.rise[0]) if self.back is None else self.back

    @cached_property
    def _borders(self) -> tuple[float, float, float]:
        """Angles from the begin of the rise to the top, to the begin of the return, and to the bottom."""
        begin = self.rise[0]
        top, returns, bottom = (float(angle_after(begin, angle)) for angle in (self.rise[1], *self._back))
        return top, top if abs(returns - top) < ROUNDING else returns, bottom if bottom > ROUNDING else _TURN

    @cached_property
    def _motion(self) -> SegmentedMotion:
        top, returns, bottom = self._borders
        rest_above = Segment(None, top, returns, self.stroke)
        back = Segment(self.law, returns, bottom, 0.0, self.stroke, is_reversed=True)
        rest_below = Segment(None, bottom, _TURN, 0.0)
        return SegmentedMotion(self.rise[0], (Segment(self.law, 0.0, top, 0.0, self.stroke), rest_above, back, rest_below))

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles of any shape; where it jumps, of what begins there."""
        return self._motion(phi, order)

    def largest(self, order: int) -> float:
        """The largest magnitude of the derivative by phi of an order from 1 to 3, exactly."""
        return self._motion.largest(order)

    @property
    def jump(self) -> float:
        """Largest jump of the acceleration: where the rise or the return begins or ends, or within them."""
        ends = np.abs(self.law(np.array([0.0, 1.0]), 2)).max()
        top, returns, bottom = self._borders
        at_ends = float(abs(self.stroke) * ends / min(top, bottom - returns) ** 2) if ends > ROUNDING * self.law.Ca else 0.0
        return max([at_ends, *(step for segment in self._motion.segments for step in segment.inner_jumps(2).values())])


def angle_after(begin: float, angle: np.ndarray | float) -> np.ndarray:
    """Return the angle from one angle on to another, in [0, 2 pi); 0 also where it lies before it by no more than rounding."""
    t = np.mod(np.asarray(angle, float) - begin, _TURN)
    return np.asarray(np.where(t > _TURN - ROUNDING, 0.0, t))


def _check_arc(key: str, arc: Arc) -> None:
    begin, end = arc
    if not abs(end - begin) > _SHORTEST:  # nor where they are no numbers
        raise InputError(key, _format_arc(arc), "must be two different angles, begin and end")
    if abs(end - begin) > _TURN - _SHORTEST:
        raise InputError(key, _format_arc(arc), "must be shorter than a turn of the cam")


def _format_arc(arc: Arc) -> str:
    return f"{math.degrees(arc[0]):.6g} ... {math.degrees(arc[1]):.6g} deg"
