"""From the key `start` of a study file to the state vector."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.refusals import refused

from wucht.analysis.static import static_position
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.errors import InputError
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

Study = Callable[..., Path]
LINEAR = 'on = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'


def _state(machine: Machine, start: dict[str, Any]) -> dict[str, float]:
    return dict(zip(machine.system.state_names, initial_state(machine, start).tolist(), strict=True))


@pytest.fixture
def drum(study: Study) -> Machine:
    return load_machine(str(study()))


def test_bodies_not_named_start_at_rest_at_angle_0(drum: Machine) -> None:
    assert set(_state(drum, {}).values()) == {0.0}


def test_angles_are_relative_and_speeds_absolute(drum: Machine) -> None:
    state = _state(
        drum, {"drum": {"angle": 1.0, "speed": "100 rad/s"}, "p1": "0.3 rad", "p2": {"angle": "-90 deg", "speed": 7}}
    )
    assert state["drum.angle"] == 1.0
    assert state["drum.speed"] == 100.0
    assert state["p1.angle"] == pytest.approx(1.3)
    assert state["p1.speed"] == 0.0, "a free drum does not lead its pendulums"
    assert state["p2.angle"] == pytest.approx(1.0 - math.pi / 2)
    assert state["p2.speed"] == 7.0


def test_the_order_of_the_file_does_not_matter(study: Study) -> None:
    machine = load_machine(str(study('about = "drum"', 'about = "p2"')))  # p1 about p2, which comes after it
    state = _state(machine, {"drum": 0.1, "p1": 0.01, "p2": 1.0})
    assert state["p2.angle"] == pytest.approx(1.1)
    assert state["p1.angle"] == pytest.approx(1.11)


def test_only_a_speed(drum: Machine) -> None:
    state = _state(drum, {"p1": {"speed": "60 rpm"}})
    assert state["p1.angle"] == 0.0
    assert state["p1.speed"] == pytest.approx(2 * math.pi)


def test_the_carrier(drum: Machine) -> None:
    state = _state(drum, {"carrier": {"x": "1 mm", "vy": "-2 mm/s"}})
    assert [state[f"carrier.{k}"] for k in ("x", "y", "vx", "vy")] == [1e-3, 0.0, 0.0, -2e-3]


def test_under_gravity_the_carrier_starts_where_it_rests(study: Study) -> None:
    machine = load_machine(str(study('"1 kg"', '"1 kg"\ngravity = "9.81 m/s^2"', '"1e5 N/m"', '["1e5 N/m", "2e5 N/m"]')))
    rest = -(1 + 9 + 0.125 + 0.125) * 9.81 / 2e5  # weight over stiffness in y
    assert static_position(machine).tolist() == pytest.approx([0.0, rest])
    assert _state(machine, {})["carrier.y"] == pytest.approx(rest)
    assert _state(machine, {"carrier": {"y": "1 mm"}})["carrier.y"] == pytest.approx(rest + 1e-3)


def test_a_carrier_without_springs_starts_at_zero(study: Study) -> None:
    machine = load_machine(str(study('"1e5 N/m"', "0")))
    assert static_position(machine).tolist() == [0.0, 0.0]


def test_a_prescribed_rotor_leads_its_bodies(study: Study) -> None:
    machine = load_machine(str(study(LINEAR, 'kind = "constant-speed"\nspeed = "100 rad/s"\nangle = "90 deg"\n')))
    state = _state(machine, {"p1": "0.3 rad", "p2": {"angle": -0.5, "speed": 90}})
    assert state["drum.angle"] == pytest.approx(math.pi / 2)
    assert "drum.speed" not in state, "a prescribed speed is no state"
    assert state["p1.angle"] == pytest.approx(math.pi / 2 + 0.3)
    assert state["p1.speed"] == 100.0
    assert state["p2.angle"] == pytest.approx(math.pi / 2 - 0.5)
    assert state["p2.speed"] == 90.0


def test_a_body_on_a_led_body_is_led(study: Study) -> None:
    second = 'name = "p2"\nabout = "drum"'
    machine = load_machine(str(study(LINEAR, 'kind = "constant-speed"\nspeed = -50\n', second, 'name = "p2"\nabout = "p1"')))
    state = _state(machine, {"p1": 1.0, "p2": 1.0})
    assert (state["p1.speed"], state["p2.speed"], state["p2.angle"]) == (-50.0, -50.0, 2.0)


def test_psi_and_delta() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    state = _state(machine, {"psi": 0.1, "delta": 0.5, "rotor": 1.0})
    # psi = (theta_1 + theta_2)/2 - phi, delta = theta_1 - theta_2
    assert (state["p1.angle"] + state["p2.angle"]) / 2 - state["rotor.angle"] == pytest.approx(0.1)
    assert state["p1.angle"] - state["p2.angle"] == pytest.approx(0.5)
    assert state["rotor.angle"] == 1.0
    alone = _state(machine, {"delta": 0.5})
    assert (alone["p1.angle"], alone["p2.angle"]) == (0.25, -0.25)


def test_psi_and_delta_need_two_bodies_about_the_rotor(study: Study) -> None:
    machine = load_machine("drozdetskaya-2020/table-3.1-laval")
    with refused("study.start.psi", code="unknown-key"):
        initial_state(machine, {"psi": 0.1})
    chain = load_machine(str(study('name = "p2"\nabout = "drum"', 'name = "p2"\nabout = "p1"')))
    with refused("study.start.psi", code="unknown-key"):
        initial_state(chain, {"psi": 0.1})


def test_a_dimensionless_start_has_no_units() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    assert _state(machine, {"p1": 0.3})["p1.angle"] == 0.3
    with refused("study.start.carrier.x", code="dimension"):
        initial_state(machine, {"carrier": {"x": "1 mm"}})
    with refused("study.start.p1.speed", code="dimension"):
        initial_state(machine, {"p1": {"speed": "1 rad/s"}})


WRONG = {
    "unknown body": ({"p3": 1}, r"study\.start\.p3: given 1; unknown key; did you mean 'p2'"),
    "unknown key": ({"p1": {"angel": 1}}, r"study\.start\.p1\.angel: .*did you mean 'angle'"),
    "unknown direction": ({"carrier": {"z": 1}}, r"study\.start\.carrier\.z: .*known: vx, vy, x, y"),
    "mass": ({"p1": "3 kg"}, r"study\.start\.p1\.angle: given '3 kg'; .*this one is a mass"),
    "NaN": ({"p1": math.nan}, r"study\.start\.p1\.angle: given nan; must be a finite angle"),
    "list": ({"p1": [1.0]}, r"study\.start\.p1\.angle: given \[1\.0\]"),
    "bool": ({"p1": True}, r"study\.start\.p1\.angle: given True"),
    "carrier a number": ({"carrier": 1}, r"study\.start\.carrier: given 1; must be a table"),
    "psi beside a body": ({"psi": 1, "p2": 1}, r"study\.start\.p2: .*either psi and delta"),
    "psi in kg": ({"psi": "1 kg"}, r"study\.start\.psi: given '1 kg'"),
}


@pytest.mark.parametrize(("start", "says"), WRONG.values(), ids=WRONG.keys())
def test_a_wrong_start_is_located(drum: Machine, start: dict[str, Any], says: str) -> None:
    with pytest.raises(InputError, match=says):
        initial_state(drum, start)


@pytest.mark.parametrize("start", [{"drum": 1}, {"drum": {"speed": 1}}, {"drum": {"angle": 0}}])
def test_a_prescribed_body_has_no_start(study: Study, start: dict[str, Any]) -> None:
    machine = load_machine(str(study(LINEAR, 'kind = "constant-speed"\nspeed = 100\n')))
    with refused("study.start.drum"):
        initial_state(machine, start)


def test_a_prescribed_follower_starts_where_its_drive_says(study: Study) -> None:
    drive = 'on = "p1"\nkind = "constant-speed"\nspeed = "100 rad/s"\nangle = "90 deg"\n'
    state = _state(load_machine(str(study(LINEAR, drive))), {"drum": 1.0})
    assert state["p1.angle"] == pytest.approx(math.pi / 2)
