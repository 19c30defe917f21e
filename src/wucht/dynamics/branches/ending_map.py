"""Map of the ways in which the modulated motion ends: places in the plane examined one by one, and the curves between them."""

from __future__ import annotations

import math
from collections.abc import Generator, Iterator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.dynamics.branches.ending_curves import RETURNS, curves_between
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.orbit_endings import OrbitEnd, OrbitEnding, ending_at
from wucht.dynamics.branches.plane_regions import PlaneCurve, PlanePoint, divide_plane
from wucht.dynamics.work import Work, with_result
from wucht.errors import WuchtError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT

_PLACES, _CURVES = 0.7, 0.9  # shares of the work at which these are done
_ATTEMPTS = 3  # curves that are begun between places


@dataclass(frozen=True)
class EndingFindings:
    """Results so far. places: examined ones. curves, points: of the plane. omissions: sentences on what is missing."""

    places: tuple[OrbitEnding, ...] = ()
    curves: tuple[PlaneCurve, ...] = ()
    points: tuple[PlanePoint, ...] = ()
    omissions: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False


Stage = Generator[EndingFindings, None, EndingFindings]


def map_endings(case: EndingMapCase, work: Work) -> Iterator[EndingFindings]:
    """Examine place by place, then the curves, then a place in each region that has none; yield the findings after each."""
    findings = EndingFindings()
    cells = case.centres
    for k, cell in enumerate(cells):
        findings = with_result(findings, "places", _place(case, work, cell, _PLACES * k / len(cells)))
        yield findings
    findings = yield from _curves(case, findings, work)
    partition = divide_plane([(c.x, c.y) for c in findings.curves], case.bounds)
    sampled_regions = {partition.region_at(p.x, p.y) for p in findings.places}
    for k in [k for k in range(partition.count) if k not in sampled_regions]:
        findings = with_result(findings, "places", _place(case, work, partition.innermost_point(k), _CURVES))
        yield findings
    work.report(1.0)
    yield replace(findings, complete=True)


def _place(case: EndingMapCase, work: Work, place: tuple[float, float], share: float) -> OrbitEnding:
    (_, along, second), (x, y) = case.paths, place
    label = f"{along} = {x:.4g}, {second} = {y:.4g}"
    work.report(share, label)
    return work.unit(f"place {x!r} {y!r}", partial(_ending, case, place, partial(work.report, share, label)))


def _ending(case: EndingMapCase, place: tuple[float, float], report: partial[None]) -> OrbitEnding:
    try:
        return ending_at(case.motion_at(*place), place, report)
    except WuchtError as error:
        return OrbitEnding(*place, math.nan, OrbitEnd("failed", math.nan, str(error)))


def _curves(case: EndingMapCase, findings: EndingFindings, work: Work) -> Stage:
    """Follow the curves that begin between neighbouring places where the motion ends differently."""
    attempts = 0
    for a, b in _neighbours(case, findings):
        kinds = {a.kind, b.kind}
        if kinds != {SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT} or attempts >= _ATTEMPTS:
            continue
        if any(c.kind == RETURNS and c.passes_between((a.x, a.y), (b.x, b.y)) for c in findings.curves):
            continue
        connection_ending, saddle_node_ending = (a, b) if a.kind == SADDLE_CONNECTION else (b, a)
        share = _PLACES + (_CURVES - _PLACES) * attempts / _ATTEMPTS
        report = partial(work.report, share)
        make = partial(curves_between, case, connection_ending, saddle_node_ending, report)
        place, beside = ((e.x, e.y) for e in (connection_ending, saddle_node_ending))
        parts = work.unit(f"curves {place[0]!r} {place[1]!r} {beside[0]!r} {beside[1]!r}", make)
        attempts += 1
        for part in parts:
            findings = with_result(findings, "points" if isinstance(part, PlanePoint) else "curves", part)
        yield findings
    return findings


def _neighbours(case: EndingMapCase, findings: EndingFindings) -> list[tuple[OrbitEnding, OrbitEnding]]:
    """Pairs of adjacent places; those far from the plane's corners first, where the motion is best known."""
    n, cells = case.cells, findings.places
    pairs = [(cells[r * n + c], cells[r * n + c + 1]) for r in range(n) for c in range(n - 1)]
    pairs += [(cells[r * n + c], cells[(r + 1) * n + c]) for r in range(n - 1) for c in range(n)]
    middle = np.array([sum(b) / 2 for b in case.bounds])
    width = np.array([b[1] - b[0] for b in case.bounds])
    return sorted(
        pairs,
        key=lambda p: float(np.linalg.norm(((p[0].x + p[1].x) / 2 - middle[0], (p[0].y + p[1].y) / 2 - middle[1]) / width)),
    )


def unexplained_changes(case: EndingMapCase, findings: EndingFindings) -> list[tuple[OrbitEnding, OrbitEnding]]:
    """Return neighbouring places where the motion ends differently, with no curve between them."""
    return [
        (a, b) for a, b in _neighbours(case, findings)
        if a.kind != b.kind and not any(c.passes_between((a.x, a.y), (b.x, b.y)) for c in findings.curves)
    ]  # fmt: skip
