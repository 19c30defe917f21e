"""A motion law given as a table of points: the periodic spline through them."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np

from wucht.errors import InputError
from wucht.schema import LARGEST

_TURN = 2 * math.pi
_REPEAT_TOLERANCE = 1e-5  # rad: a last angle so near to a turn after the first is the first again, as tables are rounded
_WIDE, _STEEP = 5.0, 10.0  # times the widest spacing and the steepest change between points: over the end of a turn no more
_CLOSURE = 1e-6  # of the range of the output: permitted difference there


@dataclass(frozen=True, eq=False)
class TableLaw:
    """The motion through points (M,): cam angles in rad that increase, over no more than a turn, evenly spaced or not.

    The first point may stand there again at the end, a turn later. degree: 5, and the derivatives up to the fourth are
    continuous, or 3, and those up to the second are: the third jumps at the points. A table of rounded values needs few
    points rather than many: the derivative of order p of an error is larger by about (3/spacing)^p.

    Raises ``InputError`` (law.file, law.degree): another degree; not as many outputs as angles; values that are no numbers;
    angles that do not increase or span more than a turn; a last point, a turn after the first, that differs from it; no more
    points than the degree, without a repeated one; points that leave a part of the turn open, or do not meet at its end.
    """

    angles: np.ndarray
    outputs: np.ndarray
    degree: int = 5

    def __post_init__(self) -> None:
        if self.degree not in (3, 5):
            raise InputError("law.degree", self.degree, "must be 5 or 3")
        phi, psi = np.asarray(self.angles, float), np.asarray(self.outputs, float)
        if phi.shape != psi.shape or phi.ndim != 1:
            raise InputError(
                "law.file", None, f"needs as many outputs as cam angles, not {psi.size} and {phi.size}", code="count"
            )
        bad = np.flatnonzero(~(np.isfinite(phi) & np.isfinite(psi)))
        if len(bad):
            raise InputError("law.file", None, f"point {bad[0] + 1} is not made of two finite numbers", code="not-finite")
        beyond = np.flatnonzero(np.maximum(np.abs(phi), np.abs(psi)) > LARGEST)
        if len(beyond):
            raise InputError(
                "law.file", None, f"point {beyond[0] + 1} has a number above {LARGEST:g} in magnitude", code="limits"
            )
        falls = np.flatnonzero(np.diff(phi) <= 0)
        if len(falls):
            at, after = np.degrees(phi[[falls[0], falls[0] + 1]])
            raise InputError(
                "law.file", f"{after:.6g} deg after {at:.6g} deg", "the cam angles must increase", code="not-increasing"
            )
        if len(phi) and phi[-1] - phi[0] > _TURN + _REPEAT_TOLERANCE:
            raise InputError(
                "law.file",
                f"{math.degrees(phi[-1] - phi[0]):.9g} deg",
                "the cam angles must span at most 360 deg",
                code="too-long",
            )
        if self._is_closed and abs(psi[-1] - psi[0]) > _CLOSURE * np.ptp(psi):
            requirement = f"the last point, a turn after the first, must have the same output, {psi[0]:.9g}"
            raise InputError("law.file", float(psi[-1]), requirement, code="not-closed")
        if (count := len(phi) - self._is_closed) <= self.degree:
            raise InputError(
                "law.file",
                f"{count} points",
                f"degree {self.degree} needs at least {self.degree + 1} different points",
                code="too-few",
            )
        if not self._is_closed:
            _check_whole_turn(phi, psi)

    @property
    def _is_closed(self) -> bool:
        """True if the last point repeats the first."""
        return len(self.angles) > 1 and bool(self.angles[-1] - self.angles[0] > _TURN - _REPEAT_TOLERANCE)

    @cached_property
    def _spline(self) -> Any:
        from scipy.interpolate import make_interp_spline

        end = len(self.angles) - self._is_closed
        phi, psi = np.asarray(self.angles, float)[:end], np.asarray(self.outputs, float)[:end]
        return make_interp_spline(np.append(phi, phi[0] + _TURN), np.append(psi, psi[0]), k=self.degree, bc_type="periodic")

    def __call__(self, phi: np.ndarray | float, order: int = 0) -> np.ndarray:
        """The derivative by phi of an order from 0 to 3, at angles of any shape; where it jumps, of what begins there."""
        return np.asarray(self._spline(np.asarray(phi, float), nu=order))


def _check_whole_turn(phi: np.ndarray, psi: np.ndarray) -> None:
    """Raise ``InputError`` where the points, the first not repeated at the end, do not cover a whole turn."""
    gap, jump, spacing = _TURN - (phi[-1] - phi[0]), abs(psi[0] - psi[-1]), np.diff(phi)
    open_at = f"from {math.degrees(phi[-1]):.6g} to {math.degrees(phi[0] + _TURN):.6g} deg"
    if gap > _WIDE * spacing.max():
        raise InputError(
            "law.file", None, f"the points must cover a whole turn of the cam: there are none {open_at}", code="gap"
        )
    if jump / gap > _STEEP * np.abs(np.diff(psi) / spacing).max():
        raise InputError(
            "law.file",
            None,
            f"the motion must close after a turn: {open_at} it jumps back; give points there",
            code="not-closed",
        )
