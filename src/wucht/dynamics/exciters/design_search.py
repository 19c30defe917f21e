"""Search for a design: random points, generations, local searches, and corrections by the full equations."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from functools import partial

import numpy as np

from wucht.dynamics.exciters.design_trials import Candidates, CheckedCandidate, DesignTrials, check_candidate
from wucht.dynamics.sampling.searches import generations
from wucht.dynamics.work import Work
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.fatigue.cumulative_spectra import shift_spectrum

_APART = 0.1  # of the ranges: candidates nearer to each other count as one
_WHOLE = 2  # corrections with as many evaluations as the local searches before; later ones are near, and have half as many


def sobol_points(trials: DesignTrials, count: int, seed: Sequence[int]) -> np.ndarray:
    """Return scrambled Sobol' points (P, k), shares of the ranges."""
    from scipy.stats import qmc

    sobol = qmc.Sobol(len(trials.variables), scramble=True, rng=np.random.default_rng(seed))
    return np.asarray(sobol.random(1 << (count - 1).bit_length())[:count])


def candidate_batches(
    trials: DesignTrials, numbers: np.ndarray, target: LoadCycles, size: int, label: str, work: Work
) -> Iterator[Candidates]:
    """Evaluate candidates (P, k) in batches."""
    for begin in range(0, len(numbers), size):
        part = work.part("", begin / len(numbers), min(1.0, (begin + size) / len(numbers)))
        rows = numbers[begin : begin + size]
        yield part.unit(f"{begin}", partial(trials.evaluate, rows, target, _progress_report(part, label)))


def _progress_report(work: Work, label: str) -> Callable[[float], None]:
    return lambda share: work.report(share, label)


def search_generations(
    trials: DesignTrials,
    nominal: np.ndarray,
    target: LoadCycles,
    reach: Sequence[Candidates],
    size: int,
    count: int,
    seed: int,
    work: Work,
) -> Iterator[Candidates]:
    """Yield generations of a search, the first from the best random points and the nominal exciter (k,)."""
    numbers, far = _all_candidates(reach, trials.metric)
    nominal_shares = trials.shares(nominal)
    first = np.array([trials.shares(row) for row in numbers[np.argsort(far, kind="stable")[:size]]])
    if ((nominal_shares >= 0) & (nominal_shares <= 1)).all():
        first[-1] = nominal_shares
    latest: list[Candidates] = []

    def value(number: int, shares: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        here = work.part("", number / count, (number + 1) / count)
        report = _progress_report(here, f"generation {number + 1} of {count}")
        batch = here.unit(f"generation {number}", partial(trials.evaluate, trials.values(shares), target, report))
        latest.append(batch)
        column = batch.distances[:, [trials.metric]]
        return column, np.isfinite(column[:, 0])

    for _ in generations(count, first, 1, seed, value):
        yield latest[-1]


def local_optimum(
    trials: DesignTrials, numbers: np.ndarray, target: LoadCycles, evaluations: int, name: str, work: Work
) -> tuple[np.ndarray, float]:
    """Return the best near a candidate (k,), without evaluations that itself, and its distance."""
    if not evaluations:
        candidates = trials.evaluate(numbers[None], target, _progress_report(work, name))
        return numbers, float(candidates.distances[0, trials.metric])
    return work.unit(name, partial(trials.optimise, numbers, target, evaluations, _progress_report(work, "local search")))


def full_run(
    trials: DesignTrials, numbers: np.ndarray, target: LoadCycles, beats: int, name: str, work: Work
) -> CheckedCandidate:
    """Run a candidate (k,) with the full equations."""
    work.report(0.0, "full equations")
    part = work.part(name, 0.0, 1.0)
    return work.unit(name, partial(check_candidate, trials, numbers, target, beats, part))


def corrected_runs(
    trials: DesignTrials,
    target: LoadCycles,
    runs: Sequence[CheckedCandidate],
    corrections: int,
    polish: int,
    beats: int,
    work: Work,
) -> Iterator[CheckedCandidate]:
    """Optimise again for a target corrected by the deviation of the full equations, while that helps: output space mapping.

    J. W. Bandler et al., "Space mapping: the state of the art", IEEE Transactions on Microwave Theory and Techniques 52 (2004)
    337-361. runs: those before. corrections: at most. polish: evaluations of a local search; none without.
    """
    count, best = corrections if polish else 0, nearest_that_beats(runs, trials.metric)
    for k in range(count):
        if best is None:
            return
        here = work.part("", k / count, (k + 1) / count)
        corrected_target = shift_spectrum(target, best.slow.cycles, best.cycles)
        part, evaluations = here.part("", 0.0, 0.8), polish if k < _WHOLE else -(-polish // 2)
        numbers, _ = local_optimum(trials, best.numbers, corrected_target, evaluations, f"{k} polish", part)
        corrected_run = full_run(trials, numbers, target, beats, f"{k} full", here.part("", 0.8, 1.0))
        yield corrected_run
        before, best = best, nearest_that_beats([best, corrected_run], trials.metric)
        if best is before:  # a further correction would give the same
            return


def _all_candidates(batches: Sequence[Candidates], metric: int) -> tuple[np.ndarray, np.ndarray]:
    """Return all candidates (P, k), and their distances (P,), infinite where undefined."""
    far = np.concatenate([b.distances[:, metric] for b in batches])
    return np.concatenate([b.numbers for b in batches]), np.where(np.isfinite(far), far, np.inf)


def best_apart(trials: DesignTrials, batches: Sequence[Candidates], count: int) -> list[np.ndarray]:
    """Return the best candidates, at most so many, each apart from those before it."""
    numbers, far = _all_candidates(batches, trials.metric)
    shares = np.array([trials.shares(row) for row in numbers])
    chosen: list[int] = []
    for k in np.argsort(far, kind="stable").tolist():
        if len(chosen) == count or not np.isfinite(far[k]):
            break
        if all(np.abs(shares[k] - shares[j]).max() > _APART for j in chosen):
            chosen.append(k)
    return [numbers[k] for k in chosen]


def nearest_that_beats(runs: Sequence[CheckedCandidate], metric: int) -> CheckedCandidate | None:
    """Return the run of the full equations whose spectrum is nearest to the target; None where none beats."""
    return next(iter(beating_runs(runs, metric)), None)


def beating_runs(runs: Sequence[CheckedCandidate], metric: int) -> list[CheckedCandidate]:
    """Return the runs of the full equations that beat, those first whose spectra are nearest to the target."""
    beating = [c for c in runs if c.beats and np.isfinite(c.distances[metric])]
    return sorted(beating, key=lambda c: float(c.distances[metric]))
