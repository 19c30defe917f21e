"""The study ``approximation``: how far the slow equations are from the full ones, and whether they may be trusted. 002, 5.6."""

from __future__ import annotations

import math
import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np

from wucht.documents import choice, refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.fields import Parameter
from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE
from wucht.quantities import Unit
from wucht.studies.keys import allowed_value, engine_of, parameter, positive, quantity, span, start_of, tolerance_of, whole
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.run_up.model import inertia_of
from wucht.studies.run_up.study import RunUp, prepared, read_model

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_POINTS, MOST_POINTS = 7, 200
UNTIL_PHI = 100.0  # rad: 1/epsilon of Table 5.1, over which 002, 5.6.1 expects the slow equations to hold
SPACINGS = ("linear", "log")
_DECADE = 10.0
_FULL_SHARE = 0.9  # of the time that a comparison takes


@dataclass(frozen=True)
class Approximation:
    """Run-ups of both models, at the machine's own values and over the range of a parameter.

    along: a parameter, or several that are multiplied by one factor (of 002, 5.6.2: beta_p and beta_r for b_r); range: of it,
    or of the factor; values: instead of a range. points: in the range, spaced ``"linear"`` or ``"log"`` (the default over a
    decade and more). until_phi: the rotor angle up to which deviations count. start, until: of the run-ups, which by default
    end when the machine has settled, and decide the outcomes. inertia, order: of the slow equations, as in ``run-up``.
    """

    along: tuple[str, ...] = ()
    values: tuple[float, ...] = ()
    until_phi: float = UNTIL_PHI
    start: Mapping[str, Any] = field(default_factory=dict)
    until: float | None = None
    inertia: bool | None = None
    order: int = 1
    tolerance: float = DEFAULT_TOLERANCE
    engine: str | None = None

    kind: ClassVar[str] = "approximation"
    keys: ClassVar[tuple[str, ...]] = (
        "kind", "along", "range", "values", "points", "spacing", "until_phi", "start", "until", "inertia", "order",
        "tolerance", "engine",
    )  # fmt: skip

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> Approximation:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        _, inertia, order = read_model(dict(table) | {"model": "both"})
        along = _along(table, machine)
        found = cls(
            along=tuple(p.path for p in along),
            values=_values(table, along),
            until_phi=positive(table, "until_phi", Unit("rad" if machine.units.time else "", "angle")) or UNTIL_PHI,
            start=start_of(table),
            until=positive(table, "until", Unit(machine.units.time, "time")),
            inertia=inertia,
            order=order,
            tolerance=tolerance_of(table),
            engine=engine_of(table),
        )
        found.check_values(machine, "study.values" if "values" in table else "study.range")
        return found

    def check_values(self, machine: Machine, where: str) -> None:
        """Raises ``InputError``, located at ``where``, for a value that a part does not allow."""
        for value in self.values:
            for path, v in self.changes(machine, value).items():
                allowed_value(machine, path, v, where)

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the machine has no slow equations, or a part does not allow a value."""
        self.check_values(machine, "study.values")
        for value in (None, *self.values):
            case = machine.with_values(self.changes(machine, value))
            prepared(case, self.run_up())
            inertia_of(case, self.inertia)
        self.run_up().check(machine)

    def changes(self, machine: Machine, value: float | None) -> dict[str, float]:
        """Parameter values at a value of ``along``, None for the machine's own."""
        if value is None:
            return {}
        if len(self.along) == 1:
            return {self.along[0]: value}
        return {path: value * machine.values[path] for path in self.along}

    def run_up(self) -> RunUp:
        """The run-up whose models are compared."""
        return RunUp(
            until=self.until,
            start=self.start,
            model="both",
            inertia=self.inertia,
            order=self.order,
            tolerance=self.tolerance,
            engine=self.engine,
        )


def _along(table: Mapping[str, Any], machine: Machine) -> tuple[Parameter, ...]:
    given = table.get("along")
    if given is None:
        if missing := [k for k in ("range", "values", "points", "spacing") if k in table]:
            raise InputError(f"study.{missing[0]}", table[missing[0]], "allowed only together with along = PATH")
        return ()
    paths = given if isinstance(given, list) else [given]
    if not paths or len(set(map(str, paths))) < len(paths):
        raise InputError("study.along", given, "allowed is the path of a parameter, or a list of different ones")
    return tuple(parameter({"along": path}, "along", machine) for path in paths)


def _values(table: Mapping[str, Any], along: tuple[Parameter, ...]) -> tuple[float, ...]:
    if not along:
        return ()
    unit = Unit(along[0].unit, along[0].what) if len(along) == 1 else Unit("", "factor")
    given = table.get("values")
    if given is not None:
        if not isinstance(given, list) or not 0 < len(given) <= MOST_POINTS:
            raise InputError("study.values", given, f"allowed is a list of 1 to {MOST_POINTS} values")
        if "range" in table or "points" in table or "spacing" in table:
            raise InputError("study.values", None, "allowed is either values, or range with points and spacing")
        read = [quantity({f"values[{i}]": v}, f"values[{i}]", unit) for i, v in enumerate(given)]
        return tuple(sorted({v for v in read if v is not None}))
    limits = span(table, "range", unit)
    if limits is None:
        raise InputError("study.range", None, f"this key is missing; needed is a pair [low, high] of a {unit.what}")
    points = whole(table, "points", DEFAULT_POINTS, 2, MOST_POINTS)
    low, high = limits
    far = low > 0 and high / low >= _DECADE
    spacing = choice({"spacing": "log" if far else "linear"} | dict(table), "spacing", "study", SPACINGS)
    if spacing == "log" and low <= 0:
        raise InputError("study.spacing", spacing, "allowed is 'linear' for a range that does not begin above 0")
    found = np.geomspace(low, high, points) if spacing == "log" else np.linspace(low, high, points)
    return tuple(map(float, found))


def _share(progress: Progress, k: int, count: int) -> Progress:
    return lambda reached, goal: progress(k + (_FULL_SHARE * min(reached / goal, 1.0) if goal else 0.0), count)


@np.errstate(all="ignore")  # a run that fails says so in a sentence, not by warnings about overflow
def approximation(
    machine: Machine,
    question: Approximation,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """Compare both models. Returns the Dataset of ``approximation.result``.

    progress: called with the comparisons done and to do. checkpoint: called with the result so far after each. resume: an
    earlier result of the same question, whose comparisons are kept. Raises ``InputError`` for a question that does not fit;
    a run that fails is recorded.
    """
    from wucht.studies.approximation.comparison import comparison, restored
    from wucht.studies.approximation.order import UnmeasuredError, errors
    from wucht.studies.approximation.result import result
    from wucht.studies.resuming import check_same, whole_fingerprint

    begun = clock.perf_counter()
    question.check(machine)
    values = (math.nan, *question.values)
    if resume is not None:
        check_same(resume, whole_fingerprint(machine, question), "machine or question")
    done = restored(resume) if resume is not None else []
    interrupted, measured, unmeasured = False, None, ""
    try:
        for k, value in list(enumerate(values))[len(done) :]:
            share = None if progress is None else _share(progress, k, len(values) + 1)
            changed = question.changes(machine, None if math.isnan(value) else value)
            done.append(comparison(machine.with_values(changed), question, value, share))
            if checkpoint is not None and k:
                checkpoint(result(machine, question, done, None, begun, interrupted=True))
        measured = errors(machine, question)
    except UnmeasuredError as error:
        unmeasured = str(error)
    except KeyboardInterrupt:
        interrupted = True
    return result(machine, question, done, measured, begun, interrupted, unmeasured)
