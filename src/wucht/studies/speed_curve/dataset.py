"""Findings -> the quantities of a speed curve, its sentence and its warnings."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp

from wucht.dynamics.branches.bifurcation_diagram import BranchFindings, SearchedValue
from wucht.dynamics.branches.equilibrium_branches import ALL_STABLE, SOME_STABLE, StabilityLevel
from wucht.dynamics.branches.family_curve import SAMPLED_MEMBERS
from wucht.dynamics.branches.steady_states import Labels, SteadyStates
from wucht.dynamics.branches.steady_states import speed_range_text as speeds_in_words
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.shared_keys import VALUES, entry_with_values
from wucht.studies.speed_curve.computation import Plan
from wucht.studies.speed_curve.report import (
    Special,
    branch_quantities,
    collect_special_points,
    count_phrase,
    curve_quantities,
    frequency_unit,
    kinds_phrase,
    label_of,
    nominal_quantities,
    point_quantities,
    special_point_quantities,
)

if TYPE_CHECKING:
    import xarray as xr

_MOST_LOST = 3  # sentences on states that could not be followed
_OF_MACHINES = frozenset({
    "speed", "amplitude", "exponents_phi", "type", "name", "label", "multiplicity", "family_dimension", "stable_share",
    "partly_stable", "partly_stable_speeds", "partly_stable_shares",
})  # fmt: skip
_AT_ZERO = 1e-9  # of the range: a value this close to zero is zero


def dataset(plan: Plan, findings: BranchFindings) -> xr.Dataset:
    """Return the Dataset of a speed curve."""
    special_points, nominal, second, names = (
        collect_special_points(plan, findings),
        _nominal_states(plan, findings),
        plan.second,
        plan.case.steady_states.names,
    )
    quantities = [
        *point_quantities(plan, findings.branches), *branch_quantities(plan, findings.branches),
        *special_point_quantities(plan, special_points),
        *nominal_quantities(plan, nominal), *curve_quantities(plan, findings.curves),
        Quantity("state_name", list(names), "state of the equations", "", "state", coordinate=True),
        *_question_quantities(plan), *_table_quantities(plan, findings, special_points, nominal),
        *_search_quantities(plan, findings.searches),
    ]  # fmt: skip
    more: dict[str, Any] = {} if not plan.case.steady_states.labels.of_equations else {"subject": "system"}
    more |= {} if second is None else {"second": second.path, "second_unit": second.unit, "second_what": second.full_name,
        "second_symbol": _symbol(second.path)}  # fmt: skip
    return result_dataset(
        quantities, _sentence(plan, findings, special_points), _warnings(plan, findings),
        along_symbol=_symbol(plan.along.path),
        along=plan.along.path, along_unit=plan.along.unit, along_what=plan.along.full_name, low=plan.bounds[0],
        high=plan.bounds[1],
        shown=plan.case.steady_states.labels.ordinate, **more,
    )  # fmt: skip


def _symbol(path: str) -> str:
    """Return a parameter's label in a figure: a single name is a symbol."""
    return f"${sp.latex(sp.Symbol(path))}$" if path.isidentifier() else path


def _nominal_states(plan: Plan, findings: BranchFindings) -> list[dict[str, Any]]:
    """Return the states at the subject's value of the parameter, the fastest first."""
    entries, steady_states = list[dict[str, Any]](), plan.case.steady_states
    for nominal in findings.nominal:
        branch, ordinates = findings.branches[nominal.branch], steady_states.ordinates(nominal.unknowns[:, None])
        speed = float(ordinates.speed[0])
        kind = steady_states.kind(nominal.unknowns) if not branch.dimension else branch.kind
        exponents = nominal.exponents[np.isfinite(nominal.exponents)]
        exponents = exponents[np.argsort(-exponents.real, kind="stable")]
        entries.append({
            "name": kind.name, "type": kind.type, "speed": speed, "amplitude": float(ordinates.amplitude[0]),
            "stable": nominal.stability == StabilityLevel.STABLE, "stable_share": nominal.share, "branch": nominal.branch,
            "state": _state_by_name(steady_states, nominal.unknowns),
            "family_dimension": branch.dimension,
            "exponents": [[float(e.real), float(e.imag)] for e in exponents],
            "exponents_phi": _exponents_by_angle(plan, exponents, speed),
        })  # fmt: skip
    return [_keys_of_subject(plan, entry) for entry in sorted(entries, key=lambda s: -abs(s["speed"]))]


def _keys_of_subject(plan: Plan, entry: dict[str, Any]) -> dict[str, Any]:
    """Return an entry of a table without the keys that user equations lack."""
    return {k: x for k, x in entry.items() if k not in _OF_MACHINES} if plan.case.steady_states.labels.of_equations else entry


