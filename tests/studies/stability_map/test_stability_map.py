"""Maps of equations with known boundaries, what is refused, and the parts of a map."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
import sympy as sp
from tests.refusals import Refusal, refused

import wucht
from wucht import RunUp, StabilityMap, System, draw, report, run
from wucht.files.building import machine_from

X, Y, P, R = sp.symbols("x y p r", real=True)
CUSP = wucht.UserSystem(System((X,), (P + R * X - X**3,), (P, R)), {"p": 0.0, "r": 1.0}, "a cusp")
PLANE: dict[str, Any] = {"along": "p", "range": [-2.0, 2.0], "second": "r", "second_range": [-1.0, 2.0]}


Q = X**2 + Y**2
# In polar coordinates r' = r (p + s r^2 - r^4), theta' = 1: a Hopf point at p = 0; orbits fold at p = -s^2/4 where s > 0.
S = sp.Symbol("s", real=True)
HOPF_FORM = wucht.UserSystem(
    System((X, Y), (X * (P + S * Q - Q**2) - Y, Y * (P + S * Q - Q**2) + X), (P, S)), {"p": 0.1, "s": 1.0}, "a Hopf point"
)


UNEQUAL = {
    "carrier": {"directions": "xy", "mass": 8.0, "stiffness": [20000.0, 55000.0], "damping": [60.0, 90.0]},
    "bodies": [
        {"kind": "rotor", "name": "r1", "mass": 4.0, "unbalance": 0.012, "inertia": 0.06, "bearing_damping": 0.0002},
        {"kind": "pendulum", "name": "p1", "about": "r1", "mass": 0.07, "length": 0.1, "damping": 0.004},
        {"kind": "pendulum", "name": "p2", "about": "r1", "mass": 0.13, "length": 0.09, "damping": 0.006, "inertia": 0.0011},
    ],
    "drive": {"on": "r1", "kind": "linear", "slope": 0.03, "no_load_speed": 110.0},
    "loads": [{"on": "r1", "kind": "quadratic", "coefficient": 5e-06}],
}


# Between captured and compensated at small slopes: several families of modulated motions in narrow bands, whose branches turn
# back at folds or are closed. Of 7 x 8 places with eight starts each, 21 have one that is captured for good (own DOPRI5).
BANDS = {
    "carrier": {"directions": "xy", "mass": 3.0, "stiffness": [80000.0, 95000.0], "damping": [170.0, 190.0]},
    "bodies": [
        {"kind": "rotor", "name": "r", "mass": 7.0, "unbalance": 0.009, "inertia": 0.03},
        {"kind": "pendulum", "name": "p1", "about": "r", "mass": 0.12, "length": 0.1, "damping": 0.09},
        {"kind": "pendulum", "name": "p2", "about": "r", "mass": 0.1, "length": 0.1, "damping": 0.12},
    ],
    "drive": {"on": "r", "kind": "linear", "slope": 0.01, "no_load_speed": 180.0},
}


@pytest.fixture(scope="module")
def cusp() -> Any:
    return run(StabilityMap(**PLANE, cells=3, orbits=False, ranges={"x": [-2.0, 2.0]}), CUSP)


def test_folds_of_a_cusp(cusp: Any) -> None:
    """x' = p + r x - x^3 folds at 27 p^2 = 4 r^3: inside there are two stable states, outside one."""
    summary = cusp.wucht.summary
    (points,) = summary["boundaries"].values()
    p, r = np.array(points).T
    np.testing.assert_allclose(27 * p**2, 4 * r**3, atol=1e-8)
    (mark,) = summary["points"]
    assert (mark["kind"], mark["p"], mark["r"]) == ("cusp", pytest.approx(0.0, abs=1e-6), pytest.approx(0.0, abs=1e-6))
    inside = 2 * 2 * 2 * 2**2.5 / 5 / 3**1.5 / 12  # the integral over r of 2 (4 r^3/27)^(1/2), of the plane
    shares = {each["label"]: each["share"] for each in summary["regions"]}
    assert shares["2 stable states"] == pytest.approx(inside, abs=0.01)
    assert sum(shares.values()) == pytest.approx(1.0)
    assert summary["against"] == 0


