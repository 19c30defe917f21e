"""Plan -> findings: settle, ramp, settle again, find the jumps; then back."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.numerics.flow.compiled import compile_system
from wucht.studies.release_events import release_event
from wucht.studies.sweep.jumps import Jump, candidates, find_jump
from wucht.studies.sweep.moving import IntegrationError, Leg, Mover, Place, Reading, moving_system
from wucht.studies.sweep.pace import rate_unit
from wucht.studies.sweep.prepare import Plan
from wucht.studies.sweep.settling import Scale, Settled, settle
from wucht.studies.work import Work

_TOO_FAST = 0.01  # by how much the speed may change after a ramp, relative to the largest of the sweep
_TURNS_A_UNIT, _MOST_LEGS_A_UNIT = 500, 20
_SETTLED_SHARE, _RAMP_SHARE, _JUMPS_SHARE = 0.02, 0.5, 0.55  # of the time of a way: what of it is done after each part


@dataclass(frozen=True)
class Legs:
    """Some legs of a ramp, and why there are no more."""

    legs: tuple[Leg, ...] = ()
    failure: str | None = None


@dataclass(frozen=True)
class Ramp:
    """One way, as far as it was gone."""

    way: str
    legs: tuple[Leg, ...] = ()

    @property
    def readings(self) -> tuple[Reading, ...]:
        """What each leg showed."""
        return tuple(leg.reading for leg in self.legs)


@dataclass(frozen=True)
class Findings:
    """jumps: in the order in which they happen. warnings: what is doubtful. failure: why the sweep ended early.

    complete: whether all ramps were made and searched for jumps. engine: which integrated them.
    """

    engine: str
    warnings: tuple[str, ...]
    ramps: tuple[Ramp, ...] = ()
    jumps: tuple[Jump, ...] = ()
    failure: str | None = None
    complete: bool = False

    @property
    def readings(self) -> list[Reading]:
        """Of all ramps."""
        return [r for ramp in self.ramps for r in ramp.readings]

    def warned(self, *warnings: str) -> Findings:
        """With more warnings, each once."""
        return replace(self, warnings=tuple(dict.fromkeys((*self.warnings, *warnings))))

    def ramped(self, ramp: Ramp) -> Findings:
        """With the ramp that is under way."""
        before = [r for r in self.ramps if r.way != ramp.way]
        return replace(self, ramps=(*before, ramp))


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Move the machine; what was found after each part of a ramp and each search. A failure ends the sweep, with a sentence."""
    machine = plan.machine
    events = tuple(release_event(machine, b) for b in machine.bodies if b.release is not None)
    compiled = compile_system(moving_system(machine, plan.swept.path), plan.spec.tolerance, events, plan.spec.engine)
    mover = Mover.of(machine, plan.swept.path, compiled, plan.pace.fastest, _at(work, 0.0, "settling"))
    begun = findings = Findings(compiled.engine.name, plan.pace.warnings)
    yield begun
    try:
        for findings in _there_and_back(plan, mover, begun, work):
            yield findings
    except IntegrationError as error:
        yield replace(findings, failure=str(error))


def _there_and_back(plan: Plan, mover: Mover, findings: Findings, work: Work) -> Iterator[Findings]:
    place = mover.begin(plan.ends(plan.ways[0])[0], plan.initial)
    settled = work.unit("settling", partial(settle, mover, plan.pace, place, scale=Scale(plan.pace.driven)))
    findings = findings.warned(*_unsettled(plan, settled, "before the sweep"))
    for k, way in enumerate(plan.ways):
        part = work.part(way, k / len(plan.ways), (k + 1) / len(plan.ways))
        for ramp in _ramp(plan, mover, settled.leg.place, way, part):
            findings = findings.ramped(ramp)
            yield findings
        last = ramp.legs[-1]
        at_end = mover.reporting(_at(part, _RAMP_SHARE, "settling"))
        scale = Scale(plan.pace.driven).with_(findings.readings)
        settled = part.unit("settling", partial(settle, at_end, plan.pace, last.place, scale=scale))
        findings = findings.warned(
            *_unsettled(plan, settled, f"after the way {way}"),
            *_too_fast(plan, way, last.reading, settled.leg.reading, findings),
        )
        yield findings
        for jump in _jumps(plan, mover, ramp.legs, part.part("jump", _JUMPS_SHARE, 1.0)):
            findings = replace(findings, jumps=(*findings.jumps, jump))
            yield findings
    work.report(1.0)
    yield replace(findings, complete=True)


