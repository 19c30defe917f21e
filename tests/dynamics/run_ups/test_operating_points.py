"""Several rotors run in a stable synchronous configuration: where a run-up takes them, in three studies that do not run it."""

from __future__ import annotations

import cmath
import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from wucht import CoastDown, Response, RunUp, TorqueBalance, report, run
from wucht.dynamics.run_ups import operating_points
from wucht.dynamics.run_ups.operating_points import OperatingPoints, vibration_in_operation
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_to_pi

START_OF_FILE = {"e1": -1.5708, "e2": -1.5708}


# --- decks at random ---

MOTOR = {
    "kind": "induction", "stator": "carrier", "voltage": 230.0, "frequency": "50 Hz", "pole_pairs": 2,
    "stator_reactance": 8.0, "rotor_reactance": 8.0,
}  # fmt: skip


def random_deck(seed: int, count: int) -> dict[str, Any]:
    """A deck with unequal motors, each somewhere on it, in one sense or the other, on two mounts below its centre of mass."""
    r = np.random.default_rng(seed)

    def between(low: float, high: float) -> float:
        return float(r.uniform(low, high))

    rotors, drives = [], []
    for k in range(count):
        rotors.append({
            "kind": "rotor", "name": f"e{k + 1}", "mass": between(15, 30), "unbalance": between(0.3, 0.6),
            "inertia": between(0.02, 0.04), "bearing_damping": 0.01, "position": [between(-0.7, 0.7), between(-0.1, 0.7)],
        })  # fmt: skip
        sense = int(r.choice([-1, 1])) if k else 1
        resistances = {"stator_resistance": between(7, 8), "rotor_resistance": between(6, 7.5)}
        drives.append(MOTOR | {"on": f"e{k + 1}", "sense": sense} | resistances)
    mounts = [
        {
            "at": [side * between(0.7, 1.0), -between(0.1, 0.3)],
            "stiffness": [between(5e4, 8e4), between(8e4, 1.3e5)],
            "damping": [300.0, 500.0],
        }
        for side in (-1, 1)
    ]
    carrier = {"mass": between(300, 450), "inertia": between(120, 180), "directions": "xyr", "gravity": 9.81, "mounts": mounts}
    return {"carrier": carrier, "bodies": rotors, "drives": drives}


def three_in_a_circle(seed: int) -> dict[str, Any]:
    """A deck with three motors of one sense, nearly equal, around its centre of mass: two ways to run synchronously."""
    deck, r = random_deck(seed, 3), np.random.default_rng(seed)
    shared = {name: deck["bodies"][0][name] for name in ("mass", "unbalance", "inertia")}
    angles = [2 * math.pi * k / 3 + float(r.normal(0, 0.1)) for k in range(3)]
    positions = [[0.3 * math.cos(angle), 0.3 * math.sin(angle)] for angle in angles]
    rotors = [b | shared | {"position": position} for b, position in zip(deck["bodies"], positions, strict=True)]
    resistances = {"sense": 1, "stator_resistance": 7.5}
    drives = [d | resistances | {"rotor_resistance": float(r.uniform(6.3, 6.6))} for d in deck["drives"]]
    return deck | {"bodies": rotors, "drives": drives}


def mirrored(deck: dict[str, Any]) -> dict[str, Any]:
    """The deck from behind: left is right, and each motor turns the other way."""
    mounts = [m | {"at": [-m["at"][0], m["at"][1]]} for m in deck["carrier"]["mounts"]]
    rotors = [b | {"position": [-b["position"][0], b["position"][1]]} for b in deck["bodies"]]
    drives = [d | {"sense": -d["sense"]} for d in deck["drives"]]
    return {"carrier": deck["carrier"] | {"mounts": mounts}, "bodies": rotors, "drives": drives}


def stable_points(balance: xr.Dataset) -> list[dict[str, Any]]:
    return [p for p in balance.wucht.summary["working_points"] if p["stable"]]


def summary_of(study: Any, machine: Machine) -> dict[str, Any]:
    result: dict[str, Any] = run(study, machine).wucht.summary
    return result


def apart(first: dict[str, float], second: dict[str, float]) -> float:
    """The largest difference of phases, in degrees."""
    return max(abs(math.degrees(wrap_to_pi(first[name] - second[name]))) for name in second)


