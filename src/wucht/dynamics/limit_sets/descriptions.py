"""Limit sets in words and as tables of numbers."""

from __future__ import annotations

from typing import Any

import numpy as np

from wucht.dynamics.limit_sets.limit_set import LimitSet, MotionKind
from wucht.numerics.angles import wrap_to_pi

_NEGLIGIBLE = 1e-9  # of the largest size of a state: rounding errors of zero


def sentence_of(kind: MotionKind, limit_set: LimitSet | None, names: tuple[str, ...]) -> str:
    """Return what a motion tends to, in words with its main number; of a chaotic one, which may end, for how long it is so."""
    if limit_set is None:
        return kind.sentence
    if limit_set.kind is MotionKind.EQUILIBRIUM:
        state = _mean_in_turn(limit_set)
        state = np.where(np.abs(state) < _NEGLIGIBLE * limit_set.metric.sizes.max(), 0.0, state)
        places = ", ".join(f"{n} = {x:.5g}" for n, x in zip(names, state, strict=True))
        return f"{kind.sentence} at {places}{_stability_clause(limit_set)}"
    if limit_set.kind is MotionKind.PERIODIC:
        motion = "the motion is periodic, with the" if limit_set.attracts is None else f"{kind.sentence} of"
        return f"{motion} period {limit_set.period:.7g}{_stability_clause(limit_set)}"
    if limit_set.kind is MotionKind.CHAOTIC and limit_set.exponent is not None:
        e = limit_set.exponent
        exponent = f"largest Lyapunov exponent {e.value:.3g} ({e.low:.3g} to {e.high:.3g})"
        return f"the motion is chaotic for at least {limit_set.times[-1]:.4g}: {kind.sentence}, {exponent}"
    return kind.sentence


def _stability_clause(limit_set: LimitSet) -> str:
    if limit_set.attracts is None:
        is_known = limit_set.eigenvalues is None or len(limit_set.eigenvalues) > 0
        return ", one of a family: disturbances neither grow nor decay" if is_known else ""
    return "" if limit_set.attracts else ", which is unstable"


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
