"""Spec and machine -> case -> findings: locked motions, and runs from the start over a parameter."""

from __future__ import annotations

from bisect import insort
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain

import numpy as np

from wucht.dynamics.entrainment.entrainment_case import EntrainmentCase, check_entrainable, swept_parameter
from wucht.dynamics.entrainment.existence import Existence, existence, range_around, threshold
from wucht.dynamics.entrainment.locked_motions import LockedMotion, LockedMotions
from wucht.dynamics.entrainment.runs_from_start import (
    CaptureBand,
    RunFromStart,
    RunsFromStart,
    capture_band,
    senses_of,
    values_to_run,
)
from wucht.dynamics.parameters import range_of
from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.schema import Unit, article, read_quantity
from wucht.studies.entrainment.spec import Entrainment


def prepare(spec: Entrainment, machine: Machine) -> EntrainmentCase:
    """Return the case. Raises ``InputError`` where the study does not fit the machine."""
    check_entrainable(machine)
    parameter = swept_parameter(machine, spec.along)
    unit = Unit(parameter.unit, parameter.description)
    range_ = None if spec.range is None else range_of(unit, spec.range)
    resolution = None if spec.resolution is None else read_quantity(unit, spec.resolution, "study.resolution")
    if resolution is not None and resolution <= 0:
        raise InputError("study.resolution", spec.resolution, f"must be {article(unit.long_name)} greater than 0")
    return EntrainmentCase.of(machine, parameter, spec.start, spec.points, range_, resolution, spec.until)


_RESOLUTION = 1e-5  # of the range
_BISECTIONS = 70  # expected, for the progress
_MOTIONS = 8  # to each side of the seed
_TOO_SHORT = 1.5  # ratio of required to actual duration beyond which a run is repeated

Stage = Generator["Findings", None, "Findings"]  # yields more and more complete findings, and returns the last


@dataclass(frozen=True)
class Findings:
    """Findings so far. nominal_run: at the nominal value of the parameter. range, resolution: of the parameter.

    existing: bands of the averaged equations. runs: from the start, in increasing order of their value; band: reached by them.
    motions: locked ones, likewise in order; ends: where they end below and above, None where beyond the range; no_motion:
    reason why there are none. threshold: the least amplitude of the vibration. complete: true if all work is done.
    """

    nominal_run: RunFromStart | None = None
    range: tuple[float, float] | None = None
    resolution: float = 0.0
    existing: Existence = field(default_factory=Existence)
    runs: tuple[RunFromStart, ...] = ()
    band: CaptureBand | None = None
    motions: tuple[LockedMotion, ...] = ()
    ends: tuple[float | None, float | None] = (None, None)
    no_motion: str | None = None
    threshold: float | None = None
    complete: bool = False

    @property
    def failure(self) -> str | None:
        """Reason why the nominal run failed, after which no search follows."""
        return self.nominal_run.failure if self.nominal_run is not None else None

    @property
    def nominal_motion(self) -> LockedMotion | None:
        """Locked motion at the nominal value, if its run is entrained."""
        nominal_value = self.nominal_run.value if self.nominal_run is not None and self.nominal_run.is_entrained else None
        return next((m for m in self.motions if m.value == nominal_value), None)


