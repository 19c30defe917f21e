"""From what was seen of a motion to the evidence, the outcome, and what goes into the summary."""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.analysis.vibration import Vibration, unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import net_torque
from wucht.machines.tree import RotatingBody
from wucht.numerics.observers.modulation import Modulation, modulation
from wucht.numerics.observers.turn_record import Blocks, TurnRecord
from wucht.numerics.observers.trend import UNKNOWN, Trend, trend
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
from wucht.studies.motion.locking import Locked, is_locking, locked
from wucht.studies.motion.observation import Observation

STEADY_TOLERANCE = 1e-3  # of the free speed and of the rotor's unbalance
MODULATION_THRESHOLD = 2e-3  # range of the turn-averaged speed, of the mean speed: less is not called a modulation
LAG_CREEP_TOLERANCE = 0.02  # of the lag: by how much the mean speed of a body that lags may wander between windows
_FEWEST_TURNS = 6
_LAST_SHARE = 0.05
_LOCKED_PERIODS = 200  # a run until settled of rotors that may be entrained lasts for four hundred of their turns


@dataclass(frozen=True)
class Verdict:
    """What became of a run. window: begin and end time of the last window. phases: circular means over the last turn.

    settling_time, modulation, advice: None where they do not apply. faster_branch: the drive could hold a higher speed as well.
    """

    outcome: Outcome
    evidence: Evidence
    window: tuple[float, float]
    phases: dict[str, float] = field(default_factory=dict)
    trend: Trend = UNKNOWN
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


def judge(machine: Machine, seen: Observation, free: float | None, failure: str | None = None, beyond: bool = False) -> Verdict:
    """Decide the outcome of a run.

    free: what the drive reaches without vibration, at the end of the run. failure: why the run failed, if it did. beyond: whether
    it ended because it reached the speed limit.
    """
    machine = machine.at(seen.end_time)
    bodies, record = machine.group(machine.rotor), seen.rotors[machine.rotor.name]
    angle = seen.main.last(0.25)
    if record.turns < _FEWEST_TURNS or angle.greatest_angle.max() - angle.least_angle.min() < 2 * math.pi:
        verdict = _without_turning(machine, seen)
    else:
        verdict = _turning(machine, seen.end_time, record, bodies, free)
    if failure:
        return replace(verdict, outcome=Outcome.FAILED, advice=None)
    if beyond:
        evidence = replace(verdict.evidence, beyond_limit=True)
        return replace(verdict, evidence=evidence, outcome=classify(evidence), advice=None)
    turning = verdict.evidence.turning or verdict.outcome is Outcome.UNIDENTIFIED
    return _by_locking(machine, seen, verdict) if is_locking(machine) and turning else verdict


def _by_locking(machine: Machine, seen: Observation, verdict: Verdict) -> Verdict:
    """The verdict on rotors that may be entrained: by their mean speeds over whole periods."""
    means = locked(machine, seen)
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


