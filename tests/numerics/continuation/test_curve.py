from __future__ import annotations

from dataclasses import replace

import numpy as np

from wucht.numerics.continuation.curve import Curve, Steps
from wucht.numerics.continuation.equations import FunctionProblem


def test_a_point_is_taken_when_its_convergence_foretells_what_is_left() -> None:
    """Fewer evaluations, and what is left of the equations is below the tolerance all the same."""
    calls = [0]

    def ellipse(unknowns: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        calls[0] += 1
        return np.array([unknowns[0] ** 2 + 4 * unknowns[1] ** 2 - 1]), np.array([[2 * unknowns[0], 8 * unknowns[1]]])

    counts = []
    for foretold in (False, True):
        curve = Curve(
            FunctionProblem(ellipse, np.ones(2)), steps=Steps(most=0.05, tolerance=1e-8, predicts_correction=foretold)
        )
        exact = replace(curve, steps=replace(curve.steps, predicts_correction=False))
        start = exact.start(np.array([1.0, 0.1]), np.array([0.0, 1.0]))
        calls[0] = 0
        walk = curve.follow(start)
        points = [p for _, p in walk]
        counts.append(calls[0] / len(points))
        assert walk.end == "it is closed"
        assert max(abs(ellipse(p.unknowns)[0][0]) for p in points) < 1e-8
    assert counts[1] < 0.9 * counts[0]


def test_the_bend_of_the_curve_is_known_at_the_second_point() -> None:
    """On a circle of radius 1 it points to the centre."""
    bends = []

    class Kept(FunctionProblem):
        def reformulate(self, point):  # type: ignore[no-untyped-def]
            bends.append((point.unknowns, point.bend))
            return super().reformulate(point)

    curve = Curve(
        Kept(lambda unknowns: (np.array([unknowns @ unknowns - 1]), 2 * unknowns[None, :]), np.ones(2)),
        steps=Steps(first=0.01, most=0.01, points=5),
    )
    list(curve.follow(curve.start(np.array([1.0, 0.0]), np.array([0.0, 1.0]))))
    for unknowns, bend in bends:
        np.testing.assert_allclose(bend, -unknowns, atol=0.01)
