"""Numbers as they are printed."""

from __future__ import annotations

import math

import pytest
import xarray as xr
from matplotlib.text import Text

from wucht import TorqueBalance, draw, load_machine, report, run
from wucht.results.formatting import (
    abscissa_label,
    bodies_in_words,
    engineering_text,
    label,
    number_text,
    parameter_in_words,
    percent,
    round_numbers,
    unit_in_print,
    units_in_print,
    value_in_words,
    with_unit,
    wrap_text,
)
from wucht.schema.units import Unit


@pytest.mark.parametrize(
    ("share", "off", "words"),
    [
        (0.24881, 0.0075, "24.88 % ± 0.75 %"),
        (0.0389, 0.000112, "3.890 % ± 0.011 %"),
        (0.83, 0.14, "83 % ± 14 %"),
        (0.5, 0.0, "50 %"),
        (1.0, float("nan"), "100 %"),
        (0.5, 1e-12, "50.000000 % ± 0.000000 %"),
    ],
)
def test_as_many_decimals_as_the_uncertainty_is_worth(share: float, off: float, words: str) -> None:
    assert percent(share, off) == words


def test_several_numbers_are_printed_by_the_same_factor() -> None:
    assert value_in_words([0.001, 0.0025], 1e3, "mm") == "[1, 2.5] mm"
    assert value_in_words(0.001, 1e3, "mm") == "1 mm" and value_in_words(True, 1e3, "mm") == "True"


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (0.5 * math.pi, "rad/s", "1.5708 rad/s (15 rpm)"),
        (math.pi / 4, "rad/s", "0.7854 rad/s (7.5 rpm)"),
        (-math.pi / 4, "rad/s", "-0.7854 rad/s (-7.5 rpm)"),
        (-100 * math.pi / 3, "rad/s", "-104.72 rad/s (-1000 rpm)"),
        (math.pi / 8, "rad", "22.5°"),
        (1.5e-3, "m", "1.5 mm"),
        (1e-5, "m", "0.01 mm"),
        (9e-6, "m", "9 µm"),
        (-2e-3, "m", "-2 mm"),
        (-9e-6, "m", "-9 µm"),
        (0.0, "m", "0 µm"),
        (2.0, "m", "2000 mm"),
    ],
)
def test_speeds_in_both_units_small_lengths_in_micrometres(value: float, unit: str, words: str) -> None:
    assert number_text(value, unit) == words


def test_labels_have_their_unit_in_brackets_and_powers_raised() -> None:
    data = xr.Dataset({"a": ("n", [1.0], {"long_name": "acceleration", "units": "m/s^2"}), "b": ("n", [1.0])})
    assert label(data, "a") == "acceleration (m/s²)" and label(data, "a", "mm") == "acceleration (mm)"
    assert (label(data, "b"), label(data, "a", "")) == ("b", "acceleration")
    assert with_unit("jerk", "m/s^3") == "jerk (m/s³)"
    assert (unit_in_print("m"), unit_in_print("m/s"), unit_in_print("")) == ((1e3, "mm"), (1.0, "m/s"), (1.0, ""))


@pytest.mark.parametrize(
    ("name", "printed"),
    [
        ("slope of the motor, U_M/(k M e^2)", "slope of the motor, $U_M/(k\\,M\\,e^2)$"),
        ("amplitude ratio, m r/(M* e)", "amplitude ratio, $m\\,r/(M^*\\,e)$"),
        ("damping of n pendulums on the rotor, n b_r/(k J_R)", "damping of n pendulums on the rotor, $n\\,b_r/(k\\,J_R)$"),
        ("beta_p: damping of the pendulums, b_r/(k J_P)", "$\\beta_p$: damping of the pendulums, $b_r/(k\\,J_P)$"),
        ("u: slope of the motor", "$u$: slope of the motor"),
        ("psi: mean phase at the start", "$\\psi$: mean phase at the start"),
        ("no-load speed over natural frequency", "no-load speed over natural frequency"),
        ("rotor: speed", "rotor: speed"),
        ("sigma", "$\\sigma$"),
        ("phase", "phase"),
        ("signal, either/or", "signal, either/or"),
    ],
)  # fmt: skip
def test_a_formula_in_a_label_is_set_as_one(name: str, printed: str) -> None:
    assert with_unit(name, "") == printed


def test_an_abscissa_without_a_unit_has_a_symbol() -> None:
    data = xr.Dataset({n: (n, [1.0], {"long_name": f"the {n}", "units": ""}) for n in ("time", "speed", "course_time")})
    assert abscissa_label(data, "time") == "time $\\tau$" and abscissa_label(data, "speed") == "speed $\\omega$"
    assert abscissa_label(data, "course_time", "time") == "time $\\tau$"
    data.course_time.attrs["units"] = "s"
    assert abscissa_label(data, "course_time", "time") == "the course_time (s)"


@pytest.mark.parametrize(
    ("path", "name", "words"),
    [("u", "u", "u"), ("u", "parameter u", "u"), ("u", "drive", "u: drive"), ("drive.slope", "slope, drive", "slope, drive")],
)
def test_a_parameter_in_words(path: str, name: str, words: str) -> None:
    assert parameter_in_words(path, name) == words


