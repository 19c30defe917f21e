"""O. Drozdetskaya, dissertation, KIT Karlsruhe 2020: figures 3.2, 5.2, 5.3 and A.1.

Numbers computed independently from the corrected equations (AUTO-07p, SymPy), met to all digits given. Every point of the
branches is held against the closed forms (3.52), (5.11), (5.15) with the corrections of docs/errata.md.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest

from wucht import SpeedCurve, run
from wucht.files.catalogue import load_machine
from wucht.studies.study_file import read_study

FIGURE = "drozdetskaya-2020/figure-{}"


@cache
def result(name: str, **settings: float) -> Any:
    study = read_study(FIGURE.format(name), settings)
    return run(study.spec, study.subject)


def answer(name: str, **settings: float) -> dict[str, Any]:
    return result(name, **settings).wucht.summary


def branches_of(name: str, type_: str) -> list[tuple[np.ndarray, np.ndarray]]:
    """u and omega of the points of all branches of a type."""
    r = result(name)
    numbers = [k for k, t in enumerate(r.branch_type.values) if t == type_]
    return [(r.value.values[at], r.speed.values[at]) for k in numbers for at in [r.branch.values == k]]


def folds(name: str, type_: str | None, **settings: float) -> list[tuple[float, float]]:
    s = answer(name, **settings)
    points = [p for p in s["special_points"] if s["branches"][p["branch"]]["type"] == type_]
    assert {p["kind"] for p in points} == {"fold"}
    return sorted((p["u"], p["speed"]) for p in points)


def test_figure_3_2() -> None:
    """Table 3.1: the folds; three speeds at u = 2; (3.52) all along."""
    assert folds("3.2", None) == [
        pytest.approx((0.8937191, 1.4239669), abs=5e-8),
        pytest.approx((2.6053860, 1.0213376), abs=5e-8),
    ]
    states = answer("3.2")["states"]
    assert [s["speed"] for s in states] == pytest.approx([1.8176384, 1.0937039, 0.9686444], abs=5e-8)
    assert [s["stable"] for s in states] == [True, False, True]
    (branch,) = answer("3.2")["branches"]
    assert branch["stable"] == [pytest.approx([0.0, 2.6053860]), pytest.approx([0.8937191, 5.0])]
    u, w = result("3.2").value.values, result("3.2").speed.values
    assert u == pytest.approx(0.1 * w**5 / (((1 - w**2) ** 2 + 4 * 0.01 * w**2) * (2 - w)), rel=1e-9, abs=1e-14)


def test_figure_3_2_of_the_laval_rotor_has_twice_the_folds() -> None:
    laval = run(SpeedCurve(along="u", range=[0.1, 10]), load_machine("drozdetskaya-2020/table-3.1-laval"))
    found = sorted(p["u"] for p in laval.wucht.summary["special_points"])
    assert found == pytest.approx([2 * 0.8937191, 2 * 2.6053860], abs=1e-7)


def test_figure_5_2() -> None:
    """Table 5.1, type II: u1*, u2*; stable below u1* only; type I always, type III never."""
    assert folds("5.2", "II") == [
        pytest.approx((1.8331080, 0.7758765), abs=5e-8),
        pytest.approx((5.8710372, 1.4926832), abs=5e-8),
    ]
    states = [p["state"] for p in answer("5.2")["special_points"] if p["branch"] in (2, 3)]
    assert [(s["psi"], s["delta"]) for s in states] == [
        pytest.approx((-1.6914641, 0.0), abs=5e-8),
        pytest.approx((2.6986434, 0.0), abs=5e-8),
    ]
    stable = [(b["type"], b["stable"]) for b in answer("5.2")["branches"]]
    assert stable == [
        ("I", [pytest.approx([0.0, 10.0], abs=0.02)]),  # at u = 0 nothing drives: the equations are singular there
        ("III", []),
        ("II", [pytest.approx([0.0, 1.8331080])]),
        ("II", []),
    ]
    assert answer("5.2")["complete"]


def closed_form(w: np.ndarray, s: float, w_ratio: float, sigma: float, lambda_: float) -> tuple[np.ndarray, np.ndarray]:
    """u of type II by (5.11), corrected, both signs; not a number where there is none."""
    A, B = 1 - w**2, 2 * sigma * w
    with np.errstate(invalid="ignore"):
        root = np.sqrt(A**2 * s**2 + B**2 * (s**2 - 4))
    factor = 2 * sigma * w_ratio * w**5 / (s * (lambda_ - w) * (A**2 + B**2) ** 2)
    even = A**2 * (s**2 + 4) + B**2 * (s**2 - 4)
    return factor * (even + 4 * A * root), factor * (even - 4 * A * root)


@pytest.mark.parametrize(("name", "s", "w_ratio"), [("5.2", 0.75, 1.30), ("a.1", 1.0, 0.98)])
def test_all_points_of_types_ii_and_iii_are_those_of_the_closed_forms(name: str, s: float, w_ratio: float) -> None:
    for u, w in branches_of(name, "II"):
        regular = np.abs(w) > 0.1
        plus, minus = closed_form(w[regular], s, w_ratio, 0.1, 2.0)
        # Near its fold in w the square root of (5.11) loses half the digits.
        away = np.fmin(np.abs(plus - u[regular]), np.abs(minus - u[regular]))
        assert np.nanmax(away / u[regular]) < 1e-6
        assert len(u) > 50
    ((u, w),) = branches_of(name, "III")
    denominator = (2.0 - w) * ((1 - w**2) ** 2 + (0.2 * w) ** 2)
    expected = 2 * w**5 * s * 0.1 * w_ratio / denominator
    assert u == pytest.approx(expected, rel=1e-9, abs=1e-13)


def test_figure_5_2_at_u_1() -> None:
    """Type II at u = 1: a stable node and a saddle, eigenvalues per unit of phi."""
    s = answer("5.2", u=1.0)
    together = [x for x in s["states"] if x["type"] == "II"]
    assert [(x["speed"], x["stable"]) for x in together] == [
        (pytest.approx(0.7674411, abs=5e-8), False),
        (pytest.approx(0.7028953, abs=5e-8), True),
    ]
    per_phi = sorted(e[0] for e in together[1]["exponents_phi"])
    assert per_phi == pytest.approx([-0.16462, -0.016217, -0.003762], rel=2e-4)


def test_figure_5_2_at_u_2_type_i() -> None:
    (own,) = [x for x in answer("5.2", u=2.0)["states"] if x["type"] == "I"]
    assert own["speed"] == pytest.approx(2.0, rel=1e-12) and own["amplitude"] == 0
    assert own["exponents_phi"][0] == pytest.approx([-0.001807, 0.0], abs=1e-6)
    assert sorted(own["exponents_phi"][1:]) == [pytest.approx([-0.04112, s * 0.0029], abs=6e-5) for s in (-1, 1)]
    assert (own["state"]["psi"], own["state"]["delta"]) == pytest.approx((np.pi, 2 * np.arccos(0.375)), rel=1e-9)


@pytest.mark.slow
def test_figure_5_3() -> None:
    """sigma = 0.05: both pairs coexist; 0.0672888: u1* = u2*."""
    by_sigma: dict[float, list[float]] = {}
    for p in answer("5.3")["special_points"]:
        by_sigma.setdefault(p["sigma"], []).append(p["u"])
    assert sorted(by_sigma[0.05]) == pytest.approx([2.6739155, 5.8600817], abs=5e-8)
    assert by_sigma[0.0672888] == pytest.approx([3.6873885, 3.6873885], rel=3e-6)
    assert sorted(by_sigma[0.1]) == pytest.approx([1.8331080, 5.8710372], abs=5e-8)
    assert {b["name"] for b in answer("5.3")["branches"]} == {"together"}


def test_figure_a_1() -> None:
    assert [u for u, _ in folds("a.1", "II")] == pytest.approx([2.0173455, 2.3440611], abs=5e-8)


def test_the_folds_of_table_5_1_over_the_damping() -> None:
    """In the plane of u and sigma the two curves of type II cross at sigma = 0.0672888, u = 3.6873885."""
    spec = SpeedCurve(along="u", range=[0.5, 10], second="sigma", second_range=[0.03, 0.2], only=["together"], points=2)
    r = run(spec, load_machine("drozdetskaya-2020/table-5.1"))
    assert r.wucht.summary["second"] == "sigma" and r.sizes["curve_number"] == 2
    for k in range(2):
        at = r["curve"].values == k
        q, p = r.curve_second.values[at], r.curve_value.values[at]
        order = np.argsort(q)
        # A cubic through neighbours of the crossing: points are a few hundredths apart.
        near = order[np.argsort(np.abs(q[order] - 0.0672888))[:4]]
        assert np.polyval(np.polyfit(q[near] - 0.0672888, p[near], 3), 0.0) == pytest.approx(3.6873885, rel=2e-5)
        assert np.interp(0.1, q[order], p[order]) == pytest.approx((1.8331080, 5.8710372)[k], rel=1e-4)


@pytest.mark.parametrize("name", ["r1", "r2"])
def test_real_machines_have_the_folds_of_their_dimensionless_numbers(name: str) -> None:
    """errata.md, R1, R2: slope = 9.75e-4 u N m s; epsilon and the inertias do not change where states are."""
    machine = load_machine(f"drozdetskaya-2020/{name}")
    spec = SpeedCurve(along="drive.slope", range=["1e-4 N m s", "0.01 N m s"], points=3, only=["together"])
    s = run(spec, machine).wucht.summary
    assert sorted(p["drive.slope"] for p in s["special_points"]) == pytest.approx(
        [9.75e-4 * 1.8331080, 9.75e-4 * 5.8710372], rel=1e-7
    )
    assert [b["stable"] for b in s["branches"]] == [[pytest.approx([1e-4, 9.75e-4 * 1.8331080])], []]
