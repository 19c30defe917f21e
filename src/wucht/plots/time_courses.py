"""Signals of a rotating machine over a run: means over whole turns with the range about them, phases, and the part drawn.

A signal that swings within a turn is drawn as the mean over windows of whole turns, each at least a hundredth of the panel
wide, and as a band between the least and the greatest value in them. Neither depends on how the samples meet the swings.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from wucht.plots.curves import angle_panel, thin_curve, without_jumps

if TYPE_CHECKING:
    from matplotlib.axes import Axes

SETTLED_SHARE = 1.5  # times the settling time: until then a run is drawn
_PERIODS = 3  # of a modulation, at least
_WHOLE = 0.8  # of a run: a larger part is drawn as the whole
_MOST_KNOTS, _FEWEST_WINDOWS, _LONGEST = 1200, 100, 8  # in a panel; a window is at most its eighth
_VISIBLE, _TINY = 0.01, 1e-300  # of the range of a signal: smaller swings are drawn as they are, those twice as large as a band
_BAND: dict[str, Any] = {"alpha": 0.25, "linewidth": 0, "zorder": 1.5}
_SYNCHRONOUS, _SLOW = 0.5, math.pi / 2  # length of the mean of exp(i phase), and change of a phase within a window
_LATE = 0.1  # of the panel
_ROUNDING = 1e-6  # of a turn
RANGE = "least to greatest"


def shown_until(summaries: Iterable[Mapping[str, Any]], end: float) -> float:
    """The end of what is drawn: 1.5 times the settling time of speed and amplitude, and three periods of a modulation.

    Parameters
    ----------
    summaries : iterable of mapping
        Summaries with ``settling_time``, ``amplitude_settling_time`` (None for an amplitude that beats for ever) and
        ``modulation_period``, each a number in the unit of ``end`` or None.
    end : float
        The end of the longest run.

    Returns
    -------
    float
        ``end`` where a run has not settled, or where less than a fifth would be left out.
    """
    until = 0.0
    for summary in summaries:
        speed, amplitude, period = (
            _number(summary.get(key)) for key in ("settling_time", "amplitude_settling_time", "modulation_period")
        )
        if not speed > 0:
            return end
        settled = max(speed, amplitude) if amplitude > 0 else speed
        until = max(until, SETTLED_SHARE * settled, settled + _PERIODS * (period if period > 0 else 0.0))
    return until if 0 < until < _WHOLE * end else end


def _number(value: Any) -> float:
    """A number of a summary; NaN where it has none, or was edited to be none."""
    return float(value) if isinstance(value, int | float) else math.nan


@dataclass(frozen=True)
class TurnWindows:
    """TurnWindows of whole turns about points of a panel.

    Attributes
    ----------
    x : numpy.ndarray
        Abscissae (N,) of the samples, increasing.
    at : numpy.ndarray
        Points (K,) of the panel, the middles of windows.
    begin, end : numpy.ndarray
        The windows (K,); shorter towards the start of the run, and the last one alike up to its end.
    """

    x: np.ndarray
    at: np.ndarray
    begin: np.ndarray
    end: np.ndarray

    @classmethod
    def of(cls, x: np.ndarray, angle: np.ndarray, until: float) -> Self:
        """TurnWindows of whole turns of a rotor.

        Parameters
        ----------
        x : numpy.ndarray
            Abscissae (N,) of the samples, increasing.
        angle : numpy.ndarray
            Angle (N,) of the rotor, rad.
        until : float
            End of the panel.

        Returns
        -------
        TurnWindows
        """
        span, turn_counts = until - x[0], np.append(0.0, np.cumsum(np.abs(np.diff(angle)))) / (2 * math.pi)
        at = x[x <= until] if np.count_nonzero(x <= until) <= _MOST_KNOTS else np.linspace(x[0], until, _MOST_KNOTS)
        middle, last = np.interp(at, x, turn_counts), turn_counts[-1]
        inner = np.clip(middle, 0.5, max(last - 0.5, 0.5))
        turn = np.interp(inner + 0.5, turn_counts, x) - np.interp(inner - 0.5, turn_counts, x)
        needed = span / _FEWEST_WINDOWS / np.maximum(turn, 1e-9 * span) if span > 0 else np.ones(len(at))
        count = np.ceil(needed - _ROUNDING)  # else a turn of just this width would be one or two
        half = np.minimum(np.maximum(count, 1.0) / 2, middle)
        middle = np.maximum(np.minimum(middle, last - half), half)
        shortest = np.maximum(at - span / 2 / _LONGEST, x[0]), np.minimum(at + span / 2 / _LONGEST, x[-1])
        begin, end = np.interp(middle - half, turn_counts, x), np.interp(middle + half, turn_counts, x)
        return cls(x, at, np.maximum(begin, np.minimum(shortest[0], end)), np.minimum(end, np.maximum(shortest[1], begin)))

    @classmethod
    def even(cls, x: np.ndarray, until: float) -> Self:
        """TurnWindows of a hundredth of the panel, for a signal whose turns are not known; see ``of``."""
        return cls.of(x, 2 * math.pi * _FEWEST_WINDOWS * (x - x[0]) / ((until - x[0]) or 1.0), until)

    def means(self, y: np.ndarray) -> np.ndarray:
        """Means (K,) of a signal (N,) over the windows; its value where a window has no width."""
        integral = np.append(0.0, np.cumsum((y[1:] + y[:-1]) / 2 * np.diff(self.x)))
        return np.asarray(np.where(self.end > self.begin, self.slopes(integral), np.interp(self.at, self.x, y)))

    def slopes(self, y: np.ndarray) -> np.ndarray:
        """Mean slopes (K,) of a signal (N,) over the windows, 0 where one has no width."""
        rise = np.interp(self.end, self.x, y) - np.interp(self.begin, self.x, y)
        width = self.end - self.begin
        return np.asarray(np.divide(rise, width, out=np.zeros(len(rise)), where=width > 0))

    def rates(self, y: np.ndarray) -> np.ndarray:
        """Mean slopes (K,) of a signal (N,), such as the speed of an angle: exact, however few samples of it there are."""
        return self.at_least(1 / 2 / _FEWEST_WINDOWS).slopes(y)

    def extremes(self, y: np.ndarray, mean: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The least and the greatest value (K,) of a signal (N,) in the windows along its mean (K,), smoothed."""
        off, windows = y - np.interp(self.x, self.at, mean), _slices(self.x, self.begin, self.end)
        limits = np.array([(a.min(), a.max(), b.min(), b.max()) for a, b in ((off[w], y[w]) for w in windows)])
        low, high, least, greatest = limits.reshape(-1, 4).T
        return _smooth(np.maximum(mean + low, least)), _smooth(np.minimum(mean + high, greatest))

    def swings(self, y: np.ndarray) -> np.ndarray:
        """By how much a signal (N,) goes up as well as down about each point (K,), within two windows.

        That is nothing where it only rises or falls, or has a single peak.
        """
        width = self.end - self.begin
        parts = [y[w] for w in _slices(self.x, self.at - width, self.at + width)]
        up = [(part - np.minimum.accumulate(part)).max() for part in parts]
        down = [(np.maximum.accumulate(part) - part).max() for part in parts]
        swing = np.minimum(up, down)
        return np.array([swing[w].min() for w in _slices(self.at, self.at - width, self.at + width)])

    def shares(self, y: np.ndarray, span: float) -> np.ndarray:
        """The shares (K,) of the mean in what is drawn of a signal (N,): 0 where its swings are small in a panel of a span."""
        return _smooth(np.clip(self.swings(y) / max(_VISIBLE * span, _TINY) - 1, 0.0, 1.0))

    def at_least(self, share: float) -> TurnWindows:
        """The windows, each widened to a share of the panel."""
        width = share * (self.at[-1] - self.at[0])
        begin = np.clip(np.minimum(self.begin, self.at - width / 2), self.x[0], max(self.x[-1] - width, self.x[0]))
        return TurnWindows(self.x, self.at, begin, np.minimum(np.maximum(self.end, begin + width), self.x[-1]))


