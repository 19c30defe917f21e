"""Maps of states and motions of the normal form of a generalised Hopf point, and in what order they are made."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import cache
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.dynamics.branches import state_map, state_rows
from wucht.dynamics.branches.modulated_motion import ReachedMotions
from wucht.dynamics.branches.plane_regions import COINCIDE, PlaneCurve, PlanePoint
from wucht.dynamics.branches.state_map import StateFindings, StateMapCase, extended_curves, map_states
from wucht.dynamics.branches.state_rows import OrbitRow, orbit_curve
from wucht.dynamics.work import Work
from wucht.errors import InputError, RunError
from wucht.numerics.periodic.cycle import BRANCH_POINT, FOLD
from wucht.system import System

X, Y, P, S, IDLE = sp.symbols("x y p s idle", real=True)
SQUARE = X**2 + Y**2
GROWTH = P + S * SQUARE - SQUARE**2
# r' = r (p + s r^2 - r^4), theta' = 1: a Hopf point at p = 0; orbits r^2 = s/2 +- sqrt(s^2/4 + p), which fold at p = -s^2/4.
FORM = System((X, Y), (X * GROWTH - Y, Y * GROWTH + X), (P, S))
EQUATIONS = wucht.UserSystem(FORM, {"p": 0.1, "s": 1.0})
RANGES = {"x": (-2.0, 2.0), "y": (-2.0, 2.0)}
PLANE = (-0.6, 0.5), (0.5, 1.3)


def case_of(plane: Any = PLANE, cells: int = 2) -> StateMapCase:
    return StateMapCase.of(EQUATIONS, ("p", "s"), plane, cells, ranges=RANGES)


@cache
def mapped() -> list[StateFindings]:
    return list(map_states(case_of(), Work()))


def test_a_row_of_motions_from_its_fold_to_where_it_begins() -> None:
    """Both rows, along the branch: it begins at the Hopf point, turns at -s^2/4, and leaves the range at 0.5."""
    last = mapped()[-1]
    low, high, _ = last.orbits
    assert (low.second, high.second) == pytest.approx((0.7, 1.1))
    for row in (low, high):
        s = row.second
        assert [side.kind for side in row.sides] == ["hopf", "range"]
        assert [side.value for side in row.sides] == pytest.approx([0.0, 0.5], abs=1e-9)
        (fold,) = row.special
        assert (fold.kind, fold.value) == (FOLD, pytest.approx(-(s**2) / 4, abs=1e-9))
        assert fold.period == pytest.approx(2 * np.pi, abs=1e-7)
        turn = int(row.values.argmin())
        assert (np.diff(row.values[: turn + 1]) <= 0).all() and (np.diff(row.values[turn:]) >= 0).all()
        assert row.values[turn] < -0.9 * s**2 / 4
        assert row.state_at(-0.2 * s**2) == 2, "beside the unstable part that begins at the Hopf point"
        assert row.state_at(0.3) == 2 and row.state_at(-0.26 * s**2) == 0 and row.state_at(0.51) == 0
        assert row.has_orbit(0.3, np.array([0, 0])) and not row.has_orbit(0.3, np.array([1, 0]))
        assert row.middle.value == pytest.approx(0.25) and row.middle.period == pytest.approx(2 * np.pi)
        radius = np.hypot(*row.middle.states.T)
        np.testing.assert_allclose(radius**2, s / 2 + np.sqrt(s**2 / 4 + 0.25), rtol=1e-6)


def test_the_curve_of_folds_of_motions() -> None:
    (curve,) = mapped()[-1].orbit_curves
    assert curve.kind == FOLD
    np.testing.assert_allclose(curve.x, -(curve.y**2) / 4, atol=1e-8)
    assert sorted(curve.y[[0, -1]]) == pytest.approx([0.5, 1.3])
    assert (np.diff(curve.y) > 0).all() or (np.diff(curve.y) < 0).all()


def test_what_runs_come_to_at_each_cell() -> None:
    """At p = 0.225 the motion; at -0.325 the state at rest, beyond the fold at -0.3025."""
    last = mapped()[-1]
    assert [(round(m.x, 9), round(m.y, 9)) for m in last.runs_by_place[:4]] == [
        (-0.325, 0.7),
        (0.225, 0.7),
        (-0.325, 1.1),
        (0.225, 1.1),
    ]
    for m in last.runs_by_place[:4]:
        assert (m.runs, len(m.orbits) if m.x < 0.0 else m.steady, m.unsettled_runs) == (6, 0, 0)
    for m in (m for m in last.runs_by_place if m.orbits):
        (orbit,) = m.orbits
        assert orbit.period == pytest.approx(2 * np.pi, rel=1e-7) and orbit.winding.tolist() == [0, 0]


def test_a_place_in_the_region_that_no_cell_lies_in() -> None:
    """Between the fold of motions and the Hopf points there is none; runs are begun in it, and a row."""
    last = mapped()[-1]
    (extra,) = last.extra
    assert -(extra[1] ** 2) / 4 < extra[0] < 0
    (both,) = last.runs_by_place[4:]
    assert (both.x, both.y, len(both.orbits), both.unsettled_runs) == (*extra, 1, 0) and 0 < both.steady < 6
    assert last.orbits[-1].second == extra[1]
    assert last.complete and last.omissions == () and len(last.rows) == 3


def test_stages_of_the_map() -> None:
    """Rows and their curves; runs, both rows; orbits from the middle on, each with its curves; the place that is left."""
    counts = [
        (len(f.rows), len(f.curves), len(f.runs_by_place), len(f.orbits), len(f.orbit_curves), len(f.extra), f.complete)
        for f in mapped()
    ]
    assert counts == [
        (1, 0, 0, 0, 0, 0, False), (1, 1, 0, 0, 0, 0, False), (2, 1, 0, 0, 0, 0, False), (2, 1, 2, 0, 0, 0, False),
        (2, 1, 4, 0, 0, 0, False), (2, 1, 4, 1, 0, 0, False), (2, 1, 4, 1, 1, 0, False), (2, 1, 4, 2, 1, 0, False),
        (3, 1, 4, 2, 1, 0, False), (3, 1, 5, 3, 1, 1, False), (3, 1, 5, 3, 1, 1, True),
    ]  # fmt: skip


def test_a_parameter_that_changes_nothing_is_refused() -> None:
    system = System(FORM.states, FORM.derivatives, (P, S, IDLE))
    equations = wucht.UserSystem(system, {"p": 0.1, "s": 1.0, "idle": 1.0})
    assert StateMapCase.of(equations, ("p", "idle"), PLANE, 2, ranges=RANGES).motion is not None
    motion = case_of().motion
    assert motion is not None
    with pytest.raises(InputError) as refused:
        motion.refuse_idle({"along": "p", "second": "idle"})
    assert (refused.value.location, refused.value.value) == ("study.second", "idle")


def test_a_motion_at_other_values() -> None:
    there = case_of().motion_at(0.9)
    assert (there.subject.values["s"], there.subject.values["p"], there.subject.path) == (0.9, 0.1, "p")
    row = case_of().orbits_at(0.9, lambda: None)
    assert (row.second, row.path, row.motion.subject.values["s"]) == (0.9, "s", 0.9)
    assert row.motion.subject.bounds == (-0.6, 0.5)


def test_a_special_orbit_whose_curve_cannot_be_followed_is_said() -> None:
    """A fold where the branch has none: it is not on it."""
    row = mapped()[-1].orbits[0]
    wrong = replace(row.special[0], value=-0.05)
    with pytest.raises(RunError, match="the special orbit could not be recomputed"):
        orbit_curve(case_of().motion_at(row.second), case_of().second(row.second), row, wrong)


# What follows is of findings as they might be.
NONE = "none"


def row_at(second: float, *special: tuple[str, float], sides: tuple[Any, ...] = (), winding: int = 0) -> OrbitRow:
    """Stable orbits of a winding between 0 and 1."""
    ends: Any = sides or tuple(SimpleNamespace(kind="range", value=v) for v in (0.0, 1.0))
    whole: Any = SimpleNamespace(winding=np.array([winding, 0]))
    of: Any = tuple(SimpleNamespace(kind=kind, value=value) for kind, value in special)
    return OrbitRow(second, ends, np.array([0.0, 1.0]), np.array([True, True]), of, whole, whole)


def bare(cells: int = 3, rows: Callable[..., Any] | None = None) -> Any:
    """A plane from 0 to 1 and 0 to 3, in which rows of motions are made by a function of the value and how they begin."""
    made: Any = replace(
        case_of(),
        bounds=((0.0, 1.0), (0.0, 3.0)),
        cells=cells,
        motion=SimpleNamespace(is_partial=False, with_values=lambda *_: "there"),
    )
    if rows is not None:

        def orbits_at(_: Any, second: float, watch: Any) -> Any:
            return SimpleNamespace(
                row=lambda near: rows(second, near), further_row=lambda near, given: rows(second, near, given)
            )

        return made, orbits_at
    return made


def finished(generator: Any) -> tuple[list[StateFindings], StateFindings]:
    stages = list[StateFindings]()
    while True:
        try:
            stages.append(next(generator))
        except StopIteration as stop:
            return stages, stop.value


def test_rows_of_motions_begin_in_the_middle_each_with_its_neighbour(monkeypatch: pytest.MonkeyPatch) -> None:
    asked = list[tuple[float, float | None]]()

    def row(second: float, near: Any) -> OrbitRow:
        asked.append((second, None if near is None else near.second))
        return row_at(second)

    case, orbits_at = bare(4, row)
    monkeypatch.setattr(StateMapCase, "orbits_at", orbits_at)
    names = list[tuple[float, str]]()
    stages, last = finished(
        state_map._orbits(case, StateFindings(), Work(reporter=lambda share, what: names.append((share, what))))
    )
    c = case.centres(1).tolist()
    assert asked == [(c[2], None), (c[3], c[2]), (c[1], c[2]), (c[0], c[1])]
    assert [[r.second for r in s.orbits] for s in stages] == [[c[2]], c[2:], c[1:], c] and last is stages[-1]
    assert [share for share, _ in names] == pytest.approx([0.5, 0.6, 0.7, 0.8])
    assert names[0][1] == "modulated motions at s = 1.875"


def curves_of(
    monkeypatch: pytest.MonkeyPatch, row: Any, known: tuple[PlaneCurve, ...], made: Any
) -> tuple[list[Any], StateFindings]:
    """What curves are asked for, with those that are known."""
    asked = list[Any]()

    def through(kind: str) -> Any:
        def make(there: Any, second: Any, row: Any, special: Any) -> Any:
            asked.append((kind, special.kind, special.value))
            return made

        return make

    monkeypatch.setattr(state_map, "orbit_curve", through("orbit"))
    monkeypatch.setattr(state_map, "connection_curve", through("connection"))
    _, last = finished(state_map._curves_of(bare(), StateFindings(orbit_curves=known), row, Work(), 0.6))
    return asked, last


def line(kind: str, x: float, low: float, high: float) -> PlaneCurve:
    return PlaneCurve(kind, np.array([x, x, x]), np.array([low, (low + high) / 2, high]))


ENDS = SimpleNamespace(kind="saddle-connection", value=0.1), SimpleNamespace(kind="range", value=1.0)


def test_curves_through_what_is_special_on_a_row_unless_they_are_known(monkeypatch: pytest.MonkeyPatch) -> None:
    """Known: a curve of the same kind within 0.01 of the range there. Else special orbits first, then saddle connections."""
    row = row_at(1.5, ("fold", 0.5), ("torus", 0.7), sides=ENDS)
    new = line("new", 0.0, 0.0, 3.0)
    asked, last = curves_of(monkeypatch, row, (), new)
    assert asked == [("orbit", "fold", 0.5), ("orbit", "torus", 0.7), ("connection", "saddle-connection", 0.1)]
    assert last.orbit_curves == (new, new, new)
    known = line("fold", 0.509, 0.0, 3.0), line("fold", 0.7, 0.0, 3.0), line("saddle-connection", 0.111, 0.0, 3.0)
    asked, _ = curves_of(monkeypatch, row, known, new)
    assert asked == [("orbit", "torus", 0.7), ("connection", "saddle-connection", 0.1)]
    assert curves_of(monkeypatch, NONE, known, new)[0] == []


def test_a_curve_of_lost_stability_that_ends_just_before_a_row_is_the_rows(monkeypatch: pytest.MonkeyPatch) -> None:
    """Within a tenth of the first range, and one and a half cells of the second one, but not at the row; not so a fold."""
    row, new = row_at(1.5, (BRANCH_POINT, 0.5)), line("new", 0.0, 0.0, 3.0)
    for x, end, count in ((0.55, 0.3, 0), (0.65, 0.3, 1), (0.55, -0.1, 1), (0.55, 1.5, 1)):
        known = PlaneCurve(BRANCH_POINT, np.full(3, x), np.array([end - 0.2, end - 0.1, end]))
        assert len(curves_of(monkeypatch, row, (known,), new)[0]) == count
    known = PlaneCurve("fold", np.full(3, 0.55), np.array([0.1, 0.2, 0.3]))
    assert len(curves_of(monkeypatch, row_at(1.5, ("fold", 0.5)), (known,), new)[0]) == 1


def test_a_curve_that_is_lost_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    _, last = curves_of(monkeypatch, row_at(1.5, ("period-doubling", 0.5)), (), "no start")
    assert last.orbit_curves == ()
    assert last.omissions == ("the period-doubling of the modulated motion at p = 0.5, s = 1.5 is not followed: no start",)


def reached(x: float, y: float, *windings: int) -> ReachedMotions:
    seeds: Any = tuple(SimpleNamespace(winding=np.array([w, 0]), origin=f"a run of {w}") for w in windings)
    return ReachedMotions(x, y, 6, 0, seeds, 0)


def further(monkeypatch: pytest.MonkeyPatch, findings: StateFindings, row: Any) -> tuple[list[Any], StateFindings]:
    case, orbits_at = bare(3, row)
    monkeypatch.setattr(StateMapCase, "orbits_at", orbits_at)
    monkeypatch.setattr(state_map, "_curves_of", lambda case, findings, *_: _nothing(findings))
    _, last = finished(state_map._further_orbits(case, findings, Work()))
    return last


def _nothing(findings: StateFindings) -> Any:
    return findings
    yield findings


def test_motions_that_runs_reach_and_no_row_has_are_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the winding with most of them, from the row that has most, both ways as long as there is one; then the others."""
    asked = list[Any]()

    def row(second: float, near: Any, given: Any) -> Any:
        asked.append((second, getattr(near, "second", None), [s.winding[0] for s in given]))
        winding = given[0].winding[0] if given else near.whole.winding[0]
        return NONE if (second, winding) == (2.5, 2) else row_at(second, winding=winding)

    at = (reached(0.2, 0.5, 1), reached(0.6, 1.5, 2), reached(0.4, 1.5, 1), reached(0.6, 1.5, 1), reached(0.2, 2.5, 0))
    last = further(monkeypatch, StateFindings(runs_by_place=at, orbits=(row_at(2.5, winding=0),)), row)
    one = [(1.5, None, [1, 1]), (2.5, 1.5, []), (0.5, 1.5, [1])]
    assert asked == [*one, (1.5, None, [2]), (2.5, 1.5, []), (0.5, 1.5, [])]
    assert last.omissions == () and [r.second for r in last.orbits] == [2.5, 1.5, 2.5, 0.5, 1.5, 0.5]


