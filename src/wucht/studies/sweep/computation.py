"""Question and subject -> plan -> findings: ramps of the parameter, and a search for the jumps of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.analysis.working_points import energy_scale
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.sweeps.jumps import Jump, candidates, find_jump
from wucht.dynamics.sweeps.moving import (
    IntegrationError,
    MovedMachine,
    Mover,
    Place,
    SweepLeg,
    moving_system,
    rate_unit,
    sweep_pace,
)
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.machines.changes import release_events
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.schema import Parameter, Unit, read_quantity
from wucht.studies.sweep.spec import Sweep
from wucht.studies.sweep.system_sweep import SystemSweepFindings, SystemSweepPlan, compute_system_sweep, system_sweep_plan

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter


@dataclass(frozen=True)
class Plan:
    """Plan of a sweep. moved_machine: with the swept parameter at its first value.

    low, high: range of the swept parameter. ways: first and last value of the ramps ``"up"`` and ``"down"``, in their order.
    """

    spec: Sweep
    moved_machine: MovedMachine
    parameter: Parameter
    low: float
    high: float
    ways: dict[str, tuple[float, float]]


def prepare(spec: Sweep, subject: Machine | UserSystem) -> Plan | SystemSweepPlan:
    """The plan. Raises ``InputError`` where the question does not fit the subject."""
    return _machine_plan(spec, subject) if isinstance(subject, Machine) else system_sweep_plan(spec, subject)


def _machine_plan(spec: Sweep, machine: Machine) -> Plan:
    parameter = parameter_of(machine, spec.along)
    low, high = range_of(Unit(parameter.unit, parameter.long_name), spec.range)
    rate = _rate(spec, machine, parameter)
    if machine.schedules:
        raise InputError("machine.schedules", None, "not allowed in a sweep: the machine would change by itself")
    if machine.shaking is not None and parameter.path == machine.shaking[1].name:
        raise InputError("study.along", parameter.path, "not allowed: the phase of the motion would run away")
    if parameter.path in {f"{b.name}.{key}" for b in machine.bodies for key in ("locked", "release.time", "release.speed")}:
        raise InputError("study.along", parameter.path, "not allowed: it says when a body is released")
    for i, value in enumerate((low, high)):
        check_values(machine.parts, {parameter.path: value}, f"study.range[{i}]", machine.values)
    ways = {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if spec.direction in (way, "both")}
    machine = machine.with_unchecked_values({parameter.path: next(iter(ways.values()))[0]})
    initial = initial_state(machine, with_default_start(machine, spec.start))
    machine = machine_in_state(machine, initial)
    moved_machine = MovedMachine(
        machine, initial, parameter.path, sweep_pace(machine, parameter.path, low, high, rate), energy_scale(machine)
    )
    return Plan(spec, moved_machine, parameter, low, high, ways)


def _rate(spec: Sweep, machine: Machine, parameter: Parameter) -> float | None:
    """The rate of the parameter, None if it is not given. Raises ``InputError``."""
    if spec.rate is None:
        return None
    time, long_name = machine.units.time, f"rate of the {parameter.long_name}"
    rate = read_quantity(
        Unit(f"{parameter.unit or '1'}/{time}" if time else parameter.unit, long_name), spec.rate, "study.rate"
    )
    if rate <= 0:
        unit = f", in {rate_unit(machine, parameter.path)}" if time else ""
        raise InputError("study.rate", spec.rate, f"must be a {long_name} greater than 0{unit}")
    return rate


_TOO_FAST = 0.01  # greatest change of the speed after a ramp, relative to the largest speed of the sweep
_TURNS_A_UNIT, _MOST_LEGS_A_UNIT = 500, 20
_JUMPS_SHARE = 0.55  # of the time of a ramp: completed share when the search for jumps begins


@dataclass(frozen=True)
class Findings:
    """Findings so far. ramps: completed legs of each ramp. jumps: in the order in which they occur. warnings: doubts.

    failure: why the sweep ended early. complete: true if all ramps were made and searched for jumps. engine: of integration.
    """

    engine: str
    warnings: tuple[str, ...]
    ramps: dict[str, tuple[SweepLeg, ...]] = field(default_factory=dict)
    jumps: tuple[Jump, ...] = ()
    failure: str | None = None
    complete: bool = False

    @property
    def all_legs(self) -> list[SweepLeg]:
        """Legs of all ramps."""
        return [leg for legs in self.ramps.values() for leg in legs]


def run(plan: Plan | SystemSweepPlan, work: Work) -> Iterator[Findings | SystemSweepFindings]:
    """Run the ramps; yield the findings after each part of a ramp and each search. A failure ends the sweep with a sentence."""
    if isinstance(plan, SystemSweepPlan):
        yield from compute_system_sweep(plan, work)
        return
    machine = plan.moved_machine.machine
    moving, events = moving_system(machine, plan.parameter.path), release_events(machine)
    flow = compile_system(moving, plan.spec.tolerance, events, plan.spec.engine)
    driven, ways = (plan.moved_machine.pace.driven, 0.0), len(plan.ways)
    mover = Mover(plan.moved_machine, flow, _ignore_time)
    ramp, longest = plan.moved_machine.pace.samples * plan.moved_machine.pace.step, mover.longest_settling
    ramp_share = _JUMPS_SHARE * ramp / (ramp + longest)
    first = longest / (longest + ways * (ramp + longest) / _JUMPS_SHARE)  # as long as what follows, for its time
    findings = Findings(flow.engine_name, plan.moved_machine.pace.warnings)
    yield findings
    work.report(0.0, "settling")
    try:
        settling = replace(mover, report=_time_reporter(work.part("", 0.0, first).open_ended, 0.0, longest, "settling"))
        settled_leg, steady = work.unit("settling", partial(settling.settle, settling.begin(), driven))
        findings = replace(findings, warnings=findings.warnings + _doubts(plan, settled_leg, steady, "before the sweep"))
        for k, way in enumerate(plan.ways):
            begin, end = (first + (1 - first) * n / ways for n in (k, k + 1))
            part = work.part(way, begin, end)
            for legs in _ramp(plan, mover, settled_leg.place, way, part, ramp_share):
                findings = replace(findings, ramps=findings.ramps | {way: legs})
                yield findings
            speed, amplitude = np.abs([driven, *((leg.speed, leg.amplitude) for leg in findings.all_legs)]).max(axis=0)
            settling_part = part.part("", ramp_share, _JUMPS_SHARE).open_ended
            at_end = replace(mover, report=_time_reporter(settling_part, legs[-1].place.time, longest, "settling"))
            settled_leg, steady = part.unit("settling", partial(at_end.settle, legs[-1].place, (speed, amplitude)))
            doubts = _doubts(plan, settled_leg, steady, f"after the ramp {way}", findings.all_legs)
            findings = replace(findings, warnings=findings.warnings + doubts)
            yield findings
            for jump in _jumps(mover, legs, plan.spec.jump_tolerance, part.part("jump", _JUMPS_SHARE, 1.0)):
                findings = replace(findings, jumps=(*findings.jumps, jump))
                yield findings
        work.report(1.0)
        yield replace(findings, complete=True)
    except IntegrationError as error:
        yield replace(findings, failure=str(error))


def _ramp(plan: Plan, mover: Mover, place: Place, way: str, work: Work, share: float) -> Iterator[tuple[SweepLeg, ...]]:
    """Run one ramp in equal legs; yield the completed legs after each unit of work. place: its start. share: of the work."""
    step, samples = plan.moved_machine.pace.step, plan.moved_machine.pace.samples
    turns = step * plan.moved_machine.pace.fastest / (2 * math.pi)
    count = max(1, min(_MOST_LEGS_A_UNIT, round(_TURNS_A_UNIT / turns)))

    report = _time_reporter(work.part("", 0.0, share), place.time, samples * step, SENSE[way])
    ramping, legs = replace(mover, report=report), tuple[SweepLeg, ...]()
    values = np.linspace(*plan.ways[way], samples + 1)[1:]
    for begin in range(0, samples, count):
        unit = partial(_legs, ramping, place, step, values[begin : begin + count].tolist())
        more, failure = work.unit(f"legs {begin + 1} on", unit)
        legs += more
        yield legs
        if failure:
            raise IntegrationError(failure)
        place = legs[-1].place


def _legs(mover: Mover, place: Place, step: float, values: Sequence[float]) -> tuple[tuple[SweepLeg, ...], str | None]:
    """Integrate legs to one value after the other, as far as possible; return them with the failure, if any."""
    legs = list[SweepLeg]()
    for value in values:
        try:
            legs.append(mover.leg(place, step, value))
        except IntegrationError as error:
            return tuple(legs), str(error)
        place = legs[-1].place
    return tuple(legs), None


def _jumps(mover: Mover, legs: Sequence[SweepLeg], tolerance: float, work: Work) -> Iterator[Jump]:
    """Yield the jumps of one ramp."""
    pairs = candidates(mover, legs)
    for i, (first, last) in enumerate(pairs):
        searching = replace(mover, report=_share_reporter(work, i / len(pairs), f"jump {i + 1} of {len(pairs)} at most"))
        jump = work.unit(str(i + 1), partial(find_jump, searching, legs, first, last, tolerance))
        if jump is not None:
            yield jump


def _time_reporter(work: Work, begin: float, duration: float, activity: str) -> Callable[[float], None]:
    """Progress function of a mover from a time on, for a duration at most.

    All parts of a sweep have shares as long as they last: the pace of the first seconds of a ramp tells how long the whole will
    take.
    """
    return lambda time: work.report((time - begin) / duration, activity)


def _ignore_time(_time: float) -> None:
    """Ignore the progress of a mover."""


def _share_reporter(work: Work, share: float, activity: str) -> Callable[[float], None]:
    """Progress function of a mover while its duration is unknown."""
    return lambda _: work.report(share, activity)


def _doubts(plan: Plan, settled_leg: SweepLeg, steady: bool, occasion: str, legs: Sequence[SweepLeg] = ()) -> tuple[str, ...]:
    """Warnings if the machine did not settle, or did not follow a ramp to its end. legs: of all ramps so far."""
    doubts, speed = list[str](), f"{settled_leg.speed:.5g} {plan.moved_machine.machine.units.speed}".strip()
    if not steady:
        doubts.append(f"the machine did not settle {occasion}: its speed was still changing at {speed}")
    largest = max(abs(leg.speed) for leg in (settled_leg, *legs))
    if legs and legs[-1].modulation < _TOO_FAST and abs(settled_leg.speed - legs[-1].speed) > _TOO_FAST * largest:
        doubts.append(
            f"the sweep is too fast: {occasion} the speed still changed from {legs[-1].speed:.5g} to {speed}; "
            f"give a rate below {plan.moved_machine.pace.rate:.3g} {plan.moved_machine.pace.rate_unit}"
        )
    return tuple(doubts)
