"""Cycles of machines with two rotors, by hand: the heat in their circuits, and where the way down begins and ends."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import sympy as sp

from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.start_stop_cases import SLOW_EVENT, drives_without_circuit, stop_case, with_circuit_heat
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

ROTORS = [
    {"kind": "rotor", "name": n, "mass": 1.0, "unbalance": 1e-3, "inertia": 0.1, "position": [x, 0.0]}
    for n, x in (("a", -0.5), ("b", 0.5))
]
CARRIER = {
    "directions": "xyr", "mass": 10.0, "inertia": 2.0, "stiffness": 1e4, "damping": 10.0, "rotation_stiffness": 1e3,
    "rotation_damping": 1.0,
}  # fmt: skip
DC = {"kind": "dc-separate", "armature_resistance": 2.0, "motor_constant": 1.0, "flux": 0.5}


def machine(**more: Any) -> Machine:
    drives = [
        DC | {"on": "a", "voltage": 100.0, "transmission": {"ratio": 2.0}, "stator": "carrier"},
        DC | {"on": "b", "voltage": -80.0},
    ]
    return machine_from({"carrier": CARRIER, "bodies": ROTORS, "drives": drives} | more)


def test_the_heat_is_that_of_all_circuits_at_the_speeds_of_their_motors() -> None:
    """(U - k Phi w)^2/R_A: behind a gear the motor is twice as fast as its rotor, on a carrier its stator turns with that."""
    of = machine()
    heat = with_circuit_heat(of).quadratures[-1].expression
    speeds = {of.body("a").coordinate.velocity: 30.0, of.body("b").coordinate.velocity: -50.0, of.frame.rotation: 4.0}
    found = sp.sympify(heat).xreplace({s: sp.Float(x) for s, x in speeds.items()}).xreplace(of.numbers)
    assert float(found) == pytest.approx((100 - 0.5 * 2 * (30 - 4)) ** 2 / 2 + (-80 + 0.5 * 50) ** 2 / 2)
    assert drives_without_circuit(of) == []


def test_all_drives_that_have_no_circuit_are_known() -> None:
    linear = [{"on": n, "kind": "linear", "slope": 0.1, "no_load_speed": 50.0} for n in ("a", "b")]
    assert [d.on for d in drives_without_circuit(machine(drives=linear))] == ["a", "b"]
    assert [d.on for d in drives_without_circuit(machine(drives=[DC | {"on": "a", "voltage": 1.0}, linear[1]]))] == ["b"]


def stopped(of: Machine, speeds: tuple[float, float], time: float = 1.0) -> Any:
    states = np.zeros((len(of.state_names), 2))
    for name, speed in zip(("a", "b"), speeds, strict=True):
        states[of.row(of.body(name).coordinate.velocity), -1] = speed
    values = np.array(of.system.values(of.values))
    end: Any = SimpleNamespace(end_time=time, states=states, final_parameter_values=values)
    return stop_case(of, end, RunSettings())


def slow_value(case: Any, a: float, b: float) -> float:
    (event,) = (e for e in case.horizon.events if e.name == SLOW_EVENT)
    coasting, [model] = case.machine, case.models
    at = {coasting.body(n).coordinate.velocity: w for n, w in (("a", a), ("b", b))}
    at |= dict(zip(model.system.parameters[-len(model.further_values) :], model.further_values, strict=True))
    assert (event.direction, event.terminal) == (-1, True)
    return float(sp.sympify(event.expression).subs(at))


def test_the_way_down_ends_where_the_rotors_are_slow_in_the_mean_square() -> None:
    """100 rad/s clockwise and 40 rad/s at the switch-off: both at 1 % of that, or one of them at rest and one at 1.41 %."""
    case = stopped(machine(), (-100.0, 40.0))
    assert slow_value(case, -1.0, 0.4) == pytest.approx(0.0, abs=1e-12)
    assert slow_value(case, 0.0, 0.4 * 2**0.5) == pytest.approx(0.0, abs=1e-12)
    assert slow_value(case, -1.5, 0.4) > 0 > slow_value(case, 0.9, -0.3)
    assert case.machine.drives == ()
    assert [float(case.models[0].initial[case.machine.row(r.coordinate.velocity)]) for r in case.machine.rotors] == [
        -100.0,
        40.0,
    ]


def test_a_rotor_that_rests_at_the_switch_off_does_not_count() -> None:
    case = stopped(machine(), (0.0, -40.0))
    assert case.models[0].further_values == (-40.0,)
    assert stopped(machine(), (0.0, 0.0)) is None


def test_schedules_stay_as_they_are_at_the_switch_off() -> None:
    ramp = {"parameter": "carrier.damping", "points": [[0.0, 10.0], [2.0, 50.0]]}
    of = machine(schedules=[ramp])
    for time, damping in ((0.5, 20.0), (2.0, 50.0), (9.0, 50.0)):
        case = stopped(of, (100.0, 40.0), time)
        assert case.machine.values["carrier.damping"] == pytest.approx(damping) and case.machine.schedules == ()


def test_bodies_that_are_locked_at_the_switch_off_stay_so() -> None:
    balls = [
        {"kind": "pendulum", "name": n, "about": "a", "mass": 0.1, "length": 0.1, "damping": 0.01, "release": {"speed": 20.0}}
        for n in ("p", "q")
    ]
    of = machine(bodies=[*ROTORS, *balls]).with_unchecked_values({"p.locked": 0.0, "q.locked": 1.0})
    left = stopped(of, (10.0, 40.0)).machine.values
    assert (left["p.locked"], left["q.locked"]) == (0.0, 1.0)
