"""A sweep of equations of a table ``[system]``: findings -> quantities, and the lines of its report."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import TYPE_CHECKING

import numpy as np

from wucht.dynamics.limit_sets.stepped_parameter import Way, range_of_history, state_jumps, unstable_values
from wucht.results.formatting import report_lines
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.sweep.system_sweep import SystemSweepFindings, SystemSweepPlan

if TYPE_CHECKING:
    import xarray as xr


def system_sweep_dataset(findings: SystemSweepFindings) -> xr.Dataset:
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
    warnings = [*failures, *_unstable_rests(plan, ways)]
    return result_dataset(
        quantities, _sentence_of_jumps(plan, rows, history), warnings, (), failures[0] if failures else None,
        along=plan.path, subject="system",
    )  # fmt: skip


def _unstable_rests(plan: SystemSweepPlan, ways: Mapping[str, Way]) -> Iterator[str]:
    """Yield a warning for each direction in which the motion rests on an unstable equilibrium."""
    for name, way in ways.items():
        values = unstable_values(plan.subject, plan.path, way)
        if len(values):
            yield (
                f"{name}: for {plan.path} {_range_in_words(values.min(), values.max())} the motion rests on an unstable "
                "equilibrium, which any disturbance leaves; jumps do not show there. Begin beside it (study.start)"
            )


def _range_in_words(low: float, high: float) -> str:
    return f"between {low:.5g} and {high:.5g}" if high > low else f"at {low:.5g}"


def _sentence_of_jumps(plan: SystemSweepPlan, rows: list[dict[str, object]], history: tuple[float, float] | None) -> str:
    jumps = [
        f"at {plan.path} = {row['value']:.5g} ({row['direction']}) {row['state']} jumps from {row['from']:.4g} to "
        f"{row['to']:.4g}"
        for row in rows
    ]
    low, high = (f(next(iter(plan.ways.values()))) for f in (min, max))
    hysteresis = [f"the motion depends on the direction {_range_in_words(*history)}"] if history else []
    return "; ".join([*(jumps or [f"no jump for {plan.path} between {low:.5g} and {high:.5g}"]), *hysteresis])


def system_sweep_report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a sweep of equations."""
    s = result.wucht.summary
    lines = [("sweep", f"{s['along']} in steps, a time of {s['span']:.4g} at each")]
    lines += [
        ("jump", f"{j['direction']}, at {s['along']} = {j['value']:.6g}: {j['state']} {j['from']:.5g} to {j['to']:.5g}")
        for j in s["jumps"]
    ]
    count = {0: "NO JUMP", 1: "ONE JUMP"}.get(len(s["jumps"]), f"{len(s['jumps'])} JUMPS")
    return report_lines(result, count if not s["hysteresis"] else f"{count}, {s['sentence'].rpartition('; ')[2]}", lines)
