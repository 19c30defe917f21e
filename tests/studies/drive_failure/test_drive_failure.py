"""The study ``drive-failure``: against run-ups with a schedule, the balance of power, and the averaged equations."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import check_file, check_refusal

from wucht import DriveFailure, Machine, RunUp, draw, load_machine, report, run, run_file
from wucht.dynamics.run_ups.drive_losses import machine_without_supply, mean_torques
from wucht.dynamics.run_ups.operating_state import machine_in_operation
from wucht.machines.parts import drives
from wucht.machines.schedules import schedules_of
from wucht.studies.registry import study_of

SCREEN = "practice/screen"


@pytest.fixture(scope="module")
def screen() -> Machine:
    return load_machine(SCREEN)


@pytest.fixture(scope="module")
def failures(screen: Machine) -> Any:
    return run(DriveFailure(time=3.0, until=8.0), screen)


def test_before_it_runs_as_its_run_up_ends(failures: Any) -> None:
    """The numbers of practice/screen."""
    (before,) = failures.wucht.summary["operation"]
    assert before["outcome"] == "synchronised"
    assert before["speed"] == pytest.approx(155.156, rel=1e-5)
    assert before["throw"] == pytest.approx(4.58e-3, rel=1e-3)
    assert before["amplitude"] == pytest.approx(2.299e-3, rel=1e-3)
    assert math.degrees(before["throw_direction"]) == pytest.approx(45.5, abs=0.5)
    assert before["phases"]["e2"] == pytest.approx(math.radians(360 - 90.4), abs=5e-3)


@pytest.mark.slow
@pytest.mark.parametrize("index", [0, 1])
def test_afterwards_it_runs_as_with_a_schedule_of_the_voltage(failures: Any, screen: Machine, index: int) -> None:
    """A run-up from rest, whose motor has no voltage from 5 s on, ends in the same state."""
    case = failures.wucht.summary["cases"][index]
    failing = case["drive"]
    assert failing == f"e{index + 1}"
    table = {"parameter": f"drives.{failing}.voltage", "points": [[0, 230], [5, 0]], "interpolation": "steps"}
    scheduled = screen.with_fields(schedules=schedules_of([table], screen.parameters, screen.parts, "s"))
    up = run(RunUp(until=15.0, start={"e1": -math.pi / 2, "e2": -math.pi / 2}), scheduled).wucht.summary
    assert case["outcome"] == up["outcome"] == "synchronised"
    assert case["speed"] == pytest.approx(abs(up["mean_speeds"]["e1"]), rel=1e-5)
    assert case["phases"]["e2"] == pytest.approx(up["rotor_phases"]["e2"], abs=1e-3)
    assert case["throw"] == pytest.approx(up["stroke"], rel=2e-3)


def test_the_other_motor_does_the_work_of_both(failures: Any) -> None:
    """Without load the speed hardly changes, nor do bearing losses and dampers: the torques are those of both before."""
    (before,) = failures.wucht.summary["operation"]
    together = sum(abs(torque) for torque in before["torques"].values())
    for case, failing, remaining in zip(failures.wucht.summary["cases"], ("e1", "e2"), ("e2", "e1"), strict=True):
        assert case["torques"][failing] == 0.0
        assert abs(case["torques"][remaining]) == pytest.approx(together, rel=0.04)
        assert abs(case["torques"][remaining]) > 1.8 * abs(before["torques"][remaining])


def test_the_torques_are_those_of_a_run_up(failures: Any, screen: Machine) -> None:
    """Their sum is its motor torque and, with the speeds, its power; one by one the circuit gives them at the mean speed, but
    for the waves of the speed within a turn, at whose ends its curve is lower."""
    (before,) = failures.wucht.summary["operation"]
    up = run(RunUp(until=12.0, start={"e1": -math.pi / 2, "e2": -math.pi / 2}), screen)
    late = up.time.values > 8.0
    torques, speed = before["torques"], before["speed"]
    assert sum(torques.values()) == pytest.approx(up.motor_torque.values[late].mean(), abs=0.005)
    power = sum(abs(torque) for torque in torques.values()) * speed
    assert power == pytest.approx(up.motor_power.values[late].mean(), rel=0.015)  # the torque is low where the speed is high
    for drive in screen.drives:
        circuit = drive.torque_at(before["speeds"][drive.on])
        assert 0.96 * abs(circuit) < abs(torques[drive.on]) < abs(circuit)


def test_the_amplitude_after_the_failure_is_the_largest(failures: Any) -> None:
    for k, case in enumerate(failures.wucht.summary["cases"]):
        after = failures.time.values[k] > 0
        assert case["peak_amplitude"] == pytest.approx(np.nanmax(failures.amplitude.values[k][after]), rel=0.01)
        assert case["peak_amplitude"] >= case["amplitude"]


def test_times_run_through_the_failure_without_a_gap(failures: Any) -> None:
    turn = 2 * math.pi / 150.0
    for times in failures.time.values:
        steps = np.diff(times[np.isfinite(times)])
        assert times[0] < -10 * turn and steps.min() > 0 and steps.max() < 3 * turn


def test_a_drive_that_brakes_without_voltage_is_taken_away() -> None:
    """A DC motor whose armature is short-circuited is a brake; one that is cut off is not."""
    machine = _screen_with("dc-separate", {"voltage": 160, "armature_resistance": 2, "motor_constant": 1.0, "flux": "1 V s"})
    bare = machine_without_supply(machine_in_operation(machine), machine.drives[0])
    assert [d.on for d in bare.drives] == ["e2"]


def _screen_with(kind: str, keys: dict[str, Any]) -> Machine:
    screen = load_machine(SCREEN)
    made = drives()[kind]
    motors = [made(on="e1", stator="carrier", **keys), made(on="e2", stator="carrier", **keys | _backwards(keys))]
    carrier, *bodies = screen.parts[:3]
    return Machine(carrier, bodies, motors)


def _backwards(keys: dict[str, Any]) -> dict[str, Any]:
    return {name: -value for name, value in keys.items() if name in ("voltage", "no_load_speed")}


def largest_moment(screen: Machine, speed: float) -> float:
    """Between two exciters that turn in opposite senses, coupled by the rotation alone: U^2 w^2 r_1 r_2/(2 J)."""
    centre = 20 * np.array([0.7, 0.7]) / 400
    arms = [math.dist(place, centre) for place in ((0.5, 0.2), (0.2, 0.5))]
    inertia = 150 + 360 * float(centre @ centre) + 20 * sum(arm**2 for arm in arms)
    assert screen.values["e2.unbalance"] == 0.45
    return 0.45**2 * speed**2 * arms[0] * arms[1] / (2 * inertia)


@pytest.mark.parametrize(("damping", "outcome"), [(0.019, "synchronised"), (0.025, "not-synchronised")])
def test_both_sides_of_the_friction_at_which_the_rotor_stops(screen: Machine, damping: float, outcome: str) -> None:
    """The vibration carries e2 along as long as the moment covers its bearing losses: M sin(phi_0 - phi) = b w.

    phi_0, where no moment passes, is 90.4 - 1.9 degrees before e1.
    """
    result = run(DriveFailure(time=2.0), screen.with_values({"e2.bearing_damping": damping}))
    case = next(case for case in result.wucht.summary["cases"] if case["drive"] == "e2")
    assert case["outcome"] == outcome
    assert result.attrs["outcome"] == ("synchronised" if outcome == "synchronised" else "several")
    assert (case["phases"] is None) == (case["speed"] is None) == (outcome != "synchronised")
    assert (damping * 151.7 > largest_moment(screen, 151.7)) == (damping == 0.025)
    if case["phases"] is not None:
        moment = largest_moment(screen, case["speed"]) * math.sin(math.radians(360 - 88.5) - case["phases"]["e2"])
        assert moment == pytest.approx(damping * case["speed"], rel=0.07)
    else:
        assert abs(case["speeds"]["e2"]) < 1e-3
        assert case["speeds"]["e1"] == pytest.approx(155.18, rel=1e-4)


def test_run_up_from_rest(screen: Machine) -> None:
    """It ends in the same operation; ``start`` is the state at rest. Rotors that do not run together are run up, too."""
    start = {"e1": -math.pi / 2, "e2": -math.pi / 2}
    result = run(DriveFailure(time=6.0, until=1.0, begin="rest", start=start), screen)
    (before,) = result.wucht.summary["operation"]
    assert before["configuration"] is None
    assert before["speed"] == pytest.approx(155.156, rel=1e-4)
    result = run(DriveFailure(time=0.5, until=0.3), load_machine("practice/screen-unsynchronised"))
    assert any("run up from rest" in warning for warning in result.wucht.warnings)


def test_the_main_rotor_that_stops_is_not_the_verdict_on_all(screen: Machine) -> None:
    """e1 is the main rotor: without supply and with much friction it stops, while e2 goes on."""
    damped = screen.with_values({"e1.bearing_damping": 0.04})
    result = run(DriveFailure(time=3.0), damped)
    assert result.wucht.summary["operation"][0]["outcome"] == "synchronised"
    first, _ = result.wucht.summary["cases"]
    assert (first["outcome"], first["sentence"]) == ("not-synchronised", "e1 oscillates, e2 turns")
    assert abs(first["speeds"]["e1"]) < 5
    assert abs(first["speeds"]["e2"]) > 100


@pytest.fixture(scope="module")
def briefly() -> Any:
    """Two exciters with two stable configurations, for a few turns."""
    return run(DriveFailure(time=2.0, until=4.0), load_machine("sperling-vibration/self-synchronisation-soft"))


def test_each_drive_fails_in_each_configuration(briefly: Any) -> None:
    s, both = briefly.wucht.summary, ("together", "opposed")
    assert [(row["configuration"], row["drive"]) for row in s["cases"]] == [(c, d) for c in both for d in ("e1", "e2")]
    assert ([o["configuration"] for o in s["operation"]], s["failure_times"]) == (["together", "opposed"], [2.0, 2.0])
    assert [o["speeds"]["e1"] for o in s["operation"]] == [pytest.approx(5.7, abs=0.05), pytest.approx(12.0, rel=1e-3)]
    assert [row["end_time"] for row in s["cases"]] == [4.0] * 4
    assert [briefly.drive_torque.values[k, k % 2] for k in range(4)] == [0.0] * 4
    assert briefly.operation_torque.values[:2].tolist() == [list(s["operation"][0]["torques"].values())] * 2
    assert report(briefly) and draw(briefly).axes


def test_each_run_is_resumed_as_itself(briefly: Any, tmp_path: Path) -> None:
    """Interrupted in the second configuration, when all runs from the first one are stored."""

    def stop(done: float, _what: str) -> None:
        if done >= 0.55:
            raise KeyboardInterrupt

    spec, machine = DriveFailure(time=2.0, until=4.0), load_machine("sperling-vibration/self-synchronisation-soft")
    partial = run(spec, machine, folder=tmp_path, progress=stop)
    assert "2 of 4 failures are computed" in partial.wucht.warnings and report(partial) and draw(partial).axes
    again = run(spec, machine, folder=tmp_path, resume=True)
    assert again.wucht.summary == briefly.wucht.summary


def test_a_quarter_of_the_time_after_the_failure_is_kept_of_that_before(briefly: Any) -> None:
    for times in briefly.time.values:
        last, turn = np.nanmax(times), np.nanmax(np.diff(times))
        assert -last / 4 <= times[0] < turn - last / 4
    ends = np.isfinite(briefly.time.values).sum(axis=1)
    assert ends[0] < ends[2], "a course that ends earlier has no numbers there"
    assert np.isfinite(briefly.amplitude.values).sum(axis=1).tolist() == ends.tolist()


def test_the_mean_torque_of_a_clockwise_drive_behind_a_gear(screen: Machine) -> None:
    """On its body: it is the motor's torque times the ratio, and pushes clockwise."""
    carrier, *bodies = screen.parts[:3]
    linear = drives()["linear"]
    motors = [
        linear(on="e1", slope=0.1, no_load_speed=-300.0, transmission={"ratio": 2.0}),
        linear(on="e2", slope=0.1, no_load_speed=160.0),
    ]
    machine, time = Machine(carrier, bodies, motors), np.linspace(0.0, 1.0, 50)
    states = np.zeros((len(machine.state_names), len(time)))
    states[machine.row(machine.body("e1").coordinate.velocity)] = -90.0
    states[machine.row(machine.body("e2").coordinate.velocity)] = 150.0
    values = np.array(machine.system.values(machine.values))
    torques = mean_torques(machine, machine.drives, time, states, values)
    assert torques == pytest.approx({"e1": -2 * 0.1 * (300 - 2 * 90), "e2": 0.1 * (160 - 150)})