def _state_by_name(steady_states: SteadyStates, unknowns: np.ndarray) -> dict[str, float]:
    """Return the state at a point by names; of user equations that which is drawn is zero within rounding."""
    state, labels = dict(steady_states.state_by_name(unknowns)), steady_states.labels
    if labels.of_equations and labels.state is not None:
        state[labels.state] = _round_ordinate(steady_states, state[labels.state])
    return state


def _exponents_by_angle(plan: Plan, exponents: np.ndarray, speed: float) -> list[list[float]] | None:
    """Return exponents by the rotor's angle instead of time; None where the ordinate is no speed."""
    if plan.case.steady_states.labels.state is not None or not speed:
        return None
    return [[float(e.real) / abs(speed), float(e.imag) / abs(speed)] for e in exponents]


def _question_quantities(plan: Plan) -> list[Quantity]:
    along, second, plane, words = plan.along, plan.second, plan.case.plane, plan.case.steady_states.labels
    of_second = (None, None) if second is None else (second.path, second.unit)
    return [
        Quantity("along", along.path, "parameter over which branches are followed"),
        Quantity("along_unit", along.unit, "its unit"),
        Quantity("range", list(plan.bounds), f"range of the {along.full_name}", along.unit),
        Quantity("second", of_second[0], "second parameter"),
        Quantity("second_unit", of_second[1], "its unit"),
        Quantity("second_value", plane and plane.value, "second parameter where the curves begin", of_second[1] or ""),
        Quantity("show", words.state, "state that is drawn instead of the speed"),
        Quantity("inertia", words.inertia, "whether the averaged equations keep the inertia of the balancing bodies"),
    ]


def _table_quantities(
    plan: Plan, findings: BranchFindings, special_points: Sequence[Special], nominal: Sequence[Any]
) -> list[Quantity]:
    words, at = plan.case.steady_states.labels, (plan.along.full_name, plan.along.unit)
    at_ends, dimension = (f"{words.ordinate} at their ends", words.unit), ("dimension of the family", "")
    free = [(p, (p.full_name, p.unit)) for p in (plan.along, plan.second) if p is not None]
    values = {p.path: words for p, words in free} | {key: words for key, (_, words) in zip(VALUES, free, strict=False)}
    kind = {"name": ("kind of steady state", ""), "type": ("type of 002, section 5.1", "")}
    place = {
        "speed": (words.ordinate, words.unit), "amplitude": ("amplitude of the axis", words.length),
        "state": ("states of the equations", ""), "branch": ("branch", ""),
    }  # fmt: skip
    special_columns = {"kind": ("kind", ""), "frequency": ("frequency of the oscillation that begins", frequency_unit(plan))}
    branch_columns = {
        "label": ("label of the states", ""), "range": at, "ends": ("ends of the branch", ""),
        "stable": ("ranges in which all members are stable", at[1]), _at_ends(words): at_ends,
        "partly_stable": ("ranges in which some members are stable", at[1]), "partly_stable_speeds": at_ends,
        "partly_stable_shares": ("shares of stable members at their ends", ""),
        "family_dimension": dimension, "multiplicity": ("states that differ in equal bodies only", ""),
    }  # fmt: skip
    nominal_columns = {
        "stable": ("whether all members are stable", ""), "stable_share": ("share of members that are stable", ""),
        "exponents": ("exponents", words.rate), "exponents_phi": ("exponents over the angle of the main rotor", ""),
        "family_dimension": dimension,
    }  # fmt: skip
    curve_columns = {
        "of": ("kind of the curve's points", ""), "range": at, "ends": ("ends of the curve", ""),
        "second_range": ("second parameter", "" if plan.second is None else plan.second.unit),
        "special_points": ("points where a second condition holds", ""),
    }  # fmt: skip
    return [
        *table(
            "special_points",
            [_special_entry(plan, s) for s in special_points],
            "special points",
            values | place | special_columns,
        ),
        *table("branches", _branch_entries(plan, findings), "branches of steady states", values | kind | branch_columns),
        Quantity("value", plan.case.steady_states.nominal_value, f"{at[0]} of the subject", at[1]),
        *table("states", nominal, "steady states at this value", kind | place | nominal_columns),
        *table("curves", _curve_entries(plan, findings), "curves of special points", values | kind | place | curve_columns),
    ]


def _search_quantities(plan: Plan, searched_values: Sequence[SearchedValue]) -> list[Quantity]:
    values, along = [s.value for s in searched_values if s.failure is None], plan.along
    return [
        Quantity("searched_value", [s.value for s in searched_values], along.full_name, along.unit, "search"),
        Quantity(
            "searched_states", np.array([s.state_count for s in searched_values], int), "number of states there", "", "search"
        ),
        Quantity("searched", values, f"{along.full_name} at which all states were searched for", along.unit),
        Quantity(
            "complete", bool(searched_values) and all(s.complete for s in searched_values), "whether all states are known there"
        ),
        Quantity("shown", _completeness_evidence(plan, searched_values), "evidence for that"),
    ]