def test_where_bodies_keep_together_no_further_motions_are_followed(monkeypatch: pytest.MonkeyPatch) -> None:
    findings = StateFindings(runs_by_place=(reached(0.4, 1.5, 3),))
    together: Any = replace(bare(), motion=SimpleNamespace(is_partial=True))
    assert finished(state_map._further_orbits(together, findings, Work())) == ([], findings)


def test_a_motion_that_is_followed_nowhere_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    last = further(monkeypatch, StateFindings(runs_by_place=(reached(0.4, 1.5, 3),)), lambda *_: NONE)
    assert last.omissions == ("the modulated motion reached by runs, such as a run of 3, is not followed over the plane",)
    assert last.orbits == ()


def test_curves_of_lost_stability_go_on_through_rows_to_a_crossing() -> None:
    """Sorted; rows beyond both ends; then crossings within one and a half cells, where the curve ends inside the plane."""
    curve = PlaneCurve(BRANCH_POINT, np.array([0.6, 0.5, 0.4]), np.array([1.8, 1.5, 1.2]))
    fold = line("fold", 0.2, 0.0, 3.0)
    rows = tuple(
        row_at(y, (BRANCH_POINT, x), ("fold", 0.9)) for x, y in ((0.8, 2.5), (0.7, 2.1), (0.5, 1.5), (0.3, 0.5), (0.35, 0.8))
    )
    crossings = PlanePoint(COINCIDE, 0.85, 2.9), PlanePoint(COINCIDE, 0.1, 2.4), PlanePoint(COINCIDE, 0.15, 0.1)
    findings = StateFindings(orbits=rows, crossings=crossings, orbit_curves=(curve, fold))
    made, same = extended_curves(bare(), findings)
    assert same is fold
    assert made.x.tolist() == [0.15, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85]
    assert made.y.tolist() == [0.1, 0.5, 0.8, 1.2, 1.5, 1.8, 2.1, 2.5, 2.9]
    far = replace(findings, orbits=(), crossings=(PlanePoint(COINCIDE, 0.9, 3.4), PlanePoint(COINCIDE, 0.0, -0.4)))
    assert extended_curves(bare(), far)[0].y.tolist() == [1.2, 1.5, 1.8]
    at_edge = replace(curve, y=np.array([3.0, 1.5, 0.0]))
    to_edge = replace(far, orbit_curves=(at_edge,), crossings=(PlanePoint(COINCIDE, 0.9, 3.1),))
    assert extended_curves(bare(), to_edge)[0].y.tolist() == [0.0, 1.5, 3.0]


