"""Random arrangements of the bodies of a track: none overlap, and all that do not are equally likely."""

from __future__ import annotations

import math
from itertools import permutations

import numpy as np
import pytest
from scipy.stats import kstest

from wucht.dynamics.sampling.arrangements import Arrangement, arranged_quantities, arrangement_of
from wucht.dynamics.sampling.distributions import points, sample_values
from wucht.files.building import machine_from
from wucht.machines.machine import Machine

COUNT = 4096


def ring(radii: list[float]) -> Machine:
    ball = {
        "kind": "roller",
        "about": "drum",
        "mass": 0.1,
        "track_radius": 0.06 + radii[0],
        "shape_factor": 0.4,
        "damping": 0.01,
    }
    balls = [ball | {"name": f"b{k}", "radius": r, "track_radius": 0.06 + r, "track": "ring"} for k, r in enumerate(radii, 1)]
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}
    carrier = {"mass": 1.0, "stiffness": 1e4, "damping": 20.0}
    drive = {"on": "drum", "kind": "linear", "slope": 0.01, "no_load_speed": 30.0}
    return machine_from({"carrier": carrier, "bodies": [drum, *balls], "drive": drive})


def angles_of(arrangement: Arrangement, seed: int = 0) -> np.ndarray:
    """Angles (n, COUNT)."""
    return sample_values([arrangement], points(COUNT, arrangement.dimensions, seed).reshape(COUNT, -1))


def gaps_ahead(angles: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The order of the bodies (n, M) from the first one on, and the angle from each to the next one."""
    turned = (angles - angles[0]) % (2 * math.pi)  # the gap about a fixed angle would be a long one more often
    order = np.argsort(turned, axis=0)
    placed = np.take_along_axis(turned, order, axis=0)
    return order, np.diff(placed, axis=0, append=placed[:1] + 2 * math.pi)


@pytest.mark.parametrize("radii", [[0.012] * 7, [0.004, 0.012, 0.008, 0.02], [0.02, 0.02, 0.004]])
def test_no_two_bodies_overlap(radii: list[float]) -> None:
    """Two circles of radii r1, r2 about a circle of radius R touch at the angle 2 asin((r1 + r2)/(2 R))."""
    order, ahead = gaps_ahead(angles_of(arrangement_of(ring(radii), "tracks.ring", "here")))
    sums = np.array(radii)[order] + np.array(radii)[np.roll(order, -1, axis=0)]
    gaps = ahead - 2 * np.arcsin(sums / (2 * 0.06))
    assert gaps.min() > -1e-12
    # The gaps are what the bodies leave free, and each has the same mean.
    free = 2 * math.pi - (ahead - gaps).sum(axis=0)
    assert (gaps.mean(axis=1) * len(radii) / free.mean()) == pytest.approx(1.0, abs=0.05)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_angles_are_uniform_and_orders_equally_likely(seed: int) -> None:
    """Four bodies that fill nearly half of the circle: six orders about it. The bounds are those of 4096 independent points."""
    angles = angles_of(arrangement_of(ring([0.02, 0.016, 0.012, 0.01]), "tracks.ring", "here"), seed)
    for of_body in angles % (2 * math.pi):
        assert kstest(of_body, "uniform", (0.0, 2 * math.pi)).statistic < 1.63 / math.sqrt(COUNT), "1 % of independent ones"
    order = np.argsort((angles - angles[0]) % (2 * math.pi), axis=0)
    for one in permutations((1, 2, 3)):
        assert np.mean((one == order[1:].T).all(axis=1)) == pytest.approx(1 / 6, abs=0.02)


@pytest.mark.parametrize("seed", [0, 1, 2])
def test_gaps_of_points_and_of_wide_bodies(seed: int) -> None:
    """Of n points on a circle of length 1 a spacing has the distribution 1 - (1 - x)^(n - 1), Beta(1, n - 1): R. Pyke (1965);
    of bodies likewise, as a share of the free length: the spacing ahead of any body."""
    for width in (1e-9, 0.9):
        one = Arrangement(((width,) * 6,) * 6)
        _, ahead = gaps_ahead(angles_of(one, seed))
        for spacing in (ahead - width) / (2 * math.pi - 6 * width):
            assert spacing.mean() == pytest.approx(1 / 6, abs=0.005)
            assert kstest(spacing, "beta", (1, 5)).statistic < 1.63 / math.sqrt(COUNT)


def test_the_density_is_the_same_wherever_two_bodies_fit() -> None:
    """Of two bodies a radian wide the second is ahead by 1 to 2 pi - 1 rad, each angle alike; drawn in vain are none."""
    ahead = np.diff(angles_of(Arrangement(((1.0, 1.0), (1.0, 1.0)))), axis=0)[0] % (2 * math.pi)
    assert kstest(ahead, "uniform", (1.0, 2 * math.pi - 2)).statistic < 1.63 / math.sqrt(COUNT)


def test_a_single_body_is_anywhere() -> None:
    machine = ring([0.02])
    (alone,) = angles_of(arrangement_of(machine, "tracks.ring", "here"))
    assert kstest(alone, "uniform", (0.0, 2 * math.pi)).statistic < 1.63 / math.sqrt(COUNT)
    (quantity,) = arranged_quantities(machine, "tracks.ring")
    assert quantity.state is not None
    assert quantity.state.keys == ("b1", "angle")
