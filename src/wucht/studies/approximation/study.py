"""Averaged equations against the full ones: where they agree, over a parameter; the order of their error (002, 5.6)."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any, Literal

import numpy as np
from pydantic import BeforeValidator, Field, WithJsonSchema

from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.scenarios.model_comparison import ModelComparison, compare_models
from wucht.dynamics.scenarios.order_of_error import Errors, UnmeasuredError, measured_errors
from wucht.dynamics.scenarios.runs_in_turn import runs_in_turn
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.schema import SI, Composite, Unit, composite, read_quantity, si
from wucht.studies.answer import Answer
from wucht.studies.approximation.answer import state_approximation
from wucht.studies.approximation.figure import figure
from wucht.studies.key_types import DEFAULT_TOLERANCE, Engine, Inertia, Order, Pair, Start, Tolerance, Values, Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import AVERAGED_EQUATIONS, FULL_EQUATIONS, Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

DEFAULT_POINTS, MOST_POINTS = 7, 200
UNTIL_PHI = 100.0  # rad: 1/epsilon of Table 5.1, over which 002, 5.6.1 expects the averaged equations to hold
_ALONG_KEYS = ("range", "values", "points", "spacing")
_PATHS = {"anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}]}


def _paths(raw: Any) -> Any:
    paths = raw if isinstance(raw, list | tuple) else [raw]
    if not paths or not all(isinstance(p, str) for p in paths) or len(set(paths)) < len(paths):
        raise ValueError("must be the path of a parameter, or a list of different ones")
    return tuple(paths)


NOMINAL_VALUE = math.nan  # in place of a value of the parameter: the nominal machine
_DECADE = 10.0
ValueCase = tuple[float, RunUpCase]  # the parameter, or the factor of several, and the run-up of both models there


class Approximation(Study):
    """Run-ups of both models, at the machine's nominal values and over the range of a parameter."""

    kind = "approximation"
    next_questions = (NextQuestion("in which state it ends when it is started", {"study.kind": "run-up"}),)
    curves = (("value", "speed_deviation"), ("value", "amplitude_deviation"))
    solves = f"{FULL_EQUATIONS}, compared with {AVERAGED_EQUATIONS}"
    from_start = True
    without_inertia = True

    along: Composite[Annotated[tuple[str, ...], BeforeValidator(_paths), WithJsonSchema(_PATHS)]] = composite(
        default=(), title="path of a parameter, or of several",
        description="path of a parameter, or of several that are multiplied by one factor (such as beta_p and beta_r for b_r "
        "in 002, 5.6.2)",
    )  # fmt: skip
    range: Composite[Pair | None] = composite(default=None, description="pair [low, high] of the parameter, or of the factor")
    values: Composite[Values] = composite(
        default=(), description="values of the parameter, or of the factor, instead of a range"
    )
    points: Whole = Field(default=DEFAULT_POINTS, description="number of points in the range")
    spacing: Literal["linear", "log"] | None = Field(
        default=None, description='spacing of the points, `"linear"` or `"log"` (the default over a decade or more)'
    )
    until_phi: SI[float] = si("rad", "angle", default=UNTIL_PHI, gt=0, help="rotor angle up to which deviations count")
    start: Composite[Start] = composite(
        default_factory=dict, description="initial state of the run-ups, which decide the outcomes"
    )
    until: SI[float | None] = si(
        "s", "time", default=None, gt=0, help="time at which the run-ups end, by default when the machine has settled"
    )
    inertia: Inertia | None = None
    order: Order = 1
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def check(self) -> None:
        """Check that the parameter is varied once: by a range, or by values."""
        given_keys = [key for key in _ALONG_KEYS if key in self.model_fields_set]
        if not self.along:
            if given_keys:
                raise InputError(
                    f"study.{given_keys[0]}", getattr(self, given_keys[0]), "allowed only together with along = PATH"
                )
            return
        if "values" in given_keys:
            if not 0 < len(self.values) <= MOST_POINTS:
                raise InputError("study.values", list(self.values), f"must be a list of 1 to {MOST_POINTS} values")
            if len(given_keys) > 1:
                raise InputError("study.values", None, "give either values, or range with points and spacing")
        elif self.range is None:
            raise InputError(
                "study.range", None, "this key is missing; it must be a pair [low, high] of the parameter", code="missing"
            )
        if not 2 <= self.points <= MOST_POINTS:
            raise InputError("study.points", self.points, f"must be a whole number from 2 to {MOST_POINTS}")

    @property
    def settings(self) -> RunSettings:
        """Settings of the run-ups of both models."""
        return RunSettings(
            self.until, model="both", inertia=self.inertia, order=self.order, tolerance=self.tolerance, engine=self.engine
        )

    def prepare(self, machine: Machine) -> tuple[ValueCase, ...]:
        """Return the comparisons to be made, the first of the nominal machine.

        Raises ``InputError`` where the question does not fit the machine, or it has no averaged equations.
        """
        values = (NOMINAL_VALUE, *self._values(machine))
        location = "study.values" if self.values else "study.range"
        changes = [changes_at(machine, self.along, value) for value in values]
        for change in changes:
            machine.check_values(change, location)
        cases = (RunUpCase.of(machine.with_unchecked_values(change), self.start, self.settings) for change in changes)
        return tuple(zip(values, cases, strict=True))

    def _values(self, machine: Machine) -> tuple[float, ...]:
        """The values in increasing order."""
        along = [parameter_of(machine, path) for path in self.along]
        unit = Unit(along[0].unit, along[0].long_name) if len(along) == 1 else Unit("", "factor")
        if self.values:
            return tuple(sorted({read_quantity(unit, raw, f"study.values[{i}]") for i, raw in enumerate(self.values)}))
        if self.range is None:
            return ()
        low, high = range_of(unit, self.range)
        spacing = self.spacing or ("log" if low > 0 and high / low >= _DECADE else "linear")
        if spacing == "log" and low <= 0:
            raise InputError("study.spacing", spacing, "must be 'linear' for a range that does not begin above 0")
        between = np.geomspace if spacing == "log" else np.linspace
        return tuple(map(float, between(low, high, self.points)))

    def solve(self, machine: Machine, cases: tuple[ValueCase, ...], work: Work) -> Iterator[Answer]:
        """Compare the models at each value, then measure the error."""
        fill = partial(state_approximation, machine, self.along, self.until_phi, len(cases) - 1)
        order_share = 1 / (len(cases) + 1)
        yield Answer(machine.units, partial(fill, (), None))
        for comparisons in runs_in_turn(cases, self._compare, work.part("", 0.0, 1 - order_share), "comparison"):
            yield Answer(machine.units, partial(fill, comparisons, None))
        part = work.part("order", 1 - order_share, 1.0)
        part.report(0.0)
        order: Errors | str
        try:
            order = measured_errors(machine, self.start, self.settings, self.until_phi, part)
        except UnmeasuredError as error:
            order = str(error)
        yield Answer(machine.units, partial(fill, comparisons, order))

    def _compare(self, case: ValueCase, work: Work) -> Iterator[ModelComparison]:
        value, run_up_case = case
        work.report(0.0)
        yield work.unit("both models", partial(compare_models, run_up_case, value, self.until_phi, work))

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw the deviations over the rotor's angle, over the parameter, and over epsilon."""
        return figure(result)


def changes_at(machine: Machine, along: Sequence[str], value: float) -> Mapping[str, float]:
    """Changed parameters by path: a single one has the value, several are multiplied by it."""
    if math.isnan(value):
        return {}
    return {path: value if len(along) == 1 else value * machine.values[path] for path in along}
