"""001, sections 2.2 and 2.3: bands of existence (21) and from rest, phases (22), thresholds (25), lock limits of exciters."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from wucht import Entrainment, run
from wucht.dynamics.entrainment.entrainment_case import swept_parameter
from wucht.dynamics.entrainment.entrainment_equations import EntrainmentEquations
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of

FREQUENCY = 2 * math.pi
UNBALANCE, SLOPE, INERTIA, AMPLITUDE = 1e-3, 1e-5, 1e-5, 1e-3  # Bild 2, SI
TORQUE = UNBALANCE * FREQUENCY**2 * AMPLITUDE / 2  # the largest vibration torque, (20)


def answered(machine: Machine, **table: Any) -> tuple[xr.Dataset, dict[str, Any]]:
    result = run(Entrainment.from_table(table), machine)
    assert result.attrs["finished"], result.attrs["failure"]
    return result, result.wucht.summary


def bild_2(**values: float) -> Machine:
    return load_machine("sperling-vibration/figure-2a", {k.replace("__", "."): v for k, v in values.items()})


@pytest.fixture(scope="module")
def own_answer() -> tuple[xr.Dataset, dict[str, Any]]:
    return answered(bild_2())


@pytest.mark.slow
def test_the_band_of_existence_is_that_of_equation_21(own_answer: tuple[xr.Dataset, dict[str, Any]]) -> None:
    _, s = own_answer
    assert s["along"] == "drive.no_load_speed"
    width = TORQUE / SLOPE
    assert s["existence_band"] == pytest.approx([FREQUENCY - width, FREQUENCY + width], rel=1e-11)
    assert s["existence_band"] == pytest.approx([4.30926, 8.25711], abs=5e-6)
    assert s["existence_edges"] == ["fold", "fold"]


@pytest.mark.slow
def test_the_full_equations_have_nearly_that_band(own_answer: tuple[xr.Dataset, dict[str, Any]]) -> None:
    """The averaged equations leave out terms of the order of the fluctuation (26), squared: here 0.02 rad, squared."""
    _, s = own_answer
    assert s["existence_band_full"] == pytest.approx(s["existence_band"], rel=4e-4)
    assert s["existence_band_full"] != pytest.approx(s["existence_band"], rel=1e-5)


@pytest.mark.slow
def test_the_phases_of_equation_22_and_their_stability_24(own_answer: tuple[xr.Dataset, dict[str, Any]]) -> None:
    dataset, _ = own_answer
    phase, partial = dataset.phase.sel(body="rotor").values, dataset.value.values
    assert np.abs(TORQUE * np.sin(phase) - SLOPE * (partial - FREQUENCY)).max() < 1e-9 * TORQUE
    stable = dataset.stable.values.astype(bool)
    regular = np.abs(np.cos(phase)) > 1e-6  # at the folds themselves the cosine is zero
    assert (stable == (np.cos(phase) > 0))[regular].all() and regular.sum() == len(phase) - 2
    assert stable.any()
    assert not stable.all()


def test_phase_and_mean_speed_of_bild_2a(own_answer: tuple[xr.Dataset, dict[str, Any]]) -> None:
    _, s = own_answer
    assert s["outcome"] == "entrained"
    assert s["mean_speed"] == pytest.approx(6.283185, abs=5e-7)
    assert s["phase"] == pytest.approx(-0.40856, abs=5e-6)
    assert s["phase_slow"] == pytest.approx(-0.40799, abs=5e-6)
    assert s["phase_slow"] == pytest.approx(math.asin(SLOPE * (5.5 - FREQUENCY) / TORQUE), abs=1e-9)
    assert s["window"][1] > s["window"][0] > 0
    assert s["stable"]
    # a focus: both multipliers have the modulus that Liouville's formula gives their product, the square root of it
    assert s["multiplier"] == pytest.approx(math.exp(-SLOPE / INERTIA / 2), rel=1e-9)


def test_the_band_from_rest_is_narrower_at_both_ends(own_answer: tuple[xr.Dataset, dict[str, Any]]) -> None:
    _, s = own_answer
    low, high = s["band_from_rest"]
    assert low == pytest.approx(4.7177, abs=5e-5)
    assert high == pytest.approx(7.854, abs=5e-4)
    assert s["existence_band"][0] < low
    assert high < s["existence_band"][1]


@pytest.mark.parametrize(("partial", "entrained"), [(4.7175, False), (4.7180, True), (7.8538, True), (7.8546, False)], ids=str)
def test_runs_by_scipy_at_the_edges(partial: float, entrained: bool) -> None:
    """Equation (12) written by hand: what becomes of a rotor at rest on both sides of the edges."""

    def rate(t: float, y: np.ndarray) -> list[float]:
        shaking = UNBALANCE * -AMPLITUDE * FREQUENCY**2 * math.cos(FREQUENCY * t)
        return [y[1], (SLOPE * (partial - y[1]) + shaking * math.sin(y[0])) / INERTIA]

    run = solve_ivp(rate, (0, 120), [0.0, 0.0], "DOP853", t_eval=[80.0, 120.0], rtol=1e-10, atol=1e-10)
    mean = (run.y[0, 1] - run.y[0, 0]) / 40
    assert (abs(mean / FREQUENCY - 1) < 1e-3) == entrained


def test_bild_2b_is_not_entrained() -> None:
    dataset, s = answered(load_machine("sperling-vibration/figure-2b"), points=9, resolution=1e-2)
    assert s["outcome"] == "not-entrained"
    assert s["mean_speed"] == pytest.approx(4.152, abs=5e-4)
    assert s["phase"] is None
    assert s["phase_slow"] is None
    assert s["existence_band"] == pytest.approx([4.30926, 8.25711], abs=5e-6)
    assert s["threshold_amplitude"] == pytest.approx(SLOPE * (FREQUENCY - 4) * 2 / (UNBALANCE * FREQUENCY**2), rel=1e-9)
    assert not dataset.run_taken.values[dataset.run_value.values == 4.0].any()


@pytest.mark.slow
def test_the_threshold_of_sustained_rotation() -> None:
    """Equation (25): x_0 > 2 k_1/(m_1 eps_1 Omega) = 3.1831 mm; the drive is off, k_1 is the bearing's damping."""
    machine = load_machine("sperling-vibration/sustained-rotation")
    _, s = answered(machine, start={"rotor": {"speed": "1 Hz"}}, points=9, resolution="1e-5 m")
    assert s["along"] == "carrier.motion.amplitude"
    assert s["threshold_amplitude"] == pytest.approx(3.1831e-3, abs=5e-8)
    assert s["threshold_amplitude"] == pytest.approx(2 * SLOPE / (UNBALANCE * FREQUENCY), rel=1e-11)
    assert s["existence_band"] == [s["threshold_amplitude"], None]
    assert s["band_from_rest"][0] > s["threshold_amplitude"]
    assert s["phase_slow"] == pytest.approx(-math.asin(3.1831 / 5), abs=1e-5)


