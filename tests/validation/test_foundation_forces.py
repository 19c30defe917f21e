"""Forces into the foundation against hand formulas, and the closed form of the response against the run.

J. P. Den Hartog, Mechanical Vibrations, section 2.12: an undamped mount passes the share 1/(r^2 - 1) of the exciting force, r
being the speed over the natural frequency; a damped one sqrt((1 + (2 z r)^2)/((1 - r^2)^2 + (2 z r)^2)).
"""

from __future__ import annotations

import math
from typing import Any

import pytest

from wucht import CoastDown, Response, RunUp, StartStop, load_machine, run, run_file
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

MASS, UNBALANCE, FREQUENCY, G = 100.0, 0.05, 20.0, 9.81
SCREEN = "practice/screen"


def block(damping_ratio: float, speed: float, directions: str = "y", gravity: float = G) -> Machine:
    rotor = {"kind": "rotor", "name": "fan", "mass": 10.0, "unbalance": UNBALANCE, "inertia": 0.1}
    carrier = {"directions": directions, "mass": MASS - 10.0, "frequency": FREQUENCY, "damping_ratio": damping_ratio}
    carrier |= {"gravity": gravity}
    drive = {"on": "fan", "kind": "linear", "slope": 10.0, "no_load_speed": speed}
    return machine_from({"carrier": carrier, "bodies": [rotor], "drives": [drive]})


@pytest.mark.parametrize("damping_ratio", [0.0, 0.05, 0.3])
@pytest.mark.parametrize("speed", [24.0, 30.0, 100.0])  # below sqrt(2) times the frequency more than the force passes
def test_isolation_of_one_mount(damping_ratio: float, speed: float) -> None:
    summary = run(Response(), block(damping_ratio, speed)).wucht.summary
    ratio = abs(summary["operating_speed"]) / FREQUENCY
    damped = (2 * damping_ratio * ratio) ** 2
    share = math.sqrt((1 + damped) / ((1 - ratio**2) ** 2 + damped))
    assert summary["transmissibility"] == pytest.approx(share, rel=1e-9)
    assert (share < 1) is (ratio > math.sqrt(2))
    exciting = UNBALANCE * summary["operating_speed"] ** 2
    assert summary["foundation_force_amplitudes"] == {"carrier": {"y": pytest.approx(share * exciting, rel=1e-9)}}
    if not damping_ratio:
        assert share == pytest.approx(1 / (ratio**2 - 1))
        force = MASS * FREQUENCY**2 * summary["operating_amplitude"]  # k x
        assert summary["foundation_force_amplitudes"]["carrier"]["y"] == pytest.approx(force, rel=1e-9)


def test_static_deflection_is_that_of_the_natural_frequency() -> None:
    """d = g/w0^2, and all the weight is on the spring."""
    summary = run(Response(), block(0.1, 60.0, "xy")).wucht.summary
    assert summary["static_deflection"] == {"carrier": pytest.approx(G / FREQUENCY**2)}
    assert summary["static_foundation_forces"] == {"carrier": {"x": 0.0, "y": pytest.approx(-MASS * G)}}


@pytest.fixture(scope="module")
def of_run() -> Any:
    start = {"e1": -math.pi / 2, "e2": -math.pi / 2}
    return run(RunUp(until=10.0, start=start), load_machine(SCREEN)).wucht.summary


def test_mounts_bear_the_whole_weight_and_its_moment(of_run: Any) -> None:
    """400 kg in all: two exciters of 20 kg, and mounts at -0.9 m and 0.9 m."""
    left, right = of_run["static_foundation_forces"]["mount 1"], of_run["static_foundation_forces"]["mount 2"]
    assert left["y"] + right["y"] == pytest.approx(-400.0 * G, rel=1e-9)
    sinking = of_run["static_deflection"]
    assert [-110e3 * sinking["mount 1"], -110e3 * sinking["mount 2"]] == pytest.approx([left["y"], right["y"]], rel=1e-9)
    turn = (sinking["mount 1"] - sinking["mount 2"]) / 1.8  # rad, with which the springs in x give way too
    moment = 0.9 * (right["y"] - left["y"]) + 0.2 * (left["x"] + right["x"])
    assert moment == pytest.approx(-20.0 * G * (0.5 + 0.2), rel=1e-9)
    assert turn < 0
    assert left["x"] + right["x"] == pytest.approx(0.0, abs=1e-9)


