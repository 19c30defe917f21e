"""A map of states and motions of the normal form of a generalised Hopf point."""

from __future__ import annotations

from dataclasses import replace
from functools import cache
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.dynamics.branches.plane_regions import COINCIDE, PlaneCurve, PlanePoint
from wucht.dynamics.branches.state_map import StateFindings, StateMapCase, extended_curves, map_states
from wucht.dynamics.work import Work
from wucht.errors import InputError
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


def test_a_parameter_that_changes_nothing_is_refused() -> None:
    system = System(FORM.states, FORM.derivatives, (P, S, IDLE))
    equations = wucht.UserSystem(system, {"p": 0.1, "s": 1.0, "idle": 1.0})
    assert StateMapCase.of(equations, ("p", "idle"), PLANE, 2, ranges=RANGES).motion is not None
    motion = case_of().motion
    assert motion is not None
    with pytest.raises(InputError) as refused:
        motion.refuse_idle({"along": "p", "second": "idle"})
    assert (refused.value.location, refused.value.value) == ("study.second", "idle")


def test_curves_of_lost_stability_go_on_through_rows_to_a_crossing() -> None:
    """Sorted; rows beyond both ends; then crossings within one and a half cells, where the curve ends inside the plane."""
    plane = replace(case_of(), bounds=((0.0, 1.0), (0.0, 3.0)), cells=3)
    curve = PlaneCurve(BRANCH_POINT, np.array([0.6, 0.5, 0.4]), np.array([1.8, 1.5, 1.2]))
    fold = PlaneCurve(FOLD, np.full(2, 0.2), np.array([0.0, 3.0]))
    known = mapped()[-1].orbits[0]
    rows = tuple(
        replace(
            known,
            second=y,
            special=tuple(replace(known.special[0], kind=k, value=v) for k, v in ((BRANCH_POINT, x), (FOLD, 0.9))),
        )
        for x, y in ((0.8, 2.5), (0.7, 2.1), (0.5, 1.5), (0.3, 0.5), (0.35, 0.8))
    )
    crossings = PlanePoint(COINCIDE, 0.85, 2.9), PlanePoint(COINCIDE, 0.1, 2.4), PlanePoint(COINCIDE, 0.15, 0.1)
    findings = StateFindings(orbits=rows, crossings=crossings, orbit_curves=(curve, fold))
    made, same = extended_curves(plane, findings)
    assert same is fold
    assert made.x.tolist() == [0.15, 0.3, 0.35, 0.4, 0.5, 0.6, 0.7, 0.8, 0.85]
    assert made.y.tolist() == [0.1, 0.5, 0.8, 1.2, 1.5, 1.8, 2.1, 2.5, 2.9]
    far = replace(findings, orbits=(), crossings=(PlanePoint(COINCIDE, 0.9, 3.4), PlanePoint(COINCIDE, 0.0, -0.4)))
    assert extended_curves(plane, far)[0].y.tolist() == [1.2, 1.5, 1.8]
