"""The search for the Pareto front: NSGA-II, and what of many candidates no other one is better than.

K. Deb, A. Pratap, S. Agarwal, T. Meyarivan, "A fast and elitist multiobjective genetic algorithm: NSGA-II", IEEE Transactions
on Evolutionary Computation 6 (2002) 182-197; J. Blank, K. Deb, "pymoo: multi-objective optimization in Python", IEEE Access 8
(2020) 89497-89509.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from importlib import import_module
from typing import Any

import numpy as np

from wucht.errors import InputError

_NONE = 1e30  # in place of an objective that a candidate does not have


def needed(kind: str) -> None:
    """Raises ``InputError`` where pymoo is not installed, which a study of this kind needs."""
    try:
        import_module("pymoo.algorithms.moo.nsga2")
    except ImportError:
        raise InputError("study.kind", kind, "this study needs the extra: pip install wucht[optimise]") from None


def generations(
    count: int, first: np.ndarray, objectives: int, seed: int, value: Callable[[int, np.ndarray], tuple[np.ndarray, np.ndarray]]
) -> Iterator[int]:
    """Work off a number of generations, each as large as the first one (P, k), of shares from 0 to 1.

    value: of a generation, by its number, and candidates (P, k): objectives (P, o), and whether they are allowed (P,). Yields
    the number of each generation that is done. The same values give the same search.
    """
    of: Callable[[str], Any] = import_module
    problem = of("pymoo.core.problem").Problem(n_var=first.shape[1], n_obj=objectives, n_ieq_constr=1, xl=0.0, xu=1.0)
    algorithm = of("pymoo.algorithms.moo.nsga2").NSGA2(pop_size=len(first), sampling=first)
    algorithm.setup(problem, termination=("n_gen", count), seed=seed, verbose=False)
    evaluator, static = of("pymoo.core.evaluator").Evaluator(), of("pymoo.problems.static").StaticProblem
    for number in range(count):
        asked = algorithm.ask()
        found, allowed = value(number, np.clip(asked.get("X").astype(float), 0.0, 1.0))
        fit = allowed & np.isfinite(found).all(axis=1)
        shown = np.where(fit[:, None], found, _NONE)
        evaluator.eval(static(problem, F=shown, G=np.where(fit, -1.0, 1.0)[:, None]), asked)
        algorithm.tell(infills=asked)
        yield number


def not_dominated(objectives: np.ndarray) -> np.ndarray:
    """Which (N,) of N points (N, o) no other one is better than: at least as good in all, better in one."""
    kept = np.ones(len(objectives), bool)
    for i, one in enumerate(objectives):
        others = (objectives <= one).all(axis=1)
        kept[i] = not (others & (objectives < one).any(axis=1)).any()
    return kept


def spread_out(objectives: np.ndarray, count: int) -> np.ndarray:
    """The places (c,) of at most ``count`` of the points (N, o): the best in each objective, then those far from all others."""
    size = np.ptp(objectives, axis=0)
    scaled = (objectives - objectives.min(axis=0)) / np.where(size > 0, size, 1.0)
    chosen = list(dict.fromkeys(int(k) for k in objectives.argmin(axis=0)))[:count]
    while len(chosen) < min(count, len(objectives)):
        away = np.sqrt(((scaled[:, None] - scaled[chosen]) ** 2).sum(axis=2)).min(axis=1)
        if away.max() <= 0:  # the rest are the same in all
            break
        chosen.append(int(away.argmax()))
    return np.array(sorted(chosen), int)
