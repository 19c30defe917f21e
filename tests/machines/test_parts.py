"""Parts: their energies are those of the bodies they stand for, and values that no body can have are refused."""

import copy

import pytest
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


@pytest.mark.parametrize(
    ("path", "value", "refusal"),
    [
        ("bodies.0.inertia", 0.0199, refused("machine.bodies[0] (drum).inertia", "2 = 0.02", given=0.0199)),
        ("bodies.2.radius", 0.3, refused("machine.bodies[2] (r).radius", "0.3 m", given=0.3)),
        ("bodies.0.unbalance", 0.2, refused("machine.bodies[0] (drum).eccentricity", given=0.1)),
        ("bodies.0.eccentricity", None, refused("machine.bodies[0] (drum).eccentricity", given=None)),
        ("bodies.1.about", "drums", refused("machine.bodies[1] (p).about", "drum", given="drums")),
        ("bodies.1.name", "r", refused("machine.bodies", given="r")),
        ("bodies.1.name", "carrier", refused("machine.bodies[1].name", given="carrier")),
        ("carrier.stiffness", [4e3, -1.0], refused("machine.carrier.stiffness", given=[4000.0, -1.0])),
        ("carrier.stiffness", [4e3, 0.0], refused("machine.carrier.stiffness", given=[4000.0, 0.0])),
        ("carrier.directions", "y", refused("machine.carrier.stiffness", "directions = 'y'", given=[4000.0, 9000.0])),
        ("drive.on", "dram", refused("machine.drive.on", "drum", given="dram")),
    ],
)
def test_impossible_values_are_refused_with_place_and_remedy(path, value, refusal):
    with refusal:
        machine_from(changed(path, value))


def test_limits_themselves_are_allowed():
    """J = m e^2 is a point mass on a massless arm."""
    assert machine_from(changed("bodies.0.inertia", 0.02)).values["drum.inertia"] == 0.02
    assert machine_from(changed("bodies.1.inertia", 0.02)).values["p.inertia"] == 0.02
    assert machine_from(changed("bodies.2.shape_factor", 1.0)).values["r.shape_factor"] == 1.0


def test_bodies_may_not_turn_about_each_other_in_a_circle():
    with refused("machine.bodies[1] (p).about", given="r"):
        machine_from(changed("bodies.1.about", "r", changed("bodies.2.about", "p")))
