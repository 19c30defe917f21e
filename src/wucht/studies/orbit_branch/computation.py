"""Question and subject -> plan -> findings: the parameter, and the branches of orbits over it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

from wucht.dynamics.branches.orbit_diagram import OrbitCase, OrbitFindings, follow_orbits
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.dynamics.parameters import checked_range, parameter_of, values_of
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.schema import Parameter
from wucht.studies.orbit_branch.spec import OrbitBranch
from wucht.studies.spec import Value


@dataclass(frozen=True, eq=False)
class Plan:
    """The plan of a branch of orbits.

    along: the parameter. case: the orbits to search and follow.
    """

    along: Parameter
    case: OrbitCase

    @property
    def problem(self) -> OrbitProblem:
        """Return the equations."""
        return self.case.problem


def prepare(spec: OrbitBranch, subject: Machine | UserSystem) -> Plan:
    """Return the plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along = parameter_of(subject, spec.along, "along")
    bounds = checked_range(subject, along, spec.range)
    at = _values_in_range(subject, along, bounds, spec.at, "at")
    values = _values_in_range(subject, along, bounds, spec.values, "values")
    return Plan(along, OrbitCase.of(subject, along.path, bounds, spec.settings, at, values))


def _values_in_range(
    subject: Machine | UserSystem,
    along: Parameter,
    bounds: tuple[float, float],
    given_values: tuple[Value, ...] | None,
    key: str,
) -> tuple[float, ...] | None:
    """Return values of the parameter, all in the range. Raises ``InputError``."""
    if given_values is None:
        return None
    values = values_of(subject, along, given_values, key)
    for i, value in enumerate(values):
        if not bounds[0] <= value <= bounds[1]:
            raise InputError(f"study.{key}[{i}]", given_values[i], f"must lie in the range, {bounds[0]:g} to {bounds[1]:g}")
    return tuple(dict.fromkeys(values))


def run(plan: Plan, work: Work) -> Iterator[OrbitFindings]:
    """Yield the findings after each step."""
    return follow_orbits(plan.case, work)