def test_a_unit_in_brackets_is_not_broken() -> None:
    assert wrap_text("torque of the drive (N m s)", 20) == ["torque of the drive", "(N\xa0m\xa0s)"]
    assert wrap_text("one\n\ntwo three", 5) == ["one", "", "two", "three"]
    assert wrap_text("unbreakable-word", 4) == ["unbreakable-word"]


@pytest.mark.parametrize(
    ("value", "unit", "form", "words", "bare"),
    [
        (2.0, "m", "", "2000 mm", "2"),
        (2.0, "m/rad^2", "", "2000 mm/rad²", "2"),
        (math.pi, "rad", "", "180°", "180°"),
        (0.125, "", "%", "12.5 %", "12.5 %"),
        (0.123461, "", ".4%", "12.35 %", "12.35 %"),
        (1.23456, "N m", "", "1.235 N m", "1.2346"),
        (1.23456, "m", ".2f", "1.23 m", "1.23"),
        ({}, "m", "", "none", "none"),
        (None, "m", "", None, None),
        ("as it is", "m", "", "as it is", "as it is"),
    ],
)
def test_a_number_with_the_unit_of_its_quantity(
    value: object, unit: str, form: str, words: str | None, bare: str | None
) -> None:
    assert number_text(value, unit, form) == words
    assert number_text(value, unit, form, dimensionless=True) == bare


def test_counts_and_lists_in_words() -> None:
    assert [bodies_in_words(n) for n in (0, 1, 2)] == ["0 bodies", "1 body", "2 bodies"]
    assert value_in_words(0.0123456789, 1e3, "mm") == "12.3457 mm" and value_in_words("high", 1e3, "mm") == "high"
    assert value_in_words(2, 1.0, "") == "2"


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("torque 3.4 N m; 0.02 N m s, 60000 N/m", "torque 3.4 N·m; 0.02 N·m·s, 60000 N/m"),
        ("0.45 kg m and 150 kg m^2, 3 g mm", "0.45 kg·m and 150 kg·m², 3 g·mm"),
        ("1 N m s^2, 5 N s/m, 2 N m/rad", "1 N·m·s², 5 N·s/m, 2 N·m/rad"),
        ("at most 9.81 m/s^2 or 3 rad/s^2", "at most 9.81 m/s² or 3 rad/s²"),
        ("chords within 1 um, sum 3", "chords within 1 µm, sum 3"),
        ("the mass m of 3 kg moves s of 2 m; h^2/r", "the mass m of 3 kg moves s of 2 m; h^2/r"),
    ],
)
def test_units_in_print(text: str, printed: str) -> None:
    """Products with a dot, powers raised, micrometres with a Greek letter; words are left alone."""
    assert units_in_print(text) == printed
    assert units_in_print(printed) == printed


@pytest.mark.parametrize("unit", ["N m", "N m s", "kg m^2", "kg m", "N s/m", "um", "m/s^2", "N m s^2"])
def test_a_file_may_give_a_unit_as_it_is_printed(unit: str) -> None:
    si = "m" if unit == "um" else unit
    quantity = Unit(si, "number")
    assert quantity.parse_quantity(f"2 {units_in_print(unit)}") == quantity.parse_quantity(f"2 {unit}")


@pytest.mark.parametrize(
    ("value", "unit", "printed"),
    [
        (0.0, "N m s", "0 N·m·s"),
        (3000.0, "N m", "3 kN·m"),
        (3.0, "N m", "3 N·m"),
        (300.0, "N s/m", "300 N·s/m"),
        (0.45, "kg m", "0.45 kg·m"),
        (0.045, "kg m", "45 kg·mm"),
        (0.025, "kg m^2", "0.025 kg·m²"),
        (0.0025, "kg m^2", "25 kg·cm²"),
        (2e-6, "m", "2 µm"),
        (9.81, "m/s^2", "9.81 m/s²"),
        (5e4, "N/m", "50 N/mm"),
        (-5e4, "N/m", "-50 N/mm"),
    ],
)
def test_a_data_sheet_has_units_in_print(value: float, unit: str, printed: str) -> None:
    assert engineering_text(value, unit) == printed


def test_a_report_and_a_figure_are_printed_in_these_units() -> None:
    """Whatever a study writes: the torques of working points, a parameter of another unit than its own."""
    result = run(TorqueBalance(), load_machine("practice/fan-on-belt"))
    printed = "\n".join(report(result))
    assert "N·m" in printed
    assert "N m" not in printed
    words = [text.get_text() for text in draw(result).findobj(Text)]
    assert "torque (N·m)" in words
    assert not any("N m" in text for text in words)
    assert result.wucht.quantities["working_points"]["parts"]["torque"]["unit"] == "N m", "data keep their units"


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("after 7.3071 s", "after 7.307 s"),
        ("-13.766 rad/s, 12345.678 rpm", "-13.77 rad/s, 12350 rpm"),
        ("1.234567e-05 m and 0.000123456 m", "1.235e-05 m and 0.0001235 m"),
        ("9.99996 s", "10.00 s"),
        ("25000 turns, 0.0195 N m s, version 1.23456.7, u = 2.5.", "25000 turns, 0.0195 N m s, version 1.23456.7, u = 2.5."),
    ],
)
def test_numbers_of_a_sentence_have_four_digits(text: str, expected: str) -> None:
    assert round_numbers(text) == expected
