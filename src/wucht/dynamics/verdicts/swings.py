"""A rotor that no longer turns, or turns back in each turn: its future motion; and the stop of one without a drive."""

from __future__ import annotations

import math

import numpy as np

from wucht.analysis.starting import StartFromRest, starts_from_rest
from wucht.analysis.vibration import Vibration
from wucht.analysis.working_points import creep_speed, is_only_braked
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import AT_REST, FEWEST_TURNS, Evidence
from wucht.machines.machine import Machine
from wucht.numerics.observers.projection import AHEAD, SHARE, Course, project, trend, windows_of
from wucht.numerics.observers.records import Blocks, SpanRecord, Spans

REASON_COASTING = "the rotor coasts ever more slowly, and does not stop"
_VISIBLE_FALL = 0.998  # of the speed, from the first to the last window: the law of its fall is visible below
_WITHOUT_END = 1.3  # the power of the speed in proportion to which it falls: from this one on it never stops


def windows_to_rest(whole: Blocks, means: np.ndarray) -> float:
    """Return the tenths of the record's time until a falling speed is zero, from its means (w,) over tenths of the turns.

    It falls in proportion to a power of itself: 0 by dry friction, 1 by a viscous damper; beyond that it has no end: inf.
    """
    if (np.diff(means) >= 0).any() or means[-1] <= 0:
        return math.inf
    changes, power = -np.diff(means), 1.0
    if means[-1] < _VISIBLE_FALL * means[0]:
        between = (means[1:] + means[:-1]) / 2
        # Over the angle, in which the windows are equal, the power is less by one.
        power = max(0.0, 1 + math.log(changes[0] / changes[-1]) / math.log(between[0] / between[-1]))
    if power > _WITHOUT_END:
        return math.inf
    last = float(np.ptp(windows_of(whole.time)[-1]) / np.ptp(whole.time)) / SHARE  # the length of the last window, in tenths
    exponential = math.log(1 / AT_REST)
    return last * float(means[-1] / changes[-1]) * (min(exponential, 1 / (1 - power)) if power < 1 else exponential)


def rotors_not_started(machine: Machine, observation: Observation) -> dict[str, StartFromRest]:
    """Return the rotors that never turned, and which weight or load holds against their drives, by name.

    Never turned: they made no turn, or did no more than creep under dry friction.
    """
    creep = creep_speed(machine)
    standing = {
        name for name, record in observation.rotors.items() if not record.turns or float(record.whole.highest.max()) <= creep
    }
    if not standing:
        return {}
    return {name: start for name, start in starts_from_rest(machine).items() if name in standing and start.is_held}


_NEARLY = 0.03  # logarithm of a swing: so near its end an approach is known to have one
_SMALL, _FALLS = 0.5, 0.9  # of the largest speed, and from window to window but three: a swing that will die out
_UNEVEN = 0.2  # of the mean speed: a rotor whose mean speeds over tenths of the run vary by more does not turn evenly
_NO_LARGER = 1.05  # times the smallest window: a swing that grows again does not die out
_IN_PLACE, _ELSEWHERE = 1e-2, math.pi / 2  # rad: a mean angle that moves less is at rest, one that may move more is not
_EQUAL = 1e-3  # share by which swings differ that are treated as equal


def swing_of(machine: Machine, observation: Observation, is_held: bool = False) -> tuple[tuple[float, float], float] | None:
    """Return the bounds of the main rotor's swing; None if it still turns, but too little to average over turns.

    It will stay between these, a share of the largest speed in the run. Beside them stands the run until that is known at its
    present decay, as a multiple of the run so far; 0: unknown.
    is_held: it never turned, and weight or load hold it against its drive: once at rest it stays so.
    """
    whole, half = observation.main.last(1.0), observation.main.last(0.5)
    speeds = _largest_speeds(whole)
    windows = windows_of(speeds)
    if not windows.size or half.greatest_angle.max() - half.least_angle.min() > 2 * math.pi:
        return None
    # A rotor that does not swing, but creeps, will stop or begin to turn.
    to_and_fro = _turns_back(half)
    sizes = windows.max(axis=1) / speeds.max()
    turning = any(r.turns >= 1 for name, r in observation.rotors.items() if name != machine.rotor.name)
    place = project(windows_of(whole.angle).mean(axis=1), AHEAD, _IN_PLACE)
    in_place = place.width < _ELSEWHERE and not turning
    is_braked = to_and_fro and in_place and is_only_braked(machine, float(windows.max()))
    standing = [record for name, record in observation.further_rotors.items() if observation.rotors[name].turns < 1]
    ends = (is_braked and _dies_out(sizes)) or (is_held and bool(sizes[-1] <= AT_REST))
    if not is_only_braked(machine, float(windows.max())) and not all(map(_lasts, standing)):
        # A drive that feeds the swing of one rotor may turn it over, which changes that of the main one.
        return (0.0, 1.0), 0.0
    bounds = (0.0, 0.0) if ends else _bounds(sizes, to_and_fro)
    return bounds, _run_factor(sizes, _SMALL * _FALLS if is_braked else AT_REST)