@pytest.mark.parametrize(
    ("seed", "count", "degrees", "share"),
    [
        # The exciters work against each other: their fluctuation shows in what is left.
        pytest.param(1, 2, 0.5, 0.025, marks=pytest.mark.slow),
        (2, 2, 0.5, 0.01),
        # Near the edge of synchronisation the phases depend on what the averaged equations leave out.
        pytest.param(3, 3, 2.0, 0.01, marks=pytest.mark.slow),
        pytest.param(4, 3, 0.5, 0.01, marks=pytest.mark.slow),
    ],
)
def test_a_working_point_is_where_the_run_up_ends(seed: int, count: int, degrees: float, share: float) -> None:
    """The speed to 0.2 %; phases and amplitude as closely as averaged equations of first order give them."""
    machine = machine_from(random_deck(seed, count))
    steady, curves, speeds = TorqueBalance().prepare(machine)
    found = OperatingPoints.of(steady, curves, speeds, None)
    ((point, c),) = [(p, c) for p, c in zip(found.points, found.configurations, strict=True) if p.stable]
    (operation,) = vibration_in_operation(steady)
    at_the_end = summary_of(RunUp(until=20.0), machine)
    assert at_the_end["outcome"] == "synchronised"
    assert point.speed == operation.speed == pytest.approx(at_the_end["final_speed"], rel=2e-3)
    assert apart(c.phases, at_the_end["rotor_phases"]) < degrees
    assert operation.amplitude == pytest.approx(at_the_end["final_amplitude"], rel=share)


# --- two configurations ---


@cache
def two_ways() -> Machine:
    return machine_from(three_in_a_circle(1))


@cache
def balance_of_two_ways() -> xr.Dataset:
    return run(TorqueBalance(), two_ways())


def test_each_stable_configuration_is_reached_by_a_run_up() -> None:
    points, r, reached = stable_points(balance_of_two_ways()), np.random.default_rng(0), set[str]()
    assert len(points) == 2
    for _ in range(6):
        start = {name: float(r.uniform(0, 2 * math.pi)) for name in ("e1", "e2", "e3")}
        final = summary_of(RunUp(until=8.0, start=start), two_ways())
        (same,) = [p for p in points if apart(p["phases"], final["rotor_phases"]) < 1.0]
        assert same["speed"] == pytest.approx(final["final_speed"], rel=2e-3)
        reached.add(same["configuration"])
        if len(reached) == 2:
            return
    pytest.fail(f"{reached} alone")


@pytest.mark.slow
def test_the_start_selects_the_nearest_configuration() -> None:
    for point in stable_points(balance_of_two_ways()):
        start = {name: phase + 0.3 for name, phase in point["phases"].items()} | {"e1": 0.1}
        (selected,) = stable_points(run(TorqueBalance(start=start), two_ways()))
        assert selected == point
    unstable = [p for p in balance_of_two_ways().wucht.summary["working_points"] if not p["stable"]]
    result = run(CoastDown(until=0.02, start=start), two_ways()).wucht.summary
    assert unstable and [one["configuration"] for one in result["configurations"]] == [point["configuration"]]


# --- senses and shafts ---


def test_a_clockwise_machine_is_the_mirror_image() -> None:
    deck = random_deck(2, 2)
    first, second = (run(TorqueBalance(), machine_from(d)) for d in (deck, mirrored(deck)))
    (right,), (left,) = stable_points(first), stable_points(second)
    assert left["speed"] == pytest.approx(-right["speed"], rel=1e-9) and apart(left["phases"], right["phases"]) < 1e-6
    (operation,) = summary_of(Response(), machine_from(mirrored(deck)))["operation"]
    assert operation["speed"] == left["speed"]
    coasting = summary_of(CoastDown(until=0.05), machine_from(mirrored(deck)))
    assert coasting["configurations"][0]["start_speed"] == pytest.approx(left["speed"])


def test_the_shaft_of_the_second_motor_has_the_same_working_point() -> None:
    screen = load_machine("practice/screen")
    (first,), (second,) = (stable_points(run(TorqueBalance(on=on), screen)) for on in ("e1", "e2"))
    assert second["speed"] == -first["speed"] and second["phases"] == first["phases"]
    assert second["torque"] < 0 < first["torque"], "in its sense of rotation"
    # The motors balance bearings and vibration together, and the vibration passes torque from one to the other.
    assert first["torque"] - second["torque"] == pytest.approx(2 * 0.01 * first["speed"], rel=0.15)


