"""Another number of bodies, and the starts of their runs."""

from __future__ import annotations

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht import load_machine
from wucht.dynamics.balancers.candidates import least_residual, phases, with_bodies
from wucht.dynamics.sampling.searches import balancer_names
from wucht.machines.tracks import angular_width

CENTRIFUGE = load_machine("practice/laboratory-centrifuge")
GRINDER = load_machine("practice/grinder-4-balls")


def test_more_and_fewer_bodies_are_like_the_first_one() -> None:
    heavy = CENTRIFUGE.with_values({f"b{k}.mass": 5e-3 for k in range(1, 5)})
    for count in (1, 2, 6):
        made = with_bodies(heavy, count)
        assert len(balancer_names(made)) == count
        assert {made.values[f"{b}.mass"] for b in balancer_names(made)} == {5e-3}
        assert {k: v for k, v in made.values.items() if not k.startswith("b")} == {
            k: v for k, v in heavy.values.items() if not k.startswith("b")
        }
    assert with_bodies(heavy, 4) is heavy
    assert with_bodies(with_bodies(heavy, 6), 4).values == heavy.values


def test_starts_on_a_track_never_overlap_and_are_everywhere() -> None:
    at = phases(GRINDER, 256, [5]) % (2 * np.pi)
    bodies = GRINDER.tracks[0].bodies
    gaps = np.diff(np.sort(at, axis=0), axis=0, append=np.sort(at, axis=0)[:1] + 2 * np.pi)
    assert gaps.min() >= angular_width(bodies[0], bodies[1]) - 1e-12
    assert np.histogram(at, bins=8, range=(0, 2 * np.pi))[0].min() > 0.7 * at.size / 8
    assert np.array_equal(phases(CENTRIFUGE, 8, [1]), phases(CENTRIFUGE, 8, [1]))
    assert not np.array_equal(phases(CENTRIFUGE, 8, [1]), phases(CENTRIFUGE, 8, [2]))


@pytest.mark.parametrize(("share", "left"), [(0.5, 0.0), (1.0, 0.0), (1.5, 0.5)])
def test_what_is_left_of_more_unbalance_than_the_bodies_have(share: float, left: float) -> None:
    moment = sum(CENTRIFUGE.values[f"b{k}.mass"] * (0.115 - 0.005) for k in range(1, 5))
    assert least_residual(CENTRIFUGE.with_values({"rotor.unbalance": share * moment})) == pytest.approx(
        left * moment, abs=1e-15
    )


@pytest.mark.parametrize(("share", "left"), [(0.999, 0.0), (1.1, 0.1)])
def test_bodies_of_a_track_leave_what_they_cannot_compensate_side_by_side(share: float, left: float) -> None:
    """U sin(n a/2)/sin(a/2) of n balls that touch, also where their radius is varied."""
    balls = GRINDER.tracks[0].bodies
    for radius in (balls[0].radius, 0.6 * balls[0].radius):
        ring = balls[0].track_radius - radius
        angle = 2 * math.asin(radius / ring)
        capacity = balls[0].mass * ring * math.sin(len(balls) * angle / 2) / math.sin(angle / 2)
        made = GRINDER.with_values({f"{b.name}.radius": radius for b in balls} | {"wheel.unbalance": share * capacity})
        assert least_residual(made) == pytest.approx(left * capacity, rel=1e-9, abs=1e-15)


def test_one_body_that_is_too_heavy_leaves_the_difference() -> None:
    lone = with_bodies(CENTRIFUGE, 1)
    moment = lone.values["b1.mass"] * 0.11
    assert least_residual(lone.with_values({"rotor.unbalance": 0.25 * moment})) == pytest.approx(0.75 * moment)


def test_unlike_bodies_of_a_track_start_apart_as_well() -> None:
    """Two small ones and two large ones, all centres at 26 mm: each gap is as wide as its own two neighbours."""
    radii = np.array([0.003, 0.003, 0.009, 0.009])
    sizes = {f"b{k + 1}": r for k, r in enumerate(radii)}
    values = {f"{b}.{key}": v for b, r in sizes.items() for key, v in (("radius", r), ("track_radius", 0.026 + r))}
    at = phases(GRINDER.with_values(values), 256, [5])
    touching = 2 * np.arcsin((radii + np.roll(radii, -1)) / (2 * 0.026))
    gaps = np.diff(at, axis=0, append=at[:1] + 2 * np.pi)
    assert (gaps.min(axis=1) >= touching - 1e-12).all()
    assert gaps.min(axis=1) == pytest.approx(touching, abs=0.05)


def test_bodies_that_differ_have_no_number() -> None:
    with refused("study.bodies", "b3", "b1", given=2, code="different-bodies"):
        with_bodies(CENTRIFUGE.with_values({"b3.mass": 5e-3}), 2)
    with refused("study.bodies", given=2, code="schedules"):
        with_bodies(load_machine("practice/balls-at-resonance"), 2)
