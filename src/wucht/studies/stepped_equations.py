"""A sweep of equations of a table ``[system]``: plan -> findings -> quantities, the lines of its report, and its figure."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import partial
from typing import TYPE_CHECKING

import numpy as np

from wucht.dynamics.limit_sets.long_run import LongRunSettings
from wucht.dynamics.limit_sets.stepped_parameter import Way, range_of_history, settling_span, state_jumps, step_through
from wucht.dynamics.work import Work
from wucht.files.user_system import UserSystem
from wucht.results.quantities import Quantity, result_dataset, table

if TYPE_CHECKING:
    import xarray as xr

_FIRST = 0.1  # share of the work until the motion has settled at the first value


@dataclass(frozen=True, eq=False)
class SteppedPlan:
    """Sweep of equations. ways: first and last value of ``"up"`` and ``"down"``, in their order. points: values of each."""

    subject: UserSystem
    path: str
    ways: Mapping[str, tuple[float, float]]
    points: int
    start: np.ndarray
    settings: LongRunSettings


@dataclass(frozen=True, eq=False)
class SteppedFindings:
    """Finished ways. span: time at each value."""

    plan: SteppedPlan
    span: float
    ways: dict[str, Way] = field(default_factory=dict)


def compute_steps(plan: SteppedPlan, work: Work) -> Iterator[SteppedFindings]:
    """Yield the findings after each way."""
    first = next(iter(plan.ways.values()))[0]
    work.report(0.0, "settling")
    at_first = plan.subject.with_parameters({plan.path: first})
    span, state = work.unit("settling", partial(settling_span, at_first, plan.start, plan.settings))
    findings = SteppedFindings(plan, span)
    for k, (name, ends) in enumerate(plan.ways.items()):
        begin, end = (_FIRST + (1 - _FIRST) * n / len(plan.ways) for n in (k, k + 1))
        part = work.part(name, begin, end)
        values = np.linspace(*ends, plan.points)
        step = partial(step_through, plan.subject, plan.path, values, state, span, plan.settings)
        way, state = part.unit("values", partial(step, partial(_report_share, part, name)))
        findings = SteppedFindings(plan, span, findings.ways | {name: way})
        yield findings
        if way.failure:
            return


def _report_share(part: Work, name: str, share: float) -> None:
    part.report(share, name)


def stepped_dataset(findings: SteppedFindings) -> xr.Dataset:
    """Return the Dataset of a sweep of equations."""
    plan, ways = findings.plan, findings.ways
    system, names = plan.subject.system, plan.subject.system.state_names
    rows_of_states = [i for i, s in enumerate(system.states) if s not in system.angles]
    rows = [
        {plan.path: j.value, "value": j.value, "state": j.state, "from": j.before, "to": j.after, "direction": name}
        for name, way in ways.items()
        for j in state_jumps(way, names, rows_of_states)
    ]
    history = range_of_history(ways["up"], ways["down"], rows_of_states) if {"up", "down"} <= ways.keys() else None
    parts = {
        plan.path: (f"parameter {plan.path}", ""), "value": (f"parameter {plan.path}", ""),
        "state": ("state that jumps most", ""), "from": ("largest value of that state before the jump", ""),
        "to": ("largest value of that state after it", ""), "direction": ("direction in which the parameter moves", ""),
    }  # fmt: skip
    arrays = {name: np.stack([getattr(way, name) for way in ways.values()]) for name in ("low", "high", "mean", "maxima")}
    words = {"low": "least value", "high": "largest value", "mean": "mean value"}
    quantities = [
        Quantity("along", plan.path, "swept parameter"),
        *table("jumps", rows, "jumps, in the order in which they occur", parts),
        Quantity("hysteresis", history and list(history), "range in which the motion depends on the direction"),
        Quantity("span", findings.span, "time at each value of the parameter"),
        Quantity("direction", list(ways), "direction of the sweep", "", "direction"),
        Quantity("value", np.stack([w.values for w in ways.values()]), f"parameter {plan.path}", "", "direction step"),
        Quantity("state", list(names), "state", "", "state"),
        Quantity("is_angle", [int(s in system.angles) for s in system.states], "1 of an angle", "", "state", coordinate=True),
        *(Quantity(n, arrays[n], f"{word} of the state", "", "direction state step") for n, word in words.items()),
        Quantity("maxima", arrays["maxima"], "maximum of the state", "", "direction state step peak"),
    ]
    failures = [w.failure for w in ways.values() if w.failure]
    return result_dataset(
        quantities, _sentence_of_jumps(plan, rows, history), failures, (), failures[0] if failures else None,
        along=plan.path, subject="system",
    )  # fmt: skip


def _range_in_words(low: float, high: float) -> str:
    return f"between {low:.5g} and {high:.5g}" if high > low else f"at {low:.5g}"


def _sentence_of_jumps(plan: SteppedPlan, rows: list[dict[str, object]], history: tuple[float, float] | None) -> str:
    jumps = [
        f"at {plan.path} = {row['value']:.5g} ({row['direction']}) {row['state']} jumps from {row['from']:.4g} to "
        f"{row['to']:.4g}"
        for row in rows
    ]
    low, high = (f(next(iter(plan.ways.values()))) for f in (min, max))
    hysteresis = [f"the motion depends on the direction {_range_in_words(*history)}"] if history else []
    return "; ".join([*(jumps or [f"no jump for {plan.path} between {low:.5g} and {high:.5g}"]), *hysteresis])
