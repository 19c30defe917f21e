"""Where a wanted probability is reached with confidence.

The random numbers are the same at all values of the parameter. Where more of it never makes a run worse, the estimate rises
with it, and so does the lower bound, but for what the scatter of the replicates changes. A value that is taken too early then
means that the lower bound was too high where the wanted probability is reached in truth: that is as rare as the confidence of
this one bound says, however many values are looked at on the way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

_NEAR = 1e-3  # of the range: so near the smallest value is found


@dataclass(frozen=True)
class Bounds:
    """Of the probability at a value of the parameter."""

    value: float
    low: float
    high: float


@dataclass(frozen=True)
class Fall:
    """Where the probability falls for certain: its band at a value lies above that at a larger one."""

    before: Bounds
    after: Bounds


def fall_of(seen: Sequence[Bounds]) -> Fall | None:
    """Where the probability falls, of values in order: the deepest fall; None: nowhere for certain."""
    falls = [Fall(a, b) for i, a in enumerate(seen) for b in seen[i + 1 :] if b.high < a.low]
    return max(falls, key=lambda f: f.before.low - f.after.high, default=None)


def smallest(seen: Sequence[Bounds], wanted: float) -> float | None:
    """The smallest of some values in order from which on the lower bounds reach what is wanted.

    None: they do not, or the probability falls.
    """
    if not seen or fall_of(seen) is not None or seen[-1].low < wanted:
        return None
    short = [k for k, one in enumerate(seen) if one.low < wanted]
    return seen[short[-1] + 1 if short else 0].value


def to_look_at(seen: Sequence[Bounds], wanted: float) -> float | None:
    """The value to look at next to know the smallest one better; None: it is known well enough, or there is none."""
    found = smallest(seen, wanted)
    if found is None or found == seen[0].value:
        return None
    before = max(one.value for one in seen if one.value < found)
    if found - before <= _NEAR * (seen[-1].value - seen[0].value):
        return None
    return (before + found) / 2
