"""Zeros of functions on a grid, all at once; peaks of sampled signals between samples; intervals in which a condition holds."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

RealFunction = Callable[[np.ndarray], np.ndarray]

_MOST_STEPS = 100  # a dozen are enough, but for a function that jumps


def crossings(function: RealFunction, grid: np.ndarray, direction: int = 0) -> np.ndarray:
    """Return the places where a function (N,) -> (N,) changes sign between samples of a grid (N,), exact to the last bit.

    direction: +1 only where it rises through zero, -1 only where it falls, 0 both. An interval in which it is zero counts
    once where it has different signs on its two sides, else not at all.
    """
    values = function(grid)
    has_sign = np.isfinite(values) & (values != 0)
    x, f = grid[has_sign], values[has_sign]
    change = np.diff(np.sign(f))
    i = np.flatnonzero(change * direction > 0 if direction else change)
    return _roots(function, x[i], x[i + 1], f[i], f[i + 1]) if len(i) else np.empty(0)


def values_at_passages(samples: np.ndarray, value: float, signals: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Return the samples (K,) before which samples (N,) pass a value, and other signals (..., N) there, to first order."""
    i = np.flatnonzero((samples[:-1] - value) * (samples[1:] - value) <= 0)
    width = samples[i + 1] - samples[i]
    share = np.divide(value - samples[i], width, out=np.zeros(len(i)), where=width != 0)
    return i, np.asarray(signals[..., i] + share * (signals[..., i + 1] - signals[..., i]))


@np.errstate(divide="ignore", invalid="ignore")  # where no interpolation is safe
def _roots(function: RealFunction, a: np.ndarray, b: np.ndarray, fa: np.ndarray, fb: np.ndarray) -> np.ndarray:
    """Return the zeros between a and b (k,), where the function has values of different signs.

    Inverse quadratic interpolation where it is safe, else bisection: T. R. Chandrupatla, Adv. Eng. Software 28 (1997) 145-149.
    """
    share, roots = fa / (fa - fb), np.full(len(a), np.nan)
    for _ in range(_MOST_STEPS):
        x = a + share * (b - a)
        f = function(x)
        same = np.sign(f) == np.sign(fa)
        (c, fc), (b, fb) = (np.where(same, (a, fa), (b, fb)), np.where(same, (b, fb), (a, fa)))
        a, fa = x, f
        best = np.where(np.abs(fa) < np.abs(fb), a, b)
        least = np.finfo(float).eps * np.abs(best) / np.abs(b - a)  # nearer to an end there is no other number
        roots = np.where(np.isnan(roots) & ((least > 0.5) | (fa == 0)), best, roots)
        if not np.isnan(roots).any():
            break
        xi, phi = (a - b) / (c - b), (fa - fb) / (fc - fb)
        safe = (phi**2 < xi) & ((1 - phi) ** 2 < 1 - xi)
        quadratic = fa / (fb - fa) * fc / (fb - fc) + (c - a) / (b - a) * fa / (fc - fa) * fb / (fc - fb)
        share = np.clip(np.where(safe, quadratic, 0.5), np.minimum(least, 0.5), np.maximum(1 - least, 0.5))
    return np.where(np.isnan(roots), best, roots)


def first_where(holds: Callable[[float], bool], low: float, high: float) -> float:
    """Return the lowest number between two from which on a condition holds, as it does at ``high``, to the last bit."""
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


def fewest_where(holds: Callable[[int], bool], low: int, high: int) -> int:
    """Return the least whole number above ``low`` from which on a condition holds, as it does at ``high``."""
    while high - low > 1:
        middle = (low + high) // 2
        low, high = (low, middle) if holds(middle) else (middle, high)
    return high


_ROUNDING = 1e-6  # of a sampling interval


