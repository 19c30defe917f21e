"""001, section 2.1: the rocking machine of Bild 1b maps onto the translating one of Bild 1a.

(8)-(9): J_i phi_i'' = L_i + U_i x'' sin phi_i, M x'' = f + sum U_i (phi_i'^2 cos phi_i + phi_i'' sin phi_i).
(10)-(11): the same with 2 J_i, 2 L_i, D_i = m_i e_i a_i and chi, Theta. With a length s: x = s chi, M = Theta/s^2, U_i = D_i/s.
"""

import math

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.files.building import machine_from
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

few = settings(
    max_examples=12, deadline=None, suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.generate),
)  # fmt: skip


def numbers(low, high):
    return st.integers(0, 1000).map(lambda i: low + (high - low) * i / 1000)


def moved(document, start, time):
    machine = machine_from(document)
    run = integrate(compile_system(machine.system), initial_state(machine, start), machine.values, time)
    assert run.failure is None
    return dict(zip(machine.system.state_names, run.states, strict=True)) | dict(run.quadratures)


@few
@given(
    st.integers(1, 3), st.lists(numbers(0.5, 2.0), min_size=9, max_size=9), numbers(0.1, 5.0), numbers(10.0, 60.0),
    numbers(0.01, 0.3), st.lists(st.sampled_from([-1, 1]), min_size=3, max_size=3), numbers(-3.0, 3.0), numbers(-1.0, 1.0),
)  # fmt: skip
def test_both_machines_have_the_same_motion(count, drawn, length, natural, ratio, senses, angle, push):
    inertia = 2.0  # Theta, in kg m^2
    couples = [0.02 * d for d in drawn[:3]]
    inertias = [0.05 * d for d in drawn[3:6]]
    drives = [
        {"kind": "linear", "on": f"r{i}", "slope": 0.1, "no_load_speed": senses[i] * natural * drawn[6 + i]}
        for i in range(count)
    ]
    rotors = [{"kind": "rotor", "name": f"r{i}", "mass": 1e-9, "inertia": inertias[i]} for i in range(count)]
    rocking = {
        "carrier": {"directions": "r", "inertia": inertia, "rotation_stiffness": inertia * natural**2,
                    "rotation_damping": 2 * ratio * natural * inertia},
        "bodies": [r | {"couple_unbalance": d} for r, d in zip(rotors, couples, strict=False)],
        "drives": drives,
    }  # fmt: skip
    mass = inertia / length**2
    own = mass - 0.01 * mass * count  # each rotor has a hundredth of the mass, and the unbalance that is asked for
    heavy = [{**r, "mass": 0.01 * mass, "unbalance": d / length} for r, d in zip(rotors, couples, strict=False)]
    heavy = [r | {"inertia": max(r["inertia"], 0.0)} for r in heavy]
    if any(r["inertia"] < r["unbalance"] ** 2 / r["mass"] for r in heavy):  # so light a rotor cannot have that unbalance
        heavy = [r | {"mass": r["unbalance"] ** 2 / r["inertia"] * 1.01} for r in heavy]
        own = mass - sum(r["mass"] for r in heavy)
    translating = {
        "carrier": {"directions": "x", "mass": own, "stiffness": mass * natural**2, "damping": 2 * ratio * natural * mass},
        "bodies": heavy,
        "drives": drives,
    }
    time = np.linspace(0, 20 * 2 * math.pi / natural, 201)
    start = {f"r{i}": angle + i for i in range(count)}
    one = moved(rocking, start | {"carrier": {"r": 0.01, "vr": push}}, time)
    other = moved(translating, start | {"carrier": {"x": 0.01 * length, "vx": push * length}}, time)
    assert np.abs(one["carrier.r"] - other["carrier.x"] / length).max() < 1e-8 * np.abs(one["carrier.r"]).max()
    for i in range(count):
        assert np.abs(one[f"r{i}.angle"] - other[f"r{i}.angle"]).max() < 1e-7
    for work in ("supplied_work", "dissipated_work"):  # the energies are the same too: M x'^2 = Theta chi'^2
        assert np.abs(one[work] - other[work]).max() < 1e-8 * np.abs(one[work]).max()
