"""The study ``start-stop``: energy in closed form, the phases against the studies of each, loads and damage by hand."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp
from tests.refusals import cases_of, check_file

from wucht import CoastDown, LoadSpectrum, Machine, RunUp, StartStop, load_machine, report, run
from wucht.dynamics.run_ups.observed_loads import largest_magnitude, mount_places
from wucht.fatigue.damage import WoehlerLine
from wucht.files.building import machine_from

MOTOR = {
    "kind": "induction", "voltage": 230.0, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 2.0,
    "rotor_resistance": 1.5, "stator_reactance": 3.0, "rotor_reactance": 3.0,
}  # fmt: skip
LINE = {"k": 5.0, "ND": 2e6, "SD": "1.5 mm", "miner": "elementary"}


def fan(eccentricity: float = 1e-3, drive: dict[str, Any] = MOTOR, bearing: float = 0.02, **carrier: Any) -> Machine:
    """A rotor on springs with its resonance at 50 rad/s."""
    rotor = {
        "kind": "rotor", "name": "fan", "mass": 20.0, "eccentricity": eccentricity, "inertia": 0.1, "bearing_damping": bearing,
    }  # fmt: skip
    springs = {"mass": 60.0, "directions": "xy", "stiffness": 2e5, "damping": 400.0} | carrier
    return machine_from({"carrier": springs, "bodies": [rotor], "drive": {"on": "fan", **drive}})


@pytest.fixture(scope="module")
def cycle() -> Any:
    return run(StartStop(until=6.0, woehler=LINE, target_life="20000 h"), fan())


def test_the_energy_of_a_run_up_in_closed_form() -> None:
    """Without load and loss the field gives w_s int T dt = w_s J w; the stator's heat is R1/R2 times the rotor's."""
    summary = run(StartStop(until=1.0), fan(eccentricity=0.0, bearing=0.0)).wucht.summary
    synchronous, speed, inertia = 50 * math.pi, summary["operating_speed"], 0.1
    work, field = inertia * speed**2 / 2, inertia * synchronous * speed
    assert speed == pytest.approx(synchronous, rel=1e-6)
    assert summary["shaft_work"] == pytest.approx(work, rel=1e-9)
    assert summary["energy"] == pytest.approx(field + 2.0 / 1.5 * (field - work), rel=1e-9)


def test_the_energy_of_a_drive_known_by_its_torque_is_its_work() -> None:
    linear = {"kind": "linear", "slope": 0.2, "no_load_speed": 150.0}
    result = run(StartStop(until=3.0), fan(eccentricity=0.0, bearing=0.0, drive=linear))
    speed = 150 * (1 - math.exp(-0.2 * 3 / 0.1))
    assert result.wucht.summary["energy"] == result.wucht.summary["shaft_work"] == pytest.approx(0.1 * speed**2 / 2, rel=1e-9)
    assert any("torque alone is known" in statement for statement in result.wucht.assumed)


def test_the_way_up_is_that_of_a_run_up(cycle: Any) -> None:
    up = run(RunUp(until=6.0), fan())
    summary = cycle.wucht.summary
    assert summary["outcome"] == up.wucht.summary["outcome"]
    assert summary["peak_amplitude_up"] == pytest.approx(up.wucht.summary["peak_amplitude"], rel=1e-5)
    assert summary["operating_speed"] == pytest.approx(up.wucht.summary["final_speed"], rel=1e-9)
    assert summary["operating_amplitude"] == pytest.approx(up.wucht.summary["final_amplitude"], rel=1e-3)
    assert summary["shaft_work"] == pytest.approx(float(up.supplied_work[-1]), rel=1e-9)


def test_the_way_down_is_that_of_a_coast_down(cycle: Any) -> None:
    """Which begins in the steady vibration of the speed that is reached."""
    summary = cycle.wucht.summary
    start = {"fan": {"speed": summary["operating_speed"]}}
    down = run(CoastDown(start=start), fan()).wucht.summary
    assert summary["peak_amplitude_down"] == pytest.approx(down["peak_amplitude"], rel=2e-3)
    assert summary["peak_speed_down"] == pytest.approx(down["peak_speed"], rel=5e-3)
    assert summary["down_time"] == pytest.approx(0.1 / 0.02 * math.log(100), rel=0.01)


@pytest.mark.slow
def test_the_speed_at_the_largest_amplitude_is_the_mean_over_a_turn() -> None:
    """A light, heavily unbalanced rotor is slower and faster within a turn; against an integration of our own, with the turn,
    begun at an eighth of one, in whose middle the largest distance lies."""
    mass, unbalance, inertia, stiffness, damping, slope, no_load = 5.0, 0.05, 0.02, 5e3, 40.0, 0.02, 90.0

    def rates(_: float, s: np.ndarray) -> list[float]:
        x, v, angle, speed = s
        matrix = [[mass, -unbalance * math.sin(angle)], [-unbalance * math.sin(angle), inertia]]
        forces = [unbalance * speed**2 * math.cos(angle) - damping * v - stiffness * x, slope * (no_load - speed)]
        return [v, (a := np.linalg.solve(matrix, forces))[0], speed, a[1]]

    own = solve_ivp(rates, (0, 8), [0, 0, 0, 0], "DOP853", np.linspace(0, 8, 160_001), rtol=1e-11, atol=1e-12)
    time, (x, _, angle, speed) = own.t, own.y
    top = int(np.abs(x).argmax())
    eighth = math.floor(angle[top] / (math.pi / 4))
    begin, end = (np.interp((eighth + k) * math.pi / 4, angle, time) for k in (-3, 5))
    rotor = {"kind": "rotor", "name": "r", "mass": 4.0, "unbalance": unbalance, "inertia": inertia}
    machine = machine_from({
        "carrier": {"mass": 1.0, "directions": "x", "stiffness": stiffness, "damping": damping}, "bodies": [rotor],
        "drive": {"kind": "linear", "on": "r", "slope": slope, "no_load_speed": no_load},
    })  # fmt: skip
    s = run(StartStop(until=8.0), machine).wucht.summary
    assert s["peak_amplitude_up"] == pytest.approx(np.abs(x).max(), rel=1e-5)
    assert s["peak_speed_up"] == pytest.approx(2 * math.pi / (end - begin), rel=1e-5)
    assert s["peak_speed_up"] != pytest.approx(speed[top], rel=0.01), "not that of the instant"


def test_forces_and_travel_are_the_largest_of_both_phases(cycle: Any) -> None:
    """Of a rotor at the centre of the springs the travel is the amplitude; its force on the carrier |c - m w^2 + i b w| r."""
    summary = cycle.wucht.summary
    assert summary["mount_travel"] == {"carrier": pytest.approx(summary["peak_amplitude_down"], rel=1e-4)}
    up = run(RunUp(until=6.0), fan())
    largest = largest_magnitude(up.time.values, list(up.bearing_force.values))
    assert summary["bearing_forces"]["fan"] == pytest.approx(largest, rel=2e-3)  # the force grows with the speed squared
    speed, radius = summary["operating_speed"], summary["operating_amplitude"]
    late = up.time.values > 5.0
    steady = largest_magnitude(up.time.values[late], list(up.bearing_force.values[:, late]))
    assert steady == pytest.approx(abs(2e5 - 60 * speed**2 + 400j * speed) * radius, rel=2e-3)


@pytest.mark.slow
def test_the_travel_of_mounts_off_the_centre() -> None:
    screen = load_machine("practice/screen")
    assert mount_places(screen) == {"mount 1": (-0.9, -0.2), "mount 2": (0.9, -0.2)}
    start = {"e1": "-90 deg", "e2": "-90 deg"}
    summary = run(StartStop(until=1.0, start=start), screen).wucht.summary
    up = run(RunUp(until=1.0, start=start), screen)
    x, y, chi = up.displacement.values - up.displacement.values[:, :1]
    travel = np.hypot(x + 0.2 * chi, y + 0.9 * chi).max()
    assert summary["mount_travel"]["mount 2"] >= travel * (1 - 1e-6)
    assert set(summary["bearing_forces"]) == {"e1", "e2"}


def test_the_damage_of_the_way_up_is_that_of_a_load_spectrum(cycle: Any) -> None:
    """The course of the damage at the switch-off, half cycles counted."""
    spectrum = run(LoadSpectrum(until=6.0, signal="displacement", woehler=LINE), fan()).wucht.summary
    so_far = np.interp(6.0, cycle.damage_time, cycle.damage_course)
    assert so_far == pytest.approx(spectrum["damage"], rel=0.02)


def test_the_damage_of_a_cycle_is_miners_sum(cycle: Any) -> None:
    """The largest range, from peak to peak at the resonance on the way down, does the most; a cycle ends as it began."""
    summary = cycle.wucht.summary
    line = WoehlerLine(5.0, 2e6, 1.5e-3, 5.0)
    assert summary["largest_range"] == pytest.approx(2 * summary["peak_amplitude_down"], rel=0.01)
    assert summary["damage"] > float(line.damage_of_a_cycle([summary["largest_range"] / 2])[0])
    assert summary["damage"] == pytest.approx(float(cycle.damage_course[-1]), rel=0.01)
    assert summary["cycles"] * summary["damage"] == pytest.approx(1.0)


def test_the_damage_of_operation_is_that_of_its_amplitude(cycle: Any) -> None:
    summary = cycle.wucht.summary
    amplitude, speed = summary["operating_amplitude"], summary["operating_speed"]
    a_second = speed / (2 * math.pi) * (amplitude / 1.5e-3) ** 5 / 2e6
    assert summary["operation_damage"] == pytest.approx(a_second, rel=0.05)


def test_the_cycles_that_a_target_life_allows(cycle: Any) -> None:
    """With them, and with steady operation for the rest of the target life, Miner's sum is 1."""
    s = cycle.wucht.summary
    rest = s["target_life"] - s["allowed_cycles"] * s["switch_off_time"]
    total = s["allowed_cycles"] * s["damage"] + rest * s["operation_damage"]
    assert s["target_life"] == 20000 * 3600
    assert total == pytest.approx(1.0, rel=1e-12)


