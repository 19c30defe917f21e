"""The report of a speed curve, and its variables: points, branches, special points, and curves in two parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.configurations.averaged_stability import NEUTRAL
from wucht.dynamics.branches.bifurcation_diagram import BranchFindings
from wucht.dynamics.branches.equilibrium_branches import ALL_STABLE, SOME_STABLE, EquilibriumBranch
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.numerics.continuation.equilibria import HOPF
from wucht.results.formatting import formats
from wucht.results.quantities import Quantity
from wucht.studies.motion_variables import join_arrays, steady_branch_quantities
from wucht.studies.speed_curve.computation import Plan

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
    "unresolved": "this change is no simple fold, Hopf or branch point, or several lie too close together",
}
_CURVES = {"fold": "folds", "hopf": "Hopf points"}
_NO_LABEL = "steady states"
_PLAIN = ("the range ends", "it is closed")


def label_of(name: str | None, type_: str | None, split: tuple[int, int] | None) -> str:
    """Return the label of a branch's states in a legend: ``type II, together``, ``opposed 3 : 1``."""
    if name is None:
        return _NO_LABEL
    apart = f" {split[0]} : {split[1]}" if split is not None and name == "opposed" and sum(split) > 2 else ""
    return f"type {type_}: {name}" if type_ else f"{name}{apart}"


def count_phrase(number: int, one: str, several: str) -> str:
    """Return a number with its noun: ``one fold``, ``3 folds``."""
    return f"one {one}" if number == 1 else f"{number} {several}"


def kinds_phrase(kinds: Sequence[str]) -> str:
    """Return the numbers of points by kind: ``2 folds, one Hopf point``; empty without points."""
    return ", ".join(
        count_phrase(kinds.count(kind), *_WORDS.get(kind, (kind.replace("-", " "), f"{kind.replace('-', ' ')}s")))
        for kind in dict.fromkeys(kinds)
    )


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a speed curve."""
    s = result.wucht.summary
    lines = [result.attrs["title"], f"verdict: {s['sentence']}", *_branch_lines(result, s), *_point_lines(result, s)]
    complete = "yes" if s["complete"] else "not proved"
    count = count_phrase(len(s["searched"]), "value", "values")
    if s["searched"]:
        evidence = f"{s['shown']}; only branches between these values may be missing"
        lines.append(f"  complete     {complete} at {count} of {s['along']}: {evidence}")
    if s["inertia"] is not None:
        lines += [
            "  stability    in the averaged equations; study.kind = 'synchronous-states' has that in the full equations",
            "  left out     motions with bodies of different mean speeds, or with modulated speed; of these "
            "study.kind = 'orbit-branch' has the modulated ones",
        ]
    return lines


def _branch_lines(result: xr.Dataset, s: dict[str, Any]) -> list[str]:
    ordinate, along, unit = _ordinate_format(result), s["along"], f" {s['along_unit']}".rstrip()
    at_ends = "stable_speeds" if "speed" in result else f"stable_{s['show']}"

    def stretches(branch: dict[str, Any], word: str) -> str:
        """Return the ranges of one kind of stability, with the ordinates at their ends."""
        pairs = zip(branch[f"{word}stable"], branch[f"{word}{at_ends}"], strict=True)
        return " and ".join(f"{x:.5g} to {y:.5g}{unit} ({ordinate(a)} to {ordinate(b)})" for (x, y), (a, b) in pairs)

    lines = []
    for k, branch in enumerate(s["branches"][:_MOST]):
        second = (
            f" at {s['second']} = {branch['second_value']:.6g} {s['second_unit']}".rstrip() if "second_value" in branch else ""
        )
        dimension, stable = branch.get("family_dimension", 0), stretches(branch, "")
        partly = stretches(branch, "partly_") if "partly_stable" in branch else ""
        verdict = f"stable at {along} from {stable}" if stable else "nowhere stable"
        if dimension and stable:
            verdict = f"all members stable at {along} from {stable}"
        elif dimension and partly:
            verdict = "nowhere are all members stable"
        shares = " and ".join(f"{100 * a:.1f} to {100 * b:.1f} %" for a, b in branch.get("partly_stable_shares", ()))
        verdict += f"; some members stable and others not from {partly}, {shares} of them" if partly else ""
        (low, high), label = (
            branch["range"],
            f"{branch.get('label', _NO_LABEL)}{f' (family of dimension {dimension})' if dimension else ''}{second}",
        )
        lines.append(f"  branch {k + 1:<5} {label}, from {low:.5g} to {high:.5g}{unit}: {verdict}")
        lines += [f"               its end: {end}" for end in dict.fromkeys(branch["ends"]) if end not in _PLAIN]
    return lines + ([f"  and {len(s['branches']) - _MOST} more branches"] if len(s["branches"]) > _MOST else [])


def _point_lines(result: xr.Dataset, s: dict[str, Any]) -> list[str]:
    """Return lines on special points, on curves in two parameters, and on the states at the subject's value."""
    lines, along, unit = [], s["along"], f" {s['along_unit']}".rstrip()
    second_unit = f" {s['second_unit'] or ''}".rstrip()
    for p in s["special_points"][:_MOST]:
        second = f", {s['second']} = {p['second_value']:.6g}{second_unit}" if "second_value" in p else ""
        at = f"{along} = {p['value']:.7g}{unit}{second}"
        remark = "" if p["frequency"] is None else f", oscillation with {p['frequency']:.5g} {_frequency(result)}".rstrip()
        remark += f"; {_BESIDE[p['kind']]}" if p["kind"] in _BESIDE else ""
        lines.append(f"  {p['kind']:12} {at}: {_place(result, p)}{remark}")
    rest = len(s["special_points"]) - _MOST
    lines += [f"  and {rest} more special points: see the Dataset"] if rest > 0 else []
    for c in s["curves"]:
        (low, high), (least, most) = c["range"], c["second_range"]
        extent = f"{along} from {low:.5g} to {high:.5g}{unit}, {s['second']} from {least:.5g} to {most:.5g}{second_unit}"
        lines.append(f"  curve of {_CURVES[c['of']]}{', ' if c.get('name') else ''}{c.get('name') or ''}: {extent}")
        for p in c["special_points"]:
            lines.append(
                f"    {p['kind']:16} {along} = {p['value']:.7g}{unit}, {s['second']} = {p['second_value']:.7g}{second_unit}"
            )
    for state in s["states"]:
        word, value = "stable" if state["stable"] else "unstable", f"at {along} = {s['value']:.6g}{unit}"
        if not state["stable"] and state.get("stable_share"):
            word = "partly"
        members = f"; {100 * state['stable_share']:.1f} % of the family's members are stable" if word == "partly" else ""
        name = f"{state['name'] or 'steady'}, " if "speed" in result else ""
        lines.append(f"  {word:12} {value}: {name}{_place(result, state)}{members}")
    return lines


