"""The evidence of many motions at once, from samples at even times: of those that settle about a turning rotor.

The criteria are those of one run. What samples do not show (cycles of a modulation, bodies that lag) is left open: such a
motion is ``unidentified`` here, and its turns decide (``evidence``).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.verdicts.evidence import UNREST, unrest
from wucht.dynamics.verdicts.lags import LIBRATION, grows
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.outcomes import FEWEST_TURNS, MODULATION_THRESHOLD, SPEED_TOLERANCE, Evidence
from wucht.numerics.observers.projection import WINDOWS, project_signals

_ROUNDING = 1e-9  # of the speed: changes below are none
_RIPPLE = 1e-3  # of the range of the speed in a window: the accuracy of its mean
_STILL, _STILL_LEFT = 1e-4, 5e-3  # of the speed, of the unbalance: smaller changes are rest, but for rounding or a drift
_RINGING = 300.0  # times the noise of the speed: the integration keeps a weakly damped motion at rest moving by so much
_NARROW = 1e-3  # bounds of those, that are narrow enough: see ``Verdict.settled_within``
# Times what may change of a settled speed: a nearer end may be known from each turn; share of all changes.
_FAR, _ONE_WAY = 10.0, 0.9
_FEWEST_CYCLES = 3  # of a modulation, which are worth a full classification


@dataclass(frozen=True)
class Screening:
    """The evidence of M motions, without their resonances; each array (M,).

    sense: in which the rotor turns at the end, +1 or -1. evidence: ``has_settled`` where all of it is valid. quiet: the bodies
    hardly move. cycling: not settled, and the speed rises and falls so often that a full classification may decide. nearing:
    they approach an end. rises: the number of times that the speed rose through the middle of its range. early: they approach
    an end that is not known yet: their bodies still move, or their speed changes. still: they hardly move.
    """

    sense: np.ndarray
    evidence: Evidence[np.ndarray]
    quiet: np.ndarray
    cycling: np.ndarray
    nearing: np.ndarray
    rises: np.ndarray
    early: np.ndarray
    still: np.ndarray

    @property
    def has_settled(self) -> np.ndarray:
        """Mask of the members whose evidence is valid."""
        return np.asarray(self.evidence.has_settled)

    @property
    def width(self) -> np.ndarray:
        """The distance of the bounds: of the speed, as a share of it, or of the residual, whichever is larger."""
        assert self.evidence.residual is not None
        mean, residual = np.array(self.evidence.mean_speed), self.evidence.residual
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.asarray(np.maximum((mean[1] - mean[0]) / np.abs(mean).max(axis=0), residual[1] - residual[0]))


@np.errstate(divide="ignore", invalid="ignore")
def screening_of(
    duration: float, signed_speed: np.ndarray, phases: np.ndarray, residuals: np.ndarray, free: np.ndarray, noise: Noise
) -> Screening:
    """Screen M members by the last half of their motion, at K even times, K a multiple of five.

    duration: of that half. signed_speed (K, M): of the main rotor. phases (b, K, M): of the bodies about it, as they turn.
    residuals (K, M): magnitude of the rotor's residual unbalance, as a share of its unbalance. free (M,): signed speeds of
    their drives without vibration, nan where not known. noise: of their integration.
    """
    sense, count = np.where(signed_speed[-1] < 0, -1, 1), signed_speed.shape[1]
    speed = sense * signed_speed
    windows = speed.reshape(WINDOWS, -1, count)
    means, lows, highs = windows.mean(axis=1), windows.min(axis=1), windows.max(axis=1)
    sizes = residuals.reshape(WINDOWS, -1, count).max(axis=1)
    largest, tolerance = np.abs(means).max(axis=0), SPEED_TOLERANCE * np.abs(means).max(axis=0)
    rounding = np.maximum(_RIPPLE * (highs - lows)[-1], max(_ROUNDING, noise.speed) * largest)
    mean, lowest = project_signals(means, rounding=rounding), project_signals(lows, rounding=rounding)
    speed_range = project_signals((highs - lows) / means, rounding=rounding / means[-1])
    residual = project_signals(sizes, rounding=noise.angle)
    bounds = noise.widen(residual.bounds)
    # Rounding and the drift that the integration's tolerance adds to rest do not contract.
    still_range = min(max(_STILL, _RINGING * noise.speed), _NARROW) * largest
    calm = (highs.max(axis=0) - lows.min(axis=0) <= still_range) & (np.ptp(sizes, axis=0) <= _STILL_LEFT)
    narrow = (mean.width <= _NARROW * means[-1]) & (lowest.width <= _NARROW * means[-1]) & (speed_range.width <= _NARROW)
    still = calm & narrow & (bounds[1] - bounds[0] <= _NARROW)
    nearing = (mean.converging & residual.converging) | still
    turning = (speed > 0).all(axis=0) & (means.mean(axis=0) * duration >= 2 * math.pi * FEWEST_TURNS)
    is_steady = (lowest.converging | still) & nearing & (mean.width <= tolerance)
    in_place = ((np.ptp(phases, axis=1) < LIBRATION) & ~grows(phases, axis=1)).all(axis=0)
    quiet = unrest(residuals.min(axis=0), residuals.max(axis=0)) <= UNREST
    has_settled = turning & (speed_range.converging | still) & is_steady & in_place
    rises = rises_of(speed)
    early = turning & nearing & (mean.width > _FAR * tolerance) & ~quiet
    # For a rotor that still rises, with bodies at rest, the torques decide its end: ``verdict.rising_evidence``.
    changes = np.diff(means, axis=0)
    one_way = np.abs(changes.sum(axis=0)) >= _ONE_WAY * np.abs(changes).sum(axis=0)
    far = one_way & (np.where(mean.converging | still, mean.width, np.abs(changes[-1])) > _FAR * tolerance)
    early |= turning & ~has_settled & (rises < 2) & (~quiet | (means[-1] < means[-2])) & far
    even = np.where(speed_range.high <= MODULATION_THRESHOLD, speed_range.high, math.inf)
    evidence = Evidence(
        turning=np.ones(count, bool),
        mean_speed=(mean.low, mean.high),
        lowest_speed=(lowest.low, lowest.high),
        has_settled=has_settled,
        free_speed=sense * free,
        residual=(np.maximum(bounds[0], 0.0), np.maximum(bounds[1], 0.0)),
        modulation=(np.zeros(count), even),
    )
    return Screening(sense, evidence, quiet, ~has_settled & (rises >= _FEWEST_CYCLES), nearing, rises, early, still)


def rises_of(speed: np.ndarray) -> np.ndarray:
    """Count the rises of the speed (K, M) through the middle of its range, from far below to far above (M,)."""
    low, high = speed.min(axis=0), speed.max(axis=0)
    middle, reach = (low + high) / 2, 0.25 * (high - low)
    was_below, rises = np.zeros_like(low, bool), np.zeros_like(low, int)
    # Sample by sample: the state of all members stays in the cache.
    for is_above, is_below in zip(speed > middle + reach, speed < middle - reach, strict=True):
        rises += was_below & is_above
        was_below = is_below | (was_below > is_above)
    return rises
