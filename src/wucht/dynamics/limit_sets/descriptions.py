"""Limit sets in words and as tables of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind
from wucht.numerics.angles import wrap_to_pi

_NEGLIGIBLE = 1e-9  # of the largest component of an equilibrium: rounding errors of zero


def sentence_of(kind: MotionKind, limit_set: LimitSet | None, names: tuple[str, ...]) -> str:
    """Return what a motion tends to, in words with its main number."""
    if limit_set is None:
        return kind.sentence
    if limit_set.kind is MotionKind.EQUILIBRIUM:
        state = _mean_in_turn(limit_set)
        state = np.where(np.abs(state) < _NEGLIGIBLE * np.abs(state).max(initial=0.0), 0.0, state)
        places = ", ".join(f"{n} = {x:.5g}" for n, x in zip(names, state, strict=True))
        return f"{kind.sentence}{_stability_clause(limit_set)} at {places}"
    if limit_set.kind is MotionKind.PERIODIC:
        return f"{kind.sentence} of period {limit_set.period:.7g}{_stability_clause(limit_set)}"
    if limit_set.kind is MotionKind.CHAOTIC and limit_set.exponent is not None:
        e = limit_set.exponent
        return f"{kind.sentence}: largest Lyapunov exponent {e.value:.3g} ({e.low:.3g} to {e.high:.3g})"
    return kind.sentence


def _stability_clause(limit_set: LimitSet) -> str:
    if limit_set.attracts is None:
        return "" if limit_set.eigenvalues is not None and not len(limit_set.eigenvalues) else " that does not attract"
    return "" if limit_set.attracts else " that is unstable"


def _mean_in_turn(limit_set: LimitSet) -> np.ndarray:
    """Return the mean state with angles in [-pi, pi)."""
    return np.where(limit_set.metric.turning, wrap_to_pi(limit_set.mean), limit_set.mean)


def numbers_of(limit_set: LimitSet, names: tuple[str, ...]) -> dict[str, Any]:
    """Return the numbers of a limit set, None or empty where it has none of that name.

    Keys: ``stable``; ``state`` (of an equilibrium), ``eigenvalues``; ``period``, ``turns``, ``multipliers``;
    ``lyapunov_exponent`` {``value``, ``low``, ``high``, ``duration``}; ``min``, ``max``, ``mean`` of each state.
    """
    e, turns = limit_set.exponent, limit_set.turns
    return {
        "stable": limit_set.attracts,
        "state": _name_values(names, _mean_in_turn(limit_set)) if limit_set.kind is MotionKind.EQUILIBRIUM else None,
        "eigenvalues": _pairs(limit_set.eigenvalues),
        "period": limit_set.period or None,
        "turns": {} if turns is None else {n: int(k) for n, k in zip(names, turns, strict=True) if k},
        "multipliers": _pairs(limit_set.multipliers),
        "lyapunov_exponent": None if e is None else {"value": e.value, "low": e.low, "high": e.high, "duration": e.duration},
        "min": _name_values(names, limit_set.low),
        "max": _name_values(names, limit_set.high),
        "mean": _name_values(names, limit_set.mean),
    }


def _name_values(names: tuple[str, ...], values: np.ndarray) -> dict[str, float]:
    return dict(zip(names, values.tolist(), strict=True))


def _pairs(values: np.ndarray | None) -> list[list[float]]:
    return [] if values is None else [[float(v.real), float(v.imag)] for v in values]
