"""From a trajectory to the evidence, the outcome, and what goes into the summary."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.vibration import Vibration, unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import net_torque
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.steadiness import Modulation, Trend, creep, modulation, trend
from wucht.numerics.turns import PER_TURN, Turns, turns
from wucht.results.conventions import wrapped
from wucht.results.outcomes import (
    FEWEST_PERIODS,
    SLIP_TOLERANCE,
    SPEED_TOLERANCE,
    UNBALANCE_TOLERANCE,
    Evidence,
    Outcome,
    classify,
)
from wucht.studies.locking import Locked, is_locking, locked, motion_of
from wucht.studies.run_up.horizon import SPEED_LIMIT

STEADY_TOLERANCE = 1e-3  # of the free speed and of the rotor's unbalance
MODULATION_THRESHOLD = 2e-3  # range of the turn-averaged speed, of the mean speed: less is not called a modulation
SLIP_DRIFT_TOLERANCE = 0.02  # of the slip: by how much a slipping body's mean speed may wander between windows
_FEWEST_TURNS = 6
_LAST_SHARE = 0.05
_LOCKED_PERIODS = 200  # a run until settled of rotors that may be taken along goes on for four hundred of their turns


@dataclass(frozen=True)
class Verdict:
    """What became of a run. window: begin and end time of the last window. phases: circular means over the last turn.

    settling_time, modulation, advice: None where they do not apply. faster_branch: the drive could hold a higher speed as well.
    """

    outcome: Outcome
    evidence: Evidence
    window: tuple[float, float]
    phases: dict[str, float]
    residual: np.ndarray
    turns: Turns
    trend: Trend
    modulation: Modulation | None
    settling_time: float | None
    advice: str | None
    faster_branch: bool = False
    locked: Locked | None = None

    @property
    def sentence(self) -> str:
        """The outcome in words."""
        if self.outcome is Outcome.PASSED and self.evidence.resonance is None:
            return "the rotor settles, and no resonance lies below the speed of its drive; unbalance is left"
        return self.outcome.sentence

    def settled_within(self, tolerance: float) -> bool:
        """Whether the outcome is known and the numbers will change by less than the tolerance."""
        if self.outcome is Outcome.UNIDENTIFIED:
            return False
        if self.locked is not None:
            return self.locked.evidence.periods >= _LOCKED_PERIODS
        return self.evidence.modulated or not self.evidence.turning or self.trend.steady(tolerance)


def judge(machine: Machine, trajectory: Trajectory, free: float | None) -> Verdict:
    """Decide the outcome of a run. free: what the drive reaches without vibration, at the end of the run."""
    machine = machine.at(trajectory.end_time)
    rotor = machine.rotor
    bodies = machine.group(rotor)
    angle, speed = motion_of(machine, trajectory, rotor)
    followers = {b.name: motion_of(machine, trajectory, b) for b in bodies[1:]}
    averaged = turns(trajectory.time, angle, speed, followers)
    vibration = Vibration.of(machine).only([machine.bodies.index(b) for b in bodies])
    last_quarter = angle[-(len(angle) // 4 + 1) :]
    if averaged.count < _FEWEST_TURNS or np.ptp(last_quarter) < 2 * math.pi:
        verdict = _without_turning(machine, trajectory, averaged, speed, angle)
    else:
        verdict = _turning(machine, trajectory, averaged, bodies, vibration, free)
    if trajectory.failure:
        return replace(verdict, outcome=Outcome.FAILED, advice=None)
    if trajectory.stopped_by == SPEED_LIMIT:
        evidence = replace(verdict.evidence, beyond_limit=True)
        return replace(verdict, evidence=evidence, outcome=classify(evidence), advice=None)
    turning = verdict.evidence.turning or verdict.outcome is Outcome.UNIDENTIFIED
    return _by_locking(machine, trajectory, verdict) if is_locking(machine) and turning else verdict


def _by_locking(machine: Machine, trajectory: Trajectory, verdict: Verdict) -> Verdict:
    """The verdict on rotors that may be taken along: by their mean speeds over whole periods."""
    found = locked(machine, trajectory)
    if found is None:
        return verdict
    outcome = found.evidence.outcome()
    advice = None
    if outcome is Outcome.UNIDENTIFIED:
        span = found.window[1] - found.window[0]
        needed = 2 * (FEWEST_PERIODS + 1) * span / max(found.evidence.periods, 1)
        unit = f" {machine.units.time}" if machine.units.time else ""
        advice = f"fewer than {FEWEST_PERIODS} whole periods were made in the last half: run at least until {needed:.3g}{unit}"
    evidence = replace(verdict.evidence, mean_speed=abs(found.mean_speed), turning=True)
    return replace(verdict, outcome=outcome, evidence=evidence, window=found.window, locked=found, advice=advice)


def _turning(
    machine: Machine,
    trajectory: Trajectory,
    averaged: Turns,
    bodies: list[RotatingBody],
    vibration: Vibration,
    free: float | None,
) -> Verdict:
    index = [machine.bodies.index(b) for b in bodies]
    own = unbalances(machine)[index]
    sense = float(np.sign(averaged.speed[-1]))
    speed = sense * averaged.speed
    expected = None if free is None else sense * free
    remaining = own[0] + (own[1:, None] * averaged.phases).sum(axis=0)
    scale = abs(own[0]) or float(np.abs(own).max())
    residual = remaining / scale if scale else np.zeros(len(speed))
    # A body slips that keeps falling back (or running ahead) over the last fifth of the run.
    late = averaged.last(0.2)
    lag = np.abs(averaged.followers[:, late].mean(axis=1) - averaged.speed[late].mean()) if len(bodies) > 1 else np.zeros(1)
    duration = averaged.time[-1] - averaged.time[late][0]
    slip = float(lag.max()) if float(lag.max()) * duration > 2 * math.pi else 0.0
    slipping = slip > SLIP_TOLERANCE * speed[late].mean()
    reference = expected or float(speed[late].mean())
    observed = modulation(averaged.time, averaged.angle, speed, MODULATION_THRESHOLD * float(speed[late].mean()))
    slow = [speed / reference] if slipping else [speed / reference, residual]
    heading = trend(np.array([s.astype(complex) for s in slow]), STEADY_TOLERANCE)
    quiet = float(np.ptp(speed[late])) <= MODULATION_THRESHOLD * float(speed[late].mean())
    if slipping:
        quiet = quiet and creep(averaged.followers) <= SLIP_DRIFT_TOLERANCE * slip
    modulated = observed is not None and observed.sustained
    window = (
        slice(observed.begin, observed.end)
        if modulated and observed
        else averaged.last(max(_LAST_SHARE, 2 * PER_TURN / len(speed)))
    )
    phases = {b.name: float(wrapped(np.angle(averaged.phases[i, -1]))) for i, b in enumerate(bodies[1:])}
    final = np.zeros(len(bodies))
    if not slipping:
        final[1:] = [sense * phases[b.name] for b in bodies[1:]]
    resonance = vibration.last_maximum(expected, final) if expected else None
    evidence = Evidence(
        turning=True,
        mean_speed=_mean_speed(averaged, window) * sense,
        lowest_speed=float(speed[window].min()),
        free_speed=expected,
        resonance=resonance,
        residual=float(np.abs(residual[window]).max()) if scale else None,
        slip=slip,
        steady=heading.steady(STEADY_TOLERANCE) and quiet,
        modulated=modulated,
    )
    outcome = classify(evidence)
    settling = _settling_time(
        averaged, speed, residual, None if slipping else reference, window, observed if modulated else None
    )
    return Verdict(
        outcome,
        evidence,
        (float(averaged.time[window][0]), float(averaged.time[window][-1])),
        phases,
        np.abs(residual),
        averaged,
        heading,
        observed if modulated else None,
        settling if outcome is not Outcome.UNIDENTIFIED else None,
        _advice(trajectory, heading, observed, machine.units.time) if outcome is Outcome.UNIDENTIFIED else None,
        outcome is Outcome.PASSED and not slipping and _faster_branch(machine, vibration, evidence, sense, final),
    )


def _faster_branch(machine: Machine, vibration: Vibration, e: Evidence, sense: float, phases: np.ndarray) -> bool:
    """Whether the drive's torque exceeds the vibration torque again somewhere between the speed reached and the free speed."""
    if e.free_speed is None or e.resonance is None or machine.rotor.coordinate.prescribed is not None:
        return False
    torque = net_torque(machine, machine.rotor)
    speeds = np.linspace(e.mean_speed, e.free_speed, 402)[1:-1]
    drive = np.array([sense * torque(sense * w) for w in speeds])
    balance = drive - vibration.torque(speeds, phases)
    # Between two branches the vibration takes more than the drive gives: without such a gap there is only one.
    small = 1e-3 * float(np.abs(drive).max())
    short = np.flatnonzero(balance < -small)
    return bool(len(short) and (balance[short[0] :] > small).any())