def test_the_run_ends_with_the_forces_of_the_closed_form(of_run: Any) -> None:
    steady = run(Response(), load_machine(SCREEN)).wucht.summary
    assert of_run["transmissibility"] == pytest.approx(steady["transmissibility"], rel=0.03)
    for mount, forces in steady["foundation_force_amplitudes"].items():
        for way, force in forces.items():
            assert of_run["foundation_force_amplitudes"][mount][way] == pytest.approx(force, rel=0.05)
            assert of_run["peak_foundation_forces"][mount][way] > force


def test_starting_and_stopping_give_the_peaks_of_their_runs(of_run: Any) -> None:
    start = {"e1": -math.pi / 2, "e2": -math.pi / 2}
    cycle = run(StartStop(until=10.0, start=start), load_machine(SCREEN)).wucht.summary
    for mount, forces in of_run["peak_foundation_forces"].items():
        for way, force in forces.items():
            assert cycle["peak_foundation_forces_up"][mount][way] == pytest.approx(force, rel=5e-3)
    down = run(CoastDown(), load_machine(SCREEN)).wucht.summary["peak_foundation_forces"]
    assert cycle["peak_foundation_forces_down"]["mount 1"]["y"] == pytest.approx(down["mount 1"]["y"], rel=0.3)


def test_the_energy_of_the_stroke_is_that_of_its_speed(of_run: Any) -> None:
    """M v^2/2 with v = stroke w/2, and a little more as the screen turns."""
    translation = 400.0 * (of_run["stroke"] / 2 * of_run["final_speed"]) ** 2 / 2
    assert translation < of_run["stroke_energy"] < 1.03 * translation


def test_a_foundation_of_its_own_takes_its_share() -> None:
    """On a block of its own the ground gets what the springs below that give: their force, by the displacement of the block."""
    carrier = {"directions": "y", "mass": 50.0, "stiffness": 4e4, "damping": 100.0}
    carrier |= {"foundation": {"direction": "y", "mass": 500.0, "stiffness": 3e5, "damping": 0.0}}
    rotor = {"kind": "rotor", "name": "fan", "mass": 10.0, "unbalance": UNBALANCE, "inertia": 0.1}
    drive = {"on": "fan", "kind": "linear", "slope": 10.0, "no_load_speed": 100.0}
    result = run(
        Response(points=400, range=(99.0, 100.0)), machine_from({"carrier": carrier, "bodies": [rotor], "drives": [drive]})
    )
    summary, w = result.wucht.summary, result.wucht.summary["operating_speed"]
    below = result.displacement_amplitude.sel(direction="foundation").interp(speed=w)
    assert summary["foundation_force_amplitudes"]["carrier"]["y"] == pytest.approx(3e5 * float(below), rel=1e-4)


def test_friction_dampers_and_buffers_are_supports_of_their_own() -> None:
    """Each damper slips at 60 N along its line, at 60 and 120 degrees; the buffers at 12 mm are not reached."""
    peaks = run_file("practice/laundry-drum-friction").wucht.summary["peak_foundation_forces"]
    along_line = {"x": pytest.approx(30.0, rel=0.01), "y": pytest.approx(60.0 * math.sin(math.pi / 3), rel=0.01)}
    assert peaks["left"] == along_line and peaks["right"] == along_line
    assert peaks["buffer"] == {"x": 0.0, "y": 0.0}


def test_forces_at_rest_are_no_vibration() -> None:
    """A balanced rotor: nothing but the weight, and no exciting force to take a share of."""
    rotor = {"kind": "rotor", "name": "fan", "mass": 10.0, "eccentricity": 0.0, "inertia": 0.1}
    carrier = {"directions": "xy", "mass": 90.0, "stiffness": 4e4, "damping": 400.0, "gravity": G}
    drive = {"on": "fan", "kind": "linear", "slope": 10.0, "no_load_speed": 100.0}
    summary = run(RunUp(until=3.0), machine_from({"carrier": carrier, "bodies": [rotor], "drives": [drive]})).wucht.summary
    assert summary["foundation_force_amplitudes"] == summary["peak_foundation_forces"] == {"carrier": {"x": 0.0, "y": 0.0}}
    assert summary["transmissibility"] is None
    assert summary["static_foundation_forces"]["carrier"]["y"] == pytest.approx(-MASS * G)


def test_machines_without_weight_or_supports_state_no_static_loads() -> None:
    weightless = run(Response(), block(0.1, 60.0, gravity=0.0)).wucht.summary
    assert "foundation_force_amplitudes" in weightless and "static_deflection" not in weightless
    laval = run(Response(range=(0.1, 3.0)), load_machine("drozdetskaya-2020/table-5.1")).wucht.summary
    assert "foundation_force_amplitudes" not in laval
