"""Steady phase configurations: tables 1 to 3 of 000, table 1 of 001, section 5.1 of 002.

000: L. Sperling, H. Duckstein, B. Ryzhik, "Selbsttaetiges Auswuchten mittels zweier beliebiger Rollen". 001: L. Sperling,
F. Merten, H. Duckstein, "Rotation und Vibration in Beispielen zur Methode der direkten Bewegungsteilung". 002: O. Drozdetskaya,
dissertation, KIT Karlsruhe 2020; (5.8), (5.11), (5.12) corrected as in the errata.
"""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest

from wucht import SynchronousStates, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.catalogue import load_machine
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

Entry = dict[str, Any]


def states(name: str, values: dict[str, float] | None = None, **question: Any) -> list[Entry]:
    result = run(SynchronousStates(**question), load_machine(name, values or {}))
    summary = result.wucht.summary
    assert summary["complete"], summary["shown"]
    entries: list[Entry] = summary["states"]
    return entries


def degrees(state: Entry) -> tuple[float, ...]:
    return tuple(math.degrees(p) for p in state["phases"].values())


# --- 000, tables 1 to 3 ---

UNDAMPED = {"carrier.damping.x": 0.0, "carrier.damping.y": 0.0}  # 000 (20)
SPEEDS = (40.0, 80.0, 110.0, 300.0)  # one in each of the four ranges; 40, 80 and 300 are those of Bild 7 to 10
# phases in degrees (exact values follow from (42)-(48)): stable in the four ranges, as printed
ROWS = {
    "table-1": {
        (138.59, 262.82): (False, True, False, True),
        (221.41, 97.18): (False, True, False, True),
        (0.0, 0.0): (True, False, True, False),
        (180.0, 180.0): (False, False, False, False),
        (180.0, 0.0): (False, False, False, False),
        (0.0, 180.0): (False, False, False, False),
    },
    "table-2": {
        (0.0, 0.0): (True, False, True, False),
        (180.0, 180.0): (False, True, False, True),
        (180.0, 0.0): (False, False, False, False),
        (0.0, 180.0): (False, False, False, False),
    },
    "table-3": {
        (0.0, 0.0): (True, False, True, False),
        (180.0, 180.0): (False, False, False, False),
        (180.0, 0.0): (False, True, False, True),
        (0.0, 180.0): (False, False, False, False),
    },
}  # fmt: skip


def nearest(entries: list[Entry], phases: tuple[float, ...]) -> Entry:
    def apart(state: Entry) -> float:
        return max(abs((a - b + 180) % 360 - 180) for a, b in zip(degrees(state), phases, strict=True))

    return min(entries, key=apart)


# Quick is the lowest speed of the first table and the highest of the others.
@pytest.mark.parametrize(
    ("table", "column"),
    [pytest.param(t, k, marks=() if k == (3 if i else 0) else pytest.mark.slow) for i, t in enumerate(ROWS) for k in range(4)],
)
def test_every_entry_of_tables_1_to_3(table: str, column: int) -> None:
    """Without damping, as the paper computes. Table 3 prints its stable row as (0, pi), which belongs to f_2 > f_0 + f_1; its
    machine has f_1 > f_0 + f_2, and Bild 10 ends at (pi, 0)."""
    entries = states(f"sperling-rollers/{table}", UNDAMPED, speed=SPEEDS[column])
    assert len(entries) == len(ROWS[table])
    for phases, stable in ROWS[table].items():
        state = nearest(entries, phases)
        assert [(p + 1e-6) % 360 for p in degrees(state)] == pytest.approx(list(phases), abs=0.005)
        assert state["stable_slow"] is stable[column], phases
        if not stable[column]:
            assert state["stable_full"] is False


@pytest.mark.parametrize("column", range(4))
@pytest.mark.parametrize("table", ROWS)
def test_the_full_equations_with_damping_agree(table: str, column: int) -> None:
    """0.25 % of critical damping, as in the catalogue: phases move by up to 8 degrees, by omega_0 most."""
    entries = states(f"sperling-rollers/{table}", speed=SPEEDS[column])
    for phases, stable in ROWS[table].items():
        state = nearest(entries, phases)
        apart = max(abs((a - b + 180) % 360 - 180) for a, b in zip(degrees(state), phases, strict=True))
        assert apart < 8
        assert state["stable_full"] is stable[column], phases


