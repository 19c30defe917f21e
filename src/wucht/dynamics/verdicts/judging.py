"""From the observation of a motion to its outcome, and the numbers for the summary."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from wucht.analysis.time_constants import run_up_time, runaway_limit, slowest_decay, vibration_decay
from wucht.analysis.working_points import creep_speed, is_held_at_rest, torque_surplus
from wucht.dynamics.verdicts.evidence import REASON_IN_NOISE, UNREST, RotorAssessment, assess_rotor
from wucht.dynamics.verdicts.locking import assess_locking, is_locking, rotor_outcomes, turning_outcomes
from wucht.dynamics.verdicts.observation import Observation
from wucht.dynamics.verdicts.outcomes import (
    AMPLITUDE_TOLERANCE,
    FEWEST_PERIODS,
    FEWEST_TURNS,
    SPEED_TOLERANCE,
    UNBALANCE_TOLERANCE,
    Evidence,
    Outcome,
    classify,
)
from wucht.dynamics.verdicts.swings import (
    REASON_COASTING,
    mean_turning_evidence,
    rotors_not_started,
    run_factor_until_swinging,
    swing_of,
)
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.machines.changes import last_change
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.observers.projection import Course
from wucht.numerics.observers.records import Blocks

_SHORT = 0.98  # of the free speed: a rotor held below has not reached it


def rising_evidence(machine: Machine, assessment: RotorAssessment) -> Evidence[float]:
    """Return the evidence of a rotor whose speed still rises, beyond all resonances, with bodies that do not lag.

    It is settled as soon as it is known that the vibration holds it below its free speed; or that nothing limits it.
    """
    e, (mean, *_) = assessment.evidence, assessment.projections
    rises = mean.course is not Course.STATIONARY and mean.high > mean.last
    limit = runaway_limit(machine) if e.free_speed is None else _SHORT * e.free_speed
    moving = assessment.growing or assessment.unrest > UNREST
    if e.has_settled or moving or not (rises and e.is_beyond_resonance) or not e.asynchronous.no or limit is None:
        return e
    speeds = np.linspace(assessment.speed, limit, 800)
    is_held = not (torque_surplus(machine, assessment.vibration, assessment.final_phases, speeds) > 0).all()
    return replace(e, has_settled=is_held, unheld=not is_held and e.free_speed is None)


def has_faster_branch(machine: Machine, assessment: RotorAssessment) -> bool:
    """True if the drive's torque exceeds the vibration torque again between the speed reached and the free speed."""
    e = assessment.evidence
    if e.free_speed is None or e.resonance is None or machine.rotor.coordinate.prescribed_velocity is not None:
        return False
    speeds = np.linspace(assessment.speed, e.free_speed, 402)[1:-1]
    surplus = torque_surplus(machine, assessment.vibration, assessment.final_phases, speeds)
    # Between two branches the vibration takes more than the drive gives: without such a gap there is only one.
    small = 1e-3 * float(np.abs(surplus).max())
    short = np.flatnonzero(surplus < -small)
    return bool(len(short) and (surplus[short[0] :] > small).any())


LONGER = 2.5  # times the run: at least, and if the time needed is unknown; so never three times what is needed
_VERY_MANY_TURNS = 40_000  # after which a fluctuation that neither falls nor drifts is treated as lasting
_RUN_UPS, _DECAYS = 2.0, 12.0  # times the run-up, and times the slowest decay: transients are over then
_FLOAT = 1e-9  # share that is rounding
_OLD = 5.0  # decays of the slowest free vibration, after which a motion that is not at rest is treated as the final one
_RESTLESS = (Outcome.BALANCER_CAPTURED, Outcome.CAPTURED_MODULATED, Outcome.NOT_ENTRAINED, Outcome.NOT_SYNCHRONISED)


