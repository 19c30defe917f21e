"""The report of a search for the best balancer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.results.formatting import bodies_in_words, formats, in_lines, percent

if TYPE_CHECKING:
    import xarray as xr

_WORDS = {
    "settling-time": "min settling",
    "residual": "min residual",
    "peak": "min peak",
    "capture-probability": "min capture",
}


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a search."""
    s = result.wucht.summary
    own = s["as_it_is"]
    ends = " to ".join(dict.fromkeys(f"{u:.4g}" for u in s["unbalance"]))
    runs = f"{s['samples']} runs each from random phases, unbalance {ends} {s['units']['residual']}"
    lines = [
        ("searched", f"{s['candidates']} candidates, {runs}; {_equations(s)}"),
        ("as it is", f"{_design(own, s)}: {_worth(own, s, result)}"),
    ]
    told: set[int] = set()
    for objective in s["objectives"]:
        best = _best(s, objective)
        if best is not None and best not in told:
            told.add(best)
            point = s["front"][best]
            worth = f"{_worth(point, s, result)}{_gain(point, own, s)}"
            lines.append((_WORDS[objective], f"{_design(point, s)}: {worth}"))
    if s["damping"] is not None and s["damping"]["optimum"] is not None:
        lines.append(("damping", _damping(s["damping"])))
    lines.append(("integrated", s["integration"]))
    return in_lines(result, s["sentence"], lines)


def _damping(d: dict[str, Any]) -> str:
    least, greatest = d["range"]
    where = f"{d['optimum']:.3g} {d['unit']} settles fastest from random phases"
    where += "" if d["as_many"] else ", of those with the fewest captured runs"
    if d["optimum"] in (least, greatest):
        where += f", the {'lowest' if d['optimum'] == least else 'highest'} of the curve"
    return where if d["of_rates"] is None else f"{where}; small deviations decay fastest with {d['of_rates']:.3g} {d['unit']}"


def _equations(s: dict[str, Any]) -> str:
    return "evaluated with the averaged equations" if s["model"] == "slow" else "evaluated with the full equations"


def _known(point: dict[str, Any]) -> dict[str, Any]:
    """Return the objectives by the full equations where they are checked, else by the search."""
    numbers: dict[str, Any] = point["checked"] or point["objectives"]
    return numbers


def _best(s: dict[str, Any], objective: str) -> int | None:
    """Return the index of the point that is best in an objective, of those that hold."""
    places = [k for k, p in enumerate(s["front"]) if p["holds"] is not False and _known(p)[objective] is not None]

    def order(k: int) -> tuple[float, float]:  # of equally good points, that with the lower capture probability
        known = _known(s["front"][k])
        return known[objective], known["capture-probability"] or 0.0

    return min(places, key=order, default=None)


def _design(point: dict[str, Any], s: dict[str, Any]) -> str:
    values = [f"{name} {x:.3g} {s['variables'][name]['unit']}".rstrip() for name, x in point["parameters"].items()]
    count = point["bodies"]
    return f"{bodies_in_words(count)}, {', '.join(values)}"


def _worth(point: dict[str, Any], s: dict[str, Any], result: xr.Dataset) -> str:
    length, numbers = formats(result)[1], _known(point)
    open_ = point["checked_undecided"] if point["checked"] else point["undecided"]
    least = "at least " if open_ else ""
    shown = {
        "settling-time": lambda x: f"median settling time {least}{x:.3g} {s['units']['settling-time']}",
        "residual": lambda x: f"{x:.3g} {s['units']['residual']} residual unbalance",
        "peak": lambda x: f"peak {length(x)}",
        "capture-probability": lambda x: f"{_captured(x, open_)} captured",
    }
    return ", ".join(shown[o](numbers[o]) for o in s["objectives"] if numbers[o] is not None) or "no objective is known"


def _captured(most: float, undecided: float) -> str:
    if not undecided:
        return percent(most)
    return f"{percent(max(most - undecided, 0.0))} to {percent(most)} (the rest without a verdict)"


def _gain(point: dict[str, Any], own: dict[str, Any], s: dict[str, Any]) -> str:
    """Return the relative changes from the machine as it is."""
    ours, before, words = _known(point), own["checked"] or own["objectives"], []
    for o, noun in (("settling-time", "time"), ("residual", "residual unbalance"), ("peak", "peak")):
        if o in s["objectives"] and ours[o] is not None and before[o]:
            change = ours[o] / before[o] - 1
            words += [f"{noun} {'-' if change < 0 else '+'}{100 * abs(change):.0f} %"] if abs(change) >= 0.005 else []
    if "residual" in s["objectives"] and before["residual"] == 0 and ours["residual"]:
        words.append("residual unbalance where there was none")
    return f" ({', '.join(words)})" if words else ""
