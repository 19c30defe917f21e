"""Question and subject -> plan -> findings: the planar System of each portrait, its points and curves."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from typing import Any

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of, keeps_inertia
from wucht.analysis.sections import Axis, Section, section_of
from wucht.dynamics.parameters import parameter_of, values_of, with_parameters
from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.machines.operation import has_damped_balancers, machine_at_speed
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.phase_plane.closed_curves import ClosedCurve
from wucht.numerics.phase_plane.fixed_points import SADDLE, FixedPoints, fixed_points, window_around
from wucht.numerics.phase_plane.manifolds import Manifold, manifold
from wucht.numerics.phase_plane.phase_curves import PhaseCurve, Portrait
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.schema import Unit, read_quantity, refuse_unknown
from wucht.studies.phase_portrait.spec import PhasePortrait
from wucht.studies.phase_portrait.state_projection import (
    ProjectionFindings,
    ProjectionPlan,
    compute_projection,
    projection_plan,
)
from wucht.system import Output, System

_NARROWEST = 1e-6  # of a range: below, differences vanish in rounding
_DRAWN_TURNS = 2  # of an angle, by default


def planar_section(spec: PhasePortrait, machine: Machine) -> Section:
    """Return the requested section. Raises ``InputError``: it has not two states, or curves do not stay in it.

    Where the inertia of balancing bodies would leave more than two states, it is left out by default, with a warning.
    """
    steady = machine_at_speed(machine, None)
    section = _candidate_section(spec, steady, keeps_inertia(steady, spec.inertia))
    if spec.inertia is None and section.inertia and len(section.axes) > 2 and has_damped_balancers(steady):
        section = _candidate_section(spec, steady, False)
        bodies = ", ".join(b.name for b in steady.bodies if b.about is not None)
        advice = "study.kind = 'approximation' shows how far such equations are from the full ones"
        left_out = (
            f"the inertia of {bodies} is left out, as if their damping were strong: with it, there are more than two states"
        )
        section = replace(section, warnings=(*section.warnings, f"{left_out}; {advice}"))
    if len(section.axes) != 2:
        _refuse_section(spec, section)
    return section


def _candidate_section(spec: PhasePortrait, steady: Machine, inertia: bool) -> Section:
    averaged_equations = averaged_equations_of(steady, inertia, spec.order, has_fixed_speed=spec.speed is not None)
    return section_of(averaged_equations, spec.together, spec.speed)


def _refuse_section(spec: PhasePortrait, section: Section) -> None:
    names = section.whole.state_names
    groups = [[n for n, x in zip(names, column, strict=True) if x] for column in section.embedding.T]
    listing = ", ".join(" = ".join(group) for group in groups)
    if len(groups) < 2 and spec.together and spec.speed is not None:
        advice = "leave out speed, so that the main rotor's speed is a state, or together"
        raise InputError("study.speed", spec.speed, f"with together, only one of two states is left, {listing}: {advice}")
    if len(groups) < 2:
        raise InputError(
            "study.kind",
            spec.kind,
            f"a phase portrait has two states, and this machine's averaged equations have {listing or 'none'}",
        )
    without = ", inertia = false leaves out the speeds of the bodies" if section.inertia else ""
    raise InputError(
        "study.together", spec.together,
        f"a phase portrait has two states, and these averaged equations have {len(groups)}: {listing}; "
        f"together = true keeps the phases of the balancing bodies equal, speed holds the main rotor's speed{without}",
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class PortraitCase:
    """A portrait. value: of the parameter ``along``, if there is one. section: of a machine, the origin of its System."""

    label: str
    value: float | None
    plane: Plane
    section: Section | None


@dataclass(frozen=True, eq=False)
class Plan:
    """The portraits. axes: the two states. drawn_ranges: (2, 2), those of the states in the figure.

    given_starts: of trajectories (2, k), None where the program chooses them. time: its unit.
    """

    spec: PhasePortrait
    cases: tuple[PortraitCase, ...]
    axes: tuple[Axis, ...]
    drawn_ranges: np.ndarray
    given_starts: np.ndarray | None
    time: str
    warnings: tuple[str, ...]

    @property
    def count(self) -> int:
        """Return the number of trajectories to be drawn."""
        return self.spec.trajectories if isinstance(self.spec.trajectories, int) else len(self.spec.trajectories)

    @property
    def model(self) -> str:
        """Return the description of a machine's equations, empty for a system."""
        section = self.cases[0].section
        if section is None:
            return ""
        order = ", second order" if section.order == 2 else ""
        return f"averaged equations{order}, {'with' if section.inertia else 'without'} the inertia of the balancing bodies"


