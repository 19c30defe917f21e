"""The smallest value of a parameter from which on a probability is reached with confidence, and where to sample next."""

from __future__ import annotations

from collections.abc import Sequence

from wucht.dynamics.sampling.random_runs import ProbabilityPoint

_VALUE_ACCURACY = 1e-3  # of the range: the accuracy of the smallest value


def certain_fall(points: Sequence[ProbabilityPoint]) -> tuple[ProbabilityPoint, ProbabilityPoint] | None:
    """Return the points before and after the deepest fall of the probability; None: no fall is certain.

    The band at a value lies above that at a larger one. points: in the order of their values.
    """
    falls = [(a, b) for i, a in enumerate(points) for b in points[i + 1 :] if b.high < a.low]
    return max(falls, key=lambda fall: fall[0].low - fall[1].high, default=None)


def smallest_value(points: Sequence[ProbabilityPoint], target: float) -> float | None:
    """Return the smallest of some values, in order, from which on the lower bounds reach a target.

    None: they do not, or the probability falls.
    """
    if not points or certain_fall(points) is not None or points[-1].low < target:
        return None
    below_target = [k for k, b in enumerate(points) if b.low < target]
    return points[below_target[-1] + 1 if below_target else 0].value


def next_sample_value(points: Sequence[ProbabilityPoint], target: float) -> float | None:
    """Return the value to sample next to refine the smallest one; None: it is known well enough, or there is none."""
    smallest = smallest_value(points, target)
    if smallest is None or smallest == points[0].value:
        return None
    lower_value = max(b.value for b in points if b.value < smallest)
    if smallest - lower_value <= _VALUE_ACCURACY * (points[-1].value - points[0].value):
        return None
    return (lower_value + smallest) / 2
