"""The tables of a speed curve: branches, special points, states at the subject's value, curves in two parameters."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, BranchFindings
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch, StabilityLevel
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.dynamics.branches.special_states import SpecialState
from wucht.dynamics.branches.steady_states import Labels, SteadyStates
from wucht.numerics.periodic.branch_ends import significant_value
from wucht.schema import Parameter
from wucht.studies.answer import Answer, Column
from wucht.studies.motion_variables import join_arrays, parameter_columns

_MOST = 16  # special points, and branches, named one by one
_AT_ZERO = 1e-9  # of its size: an ordinate this close to zero is zero
_BESIDE = {
    "some-stable": "on one side some members of the family are stable, on the other none",
    "all-stable": "on one side all members of the family are stable, on the other not all",
    "unresolved": "this change is no simple fold, Hopf or branch point, or several lie too close together",
}
_CURVES = {"fold": "folds", "hopf": "Hopf points"}
_PLAIN = ("the range ends", "it is closed")
_OF_MACHINES = frozenset({
    "speed", "amplitude", "exponents_phi", "type", "name", "label", "multiplicity", "family_dimension", "stable_share",
    "partly_stable", "partly_stable_speeds", "partly_stable_shares",
})  # fmt: skip


def _of_subject(labels: Labels, columns: dict[str, Column]) -> dict[str, Column]:
    """Return columns of a table without those that user equations lack."""
    return {name: column for name, column in columns.items() if not labels.of_equations or name not in _OF_MACHINES}


def _ordinate_text(labels: Labels, value: float, path: str) -> str:
    """Return the ordinate of a line: a field for the speed of a machine, else the state that is drawn."""
    return f"{{{path}}}" if labels.state is None else f"{value:.6g} {labels.unit}".rstrip()


def _place_text(labels: Labels, speed: float, amplitude: float) -> str:
    """Return where a point is, in words: by speed and amplitude, of user equations by the state that is drawn."""
    place = f"{'speed ' if labels.state is None else f'{labels.state} = '}{_ordinate_text(labels, speed, 'speed')}"
    return place + ("" if np.isnan(amplitude) else ", amplitude {amplitude}")


def _round_ordinate(steady_states: SteadyStates, ordinate: float) -> float:
    """Return the ordinate, zero within rounding."""
    return 0.0 if abs(ordinate) < _AT_ZERO * steady_states.ordinate_size else ordinate


def _state_by_name(steady_states: SteadyStates, unknowns: np.ndarray) -> dict[str, float]:
    """Return the state at a point by names; of user equations that which is drawn is zero within rounding."""
    state, labels = dict(steady_states.state_by_name(unknowns)), steady_states.labels
    if labels.of_equations and labels.state is not None:
        state[labels.state] = _round_ordinate(steady_states, state[labels.state])
    return state


def state_branches(
    a: Answer, along: Parameter, second: Parameter | None, case: BranchCase, branches: Sequence[EquilibriumBranch]
) -> None:
    """State names, ranges and ends of the branches, and where they are stable."""
    labels, states_at, kinds = case.steady_states.labels, case.states_by_second_value, [b.kind for b in branches]
    seconds, dimensions = [b.second for b in branches], [b.dimension for b in branches]
    words, unit = ("second parameter", "") if second is None else (second.full_name, second.unit)
    a.curve("branch_name", np.array([k.name or "" for k in kinds], "U16"), "name", "", "branch")
    a.curve("branch_type", np.array([k.type or "" for k in kinds], "U4"), "type of 002, section 5.1", "", "branch")
    a.curve("branch_label", np.array([k.label for k in kinds], "U40"), "states", "", "branch")
    a.curve("family_dimension", np.array(dimensions, int), "dimension of the family", "", "branch")
    many = np.array([k.multiplicity for k in kinds], int)
    a.curve("multiplicity", many, "states that differ in equal bodies only", "", "branch")
    a.curve("second_value", np.array(seconds, float), words, unit, "branch")
    stable, partly = ([b.intervals(level) for b in branches] for level in (StabilityLevel.STABLE, StabilityLevel.PARTLY_STABLE))
    ordinates = [states_at[b.second].ordinate(b.unknowns).tolist() for b in branches]
    ordinates = [[_round_ordinate(states_at[b.second], x) for x in row] for b, row in zip(branches, ordinates, strict=True)]
    shares = [b.stable_share for b in branches]

    def ranges(stretches: Sequence[Sequence[tuple[int, int]]]) -> list[list[list[float]]]:
        return [[_span(case, b.parameter_values[i : k + 1]) for i, k in at] for b, at in zip(branches, stretches, strict=True)]

    def at_ends(courses: Sequence[Sequence[float]], stretches: Sequence[Sequence[tuple[int, int]]]) -> list[list[list[float]]]:
        """Return the numbers at both ends of each stretch, that at the lower value first."""
        return [
            [[course[i] for i in sorted(ends, key=b.parameter_values.__getitem__)] for ends in at]
            for b, course, at in zip(branches, courses, stretches, strict=True)
        ]

    stable_at, partly_at, extents = ranges(stable), ranges(partly), [_span(case, b.parameter_values) for b in branches]
    stable_ends, partly_ends, partly_shares = at_ends(ordinates, stable), at_ends(ordinates, partly), at_ends(shares, partly)
    name_at_ends = f"stable_{labels.state}" if labels.of_equations else "stable_speeds"
    words_at_ends = f"{labels.ordinate} at their ends", labels.unit
    free = parameter_columns((along, ()), *([] if second is None else [(second, seconds)]))
    a.table_of(
        "branches", "branches of steady states", optional=tuple(free),
        columns=free | _of_subject(labels, {
            "type": ([k.type for k in kinds], "type of 002, section 5.1"),
            "name": ([k.name for k in kinds], "kind of steady state"),
            "label": ([k.label for k in kinds], "label of the states"),
            "stable": (stable_at, "ranges in which all members are stable", along.unit),
            "partly_stable": (partly_at, "ranges in which some members are stable", along.unit),
            name_at_ends: (stable_ends, *words_at_ends),
            "partly_stable_speeds": (partly_ends, *words_at_ends),
            "partly_stable_shares": (partly_shares, "shares of stable members at their ends"),
            "range": (extents, along.full_name, along.unit),
            "ends": ([list(b.ends) for b in branches], "ends of the branch"),
            "family_dimension": (dimensions, "dimension of the family"),
            "multiplicity": ([k.multiplicity for k in kinds], "states that differ in equal bodies only"),
        }),
    )  # fmt: skip
    unit = f" {along.unit}".rstrip()

    def stretches_text(at: list[list[float]], ends: list[list[float]], key: str) -> str:
        """Return the ranges of one kind of stability, with the ordinates at their ends."""
        return " and ".join(
            f"{low:.5g} to {high:.5g}{unit} ({_ordinate_text(labels, first, f'{key}[{j}][0]')} to "
            f"{_ordinate_text(labels, last, f'{key}[{j}][1]')})"
            for j, ((low, high), (first, last)) in enumerate(zip(at, ends, strict=True))
        )

    for k, branch in enumerate(branches[:_MOST]):
        family = f" (family of dimension {branch.dimension})" if branch.dimension else ""
        place = "" if second is None or branch.second is None else f" at {second.path} = {branch.second:.6g} {second.unit}"
        all_stable = stretches_text(stable_at[k], stable_ends[k], name_at_ends)
        some_stable = stretches_text(partly_at[k], partly_ends[k], "partly_stable_speeds")
        verdict = f"stable at {along.path} from {all_stable}" if all_stable else "nowhere stable"
        if branch.dimension and all_stable:
            verdict = f"all members {verdict}"
        elif branch.dimension and some_stable:
            verdict = "nowhere are all members stable"
        if some_stable:
            percent = " and ".join(f"{100 * first:.1f} to {100 * last:.1f} %" for first, last in partly_shares[k])
            verdict += f"; some members stable and others not from {some_stable}, {percent} of them"
        low, high = extents[k]
        extent = f"{branch.kind.label}{family}{place.rstrip()}, from {low:.5g} to {high:.5g}{unit}"
        a.line(f"branch {k + 1}", f"{extent}: {verdict}", at=f"branches[{k}]")
        for end in dict.fromkeys(branch.ends):
            if end not in _PLAIN:
                a.line("", "its end: {end}", end=end)
    if len(branches) > _MOST:
        a.line(f"and {len(branches) - _MOST} more branches", "")


def _span(case: BranchCase, values: np.ndarray) -> list[float]:
    return [significant_value(float(end), case.steady_states.bounds) for end in (values.min(), values.max())]


def state_special_points(
    a: Answer, along: Parameter, second: Parameter | None, case: BranchCase, special_points: Sequence[SpecialState]
) -> None:
    """State the special points, with the frequency of the oscillation that begins there."""
    labels, names, states_at = case.steady_states.labels, case.steady_states.names, case.states_by_second_value
    values = [significant_value(float(s.unknowns[-1]), case.steady_states.bounds) for s in special_points]
    speeds = [_round_ordinate(states_at[s.second], s.speed) for s in special_points]
    frequency_unit = f"rad{labels.rate.removeprefix('1')}" if labels.rate else ""
    a.curve("special_kind", np.array([s.kind for s in special_points], "U20"), "kind of the special point", "", "special")
    a.curve("special_value", [float(s.unknowns[-1]) for s in special_points], along.full_name, along.unit, "special")
    if not labels.of_equations:
        a.curve("special_speed", [s.speed for s in special_points], labels.ordinate, labels.unit, "special")
    kinds = ({} if labels.of_equations else {"amplitude": float}) | {"branch": int, "frequency": float}
    free = parameter_columns((along, values), *([] if second is None else [(second, [s.second for s in special_points])]))
    a.table_of(
        "special_points", "special points", over="special", kinds=kinds,
        optional=() if second is None else (second.path, "second_value"), columns=free | _of_subject(labels, {
            "kind": ([s.kind for s in special_points], "kind"),
            "speed": (speeds, labels.ordinate, labels.unit),
            "state": ([_state_by_name(states_at[s.second], s.unknowns) for s in special_points], "states of the equations"),
            "amplitude": ([s.amplitude for s in special_points], "amplitude of the axis", labels.length),
            "branch": ([s.branch for s in special_points], "branch"),
            "frequency": ([s.frequency for s in special_points], "frequency of the oscillation that begins", frequency_unit),
        }),
    )  # fmt: skip
    states = np.array([s.unknowns[:-1] for s in special_points]).reshape(len(special_points), len(names)).T
    a.curve("special_state", states, "states of the equations", "", "state special")
    for i, point in enumerate(special_points[:_MOST]):
        place = f"{along.path} = {values[i]:.7g} {along.unit}".rstrip()
        if second is not None and point.second is not None:
            place += f", {second.path} = {point.second:.6g} {second.unit}".rstrip()
        remark = "" if point.frequency is None else f", oscillation with {point.frequency:.5g} {frequency_unit}".rstrip()
        remark += f"; {_BESIDE[point.kind]}" if point.kind in _BESIDE else ""
        text = f"{place}: {_place_text(labels, speeds[i], point.amplitude)}{remark}"
        a.line(f"{point.kind:12} ", text, at=f"special_points[{i}]")
    if len(special_points) > _MOST:
        a.line(f"and {len(special_points) - _MOST} more special points: see the Dataset", "")


def state_nominal_states(a: Answer, along: Parameter, case: BranchCase, findings: BranchFindings) -> list[tuple[str, str, str]]:
    """State the states at the subject's value of the parameter, the fastest first, and return a line for each."""
    labels, steady_states, branches = case.steady_states.labels, case.steady_states, findings.branches
    states = sorted(findings.nominal, key=lambda n: -abs(float(steady_states.ordinate(n.unknowns[:, None])[0])))
    speeds = [float(steady_states.ordinate(n.unknowns[:, None])[0]) for n in states]
    amplitudes = [float(steady_states.amplitude(n.unknowns[:, None])[0]) for n in states]
    kinds = [branches[n.branch].kind if branches[n.branch].dimension else steady_states.kind(n.unknowns) for n in states]
    exponents = [n.fastest_exponents for n in states]
    by_name = [_state_by_name(steady_states, n.unknowns) for n in states]
    stable = [n.stability == StabilityLevel.STABLE for n in states]
    a.number("value", steady_states.nominal_value, f"{along.full_name} of the subject", along.unit)
    if labels.of_equations:
        rows = np.array([list(state.values()) for state in by_name]).reshape(len(states), len(steady_states.names)).T
        a.curve("own_state", rows, "states of the equations", "", "state own")
    a.table_of(
        "states", "steady states at this value", over="own",
        kinds={} if labels.of_equations else {"speed": float, "amplitude": float},
        columns=_of_subject(labels, {
            "name": ([k.name for k in kinds], "kind of steady state"),
            "type": ([k.type for k in kinds], "type of 002, section 5.1"),
            "speed": (speeds, labels.ordinate, labels.unit),
            "amplitude": (amplitudes, "amplitude of the axis", labels.length),
            "stable": (stable, "whether all members are stable"),
            "stable_share": ([n.share for n in states], "share of members that are stable"),
            "branch": ([n.branch for n in states], "branch"),
            "state": (by_name, "states of the equations"),
            "family_dimension": ([branches[n.branch].dimension for n in states], "dimension of the family"),
            "exponents": ([[[float(e.real), float(e.imag)] for e in row] for row in exponents], "exponents", labels.rate),
            "exponents_phi": (
                [_exponents_by_angle(labels, row, speed) for row, speed in zip(exponents, speeds, strict=True)],
                "exponents over the angle of the main rotor",
            ),
        }),
    )  # fmt: skip
    a.curve("own_stable", np.array(stable, np.int8), "stable", "", "own")
    a.curve("own_stable_share", np.array([n.share for n in states], float), "share of a family's members", "", "own")
    a.curve("own_branch", np.array([n.branch for n in states], int), "branch", "", "own")
    a.curve("own_growth", [float(row[0].real) for row in exponents], "fastest growth", labels.rate, "own")
    lines, place = list[tuple[str, str, str]](), f"at {along.path} = {steady_states.nominal_value:.6g} {along.unit}".rstrip()
    for i, (state, kind) in enumerate(zip(states, kinds, strict=True)):
        word = "stable" if stable[i] else "partly" if state.share else "unstable"
        members = f"; {100 * (state.share or 0):.1f} % of the family's members are stable" if word == "partly" else ""
        name = "" if labels.of_equations else f"{kind.name or 'steady'}, "
        text = f"{place}: {name}{_place_text(labels, speeds[i], amplitudes[i])}{members}"
        lines.append((f"{word:12} ", text, f"states[{i}]"))
    return lines


