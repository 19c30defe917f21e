"""Findings -> the Dataset of a speed curve, with the answer in numbers and in words."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.conventions import answered, variable
from wucht.studies.speed_curve.curve_variables import Special, of_branches, of_curves, of_own, of_points, of_specials, specials
from wucht.studies.speed_curve.prepare import Plan
from wucht.studies.speed_curve.report import counted, in_words, label_of
from wucht.studies.speed_curve.run import Findings

if TYPE_CHECKING:
    import xarray as xr

_MOST_LOST = 3  # sentences on what could not be followed
_AT_ZERO = 1e-9  # of the range: a value so near to zero is zero


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of a speed curve.

    Points of all branches, one after another (point): value of the parameter, speed of the main rotor with its sign (or the
    state that was chosen), amplitude, stable, unstable (how many disturbances grow), at_special, branch; state (state, point),
    those of the equations, in the bodies' own senses, angles as they have turned; exponent_re, exponent_im (exponent, point),
    not numbers where a family has less; stable_share of a family's members. Of branches (branch): branch_name, branch_type,
    branch_label, family_dimension, multiplicity, second_value. Special points (special): special_kind, special_value,
    special_speed, special_amplitude, special_branch, special_frequency, special_state (state, special). States at the subject's
    own value (own): own_speed, own_amplitude, own_stable, own_branch, own_growth. Curves in two parameters (curve_point):
    curve_value, curve_second, curve_speed, curve, curve_kind (of a point where a second condition holds); curve_of,
    curve_label (curve). searched_value, searched_states (search).
    """
    import xarray as xr_

    found, states = specials(plan, findings), plan.curves[0][1]
    data = of_points(plan, findings.branches) | of_branches(plan, findings.branches) | of_specials(plan, found)
    own = _own(plan, findings)
    data |= of_own(plan, own) | (of_curves(plan, findings.curves) if plan.plane is not None else {})
    data["searched_value"] = variable("search", [s.value for s in findings.searched], plan.along.what, plan.along.unit)
    data["searched_states"] = variable("search", np.array([s.states for s in findings.searched], int), "states found there")
    coordinates = {"state_name": variable("state", list(states.names), "state of the equations")}
    summary = _summary(plan, findings, found, own)
    second = plan.second
    more = {} if second is None else {"second": second.path, "second_unit": second.unit, "second_what": second.what}
    return answered(
        xr_.Dataset(data, coords=coordinates), summary, summary["sentence"], _warnings(plan, findings),
        along=plan.along.path, along_unit=plan.along.unit, along_what=plan.along.what, low=plan.bounds[0], high=plan.bounds[1],
        shown=states.words.shown, **more,
    )  # fmt: skip


def _own(plan: Plan, findings: Findings) -> list[dict[str, Any]]:
    """The states at the subject's own value, the fastest first."""
    made, states = [], plan.curves[0][1]
    for own in findings.own:
        branch, shown = findings.branches[own.branch], states.shown(own.u[:, None])
        speed = float(shown.speed[0])
        kind = states.kind(own.u) if not branch.dimension else branch.kind
        exponents = own.exponents[np.isfinite(own.exponents)]
        exponents = exponents[np.argsort(-exponents.real, kind="stable")]
        made.append({
            "name": kind.name, "type": kind.type, "speed": speed, "amplitude": float(shown.amplitude[0]),
            "stable": bool(exponents[0].real < 0), "branch": own.branch, "state": dict(states.stated(own.u)),
            "family_dimension": branch.dimension,
            "exponents": [[float(e.real), float(e.imag)] for e in exponents],
            "exponents_phi": _by_angle(plan, exponents, speed),
        })  # fmt: skip
    return sorted(made, key=lambda s: -abs(s["speed"]))


def _by_angle(plan: Plan, exponents: np.ndarray, speed: float) -> list[list[float]] | None:
    """Exponents by the rotor's angle instead of time; None where what is drawn is no speed."""
    if plan.curves[0][1].words.shown != "speed of the main rotor" or not speed:
        return None
    return [[float(e.real) / abs(speed), float(e.imag) / abs(speed)] for e in exponents]


def _summary(
    plan: Plan, findings: Findings, found: Sequence[Special], own: Sequence[Mapping[str, Any]]
) -> dict[str, Any]:  # fmt: skip
    path, second, searched = plan.along.path, plan.second, findings.searched
    return {
        "sentence": _sentence(plan, findings, found),
        "along": path,
        "along_unit": plan.along.unit,
        "range": list(plan.bounds),
        "second": None if second is None else second.path,
        "second_unit": None if second is None else second.unit,
        "second_value": None if plan.plane is None else plan.plane.value,
        "inertia": getattr(plan.curves[0][1], "inertia", None),
        "special_points": [_of_special(plan, s) for s in found],
        "branches": _branches(plan, findings),
        "value": plan.curves[0][1].own_value,
        "states": list(own),
        "curves": _curves(plan, findings),
        "searched": [s.value for s in searched if s.failure is None],
        "complete": bool(searched) and all(s.complete for s in searched),
        "shown": next((s.shown for s in searched if not s.complete and s.shown), searched[0].shown if searched else ""),
    }


