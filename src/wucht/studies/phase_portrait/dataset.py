"""Findings -> the Dataset of a phase portrait: points and curves, where each curve goes, and the summary."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.numerics.angles import within_half_a_turn
from wucht.numerics.phase_plane.fixed_points import DEGENERATE, SADDLE, STABLE, FixedPoint
from wucht.numerics.phase_plane.manifolds import Manifold
from wucht.numerics.phase_plane.phase_curves import CLOSED, FAILED, FIXED_POINT, KINKS, LENGTH, PhaseCurve
from wucht.results.conventions import Variable, answered, assuming, variable
from wucht.studies.phase_portrait.prepare import Case, Plan
from wucht.studies.phase_portrait.run import Findings, Found

if TYPE_CHECKING:
    import xarray as xr

_GRID = 161  # points a side at which the rates of nullclines are given


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """The Dataset of phase portraits.

    Coordinates: state (the names of the two), case and value (of the parameter ``along``) where there are several portraits.
    Variables, padded with not a number: fixed_points (fixed_point, state), fixed_point_kind, eigenvalues_real, eigenvalues_imag
    (fixed_point, mode), transverse_growth (fixed_point: the fastest out of the section, of a machine); separatrices
    (separatrix, state, sample), separatrix_saddle, separatrix_stable, separatrix_end; trajectories (trajectory, state, sample),
    trajectory_end; closed_curves (closed_curve, state, sample), closed_curve_kind, closed_curve_period; drawn (state, end): the
    range of the figure; rate (state, ordinate, abscissa) where nullclines are asked for. abscissa, an attribute: which state.
    """
    import xarray as xr_

    pairs = list(zip(plan.cases, findings.portraits, strict=False))  # a portrait may be missing
    data = _of_points(plan, findings.portraits) | _of_curves(plan, findings.portraits)
    abscissa = _abscissa(plan)
    if plan.spec.nullclines:
        data["rate"] = _rates(plan, len(pairs), abscissa)
    coordinates: dict[str, Variable] = {
        "state": variable("state", [a.name for a in plan.axes], "state"),
        "state_label": variable("state", [a.long_name for a in plan.axes], "state in words"),
        "state_unit": variable("state", [a.unit for a in plan.axes], "unit of the state"),
        "turn": variable("state", plan.cases[0].plane.turns, "turn of an angle, 0 of another state", "rad"),
    }
    data["drawn"] = variable("state end", plan.drawn, "range of the figure")
    if plan.spec.along is not None:
        coordinates["case"] = variable("case", [c.label for c, _ in pairs], "case")
        coordinates["value"] = variable("case", [c.value for c, _ in pairs], plan.spec.along)
    result = xr_.Dataset(dict(data), coords=coordinates)
    entries = [_summary(plan, case, found) for case, found in pairs]
    several = plan.spec.along is not None
    result = result if several else result.isel(case=0)
    summary: dict[str, Any] = {"along": plan.spec.along, "cases": entries} if several else dict(entries[0])
    sentences = [f"{c.label}: {e['sentence']}" if c.label else e["sentence"] for (c, _), e in zip(pairs, entries, strict=True)]
    sentence = (f"{plan.model}: " if plan.model else "") + "; ".join(sentences)
    if (made := plan.cases[0].section) is not None:
        summary |= {"model": "averaged", "inertia": made.inertia, "order": made.order}
    summary["sentence"] = sentence
    warnings = [*plan.warnings, *(w for case, found in pairs for w in _warnings(plan, case, found))]
    if len(pairs) < len(plan.cases):
        warnings.append(f"{len(pairs)} of {len(plan.cases)} portraits are finished")
    portrait = answered(result, summary, sentence, warnings, abscissa=abscissa, section=int(bool(plan.model)), model=plan.model)
    return assuming(portrait, [plan.model] if plan.model else [])


def _abscissa(plan: Plan) -> int:
    """Which state is drawn along the abscissa: the only angle, else the first."""
    turning = plan.cases[0].plane.turns > 0
    return int(turning.argmax()) if turning.sum() == 1 else 0


def _padded(arrays: Sequence[Sequence[np.ndarray]], inner: tuple[int, ...]) -> np.ndarray:
    """Arrays of each case (case, item, *inner) where their last dimension is padded; of none an empty one."""
    items = max((len(of_case) for of_case in arrays), default=0)
    longest = max((a.shape[-1] for of_case in arrays for a in of_case), default=0)
    shape = inner if inner and inner[-1] >= 0 else (*inner[:-1], longest)
    whole = np.full((len(arrays), items, *shape), np.nan)
    for c, of_case in enumerate(arrays):
        for k, a in enumerate(of_case):
            whole[c, k, ..., : a.shape[-1]] = a
    return whole


def _words(texts: Sequence[Sequence[str]], items: int) -> np.ndarray:
    whole = np.full((len(texts), items), "", dtype="U64")
    for c, of_case in enumerate(texts):
        whole[c, : len(of_case)] = of_case
    return whole


def _of_points(plan: Plan, found: Sequence[Found]) -> dict[str, Variable]:
    points = [f.fixed.points for f in found]
    states = _padded([[_reported(plan, p.state) for p in each] for each in points], (2,))
    per = f"1/{plan.time}" if plan.time else ""
    many = states.shape[1]
    growth = [[float(out.real.max(initial=-math.inf)) if out.size else math.nan for out in f.transverse] for f in found]
    at, modes = "case fixed_point", "case fixed_point mode"
    return {
        "fixed_points": variable(f"{at} state", states, "fixed point"),
        "fixed_point_kind": variable(at, _words([[p.kind for p in each] for each in points], many), "kind"),
        "eigenvalues_real": variable(
            modes, _padded([[p.eigenvalues.real for p in e] for e in points], (2,)), "real part of the eigenvalue", per
        ),
        "eigenvalues_imag": variable(
            modes, _padded([[p.eigenvalues.imag for p in e] for e in points], (2,)), "imaginary part of the eigenvalue", per
        ),
        "transverse_growth": variable(at, _filled(growth, many), "fastest growth out of the section", per),
    }


def _filled(rows: Sequence[Sequence[float]], items: int) -> np.ndarray:
    whole = np.full((len(rows), items), np.nan)
    for c, row in enumerate(rows):
        whole[c, : len(row)] = row
    return whole


def _of_curves(plan: Plan, found: Sequence[Found]) -> dict[str, Variable]:
    separatrices = [[m.curve.states for m in f.separatrices] for f in found]
    both = [[np.concatenate([b.states[:, :0:-1], a.states], axis=1) for a, b in f.trajectories] for f in found]
    closed = [[c.states for c in f.closed] for f in found]
    lines = {"separatrix": separatrices, "trajectory": both, "closed_curve": closed}
    names = {"separatrix": "separatrices", "trajectory": "trajectories", "closed_curve": "closed_curves"}
    data = {
        names[one]: variable(f"case {one} state {one}_sample", _padded(curves, (2, -1)), one.replace("_", " "))
        for one, curves in lines.items()
    }
    many = {one: max((len(c) for c in curves), default=0) for one, curves in lines.items()}
    saddles = [[float(m.saddle) for m in f.separatrices] for f in found]
    stable = [[float(m.stable) for m in f.separatrices] for f in found]
    ends = [[_end_in_words(f, m.curve) for m in f.separatrices] for f in found]
    finals = [[_end_in_words(f, a) for a, _ in f.trajectories] for f in found]
    starts = [[float(b.states.shape[1] - 1) for _, b in f.trajectories] for f in found]
    kinds, periods = [[c.kind for c in f.closed] for f in found], [[c.period for c in f.closed] for f in found]
    return data | {
        "separatrix_saddle": variable("case separatrix", _filled(saddles, many["separatrix"]), "saddle, by its number"),
        "separatrix_stable": variable("case separatrix", _filled(stable, many["separatrix"]), "whether it goes to the saddle"),
        "separatrix_end": variable("case separatrix", _words(ends, many["separatrix"]), "its other end"),
        "trajectory_end": variable("case trajectory", _words(finals, many["trajectory"]), "where it goes"),
        "trajectory_start": variable("case trajectory", _filled(starts, many["trajectory"]), "sample at which it was started"),
        "closed_curve_kind": variable("case closed_curve", _words(kinds, many["closed_curve"]), "kind"),
        "closed_curve_period": variable("case closed_curve", _filled(periods, many["closed_curve"]), "period", plan.time),
    }  # fmt: skip


def _rates(plan: Plan, cases: int, abscissa: int) -> Variable:
    """The rates over the figure, at even places."""
    axes = [np.linspace(low, high, _GRID) for low, high in plan.drawn]
    across, up = np.meshgrid(axes[abscissa], axes[1 - abscissa])
    at = np.empty((2, _GRID * _GRID))
    at[abscissa], at[1 - abscissa] = across.ravel(), up.ravel()
    rates = [case.plane.rates(at).reshape(2, _GRID, _GRID) for case in plan.cases[:cases]]
    return variable("case state ordinate abscissa", np.array(rates), "rate of the state")


def _end_in_words(found: Found, curve: PhaseCurve) -> str:
    if curve.end == FIXED_POINT:
        return f"{found.fixed.points[curve.index].kind} {curve.index + 1}"
    return f"closed curve {curve.index + 1}" if curve.end == CLOSED else curve.end


def _summary(plan: Plan, case: Case, found: Found) -> dict[str, Any]:
    kinds = Counter(p.kind for p in found.fixed.points)
    counted = ", ".join(f"{n} {kind if n == 1 or kind == DEGENERATE else _several(kind)}" for kind, n in kinds.items())
    shown = "" if not found.fixed.complete else " (proved to be all)" if counted else " (proved)"
    sentence = f"{counted or 'no fixed point'}{shown}"
    if found.closed:
        each = Counter("closed curve of a family" if c.neutral else f"{c.kind} closed curve" for c in found.closed)
        sentence += ", " + ", ".join(f"{n} {kind.replace('curve', 'curves') if n > 1 else kind}" for kind, n in each.items())
    return {
        "label": case.label,
        "value": case.value,
        "sentence": sentence,
        "fixed_points": [_point(plan, case, found, k) for k in range(len(found.fixed.points))],
        "separatrices": [_separatrix(found, m) for m in found.separatrices],
        "closed_curves": [_closed(plan, case, found, k) for k in range(len(found.closed))],
        "complete": found.fixed.complete,
        "shown": f"{found.fixed.shown}; closed curves are those that {found.followed} followed curves met",
    }


def _several(kind: str) -> str:
    return kind.replace("focus", "foci") if "focus" in kind else f"{kind}s"


def _reported(plan: Plan, state: np.ndarray) -> np.ndarray:
    """A state (2,) with angles in (-pi, pi]."""
    return np.where(plan.cases[0].plane.turns > 0, -within_half_a_turn(-state), state)


def _named(plan: Plan, state: np.ndarray) -> dict[str, float]:
    return {a.name: float(x) for a, x in zip(plan.axes, state, strict=True)}


def _complex(values: np.ndarray) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in values]


def _point(plan: Plan, case: Case, found: Found, index: int) -> dict[str, Any]:
    p: FixedPoint = found.fixed.points[index]
    entry: dict[str, Any] = {
        "state": _named(plan, _reported(plan, p.state)),
        "kind": p.kind,
        "eigenvalues": _complex(p.eigenvalues),
    }
    if case.section is None:
        return entry | {"stable": p.kind in STABLE}
    speed, out = abs(float(case.section.rotor_speed(p.state))), found.transverse[index]
    phi = {"eigenvalues_phi": _complex(p.eigenvalues / speed), "transverse_phi": _complex(out / speed)} if speed else {}
    stays = bool((out.real < 0).all())
    return entry | phi | {"transverse": _complex(out), "stable": p.kind in STABLE and stays}


def _separatrix(found: Found, m: Manifold) -> dict[str, Any]:
    c = m.curve
    return {
        "saddle": m.saddle, "stable": m.stable, "side": m.side, "end": c.end, "to": _end_in_words(found, c),
        "fixed_point": c.index if c.end == FIXED_POINT else None, "closed_curve": c.index if c.end == CLOSED else None,
        "gap": c.gap, "length": c.length, "error": m.error, "state": c.states[:, -1].tolist(),
    }  # fmt: skip


def _closed(plan: Plan, case: Case, found: Found, index: int) -> dict[str, Any]:
    c = found.closed[index]
    turns = np.round(c.turns / (2 * math.pi)).tolist()
    entry: dict[str, Any] = {"kind": c.kind, "period": c.period, "multiplier": c.multiplier, "turns": turns}
    low, high = c.states.min(axis=1), c.states.max(axis=1)
    shift = _reported(plan, (low + high) / 2) - (low + high) / 2  # its middle is in (-pi, pi]
    entry |= {"min": _named(plan, low + shift), "max": _named(plan, high + shift)}
    return entry | ({"period_phi": found.turned[index]} if found.turned else {})


def _warnings(plan: Plan, case: Case, found: Found) -> list[str]:
    about = f"{case.label}: " if case.label else ""
    warnings = [] if found.fixed.complete else [f"{about}{found.fixed.shown}"]
    curves = [*(m.curve for m in found.separatrices), *(a for a, _ in found.trajectories)]
    if any(c.end == LENGTH for c in curves):
        warnings.append(
            f"{about}some curves were given up after {plan.spec.length:g} windows: study.length follows them further"
        )
    if any(c.end == FAILED for c in curves):
        warnings.append(f"{about}some curves end where the equations cannot be evaluated")
    if any(c.end == KINKS for c in curves):
        warnings.append(f"{about}some curves are given up where they slide along a jump of the equations")
    if any(m.curve.end == FIXED_POINT and found.fixed.points[m.curve.index].kind == SADDLE for m in found.separatrices):
        warnings.append(f"{about}a separatrix goes to a saddle: the least change of a parameter parts them")
    return warnings
