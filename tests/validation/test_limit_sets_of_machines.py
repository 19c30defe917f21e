"""What the motion of a machine tends to (run-up with ``limit_set``), against closed forms and other formulations.

Source: the rotor on a vibrating axis of L. Sperling, F. Merten, H. Duckstein, "Rotation und Vibration in Beispielen zur Methode
der direkten Bewegungsteilung", 2.2 and Bild 2, without its motor: with x = x_0 cos(Omega t) its equation is

    J phi'' = -b phi' - m eps x_0 Omega^2 cos(Omega t) sin(phi),

so that with b/J = 1 /s and m eps/J = 100 /m the area of any set of states decays as exp(-t): Liouville's theorem.
"""

from __future__ import annotations

from functools import cache
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import wucht

B, RATIO, OMEGA = 1.0, 100.0, 2 * np.pi


@cache
def limit_set(amplitude: float, angle: float) -> dict[str, Any]:
    machine = wucht.load_machine("sperling-vibration/sustained-rotation").with_values({"carrier.motion.amplitude": amplitude})
    result = wucht.run(wucht.RunUp(until=60.0, start={"rotor": angle}, limit_set=True), machine)
    found: dict[str, Any] = result.wucht.summary["limit_set"]
    return found


def multipliers_by_scipy(amplitude: float) -> np.ndarray:
    """Floquet multipliers of phi = 0 with Omega_1 = 2 pi: the equation linearised by hand, integrated by SciPy."""

    def rates(t: float, y: np.ndarray) -> np.ndarray:
        return np.array([y[1], -B * y[1] - RATIO * amplitude * OMEGA**2 * np.cos(OMEGA * t) * y[0]])

    ends = [solve_ivp(rates, (0.0, 1.0), y0, "DOP853", rtol=1e-11, atol=1e-13).y[:, -1] for y0 in np.eye(2)]
    return np.linalg.eigvals(np.column_stack(ends))


@pytest.mark.parametrize("amplitude", [0.005, 0.008, 0.012])
def test_a_rotor_on_an_orbit_returns_as_the_area_of_states(amplitude: float) -> None:
    """Both multipliers are a complex pair, whose size after a time T is exp(-T/2): to 1e-7, hundred times the tolerance.

    With 5 mm the rotor swings, with twice the period of the axis; with more it turns.
    """
    found = limit_set(amplitude, 0.5)
    assert (found["kind"], found["stable"]) == ("periodic", True)
    assert found["period"] == pytest.approx(2.0 if amplitude == 0.005 else 1.0, rel=1e-9)
    assert [abs(complex(*m)) for m in found["multipliers"]] == pytest.approx([np.exp(-found["period"] / 2)] * 2, rel=1e-7)
    assert found["decay_time"] == pytest.approx(2.0, rel=1e-7)


@pytest.mark.parametrize(("amplitude", "is_stable"), [(0.0005, True), (0.008, False)])
def test_a_rotor_at_rest_at_angle_zero_is_judged_by_its_multipliers(amplitude: float, is_stable: bool) -> None:
    """On both sides of the border of stability. The multipliers to 1e-6 of SciPy's."""
    found, expected = limit_set(amplitude, 0.0), multipliers_by_scipy(amplitude)
    assert (found["kind"], found["stable"]) == ("periodic", is_stable)
    assert (np.abs(expected).max() < 1) == is_stable
    assert sorted(abs(complex(*m)) for m in found["multipliers"]) == pytest.approx(sorted(abs(expected)), rel=1e-6)
    assert (found["decay_time"] is not None) is is_stable


@pytest.mark.slow
@pytest.mark.parametrize("amplitude", [0.02, 0.03])
def test_a_machine_and_its_equations_by_hand_have_the_same_exponent(amplitude: float) -> None:
    """Intervals of 95 % that two formulations give overlap."""
    states = {"phi": "w", "w": "-w - 100*x0*(2*pi)^2*cos(2*pi*t)*sin(phi)"}
    equations = wucht.UserSystem.from_formulas(states, {"x0": amplitude}, angles=("phi",))
    other = wucht.run(wucht.RunUp(start={"phi": 0.5}), equations).wucht.summary
    found = limit_set(amplitude, 0.5)
    assert (found["kind"], other["outcome"]) == ("chaotic", "chaotic")
    first, second = found["lyapunov_exponent"], other["lyapunov_exponent"]
    assert first["low"] > 0
    assert max(first["low"], second["low"]) < min(first["high"], second["high"])


