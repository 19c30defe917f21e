"""When a machine changes for the last time."""

import pytest

from wucht.files.building import machine_from
from wucht.machines.changes import last_change

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
