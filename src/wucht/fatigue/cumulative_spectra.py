"""Required spectra: from a table of amplitude over cumulative cycles, or of a standard shape; as cycles."""

from __future__ import annotations

import math

import numpy as np

from wucht.fatigue.counted_cycles import LoadCycles

# Amplitude over cumulative cycles: S/S_max = (1 - ln H/ln H_0)^(1/exponent), so that H = H_0^(1 - (S/S_max)^exponent).
EXPONENTS = {"constant": math.inf, "normal": 2.0, "straight-line": 1.0}
_SHARES, _FEW = 400, 120  # of the cycles, at which amplitudes are given; and a few more, evenly by their logarithm
_PARTS, _DECADES_IN = 1000, 20  # of the cycles, by their share; and of each decade of few cycles


def standard_spectrum(largest: float, count: float, exponent: float, ratio: float = 0.0) -> LoadCycles:
    """Return a spectrum of a standard shape, reversed about zero, the largest amplitude once.

    S/S_max = p + (1 - p) (1 - ln H/ln H_0)^(1/exponent), H cycles of at least S of H_0 in all.

    Parameters
    ----------
    largest : float
        S_max, an amplitude.
    count : float
        H_0, the number of cycles.
    exponent : float
        2: ``normal``, the amplitudes of a narrow-band Gaussian process, which are Rayleigh's; 1: ``straight-line``, amplitudes
        with an exponential distribution; infinite: ``constant``.
    ratio : float, optional
        p, E. Gassner's ratio of the lowest to the largest amplitude.

    Returns
    -------
    LoadCycles
    """
    shares, counts = _parts(count)
    with np.errstate(divide="ignore"):
        depth = np.clip(-np.log(shares) / math.log(count), 0.0, 1.0)
    form = np.ones_like(depth) if math.isinf(exponent) else depth ** (1 / exponent)
    return _reversed_cycles(largest * (ratio + (1 - ratio) * form), counts)


def tabulated_spectrum(amplitudes: np.ndarray, cumulative: np.ndarray, is_stepped: bool = False) -> LoadCycles:
    """Return the spectrum of a table of amplitudes and the numbers of cycles that reach each.

    Parameters
    ----------
    amplitudes : numpy.ndarray, (n,)
        Ascending.
    cumulative : numpy.ndarray, (n,)
        Cycles with at least each amplitude, descending.
    is_stepped : bool, optional
        No cycle lies between two of the amplitudes. Else the amplitude falls between the rows as the logarithm of the cycles
        rises, as such spectra are drawn.

    Returns
    -------
    LoadCycles
        Reversed about zero.
    """
    total = float(cumulative[0])
    shares, counts = _parts(total, cumulative / total)
    if is_stepped:
        return _reversed_cycles(amplitudes[np.searchsorted(-cumulative, -shares * total, side="right") - 1], counts)
    return _reversed_cycles(np.interp(np.log(shares * total), np.log(cumulative[::-1]), amplitudes[::-1]), counts)


def amplitudes_at(cycles: LoadCycles, shares: np.ndarray) -> np.ndarray:
    """Return the amplitudes that shares of the cycles reach or exceed.

    Parameters
    ----------
    cycles : LoadCycles
    shares : numpy.ndarray, (k,)
        Of the number of cycles, 0 to 1.

    Returns
    -------
    numpy.ndarray, (k,)
    """
    order = np.argsort(-cycles.ranges, kind="stable")
    cumulative_shares = np.cumsum(cycles.counts[order]) / cycles.total
    at = np.minimum(np.searchsorted(cumulative_shares, shares, side="left"), len(order) - 1)
    return np.asarray(cycles.ranges[order][at] / 2)


def cycle_shares(total: float) -> np.ndarray:
    """Return the shares (n,) of a number of cycles at which amplitudes are given, from one cycle to all of them."""
    few = np.geomspace(1 / total, 1.0, _FEW)
    return np.unique(np.concatenate([few, np.linspace(0.0, 1.0, _SHARES + 1)[1:]]))


def spectrum_form(cycles: LoadCycles) -> tuple[float, float, float]:
    """Return largest amplitude, smallest over largest, and the position of the mean between (nan if they coincide)."""
    low, high = float(cycles.ranges.min()) / 2, cycles.largest / 2
    mean = float(np.average(cycles.ranges, weights=cycles.counts)) / 2
    return high, low / high, (mean - low) / (high - low) if high > low else np.nan


def shift_spectrum(cycles: LoadCycles, target: LoadCycles, reference: LoadCycles) -> LoadCycles:
    """Increase the amplitudes of cycles by the excess of ``target`` over ``reference`` at the same share of the cycles."""
    order = np.argsort(-cycles.ranges, kind="stable")
    counts = cycles.counts[order]
    shares = (np.cumsum(counts) - counts / 2) / cycles.total
    amplitudes = cycles.ranges[order] / 2 + amplitudes_at(target, shares) - amplitudes_at(reference, shares)
    return LoadCycles(2 * np.maximum(amplitudes, 0.0), cycles.means[order], counts)


def amplitude_distance(cycles: LoadCycles, reference: LoadCycles) -> float:
    """Return the mean difference between the amplitudes of two spectra over equal shares of their cycles.

    It is Wasserstein's distance of their distributions (L. N. Vaserstein, Problemy Peredachi Informatsii 5 (1969) 64-72): the
    area between the two cumulative curves over a linear axis.

    Parameters
    ----------
    cycles, reference : LoadCycles

    Returns
    -------
    float
        A share of the reference's largest amplitude; infinite if one of the two has no cycle.
    """
    from scipy.stats import wasserstein_distance

    if not cycles.total or not reference.total:
        return 0.0 if cycles.total == reference.total else math.inf
    area = wasserstein_distance(cycles.ranges, reference.ranges, cycles.counts, reference.counts)
    return float(area) / reference.largest


def _parts(count: float, also: np.ndarray | None = None) -> tuple[np.ndarray, np.ndarray]:
    """Divide so many cycles into parts: the share at the middle of each (m,), and its number (m,); finer at both ends.

    also: shares (k,) at which a part ends too.
    """
    decades = max(int(math.log10(count)), 1)
    few = np.geomspace(1 / count, 1.0, _DECADES_IN * decades + 1)
    more = also if also is not None else np.empty(0)
    edges = np.unique(np.concatenate([[0.0], few, 1 - few, np.linspace(0.0, 1.0, _PARTS + 1), more]))
    return (edges[1:] + edges[:-1]) / 2, np.diff(edges) * count


def _reversed_cycles(amplitudes: np.ndarray, counts: np.ndarray) -> LoadCycles:
    """Return cycles (m,) about zero."""
    return LoadCycles(2 * amplitudes, np.zeros(len(amplitudes)), counts)