def _completeness_evidence(plan: Plan, searched_values: Sequence[SearchedValue]) -> str:
    """Return the evidence that all states are known, or the reason why not, for all values at which they were searched."""
    sentence = next(
        (s.evidence for s in searched_values if not s.complete and s.evidence),
        searched_values[0].evidence if searched_values else "",
    )
    speeds = [s.speeds for s in searched_values if s.speeds is not None]
    if not speeds:
        return sentence
    widest = min(low for low, _ in speeds), max(high for _, high in speeds)
    return f"{sentence}; over all of them {speeds_in_words(widest, plan.case.steady_states.labels.speed)}"


def _snap_to_zero(plan: Plan, value: float) -> float:
    return 0.0 if abs(value) < _AT_ZERO * (plan.bounds[1] - plan.bounds[0]) else float(value)


def _round_ordinate(steady_states: SteadyStates, ordinate: float) -> float:
    """Return the ordinate, zero within rounding."""
    return 0.0 if abs(ordinate) < _AT_ZERO * steady_states.ordinate_size else ordinate


def _special_entry(plan: Plan, s: Special) -> dict[str, Any]:
    steady_states = dict(plan.case.states_by_second_value)[s.second]
    second = {} if plan.second is None or s.second is None else {plan.second.path: s.second}
    return entry_with_values(_keys_of_subject(plan, {
        "kind": s.kind, "speed": _round_ordinate(steady_states, s.speed), "state": _state_by_name(steady_states, s.unknowns),
        "amplitude": s.amplitude, "branch": s.branch, "frequency": s.frequency,
    }), [plan.along.path, *second], [_snap_to_zero(plan, s.unknowns[-1]), *second.values()], ["second_value"])  # fmt: skip


def _branch_entries(plan: Plan, findings: BranchFindings) -> list[dict[str, Any]]:
    entries, labels = [], plan.case.steady_states.labels
    for b in findings.branches:
        steady_states = dict(plan.case.states_by_second_value)[b.second]
        speeds = [_round_ordinate(steady_states, float(speed)) for speed in steady_states.ordinates(b.unknowns).speed]
        second = {} if plan.second is None or b.second is None else {plan.second.path: b.second, "second_value": b.second}
        stretches = {"": b.intervals(StabilityLevel.STABLE), "partly_": b.intervals(StabilityLevel.PARTLY_STABLE)}
        spans = {f"{word}stable": [_span(plan, b.parameter_values[i : k + 1]) for i, k in at] for word, at in stretches.items()}
        keys = {"": _at_ends(labels), "partly_": "partly_stable_speeds"}
        at_ends = {keys[word]: [_upwards(b.parameter_values, speeds, i, k) for i, k in at] for word, at in stretches.items()}
        entries.append(second | _keys_of_subject(plan, {
            "type": b.kind.type, "name": b.kind.name, "label": label_of(b.kind.name, b.kind.type, b.kind.split),
            **spans, **at_ends,
            "partly_stable_shares": [_upwards(b.parameter_values, b.stable_share, i, k) for i, k in stretches["partly_"]],
            "range": _span(plan, b.parameter_values), "ends": list(b.ends),
            "family_dimension": b.dimension, "multiplicity": b.kind.multiplicity,
        }))  # fmt: skip
    return entries


def _at_ends(labels: Labels) -> str:
    """Return the key of the ordinate at the ends of stable stretches."""
    return f"stable_{labels.state}" if labels.of_equations else "stable_speeds"


def _span(plan: Plan, values: np.ndarray) -> list[float]:
    return [_snap_to_zero(plan, values.min()), _snap_to_zero(plan, values.max())]


def _upwards(values: np.ndarray, speeds: Sequence[float], i: int, k: int) -> list[float]:
    """Return the ordinates at both ends of a stretch, that at the lower value first."""
    return [speeds[i], speeds[k]] if values[i] <= values[k] else [speeds[k], speeds[i]]


def _curve_entries(plan: Plan, findings: BranchFindings) -> list[dict[str, Any]]:
    """Return the curves of folds and Hopf points in two parameters, with the points where a second condition holds."""
    if plan.case.plane is None:
        return []
    entries, steady_states = [], plan.case.steady_states
    for c in findings.curves:
        speeds = steady_states.ordinates(c.unknowns[:-1]).speed
        special = [
            entry_with_values(_keys_of_subject(plan, {
                "kind": c.kinds[i], "speed": float(speeds[i]), "state": dict(steady_states.state_by_name(c.unknowns[:-1, i])),
                "coefficients": dict(c.coefficients[i]),
            }), [plan.along.path, plan.case.plane.path], c.unknowns[-2:, i].tolist())
            for i in np.flatnonzero([bool(kind) for kind in c.kinds]).tolist()
        ]  # fmt: skip
        entries.append({
            "of": c.bifurcation, "type": c.kind.type, "name": c.kind.name,
            **{
                key: [float(values.min()), float(values.max())]
                for key, values in zip(("range", "second_range"), c.unknowns[-2:], strict=True)
            },
            "special_points": special, "ends": list(c.ends),
        })  # fmt: skip
    return [_keys_of_subject(plan, entry) for entry in entries]


