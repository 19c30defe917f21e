"""Order tracking: signals over the angle of a shaft instead of time."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.errors import InputError
from wucht.measurements.recording import Channel
from wucht.measurements.shaft_signal import TURN, ShaftSignal
from wucht.numerics.fourier_series import FourierSeries

_FINER = 2.0  # times the samples of a turn: so fine a signal is taken over angle before its high orders are cut off


@dataclass(frozen=True, eq=False)
class OrderSpectrum:
    """Spectrum over orders, in steps of 1 by the number of turns.

    Attributes
    ----------
    orders : numpy.ndarray, (k,)
    cosine, sine : numpy.ndarray, (k,)
        a, b of a cos(j phi) + b sin(j phi), in the unit of the signal.
    """

    orders: np.ndarray
    cosine: np.ndarray
    sine: np.ndarray

    @property
    def amplitudes(self) -> np.ndarray:
        """The amplitudes sqrt(a^2 + b^2) (k,)."""
        return np.asarray(np.hypot(self.cosine, self.sine))


@dataclass(frozen=True, eq=False)
class AngleSamples:
    """A signal at equal steps of the angle of a shaft, over whole turns, without orders of ``per_turn``/2 and above.

    Attributes
    ----------
    location : str
        File and channel.
    per_turn : int
        M.
    first : float
        The angle in rad of the first sample, whole turns.
    time : numpy.ndarray, (n,)
        In s, n = M turns.
    values : numpy.ndarray, (n,)
        In the unit of the signal.
    """

    location: str
    per_turn: int
    first: float
    time: np.ndarray
    values: np.ndarray

    @property
    def turns(self) -> int:
        """The number of turns."""
        return len(self.values) // self.per_turn

    @property
    def angle(self) -> np.ndarray:
        """The angle of the samples (n,), in rad."""
        return np.asarray(self.first + TURN / self.per_turn * np.arange(len(self.values)))

    def spectrum(self) -> OrderSpectrum:
        """Return the orders below M/2, also those between whole ones."""
        series, n = FourierSeries.from_samples(self.values), len(self.values)
        below = (n - 1) // 2
        orders = np.arange(below + 1) / self.turns
        return OrderSpectrum(orders, np.append(series.mean, series.cosine[:below]), np.append(0.0, series.sine[:below]))

    def mean_turn(self) -> FourierSeries:
        """Return the mean of all turns over the angle, which repeats with the shaft; all orders below M/2."""
        return FourierSeries.from_samples(self.values.reshape(self.turns, self.per_turn).mean(axis=0))


def track_orders(signal: Channel, shaft: ShaftSignal, per_turn: int) -> AngleSamples:
    """Resample a signal at equal angles of a shaft, 2 pi k/M from its zero, over all whole turns of both records.

    Cubic splines give t(phi) and the signal in between its samples. Orders of M/2 and above are cut off, not folded back.

    Parameters
    ----------
    signal : Channel
    shaft : ShaftSignal
        Recorded at the same time.
    per_turn : int
        M, 4 or more.

    Returns
    -------
    AngleSamples

    Raises
    ------
    InputError
        For M below 4 or above the samples of the fastest turn, an angle that does not increase, and less than a whole turn.
    """
    from scipy.interpolate import CubicSpline

    if isinstance(per_turn, bool) or int(per_turn) != per_turn or per_turn < 4:
        raise InputError(
            signal.location, per_turn, "the samples per turn must be a whole number, 4 or more", code="whole-number"
        )
    time, angle = _common_samples(signal, shaft)
    first = math.ceil(angle[0] / TURN - 1e-9)
    turns = math.floor(angle[-1] / TURN + 1e-9) - first
    if turns < 1:
        explanation = "signal and shaft must have a whole turn in common, from one zero of the angle to the next"
        raise InputError(signal.location, None, explanation, code="no-turn")
    fastest = float((np.diff(angle) / np.diff(time)).max())
    most = TURN / fastest / float(np.median(np.diff(signal.time)))
    if per_turn > most:
        explanation = f"the signal has {most:.3g} samples in the fastest turn; there must not be more per turn"
        raise InputError(signal.location, per_turn, explanation, code="too-few")
    finer = math.ceil(_FINER * most / per_turn)
    fine = per_turn * finer
    at = CubicSpline(angle, time)(TURN * (first + np.arange(turns * fine) / fine))
    if not (np.diff(at) > 0).all():
        raise InputError(
            shaft.location,
            None,
            "the angle is too noisy or too coarse: between its samples it appears to turn back",
            code="too-noisy",
        )
    at = np.clip(at, signal.time[0], signal.time[-1])
    values = _without_high_orders(CubicSpline(signal.time, signal.values)(at), turns * per_turn)
    return AngleSamples(signal.location, per_turn, TURN * first, at[::finer], values)


def _common_samples(signal: Channel, shaft: ShaftSignal) -> tuple[np.ndarray, np.ndarray]:
    """Return times and angles of the shaft within the signal's span."""
    time, angle = shaft.angle()
    if not (np.diff(angle) > 0).all():
        explanation = "the angle must increase all the time for order tracking; smooth it, or reverse its sign"
        raise InputError(shaft.location, None, explanation, code="turns-back")
    low, high = max(time[0], signal.time[0]), min(time[-1], signal.time[-1])
    inside = (time >= low) & (time <= high)
    if inside.sum() < 4:
        raise InputError(
            signal.location,
            None,
            f"signal and shaft must be recorded at the same time; {shaft.location} is not",
            code="other-times",
        )
    return time[inside], angle[inside]


def _without_high_orders(values: np.ndarray, count: int) -> np.ndarray:
    """Subsample whole turns to ``count`` samples, with the harmonics below count/2 alone."""
    spectrum = np.fft.rfft(values)[: (count + 1) // 2]
    return np.asarray(np.fft.irfft(spectrum, count) * (count / len(values)))
