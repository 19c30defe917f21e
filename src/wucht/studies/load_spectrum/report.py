"""A load spectrum in words."""

from __future__ import annotations

from typing import TYPE_CHECKING

from wucht.results.formatting import in_lines

if TYPE_CHECKING:
    import xarray as xr

_MOST = 6
_RESIDUES = {
    "half-cycles": "what does not close counts as half cycles",
    "repeat": "the history repeats, all cycles close",
    "drop": "what does not close is left out",
}


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a load spectrum."""
    s = result.wucht.summary
    unit = f" {s['unit']}" if s["unit"] else ""
    time_unit = "" if result.attrs["dimensionless"] else " s"
    lines = [("signal", f"{result.attrs['signal']}, from {s['begin']:.6g} to {s['end']:.6g}{time_unit}")]
    if s["outcome"] is not None:
        lines.append(("machine", str(s["outcome"])))
    lines.append(("counting", f"{s['counting']}; {_RESIDUES[s['residue']]}"))
    if s["cycles"]:
        lines.append(("between", f"{s['min']:.5g} and {s['max']:.5g}{unit}"))
        shown = sorted(s["spectrum"], key=lambda row: -row["range"])
        for name, row in zip(["range"] + [""] * _MOST, shown[:_MOST], strict=False):
            lines.append((name, f"{row['range']:.5g}{unit}, mean {row['mean']:.5g}: {row['count']:.10g}"))
        if len(shown) > _MOST:
            lines.append(("", f"and {len(shown) - _MOST} smaller ones"))
    if s["damage"] is not None:
        lines.append(("damage", f"{s['damage']:.5g}"))
    if s["life"] is not None:
        hours = "" if result.attrs["dimensionless"] else f" ({s['life'] / 3600:.4g} h)"
        lines.append(("life", f"{s['repetitions']:.5g} times this, {s['life']:.5g}{time_unit}{hours}"))
    if s["cycles"]:
        c = s["convergence"]
        damage = "" if c["damage"] is None else f", the damage by {abs(c['damage']):.2%}"
        lines.append(("convergence", f"twice the first half is off by {c['spectrum']:.2%} of all cycles{damage}"))
    return in_lines(result, result.attrs["sentence"], lines)