@pytest.mark.slow
def test_rotation_against_the_drive() -> None:
    """The motor would turn the other way: the torque of vibration must carry k_1 (Omega + 1 1/s)."""
    machine = load_machine("sperling-vibration/against-the-drive")
    _, s = answered(machine, start={"rotor": {"speed": "1 Hz"}}, points=9, resolution="1e-2 rad/s")
    assert s["outcome"] == "entrained"
    assert s["threshold_amplitude"] == pytest.approx(2 * SLOPE * (FREQUENCY + 1) / (UNBALANCE * FREQUENCY**2), rel=1e-9)
    width = 5 * TORQUE / SLOPE
    assert s["existence_band"] == pytest.approx([FREQUENCY - width, FREQUENCY + width], rel=1e-11)
    low, high = s["band_from_rest"]
    assert s["existence_band"][0] < low < -1 < high < s["existence_band"][1]  # beyond, it turns with its drive at -Omega


@pytest.mark.slow
def test_a_motor_of_constant_torque() -> None:
    """(15) with L in place of k_1 Omega_1: entrained for |L - k_1 Omega| < f_1 x_0/2, k_1 the bearing's damping."""
    rotor = {"kind": "rotor", "name": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": INERTIA, "bearing_damping": SLOPE}
    motion = {"direction": "x", "amplitude": AMPLITUDE, "frequency": FREQUENCY}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "motion": motion}, "bodies": [rotor],
        "drive": {"on": "rotor", "kind": "constant-torque", "torque": 6e-5},
    })  # fmt: skip
    _, s = answered(machine, along="drive.torque", range=[3e-5, 1e-4], points=9, resolution=1e-7)
    centre = SLOPE * FREQUENCY
    assert s["existence_band"] == pytest.approx([centre - TORQUE, centre + TORQUE], rel=1e-11)
    assert s["band_from_rest"] == pytest.approx([4.7177e-5, 7.854e-5], abs=2e-7)  # the same equation as Bild 2


def test_exciters_that_turn_against_each_other() -> None:
    """practice/screen: the sum of the angles is 90.4 degrees, as its notes report; the other phase is not stable."""
    machine = load_machine("practice/screen")
    senses = {b.name: sense_of(machine, b) for b in machine.bodies}
    averaged = EntrainmentEquations(machine, swept_parameter(machine, "drives.e2.voltage"), senses, (200, 260))
    equilibria = averaged.equilibria(230.0)
    (stable,) = (x for x in equilibria if averaged.is_stable(x, 230.0))
    assert -math.degrees(stable[0]) == pytest.approx(90.4, abs=0.05)
    assert len(equilibria) == 2


K_1, K_2, MASS, E_UNBALANCE = 3e-5, 6e-5, 1.0, 1e-3


def exciters(stiffness: float, first: float, second: float) -> Machine:
    """Two exciters on an almost undamped spring: section 2.3."""
    rotor = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
    drive = {"kind": "linear"}
    return machine_from({
        "carrier": {"mass": 0.8, "directions": "x", "stiffness": stiffness, "damping": 1e-7},
        "bodies": [rotor | {"name": "e1"}, rotor | {"name": "e2"}],
        "drives": [
            drive | {"on": "e1", "slope": K_1, "no_load_speed": first},
            drive | {"on": "e2", "slope": K_2, "no_load_speed": second},
        ],
    })  # fmt: skip


