"""Curves with more in them than a print shows: thinned, broken where angles wrap, a band where they swing fast."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from matplotlib.figure import Figure

from wucht.plots.curves import angle_panel, draw_swings, thin_curve, without_jumps


@pytest.mark.parametrize("count", [10, 3999, 4000, 4001, 9999, 123_457, 400_000])
def test_thinning_keeps_extremes_and_ends(count: int) -> None:
    x = np.linspace(0, 1, count)
    generator = np.random.default_rng(count)
    for peak in (0, count // 3, count - 2, count - 1):
        y = generator.uniform(-1, 1, count)
        y[peak] = 5.0
        y[(peak + count // 2) % count] = -5.0
        tx, ty = thin_curve(x, y)
        assert len(tx) == len(ty) <= 5000
        assert (tx[0], tx[-1]) == (0.0, 1.0)
        assert (np.diff(tx) > 0).all()
        assert ty.max() == 5.0
        assert ty.min() == -5.0


def test_a_phase_that_wraps_is_broken() -> None:
    shown = without_jumps(np.array([350.0, 355.0, 1.0, 5.0, 359.0]), 360.0)
    assert np.isnan(shown).tolist() == [False, False, True, False, True]


def bands(y: np.ndarray, x: np.ndarray | None = None, scale: str = "linear") -> tuple[list[Any], list[Any]]:
    """Lines and bands of a curve, over 0 to 1."""
    axis, x = Figure().subplots(), np.linspace(0.0, 1.0, len(y)) if x is None else x
    axis.set_yscale(scale)
    draw_swings(axis, x, y, color="#0072B2", label="swing", linewidth=2.0)
    return list(axis.get_lines()), list(axis.collections)


def test_two_bands_are_drawn_where_they_are() -> None:
    """From 0.2 to 0.4 and from 0.6 to 0.8; in the line there is a gap for each."""
    x = np.linspace(0.0, 1.0, 40_001)
    fast = ((x > 0.2) & (x < 0.4)) | ((x > 0.6) & (x < 0.8))
    (line,), found = bands(np.where(fast, np.sin(800 * np.pi * x), 0.0))
    spans = [(b.get_paths()[0].vertices[:, 0].min(), b.get_paths()[0].vertices[:, 0].max()) for b in found]
    assert spans == [pytest.approx((0.2, 0.4), abs=0.011), pytest.approx((0.6, 0.8), abs=0.011)]
    assert line.get_label() == "swing" and line.get_linewidth() == 2.0
    assert all(str(b.get_label()).startswith("_") for b in found)
    at, y = (np.asarray(v, float) for v in line.get_data())
    assert not np.isfinite(y[(at > 0.22) & (at < 0.38)]).any() and np.isfinite(y[(at > 0.42) & (at < 0.58)]).all()


@pytest.mark.parametrize(("turns", "dense"), [(100, False), (150, True)])
def test_three_turning_points_in_a_hundredth_of_the_panel_are_too_many(turns: int, dense: bool) -> None:
    """Two or three a strip."""
    lines, found = bands(np.sin(2 * np.pi * turns * np.linspace(0.0, 1.0, 20_001) + 0.3))
    assert bool(found) is dense and bool(lines) is not dense


@pytest.mark.parametrize(("size", "visible"), [(0.9e-2, False), (1.1e-2, True)])
@pytest.mark.parametrize("scale", ["linear", "log"])
def test_swings_of_less_than_a_hundredth_of_the_panel_are_a_line(size: float, visible: bool, scale: str) -> None:
    """From turning point to turning point; in decades where the scale is logarithmic."""
    x = np.linspace(0.0, 1.0, 40_001)
    y = np.where(x < 0.5, 0.5 * size * np.sin(800 * np.pi * x), 0.0) + np.where(x > 0.75, 1.0, 0.0)
    _, found = bands(10**y if scale == "log" else y, scale=scale)
    assert bool(found) is visible


def test_what_does_not_go_forward_or_is_not_finite_is_a_line() -> None:
    x = np.linspace(0.0, 1.0, 20_001)
    y = np.sin(800 * np.pi * x)
    assert not bands(y, x[::-1].copy())[1] and not bands(np.where(x > 0.9, np.nan, y))[1]
    assert not bands(np.zeros(3), np.zeros(3))[1] and len(bands(np.array([1.0]), np.array([0.0]))[0]) == 1


@pytest.mark.parametrize(
    ("ends", "begin"), [((44.0, 316.0), -180), ((46.0,), 0), ((314.0,), 0), ((-44.0, 404.0), -180), ((), 0)]
)
def test_the_panel_of_angles_begins_where_none_of_them_ends(ends: tuple[float, ...], begin: float) -> None:
    axis = Figure().subplots()
    assert angle_panel(axis, [np.array([100.0, end, np.nan]) for end in ends]) == begin
    assert list(axis.get_yticks()) == [begin + 90 * k for k in range(5)]


def test_a_step_of_half_a_period_is_no_jump() -> None:
    assert np.isnan(without_jumps(np.array([0.0, 180.0, 359.0, 178.0]), 360.0)).tolist() == [False, False, False, True]
