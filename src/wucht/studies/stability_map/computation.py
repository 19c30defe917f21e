"""Question and subject -> plan -> findings: the map of all motions, or that of the ends of the modulated motion."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from wucht.dynamics.branches.ending_curves import ParameterPlane
from wucht.dynamics.branches.ending_map import EndingFindings, EndingMapCase, map_endings, unexplained_changes
from wucht.dynamics.branches.orbit_endings import NO_MOTION
from wucht.dynamics.branches.plane_regions import (
    NOT_DECIDED,
    Bounds,
    PlaneCurve,
    PlanePoint,
    cell_size,
    divide_plane,
    divided_by_places,
    kinds_by_region,
    sides_of,
)
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.dynamics.branches.state_map import (
    StateFindings,
    StateMapCase,
    examined_places,
    extended_curves,
    lines_of,
    map_states,
)
from wucht.dynamics.parameters import checked_range, parameter_of
from wucht.dynamics.work import Work
from wucht.files.user_system import UserSystem
from wucht.machines.machine import Machine
from wucht.numerics.continuation.equilibria import FOLD
from wucht.numerics.periodic.branch_ends import NOT_IDENTIFIED, RANGE, SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.numerics.zeros_and_peaks import values_at_passages
from wucht.schema import Parameter
from wucht.studies.stability_map.map_parts import (
    MODULATED_MOTION,
    NO_OTHER_STATE,
    NOT_EXAMINED,
    NOTHING_ELSE,
    PERIODIC_ORBIT,
    UNDECIDED_TONE,
    UNKNOWN,
    F,
    MapParts,
    MapPlace,
    MapPlan,
    curves_by_name,
)
from wucht.studies.stability_map.spec import StabilityMap

ORBIT_CURVES: Mapping[str, str] = {
    "branch-point": "loses stability sideways",
    "fold": "fold",
    "period-doubling": "period doubling",
    "torus": "torus",
    SADDLE_CONNECTION: "saddle connection",
    SADDLE_NODE_ON_ORBIT: "saddle-node on it",
}
LEVELS = ("", "unstable", "stable")  # of the motion that is periodic but not steady
_ON_FOLD = 1e-4  # of the range: a row's end that lies on a curve of folds
ENDINGS: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "ends at a saddle-node on the orbit",
    SADDLE_CONNECTION: "ends at a saddle connection",
    RANGE: "lasts to the end of the range",
}
SHORT: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "saddle-node on the orbit",
    SADDLE_CONNECTION: "saddle connection",
    RANGE: "end of the range",
}
TONES: Mapping[str, int] = {SADDLE_NODE_ON_ORBIT: 2, SADDLE_CONNECTION: 1, RANGE: 3, NO_MOTION: 0}
_SAME_SIDES = 0.5  # of a curve's points: a curve with different regions on both sides at fewer points separates nothing
_SMALL_PARTS = 12  # points: a longer curve is judged without its ends
_CELLS_OF_STATES, _CELLS_OF_ENDINGS = 12, 6  # a side, by default


def prepare(spec: StabilityMap, subject: Machine | UserSystem) -> StatePlan | EndingPlan:
    """Return the plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along, second = parameter_of(subject, spec.along, "along"), parameter_of(subject, spec.second, "second")
    bounds = checked_range(subject, along, spec.range), checked_range(subject, second, spec.second_range, "second_range")
    return (StatePlan if spec.eliminate is None else EndingPlan).from_spec(spec, subject, along, second, bounds)


def run(plan: MapPlan[F], work: Work) -> Iterator[F]:
    """Yield the findings, each more complete than those before."""
    return plan.run(work)


