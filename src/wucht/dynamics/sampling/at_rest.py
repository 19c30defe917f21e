"""Members whose motion comes to rest about the turning rotor: their outcome, for many of them at once.

The criteria are those of ``motion.evidence``, of a motion without ripple, as far as its numbers approach their ends
monotonically; of all other motions nothing is said here.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.verdicts.evidence import FEWEST_TURNS, UNREST
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import MODULATION_THRESHOLD, SPEED_TOLERANCE, UNBALANCE_TOLERANCE
from wucht.numerics.observers.projection import WINDOWS, projected_each

_CONTRACTING = 0.98  # ratio of successive changes: above, it is no approach
_ROUNDING = 1e-9  # of the speed: changes below are none
_RIPPLE = 1e-3  # of the range of the speed in a window: so well its mean is known
_STILL, _STILL_LEFT = 1e-4, 5e-3  # of the speed, of the unbalance: who moves by less is at rest, but for rounding or a drift
_NARROW = 1e-3  # bounds of those, that are narrow enough: see ``Verdict.settled_within``
_LIBRATION, _SMALL, _GROWING = math.pi / 2, 0.1, 1.05  # of a phase, in rad: see ``motion.lags``
_FAR, _ONE_WAY = 4.0, 0.9  # times what may change of a settled speed; share of all changes: see ``projection.projected``
_FEWEST_CYCLES = 3  # of a modulation, which are worth a closer look


@dataclass(frozen=True)
class LastHalf:
    """The last half of the motion of M members at K even times, K a multiple of five.

    duration: of it. speed: of the main rotor (K, M). phases: of the bodies about it, as they turn
    (b, K, M). left: the magnitude of what is left of the rotor's unbalance, as a share of it (K, M).
    """

    duration: float
    speed: np.ndarray
    phases: np.ndarray
    left: np.ndarray


@dataclass(frozen=True)
class Resting:
    """Of M members what can be told of them at rest, each array (M,) but for bounds (2, M).

    mean, lowest: bounds of the mean and the lowest speed, in the sense of turning; left: of what is left of the unbalance.
    known: whether they hold. even: whether the speed then is not modulated. quiet: whether the bodies hardly move. sense: +1 or
    -1. cycling: of those that are not known, whether the speed goes up and down so often that a closer look may tell. nearing:
    whether they approach an end. rises: how often the speed rose through the middle of its range. early: whether they are on
    the way to an end that is not known yet: their bodies still move, or their speed does. still: whether they hardly move.
    """

    mean: np.ndarray
    lowest: np.ndarray
    left: np.ndarray
    known: np.ndarray
    even: np.ndarray
    quiet: np.ndarray
    sense: np.ndarray
    cycling: np.ndarray
    nearing: np.ndarray
    rises: np.ndarray
    early: np.ndarray
    still: np.ndarray

    @property
    def width(self) -> np.ndarray:
        """How far the bounds are apart (M,): of the speed, as a share of it, or of what is left, whichever is more."""
        with np.errstate(divide="ignore", invalid="ignore"):
            speed = (self.mean[1] - self.mean[0]) / np.abs(self.mean).max(axis=0)
        return np.asarray(np.maximum(speed, self.left[1] - self.left[0]))

    def at_speed(self, free: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Whether a member holds its free speed (M,), signed, nan: none, within 0.5 %; and whether that is known."""
        reach, expected = SPEED_TOLERANCE * np.abs(free), self.sense * free
        low, high = expected - reach, expected + reach
        inside = [(low <= b[0]) & (b[1] <= high) for b in (self.mean, self.lowest)]
        outside = [(b[1] < low) | (high < b[0]) for b in (self.mean, self.lowest)]
        none = np.isnan(free)
        return inside[0] & inside[1] & ~none, (inside[0] & inside[1]) | outside[0] | outside[1] | none

    @property
    def balanced(self) -> tuple[np.ndarray, np.ndarray]:
        """Whether less than 1 % of the unbalance is left (M,), and whether that is known."""
        below, above = self.left[1] < UNBALANCE_TOLERANCE, self.left[0] >= UNBALANCE_TOLERANCE
        return below, below | above