def test_the_region_of_a_place_is_read_by_its_coordinates(cusp: Any) -> None:
    region = cusp.region
    assert (region.x.dims, region.y.dims) == (("x",), ("y",))
    assert (region.x.attrs["long_name"], region.y.attrs["long_name"]) == ("parameter p", "parameter r")
    here = {"x": -0.5, "y": 1.5}  # p, r: between the folds
    assert cusp.region_label[region.sel(here, method="nearest").item()].item() == "2 stable states"
    assert cusp.region_label[region.sel({"x": -0.5, "y": 0.0}, method="nearest").item()].item() != "2 stable states"


@pytest.mark.parametrize(
    ("changed", "refusal"),
    [
        ({"second": "p"}, refused("study.second", given="p")),
        ({"second": "q"}, refused("study.second", given="q", code="unknown-parameter")),
        ({"cells": 1}, refused("study.cells", "64", given=1)),
        ({"range": [2.0, -2.0]}, refused("study.range", given=[2.0, -2.0])),
        ({"eliminate": "s"}, refused("study.eliminate_range", given=None, code="missing")),
        ({"eliminate": "r", "eliminate_range": [0, 1]}, refused("study.eliminate", given="r")),
        ({"eliminate": "s", "eliminate_range": [0, 1], "orbits": False}, refused("study.orbits", given=False)),
        (
            {"eliminate": "t", "eliminate_range": [0, 1], "orbits": True},
            refused("study.eliminate", given="t", code="unknown-parameter"),
        ),
        ({"together": True, "orbits": True}, refused("study.together", given=True, code="machine-only")),
        ({"ranges": None}, refused("study.ranges", given=None, code="missing")),
    ],
)
def test_what_does_not_fit_is_refused(changed: dict[str, Any], refusal: Refusal) -> None:
    asked = {**PLANE, "orbits": False, "ranges": {"x": [-2.0, 2.0]}, **changed}
    with refusal:
        run(StabilityMap(**asked), CUSP)


@pytest.mark.slow
def test_orbits_that_begin_at_a_hopf_point_and_fold() -> None:
    asked: dict[str, Any] = {"along": "p", "range": [-0.6, 0.5], "second": "s", "second_range": [0.5, 1.3], "cells": 3}
    summary = run(StabilityMap(**asked, ranges={"x": [-2, 2], "y": [-2, 2]}), HOPF_FORM).wucht.summary
    hopf, fold = (np.array(summary["boundaries"][name]) for name in ("hopf: steady states", "periodic orbit: fold"))
    np.testing.assert_allclose(hopf[:, 0], 0.0, atol=1e-8)
    np.testing.assert_allclose(fold[:, 0], -(fold[:, 1] ** 2) / 4, atol=1e-6)
    assert np.ptp(fold[:, 1]) == pytest.approx(0.8)
    labels = {each["label"] for each in summary["regions"]}
    assert "periodic orbit stable" in labels
    assert summary["against"] == 0


# In polar coordinates r' = r (s - p^2 - (r^2 - 1)^2), theta' = 1: for s < 1 rest is stable, and beside it an orbit where
# p^2 < s; over p its branch is closed, an isola, which no steady state is connected with.
ISOLA = wucht.UserSystem(
    System((X, Y), (X * (S - P**2 - (Q - 1) ** 2) - Y, Y * (S - P**2 - (Q - 1) ** 2) + X), (P, S)),
    {"p": 0.1, "s": 0.5},
    "isola",
)