def _place(result: xr.Dataset, entry: Mapping[str, Any]) -> str:
    """Return where a point is, in words: by speed and amplitude, of user equations by the state that is drawn."""
    show, ordinate = result.wucht.summary["show"], _ordinate_format(result)
    if "speed" not in result:
        return f"{show} = {ordinate(entry['state'][show])}"
    _, length = formats(result, str(result.amplitude.attrs["units"]))
    amplitude = "" if entry["amplitude"] is None else f", amplitude {length(entry['amplitude'])}"
    return f"{'speed ' if show is None else f'{show} = '}{ordinate(entry['speed'])}{amplitude}"


def _ordinate_format(result: xr.Dataset) -> Callable[[float], str]:
    if result.wucht.summary["show"] is None:
        return formats(result)[0]
    unit = str(result.speed.attrs["units"]) if "speed" in result else ""
    return lambda x: f"{x:.6g} {unit}".rstrip()


def _frequency(result: xr.Dataset) -> str:
    return str(result.special_frequency.attrs["units"])


_ONE_POINT = 1e-6  # in units of scale: a special point that lies on two branches


@dataclass(frozen=True)
class Special:
    """Special point of a numbered branch: unknowns (n+1,). frequency: of a Hopf point. second: the second parameter's value."""

    kind: str
    unknowns: np.ndarray
    speed: float
    amplitude: float
    branch: int
    frequency: float | None
    second: float | None


