"""Attractors made by hand: how near a motion must come to itself, and which members stay on it."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht.dynamics.sampling import attractors as module
from wucht.dynamics.sampling.attractors import Attractor, _motion, _starts, _with_candidate
from wucht.dynamics.sampling.member_quantities import MemberQuantities
from wucht.files.building import machine_from

PHI, SPEED = sp.symbols("phi speed", real=True)
SYSTEM: Any = SimpleNamespace(states=(PHI, SPEED), angles={PHI})
NONE: Any = None
QUANTITIES = MemberQuantities(SYSTEM, NONE, NONE, 0, (0, 1))


def circle(count: int, turns: float = 2.0, growth: float = 0.0) -> np.ndarray:
    """Points (P, 2) on a circle of the radii 3 and 0.5, run through twice."""
    at = np.arange(count) * 2 * math.pi * turns / count
    return np.stack([3 * np.cos(at), 0.5 * (1 + growth * at) * np.sin(at)], axis=1)


def test_an_angle_is_embedded_by_its_cosine_and_sine() -> None:
    samples = np.array([[[0.5, 2.0], [10.0, 20.0]]])  # K = 1, two states, two members
    points = QUANTITIES.points(samples)
    assert points.shape == (1, 2, 3)
    assert points[0, 1] == pytest.approx([math.cos(2.0), math.sin(2.0), 20.0])


def test_a_motion_that_comes_back_is_an_attractor() -> None:
    """Its points are shares of its sizes; the reach is twice the gap between neighbours of the two rounds."""
    made = Attractor.of(circle(401), 4, 1, (8.0, 12.0), 0.5, 0.25)
    assert made is not None
    assert (made.outcome, made.sense, made.low, made.high, made.period, made.peak_distance_squared) == (
        4,
        1,
        8.0,
        12.0,
        0.5,
        0.25,
    )
    assert made.sizes == pytest.approx([3.0, 0.5], rel=1e-3) and np.abs(made.points).max(axis=0).tolist() == [1.0, 1.0]
    apart = 2 * math.pi * 2 / 401
    assert made.reach == pytest.approx(2 * apart / 2, rel=0.02), "the rounds are shifted by half a step"
    dense = Attractor.of(circle(15_000), 4, 1, (8.0, 12.0), 0.5, 0.25)
    assert dense is not None and dense.reach == 1e-3, "the least one"
    assert made.member_points[5, 0] == pytest.approx(circle(401)[5])


def test_a_motion_that_does_not_come_back_is_none() -> None:
    """The second round is away by 7 %, or by 3 %, of the size."""
    numbers = (4, 1, (8.0, 12.0), 0.5, 0.25)
    assert Attractor.of(circle(401, growth=0.02), *numbers) is None
    assert Attractor.of(circle(401, growth=0.002), *numbers) is not None
    half = circle(401, turns=1.0)
    assert Attractor.of(half, *numbers) is None, "the halves of a round are not near each other"


def attractor(sense: int = 1, period: float = 2.0) -> Attractor:
    points = np.array([[math.cos(a), math.sin(a), 10.0 + math.sin(a)] for a in np.linspace(0, 2 * math.pi, 500)])
    sizes = np.array([1.0, 1.0, 11.0])
    return Attractor(1, points / sizes, sizes, 0.02, sense, 9.0, 11.0, period, 1.0)


@pytest.mark.parametrize("sense", [1, -1])
def test_members_that_stay_near_it_and_move_along_it(sense: int) -> None:
    """Near its points, within its speeds and a tenth of their range, through nine tenths of it, half in less than a period."""
    phase = np.linspace(0.0, 2 * math.pi, 61)
    on, off = np.stack([phase, 10.0 + np.sin(phase)]), np.stack([phase, 10.5 + np.sin(phase)])
    samples = np.stack([on, on, on, on, off, on, on], axis=-1).transpose(1, 0, 2)
    speeds = sense * np.array([[9.0, 8.85, 9.0, 9.2, 9.0, 8.81, 9.9], [11.0, 11.0, 11.15, 11.01, 11.0, 11.19, 10.0]])
    everyone = np.arange(7)
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 2.0, everyone).tolist() == [0, 1, 2, 3, 5]
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 2.0, np.array([5, 4, 2])).tolist() == [
        5,
        2,
    ]
    speeds[:, 1], speeds[:, 2] = sense * np.array([8.79, 11.0]), sense * np.array([9.0, 11.21])
    speeds[:, 3] = sense * np.array([9.3, 11.0])
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 2.0, everyone).tolist() == [0, 5]
    assert attractor(sense).resident_members(QUANTITIES.points, samples, speeds, 1.9, everyone).tolist() == [0, 3, 5]


def test_near_in_all_of_its_states() -> None:
    at = np.array([[[1.0, 0.0, 10.0], [1.0, 0.0, 10.0]], [[0.0, 1.0, 11.0], [0.0, 1.0, 11.4]]])
    assert attractor().is_near(at).tolist() == [True, False]


def test_the_same_modulation_is_one_attractor_with_the_points_of_both() -> None:
    one = attractor()
    again = replace(
        one,
        points=one.points[:40] * 1.5,
        reach=3 * one.reach,
        low=one.low - 1e-3,
        peak_distance_squared=one.peak_distance_squared + 1.0,
    )
    (merged,) = _with_candidate([one], again)
    assert (merged.reach, merged.low, merged.high, merged.peak_distance_squared) == (
        again.reach,
        again.low,
        one.high,
        again.peak_distance_squared,
    )
    assert merged.is_near(one.member_points).all() and merged.is_near(again.member_points).all()
    everything = np.concatenate([one.points, again.points])
    distances = np.linalg.norm(everything[:, None] - merged.points, axis=-1).min(axis=1)
    assert 200 < len(merged.points) < len(everything), "of points that are near to each other one is kept"
    assert 0 < distances.max() <= math.sqrt(3) * merged.reach / 16


def far(one: Attractor) -> Attractor:
    """Points elsewhere."""
    return replace(one, points=one.points + 5.0)


@pytest.mark.parametrize("share", [0.9, 1.1])
def test_how_much_modulations_may_differ_to_be_the_same(share: float) -> None:
    """By 1 % of the period, and of the range of the speed."""
    one = attractor()
    width, is_same = one.high - one.low, share < 1
    for changes in ({"period": one.period * (1 + 0.01 * share)}, {"low": one.low - 0.01 * share * width}):
        candidate = replace(far(one), **changes)
        assert one.has_modulation_of(candidate) == is_same
        assert len(_with_candidate([one], candidate)) == (1 if is_same else 2)
    for changes in ({"sense": -one.sense}, {"outcome": one.outcome + 1}):
        assert len(_with_candidate([one], replace(far(one), **changes))) == 2
    steady = replace(one, period=0.0)
    assert len(_with_candidate([steady], far(steady))) == 2
    assert len(_with_candidate([steady], replace(steady, peak_distance_squared=9.0))) == 1, "it is near in all of its points"


def test_starts_are_spread_evenly_about_the_rotor() -> None:
    rotor = {"kind": "rotor", "name": "d", "mass": 1.0, "unbalance": 1e-3, "inertia": 1e-2}
    ball = {"kind": "pendulum", "about": "d", "mass": 0.05, "length": 0.1, "damping": 0.01}
    motor = {"kind": "linear", "slope": 0.1, "no_load_speed": 100.0}
    for count in (0, 1, 2):
        bodies = [rotor, *(ball | {"name": f"p{k}"} for k in range(count))]
        machine = machine_from({"carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 5.0}, "bodies": bodies, "drive": motor})
        starts = _starts(machine)
        assert starts.shape == (len(machine.state_names), 16 if count else 1)
        rows = [machine.row(b.coordinate.position) for b in machine.bodies]
        shares = (starts[rows[1:]] - starts[rows[0]]) / (2 * math.pi)
        # The golden section; the plastic number, x^3 = x + 1.
        for row, share in zip(shares, ((), (0.6180339887,), (0.7548776662, 0.5698402910))[count], strict=True):
            assert row == pytest.approx((np.arange(16) + 0.5) * share % 1, abs=1e-8)


@pytest.mark.parametrize("failures", [{}, {0: "it burst"}])
def test_a_motion_that_breaks_off_is_none(failures: dict[int, str]) -> None:
    grids, released = list[np.ndarray](), list[Any]()

    def advance(states: np.ndarray, constants: Any, grid: np.ndarray) -> Any:
        grids.append(grid)
        return SimpleNamespace(failures=failures, values="samples", peaks="peaks")

    integrator = SimpleNamespace(advance=advance)
    batch: Any = SimpleNamespace(
        lane_constants=lambda parameters: (parameters, None), acquire=lambda: integrator, release=released.append
    )
    made: Any = _motion(batch, np.zeros(2), np.zeros(1), 3.0)
    assert made is None if failures else (made.samples, made.peaks, made.times[-1]) == ("samples", "peaks", 3.0)
    assert (grids[0][0], grids[0][-1], len(grids[0])) == (0.0, 3.0, 16_385) and released == [integrator]


def test_attractors_are_computed_once_and_not_where_parameters_vary(monkeypatch: pytest.MonkeyPatch) -> None:
    surveys = list[Any]()
    monkeypatch.setattr(module, "_CACHE", {})
    monkeypatch.setattr(module, "_MOST_CACHED", 2)
    monkeypatch.setattr(module, "_survey_attractors", lambda *given: (surveys.append(given[0]), ("one",))[1])
    monkeypatch.setattr(module, "replace", lambda question, until: (question, until))

    def ask(value: float, paths: tuple[str, ...] = ()) -> Any:
        machine = SimpleNamespace(structure="s", values={"c": value}, tracks=(), schedules=())
        question: Any = SimpleNamespace(
            varied_paths=paths, machine=machine, model="full", inertia=None, order=1, tolerance=1e-9, longest=9.0
        )
        return module.attractors_of(question, None, None)  # type: ignore[arg-type]

    assert ask(1.0, ("c",)) == () and not surveys
    assert ask(1.0) == ask(1.0) == ("one",) and len(surveys) == 1 and surveys[0][1] is None
    ask(2.0), ask(1.0)
    assert len(surveys) == 2
    ask(3.0), ask(2.0)
    assert len(surveys) == 3, "the one that came first has gone"
    ask(1.0)
    assert len(surveys) == 4
