"""The design compared with its neighbours in the full equations, by beats that the search has not counted; and its cliff."""

from __future__ import annotations

from collections.abc import Sequence
from functools import partial

import numpy as np

from wucht.dynamics.exciters.design_search import beating_runs
from wucht.dynamics.exciters.design_trials import CheckedCandidate, DesignTrials, check_candidate
from wucht.dynamics.exciters.slow_beats import MOTIONS
from wucht.dynamics.sampling.choice import Cliff, Contest, Scores, nearest_cliff
from wucht.dynamics.work import Work
from wucht.fatigue.counted_cycles import LoadCycles

Design = tuple[float, ...]
_RIVALS = 2  # of the runs before, compared again
_LINE = (0.05, 0.1, 0.2, 0.4)  # relative: values at which an exciter may cease to beat
_DIGITS = 6  # of a value: a step up and a step down lead back


def compare_designs(
    trials: DesignTrials,
    nominal: np.ndarray,
    target: LoadCycles,
    runs: Sequence[CheckedCandidate],
    beats: int,
    step: float,
    work: Work,
) -> tuple[CheckedCandidate, ...]:
    """Return runs of the full equations over later beats: of the best candidates, the nominal exciter (k,), and of the
    neighbours of the best one, until none of these is nearer to the target. Those that do not beat in the averaged equations
    have none.

    runs: over the first beats. step: relative distance of the neighbours.
    """
    checks, metric, calls = dict[Design, CheckedCandidate](), trials.metric, 0

    def evaluate(designs: Sequence[Design]) -> Scores:
        nonlocal calls
        calls += 1
        part = work.part("", 1 - 0.5 ** (calls - 1), 1 - 0.5**calls)
        for k, design in enumerate(designs):
            here = part.part("", k / len(designs), (k + 1) / len(designs))
            here.report(0.0, "full equations of the neighbours")
            numbers = np.array(design)
            if trials.beat(numbers).motion == "modulated":
                check = partial(check_candidate, trials, numbers, target, beats, here.without_memory, beats)
                checks[design] = here.unit(f"{design}", check)
        is_beating = [d in checks and checks[d].beats for d in designs]
        costs = [
            float(checks[d].distances[metric]) if is_one else np.inf for d, is_one in zip(designs, is_beating, strict=True)
        ]
        return Scores(np.array(costs)[:, None], ~np.array(is_beating, bool)[:, None])

    def neighbours(design: Design, step: float) -> list[Design]:
        return [d for _, designs in _sides(trials, design, (step,)) for d in designs]

    first = [*(_round_values(c.numbers) for c in beating_runs(runs, metric)[:_RIVALS]), tuple(nominal.tolist())]
    comparison = Contest.of(first, evaluate).climb(neighbours, (step,), evaluate)
    work.report(1.0)
    return tuple(checks[d] for d in comparison.ranking if d in checks)


def end_of_beating(trials: DesignTrials, target: LoadCycles, numbers: np.ndarray, work: Work) -> Cliff | None:
    """Return the nearest value within the ranges at which an exciter (k,) does not beat in the averaged equations."""
    design, names = _round_values(numbers), [v.name for v in trials.variables]
    sides = _sides(trials, design, _LINE)
    designs = [design, *(d for _, side in sides for d in side)]
    results = work.unit("cliff", partial(trials.evaluate, np.array(designs), target, lambda _: None))
    failing = (results.motion != MOTIONS.index("modulated"))[:, None]
    scores = Scores(np.zeros(failing.shape), failing)
    return nearest_cliff(scores, 0, names, designs, [(k, list(map(designs.index, side))) for k, side in sides], ratio=None)


def _round_values(numbers: Sequence[float] | np.ndarray) -> Design:
    return tuple(float(f"{x:.{_DIGITS}g}") for x in numbers)


def _sides(trials: DesignTrials, design: Design, steps: Sequence[float]) -> list[tuple[int, list[Design]]]:
    """Return the candidates on either side of one, variable by variable, at relative steps and within the ranges."""
    sides = list[tuple[int, list[Design]]]()
    for k, variable in enumerate(trials.variables):
        for sign in (-1, 1):
            values = _round_values([design[k] * (1 + step) ** sign for step in steps])
            inside = [x for x in values if variable.low <= x <= variable.high and x != design[k]]
            sides.append((k, [(*design[:k], x, *design[k + 1 :]) for x in inside]))
    return sides
