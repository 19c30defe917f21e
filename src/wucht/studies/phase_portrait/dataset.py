"""Findings -> the quantities of phase portraits, and their lines in a report."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import replace
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.phase_plane.fixed_points import DEGENERATE, SADDLE, STABLE, FixedPoint
from wucht.numerics.phase_plane.manifolds import Manifold
from wucht.numerics.phase_plane.phase_curves import CLOSED_CURVE, FAILURE, FIXED_POINT, KINKS, LENGTH, PhaseCurve
from wucht.results.attributes import text_in
from wucht.results.quantities import Quantity, result_dataset, table
from wucht.studies.phase_portrait.computation import Findings, Plan, PortraitCase, PortraitFindings
from wucht.studies.phase_portrait.state_projection import (
    ProjectionFindings,
    ProjectionPlan,
    projection_dataset,
    projection_report,
)

if TYPE_CHECKING:
    import xarray as xr


_GRID = 161  # points a side of the grid of rates for nullclines


def dataset(plan: Plan | ProjectionPlan, findings: Findings | ProjectionFindings) -> xr.Dataset:
    """Return the Dataset of phase portraits. Of several, each variable has them along its first dimension."""
    if isinstance(findings, ProjectionFindings):
        return projection_dataset(findings)
    assert isinstance(plan, Plan)
    pairs = list(zip(plan.cases, findings.portraits, strict=False))  # a portrait may be missing
    along, section = plan.spec.along, plan.cases[0].section
    case_quantities, quantities = [_case_quantities(plan, *pair) for pair in pairs], _variables(plan, findings.portraits)
    sentences = [_sentence(portrait) for _, portrait in pairs]
    if along is None:
        quantities = [*map(_single_case, quantities), *case_quantities[0]]
    else:
        quantities += [
            Quantity("case", [c.label for c, _ in pairs], "case", "", "case"),
            Quantity("value", [c.value for c, _ in pairs], along, "", "case", coordinate=True),
            Quantity("along", along, "parameter that differs"),
            *_cases_table(case_quantities, sentences),
        ]
    if section is not None:
        quantities += [
            Quantity("model", "averaged", "equations"),
            Quantity("inertia", section.inertia, "whether they keep the inertia of the balancing bodies"),
            Quantity("order", section.order, "their order"),
        ]
    clauses = [f"{case.label}: {one}" if case.label else one for (case, _), one in zip(pairs, sentences, strict=True)]
    sentence = (f"{plan.model}: " if plan.model else "") + "; ".join(clauses)
    warnings = [*plan.warnings, *(w for case, portrait in pairs for w in _warnings(plan, case, portrait))]
    if len(pairs) < len(plan.cases):
        warnings.append(f"{len(pairs)} of {len(plan.cases)} portraits are finished")
    assumptions = [plan.model] if plan.model else []
    return result_dataset(
        quantities, sentence, warnings, assumptions, abscissa=_abscissa(plan), section=int(bool(plan.model)), model=plan.model
    )


def _single_case(q: Quantity) -> Quantity:
    along, _, inner = (q.dimensions or "").partition(" ")
    return replace(q, value=q.value[0], dimensions=inner) if along == "case" else q


def _variables(plan: Plan, portraits: Sequence[PortraitFindings]) -> list[Quantity]:
    return [
        Quantity("state", [a.name for a in plan.axes], "state", "", "state"),
        Quantity("state_label", [a.long_name for a in plan.axes], "name of the state", "", "state", coordinate=True),
        Quantity("state_unit", [a.unit for a in plan.axes], "unit of the state", "", "state", coordinate=True),
        Quantity("turn", plan.cases[0].plane.turns, "turn of an angle, 0 of another state", "rad", "state", coordinate=True),
        *_point_quantities(plan, portraits),
        *_curve_quantities(plan, portraits),
        *([_rates(plan, len(portraits))] if plan.spec.nullclines else []),
        Quantity("drawn", plan.drawn_ranges, "range of the figure", "", "state end"),
    ]


def _abscissa(plan: Plan) -> int:
    """Return the index of the state along the abscissa: the only angle, else the first state."""
    turning = plan.cases[0].plane.turns > 0
    return int(turning.argmax()) if turning.sum() == 1 else 0


def _pad_arrays(arrays: Sequence[Sequence[np.ndarray]], inner: tuple[int, ...]) -> np.ndarray:
    """Join arrays of each case, (case, item, *inner), with their last dimension padded; an empty one for none."""
    items = max((len(of_case) for of_case in arrays), default=0)
    longest = max((a.shape[-1] for of_case in arrays for a in of_case), default=0)
    shape = inner if inner and inner[-1] >= 0 else (*inner[:-1], longest)
    whole = np.full((len(arrays), items, *shape), np.nan)
    for c, of_case in enumerate(arrays):
        for k, a in enumerate(of_case):
            whole[c, k, ..., : a.shape[-1]] = a
    return whole


def _pad_texts(texts: Sequence[Sequence[str]], items: int) -> np.ndarray:
    whole = np.full((len(texts), items), "", dtype="U64")
    for c, of_case in enumerate(texts):
        whole[c, : len(of_case)] = of_case
    return whole


def _point_quantities(plan: Plan, portraits: Sequence[PortraitFindings]) -> list[Quantity]:
    points = [f.fixed_points.points for f in portraits]
    states = _pad_arrays([[_wrap_state(plan, p.state) for p in case_points] for case_points in points], (2,))
    per, many = _rate_unit(plan), states.shape[1]
    growth = [[float(out.real.max(initial=-math.inf)) if out.size else math.nan for out in f.transverse] for f in portraits]
    at, modes = "case fixed_point", "case fixed_point mode"
    real, imag = (_pad_arrays([[part(p.eigenvalues) for p in e] for e in points], (2,)) for part in (np.real, np.imag))
    return [
        Quantity("fixed_points", states, "fixed point", "", f"{at} state"),
        Quantity(
            "fixed_point_kind", _pad_texts([[p.kind for p in case_points] for case_points in points], many), "kind", "", at
        ),
        Quantity("eigenvalues_real", real, "real part of the eigenvalue", per, modes),
        Quantity("eigenvalues_imag", imag, "imaginary part of the eigenvalue", per, modes),
        Quantity("transverse_growth", _pad_rows(growth, many), "fastest growth out of the section", per, at),
    ]


def _rate_unit(plan: Plan) -> str:
    return f"1/{plan.time}" if plan.time else ""


def _pad_rows(rows: Sequence[Sequence[float]], items: int) -> np.ndarray:
    whole = np.full((len(rows), items), np.nan)
    for c, row in enumerate(rows):
        whole[c, : len(row)] = row
    return whole


def _curve_quantities(plan: Plan, portraits: Sequence[PortraitFindings]) -> list[Quantity]:
    separatrices = [[m.curve.states for m in f.separatrices] for f in portraits]
    trajectories = [[np.concatenate([b.states[:, :0:-1], a.states], axis=1) for a, b in f.trajectories] for f in portraits]
    closed_curves = [[c.states for c in f.closed_curves] for f in portraits]
    lines = {"separatrix": separatrices, "trajectory": trajectories, "closed_curve": closed_curves}
    names = {"separatrix": "separatrices", "trajectory": "trajectories", "closed_curve": "closed_curves"}
    of_lines = [
        Quantity(names[one], _pad_arrays(curves, (2, -1)), one.replace("_", " "), "", f"case {one} state {one}_sample")
        for one, curves in lines.items()
    ]
    separatrix, trajectory, closed_curve = (max(map(len, curves), default=0) for curves in lines.values())
    saddles = _pad_rows([[float(m.saddle) for m in f.separatrices] for f in portraits], separatrix)
    stable = _pad_rows([[float(m.stable) for m in f.separatrices] for f in portraits], separatrix)
    ends = _pad_texts([[_end_label(f, m.curve) for m in f.separatrices] for f in portraits], separatrix)
    finals = _pad_texts([[_end_label(f, a) for a, _ in f.trajectories] for f in portraits], trajectory)
    starts = _pad_rows([[float(b.states.shape[1] - 1) for _, b in f.trajectories] for f in portraits], trajectory)
    kinds = _pad_texts([[c.kind for c in f.closed_curves] for f in portraits], closed_curve)
    periods = _pad_rows([[c.period for c in f.closed_curves] for f in portraits], closed_curve)
    return [
        *of_lines,
        Quantity("separatrix_saddle", saddles, "saddle, by its number", "", "case separatrix"),
        Quantity("separatrix_stable", stable, "whether it leads to the saddle", "", "case separatrix"),
        Quantity("separatrix_end", ends, "its other end", "", "case separatrix"),
        Quantity("trajectory_end", finals, "its end", "", "case trajectory"),
        Quantity("trajectory_start", starts, "sample of its start", "", "case trajectory"),
        Quantity("closed_curve_kind", kinds, "kind", "", "case closed_curve"),
        Quantity("closed_curve_period", periods, "period", plan.time, "case closed_curve"),
    ]


def _rates(plan: Plan, cases: int) -> Quantity:
    """Return the rates on an even grid over the figure."""
    abscissa, axes = _abscissa(plan), [np.linspace(low, high, _GRID) for low, high in plan.drawn_ranges]
    across, up = np.meshgrid(axes[abscissa], axes[1 - abscissa])
    at = np.empty((2, _GRID * _GRID))
    at[abscissa], at[1 - abscissa] = across.ravel(), up.ravel()
    rates = [case.plane.rates(at).reshape(2, _GRID, _GRID) for case in plan.cases[:cases]]
    return Quantity("rate", np.array(rates), "rate of the state", "", "case state ordinate abscissa")


def _end_label(portrait: PortraitFindings, curve: PhaseCurve) -> str:
    if curve.end == FIXED_POINT:
        return f"{portrait.fixed_points.points[curve.index].kind} {curve.index + 1}"
    return f"closed curve {curve.index + 1}" if curve.end == CLOSED_CURVE else curve.end


def _sentence(portrait: PortraitFindings) -> str:
    kinds = Counter(p.kind for p in portrait.fixed_points.points)
    point_counts = ", ".join(f"{n} {kind if n == 1 or kind == DEGENERATE else _plural(kind)}" for kind, n in kinds.items())
    proof = "" if not portrait.fixed_points.complete else " (proved to be all)" if point_counts else " (proved)"
    sentence = f"{point_counts or 'no fixed point'}{proof}"
    if portrait.closed_curves:
        curve_counts = Counter(
            "closed curve of a family" if c.neutral else f"{c.kind} closed curve" for c in portrait.closed_curves
        )
        sentence += ", " + ", ".join(
            f"{n} {kind.replace('curve', 'curves') if n > 1 else kind}" for kind, n in curve_counts.items()
        )
    return sentence


def _case_quantities(plan: Plan, case: PortraitCase, portrait: PortraitFindings) -> list[Quantity]:
    """Return the quantities of a portrait in the summary."""
    per, states = _rate_unit(plan), {a.name: (a.long_name, a.unit) for a in plan.axes}
    kind, stable = {"kind": ("kind", "")}, {"stable": ("whether it is stable", "")}
    point_columns = kind | stable | states | {
        "state": ("states there", ""), "eigenvalues": ("eigenvalues", per),
        "transverse": ("eigenvalues out of the section", per),
        "eigenvalues_phi": ("eigenvalues over the angle of the main rotor", ""),
        "transverse_phi": ("eigenvalues out of the section over this angle", ""),
    }  # fmt: skip
    separatrix_columns = {
        "saddle": ("its saddle, by its number", ""), "stable": ("whether it leads to the saddle", ""),
        "side": ("side of the saddle", ""), "end": ("reason for its end", ""), "to": ("description of its other end", ""),
        "fixed_point": ("fixed point at its other end", ""), "closed_curve": ("closed curve at its other end", ""),
        "gap": ("distance from that", ""), "length": ("length in windows", ""), "error": ("error of its beginning", ""),
        "state": ("states at its other end", ""),
    }  # fmt: skip
    closed_curve_columns = kind | states | {
        "period": ("period", plan.time), "period_phi": ("period in the angle of the main rotor", ""),
        "multiplier": ("multiplier", ""), "turns": ("turns of the states in a period", ""),
        "min": ("least states", ""), "max": ("largest states", ""),
    }  # fmt: skip
    points = [_point_entry(plan, case, portrait, k) for k in range(len(portrait.fixed_points.points))]
    closed_curves = [_closed_curve_entry(plan, case, portrait, k) for k in range(len(portrait.closed_curves))]
    evidence = f"{portrait.fixed_points.evidence}; closed curves are those met by {portrait.curve_count} followed curves"
    return [
        Quantity("label", case.label, "name of the portrait"),
        Quantity("value", case.value, "value of the parameter that differs"),
        *table("fixed_points", points, "fixed points", point_columns),
        *table(
            "separatrices", [_separatrix_entry(portrait, m) for m in portrait.separatrices], "separatrices", separatrix_columns
        ),
        *table("closed_curves", closed_curves, "closed curves", closed_curve_columns),
        Quantity("complete", portrait.fixed_points.complete, "whether all fixed points are known"),
        Quantity("shown", evidence, "evidence for that"),
    ]


def _cases_table(case_quantities: Sequence[Sequence[Quantity]], sentences: Sequence[str]) -> list[Quantity]:
    """Return a table of several portraits, each with a sentence."""
    rows, parts = [], {"sentence": ("description of the portrait", "")}
    for quantities, sentence in zip(case_quantities, sentences, strict=True):
        rows.append({q.name: q.value for q in quantities} | {"sentence": sentence})
        for q in quantities:
            parts |= {q.name: (q.long_name, q.unit), **q.parts}
    return table("cases", rows, "portraits", parts)


def _plural(kind: str) -> str:
    return kind.replace("focus", "foci") if "focus" in kind else f"{kind}s"


def _wrap_state(plan: Plan, state: np.ndarray) -> np.ndarray:
    """Return a state (2,) with angles in (-pi, pi]."""
    return np.where(plan.cases[0].plane.turns > 0, -wrap_to_pi(-state), state)


def _state_values(plan: Plan, state: np.ndarray) -> dict[str, float]:
    return {a.name: float(x) for a, x in zip(plan.axes, state, strict=True)}


def _complex(values: np.ndarray) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in values]


def _point_entry(plan: Plan, case: PortraitCase, portrait: PortraitFindings, index: int) -> dict[str, Any]:
    p: FixedPoint = portrait.fixed_points.points[index]
    entry: dict[str, Any] = {
        "state": _state_values(plan, _wrap_state(plan, p.state)),
        "kind": p.kind,
        "eigenvalues": _complex(p.eigenvalues),
    }
    if case.section is None:
        return entry | {"stable": p.kind in STABLE}
    speed, out = abs(float(case.section.rotor_speed(p.state))), portrait.transverse[index]
    phi = {"eigenvalues_phi": _complex(p.eigenvalues / speed), "transverse_phi": _complex(out / speed)} if speed else {}
    stays = bool((out.real < 0).all())
    return entry | phi | {"transverse": _complex(out), "stable": p.kind in STABLE and stays}


def _separatrix_entry(portrait: PortraitFindings, m: Manifold) -> dict[str, Any]:
    c = m.curve
    return {
        "saddle": m.saddle, "stable": m.stable, "side": m.side, "end": c.end, "to": _end_label(portrait, c),
        "fixed_point": c.index if c.end == FIXED_POINT else None, "closed_curve": c.index if c.end == CLOSED_CURVE else None,
        "gap": c.gap, "length": c.length, "error": m.error, "state": c.states[:, -1].tolist(),
    }  # fmt: skip


def _closed_curve_entry(plan: Plan, case: PortraitCase, portrait: PortraitFindings, index: int) -> dict[str, Any]:
    c = portrait.closed_curves[index]
    turns = np.round(c.turns / (2 * math.pi)).tolist()
    entry: dict[str, Any] = {"kind": c.kind, "period": c.period, "multiplier": c.multiplier, "turns": turns}
    low, high = c.states.min(axis=1), c.states.max(axis=1)
    shift = _wrap_state(plan, (low + high) / 2) - (low + high) / 2  # its middle is in (-pi, pi]
    entry |= {"min": _state_values(plan, low + shift), "max": _state_values(plan, high + shift)}
    return entry | ({"period_phi": portrait.rotor_angles[index]} if portrait.rotor_angles else {})


def _warnings(plan: Plan, case: PortraitCase, portrait: PortraitFindings) -> list[str]:
    about = f"{case.label}: " if case.label else ""
    warnings = [] if portrait.fixed_points.complete else [f"{about}{portrait.fixed_points.evidence}"]
    curves = [*(m.curve for m in portrait.separatrices), *(a for a, _ in portrait.trajectories)]
    if any(c.end == LENGTH for c in curves):
        warnings.append(
            f"{about}some curves were stopped after {plan.spec.length:g} windows: study.length follows them further"
        )
    if any(c.end == FAILURE for c in curves):
        warnings.append(f"{about}some curves end where the equations cannot be evaluated")
    if any(c.end == KINKS for c in curves):
        warnings.append(f"{about}some curves are stopped where they slide along a jump of the equations")
    if any(
        m.curve.end == FIXED_POINT and portrait.fixed_points.points[m.curve.index].kind == SADDLE for m in portrait.separatrices
    ):
        warnings.append(f"{about}a separatrix leads to a saddle: the least change of a parameter breaks this connection")
    return warnings


def report(result: xr.Dataset) -> list[str]:
    """Return the lines that ``wucht run`` prints for a phase portrait."""
    if "equilibria" in result:
        return projection_report(result)
    s = result.wucht.summary
    lines = [result.attrs["title"]]
    if "cases" not in s:
        lines += [f"verdict: {s['sentence']}", *_portrait_lines(s)]
    for case in s.get("cases", []):
        lines += [f"{case['label']}: {case['sentence']}", *_portrait_lines(case)]
    if text_in(result, "model"):
        advice = "study.kind = 'approximation' compares them with the full equations"
        lines.append(f"  equations: {text_in(result, 'model')}; {advice}")
    return lines


def _portrait_lines(s: Mapping[str, Any]) -> list[str]:
    lines = []
    for k, p in enumerate(s["fixed_points"], 1):
        at = ", ".join(f"{name} {value:.7g}" for name, value in p["state"].items())
        values = ", ".join(map(_number, p["eigenvalues"]))
        beside = f"; out of the section {', '.join(map(_number, p['transverse']))}" if p.get("transverse") else ""
        lines.append(f"  {k} {p['kind']:15} {at}; eigenvalues {values}{beside}")
    for m in s["separatrices"]:
        kind, side = "stable" if m["stable"] else "unstable", "one side" if m["side"] > 0 else "other side"
        lines.append(f"  saddle {m['saddle'] + 1}, {kind} manifold, {side}: {_end_clause(m['to'], m['stable'])}")
    for k, c in enumerate(s["closed_curves"], 1):
        turns = ", winding around" if any(c["turns"]) else ""
        phi = f", {c['period_phi']:.7g} of the rotor's angle" if "period_phi" in c else ""
        lines.append(f"  closed curve {k}: {c['kind']}{turns}, period {c['period']:.7g}{phi}")
    lines.append(f"  fixed points: {s['shown']}")
    return lines


def _end_clause(end: str, stable: bool) -> str:
    """Return the origin of a stable manifold, or the destination of an unstable one."""
    if end == "left the window":
        return "comes from outside the window" if stable else "leaves the window"
    is_identified = end.startswith(("stable", "unstable", "saddle", "closed", "centre", "degenerate"))
    return f"{'comes from' if stable else 'goes to'} {end}" if is_identified else f"followed no further: {end}"


def _number(value: list[float]) -> str:
    real, imag = value
    return f"{real:.5g}" if not imag else f"{real:.5g}{imag:+.5g}i"
