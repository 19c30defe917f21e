"""Parameters set by path before the machine is built, down into tables, lists and pairs, and refused otherwise."""

import copy

import pytest
from tests.refusals import refused

from wucht.files.building import machine_from, with_settings

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
        (SCREEN, "carrier.mounts.2.stiffness.y", 9.0, 9.0),
        (SCREEN, "carrier.mounts.1.at.y", "-3 cm", -0.03),
        (SCREEN, "carrier.mass", "40 kg", 40.0),
        (SCREEN, "left.position.x", 0.7, 0.7),
        (SCREEN, "left.eccentricity", "3 mm", 3e-3),
        (SCREEN, "drive.slope", 0.07, 0.07),
        (SCREEN, "loads.left.viscous.coefficient", 0.5, 0.5),
        (SCREEN, "loads.left.quadratic.coefficient", 0.25, 0.25),
        (SCREEN, "tracks.t.contact_frequency", 5e3, 5e3),
        (SCREEN, "p1.restitution", 0.75, 0.75),
        (SCREEN, "p2.release.time", "2 min", 120.0),
        (SHAKEN, "carrier.motion.amplitude", "2 cm", 0.02),
        (SHAKEN, "carrier.motion.frequency", "20 rad/s", 20.0),
        (SHAKEN, "carrier.foundation.mass", 55.0, 55.0),
        (SHAKEN, "carrier.stiffness.y", 7.0, 7.0),
        (SHAKEN, "load.coefficient", 0.03, 0.03),
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


def test_a_table_sets_as_its_paths_do():
    nested = machine_from(SCREEN | {"set": {"carrier": {"mass": 40.0}, "drive": {"slope": 0.07}}})
    assert nested.values == set_in(SCREEN, **{"carrier.mass": 40.0, "drive.slope": 0.07}).values


def test_every_parameter_of_a_machine_can_be_set_by_its_path():
    """All but those that follow from others: contact offsets and locks."""
    for document in (SCREEN, SHAKEN):
        machine = machine_from(document)
        settable = [p for p in machine.values if not p.startswith("tracks.") and not p.endswith(".locked")]
        settable = [p for p in settable if p not in ("p1.restitution", "p2.restitution", "carrier.mounts.2.damping.x")]
        same = {p: machine.values[p] for p in settable if not (p.startswith("carrier.mounts.2.damping"))}
        same = {p: v for p, v in same.items() if p != "p1.inertia"}
        assert machine_from(document | {"set": same}).values == pytest.approx(machine.values, rel=1e-14)


def test_the_document_given_stays():
    given = copy.deepcopy(SCREEN)
    with_settings(given, {"carrier.mounts.1.stiffness.x": 1.0, "tracks.t.contact_frequency": 5.0})
    assert given == SCREEN


@pytest.mark.parametrize(
    ("table", "before", "path", "after"),
    [
        ("drive", {"file": "a.csv"}, "drive.points", {"points": [[0, 1], [2, 0]]}),
        ("drive", {"points": [[0, 1], [2, 0]]}, "drive.file", {"file": "a.csv"}),
        ("carrier", {"table": "a.csv"}, "carrier.motion.points", {"points": [[0, 0], [1, 2]]}),
        ("carrier", {"points": [[0, 0], [1, 2]]}, "carrier.motion.table", {"table": "a.csv"}),
    ],
)
def test_points_and_the_file_that_has_them_replace_each_other(table, before, path, after):
    inside = {"kind": "table", "on": "left"} if table == "drive" else {"direction": "x"}
    (value,) = after.values()
    described = {"drive": inside | before} if table == "drive" else {"carrier": {"mass": 1.0, "motion": inside | before}}
    given = with_settings(SHAKEN | described, {path: value})[table]
    assert (given if table == "drive" else given["motion"]) == inside | after


