"""Question and subject -> plan: the parameters, the cells, and the equations of the modulated motions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.parameters import ends_of, parameter_of, with_parameters
from wucht.errors import InputError
from wucht.fields import Parameter
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.studies.orbit_branch.orbit_subject import OrbitSubject, orbit_subject
from wucht.studies.orbit_branch.spec import OrbitBranch
from wucht.studies.speed_curve.own_states import OwnStates
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
    along, second = parameter_of(subject, spec.along), parameter_of(subject, spec.second, "second")
    bounds, limits = ends_of(subject, along, spec.range), ends_of(subject, second, spec.second_range, "second_range")

    def row(value: float) -> CurvePlan:
        asked = SpeedCurve(
            along=spec.along, range=spec.range, points=_SEARCHED, only=spec.only, ranges=spec.ranges, inertia=spec.inertia
        )
        return prepare_curve(asked, with_parameters(subject, {second.path: value}))

    middle = row(sum(limits) / 2)  # every check of the steady states
    third, plane = None, None
    if spec.eliminate is not None and spec.eliminate_range is not None:
        third = parameter_of(subject, spec.eliminate, "eliminate")
        ends = ends_of(subject, third, spec.eliminate_range, "eliminate_range")
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


def _motion(spec: StabilityMap, subject: Machine | OwnEquations, path: str, row: CurvePlan) -> MappedMotion:
    """The equations of modulated motions."""
    asked = OrbitBranch(along=path, range=(0.0, 1.0), together=spec.together, inertia=spec.inertia, ranges=spec.ranges)
    part = orbit_subject(asked, subject, path)
    whole = orbit_subject(asked.model_copy(update={"together": False}), subject, path) if spec.together else None
    return MappedMotion(part, whole, _box(part, row))


def _box(subject: OrbitSubject, row: CurvePlan) -> np.ndarray:
    """Ranges (2, n) of the states."""
    states = row.curves[0][1]
    if isinstance(states, OwnStates):
        return np.array([states.ranges[n] for n in states.names]).T
    speeds = (_LOWEST * states.size_of_shown, _HIGHEST * states.size_of_shown)
    return np.array([_ANGLES if turns else speeds for turns in subject.turning]).T
