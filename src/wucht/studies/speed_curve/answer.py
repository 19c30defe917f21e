"""The answer of a speed curve: points, branches, special points, states at the subject's value, curves in two parameters."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import sympy as sp

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, BranchFindings
from wucht.dynamics.branches.equilibrium_branches import ALL_STABLE, SOME_STABLE, EquilibriumBranch, StabilityLevel
from wucht.dynamics.branches.family_curve import SAMPLED_MEMBERS
from wucht.dynamics.branches.special_states import SpecialState, special_states
from wucht.schema import Parameter
from wucht.studies.answer import Answer
from wucht.studies.motion_variables import join_arrays, state_steady_points
from wucht.studies.speed_curve import steady_state_tables as tables

_MOST_LOST = 3  # sentences on states that could not be followed
_WORDS = {
    "hopf": ("Hopf point", "Hopf points"),
    "branch-point": ("branch point", "branch points"),
    "generalised-hopf": ("generalised Hopf point", "generalised Hopf points"),
    "double-hopf": ("double Hopf point", "double Hopf points"),
    "zero-hopf": ("zero-Hopf point", "zero-Hopf points"),
    "bogdanov-takens": ("Bogdanov-Takens point", "Bogdanov-Takens points"),
    "unresolved": ("change that was not resolved", "changes that were not resolved"),
}


def state_speeds(a: Answer, along: Parameter, second: Parameter | None, case: BranchCase, findings: BranchFindings) -> None:
    """State the answer, as far as branches are followed."""
    steady_states, bounds = case.steady_states, case.steady_states.bounds
    labels, special_points = steady_states.labels, special_states(case, findings.branches)
    a.sentence = _sentence(along, second, case, findings, special_points)
    a.attribute(
        along=along.path, along_unit=along.unit, along_what=along.full_name, along_symbol=_symbol(along.path), low=bounds[0],
        high=bounds[1], shown=labels.ordinate, **({"subject": "system"} if labels.of_equations else {}),
    )  # fmt: skip
    if second is not None:
        symbol = _symbol(second.path)
        a.attribute(second=second.path, second_unit=second.unit, second_what=second.full_name, second_symbol=symbol)
    a.number("along", along.path, "parameter over which branches are followed")
    a.number("along_unit", along.unit, "its unit")
    a.number("range", list(bounds), f"range of the {along.full_name}", along.unit)
    a.number("second", second and second.path, "second parameter")
    a.number("second_unit", second and second.unit, "its unit")
    begin = case.plane and case.plane.value
    a.number("second_value", begin, "second parameter where the curves begin", second.unit if second else "")
    a.number("show", labels.state, "state that is drawn instead of the speed")
    a.number("inertia", labels.inertia, "whether the averaged equations keep the inertia of the balancing bodies")
    _state_points(a, along, case, findings.branches)
    tables.state_branches(a, along, second, case, findings.branches)
    tables.state_special_points(a, along, second, case, special_points)
    lines = tables.state_nominal_states(a, along, case, findings)
    tables.state_special_curves(a, along, second, case, findings.curves)
    for heading, text, at in lines:
        a.line(heading, text, at=at)
    a.curve("state_name", list(steady_states.names), "state of the equations", "", "state", coordinate=True)
    _state_searches(a, along, findings, labels.speed)
    if labels.inertia is not None:
        a.line("stability", "in the averaged equations; study.kind = 'synchronous-states' has that in the full equations")
        a.line("left out", "motions with bodies of different mean speeds, or with modulated speed; of these study.kind = "
                           "'orbit-branch' has the modulated ones")  # fmt: skip
    _warn(a, along, case, findings)


def _symbol(path: str) -> str:
    """Return a parameter's label in a figure: a single name is a symbol."""
    return f"${sp.latex(sp.Symbol(path))}$" if path.isidentifier() else path


def _count_phrase(number: int, one: str, several: str) -> str:
    """Return a number with its noun: ``one fold``, ``3 folds``."""
    return f"one {one}" if number == 1 else f"{number} {several}"


def _kinds_phrase(kinds: Sequence[str]) -> str:
    """Return the numbers of points by kind: ``2 folds, one Hopf point``; empty without points."""
    return ", ".join(
        _count_phrase(kinds.count(kind), *_WORDS.get(kind, (kind.replace("-", " "), f"{kind.replace('-', ' ')}s")))
        for kind in dict.fromkeys(kinds)
    )


def _state_points(a: Answer, along: Parameter, case: BranchCase, branches: Sequence[EquilibriumBranch]) -> None:
    """State the points of all branches."""
    labels, n = case.steady_states.labels, len(case.steady_states.names)
    exponents = join_arrays([b.exponents for b in branches], n)
    shares = [np.array(b.stable_share) if b.stable_share else np.full(b.unknowns.shape[1], np.nan) for b in branches]
    at_special = join_arrays([np.array([bool(kind) for kind in b.kinds]) for b in branches])
    state_steady_points(a, "point", "", branches, [case.states_by_second_value[b.second] for b in branches], along, labels)
    a.curve("unstable", join_arrays([b.unstable for b in branches]).astype(int), "number of growing disturbances", "", "point")
    a.curve("stable_share", join_arrays(shares), "share of a family's members that are stable", "", "point")
    a.curve("at_special", at_special.astype(np.int8), "a special point", "", "point")
    a.curve("state", join_arrays([b.unknowns[:-1] for b in branches], n), "states of the equations", "", "state point")
    a.curve("exponent_re", np.asarray(exponents.real), "real part of an exponent", labels.rate, "exponent point")
    a.curve("exponent_im", np.asarray(exponents.imag), "imaginary part of an exponent", labels.rate, "exponent point")


