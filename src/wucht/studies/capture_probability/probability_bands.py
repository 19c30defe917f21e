"""How sure a probability is that was counted on scrambled Sobol' points.

Points of one scrambled sequence are not independent, but its replicates are, and the share of each is right on average (A. B.
Owen, "Error estimation for quasi-Monte Carlo", 2025, arXiv:2501.00150). The scatter of their counts gives the variance of the
mean: it is as large as if there were so many independent points, mostly far more than were drawn. With their number the
interval of C. J. Clopper and E. S. Pearson (1934) is taken, which is right also near 0 and 1, as E. L. Korn and B. I. Graubard
do for counts in clusters (Survey Methodology 24 (1998) 193-201), Student's t in place of the normal quantile; and the plain
interval of Student's t, which P. L'Ecuyer, M. K. Nakayama, A. B. Owen and B. Tuffin found to hold well ("Confidence intervals
for randomized quasi-Monte Carlo estimators", Winter Simulation Conference 2023). The band covers both.

Counts are whole numbers. Where all replicates count alike, that they never would do otherwise is not known: of R like ones a
share of at most 1 - (a/2)^(1/R) can be otherwise, which is taken as the least variance of a count, but no more than
independent points have.
"""

from __future__ import annotations

import numpy as np


def interval(counts: np.ndarray, each: int, confidence: float) -> tuple[float, float]:
    """Between which bounds a probability lies, two-sided, by how many of ``each`` points of each replicate (R,) are inside."""
    from scipy.stats import norm, t

    replicates, tail = len(counts), (1 - confidence) / 2
    share, total = float(counts.mean()) / each, replicates * each
    if counts.min() == each or counts.max() == 0:  # independent points scatter no less: these bounds are wide enough
        return clopper_pearson(share * total, total, tail)
    otherwise = min(1 - tail ** (1 / replicates), 0.5)
    least = min(otherwise * (1 - otherwise), each * share * (1 - share))
    variance = max(float(counts.var(ddof=1)), least) / replicates / each**2
    student = float(t.ppf(1 - tail, replicates - 1))
    independent = share * (1 - share) / variance * (float(norm.ppf(1 - tail)) / student) ** 2
    low, high = clopper_pearson(share * independent, independent, tail)
    reach = student * variance**0.5
    return max(min(low, share - reach), 0.0), min(max(high, share + reach), 1.0)


def clopper_pearson(inside: float, total: float, tail: float) -> tuple[float, float]:
    """The bounds beyond each of which as many as were counted, or fewer, or more, would be less likely than ``tail``."""
    from scipy.stats import beta

    low = float(beta.ppf(tail, inside, total - inside + 1)) if inside > 0 else 0.0
    high = float(beta.ppf(1 - tail, inside + 1, total - inside)) if inside < total else 1.0
    return low, high


def band(inside: np.ndarray, open_: np.ndarray, each: int, confidence: float) -> tuple[float, float]:
    """The bounds where some points of each replicate (R,) are inside and of others it is open: these could be either."""
    return interval(inside, each, confidence)[0], interval(inside + open_, each, confidence)[1]
