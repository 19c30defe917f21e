"""Shares of areas that are known, counted by cells: how far they are off, and how far it is said they are."""

from __future__ import annotations

import math
from collections.abc import Callable
from itertools import pairwise

import numpy as np
import pytest

from wucht.dynamics.sampling.label_maps import error_bound, share, uncertainty

Inside = Callable[[np.ndarray, np.ndarray], np.ndarray]
OPEN = (False, False)
TIMES = 200


def centres(count: int) -> list[np.ndarray]:
    at = (np.arange(count) + 0.5) / count
    return [np.asarray(v) for v in np.meshgrid(at, at)]


def disc(random: np.random.Generator) -> tuple[Inside, float]:
    (x0, y0), r = random.uniform(0.35, 0.65, 2), random.uniform(0.1, 0.33)
    return lambda x, y: np.hypot(x - x0, y - y0) < r, math.pi * r**2


def slanted_box(random: np.random.Generator) -> tuple[Inside, float]:
    (x0, y0), (a, b), t = random.uniform(0.45, 0.55, 2), random.uniform(0.1, 0.3, 2), random.uniform(0.0, 3.0)
    c, s = math.cos(t), math.sin(t)
    return lambda x, y: (abs((x - x0) * c + (y - y0) * s) < a) & (abs((y - y0) * c - (x - x0) * s) < b), float(4 * a * b)


def upright_box(random: np.random.Generator) -> tuple[Inside, float]:
    (x0, y0), (a, b) = random.uniform(0.1, 0.3, 2), random.uniform(0.2, 0.6, 2)
    return lambda x, y: (x > x0) & (x < x0 + a) & (y > y0) & (y < y0 + b), float(a * b)


@pytest.mark.parametrize(("region", "power"), [(disc, 1.5), (slanted_box, 1.5), (upright_box, 1.0)])
def test_it_is_off_by_no_more_in_19_of_20_cases(region: Callable[..., tuple[Inside, float]], power: float) -> None:
    """Of discs and boxes anywhere on 16 x 16, 32 x 32 and 64 x 64 cells; the bound always holds.

    What is said falls as the cells' size to the power that it should, and it is not idle: the true error of upright boxes is as
    large as it says, that of the others half.
    """
    random, said = np.random.default_rng(5), []
    for count in (16, 32, 64):
        x, y = centres(count)
        off, estimates, bounds = np.empty(TIMES), np.empty(TIMES), np.empty(TIMES)
        for k in range(TIMES):
            inside, area = region(random)
            cells = inside(x, y)
            off[k], estimates[k], bounds[k] = abs(share(cells) - area), uncertainty(cells, OPEN), error_bound(cells, OPEN)
        assert (off <= estimates).mean() >= 0.93
        assert (off <= bounds).all()
        of_error = math.sqrt((off**2).mean() / (estimates**2 / 4).mean())
        assert (0.9 if power == 1 else 0.3) < of_error < 1.15
        said.append(estimates.mean())
    for coarse, fine in pairwise(said):
        assert math.log2(coarse / fine) == pytest.approx(power, abs=0.25)


def test_a_border_along_an_axis_may_be_off_by_half_a_cell_all_along() -> None:
    for count in (16, 32):
        inside = centres(count)[0] < 0.5
        assert uncertainty(inside, OPEN) == pytest.approx(2 / math.sqrt(12) / count)
        assert error_bound(inside, OPEN) == pytest.approx(1 / count)


def test_over_a_seam_a_border_is_one() -> None:
    """The same map rolled along its periodic axes says the same."""
    x, y = centres(24)
    inside = (np.hypot(x - 0.5, y - 0.4) < 0.3) | (y > 0.8)
    once = uncertainty(inside, (True, True)), error_bound(inside, (True, True))
    for shift in range(1, 24, 5):
        for axis in (0, 1):
            rolled = np.roll(inside, shift, axis)
            assert (uncertainty(rolled, (True, True)), error_bound(rolled, (True, True))) == pytest.approx(once)
    assert uncertainty(np.roll(inside, 12, 1), OPEN) != pytest.approx(once[0])


def test_all_or_nothing_is_certain() -> None:
    whole = np.ones((4, 5), bool)
    assert (share(whole), uncertainty(whole, (True, True)), error_bound(whole, OPEN)) == (1.0, 0.0, 0.0)
    assert (share(~whole), uncertainty(~whole, OPEN)) == (0.0, 0.0)
