"""The figure of many run-ups: speed and amplitude of each case."""

from __future__ import annotations

import json
from typing import TYPE_CHECKING

import numpy as np

from wucht.results.style import DASHES, GREY, SLOW, label, line_style, new_figure, thinned

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

_MOST_NAMED, _LONG, _HEIGHT = 14, 40, 6.4


def figure_of_many(result: xr.Dataset) -> Figure:
    """Two panels from the Dataset of many run-ups."""
    drawn, (speed, amplitude) = new_figure(2, _HEIGHT, result.attrs["title"], result.attrs["sentence"])
    cases = json.loads(result.attrs["summary"])["cases"]
    dimensional = result.amplitude.attrs["units"] == "m"
    scale, unit = (1e3, "mm") if dimensional else (1.0, result.amplitude.attrs["units"])
    over = "abscissa" in result
    for k, case in enumerate(cases):
        run = result.isel(case=k)
        inside = np.isfinite(run.time.values)
        at = run["abscissa" if over else "time"].values[inside]
        name = f"{case['label']}: {case['outcome']}" if k < _MOST_NAMED else None
        # Runs that end alike lie upon each other: later ones are dashed, so that the earlier stay visible.
        style = line_style(k) | {"linestyle": DASHES[min(k, len(DASHES) - 1)] if len(cases) <= len(DASHES) else "-"}
        speed.plot(*thinned(at, run.speed.values[0][inside]), label=name, **style)
        amplitude.plot(*thinned(at, scale * run.amplitude.values[inside]), **style)
        if "slow_speed" in result:
            slow = run["slow_abscissa" if over else "time"].values[inside]
            named = "slow equations" if k == 0 else None
            speed.plot(*thinned(slow, run.slow_speed.values[0][inside]), label=named, **SLOW)
            amplitude.plot(*thinned(slow, scale * run.slow_amplitude.values[inside]), **SLOW)
    free = {round(case["free_speed"], 6) for case in cases if case["free_speed"] is not None}
    for k, value in enumerate(sorted(free) if len(free) <= 2 else ()):
        speed.axhline(value, color=GREY, linestyle=":", linewidth=0.9, label="no-load speed" if k == 0 else None)
    speed.set_ylabel(label(result, "speed"))
    amplitude.set_ylabel(label(result, "amplitude", unit))
    amplitude.set_ylim(bottom=0)
    plain = label(result, "time") if result.time.attrs["units"] else "time $\\tau$"
    amplitude.set_xlabel(label(result, "abscissa") if over else plain)
    columns = 1 if max(len(c["label"]) for c in cases) > _LONG else 2
    rows = -(-min(len(cases) + 1, _MOST_NAMED) // columns)
    drawn.subplots_adjust(right=0.97, bottom=(0.55 + 0.17 * rows) / _HEIGHT)
    drawn.legend(loc="lower center", ncol=columns, frameon=False, fontsize=7.5)
    return drawn