def test_a_closed_branch_of_orbits() -> None:
    asked: dict[str, Any] = {"along": "p", "range": [-1.0, 1.0], "second": "s", "second_range": [0.2, 0.8], "cells": 2}
    summary = run(StabilityMap(**asked, ranges={"x": [-2, 2], "y": [-2, 2]}), ISOLA).wucht.summary
    fold = np.concatenate([line for name, line in summary["boundaries"].items() if name.startswith("periodic orbit: fold")])
    np.testing.assert_allclose(fold[:, 0] ** 2, fold[:, 1], atol=1e-6)
    shares = {each["label"]: (each["share"], each["uncertainty"]) for each in summary["regions"]}
    inside = (0.8**1.5 - 0.2**1.5) / 0.9  # of the plane: the integral over s of 2 sqrt(s)
    assert set(shares) == {"periodic orbit stable", "nothing else"}
    share, uncertainty = shares["periodic orbit stable"]
    assert share == pytest.approx(inside, abs=0.01) and uncertainty < 0.01
    assert summary["against"] == 0


def test_few_places_say_how_much_they_may_miss() -> None:
    """All of n random places miss a share s with probability (1 - s)^n: 5 % at s = 1 - 0.05^(1/n)."""
    asked: dict[str, Any] = {"along": "p", "range": [-0.9, -0.6], "second": "s", "second_range": [0.2, 0.3], "cells": 2}
    result = run(StabilityMap(**asked, ranges={"x": [-2, 2], "y": [-2, 2]}), ISOLA)
    summary = result.wucht.summary
    (region,) = summary["regions"]
    assert (region["label"], region["share"]) == ("nothing else", 1.0)
    assert region["uncertainty"] == summary["detection_limit"]
    assert summary["detection_limit"] == pytest.approx(1 - 0.05**0.25)
    assert "another motion may exist in up to 53 % of it" in result.attrs["warnings"]
    assert "less than 53 % of it may be missed" in result.attrs["sentence"]


@pytest.mark.slow
def test_a_motion_that_begins_at_no_steady_state_that_is_lost() -> None:
    """Left of the Hopf point the state at rest is stable all over; only runs from afar come to the other motion."""
    asked: dict[str, Any] = {"along": "p", "range": [-0.6, -0.05], "second": "s", "second_range": [0.8, 1.2], "cells": 2}
    result = run(StabilityMap(**asked, ranges={"x": [-2, 2], "y": [-2, 2]}), HOPF_FORM)
    summary = result.wucht.summary
    fold = np.array(summary["boundaries"]["periodic orbit: fold"])
    np.testing.assert_allclose(fold[:, 0], -(fold[:, 1] ** 2) / 4, atol=1e-6)
    share = (-0.05 + np.mean(np.linspace(0.8, 1.2, 201) ** 2) / 4) / 0.55
    shares = {each["label"]: each["share"] for each in summary["regions"]}
    assert summary["everywhere"] == ["one stable state"]
    assert shares["periodic orbit stable"] == pytest.approx(share, abs=0.01)
    assert shares["nothing else"] == pytest.approx(1 - share, abs=0.01)
    assert (summary["against"], summary["runs"]) == (0, 6 * summary["places"])
    assert any(f"by {summary['runs']} runs from several starts" in line for line in report(result))


def test_what_was_not_sought_is_not_called_absent(cusp: Any) -> None:
    assert cusp.attrs["sentence"].endswith("; periodic orbits were not searched for")
    assert cusp.wucht.summary["detection_limit"] == pytest.approx(1 - 0.05 ** (1 / 12)), "at four values in each of three rows"
    assert cusp.wucht.summary["runs"] == 0
    assert not any("nothing else" in each["label"] for each in cusp.wucht.summary["regions"])


@pytest.mark.slow
def test_modulated_motion_of_two_unequal_pendulums() -> None:
    """At small slopes the pendulums lag and rotate, though the steady state that compensates is stable all over the plane."""
    asked: dict[str, Any] = {"along": "drive.slope", "range": [0.002, 0.03], "second": "r1.unbalance"}
    summary = run(StabilityMap(**asked, second_range=[0.006, 0.018], cells=4), machine_from(UNEQUAL)).wucht.summary
    assert summary["everywhere"] == ["compensating"]
    assert sum(r["share"] for r in summary["regions"] if "modulated motion stable" in r["label"]) == pytest.approx(
        0.43, abs=0.03
    )
    assert summary["against"] == 0
    fold = np.array(summary["boundaries"]["modulated motion: fold"])
    at = float(np.interp(0.012, *fold[np.argsort(fold[:, 1])].T[::-1]))
    assert 0.012 < at < 0.0145
    for slope, outcome in ((0.005, "captured-modulated"), (at + 0.002, "compensated")):
        machine = machine_from(UNEQUAL).with_values({"drive.slope": slope})
        for start in ({"p1": 1.0}, {"p1": 2.5, "p2": -1.0}):
            assert run(RunUp(settled=True, model="slow", start=start), machine).wucht.summary["outcome"] == outcome


