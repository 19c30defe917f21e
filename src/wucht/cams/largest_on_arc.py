"""The largest magnitude on an arc of many series with the same orders: those of one lever at many speeds, all at once."""

from __future__ import annotations

import math

import numpy as np

_DENSE = 16  # samples for each turn of the highest order: two extrema between two of them differ by nothing that counts
_BLOCK = 64  # series that are looked at together, so that memory stays small
_STEPS = 5  # of Newton's method, from a sample beside the extremum


def largest_on_arc(begin: float, arc: float, mean: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """The largest |c0 + Re sum z_k exp(i k x)| (M,) for x from begin on over an arc in rad, ends included, to rounding.

    mean: c0 (M,). waves: z_k = A_k - i B_k (M, N), the first order first. At its extrema, by Newton's method, or at an end.
    """
    k = np.arange(1, waves.shape[1] + 1)
    x = begin + np.linspace(0.0, arc, 2 + math.ceil(_DENSE * len(k) * arc / (2 * math.pi)))
    basis = np.exp(1j * np.outer(k, x))
    blocks = range(0, len(mean), _BLOCK)
    found = [_largest(x, basis, mean[i : i + _BLOCK], waves[i : i + _BLOCK]) for i in blocks]
    return np.concatenate(found) if found else np.empty(0)


def _largest(x: np.ndarray, basis: np.ndarray, mean: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """As ``largest_on_arc``, x (G,) being the samples and basis exp(i k x) (N, G)."""
    size = np.abs(mean[:, None] + (waves @ basis).real)
    largest = size.max(axis=1)
    beside = np.pad(size, ((0, 0), (1, 1)), constant_values=-1.0)
    series, at = np.nonzero((size >= beside[:, :-2]) & (size >= beside[:, 2:]))
    low, near, high = x[np.maximum(at - 1, 0)], x[at], x[np.minimum(at + 1, len(x) - 1)]
    k, z = np.arange(1, waves.shape[1] + 1), waves[series]
    for _ in range(_STEPS):
        wave = z * np.exp(1j * near[:, None] * k)
        slope, bend = -(wave.imag @ k), -(wave.real @ k**2)
        step = np.divide(slope, bend, out=np.zeros(len(near)), where=bend != 0)
        near = np.clip(near - step, low, high)
    peaks = np.abs(mean[series] + (z * np.exp(1j * near[:, None] * k)).real.sum(axis=1))
    np.maximum.at(largest, series, peaks)
    return np.asarray(largest)
