"""Balance of the torques of drive, load and vibration: 002 (3.51), figure 3.2b."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import asdict, dataclass, replace
from functools import partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
from pydantic import Field

from wucht.analysis.working_points import TorqueCurves
from wucht.dynamics.run_ups.operating_points import OperatingPoints, shaft_speed_range, speeds_in_sense
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, is_driven, operating_speed, sense_of
from wucht.plots.sheet import new_figure
from wucht.plots.stability_lines import draw_by_stability, draw_classes, draw_configurations
from wucht.plots.style import COLOURS, GREY, mark_speeds
from wucht.results.formatting import ReportLines, with_unit
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.results.starting_text import add_starting_line
from wucht.schema import SI, Composite, composite, si
from wucht.studies.from_rest_variables import FROM_REST_WORDS, from_rest_quantities
from wucht.studies.motion_variables import natural_vibrations
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import BalancingBodies, Interval, Spec, Start, Whole
from wucht.studies.starting_variables import not_started_statement, starting_quantities

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class TorqueBalance(Spec):
    """The drive's characteristic, the load line and the vibration torque over the speed, and the working points."""

    kind: ClassVar[str] = "torque-balance"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("how it vibrates over the speed", {"study.kind": "response"}),
        NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),
    )
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("speed", "drive_torque"), ("speed", "surplus_torque"))
    solves: ClassVar[str] = "steady vibration of a linear carrier, in closed form"

    range: SI[Interval | None] = si("rad/s", "speed", default=None, help=(
        "lowest and highest speed, signed; by default from 0 to 1.2 times the speed that the drive reaches without vibration; "
        "if it reaches none, or one beyond 20 times the highest natural frequency (and 3000 rad/s), to 3 times that "
        "frequency, and to 1.2 times the fastest working point up to there"
    ))  # fmt: skip
    on: str | None = Field(default=None, title="rotor", description=(
        "name of the rotor whose shaft is balanced, by default the main one; other rotors turn with it at the same speed"
    ))  # fmt: skip
    points: Whole = Field(default=1200, ge=2, le=100_000, description=(
        "number of speeds, evenly spaced over the range; more are added to resolve resonances and breakdown"
    ))  # fmt: skip
    bodies: BalancingBodies = None
    start: Composite[Start] = composite(default_factory=dict, description=(
        "phases of bodies that are held; of several rotors in steady phases, those that select the nearest stable configuration"
    ))  # fmt: skip

    def turning(self) -> str:
        """See ``Spec``."""
        return "all bodies turn at one speed; the drive as its characteristic says"


@dataclass(frozen=True)
class Plan:
    """Plan of a torque balance. curves: torques on the shaft over its speed, for each branch of ``steady`` or the held bodies.

    search_range: lowest and highest speed in the search for working points of bodies in steady phases, in the main rotor's
    sense. machine: with its schedules, as it starts.
    """

    steady: SteadyPhases
    curves: tuple[TorqueCurves, ...]
    search_range: tuple[float, float]
    machine: Machine


def prepare(spec: TorqueBalance, machine: Machine, watch: Callable[[], None] | None = None) -> Plan:
    """The plan. Raises ``InputError`` where the start does not fit the machine, or the shaft has no drive with a torque.

    watch: called often during the search for the configurations of several rotors.
    """
    by_name = {r.name: r for r in machine.rotors}
    if spec.on is not None and spec.on not in by_name:
        raise InputError("study.on", spec.on, f"must be a rotor: {', '.join(by_name)}")
    rotor = machine.rotor if spec.on is None else by_name[spec.on]
    steady = SteadyPhases.of(machine, spec.start, spec.bodies, watch)
    if rotor.coordinate.prescribed_velocity is not None:
        reason = f"the drive gives {rotor.name!r} its speed, whatever torque that takes: there is no torque balance"
        advice = "study.kind = 'response' computes the required torque"
        raise InputError("machine.drive", None, f"{reason}; {advice}", code="prescribed")
    driven_bodies = {b.name for b in machine.group(rotor)}
    if not machine.dimensionless and not any(d.on in driven_bodies for d in machine.drives):
        raise InputError(
            "machine.drive", None, f"nothing drives {rotor.name!r}: there is no torque to balance", code="no-drive"
        )
    fastest = max(operating_speed(steady.machine), *map(abs, spec.range or (0.0, 0.0)))
    if not is_driven(steady.machine, rotor, fastest):
        reason = f"nothing drives {rotor.name!r}: its drives give no torque at standstill and no power at any speed"
        raise InputError("machine.drive", None, f"{reason}, so that there is no torque to balance", code="no-drive")
    speeds = spec.range or shaft_speed_range(steady, rotor)
    curves = tuple(TorqueCurves(steady.machine, rotor, vibration, speeds, spec.points) for vibration in steady.curves)
    return Plan(steady, curves, speeds_in_sense(steady, rotor, speeds) if steady.torques is not None else speeds, machine)