def judge(
    machine: Machine, observation: Observation, free: float | None, failure: str | None = None, is_beyond_limit: bool = False
) -> Verdict:
    """Decide the outcome of a run.

    free: the drive's speed without vibration, at the end of the run. failure: why the run failed, if it did.
    is_beyond_limit: it ended because it reached the speed limit.
    """
    machine = machine.at(observation.end_time)
    record, angle = observation.rotors[machine.rotor.name], observation.main.last(0.25)
    has_turned = len(angle.time) > 0 and bool(angle.greatest_angle.max() - angle.least_angle.min() >= 2 * math.pi)
    turning, not_started = has_turned and record.turns >= FEWEST_TURNS, rotors_not_started(machine, observation)
    if turning:
        verdict = _turning_verdict(machine, observation, free)
    else:
        verdict = _swinging_verdict(machine, observation, free, machine.rotor.name in not_started)
    verdict = replace(verdict, not_started=not_started)
    if failure:
        return replace(verdict, outcome=Outcome.FAILED, advice=None, needed_time=None)
    if is_beyond_limit:
        evidence = replace(verdict.evidence, beyond_limit=True)
        return replace(verdict, evidence=evidence, outcome=classify(evidence), advice=None, needed_time=None)
    if observation.end_time < (changes := last_change(machine)):
        return open_verdict(machine, verdict, f"the machine still changes at {changes:.4g} {machine.units.time}", 2 * changes)
    if _is_creeping(machine, observation):
        outcome = Outcome.NOT_STARTED if not_started else Outcome.STOPPED
        return replace(verdict, outcome=outcome, settling_time=None, advice=None, needed_time=None)
    if verdict.outcome is Outcome.NOT_STARTED:
        standing = dict.fromkeys(not_started, Outcome.NOT_STARTED) if len(machine.rotors) > 1 else {}
        return replace(verdict, rotors=standing | turning_outcomes(machine, observation))
    verdict = _locking_verdict(machine, observation, verdict) if is_locking(machine) and has_turned else verdict
    return _verdict_after_transients(machine, verdict, observation.end_time)


def _is_creeping(machine: Machine, observation: Observation) -> bool:
    """True if dry friction holds the only rotor, and it did no more than creep in the last quarter of the time."""
    if len(machine.rotors) > 1 or not is_held_at_rest(machine):
        return False
    last = observation.main.last(0.25)
    return float(np.abs([last.least_speed, last.greatest_speed]).max(initial=0.0)) <= creep_speed(machine)


def _verdict_after_transients(machine: Machine, verdict: Verdict, end: float) -> Verdict:
    """Return the verdict; ``unidentified`` for a motion that is not at rest as long as it may be a transient."""
    if verdict.outcome in _RESTLESS and end < (needed_time := _OLD * vibration_decay(machine)):
        reason = "free vibrations have hardly decayed"
    elif verdict.outcome is Outcome.PASSED and verdict.assessment is not None and verdict.assessment.unrest > UNREST:
        needed_time = _DECAYS * slowest_decay(machine, verdict.assessment.sense * verdict.speed)
        reason = "bodies still move about the rotor"
        if end >= needed_time:
            return verdict
    else:
        return verdict
    return open_verdict(machine, verdict, reason, needed_time)


def _locking_verdict(machine: Machine, observation: Observation, verdict: Verdict) -> Verdict:
    """Return the verdict on rotors that may be entrained: by their mean speeds over whole periods."""
    locking = assess_locking(machine, observation)
    if locking is None:
        return verdict
    end, periods = observation.end_time, locking.evidence.periods
    before = verdict.needed_time or LONGER * end
    drifting = verdict.assessment is not None and verdict.assessment.drifting and not locking.evidence.is_locked
    verdict = replace(
        verdict,
        outcome=Outcome.UNIDENTIFIED if drifting else locking.evidence.outcome(by_vibration=observation.vibration is not None),
        evidence=replace(verdict.evidence, turning=True),
        window=(float(locking.final.time[0]), float(locking.final.time[-1])),
        speed=abs(locking.final_speeds[machine.rotor.name]),
        advice=None,
        needed_time=None,
        locking=locking,
    )
    if verdict.outcome is not Outcome.UNIDENTIFIED:
        rotors, common = rotor_outcomes(machine, observation, locking)
        rotors |= dict.fromkeys(verdict.not_started, Outcome.NOT_STARTED)
        return replace(verdict, rotors=rotors, evidence=common or verdict.evidence)
    reason, needed_time = "the phases still move", before
    if periods < FEWEST_PERIODS:
        reason = f"fewer than {FEWEST_PERIODS} whole periods lie in the last half of the run"
        needed_time = LONGER * end
    return open_verdict(machine, verdict, reason, needed_time)


