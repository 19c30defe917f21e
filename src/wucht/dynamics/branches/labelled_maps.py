"""Labelled maps of a plane of parameters: regions with the motions in them, the lines between, and the examined places."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from wucht.dynamics.branches.ending_map import EndingFindings, unexplained_changes
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.orbit_endings import NO_MOTION
from wucht.dynamics.branches.plane_regions import (
    NOT_DECIDED,
    PlaneCurve,
    PlanePoint,
    PlaneRegions,
    cell_size,
    divide_plane,
    divided_by_places,
    kinds_by_region,
    sides_of,
)
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.dynamics.branches.state_map import StateFindings, StateMapCase, examined_places, extended_curves, lines_of
from wucht.dynamics.sampling.label_maps import share, uncertainty
from wucht.numerics.continuation.equilibria import FOLD
from wucht.numerics.periodic.branch_ends import NOT_IDENTIFIED, RANGE, SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.numerics.zeros_and_peaks import values_at_passages

_UNKNOWN = "not identified"
_NOT_EXAMINED = "not examined"
_NOTHING_ELSE, _NO_OTHER_STATE = "nothing else", "no other steady state"
_UNDECIDED_TONE = 4
_LEVEL = 0.05  # probability with which what exists in a larger share of the plane is missed at all places
_ORBIT_CURVES: Mapping[str, str] = {
    "branch-point": "loses stability sideways",
    "fold": "fold",
    "period-doubling": "period doubling",
    "torus": "torus",
    SADDLE_CONNECTION: "saddle connection",
    SADDLE_NODE_ON_ORBIT: "saddle-node on it",
}
_LEVELS = ("", "unstable", "stable")  # of the motion that is periodic but not steady
_ON_FOLD = 1e-4  # of the range: a row's end that lies on a curve of folds
_ENDINGS: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "ends at a saddle-node on the orbit",
    SADDLE_CONNECTION: "ends at a saddle connection",
    RANGE: "lasts to the end of the range",
}
_SHORT: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "saddle-node on the orbit",
    SADDLE_CONNECTION: "saddle connection",
    RANGE: "end of the range",
}
_TONES: Mapping[str, int] = {SADDLE_NODE_ON_ORBIT: 2, SADDLE_CONNECTION: 1, RANGE: 3, NO_MOTION: 0}
_SAME_SIDES = 0.5  # of a curve's points: a curve with different regions on both sides at fewer points separates nothing
_SMALL_PARTS = 12  # points: a longer curve is judged without its ends


@dataclass(frozen=True)
class MapPlace:
    """An examined place, with its motions. begins, ends: values of the third parameter."""

    x: float
    y: float
    label: str
    begins: float = math.nan
    ends: float = math.nan


@dataclass(frozen=True, eq=False)
class LabelledMap:
    """A map. lines: boundaries by name, the kind being their style. labels, tones, hatches: of its regions;
    everywhere: names of states that are stable in all of them.

    contradictions: places that no line separates from others of another kind. omissions: sentences on missing parts. runs:
    number of checking runs. searches: number of places at which all motions were sought. complete: True if nothing is left
    to do.
    """

    lines: Mapping[str, PlaneCurve]
    marks: tuple[PlanePoint, ...]
    places: tuple[MapPlace, ...]
    areas: PlaneRegions
    labels: tuple[str, ...]
    tones: tuple[int, ...]
    hatches: tuple[int, ...]
    everywhere: tuple[str, ...] = ()
    contradictions: tuple[MapPlace, ...] = ()
    omissions: tuple[str, ...] = field(default_factory=tuple)
    runs: int = 0
    searches: int = 0
    complete: bool = False

    @property
    def shares(self) -> dict[str, tuple[float, float]]:
        """Share of the plane of each label, and its uncertainty in 19 of 20 cases: by the resolution of the regions; of absence
        what may be missed.
        """
        shares = {}
        for label in dict.fromkeys(self.labels):
            inside = np.isin(self.areas.index, [k for k, region_label in enumerate(self.labels) if region_label == label])
            off = uncertainty(inside, (False, False))
            is_absence = label in (_NOTHING_ELSE, _NO_OTHER_STATE)
            shares[label] = share(inside), max(off, self.detection_limit) if is_absence else off
        return shares

    @property
    def detection_limit(self) -> float:
        """Share of the plane below which a motion may be missed at all places."""
        return detection_limit(self.searches)


def detection_limit(places: int) -> float:
    """Return the share of the plane below which a motion may exist without being detected at any place, in 19 of 20 cases.

    Of n places that lie at random to what is narrower than their distances, all miss a share s with probability (1 - s)^n.
    """
    return float(1 - _LEVEL ** (1 / places)) if places else 1.0


def map_of_states(case: StateMapCase, findings: StateFindings) -> LabelledMap:
    """Return the map of all motions."""
    places = examined_places(case, findings)
    everywhere = frozenset(set.intersection(*(set(p.names) for p in places)) if places else ())
    keys = [(p.x, p.y, p.key(everywhere)) for p in places]
    motions = {key: (sorted(set(p.names) - everywhere), p.level) for p, (_, _, key) in zip(places, keys, strict=True)}
    areas = divide_plane(lines_of(case, findings), case.bounds)
    kinds, contradictions = kinds_by_region(areas, keys)
    areas, kinds = divided_by_places(areas, kinds, keys, cell_size(case.bounds, case.cells))
    includes_orbits = case.motion is not None
    labels_of = {key: _state_label(names, level, includes_orbits, case.labels.orbit) for key, (names, level) in motions.items()}
    hatched_sets = sorted({tuple(names) for names, _ in motions.values() if names})
    hatches = {key: 1 + hatched_sets.index(tuple(names)) for key, (names, _) in motions.items() if names}
    lines = [
        _line(f"{c.bifurcation}: {c.kind.name or 'steady states'}", c.unknowns[-2], c.unknowns[-1]) for c in findings.curves
    ]
    lines += [_line(f"{case.labels.orbit}: {_ORBIT_CURVES[c.kind]}", c.x, c.y) for c in extended_curves(case, findings)]
    on_orbit = f"{case.labels.orbit}: {_ORBIT_CURVES[SADDLE_NODE_ON_ORBIT]}"
    lines += [_line(on_orbit, x, y) for x, y in _ends_on_folds(case, findings)]
    marks = [
        PlanePoint(kind, float(c.unknowns[-2, i]), float(c.unknowns[-1, i]))
        for c in findings.curves for i, kind in enumerate(c.kinds) if kind
    ]  # fmt: skip
    return LabelledMap(
        _curves_by_name(lines), (*findings.crossings, *marks), tuple(MapPlace(x, y, labels_of[key]) for x, y, key in keys),
        areas, tuple(labels_of.get(k, k or _NOT_EXAMINED) for k in kinds),
        tuple(_UNDECIDED_TONE if k == NOT_DECIDED else motions[k][1] if k else 0 for k in kinds),
        tuple(hatches.get(k, 0) for k in kinds), tuple(sorted(everywhere)),
        tuple(MapPlace(x, y, labels_of[key]) for x, y, key in contradictions),
        findings.omissions, sum(place.runs for place in findings.runs_by_place),
        len(findings.runs_by_place) if includes_orbits else len(findings.rows) * (case.points + 2), findings.complete,
    )  # fmt: skip


def _line(kind: str, x: np.ndarray, y: np.ndarray) -> PlaneCurve:
    return PlaneCurve(kind, x, y, np.full(len(x), np.nan))


def _state_label(names: Sequence[str], level: int, includes_orbits: bool, motion: str) -> str:
    """Return a label such as ``together, modulated motion stable``. includes_orbits: modulated motions were searched."""
    parts = [*names, f"{motion} {_LEVELS[level]}"] if level else [*names]
    return ", ".join(parts) or (_NOTHING_ELSE if includes_orbits else _NO_OTHER_STATE)


def _ends_on_folds(case: StateMapCase, findings: StateFindings) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the parts of fold curves on the modulated motion: between rows whose branch ends there."""
    half = (case.bounds[1][1] - case.bounds[1][0]) / case.cells / 2
    parts = []
    for c in findings.curves:
        if c.bifurcation != FOLD:
            continue
        seconds = [
            r.second
            for r in findings.orbits
            for s in r.sides
            if s.kind in (SADDLE_NODE_ON_ORBIT, NOT_IDENTIFIED) and _lies_on(case, c, s.value, r.second)
        ]
        if not seconds:
            continue
        low, high = min(seconds) - half, max(seconds) + half
        for crossing in findings.crossings:
            if low <= crossing.y <= min(seconds):
                low = crossing.y
        y = c.unknowns[-1]
        inside = (y >= low) & (y <= high)
        if inside.sum() > 1:
            parts.append((c.unknowns[-2][inside], y[inside]))
    return parts


