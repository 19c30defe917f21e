"""Compiled once a structure: values never compile again."""

from __future__ import annotations

import itertools
from importlib.util import find_spec

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import available_engine, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import ABSOLUTE, PiecewiseCubic
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


def test_other_values_get_the_same_flow(engine):
    first, other = rotor(0.02, 1e5), rotor(0.5, 2e4, bearing_damping=0.1)
    assert first.system is other.system
    assert compile_system(first.system, engine=engine) is compile_system(other.system, engine=engine)


def test_another_structure_gets_another_flow():
    flows = [
        compile_system(rotor(0.02, stiffness, **body).system, engine="scipy")
        for stiffness, body in ((1e5, {}), ([1e5, 1e5], {}), (1e5, {"eccentricity": None, "unbalance": 0.01}))
    ]
    assert len({id(f) for f in flows}) == 3


def test_other_events_tolerance_or_engine_get_another_flow():
    flows = [
        compile_system(SPRING, engine="scipy"),
        compile_system(SPRING, 1e-6, engine="scipy"),
        compile_system(SPRING, events=(Event("middle", x),), engine="scipy"),
        compile_system(SPRING, engine="scipy-radau"),
        compile_system(SPRING, engine="compiled"),
    ]
    assert len({id(f) for f in flows}) == 5


def test_one_flow_many_values(any_engine):
    """x'' = -k x from x = 1: at t = 1, x = cos(sqrt k)."""
    flow = compile_system(SPRING, 1e-10, engine=any_engine)
    for stiffness in (1.0, 4.0, 0.25):
        run = integrate(flow, [1.0, 0.0], {"k": stiffness}, np.array([0.0, 1.0]))
        assert run.states[0, -1] == pytest.approx(np.cos(np.sqrt(stiffness)), abs=1e-9)


def test_without_a_choice_the_best_engine_is_taken():
    assert compile_system(SPRING).engine.name == available_engine()
    assert available_engine() == ("heyoka" if find_spec("heyoka") else "compiled" if find_spec("llvmlite") else "scipy")


@pytest.mark.skipif(not (find_spec("heyoka") and find_spec("llvmlite")), reason="needs both engines")
@pytest.mark.parametrize(
    ("system", "events", "engine"),
    [
        (SPRING, (), "heyoka"),
        (SPRING, (Event("passes", x),), "heyoka"),
        (SPRING, (Event("ends", x, terminal=True),), "compiled"),
        (SPRING, (Event("acts", x, action=lambda time, state, parameters: (state, parameters)),), "compiled"),
        (System((x, v), (v, -k * PiecewiseCubic(x, ABSOLUTE)), (k,)), (), "compiled"),
    ],
    ids=["nothing", "recorded", "terminal", "action", "breakpoint"],
)
def test_what_is_interrupted_is_integrated_by_the_compiled_engine(system, events, engine):
    assert compile_system(system, events=events).engine.name == engine
    assert compile_system(system, events=events, engine="heyoka").engine.name == "heyoka"


def test_an_unknown_engine_is_refused():
    with rejected("unknown-engine", "euler"):
        compile_system(SPRING, engine="euler")


def test_definitions_that_use_one_another_are_never_written_out():
    """Fifty, each a product with the one before: written out they have 2^50 terms. An angle's unit is known all the same."""
    pytest.importorskip("heyoka")
    from wucht.numerics.flow.heyoka_engine import state_units

    theta, omega, slip = sp.symbols("theta omega slip", real=True)
    names = sp.symbols("d0:50", real=True)
    chain = [(names[0], sp.sin(theta)), *((b, a * (a + omega)) for a, b in itertools.pairwise(names))]
    twice = sp.Symbol("twice", real=True)
    system = System(
        (theta, omega, slip), (twice, names[-1] - omega, omega + names[-1]), (),
        (*chain, (twice, 2 * omega)), angles=frozenset({theta, slip}),
    )  # fmt: skip
    assert state_units(system).tolist() == [2.0**20, 1.0, 1.0]