def open_verdict(machine: Machine, verdict: Verdict, reason: str, until: float | None = None) -> Verdict:
    """Return a verdict left open for a reason. until: the end of a run that may decide; None: no longer run does."""
    advice, needed_time = f"{reason}: a longer run would not change the verdict", None
    if until is not None:
        digit = 10.0 ** (math.floor(math.log10(until)) - 2)
        until = math.ceil(until / digit * (1 - _FLOAT)) * digit  # rounded up: a run of the printed length is enough
        advice = f"{reason}: run at least until {until:.3g} {machine.units.time}".rstrip()
        needed_time = float(f"{until:.3g}")
    return replace(
        verdict, outcome=Outcome.UNIDENTIFIED, settling_time=None, amplitude_settling_time=None, advice=advice,
        needed_time=needed_time,
    )  # fmt: skip


def _turning_verdict(machine: Machine, observation: Observation, free: float | None) -> Verdict:
    record = observation.rotors[machine.rotor.name]
    assessment = assess_rotor(machine, machine.rotor, record, free, observation.end_time, observation.noise)
    evidence, window = rising_evidence(machine, assessment), assessment.window
    verdict = Verdict(
        classify(evidence), evidence, (float(window.time[0]), float(window.time[-1])), assessment, assessment.speed
    )
    if verdict.outcome is Outcome.UNIDENTIFIED:
        if assessment.undecidable_reason in (REASON_COASTING, REASON_IN_NOISE) or (
            assessment.undecidable_reason and _is_long_run(machine, observation.end_time, record.turns, assessment)
        ):
            return open_verdict(machine, verdict, assessment.undecidable_reason)
        return open_verdict(machine, verdict, *_advice(machine, observation.end_time, assessment))
    has_passed = verdict.outcome is Outcome.PASSED
    return replace(
        verdict,
        settling_time=_settling_time(record.whole, assessment),
        amplitude_settling_time=_amplitude_settling_time(record.whole, assessment),
        faster_branch=has_passed and has_faster_branch(machine, assessment),
    )


def _settling_time(whole: Blocks, assessment: RotorAssessment) -> float:
    """The time from which the speed stays within 0.5 % (of the free speed) and the unbalance within 1 % of their final values.

    With a modulation: from which both stay within its range, widened by the same amounts.
    """
    period, reference = 0.0, assessment.evidence.free_speed or assessment.speed
    margin, low, high, cycle = SPEED_TOLERANCE * reference, assessment.speed, assessment.speed, assessment.modulation
    if cycle is not None:
        # The approach may cross the range: settled is a motion that has repeated, one period after the range is last left.
        low, high, period = cycle.low, cycle.high, cycle.period
    is_outside = (whole.highest > high + margin) | (whole.lowest < low - margin)
    if cycle is None and not assessment.evidence.asynchronous:
        final = (assessment.window.greatest_sum.mean() + assessment.window.least_sum.mean()) / 2
        is_outside |= (whole.greatest_sum > final + UNBALANCE_TOLERANCE) | (whole.least_sum < final - UNBALANCE_TOLERANCE)
    return _last_exit_time(whole, is_outside, period)