@dataclass(frozen=True)
class Findings:
    """The working points, and the ends of run-ups from rest: None before it, and where no state can be reached."""

    operating: OperatingPoints
    from_rest: FromRest | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the working points, and then with the state that is reached from rest."""
    watch = partial(work.report, 0.0, "working points")
    watch()
    findings = Findings(work.unit("search", partial(OperatingPoints.of, plan.steady, plan.curves, plan.search_range, watch)))
    yield findings
    if (states := findings.operating.stable_states(plan.machine)) and plan.steady.is_free:
        yield replace(findings, from_rest=FromRest.of(plan.machine, plan.curves[0].rotor.name, states, work))


def _answers(plan: Plan, findings: Findings) -> list[bool | None]:
    """Return for each working point whether it is reached from rest: only stable ones can be."""
    operating, end = findings.operating, findings.from_rest
    if end is None:
        return [None] * len(operating.points)
    answers = iter(end.is_reached(plan.curves[0].rotor.name, operating.stable_states(plan.machine)))
    return [next(answers) if possible else False for possible in operating.possible]


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of a torque balance."""
    sentence = _sentence(plan, findings)
    quantities = [*_curve_quantities(plan), *_point_quantities(plan, findings), *_machine_quantities(plan)]
    quantities += starting_quantities(plan.steady.machine)
    rotor, is_one_of_several = plan.curves[0].rotor.name, len(plan.steady.machine.rotors) > 1
    assumptions = [*plan.steady.assumptions, *([f"torques on the shaft of {rotor}"] if is_one_of_several else [])]
    return result_dataset(quantities, sentence, _warnings(plan, findings) + plan.steady.warnings, assumptions)


def _curve_quantities(plan: Plan) -> list[Quantity]:
    """The torques over the speed, and the stability of a working point there; separately for each configuration."""
    machine, base = plan.steady.machine, plan.curves[0]
    grid = plan.steady.grid(np.unique(np.concatenate([c.grid for c in plan.curves])))
    drive, load, _ = base.torques(grid)[0]
    vibration = np.array([c.torques(grid)[0][2] for c in plan.curves])
    surplus, slope = np.moveaxis(np.array([c.surplus(grid) for c in plan.curves]), 1, 0)
    stable, along, of_pieces = slope < 0, "configuration speed", list[Quantity]()
    if not plan.steady.branches:
        vibration, surplus, stable, along = vibration[0], surplus[0], stable[0], "speed"
    else:
        pieces = plan.steady.pieces(sense_of(machine, base.rotor) * grid)
        at, inside = [p.branch for p in pieces], np.array([p.inside for p in pieces])
        vibration, surplus = (np.where(inside, torque[at], np.nan) for torque in (vibration, surplus))
        stable = stable[at] & np.array([p.stable for p in pieces])
        names, overlapping = np.array([p.label for p in pieces], str), np.array([p.overlapping for p in pieces], np.int8)
        of_pieces = [
            Quantity("configuration_name", names, "steady phase configuration", "", "configuration", coordinate=True),
            Quantity("overlapping", overlapping, "bodies of a track overlap", "", "configuration"),
        ]
    speed, torque = machine.units.speed, machine.units.torque
    return [
        Quantity("speed", grid, "speed", speed, "speed"),
        Quantity("drive_torque", drive, "torque of the drive", torque, "speed"),
        Quantity("load_torque", load, "torque of loads and bearings", torque, "speed"),
        Quantity("vibration_torque", vibration, "torque of the vibration", torque, along),
        Quantity("surplus_torque", surplus, "drive less load and vibration", torque, along),
        Quantity("stable", stable.astype(np.int8), "stable, if it is a working point", "", along),
        *of_pieces,
    ]