def prepare(spec: PhasePortrait, subject: Machine | UserSystem) -> Plan | ProjectionPlan:
    """Return the plan. Raises ``InputError`` where the subject has no two states, or a key does not fit it."""
    if isinstance(subject, UserSystem) and len(subject.system.states) > 2:
        return projection_plan(spec, subject)
    if spec.show:
        raise InputError("study.show", list(spec.show), "allowed for a table [system] of more than two states only")
    return _plane_plan(spec, subject)


def _plane_plan(spec: PhasePortrait, subject: Machine | UserSystem) -> Plan:
    values = tuple(dict.fromkeys(_values(spec, subject)))
    subjects = [(v, subject if v is None else with_parameters(subject, {spec.along or "": v})) for v in values]
    sections = [planar_section(spec, s) if isinstance(s, Machine) else None for _, s in subjects]
    systems = [
        (section.system, section.values) if section is not None else (s.system, s.values)
        for section, (_, s) in zip(sections, subjects, strict=True)
    ]
    if isinstance(subject, UserSystem):
        _refuse_keys_of_machines(spec)
    first = sections[0]
    axes = first.axes if first is not None else _system_axes(systems[0][0])
    ranges = _ranges(spec, axes)
    try:
        low, high = _window(systems, axes, ranges)
        planes = [Plane(system, numbers, low, high) for system, numbers in systems]
    except InputError:
        raise
    except WuchtError as error:
        raise InputError("system" if first is None else "machine", None, str(error)) from None
    labels = ["" if v is None else f"{spec.along} = {v:.6g}" for v in values]
    cases = tuple(PortraitCase(n, v, p, section) for n, v, p, section in zip(labels, values, planes, sections, strict=True))
    warnings = first.warnings if first is not None else ()
    time = "" if isinstance(subject, UserSystem) else subject.units.time
    return Plan(spec, cases, axes, _drawn_ranges(planes[0], axes, ranges), _starts(spec, planes[0], axes), time, warnings)


def _refuse_keys_of_machines(spec: PhasePortrait) -> None:
    for key in ("together", "speed", "inertia", "order"):
        if key in spec.model_fields_set and getattr(spec, key) is not None:
            raise InputError(f"study.{key}", getattr(spec, key), "allowed only for a machine: [system] states its two states")


def _values(spec: PhasePortrait, subject: Machine | UserSystem) -> tuple[float | None, ...]:
    if spec.along is None:
        return (None,)
    return values_of(subject, parameter_of(subject, spec.along), spec.values)


def _system_axes(system: System) -> tuple[Axis, Axis]:
    if len(system.states) != 2:
        names = ", ".join(system.state_names)
        raise InputError("system.states", names, f"a phase portrait has two states, not {len(system.states)}")
    turning = [s in system.angles for s in system.states]
    a, b = (
        Axis(s.name, s.name, "rad" if turns else "", *((0.0, TURN) if turns else (math.nan, math.nan)))
        for s, turns in zip(system.states, turning, strict=True)
    )
    return a, b


def _ranges(spec: PhasePortrait, axes: tuple[Axis, ...]) -> dict[str, tuple[float, float]]:
    refuse_unknown(spec.ranges, [a.name for a in axes], "study.ranges")
    ranges = {}
    for a in axes:
        if a.name in spec.ranges:
            key = f"study.ranges.{a.name}"
            pair = spec.ranges[a.name]
            low, high = (read_quantity(Unit(a.unit, a.long_name), v, key) for v in pair)
            if not low < high:
                raise InputError(key, list(pair), "must be a pair [low, high] with low below high")
            if high - low < _NARROWEST * max(abs(low), abs(high)):
                raise InputError(key, list(pair), "must be a pair [low, high] farther apart than rounding")
            ranges[a.name] = low, high
    return ranges