def run(case: EntrainmentCase, work: Work) -> Iterator[Findings]:
    """Search for the bands, and yield the findings after each run and each locked motion."""
    yield (findings := Findings())
    runs = RunsFromStart(case)
    nominal_run = _run(runs, case.parameter.nominal_value, work.part("own", 0.0, 0.03))
    yield (findings := replace(findings, nominal_run=nominal_run))
    if nominal_run.failure is not None:
        return
    senses = senses_of(case.machine, case.initial, nominal_run)
    try:
        existing = existence(case, nominal_run, senses, work.part("existence", 0.03, 0.1))
    except InputError as error:
        existing = Existence(warnings=(f"the averaged equations are left out: {error.explanation}",))
    low, high = case.range or range_around(case, existing.band)
    resolution = case.resolution or _RESOLUTION * (high - low)
    runs = RunsFromStart(case, senses, existing.slowest_rate)
    if runs.duration > _TOO_SHORT * nominal_run.end_time:
        nominal_run = _run(runs, case.parameter.nominal_value, work.part("own, longer", 0.1, 0.1))
    yield (findings := Findings(nominal_run, (low, high), resolution, existing))
    findings = yield from _search_band(case, runs, findings, nominal_run, work.part("runs", 0.1, 0.8))
    findings = yield from _follow_motions(case, senses, findings, work)
    least = threshold(case, existing, work.part("threshold", 0.95, 1.0))
    work.report(1.0)
    yield replace(findings, threshold=least, complete=True)


def _run(runs: RunsFromStart, value: float, work: Work, share: float = 0.0) -> RunFromStart:
    """Make a run from the start. share: of this part of the work, for the progress."""
    label = f"{runs.case.parameter.name} = {value:.6g}"
    return work.unit(f"at {value!r} for {runs.duration!r}", lambda: runs(value, lambda _: work.report(share, label)))


def _search_band(
    case: EntrainmentCase, runs: RunsFromStart, findings: Findings, nominal_run: RunFromStart, work: Work
) -> Stage:
    """Make runs evenly over the range and at the nominal value, then those that the search for the edges needs."""
    done, points = list[RunFromStart](), case.points
    scan = dict.fromkeys([*np.linspace(*(findings.range or case.limits), points).tolist(), nominal_run.value])
    for k, value in enumerate(chain(scan, values_to_run(done, nominal_run.value, findings.resolution))):
        new_run = nominal_run if value == nominal_run.value else _run(runs, value, work, k / (points + _BISECTIONS))
        insort(done, new_run, key=lambda r: r.value)
        yield (findings := replace(findings, runs=tuple(done)))
    return replace(findings, band=capture_band(done, nominal_run.value))


def _follow_motions(case: EntrainmentCase, senses: Mapping[str, float], findings: Findings, work: Work) -> Stage:
    """Follow locked motions from the nominal value on, or from the entrained run nearest to it."""
    nearest = min(
        (r for r in findings.runs if r.is_entrained), key=lambda r: abs(r.value - case.parameter.nominal_value), default=None
    )
    if nearest is None:
        return findings
    motion_solver = LockedMotions(case, senses, nearest.end_time)
    seed = work.unit("locked motion", partial(_seed, motion_solver, nearest))
    if isinstance(seed, str):
        return replace(findings, no_motion=f"at {case.parameter.name} = {nearest.value:.6g}: {seed}")
    yield (findings := replace(findings, motions=(seed,)))
    low, high = edges = findings.range or case.limits
    if (band := findings.existing.band) is not None:
        edges = max(low, band.low.value), min(high, band.high.value)
    for side, (limit, edge) in enumerate(zip((low, high), edges, strict=True)):
        inside = np.linspace(seed.value, edge, _MOTIONS + 1)[1:-1].tolist()
        goals = [v for v in (*inside, limit) if v != seed.value]
        earlier_motions, part = findings.motions, work.part("locked motion", (0.8, 0.875)[side], (0.875, 0.95)[side])
        for motions, end in motion_solver.follow(seed, goals, findings.resolution, part):
            ends = (end, None) if side == 0 else (findings.ends[0], end)
            findings = replace(findings, ends=ends, motions=tuple(sorted([*earlier_motions, *motions], key=lambda m: m.value)))
            yield findings
    return findings


def _seed(motion_solver: LockedMotions, nearest: RunFromStart) -> LockedMotion | str:
    """Return the locked motion at the end of a run, or the reason why there is none."""
    try:
        return motion_solver.motion(nearest.value, nearest.end_state, abs(nearest.mean_speed))
    except WuchtError as error:
        return str(error)
