"""The output on a spring: its motion for a motion of the lever, its residual vibration in dwells, and the lever tuned for it.

Between the lever, which the cam moves, and the mass of the output stand one spring and one damper: the kinetoelastic part of
004, section 4. Motions are series over tau = omega t, the time of a turn as an angle; all numbers are in SI, a motion in rad
with kg m^2, N m/rad, N m s/rad, or in m with kg, N/m, N s/m.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.cams.demands import require_not_negative, require_positive
from wucht.cams.laws import Law
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries

_DENSE = 16  # samples for each turn of the highest order: two extrema between two of them differ by nothing that counts
_BLOCK = 64  # series that are evaluated together, so that memory stays small
_STEPS = 5  # of Newton's method, from a sample beside the extremum
_TURN = 2 * math.pi
_NEGLIGIBLE = 1e-13  # of the largest order: orders of a motion that are rounding
_AT_RESONANCE = 1e-12  # of the natural frequency squared: nearer to it than rounding can tell
_MOST = 20.0  # of |H| and of 1/|H|: an order 2.5 % from the resonance, or 4.6 times above it


def largest_on_arc(begin: float, arc: float, mean: np.ndarray, waves: np.ndarray) -> np.ndarray:
    """The largest |c0 + Re sum z_k exp(i k x)| (M,) for x from begin on over an arc in rad, ends included, to rounding.

    mean: c0 (M,). waves: z_k = A_k - i B_k (M, N), the first order first. At its extrema, by Newton's method, or at an end.
    """
    k = np.arange(1, waves.shape[1] + 1)
    x = begin + np.linspace(0.0, arc, 2 + math.ceil(_DENSE * len(k) * arc / (2 * math.pi)))
    basis = np.exp(1j * np.outer(k, x))
    blocks = range(0, len(mean), _BLOCK)
    maxima = [_largest(x, basis, mean[i : i + _BLOCK], waves[i : i + _BLOCK]) for i in blocks]
    return np.concatenate(maxima) if maxima else np.empty(0)


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


@dataclass(frozen=True)
class Dwell:
    """Arc on which the output rests: begin to end, in rad of tau (an end below its begin is one turn later), at a value."""

    begin: float
    end: float
    value: float = 0.0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.begin) and math.isfinite(self.end) and abs(self.end - self.begin) <= _TURN):
            raise InputError("dwell", [self.begin, self.end], "must be two angles in rad, at most a turn apart: begin and end")
        if not math.isfinite(self.value):
            raise InputError("dwell.value", self.value, "must be a finite number")

    @property
    def last(self) -> float:
        """The end of the arc in rad, never below its begin."""
        return self.end if self.end >= self.begin else self.end + _TURN

    def largest(self, series: FourierSeries) -> float:
        """The largest magnitude of a function on the arc, exactly: at its extrema or at an end."""
        return float(self.largest_of(np.array([series.mean]), _waves(series)[np.newaxis])[0])

    def largest_of(self, mean: np.ndarray, waves: np.ndarray) -> np.ndarray:
        """Return the largest magnitudes of many series at once (M,): see ``largest_on_arc``."""
        return largest_on_arc(self.begin, self.last - self.begin, mean, waves)


@dataclass(frozen=True)
class ElasticOutput:
    """J psi_o'' + b (psi_o' - psi_l') + c (psi_o - psi_l) = 0: output psi_o, lever psi_l.

    inertia: J > 0. stiffness: c > 0. damping: b >= 0. Raises ``InputError`` (output.inertia, output.stiffness,
    output.damping).
    """

    inertia: float
    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        require_positive("output.inertia", self.inertia)
        require_positive("output.stiffness", self.stiffness)
        require_not_negative("output.damping", self.damping)

    @property
    def natural_frequency(self) -> float:
        """omega_0 = sqrt(c/J), in rad/s."""
        return math.sqrt(self.stiffness / self.inertia)

    @property
    def damping_ratio(self) -> float:
        """b/(2 sqrt(c J))."""
        return self.damping / (2 * math.sqrt(self.stiffness * self.inertia))

    def response(self, frequency: np.ndarray | float) -> np.ndarray:
        """H = (c + i w b)/(c - J w^2 + i w b) at w in rad/s (any shape), complex; infinite at an undamped resonance."""
        coupling, dynamic = self._stiffnesses(frequency)
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.where(dynamic == 0, np.inf, coupling / dynamic))

    def steady(self, lever: FourierSeries, omega: float) -> FourierSeries:
        """The motion of the output at a mean speed omega in rad/s, when all else has decayed.

        Raises ``InputError``: a speed that is not positive, an order of the lever at the resonance without damping.
        """
        coupling, dynamic = self._order_stiffnesses(lever, omega)
        return _multiplied_series(lever, lever.mean, coupling / dynamic)

    def elastic_part(self, lever: FourierSeries, omega: float) -> FourierSeries:
        """The kinetoelastic part: output less lever, without loss of digits where it is small. Raises as ``steady``."""
        coupling, dynamic = self._order_stiffnesses(lever, omega)
        return _multiplied_series(lever, 0.0, (coupling - dynamic) / dynamic)

    def tuned_lever(self, law: FourierSeries, omega: float, most: float = _MOST) -> FourierSeries:
        """The motion of the lever with which the output makes the law exactly, at this speed.

        Parameters
        ----------
        law : FourierSeries, of the output
        omega : float, in rad/s
        most : float, above 1
            The largest accepted |H_k| and 1/|H_k| of an order of the law. Near a resonance the lever must nearly rest in
            that order, and a small error of speed or stiffness spoils the motion; far above it the lever must exaggerate.

        Raises ``InputError`` (law): an order beyond ``most``; (most); (omega): a speed that is not positive.
        """
        if not most > 1:
            raise InputError("most", most, "must be above 1")
        coupling, dynamic = self._stiffnesses(_frequencies(law.count, omega))
        inverse = dynamic / coupling
        present, size = _present(law), np.abs(inverse)
        bad = np.flatnonzero(present & ((size <= max(1 / most, _AT_RESONANCE)) | (size > most)))
        if len(bad):
            k = int(bad[0]) + 1
            ratio = k * omega / self.natural_frequency
            near = bool(size[bad[0]] < 1)
            reason = "too near the resonance" if near else "too far above the resonance"
            requirement = (
                f"its order {k} lies at {ratio:.4g} times the natural frequency of the output, {reason} to tune the lever to "
                f"it: choose another speed, a stiffer output, or a law without this order"
            )
            raise InputError("law", None, requirement, code="near-resonance" if near else "above-resonance")
        return _multiplied_series(law, law.mean, inverse)

    def residual(self, lever: FourierSeries, omega: float, dwells: Sequence[Dwell]) -> tuple[float, float]:
        """Return the residual vibration, exactly: the largest values in the dwells. Raises as ``steady``, and without a dwell.

        They are the deviation of the output from its rest position, in its unit, and its acceleration, per s^2.
        """
        deviation, acceleration = self.residual_over_speed(lever, np.array([omega]), dwells)
        return float(deviation[0]), float(acceleration[0])

    def resonances(self, lever: FourierSeries, low: float, high: float) -> tuple[np.ndarray, np.ndarray]:
        """Return the orders k of the lever (R,) that meet the natural frequency between two speeds, and where: omega_0/k."""
        orders = np.flatnonzero(_present(lever)) + 1
        speeds = self.natural_frequency / orders
        within = (speeds >= low) & (speeds <= high)
        return orders[within], speeds[within]

    def residual_over_speed(
        self, lever: FourierSeries, speeds: np.ndarray, dwells: Sequence[Dwell]
    ) -> tuple[np.ndarray, np.ndarray]:
        """Return the residual vibration of one lever at each mean speed in rad/s (M,). Raises as ``residual``."""
        if not len(speeds):
            raise InputError("speeds", None, "there must be at least one speed")
        if not dwells:
            raise InputError("dwells", None, "there must be a dwell in which the residual vibration is evaluated")
        waves, k = np.stack([_waves(self.steady(lever, float(omega))) for omega in speeds]), np.arange(1, lever.count + 1)
        mean, zeros = np.full(len(speeds), lever.mean), np.zeros(len(speeds))
        deviations = [d.largest_of(mean - d.value, waves) for d in dwells]
        accelerations = [d.largest_of(zeros, k**2 * waves) for d in dwells]
        return np.max(deviations, axis=0), speeds**2 * np.max(accelerations, axis=0)

    def weights(self, count: int, omega: float, power: float = 2.0) -> np.ndarray:
        """Return k^power |H_k| (N,), for ``synthesise``: 2 gives the law with the least rms acceleration of the output.

        Raises ``InputError``: a speed that is not positive, an order at the resonance without damping.
        """
        coupling, dynamic = self._order_stiffnesses(FourierSeries.of(0.0, np.ones(count)), omega)
        return np.asarray(np.arange(1, count + 1) ** power * np.abs(coupling / dynamic))

    def _stiffnesses(self, frequency: np.ndarray | float) -> tuple[np.ndarray, np.ndarray]:
        """c + i w b, by which the lever moves the output, and c - J w^2 + i w b, by which the output resists."""
        w = np.asarray(frequency, float)
        coupling = self.stiffness + 1j * w * self.damping
        return coupling, coupling - self.inertia * w**2

    def _order_stiffnesses(self, lever: FourierSeries, omega: float) -> tuple[np.ndarray, np.ndarray]:
        """Return both stiffnesses at the orders of a lever (N,), neither zero."""
        coupling, dynamic = self._stiffnesses(_frequencies(lever.count, omega))
        resonant = np.abs(dynamic) <= _AT_RESONANCE * self.stiffness
        present = _present(lever)
        if (resonant & present).any():
            k = int(np.flatnonzero(resonant & present)[0]) + 1
            requirement = f"order {k} of the lever meets the natural frequency of an output without damping, which then has no"
            raise InputError("omega", omega, f"{requirement} steady motion: give damping, or another speed", code="resonance")
        return coupling, np.where(resonant, 1.0, dynamic)


def _frequencies(count: int, omega: float) -> np.ndarray:
    """k omega (N,)."""
    if not (math.isfinite(omega) and omega > 0):
        raise InputError("omega", omega, "the mean speed must be a positive number of rad/s", code="not-positive")
    return np.arange(1, count + 1) * omega


def _present(series: FourierSeries) -> np.ndarray:
    """Return True for each order that is not negligible (N,)."""
    return np.asarray(series.amplitudes > _NEGLIGIBLE * series.amplitudes.max(initial=0.0))


def _multiplied_series(series: FourierSeries, mean: float, by: np.ndarray) -> FourierSeries:
    """Return the series of Re (A_k - i B_k) exp(i k tau), each order multiplied by a complex number (N,)."""
    product = _waves(series) * by
    return FourierSeries(mean, product.real, -product.imag)


def _waves(series: FourierSeries) -> np.ndarray:
    """A_k - i B_k (N,)."""
    return np.asarray(series.cosine - 1j * series.sine)


def truncate_law(law: Law, count: int, samples: int | None = None) -> FourierSeries:
    """The first orders of a law that has infinitely many, such as 3-4-5, over tau.

    samples: of a turn; by default 256 count, at least 16384. What aliases into the series is as large as the orders
    about that number. Raises ``InputError`` (orders): none, or not below half of the samples.
    """
    samples = max(256 * count, 16384) if samples is None else samples
    if not 1 <= count < samples / 2:
        raise InputError("orders", count, f"must be at least 1 and below half of the {samples} samples of a turn")
    whole = FourierSeries.from_samples(law(_TURN * np.arange(samples) / samples))
    return FourierSeries(whole.mean, whole.cosine[:count], whole.sine[:count])


Levers = Mapping[str, tuple[FourierSeries, tuple[Dwell, ...]]]  # motions of the lever, and dwells of the output, over tau


@dataclass(frozen=True, eq=False)
class Excitation:
    """Vibration that a motion of the lever excites. deviation, acceleration: see ``ElasticOutput.residual``. peak: the largest
    acceleration of the output, exactly, per s^2."""

    name: str
    deviation: float
    acceleration: float
    peak: float


def ranked_excitations(output: ElasticOutput, levers: Levers, omega: float) -> tuple[Excitation, ...]:
    """Return the vibration that each lever excites at a mean speed in rad/s, that with the least deviation in dwells first.

    Raises ``InputError`` as ``ElasticOutput.residual``, with the name of the motion.
    """
    excitations = list[Excitation]()
    for name, (lever, dwells) in levers.items():
        try:
            deviation, acceleration = output.residual(lever, omega, dwells)
        except InputError as error:
            raise error.with_prefix(name, ": ") from None
        peak = omega**2 * output.steady(lever, omega).derivative(2).peak
        excitations.append(Excitation(name, deviation, acceleration, peak))
    return tuple(sorted(excitations, key=lambda e: e.deviation))
