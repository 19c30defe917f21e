"""Map of steady states and modulated motions: rows of branches, the curves through their special points, and crossings."""

from __future__ import annotations

from collections import Counter
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from itertools import chain

import numpy as np

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, follow_branches
from wucht.dynamics.branches.first_orbits import SeedOrbit
from wucht.dynamics.branches.modulated_motion import ModulatedMotion, ReachedMotions, reached_motions
from wucht.dynamics.branches.plane_regions import (
    Bounds,
    PlaneCurve,
    PlanePoint,
    Range,
    cell_centres,
    cell_size,
    divide_plane,
    widest_difference,
)
from wucht.dynamics.branches.second_parameter import (
    BifurcationCurve,
    SecondParameter,
    curve_starts,
    curve_through,
    fold_crossings,
    lies_on_curve,
)  # fmt: skip
from wucht.dynamics.branches.state_rows import (
    STABLE,
    ExaminedPlace,
    OrbitRow,
    RowCase,
    connection_curve,
    orbit_curve,
    steady_row,
)  # fmt: skip
from wucht.dynamics.branches.steady_states import Heartbeat, Labels
from wucht.dynamics.work import Work, result_or_reason, with_result
from wucht.machines.subject import Subject
from wucht.numerics.periodic.branch_ends import SADDLE_CONNECTION
from wucht.numerics.periodic.cycle import BRANCH_POINT

_ROWS, _CURVES, _RUNS, _ORBITS = 0.2, 0.3, 0.5, 0.9  # shares of the work at which these are done
_MOST_FAMILIES = 4  # of modulated motions reached by runs
_ON_CURVE = 0.01  # of the range: a special orbit that lies on a known curve
_MOST_EXTRA, _MOST_BETWEEN = 12, 24  # places beside the centres of the cells: in small regions, and between places that differ
UNIDENTIFIED_STATE = "an unidentified steady state"
UNSETTLED_MOTION = "a motion that is neither steady nor periodic"


@dataclass(frozen=True, eq=False)
class StateMapCase:
    """Plane of two parameters, whose steady states and modulated motions are mapped.

    paths, bounds: of the parameters. cells: per side, at whose centres the motions are examined. points, only, ranges, inertia:
    of the steady states, see ``BranchCase.of``. motion: None where modulated ones are left out. labels: of the states.
    """

    subject: Subject
    paths: tuple[str, str]
    bounds: Bounds
    cells: int
    points: int
    only: tuple[str, ...] | None
    ranges: Mapping[str, Range] | None
    inertia: bool | None
    motion: ModulatedMotion | None
    labels: Labels

    @classmethod
    def of(
        cls, subject: Subject, paths: tuple[str, str], bounds: Bounds, cells: int, points: int = 5,
        only: tuple[str, ...] | None = None, ranges: Mapping[str, Range] | None = None, inertia: bool | None = None,
        orbits: bool = True, together: bool = False,
    ) -> StateMapCase:  # fmt: skip
        """Set up the plane of a machine, or of user equations. orbits: False to leave out modulated motions; together: in which
        equal balancing bodies keep equal phases.

        Raises ``InputError`` where one of these does not fit the subject, or it has no averaged equations.
        """
        middle, motion = subject.with_values({paths[1]: sum(bounds[1]) / 2}), None
        steady_states = BranchCase.of(middle, paths[0], bounds[0], points, only, ranges=ranges, inertia=inertia).steady_states
        if orbits:
            motion = ModulatedMotion.of(subject, paths[0], bounds[0], steady_states, together, ranges, inertia)
            motion.refuse_idle(dict(zip(("along", "second"), paths, strict=True)))
        return cls(subject, paths, bounds, cells, points, only, ranges, inertia, motion, steady_states.labels)

    def row(self, second: float) -> BranchCase:
        """Return the steady states over the first parameter at a value of the second."""
        subject = self.subject.with_values({self.paths[1]: second})
        bounds = self.bounds[0]
        return BranchCase.of(subject, self.paths[0], bounds, self.points, self.only, ranges=self.ranges, inertia=self.inertia)

    def centres(self, k: int) -> np.ndarray:
        """Return the centres of the cells, in the first (0) or the second (1) parameter."""
        return cell_centres(self.bounds[k], self.cells)

    def motion_at(self, second: float) -> ModulatedMotion:
        """Return the modulated motions at a value of the second parameter."""
        assert self.motion is not None
        return self.motion.with_values({self.paths[1]: second})

    def orbits_at(self, second: float, report: Heartbeat) -> RowCase:
        """Return the row of modulated motions at a value of the second parameter."""
        return RowCase(self.motion_at(second), self.paths[1], second, report)

    def second(self, value: float) -> SecondParameter:
        """Return the second parameter at a value."""
        return SecondParameter(self.paths[1], self.bounds[1], value)


