"""Findings -> what a map is made of, the same for both kinds: lines, points, places and regions."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Sequence
from dataclasses import dataclass, field

import numpy as np

from wucht.numerics.continuation.equilibria import FOLD
from wucht.numerics.periodic.branch_ends import NOT_IDENTIFIED, SADDLE_NODE_ON_ORBIT
from wucht.studies.speed_curve.second_parameter import FollowedCurve
from wucht.studies.stability_map.ending_map import EndingFindings, unexplained
from wucht.studies.stability_map.fold_crossings import COINCIDE
from wucht.studies.stability_map.map_words import (
    ENDINGS,
    MODULATED,
    ORBIT_CURVES,
    POINTS,
    SHORT,
    TONES,
    UNKNOWN,
    UNNAMED,
    UNSETTLED,
    numbered,
    state_label,
)  # fmt: skip
from wucht.studies.stability_map.plane_regions import Regions, kinds_of, regions, sides_of
from wucht.studies.stability_map.prepare import Plan
from wucht.studies.stability_map.state_map import StateFindings, extended, lines_of
from wucht.studies.stability_map.state_rows import STABLE, OrbitRow

_ON_FOLD = 1e-4  # of the range: a row's end that lies on a curve of folds
_SAME_SIDES = 0.5  # of a curve's points: a curve with different things on both sides at fewer of them parts nothing
_SMALL_PARTS = 12  # points at its ends, at most, that are not looked at


@dataclass(frozen=True, eq=False)
class Line:
    """A boundary. name, group: its own, and of all that are drawn alike. value (N,): of the third parameter."""

    name: str
    group: str
    x: np.ndarray
    y: np.ndarray
    value: np.ndarray


@dataclass(frozen=True)
class Mark:
    """A point of the plane. value: of the third parameter, not a number where there is none."""

    kind: str
    label: str
    x: float
    y: float
    value: float = math.nan


@dataclass(frozen=True)
class Place:
    """A place that was looked at, with what is the case there. begins, ends: values of the third parameter."""

    x: float
    y: float
    label: str
    begins: float = math.nan
    ends: float = math.nan


@dataclass(frozen=True, eq=False)
class MapParts:
    """Of a map. labels, tones, hatches: of its regions; everywhere: names of states that are stable in all of them.

    against: places that say otherwise than their region. lost: sentences on what is missing.
    """

    lines: tuple[Line, ...]
    marks: tuple[Mark, ...]
    places: tuple[Place, ...]
    areas: Regions
    labels: tuple[str, ...]
    tones: tuple[int, ...]
    hatches: tuple[int, ...]
    everywhere: tuple[str, ...] = ()
    against: tuple[Place, ...] = ()
    lost: tuple[str, ...] = field(default_factory=tuple)


def ending_parts(plan: Plan, findings: EndingFindings) -> MapParts:
    """The map of how the modulated motion ends."""
    areas = regions([(c.x, c.y) for c in findings.curves], plan.bounds)
    asked = [(p.x, p.y, p.kind) for p in findings.places]
    kinds, against = kinds_of(areas, asked)
    lines = []
    for c in findings.curves:
        inner = slice(2, -2) if len(c.x) > _SMALL_PARTS else slice(None)
        sides = sides_of(areas, kinds, c.x[inner], c.y[inner])
        differing = [s for s in sides if s[0] != s[1]]
        if len(differing) <= _SAME_SIDES * len(sides):
            continue
        a, b = Counter((min(s), max(s)) for s in differing).most_common(1)[0][0]
        name = " | ".join(sorted((SHORT.get(a, UNKNOWN), SHORT.get(b, UNKNOWN)), key=list(SHORT.values()).index))
        lines.append((name, c))
    names = numbered([name for name, _ in lines])
    made = tuple(Line(n, g, c.x, c.y, c.value) for n, (g, c) in zip(names, lines, strict=True))
    marks = tuple(Mark(p.kind, POINTS[p.kind], p.x, p.y, p.value) for p in findings.points)
    places = tuple(Place(p.x, p.y, ENDINGS.get(p.kind, UNKNOWN), p.begins, p.value) for p in findings.places)
    labels = tuple(ENDINGS.get(k, UNKNOWN) for k in kinds)
    tones = tuple(TONES.get(k, 0) for k in kinds)
    wrong = tuple(Place(x, y, ENDINGS.get(k, UNKNOWN)) for x, y, k in against)
    lost = list(findings.lost)
    if findings.complete and (left := unexplained(plan, findings)):
        one, other = left[0]
        lost.append(
            f"between {len(left)} pairs of neighbouring places no curve was found, such as {plan.along.path} = {one.x:.4g}, "
            f"{plan.second.path} = {one.y:.4g} ({ENDINGS.get(one.kind, UNKNOWN)}) and {other.x:.4g}, {other.y:.4g} "
            f"({ENDINGS.get(other.kind, UNKNOWN)})"
        )
    return MapParts(made, marks, places, areas, labels, tones, tuple(int(t == 1) for t in tones), (), wrong, tuple(lost))


def state_parts(plan: Plan, findings: StateFindings) -> MapParts:
    """The map of steady states and modulated motions."""
    areas = regions(lines_of(plan, findings), plan.bounds)
    looked = _looked(plan, findings)
    sets = [set(names) for _, _, names, _ in looked]
    everywhere = set.intersection(*sets) if sets else set()
    keyed = [(x, y, f"{level};{','.join(sorted(set(names) - everywhere))}") for x, y, names, level in looked]
    kinds, against = kinds_of(areas, keyed)
    read = [_read(kind) for kind in kinds]
    sought = plan.motion is not None
    labels = [state_label(names, level, sought) if known else "not looked at" for names, level, known in read]
    hatched = sorted({tuple(names) for names, _, _ in read if names})
    hatches = [1 + hatched.index(tuple(names)) if names else 0 for names, _, _ in read]
    lines = [(f"{c.of}: {c.kind.name or 'steady states'}", c.u[-2], c.u[-1]) for c in findings.curves]
    lines += [(f"{MODULATED}: {ORBIT_CURVES[c.kind]}", c.x, c.y) for c in extended(plan, findings)]
    lines += [(f"{MODULATED}: {ORBIT_CURVES[SADDLE_NODE_ON_ORBIT]}", x, y) for x, y in _ends_on_folds(plan, findings)]
    names = numbered([name for name, _, _ in lines])
    made = tuple(Line(n, g, x, y, np.full(len(x), np.nan)) for n, (g, x, y) in zip(names, lines, strict=True))
    marks = [Mark(COINCIDE, COINCIDE, c.x, c.y) for c in findings.crossings]
    marks += [
        Mark(kind, kind.replace("-", " "), float(c.u[-2, i]), float(c.u[-1, i]))
        for c in findings.curves for i, kind in enumerate(c.kinds) if kind
    ]  # fmt: skip
    places = tuple(Place(x, y, state_label(sorted(set(names) - everywhere), level, sought)) for x, y, names, level in looked)
    wrong = tuple(Place(x, y, state_label(*_read(kind)[:2], sought)) for x, y, kind in against)
    return MapParts(
        made, tuple(marks), places, areas, tuple(labels), tuple(level for _, level, _ in read), tuple(hatches),
        tuple(sorted(everywhere)), wrong, findings.lost,
    )  # fmt: skip


def _read(kind: str) -> tuple[list[str], int, bool]:
    level, _, names = kind.partition(";")
    return ([n for n in names.split(",") if n], int(level), True) if level else ([], 0, False)


def _looked(plan: Plan, findings: StateFindings) -> list[tuple[float, float, tuple[str, ...], int]]:
    """Each place with the stable motions there: steady states by name, and how stable modulated ones are, see ``LEVELS``.

    They are those of the branches, and those that runs from several starts have reached.
    """
    orbits = [r for r in findings.orbits if isinstance(r, OrbitRow)]
    reached = {(r.x, r.y): r for r in findings.reached}
    across = plan.centres(0).tolist()
    # The rows of the cells come first; each of the others is of one place.
    values = [across] * plan.cells + [[x] for x, _ in findings.extra]
    found = []
    for row, xs in zip(findings.rows, values, strict=False):
        for x, named in zip(xs, row.stable, strict=True):
            names, level = list(named), max((r.state_at(x) for r in orbits if r.second == row.second), default=0)
            if (runs := reached.get((x, row.second))) is not None:
                level = STABLE if runs.orbits else level
                names += [UNNAMED] if runs.steady and not named else []
                names += [UNSETTLED] if runs.unsettled else []
            found.append((x, row.second, tuple(names), level))
    return found


def _ends_on_folds(plan: Plan, findings: StateFindings) -> list[tuple[np.ndarray, np.ndarray]]:
    """Those parts of fold curves that lie on the modulated motion: between rows whose branch ends there."""
    rows = [r for r in findings.orbits if isinstance(r, OrbitRow)]
    half = (plan.bounds[1][1] - plan.bounds[1][0]) / plan.cells / 2
    parts = []
    for c in findings.curves:
        if c.of != FOLD:
            continue
        seconds = [
            r.second
            for r in rows
            for s in r.sides
            if s.kind in (SADDLE_NODE_ON_ORBIT, NOT_IDENTIFIED) and _lies_on(plan, c, s.value, r.second)
        ]
        if not seconds:
            continue
        low, high = min(seconds) - half, max(seconds) + half
        for crossing in findings.crossings:
            if low <= crossing.y <= min(seconds):
                low = crossing.y
        y = c.u[-1]
        inside = (y >= low) & (y <= high)
        if inside.sum() > 1:
            parts.append((c.u[-2][inside], y[inside]))
    return parts


def _lies_on(plan: Plan, curve: FollowedCurve, value: float, second: float) -> bool:
    x, y = curve.u[-2:]
    width = plan.bounds[0][1] - plan.bounds[0][0]
    i = np.flatnonzero((y[:-1] - second) * (y[1:] - second) <= 0)
    near = 0.02 * np.abs(np.diff(x))[i] + _ON_FOLD * width
    share = np.divide(second - y[i], y[i + 1] - y[i], out=np.zeros(len(i)), where=y[i + 1] != y[i])
    return bool((np.abs(x[i] + share * (x[i + 1] - x[i]) - value) < near).any())


def shares(areas: Regions, labels: Sequence[str]) -> dict[str, float]:
    """Of the plane that each label has."""
    sizes = np.bincount(areas.index.ravel(), minlength=areas.count) / areas.index.size
    return {label: float(sizes[[k for k, each in enumerate(labels) if each == label]].sum()) for label in dict.fromkeys(labels)}
