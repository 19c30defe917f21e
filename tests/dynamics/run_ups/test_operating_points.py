"""Several rotors run in a stable synchronous configuration: where a run-up takes them, in three studies that do not run it."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

from wucht import CoastDown, Response, RunUp, TorqueBalance, report, run
from wucht.dynamics.run_ups.operating_points import OperatingPoints, vibration_in_operation
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrap_to_pi

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


@pytest.mark.slow
@pytest.mark.parametrize(
    ("seed", "count", "degrees", "share"),
    [
        # The exciters work against each other: their fluctuation shows in what is left.
        (1, 2, 0.5, 0.025),
        (2, 2, 0.5, 0.01),
        # Near the edge of synchronisation the phases depend on what the averaged equations leave out.
        (3, 3, 2.0, 0.01),
        (4, 3, 0.5, 0.01),
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


@pytest.mark.slow
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


@pytest.mark.slow
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
    assert "rotors in the stable synchronous configuration e2 269.6° at 155.2 rad/s" in " ".join(balance.wucht.assumed)
    response = run(Response(), screen)
    (operation,) = response.wucht.summary["operation"]
    assert operation["amplitude"] == pytest.approx(2.299e-3, rel=5e-3)
    assert operation["stroke"] == pytest.approx(4.593e-3, rel=5e-3)
    assert "  in operation 2.294 mm at 155.2 rad/s (1482 rpm), e2 269.6°; reached from rest" in report(response)


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