@dataclass(frozen=True)
class StateFindings:
    """Results so far. rows: places with their steady states. crossings: of fold curves. orbits: rows of modulated motions, one
    for each motion. runs_by_place: motions reached by runs. omissions: sentences on what is missing."""

    rows: tuple[tuple[ExaminedPlace, ...], ...] = ()
    curves: tuple[BifurcationCurve, ...] = ()
    crossings: tuple[PlanePoint, ...] = ()
    orbits: tuple[OrbitRow, ...] = ()
    runs_by_place: tuple[ReachedMotions, ...] = ()
    orbit_curves: tuple[PlaneCurve, ...] = ()
    extra: tuple[tuple[float, float], ...] = ()
    omissions: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False


def examined_places(case: StateMapCase, findings: StateFindings) -> list[ExaminedPlace]:
    """Return each place with its stable motions: those of the branches, and those reached by runs from several starts."""
    runs_by_place, places = {(r.x, r.y): r for r in findings.runs_by_place}, list[ExaminedPlace]()
    # The rows of the cells come first; each further row has one place, which is examined once it is in ``extra``.
    for place in chain.from_iterable(findings.rows[: case.cells + len(findings.extra)]):
        names, level = list(place.names), max((r.state_at(place.x) for r in findings.orbits if r.second == place.y), default=0)
        if (runs := runs_by_place.get((place.x, place.y))) is not None:
            level = STABLE if runs.orbits else level
            names += [UNIDENTIFIED_STATE] if runs.steady and not place.names else []
            names += [UNSETTLED_MOTION] if runs.unsettled_runs else []
        places.append(replace(place, names=tuple(names), level=level))
    return places


Stage = Generator[StateFindings, None, StateFindings]


def map_states(case: StateMapCase, work: Work) -> Iterator[StateFindings]:
    """Compute rows of steady states, the curves of their folds and Hopf points, rows of orbits, and their curves."""
    findings = StateFindings()
    seconds = case.centres(1).tolist()
    for k, second in enumerate(seconds):
        part = work.part(f"row {second!r}", _ROWS * k / len(seconds), _ROWS * (k + 1) / len(seconds))
        findings = yield from _follow_row(case, findings, second, case.centres(0), part, work)
    middle = sum(case.bounds[1]) / 2
    crossings = work.unit(
        "crossings", lambda: fold_crossings(case.row(middle).steady_states, case.second(middle), findings.curves)
    )
    for crossing in crossings:
        findings = with_result(findings, "crossings", crossing)
    if case.motion is not None:
        findings = yield from _runs(case, findings, work)
        findings = yield from _orbits(case, findings, work)
        findings = yield from _further_orbits(case, findings, work)
    findings = yield from _extra_places(case, findings, work)
    findings = yield from _places_between(case, findings, work)
    work.report(1.0)
    yield replace(findings, complete=True)


def _follow_row(
    case: StateMapCase, findings: StateFindings, second: float, values: np.ndarray, part: Work, work: Work
) -> Stage:
    """Follow a row of steady states, and the curves through their folds and Hopf points that are not known yet."""
    row = case.row(second)
    *_, steady = follow_branches(row, part)
    findings = with_result(findings, "rows", steady_row(second, steady.branches, values))
    yield findings
    steady_states, second_parameter = row.steady_states, case.second(second)
    for k, (bifurcation, kind, unknowns) in enumerate(curve_starts(steady.branches)):
        if any(lies_on_curve(steady_states, second_parameter, c, bifurcation, unknowns) for c in findings.curves):
            continue
        part.report(0.5, f"{bifurcation}s in both parameters")
        curve = work.unit(
            f"curve {second!r} {k}",
            partial(result_or_reason, curve_through, steady_states, second_parameter, bifurcation, kind, unknowns),
        )
        at = f"the {bifurcation} at {case.paths[0]} = {unknowns[-1]:.6g}, {case.paths[1]} = {second:.6g}"
        findings = with_result(findings, "curves", curve, f"{at} is not followed: ")
        yield findings
    return findings


def _runs(case: StateMapCase, findings: StateFindings, work: Work) -> Stage:
    """Run from several starts at the centres of all cells."""
    seconds = case.centres(1).tolist()
    for k, second in enumerate(seconds):
        share = _CURVES + (_RUNS - _CURVES) * k / len(seconds)
        findings = _with_runs(case, findings, work, case.centres(0).tolist(), second, share)
        yield findings
    return findings


def _with_runs(
    case: StateMapCase, findings: StateFindings, work: Work, values: list[float], second: float, share: float
) -> StateFindings:
    """Add the motions that runs reach at values of the first parameter."""
    report = partial(work.report, share, f"runs from several starts at {case.paths[1]} = {second:.4g}")
    report()
    make = partial(reached_motions, case.motion_at(second), values, second, report)
    return replace(findings, runs_by_place=(*findings.runs_by_place, *work.unit(f"runs {second!r}", make)))


