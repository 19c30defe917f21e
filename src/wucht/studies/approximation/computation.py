"""Question and machine -> plan -> findings: a run-up of both models at each value of the parameter, and how they differ."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.deviations import at_equal_angle, course_of
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.schema import Unit, read_quantity
from wucht.studies.approximation.order import Errors, UnmeasuredError, errors
from wucht.studies.approximation.spec import Approximation

OWN = math.nan  # in place of a value of the parameter: the machine as it is
_DECADE = 10.0


@dataclass(frozen=True)
class Plan:
    """What is to be compared. values: of the parameter, or the factor of several; the first is ``OWN``. cases: a run-up of both
    models at each of them."""

    spec: Approximation
    machine: Machine
    values: tuple[float, ...]
    cases: tuple[RunUpCase, ...]


def prepare(spec: Approximation, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine, or it has no averaged equations."""
    values = (OWN, *_values(spec, machine))
    where = "study.values" if spec.values else "study.range"
    changes = [changes_at(machine, spec.along, value) for value in values]
    for change in changes:
        check_values(machine.parts, change, where, machine.values)
    cases = tuple(RunUpCase.of(machine.with_unchecked(change), spec.start, spec.settings) for change in changes)
    return Plan(spec, machine, values, cases)


def changes_at(machine: Machine, along: Sequence[str], value: float) -> Mapping[str, float]:
    """The parameters that are other than the machine's own, by path: one has the value, of several it is a factor."""
    if math.isnan(value):
        return {}
    return {path: value if len(along) == 1 else value * machine.values[path] for path in along}


def _values(spec: Approximation, machine: Machine) -> tuple[float, ...]:
    """In increasing order."""
    along = [parameter_of(machine, path) for path in spec.along]
    unit = Unit(along[0].unit, along[0].what) if len(along) == 1 else Unit("", "factor")
    if spec.values:
        return tuple(sorted({read_quantity(unit, given, f"study.values[{i}]") for i, given in enumerate(spec.values)}))
    if spec.range is None:
        return ()
    low, high = range_of(unit, spec.range)
    spacing = spec.spacing or ("log" if low > 0 and high / low >= _DECADE else "linear")
    if spacing == "log" and low <= 0:
        raise InputError("study.spacing", spacing, "must be 'linear' for a range that does not begin above 0")
    between = np.geomspace if spacing == "log" else np.linspace
    return tuple(map(float, between(low, high, spec.points)))


@dataclass(frozen=True)
class Findings:
    """compared: the machine as it is, then each value in order. unmeasured: why there is no order of the error."""

    compared: tuple[Comparison, ...] = ()
    measured: Errors | None = None
    unmeasured: str = ""

    @property
    def complete(self) -> bool:
        """Whether nothing is left to be done."""
        return self.measured is not None or bool(self.unmeasured)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compare and measure; the findings after each comparison."""
    findings, count = Findings(), len(plan.cases) + 1
    yield findings
    for k in range(len(plan.cases)):
        part = work.part(f"comparison {k + 1}", k / count, (k + 1) / count)
        part.report(0.0)
        findings = Findings((*findings.compared, part.unit("both models", partial(comparison, plan, k, part))))
        yield findings
    part = work.part("order", 1 - 1 / count, 1.0)
    part.report(0.0)
    try:
        yield replace(findings, measured=errors(plan.spec, plan.machine, part))
    except UnmeasuredError as error:
        yield replace(findings, unmeasured=str(error))


CURVE = 400  # samples of a curve over the rotor's angle


@dataclass(frozen=True)
class Comparison:
    """What became of both models. value: of the parameter, NaN for the machine's own.

    largest: deviations of speed (of those ``watched``) and amplitude up to ``until_phi``, NaN where the runs have nothing in
    common. relative: the same, relative to the largest speed and the largest distance of the axis of the full run up to there.
    curves (2, CURVE): their magnitudes over the rotor's angle. failure: a sentence, where one of the runs failed.
    """

    value: float
    outcome: str
    slow_outcome: str
    largest: tuple[float, float]
    relative: tuple[float, float]
    curves: np.ndarray
    failure: str = ""

    @property
    def same_outcome(self) -> bool | None:
        """Whether both end alike; None where a run was not long enough to tell."""
        if Outcome.UNIDENTIFIED in (self.outcome, self.slow_outcome) and not self.failure:
            return None
        return self.outcome == self.slow_outcome and not self.failure


def angles(until_phi: float) -> np.ndarray:
    """The rotor's angles (CURVE,) at which the curves are stored."""
    return np.linspace(0.0, until_phi, CURVE)


def comparison(plan: Plan, k: int, work: Work) -> Comparison:
    """Run both models of the k-th case. Raises ``KeyboardInterrupt`` where the user has asked to stop."""
    # What is remembered is the comparison: the legs of its two runs would be some ten megabytes each time.
    [motions] = deque(run_up(plan.cases[k], work.unkept), maxlen=1)
    failure = "; ".join(m.trajectory.failure for m in motions if m.trajectory.failure)
    outcome, slow_outcome, *_ = [*(str(m.verdict.outcome) for m in motions), str(Outcome.FAILED)]
    until, at, courses = plan.spec.until_phi, angles(plan.spec.until_phi), [course_of(m) for m in motions]
    apart = at_equal_angle(courses[0], courses[1], until) if len(courses) == 2 else None
    largest = relative = (math.nan, math.nan)
    curves = np.full((2, CURVE), np.nan)
    if apart is not None:
        largest, inside = apart.largest, courses[0].angle - courses[0].angle[0] <= until
        reached = (float(np.abs(y[..., inside]).max()) for y in (courses[0].speed, courses[0].radius))
        speed, radius = (d / of if of else math.nan if d else 0.0 for d, of in zip(largest, reached, strict=True))
        relative = speed, radius
        curves = np.array([np.interp(at, apart.at, np.abs(y), np.nan, np.nan) for y in (apart.speed, apart.radius)])
    return Comparison(plan.values[k], outcome, slow_outcome, largest, relative, curves, failure)
