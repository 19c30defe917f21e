"""The figure of many run-ups: speed and amplitude of each."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.plots import sheet, style
from wucht.plots.curves import thin_curve
from wucht.plots.scales import name_speeds
from wucht.plots.time_courses import SETTLED_SHARE, shown_until
from wucht.results.formatting import abscissa_label, label, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MOST_NAMED, _HEIGHT, _STRIP = 14, 2.3, 0.6
_SMALL = 0.05  # of the largest amplitude: it is small
_SOON = 0.25  # of the time that is drawn: amplitudes that are small before have a panel with a shorter time


def _last_large_amplitude(result: xr.Dataset) -> float:
    """Return the last time at which the amplitude of one of many run-ups is not small beside the largest of all."""
    amplitude = result.amplitude.values
    with np.errstate(invalid="ignore"):
        large = amplitude > _SMALL * np.nanmax(amplitude, initial=0.0)
    return float(np.broadcast_to(result.time.values, amplitude.shape)[large].max(initial=0.0))


def figure_of_many(result: xr.Dataset) -> Figure:
    """Draw speed and amplitude of each of many run-ups, named at the ends of lines where there is room."""
    cases, over, (scale, unit) = result.wucht.summary["cases"], "abscissa" in result, printed_unit(result, "amplitude")
    end = float(np.nanmax(result.time.values))
    until = shown_until(cases, end)
    large = _last_large_amplitude(result)
    vibrating = SETTLED_SHARE * large if SETTLED_SHARE * large < _SOON * until else until
    heights, words = [_HEIGHT, _HEIGHT, _STRIP], (result.attrs["title"], result.attrs["sentence"])
    if vibrating < until:
        fig, axes = sheet.new_grid(2 + (until < end), *words, columns=1, heights=heights)
    else:
        fig, axes = sheet.new_figure(2, *words, heights, apart=int(until < end))
    speed, amplitude, *strips = axes
    few, tones = len(cases) <= style.MOST_LOOKS, style.shades(len(cases))
    name = label(result, "abscissa") if over else abscissa_label(result, "time")
    for k, case in enumerate(cases):
        run = result.isel(case=k)
        text = f"{case['label']}: {case['outcome']}" if few or k < _MOST_NAMED else None
        look = style.line_style(k) if few else {"color": tones[k], "linewidth": 0.7}
        inside, every = run.time.values <= until, np.isfinite(run.time.values)
        shaking = run.time.values <= vibrating
        at = run["abscissa" if over else "time"].values
        speed.plot(*thin_curve(at[inside], run.speed.values[0][inside]), **look)
        amplitude.plot(*thin_curve(at[shaking], scale * run.amplitude.values[shaking]), label=text, **look)
        for strip in strips:
            strip.plot(*thin_curve(at[every], scale * run.amplitude.values[every]), **look)
        if "slow_speed" in result:
            slow = run["slow_abscissa" if over else "time"].values
            line_label = "averaged equations" if k == 0 else None
            speed.plot(*thin_curve(slow[inside], run.slow_speed.values[0][inside]), label=line_label, **style.SLOW)
            amplitude.plot(*thin_curve(slow[shaking], scale * run.slow_amplitude.values[shaking]), **style.SLOW)
    free = {round(case["free_speed"], 6) for case in cases if case["free_speed"] is not None}
    style.mark_levels(speed, sorted(free) if len(free) <= 2 else (), "no-load speed")
    name_speeds(speed, result)
    if vibrating < until:
        speed.set_xlabel(name)
    amplitude.set(xlabel=name, ylabel=label(result, "amplitude", unit), ylim=(0, None))
    for axis in ((speed,) if vibrating < until else ()) + (amplitude, *strips):
        ends = [np.asarray(line.get_xdata())[[0, -1]] for line in axis.get_lines() if np.size(line.get_xdata())]
        if ends and np.ptp(ends) > 0:
            axis.set_xlim(np.min(ends), np.max(ends))
    for strip in strips:
        strip.set(xlabel=f"whole runs, {name}", ylabel=with_unit("amplitude", unit), ylim=(0, None))
    sheet.name_at_ends(amplitude)
    sheet.legend_below(fig, sheet.labelled_handles([speed]))
    return fig