def _further_orbits(case: StateMapCase, findings: StateFindings, work: Work) -> Stage:
    """Follow over the plane the orbits on which runs have settled and which begin at no lost steady state.

    Each family begins in the row that has most of its orbits, and is followed from row to row both ways.
    """
    assert case.motion is not None
    seconds = case.centres(1).tolist()
    given_up = set[tuple[int, ...]]()
    for family in range(_MOST_FAMILIES if not case.motion.is_partial else 0):
        seeds = [at for at in _unexplained_orbits(findings) if tuple(at[1].winding.tolist()) not in given_up]
        if not seeds:
            break
        winding = Counter(tuple(seed.winding.tolist()) for _, seed in seeds).most_common(1)[0][0]
        family_seeds = [(second, seed) for second, seed in seeds if tuple(seed.winding.tolist()) == winding]
        begin = seconds.index(Counter(second for second, _ in family_seeds).most_common(1)[0][0])
        orbit_rows = dict[int, OrbitRow | str]()
        for k in [*range(begin, len(seconds)), *range(begin - 1, -1, -1)]:
            beside, row_seeds = (
                orbit_rows.get(k - 1 if k > begin else k + 1),
                [seed for second, seed in family_seeds if second == seconds[k]],
            )
            if not row_seeds and not isinstance(beside, OrbitRow):
                continue
            report = partial(work.report, _ORBITS, f"further modulated motions at {case.paths[1]} = {seconds[k]:.4g}")
            report()
            make = partial(case.orbits_at(seconds[k], report).further_row, beside, tuple(row_seeds))
            orbit_rows[k] = work.unit(f"orbits {seconds[k]!r} {family}", make)
            findings = _with_row(findings, orbit_rows[k])
            yield findings
            findings = yield from _curves_of(case, findings, orbit_rows[k], work, _ORBITS)
        left = [at for at in _unexplained_orbits(findings) if tuple(at[1].winding.tolist()) == winding]
        if not any(isinstance(row, OrbitRow) for row in orbit_rows.values()):
            sentence = (
                f"the modulated motion reached by runs, such as {family_seeds[0][1].origin}, is not followed over the plane"
            )
            findings = with_result(findings, "orbits", sentence)
        if len(left) == len(family_seeds):
            given_up.add(winding)
    return findings


def _unexplained_orbits(findings: StateFindings) -> list[tuple[float, SeedOrbit]]:
    """Return the orbits that runs have reached and no row has, with the values of the second parameter."""
    return [
        (place.y, orbit)
        for place in findings.runs_by_place
        for orbit in place.orbits
        if not any(r.second == place.y and r.has_orbit(place.x, orbit.winding) for r in findings.orbits)
    ]


def _orbits(case: StateMapCase, findings: StateFindings, work: Work) -> Stage:
    """Follow rows of orbits, from the middle outwards, each started from its neighbour; and their curves."""
    seconds = case.centres(1).tolist()
    middle = len(seconds) // 2
    order = [*range(middle, len(seconds)), *range(middle - 1, -1, -1)]
    orbit_rows = dict[int, OrbitRow | str]()
    for done, k in enumerate(order):
        share = _RUNS + (_ORBITS - _RUNS) * done / len(order)
        label = f"modulated motions at {case.paths[1]} = {seconds[k]:.4g}"
        work.report(share, label)
        beside = orbit_rows.get(k - 1 if k > middle else k + 1)
        orbit_rows[k] = _orbit_row(case, work, seconds[k], beside, share, label)
        rows_in_order = [orbit_rows[i] for i in sorted(orbit_rows)]
        findings = replace(findings, orbits=tuple(row for row in rows_in_order if isinstance(row, OrbitRow)))
        yield findings
        findings = yield from _curves_of(case, findings, orbit_rows[k], work, share)
    return findings


def _orbit_row(
    case: StateMapCase, work: Work, second: float, near: OrbitRow | str | None, share: float, label: str
) -> OrbitRow | str:
    row = case.orbits_at(second, partial(work.report, share, label))
    return work.unit(f"orbits {second!r}", partial(row.row, near))


def _with_row(findings: StateFindings, row: OrbitRow | str) -> StateFindings:
    """Add a row of modulated motions, if there is one."""
    return findings if isinstance(row, str) else with_result(findings, "orbits", row)


