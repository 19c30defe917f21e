"""The stable and unstable manifolds of saddles of planar Systems, also where states are angles.

On the local manifold of an eigenvalue l with eigenvector v the motion is s' = l s + O(s^2) with

    x(s) = x_0 + v s + w s^2 + O(s^3),    (J - 2 l I) w = -(1/2) d^2f(v, v)

(Y. A. Kuznetsov, "Elements of Applied Bifurcation Theory", 4th ed., Springer 2023, section 10.3.5). The error of third order
follows from the defect of x(s) in the equation dx/ds l s = f(x(s)): the manifold is followed from where that is small enough.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.errors import WuchtError
from wucht.numerics.phase_plane.fixed_points import SADDLE, FixedPoint
from wucht.numerics.phase_plane.phase_curves import PhaseCurve, Portrait
from wucht.numerics.phase_plane.plane import Plane

_ACCURATE = 1e-11  # of the window: the error at the start of a manifold
_LONGEST, _SHORTEST = 1e-2, 1e-5  # of the window: distances from the saddle at which it starts


@dataclass(frozen=True, eq=False)
class LocalManifold:
    """A one-dimensional manifold near its saddle, to second order. Lengths in units of the window.

    Attributes
    ----------
    plane : Plane
    saddle : ndarray, (2,)
    stable : bool
    rate : float
        l, the eigenvalue.
    direction, bend : ndarray, (2,)
        v and w, v of length 1.
    """

    plane: Plane
    saddle: np.ndarray
    stable: bool
    rate: float
    direction: np.ndarray
    bend: np.ndarray

    @classmethod
    def of(cls, plane: Plane, saddle: np.ndarray, stable: bool) -> LocalManifold:
        """Compute the local manifold of a saddle. Raises ``WuchtError`` where the state is no saddle."""
        state, scale = np.asarray(saddle, float), plane.scale
        matrix = plane.jacobian(state[:, None])[..., 0] * scale[None, :] / scale[:, None]
        values, vectors = np.linalg.eig(matrix)
        if np.iscomplexobj(values) or not values.min() < 0 < values.max():
            raise WuchtError(
                f"the state {state} is not a saddle: its eigenvalues are {values[0]:.6g} and {values[1]:.6g}", code="no-saddle"
            )
        k = int(values.argmin() if stable else values.argmax())
        rate, v = float(values[k]), vectors[:, k] / np.hypot(*vectors[:, k])
        v = v * (1.0 if v[np.abs(v).argmax()] > 0 else -1.0)
        second = plane.curvature(state, v * scale) / scale
        return cls(plane, state, stable, rate, v, np.linalg.solve(matrix - 2 * rate * np.eye(2), -second / 2))

    def state_at(self, s: float) -> np.ndarray:
        """Return the state (2,) at a distance s from the saddle, on either side."""
        return np.asarray(self.saddle + self.plane.scale * (self.direction * s + self.bend * s**2))

    def error(self, s: float) -> float:
        """Estimate the distance of that state from the manifold: the defect of the equation, corrected to leading order."""
        scale = self.plane.scale
        f = self.plane.rates(self.state_at(s)[:, None])[:, 0] / scale
        defect = f - self.rate * s * (self.direction + 2 * self.bend * s)
        matrix = self.plane.jacobian(self.saddle[:, None])[..., 0] * scale[None, :] / scale[:, None]
        correction, v = np.linalg.solve(matrix - 3 * self.rate * np.eye(2), -defect), self.direction
        return abs(float(correction[0] * v[1] - correction[1] * v[0]))

    def start(self, side: int) -> float:
        """Return the distance (with the sign of the side) from which the manifold is followed, where it is accurate enough."""
        s = side * _LONGEST
        while self.error(s) > _ACCURATE and abs(s) > _SHORTEST:
            s /= 2
        return s


@dataclass(frozen=True, eq=False)
class Manifold:
    """One side of a manifold of a saddle.

    Attributes
    ----------
    saddle : int
        Index among the fixed points.
    stable : bool
        True if its curve goes to the saddle (it was followed backwards), false if it comes from it.
    side : int
        +1 or -1 along the eigenvector.
    error : float
        At its start, in units of the window.
    curve : PhaseCurve
        From the saddle on, its first state.
    """

    saddle: int
    stable: bool
    side: int
    error: float
    curve: PhaseCurve


def manifold(portrait: Portrait, saddle: int, stable: bool, side: int) -> Manifold:
    """Follow one of the four half manifolds of a saddle of a portrait.

    Parameters
    ----------
    portrait : Portrait
        With the fixed points, at one of which the curve may end; a closed curve at which it ends is added.
    saddle : int
        Index among the fixed points.
    stable : bool
    side : {1, -1}

    Raises
    ------
    WuchtError
        Where that fixed point is no saddle, or the System not planar.
    """
    point: FixedPoint = portrait.points[saddle]
    if point.kind != SADDLE:
        raise WuchtError(f"this fixed point is a {point.kind}: only a saddle has two manifolds", code="no-saddle")
    local = LocalManifold.of(portrait.plane, point.state, stable)
    s = local.start(side)
    phase_curve = portrait.follow(local.state_at(s), not stable)
    curve = PhaseCurve(
        np.concatenate([point.state[:, None], phase_curve.states], axis=1),
        np.concatenate([[np.nan], phase_curve.time]),  # it takes for ever from the saddle to there
        phase_curve.forwards, phase_curve.end, phase_curve.index, phase_curve.gap, phase_curve.length + abs(s),
    )  # fmt: skip
    return Manifold(saddle, stable, side, local.error(s), curve)


def manifolds(portrait: Portrait) -> tuple[Manifold, ...]:
    """Follow all half manifolds of all saddles of a portrait: four of each, the unstable ones first."""
    saddles = [k for k, p in enumerate(portrait.points) if p.kind == SADDLE]
    return tuple(manifold(portrait, k, stable, side) for k in saddles for stable in (False, True) for side in (1, -1))