def _slices(x: np.ndarray, begin: np.ndarray, end: np.ndarray) -> list[slice]:
    """The samples (N,) between each pair of ends (K,), at least one."""
    first = np.minimum(np.searchsorted(x, begin), len(x) - 1)
    last = np.maximum(np.searchsorted(x, end, side="right"), first + 1)
    return [slice(i, k) for i, k in zip(first.tolist(), last.tolist(), strict=True)]


def _smooth(y: np.ndarray) -> np.ndarray:
    """The mean (K,) of each value and its neighbours, twice."""
    for _ in range(2):
        y = np.concatenate([y[:1], (y[:-2] + 2 * y[1:-1] + y[2:]) / 4, y[-1:]]) if len(y) > 2 else y
    return y


def with_peaks(y: np.ndarray) -> np.ndarray:
    """A signal (N,) whose least and greatest samples are replaced by those of parabolas through them and their neighbours.

    Without that a band would show how the samples meet the swings.
    """
    if len(y) < 3:
        return y
    before, middle, after = y[:-2], y[1:-1], y[2:]
    bend = after - 2 * middle + before
    is_peak = ((middle - before) * (after - middle) < 0) & (bend != 0)
    peaks = y.copy()
    peaks[1:-1][is_peak] = (middle - (after - before) ** 2 / (8 * np.where(is_peak, bend, 1.0)))[is_peak]
    return peaks