def _lies_on(case: StateMapCase, curve: BifurcationCurve, value: float, second: float) -> bool:
    x, y = curve.unknowns[-2:]
    width = case.bounds[0][1] - case.bounds[0][0]
    i, passages = values_at_passages(y, second, x)
    near = 0.02 * np.abs(np.diff(x))[i] + _ON_FOLD * width
    return bool((np.abs(passages - value) < near).any())


def map_of_endings(case: EndingMapCase, findings: EndingFindings) -> LabelledMap:
    """Return the map of how a motion ends."""
    areas, motion = divide_plane([(c.x, c.y) for c in findings.curves], case.bounds), case.labels.orbit
    keys = [(p.x, p.y, p.kind) for p in findings.places]
    kinds, contradictions = kinds_by_region(areas, keys)
    areas, kinds = divided_by_places(areas, kinds, keys, cell_size(case.bounds, case.cells))
    lines = list[PlaneCurve]()
    for c in findings.curves:
        inner = slice(2, -2) if len(c.x) > _SMALL_PARTS else slice(None)
        sides = sides_of(areas, kinds, c.x[inner], c.y[inner])
        differing = [s for s in sides if s[0] != s[1]]
        if len(differing) <= _SAME_SIDES * len(sides):
            continue
        a, b = Counter((min(s), max(s)) for s in differing).most_common(1)[0][0]
        short = {**_SHORT, NO_MOTION: f"no {motion}"}
        name = " | ".join(sorted((short.get(a, _UNKNOWN), short.get(b, _UNKNOWN)), key=list(short.values()).index))
        lines.append(replace(c, kind=name))
    tones = tuple(_UNDECIDED_TONE if k == NOT_DECIDED else _TONES.get(k, 0) for k in kinds)
    return LabelledMap(
        lines=_curves_by_name(lines), marks=findings.points,
        places=tuple(MapPlace(p.x, p.y, _ending(p.kind, motion), p.begins, p.end.value) for p in findings.places),
        areas=areas, labels=tuple(k if k == NOT_DECIDED else _ending(k, motion) for k in kinds), tones=tones,
        hatches=tuple(int(t == 1) for t in tones),
        contradictions=tuple(MapPlace(x, y, _ending(k, motion)) for x, y, k in contradictions),
        omissions=(*findings.omissions, *_change_sentences(case, findings, motion)), complete=findings.complete,
    )  # fmt: skip


