"""A motor that has to lift the weight or overcome the load of its rotor from rest, against closed forms and own integrations.

A rotor hangs with its centre of mass below its axis; theta is its angle from there. A constant torque T on a pendulum with
the moment M = m e g turns it over from rest, without damping, if T theta >= M (1 - cos theta) for all theta: T >= 0.7246 M.
A torque that rises slowly needs T >= M, the largest torque of a pendulum held at rest. The torque of an induction motor at
standstill follows from its nameplate by Kloss' formula, T = 2 T_k/(s_k + 1/s_k), with the slip s_k of its breakdown.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp
from scipy.optimize import brentq

from wucht import RunUp, TorqueBalance, VoltageDip, run
from wucht.analysis.starting import SUDDEN, starts_from_rest
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

G, UNBALANCE, INERTIA = 9.81, 0.1, 0.05
MOMENT = UNBALANCE * G
STANDING = {"directions": "fixed", "gravity": G}
NAMEPLATE = {"power": "3 kW", "speed": "1450 rpm", "voltage": "400 V", "frequency": "50 Hz", "breakdown_torque_ratio": 2.8}


def rotor(name: str = "r", damping: float = 0.002, **changed: Any) -> dict[str, Any]:
    table = {"kind": "rotor", "name": name, "mass": 2.0, "unbalance": UNBALANCE, "inertia": INERTIA}
    return table | {"bearing_damping": damping} | changed


def pendulum(torque: float, **changed: Any) -> Machine:
    """A rotor on a standing axis under a constant torque."""
    drive = {"kind": "constant-torque", "torque": torque}
    return machine_from({"carrier": STANDING, "bodies": [rotor()], "drive": drive} | changed)


def screen(**nameplate: Any) -> Machine:
    """Two motors of 3 kW on a screen of 1900 kg; unbalances of 4.5 kg m."""
    mounts = [
        {"at": [x, -0.5], "stiffness": [55e3, 133e3], "damping": [500.0, 800.0]} for x in (-1.7, 1.7, -1.5, 1.5)
    ]  # fmt: skip
    bodies = [
        rotor(name, 0.02, mass=80.0, unbalance=4.5, inertia=0.6, position=place, bearing={"C": 6e5, "p": "10/3", "share": 0.5})
        for name, place in (("e1", [0.9, 0.45]), ("e2", [0.45, 0.9]))
    ]
    carrier = {"directions": "xyr", "mass": 1900.0, "inertia": 2700.0, "gravity": G, "mounts": mounts}
    motor = {"kind": "induction", "stator": "carrier", "nameplate": NAMEPLATE | nameplate}
    return machine_from(
        {"carrier": carrier, "bodies": bodies, "drives": [motor | {"on": "e1"}, motor | {"on": "e2", "sense": -1}]}
    )


def kloss_at_standstill() -> float:
    rated_slip, ratio = 1 - 1450 / 1500, 2.8
    rated_torque = 3000.0 / (1450 * 2 * math.pi / 60)
    breakdown_slip = rated_slip * (ratio + math.sqrt(ratio**2 - 1))
    return 2 * ratio * rated_torque / (breakdown_slip + 1 / breakdown_slip)


@pytest.fixture(scope="module")
def weak() -> xr.Dataset:
    return run(RunUp(), screen())


# --- the torque that is needed ---


def test_the_sudden_torque_in_closed_form() -> None:
    angle = brentq(lambda x: x * math.sin(x) - 1 + math.cos(x), 2.0, 3.0)
    assert pytest.approx(math.sin(angle), rel=1e-12) == SUDDEN


@pytest.mark.parametrize(("share", "starts"), [(SUDDEN - 1e-3, False), (SUDDEN + 1e-3, True), (0.999, True), (1.001, True)])
@pytest.mark.parametrize("sense", [1, -1])
def test_a_constant_torque(share: float, starts: bool, sense: int) -> None:
    start = starts_from_rest(pendulum(sense * share * MOMENT, bodies=[rotor(damping=0.0)]))["r"]
    assert (start.torque, start.weight) == (pytest.approx(share * MOMENT), pytest.approx(MOMENT))
    assert start.starts is starts and start.is_held is (share < 1)


def test_torques_that_change_with_the_speed_against_an_own_integration() -> None:
    """Twenty random linear drives, quadratic loads and inertias, on both sides of the border."""
    rng = np.random.default_rng()
    for _ in range(20):
        torque, inertia = rng.uniform(0.6, 1.0) * MOMENT, 10 ** rng.uniform(-2, 0)
        no_load, load = 10 ** rng.uniform(0.5, 2), 10 ** rng.uniform(-6, -3)
        drive = {"kind": "linear", "slope": torque / no_load, "no_load_speed": no_load}
        machine = pendulum(
            0.0, bodies=[rotor(damping=0.0, inertia=inertia)], drive=drive, loads=[{"kind": "quadratic", "coefficient": load}]
        )

        def rates(_: float, y: np.ndarray, torque=torque, no_load=no_load, load=load, inertia=inertia) -> list[float]:
            accelerating = torque * (1 - y[1] / no_load) - load * y[1] * abs(y[1]) - MOMENT * math.sin(y[0])
            return [y[1], accelerating / inertia]

        motion = solve_ivp(
            rates, (0.0, 60.0 * math.sqrt(inertia / MOMENT)), [0.0, 0.0], method="DOP853", rtol=1e-11, atol=1e-11
        )
        back = np.flatnonzero(motion.y[1] < 0)
        highest = motion.y[0][: back[0] if len(back) else None].max()
        assert starts_from_rest(machine)["r"].starts is bool(highest > math.pi)


def test_pivots_and_locked_bodies_weigh_too() -> None:
    """A pendulum that hangs from a pivot on the rotor weighs there; one that is locked to the rotor with all of its moment."""
    swinging = {"kind": "pendulum", "name": "p", "about": "r", "mass": 0.5, "length": 0.2, "suspension": [0.0, 0.4]}
    locked = {"kind": "pendulum", "name": "p", "about": "r", "mass": 0.5, "length": 0.2, "release": {"speed": 50.0}}
    hanging, carried = (pendulum(1.0, bodies=[rotor(), body]) for body in (swinging, locked))
    assert starts_from_rest(hanging)["r"].weight == pytest.approx(G * math.hypot(UNBALANCE, 0.5 * 0.4))
    assert starts_from_rest(carried)["r"].weight == pytest.approx(G * (UNBALANCE + 0.5 * 0.2))


# --- run-ups from rest ---


@pytest.mark.parametrize(("share", "outcome"), [(0.70, "not-started"), (0.76, "passed")])
def test_a_run_up_under_a_sudden_torque(share: float, outcome: str) -> None:
    result = run(RunUp(), pendulum(share * MOMENT))
    s = result.wucht.summary
    assert s["outcome"] == outcome and s["start_state"] == "at rest, hanging"
    assert "start: at rest, hanging" in result.attrs["assumed"]
    assert s["starting_torque"] == {"r": pytest.approx(share * MOMENT)} and s["weight_moment"] == {"r": pytest.approx(MOMENT)}
    assert s["starts_from_rest"] == {"r": outcome == "passed"} and s["load_torque"] == {"r": 0.0}
    assert ("the weight takes up to 0.981 N m (0.7108 N m" in s["sentence"]) == (outcome == "not-started")
    if outcome == "not-started":  # it comes to rest where its torque holds the weight
        angle = float(result.angle.sel(body="r")[-1])
        assert -MOMENT * math.cos(angle) == pytest.approx(-share * MOMENT, rel=0.2)


@pytest.mark.parametrize(("share", "outcome"), [(0.97, "not-started"), (1.03, "passed")])
def test_a_run_up_under_a_torque_that_comes_slowly(share: float, outcome: str) -> None:
    """More than a sudden torque needs, but the rotor does not swing."""
    ramp = {"parameter": "drive.torque", "points": [[0.0, 0.0], [20.0, share * MOMENT]]}
    machine = pendulum(0.1, bodies=[rotor(damping=0.05)], schedules=[ramp])
    assert run(RunUp(until=120.0), machine).attrs["outcome"] == outcome


@pytest.mark.parametrize(("share", "outcome"), [(0.98, "not-started"), (1.02, "passed")])
def test_a_load_of_dry_friction(share: float, outcome: str) -> None:
    machine = pendulum(share, carrier={"directions": "fixed"}, loads=[{"kind": "coulomb", "torque": 1.0}])
    result = run(RunUp(), machine)
    assert result.attrs["outcome"] == outcome and "start_state" not in result.wucht.summary
    assert result.wucht.summary["load_torque"] == {"r": pytest.approx(1.0, rel=3e-3)}


def test_of_several_rotors_each() -> None:
    """On a standing axis they do not act on each other; the main rotor is one that starts, or one that does not."""
    torques = {"a": 2.0 * MOMENT, "b": 0.5 * MOMENT}
    drives = [{"kind": "constant-torque", "torque": t, "on": name} for name, t in torques.items()]
    for names, outcome in (("ab", "not-synchronised"), ("ba", "not-started")):
        result = run(RunUp(until=200.0), pendulum(1.0, bodies=[rotor(n, 0.02) for n in names], drive=None, drives=drives))
        assert result.attrs["outcome"] == outcome
        assert result.wucht.summary["rotor_outcomes"] == {"a": "passed", "b": "not-started"}
        assert "b does not start: the drive gives 0.4905 N m" in result.attrs["sentence"]


def test_a_rotor_that_has_turned_has_stopped() -> None:
    """From speed it turns some times before its weight stops it: no rotation is left, and from rest it does not start."""
    result = run(RunUp(start={"r": {"speed": 40.0}}), pendulum(0.1 * MOMENT, bodies=[rotor(damping=0.02)]))
    assert result.attrs["outcome"] == "stopped"
    assert any("from rest, hanging, r does not start" in warning for warning in result.wucht.warnings)


# --- the screen ---


@pytest.mark.slow
def test_the_motors_of_a_screen_do_not_lift_their_weights(weak: xr.Dataset) -> None:
    """The swings beat, and feed on the motors, whose torque rises with the speed: that of e2 turns over after 90 s."""
    s = weak.wucht.summary
    assert s["outcome"] == "not-started" and s["rotor_outcomes"] == {"e1": "not-started", "e2": "passed"}
    assert s["starting_torque"] == dict.fromkeys(("e1", "e2"), pytest.approx(kloss_at_standstill(), rel=1e-4))
    assert s["weight_moment"] == dict.fromkeys(("e1", "e2"), pytest.approx(4.5 * G))
    assert s["bearing_life"]["e1"] is s["equivalent_bearing_loads"]["e1"] is None
    assert "no bearing life of 'e1': it makes no full turn" in weak.wucht.warnings
    own = run(RunUp(until=100.0, engine="scipy"), screen())  # DOP853
    begins = [float(result["time"][np.abs(result["speed"].sel(body="e2").values) > 50.0][0]) for result in (weak, own)]
    assert begins == [pytest.approx(91.15, abs=0.5)] * 2


@pytest.mark.slow
def test_swings_that_a_motor_feeds_have_no_verdict_while_they_change(weak: xr.Dataset) -> None:
    """Also of a rotor beside the main one. The advice leads to the verdict by no more than a few runs."""
    until, ends = 15.0, []
    while len(ends) < 6:
        s = run(RunUp(until=until), screen()).wucht.summary
        if s["outcome"] == "not-started":
            break
        assert s["outcome"] == "unidentified" and until < s["advised_time"] < 3 * until
        ends.append(until)
        until = s["advised_time"]
    assert 2 <= len(ends) < 6 and s["rotor_outcomes"] == weak.wucht.summary["rotor_outcomes"]


@pytest.mark.slow
def test_motors_of_a_third_of_the_power_never_start() -> None:
    s = run(RunUp(), screen(power="1 kW")).wucht.summary
    assert s["outcome"] == "not-started" and s["rotor_outcomes"] == {"e1": "not-started", "e2": "not-started"}
    assert s["bearing_life"] == s["equivalent_bearing_loads"] == {"e1": None, "e2": None}


@pytest.mark.slow
def test_from_another_start_the_verdict_stays_with_a_warning() -> None:
    result = run(RunUp(start={"e1": 0.0, "e2": 0.0}), screen())
    assert result.attrs["outcome"] == "synchronised" and "start_state" not in result.wucht.summary
    (warning,) = result.wucht.warnings
    assert warning.startswith("from rest, hanging, e1, e2 do not start: the drive gives 19.34 N m at standstill")
    assert warning.endswith("; here the given start sets them turning")
    assert run(RunUp(until=1.0), screen(starting_torque_ratio=2.4)).wucht.summary["starts_from_rest"] == {
        "e1": True,
        "e2": True,
    }


def test_torque_balance_knows_the_weight() -> None:
    weak, strong = (run(TorqueBalance(), m) for m in (screen(), screen(starting_torque_ratio=2.4)))
    assert weak.wucht.summary["starts_from_rest"] == {"e1": False, "e2": False}
    assert "1 of them stable" in weak.attrs["sentence"] and "from rest, hanging, e1, e2 do not start" in weak.attrs["sentence"]
    assert strong.wucht.summary["starts_from_rest"] == {"e1": True, "e2": True}
    assert strong.attrs["sentence"].endswith("reached from rest") and "do not start" not in strong.attrs["sentence"]


def test_a_dip_lets_the_rotor_stop() -> None:
    """A motor without vibration, with less torque at standstill than its rotor needs: from speed it runs on, but not after
    a dip that lets it swing."""
    resistance = 24.0 * 0.6 / (0.7 * MOMENT)
    drive = {"kind": "dc-separate", "voltage": 24.0, "armature_resistance": resistance, "motor_constant": 1.0, "flux": 0.6}
    machine = pendulum(0.0, bodies=[rotor(inertia=0.5)], drive=drive)
    result = run(VoltageDip(depth=1.0, start={"r": {"speed": 35.0}}, points=4), machine)
    s = result.wucht.summary
    assert s["operating_outcome"] == "passed" and s["starts_from_rest"] == {"r": False}
    assert s["outcome"] == s["beyond"]["outcome"] == "not-started" and s["critical_duration"] > 0
    assert result.attrs["sentence"].endswith(": not-started")
    assert any("the weight takes up to 0.981 N m" in warning for warning in result.wucht.warnings)