@pytest.mark.slow
def test_narrow_bands_of_modulated_motions() -> None:
    """A map says what run-ups from eight starts do at places of its regions that lie 2 % of the plane from any border.

    With 2 x 2 cells none of these motions is met, and the map says so.
    """
    asked: dict[str, Any] = {"along": "drive.slope", "range": [0.008, 0.0115], "second": "p1.damping"}
    result = run(StabilityMap(**asked, second_range=[0.05, 0.09], cells=7), machine_from(BANDS))
    shares = {each["label"]: each["share"] for each in result.wucht.summary["regions"]}
    survey, scatter = 21 / 56, 2 * np.sqrt(21 * 35 / 56**3)
    assert shares["modulated motion stable"] == pytest.approx(survey, abs=scatter)
    few = run(StabilityMap(**asked, second_range=[0.05, 0.09], cells=2), machine_from(BANDS)).wucht.summary
    assert few["detection_limit"] > survey
    random, sizes = np.random.default_rng(56), result.region.shape
    outcomes: dict[str, list[bool]] = {"modulated motion stable": [], "nothing else": []}
    while min(map(len, outcomes.values())) < 4:
        i, j = (int(random.integers(5, n - 5)) for n in sizes)
        around = np.unique(result.region_label.values[result.region.values[i - 5 : i + 6, j - 5 : j + 6]])
        if len(around) > 1 or len(outcomes.get(str(around[0]), range(4))) >= 4:
            continue
        values = {"drive.slope": float(result.x[j]), "p1.damping": float(result.y[i])}
        machine = machine_from(BANDS).with_values(values)
        ends = [
            run(RunUp(settled=True, model="slow", start={"p1": a, "p2": b}), machine).wucht.summary["outcome"]
            for a, b in random.uniform(-np.pi, np.pi, (8, 2)).tolist()
        ]
        outcomes[str(around[0])].append("captured-modulated" in ends)
    assert all(outcomes["modulated motion stable"]) and not any(outcomes["nothing else"]), outcomes


def test_interrupted_maps_are_kept() -> None:
    asked = StabilityMap(**PLANE, cells=3, orbits=False, ranges={"x": [-2.0, 2.0]})

    def stop(share: float, _: str) -> None:
        if share > 0.2:
            raise KeyboardInterrupt

    result = run(asked, CUSP, progress=stop)
    assert not result.attrs["finished"]
    assert "the map is not finished" in result.attrs["warnings"]
    draw(result)


# Folds at p = -r (x = -2) and at p = r (x = 2): both coincide at (0, 0).
PAIRS = wucht.UserSystem(
    System((X,), (-((X + 2) ** 2 - P - R) * ((X - 2) ** 2 - P + R),), (P, R)), {"p": 0.5, "r": 0.1}, "pairs"
)


def two_pairs() -> Any:
    plane = {"along": "p", "range": [-0.6, 1.0], "second": "r", "second_range": [-0.5, 0.7]}
    return run(StabilityMap(**plane, cells=3, orbits=False, ranges={"x": [-4.0, 4.0]}), PAIRS)


@pytest.mark.slow
def test_curves_of_folds_that_cross() -> None:
    """And where Newton's method does not find the place, that is said."""
    (mark,) = two_pairs().wucht.summary["points"]
    assert (mark["kind"], mark["p"], mark["r"]) == ("two folds at once", pytest.approx(0, abs=1e-8), pytest.approx(0, abs=1e-8))