def test_what_only_rows_at_the_same_value_explain() -> None:
    """Runs that reach an orbit at 0.5, where there is no row; at 1.5, where its row ends before; at 2.5, where one has it."""
    at = (reached(0.2, 0.5, 1), reached(2.0, 1.5, 1), reached(0.2, 1.5, 2, 1), reached(0.2, 2.5, 1))
    rows = tuple(row_at(y, winding=1) for y in (1.5, 2.5))
    left = state_map._unexplained_orbits(StateFindings(runs_by_place=at, orbits=rows))
    assert [(y, orbit.winding[0]) for y, orbit in left] == [(0.5, 1), (1.5, 1), (1.5, 2)]


def test_a_place_in_each_region_that_has_none_with_the_nearest_row(monkeypatch: pytest.MonkeyPatch) -> None:
    """Below 0.2 and above 2.75 of the second parameter: steady states, a row begun with its neighbour, and runs there."""
    done = list[Any]()

    def steady(_: Any, findings: StateFindings, second: float, values: np.ndarray, *works: Work) -> Any:
        done.append(("steady", round(second, 2), len(values), *[w.name for w in works]))
        yield findings
        return findings

    def orbit_row(_: Any, work: Work, second: float, near: Any, *__: Any) -> str:
        done.append(("row", round(second, 2), near.second, work.name))
        return NONE

    def with_runs(
        _: Any, findings: StateFindings, work: Work, values: list[float], second: float, share: float
    ) -> StateFindings:
        done.append(("runs", len(values), round(second, 2), share, work.name))
        return findings

    monkeypatch.setattr(state_map, "_follow_row", steady)
    monkeypatch.setattr(state_map, "_orbit_row", orbit_row)
    monkeypatch.setattr(state_map, "_with_runs", with_runs)
    lines = tuple(PlaneCurve("fold", np.array([-1.0, 2.0]), np.array([y, y])) for y in (0.2, 2.75))
    findings = StateFindings(orbits=tuple(row_at(y) for y in (0.5, 1.5, 2.5)), orbit_curves=lines)
    _, last = finished(state_map._extra_places(bare(), findings, Work()))
    low, high = ((round(y, 2), k) for k, (_, y) in enumerate(last.extra))
    assert (low[0], high[0]) == (pytest.approx(0.1, abs=0.02), pytest.approx(2.87, abs=0.02))
    assert done == [
        step
        for (y, k), near in ((low, 0.5), (high, 2.5))
        for name in [f"place {k}/"]
        for step in (("steady", y, 1, name, name), ("row", y, near, name), ("runs", 1, y, 0.9, name))
    ]
    assert last.orbits == findings.orbits and last.omissions == ()


