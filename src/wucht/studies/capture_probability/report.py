"""A probability over a parameter in words."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import in_lines, percent

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a probability."""
    s = result.wucht.summary
    lines = [("random" if not k else "", f"{name} {words}") for k, (name, words) in enumerate(s["random"].items())]
    for k, one in enumerate(p for p in s["probability"] if p is not None):
        value = f"{s['along']} = {one[s['along']]:.5g}" + (f" {s['unit']}" if s["unit"] else "")
        lines.append(("" if k else "probability", f"{value}: {_share(one)}"))
    searched = f", {s['searched']} of them for the search" if s["searched"] else ""
    lines.append(("runs", f"{s['runs']}: {s['samples']} at each of {len(s['probability'])} values{searched}"))
    lines += _sensitivity(s)
    lines.append(("integrated", s["integration"]))
    return in_lines(result, s["sentence"] or "nothing is computed yet", lines)


def _share(one: dict[str, Any]) -> str:
    estimate = "not known" if one["estimate"] is None else f"{100 * one['estimate']:.3g} %"
    unknown = f", {percent(one['not_identified'])} without a verdict" if one["not_identified"] else ""
    return f"{estimate} ({100 * one['low']:.3g} to {100 * one['high']:.3g} %){unknown}"


def _sensitivity(s: dict[str, Any]) -> list[tuple[str, str]]:
    asked = s["sensitivity"]
    if asked is None:
        return []
    at = f"at {s['along']} = {asked['at']:.5g}" + (f" {s['unit']}" if s["unit"] else "")
    if asked["indices"] is None:
        return [("sensitivity", f"{at} nothing matters: all runs end alike")]
    order = sorted(asked["indices"].items(), key=lambda one: -one[1]["total"])
    lines = [("sensitivity", f"{at}, share of the variance of the outcome, alone and with the others ({asked['runs']} runs)")]
    for name, i in order:
        alone, together = (f"{i[key]:.2f} ± {i[f'{key}_off']:.2f}" for key in ("first_order", "total"))
        lines.append(("", f"{name}: {alone} alone, {together} with the others"))
    return lines
