"""The figure of a map of basins: its outcomes, the settling time and the peak amplitude."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.scales import multiples_of_pi
from wucht.plots.sheet import colour_bar, legend_beside, new_grid
from wucht.plots.stability_lines import draw_region, field
from wucht.plots.style import GREY
from wucht.results.attributes import number_in
from wucht.results.formatting import parameter_in_words, percent, printed_unit, with_unit

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

# Colour and hatch of each outcome (Okabe and Ito's colours, lightened or darkened so that frequent neighbours differ in grey
# too).
_LOOKS = {
    "compensated": ("#5FAEDF", "//"), "passed": ("#D9EFC9", ".."), "captured": ("#F5C04A", ""),
    "captured-modulated": ("#C24E00", "\\\\"), "balancer-captured": ("#9A5B84", "xx"), "entrained": ("#0072B2", "//"),
    "not-entrained": ("#F0E3B0", "--"), "synchronised": ("#009E73", "\\|"), "not-synchronised": ("#E8CFDD", "||"),
    "not-started": ("#A0A0A0", "oo"),
    "stopped": ("#404040", ""), "oscillating": ("#7F7F7F", "++"), "runaway": ("#6B1F00", "oo"),
    "unidentified": ("#FFFFFF", "xxx"), "failed": ("#000000", ".."),
}  # fmt: skip
_DARK = {"#C24E00", "#9A5B84", "#0072B2", "#009E73", "#404040", "#7F7F7F", "#6B1F00", "#000000"}
_NOT_COMPUTED, _BLANK = "not computed", "#EFEFEF"
_HATCH_POINTS = 512  # points per side
_SCALE = "viridis"


def figure(result: xr.Dataset) -> Figure:
    """Draw three maps over both axes from the Dataset alone; the refined map if the borders are refined."""
    prefix = "refined_" if "refined_outcome" in result else ""
    s = result.wucht.summary
    below = f"{' x '.join(map(str, s['levels'][-1]['cells']))} cells, {s['runs']} runs"
    maps = [name for name in (f"{prefix}settling_time", f"{prefix}peak_amplitude") if np.isfinite(result[name].values).any()]
    fig, (outcomes, *axes) = new_grid(1 + len(maps), result.attrs["title"], below, heights=(3.2, 2.2), wide=1)
    handles = _outcomes(outcomes, result, prefix)
    for axis, name in zip(axes, maps, strict=True):
        _values(axis, result, name)
    for axis in (outcomes, *axes):
        _frame(axis, result)
    legend_beside(outcomes, handles)
    return fig


def _outcomes(axis: Axes, result: xr.Dataset, prefix: str) -> list[Any]:
    """Draw the map of outcomes; return legend entries with the share of each outcome."""
    from matplotlib.colors import ListedColormap

    s, variable = result.wucht.summary, result[f"{prefix}outcome"]
    fractions, off = s["fractions"], s["uncertainty"]
    flags = dict(zip(np.asarray(variable.flag_values).tolist(), str(variable.flag_meanings).split(), strict=True))
    present = [k for k in flags if (variable.values == k).any()]
    looks = {k: _LOOKS.get(flags[k], (_BLANK, "")) for k in present}
    tones = ListedColormap([colour for colour, _ in looks.values()])
    places = np.searchsorted(present, variable.values).astype(np.int8)
    _image(axis, result, places, cmap=tones, vmin=-0.5, vmax=len(present) - 0.5)
    _hatches(axis, result, variable.values, looks)
    words = {k: _NOT_COMPUTED if k < 0 else f"{flags[k]}: {percent(fractions[flags[k]], off[flags[k]])}" for k in present}
    axis.set_title("outcome and share of the map")
    order = sorted(present, key=lambda k: -fractions.get(flags[k], -1.0))
    return [field(words[k], *looks[k], edge=_edge(looks[k][0]) if looks[k][1] else GREY) for k in order]


def _image(axis: Axes, result: xr.Dataset, values: np.ndarray, **look: Any) -> Any:
    extent = (*_ends(result, "x"), *_ends(result, "y"))
    # Colours are computed for the pixels of the picture: those of a million cells would take a hundred megabytes.
    look |= {"interpolation": "nearest", "interpolation_stage": "data"}
    return axis.imshow(values, origin="lower", extent=extent, aspect="auto", **look)


def _hatches(axis: Axes, result: xr.Dataset, outcome: np.ndarray, looks: dict[int, tuple[str, str]]) -> None:
    """Draw the hatch of each outcome on as many points as a print can show: its edge is drawn between the points."""
    rows, columns = (((np.arange(_HATCH_POINTS) + 0.5) / _HATCH_POINTS * n).astype(int) for n in outcome.shape)
    outcome_samples = outcome[np.ix_(rows, columns)]
    share = np.r_[0.0, (np.arange(_HATCH_POINTS) + 0.5) / _HATCH_POINTS, 1.0]
    x, y = (low + share * (high - low) for low, high in (_ends(result, "x"), _ends(result, "y")))
    for k, (tone, hatch) in looks.items():
        if hatch:
            draw_region(axis, x, y, np.pad(outcome_samples == k, 1, mode="edge"), hatch, _edge(tone))


def _ends(result: xr.Dataset, axis: str) -> tuple[float, float]:
    """Return the ends of an axis of the map."""
    return number_in(result, f"{axis}_low"), number_in(result, f"{axis}_high")


def _edge(colour: str) -> str:
    """Colour of a hatch that is visible on a tone."""
    return "#FFFFFF" if colour in _DARK else GREY


def _values(axis: Axes, result: xr.Dataset, name: str) -> None:
    """Draw a map of numbers with its scale; blank where numbers are missing."""
    scale, unit = printed_unit(result, name)
    values = np.ma.masked_invalid(scale * result[name].values, copy=False)
    axis.set_facecolor(_BLANK)
    image = _image(axis, result, values, cmap=_SCALE, vmin=values.min(), vmax=values.max())
    colour_bar(axis, image, unit)
    axis.set_title(str(result[name].long_name) + (" (grey: not settled)" if values.mask.any() else ""))


def _frame(axis: Axes, result: xr.Dataset) -> None:
    axis.grid(visible=False)
    at, dimensions = result.attrs, dict(zip("yx", map(str, result.outcome.dims), strict=True))
    for k in "xy":
        scale = result[dimensions[k]]
        name = with_unit(parameter_in_words(str(at[f"{k}_axis"]), str(scale.attrs["long_name"])), str(scale.attrs["units"]))
        axis.set(**{f"{k}label": name})
        if at[f"{k}_is_angle"] and (ticks := multiples_of_pi(at[f"{k}_low"], at[f"{k}_high"])):
            getattr(axis, f"set_{k}ticks")([t for t, _ in ticks], [word for _, word in ticks])
