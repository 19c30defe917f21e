"""The answer of a phase portrait in words."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import xarray as xr


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a phase portrait."""
    s = result.wucht.summary
    lines = [result.attrs["title"]]
    if "cases" not in s:
        lines += [f"verdict: {s['sentence']}", *_of_one(s)]
    for case in s.get("cases", []):
        lines += [f"{case['label']}: {case['sentence']}", *_of_one(case)]
    if result.attrs["model"]:
        how_far = "study.kind = 'approximation' compares them with the full equations"
        lines.append(f"  equations: {result.attrs['model']}; {how_far}")
    return lines


def _of_one(s: Mapping[str, Any]) -> list[str]:
    lines = []
    for k, p in enumerate(s["fixed_points"], 1):
        at = ", ".join(f"{name} {value:.7g}" for name, value in p["state"].items())
        values = ", ".join(map(_number, p["eigenvalues"]))
        beside = f"; out of the section {', '.join(map(_number, p['transverse']))}" if p.get("transverse") else ""
        lines.append(f"  {k} {p['kind']:15} {at}; eigenvalues {values}{beside}")
    for m in s["separatrices"]:
        kind, side = "stable" if m["stable"] else "unstable", "one side" if m["side"] > 0 else "other side"
        lines.append(f"  saddle {m['saddle'] + 1}, {kind} manifold, {side}: {_where(m['to'], m['stable'])}")
    for k, c in enumerate(s["closed_curves"], 1):
        turns = ", winding around" if any(c["turns"]) else ""
        phi = f", {c['period_phi']:.7g} of the rotor's angle" if "period_phi" in c else ""
        lines.append(f"  closed curve {k}: {c['kind']}{turns}, period {c['period']:.7g}{phi}")
    lines.append(f"  fixed points: {s['shown']}")
    return lines


def _where(end: str, stable: bool) -> str:
    """Whence a stable manifold comes, and where an unstable one goes."""
    if end == "left the window":
        return "comes from beyond the window" if stable else "leaves the window"
    known = end.startswith(("stable", "unstable", "saddle", "closed", "centre", "degenerate"))
    return f"{'comes from' if stable else 'goes to'} {end}" if known else f"followed no further: {end}"


def _number(value: list[float]) -> str:
    real, imag = value
    return f"{real:.5g}" if not imag else f"{real:.5g}{imag:+.5g}i"