def _point_quantities(plan: Plan, findings: Findings) -> list[Quantity]:
    """The working points; with bodies in steady phases including their configuration."""
    units, rows = plan.steady.machine.units, [asdict(p) for p in findings.operating.points]
    operating, answers = findings.operating, _answers(plan, findings)
    for row, answer in zip(rows, answers, strict=True):
        row["reached_from_rest"] = answer
    for row, c, label in zip(rows, operating.configurations, operating.labels, strict=False):
        row |= {
            "configuration": label, "name": c.name, "phases": c.phases, "residual_share": c.share,
            "overlapping": c.overlapping, "indifferent": c.state.is_indifferent, "family_dimension": c.state.dimension,
        }  # fmt: skip
    parts = {
        "speed": ("speed of a working point", units.speed),
        "torque": ("torque of the drive there", units.torque),
        "stable": ("whether it is stable", ""),
        "tangential": ("whether the curves only touch there", ""),
        "slope": ("slope of the drive's characteristic there", f"{units.torque} {units.time}".strip()),
        "no_load_speed": ("no-load speed of the straight line that replaces it", units.speed),
        "slip": ("slip of an induction motor", ""),
        "configuration": ("steady phase configuration there", ""),
        "name": ("kind of configuration", ""),
        "phases": ("phases of the bodies to the rotor", "rad"),
        "residual_share": ("residual unbalance, as a share of the rotor's", ""),
        "overlapping": ("whether bodies of a track overlap", ""),
        "indifferent": ("whether there is a continuous family of phases", ""),
        "family_dimension": ("dimension of the family of phases", ""),
        "reached_from_rest": FROM_REST_WORDS,
    }
    stable_speeds = [p.speed for p, possible in zip(operating.points, operating.possible, strict=True) if possible]
    fastest = max(stable_speeds, key=abs, default=None)
    columns: dict[str, type] = {"speed": float, "torque": float, "stable": np.int8}
    columns |= {"configuration": str, "overlapping": np.int8} if plan.steady.torques is not None else {}
    return [
        Quantity("operating_speed", fastest, "fastest stable working point", units.speed, headline=True),
        *from_rest_quantities(findings.from_rest, units),
        *table("working_points", rows, "steady speeds at which the torques balance", parts, "point", columns),
    ]


def _machine_quantities(plan: Plan) -> list[Quantity]:
    """Properties of the machine without vibration, and the question."""
    machine, base = plan.steady.machine, plan.curves[0]
    units = machine.units
    breakdown = None if base.breakdown is None else dict(zip(("slip", "speed", "torque"), base.breakdown, strict=True))
    parts = {"slip": ("slip", ""), "speed": ("speed", units.speed), "torque": ("torque of the drive", units.torque)}
    return [
        Quantity("on", base.rotor.name, "rotor on whose shaft the torques act"),
        Quantity("range", list(base.range), "lowest and highest speed", units.speed),
        Quantity("bodies", "steady" if plan.steady.branches else "held", "phases of bodies: steady, or held"),
        Quantity(
            "free_speed", free_speed(machine, base.rotor), "speed reached without vibration", units.speed, "",
            in_summary=True, headline=True,
        ),
        Quantity("breakdown", breakdown, "largest torque of an induction motor", parts=parts),
        Quantity("runaway", base.runaway, "whether the drive's torque, without vibration, never meets the load"),
        *natural_vibrations(machine),
    ]  # fmt: skip


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    warnings, machine = list[str](), plan.steady.machine
    if any(p.tangential for p in findings.operating.points):
        warnings.append("at a working point the curves only touch: a small change splits it into two or removes it")
    if len(machine.rotors) > 1 and plan.steady.configurations is None:
        name = plan.curves[0].rotor.name
        warnings.append(f"all rotors are assumed to turn as fast as {name!r}, in the phases of the start")
    return warnings