def test_loads_without_a_body_are_on_the_only_rotor():
    loads = [{k: v for k, v in x.items() if k != "on"} for x in SCREEN["loads"]]
    machine = machine_from(SCREEN | {"loads": loads})
    assert machine.values == machine_from(SCREEN).values
    assert machine_from(SCREEN | {"loads": loads, "set": {"loads.left.viscous.coefficient": 0.5}}).values[
        "loads.left.viscous.coefficient"
    ] == 0.5  # fmt: skip


@pytest.mark.parametrize(
    ("path", "value", "refusal"),
    [
        (
            "carrier.mounts.3.stiffness.x",
            1.0,
            refused("machine.set.carrier.mounts.3.stiffness.x", given=1.0, code="unknown-parameter"),
        ),
        (
            "carrier.mounts.0.stiffness.x",
            1.0,
            refused("machine.set.carrier.mounts.0.stiffness.x", given=1.0, code="unknown-parameter"),
        ),
        (
            "carrier.mounts.1.stifness.x",
            1.0,
            refused("machine.set.carrier.mounts.1.stifness.x", "stiffness", given=1.0, code="unknown-parameter"),
        ),
        (
            "carrier.mounts.1.stiffness.z",
            1.0,
            refused("machine.set.carrier.mounts.1.stiffness.z", given=1.0, code="unknown-parameter"),
        ),
        ("carrier.mas", 1.0, refused("machine.carrier.mas", "mass", code="unknown-key")),
        ("lefd.mass", 1.0, refused("machine.set.lefd.mass", "left", given=1.0, code="unknown-parameter")),
        ("drive.slope.x", 1.0, refused("machine.set.drive.slope.x", given=1.0, code="pair")),
        (
            "tracks.u.contact_frequency",
            1.0,
            refused("machine.set.tracks.u.contact_frequency", given=1.0, code="unknown-parameter"),
        ),
        ("tracks.t.frequency", 1.0, refused("machine.tracks.t.frequency", "contact_frequency", given=1.0, code="unknown-key")),
        ("tracks.t.contact_frequency", -1.0, refused("machine.tracks.t.contact_frequency", given=-1.0)),
        ("tracks.t.contact_frequency", "3 kg", refused("machine.tracks.t.contact_frequency", given="3 kg", code="dimension")),
        ("loads.left.coefficient", 1.0, refused("machine.set.loads.left.coefficient", given=1.0, code="unknown-parameter")),
        ("study.until", 1.0, refused("machine.set.study.until", given=1.0, code="study-key")),
        ("drive.slope", float("inf"), refused("machine.drive.slope", code="not-finite")),
        ("carrier.mass", "7 m", refused("machine.carrier.mass", code="dimension")),
        (
            "drive.transmission.efficiency",
            0.9,
            refused("machine.drive.transmission.ratio", code="missing"),
        ),
        (
            "drive.transmission.ratoi",
            2.0,
            refused("machine.set.drive.transmission.ratoi", "ratio", given=2.0, code="unknown-parameter"),
        ),
        ("drive.transmission.ratio", "2 m", refused("machine.drive.transmission.ratio", code="dimension")),
        ("drive.transmission.ratio", 0, refused("machine.drive.transmission.ratio", code="limits")),
        (
            "drive.transmission.ratio.x",
            1.0,
            refused("machine.set.drive.transmission.ratio.x", given=1.0, code="unknown-parameter"),
        ),
        (
            "drive.transmision.ratio",
            2.0,
            refused("machine.set.drive.transmision.ratio", "transmission", given=2.0, code="unknown-parameter"),
        ),
        (
            "loads.left.viscous.transmission.ratio",
            2.0,
            refused("machine.set.loads.left.viscous.transmission.ratio", given=2.0, code="unknown-parameter"),
        ),
        ("carrier.mounts.1.at.z", 1.0, refused("machine.set.carrier.mounts.1.at.z", given=1.0, code="unknown-parameter")),
        ("drive.stator.x", 1.0, refused("machine.set.drive.stator.x", given=1.0, code="unknown-parameter")),
    ],
)
def test_paths_that_lead_nowhere_are_refused(path, value, refusal):
    with refusal:
        set_in(SCREEN, **{path: value})