def interval_peaks(time: np.ndarray, signal: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return the largest value that a signal reaches between each sample and its neighbours, all (N,)."""
    if len(time) < 2:
        return signal.copy()
    maxima = interval_maxima(time, signal, slope)
    return np.asarray(np.maximum(np.concatenate([maxima[:1], maxima]), np.concatenate([maxima, maxima[-1:]])))


def interval_maxima(time: np.ndarray, signal: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """Return the largest value (N - 1, ...) that signals (N, ...) reach between samples. time: (N,), or of each (N, ...).

    Between samples the signal is the cubic with the given values and slopes; the error is of fourth order in the sampling
    interval, that of the largest sample of second order.
    """
    h = np.diff(time, axis=0)
    h = h if time.ndim == signal.ndim else h.reshape(-1, *(1,) * (signal.ndim - 1))
    start, end, before, after = signal[:-1], signal[1:], slope[:-1] * h, slope[1:] * h
    largest, middle = np.maximum(start, end), 3 * (end - start) - before - after
    # The slope lies between the coefficients of its Bernstein form, before, middle and after: where these have one sign there
    # is no maximum inside.
    i = (np.maximum(before, middle) > 0) & (np.minimum(middle, after) < 0)
    if i.any():
        largest[i] = np.maximum(largest[i], _interior_maxima(start[i], end[i], before[i], after[i]))
    return np.asarray(largest)


def _interior_maxima(start: np.ndarray, end: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return the maximum of each cubic by values and slopes at the ends of 0 <= s <= 1; the first value where there is none."""
    # y(s) = start + a s + c s^2 + d s^3
    d = 2 * (start - end) + a + b
    c = 3 * (end - start) - 2 * a - b
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(c**2 - 3 * a * d)
        # The maximum is where y' = 0 and y'' < 0; this form of the root stays accurate as d -> 0.
        s = np.where(c > 0, (-c - root) / (3 * d), a / (root - c))
    s = np.where(np.isfinite(s) & (s > 0) & (s < 1), s, 0.0)
    return np.asarray(start + s * (a + s * (c + s * d)))


def extremes(signal: np.ndarray) -> tuple[float, float]:
    """Return least and largest value of an evenly sampled signal (N,), between samples by a parabola through three of them."""
    return -_vertex(-signal, int(signal.argmin())), _vertex(signal, int(signal.argmax()))


def _vertex(signal: np.ndarray, i: int) -> float:
    if not 0 < i < len(signal) - 1:
        return float(signal[i])
    before, centre, after = (float(x) for x in signal[i - 1 : i + 2])
    curvature = before - 2 * centre + after
    return centre - (after - before) ** 2 / (8 * curvature) if curvature < 0 else centre


def envelope(time: np.ndarray, radius: np.ndarray, window: np.ndarray, before: float | None = None) -> np.ndarray:
    """Return the line through the peaks of ``radius``: valleys shorter than ``window`` are filled, slower changes remain.

    All (N,); time is evenly spaced but for a few places. This is the morphological closing, the largest value within
    +-window/2 of each sample and then the smallest of those. It would also fill the lowest part of a slow, smooth minimum: such
    a minimum is distinguished from a valley between peaks by the slopes at its ends, and not filled. Of a valley that an end of
    the record cuts only one peak is known: the line continues at its height. before: the radius before the
    record, if that is known (0 of a motion that begins from rest): the line begins there.
    """
    n = len(time)
    if n < 4:
        return radius.copy()
    steps = time[1] - time[0], time[-1] - time[-2]
    beyond = int(min(np.ceil(window.max() / 2 / min(steps)), n - 1))
    first = _outermost(time[0] - time[::-1], radius[::-1], window[0]) if before is None else before
    ends = first, _outermost(time - time[-1], radius, window[-1])
    padded_radius, reach = np.pad(radius, beyond, constant_values=ends), np.pad(window / 2, beyond, mode="edge")
    past, future = (step * np.arange(1, beyond + 1) for step in steps)
    times = np.concatenate([time[0] - past[::-1], time, time[-1] + future])
    rounding = _ROUNDING * min(steps)
    low = np.maximum(np.searchsorted(times, times - reach + rounding, side="right") - 1, 0)
    high = np.minimum(np.searchsorted(times, times + reach - rounding), len(times) - 1)
    closing = -_largest_within(-_largest_within(padded_radius, low, high), low, high)
    return np.where(_smooth_minima(padded_radius, closing > padded_radius), padded_radius, closing)[beyond : beyond + n]


def _outermost(time: np.ndarray, radius: np.ndarray, window: float) -> float:
    """Return the height of the line at the end of a record (N,), at time 0: the highest peak within a window, or the end."""
    steps = np.flatnonzero(np.diff(radius))
    rises = radius[steps + 1] > radius[steps]
    peaks = steps[1:][rises[:-1] & ~rises[1:]]  # the last sample of each, which may be as high as those before
    late = peaks[time[np.minimum(peaks + 1, len(time) - 1)] > -window]
    return float(radius[late].max(initial=float(radius[-1])))


def _smooth_minima(radius: np.ndarray, is_filled: np.ndarray) -> np.ndarray:
    """Return which filled samples (N,) lie in a parabolic minimum: its depth follows from the slopes outside its ends."""
    edges = np.flatnonzero(np.diff(is_filled.astype(int)))
    if is_filled[0]:
        edges = edges[1:]
    begin, end = edges[: len(edges) // 2 * 2 : 2], edges[1::2] + 1
    inside = (begin >= 1) & (end <= len(radius) - 2)
    begin, end = begin[inside], end[inside]
    slopes = radius[end + 1] - radius[end] + radius[begin - 1] - radius[begin]
    # The outer slopes belong to points half a sample outside: a parabola over h + 1 intervals.
    predicted_depth = slopes * (end - begin) ** 2 / (8 * (end - begin + 1))
    actual_depth = (radius[begin] + radius[end]) / 2 - radius[(begin + end) // 2]
    smooth = np.abs(predicted_depth - actual_depth) <= 0.25 * np.abs(actual_depth)
    marks = np.zeros(len(radius) + 1, int)
    np.add.at(marks, begin[smooth], 1)
    np.add.at(marks, end[smooth] + 1, -1)
    return np.asarray(np.cumsum(marks)[:-1] > 0)


def _largest_within(signal: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Return the maximum of signal[low[i] : high[i] + 1] for each i: two overlapping blocks of length 2^k cover each range."""
    level = np.floor(np.log2(high - low + 1)).astype(int)
    largest, table = np.empty(len(signal)), signal
    for k in range(int(level.max()) + 1):
        if k:
            table = np.maximum(table[: -(2 ** (k - 1))], table[2 ** (k - 1) :])
        at_level = level == k
        largest[at_level] = np.maximum(table[low[at_level]], table[high[at_level] - 2**k + 1])
    return largest


def stretches(holds: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and one past the last sample of each interval in which a condition holds (N,), in order."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], holds.astype(int), [0]])))
    return list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