def _sentence(plan: Plan, findings: Findings) -> str:
    """The number of working points, and which of the stable ones is reached from rest."""
    operating, end = findings.operating, findings.from_rest
    answers = [x for x, possible in zip(_answers(plan, findings), operating.possible, strict=True) if possible]
    unit = f" {plan.steady.machine.units.speed}".rstrip()
    labels = operating.labels or [f"{p.speed:.5g}{unit}" for p in operating.points]
    labels_of_stable = [label for label, possible in zip(labels, operating.possible, strict=True) if possible]
    not_started = not_started_statement(plan.machine)
    from_rest = "" if end is None else end.sentence(answers, labels_of_stable, with_reason=not not_started)
    return "; ".join(filter(None, [_count_sentence(plan, operating), from_rest, not_started]))


def _count_sentence(plan: Plan, operating: OperatingPoints) -> str:
    overlapping = [c.overlapping for c in operating.configurations] or [False] * len(operating.points)
    points = [p for p, over in zip(operating.points, overlapping, strict=True) if not over]
    labelled_points = zip(operating.labels, operating.points, overlapping, strict=False)
    stable_names = [name for name, p, over in labelled_points if p.stable and not over]
    stable = sum(p.stable for p in points)
    if plan.steady.configurations is not None and not stable:
        unstable = f" ({len(points)} not stable)" if points else ""
        return f"the rotors do not run synchronously: no synchronous configuration in the range is stable{unstable}"
    one, several = f"one working point, {'stable' if stable else 'not stable'}", f"{len(points)} working points"
    count = one if len(points) == 1 else f"{several}, {stable} of them stable"
    count += f": {plan.steady.list_labels(stable_names)}" if stable_names else ""
    if impossible := sum(overlapping):
        count += f"; {impossible} more with overlapping bodies of a track" if points else ""
    if plan.curves[0].runaway:
        away = "without vibration the drive's torque never meets the load: the rotor would run away"
        return f"{away}; with it {'are' if len(points) > 1 else 'is'} {count}" if points else away
    if points:
        return count
    place = " in any steady phases of the balancing bodies" if plan.steady.torques is not None else ""
    return f"drive, load and vibration do not balance anywhere in the range{place}"


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a torque balance."""
    summary, lines = result.wucht.summary, ReportLines(result)
    points = summary["working_points"]
    for point in [p for p in points if not p.get("overlapping")] or points:  # impossible ones are counted in the verdict
        kind = "stable" if point["stable"] else "touching" if point["tangential"] else "unstable"
        slip = "" if point["slip"] is None else ", slip {slip:%}"
        mark = "; reached from rest" if point["reached_from_rest"] else ""
        lines.add(
            kind, f"{{speed}}{{bodies}}: {{torque}}{slip}; {_drive(point)}{mark}", point, "working_points",
            bodies=_bodies(point),
        )  # fmt: skip
    lines.add("free", "{free_speed} without vibration")
    add_starting_line(lines, summary)
    lines.add("breakdown", "{breakdown.torque} at {breakdown.speed}, slip {breakdown.slip:%}")
    lines.add("resonance", "{natural_frequencies}")
    return lines.report(summary["sentence"])


def _drive(point: dict[str, Any]) -> str:
    """The straight line that replaces the drive's characteristic there."""
    if point["slope"] is None:
        return "held by the drive's controller"
    return (
        "drive of constant torque there" if point["no_load_speed"] is None else "drive there like {slope} from {no_load_speed}"
    )


def _bodies(point: dict[str, Any]) -> str:
    """The configuration of bodies in steady phases."""
    if "configuration" not in point:
        return ""
    place = ", but with overlapping bodies of a track" if point["overlapping"] else ""
    return f", {point['configuration']}{place}"


