"""The resonance curve of a machine whose drive is moved slowly up and down: its jumps and its hysteresis."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import asdict, dataclass, field, replace
from functools import partial
from typing import TYPE_CHECKING, ClassVar, Literal

import numpy as np
from pydantic import Field

from wucht.analysis.working_points import energy_scale
from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.sweeps.jumps import JUMP_TOLERANCE, Jump, candidates, find_jump
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
from wucht.dynamics.system_states import refuse_machine_keys, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.machines.changes import release_events
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.flow.compiled_system import compile_system
from wucht.plots.parameter_steps import draw_steps
from wucht.plots.scales import name_speeds
from wucht.plots.sheet import legend_beside, new_figure
from wucht.plots.style import COLOURS, FREE, line_style
from wucht.results.formatting import ReportLines, label, parameter_in_words, printed_unit, report_lines, with_unit
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.schema import Composite, Parameter, Unit, composite, read_quantity
from wucht.studies.motion_variables import parameter_values
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL_EQUATIONS, Engine, Pair, Path, Spec, Start, Tolerance, Value, Whole
from wucht.studies.stepped_equations import SteppedFindings, SteppedPlan, compute_steps, stepped_dataset

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

SENSE = {"up": "rising", "down": "falling"}  # of the swept parameter


class Sweep(Spec):
    """Move the parameter ``along``, the swept parameter, through ``range``, so slowly that the machine follows."""

    kind: ClassVar[str] = "sweep"
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion(
            "all branches of steady operation, also those that a sweep jumps over",
            {"study.kind": "speed-curve", "study.along": "{along}", "study.range": "{range}"},
        ),
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("value", "speed"), ("value", "amplitude"))
    solves: ClassVar[str] = FULL_EQUATIONS
    from_start: ClassVar[bool] = True

    along: Path = Field(description="path of the parameter that is swept")
    range: Composite[Pair]
    rate: Value | None = Field(default=None, title="rate of the parameter", description=(
        "rate of the parameter, in its unit per unit of time; by default the range takes a thousand times as long as the "
        "response of the machine"
    ))  # fmt: skip
    direction: Literal["both", "up", "down"] = Field(
        default="both", description='direction of the sweep: `"both"` (up, then down again), `"up"` or `"down"`'
    )
    start: Composite[Start] = composite(default_factory=dict, description=(
        "initial state; the machine starts there with the parameter at its first value, and settles"
    ))  # fmt: skip
    jump_tolerance: float = Field(
        default=JUMP_TOLERANCE, ge=1e-8, le=0.1, description="relative tolerance of the values of jumps"
    )
    points: Whole = Field(
        default=101, ge=11, le=10_000, description="number of values of the parameter, of the equations of a table [system]"
    )
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None


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


def prepare(spec: Sweep, subject: Machine | UserSystem) -> Plan | SteppedPlan:
    """The plan. Raises ``InputError`` where the question does not fit the subject."""
    return _machine_plan(spec, subject) if isinstance(subject, Machine) else _system_plan(spec, subject)


def _system_plan(spec: Sweep, subject: UserSystem) -> SteppedPlan:
    refuse_machine_keys(spec, ("rate", "jump_tolerance"))
    parameter = parameter_of(subject, spec.along)
    low, high = range_of(Unit(parameter.unit, parameter.long_name), spec.range)
    ways = {way: ends for way, ends in (("up", (low, high)), ("down", (high, low))) if spec.direction in (way, "both")}
    start = states_from(subject.system, spec.start, "study.start")
    return SteppedPlan(subject, parameter.path, ways, spec.points, start, LongRunSettings(None, spec.tolerance, spec.engine))


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
    initial = initial_state(machine, spec.start)
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


def run(plan: Plan | SteppedPlan, work: Work) -> Iterator[Findings | SteppedFindings]:
    """Run the ramps; yield the findings after each part of a ramp and each search. A failure ends the sweep with a sentence."""
    if isinstance(plan, SteppedPlan):
        yield from compute_steps(plan, work)
        return
    machine = plan.moved_machine.machine
    moving, events = moving_system(machine, plan.parameter.path), release_events(machine)
    flow = compile_system(moving, plan.spec.tolerance, events, plan.spec.engine)
    driven, ways = (plan.moved_machine.pace.driven, 0.0), len(plan.ways)
    mover = Mover(plan.moved_machine, flow, _ignore_time)
    ramp, longest = plan.moved_machine.pace.samples * plan.moved_machine.pace.step, mover.longest_settling
    ramp_share = _JUMPS_SHARE * ramp / (ramp + longest)
    first = longest / (longest + ways * (ramp + longest) / _JUMPS_SHARE)  # as long as what follows, for its time
    findings = Findings(flow.engine.name, plan.moved_machine.pace.warnings)
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


_FREE_SPEEDS = 21


def dataset(plan: Plan | SteppedPlan, findings: Findings | SteppedFindings) -> xr.Dataset:
    """Build the Dataset of a sweep."""
    if isinstance(findings, SteppedFindings):
        return stepped_dataset(findings)
    assert isinstance(plan, Plan)
    pace, parameter = plan.moved_machine.pace, plan.parameter
    quantities = [*_jump_quantities(plan, findings), *_question_quantities(plan), *_ramp_quantities(plan, findings)]
    more = {"along": parameter.path, "along_unit": parameter.unit, "rate": pace.rate, "engine": findings.engine}
    return result_dataset(quantities, _sentence(plan, findings), _warnings(findings), (), findings.failure, **more)


def _jump_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """The jumps, in the summary with the value of the parameter under its path."""
    parameter, jumps, speed, length = (
        plan.parameter,
        findings.jumps,
        plan.moved_machine.machine.units.speed,
        plan.moved_machine.machine.orbit_unit,
    )
    parts = {
        parameter.path: (parameter.full_name, parameter.unit),
        "from_speed": ("speed before the jump", speed),
        "to_speed": ("speed after the jump", speed),
        "direction": ("direction in which the parameter moves", ""),
        "from_amplitude": ("amplitude before the jump", length),
        "to_amplitude": ("amplitude after the jump", length),
        "fold": ("whether the branch ends in a fold there", ""),
        "only_seen": ("whether it is known from the ramp only", ""),
        "bracket": ("values between which the branch ends", parameter.unit),
    }
    rows = [{parameter.path if key == "value" else key: x for key, x in asdict(j).items()} for j in jumps]
    columns = {"value": parameter.path, "from": "from_speed", "to": "to_speed"} | {
        n: n for n in ("from_amplitude", "to_amplitude")
    }
    return [
        *table("jumps", rows, "jumps, in the order in which they occur", parts),
        *(Quantity(f"jump_{n}", [row[part] for row in rows], *parts[part], "jump") for n, part in columns.items()),
        Quantity("jump_upward", [int(j.direction == "up") for j in jumps], "1 where the parameter rises", "", "jump"),
    ]


def _question_quantities(plan: Plan) -> list[Quantity]:
    """The swept parameter, its rate, and the speed of the drive without vibration."""
    machine, parameter, pace = plan.moved_machine.machine, plan.parameter, plan.moved_machine.pace
    grid = np.linspace(plan.low, plan.high, _FREE_SPEEDS)
    free = [free_speed(machine.with_unchecked_values({parameter.path: float(v)}), machine.rotor) for v in grid]
    return [
        Quantity("along", parameter.path, "swept parameter"),
        Quantity("along_unit", parameter.unit, "unit of the swept parameter"),
        Quantity("range", [plan.low, plan.high], "lowest and highest value of the parameter", parameter.unit),
        Quantity("rate", pace.rate, "rate of the parameter", pace.rate_unit),
        Quantity("rate_unit", pace.rate_unit, "unit of the rate"),
        Quantity("rate_chosen", plan.spec.rate is None, "whether the rate is the program's choice"),
        Quantity("jump_tolerance", plan.spec.jump_tolerance, "relative tolerance of the values of jumps"),
        Quantity("grid", grid, parameter.full_name, parameter.unit, "grid"),
        Quantity("free_speed", np.array(free, float), "speed reached without vibration", machine.units.speed, "grid"),
        *parameter_values(machine),
    ]


def _ramp_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """Readings of the ramps, NaN where one ended early."""
    parameter, speed, length, legs = (
        plan.parameter,
        plan.moved_machine.machine.units.speed,
        plan.moved_machine.machine.orbit_unit,
        findings.all_legs,
    )
    peak, residual = (max((getattr(leg, n) for leg in legs), default=None) for n in ("amplitude", "energy_residual"))
    ends = {way: {"from_speed": r[0].speed, "to_speed": r[-1].speed} for way, r in findings.ramps.items() if r}
    parts = {"from_speed": ("speed at its start", speed), "to_speed": ("speed at its end", speed)}
    readings = {
        "value": ("value", parameter.full_name, parameter.unit),
        "speed": ("speed", "mean speed", speed),
        "min_speed": ("low", "least speed, mean over a turn", speed),
        "max_speed": ("high", "largest speed, mean over a turn", speed),
        "amplitude": ("amplitude", "amplitude of the axis", length),
        "energy_residual": ("energy_residual", "energy residual, relative", ""),
    }
    return [
        Quantity("direction", list(findings.ramps) or np.empty(0, "U4"), "direction of the sweep", "", "direction"),
        *(
            Quantity(n, _table(plan, findings, of), long_name, u, "direction sample", coordinate=n == "value")
            for n, (of, long_name, u) in readings.items()
        ),
        Quantity("hysteresis", hysteresis(findings.jumps), "range in which the state depends on the direction", parameter.unit),
        Quantity("peak_amplitude", peak, "largest amplitude of the axis", length, headline=True),
        Quantity("energy_residual", residual, "largest relative error of the energy balance"),
        Quantity("ends", ends, "speeds at the ends of each ramp", parts=parts),
    ]


def _table(plan: Plan, findings: Findings, key: str) -> np.ndarray:
    rows = [[getattr(leg, key) for leg in legs] for legs in findings.ramps.values()]
    samples = plan.moved_machine.pace.samples
    return np.array([row + [math.nan] * (samples - len(row)) for row in rows]).reshape(len(rows), samples)


def hysteresis(jumps: Sequence[Jump]) -> list[float] | None:
    """Range of values in which the state depends on the direction of the sweep; None if there is none."""
    up, down = ([j.value for j in jumps if j.direction == way] for way in ("up", "down"))
    return [min(down), max(up)] if up and down and min(down) < max(up) else None


def _warnings(findings: Findings) -> list[str]:
    doubtful_jumps = [
        f"the jump near {j.value:.5g} is only known to lie between {j.bracket[0]:.6g} and {j.bracket[1]:.6g}: with the "
        "parameter held before it, the machine does not remain in the state of the sweep; a lower rate shows where it settles"
        for j in findings.jumps
        if j.only_seen
    ]
    end = findings.failure or ("" if findings.complete else "the sweep is not finished: jumps may be missing")
    return [*findings.warnings, *doubtful_jumps, *([end] if end else [])]


def _sentence(plan: Plan, findings: Findings) -> str:
    path = plan.parameter.sentence_name
    if findings.failure:
        return "the sweep failed"
    if not findings.complete:
        return "the sweep was interrupted"
    if not findings.jumps:
        return f"no jump: the machine follows {path} between {plan.low:.5g} and {plan.high:.5g}"
    jumps = []
    for j in findings.jumps:
        change = f"speed jumps from {j.from_speed:.5g} to {j.to_speed:.5g}"
        if math.isclose(j.from_speed, j.to_speed, rel_tol=1e-4):
            change = f"amplitude jumps from {j.from_amplitude:.4g} to {j.to_amplitude:.4g}"
        jumps.append(f"at {plan.parameter.value_text(j.value)} {SENSE[j.direction]} the {change}")
    return "; ".join(jumps)


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a sweep."""
    if "maxima" in result:
        return _lines_of_steps(result)
    s, lines = result.wucht.summary, ReportLines(result)
    jumps, (low, high), unit = s["jumps"], s["range"], f" {s['along_unit']}" if s["along_unit"] else ""
    chosen = " (chosen so that the machine follows)" if s["rate_chosen"] else ""
    lines.add("sweep", f"{{along}} from {low:.5g} to {high:.5g}{unit} at {{rate:.3g}}{chosen}")
    for way, ends in s["ends"].items():
        lines.add(way, "{from_speed} to {to_speed}", ends, "ends")
    for jump in jumps:
        lines.add("jump", f"{SENSE[jump['direction']]}, at {s['along']} = {jump[s['along']]:.6g}{unit}:")
        lines.add("", "speed {from_speed} to {to_speed}", jump, "jumps")
        lines.add("", "amplitude {from_amplitude} to {to_amplitude}", jump, "jumps")
    if s["hysteresis"]:
        between = "{:.6g} and {:.6g}".format(*s["hysteresis"])
        lines.add("hysteresis", f"between {between}{unit} the state depends on the direction of the sweep")
    if jumps:
        lines.add("accuracy", "{jump_tolerance:.0e} of these values, obtained with {along} held: independent of the rate")
    lines.add("energy", "balance closed to {energy_residual:.1e}")
    count = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(jumps), f"{len(jumps)} JUMPS")
    return lines.report(s["sentence"].upper() if s["sentence"].startswith("the sweep") else count)