def _state_searches(a: Answer, along: Parameter, findings: BranchFindings, speed_unit: str) -> None:
    """State the values at which all states were searched, and whether they are known there."""
    searches, is_complete = findings.searches, findings.knows_all_states
    values = [s.value for s in searches if s.failure is None]
    a.curve("searched_value", [s.value for s in searches], along.full_name, along.unit, "search")
    counts = [len(s.points) + len(s.families) for s in searches]
    a.curve("searched_states", np.array(counts, int), "number of states there", "", "search")
    a.number("searched", values, f"{along.full_name} at which all states were searched for", along.unit)
    a.number("complete", is_complete, "whether all states are known there")
    a.number("shown", findings.evidence(speed_unit), "evidence for that")
    if values:
        place = f"{'yes' if is_complete else 'not proved'} at {_count_phrase(len(values), 'value', 'values')} of {along.path}"
        a.line("complete", place + ": {shown}; only branches between these values may be missing")


def _sentence(
    along: Parameter, second: Parameter | None, case: BranchCase, findings: BranchFindings, points: Sequence[SpecialState]
) -> str:
    branches, (low, high) = findings.branches, case.steady_states.bounds
    if not branches:
        if not findings.complete:
            return "the study was interrupted before the first branch"
        of = f" {' or '.join(case.only)}," if case.only else ""
        return f"no steady states were found,{of} between {along.value_text(low, 5)} and {high:.5g}"
    stable = sum(bool(b.intervals(StabilityLevel.STABLE)) for b in branches)
    partly = sum(bool(b.intervals(StabilityLevel.PARTLY_STABLE)) for b in branches)
    count = _count_phrase(len(branches), "branch of steady states", "branches of steady states")
    part = f"{stable} of them stable somewhere"
    if len(branches) == 1:
        part = "stable somewhere" if stable else "nowhere stable"
    elif not stable:
        part = f"none of them stable {'with all members' if partly else 'anywhere'}"
    if partly:
        part += f", {_count_phrase(partly, 'family', 'families')} with members that are stable and others that are not"
    kinds = [s.kind for s in points if s.kind not in (SOME_STABLE, ALL_STABLE)]
    sentence = f"{count}, {part}; {_kinds_phrase(kinds) or 'no special point'}"
    if case.plane is None:
        return sentence
    of_curves = _kinds_phrase([kind for c in findings.curves for kind in c.kinds if kind])
    many = _count_phrase(len(findings.curves), "curve", "curves")
    sentence += f"; {many} of them in {along.sentence_name} and {second.sentence_name if second else case.plane.path}"
    return sentence + (f" with {of_curves}" if of_curves else "")


def _warn(a: Answer, along: Parameter, case: BranchCase, findings: BranchFindings) -> None:
    """Warn of omissions, doubts, and unfinished work."""
    a.warn(*case.steady_states.labels.warnings)
    for failure in dict.fromkeys(s.failure for s in findings.searches if s.failure):
        at = [s.value for s in findings.searches if s.failure == failure]
        several = f"{len(at)} values of {along.path} from {min(at):.5g} to {max(at):.5g}"
        place = f"{along.path} = {at[0]:.5g}" if len(at) == 1 else several
        a.warn(f"at {place} states could not be searched for: {failure}")
    a.warn(*findings.omissions[:_MOST_LOST])
    if len(findings.omissions) > _MOST_LOST:
        a.warn(f"and {len(findings.omissions) - _MOST_LOST} more states")
    incomplete = next((s for s in findings.searches if s.failure is None and not s.complete), None)
    if incomplete is not None:
        a.warn(f"it is not proved that all states are known: {incomplete.evidence}")
    _warn_of_stability(a, along, findings)
    if not findings.complete:
        count = _count_phrase(len(findings.branches), "branch is", "branches are")
        a.warn(f"{count} followed; the search is not finished")


def _warn_of_stability(a: Answer, along: Parameter, findings: BranchFindings) -> None:
    """Warn of changes of stability that are not located, and of what is known of the stability of families."""
    for k, b in enumerate(findings.branches):
        gaps = [f"{b.parameter_values[i]:.5g} and {b.parameter_values[j]:.5g}" for i, j in b.unlocated_changes]
        if gaps:
            more = f", and at {len(gaps) - 1} more places" if len(gaps) > 1 else ""
            place = f"between {along.path} = {gaps[0]}{more}"
            a.warn(f"on branch {k + 1} stability changes {place}: no fold, Hopf or branch point was located there")
    families = sorted({b.dimension for b in findings.branches if b.dimension})
    if families:
        of = " and ".join(map(str, families))
        explanation = "one member represents each where a state is listed; its exponents are those transverse to the family"
        a.warn(f"the states in which the unbalances compensate form families of dimension {of}: {explanation}")
    if any(b.intervals(StabilityLevel.PARTLY_STABLE) for b in findings.branches):
        a.warn(
            f"of a family {SAMPLED_MEMBERS} members are examined: these alone decide where some are stable, and where all are; "
            "the limits of rare members may be wider"
        )