def collect_special_points(plan: Plan, findings: BranchFindings) -> list[Special]:
    """Collect all special points; one on two branches counts once."""
    special_points: list[Special] = []
    states_by_second_value = dict(plan.case.states_by_second_value)
    for k, branch in enumerate(findings.branches):
        steady_states = states_by_second_value[branch.second]
        width, ordinates = steady_states.equilibria.equations.scale[-1], steady_states.ordinates(branch.unknowns)
        for i in np.flatnonzero([bool(kind) for kind in branch.kinds]).tolist():
            unknowns, kind = branch.unknowns[:, i], branch.kinds[i]
            neighbours = [
                s
                for s in special_points
                if (s.kind, s.second) == (kind, branch.second) and abs(s.unknowns[-1] - unknowns[-1]) < _ONE_POINT * width
            ]
            if any(steady_states.is_same(unknowns, np.append(s.unknowns[:-1], unknowns[-1])) for s in neighbours):
                continue
            speed, amplitude = float(ordinates.speed[i]), float(ordinates.amplitude[i])
            exponents = branch.exponents[:, i][np.isfinite(branch.exponents[:, i])]
            swings = kind == HOPF or (kind in (SOME_STABLE, ALL_STABLE) and exponents[exponents.real.argmax()].imag != 0)
            frequency = _frequency_of(exponents) if swings else None
            special_points.append(Special(kind, unknowns, speed, amplitude, k, frequency, branch.second))
    return special_points


def _frequency_of(exponents: np.ndarray) -> float:
    pairs = exponents[exponents.imag > 0]
    return float(pairs[np.abs(pairs.real).argmin()].imag)


def point_quantities(plan: Plan, branches: Sequence[EquilibriumBranch]) -> list[Quantity]:
    """Return the points of all branches."""
    steady_states, states_by_second_value = plan.case.steady_states, dict(plan.case.states_by_second_value)
    words, n = steady_states.labels, len(steady_states.names)
    ordinates = [states_by_second_value[b.second].ordinates(b.unknowns) for b in branches]
    exponents = join_arrays([b.exponents for b in branches], n)
    # Against the fastest of the branch: at a fold of equations of one state there is no exponent but the one that is zero.
    fastest = [np.nanmax(np.abs(b.exponents), initial=0.0) for b in branches]
    growing = [(b.exponents.real > NEUTRAL * rate).sum(axis=0) for b, rate in zip(branches, fastest, strict=True)]
    shares = [np.array(b.stable_share) if b.stable_share else np.full(b.unknowns.shape[1], np.nan) for b in branches]
    at_special = [np.array([bool(kind) for kind in b.kinds]) for b in branches]
    return [
        *steady_branch_quantities("point", "", branches, ordinates, plan.along, words),
        Quantity("unstable", join_arrays(growing).astype(int), "number of growing disturbances", "", "point"),
        Quantity("stable_share", join_arrays(shares), "share of a family's members that are stable", "", "point"),
        Quantity("at_special", join_arrays(at_special).astype(np.int8), "a special point", "", "point"),
        Quantity("state", join_arrays([b.unknowns[:-1] for b in branches], n), "states of the equations", "", "state point"),
        Quantity("exponent_re", np.asarray(exponents.real), "real part of an exponent", words.rate, "exponent point"),
        Quantity("exponent_im", np.asarray(exponents.imag), "imaginary part of an exponent", words.rate, "exponent point"),
    ]


def branch_quantities(plan: Plan, branches: Sequence[EquilibriumBranch]) -> list[Quantity]:
    """Return the names, types and multiplicities of the branches."""
    kinds = [b.kind for b in branches]
    labels = np.array([label_of(k.name, k.type, k.split) for k in kinds], "U40")
    description, unit = ("second parameter", "") if plan.second is None else (plan.second.full_name, plan.second.unit)
    many = np.array([k.multiplicity for k in kinds], int)
    return [
        Quantity("branch_name", np.array([k.name or "" for k in kinds], "U16"), "name", "", "branch"),
        Quantity("branch_type", np.array([k.type or "" for k in kinds], "U4"), "type of 002, section 5.1", "", "branch"),
        Quantity("branch_label", labels, "states", "", "branch"),
        Quantity("family_dimension", np.array([b.dimension for b in branches], int), "dimension of the family", "", "branch"),
        Quantity("multiplicity", many, "states that differ in equal bodies only", "", "branch"),
        Quantity("second_value", np.array([b.second for b in branches], float), description, unit, "branch"),
    ]