def test_operation_alone_may_use_up_the_life(cycle: Any) -> None:
    rate = cycle.wucht.summary["operation_damage"]
    for share, allows in ((0.999, True), (1.001, False)):
        s = run(StartStop(until=6.0, woehler=LINE, target_life=share / rate), fan()).wucht.summary
        assert (s["allowed_cycles"] > 0) is allows


def test_a_cycle_that_damages_no_more_than_operation_may_be_repeated_at_will() -> None:
    """A stiff carrier, whose resonance is never reached: what a start spares is more than a stop adds, or less."""
    for bearing, number in ((0.5, "any number of"), (0.02, "")):
        result = run(StartStop(until=3.0, woehler=LINE, target_life=3600), fan(bearing=bearing, stiffness=2e7))
        s = result.wucht.summary
        assert (s["damage"] <= s["operation_damage"] * s["switch_off_time"]) is bool(number)
        assert (s["allowed_cycles"] is None) is bool(number)
        assert f"  target life  1 h of operation allow {number}" in report(result)[-2]
    in_seconds = report(run(StartStop(until=3.0, woehler=LINE, target_life=3599), fan()))
    assert any(line.startswith("  target life  3599 s of operation allow") for line in in_seconds)


def test_two_rotors_that_turn_against_each_other() -> None:
    """Speeds are given in magnitude, forces and drives by name."""
    rotors = [{"kind": "rotor", "name": n, "mass": 5.0, "eccentricity": 1e-3, "inertia": 0.05} for n in ("a", "b")]
    drives = [{"kind": "linear", "on": n, "slope": 0.2, "no_load_speed": w} for n, w in (("a", -150.0), ("b", 150.0))]
    carrier = {"mass": 60.0, "directions": "x", "stiffness": 2e5, "damping": 400.0}
    result = run(StartStop(until=3.0), machine_from({"carrier": carrier, "bodies": rotors, "drives": drives}))
    s = result.wucht.summary
    assert result.rotor_speed.values[:, result.time.values <= 3.0][:, -1] == pytest.approx([-150.0, 150.0], rel=0.02)
    assert min(s["peak_speed_up"], s["peak_speed_down"]) > 0
    assert set(s["bearing_forces"]) == {"a", "b"}
    assert any("shaft of a and b, whose torque alone is known" in statement for statement in result.wucht.assumed)