START = {"e1": {"speed": 12.0}, "e2": {"angle": 1.0, "speed": 12.0}}
SOFT, STIFF = (2 * math.pi) ** 2, (6 * math.pi) ** 2


@pytest.mark.parametrize(("stiffness", "phase"), [(STIFF, 0.0), (SOFT, math.pi)], ids=["below resonance", "above"])
def test_phases_37_and_their_stability_40(stiffness: float, phase: float) -> None:
    """Below the natural frequency of the carrier exciters swing together, above it against each other."""
    machine = exciters(stiffness, 12.0, 12.0)
    swept = swept_parameter(machine, "detuning")
    averaged = EntrainmentEquations(machine, swept, {b.name: sense_of(machine, b) for b in machine.bodies}, (-9.0, 9.0))
    synchronous = [x for x in averaged.equilibria(0.0) if x[1] == pytest.approx(12.0, rel=1e-6)]
    assert sorted(abs(math.sin(x[0])) for x in synchronous) == pytest.approx([0.0, 0.0], abs=1e-6)
    assert {round(math.cos(x[0])): averaged.is_stable(x, 0.0) for x in synchronous} == {1: phase == 0.0, -1: phase != 0.0}


def test_synchronous_speed_35_and_the_lock_limit() -> None:
    """(33) with V_1 = -V_2: k_1 k_2/(k_1 + k_2) |Omega_1 - Omega_2| < |A_xx| f_1 f_2/2."""
    machine = exciters(STIFF, 12.0, 12.4)
    dataset, s = answered(machine, start=START, points=5, resolution=1e-1, range=[-3.0, 3.0])
    assert s["along"] == "detuning"
    assert s["value"] == pytest.approx(0.4)
    # The mean of the no-load speeds stays; (35) weights them, so that the synchronous speed moves with the detuning.
    row = dataset.branch == s["branch"]
    speed, detuning = dataset.speed.values[row], dataset.value.values[row]
    omega = (K_1 * (12.2 - detuning / 2) + K_2 * (12.2 + detuning / 2)) / (K_1 + K_2)
    assert np.abs(speed - omega).max() < 1e-6 * 12
    phase = dataset.phase.sel(body="e2").values[row]
    force = E_UNBALANCE * omega**2
    torque = force**2 / 2 / (MASS * (STIFF / MASS - omega**2))
    needed = K_1 * K_2 / (K_1 + K_2) * detuning
    assert np.abs(torque * np.sin(phase) - needed).max() < 1e-6 * np.abs(torque).max()


@pytest.mark.slow
@pytest.mark.parametrize("name", ["self-synchronisation-stiff-unequal", "self-synchronisation-soft-unequal"])
def test_full_orbits_follow_the_averaged_phases(name: str) -> None:
    """Phase against detuning: periodic motions of the full equations lie beside the stable branch of the averaged ones."""
    start = {"e1": {"speed": "12 rad/s"}, "e2": {"angle": "1 rad", "speed": "12 rad/s"}}
    dataset, s = answered(load_machine(f"sperling-vibration/{name}"), start=start, points=9, resolution=1e-2)
    own = ((dataset.branch == s["branch"]) & (dataset.stable == 1)).values
    order = np.argsort(dataset.value.values[own])
    low, high = s["existence_band"]
    inside = ((dataset.orbit_value > 0.9 * low) & (dataset.orbit_value < 0.9 * high)).values
    assert inside.sum() > 8
    slow = np.interp(
        dataset.orbit_value.values[inside], dataset.value.values[own][order],
        np.unwrap(dataset.phase.sel(body="e2").values[own][order]),
    )  # fmt: skip
    apart = dataset.orbit_phase.sel(body="e2").values[inside] - slow
    apart = np.abs(np.remainder(apart + math.pi, 2 * math.pi) - math.pi)
    assert 0 < apart.max() < 0.02
    assert dataset.orbit_stable.values.all()
    assert s["existence_band_full"] == pytest.approx(s["existence_band"], rel=0.01)
    assert s["phase"] == pytest.approx(s["phase_slow"], abs=0.01)


@pytest.mark.slow
def test_the_edges_do_not_depend_on_how_finely_it_is_looked() -> None:
    """The lower edge is tangled over 4e-5 rad/s: between 4.71772 and 4.71776 runs with a rest that differs by 1e-12 part."""
    _, coarse = answered(bild_2(), points=11, resolution=1e-6)
    _, fine = answered(bild_2(), points=201, resolution=1e-7)
    assert coarse["band_from_rest"][0] == pytest.approx(fine["band_from_rest"][0], abs=5e-5)
    assert coarse["band_from_rest"][1] == pytest.approx(fine["band_from_rest"][1], abs=2e-6)
    assert all(4.7177 < low <= high < 4.7178 for low, high in fine["islands"])
