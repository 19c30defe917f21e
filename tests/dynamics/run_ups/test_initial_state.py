"""From the key `start` of a study file to the state vector."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht import RunUp, run
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

INVERTER = {"kind": "inverter", "set_speed": 30.0, "gain": 1.0, "integral_time": 0.5, "torque_limit": 5.0}
DAMPER = {"kind": "friction-damper", "name": "left", "angle": 0.0, "force": 20.0}
BUILD_UP = 2e-4
CARRIER = {"directions": "x", "mass": 20.0, "stiffness": 1e4}


def drum(name: str = "drum") -> dict[str, Any]:
    return {"kind": "rotor", "name": name, "mass": 5.0, "eccentricity": 0.0, "inertia": 0.3, "bearing_damping": 0.02}


def machine(**changed: Any) -> Machine:
    given = {"carrier": CARRIER, "bodies": [drum()], "drive": INVERTER, "attachments": [DAMPER]}
    return machine_from({k: v for k, v in (given | changed).items() if v is not None})


def state(of: Machine, start: dict[str, Any]) -> dict[str, float]:
    return dict(zip(of.state_names, initial_state(of, start).tolist(), strict=True))


def test_they_begin_at_zero_or_where_the_start_says() -> None:
    assert {state(machine(), {})[n] for n in ("left.lining", "drive.integral")} == {0.0}
    given = state(machine(), {"left": {"lining": "0.15 mm"}, "drive": {"integral": -2.0}, "drum": 0.3})
    assert (given["left.lining"], given["drive.integral"], given["drum.angle"]) == (pytest.approx(1.5e-4), -2.0, 0.3)


@pytest.mark.parametrize(
    ("start", "refusal"),
    [
        ({"left": {"lining": "0.3 mm"}}, refused("study.start.left.lining", "-0.0002", "0.0002 m", given="0.3 mm")),
        ({"left": {"lining": "3 N"}}, refused("study.start.left.lining", "m", code="dimension")),
        ({"left": {"lining": float("nan")}}, refused("study.start.left.lining", given=float("nan"), code="not-finite")),
        ({"left": {"linning": 0}}, refused("study.start.left.linning", "lining", given=0, code="unknown-key")),
        ({"left": 1e-4}, refused("study.start.left", 'lining = "0 m"', given=0.0001)),
        ({"left": {"lining": {"x": 1}}}, refused("study.start.left.lining", "x", given={"x": 1}, code="no-quantity")),
        ({"drive": {"integral": -5.1}}, refused("study.start.drive.integral", "-5", "5 N", "m", given=-5.1)),
        ({"lefd": {"lining": 0}}, refused("study.start.lefd", "left", code="unknown-key")),
        ({"drives": {}}, refused("study.start.drives", code="unknown-key")),
    ],
)
def test_bad_values_are_refused(start: dict[str, Any], refusal: Refusal) -> None:
    with refusal:
        state(machine(), start)


def test_a_run_up_stores_them_from_their_start_on() -> None:
    """The carrier stands; the controller is at its limit, where T_i x' = T_m - x, and the lining holds what the start drew."""
    result = run(RunUp(until=0.4, start={"left": {"lining": 1e-4}, "drive": {"integral": 1.0}}), machine())
    integral, lining = result["drive.integral"], result["left.lining"]
    assert (integral.dims, integral.units, integral.long_name) == (("time",), "N m", "integral part of the drive")
    assert (lining.units, lining.long_name) == ("m", "lining travel of left")
    limited = result.speed.sel(body="drum").values < 20
    assert integral.values[limited] == pytest.approx(5 - 4 * np.exp(-result.time.values[limited] / 0.5), rel=1e-8)
    assert lining.values[0] == 1e-4
    # The drawn lining pushes with F/2 on the spring's 1e4 N/m: the carrier turns back where both balance.
    assert float(result.displacement.min()) < -BUILD_UP / 4
    assert result.wucht.summary["energy_residual"] < 1e-9


