"""Question and machine -> plan -> findings: how a parameter is led through its values, and what the machine does."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.analysis.working_points import energy_scale
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.initial_state import initial_state, placed
from wucht.dynamics.sweeps.jumps import Jump, candidates, find_jump
from wucht.dynamics.sweeps.moving import IntegrationError, Leg, MovedMachine, Mover, Place, moving_system
from wucht.dynamics.sweeps.pace import pace_of, rate_unit
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.changes import release_events
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import compile_system
from wucht.schema import Parameter, Unit, read_quantity
from wucht.studies.sweep.spec import SENSE, Sweep


@dataclass(frozen=True)
class Plan:
    """What is to be done. moved: the machine with the swept parameter at its first value.

    low, high: values of the swept parameter. ways: from which to which value it goes ``"up"`` or ``"down"``, in their order.
    """

    spec: Sweep
    moved: MovedMachine
    swept: Parameter
    low: float
    high: float
    ways: dict[str, tuple[float, float]]


def prepare(spec: Sweep, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    swept = parameter_of(machine, spec.along)
    low, high = range_of(Unit(swept.unit, swept.what), spec.range)
    rate = _rate(spec, machine, swept)
    if machine.schedules:
        raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
    if machine.shaking is not None and swept.path == machine.shaking[1].name:
        raise InputError("study.along", swept.path, "not allowed: the phase of the motion would run away")
    if swept.path in {f"{b.name}.{key}" for b in machine.bodies for key in ("locked", "release.time", "release.speed")}:
        raise InputError("study.along", swept.path, "not allowed: it says when a body is released")
    for i, value in enumerate((low, high)):
        check_values(machine.parts, {swept.path: value}, f"study.range[{i}]", machine.values)
    ways = {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if spec.direction in (way, "both")}
    machine = machine.with_unchecked({swept.path: next(iter(ways.values()))[0]})
    initial = initial_state(machine, spec.start)
    machine = placed(machine, initial)
    moved = MovedMachine(machine, initial, swept.path, pace_of(machine, swept.path, low, high, rate), energy_scale(machine))
    return Plan(spec, moved, swept, low, high, ways)


def _rate(spec: Sweep, machine: Machine, swept: Parameter) -> float | None:
    """The rate of the parameter, None if it is not given. Raises ``InputError``."""
    if spec.rate is None:
        return None
    time, what = machine.units.time, f"rate of the {swept.what}"
    rate = read_quantity(Unit(f"{swept.unit or '1'}/{time}" if time else swept.unit, what), spec.rate, "study.rate")
    if rate <= 0:
        unit = f", in {rate_unit(machine, swept.path)}" if time else ""
        raise InputError("study.rate", spec.rate, f"must be a {what} greater than 0{unit}")
    return rate


_TOO_FAST = 0.01  # by how much the speed may change after a ramp, relative to the largest of the sweep
_TURNS_A_UNIT, _MOST_LEGS_A_UNIT = 500, 20
_SETTLED_SHARE, _RAMP_SHARE, _JUMPS_SHARE = 0.02, 0.5, 0.55  # of the time of a way: what of it is done after each part


@dataclass(frozen=True)
class Findings:
    """ramps: the legs of each way, as far as it was gone. jumps: in the order in which they happen. warnings: what is doubtful.

    failure: why the sweep ended early. complete: whether all ramps were made and searched for jumps. engine: of integration.
    """

    engine: str
    warnings: tuple[str, ...]
    ramps: dict[str, tuple[Leg, ...]] = field(default_factory=dict)
    jumps: tuple[Jump, ...] = ()
    failure: str | None = None
    complete: bool = False

    @property
    def all_legs(self) -> list[Leg]:
        """Of all ramps."""
        return [leg for legs in self.ramps.values() for leg in legs]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Move the machine; what was found after each part of a ramp and each search. A failure ends the sweep, with a sentence."""
    machine = plan.moved.machine
    moving, events = moving_system(machine, plan.swept.path), release_events(machine)
    compiled = compile_system(moving, plan.spec.tolerance, events, plan.spec.engine)
    mover = Mover(plan.moved, compiled, _at(work, 0.0, "settling"))
    driven, ways = (plan.moved.pace.driven, 0.0), len(plan.ways)
    findings = Findings(compiled.engine.name, plan.moved.pace.warnings)
    yield findings
    try:
        settled, steady = work.unit("settling", partial(mover.settle, mover.begin(), driven))
        findings = replace(findings, warnings=findings.warnings + _doubts(plan, settled, steady, "before the sweep"))
        for k, way in enumerate(plan.ways):
            part = work.part(way, k / ways, (k + 1) / ways)
            for legs in _ramp(plan, mover, settled.place, way, part):
                findings = replace(findings, ramps=findings.ramps | {way: legs})
                yield findings
            speed, amplitude = np.abs([driven, *((leg.speed, leg.amplitude) for leg in findings.all_legs)]).max(axis=0)
            at_end = replace(mover, report=_at(part, _RAMP_SHARE, "settling"))
            settled, steady = part.unit("settling", partial(at_end.settle, legs[-1].place, (speed, amplitude)))
            doubts = _doubts(plan, settled, steady, f"after the way {way}", findings.all_legs)
            findings = replace(findings, warnings=findings.warnings + doubts)
            yield findings
            for jump in _jumps(mover, legs, plan.spec.jump_tolerance, part.part("jump", _JUMPS_SHARE, 1.0)):
                findings = replace(findings, jumps=(*findings.jumps, jump))
                yield findings
        work.report(1.0)
        yield replace(findings, complete=True)
    except IntegrationError as error:
        yield replace(findings, failure=str(error))


