"""Parts: their energies are those of the bodies they stand for, and values that no body can have are refused."""

import copy

from tests.refusals import refused

from wucht.files.building import machine_from

MACHINE = {
    "carrier": {"mass": 1.0, "stiffness": [4e3, 9e3], "damping": [3.0, 5.0], "gravity": 9.81},
    "bodies": [
        {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.1, "inertia": 0.5, "bearing_damping": 0.01},
        {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.5, "length": 0.2, "inertia": 0.03, "damping": 0.02},
        {"kind": "roller", "name": "r", "about": "drum", "mass": 0.25, "track_radius": 0.3, "radius": 0.1, "damping": 0.03},
    ],
    "drive": {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0},
}


def changed(path, value, base=MACHINE):
    """A copy with one key set (or, with None, removed): ``bodies.1.mass``."""
    document = copy.deepcopy(base)
    target = document
    *way, last = (int(key) if key.isdigit() else key for key in path.split("."))
    for key in way:
        target = target[key]
    if value is None:
        del target[last]
    else:
        target[last] = value
    return document


def test_limits_themselves_are_allowed():
    """J = m e^2 is a point mass on a massless arm."""
    assert machine_from(changed("bodies.0.inertia", 0.02)).values["drum.inertia"] == 0.02
    assert machine_from(changed("bodies.1.inertia", 0.02)).values["p.inertia"] == 0.02
    assert machine_from(changed("bodies.2.shape_factor", 1.0)).values["r.shape_factor"] == 1.0


def test_bodies_may_not_turn_about_each_other_in_a_circle():
    with refused("machine.bodies[1] (p).about", given="r"):
        machine_from(changed("bodies.1.about", "r", changed("bodies.2.about", "p")))
