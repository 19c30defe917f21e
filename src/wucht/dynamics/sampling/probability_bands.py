"""Confidence of a probability that was counted on scrambled Sobol' points.

Points of one scrambled sequence are not independent, but its replicates are, and the share of each is unbiased (A. B. Owen,
"Error estimation for quasi-Monte Carlo", 2025, arXiv:2501.00150). The scatter of their counts gives the variance of the mean,
and thus an equivalent number of independent points, mostly far more than were drawn. With this number the interval of
C. J. Clopper and E. S. Pearson (1934) is used, which holds also near 0 and 1, as E. L. Korn and B. I. Graubard do for counts in
clusters (Survey Methodology 24 (1998) 193-201), Student's t in place of the normal quantile; and the plain interval of
Student's t, which holds well according to P. L'Ecuyer, M. K. Nakayama, A. B. Owen and B. Tuffin ("Confidence intervals for
randomized quasi-Monte Carlo estimators", Winter Simulation Conference 2023). The band covers both.

Counts are whole numbers. If all replicates have the same count, other counts are not excluded: after R equal ones a share of
at most 1 - (a/2)^(1/R) can differ, which gives the least variance of a count, but no more than independent points have.

Replicates of one point each are independent points: then the interval of Clopper and Pearson is exact, and used alone. Where
points are left out, since nothing can be run there, replicates differ in size: the share is a ratio, and its scatter that of
the residuals, count - share size (W. G. Cochran, Sampling Techniques, 3rd ed. (1977), section 2.11).
"""

from __future__ import annotations

import numpy as np


def interval(counts: np.ndarray, sizes: np.ndarray | int, confidence: float) -> tuple[float, float]:
    """Two-sided bounds of a probability, from the number of inside points of each replicate (R,), and their sizes."""
    from scipy.stats import norm, t

    sizes, replicates, tail = np.broadcast_to(sizes, counts.shape), len(counts), (1 - confidence) / 2
    inside, total = float(counts.sum()), int(sizes.sum())
    if inside in (0, total) or sizes.max() <= 1:  # independent points scatter at least as much: these bounds are wide enough
        return clopper_pearson(inside, total, tail)
    share, mean_size = inside / total, total / replicates
    otherwise = min(1 - tail ** (1 / replicates), 0.5)
    least = min(otherwise * (1 - otherwise), mean_size * share * (1 - share))
    scatter = float(np.sum((counts - share * sizes) ** 2)) / (replicates - 1)
    variance = max(scatter, least) / replicates / mean_size**2
    student = float(t.ppf(1 - tail, replicates - 1))
    independent = share * (1 - share) / variance * (float(norm.ppf(1 - tail)) / student) ** 2
    low, high = clopper_pearson(share * independent, independent, tail)
    reach = student * variance**0.5
    return max(min(low, share - reach), 0.0), min(max(high, share + reach), 1.0)


def clopper_pearson(inside: float, total: float, tail: float) -> tuple[float, float]:
    """Bounds beyond which the counted number, or a more extreme one, would be less likely than ``tail``."""
    from scipy.stats import beta

    low = float(beta.ppf(tail, inside, total - inside + 1)) if inside > 0 else 0.0
    high = float(beta.ppf(1 - tail, inside + 1, total - inside)) if inside < total else 1.0
    return low, high


def band(inside: np.ndarray, open_: np.ndarray, sizes: np.ndarray | int, confidence: float) -> tuple[float, float]:
    """Bounds if some points of each replicate (R,) are inside and others are undecided: these may count or not."""
    return interval(inside, sizes, confidence)[0], interval(inside + open_, sizes, confidence)[1]
