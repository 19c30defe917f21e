"""The figure of a map of basins: its outcomes, with the attractors of equations in them, settling time and peak amplitude."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.limit_set_curves import draw_limit_set
from wucht.plots.scales import multiples_of_pi
from wucht.plots.sheet import colour_bar, legend_beside, new_grid, write_counts
from wucht.plots.stability_lines import draw_region, entry, field
from wucht.plots.style import GREY
from wucht.results.attributes import number_in, text_in
from wucht.results.formatting import parameter_in_words, percent, printed_unit, with_unit
from wucht.results.report import answer_in_print

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
    "unsettled": ("#FFFFFF", "xxx"), "diverges": ("#404040", ""), "neutral": ("#8C8C8C", "++"),
}  # fmt: skip
_TONES = ("#5FAEDF", "#F5C04A", "#D9EFC9", "#E8A0BF", "#B9A7DA", "#F0E3B0", "#9CCFC0", "#C7C7C7")  # of attractors
_DARK = {"#C24E00", "#9A5B84", "#0072B2", "#009E73", "#404040", "#7F7F7F", "#6B1F00", "#000000"}
_NOT_COMPUTED, _BLANK = "not computed", "#EFEFEF"
_SADDLES: dict[str, tuple[str, dict[str, Any]]] = {  # of each kind: its name, and how it is drawn
    "equilibrium": ("saddle", {"linestyle": "", "marker": "x", "markersize": 6.5, "markeredgewidth": 2.0}),
    "periodic": ("saddle orbit", {"linestyle": "--"}),
}
_HATCH_POINTS = 512  # points per side
_SCALE = "viridis"


def figure(result: xr.Dataset) -> Figure:
    """Draw the maps over both axes from the Dataset alone; the refined ones if the borders are refined."""
    prefix = "refined_" if "refined_outcome" in result else ""
    rows, columns = result[f"{prefix}outcome"].shape
    readings = [name for name in (f"{prefix}settling_time", f"{prefix}peak_amplitude") if name in result]
    maps = [name for name in readings if np.isfinite(result[name].values).any()]
    fig, (outcomes, *axes) = new_grid(1 + len(maps), result.attrs["title"], answer_in_print(result), heights=(3.2, 2.2), wide=1)
    write_counts(fig, f"{columns} x {rows} cells, {result.wucht.summary['runs']} runs")
    handles = _outcomes(outcomes, result, prefix)
    if "attractor_states" in result:
        handles += _attractors(outcomes, result)
    for axis, name in zip(axes, maps, strict=True):
        _values(axis, result, name)
    for axis in (outcomes, *axes):
        _frame(axis, result)
    legend_beside(outcomes, handles)
    return fig


def _outcomes(axis: Axes, result: xr.Dataset, prefix: str) -> list[Any]:
    """Draw the map of outcomes; return legend entries with the share of each outcome."""
    from matplotlib.colors import ListedColormap

    fractions, variable = result.wucht.summary["fractions"], result[f"{prefix}outcome"]
    names = dict(zip(np.asarray(variable.flag_values).tolist(), str(variable.flag_meanings).split(), strict=True))
    present = np.unique(variable.values).tolist()
    looks = {k: _look(k, names[k], "attractor_states" in result) for k in present}
    tones = ListedColormap([colour for colour, _ in looks.values()])
    places = np.searchsorted(present, variable.values).astype(np.int8)
    _image(axis, result, places, cmap=tones, vmin=-0.5, vmax=len(present) - 0.5)
    _hatches(axis, result, variable.values, looks)
    axis.set_title("outcome and share of the map")
    order = sorted(present, key=lambda k: -fractions.get(names[k], -1.0))
    words = {k: _share_text(result, names[k]) for k in present}
    return [field(words[k], *looks[k], edge=_edge(looks[k][0]) if looks[k][1] else GREY) for k in order]


def _look(number: int, name: str, has_attractors: bool) -> tuple[str, str]:
    """Return colour and hatch of an outcome."""
    of_attractor = (_TONES[number % len(_TONES)], "") if has_attractors else (_BLANK, "")
    return _LOOKS.get(name, of_attractor)


def _share_text(result: xr.Dataset, name: str) -> str:
    """Return an outcome with its share; what only a set without area leads to has a share of the starts only."""
    s = result.wucht.summary
    if name not in s["fractions"]:
        return _NOT_COMPUTED
    if name in _saddle_kinds(result):
        return f"{name}: {percent(s['fractions'][name])} of the starts"
    return f"{name}: {percent(s['fractions'][name], s['uncertainty'][name])}"


def _saddle_kinds(result: xr.Dataset) -> dict[str, str]:
    """Return the kind of each unstable equilibrium and orbit, by its label."""
    return {one["label"]: one["kind"] for one in result.wucht.summary.get("attractors", ()) if one["stable"] is False}


def _attractors(axis: Axes, result: xr.Dataset) -> list[Any]:
    """Draw the attractors, and what is unstable otherwise: an equilibrium as a cross, an orbit dashed. Returns entries."""
    names, kinds = [str(n) for n in result.state.values], {a["label"]: a["kind"] for a in result.wucht.summary["attractors"]}
    rows, saddles = [names.index(text_in(result, f"{k}_axis")) for k in "xy"], _saddle_kinds(result)
    turning = np.array([number_in(result, f"{k}_is_angle") for k in "xy"]) > 0
    (x_low, x_high), (y_low, y_high) = (_ends(result, k) for k in "xy")
    for samples, name in zip(result.attractor_states.values, result.attractor.values.astype(str), strict=True):
        look = _SADDLES[saddles[name]][1] if name in saddles else {}
        draw_limit_set(axis, samples[rows], turning, kinds[name], (x_low, y_low), color="black", **look)
    axis.set(xlim=(x_low, x_high), ylim=(y_low, y_high))
    attracting = (
        [entry("attractors", color="black", linestyle="", marker="o", markersize=3)] if len(kinds) > len(saddles) else []
    )
    looks = [_SADDLES[kind] for kind in dict.fromkeys(saddles.values())]
    return attracting + [entry(f"{name}, reached from a set without area", color="black", **look) for name, look in looks]


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