def _near_zero(plan: Plan, value: float) -> float:
    return 0.0 if abs(value) < _AT_ZERO * (plan.bounds[1] - plan.bounds[0]) else float(value)


def _of_special(plan: Plan, s: Special) -> dict[str, Any]:
    states = dict(plan.curves)[s.second]
    second = {} if plan.second is None or s.second is None else {plan.second.path: s.second}
    return {
        "kind": s.kind, plan.along.path: float(s.u[-1]), **second, "speed": s.speed, "state": dict(states.stated(s.u)),
        "amplitude": s.amplitude, "branch": s.branch, "frequency": s.frequency,
    }  # fmt: skip


def _branches(plan: Plan, findings: Findings) -> list[dict[str, Any]]:
    listed = []
    for b in findings.branches:
        speeds, stretches = dict(plan.curves)[b.second].shown(b.u).speed, b.stable_intervals
        spans = [b.values[i : k + 1] for i, k in stretches]
        second = {} if plan.second is None or b.second is None else {plan.second.path: b.second}
        listed.append({
            "type": b.kind.type, "name": b.kind.name, **second, "label": label_of(b.kind.name, b.kind.type, b.kind.split),
            "stable": [[_near_zero(plan, v.min()), _near_zero(plan, v.max())] for v in spans],
            "stable_speeds": [[float(speeds[i]), float(speeds[k])] for i, k in stretches],
            "range": [_near_zero(plan, b.values.min()), _near_zero(plan, b.values.max())], "ends": list(b.ends),
            "family_dimension": b.dimension, "multiplicity": b.kind.multiplicity,
        })  # fmt: skip
    return listed


def _curves(plan: Plan, findings: Findings) -> list[dict[str, Any]]:
    """Of folds and Hopf points in two parameters, with the points on them where a second condition holds."""
    if plan.plane is None:
        return []
    listed, states = [], plan.curves[0][1]
    for c in findings.curves:
        speeds = states.shown(c.u[:-1]).speed
        special = [
            {
                "kind": c.kinds[i], plan.along.path: float(c.u[-2, i]), plan.plane.path: float(c.u[-1, i]),
                "speed": float(speeds[i]), "state": dict(states.stated(c.u[:-1, i])), "coefficients": dict(c.coefficients[i]),
            }
            for i in np.flatnonzero([bool(kind) for kind in c.kinds]).tolist()
        ]  # fmt: skip
        listed.append({
            "of": c.of, "type": c.kind.type, "name": c.kind.name,
            "range": [float(c.u[-2].min()), float(c.u[-2].max())],
            "second_range": [float(c.u[-1].min()), float(c.u[-1].max())],
            "special_points": special, "ends": list(c.ends),
        })  # fmt: skip
    return listed


def _sentence(plan: Plan, findings: Findings, found: Sequence[Special]) -> str:
    branches, (low, high) = findings.branches, plan.bounds
    if not branches:
        if not findings.complete:
            return "the study was interrupted before a branch was found"
        of = f" {' or '.join(plan.spec.only)}," if plan.spec.only else ""
        return f"no steady states were found,{of} between {plan.along.path} = {low:.5g} and {high:.5g}"
    stable = sum(bool(b.stable_intervals) for b in branches)
    count = counted(len(branches), "branch of steady states", "branches of steady states")
    part = f"{stable or 'none'} of them stable somewhere"
    if len(branches) == 1:
        part = "stable somewhere" if stable else "nowhere stable"
    sentence = f"{count}, {part}; {in_words([s.kind for s in found]) or 'no special point'}"
    if plan.plane is not None:
        second = [kind for c in findings.curves for kind in c.kinds if kind]
        many = counted(len(findings.curves), "curve", "curves")
        sentence += f"; {many} of them in {plan.along.path} and {plan.plane.path}"
        sentence += f" with {in_words(second)}" if second else ""
    return sentence


def _warnings(plan: Plan, findings: Findings) -> list[str]:
    """What is left out, doubtful, or not yet done."""
    states, path = plan.curves[0][1], plan.along.path
    lines = [*states.words.warnings]
    lines += [f"at {path} = {s.value:.5g} states could not be searched: {s.failure}" for s in findings.searched if s.failure]
    lines += [*findings.lost[:_MOST_LOST]]
    if len(findings.lost) > _MOST_LOST:
        lines.append(f"so are {len(findings.lost) - _MOST_LOST} more states")
    incomplete = next((s for s in findings.searched if s.failure is None and not s.complete), None)
    if incomplete is not None:
        lines.append(f"it is not shown that all states were found: {incomplete.shown}")
    families = sorted({b.dimension for b in findings.branches if b.dimension})
    if families:
        of = " and ".join(map(str, families))
        why = "one member stands for each, and its exponents are those transverse to the family"
        lines.append(f"the states in which the unbalances compensate form families of dimension {of}: {why}")
        shares = [share for b in findings.branches for share in b.stable_share]
        if any(0 < share < 1 for share in shares):
            lines.append(f"of such a family {100 * min(shares):.0f} to {100 * max(shares):.0f} % are stable along the branch")
    if not findings.complete:
        lines.append(f"{counted(len(findings.branches), 'branch is', 'branches are')} followed; the search is not finished")
    return lines