def _ending(kind: str, motion: str) -> str:
    """Return how the motion ends, in words."""
    return f"no {motion} begins" if kind == NO_MOTION else _ENDINGS.get(kind, _UNKNOWN)


def _change_sentences(case: EndingMapCase, findings: EndingFindings, motion: str) -> list[str]:
    """Return a sentence on neighbouring places that differ, with no curve between them."""
    if not findings.complete or not (pairs := unexplained_changes(case, findings)):
        return []
    (first, second), (_, along, across) = pairs[0], case.paths
    return [
        f"between {len(pairs)} pairs of neighbouring places that differ no curve was found, such as "
        f"{along} = {first.x:.4g}, {across} = {first.y:.4g} "
        f"({_ending(first.kind, motion)}) and {second.x:.4g}, {second.y:.4g} ({_ending(second.kind, motion)})"
    ]


def _curves_by_name(curves: Sequence[PlaneCurve]) -> dict[str, PlaneCurve]:
    """Return curves by their kinds, those of one kind with numbers: ``fold: together``, ``fold: together (2)``."""
    count, named_curves = Counter[str](), dict[str, PlaneCurve]()
    for curve in curves:
        count[curve.kind] += 1
        named_curves[curve.kind if count[curve.kind] == 1 else f"{curve.kind} ({count[curve.kind]})"] = curve
    return named_curves
