"""The answer to the question of phase portraits: their points and curves, side by side, and a description of each."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from typing import Any

import numpy as np

from wucht.analysis.planar_portraits import PlanarPortrait
from wucht.analysis.sections import Axis, Section
from wucht.machines.subject import Subject
from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.phase_plane.fixed_points import SADDLE, STABLE
from wucht.numerics.phase_plane.manifolds import Manifold
from wucht.numerics.phase_plane.phase_curves import CLOSED_CURVE, FAILURE, FIXED_POINT, KINKS, LENGTH
from wucht.numerics.phase_plane.plane import Plane
from wucht.results.quantities import Quantity, table
from wucht.studies.answer import Answer

_GRID = 161  # points a side of the grid of rates for nullclines
_NAMED_ENDS = ("stable", "unstable", "saddle", "closed", "centre", "degenerate")

PortraitOf = tuple[str, float | None, Plane, Section | None, PlanarPortrait]  # its label, the value of ``along``, its origin


def state_portraits(
    subject: Subject,
    along: str | None,
    axes: Sequence[Axis],
    drawn_ranges: np.ndarray,
    has_nullclines: bool,
    length: float,
    count: int,
    portraits: Sequence[PortraitOf],
    a: Answer,
) -> None:
    """State the answer. Of several portraits each variable has them along its first dimension.

    axes, drawn_ranges: the two states, and their ranges (2, 2) in the figure. length: at which a curve is stopped. count: of
    all portraits, of which some are finished.
    """
    time = subject.units.time
    _, _, plane, section, _ = portraits[0]
    model = ""
    if section is not None:
        order = ", second order" if section.order == 2 else ""
        model = f"averaged equations{order}, {'with' if section.inertia else 'without'} the inertia of the balancing bodies"
        a.assume(model)
        a.warn(*section.warnings)
    turning = plane.turns > 0
    abscissa = int(turning.argmax()) if turning.sum() == 1 else 0  # the only angle, else the first state
    a.attribute(abscissa=abscissa, section=int(bool(model)), model=model)
    a.curve("state", [x.name for x in axes], "state")
    a.curve("state_label", [x.long_name for x in axes], "name of the state", "", "state", coordinate=True)
    a.curve("state_unit", [x.unit for x in axes], "unit of the state", "", "state", coordinate=True)
    a.curve("turn", plane.turns, "turn of an angle, 0 of another state", "rad", "state", coordinate=True)

    def state(name: str, values: np.ndarray, what: str, unit: str, over: str) -> None:
        """State a variable, whose first dimension is that of the portraits; of a single one it has none."""
        if along is None:
            a.curve(name, values[0], what, unit, over)
        else:
            a.curve(name, values, what, unit, f"case {over}")

    finished_portraits = [portrait for *_, portrait in portraits]
    _state_points(state, plane, time, finished_portraits)
    _state_curves(state, time, finished_portraits)
    if has_nullclines:
        grids = [np.linspace(low, high, _GRID) for low, high in drawn_ranges]
        across, up = np.meshgrid(grids[abscissa], grids[1 - abscissa])
        at = np.empty((2, _GRID * _GRID))
        at[abscissa], at[1 - abscissa] = across.ravel(), up.ravel()
        rates = np.array([other_plane.rates(at).reshape(2, _GRID, _GRID) for _, _, other_plane, _, _ in portraits])
        state("rate", rates, "rate of the state", "", "state ordinate abscissa")
    a.curve("drawn", drawn_ranges, "range of the figure", "", "state end")
    sentences = [portrait.sentence for portrait in finished_portraits]
    clauses = [f"{label}: {one}" if label else one for (label, *_), one in zip(portraits, sentences, strict=True)]
    a.sentence = (f"{model}: " if model else "") + "; ".join(clauses)
    _state_descriptions(a, along, axes, time, portraits, sentences)
    if section is not None:
        a.number("model", "averaged", "equations")
        a.number("inertia", section.inertia, "whether they keep the inertia of the balancing bodies")
        a.number("order", section.order, "their order")
        a.line(f"equations: {model}; study.kind = 'approximation' compares them with the full equations", "")
    for label, _, _, _, portrait in portraits:
        _add_warnings(a, f"{label}: " if label else "", portrait, length)
    if len(portraits) < count:
        a.warn(f"{len(portraits)} of {count} portraits are finished")


def _state_descriptions(
    a: Answer, along: str | None, axes: Sequence[Axis], time: str, portraits: Sequence[PortraitOf], sentences: Sequence[str]
) -> None:
    """State the points and curves of each portrait, with its lines; of several in a table."""
    described_portraits = [_quantities(axes, time, *of) for of in portraits]
    if along is None:
        a.add(described_portraits[0])
        _add_lines(a, axes, portraits[0])
    else:
        a.curve("case", [label for label, *_ in portraits], "case")
        a.curve("value", [value for _, value, *_ in portraits], along, "", "case", coordinate=True)
        a.number("along", along, "parameter that differs")
        rows, parts = [], {"sentence": ("description of the portrait", "")}
        for quantities, sentence in zip(described_portraits, sentences, strict=True):
            rows.append({q.name: q.value for q in quantities} | {"sentence": sentence})
            for q in quantities:
                parts |= {q.name: (q.long_name, q.unit), **q.parts}
        a.number("cases", rows, "portraits", parts=parts)
        a.verdict = ""
        for k, of in enumerate(portraits):
            a.line(None, "{label}: {sentence}", at=f"cases[{k}]")
            _add_lines(a, axes, of, f"cases[{k}]")


def padded_items(of_cases: Sequence[Sequence[Any]], shape: tuple[int, ...] = (), fill: Any = math.nan) -> np.ndarray:
    """Return the items of each case side by side, filled up where a case has fewer.

    shape: of an item, a number, a text or an array; with -1 at its end for arrays of different lengths.
    """
    if shape[-1:] == (-1,):
        shape = *shape[:-1], max((item.shape[-1] for items in of_cases for item in items), default=0)
    count = max(map(len, of_cases), default=0)
    whole = np.full((len(of_cases), count, *shape), fill, dtype="U64" if isinstance(fill, str) else float)
    for c, items in enumerate(of_cases):
        for k, item in enumerate(items):
            whole[(c, k, ..., slice(np.shape(item)[-1])) if shape else (c, k)] = item
    return whole


def _state_points(state: Callable[..., None], plane: Plane, time: str, portraits: Sequence[PlanarPortrait]) -> None:
    points, per = [f.fixed_points.points for f in portraits], f"1/{time}" if time else ""
    at, modes = "fixed_point", "fixed_point mode"
    states = [[_wrap_state(plane, p.state) for p in one] for one in points]
    state("fixed_points", padded_items(states, shape=(2,)), "fixed point", "", "fixed_point state")
    state("fixed_point_kind", padded_items([[p.kind for p in one] for one in points], fill=""), "kind", "", at)
    real, imag = (
        padded_items([[part(p.eigenvalues) for p in one] for one in points], shape=(2,)) for part in (np.real, np.imag)
    )
    state("eigenvalues_real", real, "real part of the eigenvalue", per, modes)
    state("eigenvalues_imag", imag, "imaginary part of the eigenvalue", per, modes)
    growth = [
        [float(out.real.max(initial=-math.inf)) if out.size else math.nan for out in f.transverse] or [math.nan] * len(one)
        for f, one in zip(portraits, points, strict=True)
    ]
    state("transverse_growth", padded_items(growth), "fastest growth out of the section", per, at)


def _state_curves(state: Callable[..., None], time: str, portraits: Sequence[PlanarPortrait]) -> None:
    separatrices = [[m.curve.states for m in f.separatrices] for f in portraits]
    trajectories = [[np.concatenate([b.states[:, :0:-1], a.states], axis=1) for a, b in f.trajectories] for f in portraits]
    closed_curves = [[c.states for c in f.closed_curves] for f in portraits]
    state("separatrices", padded_items(separatrices, (2, -1)), "separatrix", "", "separatrix state separatrix_sample")
    state("trajectories", padded_items(trajectories, (2, -1)), "trajectory", "", "trajectory state trajectory_sample")
    state("closed_curves", padded_items(closed_curves, (2, -1)), "closed curve", "", "closed_curve state closed_curve_sample")
    saddles, stable = (padded_items([[getattr(m, n) for m in f.separatrices] for f in portraits]) for n in ("saddle", "stable"))
    state("separatrix_saddle", saddles, "saddle, by its number", "", "separatrix")
    state("separatrix_stable", stable, "whether it leads to the saddle", "", "separatrix")
    ends = [[f.end_label(m.curve) for m in f.separatrices] for f in portraits]
    state("separatrix_end", padded_items(ends, fill=""), "its other end", "", "separatrix")
    finals = [[f.end_label(ahead) for ahead, _ in f.trajectories] for f in portraits]
    state("trajectory_end", padded_items(finals, fill=""), "its end", "", "trajectory")
    starts = [[back.states.shape[1] - 1 for _, back in f.trajectories] for f in portraits]
    state("trajectory_start", padded_items(starts), "sample of its start", "", "trajectory")
    kinds = [[c.kind for c in f.closed_curves] for f in portraits]
    state("closed_curve_kind", padded_items(kinds, fill=""), "kind", "", "closed_curve")
    periods = [[c.period for c in f.closed_curves] for f in portraits]
    state("closed_curve_period", padded_items(periods), "period", time, "closed_curve")


def _quantities(
    axes: Sequence[Axis],
    time: str,
    label: str,
    value: float | None,
    plane: Plane,
    section: Section | None,
    portrait: PlanarPortrait,
) -> list[Quantity]:
    """Return the quantities of a portrait in the summary."""
    per, states = f"1/{time}" if time else "", {a.name: (a.long_name, a.unit) for a in axes}
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
        "period": ("period", time), "period_phi": ("period in the angle of the main rotor", ""),
        "multiplier": ("multiplier", ""), "turns": ("turns of the states in a period", ""),
        "min": ("least states", ""), "max": ("largest states", ""),
    }  # fmt: skip
    points = [_point_entry(axes, plane, section, portrait, k) for k in range(len(portrait.fixed_points.points))]
    closed_curves = [_closed_curve_entry(axes, plane, portrait, k) for k in range(len(portrait.closed_curves))]
    separatrices = [_separatrix_entry(portrait, m) for m in portrait.separatrices]
    evidence = f"{portrait.fixed_points.evidence}; closed curves are those met by {portrait.curve_count} followed curves"
    return [
        Quantity("label", label, "name of the portrait"),
        Quantity("value", value, "value of the parameter that differs"),
        *table("fixed_points", points, "fixed points", point_columns),
        *table("separatrices", separatrices, "separatrices", separatrix_columns),
        *table("closed_curves", closed_curves, "closed curves", closed_curve_columns),
        Quantity("complete", portrait.fixed_points.complete, "whether all fixed points are known"),
        Quantity("shown", evidence, "evidence for that"),
    ]


def _wrap_state(plane: Plane, state: np.ndarray) -> np.ndarray:
    """Return a state (2,) with angles in (-pi, pi]."""
    return np.where(plane.turns > 0, -wrap_to_pi(-state), state)


def _state_values(axes: Sequence[Axis], state: np.ndarray) -> dict[str, float]:
    return {a.name: float(x) for a, x in zip(axes, state, strict=True)}


def _complex(values: np.ndarray) -> list[list[float]]:
    return [[float(v.real), float(v.imag)] for v in values]


def _point_entry(
    axes: Sequence[Axis], plane: Plane, section: Section | None, portrait: PlanarPortrait, index: int
) -> dict[str, Any]:
    p = portrait.fixed_points.points[index]
    state = _state_values(axes, _wrap_state(plane, p.state))
    entry: dict[str, Any] = {"state": state, "kind": p.kind, "eigenvalues": _complex(p.eigenvalues)}
    if section is None:
        return entry | {"stable": p.kind in STABLE}
    speed, out = abs(float(section.rotor_speed(p.state))), portrait.transverse[index]
    phi = {"eigenvalues_phi": _complex(p.eigenvalues / speed), "transverse_phi": _complex(out / speed)} if speed else {}
    stays = bool((out.real < 0).all())
    return entry | phi | {"transverse": _complex(out), "stable": p.kind in STABLE and stays}


def _separatrix_entry(portrait: PlanarPortrait, m: Manifold) -> dict[str, Any]:
    c = m.curve
    return {
        "saddle": m.saddle, "stable": m.stable, "side": m.side, "end": c.end, "to": portrait.end_label(c),
        "fixed_point": c.index if c.end == FIXED_POINT else None, "closed_curve": c.index if c.end == CLOSED_CURVE else None,
        "gap": c.gap, "length": c.length, "error": m.error, "state": c.states[:, -1].tolist(),
    }  # fmt: skip


def _closed_curve_entry(axes: Sequence[Axis], plane: Plane, portrait: PlanarPortrait, index: int) -> dict[str, Any]:
    c = portrait.closed_curves[index]
    turns = np.round(c.turns / (2 * math.pi)).tolist()
    entry: dict[str, Any] = {"kind": c.kind, "period": c.period, "multiplier": c.multiplier, "turns": turns}
    low, high = c.states.min(axis=1), c.states.max(axis=1)
    shift = _wrap_state(plane, (low + high) / 2) - (low + high) / 2  # its middle is in (-pi, pi]
    entry |= {"min": _state_values(axes, low + shift), "max": _state_values(axes, high + shift)}
    return entry | ({"period_phi": portrait.rotor_angles[index]} if portrait.rotor_angles else {})


def _add_warnings(a: Answer, about: str, portrait: PlanarPortrait, length: float) -> None:
    points = portrait.fixed_points
    if not points.complete:
        a.warn(f"{about}{points.evidence}")
    ends = {m.curve.end for m in portrait.separatrices} | {ahead.end for ahead, _ in portrait.trajectories}
    if LENGTH in ends:
        a.warn(f"{about}some curves were stopped after {length:g} windows: study.length follows them further")
    if FAILURE in ends:
        a.warn(f"{about}some curves end where the equations cannot be evaluated")
    if KINKS in ends:
        a.warn(f"{about}some curves are stopped where they slide along a jump of the equations")
    destinations = [m.curve.index for m in portrait.separatrices if m.curve.end == FIXED_POINT]
    if any(points.points[k].kind == SADDLE for k in destinations):
        a.warn(f"{about}a separatrix leads to a saddle: the least change of a parameter breaks this connection")


def _add_lines(a: Answer, axes: Sequence[Axis], of: PortraitOf, at: str = "") -> None:
    """Add the lines on the points and curves of a portrait. at: its place in the summary."""
    _, _, plane, _, portrait = of
    for k, p in enumerate(portrait.fixed_points.points):
        states = _state_values(axes, _wrap_state(plane, p.state))
        place = ", ".join(f"{name} {value:.7g}" for name, value in states.items())
        out = portrait.transverse[k] if portrait.transverse else ()
        beside = f"; out of the section {', '.join(map(_number, out))}" if len(out) else ""
        a.line(f"{k + 1} {p.kind:15} ", f"{place}; eigenvalues {', '.join(map(_number, p.eigenvalues))}{beside}")
    for m in portrait.separatrices:
        kind, side = "stable" if m.stable else "unstable", "one side" if m.side > 0 else "other side"
        a.line(f"saddle {m.saddle + 1}, {kind} manifold, {side}: ", _end_clause(portrait.end_label(m.curve), m.stable))
    for k, c in enumerate(portrait.closed_curves):
        turns = ", winding around" if np.round(c.turns / (2 * math.pi)).any() else ""
        phi = f", {portrait.rotor_angles[k]:.7g} of the rotor's angle" if portrait.rotor_angles else ""
        a.line(f"closed curve {k + 1}: ", f"{c.kind}{turns}, period {c.period:.7g}{phi}")
    a.line("fixed points: ", "{shown}", at=at)


def _end_clause(end: str, stable: bool) -> str:
    """Return the origin of a stable manifold, or the destination of an unstable one."""
    if end == "left the window":
        return "comes from outside the window" if stable else "leaves the window"
    is_identified = end.startswith(_NAMED_ENDS)
    return f"{'comes from' if stable else 'goes to'} {end}" if is_identified else f"followed no further: {end}"


def _number(value: complex) -> str:
    return f"{value.real:.5g}" if not value.imag else f"{value.real:.5g}{value.imag:+.5g}i"
