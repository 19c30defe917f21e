"""Findings -> the quantities of a branch of orbits, and its lines in a report."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.branches.first_orbits import LONGEST
from wucht.dynamics.branches.orbit_branches import PeriodicBranch
from wucht.dynamics.branches.orbit_diagram import MOST_BRANCHES, OrbitFindings, ReportedOrbit
from wucht.numerics.periodic.branch_ends import CLOSED_BRANCH, NOT_IDENTIFIED, PERIOD_LIMIT, BranchEnd, significant_value
from wucht.results.attributes import number_in, text_in
from wucht.results.formatting import formats
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.orbit_branch.computation import Plan
from wucht.studies.orbit_branch.orbit_tables import (
    end_quantities,
    orbit_quantities,
    ordinate_name,
    reported_quantities,
    steady_quantities,
)
from wucht.studies.shared_keys import entry_with_values

if TYPE_CHECKING:
    import xarray as xr


_PRODUCT = 0.1  # largest error of ln of the multipliers' product without a warning
_AT_A_LIMIT, _FARTHER = 1e-9, 10.0  # of the longest period: an end there; a longest period that is proposed
_MOST_LOST = 4  # sentences on branches that could not be followed
_ENDS = {
    "saddle-node-on-orbit": "a saddle-node on the orbit", "saddle-connection": "a saddle connection", "hopf": "a Hopf point",
    "range": "the end of the range", "period-limit": "the longest period that is followed (study.longest)",
    "not-identified": "an end that is not identified",
}  # fmt: skip


def dataset(plan: Plan, findings: OrbitFindings) -> xr.Dataset:
    """Return the Dataset of a branch of orbits."""
    ends = [(k, end) for k, branch in enumerate(findings.branches) for end in branch_ends(branch)]
    quantities = [
        *orbit_quantities(plan, findings.branches), *reported_quantities(plan, findings), *end_quantities(plan, ends),
        *steady_quantities(plan, findings),
        Quantity("law", ["saddle-node", "connection"], "law of the period", "", "law"),
        *_question_quantities(plan), *_table_quantities(plan, findings, ends),
    ]  # fmt: skip
    return result_dataset(
        quantities, _sentence(plan, findings, ends), _warnings(plan, findings),
        along=plan.along.path, along_unit=plan.along.unit, along_what=plan.along.full_name,
        low=plan.problem.bounds[0], high=plan.problem.bounds[1], shown=plan.problem.labels.ordinate,
        rotor=int(plan.problem.shows_rotor_speed), angles=int(plan.problem.turning.any()),
        state=plan.problem.labels.state or "", **({"subject": "system"} if plan.problem.labels.of_equations else {}),
    )  # fmt: skip


def branch_ends(branch: PeriodicBranch) -> list[BranchEnd]:
    """Return the ends of a branch, that at its first orbit before that at its last."""
    return [part.end for part in branch.parts]


def _pairs(values: np.ndarray) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in values]


def _orbit_entry(plan: Plan, branch: int, one: ReportedOrbit) -> dict[str, Any]:
    low, high = range_keys(plan)
    of_machine = {} if not plan.problem.shows_rotor_speed else {
        "period_phi": one.period_phi, "min_amplitude": one.least, "max_amplitude": one.largest,
        "exponents_phi": _pairs(one.exponents * (one.period / one.period_phi)),
    }  # fmt: skip
    return entry_with_values({
        "kind": one.kind or None, "branch": branch, "period": one.period, low: one.low, high: one.high,
        "exponents": _pairs(one.exponents), **of_machine,
        "stable": bool(one.exponents.real.max(initial=-np.inf) < 0) if not one.kind else None,
    }, [plan.along.path], [one.value])  # fmt: skip


def range_keys(plan: Plan) -> tuple[str, str]:
    """Return the names of the least and the largest value on an orbit: of the main rotor's speed, or of a state of a system."""
    return f"min_{ordinate_name(plan)}", f"max_{ordinate_name(plan)}"


def _advice(plan: Plan, longest: float, end: BranchEnd) -> str:
    """Return how to follow a branch farther that was left at the longest period; else nothing."""
    if end.kind not in (PERIOD_LIMIT, NOT_IDENTIFIED) or end.period < (1 - _AT_A_LIMIT) * longest:
        return ""
    default = "" if plan.case.settings.longest is not None else f" (by default it is {LONGEST:.0f} times the first period)"
    farther = float(f"{_FARTHER * longest:.1g}")
    return f"; study.longest = {farther:g} follows the branch farther{default}"