def _ramp(plan: Plan, mover: Mover, place: Place, way: str, work: Work) -> Iterator[tuple[Leg, ...]]:
    """One ramp in equal legs: those made so far after each unit of them. place: where it begins."""
    step, samples, begun = plan.moved.pace.step, plan.moved.pace.samples, place.time
    turns = step * plan.moved.pace.fastest / (2 * math.pi)
    count = max(1, min(_MOST_LEGS_A_UNIT, round(_TURNS_A_UNIT / turns)))

    def report(time: float) -> None:
        work.report(_SETTLED_SHARE + (_RAMP_SHARE - _SETTLED_SHARE) * (time - begun) / (samples * step), SENSE[way])

    ramping, legs = replace(mover, report=report), tuple[Leg, ...]()
    values = np.linspace(*plan.ways[way], samples + 1)[1:]
    for begin in range(0, samples, count):
        unit = partial(_legs, ramping, place, step, values[begin : begin + count].tolist())
        more, failure = work.unit(f"legs {begin + 1} on", unit)
        legs += more
        yield legs
        if failure:
            raise IntegrationError(failure)
        place = legs[-1].place


def _legs(mover: Mover, place: Place, step: float, values: Sequence[float]) -> tuple[tuple[Leg, ...], str | None]:
    """Legs to one value after the other, as far as they can be integrated, and why there are no more."""
    legs = list[Leg]()
    for value in values:
        try:
            legs.append(mover.leg(place, step, value))
        except IntegrationError as error:
            return tuple(legs), str(error)
        place = legs[-1].place
    return tuple(legs), None


def _jumps(mover: Mover, legs: Sequence[Leg], tolerance: float, work: Work) -> Iterator[Jump]:
    """The jumps of one ramp."""
    pairs = candidates(mover, legs)
    for i, (first, last) in enumerate(pairs):
        searching = replace(mover, report=_at(work, i / len(pairs), f"jump {i + 1} of {len(pairs)} at most"))
        jump = work.unit(str(i + 1), partial(find_jump, searching, legs, first, last, tolerance))
        if jump is not None:
            yield jump


def _at(work: Work, share: float, what: str) -> Callable[[float], None]:
    """What a mover reports while it is not known how long it takes."""
    return lambda _: work.report(share, what)


def _doubts(plan: Plan, settled: Leg, steady: bool, when: str, legs: Sequence[Leg] = ()) -> tuple[str, ...]:
    """Warnings where the machine did not settle, or did not follow to the end of a ramp. legs: of all ramps so far."""
    doubts, speed = list[str](), f"{settled.speed:.5g} {plan.moved.machine.units.speed}".strip()
    if not steady:
        doubts.append(f"the machine did not settle {when}: its speed was still changing at {speed}")
    largest = max(abs(leg.speed) for leg in (settled, *legs))
    if legs and legs[-1].modulation < _TOO_FAST and abs(settled.speed - legs[-1].speed) > _TOO_FAST * largest:
        doubts.append(
            f"the sweep is too fast: {when} the speed still changed from {legs[-1].speed:.5g} to {speed}; "
            f"give a rate below {plan.moved.pace.rate:.3g} {plan.moved.pace.rate_unit}"
        )
    return tuple(doubts)