def _mean_speed(averaged: Turns, window: slice) -> float:
    """Angle over time: the mean over time, not over the turns."""
    t, a = averaged.time[window], averaged.angle[window]
    return float((a[-1] - a[0]) / (t[-1] - t[0]))


def _settling_time(
    averaged: Turns,
    speed: np.ndarray,
    residual: np.ndarray,
    reference: float | None,
    window: slice,
    modulation: Modulation | None,
) -> float:
    """From when on the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of what they end with.

    With a modulation: from when on both stay within its range, widened by the same amounts.
    """
    margin = SPEED_TOLERANCE * (reference or float(speed[window].mean()))
    if modulation is not None:
        off = (speed < modulation.low - margin) | (speed > modulation.high + margin)
        # The approach may cross the range: settled is what has been seen to repeat, one period after the range is last left.
        extra = modulation.period
    else:
        off = np.abs(speed - speed[window].mean()) > margin
        extra = 0.0
        if reference is not None:
            off |= np.abs(np.abs(residual) - np.abs(residual[window]).mean()) > UNBALANCE_TOLERANCE
    last = np.flatnonzero(off)
    first = (
        float(averaged.time[last[-1] + 1])
        if len(last) and last[-1] + 1 < len(speed)
        else float(averaged.time[0] if not len(last) else averaged.time[-1])
    )
    return min(first + extra, float(averaged.time[-1]))