def _ramp(plan: Plan, mover: Mover, place: Place, way: str, work: Work) -> Iterator[Ramp]:
    """One ramp in equal legs, after each unit of them. place: where it begins."""
    step, samples, begun = plan.pace.step, plan.pace.samples, place.time
    turns = step * plan.pace.fastest / (2 * math.pi)
    count = max(1, min(_MOST_LEGS_A_UNIT, round(_TURNS_A_UNIT / turns)))

    def report(time: float) -> None:
        work.report(_SETTLED_SHARE + (_RAMP_SHARE - _SETTLED_SHARE) * (time - begun) / (samples * step), _name(way))

    values, ramp = np.linspace(*plan.ends(way), samples + 1)[1:], Ramp(way)
    for begin in range(0, samples, count):
        those = values[begin : begin + count].tolist()
        part = work.unit(f"legs {begin + 1} on", partial(_legs, mover.reporting(report), place, step, those))
        ramp = replace(ramp, legs=(*ramp.legs, *part.legs))
        yield ramp
        if part.failure:
            raise IntegrationError(part.failure)
        place = part.legs[-1].place


def _legs(mover: Mover, place: Place, step: float, values: Sequence[float]) -> Legs:
    """Legs to one value after the other, as far as they can be integrated."""
    legs = list[Leg]()
    for value in values:
        try:
            legs.append(mover.leg(place, step, value))
        except IntegrationError as error:
            return Legs(tuple(legs), str(error))
        place = legs[-1].place
    return Legs(tuple(legs))


def _jumps(plan: Plan, mover: Mover, legs: Sequence[Leg], work: Work) -> Iterator[Jump]:
    """The jumps of one ramp."""
    pairs = candidates(plan.machine, legs)
    for i, (first, last) in enumerate(pairs):
        searching = mover.reporting(_at(work, i / len(pairs), f"jump {i + 1} of {len(pairs)} at most"))
        search = partial(find_jump, searching, plan.pace, legs, first, last, plan.spec.jump_tolerance)
        jump = work.unit(str(i + 1), search)
        if jump is not None:
            yield jump


def _at(work: Work, share: float, what: str) -> Callable[[float], None]:
    """What a mover reports while it is not known how long it takes."""
    return lambda _: work.report(share, what)


def _unsettled(plan: Plan, settled: Settled, when: str) -> list[str]:
    """A warning where the machine did not settle."""
    if settled.steady:
        return []
    speed = f"{settled.leg.reading.speed:.5g} {plan.machine.units.speed}".strip()
    return [f"the machine did not settle {when}: its speed was still changing at {speed}"]


def _too_fast(plan: Plan, way: str, last: Reading, settled: Reading, findings: Findings) -> list[str]:
    """A warning where the machine did not follow to the end of a ramp."""
    change, scale = abs(settled.speed - last.speed), Scale().with_([settled, *findings.readings])
    if last.beating >= _TOO_FAST or change <= _TOO_FAST * scale.speed:
        return []
    speed, unit = plan.machine.units.speed, rate_unit(plan.machine, plan.swept.path)
    return [
        f"the sweep is too fast: after the way {way} the speed still changed from {last.speed:.5g} to "
        f"{f'{settled.speed:.5g} {speed}'.strip()}; give a rate below {plan.pace.rate:.3g} {unit}"
    ]


def _name(way: str) -> str:
    return "rising" if way == "up" else "falling"
