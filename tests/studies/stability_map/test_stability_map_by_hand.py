"""Findings of ``stability-map`` that are made by hand: what runs reach, ends on folds, places that differ."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp
import xarray as xr
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from tests.hand_made import drawn, five_functions, titled, warnings_of
from tests.refusals import refused
from wucht.studies.stability_map.map_parts import plane_shares
from wucht.studies.stability_map.spec import StabilityMap

from wucht.dynamics.branches.ending_curves import RETURNS
from wucht.dynamics.branches.ending_map import EndingFindings, EndingMapCase
from wucht.dynamics.branches.modulated_motion import ReachedMotions
from wucht.dynamics.branches.orbit_endings import OrbitEnd, OrbitEnding
from wucht.dynamics.branches.plane_regions import COINCIDE, DOUBLE, PlaneCurve, PlanePoint
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.dynamics.branches.state_map import StateFindings
from wucht.dynamics.branches.state_rows import OrbitRow, SteadyRow
from wucht.dynamics.branches.steady_states import Kind
from wucht.dynamics.work import Work
from wucht.files.user_system import UserSystem
from wucht.numerics.periodic.branch_ends import RANGE, SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.studies.stability_map import figure as map_figure
from wucht.system import System

STUDY = five_functions("stability-map")
X, P, R, S = sp.symbols("x p r s", real=True)
OWN = UserSystem(System((X,), (P + R * X - X**3 + S,), (P, R, S)), {"p": 0.0, "r": 1.0, "s": 0.0}, "a cusp")
ASKED: dict[str, Any] = {
    "along": "p", "range": [-2.0, 2.0], "second": "r", "second_range": [-1.0, 3.0], "cells": 2, "ranges": {"x": [-2.0, 2.0]},
}  # fmt: skip
NONE: Any = None


def plan(**asked: Any) -> Any:
    return STUDY.prepare(StabilityMap(**ASKED | {"orbits": False} | asked), OWN)


def rows(*names: tuple[str, ...]) -> tuple[SteadyRow, ...]:
    """Of two by two places, at r = 0 and 2, p = -1 and 1: what is stable there."""
    return SteadyRow(0.0, names[:2]), SteadyRow(2.0, names[2:])


def of(made: Any, **findings: Any) -> xr.Dataset:
    same = rows(("a",), ("a",), ("a",), ("a",))
    return titled(STUDY.dataset(made, StateFindings(**{"rows": same, "complete": True} | findings)), dimensionless=True)


def labels(result: xr.Dataset) -> list[str]:
    """Of the places, row by row."""
    return [str(v) for v in result.place_label.values]


def orbits(second: float, kind: str, low: float, high: float, stable: bool = True) -> OrbitRow:
    sides = OrbitEnd(kind, low, ""), OrbitEnd(RANGE, high, "")
    return OrbitRow(second, sides, np.array([low, high]), np.array([stable, stable]), (), NONE, NONE)


def fold(x: float = 0.0, **other: Any) -> BifurcationCurve:
    """Upright, at a value of p."""
    u = np.stack([np.zeros(41), np.full(41, x), np.linspace(-1.0, 3.0, 41)])
    made = BifurcationCurve("fold", Kind(), u, ("",) * 41, ({},) * 41, ("the range ends",) * 2)
    return replace(made, **other)


# --- places ---


def test_places_have_the_names_that_are_not_stable_everywhere() -> None:
    result = of(plan(), rows=rows(("a", "b"), ("a",), ("a",), ("a", "c", "b")))
    assert labels(result) == ["b", "no other steady state", "no other steady state", "b, c"]
    assert result.wucht.summary["everywhere"] == ["a"]
    assert list(zip(result.place_x.values, result.place_y.values, strict=True)) == [(-1, 0), (1, 0), (-1, 2), (1, 2)]
    assert result.wucht.summary["sentence"].startswith("stable everywhere: a; in addition not-decided in ")
    assert result.wucht.summary["sentence"].endswith("; periodic orbits were not searched for")


def test_runs_tell_of_motions_that_no_branch_has() -> None:
    reached = (
        ReachedMotions(-1.0, 0.0, 6, 6, (), 0), ReachedMotions(1.0, 0.0, 6, 5, (NONE,), 0),
        ReachedMotions(-1.0, 2.0, 6, 4, (), 2), ReachedMotions(1.0, 2.0, 5, 0, (), 0),
    )  # fmt: skip
    result = of(plan(), rows=rows(("a",), ("a",), (), ()), runs_by_place=reached)
    assert labels(result) == [
        "a", "a, periodic orbit stable",
        "a motion that is neither steady nor periodic, an unidentified steady state", "no other steady state",
    ]  # fmt: skip
    assert result.wucht.summary["runs"] == 23


def test_modulated_motions_of_the_rows() -> None:
    some = (orbits(0.0, RANGE, -2.0, 0.5), orbits(2.0, RANGE, 0.5, 2.0, stable=False), orbits(2.0, RANGE, 0.75, 1.5))
    result = of(plan(), orbits=some)
    assert labels(result) == [
        "periodic orbit stable",
        "no other steady state",
        "no other steady state",
        "periodic orbit stable",
    ]
    less = of(plan(), orbits=some[:2])
    assert labels(less)[3] == "periodic orbit unstable"
    assert set(result.wucht.summary["boundaries"]) == set()


def test_an_extra_place_has_a_row_of_its_own() -> None:
    extra = (*rows(("a",), ("a",), ("a",), ("a",)), SteadyRow(1.5, (("a", "b"),)))
    result = of(plan(), rows=extra, extra=((0.25, 1.5),))
    assert labels(result)[4] == "b" and (float(result.place_x[4]), float(result.place_y[4])) == (0.25, 1.5)


# --- parts of folds on which modulated motions end ---


ON_FOLD = "periodic orbit: saddle-node on it"


def on_folds(result: xr.Dataset) -> list[tuple[float, float, float]]:
    """Of each part p, and r from and to."""
    parts = [np.array(line) for name, line in result.wucht.summary["boundaries"].items() if name.startswith(ON_FOLD)]
    return [(float(p[0, 0]), float(p[0, 1]), float(p[-1, 1])) for p in parts]


@pytest.mark.parametrize(
    ("kind", "value", "expected"),
    [
        (SADDLE_NODE_ON_ORBIT, 0.0, [(0.0, -1.0, 1.0)]),
        ("not-identified", 3.9e-4, [(0.0, -1.0, 1.0)]),
        (SADDLE_NODE_ON_ORBIT, 4.1e-4, []),
        (SADDLE_CONNECTION, 0.0, []),
    ],
)
def test_the_part_of_a_fold_that_lies_on_a_modulated_motion(kind: str, value: float, expected: list[Any]) -> None:
    """Half a row beyond the outermost row whose motion ends there."""
    result = of(plan(), curves=(fold(),), orbits=(orbits(0.0, kind, value, 2.0),))
    assert on_folds(result) == expected
    aside = of(plan(), curves=(fold(0.5),), orbits=(orbits(0.0, kind, 0.5 + value, 2.0),))
    assert on_folds(aside) == [(0.5, low, high) for _, low, high in expected]
    assert ("fold: steady states" in result.wucht.summary["boundaries"]) is True
    both = of(plan(), curves=(fold(),), orbits=(orbits(0.0, kind, value, 2.0), orbits(2.0, kind, value, 2.0)))
    assert on_folds(both) == [(p, low, 3.0) for p, low, _ in expected]


def test_that_part_begins_at_a_crossing_of_folds_below_it() -> None:
    given = {"curves": (fold(),), "orbits": (orbits(2.0, SADDLE_NODE_ON_ORBIT, 0.0, 2.0),)}
    assert on_folds(of(plan(), **given)) == [(0.0, 1.0, 3.0)]
    crossings = tuple(PlanePoint(COINCIDE, 0.0, y) for y in (0.5, 1.5, 2.5))
    result = of(plan(), **given, crossings=crossings)
    assert on_folds(result) == [(0.0, 1.5, 3.0)]
    assert [(p["kind"], p["p"], p["r"]) for p in result.wucht.summary["points"]] == [
        (str(result.mark_kind.values[0]), 0.0, y) for y in (0.5, 1.5, 2.5)
    ]


def test_hopf_curves_and_other_folds_are_no_such_parts() -> None:
    rows_ = (orbits(2.0, SADDLE_NODE_ON_ORBIT, 0.0, 2.0),)
    assert on_folds(of(plan(), curves=(fold(bifurcation="hopf"), fold(1.0)), orbits=rows_)) == []


# --- the Dataset and the report ---


def test_places_that_say_otherwise_than_their_region() -> None:
    different = rows(("a", "b"), ("a", "b"), ("a", "b"), ("a",))
    result = of(plan(), rows=different)
    warning, _ = warnings_of(result)
    assert warning == (
        "no boundary separates 1 of 4 places from others that differ, such as p = 1, r = 2: no other steady state; "
        "what lies between them is not-decided"
    )
    assert warnings_of(of(plan(), rows=different, complete=False)) == ["4 places are examined; the map is not finished"]
    assert result.wucht.summary["against"] == 1
    assert STUDY.report(result)[-1] == "  checked      3 of 4 separately examined places agree with the boundaries"
    runs = of(plan(), rows=different, runs_by_place=(ReachedMotions(-1.0, 0.0, 6, 6, (), 0),))
    assert STUDY.report(runs)[-1].startswith("  checked      3 of 4 separately examined places, by 6 runs from several")


def test_what_is_lost_is_listed_in_part() -> None:
    lost = tuple(f"lost {k}" for k in range(6))
    assert warnings_of(of(plan(), omissions=lost))[:-1] == [*lost[:4], "and 2 more"]
    assert warnings_of(of(plan(), omissions=lost[:4]))[:-1] == list(lost[:4])


def test_before_the_first_place() -> None:
    result = of(plan(), rows=(), complete=False)
    assert result.wucht.summary["sentence"] == "the study was interrupted before the first place"
    assert warnings_of(result) == ["0 places are examined; the map is not finished"]


def test_a_small_region_is_drawn_without_its_name() -> None:
    half = rows(("a", "b"), ("a",), ("a", "b"), ("a",))
    for at, names in ((0.0, {"b", "no other steady state"}), (1.95, {"b"})):
        places = replace(STUDY_FINDINGS, rows=half if at == 0.0 else rows(("a", "b"), ("a", "b"), ("a", "b"), ("a", "b")))
        extra = () if at == 0.0 else ((1.98, 1.0),)
        more = () if at == 0.0 else (SteadyRow(1.0, (("a",),)),)
        found = replace(places, rows=(*places.rows, *more), extra=extra, curves=(fold(at),))
        axis = drawn("stability-map", titled(STUDY.dataset(plan(), found), dimensionless=True)).axes[0]
        assert {" ".join(t.get_text().split()) for t in axis.texts} == names


STUDY_FINDINGS = StateFindings(complete=True)


# --- how modulated motions end ---


def endings(kinds: list[str], *curves: PlaneCurve, **other: Any) -> tuple[Any, xr.Dataset]:
    """Over p from -2 to 2 and r from -1 to 3, with s from 0 to 1; the case looks at nothing."""
    asked = {"orbits": True, "eliminate": "s", "eliminate_range": [0.0, 1.0]}
    cases: list[Any] = []

    def case(subject: Any, plane: Any, cells: int, settings: Any, orbit_settings: Any) -> Any:
        cases.append((subject, plane, cells))
        return SimpleNamespace(warnings=("doubtful",), plane=plane, cells=cells, centres=[])

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(EndingMapCase, "of", case)
        made = plan(**asked)
    ((subject, plane, cells),) = cases
    assert subject is OWN and cells == 2
    assert (plane.paths, plane.bounds) == (("s", "p", "r"), ((0.0, 1.0), (-2.0, 2.0), (-1.0, 3.0)))
    at = [(x, y) for y in (0.0, 2.0) for x in (-1.0, 1.0)]
    places = tuple(OrbitEnding(x, y, 0.25, OrbitEnd(kind, 0.75, "")) for (x, y), kind in zip(at, kinds, strict=True))
    found = EndingFindings(**{"places": places, "curves": curves, "complete": False} | other)
    return made, titled(STUDY.dataset(made, found), dimensionless=True)


LINE = PlaneCurve(RETURNS, np.zeros(41), np.linspace(-1.0, 3.0, 41), np.linspace(0.25, 0.5, 41))


def test_how_modulated_motions_end() -> None:
    kinds = [SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION] * 2
    point = PlanePoint(DOUBLE, 0.123456789, 1.5, 0.375)
    _, result = endings(kinds, LINE, points=(point, replace(point, y=2.5)))
    s = result.wucht.summary
    assert s["sentence"] == (
        "the periodic orbit, as s changes: ends at a saddle-node on the orbit in 50 %, ends at a saddle connection in 50 % "
        "of the plane; the regions meet at p = 0.1234568, r = 1.5 and at p = 0.1234568, r = 2.5"
    )
    assert (s["eliminate"], s["eliminate_unit"], s["eliminate_range"]) == ("s", "", [0.0, 1.0])
    assert [p["s"] for p in s["points"]] == result.mark_value.values.tolist() == [0.375, 0.375]
    assert set(result.mark_label.values.tolist()) == {"connection of two saddle-nodes"}
    assert list(s["boundary_values"].values()) == [pytest.approx(LINE.value.tolist())]
    assert warnings_of(result) == ["doubtful", "4 places are examined; the map is not finished"]
    assert STUDY.report(result)[2:5] == [
        "  saddle-node on the orbit | saddle connection: p from 0 to 0, r from -1 to 3",
        "  two saddle nodes connected: p = 0.1234568, r = 1.5, s = 0.375",
        "  two saddle nodes connected: p = 0.1234568, r = 2.5, s = 0.375",
    ]
    assert (result.place_begins.values == 0.25).all() and (result.place_ends.values == 0.75).all()


def test_a_curve_with_the_same_on_both_sides_is_no_boundary() -> None:
    _, result = endings([RANGE] * 4, LINE)
    assert result.wucht.summary["boundaries"] == {}
    assert (
        result.wucht.summary["sentence"]
        == "the periodic orbit, as s changes: lasts to the end of the range in 100 % of the plane"
    )


def test_its_run_is_that_of_the_case(monkeypatch: pytest.MonkeyPatch) -> None:
    made, _ = endings([RANGE] * 4)
    work = Work()
    monkeypatch.setattr("wucht.studies.stability_map.computation.map_endings", lambda case, w: [(case, w)])
    assert list(STUDY.run(made, work)) == [(made.case, work)]


def test_the_third_parameter_is_one_of_the_equations() -> None:
    with refused("study.eliminate", given="t", code="unknown-parameter"):
        plan(orbits=True, eliminate="t", eliminate_range=[0.0, 1.0])
    with refused("study.eliminate_range", given=[1.0, 0.0]):
        plan(orbits=True, eliminate="s", eliminate_range=[1.0, 0.0])


def test_marks_and_places_stand_at_their_values_of_both_parameters() -> None:
    """The first along the abscissa; each label one kind of mark."""
    values = {
        "mark_x": [1.0, 2.0, 3.0], "mark_y": [10.0, 20.0, 30.0], "mark_label": ["cusp", "other", "cusp"], "place_x": [5.0],
        "place_y": [50.0],
    }  # fmt: skip
    given: Any = SimpleNamespace(**{name: SimpleNamespace(values=np.array(v)) for name, v in values.items()})
    handles = map_figure._marks(Figure().subplots(), given)
    assert [(h.get_label(), [*h.get_xdata()], [*h.get_ydata()]) for h in handles] == [
        ("cusp", [1.0, 3.0], [10.0, 30.0]), ("other", [2.0], [20.0]), ("examined places", [5.0], [50.0])
    ]  # fmt: skip
    assert handles[0].get_marker() != handles[1].get_marker()


def test_the_name_of_a_region_stands_far_from_its_edges() -> None:
    """A fold at p = 1 over all r: left of it three units wide and four high, the name is 1.5 from each edge."""
    half = rows(("a", "b"), ("a",), ("a", "b"), ("a",))
    result = titled(STUDY.dataset(plan(), replace(STUDY_FINDINGS, rows=half, curves=(fold(1.0),))), dimensionless=True)
    x, y = result.region_x.values, result.region_y.values
    assert len(x) == 2 and x == pytest.approx([-0.5, 1.5], abs=0.02)
    assert (np.minimum(y + 1.0, 3.0 - y) > [1.45, 0.45]).all()


# --- what is stated and drawn where ---


def legend_of(figure: Figure) -> dict[str, Any]:
    legend = figure.axes[0].get_legend()
    return {" ".join(t.get_text().split()): h for t, h in zip(legend.get_texts(), legend.legend_handles, strict=True)}


def at(result: xr.Dataset, p: float, r: float) -> int:
    """The number of the region at a place."""
    return int(result.region.sel({"x": p, "y": r}, method="nearest"))


def test_shares_of_a_label_are_those_of_all_its_regions() -> None:
    areas: Any = SimpleNamespace(index=np.array([[0, 0, 1], [0, 2, 2]]), count=3)
    shares = plane_shares(areas, ("a", "b", "a"))
    assert {label: share for label, (share, _) in shares.items()} == {"a": pytest.approx(5 / 6), "b": pytest.approx(1 / 6)}
    two_sides = 2 * np.sqrt(2 / 12) / 6  # a stretch of one cell below, and one beside it
    assert [off for _, off in shares.values()] == pytest.approx([two_sides, two_sides])


def test_the_regions_of_a_map_of_states() -> None:
    """Left of p = 0.5, five eighths of the plane, b is stable too, and a modulated motion at its lower places."""
    half = rows(("a", "b"), ("a",), ("a", "b"), ("a",))
    result = titled(STUDY.dataset(plan(), replace(STUDY_FINDINGS, rows=half, curves=(fold(0.5),))), dimensionless=True)
    left, right = at(result, -1.5, 0.0), at(result, 1.5, 2.0)
    assert [str(result.region_label[k].values) for k in (left, right)] == ["b", "no other steady state"]
    assert [int(result.region_hatch[k]) for k in (left, right)] == [1, 0]
    assert [int(result.region_tone[k]) for k in (left, right)] == [0, 0]
    shares = {region["label"]: region["share"] for region in result.wucht.summary["regions"]}
    assert shares == {"b": pytest.approx(0.625, abs=0.01), "no other steady state": pytest.approx(0.375, abs=0.01)}
    assert result.wucht.summary["sentence"].startswith("stable everywhere: a; in addition b in 6")
    report = STUDY.report(result)
    assert report[2] == "  fold: steady states: p from 0.5 to 0.5, r from -1 to 3"
    assert {line[:10] for line in report[3:5]} == {f"  {100 * share:6.2f} ±" for share in shares.values()}
    assert (result.boundary_x.values == 0.5).all() and result.boundary_y.values[[0, -1]].tolist() == [-1.0, 3.0]
    motion = (orbits(0.0, RANGE, -2.0, 0.5, stable=False), orbits(2.0, RANGE, -2.0, 0.5, stable=False))
    moved = STUDY.dataset(plan(), replace(STUDY_FINDINGS, rows=half, curves=(fold(0.5),), orbits=motion))
    assert [int(moved.region_tone[at(moved, p, 0.0)]) for p in (-1.5, 1.5)] == [1, 0]


def test_sets_of_states_have_hatches_of_their_number() -> None:
    three = rows(("a", "c"), ("a", "b"), ("a", "c"), ("a",))
    result = STUDY.dataset(plan(), replace(STUDY_FINDINGS, rows=three, curves=(fold(0.0), across(1.0))))
    assert [int(result.region_hatch[at(result, p, r)]) for p, r in ((1, 0), (-1, 0), (-1, 2), (1, 2))] == [1, 2, 2, 0]


def across(r: float) -> BifurcationCurve:
    u = np.stack([np.zeros(41), np.linspace(-2.0, 2.0, 41), np.full(41, r)])
    return fold(unknowns=u, bifurcation="hopf", kinds=("",) * 20 + ("zero-hopf",) + ("",) * 20)


def test_curves_have_names_of_their_kinds_and_marks_at_their_second_conditions() -> None:
    """Of the coordinates of a curve's points the last two are p and r."""
    named = fold(0.5, kind=Kind("together"))
    result = of(plan(), curves=(named, across(1.0), fold(-0.5, kind=Kind("together"))))
    names = ["fold: together", "hopf: steady states", "fold: together (2)"]
    assert list(result.wucht.summary["boundaries"]) == result.boundary_name.values.tolist() == names
    assert result.boundary_group.values.tolist() == ["fold: together", "hopf: steady states", "fold: together"]
    ends = [[float(v[result.boundary.values == k][i]) for v in (result.boundary_x, result.boundary_y) for i in (0, -1)]
            for k in range(3)]  # fmt: skip
    assert ends == [[0.5, 0.5, -1.0, 3.0], [-2.0, 2.0, 1.0, 1.0], [-0.5, -0.5, -1.0, 3.0]]
    (point,) = result.wucht.summary["points"]
    assert (point["kind"], point["values"], point["p"], point["r"]) == ("zero-hopf", [0.0, 1.0], 0.0, 1.0)
    assert result.mark_label.values.tolist() == ["zero hopf"]
    assert (result.mark_x.values.tolist(), result.mark_y.values.tolist()) == ([0.0], [1.0])
    assert STUDY.report(result)[5] == "  zero hopf: p = 0, r = 1"
    axis = drawn("stability-map", result).axes[0]
    lines = [np.c_[line.get_data()] for line in axis.lines]
    assert [line[[0, -1]].tolist() for line in lines[:3]] == [
        [[0.5, -1.0], [0.5, 3.0]], [[-0.5, -1.0], [-0.5, 3.0]], [[-2.0, 1.0], [2.0, 1.0]],
    ]  # fmt: skip
    assert axis.lines[0].get_linestyle() == axis.lines[1].get_linestyle() != axis.lines[2].get_linestyle()
    assert (axis.get_xlim(), axis.get_ylim()) == ((-2.0, 2.0), (-1.0, 3.0))
    assert (axis.get_xlabel(), axis.get_ylabel()) == ("p", "r")


