"""Scales: ticks of angles, limits of logarithmic scales, names with their units."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr

from wucht.plots.scales import (
    decades_about,
    fraction_of_pi,
    multiples_of_pi,
    parameter_label,
    power_text,
    prefixed_unit,
    printed_values,
    travel_unit,
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


def test_multiples_of_pi_are_in_lowest_terms_with_a_minus_sign() -> None:
    assert [fraction_of_pi(n, 2) for n in (-3, -2, -1, 0, 1, 2, 3)] == ["−3π/2", "−π", "−π/2", "0", "π/2", "π", "3π/2"]


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


@pytest.mark.parametrize(("unit", "drawn"), [("rad", (180 / math.pi, "°")), ("m", (1e3, "mm"))])
def test_a_motion_is_drawn_in_degrees_or_millimetres(unit: str, drawn: tuple[float, str]) -> None:
    assert travel_unit(xr.DataArray(0.0, attrs={"units": unit})) == pytest.approx(drawn)


def test_a_parameter_is_named_by_its_words_its_symbol_and_its_unit() -> None:
    result = xr.Dataset(attrs={"along": "q", "along_what": "share", "along_unit": "m^2"})
    assert parameter_label(result) == "q: share (m²)"
    result.attrs |= {"along": "drive.slope", "along_what": "slope", "along_unit": ""}
    assert parameter_label(result) == "slope"


def test_powers_of_ten_as_they_are_printed() -> None:
    assert [power_text(x) for x in (1e-12, 2e-5, 1.0, 5e3, 1e10, 1e12, 1e100)] == [
        "10⁻¹²", "2·10⁻⁵", "10⁰", "5·10³", "10¹⁰", "10¹²", "10¹⁰⁰",
    ]  # fmt: skip


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
