"""The map of how the modulated motion ends: places in the plane looked at one by one, and the curves between them."""

from __future__ import annotations

from collections.abc import Generator
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.studies.stability_map.ending_curves import RETURNS, EndingCurve, EndingPoint, curves_between
from wucht.studies.stability_map.orbit_endings import OrbitEnding, ending_at
from wucht.studies.stability_map.plane_regions import regions
from wucht.studies.stability_map.prepare import Plan

_PLACES, _CURVES = 0.7, 0.9  # shares of the work, by which these are done
_ATTEMPTS = 3  # curves that are begun between places


@dataclass(frozen=True)
class EndingFindings:
    """So far. places: that were looked at. curves, points: of the plane. lost: sentences on what was not found."""

    places: tuple[OrbitEnding, ...] = ()
    curves: tuple[EndingCurve, ...] = ()
    points: tuple[EndingPoint, ...] = ()
    lost: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False


Stage = Generator[EndingFindings, None, EndingFindings]


def run_endings(plan: Plan, work: Work) -> Stage:
    """Place by place, then the curves, then a place in each region that has none."""
    findings = EndingFindings()
    cells = [(x, y) for y in plan.centres(1).tolist() for x in plan.centres(0).tolist()]
    for k, cell in enumerate(cells):
        findings = _with(findings, _looked(plan, work, cell, _PLACES * k / len(cells)))
        yield findings
    findings = yield from _curves(plan, findings, work)
    assert plan.plane is not None
    parted = regions([(c.x, c.y) for c in findings.curves], plan.plane.bounds[1:])
    known = {parted.at(p.x, p.y) for p in findings.places}
    for k in [k for k in range(parted.count) if k not in known]:
        findings = _with(findings, _looked(plan, work, parted.inmost(k), _CURVES))
        yield findings
    return replace(findings, complete=True)


def _with(findings: EndingFindings, place: OrbitEnding) -> EndingFindings:
    return replace(findings, places=(*findings.places, place))


def _looked(plan: Plan, work: Work, place: tuple[float, float], share: float) -> OrbitEnding:
    x, y = place
    what = f"{plan.along.path} = {x:.4g}, {plan.second.path} = {y:.4g}"
    work.report(share, what)
    return work.unit(f"place {x!r} {y!r}", partial(_ending, plan, place, partial(work.report, share, what)))


def _ending(plan: Plan, place: tuple[float, float], watch: partial[None]) -> OrbitEnding:
    assert plan.motion is not None and plan.plane is not None
    path, bounds = plan.plane.paths[0], plan.plane.bounds[0]
    there = plan.motion.at(dict(zip(plan.plane.paths[1:], place, strict=True)), path)
    try:
        return ending_at(there, path, bounds, place, watch)
    except WuchtError as error:
        return OrbitEnding(*place, "failed", float("nan"), float("nan"), str(error))


def _curves(plan: Plan, findings: EndingFindings, work: Work) -> Stage:
    """The curves that begin between neighbouring places where the motion ends differently."""
    assert plan.motion is not None and plan.plane is not None
    attempts = 0
    for a, b in _neighbours(plan, findings):
        kinds = {a.kind, b.kind}
        if kinds != {SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT} or attempts >= _ATTEMPTS:
            continue
        if any(c.kind == RETURNS and passes_between(c, a, b) for c in findings.curves):
            continue
        connected, other = (a, b) if a.kind == SADDLE_CONNECTION else (b, a)
        share = _PLACES + (_CURVES - _PLACES) * attempts / _ATTEMPTS
        watch = partial(work.report, share)
        make = partial(curves_between, plan.motion, plan.plane, connected, other, watch)
        made = work.unit(f"curves {connected.x!r} {connected.y!r} {other.x!r} {other.y!r}", make)
        attempts += 1
        findings = replace(
            findings, curves=(*findings.curves, *made.curves), points=(*findings.points, *made.points),
            lost=(*findings.lost, *made.lost),
        )  # fmt: skip
        yield findings
    return findings


def _neighbours(plan: Plan, findings: EndingFindings) -> list[tuple[OrbitEnding, OrbitEnding]]:
    """Places side by side, or one above the other; those far from the plane's corners first, where all is best known."""
    n, cells = plan.cells, findings.places
    pairs = [(cells[r * n + c], cells[r * n + c + 1]) for r in range(n) for c in range(n - 1)]
    pairs += [(cells[r * n + c], cells[(r + 1) * n + c]) for r in range(n - 1) for c in range(n)]
    middle = np.array([sum(b) / 2 for b in plan.bounds])
    width = np.array([b[1] - b[0] for b in plan.bounds])
    return sorted(
        pairs,
        key=lambda p: float(np.linalg.norm(((p[0].x + p[1].x) / 2 - middle[0], (p[0].y + p[1].y) / 2 - middle[1]) / width)),
    )


def passes_between(curve: EndingCurve, a: OrbitEnding, b: OrbitEnding) -> bool:
    """Whether a curve crosses the straight way between two places."""
    way, x, y = np.array([b.x - a.x, b.y - a.y]), curve.x - a.x, curve.y - a.y
    beside = x * way[1] - y * way[0]
    along = (x * way[0] + y * way[1]) / (way @ way)
    for i in np.flatnonzero(beside[:-1] * beside[1:] <= 0).tolist():
        share = beside[i] / (beside[i] - beside[i + 1]) if beside[i] != beside[i + 1] else 0.0
        if 0 <= along[i] + share * (along[i + 1] - along[i]) <= 1:
            return True
    return False


def unexplained(plan: Plan, findings: EndingFindings) -> list[tuple[OrbitEnding, OrbitEnding]]:
    """Neighbouring places where the motion ends differently, with no curve between them."""
    return [
        (a, b) for a, b in _neighbours(plan, findings)
        if a.kind != b.kind and not any(passes_between(c, a, b) for c in findings.curves)
    ]  # fmt: skip
