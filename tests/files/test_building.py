"""Parameters set by path before the machine is built, down into tables, lists and pairs, and refused otherwise."""

import pytest

from wucht.files.building import machine_from

SCREEN = {
    "carrier": {
        "directions": "xyr", "mass": 30.0, "inertia": 3.0,
        "mounts": [
            {"at": [-0.5, -0.2], "stiffness": [2e3, 5e3], "damping": [3.0, 7.0]},
            {"at": [0.5, -0.3], "stiffness": [1e3, 8e3]},
        ],
    },
    "bodies": [
        {"kind": "rotor", "name": "left", "mass": 2.0, "eccentricity": 0.02, "inertia": 0.01, "position": [-0.3, 0.1]},
        {"kind": "pendulum", "name": "p1", "about": "left", "mass": 0.1, "length": 0.1, "track": "t", "diameter": 0.02},
        {"kind": "pendulum", "name": "p2", "about": "left", "mass": 0.1, "length": 0.1, "track": "t", "diameter": 0.02,
         "release": {"time": 3.0}},
    ],
    "drive": {"kind": "linear", "on": "left", "slope": 0.05, "no_load_speed": 80.0},
    "loads": [
        {"kind": "viscous", "on": "left", "coefficient": 0.01},
        {"kind": "quadratic", "on": "left", "coefficient": 1e-4},
    ],
}  # fmt: skip
SHAKEN = {
    "carrier": {
        "directions": "xy", "stiffness": [4e3, 6e3], "damping": 20.0,
        "motion": {"direction": "x", "amplitude": "1 mm", "frequency": 31.0},
        "foundation": {"direction": "y", "mass": 40.0, "stiffness": 3e4},
    },
    "bodies": [{"kind": "rotor", "name": "left", "mass": 2.0, "unbalance": 0.02, "inertia": 0.01}],
    "load": {"kind": "viscous", "on": "left", "coefficient": 0.01},
}  # fmt: skip


def set_in(document, **settings):
    return machine_from(document | {"set": settings})


@pytest.mark.parametrize(
    ("document", "path", "value", "expected"),
    [
        (SCREEN, "carrier.mounts.1.stiffness.x", "7 N/mm", 7e3),
        (SCREEN, "carrier.mounts.1.at.y", "-3 cm", -0.03),
        (SCREEN, "left.eccentricity", "3 mm", 3e-3),
        (SCREEN, "loads.left.quadratic.coefficient", 0.25, 0.25),
        (SCREEN, "tracks.t.contact_frequency", 5e3, 5e3),
        (SCREEN, "p2.release.time", "2 min", 120.0),
    ],
)
def test_a_value_is_set_and_nothing_else(document, path, value, expected):
    before = machine_from(document).values
    after = set_in(document, **{path: value}).values
    if path.startswith("tracks"):
        assert after.pop(path) == before.pop(path) * 0 + expected
    else:
        assert after[path] == pytest.approx(expected, rel=1e-14)
    derived = {k for k in before if k.startswith("tracks.")}  # the contacts follow the operating speed
    assert {k for k in after if before.get(k) != after[k]} - derived <= {path}


@pytest.mark.parametrize(
    ("document", "given"),
    [
        (SCREEN, {"drive": {"transmission": {"ratio": 2.0, "inertia": 0.01, "efficiency": 0.9}}}),
        (SCREEN, {"p1": {"release": {"speed": 20.0}}}),
        (
            SHAKEN | {"carrier": {"mass": 1.0, "stiffness": 1e3}},
            {"carrier": {"foundation": {"direction": "y", "mass": 40.0, "stiffness": 3e4}}},
        ),
    ],
)
def test_a_table_that_a_part_may_have_is_made(document, given):
    """As if the file had it, whether set as a table or key by key."""
    ((part, table),) = given.items()
    ((key, values),) = table.items()
    whole = machine_from(document | {"set": {f"{part}.{key}": values}})
    assert set_in(document, **{f"{part}.{key}.{k}": v for k, v in values.items()}).values == whole.values
    assert whole.values.keys() > machine_from(document).values.keys()
