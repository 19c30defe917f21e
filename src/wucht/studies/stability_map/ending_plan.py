"""The map of how the modulated motion ends as a third parameter changes: its plan, and what it is made of."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping
from dataclasses import dataclass

from wucht.dynamics.branches.ending_curves import DOUBLE, Plane
from wucht.dynamics.branches.ending_map import EndingFindings, EndingMapCase, map_endings, unexplained
from wucht.dynamics.branches.orbit_endings import NONE
from wucht.dynamics.branches.plane_regions import Bounds, kinds_of, regions, sides_of
from wucht.dynamics.parameters import ends_of, parameter_of
from wucht.dynamics.work import Work
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.numerics.periodic.branch_ends import RANGE, SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.schema import Parameter
from wucht.studies.stability_map.map_parts import UNKNOWN, Line, MapParts, MapPlan, Mark, Place, numbered
from wucht.studies.stability_map.spec import StabilityMap

ENDINGS: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "ends at a saddle-node on the orbit",
    SADDLE_CONNECTION: "ends at a saddle connection",
    RANGE: "lasts to the end of the range",
    NONE: "no modulated motion begins",
}
SHORT: Mapping[str, str] = {
    SADDLE_NODE_ON_ORBIT: "saddle-node on the orbit",
    SADDLE_CONNECTION: "saddle connection",
    RANGE: "end of the range",
    NONE: "no modulated motion",
}
POINTS: Mapping[str, str] = {DOUBLE: "connection of two saddle-nodes"}
TONES: Mapping[str, int] = {SADDLE_NODE_ON_ORBIT: 2, SADDLE_CONNECTION: 1, RANGE: 3, NONE: 0}
_CELLS = 6  # a side, by default
_SAME_SIDES = 0.5  # of a curve's points: a curve with different things on both sides at fewer of them parts nothing
_SMALL_PARTS = 12  # points at its ends, at most, that are not looked at


@dataclass(frozen=True, eq=False)
class EndingPlan(MapPlan[EndingFindings]):
    """third: the parameter that changes."""

    third: Parameter
    case: EndingMapCase

    @classmethod
    def of(
        cls, spec: StabilityMap, subject: Machine | OwnEquations, along: Parameter, second: Parameter, bounds: Bounds
    ) -> EndingPlan:  # fmt: skip
        """Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
        assert spec.eliminate is not None and spec.eliminate_range is not None
        third = parameter_of(subject, spec.eliminate, "eliminate")
        ends = ends_of(subject, third, spec.eliminate_range, "eliminate_range")
        plane = Plane((third.path, along.path, second.path), (ends, *bounds))
        case = EndingMapCase.of(subject, plane, spec.cells or _CELLS, spec.settings, spec.orbit_settings)
        return cls(along, second, bounds, case.warnings, third, ends, case)

    def run(self, work: Work) -> Iterator[EndingFindings]:
        """See ``MapPlan``."""
        return map_endings(self.case, work)

    def parts(self, findings: EndingFindings) -> MapParts:
        """See ``MapPlan``."""
        areas = regions([(c.x, c.y) for c in findings.curves], self.bounds)
        kinds, against = kinds_of(areas, [(p.x, p.y, p.kind) for p in findings.places])
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
        tones = tuple(TONES.get(k, 0) for k in kinds)
        return MapParts(
            lines=tuple(Line(n, g, c.x, c.y, c.value) for n, (g, c) in zip(names, lines, strict=True)),
            marks=tuple(Mark(p.kind, POINTS[p.kind], p.x, p.y, p.value) for p in findings.points),
            places=tuple(Place(p.x, p.y, ENDINGS.get(p.kind, UNKNOWN), p.begins, p.end.value) for p in findings.places),
            areas=areas, labels=tuple(ENDINGS.get(k, UNKNOWN) for k in kinds), tones=tones,
            hatches=tuple(int(t == 1) for t in tones),
            against=tuple(Place(x, y, ENDINGS.get(k, UNKNOWN)) for x, y, k in against),
            lost=(*findings.lost, *self._unexplained(findings)),
        )  # fmt: skip

    def _unexplained(self, findings: EndingFindings) -> list[str]:
        """A sentence on neighbouring places that differ, with no curve between them."""
        if not findings.complete or not (left := unexplained(self.case, findings)):
            return []
        one, other = left[0]
        return [
            f"between {len(left)} pairs of neighbouring places no curve was found, such as {self.along.path} = {one.x:.4g}, "
            f"{self.second.path} = {one.y:.4g} ({ENDINGS.get(one.kind, UNKNOWN)}) and {other.x:.4g}, {other.y:.4g} "
            f"({ENDINGS.get(other.kind, UNKNOWN)})"
        ]

    def sentence(self, parts: MapParts, areas: Mapping[str, float]) -> str:
        """See ``MapPlan``."""
        listed = ", ".join(f"{label} in {100 * share:.0f} %" for label, share in areas.items())
        sentence = f"the modulated motion, as {self.third.called} changes: {listed} of the plane"
        at = [f"{self.along.at(m.x, 7)}, {self.second.at(m.y, 7)}" for m in parts.marks]
        return sentence + (f"; the regions meet at {' and at '.join(at)}" if at else "")