def _exponents_by_angle(labels: Labels, exponents: np.ndarray, speed: float) -> list[list[float]] | None:
    """Return exponents by the rotor's angle instead of time; None where the ordinate is no speed."""
    if labels.state is not None or not speed:
        return None
    return [[float(e.real) / abs(speed), float(e.imag) / abs(speed)] for e in exponents]


def state_special_curves(
    a: Answer, along: Parameter, second: Parameter | None, case: BranchCase, curves: Sequence[BifurcationCurve]
) -> None:
    """State the curves of folds and Hopf points in two parameters, with the points where a second condition holds."""
    labels, steady_states = case.steady_states.labels, case.steady_states
    ordinates = [steady_states.ordinate(c.unknowns[:-1]) for c in curves]
    special = [
        [_second_condition(along, second, steady_states, c, i, float(speeds[i])) for i, kind in enumerate(c.kinds) if kind]
        for c, speeds in zip(curves, ordinates, strict=True)
    ]
    extents, second_extents = ([[float(c.unknowns[k].min()), float(c.unknowns[k].max())] for c in curves] for k in (-2, -1))
    of_points: dict[str, Column] = parameter_columns((along, ()), *([] if second is None else [(second, ())])) | {
        "speed": ((), labels.ordinate, labels.unit), "amplitude": ((), "amplitude of the axis", labels.length),
        "state": ((), "states of the equations"), "branch": ((), "branch"),
    }  # fmt: skip
    a.table_of("curves", "curves of special points", of_points | _of_subject(labels, {
        "of": ([c.bifurcation for c in curves], "kind of the curve's points"),
        "type": ([c.kind.type for c in curves], "type of 002, section 5.1"),
        "name": ([c.kind.name for c in curves], "kind of steady state"),
        "range": (extents, along.full_name, along.unit),
        "second_range": (second_extents, "second parameter", "" if second is None else second.unit),
        "special_points": (special, "points where a second condition holds"),
        "ends": ([list(c.ends) for c in curves], "ends of the curve"),
    }))  # fmt: skip
    if second is None or case.plane is None:
        return
    numbers = np.repeat(np.arange(len(curves)), [c.unknowns.shape[1] for c in curves])
    a.curve("curve_value", join_arrays([c.unknowns[-2] for c in curves]), along.full_name, along.unit, "curve_point")
    a.curve("curve_second", join_arrays([c.unknowns[-1] for c in curves]), second.full_name, second.unit, "curve_point")
    if labels.of_equations:
        states = join_arrays([c.unknowns[:-2] for c in curves], len(steady_states.names))
        a.curve("curve_state", states, "states of the equations", "", "state curve_point")
    else:
        a.curve("curve_speed", join_arrays(ordinates), labels.ordinate, labels.unit, "curve_point")
    kinds = np.array([kind for c in curves for kind in c.kinds], "U20")
    a.curve("curve", numbers.astype(int), "curve", "", "curve_point")
    a.curve("curve_kind", kinds, "kind of a point where a second condition holds", "", "curve_point")
    a.curve("curve_of", np.array([c.bifurcation for c in curves], "U8"), "kind of the curve's points", "", "curve_number")
    a.curve("curve_label", np.array([c.kind.label for c in curves], "U40"), "states", "", "curve_number")
    units = f" {along.unit}".rstrip(), f" {second.unit}".rstrip()
    for c, extent, second_extent, points in zip(curves, extents, second_extents, special, strict=True):
        (low, high), (least, most), of = extent, second_extent, f", {c.kind.name}" if c.kind.name else ""
        text = f"{along.path} from {low:.5g} to {high:.5g}{units[0]}, {second.path} from {least:.5g} to {most:.5g}{units[1]}"
        a.line(f"curve of {_CURVES[c.bifurcation]}{of}: ", text)
        for p in points:
            place = f"{along.path} = {p['value']:.7g}{units[0]}, {second.path} = {p['second_value']:.7g}{units[1]}"
            a.line(f"  {p['kind']:16} ", place)


def _second_condition(
    along: Parameter, second: Parameter | None, steady_states: SteadyStates, curve: BifurcationCurve, i: int, speed: float
) -> dict[str, Any]:
    """Return the table of a point of a curve. A name of a parameter that is another key as well has that meaning."""
    value, second_value = curve.unknowns[-2:, i].tolist()
    of_second = {} if second is None else {second.path: second_value}
    of_machine = {} if steady_states.labels.of_equations else {"speed": speed}
    return {along.path: value} | of_second | {
        "value": value, "second_value": second_value, "kind": curve.kinds[i], **of_machine,
        "state": dict(steady_states.state_by_name(curve.unknowns[:-1, i])), "coefficients": dict(curve.coefficients[i]),
    }  # fmt: skip
