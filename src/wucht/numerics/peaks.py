"""Peaks of sampled signals: what they reach between samples, and the line through them."""

from __future__ import annotations

import numpy as np

_ROUNDING = 1e-6  # of a sampling interval


def interval_peaks(time: np.ndarray, signal: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """The largest value that a signal reaches between each sample and its neighbours, all (N,)."""
    if len(time) < 2:
        return signal.copy()
    maxima = between_samples(time, signal, slope)
    return np.asarray(np.maximum(np.concatenate([maxima[:1], maxima]), np.concatenate([maxima, maxima[-1:]])))


def between_samples(time: np.ndarray, signal: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """The largest value (N - 1, ...) that signals (N, ...) reach from each sample to the next. time: (N,), or of each (N, ...).

    Between samples the signal is the cubic with the given values and slopes; the error is of fourth order in the sampling
    interval, where that of the largest sample is of second.
    """
    h = np.diff(time, axis=0)
    h = h if time.ndim == signal.ndim else h.reshape(-1, *(1,) * (signal.ndim - 1))
    left, right, before, after = signal[:-1], signal[1:], slope[:-1] * h, slope[1:] * h
    largest, middle = np.maximum(left, right), 3 * (right - left) - before - after
    # The slope lies between the coefficients of its Bernstein form, before, middle and after: where these have one sign there
    # is no maximum inside.
    i = (np.maximum(before, middle) > 0) & (np.minimum(middle, after) < 0)
    if i.any():
        largest[i] = np.maximum(largest[i], _interior_maxima(left[i], right[i], before[i], after[i]))
    return np.asarray(largest)


def _interior_maxima(left: np.ndarray, right: np.ndarray, a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """The maximum of each cubic with these values and slopes at the ends of 0 <= s <= 1; the left value where there is none."""
    # y(s) = left + a s + c s^2 + d s^3
    d = 2 * (left - right) + a + b
    c = 3 * (right - left) - 2 * a - b
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(c**2 - 3 * a * d)
        # The maximum is where y' = 0 and y'' < 0; this form of the root stays accurate as d -> 0.
        s = np.where(c > 0, (-c - root) / (3 * d), a / (root - c))
    s = np.where(np.isfinite(s) & (s > 0) & (s < 1), s, 0.0)
    return np.asarray(left + s * (a + s * (c + s * d)))


def extremes(signal: np.ndarray) -> tuple[float, float]:
    """Least and largest value of an evenly sampled signal (N,), between samples by the parabola through three of them."""
    return -_vertex(-signal, int(signal.argmin())), _vertex(signal, int(signal.argmax()))


def _vertex(signal: np.ndarray, i: int) -> float:
    if not 0 < i < len(signal) - 1:
        return float(signal[i])
    before, centre, after = (float(x) for x in signal[i - 1 : i + 2])
    curvature = before - 2 * centre + after
    return centre - (after - before) ** 2 / (8 * curvature) if curvature < 0 else centre


def envelope(time: np.ndarray, radius: np.ndarray, window: np.ndarray, before: float | None = None) -> np.ndarray:
    """The line through the peaks of ``radius``: valleys shorter than ``window`` are filled, slower changes are kept.

    All (N,); time is evenly spaced but for a few places. This is the morphological closing, the largest value within
    +-window/2 of each sample and then the smallest of those. It would also fill the lowest part of a slow, smooth minimum: such
    a one is distinguished from a valley between peaks by the slopes at its ends, and kept. Of a valley that an end of the
    record cuts only one peak is known: the line goes on from it as high as it is. before: what the radius was before the
    record, if that is known (0 of a motion that begins from rest): the line begins there.
    """
    n = len(time)
    if n < 4:
        return radius.copy()
    steps = time[1] - time[0], time[-1] - time[-2]
    beyond = int(min(np.ceil(window.max() / 2 / min(steps)), n - 1))
    first = _outermost(time[0] - time[::-1], radius[::-1], window[0]) if before is None else before
    ends = first, _outermost(time - time[-1], radius, window[-1])
    padded, reach = np.pad(radius, beyond, constant_values=ends), np.pad(window / 2, beyond, mode="edge")
    past, future = (step * np.arange(1, beyond + 1) for step in steps)
    times = np.concatenate([time[0] - past[::-1], time, time[-1] + future])
    rounding = _ROUNDING * min(steps)
    low = np.maximum(np.searchsorted(times, times - reach + rounding, side="right") - 1, 0)
    high = np.minimum(np.searchsorted(times, times + reach - rounding), len(times) - 1)
    closed = -_largest_within(-_largest_within(padded, low, high), low, high)
    return np.where(_smooth_minima(padded, closed > padded), padded, closed)[beyond : beyond + n]


def _outermost(time: np.ndarray, radius: np.ndarray, window: float) -> float:
    """How high the line is at the end of a record (N,), at time 0: its highest peak within a window of it, or it itself."""
    steps = np.flatnonzero(np.diff(radius))
    rises = radius[steps + 1] > radius[steps]
    peaks = steps[1:][rises[:-1] & ~rises[1:]]  # the last sample of each, which may be as high as those before
    late = peaks[time[np.minimum(peaks + 1, len(time) - 1)] > -window]
    return float(radius[late].max(initial=float(radius[-1])))


def _smooth_minima(radius: np.ndarray, filled: np.ndarray) -> np.ndarray:
    """Which filled samples (N,) lie in a parabolic minimum: its depth follows from the slopes outside its ends."""
    edges = np.flatnonzero(np.diff(filled.astype(int)))
    if filled[0]:
        edges = edges[1:]
    begin, end = edges[: len(edges) // 2 * 2 : 2], edges[1::2] + 1
    inside = (begin >= 1) & (end <= len(radius) - 2)
    begin, end = begin[inside], end[inside]
    slopes = radius[end + 1] - radius[end] + radius[begin - 1] - radius[begin]
    # The outer slopes belong to points half a sample outside: a parabola over h + 1 intervals.
    predicted = slopes * (end - begin) ** 2 / (8 * (end - begin + 1))
    actual = (radius[begin] + radius[end]) / 2 - radius[(begin + end) // 2]
    smooth = np.abs(predicted - actual) <= 0.25 * np.abs(actual)
    marks = np.zeros(len(radius) + 1, int)
    np.add.at(marks, begin[smooth], 1)
    np.add.at(marks, end[smooth] + 1, -1)
    return np.asarray(np.cumsum(marks)[:-1] > 0)


def _largest_within(signal: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Maximum of signal[low[i] : high[i] + 1] for each i: two overlapping blocks of length 2^k cover each range."""
    level = np.floor(np.log2(high - low + 1)).astype(int)
    largest, table = np.empty(len(signal)), signal
    for k in range(int(level.max()) + 1):
        if k:
            table = np.maximum(table[: -(2 ** (k - 1))], table[2 ** (k - 1) :])
        at_level = level == k
        largest[at_level] = np.maximum(table[low[at_level]], table[high[at_level] - 2**k + 1])
    return largest
