"""Labelled maps of planes whose states, runs and curves are known: names of places, ends on folds, places that differ."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import sympy as sp

import wucht
from wucht.dynamics.branches.ending_curves import RETURNS
from wucht.dynamics.branches.ending_map import EndingFindings
from wucht.dynamics.branches.ending_map_case import EndingMapCase
from wucht.dynamics.branches.labelled_maps import LabelledMap, map_of_endings, map_of_states
from wucht.dynamics.branches.modulated_motion import ReachedMotions
from wucht.dynamics.branches.orbit_endings import OrbitEnd, OrbitEnding
from wucht.dynamics.branches.plane_regions import PlaneCurve
from wucht.dynamics.branches.second_parameter import BifurcationCurve
from wucht.dynamics.branches.state_map import StateFindings, StateMapCase
from wucht.dynamics.branches.state_rows import ExaminedPlace, OrbitRow
from wucht.dynamics.branches.steady_states import Kind, Labels
from wucht.numerics.periodic.branch_ends import RANGE, SADDLE_CONNECTION, SADDLE_NODE_ON_ORBIT
from wucht.system import System

X, P, R = sp.symbols("x p r", real=True)
OWN = wucht.UserSystem(System((X,), (P + R * X - X**3,), (P, R)), {"p": 0.0, "r": 1.0}, "a cusp")
STUDY = wucht.StabilityMap(
    along="p", range=[-2.0, 2.0], second="r", second_range=[-1.0, 3.0], cells=2, ranges={"x": [-2.0, 2.0]}, orbits=False
)
NONE: Any = None
ON_FOLD = "periodic orbit: saddle-node on it"


def rows(*names: tuple[str, ...]) -> tuple[tuple[ExaminedPlace, ...], ...]:
    """Of two by two places, at r = 0 and 2, p = -1 and 1: what is stable there."""
    pairs = zip((0.0, 2.0), (names[:2], names[2:]), strict=True)
    return tuple(tuple(ExaminedPlace(x, y, of) for x, of in zip((-1.0, 1.0), pair, strict=True)) for y, pair in pairs)


HALF = rows(("a", "b"), ("a",), ("a", "b"), ("a",))


def states(**findings: Any) -> LabelledMap:
    _, case = STUDY.prepare(OWN)
    assert isinstance(case, StateMapCase)
    same = rows(("a",), ("a",), ("a",), ("a",))
    return map_of_states(case, StateFindings(**{"rows": same, "complete": True} | findings))


def labels(made: LabelledMap) -> list[str]:
    """Of the places, row by row."""
    return [place.label for place in made.places]


def orbits(second: float, kind: str, low: float, high: float, stable: bool = True) -> OrbitRow:
    sides = OrbitEnd(kind, low, ""), OrbitEnd(RANGE, high, "")
    return OrbitRow(second, sides, np.array([low, high]), np.array([stable, stable]), (), NONE, NONE)


def fold(x: float = 0.0, **other: Any) -> BifurcationCurve:
    """Upright, at a value of p."""
    unknowns = np.stack([np.zeros(41), np.full(41, x), np.linspace(-1.0, 3.0, 41)])
    made = BifurcationCurve("fold", Kind(), unknowns, ("",) * 41, ({},) * 41, ("the range ends",) * 2)
    return replace(made, **other)


# --- places ---


def test_runs_tell_of_motions_that_no_branch_has() -> None:
    reached = (
        ReachedMotions(-1.0, 0.0, 6, 6, (), 0), ReachedMotions(1.0, 0.0, 6, 5, (NONE,), 0),
        ReachedMotions(-1.0, 2.0, 6, 4, (), 2), ReachedMotions(1.0, 2.0, 5, 0, (), 0),
    )  # fmt: skip
    made = states(rows=rows(("a",), ("a",), (), ()), runs_by_place=reached)
    assert labels(made) == [
        "a", "a, periodic orbit stable",
        "a motion that is neither steady nor periodic, an unidentified steady state", "no other steady state",
    ]  # fmt: skip
    assert made.runs == 23


def test_modulated_motions_of_the_rows() -> None:
    some = (orbits(0.0, RANGE, -2.0, 0.5), orbits(2.0, RANGE, 0.5, 2.0, stable=False), orbits(2.0, RANGE, 0.75, 1.5))
    made = states(orbits=some)
    none = "no other steady state"
    assert labels(made) == ["periodic orbit stable", none, none, "periodic orbit stable"]
    assert labels(states(orbits=some[:2]))[3] == "periodic orbit unstable"
    assert not made.lines


# --- parts of folds on which modulated motions end ---


def on_folds(made: LabelledMap) -> list[tuple[float, float, float]]:
    """Of each part p, and r from and to."""
    lines = [line for name, line in made.lines.items() if name.startswith(ON_FOLD)]
    return [(float(line.x[0]), float(line.y[0]), float(line.y[-1])) for line in lines]


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
    made = states(curves=(fold(),), orbits=(orbits(0.0, kind, value, 2.0),))
    assert on_folds(made) == expected
    assert "fold: steady states" in made.lines
    aside = states(curves=(fold(0.5),), orbits=(orbits(0.0, kind, 0.5 + value, 2.0),))
    assert on_folds(aside) == [(0.5, low, high) for _, low, high in expected]
    both = states(curves=(fold(),), orbits=(orbits(0.0, kind, value, 2.0), orbits(2.0, kind, value, 2.0)))
    assert on_folds(both) == [(p, low, 3.0) for p, low, _ in expected]


# --- regions ---


def test_the_regions_of_a_map_of_states() -> None:
    """Left of p = 0.5, five eighths of the plane, b is stable too, and a modulated motion at its lower places."""
    made = states(rows=HALF, curves=(fold(0.5),))
    left, right = made.areas.region_at(-1.5, 0.0), made.areas.region_at(1.5, 2.0)
    assert [made.labels[k] for k in (left, right)] == ["b", "no other steady state"]
    assert [made.hatches[k] for k in (left, right)] == [1, 0] and [made.tones[k] for k in (left, right)] == [0, 0]
    shares = {label: of_plane for label, (of_plane, _) in made.shares.items()}
    assert shares == {"b": pytest.approx(0.625, abs=0.01), "no other steady state": pytest.approx(0.375, abs=0.01)}
    motion = (orbits(0.0, RANGE, -2.0, 0.5, stable=False), orbits(2.0, RANGE, -2.0, 0.5, stable=False))
    moved = states(rows=HALF, curves=(fold(0.5),), orbits=motion)
    assert [moved.tones[moved.areas.region_at(p, 0.0)] for p in (-1.5, 1.5)] == [1, 0]


# --- how modulated motions end ---

PLANE: Any = ("s", "p", "r"), ((0.0, 1.0), (-2.0, 2.0), (-1.0, 3.0))
LINE = PlaneCurve(RETURNS, np.zeros(41), np.linspace(-1.0, 3.0, 41), np.linspace(0.25, 0.5, 41))
SIDES = (SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION) * 2  # left of the line, right of it


def endings(kinds: tuple[str, ...], *curves: PlaneCurve, **other: Any) -> LabelledMap:
    """Of two by two places."""
    at = [(x, y) for y in (0.0, 2.0) for x in (-1.0, 1.0)]
    places = tuple(OrbitEnding(x, y, 0.25, OrbitEnd(kind, 0.75, "")) for (x, y), kind in zip(at, kinds, strict=True))
    findings = EndingFindings(**{"places": places, "curves": curves, "complete": True} | other)
    return map_of_endings(EndingMapCase(*PLANE, NONE, 2, Labels("state x", "", "x", of_equations=True)), findings)


def test_a_curve_is_a_boundary_where_most_of_it_has_different_sides() -> None:
    """Up to r = 1.5 there is nothing on either side; above, both sides differ: 15 points of 41 are less than half."""
    lower = PlaneCurve(RETURNS, np.linspace(-2.0, 2.0, 41), np.full(41, 1.5), np.full(41, 0.5))
    made = endings((RANGE, RANGE, SADDLE_NODE_ON_ORBIT, SADDLE_CONNECTION), LINE, lower)
    names = {"saddle-node on the orbit | end of the range", "saddle connection | end of the range"}
    assert len(made.lines) == 1 and set(made.lines) < names


def test_where_no_curve_was_found_between_places_that_differ_it_is_said() -> None:
    """Of both pairs side by side, once all was looked at."""
    (sentence,) = endings(SIDES).omissions
    assert sentence.startswith("between 2 pairs of neighbouring places that differ no curve was found, such as p = -1, r = ")
    assert "(ends at a saddle-node on the orbit) and 1, " in sentence
    assert endings(SIDES, complete=False).omissions == ()