def _largest_speeds(spans: Spans) -> np.ndarray:
    """The largest speed (N,) in each span, whichever way the rotor turns."""
    return np.asarray(np.maximum(np.abs(spans.least_speed), np.abs(spans.greatest_speed)))


def _turns_back(spans: Spans) -> bool:
    """True if a rotor turned both ways."""
    return bool(spans.greatest_speed.max() > 0 > spans.least_speed.min())


def _lasts(record: SpanRecord) -> bool:
    """True if a rotor is at rest, or swings without change."""
    whole, half = record.last(1.0), record.last(0.5)
    speeds = _largest_speeds(whole)
    windows, largest = windows_of(speeds), float(speeds.max(initial=0.0))
    if not windows.size or not largest:
        return True
    sizes = windows.max(axis=1) / largest
    return bool(sizes[-1] <= AT_REST) or _bounds(sizes, _turns_back(half))[0] > 0


def run_factor_until_swinging(observation: Observation) -> float:
    """Return the run, as a multiple of the run so far, until a main rotor that turns over now and then only swings, as its
    largest speeds fall; 0: they do not."""
    whole = observation.main.last(1.0)
    speeds = _largest_speeds(whole)
    windows = windows_of(speeds)
    return (
        _run_factor(windows.max(axis=1) / speeds.max(), _SMALL * _FALLS)
        if windows.size and trend(windows.max(axis=1)) < 0
        else 0.0
    )


def mean_turning_evidence(machine: Machine, observation: Observation, free: float | None) -> Evidence[float] | None:
    """Return the evidence of a main rotor that turns, but back again in each turn: by its mean speeds over tenths of the run.

    None if it does not turn so, all windows alike. free: its drive's speed without vibration.
    """
    whole, rotor = observation.main.last(1.0), machine.rotor
    if len(whole.time) < 2 / SHARE:
        return None
    angle, time = (windows_of(x)[:, [0, -1]] for x in (whole.angle, whole.time))
    speeds = np.diff(angle, axis=1)[:, 0] / np.diff(time, axis=1)[:, 0]
    sense = math.copysign(1.0, speeds[-1])
    mean = project(sense * speeds, AHEAD)
    turn_count = sense * (angle[-1, 1] - angle[0, 0]) / (2 * math.pi)
    if turn_count < FEWEST_TURNS or mean.course is not Course.STATIONARY or mean.width > _UNEVEN * mean.last:
        return None
    target_speed = None if free is None else sense * free
    index = [machine.bodies.index(b) for b in machine.group(rotor)]
    resonance = Vibration.of(machine).select_bodies(index).last_maximum(target_speed, np.zeros(len(index)))
    return Evidence(True, mean.bounds, mean.bounds, free_speed=target_speed, resonance=resonance)


def _dies_out(sizes: np.ndarray) -> bool:
    """True if a swing that can only lose energy loses some, window by window, and is too small to turn over again."""
    return bool(trend(sizes) < 0 and sizes[-1] <= min(_SMALL, _FALLS * sizes[0], _NO_LARGER * sizes.min()))


def _run_factor(sizes: np.ndarray, rest: float) -> float:
    """Return the run, as a multiple of the run so far, until a swing is as small as ``rest``, from its sizes (w,) in tenths."""
    if not 0 < sizes[-1] < sizes[0]:
        return 0.0
    windows = (len(sizes) - 1) * math.log(sizes[-1] / rest) / math.log(sizes[0] / sizes[-1])
    return 1 + SHARE * max(windows, 0.0)


def _bounds(sizes: np.ndarray, to_and_fro: bool) -> tuple[float, float]:
    """Return the bounds between which a swing will stay, from its sizes (w,) in successive windows."""
    if not sizes[-1] > 0:
        return 0.0, 0.0
    logs = np.log(np.maximum(sizes, 1e-300))
    p = project(logs, AHEAD, _EQUAL)
    # Even one that seems constant may decay unnoticed; one that rises and falls beats, however its changes contract.
    is_monotonic = p.course is Course.APPROACHING and bool((np.diff(logs) >= 0).all() or (np.diff(logs) <= 0).all())
    hidden = 0.0 if is_monotonic else float(np.ptp(logs)) / (len(logs) - 1) * AHEAD
    lasts = to_and_fro and p.course is not Course.DRIFTING and p.width <= _NEARLY
    return math.exp(p.low - hidden) if lasts else 0.0, math.exp(min(p.high, 0.0))
