"""Two saddle-nodes at one value of a parameter, over two further ones: where the curves of their folds cross.

f(x, p) = f(z, p) = 0, det f_x(x, p) = det f_x(z, p) = 0 with n states and three parameters p: 2 n + 2 equations, a curve.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.errors import RunError, WuchtError
from wucht.numerics.continuation.curve import Curve, Steps, Walk
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.problem import CurvePoint, Functions

_STEP = 6e-6  # of central differences, in units of scale: the cube root of rounding
_CORRECTIONS, _ACCURATE = 40, 1e-10
_MET = 1e-7  # of what changes of the size of scale make of the conditions: so small they are where they are met
_STEPS = Steps(first=0.01, most=0.1, turn=0.1)


@dataclass(frozen=True, eq=False)
class FoldPairs:
    """Of equations with three varied parameters, or two where only ``near`` is asked for. bounds: (low, high) of each."""

    equations: Equations
    bounds: tuple[tuple[float, float], ...]

    def __post_init__(self) -> None:
        if len(self.equations.parameters) not in (2, 3):
            raise WuchtError("two folds coincide at points of two parameters, or on curves in three of them", code="count")

    def near(self, first: np.ndarray, second: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """x, z and p (2 n + m,) nearest to states and parameters, by Gauss and Newton's method. Raises ``RunError``."""
        u = np.concatenate([first, second, parameters])
        for _ in range(_CORRECTIONS):
            off, jacobian = self._residual(u)
            slopes = jacobian * self._scale
            change = np.linalg.pinv(slopes) @ off
            u = u - change * self._scale
            # Where no parameter parts both folds' values, the best compromise does not change either.
            if np.linalg.norm(change) < _ACCURATE and np.linalg.norm(off) < _MET * np.linalg.norm(slopes):
                return self._apart(u)
        raise RunError("no point was found at which both folds coincide")

    def walk(self, u: np.ndarray, way: int = 1) -> Walk[tuple[Curve, CurvePoint]]:
        """The points after one, for growing values of the third parameter (way 1) or the other way."""
        n, curve = self.equations.n, self._curve
        along = np.linalg.svd(self._residual(u)[1] * self._scale)[2][-1]
        grows = along[2 * n + 1 :][np.abs(along[2 * n + 1 :]).argmax()]
        return curve.follow(curve.start(u, along * self._scale * way * np.sign(grows)))

    @property
    def _curve(self) -> Curve:
        n = self.equations.n
        return Curve(Functions(self._residual, self._scale), {2 * n + k: b for k, b in enumerate(self.bounds)}, _STEPS)

    @property
    def _scale(self) -> np.ndarray:
        n, scale = self.equations.n, self.equations.scale
        return np.concatenate([scale[:n], scale])

    def _residual(self, u: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        step = _STEP * self._scale
        columns = [(self._conditions(u + h) - self._conditions(u - h)) / (2 * _STEP) for h in np.diag(step)]
        return self._conditions(u), np.array(columns).T / self._scale

    def _conditions(self, u: np.ndarray) -> np.ndarray:
        m = len(self.equations.parameters)
        return np.concatenate([self._fold(x, u[-m:]) for x in u[:-m].reshape(2, -1)])

    def _fold(self, x: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        n, scale = self.equations.n, self.equations.scale
        f, f_u = self.equations.values(np.concatenate([x, parameters]))
        matrix = f_u[:, :n] * (scale[:n] / scale[:n, None])
        size = np.linalg.norm(matrix)
        # A homogeneous function of degree one of the matrix: as large as f is.
        return np.append(f / scale[:n], np.linalg.det(matrix / size) * size if size else 0.0)

    def _apart(self, u: np.ndarray) -> np.ndarray:
        n, scale = self.equations.n, self.equations.scale[: self.equations.n]
        if np.linalg.norm((u[:n] - u[n : 2 * n]) / scale) < 1e-6:
            raise RunError("both folds are one")
        return u
