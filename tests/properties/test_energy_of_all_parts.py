"""The energy balance over machines drawn at random from all carriers, bodies, contacts, releases and schedules.

Work of the motors, of prescribed motions and of schedules, less what dampers and contacts take, is what is stored.
"""

import math

import numpy as np
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from wucht import RunUp, run
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK
from wucht.machines.schedules import SCHEDULE_WORK

few = settings(
    max_examples=10, deadline=None, suppress_health_check=list(HealthCheck),
    phases=(Phase.explicit, Phase.generate),  # each example compiles: nothing is simplified
)  # fmt: skip


def numbers(low, high):
    return st.integers(0, 1000).map(lambda i: low + (high - low) * i / 1000)


@st.composite
def carriers(draw):  # noqa: PLR0911
    gravity = draw(st.sampled_from([0.0, 9.81]))
    k, c = draw(numbers(3e3, 3e4)), draw(numbers(0.0, 60.0))
    kind = draw(st.sampled_from(["x", "xy", "xyr", "mounts", "foundation", "shaken", "points", "r", "fixed"]))
    common = {"gravity": gravity}
    if kind in ("x", "xy"):
        return common | {"directions": kind, "mass": 1.0, "stiffness": k, "damping": c}
    if kind == "xyr":
        return common | {"directions": "xyr", "mass": 5.0, "inertia": 0.5, "stiffness": [k, 2 * k], "damping": c,
                         "rotation_stiffness": k / 10, "rotation_damping": c / 100}  # fmt: skip
    if kind == "mounts":
        mounts = [{"at": [s * 0.3, -0.1], "stiffness": [k / 2, k], "damping": [c, c]} for s in (-1, 1)]
        return common | {"directions": "xyr", "mass": 5.0, "inertia": 0.5, "mounts": mounts}
    if kind == "foundation":
        foundation = {"direction": "y", "mass": 20.0, "stiffness": 3 * k, "damping": c}
        return common | {"mass": 1.0, "stiffness": k, "damping": c, "foundation": foundation}
    if kind == "shaken":
        motion = {"direction": "x", "amplitude": 1e-3, "frequency": draw(numbers(10.0, 60.0))}
        return common | {"mass": 1.0, "stiffness": k, "damping": c, "motion": motion}
    if kind == "points":
        points = [[0.1 * i - 0.1, draw(numbers(-1e-3, 1e-3))] for i in range(20)]
        return common | {"mass": 1.0, "stiffness": k, "damping": c, "motion": {"direction": "y", "points": points}}
    if kind == "r":
        return common | {"directions": "r", "inertia": 0.5, "rotation_stiffness": k / 10, "rotation_damping": c / 100}
    return common | {"directions": "fixed"}


@st.composite
def about_the_drum(draw):  # noqa: PLR0911
    """A balancing body, or two on a track, with a start that does not overlap."""
    kind = draw(st.sampled_from(["pendulum", "off", "slider", "roller", "track", "rollers", "chain"]))
    m, arm, b = draw(numbers(0.05, 0.3)), draw(numbers(0.05, 0.15)), draw(numbers(0.0, 0.05))
    pendulum = {"kind": "pendulum", "about": "drum", "mass": m, "length": arm, "damping": b}
    release = draw(st.sampled_from([{}, {"release": {"time": 0.25}}, {"release": {"speed": 20.0}}]))
    if kind == "pendulum":
        return [pendulum | {"name": "p"} | release], {"p": 1.0}
    if kind == "off":
        return [pendulum | {"name": "p", "suspension": [0.05, -0.02]} | release], {"p": 1.0}
    if kind == "slider":
        slider = {"kind": "slider", "name": "s", "about": "drum", "mass": m, "radius": arm, "stiffness": 5e3, "damping": 40 * b}
        return [slider | {"angle": 1.0}], {"s": {"velocity": 0.1}}
    roller = {"kind": "roller", "about": "drum", "mass": m, "track_radius": arm, "radius": arm / 5, "damping": b / 10}
    if kind == "roller":
        return [roller | {"name": "p"}], {"p": 1.0}
    if kind == "rollers":
        return [roller | {"name": n, "track": "t", "restitution": 0.6} for n in "pqr"], {"p": 0.0, "q": 1.0, "r": 2.0}
    if kind == "track":
        tracked = pendulum | {"track": "t", "diameter": arm / 4, "restitution": draw(numbers(0.1, 1.0))}
        return [tracked | {"name": "p"}, tracked | {"name": "q"} | release], {"p": 1.0, "q": {"angle": 1.4}}
    return [pendulum | {"name": "p"} | release, pendulum | {"name": "q", "about": "p"} | release], {"p": 1.0, "q": -1.0}


@st.composite
def machines(draw):
    carrier, (bodies, start) = draw(carriers()), draw(about_the_drum())
    drum = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": draw(numbers(0.0, 0.02)), "inertia": 0.02}
    if carrier.get("directions") in ("xyr", "r"):
        drum |= {"position": [0.2, 0.1]}
    drive = draw(st.sampled_from([
        {"kind": "linear", "slope": 0.1, "no_load_speed": 60.0},
        {"kind": "linear", "slope": 0.1, "no_load_speed": -60.0},
        {"kind": "constant-speed", "speed": 40.0},
        {"kind": "dc-series", "voltage": 24.0, "armature_resistance": 1.0, "field_resistance": 0.5, "field_inductance": 0.02,
         "motor_constant": 2.0},
    ]))  # fmt: skip
    schedules = []
    how = draw(st.sampled_from(["none", "linear", "steps", "smooth"]))
    if how != "none":
        schedules.append(
            {"parameter": "drum.unbalance", "points": [[0.1, 0.0], [0.3, 0.02], [0.55, 0.01]], "interpolation": how}
        )
        if isinstance(carrier.get("stiffness"), float):
            points = [[0.1, carrier["stiffness"]], [0.4, carrier["stiffness"] / 3]]
            schedules.append({"parameter": "carrier.stiffness", "points": points, "interpolation": how})
    loads = [{"kind": "coulomb", "on": "drum", "torque": 0.05}] if draw(st.booleans()) else []
    document = {"carrier": carrier, "bodies": [drum, *bodies], "drive": drive, "loads": loads, "schedules": schedules}
    return document, start


@few
@given(machines())
def test_energy_is_booked_completely(drawn):
    document, start = drawn
    result = run(RunUp(until=0.8, start=start), machine_from(document))
    assert result.attrs["failure"] == ""
    stored, supplied, lost = (result[n].values for n in ("stored_energy", SUPPLIED_WORK, DISSIPATED_WORK))
    scheduled = result[SCHEDULE_WORK].values if SCHEDULE_WORK in result else 0.0
    gap = supplied + scheduled - lost - (stored - stored[0])
    assert np.abs(gap).max() < 1e-9 * max(np.abs(supplied).max(), np.abs(stored).max(), np.abs(lost).max())
    assert math.isfinite(float(stored[-1]))
