"""The standard motion laws: the rise of a follower from rest to rest, normalised to 1 over an arc of 1.

The polynomials and the laws of sine, constant and cosine acceleration: R. L. Norton, "Cam Design and Manufacturing Handbook",
2nd ed., Industrial Press 2009, chapters 3 and 4; H. A. Rothbart (ed.), "Cam Design Handbook", McGraw-Hill 2004, chapter 3.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wucht.earlier_names import provide_earlier_names
from wucht.errors import InputError, nearest
from wucht.schema import LARGEST

Points = Sequence[tuple[float, float]] | np.ndarray
_Phase = tuple[float, float, float, float, float]  # of the acceleration: length, constant, cosine, sine, angular frequency
ROUNDING = 1e-12  # of the arc: nearer to a knot is at the knot
_LEAST_JUMP = 1e-6  # of the largest derivative: a smaller jump within a law is the rounding of its pieces


@dataclass(frozen=True, eq=False)
class StandardLaw:
    """s(x), 0 <= x <= 1, with s(0) = 0 and s(1) = 1, in pieces; all numbers are without unit.

    In the piece i, u = x - knots[i], it is s = sum over k of polynomials[i, k] u^k + cosine[i] cos(frequency[i] u)
    + sine[i] sin(frequency[i] u). Where a piece has a wave, its polynomial is of the first degree.

    Parameters
    ----------
    knots : numpy.ndarray, (n + 1,)
        From 0 to 1.
    polynomials : numpy.ndarray, (n, degree + 1)
        The constant first.
    cosine, sine, frequency : numpy.ndarray, (n,)
    """

    knots: np.ndarray
    polynomials: np.ndarray
    cosine: np.ndarray
    sine: np.ndarray
    frequency: np.ndarray

    def __call__(self, x: np.ndarray | float, order: int = 0, side: Literal["left", "right"] = "right") -> np.ndarray:
        """The derivative of an order by x, at x of any shape; where it jumps, that on one side (at 0 and 1: inside)."""
        at = np.asarray(x, float)
        inner = self.knots[1:-1] + (ROUNDING if side == "left" else -ROUNDING)
        i = np.searchsorted(inner, at, side=side)
        u, c = at - self.knots[i], _derivative(self.polynomials, order)
        value = np.zeros(at.shape)
        for k in reversed(range(c.shape[1])):
            value = value * u + c[i, k]
        if self.frequency.any():
            cosine, sine = self._wave(order)
            value = value + cosine[i] * np.cos(self.frequency[i] * u) + sine[i] * np.sin(self.frequency[i] * u)
        return np.asarray(value)

    def _wave(self, order: int) -> np.ndarray:
        """The coefficients of cosine and sine (2, n) in the derivative of an order."""
        a, b = self.cosine, self.sine
        return np.asarray([(a, b), (b, -a), (-a, -b), (-b, a)][order % 4] * self.frequency**order)

    def largest(self, order: int) -> float:
        """The largest magnitude of the derivative of an order of at least 1: exactly, where the next one vanishes.

        A jump of the derivative below, at a knot or where the law begins and ends, does not count.
        """
        return max(
            float(np.abs(self._piece_values(i, self._stationary(i, order), order)).max()) for i in range(len(self.polynomials))
        )

    def _piece_values(self, i: int, u: np.ndarray, order: int) -> np.ndarray:
        """A derivative at places u (m,) of one piece, at its ends as from inside."""
        cosine, sine = (c[i] for c in self._wave(order))
        polynomial = np.polyval(_derivative(self.polynomials, order)[i, ::-1], u)
        return np.asarray(polynomial + cosine * np.cos(self.frequency[i] * u) + sine * np.sin(self.frequency[i] * u))

    def _stationary(self, i: int, order: int) -> np.ndarray:
        """Places in one piece, among them all where a derivative may be largest: the ends, and the zeros of the next one."""
        length = self.knots[i + 1] - self.knots[i]
        if self.frequency[i]:
            cosine, sine = (c[i] for c in self._wave(order + 1))
            first = math.atan2(-cosine, sine) % math.pi
            zeros = np.arange(first, self.frequency[i] * length, math.pi) / self.frequency[i]
        else:
            # Complex roots are kept: a double one may come out as a pair, and a further candidate does no harm.
            zeros = np.clip(np.roots(_derivative(self.polynomials, order + 1)[i, ::-1]).real, 0.0, length)
        return np.array([0.0, *zeros, length])

    def inner_jumps(self, order: int) -> np.ndarray:
        """Return the places x (n,) within the arc at which the derivative of an order jumps."""
        inner = self.knots[1:-1]
        jumps = np.abs(self(inner, order) - self(inner, order, side="left"))
        return np.asarray(inner[jumps > _LEAST_JUMP * self.largest(order)])

    @property
    def Cv(self) -> float:
        """The largest |s'|: times stroke and speed over the length of the arc, the largest velocity."""
        return self.largest(1)

    @property
    def Ca(self) -> float:
        """The largest |s''|."""
        return self.largest(2)

    @property
    def Cj(self) -> float:
        """The largest |s'''| between jumps of the acceleration."""
        return self.largest(3)