def _end_entry(plan: Plan, branch: int, end: BranchEnd, advice: str = "") -> dict[str, Any]:
    node, connection = end.saddle_node, end.connection
    names = plan.problem.system.state_names
    return entry_with_values({
        "kind": end.kind, "branch": branch, "error": end.error, "period": end.period,
        "sentence": end.sentence + advice,
        "state": dict(zip(names, end.equilibrium.tolist(), strict=True)) if len(end.equilibrium) else None,
        "eigenvalues": _pairs(end.eigenvalues),
        "laws": None if node is None or connection is None else {
            "saddle-node": {"critical": node.critical, "error": node.error, "factor": node.factor, "residual": node.residual},
            "connection": {
                "critical": connection.critical, "error": connection.error, "rate": 1 / connection.factor,
                "residual": connection.residual,
            },
        },
    }, [plan.along.path], [end.parameter])  # fmt: skip


def _special_entries(plan: Plan, findings: OrbitFindings) -> list[dict[str, Any]]:
    entries, bounds = [], plan.problem.bounds
    for k, branch in enumerate(findings.branches):
        values, periods = branch.whole_array("values"), branch.whole_array("periods")
        mean, low, high = (branch.whole_array(name) for name in ("mean", "low", "high"))
        for i in np.flatnonzero([bool(kind) for kind in branch.kinds]).tolist():
            phi = {"period_phi": float(periods[i] * abs(mean[i]))} if plan.problem.shows_rotor_speed else {}
            entries.append(entry_with_values({
                "kind": branch.kinds[i], "branch": k, "period": float(periods[i]),
                **phi, **dict(zip(range_keys(plan), (float(low[i]), float(high[i])), strict=True)),
                **({} if (hidden := branch.hidden_points[i]) is None else {"hidden": hidden.kind,
                "between": list(hidden.interval)}),
            }, [plan.along.path], [significant_value(float(values[i]), bounds)], ["hidden", "between"]))  # fmt: skip
    return entries


def _branch_entries(plan: Plan, findings: OrbitFindings) -> list[dict[str, Any]]:
    entries = []
    for branch in findings.branches:
        values, kinds = branch.whole_array("values"), np.array([bool(kind) for kind in branch.kinds])
        stretches = _stretches(branch.whole_array("stable") & ~kinds, kinds)
        limits = [_limits(branch, values, i, j) for i, j in stretches]
        if (
            len(limits) > 1
            and branch.onward.end.kind == CLOSED_BRANCH
            and stretches[0][0] == 0
            and stretches[-1][1] == len(values)
        ):
            first, last = limits[0], limits.pop()  # one stretch, on either side of the first orbit
            limits[0] = [min(first[0], last[0]), max(first[1], last[1])]
        entries.append({
            "begun": branch.seed.origin, "range": _significant_range(plan, values.min(), values.max()),
            "winding": plan.problem.turns(branch.seed.winding), "stable": [_significant_range(plan, *pair) for pair in limits],
        })  # fmt: skip
    return entries


def _limits(branch: PeriodicBranch, values: np.ndarray, begin: int, end: int) -> list[float]:
    """Return the range of a stretch of orbits, extended to the end of the branch if its last orbit is one of them."""
    inside = [*values[begin:end].tolist()]
    if end == len(values):
        inside.append(branch.onward.end.parameter)
    if begin == 0 and branch.backward is not None:
        inside.append(branch.backward.end.parameter)
    return [float(min(inside)), float(max(inside))]


def _stretches(stable: np.ndarray, special: np.ndarray) -> list[tuple[int, int]]:
    """Return the first and one past the last orbit of each stable stretch, with the special orbits at its ends."""
    edges = np.flatnonzero(np.diff(np.concatenate([[0], (stable | special).astype(int), [0]])))
    pairs = list(zip(edges[::2].tolist(), edges[1::2].tolist(), strict=True))
    return [(i, j) for i, j in pairs if stable[i:j].any()]


def _question_quantities(plan: Plan) -> list[Quantity]:
    along, problem = plan.along, plan.problem
    return [
        Quantity("along", along.path, "parameter over which branches are followed"),
        Quantity("along_unit", along.unit, "its unit"),
        Quantity("range", list(plan.problem.bounds), f"range of the {along.full_name}", along.unit),
        Quantity("inertia", problem.labels.inertia, "whether the averaged equations keep the inertia of the balancing bodies"),
        Quantity("section", problem.embedding is not None, "whether the phases of bodies are kept equal"),
    ]