_TALLEST, _BRAKING = 2.5, 0.5  # of the drive's largest torque: limits of the scale for resonances, and for the braking torque
_STARTING = 3.0  # times the opposing torques: limit of the scale for the starting torque of a motor


def figure(result: xr.Dataset) -> Figure:
    """Draw the torques over the speed from a torque balance's Dataset alone."""
    speed, drive, load, vibration = (result[n].values for n in ("speed", "drive_torque", "load_torque", "vibration_torque"))
    fig, [axis] = new_figure(1, result.attrs["title"], result.attrs["sentence"], 3.4)
    axis.plot(speed, drive, color=COLOURS[1], linewidth=1.2, label="drive")
    if has_load := bool(np.abs(load).any()):
        axis.plot(speed, load, color=COLOURS[2], linewidth=1.0, linestyle="-.", label="load and bearings")
    _resistance(axis, result, load + vibration, "load and vibration" if has_load else "vibration")
    _ordinate(axis, result)
    free = (float(result.free_speed), "speed without vibration")
    mark_speeds([axis], result, ("natural frequency", "natural frequencies"), free, 0)
    at = result.point_speed.values
    axis.set_xlim(min(speed[0], at.min(initial=speed[0])), max(speed[-1], at.max(initial=speed[-1])))
    return fig


def _resistance(axis: Axes, result: xr.Dataset, torque: np.ndarray, name: str) -> None:
    """Draw a line, dashed where a working point on it would not be stable; one for each configuration of balancing bodies.

    Working points are filled where stable, open where not; crosses where bodies would overlap.
    """
    if torque.ndim > 1:
        draw_configurations(axis, result, torque)
    else:
        stable = result.stable.values.astype(bool)
        draw_by_stability(axis, result.speed.values, torque, stable, name, color=COLOURS[0], linewidth=1.2)
    points, stable = result.point_torque.values, result.point_stable.values.astype(bool)
    over = np.zeros(len(points), bool)
    if "point_overlapping" in result:
        over = result.point_overlapping.values.astype(bool)
        axis.plot(result.point_speed.values[over], points[over], "x", color=GREY, markersize=4, zorder=5)
    classes = (
        (stable & ~over, "o", COLOURS[6], "stable working point"), (~stable & ~over, "o", "white", "unstable working point")
    )  # fmt: skip
    draw_classes(axis, result.point_speed.values, points, classes, color=COLOURS[6], markersize=6, zorder=5)


def _ordinate(axis: Axes, result: xr.Dataset) -> None:
    """Set the zero line, the label and the limits of the axis so that the drive is visible, however high the resonance."""
    drive, vibration = result.drive_torque.values, result.vibration_torque.values + result.load_torque.values
    driving = drive[drive * result.speed.values >= 0]
    largest = float(np.abs(driving).max(initial=0.0))
    torques = np.concatenate([[0.0], drive, vibration[np.isfinite(vibration)]])
    low, high = float(torques.min()), float(torques.max())
    if largest > 0:
        above, below = (_TALLEST if driving[np.abs(driving).argmax()] * s > 0 else _BRAKING for s in (1, -1))
        low, high = max(low, -below * largest), min(high, above * largest)
        opposing_torques = np.concatenate([np.abs(vibration[np.isfinite(vibration)]), np.abs(result.point_torque.values)])
        most = _STARTING * float(opposing_torques.max(initial=0.0)) or largest
        low, high = max(low, -most), min(high, most)
    points = result.point_torque.values
    points = points[np.isfinite(points)]
    low, high = min(low, points.min(initial=low)), max(high, points.max(initial=high))  # all working points are inside
    if high > low:
        axis.set_ylim(low - 0.05 * (high - low), high + 0.08 * (high - low))
    axis.axhline(0.0, color=GREY, linewidth=0.6, zorder=1)
    axis.set_ylabel(with_unit("torque", result.drive_torque.attrs["units"]))
