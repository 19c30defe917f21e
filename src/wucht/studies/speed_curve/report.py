"""A speed curve in words."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import TYPE_CHECKING, Any

from wucht.results.formatting import formats

if TYPE_CHECKING:
    import xarray as xr

_MOST = 16  # special points, and branches, named one by one
_WORDS = {
    "hopf": ("Hopf point", "Hopf points"),
    "branch-point": ("branch point", "branch points"),
    "generalised-hopf": ("generalised Hopf point", "generalised Hopf points"),
    "double-hopf": ("double Hopf point", "double Hopf points"),
    "zero-hopf": ("zero-Hopf point", "zero-Hopf points"),
    "bogdanov-takens": ("Bogdanov-Takens point", "Bogdanov-Takens points"),
    "unresolved": ("change that was not resolved", "changes that were not resolved"),
    "some-stable": ("limit of some stable members", "limits of some stable members"),
    "all-stable": ("limit of all members stable", "limits of all members stable"),
}
_BESIDE = {
    "some-stable": "on one side some members of the family are stable, on the other none",
    "all-stable": "on one side all members of the family are stable, on the other not all",
    "unresolved": "something changes here that is no simple fold, Hopf or branch point, or several lie too close together",
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
    s = result.wucht.summary
    lines = [result.attrs["title"], f"verdict: {s['sentence']}", *_of_branches(result, s), *_of_points(result, s)]
    complete = "yes" if s["complete"] else "not shown"
    count = counted(len(s["searched"]), "value", "values")
    if s["searched"]:
        shown = f"{s['shown']}; what lies between these alone may be missing"
        lines.append(f"  complete     {complete} at {count} of {s['along']}: {shown}")
    if s["inertia"] is not None:
        lines += [
            "  stability    in the averaged equations; study.kind = 'synchronous-states' has that in the full ones",
            "  left out     motions in which bodies turn at different mean speeds, or in which the speed beats; of these "
            "study.kind = 'orbit-branch' has the beating ones",
        ]
    return lines


def _of_branches(result: xr.Dataset, s: dict[str, Any]) -> list[str]:
    (speed, _), along, unit = _formats(result), s["along"], f" {s['along_unit']}".rstrip()

    def stretches(branch: dict[str, Any], word: str) -> str:
        """Of one kind of stability, with what is drawn at the ends."""
        both = zip(branch[f"{word}stable"], branch[f"{word}stable_speeds"], strict=True)
        return " and ".join(f"{x:.5g} to {y:.5g}{unit} ({speed(a)} to {speed(b)})" for (x, y), (a, b) in both)

    lines = []
    for k, branch in enumerate(s["branches"][:_MOST]):
        second = (
            f" at {s['second']} = {branch['second_value']:.6g} {s['second_unit']}".rstrip() if "second_value" in branch else ""
        )
        of, stable, partly = branch["family_dimension"], stretches(branch, ""), stretches(branch, "partly_")
        verdict = f"stable at {along} from {stable}" if stable else "nowhere stable"
        if of and stable:
            verdict = f"all members stable at {along} from {stable}"
        elif of and partly:
            verdict = "nowhere all members stable"
        shares = " and ".join(f"{100 * a:.1f} to {100 * b:.1f} %" for a, b in branch["partly_stable_shares"])
        verdict += f"; some members stable and others not from {partly}, {shares} of them" if partly else ""
        (low, high), label = branch["range"], f"{branch['label']}{f' (family of dimension {of})' if of else ''}{second}"
        lines.append(f"  branch {k + 1:<5} {label}, from {low:.5g} to {high:.5g}{unit}: {verdict}")
        lines += [f"               its end: {end}" for end in dict.fromkeys(branch["ends"]) if end not in _PLAIN]
    return lines + ([f"  and {len(s['branches']) - _MOST} more branches"] if len(s["branches"]) > _MOST else [])


def _of_points(result: xr.Dataset, s: dict[str, Any]) -> list[str]:
    """Special points, those of curves in two parameters, and the states at the subject's own value."""
    speed, amplitude = _formats(result)
    lines, along, unit = [], s["along"], f" {s['along_unit']}".rstrip()
    of_second, shown = f" {s['second_unit'] or ''}".rstrip(), "speed " if s["show"] is None else f"{s['show']} = "
    for p in s["special_points"][:_MOST]:
        second = f", {s['second']} = {p['second_value']:.6g}{of_second}" if "second_value" in p else ""
        at = f"{along} = {p['value']:.7g}{unit}{second}"
        beside = "" if p["frequency"] is None else f", oscillation with {p['frequency']:.5g} {_frequency(result)}".rstrip()
        beside += f"; {_BESIDE[p['kind']]}" if p["kind"] in _BESIDE else ""
        lines.append(f"  {p['kind']:12} {at}: {shown}{speed(p['speed'])}{amplitude(p['amplitude'])}{beside}")
    rest = len(s["special_points"]) - _MOST
    lines += [f"  and {rest} more special points: see the Dataset"] if rest > 0 else []
    for c in s["curves"]:
        (low, high), (least, most) = c["range"], c["second_range"]
        where = f"{along} from {low:.5g} to {high:.5g}{unit}, {s['second']} from {least:.5g} to {most:.5g}{of_second}"
        lines.append(f"  curve of {_CURVES[c['of']]}{', ' if c['name'] else ''}{c['name'] or ''}: {where}")
        for p in c["special_points"]:
            lines.append(
                f"    {p['kind']:16} {along} = {p['value']:.7g}{unit}, {s['second']} = {p['second_value']:.7g}{of_second}"
            )
    for state in s["states"]:
        word, value = "stable" if state["stable"] else "unstable", f"at {along} = {s['value']:.6g}{unit}"
        if not state["stable"] and state["stable_share"]:
            word = "partly"
        of = f"; {100 * state['stable_share']:.1f} % of the family's members are stable" if word == "partly" else ""
        drawn = f"{shown}{speed(state['speed'])}{amplitude(state['amplitude'])}"
        lines.append(f"  {word:12} {value}: {state['name'] or 'steady'}, {drawn}{of}")
    return lines


def _formats(result: xr.Dataset) -> tuple[Callable[[float], str], Callable[[float | None], str]]:
    """How what is drawn and the amplitude are written, the latter after a comma, if there is one."""
    speed, length = formats(result, str(result.amplitude.attrs["units"]))
    if result.wucht.summary["show"] is not None:
        unit = str(result.speed.attrs["units"])
        return lambda x: f"{x:.6g} {unit}".rstrip(), lambda a: "" if a is None else f", amplitude {length(a)}"
    return speed, lambda a: "" if a is None else f", amplitude {length(a)}"


def _frequency(result: xr.Dataset) -> str:
    return str(result.special_frequency.attrs["units"])
