"""Scales: ticks of angles, limits of logarithmic scales, names with their units; curves of cams."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from wucht.plots.cam_drawings import draw_motion, radii_of_curvature
from wucht.plots.scales import (
    decades_about,
    multiples_of_pi,
    prefixed_unit,
    printed_values,
)


@pytest.mark.parametrize(
    ("low", "high", "words"),
    [
        (0.0, 2 * math.pi, ["0", "π/2", "π", "3π/2", "2π"]),
        (-math.pi, math.pi, ["−π", "−π/2", "0", "π/2", "π"]),
        (0.0, math.pi / 2, ["0", "π/8", "π/4", "3π/8", "π/2"]),
        (0.0, 4 * math.pi, ["0", "π", "2π", "3π", "4π"]),
        (0.1, 0.2, []),
        (0.0, 40 * math.pi, []),
    ],
)
def test_ticks_of_angles(low: float, high: float, words: list[str]) -> None:
    ticks = multiples_of_pi(low, high)
    assert [word for _, word in ticks] == words
    # 3π/4 is 3 * pi / 4
    for at, word in ticks:
        number, _, parts = word.partition("/")
        times = {"0": "0", "π": "1", "−π": "-1"}.get(number, number.removesuffix("π"))
        assert at == pytest.approx(int(times) * math.pi / int(parts or 1))


@pytest.mark.parametrize(
    ("values", "limits"), [([2.0, 30.0], (1.0, 100.0)), ([0.0, 5.0], (1.0, 10.0)), ([], (0.01, 10.0)), ([1e-3], (1e-4, 1e-2))]
)
def test_a_logarithmic_scale_ends_at_decades(values: list[float], limits: tuple[float, float]) -> None:
    assert decades_about(np.array(values)) == pytest.approx(limits)


def test_lengths_are_drawn_in_millimetres_and_what_has_a_unit_of_its_own_in_that() -> None:
    result = xr.Dataset({"a": ("n", [0.5], {"long_name": "amplitude", "units": "m"})})
    values, name = printed_values(result, "a")
    assert (values.tolist(), name) == ([500.0], "amplitude (mm)")
    result.a.attrs |= {"printed_units": "µm", "printed_factor": 1e6}
    assert printed_values(result, "a")[1] == "amplitude (µm)"


@pytest.mark.parametrize(
    ("largest", "unit", "expected"),
    [
        (4999.0, "W", (1.0, "W")),
        (5000.0, "W", (1e-3, "kW")),
        (0.05, "N", (1.0, "N")),
        (0.049, "N", (1e3, "mN")),
        (0.0, "W", (1.0, "W")),
        (9e9, "", (1.0, "")),
        (float("inf"), "W", (1.0, "W")),
    ],
)
def test_large_and_small_values_have_a_prefix(largest: float, unit: str, expected: tuple[float, str]) -> None:
    assert prefixed_unit(np.array([0.0, -largest, largest / 2]), unit) == expected


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