def _lines_of_steps(result: xr.Dataset) -> list[str]:
    """The lines for a sweep of equations."""
    s = result.wucht.summary
    lines = [("sweep", f"{s['along']} in steps, a time of {s['span']:.4g} at each")]
    lines += [
        ("jump", f"{j['direction']}, at {s['along']} = {j['value']:.6g}: {j['state']} {j['from']:.5g} to {j['to']:.5g}")
        for j in s["jumps"]
    ]
    count = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(s["jumps"]), f"{len(s['jumps'])} JUMPS")
    return report_lines(result, count if not s["hysteresis"] else f"{count}, {s['sentence'].rpartition('; ')[2]}", lines)


def figure(result: xr.Dataset) -> Figure:
    """Draw two panels from a sweep's Dataset alone."""
    if "maxima" in result:
        return draw_steps(result)
    fig, (speed, amplitude) = new_figure(2, result.attrs["title"], _subtitle(result), 2.4)
    scale, unit = printed_unit(result, "amplitude")
    for i, way in enumerate(str(d) for d in result.direction.values):
        ramp = result.sel(direction=way)
        style = line_style(i) | {"linewidth": 1.4, "label": SENSE[way], "zorder": 3 - 0.1 * i}
        speed.plot(ramp.value, ramp.speed, **style)
        amplitude.plot(ramp.value, scale * ramp.amplitude, **style)
        speed.fill_between(ramp.value, ramp.min_speed, ramp.max_speed, color=style["color"], alpha=0.25, linewidth=0)
    _draw_jumps(speed, result, result.jump_from.values, result.jump_to.values)
    _draw_jumps(amplitude, result, scale * result.jump_from_amplitude.values, scale * result.jump_to_amplitude.values)
    low, high = speed.get_ylim()
    if np.isfinite(result.free_speed).any():
        speed.plot(result.grid, result.free_speed, label="no-load speed", zorder=1, **FREE)
        speed.set_ylim(low, max(high, min(high * 1.1, float(np.nanmax(result.free_speed)))))
    name_speeds(speed, result)
    amplitude.set(ylabel=label(result, "amplitude", unit), ylim=(0, None))
    amplitude.set_xlim(float(result.grid[0]), float(result.grid[-1]))
    amplitude.set_xlabel(with_unit(_parameter_words(result), result.attrs["along_unit"]))
    for axis in (speed, amplitude):
        legend_beside(axis)
    return fig