def _table_quantities(plan: Plan, findings: OrbitFindings, ends: list[tuple[int, BranchEnd]]) -> list[Quantity]:
    s, value, (least, largest) = plan.problem.labels, (plan.along.full_name, plan.along.unit), range_keys(plan)
    place = {plan.along.path: value, "value": value, "branch": ("branch", ""), "period": ("period", s.time)}
    motion = {
        "kind": ("kind of the special orbit", ""), "period_phi": ("period in the angle of the main rotor", ""),
        least: (f"least {s.ordinate}", s.unit), largest: (f"largest {s.ordinate}", s.unit),
    }  # fmt: skip
    orbit_columns = {
        "min_amplitude": ("least amplitude of the axis", s.length),
        "max_amplitude": ("largest amplitude of the axis", s.length), "stable": ("whether it is stable", ""),
        "exponents": ("exponents", s.rate), "exponents_phi": ("exponents over the angle of the main rotor", ""),
    }  # fmt: skip
    hidden = {"hidden": ("kind of a point that was not located", ""), "between": value}
    end_columns = {
        "kind": ("kind of the end", ""), "error": (f"error of {value[0]}", value[1]), "sentence": ("how the branch ends", ""),
        "state": ("states of the equilibrium there", ""), "eigenvalues": ("eigenvalues of the equilibrium there", s.rate),
        "laws": ("laws of the period", ""), "critical": value, "rate": ("rate of a connection's law", s.rate),
    }  # fmt: skip
    branch_columns = {
        "begun": ("origin of the branch", ""), "range": value, "winding": ("turns of the angles in a period", ""),
        "stable": (f"ranges of the {value[0]} in which orbits are stable", value[1]),
    }  # fmt: skip
    run_columns = {plan.along.path: value, "value": value, "found": ("result of the run", "")}
    reported_orbits, search_runs = (
        findings.orbits,
        [entry_with_values({"found": t.sentence}, [plan.along.path], [t.value]) for t in findings.runs],
    )
    end_entries = [_end_entry(plan, k, end, _advice(plan, findings.branches[k].seed.longest, end)) for k, end in ends]
    return [
        *table("orbits", [_orbit_entry(plan, k, one) for k, one in reported_orbits], "orbits", place | motion | orbit_columns),
        *table("special_points", _special_entries(plan, findings), "special orbits", place | motion | hidden),
        *table("ends", end_entries, "ends of the branches", place | end_columns),
        *table("branches", _branch_entries(plan, findings), "branches of orbits", branch_columns),
        *table("tried", search_runs, "runs in search of a first orbit", run_columns),
    ]


def _sentence(plan: Plan, findings: OrbitFindings, ends: list[tuple[int, BranchEnd]]) -> str:
    path = plan.along.sentence_name
    if not findings.branches:
        if not findings.complete:
            return "the study was interrupted before the first orbit"
        results = "; ".join(t.sentence for t in findings.runs)
        if any(t.is_family for t in findings.runs):
            return f"the motions are families, of which none attracts: there is no single orbit to follow: {results}"
        return f"no modulated motion was found: {results}" + (
            f"; {plan.case.no_steady_reason}" if plan.case.no_steady_reason else ""
        )
    values = findings.branches[0].whole_array("values")
    first_ends = sorted((e for k, e in ends if k == 0), key=lambda e: e.parameter)
    extent = _significant_range(plan, min(values.min(), first_ends[0].parameter), max(values.max(), first_ends[-1].parameter))
    names = [_ENDS.get(e.kind, e.kind.replace("-", " ")) for e in first_ends]
    ending = f"both ends are {names[0]}" if len(set(names)) == 1 and len(names) > 1 else f"it ends at {' and at '.join(names)}"
    ending = "it is closed" if first_ends[0].kind == CLOSED_BRANCH else ending
    stretches = _branch_entries(plan, findings)[0]["stable"]
    stable = ", ".join(_range_text(ends, plan.along.unit) for ends in stretches)
    within = " within their section" if plan.problem.embedding is not None else ""
    stability = f"stable{within} from {stable}" if stable else "nowhere stable"
    further_branches = len(findings.branches) - 1
    more = (
        ""
        if not further_branches
        else f"; {'one more branch' if further_branches == 1 else f'{further_branches} more branches'}"
    )
    motions = "modulated motions" if plan.problem.shows_rotor_speed else "periodic orbits"
    return f"{motions} at {path} from {_range_text(extent, plan.along.unit)}, {stability}; {ending}{more}"


def _range_text(ends: Sequence[float], unit: str) -> str:
    return f"{ends[0]:.7g} to {ends[1]:.7g} {unit}".rstrip()


def _significant_range(plan: Plan, low: float, high: float) -> list[float]:
    """Return the ends of a part of the parameter's range, without rounding errors of 0."""
    return [significant_value(float(end), plan.problem.bounds) for end in (low, high)]