def special_point_quantities(plan: Plan, special_points: Sequence[Special]) -> list[Quantity]:
    """Return the special points."""
    steady_states, words = plan.case.steady_states, plan.case.steady_states.labels
    table = np.array([s.unknowns[:-1] for s in special_points]).reshape(len(special_points), len(steady_states.names)).T
    frequency = np.array([s.frequency for s in special_points], float)
    amplitudes = [s.amplitude for s in special_points]
    of_machine = [
        Quantity("special_speed", [s.speed for s in special_points], words.ordinate, words.unit, "special"),
        Quantity("special_amplitude", amplitudes, "amplitude of the axis", words.length, "special"),
    ]
    return [
        Quantity("special_kind", np.array([s.kind for s in special_points], "U20"), "kind of the special point", "", "special"),
        Quantity(
            "special_value", [float(s.unknowns[-1]) for s in special_points], plan.along.full_name, plan.along.unit, "special"
        ),
        *([] if words.of_equations else of_machine),
        Quantity("special_branch", np.array([s.branch for s in special_points], int), "branch", "", "special"),
        Quantity("special_frequency", frequency, "frequency of the oscillation that begins", frequency_unit(plan), "special"),
        Quantity("special_state", table, "states of the equations", "", "state special"),
    ]


def frequency_unit(plan: Plan) -> str:
    """Return the unit of an oscillation's frequency."""
    rate = plan.case.steady_states.labels.rate
    return f"rad{rate.removeprefix('1')}" if rate else ""


def nominal_quantities(plan: Plan, nominal: Sequence[Mapping[str, Any]]) -> list[Quantity]:
    """Return the states at the subject's value of the parameter."""
    words, names = plan.case.steady_states.labels, plan.case.steady_states.names
    shares = [s.get("stable_share") for s in nominal]
    if words.of_equations:
        states = np.array([[s["state"][n] for s in nominal] for n in names]).reshape(len(names), len(nominal))
        place = [Quantity("own_state", states, "states of the equations", "", "state own")]
    else:
        place = [
            Quantity("own_speed", [s["speed"] for s in nominal], words.ordinate, words.unit, "own"),
            Quantity("own_amplitude", [s["amplitude"] for s in nominal], "amplitude of the axis", words.length, "own"),
        ]
    return [
        *place,
        Quantity("own_stable", np.array([s["stable"] for s in nominal], np.int8), "stable", "", "own"),
        Quantity("own_stable_share", np.array(shares, float), "share of a family's members", "", "own"),
        Quantity("own_branch", np.array([s["branch"] for s in nominal], int), "branch", "", "own"),
        Quantity("own_growth", [s["exponents"][0][0] for s in nominal], "fastest growth", words.rate, "own"),
    ]


def curve_quantities(plan: Plan, curves: Sequence[BifurcationCurve]) -> list[Quantity]:
    """Return the curves of folds and Hopf points in two parameters."""
    if plan.second is None or plan.case.plane is None:
        return []
    steady_states, words = plan.case.steady_states, plan.case.steady_states.labels
    numbers = np.repeat(np.arange(len(curves)), [c.unknowns.shape[1] for c in curves])
    speeds = [steady_states.ordinates(c.unknowns[:-1]).speed for c in curves]
    kinds = [kind for c in curves for kind in c.kinds]
    labels = np.array([label_of(c.kind.name, c.kind.type, c.kind.split) for c in curves], "U40")
    states = join_arrays([c.unknowns[:-2] for c in curves], len(steady_states.names))
    ordinate = Quantity("curve_speed", join_arrays(speeds), words.ordinate, words.unit, "curve_point")
    if words.of_equations:
        ordinate = Quantity("curve_state", states, "states of the equations", "", "state curve_point")
    return [
        Quantity(
            "curve_value", join_arrays([c.unknowns[-2] for c in curves]), plan.along.full_name, plan.along.unit, "curve_point"
        ),
        Quantity(
            "curve_second",
            join_arrays([c.unknowns[-1] for c in curves]),
            plan.second.full_name,
            plan.second.unit,
            "curve_point",
        ),
        ordinate,
        Quantity("curve", numbers.astype(int), "curve", "", "curve_point"),
        Quantity("curve_kind", np.array(kinds, "U20"), "kind of a point where a second condition holds", "", "curve_point"),
        Quantity("curve_of", np.array([c.bifurcation for c in curves], "U8"), "kind of the curve's points", "", "curve_number"),
        Quantity("curve_label", labels, "states", "", "curve_number"),
    ]
