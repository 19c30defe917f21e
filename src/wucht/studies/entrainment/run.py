"""Plan -> findings: the machine's own run, the band of existence, runs from the start, locked motions, the threshold."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import partial
from itertools import chain

import numpy as np

from wucht.errors import InputError, WuchtError
from wucht.studies.entrainment.capture_band import CaptureBand, CaptureSearch
from wucht.studies.entrainment.existence import Existence, existence, range_around, threshold
from wucht.studies.entrainment.locked_motions import LockedMotion, LockedMotions
from wucht.studies.entrainment.prepare import Plan
from wucht.studies.entrainment.runs import RunFromStart, RunsFromStart, senses_of
from wucht.studies.work import Work

_RESOLUTION = 1e-5  # of the range
_BISECTIONS = 70  # expected, for the progress
_MOTIONS = 8  # to each side of the seed
_TOO_SHORT = 1.5  # times as long as a run is, it should have been: it is made again

Stage = Generator["Findings", None, "Findings"]  # each more complete than that before; the last is returned


@dataclass(frozen=True)
class Findings:
    """What has been found so far. own: the run of the machine as it is. range, resolution: what is looked at, and how finely.

    existing: what the averaged equations say; left_out: why they say nothing. runs: from the start, in increasing order of
    their value; band: reached by them. motions: locked ones, likewise in order; ends: where they end below and above, None
    where beyond the range; no_motion: why there are none. threshold: the least amplitude of the vibration. complete: nothing
    is left to do.
    """

    own: RunFromStart | None = None
    range: tuple[float, float] | None = None
    resolution: float = 0.0
    existing: Existence | None = None
    left_out: str | None = None
    runs: tuple[RunFromStart, ...] = ()
    band: CaptureBand | None = None
    motions: tuple[LockedMotion, ...] = ()
    ends: tuple[float | None, float | None] = (None, None)
    no_motion: str | None = None
    threshold: float | None = None
    complete: bool = False

    @property
    def failure(self) -> str | None:
        """Why the run of the machine as it is failed, after which nothing is looked for."""
        return self.own.failure if self.own is not None else None

    @property
    def own_motion(self) -> LockedMotion | None:
        """The locked motion of the machine as it is, if its run is taken along."""
        if self.own is None or not self.own.entrained:
            return None
        return next((m for m in self.motions if m.value == self.own.value), None)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Search; what is found after each run and each locked motion."""
    yield (found := Findings())
    runs = RunsFromStart(plan.machine, plan.swept, plan.start, plan.until)
    own = _run(runs, plan.swept.own, work.part("own", 0.0, 0.03))
    yield (found := replace(found, own=own))
    if own.failure is not None:
        return
    senses = senses_of(plan.machine, plan.initial, own)
    found = _with_existence(plan, found, own, senses, work.part("existence", 0.03, 0.1))
    runs = replace(runs, senses=senses, rate=found.existing.slowest_rate if found.existing is not None else None)
    if runs.duration > _TOO_SHORT * own.end_time:
        own = _run(runs, plan.swept.own, work.part("own, longer", 0.1, 0.1))
    yield (found := replace(found, own=own))
    found = yield from _with_band(plan, runs, found, own, work.part("runs", 0.1, 0.8))
    found = yield from _with_motions(plan, senses, found, work)
    least = threshold(plan, found.existing, work.part("threshold", 0.95, 1.0))
    work.report(1.0)
    yield replace(found, threshold=least, complete=True)


def _run(runs: RunsFromStart, value: float, work: Work, share: float = 0.0) -> RunFromStart:
    """A run from the start. share: of the part of the work, at which it is made."""
    what = f"{runs.swept.name} = {value:.6g}"
    return work.unit(f"at {value!r} for {runs.duration!r}", lambda: runs(value, lambda _: work.report(share, what)))


def _with_existence(plan: Plan, found: Findings, own: RunFromStart, senses: Mapping[str, float], work: Work) -> Findings:
    """The band of existence, and the range to be looked at."""
    try:
        found = replace(found, existing=existence(plan, own, senses, work))
    except InputError as error:
        found = replace(found, left_out=f"the slow equations are left out: {error.allowed}")
    low, high = plan.range or range_around(plan, found.existing.band if found.existing is not None else None)
    return replace(found, range=(low, high), resolution=plan.resolution or _RESOLUTION * (high - low))


def _with_band(plan: Plan, runs: RunsFromStart, found: Findings, own: RunFromStart, work: Work) -> Stage:
    """Runs evenly over the range and at the machine's own value, then those that the search for the edges asks for."""
    search, (low, high) = CaptureSearch(own.value, found.resolution), found.range or plan.limits
    scan = dict.fromkeys([*np.linspace(low, high, plan.points).tolist(), own.value])
    for k, value in enumerate(chain(scan, search.values())):
        search.add(own if value == own.value else _run(runs, value, work, k / (plan.points + _BISECTIONS)))
        yield (found := replace(found, runs=tuple(search.runs)))
    return replace(found, band=search.band)


def _with_motions(plan: Plan, senses: Mapping[str, float], found: Findings, work: Work) -> Stage:
    """Locked motions from the machine's own on, or from the run nearest to it that is taken along."""
    range_ = found.range
    nearest = min((r for r in found.runs if r.entrained), key=lambda r: abs(r.value - plan.swept.own), default=None)
    if nearest is None or range_ is None:
        return found
    locked = LockedMotions(plan.machine, plan.swept, senses, nearest.end_time)
    seed = work.unit("locked motion", partial(_seed, locked, nearest))
    if isinstance(seed, str):
        return replace(found, no_motion=f"at {plan.swept.name} = {nearest.value:.6g}: {seed}")
    yield (found := replace(found, motions=(seed,)))
    ends: list[float | None] = []
    for side, (end, edge) in enumerate(zip(range_, _expected_edges(found), strict=True)):
        inside = np.linspace(seed.value, edge, _MOTIONS + 1)[1:-1].tolist() if edge != seed.value else []
        goals = [*(v for v in inside if v not in (seed.value, end)), *([end] if end != seed.value else [])]
        others, part = found.motions, work.part("locked motion", (0.8, 0.875)[side], (0.875, 0.95)[side])
        ends.append(None)
        for followed in locked.followed(seed, goals, found.resolution, part):
            ends[side] = followed.end
            yield (found := replace(found, motions=tuple(sorted([*others, *followed.motions], key=lambda m: m.value))))
    return replace(found, ends=(ends[0], ends[1]))


def _seed(locked: LockedMotions, nearest: RunFromStart) -> LockedMotion | str:
    """The locked motion at the end of a run; or why there is none."""
    try:
        return locked.motion(nearest.value, nearest.end_state, abs(nearest.mean_speed))
    except WuchtError as error:
        return str(error)


def _expected_edges(found: Findings) -> tuple[float, float]:
    """Between which values locked motions are expected: those of the averaged equations, within the range."""
    assert found.range is not None
    low, high = found.range
    band = found.existing.band if found.existing is not None else None
    return (low, high) if band is None else (max(low, band.low.value), min(high, band.high.value))