def _derivative(polynomials: np.ndarray, order: int) -> np.ndarray:
    """The coefficients (n, d + 1 - order) of a derivative, of polynomials (n, d + 1) with the constant first."""
    for _ in range(order):
        polynomials = polynomials[:, 1:] * np.arange(1, polynomials.shape[1])
    return polynomials


def polynomial_law(knots: np.ndarray, polynomials: np.ndarray) -> StandardLaw:
    """Return the law of polynomials in pieces.

    Parameters
    ----------
    knots : numpy.ndarray, (n + 1,)
        From 0 to 1.
    polynomials : numpy.ndarray, (n, degree + 1)
        Of the piece behind each knot, the constant first.

    Returns
    -------
    StandardLaw
    """
    zeros = np.zeros(len(polynomials))
    return StandardLaw(knots, polynomials, zeros, zeros, zeros)


def _integrated_law(phases: Sequence[_Phase]) -> StandardLaw:
    """The law whose acceleration is, in one phase after the other, a constant, or cosine cos(w u) + sine sin(w u)."""
    knots, rows, x, s, v = [0.0], [], 0.0, 0.0, 0.0
    for length, constant, cosine, sine, w in phases:
        a, b = (-cosine / w**2, -sine / w**2) if w else (0.0, 0.0)
        s, v = s - a, v - w * b
        rows.append([s, v, constant / 2, a, b, w])
        wave = a * math.cos(w * length) + b * math.sin(w * length)
        slope = w * (b * math.cos(w * length) - a * math.sin(w * length))
        s, v = s + length * (v + length * constant / 2) + wave, v + length * constant + slope
        x += length
        knots.append(x)
    table = np.array(rows)
    return StandardLaw(np.array(knots), table[:, :3], *table[:, 3:].T)


def sine_constant_cosine(b: float, c: float, d: float) -> StandardLaw:
    """The acceleration rises as a sine, is constant, passes through zero as a cosine, and so on in mirror image.

    The shares of the arc: b/2 for the rise, c/2 for the constant, d for the cosine; b + c + d = 1. Norton's SCCA family
    (chapter 3), with his factor Ca: (b, c, d) = (1/4, 1/2, 1/4) is the modified trapezoid, (1/4, 0, 3/4) the modified sine,
    (1/2, 0, 1/2) the inclined sine, (0, 0, 1) the simple harmonic motion, (0, 1, 0) the parabolic one.
    """
    pi = math.pi
    Ca = 4 * pi**2 / ((pi**2 - 8) * (b**2 - d**2) - 2 * pi * (pi - 2) * b + pi**2)
    rise: list[_Phase] = [(b / 2, 0.0, 0.0, Ca, pi / b)] if b else []
    fade: list[_Phase] = [(b / 2, 0.0, -Ca, 0.0, pi / b)] if b else []
    before: list[_Phase] = [(c / 2, Ca, 0.0, 0.0, 0.0)] if c else []
    after: list[_Phase] = [(c / 2, -Ca, 0.0, 0.0, 0.0)] if c else []
    through: list[_Phase] = [(d, 0.0, Ca, 0.0, pi / d)] if d else []
    return _integrated_law([*rise, *before, *through, *after, *fade])