def test_the_full_equations_without_damping() -> None:
    """000 (20) leaves the carrier undamped. Then the rollers' dampers, which turn with the rotor, damp its own vibration below
    the natural frequency and excite it above: what the paper calls asymptotically stable grows slowly. A run of the full
    equations grows as the multipliers say."""
    (below,) = (s for s in states("sperling-rollers/table-1", UNDAMPED, speed=40.0) if s["stable_slow"])
    assert below["stable_full"] is True
    above = states("sperling-rollers/table-1", UNDAMPED, speed=80.0)[0]
    assert (above["name"], above["stable_slow"], above["stable_full"]) == ("compensating", True, False)
    assert "the carrier's free vibration at about 62.5 rad/s" in above["why"]
    machine = load_machine("sperling-rollers/table-1", UNDAMPED | {"drive.speed": 80.0})
    start = above["phases"] | {"carrier": {"x": 1e-6}}  # m
    time = np.array([0.0, *np.linspace(40.0, 44.0, 400), *np.linspace(120.0, 124.0, 400)])
    run = integrate(compile_system(machine.system), initial_state(machine, start), list(machine.values.values()), time)
    x = run.states[machine.state_names.index("carrier.x")]
    early, late = np.abs(x[1:401]).max(), np.abs(x[401:]).max()
    assert late < 1e-4  # still small against the rollers' tracks, so that it is linear
    assert math.log(late / early) / 80.0 == pytest.approx(above["growth_full"], rel=0.02)


def test_compensating_phases_of_table_1() -> None:
    """000 (42)-(44)."""
    f0, f1, f2 = 1e-4, 1.2e-4, 8e-5
    first = math.acos((f0**2 + f1**2 - f2**2) / (2 * f0 * f1))
    second = math.acos((f0**2 - f1**2 + f2**2) / (2 * f0 * f2))
    state, other = states("sperling-rollers/table-1")[:2]
    assert tuple(state["phases"].values()) == pytest.approx((math.pi - first, math.pi + second), rel=1e-12)
    assert tuple(other["phases"].values()) == pytest.approx((math.pi + first, math.pi - second), rel=1e-12)
    assert state["name"] == other["name"] == "compensating"
    assert state["residual_unbalance"] == other["residual_unbalance"] == 0


def test_stability_changes_at_omega_0() -> None:
    """000: omega_0 = sqrt((omega_x^2 + omega_y^2)/2) = 98.884 rad/s, where A_xx + A_yy changes its sign."""
    assert math.sqrt((62.5**2 + 125.1**2) / 2) == pytest.approx(98.884, abs=1e-3)
    for speed, stable in ((98.883, True), (98.885, False)):
        entries = states("sperling-rollers/table-1", UNDAMPED, speed=speed, full=False)
        assert [s["stable_slow"] for s in entries if s["name"] == "compensating"] == [stable] * 2
        assert nearest(entries, (0.0, 0.0))["stable_slow"] is not stable


# --- 001, table 1 ---

MEMBERS = {  # name, and the cosines of both phases: of f > f_0/2 and f < f_0/2 stable below and above the natural frequency
    ("together", 1): ((True, False), (True, False)),
    ("together", -1): ((False, False), (False, True)),
    ("opposed", 0): ((False, False), (False, False)),
}


@pytest.mark.parametrize("large", [True, False])
@pytest.mark.parametrize("above", [False, True])
def test_table_1_of_001(large: bool, above: bool) -> None:
    """The machine of Bild 4 without its damping b, omega = 2 pi; f = 0.8 f_0, or 0.4 f_0 with half the balls' distance."""
    values = {"carrier.damping": 0.0} | ({} if large else {"b1.length": 0.05, "b2.length": 0.05})
    entries = states("sperling-vibration/figure-4", values, speed=12.0 if above else 4.0)
    assert len(entries) == (4 if large else 3)
    for state in entries:
        if state["name"] == "compensating":
            gamma = math.acos(1 / (2 * 0.8))  # (49)
            assert sorted(state["phases"].values()) == pytest.approx([math.pi - gamma, math.pi + gamma], rel=1e-12)
            assert state["stable_slow"] is above
            assert (state["type"], state["multiplicity"]) == ("I", 2)
            continue
        cosine = sum(math.cos(p) for p in state["phases"].values()) / 2
        assert abs(cosine - round(cosine)) < 1e-9
        assert state["stable_slow"] is MEMBERS[state["name"], round(cosine)][0 if large else 1][above]


# --- 002, section 5.1 ---

