"""The report of a search for the best balancer."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from wucht.extending_0_1 import formats, report_lines
from wucht.results.formatting import bodies_in_words, percent

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
    baseline = s["as_it_is"]
    ends = " to ".join(dict.fromkeys(f"{u:.4g}" for u in s["unbalance"]))
    runs = f"{s['samples']} runs each from random phases, unbalance {ends} {s['units']['residual']}"
    lines = [
        ("searched", f"{s['candidates']} candidates, {runs}; {_equations(s)}"),
        ("as it is", f"{_design(baseline, s)}: {_worth(baseline, s, result)}"),
    ]
    lines += _recommendation_lines(s)
    reported_points: set[int] = set()
    for objective in s["objectives"]:
        best = _best(s, objective)
        if best is not None and best not in reported_points:
            reported_points.add(best)
            point = s["front"][best]
            worth = f"{_worth(point, s, result)}{_gain(point, baseline, s)}"
            lines.append((_WORDS[objective], f"{_design(point, s)}: {worth}"))
    if s["damping"] is not None and s["damping"]["optimum"] is not None:
        lines.append(("damping", _damping(s["damping"])))
    lines.append(("integrated", s["integration"]))
    return report_lines(result, s["sentence"], lines)


def _recommendation_lines(s: dict[str, Any]) -> list[tuple[str, str]]:
    """Return the recommended balancer, what to write for it into the file, and that the motor sets its settling time."""
    recommendation, unit = s.get("recommended"), s["units"]["settling-time"]
    if recommendation is None:
        return []
    keep = "to keep the machine as it is, " if recommendation["point"] is None else ""
    lines = [("recommended", f"{keep}{_design(recommendation, s)}: of its runs {_failing_runs(recommendation)}")]
    lines += _comparison_lines(recommendation, s.get("compared", []), unit)
    if (duel := s.get("duel")) is not None and None not in duel.values():
        times = f"{duel['settling_time']:.3g} {unit}".rstrip(), f"{duel['as_it_is']:.3g} {unit}".rstrip()
        error = f"{duel['difference_error']:.2g} {unit}".rstrip()
        text = f"in {duel['runs']} further runs the best one {times[0]}, the machine as it is {times[1]}"
        lines.append(("", f"{text}, the difference to {error}"))
    lines += _lines_to_paste(recommendation, s["as_it_is"]["bodies"])
    if recommendation["motor_sets_time"]:
        time, settling_time = (f"{recommendation[key]:.3g} {unit}".rstrip() for key in ("motor_time", "settling_time"))
        lines.append(
            ("motor", f"sets the settling time of {settling_time}, not the balancer: without vibration it needs {time}")
        )
    return lines


def _comparison_lines(recommendation: dict[str, Any], rows_of_check: list[dict[str, Any]], unit: str) -> list[tuple[str, str]]:
    """Return the line on what the recommended one was compared with, from the same starts."""
    if not rows_of_check:
        return []

    def times(rows: list[dict[str, Any]]) -> str:
        numbers = [r["settling_time"] for r in rows if r["settling_time"] is not None]
        ends = dict.fromkeys(f"{t:.3g}" for t in (min(numbers), max(numbers))) if numbers else {"none": None}
        return f"{' to '.join(ends)} {unit}".rstrip() if numbers else "none"

    spread = f"{recommendation['settling_time']:.3g} ± {recommendation['error']:.2g} {unit}".rstrip()
    text = f"settling time {spread} in {recommendation['runs']} runs of its own; from the same starts "
    groups = {"as it is": "the machine as it is", "damping curve": "the best of the damping curve"}
    groups |= {"damping alone": "that damping, which is not varied,", "neighbour": "neighbours", "other candidate": "others"}
    as_reliable = [r for r in rows_of_check if r["fails"] <= recommendation["fails"]]
    rows = {words: [r for r in as_reliable if r["what"] == what] for what, words in groups.items()}
    texts = [f"{words} {times(mine)}" for words, mine in rows.items() if mine]
    texts += [f"{len(rows_of_check) - len(as_reliable)} fail more often"] if len(as_reliable) < len(rows_of_check) else []
    return [("compared", text + ", ".join(texts))]


def _lines_to_paste(recommendation: dict[str, Any], count: int) -> list[tuple[str, str]]:
    """Return the lines of a study file that change the machine into the recommended one. count: of its bodies as it is."""
    changes, lines = recommendation["changes"], list[str]()
    if changes and recommendation["bodies"] != count:
        names = dict.fromkeys(path.partition(".")[0] for path in changes)
        lines.append(f"# with {bodies_in_words(recommendation['bodies'])}, each like the first one: {', '.join(names)}")
    lines += ["[machine.set]", *(f'"{path}" = "{value}"' for path, value in changes.items())] if changes else []
    return [("to paste" if k == 0 else "", line) for k, line in enumerate(lines)]


def _failing_runs(recommendation: dict[str, Any]) -> str:
    least, most = percent(recommendation["fails_for_certain"]), percent(recommendation["fails"])
    if not recommendation["fails"]:
        return "all end compensated"
    return f"{most if least == most else f'{least} to {most}'} do not end compensated"


def _damping(d: dict[str, Any]) -> str:
    least, greatest = d["range"]
    text = f"of the machine as it is, {d['optimum']:.3g} {d['unit']} settles fastest from random phases"
    text += "" if d["as_many"] else ", of those with the fewest captured runs"
    if d["optimum"] in (least, greatest):
        text += f", the {'lowest' if d['optimum'] == least else 'highest'} of the curve"
    return text if d["of_rates"] is None else f"{text}; small deviations decay fastest with {d['of_rates']:.3g} {d['unit']}"


def _equations(s: dict[str, Any]) -> str:
    return "evaluated with the averaged equations" if s["model"] == "slow" else "evaluated with the full equations"


def _final_objectives(point: dict[str, Any]) -> dict[str, Any]:
    """Return the objectives by the full equations where they are checked, else by the search."""
    numbers: dict[str, Any] = point["checked"] or point["objectives"]
    return numbers


def _best(s: dict[str, Any], objective: str) -> int | None:
    """Return the index of the point that is best in an objective, of those that hold; of one that balances, if any does."""
    places = [k for k, p in enumerate(s["front"]) if p["holds"] is not False and _final_objectives(p)[objective] is not None]

    def order(k: int) -> tuple[bool, float, float]:  # of equally good points, that with the lower capture probability
        objectives = _final_objectives(s["front"][k])
        does_not_balance = s["front"][k].get("balances") is False
        return does_not_balance, objectives[objective], objectives["capture-probability"] or 0.0

    return min(places, key=order, default=None)


def _design(point: dict[str, Any], s: dict[str, Any]) -> str:
    values = [f"{name} {x:.3g} {s['variables'][name]['unit']}".rstrip() for name, x in point["parameters"].items()]
    count = point["bodies"]
    return f"{bodies_in_words(count)}, {', '.join(values)}"


def _worth(point: dict[str, Any], s: dict[str, Any], result: xr.Dataset) -> str:
    length, numbers = formats(result)[1], _final_objectives(point)
    undecided_share = point["checked_undecided"] if point["checked"] else point["undecided"]
    least = "at least " if undecided_share else ""
    phrases = {
        "settling-time": lambda x: f"median settling time {least}{x:.3g} {s['units']['settling-time']}",
        "residual": lambda x: f"{x:.3g} {s['units']['residual']} residual unbalance",
        "peak": lambda x: f"peak {length(x)}",
        "capture-probability": lambda x: f"{_capture_text(x, undecided_share)} captured",
    }
    words = [phrases[o](numbers[o]) for o in s["objectives"] if numbers[o] is not None] or ["no objective is known"]
    return ", ".join([*words, *(["does not balance"] if point.get("balances") is False else [])])


def _capture_text(most: float, undecided_share: float) -> str:
    if not undecided_share:
        return percent(most)
    return f"{percent(max(most - undecided_share, 0.0))} to {percent(most)} (the rest without a verdict)"


def _gain(point: dict[str, Any], baseline: dict[str, Any], s: dict[str, Any]) -> str:
    """Return the relative changes from the machine as it is."""
    ours, before, words = _final_objectives(point), baseline["checked"] or baseline["objectives"], []
    for o, noun in (("settling-time", "time"), ("residual", "residual unbalance"), ("peak", "peak")):
        if o in s["objectives"] and ours[o] is not None and before[o]:
            change = ours[o] / before[o] - 1
            words += [f"{noun} {'-' if change < 0 else '+'}{100 * abs(change):.0f} %"] if abs(change) >= 0.005 else []
    if "residual" in s["objectives"] and before["residual"] == 0 and ours["residual"]:
        words.append("residual unbalance where there was none")
    return f" ({', '.join(words)})" if words else ""
