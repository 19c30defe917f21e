"""Cams to scale: circles, radii of curvature, motions in degrees, bars without a zero."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from wucht.plots.cam_drawings import draw_bars_from, draw_circle, draw_motion, radii_of_curvature


def test_a_circle_is_closed_and_round() -> None:
    axis = Figure().add_subplot()
    draw_circle(axis, 1.0, 2.0, 3.0)
    x, y = (np.asarray(v, float) for v in axis.get_lines()[0].get_data())
    assert np.hypot(x - 1, y - 2) == pytest.approx(3.0)
    assert (x[0], y[0]) == pytest.approx((x[-1], y[-1]))


def test_no_radius_is_drawn_where_a_contour_is_nearly_straight() -> None:
    of = {"curvature": 1 / 0.02, "contour_x": 0.02, "contour_y": 0.0}
    result = xr.Dataset({name: ("n", [value, value]) for name, value in of.items()})
    result.curvature[1] = 1.0
    radii, widest = radii_of_curvature(result)
    assert widest == pytest.approx(50.0)
    assert radii.values == pytest.approx([20.0, np.nan], nan_ok=True)


def test_a_derivative_is_drawn_in_degrees_per_radian() -> None:
    axis = Figure().add_subplot()
    angle = {name: ("cam_angle", [0.0, np.pi], {"units": "rad"}) for name in ("position", "velocity")}
    result = xr.Dataset(angle, coords={"cam_angle": [0.0, np.pi / 2]})
    assert draw_motion(axis, result, "velocity", "/rad") == "°/rad"
    x, y = (np.asarray(v, float) for v in axis.get_lines()[0].get_data())
    assert (x[1], y[1]) == pytest.approx((90.0, 180.0))


def test_bars_of_a_logarithmic_scale_end_at_their_values() -> None:
    axis = Figure().add_subplot()
    draw_bars_from(axis, 0.5, np.arange(2), np.array([2.0, 0.5]))
    assert [(bar.get_y(), bar.get_y() + bar.get_height()) for bar in axis.patches] == [(0.5, 2.0), (0.5, 0.5)]  # type: ignore[attr-defined]
