"""The figure of a map of basins: its outcomes, the settling time and the peak amplitude."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.sheet import colour_bar, legend_beside, new_grid
from wucht.plots.style import GREY
from wucht.results.conventions import summary_of
from wucht.results.formatting import named, percent, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Of each outcome colour (Okabe and Ito's, lightened or darkened so that those that are often neighbours differ in grey too)
# and hatch.
_LOOKS = {
    "compensated": ("#5FAEDF", "//"),
    "passed": ("#D9EFC9", ".."),
    "captured": ("#F5C04A", ""),
    "captured-modulated": ("#C24E00", "\\\\"),
    "balancer-captured": ("#9A5B84", "xx"),
    "entrained": ("#0072B2", "//"),
    "not-entrained": ("#F0E3B0", "--"),
    "synchronised": ("#009E73", "\\|"),
    "not-synchronised": ("#E8CFDD", "||"),
    "stopped": ("#404040", ""),
    "oscillating": ("#7F7F7F", "++"),
    "runaway": ("#6B1F00", "oo"),
    "unidentified": ("#FFFFFF", "xxx"),
    "failed": ("#000000", ".."),
}
_NOT_COMPUTED, _BLANK = "not computed", "#EFEFEF"
_HATCHED = 512  # points a side
_PARTS_OF_PI = (8, 4, 2, 1)  # ticks of an angle are multiples of pi over one of these, at most so many:
_MOST_TICKS = 5
_SCALE = "viridis"


def figure(result: xr.Dataset) -> Figure:
    """The plane of both axes three times, from the Dataset alone; where the borders are refined, the refined map."""
    prefix = "refined_" if "refined_outcome" in result else ""
    s = summary_of(result)
    cells = " x ".join(map(str, s["levels"][-1]["cells"]))
    maps = [name for name in (f"{prefix}settling_time", f"{prefix}peak_amplitude") if np.isfinite(result[name].values).any()]
    drawn, (outcomes, *axes) = new_grid(
        1 + len(maps), result.attrs["title"], f"{cells} cells, {s['runs']} runs", heights=(3.2, 2.2), wide=1
    )
    handles = _outcomes(outcomes, result, prefix)
    for axis, name in zip(axes, maps, strict=True):
        _values(axis, result, name)
    for axis in (outcomes, *axes):
        _frame(axis, result)
    legend_beside(outcomes, handles)
    return drawn


def _outcomes(axis: Axes, result: xr.Dataset, prefix: str) -> list[Any]:
    """The map of outcomes; what is what, with its share of the map."""
    from matplotlib.colors import ListedColormap
    from matplotlib.patches import Patch

    s, variable = summary_of(result), result[f"{prefix}outcome"]
    fractions, off = s["fractions"], s["uncertainty"]
    flags = dict(zip(np.asarray(variable.flag_values).tolist(), str(variable.flag_meanings).split(), strict=True))
    present = [k for k in flags if (variable.values == k).any()]
    looks = {k: _LOOKS.get(flags[k], (_BLANK, "")) for k in present}
    index = np.searchsorted(present, variable.values)
    tones = ListedColormap([colour for colour, _ in looks.values()])
    _image(axis, result, index, cmap=tones, vmin=-0.5, vmax=len(present) - 0.5)
    _hatches(axis, result, variable.values, looks)
    words = {k: _NOT_COMPUTED if k < 0 else f"{flags[k]}: {percent(fractions[flags[k]], off[flags[k]])}" for k in present}
    order = sorted(present, key=lambda k: -fractions.get(flags[k], -1.0))
    axis.set_title("outcome and share of the map")
    return [
        Patch(facecolor=colour, hatch=hatch, edgecolor=_edge(colour) if hatch else GREY, linewidth=0.5, label=words[k])
        for k in order
        for colour, hatch in [looks[k]]
    ]


def _image(axis: Axes, result: xr.Dataset, values: np.ndarray, **look: Any) -> Any:
    at = result.attrs
    extent = (at["x_low"], at["x_high"], at["y_low"], at["y_high"])
    return axis.imshow(values, origin="lower", extent=extent, aspect="auto", interpolation="nearest", **look)


def _hatches(axis: Axes, result: xr.Dataset, outcome: np.ndarray, looks: dict[int, tuple[str, str]]) -> None:
    """The hatch of each outcome, on as many points as a print shows: its edge is drawn between the points."""
    at = result.attrs
    rows, columns = (((np.arange(_HATCHED) + 0.5) / _HATCHED * n).astype(int) for n in outcome.shape)
    shown = outcome[np.ix_(rows, columns)]
    edges = [
        np.linspace(at[f"{k}_low"], at[f"{k}_high"], 2 * n + 1)[1::2] for k, n in zip("xy", shown.shape[::-1], strict=True)
    ]
    ends = [np.concatenate([[at[f"{k}_low"]], e, [at[f"{k}_high"]]]) for k, e in zip("xy", edges, strict=True)]
    for k, (_, hatch) in looks.items():
        if hatch:
            inside = np.pad((shown == k).astype(float), 1, mode="edge")
            drawn = axis.contourf(*ends, inside, levels=[0.5, 1.5], colors=["none"], hatches=[hatch])
            drawn.set_edgecolor(_edge(looks[k][0]))
            drawn.set_linewidth(0.0)


def _edge(colour: str) -> str:
    """Of a hatch, which is seen on its colour."""
    return "#FFFFFF" if colour in _DARK else GREY


_DARK = {"#C24E00", "#9A5B84", "#0072B2", "#009E73", "#404040", "#7F7F7F", "#6B1F00", "#000000"}


def _values(axis: Axes, result: xr.Dataset, name: str) -> None:
    """A map of numbers with its scale; blank where there is none."""
    from matplotlib import colormaps

    scale, unit = printed_unit(result, name)
    values = scale * result[name].values
    seen = values[np.isfinite(values)]
    axis.set_facecolor(_BLANK)
    image = _image(axis, result, np.ma.masked_invalid(values), cmap=colormaps[_SCALE], vmin=seen.min(), vmax=seen.max())
    colour_bar(axis, image, unit)
    axis.set_title(str(result[name].long_name) + (" (grey: not settled)" if len(seen) < values.size else ""))


def _frame(axis: Axes, result: xr.Dataset) -> None:
    axis.grid(visible=False)
    at, dimensions = result.attrs, dict(zip("yx", map(str, result.outcome.dims), strict=True))
    for k in "xy":
        scale = result[dimensions[k]]
        low, high, unit = at[f"{k}_low"], at[f"{k}_high"], str(scale.attrs["units"])
        shown = named(str(at[f"{k}_axis"]), str(scale.attrs["long_name"]))
        getattr(axis, f"set_{k}label")(with_unit(shown, unit))
        if at[f"{k}_is_angle"] and (ticks := multiples_of_pi(low, high)):
            getattr(axis, f"set_{k}ticks")([t for t, _ in ticks], [word for _, word in ticks])


def multiples_of_pi(low: float, high: float) -> list[tuple[float, str]]:
    """The ticks of an angle and what they are called; none where fewer than two of them lie in the range."""
    ticks: list[tuple[float, str]] = []
    for parts in _PARTS_OF_PI:
        step, little = math.pi / parts, 1e-3 * (high - low)
        numbers = range(math.ceil((low - little) / step), math.floor((high + little) / step) + 1)
        ticks = [(n * step, _word(n, parts)) for n in numbers]
        if len(ticks) <= _MOST_TICKS:
            break
    return ticks if 2 <= len(ticks) <= 2 * _MOST_TICKS else []


def _word(n: int, parts: int) -> str:
    """``3π/4``."""
    common = math.gcd(n, parts)
    n, parts = n // common, parts // common
    if n == 0:
        return "0"
    head = {1: "π", -1: "-π"}.get(n, f"{n}π")
    return head if parts == 1 else f"{head}/{parts}"
