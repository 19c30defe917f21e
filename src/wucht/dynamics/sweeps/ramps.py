"""The sweep of a machine: ramps of the parameter, and after each a search for the jumps on it."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial

import numpy as np

from wucht.dynamics.sweeps.course import Ends, SweepCourse
from wucht.dynamics.sweeps.jumps import Jump, candidates, find_jump, hysteresis
from wucht.dynamics.sweeps.moving import IntegrationError, MovedMachine, Mover, Place, SweepLeg, is_too_fast
from wucht.dynamics.work import Work

_TURNS_A_UNIT, _MOST_LEGS_A_UNIT = 500, 20
_JUMPS_SHARE = 0.55  # of the time of a ramp: completed share when the search for jumps begins


Legs = tuple[SweepLeg, ...]


def ramp_courses(moved_machine: MovedMachine, ways: Mapping[str, Ends], work: Work) -> Iterator[SweepCourse]:
    """Yield the course of a sweep after each part of a ramp and each search for a jump. ways: the ends of each, in order."""
    pace, mover = moved_machine.pace, Mover(moved_machine, lambda _time: None)
    driven, ramp, longest = (pace.driven, 0.0), pace.samples * pace.step, mover.longest_settling
    ramp_share = _JUMPS_SHARE * ramp / (ramp + longest)
    first = longest / (longest + len(ways) * (ramp + longest) / _JUMPS_SHARE)  # as long as what follows, for its time
    course = SweepCourse(rate=pace.rate, span=pace.step, doubts=pace.warnings)
    yield course
    work.report(0.0, "settling")
    try:
        settling = replace(mover, report=_time_reporter(work.part("", 0.0, first).open_ended, 0.0, longest, "settling"))
        settled_leg, steady = work.unit("settling", partial(settling.settle, settling.begin(), driven))
        course = course.with_doubts(*_settling_doubts(moved_machine, settled_leg, steady, "before the sweep"))
        for k, way in enumerate(ways):
            begin, end = (first + (1 - first) * n / len(ways) for n in (k, k + 1))
            part = work.part(way, begin, end)
            for legs in _ramp(mover, settled_leg.place, ways[way], part, ramp_share):
                course = replace(course, ways={**course.ways, way: legs})
                yield course
            legs = course.ways[way]
            all_legs = [leg for of_ramp in course.ways.values() for leg in of_ramp]
            speed, amplitude = np.abs([driven, *((leg.speed, leg.amplitude) for leg in all_legs)]).max(axis=0)
            settling_part = part.part("", ramp_share, _JUMPS_SHARE).open_ended
            at_end = replace(mover, report=_time_reporter(settling_part, legs[-1].place.time, longest, "settling"))
            settled_leg, steady = part.unit("settling", partial(at_end.settle, legs[-1].place, (speed, amplitude)))
            course = course.with_doubts(
                *_settling_doubts(moved_machine, settled_leg, steady, f"after the ramp {way}", all_legs)
            )
            yield course
            for jump in _jumps(mover, legs, part.part("jump", _JUMPS_SHARE, 1.0)):
                jumps = (*course.jumps, jump)
                course = replace(course, jumps=jumps, hysteresis=hysteresis(jumps)).with_doubts(*jump.doubts)
                yield course
        work.report(1.0)
        yield replace(course, is_complete=True)
    except IntegrationError as error:
        yield replace(course, failure=str(error))


def _settling_doubts(
    moved_machine: MovedMachine, settled_leg: SweepLeg, steady: bool, occasion: str, legs: Sequence[SweepLeg] = ()
) -> Iterator[str]:
    """Yield doubts if the machine did not settle, or did not follow a ramp to its end. legs: of all ramps so far."""
    pace, speed = moved_machine.pace, f"{settled_leg.speed:.5g} {moved_machine.machine.units.speed}".strip()
    if not steady:
        yield f"the machine did not settle {occasion}: its speed was still changing at {speed}"
    if is_too_fast(settled_leg, legs):
        yield (
            f"the sweep is too fast: {occasion} the speed still changed from {legs[-1].speed:.5g} to {speed}; "
            f"give a rate below {pace.rate:.3g} {pace.rate_unit}"
        )


def _ramp(mover: Mover, place: Place, values: Ends, work: Work, share: float) -> Iterator[Legs]:
    """Run one ramp in equal legs; yield the completed legs after each unit of work. share: of the work."""
    pace = mover.moved_machine.pace
    turns = pace.step * pace.fastest / (2 * math.pi)
    count = max(1, min(_MOST_LEGS_A_UNIT, round(_TURNS_A_UNIT / turns)))
    activity = "rising" if values[1] > values[0] else "falling"
    report = _time_reporter(work.part("", 0.0, share), place.time, pace.samples * pace.step, activity)
    ramping, legs = replace(mover, report=report), Legs()
    steps = np.linspace(*values, pace.samples + 1)[1:]
    for begin in range(0, pace.samples, count):
        unit = partial(ramping.legs, place, pace.step, steps[begin : begin + count].tolist())
        more, failure = work.unit(f"legs {begin + 1} on", unit)
        legs += more
        yield legs
        if failure:
            raise IntegrationError(failure)
        place = legs[-1].place


def _jumps(mover: Mover, legs: Legs, work: Work) -> Iterator[Jump]:
    """Yield the jumps of one ramp."""
    pairs = candidates(mover, legs)
    for i, (first, last) in enumerate(pairs):
        searching = replace(mover, report=_share_reporter(work, i / len(pairs), f"jump {i + 1} of {len(pairs)} at most"))
        jump = work.unit(str(i + 1), partial(find_jump, searching, legs, first, last, mover.moved_machine.jump_tolerance))
        if jump is not None:
            yield jump


def _time_reporter(work: Work, begin: float, duration: float, activity: str) -> Callable[[float], None]:
    """Progress function of a mover from a time on, for a duration at most.

    All parts of a sweep have shares as long as they last: the pace of the first seconds of a ramp tells how long the whole will
    take.
    """
    return lambda time: work.report((time - begin) / duration, activity)


def _share_reporter(work: Work, share: float, activity: str) -> Callable[[float], None]:
    """Progress function of a mover while its duration is unknown."""
    return lambda _: work.report(share, activity)