def _curves_of(case: StateMapCase, findings: StateFindings, row: OrbitRow | str, work: Work, share: float) -> Stage:
    """Follow the curves through the special points of a row of orbits."""
    if isinstance(row, str):
        return findings
    there, second = case.motion_at(row.second), case.second(row.second)
    width, spacing = (high - low for low, high in case.bounds)
    beside = 0.1 * width, 1.5 * spacing / case.cells
    curve_makers = [(k.kind, k.value, partial(result_or_reason, orbit_curve, there, second, row, k)) for k in row.special]
    curve_makers += [
        (SADDLE_CONNECTION, s.value, partial(result_or_reason, connection_curve, there, second, row, s))
        for s in row.sides if s.kind == SADDLE_CONNECTION
    ]  # fmt: skip
    for kind, value, make in curve_makers:
        alike = [c for c in findings.orbit_curves if c.kind == kind]
        if kind == BRANCH_POINT and any(c.ends_before(value, row.second, beside) for c in alike):
            continue
        if any(c.passes(value, row.second, _ON_CURVE * width) for c in alike):
            continue
        work.report(share, f"the curve of the {kind.replace('-', ' ')}s of modulated motions")
        curve = work.unit(f"{kind} {value!r} {row.second!r}", make)
        at = f"at {case.paths[0]} = {value:.6g}, {case.paths[1]} = {row.second:.6g}"
        missing = f"the {kind} of the modulated motion {at} is not followed: "
        findings = with_result(findings, "orbit_curves", curve, missing)
        yield findings
    return findings


def lines_of(case: StateMapCase, findings: StateFindings) -> list[tuple[np.ndarray, np.ndarray]]:
    """Return all curves as x and y."""
    return [(c.unknowns[-2], c.unknowns[-1]) for c in findings.curves] + [(c.x, c.y) for c in extended_curves(case, findings)]


def extended_curves(case: StateMapCase, findings: StateFindings) -> list[PlaneCurve]:
    """Return the curves of orbits; those of a loss of stability are extended through the rows to a crossing of folds.

    Near such a crossing the period is so long that the curve's equations cannot be followed; the rows' exponents are known.
    """
    curves, spacing = list[PlaneCurve](), (case.bounds[1][1] - case.bounds[1][0]) / case.cells
    for c in findings.orbit_curves:
        if c.kind != BRANCH_POINT:
            curves.append(c)
            continue
        order = np.argsort(c.y)
        x, y = c.x[order], c.y[order]
        beyond = [(k.value, r.second) for r in findings.orbits for k in r.special if k.kind == c.kind]
        for sign in (-1, 1):
            end = 0 if sign < 0 else -1
            more = sorted((sign * b, a, b) for a, b in beyond if sign * (b - y[end]) > 0)
            line = [(a, b) for _, a, b in more]
            last = line[-1] if line else (x[end], y[end])
            inside = case.bounds[1][0] < y[end] < case.bounds[1][1]
            line += [(p.x, p.y) for p in findings.crossings if inside and 0 < sign * (p.y - last[1]) < 1.5 * spacing]
            for a, b in line:
                x, y = (np.append(x, a), np.append(y, b)) if sign > 0 else (np.insert(x, 0, a), np.insert(y, 0, b))
        curves.append(replace(c, x=x, y=y))
    return curves


def _extra_places(case: StateMapCase, findings: StateFindings, work: Work) -> Stage:
    """Examine a place in each region without a cell's centre; where that reveals further curves, repeat."""
    cells = [(x, y) for y in case.centres(1).tolist() for x in case.centres(0).tolist()]
    while len(findings.extra) < _MOST_EXTRA:
        partition = divide_plane(lines_of(case, findings), case.bounds)
        sampled_regions = {partition.region_at(x, y) for x, y in (*cells, *findings.extra)}
        missing = next((k for k in range(partition.count) if k not in sampled_regions), None)
        if missing is None:
            break
        findings = yield from _examine(case, findings, partition.innermost_point(missing), "in a small region", work)
    return findings


def _places_between(case: StateMapCase, findings: StateFindings, work: Work) -> Stage:
    """Examine places between those that differ although no curve separates them."""
    for _ in range(_MOST_BETWEEN):
        partition = divide_plane(lines_of(case, findings), case.bounds)
        keys = [(p.x, p.y, p.key()) for p in examined_places(case, findings)]
        between = widest_difference(partition, keys, cell_size(case.bounds, case.cells))
        if between is None:
            break
        findings = yield from _examine(case, findings, between, "between places that differ", work)
    return findings


def _examine(case: StateMapCase, findings: StateFindings, place: tuple[float, float], location: str, work: Work) -> Stage:
    """Examine a further place, with a row of its own."""
    x, y = place
    part = work.part(f"place {len(findings.extra)}", _ORBITS, 1.0)
    findings = yield from _follow_row(case, findings, y, np.array([x]), part, part)
    if case.motion is not None:
        near = min(findings.orbits, key=lambda r: abs(r.second - y), default=None)
        row = _orbit_row(case, part, y, near, _ORBITS, f"modulated motions {location}")
        findings = _with_runs(case, _with_row(findings, row), part, [x], y, _ORBITS)
    findings = with_result(findings, "extra", (x, y))
    yield findings
    return findings
