"""Question and subject -> plan: the equations, the parameter's range, and where first orbits are looked for."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.dynamics.parameters import ends_of, parameter_of, values_of
from wucht.errors import InputError
from wucht.fields import Parameter
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.studies.orbit_branch.orbit_subject import OrbitSubject, orbit_subject
from wucht.studies.orbit_branch.spec import OrbitBranch
from wucht.studies.spec import Quantity
from wucht.studies.speed_curve.prepare import Plan as CurvePlan
from wucht.studies.speed_curve.prepare import prepare as prepare_curve
from wucht.studies.speed_curve.spec import SpeedCurve

_TRIED = (0.5, 0.25, 0.75, 0.1, 0.9)  # of the range: where a first orbit is looked for
_SEARCHED = 3  # values at which steady states are searched, besides the ends of the range


@dataclass(frozen=True, eq=False)
class Plan:
    """What is to be done.

    along: the parameter. at: values at which first orbits are looked for, all of them where they are given. values: of
    reported orbits, None for the default. curve: the plan of the steady states' branches; without: why there is none.
    """

    spec: OrbitBranch
    along: Parameter
    bounds: tuple[float, float]
    subject: OrbitSubject
    at: tuple[float, ...]
    values: tuple[float, ...] | None
    curve: CurvePlan | None
    without: str


def prepare(spec: OrbitBranch, subject: Machine | OwnEquations) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along = parameter_of(subject, spec.along)
    made = orbit_subject(spec, subject, along.path)
    bounds = ends_of(subject, along, spec.range)
    at = _within(subject, along, bounds, spec.at, "at")
    values = _within(subject, along, bounds, spec.values, "values")
    tried = tuple(float(bounds[0] + share * np.ptp(bounds)) for share in _TRIED)
    curve, without = _curve(spec, subject, made)
    return Plan(spec, along, bounds, made, at or tried, values, curve, without)


def _within(
    subject: Machine | OwnEquations, along: Parameter, bounds: tuple[float, float], given: tuple[Quantity, ...] | None, key: str
) -> tuple[float, ...] | None:
    """Values of the parameter that lie in the range."""
    if given is None:
        return None
    values = values_of(subject, along, given, key)
    for i, value in enumerate(values):
        if not bounds[0] <= value <= bounds[1]:
            raise InputError(f"study.{key}[{i}]", given[i], f"must lie in the range, {bounds[0]:g} to {bounds[1]:g}")
    return tuple(dict.fromkeys(values))


def _curve(spec: OrbitBranch, subject: Machine | OwnEquations, made: OrbitSubject) -> tuple[CurvePlan | None, str]:
    """The plan of the branches of steady states, or why they are not looked for."""
    if not isinstance(subject, Machine) and spec.ranges is None:
        return None, "equilibria are searched where ranges = { STATE = [low, high] } are given"
    only = ("together",) if spec.together else None
    asked = SpeedCurve(
        along=spec.along,
        range=spec.range,
        points=_SEARCHED,
        inertia=made.inertia,
        ranges=spec.ranges,
        show=made.show,
        only=only,
    )
    try:
        return prepare_curve(asked, subject), ""
    except InputError as error:
        if isinstance(subject, Machine):
            return None, f"steady states are not searched: {error.allowed}"
        raise