Study = Callable[..., Path]
LINEAR = 'on = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'


def _state(machine: Machine, start: dict[str, Any]) -> dict[str, float]:
    return dict(zip(machine.system.state_names, initial_state(machine, start).tolist(), strict=True))


@pytest.fixture
def washer(study: Study) -> Machine:
    return load_machine(str(study()))


def test_angles_are_relative_and_speeds_absolute(washer: Machine) -> None:
    state = _state(
        washer,
        {"drum": {"angle": 1.0, "speed": "100 rad/s"}, "p1": "0.3 rad", "p2": {"angle": "-90 deg", "speed": 7}},
    )
    assert state["drum.angle"] == 1.0
    assert state["drum.speed"] == 100.0
    assert state["p1.angle"] == pytest.approx(1.3)
    assert state["p1.speed"] == 0.0, "a free drum does not lead its pendulums"
    assert state["p2.angle"] == pytest.approx(1.0 - math.pi / 2)
    assert state["p2.speed"] == 7.0


def test_under_gravity_the_carrier_starts_where_it_rests(study: Study) -> None:
    machine = load_machine(str(study('"1 kg"', '"1 kg"\ngravity = "9.81 m/s^2"', '"1e5 N/m"', '["1e5 N/m", "2e5 N/m"]')))
    rest = -(1 + 9 + 0.125 + 0.125) * 9.81 / 2e5  # weight over stiffness in y
    assert machine.rest.tolist() == pytest.approx([0.0, rest])
    assert _state(machine, {})["carrier.y"] == pytest.approx(rest)
    assert _state(machine, {"carrier": {"y": "1 mm"}})["carrier.y"] == pytest.approx(rest + 1e-3)


def test_a_prescribed_rotor_leads_its_bodies(study: Study) -> None:
    machine = load_machine(str(study(LINEAR, 'kind = "constant-speed"\nspeed = "100 rad/s"\nangle = "90 deg"\n')))
    state = _state(machine, {"p1": "0.3 rad", "p2": {"angle": -0.5, "speed": 90}})
    assert state["drum.angle"] == pytest.approx(math.pi / 2)
    assert "drum.speed" not in state, "a prescribed speed is no state"
    assert state["p1.angle"] == pytest.approx(math.pi / 2 + 0.3)
    assert state["p1.speed"] == 100.0
    assert state["p2.angle"] == pytest.approx(math.pi / 2 - 0.5)
    assert state["p2.speed"] == 90.0


def test_psi_and_delta() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    state = _state(machine, {"psi": 0.1, "delta": 0.5, "rotor": 1.0})
    # psi = (theta_1 + theta_2)/2 - phi, delta = theta_1 - theta_2
    assert (state["p1.angle"] + state["p2.angle"]) / 2 - state["rotor.angle"] == pytest.approx(0.1)
    assert state["p1.angle"] - state["p2.angle"] == pytest.approx(0.5)
    assert state["rotor.angle"] == 1.0
    alone = _state(machine, {"delta": 0.5})
    assert (alone["p1.angle"], alone["p2.angle"]) == (0.25, -0.25)


@pytest.mark.parametrize(("speed", "locked"), [(12.0, 0.0), (-12.0, 0.0), (9.0, 1.0), (-9.0, 1.0)])
def test_a_body_is_free_from_the_start_on_where_its_speed_of_release_is_passed(speed: float, locked: float) -> None:
    """In either sense of rotation."""
    pendulum = {
        "kind": "pendulum", "name": "p", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.1, "release": {"speed": 10.0}
    }  # fmt: skip
    released = machine(bodies=[drum(), pendulum])
    _, body = released.bodies
    assert body.lock_symbol is not None
    start = initial_state(released, {"drum": {"speed": speed}})
    assert machine_in_state(released, start).values[body.lock_symbol.name] == locked
