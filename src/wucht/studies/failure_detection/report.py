"""A specimen's failure in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import in_lines
from wucht.studies.failure_detection.report_words import counted_from, duration, within

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a failure."""
    s = result.wucht.summary
    units = (result[name].attrs["units"] for name in ("time", "speed", "stiffness_work"))
    time, speed, energy = (f" {unit}" if unit else "" for unit in units)
    lines = list[tuple[str, str]]()
    for name in ("before", "after"):
        if s[name]["speed"] is not None:
            own = s["averaged"][name]
            averaged = "" if own is None else f"; averaged equations {own:.6g}{speed}"
            lines.append((name, f"{s[name]['speed']:.6g}{speed}, {s[name]['outcome'] or 'not judged'}{averaged}"))
    if s["change"] is not None:
        spread = f"{s['signal']:.4g} times the standard deviation of the readings, {s['deviation']:.4g}{speed}"
        lines.append(("change", f"{s['change']:.5g}{speed}, {spread}"))
    if s["chart"] is not None:
        chart = s["chart"]
        lines.append(("chart", f"cumulative sum, k = {chart['reference']:.4g}, h = {chart['threshold']:.4g}{speed}"))
        delay, alarm, unit = s["delay"], result["alarm_time"], time.strip()
        horizon = within(alarm.size, float(alarm[-1]), unit)
        if delay["mean"] is not None:
            mean = f"{duration(delay['mean'], unit)} after {counted_from(s)} in the mean"
            lines.append(("seen", f"{mean}; {_by(delay, horizon, unit)}"))
        else:
            lines.append(("seen", f"not with certainty; {_by(delay, horizon, unit)}"))
    if s["damage"] is not None:
        lines.append(("damage", f"{s['damage']:.5g} at the end"))
    lines.append(
        ("stiffness", f"{s['stiffness']:.4g} of the whole specimen's at the end, its work {s['stiffness_work']:.4g}{energy}")
    )
    lines.append(("energy", f"closes to {s['energy_residual']:.1e}"))
    if s["largest"] is not None:
        largest = dict(s["largest"])
        signal, change, outcome = (largest.pop(key) for key in ("signal", "change", "outcome"))
        at = ", ".join(f"{path} = {value:.5g}" for path, value in largest.items())
        lines.append(("largest", f"signal {signal:.4g} at {at}: change {change:.5g}{speed}, then {outcome}"))
    return in_lines(result, result.attrs["sentence"], lines)


def _by(delay: dict[str, float | None], horizon: str, unit: str) -> str:
    """By when half, and nearly all, failures are seen. horizon: up to which that is known."""
    words = (("half", "half of them"), ("nearly_all", "19 of 20"))
    times = [(name, delay[key]) for key, name in words]
    return ", ".join(f"{name} {f'not {horizon}' if t is None else f'within {duration(t, unit)}'}" for name, t in times)
