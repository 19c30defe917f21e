"""The material on a screen: a mass and a damper more, with all of its weight."""

import copy

import numpy as np
import pytest
import sympy as sp

from witness import moved
from wucht import Response, run
from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.files.building import machine_from

SCREEN = {
    "carrier": {"mass": 30.0, "stiffness": [8e3, 1e4], "damping": [20.0, 30.0]},
    "bodies": [{"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 0.04, "inertia": 0.05, "bearing_damping": 0.01}],
    "drive": {"kind": "linear", "slope": 0.2, "no_load_speed": 90.0},
}
LAYER = {"kind": "material-layer", "name": "sand", "mass": 10.0, "share": 0.3, "damping": 700.0}
LOADED = SCREEN | {"attachments": [LAYER]}
HEAVIER = SCREEN | {"carrier": {"mass": 33.0, "stiffness": [8e3, 1e4], "damping": [720.0, 730.0]}}


def test_it_is_a_carrier_with_more_mass_and_damping() -> None:
    """States, works and bearing forces: what a layer does to the carrier is none of them."""
    loaded, heavier = moved(LOADED), moved(HEAVIER)
    assert loaded.keys() == heavier.keys()
    for name, values in heavier.items():
        assert loaded[name] == pytest.approx(values, rel=1e-9, abs=1e-12), name


def test_the_deck_bears_all_of_its_weight() -> None:
    heavy = copy.deepcopy(LOADED)
    heavy["carrier"]["gravity"] = 9.81
    assert moved(heavy, grid=np.array([0.0, 1e-6]))["carrier.y"][0] == pytest.approx(-45.0 * 9.81 / 1e4, rel=1e-12)


@pytest.mark.slow
def test_closed_forms_and_averaged_equations_know_it() -> None:
    response = [run(Response(range=(5.0, 60.0)), machine_from(m)).wucht.summary for m in (LOADED, HEAVIER)]
    assert response[0]["peak_amplitude"] == pytest.approx(response[1]["peak_amplitude"], rel=1e-12)
    assert response[0]["critical_speeds"] == pytest.approx(response[1]["critical_speeds"], rel=1e-9)
    averaged_equations = [averaged_equations_of(machine_from(m)) for m in (LOADED, HEAVIER)]
    speed = sp.Symbol("drum.speed", real=True)
    rates = []
    for s in averaged_equations:
        values = dict(zip(s.system.parameters, s.values(), strict=True)) | {speed: 40.0}
        rates.append(float(s.system.explicit(s.system.derivatives[0]).xreplace(values)))
    assert rates[0] == pytest.approx(rates[1], rel=1e-12)


def test_on_a_screen_that_turns_it_is_where_it_lies() -> None:
    planar = {"directions": "xyr", "mass": 30.0, "inertia": 4.0, "stiffness": 8e3, "rotation_stiffness": 2e3, "gravity": 9.81}
    machine = machine_from(SCREEN | {"carrier": planar, "attachments": [LAYER | {"at": ["-0.3 m", "0.1 m"]}]})
    (_, vx), (_, vy), (chi, turning) = ((c.position, c.velocity) for c in machine.carrier)
    y = machine.carrier[1].position
    layer, numbers = machine.energies[-1], machine.numbers
    square = (vx - 0.1 * turning) ** 2 + (vy - 0.3 * turning) ** 2
    assert sp.expand(layer.kinetic.xreplace(numbers) - 0.3 * 10.0 * square / 2) == 0
    assert sp.expand(layer.dissipation.xreplace(numbers) - 700.0 * square / 2) == 0
    weight = [float(sp.diff(layer.potential.xreplace(numbers), q)) for q in (y, chi)]
    assert weight == pytest.approx([98.1, -0.3 * 98.1], rel=1e-12)