def _window(
    systems: list[tuple[System, Mapping[str, float]]], axes: tuple[Axis, ...], ranges: Mapping[str, tuple[float, float]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the window of all portraits: as given, by default from the machine's speeds, else around all fixed points."""
    turning = [s in systems[0][0].angles for s in systems[0][0].states]
    ends = []
    for a, turns in zip(axes, turning, strict=True):
        low, high = (0.0, TURN) if turns else ranges.get(a.name, (a.low, a.high))
        ends.append((low, high))
    low, high = np.array(ends, float).T
    if np.isfinite(low).all():
        return low, high
    windows = [window_around(system, numbers, low, high) for system, numbers in systems]
    valid_windows = [f for f in windows if f is not None]
    if not valid_windows:
        missing = next(a.name for a, x in zip(axes, low, strict=True) if math.isnan(x))
        raise InputError("study.ranges", None, f"no fixed point was found from which to choose it: give a range of {missing}")
    return np.min([k[0] for k in valid_windows], axis=0), np.max([k[1] for k in valid_windows], axis=0)


def _drawn_ranges(plane: Plane, axes: tuple[Axis, ...], ranges: Mapping[str, tuple[float, float]]) -> np.ndarray:
    several = (plane.turns > 0).all()
    default = [(lo, lo + (1 if several else _DRAWN_TURNS) * TURN) if t else (lo, hi) for lo, hi, t in _sides(plane)]
    return np.array([ranges.get(a.name, d) for a, d in zip(axes, default, strict=True)])


def _sides(plane: Plane) -> list[tuple[float, float, bool]]:
    return list(zip(plane.low.tolist(), plane.high.tolist(), (plane.turns > 0).tolist(), strict=True))


def _starts(spec: PhasePortrait, plane: Plane, axes: tuple[Axis, ...]) -> np.ndarray | None:
    """Return the given starts (2, k). Raises ``InputError`` for an unknown state, or one outside the window."""
    if isinstance(spec.trajectories, int):
        return None
    starts = np.empty((2, len(spec.trajectories)))
    for k, start in enumerate(spec.trajectories):
        key = f"study.trajectories[{k}]"
        refuse_unknown(start, [a.name for a in axes], key)
        for i, a in enumerate(axes):
            if a.name not in start:
                raise InputError(f"{key}.{a.name}", None, f"this key is missing; give the {a.long_name}", code="missing")
            starts[i, k] = _read_start(start[a.name], a, f"{key}.{a.name}")
            if not plane.turns[i] and not plane.low[i] <= starts[i, k] <= plane.high[i]:
                requirement = f"must be within the range of {a.name}, {plane.low[i]:g} to {plane.high[i]:g}"
                raise InputError(f"{key}.{a.name}", start[a.name], requirement)
    return starts


def _read_start(value: Any, axis: Axis, key: str) -> float:
    return read_quantity(Unit(axis.unit, axis.long_name), value, key)


_SAMPLE_STRIDE = 3  # of the samples of a curve: a figure needs no more
_GOLDEN = 1.32471795724474602596  # x^3 = x + 1: M. Roberts' evenly spread sequence in the plane
_ROTOR_ANGLE = "turned"
_LEAST = 4  # curves that are followed both ways, drawn or not, to detect closed curves


@dataclass(frozen=True, eq=False)
class PortraitFindings:
    """A portrait. transverse: of each fixed point of a machine, the eigenvalues out of the section. trajectories: forwards and
    backwards from each start. curve_count: number of followed curves, drawn or not. rotor_angles: angle of the
    main rotor in a period of each closed curve."""

    fixed_points: FixedPoints
    transverse: tuple[np.ndarray, ...]
    separatrices: tuple[Manifold, ...]
    trajectories: tuple[tuple[PhaseCurve, PhaseCurve], ...]
    closed_curves: tuple[ClosedCurve, ...]
    curve_count: int
    rotor_angles: tuple[float, ...]


@dataclass(frozen=True)
class Findings:
    """The finished portraits."""

    portraits: tuple[PortraitFindings, ...]


def run(plan: Plan | ProjectionPlan, work: Work) -> Iterator[Findings | ProjectionFindings]:
    """Yield the findings after each portrait."""
    if isinstance(plan, ProjectionPlan):
        yield from compute_projection(plan, work)
        return
    done: list[PortraitFindings] = []
    for k, case in enumerate(plan.cases):
        part = work.part(f"portrait {k + 1}", k / len(plan.cases), (k + 1) / len(plan.cases))
        done.append(part.unit("curves", partial(_compute_portrait, plan, case, part)))
        yield Findings(tuple(done))


def _compute_portrait(plan: Plan, case: PortraitCase, work: Work) -> PortraitFindings:
    work.report(0.0, f"fixed points {case.label}".strip())
    plane, section = case.plane, case.section
    fixed_set = fixed_points(plane, partial(work.report, 0.0, "fixed points"))
    portrait = Portrait(plane, fixed_set.points, plan.spec.length, check=partial(work.report, 0.1, "separatrices"))
    separatrices: list[Manifold] = []
    for k, point in enumerate(fixed_set.points):
        for stable, side in ((False, 1), (False, -1), (True, 1), (True, -1)) if point.kind == SADDLE else ():
            separatrices.append(manifold(portrait, k, stable, side))
    trajectories: list[tuple[PhaseCurve, PhaseCurve]] = []
    starts = _places(plan, plane, plan.count) if plan.given_starts is None else plan.given_starts
    drawn_count = starts.shape[1]
    if drawn_count < _LEAST:
        starts = np.concatenate([starts, _places(plan, plane, _LEAST)[:, drawn_count:]], axis=1)
    for k, start in enumerate(starts.T):
        portrait.check = partial(work.report, 0.2 + 0.8 * k / starts.shape[1], "trajectories")
        pair = _thin_curve(portrait.follow(start, True)), _thin_curve(portrait.follow(start, False))
        trajectories += [pair] if k < drawn_count else []
    return PortraitFindings(
        fixed_set,
        tuple(section.transverse(p.state) for p in fixed_set.points) if section is not None else (),
        tuple(replace(m, curve=_thin_curve(m.curve)) for m in separatrices),
        tuple(trajectories),
        tuple(portrait.closed_curves),
        len(separatrices) + 2 * starts.shape[1],
        tuple(_rotor_angle(section, c) for c in portrait.closed_curves) if section is not None else (),
    )


def _places(plan: Plan, plane: Plane, count: int) -> np.ndarray:
    """Return evenly spread starts (2, k), the first by the seed."""
    first = np.random.default_rng(plan.spec.seed).uniform(size=2)
    steps = np.array([1 / _GOLDEN, 1 / _GOLDEN**2])
    share = np.remainder(first[:, None] + steps[:, None] * np.arange(count), 1.0)
    return np.asarray(plane.low[:, None] + share * plane.scale[:, None])


def _thin_curve(curve: PhaseCurve) -> PhaseCurve:
    keep = np.unique(np.concatenate([np.arange(0, curve.states.shape[1], _SAMPLE_STRIDE), [curve.states.shape[1] - 1]]))
    return replace(curve, states=curve.states[:, keep], time=curve.time[keep])


def _rotor_angle(section: Section, curve: ClosedCurve) -> float:
    """Return the angle by which the main rotor turns in a period."""
    if section.turning < 0:
        return abs(section.speed or 0.0) * curve.period
    system = replace(section.system, outputs=(), quadratures=(Output(_ROTOR_ANGLE, section.system.states[section.turning]),))
    ends = np.array([0.0, curve.period])
    run_ = integrate(
        compile_system(system), curve.states[:, 0], section.system.values(section.values), ends
    ).reraise_interrupt()
    if run_.failure is not None:
        raise WuchtError(run_.failure)
    return abs(float(run_.quadratures[_ROTOR_ANGLE][-1]))