def _subtitle(result: xr.Dataset) -> str:
    """Values of the jumps; without jumps the answer in words."""
    jumps, along, unit = result.wucht.summary["jumps"], result.attrs["along"], result.attrs["along_unit"]
    if not jumps or not result.attrs["finished"]:
        return str(result.attrs["sentence"])
    values = [f"{f'{j[along]:.6g} {unit}'.rstrip()} ({SENSE[j['direction']]})" for j in jumps]
    return f"it jumps at {_parameter_words(result)} = {' and '.join(values[:2])}" + (", ..." if len(values) > 2 else "")


def _parameter_words(result: xr.Dataset) -> str:
    return parameter_in_words(result.attrs["along"], str(result.grid.attrs["long_name"]))


def _draw_jumps(axis: Axes, result: xr.Dataset, before: np.ndarray, after: np.ndarray) -> None:
    """Draw an arrow from the end of each branch to the state after the jump."""
    for k, at in enumerate(result.jump_value.values):
        colour = COLOURS[0] if result.jump_upward.values[k] else COLOURS[1]
        axis.plot([at], [before[k]], "o", color=colour, markersize=5, zorder=5, label="end of a branch" if k == 0 else None)
        arrow = {"arrowstyle": "-|>", "color": colour, "linewidth": 1.0, "shrinkA": 3, "shrinkB": 0}
        axis.annotate("", xy=(at, after[k]), xytext=(at, before[k]), zorder=5, arrowprops=arrow)