_WHOLE = np.array([0.0, 1.0])
STANDARD_LAWS = {
    "3-4-5": polynomial_law(_WHOLE, np.array([[0.0, 0.0, 0.0, 10.0, -15.0, 6.0]])),
    "4-5-6-7": polynomial_law(_WHOLE, np.array([[0.0, 0.0, 0.0, 0.0, 35.0, -84.0, 70.0, -20.0]])),
    "inclined-sine": sine_constant_cosine(1 / 2, 0, 1 / 2),
    "modified-sine": sine_constant_cosine(1 / 4, 0, 3 / 4),
    "modified-trapezoid": sine_constant_cosine(1 / 4, 1 / 2, 1 / 4),
    "harmonic": sine_constant_cosine(0, 0, 1),
    "parabolic": sine_constant_cosine(0, 1, 0),
}
SPLINES = {"cubic-spline": 3, "quintic-spline": 5}  # degree


def standard_law(kind: str, points: Points = ()) -> StandardLaw:
    """Return the law of a rise by its name, or a spline through points.

    Parameters
    ----------
    kind : str
        ``"3-4-5"``, ``"4-5-6-7"``, ``"inclined-sine"``, ``"modified-sine"``, ``"modified-trapezoid"``, ``"harmonic"``,
        ``"parabolic"``, ``"cubic-spline"`` or ``"quintic-spline"``.
    points : sequence of (float, float) or numpy.ndarray, (m, 2), optional
        Of a spline: share of the arc, share of the stroke.

    Returns
    -------
    StandardLaw
        s(x), 0 <= x <= 1, with its largest derivatives ``Cv``, ``Ca`` and ``Cj``.

    Raises
    ------
    InputError
        For an unknown kind (law.kind), points of another law, or points that do not rise along the arc (law.points).

    Examples
    --------
    >>> from wucht.cams import standard_law
    >>> law = standard_law("3-4-5")
    >>> print(f"{law.Cv:.4f} {law.Ca:.4f} {law.Cj:.4f}")
    1.8750 5.7735 60.0000
    """
    if kind in SPLINES:
        return spline(points, SPLINES[kind])
    if kind not in STANDARD_LAWS:
        raise InputError("law.kind", kind, f"unknown kind; {nearest(kind, [*STANDARD_LAWS, *SPLINES])}")
    if len(points):
        raise InputError("law.points", None, f"only a spline goes through points, not the law {kind!r}")
    return STANDARD_LAWS[kind]


def spline(points: Points = (), degree: int = 5) -> StandardLaw:
    """The spline of degree 3 or 5 through points (m, 2) of the rise: share of the arc, share of the stroke.

    The ends (0, 0) and (1, 1) may be among them or not. There the velocity is zero, with degree 5 the acceleration too; the
    cubic's acceleration jumps there. Raises ``InputError`` (law.points).
    """
    from scipy.interpolate import PPoly, make_interp_spline

    x, s = _with_ends(points)
    at_rest = [(1, 0.0), (2, 0.0)][: degree // 2]
    pieces = PPoly.from_spline(make_interp_spline(x, s, k=degree, bc_type=(at_rest, at_rest)))
    real = np.diff(pieces.x) > 0  # knots are repeated at the ends
    return polynomial_law(x, pieces.c[::-1, real].T)


def _with_ends(points: Points) -> tuple[np.ndarray, np.ndarray]:
    """The shares (m,) of arc and stroke, from (0, 0) to (1, 1)."""
    shares = np.asarray(points, float) if len(points) else np.empty((0, 2))
    if shares.ndim != 2 or shares.shape[1] != 2 or not (np.abs(shares) <= LARGEST).all():
        requirement = f"must be pairs of finite numbers: share of the arc, share of the stroke, of at most {LARGEST:g}"
        raise InputError("law.points", shares.tolist(), requirement)
    has_first, has_last = len(shares) and shares[0, 0] == 0, len(shares) and shares[-1, 0] == 1
    all_points = np.concatenate([*([] if has_first else [[[0.0, 0.0]]]), shares, *([] if has_last else [[[1.0, 1.0]]])])
    if (all_points[0, 1], all_points[-1, 1]) != (0, 1):
        raise InputError("law.points", shares.tolist(), "the rise must begin at [0, 0] and end at [1, 1]")
    if not (np.diff(all_points[:, 0]) > 0).all():
        raise InputError("law.points", shares.tolist(), "the shares of the arc must increase, from 0 to 1")
    return all_points[:, 0], all_points[:, 1]


provide_earlier_names(__name__)
