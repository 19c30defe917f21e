"""A specimen's failure in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import ReportLines
from wucht.studies.failure_detection.report_words import counted_from, duration, within

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a failure."""
    s, lines = result.wucht.summary, ReportLines(result)
    for name in ("before", "after"):
        averaged = "" if s["averaged"][name] is None else f"; averaged equations {{averaged.{name}:.6g}}"
        lines.add(name, f"{{{name}.speed:.6g}}, {s[name]['outcome'] or 'not judged'}{averaged}")
    spread = "{signal:.4g} times the standard deviation of the readings, {deviation:.4g}"
    lines.add("change", "{change:.5g}, " + spread)
    if s["chart"] is not None:
        lines.add("chart", f"cumulative sum, k = {s['chart']['reference']:.4g}, h = {{chart.threshold:.4g}}")
        delay, alarm, unit = s["delay"], result["alarm_time"], result["time"].attrs["units"]
        horizon, mean = within(alarm.size, float(alarm[-1]), unit), "not with certainty"
        if delay["mean"] is not None:
            mean = f"{duration(delay['mean'], unit)} after {counted_from(s['failure_time'])} in the mean"
        lines.add("seen", f"{mean}; {_by(delay, horizon, unit)}")
    lines.add("damage", "{damage:.5g} at the end")
    lines.add("stiffness", "{stiffness:.4g} of the whole specimen's at the end, its work {stiffness_work:.4g}")
    lines.add("energy", "closes to {energy_residual:.1e}")
    if s["largest"] is not None:
        at = (f"{path} = {x:.5g}" for path, x in s["largest"].items() if path not in ("signal", "change", "outcome"))
        there = "change {largest.change:.5g}, then {largest.outcome}"
        lines.add("largest", "signal {largest.signal:.4g} at {at}: " + there, at=", ".join(at))
    return lines.report(result.wucht.sentence)


def _by(delay: dict[str, float | None], horizon: str, unit: str) -> str:
    """By when half, and nearly all, failures are seen. horizon: up to which that is known."""
    words = (("half", "half of them"), ("nearly_all", "19 of 20"))
    times = [(name, delay[key]) for key, name in words]
    return ", ".join(f"{name} {f'not {horizon}' if t is None else f'within {duration(t, unit)}'}" for name, t in times)
