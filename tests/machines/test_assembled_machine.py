"""What follows from the parts of a machine: whose bodies are whose, doubts about balancers, states, tracks and changes."""

from __future__ import annotations

import math
from typing import Any

import pytest

from wucht.files.building import machine_from
from wucht.machines.changes import last_change
from wucht.machines.machine import Machine
from wucht.machines.tracks import angular_width, arrange_contacts, even_start_angles, starts

CARRIER = {"mass": 3.0, "stiffness": 2e4, "damping": 5.0}
TURN = 2 * math.pi


def rotor(name: str, unbalance: float = 0.1, **more: Any) -> dict[str, Any]:
    return {"kind": "rotor", "name": name, "mass": 2.0, "unbalance": unbalance, "inertia": 0.5} | more


def ball(name: str, moment: float, about: str = "a", **more: Any) -> dict[str, Any]:
    """Its mass at 0.1 m gives the moment."""
    return {"kind": "pendulum", "name": name, "about": about, "mass": 10 * moment, "length": 0.1, "damping": 0.01} | more


def machine(*bodies: dict[str, Any], **more: Any) -> Machine:
    return machine_from({"carrier": CARRIER, "bodies": list(bodies)} | more)


@pytest.mark.parametrize(
    ("rotor_moment", "balls", "doubts"),
    [
        (0.1, [], []),
        (0.11, [0.05, 0.05], ["0.11 kg m, more than the 0.1 kg m"]),
        (0.1, [0.1], []),
        (0.1, [0.1005], []),
        (0.1, [0.102], ["'a' has one balancer, of 0.102 kg m"]),
        (0.1, [0.1501], []),
        (0.1, [0.098], ["0.1 kg m, more than the 0.098 kg m"]),
        (0.0, [0.1], []),
    ],
)
def test_doubts_about_balancers(rotor_moment: float, balls: list[float], doubts: list[str]) -> None:
    made = machine(rotor("a", rotor_moment), *(ball(f"p{i}", m) for i, m in enumerate(balls)))
    assert len(made.warnings) == len(doubts)
    assert all(part in warning for part, warning in zip(doubts, made.warnings, strict=True))


def rings(unbalance: float, tracks: dict[str, tuple[int, float]]) -> Machine:
    """A rotor with tracks of so many equal balls, 0.01 kg m each, that fill so large an angle each."""
    balls = [
        ball(f"{name}{k}", 0.01, track=name, diameter=0.2 * math.sin(width / 2), restitution=0.5)
        for name, (count, width) in tracks.items()
        for k in range(count)
    ]
    return machine(rotor("a", unbalance), *balls)


@pytest.mark.parametrize(
    ("tracks", "capacity"),
    [
        ({"p": (12, 0.25)}, 0.01 * math.sin(1.5) / math.sin(0.125)),
        ({"p": (12, 0.5)}, 0.01 * math.sin(3.0) / math.sin(0.25)),
        ({"p": (6, 0.25), "q": (1, 0.25)}, 0.01 * (1 + math.sin(0.75) / math.sin(0.125))),
    ],
)
def test_balls_of_a_track_compensate_what_they_do_side_by_side(tracks: dict[str, tuple[int, float]], capacity: float) -> None:
    """n unbalances U, the angle a apart, add up to U sin(n a/2)/sin(a/2); those of several tracks add up, so do free ones."""
    (only,) = rings(1.001 * capacity, tracks).warnings
    assert f"more than the {capacity:.4g} kg m" in only and "side by side" in only
    assert rings(0.999 * capacity, tracks).warnings == ()


# --- tracks ---


def on_track(*angles: float | None) -> Machine:
    """Balls of 20 mm and 30 mm by turns on a circle of 0.1 m."""
    balls = [
        ball(f"k{i}", 0.01, diameter=0.02 + 0.01 * (i % 2), track="t") | ({} if angle is None else {"start": angle})
        for i, angle in enumerate(angles)
    ]
    return machine(rotor("a", 0.0), *balls)


