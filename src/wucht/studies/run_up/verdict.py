"""From a trajectory to the evidence, the outcome, and what goes into the summary."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

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
    LAG_TOLERANCE,
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
LAG_CREEP_TOLERANCE = 0.02  # of the lag: by how much the mean speed of a body that lags may wander between windows
_FEWEST_TURNS = 6
_LAST_SHARE = 0.05
_LOCKED_PERIODS = 200  # a run until settled of rotors that may be entrained lasts for four hundred of their turns
_NO_TREND = Trend(math.inf, math.inf, math.inf)


@dataclass(frozen=True)
class Verdict:
    """What became of a run. window: begin and end time of the last window. phases: circular means over the last turn.

    settling_time, modulation, advice: None where they do not apply. faster_branch: the drive could hold a higher speed as well.
    """

    outcome: Outcome
    evidence: Evidence
    window: tuple[float, float]
    phases: dict[str, float] = field(default_factory=dict)
    trend: Trend = _NO_TREND
    modulation: Modulation | None = None
    settling_time: float | None = None
    advice: str | None = None
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
    bodies = machine.group(machine.rotor)
    (angle, speed), *others = (motion_of(machine, trajectory, b) for b in bodies)
    averaged = turns(trajectory.time, angle, speed, {b.name: m for b, m in zip(bodies[1:], others, strict=True)})
    if averaged.count < _FEWEST_TURNS or np.ptp(angle[-(len(angle) // 4 + 1) :]) < 2 * math.pi:
        verdict = _without_turning(machine, trajectory, speed, angle)
    else:
        verdict = _turning(machine, trajectory.end_time, averaged, bodies, free)
    if trajectory.failure:
        return replace(verdict, outcome=Outcome.FAILED, advice=None)
    if trajectory.stopped_by == SPEED_LIMIT:
        evidence = replace(verdict.evidence, beyond_limit=True)
        return replace(verdict, evidence=evidence, outcome=classify(evidence), advice=None)
    turning = verdict.evidence.turning or verdict.outcome is Outcome.UNIDENTIFIED
    return _by_locking(machine, trajectory, verdict) if is_locking(machine) and turning else verdict


def _by_locking(machine: Machine, trajectory: Trajectory, verdict: Verdict) -> Verdict:
    """The verdict on rotors that may be entrained: by their mean speeds over whole periods."""
    means = locked(machine, trajectory)
    if means is None:
        return verdict
    outcome, advice, (begin, end) = means.evidence.outcome(), None, means.window
    if outcome is Outcome.UNIDENTIFIED:
        needed = 2 * (FEWEST_PERIODS + 1) * (end - begin) / max(means.evidence.periods, 1)
        advice = _longer(machine, f"fewer than {FEWEST_PERIODS} whole periods were made in the last half", needed)
    evidence = replace(verdict.evidence, mean_speed=abs(means.speeds[machine.rotor.name]), turning=True)
    return replace(verdict, outcome=outcome, evidence=evidence, window=means.window, locked=means, advice=advice)


def _longer(machine: Machine, why: str, until: float) -> str:
    return f"{why}: run at least until {until:.3g} {machine.units.time}".rstrip()


def _turning(machine: Machine, end: float, averaged: Turns, bodies: list[RotatingBody], free: float | None) -> Verdict:
    index = [machine.bodies.index(b) for b in bodies]
    own, vibration = unbalances(machine)[index], Vibration.of(machine).only(index)
    sense = float(np.sign(averaged.speed[-1]))
    speed, expected = sense * averaged.speed, None if free is None else sense * free
    scale = abs(own[0]) or float(np.abs(own).max())
    residual = (own[0] + (own[1:, None] * averaged.phases).sum(axis=0)) / scale if scale else np.zeros(len(speed))
    # A body lags that keeps falling back (or running ahead) over the last fifth of the run.
    late = averaged.last(0.2)
    mean = float(speed[late].mean())
    lag = float(np.abs(averaged.followers[:, late].mean(axis=1) - averaged.speed[late].mean()).max(initial=0.0))
    lag = lag if lag * (averaged.time[-1] - averaged.time[late][0]) > 2 * math.pi else 0.0
    asynchronous = lag > LAG_TOLERANCE * mean
    reference = expected or mean
    heading = trend(np.array([speed / reference] if asynchronous else [speed / reference, residual]), STEADY_TOLERANCE)
    wandering = asynchronous and creep(averaged.followers) > LAG_CREEP_TOLERANCE * lag
    quiet = not wandering and float(np.ptp(speed[late])) <= MODULATION_THRESHOLD * mean
    observed = modulation(averaged.time, averaged.angle, speed, MODULATION_THRESHOLD * mean)
    sustained = observed if observed is not None and observed.sustained else None
    last = averaged.last(max(_LAST_SHARE, 2 * PER_TURN / len(speed)))
    window = last if sustained is None else slice(sustained.begin, sustained.end)
    phases = {b.name: float(wrapped(np.angle(p[-1]))) for b, p in zip(bodies[1:], averaged.phases, strict=True)}
    final = np.array([0.0, *(0.0 if asynchronous else sense * phase for phase in phases.values())])
    time, angle = averaged.time[window], averaged.angle[window]
    evidence = Evidence(
        turning=True,
        mean_speed=float((angle[-1] - angle[0]) / (time[-1] - time[0])) * sense,  # over time, not over the turns
        lowest_speed=float(speed[window].min()),
        free_speed=expected,
        resonance=vibration.last_maximum(expected, final) if expected else None,
        residual=float(np.abs(residual[window]).max()) if scale else None,
        lag=lag,
        steady=heading.steady(STEADY_TOLERANCE) and quiet,
        modulated=sustained is not None,
    )
    verdict = Verdict(classify(evidence), evidence, (float(time[0]), float(time[-1])), phases, heading, sustained)
    if verdict.outcome is Outcome.UNIDENTIFIED:
        return replace(verdict, advice=_advice(machine, end, heading, observed))
    settling = _settling_time(averaged.time, speed, residual, None if asynchronous else reference, window, sustained)
    passed = verdict.outcome is Outcome.PASSED and not asynchronous
    faster = passed and _faster_branch(machine, vibration, evidence, sense, final)
    return replace(verdict, settling_time=settling, faster_branch=faster)


def _faster_branch(machine: Machine, vibration: Vibration, e: Evidence, sense: float, phases: np.ndarray) -> bool:
    """Whether the drive's torque exceeds the vibration torque again somewhere between the speed reached and the free speed."""
    if e.free_speed is None or e.resonance is None or machine.rotor.coordinate.prescribed is not None:
        return False
    torque = net_torque(machine, machine.rotor)
    speeds = np.linspace(e.mean_speed, e.free_speed, 402)[1:-1]
    drive = np.array([sense * torque(sense * w) for w in speeds])
    balance = drive - vibration.torque(speeds, phases)[0]
    # Between two branches the vibration takes more than the drive gives: without such a gap there is only one.
    small = 1e-3 * float(np.abs(drive).max())
    short = np.flatnonzero(balance < -small)
    return bool(len(short) and (balance[short[0] :] > small).any())


