"""Question and machine -> plan: the random quantities, their samples, and the values of the parameter that are looked at."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.parameters import ends_of, parameter_of, values_of
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.varied import Varied, check_together, varied_of
from wucht.dynamics.sampling.ensemble_question import EnsembleQuestion
from wucht.dynamics.sampling.ensemble_run import way_of
from wucht.dynamics.sampling.placed_members import impossible, left_out, members_at
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.schema import Parameter
from wucht.studies.capture_probability.distributions import Distribution, distribution_of
from wucht.studies.capture_probability.random_points import REPLICATES, points
from wucht.studies.capture_probability.sobol_indices import cross_sampled, library
from wucht.studies.capture_probability.spec import CaptureProbability

_PROBES = 64  # samples that are looked at before the first run
_RANDOM = "study.random"


@dataclass(frozen=True)
class Plan:
    """along: the parameter. grid: its values that are looked at first. varied, distributions: the random quantities (q).

    samples: of these (q, M), those of a replicate in a row. at: the value for the sensitivity, of which cross (q, K) are the
    samples. way: how runs are integrated, in words.
    """

    spec: CaptureProbability
    machine: Machine
    along: Parameter
    grid: tuple[float, ...]
    varied: tuple[Varied, ...]
    distributions: tuple[Distribution, ...]
    samples: np.ndarray
    at: float | None = None
    cross: np.ndarray | None = None
    way: str = ""
    warnings: tuple[str, ...] = ()

    @property
    def each(self) -> int:
        """How many samples a replicate has."""
        return self.spec.samples // REPLICATES

    def question(self, value: float) -> EnsembleQuestion:
        """What is asked of each run at a value of the parameter. Raises ``InputError`` for one that is not allowed."""
        machine, spec = self.machine.with_values({self.along.path: value}), self.spec
        names = tuple(v.name for v in self.varied if v.state is None)
        return EnsembleQuestion(machine, names, spec.model, spec.inertia, spec.order, spec.until, tolerance=spec.tolerance)

    def members(self, value: float, places: np.ndarray) -> tuple[np.ndarray, dict[str, np.ndarray]]:
        """The states (n, M) in which runs begin, and the values (M,) of random parameters, at places (q, M)."""
        machine = self.machine.with_values({self.along.path: value})
        return members_at(machine, self.spec.start, self.varied, places, _RANDOM)


def prepare(spec: CaptureProbability, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    along = parameter_of(machine, spec.along)
    low, high = ends_of(machine, along, spec.range)
    varied = tuple(varied_of(machine, name, f"random.{name}") for name in spec.random)
    of = tuple(
        distribution_of(given, v.quantity, f"{_RANDOM}.{v.name}") for v, given in zip(varied, spec.random.values(), strict=True)
    )
    initial_state(machine, spec.start)
    check_together(varied, spec.start, "random", "another random quantity")
    unit_cube = points(spec.samples, len(varied), spec.seed)
    samples = _drawn(of, unit_cube.reshape(-1, len(varied)))
    plan = Plan(spec, machine, along, tuple(np.linspace(low, high, spec.points).tolist()), varied, of, samples)
    if spec.sensitivity and spec.at is not None:
        library()
        (at,) = values_of(machine, along, (spec.at,), "at")
        plan = replace(plan, at=at, cross=_drawn(of, cross_sampled(spec.base, len(varied), spec.seed)))
    warnings = _checked(plan)
    return replace(plan, way=way_of(plan.question(low)), warnings=(*warnings, *_uneven(spec)))


def _drawn(distributions: Sequence[Distribution], shares: np.ndarray) -> np.ndarray:
    """Values (q, M) of random quantities by points (M, q) of the unit cube."""
    tiny = np.finfo(float).tiny
    inside = np.clip(shares, tiny, 1 - np.finfo(float).epsneg)  # at 0 and 1 a normal distribution has no values
    return np.array([one.at(inside[:, k]) for k, one in enumerate(distributions)])


def _checked(plan: Plan) -> tuple[str, ...]:
    """What the averaged equations leave out.

    Raises ``InputError`` where there are none, where nothing would turn, and for samples that the machine does not allow:
    looked at are the least and the largest of each random quantity, and some more.
    """
    drawn = [plan.samples] if plan.cross is None else [plan.samples, plan.cross]
    for samples in drawn:
        for v, values in zip(plan.varied, samples, strict=True):
            if v.state is None:
                _refuse_what_is_not_allowed(plan, v.name, values)
    ends = np.unique([f(row) for row in plan.samples for f in (np.argmin, np.argmax)])
    probes = np.unique([*ends, *np.linspace(0, plan.spec.samples - 1, _PROBES).astype(int)])
    for value in (plan.grid[0], plan.grid[-1]):
        members = plan.members(value, plan.samples[:, probes])
        none = impossible(plan.question(value).machine, *members)
    possible = next((p for m, p in enumerate(probes) if m not in none), probes[0])
    return left_out(plan.question(plan.grid[-1]), plan.spec.start, plan.varied, plan.samples[:, possible].tolist())


def _refuse_what_is_not_allowed(plan: Plan, name: str, values: np.ndarray) -> None:
    for value in (float(values.min()), float(values.max())):
        try:
            plan.machine.with_values({name: value})
        except InputError as error:
            reached = f"this distribution reaches {value:.6g}, which the machine does not allow ({error.allowed})"
            allowed = f"{reached}; limit it, as by between = [low, high]"
            raise InputError(f"{_RANDOM}.{name}", plan.spec.random[name], allowed) from None


def _uneven(spec: CaptureProbability) -> list[str]:
    if spec.samples & (spec.samples - 1) == 0:
        return []
    fewer = 2 ** int(np.log2(spec.samples))
    return [f"samples = {spec.samples} is no power of two: Sobol' points fill evenly with {fewer} or {2 * fewer}"]
