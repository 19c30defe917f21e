"""Question and subject -> plan -> findings: the map of all motions, or that of how the modulated motion ends."""

from __future__ import annotations

from collections.abc import Iterator

from wucht.dynamics.parameters import ends_of, parameter_of
from wucht.dynamics.work import Work
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.studies.stability_map.ending_plan import EndingPlan
from wucht.studies.stability_map.map_parts import F, MapPlan
from wucht.studies.stability_map.spec import StabilityMap
from wucht.studies.stability_map.state_plan import StatePlan


def prepare(spec: StabilityMap, subject: Machine | OwnEquations) -> StatePlan | EndingPlan:
    """The plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along, second = parameter_of(subject, spec.along, "along"), parameter_of(subject, spec.second, "second")
    bounds = ends_of(subject, along, spec.range), ends_of(subject, second, spec.second_range, "second_range")
    return (StatePlan if spec.eliminate is None else EndingPlan).of(spec, subject, along, second, bounds)


def run(plan: MapPlan[F], work: Work) -> Iterator[F]:
    """The findings, each more complete than those before."""
    return plan.run(work)
