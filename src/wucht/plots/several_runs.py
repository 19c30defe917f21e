"""Several runs in common panels: a signal of each over the time, and the speeds and amplitudes of many runs of a machine."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.curves import thin_curve
from wucht.plots.scales import name_speeds
from wucht.plots.time_courses import SETTLED_SHARE, shown_until
from wucht.results.formatting import abscissa_label, label, printed_unit, with_unit
from wucht.results.report import answer_in_print

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_HEIGHTS = (2.3, 2.3, 0.6)  # inches: of speeds, amplitudes, and the strip of the whole runs
_SMALL = 0.05  # of the largest amplitude: it is small
_SOON = 0.25  # of the time that is drawn: amplitudes that are small before have a panel with a shorter time


def draw_runs(
    axis: Axes, x: Iterable[np.ndarray], y: Iterable[np.ndarray], looks: Sequence[dict[str, Any]], inside: Any = None
) -> None:
    """Draw a signal of several runs.

    x, y: abscissa and values (N,) of each. looks: of the lines, each with its ``label``. inside: masks (N,) of what is drawn.
    """
    for at, values, look, mask in zip(x, y, looks, [slice(None)] * len(looks) if inside is None else inside, strict=True):
        axis.plot(*thin_curve(at[mask], values[mask]), **look)


def _last_large_amplitude(result: xr.Dataset) -> float:
    """Return the last time at which the amplitude of one of many run-ups is not small beside the largest of all."""
    amplitude = result.amplitude.values
    with np.errstate(invalid="ignore"):
        large = amplitude > _SMALL * np.nanmax(amplitude, initial=0.0)
    return float(np.broadcast_to(result.time.values, amplitude.shape)[large].max(initial=0.0))


def figure_of_runs(result: xr.Dataset) -> Figure:
    """Draw speed and amplitude of each of many runs, named at the ends of lines where there is room."""
    cases, time, heading = result.wucht.summary["cases"], result.time.values, (result.title, answer_in_print(result))
    end = float(np.nanmax(time))
    until, large = shown_until(cases, end), SETTLED_SHARE * _last_large_amplitude(result)
    vibrating = large if large < _SOON * until else until
    if vibrating < until:
        fig, axes = sheet.new_grid(2 + (until < end), *heading, columns=1, heights=_HEIGHTS)
    else:
        fig, axes = sheet.new_figure(2, *heading, _HEIGHTS, apart=int(until < end))
    speed, amplitude, *strips = axes
    scale, unit = printed_unit(result, "amplitude")
    over, name = ("abscissa", label(result, "abscissa")) if "abscissa" in result else ("time", abscissa_label(result, "time"))
    looks = style.looks_of_many([f"{case['label']}: {case['outcome']}" for case in cases], (1.1, 0.7))
    nameless, amplitudes = [look | {"label": None} for look in looks], scale * result.amplitude.values
    for strip in strips:
        draw_runs(strip, result[over].values, amplitudes, nameless, np.isfinite(time))
        strip.set(xlabel=f"whole runs, {name}", ylabel=with_unit("amplitude", unit), ylim=(0, None))
    x, speeds = result[over].values, result.speed.values[:, 0]
    if "slow_speed" in result:  # each averaged one after the full one
        slow = [style.SLOW | {"label": None if k else "averaged equations"} for k in range(len(cases))]
        nameless = [look for pair in zip(nameless, slow, strict=True) for look in pair]
        looks = [look for full in looks for look in (full, style.SLOW)]
        x = _alternate_rows(x, result["slow_abscissa" if over == "abscissa" else "time"].values)
        speeds = _alternate_rows(speeds, result.slow_speed.values[:, 0])
        amplitudes, time = _alternate_rows(amplitudes, scale * result.slow_amplitude.values), _alternate_rows(time, time)
    draw_runs(speed, x, speeds, nameless, time <= until)
    draw_runs(amplitude, x, amplitudes, looks, time <= vibrating)
    free = {round(case["free_speed"], 6) for case in cases if case["free_speed"] is not None}
    style.mark_levels(speed, sorted(free) if len(free) <= 2 else (), "no-load speed")
    name_speeds(speed, result)
    amplitude.set(xlabel=name, ylabel=label(result, "amplitude", unit), ylim=(0, None))
    if vibrating < until:
        speed.set_xlabel(name)
    for axis in axes if vibrating < until else axes[1:]:
        ends = [np.asarray(line.get_xdata())[[0, -1]] for line in axis.get_lines() if np.size(line.get_xdata())]
        if ends and np.ptp(ends) > 0:
            axis.set_xlim(np.min(ends), np.max(ends))
    sheet.name_at_ends(amplitude)
    sheet.legend_below(fig, sheet.labelled_handles([speed]))
    return fig


def _alternate_rows(first: np.ndarray, second: np.ndarray) -> np.ndarray:
    """Return the rows of two arrays (K, N) in turn, (2 K, N)."""
    return np.concatenate(np.stack([first, second], axis=1))
