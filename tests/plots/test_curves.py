"""Curves with more in them than a print shows: thinned, broken where angles wrap, a band where they swing fast."""

from __future__ import annotations

import numpy as np
import pytest
from matplotlib.figure import Figure

from wucht.plots.curves import RESIDUAL, angle_panel, draw_angles, draw_residual, draw_swings, thin_curve, without_jumps


def test_what_swings_faster_than_is_drawn_is_a_band() -> None:
    """Two hundred swings in the first half, one in the second: there it is a line."""
    axis, x = Figure().subplots(), np.linspace(0.0, 1.0, 20_001)
    y = np.where(x < 0.5, np.sin(2 * np.pi * 400 * x), 0.5 * np.sin(4 * np.pi * x))
    draw_swings(axis, x, y, color="#0072B2", label="swing")
    [line], [band] = axis.get_lines(), axis.collections
    drawn = np.asarray(line.get_ydata())[np.isfinite(line.get_ydata())]
    assert np.abs(drawn).max() < 0.51, "nothing of the fast half is in the line"
    corners = band.get_paths()[0].vertices
    assert (corners[:, 0].min(), corners[:, 0].max()) == (0.0, pytest.approx(0.5, abs=0.011))
    assert (corners[:, 1].min(), corners[:, 1].max()) == (pytest.approx(-1, abs=5e-3), pytest.approx(1, abs=5e-3))
    assert (line.get_label(), str(band.get_label())[0]) == ("swing", "_"), "named once"


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


def test_angles_that_end_near_zero_are_not_drawn_at_the_edge() -> None:
    axis = Figure().subplots()
    assert angle_panel(axis, [np.array([100.0, 350.0]), np.array([np.nan, 20.0])]) == -180
    assert axis.get_ylim() == (-180, 180)
    assert angle_panel(axis, [np.array([100.0, 350.0]), np.array([180.0])]) == 0
    draw_angles(axis, np.arange(3.0), np.array([[350.0, 10.0, 370.0]]), -180.0, [{"color": "black"}])
    assert axis.get_lines()[0].get_ydata().tolist() == [-10, 10, 10]


def test_an_angle_that_turns_too_fast_to_be_drawn_is_a_band() -> None:
    """Forty turns within the first tenth; then it rests."""
    axis, x = Figure().subplots(), np.linspace(0.0, 100.0, 10_001)
    draw_angles(axis, x, np.remainder(360 * np.minimum(4 * x, 40.0) + 90.0, 360.0)[None], 0.0, [{"color": "black"}])
    drawn = np.asarray(axis.get_lines()[0].get_ydata())
    assert np.isnan(drawn[x < 9]).all()
    assert drawn[x > 11] == pytest.approx(90.0)
    [band] = axis.collections
    assert band.get_label() == "turning past: several", "a line without a name"


def test_the_band_has_the_name_and_colour_of_the_body_that_turns_past() -> None:
    axis, x = Figure().subplots(), np.linspace(0.0, 100.0, 10_001)
    angles = np.array([np.remainder(720 * x, 360.0), 180.0 + 0 * x])
    styles = [{"color": "#D55E00", "label": "p1"}, {"color": "#009E73", "label": "p2"}]
    draw_angles(axis, x, angles, 0.0, styles)
    [band] = axis.collections
    assert band.get_label() == "turning past: p1"
    assert band.get_facecolor()[0][:3] == pytest.approx((0xD5 / 255, 0x5E / 255, 0.0))


def test_a_residual_without_a_value_has_a_panel_all_the_same() -> None:
    axis = Figure(figsize=(4, RESIDUAL)).add_subplot()
    draw_residual(axis, np.arange(3.0), np.array([0.0, 1e-30, 2e-9]))
    assert axis.get_ylim() == pytest.approx((1e-18, 2e-8))
    assert np.asarray(axis.get_lines()[0].get_ydata(), float).tolist() == [1e-18, 1e-18, 2e-9]