def _advice(trajectory: Trajectory, heading: Trend, modulation: Modulation | None, time_unit: str) -> str:
    end, unit = trajectory.end_time, f" {time_unit}" if time_unit else ""
    if modulation is not None:
        needed = max(2 * end, end + 10 * modulation.period)
        return f"a modulation of period {modulation.period:.4g} still changes: run at least until {needed:.3g}{unit}"
    if math.isfinite(heading.windows_needed):
        needed = end + max(0.2 * end, (1 + heading.windows_needed) * 0.1 * end)
        return f"the motion still approaches its end: run at least until {needed:.3g}{unit}"
    return f"the motion is still under way: run at least until {2 * end:.3g}{unit}"


def _without_turning(
    machine: Machine, trajectory: Trajectory, averaged: Turns, speed: np.ndarray, angle: np.ndarray
) -> Verdict:
    n = len(speed) // 4
    end = trajectory.end_time
    window = (float(trajectory.time[-n]) if n else 0.0, end)
    if n < 2 or np.ptp(angle[-2 * n :]) > 2 * math.pi:
        # Some turning is left, but fewer turns than are needed to average over.
        evidence = Evidence(turning=False)
    else:
        earlier, later = np.abs(speed[-2 * n : -n]).max(), np.abs(speed[-n:]).max()
        fastest = np.abs(speed).max() or 1.0
        swings = bool((np.sign(speed[-2 * n :]) > 0).any() and (np.sign(speed[-2 * n :]) < 0).any())
        rest = bool(later <= 1e-4 * fastest) if fastest > 0 else True
        evidence = Evidence(turning=False, at_rest=rest, moving=swings and not rest, steady=bool(later <= earlier * (1 + 1e-6)))
    outcome = classify(evidence)
    advice = (
        f"fewer than {_FEWEST_TURNS} turns were made: run at least until {max(4 * end, 1e-9):.3g} {machine.units.time}".rstrip()
        if outcome is Outcome.UNIDENTIFIED
        else None
    )
    return Verdict(
        outcome, evidence, window, {}, np.empty(0), averaged, Trend(math.inf, math.inf, math.inf), None,
        None if outcome is Outcome.UNIDENTIFIED else end, advice,
    )  # fmt: skip