def draw_course(axis: Axes, windows: TurnWindows, y: np.ndarray, band: str | None = None, **look: Any) -> None:
    """Draw the mean of a signal over whole turns, and its range about that; the signal itself where it does not swing.

    Parameters
    ----------
    axis : Axes
    windows : TurnWindows
    y : numpy.ndarray
        The signal (N,).
    band : str, optional
        Name of the band, empty for one without a name; None: no band.
    **look
        Of the line, with its ``label``.
    """
    panel_mask = windows.x <= windows.at[-1]
    share = windows.shares(y, float(np.ptp(y[panel_mask])))
    if not share.max(initial=0.0) > 0:
        axis.plot(*thin_curve(windows.x[panel_mask], y[panel_mask]), **look)
        return
    mean, value = windows.means(y), np.interp(windows.at, windows.x, y)
    line = value + share * (mean - value)
    axis.plot(windows.at, line, **look)
    if band is not None:
        low, high = (line + share * (limit - line) for limit in windows.extremes(with_peaks(y), mean))
        axis.fill_between(windows.at, low, high, color=look["color"], label=band or None, **_BAND)


def draw_mean_and_range(
    axis: Axes, x: np.ndarray, mean: np.ndarray | None, limits: tuple[np.ndarray, np.ndarray], **look: Any
) -> None:
    """Draw a signal whose mean (N,), least and greatest values (N,) over x (N,) are known, as ``draw_course`` does.

    look: of the line, which is left out without a mean.
    """
    if mean is not None:
        axis.plot(x, mean, label="mean", **look)
    axis.fill_between(x, *limits, color=look["color"], label=RANGE, **_BAND)


def draw_greatest(axis: Axes, windows: TurnWindows, y: np.ndarray, **look: Any) -> None:
    """Draw the greatest value of a signal (N,) in the windows; the signal itself where it does not swing in them.

    look: of the line, with its ``label``.
    """
    swings = windows.swings(y).max(initial=0.0) > _VISIBLE * np.ptp(y)
    points = (windows.at, windows.extremes(y, windows.means(y))[1]) if swings else thin_curve(windows.x, y)
    axis.plot(*points, **look)