def test_runs_are_reported_between_curves_and_orbits(monkeypatch: pytest.MonkeyPatch) -> None:
    """From 0.3 to 0.5 of the work, row by row, each at the centres of all cells."""
    asked, reports = list[Any](), list[tuple[float, str]]()

    def reach(_: Any, values: list[float], second: float, watch: Any) -> tuple[Any, ...]:
        asked.append(([round(v, 3) for v in values], second))
        return (second,)

    monkeypatch.setattr(state_map, "reached_motions", reach)
    stages, last = finished(
        state_map._runs(bare(), StateFindings(), Work(reporter=lambda share, what: reports.append((share, what))))
    )
    assert last.runs_by_place == (0.5, 1.5, 2.5) and len(stages) == 3
    assert asked == [([0.167, 0.5, 0.833], y) for y in (0.5, 1.5, 2.5)]
    assert [share for share, _ in reports] == pytest.approx([0.3, 0.3 + 0.2 / 3, 0.3 + 0.4 / 3])
    assert reports[0][1] == "runs from several starts at s = 0.5"


def test_curves_of_orbits_are_those_of_all_equations(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where bodies keep together, too: so is the orbit from which they are begun, up to eight times the period."""
    asked = list[Any]()

    def through(subject: Any, seed: Any) -> None:
        asked.append((subject.system, subject.path, subject.bounds, seed.longest))
        raise RunError("enough")

    motion, row = case_of().motion_at(0.7), mapped()[-1].orbits[0]
    other = replace(
        motion.subject, system=System(FORM.states, (*FORM.derivatives[:1], FORM.derivatives[1] + P), FORM.parameters)
    )
    monkeypatch.setattr(state_rows, "cycles_through", through)
    for whole in (other, motion.subject):
        with pytest.raises(RunError, match="enough"):
            orbit_curve(replace(motion, whole=whole), case_of().second(0.7), row, row.special[0])
        assert asked.pop() == (whole.system, "p", PLANE[0], 8.0 * row.special[0].period)