def _amplitude_settling_time(whole: Blocks, assessment: RotorAssessment) -> float | None:
    """The time from which the largest distances over turns stay within those of the last window, widened by 1 % of the largest.

    Free vibrations decay independently, often long after the speed has settled. None where bodies lag: it beats for good; and
    where they left those limits within the length of the window before it: the amplitude still changes.
    """
    if not assessment.evidence.asynchronous.no:
        return None
    window, (_, low, high) = assessment.window, assessment.window.amplitudes
    margin = AMPLITUDE_TOLERANCE * float(whole.greatest_amplitude.max())
    is_outside = (whole.greatest_amplitude > high + margin) | (whole.least_amplitude < low - margin)
    if assessment.modulation is not None:
        return _last_exit_time(whole, is_outside, assessment.modulation.period)
    settled, begin, end = _last_exit_time(whole, is_outside, 0.0), float(window.time[0]), float(window.time[-1])
    return None if is_outside.any() and settled > begin - (end - begin) else settled


def _last_exit_time(whole: Blocks, is_outside: np.ndarray, period: float) -> float:
    """The time of the first block after which none ``is_outside`` (K,), and a period more."""
    first = int(np.flatnonzero(is_outside).max(initial=-1)) + 1
    return min(float(whole.middle[min(first, len(whole) - 1)]) + period, float(whole.time[-1]))


def _is_long_run(machine: Machine, end: float, turns: float, assessment: RotorAssessment | None = None) -> bool:
    """True if all transients have decayed long ago, and the motion has repeated many times."""
    speed = (free_speed(machine, machine.rotor) or 0.0) if assessment is None else assessment.sense * assessment.speed
    return turns >= _VERY_MANY_TURNS and end >= _DECAYS * slowest_decay(machine, speed)


def _advice(machine: Machine, end: float, assessment: RotorAssessment) -> tuple[str, float]:
    """Return the reason why there is no verdict yet, and the time of one."""
    is_known = math.isfinite(assessment.extra_run_factor)
    reason = "the motion still approaches its final state" if is_known else "the motion is still transient"
    until = max(LONGER, 1 + assessment.extra_run_factor if is_known else 0.0) * end
    speed = assessment.sense * assessment.speed
    # Before a resonance it is the vibration that decides how long a run-up takes.
    run_up = run_up_time(machine, speed) if assessment.evidence.is_beyond_resonance and runaway_limit(machine) is None else 0.0
    return reason, max(until, _RUN_UPS * run_up)


def _swinging_verdict(machine: Machine, observation: Observation, free: float | None, is_held: bool) -> Verdict:
    end, quarter = observation.end_time, observation.main.last(0.25)
    bounds, decay_factor = swing_of(machine, observation, is_held) or (None, 0.0)
    if bounds is not None:
        evidence = Evidence(turning=False, swing=bounds, is_held=is_held)
    else:
        evidence = mean_turning_evidence(machine, observation, free) or Evidence(turning=False)
    verdict = Verdict(classify(evidence), evidence, (float(quarter.time[0]) if len(quarter.time) else 0.0, end))
    if verdict.outcome is not Outcome.UNIDENTIFIED:
        return replace(verdict, settling_time=end)
    if run_factor := run_factor_until_swinging(observation) if bounds is None else decay_factor:
        needed_time = max(LONGER, run_factor) * end
    elif _is_long_run(machine, end, end / observation.main.span):
        return open_verdict(machine, verdict, "the rotor swings and turns over irregularly, and this does not visibly decay")
    else:
        needed_time = max(LONGER * end, 1e-9)
    whole = observation.main.last(1.0)
    turn_angle = float(whole.greatest_angle.max(initial=0.0) - whole.least_angle.min(initial=0.0))
    since = " since the rotor last stopped or turned back" if turn_angle >= FEWEST_TURNS * 2 * math.pi else ""
    return open_verdict(machine, verdict, f"fewer than {FEWEST_TURNS} turns were made{since}", needed_time)