def without_steps(x: np.ndarray, y: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """A signal that is held, such as the largest value within a turn, through the middles of its steps.

    Parameters
    ----------
    x, y : numpy.ndarray
        Abscissae and values (N,).

    Returns
    -------
    tuple of numpy.ndarray
        Points (K,), those of the first and the last sample, and one for each stretch of equal values between them. The largest
        and the least value remain.
    """
    edges = np.flatnonzero(np.diff(y)) + 1
    first, last = np.append(0, edges), np.append(edges, len(y)) - 1
    middle = (x[first] + x[last]) / 2
    return np.concatenate([x[:1], middle, x[-1:]]), np.concatenate([y[:1], y[first], y[-1:]])


def draw_range(axis: Axes, windows: TurnWindows, y: np.ndarray, name: str, color: str) -> None:
    """Draw the range of a distance (N,) in the windows as a band."""
    mean = windows.means(y)
    low, high = windows.extremes(np.sqrt(np.maximum(with_peaks(y**2), 0.0)), mean)
    axis.fill_between(windows.at, np.maximum(low, 0.0), high, color=color, label=name, **_BAND)


@dataclass(frozen=True)
class Phases:
    """Mean phases over the windows of a panel.

    Attributes
    ----------
    at : numpy.ndarray
        Points (K,) of the panel.
    degrees : numpy.ndarray
        Mean phases (n, K), NaN where a body turns past.
    slips : numpy.ndarray
        Mean rates (n, K) of the phases, rad per unit of the abscissa.
    """

    at: np.ndarray
    degrees: np.ndarray
    slips: np.ndarray

    @classmethod
    def of(cls, windows: TurnWindows, phases: np.ndarray) -> Self:
        """Mean phases of bodies; phases: (n, N), rad."""
        wide, angles = windows.at_least(1 / _FEWEST_WINDOWS), np.unwrap(phases, axis=-1)
        vectors = np.array([windows.means(np.cos(p)) + 1j * windows.means(np.sin(p)) for p in phases])
        slips = np.array([wide.slopes(p) for p in angles])
        is_drawn = (np.abs(vectors) >= _SYNCHRONOUS) & (np.abs(slips) * (wide.end - wide.begin) <= _SLOW)
        values = np.array([np.interp(windows.at, windows.x, p) for p in angles])
        shares = np.array([windows.shares(p, 2 * math.pi) for p in angles])
        means = values + shares * np.angle(vectors * np.exp(-1j * values))
        return cls(windows.at, np.where(is_drawn, np.degrees(means), np.nan), slips)

    @property
    def slip_mask(self) -> np.ndarray:
        """True (n,) for bodies that turn past for more than a hundredth of the panel."""
        return np.asarray(np.isnan(self.degrees).mean(axis=1) > 1 / _FEWEST_WINDOWS)

    @property
    def all_slip(self) -> bool:
        """True if all bodies turn past at the end of the panel."""
        late = self.at >= self.at[-1] - _LATE * (self.at[-1] - self.at[0])
        return bool(len(self.degrees)) and bool(np.isnan(self.degrees[:, late]).mean(axis=1).min() > 1 / 2)


def draw_phases(axis: Axes, phases: Phases, looks: Sequence[dict[str, Any]]) -> float:
    """Draw mean phases as lines that are broken where the angle wraps and while a body turns past.

    Parameters
    ----------
    axis : Axes
    phases : Phases
    looks : sequence of dict
        Of the lines (n).

    Returns
    -------
    float
        The lower limit of the panel, degrees.
    """
    begin = angle_panel(axis, phases.degrees)
    for degrees, look in zip(phases.degrees, looks, strict=True):
        axis.plot(phases.at, angles_in_turn(degrees, begin), **look)
    if phases.slip_mask.any():
        axis.plot([], [], linestyle="", label="not drawn while turning past")
    return begin


def angles_in_turn(degrees: np.ndarray, begin: float) -> np.ndarray:
    """Angles (N,) in the turn from ``begin`` on, degrees, with gaps where they wrap."""
    return without_jumps(begin + np.remainder(degrees - begin, 360), 360.0)