def resting(seen: LastHalf, noise: Noise) -> Resting:
    """What can be told of members at rest. noise: of their integration."""
    count = seen.speed.shape[1]
    sense = np.where(seen.speed[-1] < 0, -1, 1)
    speed = sense * seen.speed
    windows = speed.reshape(WINDOWS, -1, count)
    means, lows, highs = windows.mean(axis=1), windows.min(axis=1), windows.max(axis=1)
    largest = np.abs(means).max(axis=0)
    rounding = np.maximum(_RIPPLE * (highs - lows)[-1], max(_ROUNDING, noise.speed) * largest)
    mean, mean_known = approached(means, rounding)
    lowest, lowest_known = approached(lows, rounding)
    with np.errstate(divide="ignore", invalid="ignore"):
        varied, varied_known = approached((highs - lows) / means, rounding / means[-1])
    sizes = seen.left.reshape(WINDOWS, -1, count).max(axis=1)
    left, left_known = approached(sizes, np.full(count, noise.angle))
    left = noise.widened(left)
    still, bounds = _still(windows, means, sizes, rounding, noise)
    mean, lowest, varied, left = (np.where(still, b, a) for a, b in zip((mean, lowest, varied, left), bounds, strict=True))
    knowns = mean_known, lowest_known, varied_known, left_known
    mean_known, lowest_known, varied_known, left_known = (known | still for known in knowns)
    most = seen.left.max(axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        unrest = np.where(most > UNBALANCE_TOLERANCE, 1 - seen.left.min(axis=0) / most, 0.0)
    turning = (speed > 0).all(axis=0) & (means.mean(axis=0) * seen.duration >= 2 * math.pi * FEWEST_TURNS)
    even = varied_known & (varied[1] <= MODULATION_THRESHOLD)
    settled = mean_known & lowest_known & (mean[1] - mean[0] <= SPEED_TOLERANCE * largest)
    quiet = unrest <= UNREST
    known = turning & varied_known & settled & left_known & _in_place(seen.phases)
    rises = _rises(speed)
    cycling, nearing = ~known & (rises >= _FEWEST_CYCLES), mean_known & left_known
    early = turning & nearing & (mean[1] - mean[0] > SPEED_TOLERANCE * largest) & ~quiet
    # Of a rotor that still rises, with bodies at rest, the torques tell where it goes: ``motion.drive_and_vibration``.
    early |= turning & ~known & (rises < 2) & (~quiet | (means[-1] < means[-2])) & _goes_far(means, mean, mean_known)
    return Resting(mean, lowest, np.maximum(left, 0.0), known, even, quiet, sense, cycling, nearing, rises, early, still)


def _still(
    windows: np.ndarray, means: np.ndarray, sizes: np.ndarray, rounding: np.ndarray, noise: Noise
) -> tuple[np.ndarray, tuple[np.ndarray, ...]]:
    """Which members (M,) hardly move, by their speeds (w, k, M), and where mean, lowest speed, the range of the speed as a
    share of it and what is left of the unbalance (w, M) then go (2, M): as ``motion.evidence`` has it.

    Rounding and the drift that the integration's tolerance makes of rest do not contract.
    """
    lows, highs = windows.min(axis=1), windows.max(axis=1)
    calm = (highs.max(axis=0) - lows.min(axis=0) <= _STILL * np.abs(means).max(axis=0)) & (np.ptp(sizes, axis=0) <= _STILL_LEFT)
    mean, lowest = projected_each(means, rounding=rounding), projected_each(lows, rounding=rounding)
    varied = projected_each((highs - lows) / means, rounding=rounding / means[-1])
    left = noise.widened(projected_each(sizes, rounding=noise.angle))
    near = [b[1] - b[0] <= _NARROW * size for b, size in ((mean, means[-1]), (lowest, means[-1]), (varied, 1.0), (left, 1.0))]
    return calm & np.logical_and.reduce(near), (mean, lowest, varied, left)


def _goes_far(means: np.ndarray, bounds: np.ndarray, known: np.ndarray) -> np.ndarray:
    """Whether means (w, M) go one way by much more than what may change of a settled one (M,)."""
    changes, far = np.diff(means, axis=0), _FAR * SPEED_TOLERANCE * np.abs(means).max(axis=0)
    one_way = np.abs(changes.sum(axis=0)) >= _ONE_WAY * np.abs(changes).sum(axis=0)
    return np.asarray((np.where(known, bounds[1] - bounds[0], np.abs(changes[-1])) > far) & one_way)


def approached(means: np.ndarray, rounding: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Between which bounds (2, M) numbers will stay, by their means (w, M) over successive windows, and where that is known.

    Known (M,): of those that approach a limit ever more slowly, or change by rounding alone. See ``projection.projected``.
    """
    changes = np.diff(means, axis=0)
    sizes, last = np.abs(changes), means[-1]
    with np.errstate(divide="ignore", invalid="ignore"):
        ratios = sizes[1:] / sizes[:-1]
        rho = ratios[-2:].max(axis=0)
        rest = sizes[-1] * rho / (1 - rho)
    still = (sizes[-2:] <= rounding).all(axis=0)
    approaching = (ratios < _CONTRACTING).all(axis=0) & ~still
    # Changes to and fro have their limit between the last two.
    toward = np.where(changes[-1] * changes[-2] > 0, last + np.copysign(1.5 * rest, changes[-1]), means[-2])
    low = np.where(still, means[-3:].min(axis=0), np.minimum(last, toward))
    high = np.where(still, means[-3:].max(axis=0), np.maximum(last, toward))
    return np.array([low, high]), np.asarray(still | approaching)


def _in_place(phases: np.ndarray) -> np.ndarray:
    """Whether all bodies stay where they are about the rotor, swinging at most, and less and less (M,)."""
    ranges = np.ptp(phases, axis=1)
    earlier, late = (np.ptp(part, axis=1) for part in np.array_split(phases, 2, axis=1))
    return np.asarray(((ranges < _LIBRATION) & (late <= np.maximum(_SMALL, _GROWING * earlier))).all(axis=0))


def _rises(speed: np.ndarray) -> np.ndarray:
    """How often the speed (K, M) rises through the middle of its range, from far below to far above (M,)."""
    low, high = speed.min(axis=0), speed.max(axis=0)
    s, reach = speed - (low + high) / 2, 0.25 * (high - low)
    side = np.where(s > reach, 1, np.where(s < -reach, -1, 0))
    where = np.where(side != 0, np.arange(len(side))[:, None], 0)
    held = np.take_along_axis(side, np.maximum.accumulate(where, axis=0), axis=0)  # the side on which it was last
    return np.asarray(((held[1:] > 0) & (held[:-1] < 0)).sum(axis=0))