def test_the_regions_of_a_map_of_endings_have_tones_of_their_endings() -> None:
    """Left of p = 0 a saddle-node, right of it a saddle connection, which alone is hatched."""
    _, result = endings([SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION] * 2, LINE)
    left, right = at(result, -1.0, 1.0), at(result, 1.0, 1.0)
    assert [int(result.region_tone[k]) for k in (left, right)] == [2, 1]
    assert [int(result.region_hatch[k]) for k in (left, right)] == [0, 1]
    assert str(result.region_label[left].values) == "ends at a saddle-node on the orbit"
    assert result.boundary_value.values.tolist() == LINE.value.tolist()
    fig = drawn("stability-map", result)
    handles = legend_of(fig)
    names = ["ends at a saddle-node on the orbit", "ends at a saddle connection"]
    assert [to_hex(handles[name].get_facecolor()) for name in names] == ["#8fb8d6", "#f3d9c0"]
    assert [handles[name].get_hatch() for name in names] == ["", "///"]
    assert list(handles)[:2] == names, "the darkest first"
    (first, one), (second, other) = ((t.get_text(), t.get_position()[0]) for t in fig.axes[0].texts)
    assert "node" in first and "connection" in second and one < 0 < other


def test_a_curve_is_a_boundary_where_most_of_it_has_different_sides() -> None:
    """Up to r = 1.5 there is nothing on either side; above, both sides differ: 15 points of 41 are less than half."""
    lower = PlaneCurve(RETURNS, np.linspace(-2.0, 2.0, 41), np.full(41, 1.5), np.full(41, 0.5))
    kinds = [RANGE, RANGE, SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION]
    _, result = endings(kinds, LINE, lower)
    names = {"saddle-node on the orbit | end of the range", "saddle connection | end of the range"}
    assert len(result.wucht.summary["boundaries"]) == 1
    assert set(result.wucht.summary["boundaries"]) < names


def test_of_a_map_of_nothing_special_the_legend_says_what_is_stable_everywhere() -> None:
    legend = drawn("stability-map", of(plan())).axes[0].get_legend()
    assert legend.get_title().get_text() == "besides a:"
    none = drawn("stability-map", of(plan(), rows=rows((), (), (), ()))).axes[0].get_legend()
    assert none.get_title().get_text() == ""


def test_a_map_has_by_default_twelve_rows_of_states() -> None:
    made = STUDY.prepare(StabilityMap(**{**ASKED, "cells": None, "orbits": False}), OWN)
    assert made.case.cells == 12