def _settling_time(
    time: np.ndarray, speed: np.ndarray, residual: np.ndarray, reference: float | None, window: slice, cycle: Modulation | None
) -> float:
    """From when on the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of what they end with.

    With a modulation: from when on both stay within its range, widened by the same amounts.
    """
    margin, period = SPEED_TOLERANCE * (reference or float(speed[window].mean())), 0.0
    if cycle is not None:
        off = (speed < cycle.low - margin) | (speed > cycle.high + margin)
        # The approach may cross the range: settled is what has been seen to repeat, one period after the range is last left.
        period = cycle.period
    else:
        off = np.abs(speed - speed[window].mean()) > margin
        if reference is not None:
            off |= np.abs(np.abs(residual) - np.abs(residual[window]).mean()) > UNBALANCE_TOLERANCE
    first = int(np.flatnonzero(off).max(initial=-1)) + 1
    return min(float(time[min(first, len(speed) - 1)]) + period, float(time[-1]))


def _advice(machine: Machine, end: float, heading: Trend, modulation: Modulation | None) -> str:
    if modulation is not None:
        needed = max(2 * end, end + 10 * modulation.period)
        return _longer(machine, f"a modulation of period {modulation.period:.4g} still changes", needed)
    if math.isfinite(heading.windows_needed):
        needed = end + max(0.2 * end, (1 + heading.windows_needed) * 0.1 * end)
        return _longer(machine, "the motion still approaches its end", needed)
    return _longer(machine, "the motion is still under way", 2 * end)


def _without_turning(machine: Machine, trajectory: Trajectory, speed: np.ndarray, angle: np.ndarray) -> Verdict:
    n, end, evidence = len(speed) // 4, trajectory.end_time, Evidence(turning=False)
    # Otherwise some turning is left, but fewer turns than are needed to average over.
    if n >= 2 and not np.ptp(angle[-2 * n :]) > 2 * math.pi:
        earlier, later = np.abs(speed[-2 * n : -n]).max(), np.abs(speed[-n:]).max()
        rest = not later > 1e-4 * np.abs(speed).max()
        swings = bool((speed[-2 * n :] > 0).any() and (speed[-2 * n :] < 0).any())
        steady = bool(later <= earlier * (1 + 1e-6))
        evidence = Evidence(turning=False, at_rest=rest, moving=swings and not rest, steady=steady)
    verdict = Verdict(classify(evidence), evidence, (float(trajectory.time[-n]) if n else 0.0, end))
    if verdict.outcome is Outcome.UNIDENTIFIED:
        return replace(verdict, advice=_longer(machine, f"fewer than {_FEWEST_TURNS} turns were made", max(4 * end, 1e-9)))
    return replace(verdict, settling_time=end)