def test_starts_are_as_given_or_even() -> None:
    (given,) = on_track(1.0, None, -2.0).tracks
    assert starts(given.bodies) == {"k0": 1.0, "k1": 0.0, "k2": -2.0}
    (free,) = on_track(None, None, None, None).tracks
    assert list(starts(free.bodies).values()) == pytest.approx([0, TURN / 4, TURN / 2, 3 * TURN / 4])
    assert even_start_angles(free.bodies) == starts(free.bodies)


@pytest.mark.parametrize(
    ("angles", "order"),
    [((0.0, 1.0, 2.0), ("k0", "k1", "k2")), ((0.0, 2.0, 1.0), ("k0", "k2", "k1")), ((1.0, 0.2, 8.0), ("k0", "k2", "k1")),
     ((5.0, 0.2, 20.0), ("k0", "k1", "k2")),
     ((0.0, -1.0, -2.0), ("k0", "k2", "k1"))],
)  # fmt: skip
def test_neighbours_are_those_counter_clockwise_whatever_the_turns(angles: tuple[float, ...], order: tuple[str, ...]) -> None:
    """Each gap is the angle ahead within a turn, less what both bodies fill; together with these they are a turn."""
    absolute = {"a": 0.3, **{f"k{i}": angle for i, angle in enumerate(angles)}}
    placed = arrange_contacts(on_track(None, None, None), absolute)
    (track,) = placed.tracks
    assert track.order == order
    widths = []
    for k, (one, other) in enumerate(zip(order, (*order[1:], order[0]), strict=True), 1):
        bodies = {b.name: b for b in track.bodies}
        width = angular_width(bodies[one], bodies[other])
        gap = absolute[other] - absolute[one] + placed.values[f"tracks.t.offset_{k}"]
        assert gap == pytest.approx((absolute[other] - absolute[one]) % TURN - width, abs=1e-9)
        widths.append(gap + width)
    assert sum(widths) == pytest.approx(TURN)


@pytest.mark.parametrize("nearer", [0.0, 5e-10, -5e-10])
def test_bodies_that_just_touch_get_a_clearance(nearer: float) -> None:
    """Of 1e-9 rad, if they are nearer than that, and if rounding makes them overlap by less."""
    width = math.acos(1 - 0.025**2 / (2 * 0.1**2))
    made = arrange_contacts(on_track(None, None, None), {"a": 0.0, "k0": 0.0, "k1": width - nearer, "k2": 3.0})
    gap = width - nearer + made.values["tracks.t.offset_1"]
    assert gap == pytest.approx(1e-9, abs=1e-14)


HELD = {"kind": "pendulum", "name": "a", "about": "d", "mass": 0.1, "length": 0.1, "damping": 0.01}
SCHEDULE = {"parameter": "drive.slope", "points": [[0, 0.01], [3, 0.02], [5, 0.02]]}


@pytest.mark.parametrize(
    ("releases", "schedules", "last"),
    [
        ([], [], 0.0),
        ([{"time": 2.0}, {"time": 4.0}], [], 4.0),
        ([{"time": 2.0}], [SCHEDULE], 5.0),
        ([{"time": 7.0}], [SCHEDULE], 7.0),
        ([{"speed": 7.0}], [SCHEDULE], 5.0),
    ],
)
def test_a_machine_changes_for_the_last_time_with_a_schedule_or_a_timed_release(releases, schedules, last):
    """When a speed is reached nobody knows before."""
    rotor = {"kind": "rotor", "name": "d", "mass": 2.0, "unbalance": 0.01, "inertia": 0.02}
    balls = [HELD | {"name": f"a{i}", "release": release} for i, release in enumerate(releases)]
    drive = {"on": "d", "kind": "linear", "slope": 0.01, "no_load_speed": 50.0}
    document = {"carrier": {"stiffness": 1e4}, "bodies": [rotor, *balls], "drive": drive, "schedules": schedules}
    assert last_change(machine_from(document)) == last
