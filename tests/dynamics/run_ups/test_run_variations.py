from __future__ import annotations

from tests.refusals import refused

from wucht.dynamics.run_ups.run_variations import start_states, varied_quantity
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine

ROTOR = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}


HELD = {"kind": "constant-speed", "speed": 100.0}


def test_start_states_of_a_slider() -> None:
    machine = load_machine("sperling-vibration/figure-7")
    slider, _ = machine.sliders
    states = start_states(machine)
    out, moving = states[f"{slider.name}.displacement"], states[f"{slider.name}.velocity"]
    assert states[slider.name] is out
    assert (out.unit.si, moving.unit.si) == ("m", "m/s") and out.description == f"displacement of {slider.name} at the start"
    assert moving.description == f"velocity of {slider.name} at the start"


def test_the_motion_of_a_held_body_is_not_varied() -> None:
    machine = machine_from({"carrier": {"stiffness": 1e4, "damping": 1.0}, "bodies": [ROTOR], "drive": HELD})
    for name in ("drum", "drum.angle", "drum.speed"):
        with refused("study.along", given=name, code="prescribed"):
            varied_quantity(machine, name, "along")
    with refused("study.along", given="drum.sped", code="unknown-name"):
        varied_quantity(machine, "drum.sped", "along")


def test_start_states_of_a_carrier_that_rocks() -> None:
    """Its angle and angular velocity have units of their own; without units there are none."""
    rocking = machine_from({"carrier": {"directions": "xyr", "mass": 9.0, "inertia": 1.0, "stiffness": 1e4}, "bodies": [ROTOR]})
    states = start_states(rocking)
    units = [states[f"carrier.{name}"].unit.si for name in ("x", "y", "r", "vx", "vy", "vr")]
    assert units == ["m", "m", "rad", "m/s", "m/s", "rad/s"]
    assert [states[f"carrier.{name}"].keys for name in ("r", "vr")] == [("carrier", "r"), ("carrier", "vr")]
    plain = start_states(load_machine("drozdetskaya-2020/table-5.1"))
    assert {plain[name].unit.si for name in ("carrier.x", "carrier.vx")} == {""}
