"""Peaks between samples: what a sampled signal with known slopes reaches in between."""

from __future__ import annotations

import numpy as np


def interval_peaks(time: np.ndarray, signal: np.ndarray, slope: np.ndarray) -> np.ndarray:
    """The largest value that a signal reaches between each sample and its neighbours.

    All (N,). Between samples the signal is the cubic with the given values and slopes; the error is of fourth order in the
    sampling interval, where that of the largest sample is of second.
    """
    if len(time) < 2:
        return signal.copy()
    h = np.diff(time)
    left, right, a, b = signal[:-1], signal[1:], slope[:-1] * h, slope[1:] * h
    # y(s) = left + a s + c s^2 + d s^3 on 0 <= s <= 1
    d = 2 * (left - right) + a + b
    c = 3 * (right - left) - 2 * a - b
    top = np.maximum(left, right)
    with np.errstate(divide="ignore", invalid="ignore"):
        root = np.sqrt(c**2 - 3 * a * d)
        # The maximum is where y' = 0 and y'' < 0; this form of the root stays accurate as d -> 0.
        s = np.where(c > 0, (-c - root) / (3 * d), a / (root - c))
    inside = np.isfinite(s) & (s > 0) & (s < 1)
    s = np.where(inside, s, 0.0)
    between = np.where(inside, left + s * (a + s * (c + s * d)), top)
    found = np.maximum(top, between)
    around: np.ndarray = np.maximum(np.concatenate([found[:1], found]), np.concatenate([found, found[-1:]]))
    return around


def extremes(signal: np.ndarray) -> tuple[float, float]:
    """Least and largest value of an evenly sampled signal (N,), between samples by the parabola through three of them."""
    return -_vertex(-signal, int(signal.argmin())), _vertex(signal, int(signal.argmax()))


def _vertex(signal: np.ndarray, i: int) -> float:
    if not 0 < i < len(signal) - 1:
        return float(signal[i])
    before, here, after = (float(x) for x in signal[i - 1 : i + 2])
    curvature = before - 2 * here + after
    return here - (after - before) ** 2 / (8 * curvature) if curvature < 0 else here