SET = {"epsilon": 0.01, "mu": 0.01, "s": 0.75, "w": 1.30, "lambda": 2.0, "sigma": 0.1}  # table 5.1


def coefficients(omega: float) -> tuple[float, float]:
    return 1 - omega**2, 2 * SET["sigma"] * omega  # (5.4)


def psi(state: Entry) -> float:
    first, second = state["phases"].values()
    middle = (first + second) / 2
    return middle if state["name"] != "compensating" else math.pi + (middle - math.pi)


@pytest.mark.parametrize("u", [0.5, 1.0, 1.8, 2.5, 5.0, 6.0, 9.0])
def test_the_three_types(u: float) -> None:
    """Every state fulfils the corrected (5.5)-(5.15), and each root of these is a state."""
    s, w, no_load = SET["s"], SET["w"], SET["lambda"]
    entries = states("drozdetskaya-2020/table-5.1", {"u": u}, full=False)
    kinds = {t: [x for x in entries if x["type"] == t] for t in ("I", "II", "III")}
    (compensating,) = kinds["I"]
    assert compensating["speed"] == pytest.approx(no_load, rel=1e-12)  # (5.7)
    assert psi(compensating) == pytest.approx(math.pi, rel=1e-12)  # (5.5)
    assert math.cos((compensating["phases"]["p1"] - compensating["phases"]["p2"]) / 2) == pytest.approx(
        s / 2, abs=1e-12
    )  # (5.6)
    for x in kinds["II"]:
        omega = x["speed"]
        a, b = coefficients(omega)
        d = a**2 + b**2
        r = math.sqrt(s**2 * d - 4 * b**2)
        angles = [math.atan2((-2 * a * b - k * b * r) / (s * d), (k * a * r - 2 * b**2) / (s * d)) for k in (1, -1)]  # (5.8)
        root = 4 * a * math.sqrt(a**2 * s**2 + b**2 * (s**2 - 4))
        rest = a**2 * (s**2 + 4) + b**2 * (s**2 - 4)
        slopes = [
            2 * SET["sigma"] * w * omega**5 * (rest + k * root) / (s * (no_load - omega) * d**2) for k in (1, -1)
        ]  # (5.11)
        chosen = int(np.argmin([abs(v - u) for v in slopes]))
        assert slopes[chosen] == pytest.approx(u, rel=1e-9)
        assert math.cos(psi(x) - angles[chosen]) == pytest.approx(1, abs=1e-12)
        driven = u * s * d * (no_load - omega)
        squares = [(b * omega**4 * w * (s**2 + k * 4) - driven) ** 2 / (16 * v**2 * omega**8 * w**2 * s**2)
                   for k, v in ((1, b), (-1, a))]  # fmt: skip
        assert sum(squares) == pytest.approx(1, rel=1e-7)  # (5.10)
    for x in kinds["III"]:
        omega = x["speed"]
        a, b = coefficients(omega)
        assert u == pytest.approx(2 * omega**5 * s * SET["sigma"] * w / ((no_load - omega) * (a**2 + b**2)), rel=1e-9)  # (5.15)
        assert math.tan(psi(x)) == pytest.approx(a / b, rel=1e-9)  # (5.12) corrected
        assert x["multiplicity"] == 2
    assert len(kinds["III"]) == roots_of_5_15(u)
    assert len(kinds["II"]) == roots_of_5_11(u)


def roots_of_5_15(u: float) -> int:
    omega = np.linspace(1e-3, 1.9999, 400_001)
    a, b = 1 - omega**2, 2 * SET["sigma"] * omega
    left = u * (SET["lambda"] - omega) * (a**2 + b**2) - 2 * omega**5 * SET["s"] * SET["sigma"] * SET["w"]
    return int((np.diff(np.sign(left)) != 0).sum())


def roots_of_5_11(u: float) -> int:
    omega, count = np.linspace(1e-3, 1.9999, 400_001), 0
    a, b, s = 1 - omega**2, 2 * SET["sigma"] * omega, SET["s"]
    inside = a**2 * s**2 + b**2 * (s**2 - 4)
    for sign in (1, -1):
        with np.errstate(invalid="ignore"):
            rest = a**2 * (s**2 + 4) + b**2 * (s**2 - 4) + sign * 4 * a * np.sqrt(inside)
        left = np.sign(u * s * (SET["lambda"] - omega) * (a**2 + b**2) ** 2 - 2 * SET["sigma"] * SET["w"] * omega**5 * rest)
        both = np.isfinite(left[1:]) & np.isfinite(left[:-1])
        count += int((left[1:][both] != left[:-1][both]).sum())
    return count