@pytest.mark.parametrize(("start", "is_stable"), [({"p1": 0.3, "p2": -0.5}, True), ({}, False)])
def test_pendulums_that_are_together_are_on_an_orbit_that_is_unstable(start: dict[str, float], is_stable: bool) -> None:
    """R1 with u = 80: apart they compensate; hanging at the start they move as one, and the report says that any difference
    between them grows by 6.27 /s, which follows from averaging the growth of a difference, not from multipliers: to 1 %."""
    machine = wucht.load_machine("drozdetskaya-2020/r1-u80")
    found = wucht.run(wucht.RunUp(until=60.0, start=start, limit_set=True), machine).wucht.summary["limit_set"]
    assert (found["kind"], found["stable"]) == ("periodic", is_stable)
    assert (found["decay_time"] is not None) == is_stable
    if is_stable:
        assert found["period"] == pytest.approx(2 * np.pi / 200.0, rel=1e-9)
        return
    largest = max(abs(complex(*m)) for m in found["multipliers"])
    assert np.log(largest) / found["period"] == pytest.approx(6.27, rel=0.01)


@pytest.mark.parametrize(
    ("question", "key"),
    [
        ({"model": "slow", "limit_set": True}, "study.limit_set"),
        ({"starts": [{"rotor": 0.1}, {"rotr": 0.1}]}, "study.starts[1]"),
    ],
)
def test_questions_that_have_no_answer_are_refused(question: dict[str, Any], key: str) -> None:
    machine = wucht.load_machine("sperling-vibration/sustained-rotation")
    with pytest.raises(wucht.InputError) as error:
        wucht.run(wucht.RunUp(until=60.0, **question), machine)
    assert error.value.key.startswith(key)


def test_equations_tell_it_always() -> None:
    with pytest.raises(wucht.InputError) as error:
        wucht.run(wucht.RunUp(limit_set=False), wucht.UserSystem.from_formulas({"x": "-x"}))
    assert error.value.key == "study.limit_set"


def test_a_start_on_an_unstable_orbit_is_not_called_chaotic() -> None:
    """In the plane z = 0 the unit circle attracts; z' = z/2 leads away with the multiplier exp(pi), from z = 0 never."""
    states = {"x": "-y + x*(1 - x^2 - y^2)", "y": "x + y*(1 - x^2 - y^2)", "z": "z/2"}
    summary = wucht.run(wucht.RunUp(start={"x": 0.5}), wucht.UserSystem.from_formulas(states)).wucht.summary
    assert (summary["outcome"], summary["stable"]) == ("periodic", False)
    assert max(abs(complex(*m)) for m in summary["multipliers"]) == pytest.approx(np.exp(np.pi), rel=1e-6)


@pytest.mark.parametrize(("amplitude", "turns"), [(0.0182, -1), (0.01825, -2)])
def test_a_rotor_on_both_sides_of_a_period_doubling(amplitude: float, turns: int) -> None:
    """The shorter orbit, which the rotor approaches from alternate sides, is no repetition: a period and a turn, not two.

    Liouville: the multipliers' product is exp(-T).
    """
    states = {"phi": "w", "w": "-w - 100*x0*(2*pi)^2*cos(2*pi*t)*sin(phi)"}
    equations = wucht.UserSystem.from_formulas(states, {"x0": amplitude}, angles=("phi",))
    found = wucht.run(wucht.RunUp(start={"phi": 0.5, "w": -6.0}), equations).wucht.summary
    assert (found["outcome"], found["stable"], found["turns"]) == ("periodic", True, {"phi": turns})
    assert found["period"] == pytest.approx(abs(turns), rel=1e-9)
    (first, _), (second, _) = found["multipliers"]
    assert first * second == pytest.approx(np.exp(turns), rel=1e-6)
    assert (first < -0.9) is (turns == -1)
