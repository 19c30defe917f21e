"""A speed curve in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from wucht.results.conventions import summary_of
from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr

_MOST = 16  # special points, and branches, named one by one
_WORDS = {
    "hopf": ("Hopf point", "Hopf points"),
    "branch-point": ("branch point", "branch points"),
    "generalised-hopf": ("generalised Hopf point", "generalised Hopf points"),
}
_CURVES = {"fold": "folds", "hopf": "Hopf points"}
_PLAIN = ("the range ends", "it is closed")


def label_of(name: str | None, type_: str | None, split: tuple[int, int] | None) -> str:
    """What states of a branch are called in a legend: ``type II, together``, ``opposed 3 : 1``."""
    if name is None:
        return "steady states"
    apart = f" {split[0]} : {split[1]}" if split is not None and name == "opposed" and sum(split) > 2 else ""
    return f"type {type_}: {name}" if type_ else f"{name}{apart}"


def counted(number: int, one: str, several: str) -> str:
    """``one fold``, ``3 folds``."""
    return f"one {one}" if number == 1 else f"{number} {several}"


def in_words(kinds: Sequence[str]) -> str:
    """``2 folds, one Hopf point``; empty where there is none."""
    return ", ".join(
        counted(kinds.count(kind), *_WORDS.get(kind, (kind.replace("-", " "), f"{kind.replace('-', ' ')}s")))
        for kind in dict.fromkeys(kinds)
    )


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a speed curve."""
    s = summary_of(result)
    lines = [result.attrs["title"], f"verdict: {s['sentence']}", *_of_branches(s), *_of_points(result, s)]
    complete = "yes" if s["complete"] else "not shown"
    count = counted(len(s["searched"]), "value", "values")
    lines.append(
        f"  complete     {complete} at {count} of {s['along']}: {s['shown']}; what lies between these alone may be missing"
    )
    if s["inertia"] is not None:
        lines.append("  stability    in the averaged equations; study.kind = 'synchronous-states' has that in the full ones")
    return lines


def _of_branches(s: dict[str, Any]) -> list[str]:
    lines, along = [], s["along"]
    for k, branch in enumerate(s["branches"][:_MOST]):
        second = f" at {s['second']} = {branch[s['second']]:.6g}" if s["second"] in branch else ""
        stable = ", ".join(f"{low:.5g} to {high:.5g}" for low, high in branch["stable"])
        verdict = f"stable at {along} from {stable}" if stable else "nowhere stable"
        family = f" (family of dimension {branch['family_dimension']})" if branch["family_dimension"] else ""
        (low, high), label = branch["range"], f"{k + 1}  {branch['label']}{family}{second}"
        lines.append(f"  branch {label}, from {low:.5g} to {high:.5g}: {verdict}")
        lines += [f"               its end: {end}" for end in dict.fromkeys(branch["ends"]) if end not in _PLAIN]
    return lines + ([f"  and {len(s['branches']) - _MOST} more branches"] if len(s["branches"]) > _MOST else [])


def _of_points(result: xr.Dataset, s: dict[str, Any]) -> list[str]:
    """Special points, those of curves in two parameters, and the states at the subject's own value."""
    speed, amplitude = _formats(result)
    lines, along, unit = [], s["along"], f" {s['along_unit']}".rstrip()
    for p in s["special_points"][:_MOST]:
        second = f", {s['second']} = {p[s['second']]:.6g}" if s["second"] in p else ""
        at = f"{along} = {p[along]:.7g}{unit}{second}"
        beside = "" if p["frequency"] is None else f", oscillation with {p['frequency']:.5g} {_frequency(result)}".rstrip()
        lines.append(f"  {p['kind']:12} {at}: {speed(p['speed'])}{amplitude(p['amplitude'])}{beside}")
    rest = len(s["special_points"]) - _MOST
    lines += [f"  and {rest} more special points: see the Dataset"] if rest > 0 else []
    for c in s["curves"]:
        (low, high), (least, most) = c["range"], c["second_range"]
        where = f"{along} from {low:.5g} to {high:.5g}, {s['second']} from {least:.5g} to {most:.5g}"
        lines.append(f"  curve of {_CURVES[c['of']]}{', ' if c['name'] else ''}{c['name'] or ''}: {where}")
        for p in c["special_points"]:
            lines.append(f"    {p['kind']:16} {along} = {p[along]:.7g}{unit}, {s['second']} = {p[s['second']]:.7g}")
    for state in s["states"]:
        word, value = "stable" if state["stable"] else "unstable", f"at {along} = {s['value']:.6g}{unit}"
        lines.append(
            f"  {word:12} {value}: {state['name'] or 'steady'}, {speed(state['speed'])}{amplitude(state['amplitude'])}"
        )
    return lines


def _formats(result: xr.Dataset) -> tuple[Callable[[float], str], Callable[[float | None], str]]:
    """How what is drawn and the amplitude are written, the latter after a comma, if there is one."""
    speed, length = formats(result, str(result.amplitude.attrs["units"]))
    if result.attrs["shown"] != "speed of the main rotor":
        unit = str(result.speed.attrs["units"])
        return lambda x: f"{x:.6g} {unit}".rstrip(), lambda a: "" if a is None else f", amplitude {length(a)}"
    return speed, lambda a: "" if a is None else f", amplitude {length(a)}"


def _frequency(result: xr.Dataset) -> str:
    return str(result.special_frequency.attrs["units"])
