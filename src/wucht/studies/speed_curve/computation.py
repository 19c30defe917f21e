"""Question and subject -> plan -> findings: the parameters, and the branches of steady states over them."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, BranchFindings, follow_branches
from wucht.dynamics.branches.second_parameter import SecondParameter
from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.schema import Parameter
from wucht.studies.speed_curve.spec import SpeedCurve


@dataclass(frozen=True)
class Plan:
    """The plan of a speed curve.

    along, second: the parameters. bounds: of the first. case: the states to search and follow.
    """

    along: Parameter
    second: Parameter | None
    bounds: tuple[float, float]
    case: BranchCase


def prepare(spec: SpeedCurve, subject: Machine | UserSystem) -> Plan:
    """Return the plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along = parameter_of(subject, spec.along, "along")
    bounds = checked_range(subject, along, spec.range)
    second = None if spec.second is None else parameter_of(subject, spec.second, "second")
    plane, values = None, None
    if second is not None and spec.second_range is not None:
        limits = checked_range(subject, second, spec.second_range, "second_range")
        plane = SecondParameter(second.path, limits, second.value)
        if not limits[0] <= second.value <= limits[1]:
            requirement = f"must contain the value {second.value:.6g} that {second.path} has: there the curves begin"
            raise InputError("study.second_range", list(spec.second_range), requirement)
    elif second is not None and spec.second_values is not None:
        values = second.path, values_of(subject, second, spec.second_values, "second_values")
    return Plan(along, second, bounds, BranchCase.of(subject, along.path, bounds, spec.settings, plane, values))


def run(plan: Plan, work: Work) -> Iterator[BranchFindings]:
    """Yield the findings after each branch."""
    return follow_branches(plan.case, work)