def _warnings(plan: Plan, findings: OrbitFindings) -> list[str]:
    """Return warnings on omissions, doubts, and unfinished work."""
    lines = [*plan.problem.labels.warnings, *findings.omissions[:_MOST_LOST]]
    if len(findings.omissions) > _MOST_LOST:
        lines.append(f"and {len(findings.omissions) - _MOST_LOST} more")
    if plan.case.no_steady_reason and findings.branches and not plan.case.no_steady_reason.startswith("equilibria"):
        lines.append(plan.case.no_steady_reason)
    errors = [(b.whole_array("product_error"), b.whole_array("is_trusted")) for b in findings.branches]
    wrong = np.concatenate([np.empty(0), *(error[is_trusted] for error, is_trusted in errors)])
    if (wrong > _PRODUCT).any():
        lines.append(
            f"of {(wrong > _PRODUCT).sum()} orbits the fastest decays are unknown: the product of the multipliers differs from "
            "that which the divergence of the equations demands"
        )
    excess = np.concatenate([np.empty(0), *(b.whole_array("excess_error") for b in findings.branches)])
    if excess.any():
        lines.append(
            f"{(excess > 0).sum()} orbits change too fast for the finest mesh: between its points their states are known to "
            f"{excess.max():.1g} of their range only"
        )
    if len(findings.branches) >= MOST_BRANCHES:
        lines.append(f"more than {MOST_BRANCHES} branches: the others are left out")
    requested_values = plan.case.values if plan.case.values is not None else ()
    missing = [v for v in requested_values if not any(one.value == v for _, one in findings.orbits)]
    if findings.complete and findings.branches and missing:
        lines.append(f"there is no orbit of a known branch at {plan.along.path} = {', '.join(f'{v:.6g}' for v in missing)}")
    if not findings.complete:
        lines.append("the search is not finished")
    return lines


_MOST = 16  # orbits, and special points, named one by one


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a branch of orbits."""
    s = result.wucht.summary
    lines, along, unit = [result.attrs["title"], f"verdict: {s['sentence']}"], s["along"], f" {s['along_unit']}".rstrip()
    for k, branch in enumerate(s["branches"]):
        extent, *stable_stretches = (_range_text(ends, s["along_unit"]) for ends in (branch["range"], *branch["stable"]))
        winding = ", ".join(f"{name} {turns:+d}" for name, turns in branch["winding"].items())
        rotation = f"; turns a period: {winding}" if winding else "; all angles return" if number_in(result, "angles") else ""
        stable = f"stable at {along} from {', '.join(stable_stretches)}" if stable_stretches else "nowhere stable"
        lines.append(f"  branch {k + 1}     from {branch['begun']}: {along} from {extent}, {stable}{rotation}")
        lines += [f"    end        {end['sentence']}" for end in s["ends"] if end["branch"] == k]
    for p in s["special_points"][:_MOST]:
        location = f"{along} = {p['value']:.8g}{unit}"
        if "hidden" in p:
            location = (
                f"{along} from {p['between'][0]:.8g} to {p['between'][1]:.8g}{unit}: a {p['hidden']} that was not located"
            )
        lines.append(f"  {p['kind']:12} {location}: {_period(result, p)}")
    lines += [_orbit_line(result, o, along, unit) for o in s["orbits"][:_MOST] if not o["kind"]]
    if len(s["orbits"]) > _MOST:
        lines.append(f"  and {len(s['orbits']) - _MOST} more orbits: see the Dataset")
    if number_in(result, "rotor") and s["branches"]:
        disturbances = "disturbances with equal phases of the bodies only" if s["section"] else "all disturbances"
        lines.append(f"  stability    in the averaged equations, of {disturbances}; exponents: per unit of time")
    return lines


def _period(result: xr.Dataset, one: dict[str, Any]) -> str:
    time = str(result.period.attrs["units"])
    phi = f" ({one['period_phi']:.8g} of the rotor's angle)" if "period_phi" in one else ""
    return f"period {one['period']:.8g} {time}".rstrip() + phi


def _orbit_line(result: xr.Dataset, o: dict[str, Any], along: str, unit: str) -> str:
    speed = formats(result)[0] if number_in(result, "rotor") else "{:.6g}".format
    largest = o["exponents"][0] if o["exponents"] else None
    word = "" if o["stable"] is None else (", stable" if o["stable"] else ", unstable")
    growth = "" if largest is None else f", largest exponent {largest[0]:.5g}{word}"
    state = text_in(result, "state")
    low, high = (speed(o[f"{end}_{state or 'speed'}"]) for end in ("min", "max"))
    range_ = f"{state} {low} to {high}".lstrip()
    return f"  orbit        {along} = {o['value']:.9g}{unit}: {_period(result, o)}, {range_}{growth}"
