"""A rotor that no longer turns, or turns back in each turn: what becomes of it; and when one that nothing drives stops."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.analysis.vibration import Vibration
from wucht.analysis.working_points import only_braked
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import AT_REST, FEWEST_TURNS, Evidence
from wucht.machines.machine import Machine
from wucht.numerics.observers.projection import AHEAD, SHARE, Course, projected, trend, windows_of
from wucht.numerics.observers.records import Blocks

COASTS = "the rotor coasts ever more slowly, and does not come to rest"
_SEEN_TO_FALL = 0.998  # of the speed, from the first to the last window: how it falls is seen then
_WITHOUT_END = 1.3  # the power of the speed in proportion to which it falls: from here on it takes for ever


def windows_to_rest(whole: Blocks, means: np.ndarray) -> float:
    """In how many tenths of the record's time a speed that falls comes to rest, of its means (w,) over tenths of the turns.

    It falls in proportion to a power of itself: 0 by dry friction, 1 by a viscous damper; beyond that it has no end: inf.
    """
    if (np.diff(means) >= 0).any() or means[-1] <= 0:
        return math.inf
    changes, power = -np.diff(means), 1.0
    if means[-1] < _SEEN_TO_FALL * means[0]:
        between = (means[1:] + means[:-1]) / 2
        # Over the angle, in which the windows are equal, the power is less by one.
        power = max(0.0, 1 + math.log(changes[0] / changes[-1]) / math.log(between[0] / between[-1]))
    if power > _WITHOUT_END:
        return math.inf
    last = float(np.ptp(windows_of(whole.time)[-1]) / np.ptp(whole.time)) / SHARE  # how long the last window is, in tenths
    exponential = math.log(1 / AT_REST)
    return last * float(means[-1] / changes[-1]) * (min(exponential, 1 / (1 - power)) if power < 1 else exponential)


_NEARLY = 0.03  # logarithm of a swing: so near its end an approach is known to have one
_SMALL, _FALLS = 0.5, 0.9  # of the largest speed, and from window to window but three: a swing that will die out
_UNEVEN = 0.2  # of the mean speed: a rotor whose mean speeds over tenths of the run vary by more does not turn evenly
_NO_LARGER = 1.05  # times the smallest window: a swing that grows again does not die out
_IN_PLACE, _ELSEWHERE = 1e-2, math.pi / 2  # rad: a mean angle that moves less is at rest, one that may move more is not
_EQUAL = 1e-3  # share by which swings differ that are taken for equal


@dataclass(frozen=True)
class Swing:
    """bounds: between which it will stay, as a share of the largest speed there was. longer: how many times the run it takes
    until that is known if it decays as it does; 0: unknown."""

    bounds: tuple[float, float]
    longer: float


def swing_of(machine: Machine, seen: Observation) -> Swing | None:
    """The swing of the main rotor; None where some turning is left, but fewer turns than are needed to average over."""
    whole, half = seen.main.last(1.0), seen.main.last(0.5)
    speeds = np.maximum(np.abs(whole.least_speed), np.abs(whole.greatest_speed))
    each = windows_of(speeds)
    if not each.size or half.greatest_angle.max() - half.least_angle.min() > 2 * math.pi:
        return None
    # What does not swing, but creeps, comes to rest or begins to turn.
    to_and_fro = bool(half.greatest_speed.max() > 0 > half.least_speed.min())
    sizes = each.max(axis=1) / speeds.max()
    turning = any(r.turns >= 1 for name, r in seen.rotors.items() if name != machine.rotor.name)
    place = projected(windows_of(whole.angle).mean(axis=1), AHEAD, _IN_PLACE)
    in_place = place.width < _ELSEWHERE and not turning
    braked = to_and_fro and in_place and only_braked(machine, float(each.max()))
    bounds = (0.0, 0.0) if braked and _dies_out(sizes) else _bounds(sizes, to_and_fro)
    return Swing(bounds, _longer(sizes, _SMALL * _FALLS if braked else AT_REST))


def longer_until_no_turning(seen: Observation) -> float:
    """How many times as long a main rotor that turns over now and then must be watched until it only swings, as its largest
    speeds fall; 0: they do not."""
    whole = seen.main.last(1.0)
    speeds = np.maximum(np.abs(whole.least_speed), np.abs(whole.greatest_speed))
    each = windows_of(speeds)
    return _longer(each.max(axis=1) / speeds.max(), _SMALL * _FALLS) if each.size and trend(each.max(axis=1)) < 0 else 0.0


def turning_on_the_whole(machine: Machine, seen: Observation, free: float | None) -> Evidence[float] | None:
    """The evidence of a main rotor that turns, but back again in each turn: by its mean speeds over tenths of the run.

    None if it does not turn so, all windows alike. free: what its drive reaches without vibration.
    """
    whole, rotor = seen.main.last(1.0), machine.rotor
    if len(whole.time) < 2 / SHARE:
        return None
    angle, time = (windows_of(x)[:, [0, -1]] for x in (whole.angle, whole.time))
    speeds = np.diff(angle, axis=1)[:, 0] / np.diff(time, axis=1)[:, 0]
    sense = math.copysign(1.0, speeds[-1])
    mean = projected(sense * speeds, AHEAD)
    turned = sense * (angle[-1, 1] - angle[0, 0]) / (2 * math.pi)
    if turned < FEWEST_TURNS or mean.course is not Course.STATIONARY or mean.width > _UNEVEN * mean.last:
        return None
    expected = None if free is None else sense * free
    index = [machine.bodies.index(b) for b in machine.group(rotor)]
    resonance = Vibration.of(machine).only(index).last_maximum(expected, np.zeros(len(index)))
    return Evidence(True, mean.bounds, mean.bounds, free_speed=expected, resonance=resonance)


def _dies_out(sizes: np.ndarray) -> bool:
    """Whether a swing that can only lose energy loses some, window by window, and is too small to turn over again."""
    return bool(trend(sizes) < 0 and sizes[-1] <= min(_SMALL, _FALLS * sizes[0], _NO_LARGER * sizes.min()))


def _longer(sizes: np.ndarray, rest: float) -> float:
    """How many times as long a swing must be watched until it is as small as that, of its sizes (w,) in tenths."""
    if not 0 < sizes[-1] < sizes[0]:
        return 0.0
    windows = (len(sizes) - 1) * math.log(sizes[-1] / rest) / math.log(sizes[0] / sizes[-1])
    return 1 + SHARE * max(windows, 0.0)


def _bounds(sizes: np.ndarray, to_and_fro: bool) -> tuple[float, float]:
    """Between which bounds a swing will stay, of its sizes (w,) in successive windows."""
    if not sizes[-1] > 0:
        return 0.0, 0.0
    logs = np.log(np.maximum(sizes, 1e-300))
    p = projected(logs, AHEAD, _EQUAL)
    # Even one that seems to stay may decay unseen; one that goes to and fro beats, however its changes contract.
    directed = p.course is Course.APPROACHING and bool((np.diff(logs) >= 0).all() or (np.diff(logs) <= 0).all())
    hidden = 0.0 if directed else float(np.ptp(logs)) / (len(logs) - 1) * AHEAD
    lasts = to_and_fro and p.course is not Course.DRIFTING and p.width <= _NEARLY
    return math.exp(p.low - hidden) if lasts else 0.0, math.exp(min(p.high, 0.0))