# --- the screen of the catalogue ---


def test_the_screen_runs_where_its_run_up_ends() -> None:
    """155.16 rad/s, 2.299 mm and a throw of 4.593 mm."""
    screen = load_machine("practice/screen")
    balance = run(TorqueBalance(), screen)
    (point,) = stable_points(balance)
    assert point["speed"] == pytest.approx(155.16, rel=1e-3)
    assert "rotors in the stable synchronous configuration e2 -90.4° at 155.2 rad/s" in " ".join(balance.wucht.assumed)
    response = run(Response(), screen)
    (operation,) = response.wucht.summary["operation"]
    assert operation["amplitude"] == pytest.approx(2.299e-3, rel=5e-3)
    assert operation["stroke"] == pytest.approx(4.593e-3, rel=5e-3)
    assert "  in operation 2.294 mm at 155.2 rad/s (1482 rpm), e2 -90.4°; reached from rest" in report(response)


def test_a_coast_down_begins_in_operation() -> None:
    """The speed falls from turn to turn by 2.4 to 3.3 rad/s, as the bearings brake it. Within a turn it fluctuates by 4.9 rad/s
    in operation, by gravity and by the vibration torque, and after that by no more. At the phases of the file it would fall by
    9.8 rad/s within a turn, and rise again.
    """
    result = run(CoastDown(until=0.5), load_machine("practice/screen"))
    fall = -np.diff(result.mean_speed.values)
    assert fall.min() > 2.0 and fall.max() < 3.5
    turn = result.time.values <= 2 * math.pi / 155
    assert np.ptp(result.speed.values[turn]) < 4.9
    held = run(CoastDown(until=0.5, bodies="held", start=START_OF_FILE), load_machine("practice/screen"))
    fall = -np.diff(held.mean_speed.values)
    assert fall.max() > 9.0 and fall.min() < 0
    assert result.wucht.summary["start_speed"] == pytest.approx(155.2, abs=0.05)


def test_without_a_stable_configuration_it_is_said() -> None:
    machine = load_machine("practice/screen-unsynchronised")
    balance, response = run(TorqueBalance(), machine), run(Response(), machine)
    assert stable_points(balance) == [] == response.wucht.summary["operation"]
    words = "the rotors do not run synchronously: no synchronous configuration in the range is stable"
    assert balance.attrs["sentence"].startswith(words)
    coasting = run(CoastDown(until=0.02), machine)
    reason = "the rotors start at the phases of the start: no synchronous configuration of the rotors is stable"
    assert reason in coasting.wucht.warnings and "configurations" not in coasting.wucht.summary
    with refused("study.bodies", "no synchronous configuration", given="steady", code="no-stable-phases"):
        run(CoastDown(until=0.02, bodies="steady"), machine)


# --- by hand ---


def test_bodies_of_a_track_do_not_run_in_each_others_place() -> None:
    """Below the resonance both balls gather on the heavy side, which those of a track cannot.

    z = H (U + u exp(i psi)), and the balls lie along z: sin(psi - arg H) = (u/U) sin arg H.
    """
    rotor = {"kind": "rotor", "name": "r", "mass": 5.0, "unbalance": 4e-3, "inertia": 0.05}
    ball = {"kind": "pendulum", "about": "r", "mass": 0.05, "length": 0.1, "damping": 1e-3}
    drive = {"on": "r", "kind": "linear", "slope": 2.0, "no_load_speed": -30.0}

    def operations(**more: Any) -> tuple[operating_points.Operation, ...]:
        bodies = [rotor, *(ball | {"name": name} | more for name in "pq")]
        machine = machine_from({"carrier": {"mass": 10.0, "stiffness": 4e4, "damping": 60.0}, "bodies": bodies, "drive": drive})
        return vibration_in_operation(SteadyPhases.of(machine, {}, None))

    (alone,) = operations()
    assert alone.label == "together, heavy side" and alone.speed == pytest.approx(-30.0, rel=1e-4)
    w = abs(alone.speed)
    response = w**2 / (4e4 - 15.1 * w**2 + 60j * w)
    lag = cmath.phase(response)
    total = 4e-3 + 1e-2 * cmath.exp(1j * (lag + math.asin(2.5 * math.sin(lag))))
    assert alone.amplitude == pytest.approx(abs(response * total), rel=1e-9)
    assert operations(track="t", diameter=0.02) == ()
