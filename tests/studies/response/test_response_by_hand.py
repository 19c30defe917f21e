"""Lags, maxima and ranges of responses, of vibrations that are made by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.steady_phases import Piece
from wucht.results.quantities import Quantity
from wucht.studies.response import computation
from wucht.studies.response.computation import Findings, Maximum, Peaks, ResponseCurve, collect_maxima, phase_lags
from wucht.studies.response.dataset import _curve, _sentence

DEG = math.pi / 180
W = np.array([10.0, 20.0, 30.0])


def lags(z: Any, force: Any, labels: tuple[str, ...], main: float = 0.0, supported: dict[str, str] | None = None) -> Any:
    """In degrees, of displacements z (m, N) by forces (m, N); the main rotor, the second body, is at the angle ``main``."""
    bodies = [SimpleNamespace(name="other"), SimpleNamespace(name="drum")]
    parts = [SimpleNamespace(supported_directions=dict), SimpleNamespace(supported_directions=lambda: supported or {})]
    machine: Any = SimpleNamespace(bodies=bodies, rotor=bodies[1], free_labels=labels, parts=parts)
    of_labels = np.array(force, complex).T
    vibration: Any = SimpleNamespace(force=lambda w: of_labels, phases=lambda w: (np.array([99.0, main]), None))
    return phase_lags(machine, vibration, W, np.array(z, complex)) / DEG


def turned(degrees: float, size: float = 1.0) -> complex:
    return complex(size * np.exp(1j * degrees * DEG))


def test_a_displacement_lags_the_force_in_its_direction() -> None:
    force = [[turned(30)] * 3, [turned(-60, 2.0)] * 3]
    z = [[turned(30 - 10), turned(30 - 90), turned(30 - 170)], [turned(-60 - 190), turned(-60), turned(-60 + 10)]]
    assert lags(z, force, ("x", "y")) == pytest.approx(np.array([[10, 90, 170], [190, 0, 350]]), abs=1e-9)


def test_without_a_force_the_reference_is_the_angle_of_the_main_rotor() -> None:
    assert lags([[turned(25)] * 3], [[0.0, 0.0, turned(40)]], ("x",), 45 * DEG)[0] == pytest.approx([20, 20, 15])


def test_a_foundation_lags_the_force_on_what_it_carries() -> None:
    force = [[turned(50)] * 3, [0.0] * 3]
    z = [[turned(40)] * 3, [turned(20)] * 3]
    assert lags(z, force, ("x", "fx"), 0.0, {"fx": "x"})[:, 0] == pytest.approx([10, 30])
    assert lags([[turned(-20)] * 3], [[0.0] * 3], ("fx",), 0.0, {"fx": "x"})[0] == pytest.approx([20] * 3), "x is fixed"


def test_rounding_below_a_turn_is_no_lag_and_without_motion_there_is_none() -> None:
    z = [[turned(1e-10)] * 3, [1e-10] * 3, [2e-9] * 3]
    lag = lags(z, [[1.0] * 3] * 3, ("x", "y", "r"))
    assert lag[0].tolist() == [0.0] * 3 and np.isnan(lag[1]).all() and lag[2].tolist() == [0.0] * 3


@pytest.mark.parametrize(
    ("natural", "free", "expected"),
    [
        ({"x": 50.0, "y": 200.0}, 100.0, (4.0, 600.0)),
        ({"x": 50.0, "y": 200.0}, -500.0, (4.0, 750.0)),  # clockwise
        ({"x": 5.0, "y": 200.0}, None, (1.5, 600.0)),
        ({"x": 0.0}, 100.0, (2.0, 300.0)),
        ({}, None, (0.02, 3.0)),
    ],
)
def test_the_default_range_holds_all_resonances_and_the_speed_of_the_drive(
    natural: dict[str, float], free: float | None, expected: tuple[float, float], monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr(computation, "natural_frequencies", lambda machine: natural)
    monkeypatch.setattr(computation, "free_speed", lambda machine, rotor: free)
    assert computation._speed_range(SimpleNamespace(rotor=None)) == pytest.approx(expected)  # type: ignore[arg-type]


class Curve:
    """A vibration whose amplitude is ``size`` times the speed and whose torque is twice that; infinite at ``undamped``."""

    def __init__(self, size: float, excited: bool = True) -> None:
        self.size, self.excited = size, excited

    def amplitude(self, w: np.ndarray) -> tuple[np.ndarray, None]:
        return self.size * w, None

    def torque(self, w: np.ndarray) -> tuple[np.ndarray, None]:
        return 2 * self.size * w, None

    def grows_unbounded(self, of: Any, speed: float) -> bool:
        return self.excited


def collected(
    curves: list[Curve], peaks: list[Peaks], stable: list[list[int]], monkeypatch: pytest.MonkeyPatch, free: float | None = 15.0
) -> Any:
    """stable: of each branch at 10, 20 and 30 rad/s; at the speed between it is as at the speed before."""

    def branch(k: int) -> Any:
        return SimpleNamespace(
            labels=lambda w: np.full(len(w), f"b{k}"),
            stable=lambda w: np.array(stable[k], bool)[np.searchsorted(W, w, side="right") - 1],
            overlapping=False,
        )

    monkeypatch.setattr(computation, "free_speed", lambda machine, rotor: free)
    monkeypatch.setattr(computation, "steady_throw", lambda machine, vibration, speed: (vibration, speed))
    steady = SimpleNamespace(
        machine=SimpleNamespace(rotor=None), curves=curves, branches=[branch(k) for k in range(len(curves))]
    )
    there = [ResponseCurve(c.size * W, 2 * c.size * W, np.array(s, bool)) for c, s in zip(curves, stable, strict=True)]
    plan: Any = SimpleNamespace(steady=steady)
    return collect_maxima(plan, Findings(W, tuple(peaks)), there)


def none() -> Peaks:
    return Peaks(np.empty(0), np.empty(0), ())


def test_the_largest_of_all_curves_is_that_where_bodies_are_stable(monkeypatch: pytest.MonkeyPatch) -> None:
    small, large = Curve(1.0), Curve(5.0)
    some = Peaks(np.array([20.0]), np.array([10.0, 30.0]), ())
    made = collected([small, large], [some, none()], [[1, 1, 0], [1, 0, 0]], monkeypatch)
    assert made.amplitudes == [Maximum(20.0, 20.0, "b0", True)]
    assert made.torques == [Maximum(10.0, 20.0, "b0", True), Maximum(30.0, 60.0, "b0", False)]
    assert (made.largest, made.hardest) == (Maximum(10.0, 50.0), Maximum(10.0, 100.0))
    assert made.at_free == [Maximum(15.0, 15.0, "b0", True), Maximum(15.0, 75.0, "b1", True)]
    assert made.throw == (large, 15.0), "of the configuration with the largest amplitude"
    clockwise = collected([small, large], [some, none()], [[1, 1, 0], [0, 0, 0]], monkeypatch, -15.0)
    assert clockwise.at_free == [Maximum(15.0, 15.0, "b0", True)] and clockwise.throw == (small, 15.0)
    assert clockwise.largest == Maximum(20.0, 20.0)
    nowhere = collected([small], [none()], [[0, 0, 0]], monkeypatch, None)
    assert (nowhere.largest, nowhere.hardest, nowhere.at_free, nowhere.throw) == (None, None, [], None)


def test_an_undamped_resonance_is_infinite_only_where_it_moves_the_axis(monkeypatch: pytest.MonkeyPatch) -> None:
    at = Peaks(np.array([20.0]), np.empty(0), (20.0,))
    made = collected([Curve(1.0)], [at], [[1, 1, 1]], monkeypatch, 20.0)
    assert made.amplitudes == [Maximum(20.0, math.inf, "b0", True)] == made.at_free
    assert made.largest == Maximum(20.0, math.inf, "b0", True) and made.throw is None
    idle = collected([Curve(1.0, excited=False)], [at], [[1, 1, 1]], monkeypatch, 20.0)
    assert idle.amplitudes == [Maximum(20.0, 20.0, "b0", True)] and idle.largest == Maximum(30.0, 30.0)


@pytest.mark.parametrize(("free", "relation"), [(10.0, "below"), (60.0, "between"), (100.0, "above")])
def test_a_drive_of_either_sense_runs_below_between_or_above_the_critical_speeds(free: float, relation: str) -> None:
    for speed in (free, -free):
        sentence = f"2 critical speeds in the range; the drive runs {relation} them"
        assert _sentence(True, [50.0, 80.0], speed, "") == sentence


def test_maxima_are_searched_where_bodies_of_the_branch_are_stable_without_overlapping() -> None:
    values = [Quantity(n, k + W, n, "", "speed") for k, n in enumerate(("amplitude", "minor_axis", "vibration_torque"))]

    def piece(branch: int, stable: list[int], overlapping: bool = False) -> Piece:
        return Piece(branch, "", np.ones(3, bool), np.array(stable, bool), overlapping)

    pieces = [piece(0, [1, 0, 0]), piece(0, [0, 1, 0]), piece(0, [0, 0, 1], overlapping=True), piece(1, [0, 0, 1])]
    for k, stable in ((0, [1, 1, 0]), (1, [0, 0, 1]), (2, [0, 0, 0])):
        curve = _curve(values, k, pieces)
        assert curve.amplitude.tolist() == W.tolist() and curve.torque.tolist() == (W + 2).tolist()
        assert curve.stable.tolist() == stable
    assert _curve(values, 0, []).stable.all(), "held bodies"
