"""When a machine changes for the last time."""

import pytest
import sympy as sp

from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.changes import last_change, laws_in_pieces
from wucht.piecewise import PiecewiseCubic

HELD = {"kind": "pendulum", "name": "a", "about": "d", "mass": 0.1, "length": 0.1, "damping": 0.01}
SCHEDULE = {"parameter": "drive.slope", "points": [[0, 0.01], [3, 0.02], [5, 0.02]]}


@pytest.mark.parametrize(
    ("releases", "schedules", "last"),
    [
        ([], [], 0.0),
        ([], [SCHEDULE], 5.0),
        ([{"time": 2.0}], [], 2.0),
        ([{"time": 2.0}, {"time": 4.0}], [], 4.0),
        ([{"time": 2.0}], [SCHEDULE], 5.0),
        ([{"time": 7.0}], [SCHEDULE], 7.0),
        ([{"speed": 7.0}], [SCHEDULE], 5.0),
        ([{"speed": 7.0}], [], 0.0),
    ],
)
def test_a_machine_changes_for_the_last_time_with_a_schedule_or_a_timed_release(releases, schedules, last):
    """When a speed is reached nobody knows before."""
    rotor = {"kind": "rotor", "name": "d", "mass": 2.0, "unbalance": 0.01, "inertia": 0.02}
    balls = [HELD | {"name": f"a{i}", "release": release} for i, release in enumerate(releases)]
    drive = {"on": "d", "kind": "linear", "slope": 0.01, "no_load_speed": 50.0}
    document = {"carrier": {"stiffness": 1e4}, "bodies": [rotor, *balls], "drive": drive, "schedules": schedules}
    assert last_change(machine_from(document)) == last


DRUM = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.03}
LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 45.0}
SERIES = {
    "kind": "dc-series", "voltage": 42.0, "armature_resistance": 1.5, "field_resistance": 1.0, "field_inductance": 0.05,
    "motor_constant": 1.0,
}  # fmt: skip
BALL = {
    "kind": "pendulum", "about": "drum", "mass": 0.05, "length": 0.1, "diameter": 0.02, "track": "ring", "restitution": 0.5,
    "damping": 0.01,
}  # fmt: skip
SWITCHABLE = {
    "kind": "switchable-pendulum", "name": "p", "about": "drum", "mass": 0.3, "damping": 0.02, "moving_mass": 0.2,
    "inner_stop": 0.05, "outer_stop": 0.09, "stiffness": 300.0, "preload": 20.0,
}  # fmt: skip
INVERTER = {"kind": "inverter", "set_speed": 120.0, "gain": 2.0, "integral_time": 0.3, "torque_limit": 5.0}
POINTS = [[0.0, 1.0], [50.0, 0.8], [100.0, 0.0]]
SMOOTH = [LINEAR, SERIES, LINEAR | {"transmission": {"ratio": 3.0, "inertia": 0.01}}]


def machine(drive=LINEAR, *bodies, **more):
    carrier = {"mass": 4.0, "stiffness": 4e4, "damping": 40.0}
    return machine_from({"carrier": carrier, "bodies": [DRUM, *bodies], "drive": drive} | more)


def in_pieces(machine):
    system = machine.system
    used = (*system.derivatives, *(e for _, e in system.definitions))
    return any(sp.sympify(e).has(PiecewiseCubic) for e in used)


@pytest.mark.parametrize("drive", SMOOTH, ids=["linear", "dc-series", "gear without losses"])
def test_a_machine_of_smooth_laws_has_none(drive):
    smooth = machine(drive, load={"kind": "viscous", "coefficient": 0.01})
    assert laws_in_pieces(smooth) == ()
    assert not in_pieces(smooth)


@pytest.mark.parametrize(
    ("changed", "words"),
    [
        ({"drive": SERIES, "load": {"kind": "quadratic", "coefficient": 2e-4}}, "quadratic load on drum, at standstill"),
        ({"load": {"kind": "table", "points": POINTS[::2]}}, "table load on drum"),
        ({"drive": {"kind": "table", "points": POINTS}}, "table drive on drum"),
        (
            {"drive": LINEAR | {"transmission": {"ratio": 3.0, "efficiency": 0.9}}},
            "gear of the linear drive on drum, where its torque changes sign",
        ),
        ({"drive": INVERTER}, "inverter drive on drum"),
        (
            {"schedules": [{"parameter": "drive.no_load_speed", "points": [[0.0, 10.0], [1.0, 45.0]]}]},
            "schedule of drive.no_load_speed",
        ),
        ({"attachments": [{"kind": "friction-damper", "name": "left", "angle": 0.0, "force": 40.0}]}, "friction-damper left"),
        (
            {
                "attachments": [
                    {"kind": "end-stop", "name": "buffer", "angle": 0.0, "gap": 0.01, "stiffness": 4e4, "damping": 9.0}
                ]
            },
            "end-stop buffer",
        ),
        ({"bodies": [DRUM, BALL | {"name": "a"}, BALL | {"name": "b"}]}, "contacts on the track ring"),
        ({"bodies": [DRUM, SWITCHABLE]}, "switchable-pendulum p"),
    ],
    ids=lambda x: x if isinstance(x, str) else "",
)
def test_each_is_named(changed, words):
    made = machine(**changed)
    assert laws_in_pieces(made) == (words,)
    assert in_pieces(made)


def test_all_are_named():
    drum = laws_in_pieces(load_machine("practice/laundry-drum"))
    assert drum == ("schedule of drive.voltage", "contacts on the track ring", "quadratic load on drum, at standstill")
