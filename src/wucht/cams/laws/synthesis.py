"""Harmonic synthesis: the motion of finitely many harmonics that satisfies restrictions and is the best of those that do.

A derivative of psi = c0 + sum A_k cos k phi + B_k sin k phi at an angle is linear in x = (c0, A_1 ... A_N, B_1 ... B_N): every
restriction is too. One that holds on an arc is enforced between the sampled angles by exchange: where the solution violates
it, at an extremum of that derivative, the angle is added, and the programme solved again.

Dwell motions known in closed form are beside it: a rise by a stroke at pi, and a dwell about 0.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.cams.laws.cone_programme import REMEDY, InfeasibleError, Programme, solve_cone_programme
from wucht.errors import RunError
from wucht.numerics.fourier_series import FourierSeries
from wucht.numerics.zeros_and_peaks import fewest_where

_PER_HARMONIC = 6  # angles on a whole turn that are sampled first, times the number of harmonics
_VIOLATION = 1e-6  # of the bound: a smaller excess is no violation
_ROUNDING = 1e-13  # of the largest value
_ENOUGH = 1e-9  # of the largest bound: a widening that need not be smaller
_STEP, _FALLING = 4, 0.5  # harmonics tried first, then so many more while the widening falls to such a share
_MOST_EXCHANGES = 40


def equiripple(count: int, half_dwell: float, stroke: float = 1.0) -> FourierSeries:
    """Return the flattest motion of so many harmonics: on |phi| <= half_dwell it goes to and fro as little as possible.

    It is stroke T_N(u(phi))/T_N(u(pi)), with Chebyshev's polynomial and u linear in cos phi, such that |u| <= 1 on the dwell:
    so far as stroke/T_N((3 + c)/(1 - c)), c = cos half_dwell.

    Parameters
    ----------
    count : int
        N, the number of harmonics.
    half_dwell : float
        In rad, from 0 to pi.
    stroke : float, optional
        The motion at pi.

    Returns
    -------
    FourierSeries
        A law.
    """
    c = math.cos(half_dwell)
    phi = 2 * math.pi * np.arange(2 * count + 1) / (2 * count + 1)
    polynomial = np.polynomial.Chebyshev.basis(count)
    top = polynomial(-(3 + c) / (1 - c))
    return FourierSeries.from_samples(stroke * polynomial((2 * np.cos(phi) - 1 - c) / (1 - c)) / top)


def maximally_flat(count: int, stroke: float = 1.0) -> FourierSeries:
    """Return stroke sin^(2N)(phi/2), the motion of N harmonics that is flattest at 0.

    Of its derivatives there all vanish below that of order 2 N.

    Parameters
    ----------
    count : int
        N, the number of harmonics.
    stroke : float, optional
        The motion at pi.

    Returns
    -------
    FourierSeries
        A law.
    """
    k = np.arange(count + 1)
    terms = np.array([math.comb(2 * count, count - int(i)) for i in k]) / 4**count * (-1.0) ** k
    return FourierSeries.of(stroke * terms[0], 2 * stroke * terms[1:])


@dataclass(frozen=True)
class Band:
    """Bounds of a derivative on an arc: a precision point where the arc is one angle and both bounds are the same.

    Parameters
    ----------
    name : str
        Its name in messages.
    order : int
        Of the derivative, from 0.
    begin, end : float
        Of the arc, in rad; at most a turn apart.
    low, high : float
        In the unit of the motion, infinite where there is no bound.
    is_widened : bool, optional
        By the minimised widening, both sides.
    """

    name: str
    order: int
    begin: float
    end: float
    low: float
    high: float
    is_widened: bool = False

    @property
    def is_exact(self) -> bool:
        """True if it is a precision point that is not widened."""
        return self.begin == self.end and self.low == self.high and not self.is_widened

    @property
    def size(self) -> float:
        """Scale of the bounds: the width of the band, or the bound."""
        width = self.high - self.low
        sizes = [width] if math.isfinite(width) else [abs(b) for b in (self.low, self.high) if math.isfinite(b)]
        return max(sizes, default=0.0)


@dataclass(frozen=True)
class Cap:
    """Largest permitted amplitude of a harmonic, likewise."""

    name: str
    harmonic: int
    size: float
    is_widened: bool = False


Restriction = Band | Cap


@dataclass(frozen=True, eq=False)
class Synthesis:
    """law: the motion. widening: the amount by which restrictions that are to be as tight as possible are widened."""

    law: FourierSeries
    widening: float


def synthesise(
    count: int, restrictions: Sequence[Restriction], weights: Sequence[float] | np.ndarray | None = None
) -> Synthesis:
    """Synthesise the best motion of so many harmonics that satisfies restrictions.

    Parameters
    ----------
    count : int
        N, the number of harmonics.
    restrictions : sequence of Band and Cap
    weights : numpy.ndarray, (N,), optional
        The root of the sum of (w_k A_k)^2 + (w_k B_k)^2 is minimised; without weights the widening of restrictions.

    Returns
    -------
    Synthesis
        Its ``law`` is the motion, ``widening`` the amount by which restrictions are widened.

    Raises
    ------
    InfeasibleError
        Where no motion satisfies all restrictions: see ``single_relaxations``.
    RunError
        Where the solver fails.

    Examples
    --------
    >>> import math
    >>> from wucht.cams import Band, synthesise
    >>> stroke = Band("stroke", 0, math.pi, math.pi, 1.0, 1.0)
    >>> dwell = Band("dwell", 0, -1.0, 1.0, 0.0, 0.0, is_widened=True)
    >>> print(f"{synthesise(4, [stroke, dwell]).widening:.1e}")
    3.6e-05
    """
    few = _with_fewest_harmonics(count, restrictions) if weights is None else None
    try:
        return few or _solve_by_exchange(count, restrictions, weights)
    except RunError:
        # Some contradictions leave the solver undecided: widened together by a small amount, restrictions have a motion.
        together = [replace(r, is_widened=True) for r in restrictions if not r.is_widened]
        if together and _solve_by_exchange(count, together, None).widening > _VIOLATION * _largest_bound(together):
            raise InfeasibleError from None
        raise


def _largest_bound(restrictions: Sequence[Restriction]) -> float:
    bounds = [limit for r in restrictions for limit in ((r.low, r.high) if isinstance(r, Band) else (r.size,))]
    return max((abs(limit) for limit in bounds if math.isfinite(limit)), default=0.0)


def _with_fewest_harmonics(count: int, restrictions: Sequence[Restriction]) -> Synthesis | None:
    """Return the synthesis of the fewest harmonics with negligible widening, those above being zero; None where all count.

    With more harmonics rounding would hide the widening, and some admissible motions oscillate strongly elsewhere.
    """
    enough = _ENOUGH * _largest_bound(restrictions)

    def attempt(trial_count: int) -> Synthesis | None:
        applicable = [r for r in restrictions if isinstance(r, Band) or r.harmonic <= trial_count]
        try:
            return _solve_by_exchange(trial_count, applicable, None)
        except (InfeasibleError, RunError):
            return None

    def is_enough(trial_count: int) -> bool:
        trial = attempt(trial_count)
        return trial is not None and trial.widening <= enough

    before = math.inf
    for trial_count in range(_STEP, count, _STEP):
        trial = attempt(trial_count)
        if trial is not None and trial.widening <= enough:
            best = attempt(fewest_where(is_enough, trial_count - _STEP, trial_count)) or trial
            zeros = np.zeros(count - best.law.count)
            padded_law = FourierSeries(best.law.mean, np.append(best.law.cosine, zeros), np.append(best.law.sine, zeros))
            return Synthesis(padded_law, best.widening)
        if trial is not None and trial.widening > _FALLING * before:
            return None
        before = math.inf if trial is None else trial.widening
    return None


def _solve_by_exchange(
    count: int, restrictions: Sequence[Restriction], weights: Sequence[float] | np.ndarray | None
) -> Synthesis:
    bands = [r for r in restrictions if isinstance(r, Band)]
    caps = [(c.harmonic, count + c.harmonic, c.size, float(c.is_widened)) for c in restrictions if isinstance(c, Cap)]
    diagonal = None if weights is None else np.concatenate([[0.0], weights, weights])
    points = np.array([band.begin for band in bands if band.is_exact])
    angles = [_first_angles(band, count, points) for band in bands]
    widening = 0.0
    for _ in range(_MOST_EXCHANGES):
        x, widening = solve_cone_programme(
            _programme(count, bands, angles, caps, diagonal), widening if weights is None else 0.0
        )
        law = FourierSeries(float(x[0]), x[1 : count + 1], x[count + 1 :])
        violations = [_violations(band, law, widening) for band in bands]
        if not any(len(b) for b in violations):
            return Synthesis(law, max((_needed_widening(r, law) for r in restrictions if r.is_widened), default=0.0))
        angles = [np.append(previous, new) for previous, new in zip(angles, violations, strict=True)]
    raise RunError(
        f"the motion law still violates restrictions after {_MOST_EXCHANGES} steps of the exchange algorithm: {REMEDY}"
    )


def _needed_widening(restriction: Restriction, law: FourierSeries) -> float:
    """Return the widening that a restriction needs for a motion to satisfy it, exactly."""
    if isinstance(restriction, Cap):
        return max(float(law.amplitudes[restriction.harmonic - 1]) - restriction.size, 0.0)
    least, greatest = band_extremes(restriction, law)
    return max(greatest - restriction.high, restriction.low - least, 0.0)


def band_extremes(band: Band, law: FourierSeries) -> tuple[float, float]:
    """Return the least and the greatest value of the derivative on the arc of a band, exactly."""
    derivative = law.derivative(band.order)
    values = derivative(np.array([band.begin, band.end, *_extremal_angles(band, derivative)]))
    return float(values.min()), float(values.max())


def _extremal_angles(band: Band, derivative: FourierSeries) -> np.ndarray:
    """Return the angles on the arc of a band at which its derivative may have extrema."""
    at = band.begin + np.mod(derivative.stationary() - band.begin, 2 * math.pi)
    return np.asarray(at[at < band.end])


def _programme(
    count: int,
    bands: Sequence[Band],
    angles: Sequence[np.ndarray],
    caps: Sequence[tuple[int, int, float, float]],
    weights: np.ndarray | None,
) -> Programme:
    exact = [_rows(count, band.order, a) for band, a in zip(bands, angles, strict=True) if band.is_exact]
    targets = [np.full(len(a), band.low) for band, a in zip(bands, angles, strict=True) if band.is_exact]
    rows, bounds, widths = [np.zeros((0, 2 * count + 1))], [np.zeros(0)], [np.zeros(0)]
    for band, a in zip(bands, angles, strict=True):
        for sign, limit in ((1.0, band.high), (-1.0, -band.low)):
            if not band.is_exact and math.isfinite(limit):
                rows.append(sign * _rows(count, band.order, a))
                bounds.append(np.full(len(a), limit))
                widths.append(np.full(len(a), float(band.is_widened)))
    equal = np.vstack([np.zeros((0, 2 * count + 1)), *exact])
    return Programme(
        equal,
        np.concatenate([np.zeros(0), *targets]),
        np.vstack(rows),
        np.concatenate(bounds),
        np.concatenate(widths),
        caps,
        weights,
    )


def _rows(count: int, order: int, phi: np.ndarray) -> np.ndarray:
    """g with psi^(p)(phi) = g x (K, 2 N + 1)."""
    k = np.arange(1, count + 1)
    phase = np.multiply.outer(phi, k) + order * math.pi / 2
    mean = np.full((len(phi), 1), float(order == 0))
    return np.hstack([mean, k**order * np.cos(phase), k**order * np.sin(phase)])


def _first_angles(band: Band, count: int, points: np.ndarray) -> np.ndarray:
    """Return even angles over the arc, its ends among them, and the precision points on it, which may contradict it."""
    arc = band.end - band.begin
    intervals = math.ceil(_PER_HARMONIC * count * arc / (2 * math.pi))
    on = band.begin + np.mod(points - band.begin, 2 * math.pi)
    return np.append(np.linspace(band.begin, band.end, intervals + 1), on[(on > band.begin) & (on < band.end)])


def _violations(band: Band, law: FourierSeries, widening: float) -> np.ndarray:
    """Return the extrema on the arc at which the motion violates a band."""
    if band.begin == band.end:
        return np.zeros(0)
    derivative = law.derivative(band.order)
    at = _extremal_angles(band, derivative)
    by = widening if band.is_widened else 0.0
    values = derivative(at)
    tolerance = _VIOLATION * (by or band.size) + _ROUNDING * derivative.peak
    beyond = np.maximum(values - band.high, band.low - values) - by
    return np.asarray(at[beyond > tolerance])


def single_relaxations(count: int, restrictions: Sequence[Restriction]) -> tuple[tuple[Restriction, float], ...]:
    """Return the relaxations of single restrictions that remove a contradiction, each with its amount, the smallest first.

    Smallest: as a share of the bound. Empty where more than one restriction must be relaxed.
    """
    relaxations = list[tuple[Restriction, float]]()
    strict_restrictions = [replace(r, is_widened=False) for r in restrictions]
    for k, restriction in enumerate(strict_restrictions):
        alone = [*strict_restrictions[:k], replace(restriction, is_widened=True), *strict_restrictions[k + 1 :]]
        try:
            relaxations.append((restriction, synthesise(count, alone).widening))
        except (InfeasibleError, RunError):
            continue
    return tuple(sorted(relaxations, key=lambda way: way[1] / (way[0].size or way[1] or 1.0)))
