"""Question and subject -> plan: the parameters, the cells, and the equations of the modulated motions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.configurations.steady_machine import turning
from wucht.analysis.sections import section_of
from wucht.errors import InputError, nearest
from wucht.fields import Parameter
from wucht.files.own_equations import OwnEquations
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.quantities import Unit
from wucht.studies.orbit_branch.orbit_subject import OrbitSubject, subject_of_equations, subject_of_machine
from wucht.studies.orbit_branch.spec import OrbitBranch
from wucht.studies.parameters import parameter_of, range_of
from wucht.studies.spec import Pair
from wucht.studies.speed_curve.prepare import Plan as CurvePlan
from wucht.studies.speed_curve.prepare import prepare as prepare_curve
from wucht.studies.speed_curve.spec import SpeedCurve
from wucht.studies.stability_map.ending_curves import Plane
from wucht.studies.stability_map.mapped_motion import MappedMotion
from wucht.studies.stability_map.spec import StabilityMap

_CELLS, _FEWER = 12, 6
_SEARCHED = 2  # values of the first parameter at which all steady states are searched, besides those near its ends
_LOWEST, _HIGHEST = 0.02, 1.15  # of the fastest speed of steady states: between these they are searched
_ANGLES = (0.0, 2 * math.pi)

Bounds = tuple[float, float]


@dataclass(frozen=True, eq=False)
class Plan:
    """What is to be done.

    along, second: the parameters, with bounds (2 of (low, high)). third: the eliminated one, with its bounds in plane. row: the
    plan of the steady states over the first parameter at a value of the second. motion: None where no modulated motion is
    looked for. cells: a side.
    """

    spec: StabilityMap
    along: Parameter
    second: Parameter
    bounds: tuple[Bounds, Bounds]
    third: Parameter | None
    plane: Plane | None
    row: Callable[[float], CurvePlan]
    motion: MappedMotion | None
    cells: int
    time: str
    warnings: tuple[str, ...]

    def centres(self, k: int) -> np.ndarray:
        """Of the cells, in the first (0) or the second (1) parameter."""
        low, high = self.bounds[k]
        return np.asarray(low + (high - low) * (np.arange(self.cells) + 0.5) / self.cells)


def prepare(spec: StabilityMap, subject: Machine | OwnEquations) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along, bounds = _ranged(subject, spec.along, spec.range, "along", "range")
    second, limits = _ranged(subject, spec.second, spec.second_range, "second", "second_range")

    def row(value: float) -> CurvePlan:
        at = (
            subject.with_unchecked({second.path: value})
            if isinstance(subject, Machine)
            else subject.changed({second.path: value})
        )
        asked = SpeedCurve(
            along=spec.along, range=spec.range, points=_SEARCHED, only=spec.only, ranges=spec.ranges, inertia=spec.inertia
        )
        return prepare_curve(asked, at)

    middle = row(sum(limits) / 2)  # every check of the steady states
    third, plane = None, None
    if spec.eliminate is not None and spec.eliminate_range is not None:
        third, ends = _ranged(subject, spec.eliminate, spec.eliminate_range, "eliminate", "eliminate_range")
        plane = Plane((third.path, along.path, second.path), (ends, bounds, limits))
    motion = _motion(spec, subject, along.path if third is None else third.path, middle) if spec.orbits else None
    needed = [along.path, second.path] + ([third.path] if third is not None else [])
    for key, path in zip(("along", "second", "eliminate"), needed, strict=False):
        names = middle.curves[0][1].equilibria.equations.parameters if motion is None else motion.subject.system.parameter_names
        if motion is not None and path not in names:
            raise InputError(f"study.{key}", path, "not allowed: the averaged equations do not depend on it")
    time = "" if isinstance(subject, OwnEquations) else subject.units.time
    cells = spec.cells or (_CELLS if third is None else _FEWER)
    warnings = middle.curves[0][1].words.warnings
    return Plan(spec, along, second, (bounds, limits), third, plane, row, motion, cells, time, warnings)


def _ranged(
    subject: Machine | OwnEquations, path: str, given: Pair, key: str, of_range: str
) -> tuple[Parameter, tuple[float, float]]:
    """A parameter and its range."""
    if isinstance(subject, Machine):
        parameter = parameter_of(subject, path, key)
    elif path in subject.parameters:
        parameter = subject.parameters[path]
    else:
        raise InputError(f"study.{key}", path, f"unknown parameter; {nearest(path, subject.parameters)}")
    bounds = range_of(Unit(parameter.unit, parameter.what), given, of_range)
    if isinstance(subject, Machine):
        for i, value in enumerate(bounds):
            check_values(subject.parts, {parameter.path: value}, f"study.{of_range}[{i}]", subject.values)
    return parameter, bounds


def _motion(spec: StabilityMap, subject: Machine | OwnEquations, path: str, row: CurvePlan) -> MappedMotion:
    """The equations of modulated motions."""
    asked = OrbitBranch(along=path, range=(0.0, 1.0), together=spec.together, inertia=spec.inertia, ranges=spec.ranges)
    if isinstance(subject, OwnEquations):
        if spec.together:
            raise InputError("study.together", True, "allowed for a machine only")
        of = subject_of_equations(asked, subject, path)
        ranges = row.curves[0][1].ranges  # type: ignore[attr-defined]
        return MappedMotion(of, None, None, np.array([ranges[n] for n in of.system.state_names]).T)
    part = subject_of_machine(asked, subject, path)
    if not spec.together:
        return MappedMotion(part, None, None, _box(part, row))
    whole = subject_of_machine(asked.model_copy(update={"together": False}), subject, path)
    slow = averaged_machine(turning(subject, None), bool(part.inertia))
    return MappedMotion(part, whole, section_of(slow, True).embedding, _box(part, row))


def _box(subject: OrbitSubject, row: CurvePlan) -> np.ndarray:
    """Ranges (2, n) of the states of averaged equations."""
    fastest = row.curves[0][1].size_of_shown
    speeds = (_LOWEST * fastest, _HIGHEST * fastest)
    return np.array([_ANGLES if turns else speeds for turns in subject.turning]).T
