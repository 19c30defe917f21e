"""Compiled once a structure: values never compile again."""

from __future__ import annotations

import pytest
import sympy as sp
import xarray as xr
from tests.refusals import rejected

from wucht.files.building import machine_from
from wucht.numerics import flow
from wucht.numerics.flow.compiled_system import compile_system
from wucht.system import System

x, v = sp.symbols("x v", real=True)
k = sp.Symbol("k", real=True)
SPRING = System((x, v), (v, -k * x), (k,))


def rotor(slope, stiffness, **more):
    return machine_from(
        {
            "carrier": {"stiffness": stiffness, "damping": 200.0},
            "bodies": [{"kind": "rotor", "name": "drum", "mass": 9.75, "eccentricity": 1e-3, "inertia": 0.01, **more}],
            "drive": {"kind": "linear", "slope": slope, "no_load_speed": 200.0},
        }
    )


def test_other_values_get_the_same_flow():
    first, other = rotor(0.02, 1e5), rotor(0.5, 2e4, bearing_damping=0.1)
    assert first.system is other.system
    assert compile_system(first.system) is compile_system(other.system)


def test_an_unknown_engine_is_refused():
    with rejected("unknown-engine", "euler"):
        compile_system(SPRING, engine="euler")


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(("earlier", "present"), [("heyoka", "compiled"), ("scipy-radau", "radau")])
def test_an_earlier_name_of_an_engine_warns_once_and_is_the_present_one(earlier, present, wucht, study):
    compile_system.cache_clear()
    sentence = f"the engine '{earlier}' is now '{present}'"
    with pytest.warns(FutureWarning, match=sentence) as by_call:
        assert compile_system(SPRING, engine=earlier).engine_name == present
    study('until = "0.5 s"', f'until = "0.1 s"\nengine = "{earlier}"\ntolerance = 1e-6')
    with pytest.warns(FutureWarning, match=sentence) as by_file:
        done = wucht("run", "study.toml", "-o", "out", "--json")
    assert done.code == 0, done.err
    with xr.open_dataset("out/result.nc") as result:
        assert result.attrs["engine"] == present
    assert len(by_call) == len(by_file) == 1


def test_the_earlier_choice_of_an_engine_warns():
    with pytest.warns(DeprecationWarning, match=r"available_engine is no longer needed: there is one engine, 'compiled'"):
        assert flow.available_engine(True) == "compiled"
