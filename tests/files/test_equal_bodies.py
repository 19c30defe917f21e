"""Equal bodies by a count: their names, where they start, and how they are set."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.run_ups.initial_state import angles_in, initial_state
from wucht.files.building import machine_from
from wucht.files.equal_bodies import EqualBodies

RING = {"kind": "rotor", "name": "ring", "mass": 2.0, "unbalance": 1e-3, "inertia": 0.02}
BALL = {
    "kind": "roller", "name": "b", "about": "ring", "mass": "2 g", "track_radius": "30 mm", "radius": "4 mm",
    "shape_factor": 0.4, "damping": 1e-6, "track": "t",
}  # fmt: skip
WIDTH = 2 * math.asin(4 / 26)  # of a ball, seen from the axis


def machine_with(*bodies, **more):
    drive = {"kind": "linear", "on": "ring", "slope": 0.01, "no_load_speed": 100.0}
    return machine_from({"carrier": {"stiffness": 1e4}, "bodies": [RING, *bodies], "drive": drive} | more)


def angles(machine, start=None):
    """At the start, of all but the ring."""
    return {n: a for n, a in angles_in(machine, initial_state(machine, start or {})).items() if n != "ring"}


def test_a_count_stands_for_as_many_tables():
    """The same machine as written out, evenly placed."""
    by_count = machine_with(BALL | {"count": 8})
    written = machine_with(*(BALL | {"name": f"b{k}"} for k in range(1, 9)))
    assert by_count.values == written.values
    assert by_count.structure == written.structure
    assert angles(by_count) == pytest.approx(angles(written))
    assert list(angles(by_count).values()) == pytest.approx([k * math.pi / 4 for k in range(8)])


def test_at_an_angle_balls_of_a_track_lie_side_by_side():
    at = np.array(list(angles(machine_with(BALL | {"count": 5, "start": "200 deg"})).values()))
    assert np.diff(at) == pytest.approx([WIDTH] * 4)
    assert at.mean() == pytest.approx(math.radians(200))


@pytest.mark.parametrize("count", [1, 2, 8, 20])
def test_random_places_do_not_overlap_and_are_those_of_their_seed(count):
    drawn = [EqualBodies(count=count, start="random", seed=seed).angles(WIDTH) for seed in range(20)]
    for places in drawn:
        gaps = np.diff(np.sort(np.mod(places, 2 * math.pi)), append=np.min(np.mod(places, 2 * math.pi)) + 2 * math.pi)
        assert count == 1 or gaps.min() > WIDTH - 1e-12
    assert EqualBodies(count=count, start="random", seed=3).angles(WIDTH) == drawn[3]
    assert len({round(p[0], 9) for p in drawn}) == 20
    assert EqualBodies(count=count, start="random").angles(WIDTH) == drawn[0]


def test_random_places_are_anywhere():
    """Of 3000 arrangements: every tenth of the circle is as likely as any other, and each gap has its share of what is free."""
    drawn = np.array([EqualBodies(count=4, start="random", seed=seed).angles(0.3) for seed in range(3000)])
    shares = np.histogram(np.mod(drawn, 2 * math.pi), 10, (0, 2 * math.pi))[0] / drawn.size
    assert shares == pytest.approx([0.1] * 10, abs=0.01)
    gaps = np.diff(drawn, append=drawn[:, :1] + 2 * math.pi) - 0.3
    assert gaps.mean(axis=0) == pytest.approx([(2 * math.pi - 1.2) / 4] * 4, rel=0.06)
    assert gaps.min() > -1e-12


def test_all_are_set_by_their_common_name_and_one_by_its_own():
    machine = machine_with(BALL | {"count": 8}, set={"b.mass": "3 g", "b2.mass": "5 g", "b.count": 3.0, "b.start": "random"})
    assert [machine.values[f"b{k}.mass"] for k in (1, 2, 3)] == [0.003, 0.005, 0.003]
    assert "b4.mass" not in machine.values
    assert len(set(np.round(np.diff(list(angles(machine).values())), 6))) == 2


@pytest.mark.parametrize(
    ("changes", "refusal"),
    [
        ({"count": 0}, refused("machine.bodies[1] (b).count", "100", given=0, code="limits")),
        ({"count": 2.5}, refused("machine.bodies[1] (b).count", given=2.5, code="type")),
        ({"count": 30}, refused("machine.bodies[1] (b).count", "20", given=30, code="limits")),
        ({"count": 3, "seed": 2}, refused("machine.bodies[1] (b).seed", 'start = "random"', given=2)),
        ({"seed": 3}, refused("machine.bodies[1] (b).seed", code="unknown-key")),
    ],
)
def test_what_is_no_count_is_refused(changes, refusal):
    with refusal:
        machine_with(BALL | changes)
