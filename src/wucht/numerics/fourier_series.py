"""Periodic functions of finitely many harmonics: f(x) = c0 + sum over k = 1 ... N of A_k cos k x + B_k sin k x."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any, Self

import numpy as np

from wucht.numerics.zeros_and_peaks import crossings

_MANY, _DENSE = 64, 16  # harmonics whose companion matrix takes too long; samples per harmonic that resolve all extrema
_BLOCK = 16  # powers of a wave that are multiplied out; higher ones follow from the last of them by Horner's scheme
_TINY = 1e-280  # amplitude of a function that counts as zero
_NEGLIGIBLE = 1e-15  # of the largest coefficient: smaller highest harmonics are rounding that spoils a companion matrix


def even_angles(count: int) -> np.ndarray:
    """Return angles (count,) of a turn, evenly spaced from 0."""
    return 2 * math.pi * np.arange(count) / count


def differentiation(count: int, order: int = 1) -> np.ndarray:
    """Return the matrix (n, n) that differentiates samples at ``even_angles``, n even; exact for harmonics below n/2.

    L. N. Trefethen, Spectral Methods in MATLAB, SIAM 2000, chapter 3.
    """
    wave = (1j * np.fft.rfftfreq(count, 1 / count)) ** order
    column, k = np.fft.irfft(wave, count), np.arange(count)  # odd orders drop the highest sine, which is zero at every point
    return np.asarray(column[(k[:, None] - k) % count])


@dataclass(frozen=True, eq=False)
class FourierSeries:
    """A periodic function. mean: c0. cosine, sine: A_k, B_k (N,), the first harmonic first; in the unit of the function."""

    mean: float
    cosine: np.ndarray
    sine: np.ndarray

    @classmethod
    def of(cls, mean: float, cosine: Sequence[float] | np.ndarray = (), sine: Sequence[float] | np.ndarray = ()) -> Self:
        """Build the function from lists of coefficients, the shorter one padded with zeros."""
        count = max(len(cosine), len(sine))
        a, b = (np.append(np.asarray(c, float), np.zeros(count - len(c))) for c in (cosine, sine))
        return cls(float(mean), a, b)

    @classmethod
    def from_samples(cls, values: np.ndarray) -> Self:
        """Compute all harmonics below M/2 from samples (M,) at x = 2 pi k/M."""
        spectrum = np.fft.rfft(values)[: (len(values) + 1) // 2] / len(values)
        return cls(float(spectrum[0].real), 2 * spectrum[1:].real, -2 * spectrum[1:].imag)

    def __call__(self, x: np.ndarray | float, order: int = 0) -> np.ndarray:
        """Evaluate the derivative of an order at x (any shape)."""
        coefficients = self._coefficients(order)
        blocks, width = coefficients.shape
        powers = np.cumprod(np.exp(1j * np.asarray(x, float))[..., np.newaxis].repeat(width, axis=-1), axis=-1)
        sums = powers @ coefficients.T
        total = sums[..., -1]
        for block in range(blocks - 2, -1, -1):
            total = total * powers[..., -1] + sums[..., block]
        return np.asarray(total.real + (self.mean if order == 0 else 0.0))

    def _coefficients(self, order: int) -> np.ndarray:
        """Return the coefficients of powers of exp(ix) of a derivative, in blocks, the last one padded with zeros."""
        width, k = min(_BLOCK, max(self.count, 1)), np.arange(1, self.count + 1)
        coefficients = np.zeros((-(-max(self.count, 1) // width), width), complex)
        coefficients.flat[: self.count] = (1j * k) ** order * (self.cosine - 1j * self.sine)
        return coefficients

    def to_table(self) -> dict[str, Any]:
        """Return the arguments of ``of``, as JSON has them."""
        return {"mean": self.mean, "cosine": self.cosine.tolist(), "sine": self.sine.tolist()}

    @property
    def count(self) -> int:
        """Number N of harmonics."""
        return len(self.cosine)

    @property
    def amplitudes(self) -> np.ndarray:
        """Amplitudes sqrt(A_k^2 + B_k^2) (N,)."""
        return np.asarray(np.hypot(self.cosine, self.sine))

    def derivative(self, order: int = 1) -> FourierSeries:
        """Differentiate by x, to an order of 0 or more."""
        series, k = self, np.arange(1, self.count + 1)
        for _ in range(order):
            series = FourierSeries(0.0, k * series.sine, -k * series.cosine)
        return series

    def without_rounding(self, share: float = _NEGLIGIBLE) -> FourierSeries:
        """Drop the highest harmonics that are all smaller than a share of the largest value."""
        limit = share * max(abs(self.mean), float(self.amplitudes.max(initial=0.0)))
        last = int(np.flatnonzero(self.amplitudes > limit).max(initial=-1)) + 1
        return FourierSeries(self.mean, self.cosine[:last], self.sine[:last])

    def shift(self, offset: float) -> FourierSeries:
        """Return f(x - offset)."""
        coefficients = (self.cosine - 1j * self.sine) * np.exp(-1j * offset * np.arange(1, self.count + 1))
        return FourierSeries(self.mean, coefficients.real, -coefficients.imag)

    def stationary(self) -> np.ndarray:
        """Return angles in [0, 2 pi), in order, that include all extrema of the function.

        They are the arguments of all roots of z^N f' as a polynomial, from its companion matrix. Roots off the unit circle are
        included: a double one is not computed on it, and a further candidate does no harm. For many harmonics they are the
        changes of sign of f'.
        """
        slope = self.derivative()
        last = np.flatnonzero(slope.amplitudes > _NEGLIGIBLE * slope.amplitudes.max(initial=_TINY))
        if not len(last):
            return np.zeros(1)
        if last[-1] >= _MANY:
            return crossings(slope, np.linspace(0, 2 * math.pi, _DENSE * (int(last[-1]) + 1) + 1))
        half = (slope.cosine - 1j * slope.sine)[: last[-1] + 1] / 2
        roots = np.roots([*half[::-1], 0.0, *half.conj()])
        return np.sort(np.mod(np.angle(roots), 2 * math.pi))

    @property
    def bounds(self) -> tuple[float, float]:
        """Least and greatest value, exactly."""
        values = self(self.stationary())
        return float(values.min()), float(values.max())

    @property
    def peak(self) -> float:
        """Largest magnitude."""
        return max(map(abs, self.bounds))
