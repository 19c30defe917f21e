"""What follows from the parts of a machine: whose bodies are whose, doubts about balancers, states, tracks and changes."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.assembly import shaft_labels
from wucht.machines.changes import leader_of, release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
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
        (0.1, [0.05, 0.05], []),
        (0.11, [0.05, 0.05], ["0.11 kg m, more than the 0.1 kg m"]),
        (0.1, [0.2, 0.05, 0.05], []),
        (0.1, [0.22, 0.05, 0.05], ["one balancer of 'a' has 0.22 kg m"]),
        (0.1, [0.1], []),
        (0.1, [0.1005], []),
        (0.1, [0.102], ["'a' has one balancer, of 0.102 kg m"]),
        (0.1, [0.1499], ["'a' has one balancer, of 0.1499 kg m"]),
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
        ({"p": (12, 0.05)}, 0.01 * math.sin(0.3) / math.sin(0.025)),
        ({"p": (12, 0.25)}, 0.01 * math.sin(1.5) / math.sin(0.125)),
        ({"p": (12, 0.5)}, 0.01 * math.sin(3.0) / math.sin(0.25)),  # beyond half a circle more balls are a loss
        ({"p": (6, 0.25), "q": (6, 0.25)}, 0.02 * math.sin(0.75) / math.sin(0.125)),
        ({"p": (6, 0.25), "q": (1, 0.25)}, 0.01 * (1 + math.sin(0.75) / math.sin(0.125))),
    ],
)
def test_balls_of_a_track_compensate_what_they_do_side_by_side(tracks: dict[str, tuple[int, float]], capacity: float) -> None:
    """n unbalances U, the angle a apart, add up to U sin(n a/2)/sin(a/2); those of several tracks add up, so do free ones."""
    (only,) = rings(1.001 * capacity, tracks).warnings
    assert f"more than the {capacity:.4g} kg m" in only and "side by side" in only
    assert rings(0.999 * capacity, tracks).warnings == ()


def test_unequal_balls_of_a_track_keep_their_order() -> None:
    """Side by side, the row may begin at any of them: 2, 1, 1, 3 do most as 1, 1, 3, 2 or 3, 2, 1, 1."""
    width, sizes = 0.6, (0.02, 0.01, 0.01, 0.03)
    balls = [ball(f"p{k}", m, track="p", diameter=0.2 * math.sin(width / 2), restitution=0.5) for k, m in enumerate(sizes)]
    rows = [sizes[k:] + sizes[:k] for k in range(4)]
    best = max(abs(sum(m * cmath.exp(1j * width * i) for i, m in enumerate(row))) for row in rows)
    assert any(f"more than the {best:.4g} kg m" in w for w in machine(rotor("a", 1.001 * best), *balls).warnings)
    assert machine(rotor("a", 0.999 * best), *balls).warnings == ()


def test_each_rotor_has_balancers_of_its_own() -> None:
    """The first is balanced, the second not by those of the first; what turns about a balancer is none of the rotor."""
    made = machine(rotor("a", 0.1), rotor("b", 0.3), ball("p", 0.05), ball("q", 0.05), ball("r", 0.1, "b"), ball("s", 0.1, "b"))
    (only,) = made.warnings
    assert "'b' is 0.3 kg m, more than the 0.2 kg m" in only
    chain = machine(rotor("a", 0.1), ball("p", 0.1), ball("q", 0.1, "p"))
    assert chain.warnings == ()


def test_whose_bodies_are_whose() -> None:
    made = machine(ball("p", 0.05, "b"), rotor("b"), ball("q", 0.05), rotor("a"), ball("s", 0.01, "p"))
    names = {b.name: made.rotor_of(b).name for b in made.bodies}
    assert names == {"p": "b", "b": "b", "q": "a", "a": "a", "s": "b"}
    assert made.rotor.name == "b"
    assert [b.name for b in made.rotors] == ["b", "a"]
    assert [b.name for b in made.group(made.rotors[1])] == ["a", "q"]
    assert [b.name for b in made.outward] == ["b", "a", "p", "q", "s"]
    assert made.body("q").about == "a"


def test_states_are_positions_then_free_velocities() -> None:
    driven = machine(rotor("a"), ball("p", 0.1), drive={"kind": "constant-speed", "speed": -3.0})
    assert driven.state_names == (
        "carrier.x", "carrier.y", "a.angle", "p.angle", "carrier.vx", "carrier.vy", "p.speed",
    )  # fmt: skip
    assert driven.row(driven.bodies[1].coordinate.velocity) == 6
    speed = driven.prescribed_speed(driven.bodies[0].coordinate, np.array([0.0, 5.0]))
    assert speed.tolist() == [-3.0, -3.0]
    assert not driven.dimensionless
    assert load_machine("drozdetskaya-2020/table-5.1").dimensionless


def test_what_is_evaluated_as_amplitude() -> None:
    assert list(machine(rotor("a")).orbit) == ["x", "y"]
    along_y = machine_from({"carrier": CARRIER | {"directions": "y"}, "bodies": [rotor("a")]})
    assert list(along_y.orbit) == ["y"]
    assert along_y.free_labels == ("y",)
    turning = {"directions": "r", "inertia": 1.0, "rotation_stiffness": 50.0}
    tilting = machine_from({"carrier": turning, "bodies": [rotor("a", position=[0.2, 0.0])]})
    assert list(tilting.orbit) == ["r"]
    assert (tilting.orbit_unit, along_y.orbit_unit) == ("rad", "m")


def test_schedules_have_their_values_at_a_time() -> None:
    schedules = [
        {"parameter": "a.bearing_damping", "points": [[2, 0.0], [4, 0.1]]},
        {"parameter": "carrier.damping", "points": [[1, 5.0], [4, 2.0]], "interpolation": "steps"},
    ]
    made = machine(rotor("a"), schedules=schedules)
    assert made.breakpoints == (0.0, 1.0, 2.0, 4.0)
    values = [(m.values["a.bearing_damping"], m.values["carrier.damping"]) for m in map(made.at, (0.0, 3.0, 4.0))]
    assert values == [(0.0, 5.0), (pytest.approx(0.05), 5.0), (pytest.approx(0.1), 2.0)]
    first, second = made.schedules
    assert [first.holds_since(t) for t in (0.0, 3.0, 9.0)] == [2.0, 3.0, 4.0]
    assert second.holds_since(0.5) == 1.0
    assert machine(rotor("a")).breakpoints == (0.0,)


def test_a_shaken_carrier_has_a_frequency() -> None:
    motion = {"direction": "x", "amplitude": 1e-3, "frequency": 30.0}
    shaken = machine_from({"carrier": {"directions": "x", "mass": 3.0, "motion": motion}, "bodies": [rotor("a")]})
    assert shaken.shaking_frequency == 30.0
    assert shaken.shaken_coordinate is not None
    assert shaken.free_labels == ()
    still = machine(rotor("a"))
    assert (still.shaking_frequency, still.shaken_coordinate, still.rotation_coordinate) == (None, None, None)


@pytest.mark.parametrize(
    ("shafts", "labels"),
    [
        ([], []),
        ([("a", "fan")], [""]),
        ([("a", "fan"), ("b", "fan")], ["a", "b"]),
        ([("a", "fan"), ("a", "viscous"), ("b", "fan")], ["a.fan", "a.viscous", "b"]),
    ],
)
def test_labels_of_drives_and_loads(shafts: list[tuple[str, str]], labels: list[str]) -> None:
    assert shaft_labels(shafts) == labels


def test_who_releases_a_locked_body() -> None:
    """The body that it turns about; a rotor is released by the first other one, wherever that stands."""
    made = machine(rotor("a"), rotor("b"), ball("p", 0.05, "b"))
    assert [leader_of(made, b).name for b in made.bodies] == ["b", "a", "b"]


@pytest.mark.parametrize("speed", [30.0, -30.0])
def test_a_body_is_released_at_a_speed_in_either_sense_or_at_a_time(speed: float) -> None:
    made = machine(
        rotor("a"), ball("p", 0.05, release={"speed": 30.0}), ball("q", 0.05, release={"time": 2.0}), ball("s", 0.05)
    )
    by_speed, by_time = release_events(made)
    rising = by_speed.expression
    assert by_speed.direction == by_time.direction == 1
    values = {s: made.values[s.name] for s in rising.free_symbols if s.name in made.values}
    velocity = made.bodies[0].coordinate.velocity
    for factor, sign in ((0.99, -1), (1.01, 1)):
        assert np.sign(float(rising.xreplace(values | {velocity: factor * speed}))) == sign
    at_2_s = {s: 2.0 if s.name == "t" else made.values[s.name] for s in by_time.expression.free_symbols}
    assert float(by_time.expression.xreplace(at_2_s)) == 0.0
    parameters = np.array([made.values[n] for n in made.system.parameter_names])
    for event, name in ((by_speed, "p"), (by_time, "q")):
        changed = parameters.copy()
        assert event.action is not None
        event.action(0.0, np.zeros(3), changed)
        (at,) = np.flatnonzero(changed != parameters)
        assert made.system.parameter_names[at] == f"{name}.locked"
        assert changed[at] == 0.0


# --- tracks ---


def on_track(*angles: float | None) -> Machine:
    """Balls of 20 mm and 30 mm by turns on a circle of 0.1 m."""
    balls = [
        ball(f"k{i}", 0.01, diameter=0.02 + 0.01 * (i % 2), track="t") | ({} if angle is None else {"start": angle})
        for i, angle in enumerate(angles)
    ]
    return machine(rotor("a", 0.0), *balls)


def test_two_balls_that_touch_are_the_base_of_a_triangle() -> None:
    """Centres 25 mm apart on a circle of 0.1 m: by the cosine rule."""
    (track,) = on_track(0.0, 1.0).tracks
    small, large = track.bodies
    assert angular_width(small, large) == pytest.approx(math.acos(1 - 0.025**2 / (2 * 0.1**2)), rel=1e-12)
    assert angular_width(small, small) == pytest.approx(math.acos(1 - 0.02**2 / (2 * 0.1**2)), rel=1e-12)


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


def test_the_contact_is_fast_beside_operation_and_start() -> None:
    """20 times the highest resonance; or the fastest body at the start; a frequency of the file stays."""
    made = on_track(0.0, 1.0, 2.0)
    natural = math.sqrt(2e4 / (3.0 + 2.0 + 3 * 0.1))
    absolute = {"a": 0.0, "k0": 0.0, "k1": 1.0, "k2": 2.0}
    assert made.tracks[0].frequency == pytest.approx(20 * natural)
    assert arrange_contacts(made, absolute).values["tracks.t.contact_frequency"] == pytest.approx(20 * natural)
    assert arrange_contacts(made, absolute, fastest=500.0).values["tracks.t.contact_frequency"] == pytest.approx(1e4)
    balls = [ball(f"k{i}", 0.01, diameter=0.02, track="t", start=float(i)) for i in range(3)]
    given = machine(rotor("a", 0.0), *balls, tracks={"t": {"contact_frequency": 700.0}})
    assert arrange_contacts(given, absolute, fastest=500.0).values["tracks.t.contact_frequency"] == 700.0


def test_bodies_that_overlap_at_the_start_are_named() -> None:
    made, width = on_track(None, None, None), math.acos(1 - 0.025**2 / (2 * 0.1**2))
    arrange_contacts(made, {"a": 0.0, "k0": 0.0, "k1": width, "k2": 3.0})
    with refused("study.start.k1", "k0", f"{math.degrees(width):.4g}", given=10.0):
        arrange_contacts(made, {"a": 0.0, "k0": 0.0, "k1": math.radians(10.0), "k2": 3.0})


@pytest.mark.parametrize("nearer", [0.0, 5e-10, -5e-10])
def test_bodies_that_just_touch_get_a_clearance(nearer: float) -> None:
    """Of 1e-9 rad, if they are nearer than that, and if rounding makes them overlap by less."""
    width = math.acos(1 - 0.025**2 / (2 * 0.1**2))
    made = arrange_contacts(on_track(None, None, None), {"a": 0.0, "k0": 0.0, "k1": width - nearer, "k2": 3.0})
    gap = width - nearer + made.values["tracks.t.offset_1"]
    assert gap == pytest.approx(1e-9, abs=1e-14)


@pytest.mark.parametrize("speed", [0.5, -0.5])
def test_a_rotor_that_turns_slowly_has_a_sense_too(speed: float) -> None:
    made = machine(rotor("a"), ball("p", 0.05), drive={"kind": "linear", "slope": 0.1, "no_load_speed": speed})
    assert [sense_of(made, b) for b in made.bodies] == [np.sign(speed)] * 2


def test_a_locked_body_follows_the_one_it_turns_about_on_any_carrier() -> None:
    """The index of a lock counts the carrier's coordinates first; the outermost body is locked first."""
    held = {"release": {"time": 1.0}}
    made = machine(rotor("b"), rotor("a"), ball("p", 0.05, **held), ball("q", 0.02, "p", **held))
    locks = made.structure.locks()
    names = [c.position.name for c in made.coordinates]
    assert [(names[lock.index], names[lock.about or 0]) for lock in locks] == [("q.angle", "p.angle"), ("p.angle", "a.angle")]
    assert [lock.switch.name for lock in locks] == ["q.locked", "p.locked"]