@pytest.mark.slow
def test_schedules_end_at_the_switch_off(cycle: Any) -> None:
    rotor = {"kind": "rotor", "name": "fan", "mass": 20.0, "eccentricity": 1e-3, "inertia": 0.1}
    drive = {"kind": "linear", "on": "fan", "slope": 0.2, "no_load_speed": 150.0}
    springs = {"mass": 60.0, "directions": "xy", "stiffness": 2e5, "damping": 400.0}
    schedule = {"parameter": "carrier.stiffness", "points": [[0.0, 2e5], [1.0, 3e5]]}
    machine = machine_from({"carrier": springs, "bodies": [rotor], "drive": drive, "schedules": [schedule]})
    result = run(StartStop(until=0.5), machine)
    assert any("schedules end at the switch-off" in w for w in result.wucht.warnings)
    assert not any("schedules" in w for w in cycle.wucht.warnings)


def test_the_largest_magnitude_lies_between_samples() -> None:
    """Of a vector on an ellipse, with 48 samples a turn; uneven steps as well."""
    angle = np.cumsum(np.append(0.03, np.tile([0.11, 0.15], 60)))
    exact = 2.0
    assert largest_magnitude(angle, [2 * np.cos(angle), 0.3 * np.sin(angle)]) == pytest.approx(exact, rel=2e-4)
    assert largest_magnitude(angle[:1], [np.array([3.0]), np.array([4.0])]) == 5.0