@dataclass(frozen=True, eq=False)
class StatePlan(MapPlan[StateFindings]):
    """The plan of a map of all motions, without a third parameter."""

    case: StateMapCase

    @classmethod
    def from_spec(
        cls, spec: StabilityMap, subject: Machine | UserSystem, along: Parameter, second: Parameter, bounds: Bounds
    ) -> StatePlan:  # fmt: skip
        """Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
        paths, orbits = (along.path, second.path), spec.orbit_settings if spec.orbits else None
        case = StateMapCase.of(subject, paths, bounds, spec.cells or _CELLS_OF_STATES, spec.settings, orbits)
        return cls(along, second, bounds, case.warnings, None, (), case, motion=_motion_of(subject))

    def run(self, work: Work) -> Iterator[StateFindings]:
        """See ``MapPlan``."""
        return map_states(self.case, work)

    def sentence(self, parts: MapParts, areas: Mapping[str, float]) -> str:
        """See ``MapPlan``."""
        listing = "; ".join(f"{label} in {100 * share:.0f} %" for label, share in areas.items())
        everywhere = f"stable everywhere: {', '.join(parts.everywhere)}; in addition " if parts.everywhere else "stable: "
        left_out = f"; {self.motion}s were not searched for" if self.case.motion is None else ""
        only = (
            f"; of the steady states {' and '.join(self.case.settings.only)} alone were sought"
            if self.case.settings.only
            else ""
        )
        limit = f"; what exists in less than {100 * parts.detection_limit:.2g} % of it may be missed at the places examined"
        return f"{everywhere}{listing} of the plane{limit}{only}{left_out}"

    def parts(self, findings: StateFindings) -> MapParts:
        """See ``MapPlan``."""
        places = examined_places(self.case, findings)
        everywhere = frozenset(set.intersection(*(set(p.names) for p in places)) if places else ())
        keys = [(p.x, p.y, p.key(everywhere)) for p in places]
        motions = {key: (sorted(set(p.names) - everywhere), p.level) for p, (_, _, key) in zip(places, keys, strict=True)}
        areas = divide_plane(lines_of(self.case, findings), self.bounds)
        kinds, contradictions = kinds_by_region(areas, keys)
        areas, kinds = divided_by_places(areas, kinds, keys, cell_size(self.bounds, self.case.cells))
        includes_orbits = self.case.motion is not None
        labels_of = {key: state_label(*motion, includes_orbits, self.motion) for key, motion in motions.items()}
        hatched_sets = sorted({tuple(names) for names, _ in motions.values() if names})
        hatches = {key: 1 + hatched_sets.index(tuple(names)) for key, (names, _) in motions.items() if names}
        lines = [
            _line(f"{c.bifurcation}: {c.kind.name or 'steady states'}", c.unknowns[-2], c.unknowns[-1]) for c in findings.curves
        ]
        lines += [_line(f"{self.motion}: {ORBIT_CURVES[c.kind]}", c.x, c.y) for c in extended_curves(self.case, findings)]
        on_orbit = f"{self.motion}: {ORBIT_CURVES[SADDLE_NODE_ON_ORBIT]}"
        lines += [_line(on_orbit, x, y) for x, y in _ends_on_folds(self.case, findings)]
        marks = [
            PlanePoint(kind, float(c.unknowns[-2, i]), float(c.unknowns[-1, i]))
            for c in findings.curves for i, kind in enumerate(c.kinds) if kind
        ]  # fmt: skip
        return MapParts(
            curves_by_name(lines), (*findings.crossings, *marks), tuple(MapPlace(x, y, labels_of[key]) for x, y, key in keys),
            areas, tuple(labels_of.get(k, k or NOT_EXAMINED) for k in kinds),
            tuple(UNDECIDED_TONE if k == NOT_DECIDED else motions[k][1] if k else 0 for k in kinds),
            tuple(hatches.get(k, 0) for k in kinds), tuple(sorted(everywhere)),
            tuple(MapPlace(x, y, labels_of[key]) for x, y, key in contradictions),
            findings.omissions, sum(place.runs for place in findings.runs_by_place),
            len(findings.runs_by_place) if includes_orbits else len(findings.rows) * self.case.settings.searches,
        )  # fmt: skip


def _line(kind: str, x: np.ndarray, y: np.ndarray) -> PlaneCurve:
    return PlaneCurve(kind, x, y, np.full(len(x), np.nan))


def _motion_of(subject: Machine | UserSystem) -> str:
    return MODULATED_MOTION if isinstance(subject, Machine) else PERIODIC_ORBIT


def state_label(names: Sequence[str], level: int, includes_orbits: bool, motion: str = MODULATED_MOTION) -> str:
    """Return a label such as ``together, modulated motion stable``. includes_orbits: modulated motions were searched."""
    parts = [*names, f"{motion} {LEVELS[level]}"] if level else [*names]
    return ", ".join(parts) or (NOTHING_ELSE if includes_orbits else NO_OTHER_STATE)


def _ends_on_folds(case: StateMapCase, findings: StateFindings) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return the parts of fold curves on the modulated motion: between rows whose branch ends there."""
    half = (case.bounds[1][1] - case.bounds[1][0]) / case.cells / 2
    parts = []
    for c in findings.curves:
        if c.bifurcation != FOLD:
            continue
        seconds = [
            r.second
            for r in findings.orbit_rows
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


@dataclass(frozen=True, eq=False)
class EndingPlan(MapPlan[EndingFindings]):
    """The plan of a map of endings. third: the parameter that changes."""

    third: Parameter
    case: EndingMapCase

    @classmethod
    def from_spec(
        cls, spec: StabilityMap, subject: Machine | UserSystem, along: Parameter, second: Parameter, bounds: Bounds
    ) -> EndingPlan:  # fmt: skip
        """Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
        assert spec.eliminate is not None and spec.eliminate_range is not None
        third = parameter_of(subject, spec.eliminate, "eliminate")
        ends = checked_range(subject, third, spec.eliminate_range, "eliminate_range")
        plane = ParameterPlane((third.path, along.path, second.path), (ends, *bounds))
        case = EndingMapCase.of(subject, plane, spec.cells or _CELLS_OF_ENDINGS, spec.settings, spec.orbit_settings)
        return cls(along, second, bounds, case.warnings, third, ends, case, motion=_motion_of(subject))

    def run(self, work: Work) -> Iterator[EndingFindings]:
        """See ``MapPlan``."""
        return map_endings(self.case, work)

    def parts(self, findings: EndingFindings) -> MapParts:
        """See ``MapPlan``."""
        areas = divide_plane([(c.x, c.y) for c in findings.curves], self.bounds)
        keys = [(p.x, p.y, p.kind) for p in findings.places]
        kinds, contradictions = kinds_by_region(areas, keys)
        areas, kinds = divided_by_places(areas, kinds, keys, cell_size(self.bounds, self.case.cells))
        lines = list[PlaneCurve]()
        for c in findings.curves:
            inner = slice(2, -2) if len(c.x) > _SMALL_PARTS else slice(None)
            sides = sides_of(areas, kinds, c.x[inner], c.y[inner])
            differing = [s for s in sides if s[0] != s[1]]
            if len(differing) <= _SAME_SIDES * len(sides):
                continue
            a, b = Counter((min(s), max(s)) for s in differing).most_common(1)[0][0]
            short = {**SHORT, NO_MOTION: f"no {self.motion}"}
            name = " | ".join(sorted((short.get(a, UNKNOWN), short.get(b, UNKNOWN)), key=list(short.values()).index))
            lines.append(replace(c, kind=name))
        tones = tuple(UNDECIDED_TONE if k == NOT_DECIDED else TONES.get(k, 0) for k in kinds)
        return MapParts(
            lines=curves_by_name(lines), marks=findings.points,
            places=tuple(MapPlace(p.x, p.y, self._ending(p.kind), p.begins, p.end.value) for p in findings.places),
            areas=areas, labels=tuple(k if k == NOT_DECIDED else self._ending(k) for k in kinds), tones=tones,
            hatches=tuple(int(t == 1) for t in tones),
            contradictions=tuple(MapPlace(x, y, self._ending(k)) for x, y, k in contradictions),
            omissions=(*findings.omissions, *self._unexplained_warnings(findings)),
        )  # fmt: skip

    def _ending(self, kind: str) -> str:
        """Return how the motion ends, in words."""
        return f"no {self.motion} begins" if kind == NO_MOTION else ENDINGS.get(kind, UNKNOWN)

    def _unexplained_warnings(self, findings: EndingFindings) -> list[str]:
        """Return a warning on neighbouring places that differ, with no curve between them."""
        if not findings.complete or not (pairs := unexplained_changes(self.case, findings)):
            return []
        first, second = pairs[0]
        return [
            f"between {len(pairs)} pairs of neighbouring places that differ no curve was found, such as "
            f"{self.along.path} = {first.x:.4g}, {self.second.path} = {first.y:.4g} "
            f"({self._ending(first.kind)}) and {second.x:.4g}, {second.y:.4g} ({self._ending(second.kind)})"
        ]

    def sentence(self, parts: MapParts, areas: Mapping[str, float]) -> str:
        """See ``MapPlan``."""
        listing = ", ".join(f"{label} in {100 * share:.0f} %" for label, share in areas.items())
        sentence = f"the {self.motion}, as {self.third.sentence_name} changes: {listing} of the plane"
        at = [f"{self.along.value_text(m.x, 7)}, {self.second.value_text(m.y, 7)}" for m in parts.marks]
        return sentence + (f"; the regions meet at {' and at '.join(at)}" if at else "")
