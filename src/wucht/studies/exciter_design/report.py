"""The report of a design."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING, Any

from wucht.results.attributes import text_in
from wucht.results.formatting import formats, report_lines

if TYPE_CHECKING:
    import xarray as xr

_HOUR = 3600.0


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a design."""
    s, dimensionless, length = result.wucht.summary, bool(result.attrs["dimensionless"]), formats(result)[1]

    def size(amplitude: float) -> str:
        return length(amplitude) if s["unit"] == "m" else f"{amplitude:.4g} {s['unit']}".rstrip()

    target, motions = s["target"], ", ".join(f"{n} {name}" for name, n in s["motions"].items() if n)
    lines = [
        ("signal", text_in(result, "signal")),
        (
            "target",
            f"{target['cycles']:.4g} cycles, amplitudes {size(target['ratio'] * target['upper'])} to {size(target['upper'])}",
        ),
        ("search", f"{s['candidates']} candidates with the averaged equations: {motions}"),
    ]
    if s["reach"] is not None and s["reach"]["upper"] is not None:
        r = s["reach"]
        lines.append((
            "reach",
            f"{100 * r['modulated']:.0f} % of the points beat; largest amplitudes {size(r['upper'][0])} to "
            f"{size(r['upper'][1])}, the smallest {r['ratio'][0]:.2f} to {r['ratio'][1]:.2f} of it",
        ))  # fmt: skip
    if s["distance"] is not None:
        for k, (name, value) in enumerate(s["parameters"].items()):
            lines.append(("design" if not k else "", f"{name} = {value:.5g} {s['variables'][name]['unit']}".rstrip()))
        lines += _design_lines(s, size, dimensionless)
    return report_lines(result, s["sentence"], lines)


def _design_lines(s: dict[str, Any], size: Callable[[float], str], dimensionless: bool) -> list[tuple[str, str]]:
    time, full, slow = "" if dimensionless else " s", s["distances"]["full"], s["distances"]["slow"]
    hours = "" if dimensionless else f" ({s['duration'] / _HOUR:.4g} h)"
    beat = f"{s['beat']:.4g}{time}, {s['cycles_per_beat']:.3g} cycles"
    lines = [
        ("beat", f"{beat}; all cycles of the target take {s['duration']:.4g}{time}{hours}"),
        (
            "amplitudes",
            f"mean deviation {100 * full['amplitude']:.2f} % of the largest "
            f"(averaged equations {100 * slow['amplitude']:.2f} %)",
        ),
        (
            "counts",
            f"largest deviation {100 * full['cumulative']:.2f} % of all cycles "
            f"(averaged equations {100 * slow['cumulative']:.2f} %)",
        ),
        ("largest", f"{size(s['upper'])}; {s['beyond']:.3g} cycles of the target are larger"),
        (
            "damage",
            f"{s['damage_ratio']:.3f} times that of the target; off by up to {100 * full['damage']:.2f} % of it, "
            "counted from above",
        ),
    ]
    lines += _comparison_lines(s)
    t = s["tolerances"]
    if t is not None:
        middle, worst = ("none" if t[q] is None else f"{100 * t[q]:.2f} %" for q in ("median", "q95"))
        lines.append(
            (
                "tolerances",
                f"within {100 * t['spread']:.1f} % {100 * t['modulated']:.0f} % beat; "
                f"median distance {middle}, 95 % quantile {worst}",
            )
        )
    return lines


def _comparison_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the line on what the design was compared with over the same beats."""
    words = {"as it is": "as it is", "neighbour": "neighbours", "other": "others"}
    texts = list[str]()
    for what, name in words.items():
        rows = [r for r in s.get("compared", []) if r["what"] == what]
        percents = [100 * r["distance"] for r in rows if r["distance"] is not None]
        if rows:
            ends = " to ".join(dict.fromkeys(f"{x:.2f}" for x in (min(percents), max(percents)))) if percents else ""
            texts.append(f"{name} {ends} %" if percents else f"{name} none that beats")
    first = f"over the same beats, not counted before: design {100 * s['distance']:.2f} %"
    return [("compared", ", ".join([first, *texts]))] if texts else []