def test_a_run_up_that_is_too_short_has_no_target_life() -> None:
    result = run(StartStop(until=0.05, woehler=LINE, target_life="1 h"), fan())
    assert result.wucht.summary["operation_damage"] is None
    assert result.wucht.summary["allowed_cycles"] is None
    assert any("run longer" in warning for warning in result.wucht.warnings)


def test_until_it_has_settled() -> None:
    summary = run(StartStop(), fan()).wucht.summary
    assert summary["outcome"] == "passed"
    assert summary["switch_off_time"] > summary["settling_time"]
    assert "damage" in summary
    assert summary["damage"] is None


DRIVE = '[machine.drive]\nkind = "linear"\nslope = 0.2\nno_load_speed = 150\n'
FILE = """
[machine.carrier]
mass = "60 kg"
stiffness = "2e5 N/m"
damping = "400 N s/m"
[[machine.bodies]]
kind = "rotor"
name = "fan"
mass = "20 kg"
eccentricity = "1 mm"
inertia = "0.1 kg m^2"
DRIVE[study]
kind = "start-stop"
until = "0.2 s"
""".replace("DRIVE", DRIVE)
CHANGES = {
    'until = "0.2 s"': [
        "until = 0", 'until = "1 kg"', 'target_life = "3 h"', 'direction = "x"', 'signal = "acceleration"',
        'signal = "stress"', 'woehler = { k = 5, ND = 1e6, SD = "3 N" }', 'woehler = { k = 0, ND = 1e6, SD = "3 mm" }',
        'woehler = { k = 5, ND = 1e6, SD = "-1 mm" }',
        'woehler = { k = 5, ND = 1e6, SD = "0 mm" }',
        'direction = "r"\nwoehler = { k = 5, ND = 1e6, SD = "3 mm" }', "turns = 3",
    ],
    DRIVE: [""],
    'damping = "400 N s/m"': [
        'damping = "400 N s/m"\nmotion = { direction = "x", amplitude = "1 mm", frequency = "6 rad/s" }',
    ],
}  # fmt: skip


@pytest.mark.parametrize(("old", "new"), cases_of(CHANGES))
def test_bad_input(here: Path, old: str, new: str) -> None:
    check_file("start-stop", FILE, {old: new})