def test_type_ii_at_u_1() -> None:
    """Speeds of both, and eigenvalues per rotor angle of (4.60)-(4.62) corrected."""
    entries = [s for s in states("drozdetskaya-2020/table-5.1", {"u": 1.0}, inertia=False) if s["type"] == "II"]
    lower, upper = sorted(entries, key=lambda s: float(s["speed"]))
    assert (lower["speed"], upper["speed"]) == pytest.approx((0.7028953, 0.7674411), abs=5e-8)
    assert (lower["stable_slow"], upper["stable_slow"]) == (True, False)
    assert (lower["stable_full"], upper["stable_full"]) == (True, False)
    assert lower["growth_slow"] / lower["speed"] == pytest.approx(-0.003762, abs=5e-7)


def exponents_per_angle(u: float, state: Entry) -> np.ndarray:
    """Of the averaged equations without inertia, a unit of the rotor's angle, the largest first."""
    machine = load_machine("drozdetskaya-2020/table-5.1", {"u": u})
    averaged_equations = averaged_equations_of(machine, inertia=False)
    at = State(state["speed"], np.array([0.0, state["phases"]["p1"], state["phases"]["p2"]]))
    exponents: np.ndarray = (
        AveragedStability(SteadyTorques.from_averaged_equations(averaged_equations), averaged_equations).stability(at).exponents
        / state["speed"]
    )
    return exponents


def test_eigenvalues_of_the_averaged_equations() -> None:
    lower = min((s for s in states("drozdetskaya-2020/table-5.1", {"u": 1.0}) if s["type"] == "II"), key=lambda s: s["speed"])
    assert exponents_per_angle(1.0, lower) == pytest.approx(np.array([-0.003762, -0.016217, -0.16462]), abs=5e-6)
    (state,) = (s for s in states("drozdetskaya-2020/table-5.1", {"u": 2.0}) if s["type"] == "I")
    exponents = exponents_per_angle(2.0, state)
    assert exponents[0] == pytest.approx(-0.001807, abs=5e-7)
    assert exponents[1:] == pytest.approx(np.array([-0.04112 + 0.0029j, -0.04112 - 0.0029j]), abs=6e-6) or exponents[1:] == (
        pytest.approx(np.array([-0.04112 - 0.0029j, -0.04112 + 0.0029j]), abs=6e-6)
    )


@pytest.mark.parametrize(
    ("u", "below", "above", "speed"),
    [(1.8331080, 2, 0, 0.7758765), (5.8710372, 0, 2, 1.4926832)],  # u1*, u2*: cases
)
def test_the_folds_of_type_ii(u: float, below: int, above: int, speed: float) -> None:
    for factor, count in ((1 - 1e-6, below), (1 + 1e-6, above)):
        machine = load_machine("drozdetskaya-2020/table-5.1", {"u": u * factor})
        every = json.loads(run(SynchronousStates(full=False), machine).attrs["summary"])["states"]
        entries = [s for s in every if s["type"] == "II"]
        assert len(entries) == count
        for s in entries:
            assert s["speed"] == pytest.approx(speed, abs=2e-3)


@pytest.mark.parametrize("u", [0.5, 2.0, 5.0, 9.0])
def test_stable_as_in_5_1(u: float) -> None:
    """ "Type I exists for all u and is always stable, type III never": averaged equations. Supercritical type II never."""
    for state in states("drozdetskaya-2020/table-5.1", {"u": u}, inertia=False, full=False):
        if state["type"] == "I":
            assert state["stable_slow"]
        if state["type"] == "III" or (state["type"] == "II" and state["speed"] > 1):
            assert not state["stable_slow"]


@pytest.mark.parametrize(("sigma", "stable"), [(0.1, True), (0.03, True), (0.02, False), (0.01, False)])
def test_type_i_is_lost_with_light_damping(sigma: float, stable: bool) -> None:
    """Errata: the claim that type I is always stable holds for the averaged equations; the full ones lose it (Hopf)."""
    (state,) = (
        s for s in states("drozdetskaya-2020/table-5.1", {"u": 2.0, "sigma": sigma, "lambda": 1.3}) if s["type"] == "I"
    )  # fmt: skip
    assert state["stable_slow"] is True
    assert state["stable_full"] is stable
    if not stable:
        assert "a pair of multipliers" in state["why"]