BAD: list[tuple[str, object]] = [
    ("time", 0), ("time", "1 kg"), ("until", -1), ("begin", "running"), ("tolerance", 1), ("engine", "radaw"), ("turns", 3),
    ("start", 3), ("start.e3", 1),
]  # fmt: skip


@pytest.mark.parametrize(("key", "value"), BAD)
def test_bad_input(here: Path, key: str, value: object) -> None:
    check_file("drive-failure", str(study_of("drive-failure").template), {}, {f"study.{key}": value})


def test_one_drive_alone() -> None:
    check_refusal("drive-failure of r1", lambda: run_file("drozdetskaya-2020/r1", {"study.kind": "drive-failure"}))


SHAKER = """
[machine.carrier]
mass = "100 kg"
stiffness = "1e5 N/m"
damping = "100 N s/m"
MOTION
[[machine.bodies]]
kind = "rotor"
name = "a"
mass = "5 kg"
unbalance = "0.01 kg m"
inertia = "0.01 kg m^2"
[[machine.bodies]]
kind = "rotor"
name = "b"
mass = "5 kg"
unbalance = "0.01 kg m"
inertia = "0.01 kg m^2"
[[machine.drives]]
on = "a"
kind = "linear"
slope = 0.1
no_load_speed = 100
[[machine.drives]]
on = "b"
DRIVE
[study]
kind = "drive-failure"
"""
LINEAR = 'kind = "linear"\nslope = 0.1\nno_load_speed = 101'
REFUSALS = {
    "an enforced speed": ("", 'kind = "constant-speed"\nspeed = 100'),
    "a shaken carrier": ('motion = { direction = "x", amplitude = "1 mm", frequency = "90 rad/s" }', LINEAR),
    "no configuration": ("", LINEAR.replace("101", "180")),
}


@pytest.mark.parametrize("name", REFUSALS)
def test_machines_without_an_answer(here: Path, name: str) -> None:
    motion, drive = REFUSALS[name]
    text = SHAKER.replace("MOTION", motion).replace("DRIVE", drive)
    check_file(f"drive-failure, {name}", text, {}, {"study.begin": "operation"})