def _sentence(plan: Plan, findings: BranchFindings, special_points: Sequence[Special]) -> str:
    branches, (low, high) = findings.branches, plan.bounds
    if not branches:
        if not findings.complete:
            return "the study was interrupted before the first branch"
        of = f" {' or '.join(plan.case.only)}," if plan.case.only else ""
        return f"no steady states were found,{of} between {plan.along.value_text(low, 5)} and {high:.5g}"
    stable = sum(bool(b.intervals(StabilityLevel.STABLE)) for b in branches)
    partly = sum(bool(b.intervals(StabilityLevel.PARTLY_STABLE)) for b in branches)
    count = count_phrase(len(branches), "branch of steady states", "branches of steady states")
    part = (
        f"{stable} of them stable somewhere"
        if stable
        else f"none of them stable {'with all members' if partly else 'anywhere'}"
    )
    if len(branches) == 1:
        part = "stable somewhere" if stable else "nowhere stable"
    if partly:
        part += f", {count_phrase(partly, 'family', 'families')} with members that are stable and others that are not"
    sentence = (
        f"{count}, {part}; "
        f"{kinds_phrase([s.kind for s in special_points if s.kind not in (SOME_STABLE, ALL_STABLE)]) or 'no special point'}"
    )
    if plan.case.plane is not None:
        second = [kind for c in findings.curves for kind in c.kinds if kind]
        many = count_phrase(len(findings.curves), "curve", "curves")
        sentence += (
            f"; {many} of them in {plan.along.sentence_name} and "
            f"{plan.second.sentence_name if plan.second else plan.case.plane.path}"
        )
        sentence += f" with {kinds_phrase(second)}" if second else ""
    return sentence


def _warnings(plan: Plan, findings: BranchFindings) -> list[str]:
    """Return warnings on omissions, doubts, and unfinished work."""
    steady_states, path = plan.case.steady_states, plan.along.path
    lines = [*steady_states.labels.warnings]
    for failure in dict.fromkeys(s.failure for s in findings.searches if s.failure):
        at = [s.value for s in findings.searches if s.failure == failure]
        location = (
            f"{path} = {at[0]:.5g}" if len(at) == 1 else f"{len(at)} values of {path} from {min(at):.5g} to {max(at):.5g}"
        )
        lines.append(f"at {location} states could not be searched for: {failure}")
    lines += [*findings.omissions[:_MOST_LOST]]
    if len(findings.omissions) > _MOST_LOST:
        lines.append(f"and {len(findings.omissions) - _MOST_LOST} more states")
    incomplete = next((s for s in findings.searches if s.failure is None and not s.complete), None)
    if incomplete is not None:
        lines.append(f"it is not proved that all states are known: {incomplete.evidence}")
    lines += _stability_warnings(plan, findings)
    if not findings.complete:
        lines.append(
            f"{count_phrase(len(findings.branches), 'branch is', 'branches are')} followed; the search is not finished"
        )
    return lines


def _stability_warnings(plan: Plan, findings: BranchFindings) -> list[str]:
    """Return warnings on changes of stability that are not located, and on the stability of families."""
    lines = []
    for k, b in enumerate(findings.branches):
        gaps = [f"{b.parameter_values[i]:.5g} and {b.parameter_values[j]:.5g}" for i, j in b.unlocated_changes]
        if gaps:
            more = f", and at {len(gaps) - 1} more places" if len(gaps) > 1 else ""
            location = f"between {plan.along.path} = {gaps[0]}{more}"
            lines.append(f"on branch {k + 1} stability changes {location}: no fold, Hopf or branch point was located there")
    families = sorted({b.dimension for b in findings.branches if b.dimension})
    if families:
        of = " and ".join(map(str, families))
        explanation = "one member represents each where a state is listed; its exponents are those transverse to the family"
        lines.append(f"the states in which the unbalances compensate form families of dimension {of}: {explanation}")
    if any(b.intervals(StabilityLevel.PARTLY_STABLE) for b in findings.branches):
        lines.append(
            f"of a family {SAMPLED_MEMBERS} members are examined: these alone decide where some are stable, and where all are;"
            " the limits of rare members may be wider"
        )
    return lines