def _turning(machine: Machine, end: float, record: TurnRecord, bodies: list[RotatingBody], free: float | None) -> Verdict:
    index, others = [machine.bodies.index(b) for b in bodies], [b for b in machine.bodies if b is not bodies[0]]
    own, vibration = unbalances(machine)[index], Vibration.of(machine).only(index)
    about, whole, sense = [others.index(b) for b in bodies[1:]], record.whole, record.sense
    expected = None if free is None else sense * free
    scale = abs(own[0]) or float(np.abs(own).max())

    def unbalance(blocks: Blocks) -> np.ndarray:
        """What is left of the rotor's unbalance, in its own frame: the share of it (K,), complex."""
        return (own[0] + own[1:] @ blocks.phases[about]) / scale if scale else np.zeros(len(blocks))

    # A body lags that keeps falling back (or running ahead) over the last fifth of the run.
    late = record.last(0.2)
    mean, *followers = late.mean_speeds
    lag = float(np.abs(np.array(followers)[about] - mean).max(initial=0.0))
    lag = lag if lag * (late.time[-1] - late.time[0]) > 2 * math.pi else 0.0
    asynchronous = lag > LAG_TOLERANCE * mean
    reference = expected or mean
    residual = unbalance(whole)
    heading = trend(np.array([whole.speed / reference, *([] if asynchronous else [residual])]), STEADY_TOLERANCE)
    if asynchronous:
        slipping = trend(whole.followers[about] / lag, LAG_CREEP_TOLERANCE)
        heading = heading if slipping.steady(LAG_CREEP_TOLERANCE) else slipping
    quiet = float(late.highest.max() - late.lowest.min()) <= MODULATION_THRESHOLD * mean
    observed = modulation(record, MODULATION_THRESHOLD * mean)
    sustained = observed if observed is not None and observed.sustained else None
    last = record.whole_turns(max(_LAST_SHARE, 2 / record.turns))
    window = last if sustained is None else sustained.window
    phases = {b.name: float(wrapped(np.angle(p))) for b, p in zip(bodies[1:], last.phases[about, -1], strict=True)}
    final = np.array([0.0, *(0.0 if asynchronous else sense * phase for phase in phases.values())])
    evidence = Evidence(
        turning=True,
        mean_speed=window.mean_speeds[0],
        lowest_speed=float(window.lowest.min()),
        free_speed=expected,
        resonance=None if expected == 0 else vibration.last_maximum(expected, final),
        residual=float(np.abs(unbalance(window)).max()) if scale else None,
        lag=lag,
        steady=heading.steady(STEADY_TOLERANCE) and quiet,
        modulated=sustained is not None,
    )
    verdict = Verdict(classify(evidence), evidence, (float(window.time[0]), float(window.time[-1])), phases, heading, sustained)
    if verdict.outcome is Outcome.UNIDENTIFIED:
        return replace(verdict, advice=_advice(machine, end, heading, observed))
    settling = _settling_time(whole, residual, window, unbalance(window), None if asynchronous else reference, sustained)
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
    whole: Blocks, residual: np.ndarray, window: Blocks, final: np.ndarray, reference: float | None, cycle: Modulation | None
) -> float:
    """From when on the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of what they end with.

    With a modulation: from when on both stay within its range, widened by the same amounts.
    """
    mean, period = float(window.speed.mean()), 0.0
    margin = SPEED_TOLERANCE * (reference or mean)
    if cycle is not None:
        off = (whole.lowest < cycle.low - margin) | (whole.highest > cycle.high + margin)
        # The approach may cross the range: settled is what has been seen to repeat, one period after the range is last left.
        period = cycle.period
    else:
        off = (whole.highest > mean + margin) | (whole.lowest < mean - margin)
        if reference is not None:
            off |= np.abs(np.abs(residual) - np.abs(final).mean()) > UNBALANCE_TOLERANCE
    first = int(np.flatnonzero(off).max(initial=-1)) + 1
    return min(float(whole.middle[min(first, len(whole) - 1)]) + period, float(whole.time[-1]))


def _advice(machine: Machine, end: float, heading: Trend, modulation: Modulation | None) -> str:
    if modulation is not None:
        needed = max(2 * end, end + 10 * modulation.period)
        return _longer(machine, f"a modulation of period {modulation.period:.4g} still changes", needed)
    if math.isfinite(heading.windows_needed):
        needed = end + max(0.2 * end, (1 + heading.windows_needed) * 0.1 * end)
        return _longer(machine, "the motion still approaches its end", needed)
    return _longer(machine, "the motion is still under way", 2 * end)


def _without_turning(machine: Machine, seen: Observation) -> Verdict:
    end, evidence, half = seen.end_time, Evidence(turning=False), seen.main.last(0.5)
    n, speeds = len(half.time) // 2, np.maximum(np.abs(half.least_speed), np.abs(half.greatest_speed))
    # Otherwise some turning is left, but fewer turns than are needed to average over.
    if n >= 1 and not half.greatest_angle.max() - half.least_angle.min() > 2 * math.pi:
        whole = seen.main.last(1.0)
        greatest = max(float(np.abs(whole.least_speed).max()), float(whole.greatest_speed.max()))
        earlier, later = float(speeds[:-n].max()), float(speeds[-n:].max())
        rest = not later > 1e-4 * greatest
        swings = bool(half.greatest_speed.max() > 0 and half.least_speed.min() < 0)
        steady = bool(later <= earlier * (1 + 1e-6))
        evidence = Evidence(turning=False, at_rest=rest, moving=swings and not rest, steady=steady)
    verdict = Verdict(classify(evidence), evidence, (float(half.time[-n]) if n else 0.0, end))
    if verdict.outcome is Outcome.UNIDENTIFIED:
        return replace(verdict, advice=_longer(machine, f"fewer than {_FEWEST_TURNS} turns were made", max(4 * end, 1e-9)))
    return replace(verdict, settling_time=end)
