"""Numbers as they are printed."""

from __future__ import annotations

import math
from pathlib import Path

import pytest
from matplotlib.text import Text

from wucht import TorqueBalance, draw, load_machine, report, run, run_file
from wucht.results.formatting import (
    engineering_text,
    number_text,
    percent,
    round_numbers,
    rpm_first,
    units_in_print,
    with_unit,
)
from wucht.schema.units import Unit

ROTOR = """\
[machine.carrier]
mass = "40 kg"
stiffness = "2e4 N/m"
damping = "300 N s/m"
[[machine.bodies]]
kind = "rotor"
name = "drum"
mass = "10 kg"
unbalance = "0.02 kg m"
inertia = "0.3 kg m^2"
[machine.drive]
kind = "linear"
slope = "0.5 N m s"
no_load_speed = "SPEED"
[study]
kind = "run-up"
until = "4 s"
"""


@pytest.mark.parametrize(
    ("share", "off", "words"),
    [(0.24881, 0.0075, "24.88 % ± 0.75 %"), (0.83, 0.14, "83 % ± 14 %"), (0.5, 0.0, "50 %")],
)
def test_as_many_decimals_as_the_uncertainty_is_worth(share: float, off: float, words: str) -> None:
    assert percent(share, off) == words


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (0.5 * math.pi, "rad/s", "1.5708 rad/s (15 rpm)"),
        (math.pi / 8, "rad", "22.5°"),
        (1e-5, "m", "0.01 mm"),
        (9e-6, "m", "9 µm"),
    ],
)
def test_speeds_in_both_units_small_lengths_in_micrometres(value: float, unit: str, words: str) -> None:
    assert number_text(value, unit) == words


@pytest.mark.parametrize(
    ("name", "printed"),
    [
        ("slope of the motor, U_M/(k M e^2)", "slope of the motor, $U_M/(k\\,M\\,e^2)$"),
        ("beta_p: damping of the pendulums, b_r/(k J_P)", "$\\beta_p$: damping of the pendulums, $b_r/(k\\,J_P)$"),
        ("rotor: speed", "rotor: speed"),
        ("signal, either/or", "signal, either/or"),
    ],
)
def test_a_formula_in_a_label_is_set_as_one(name: str, printed: str) -> None:
    assert with_unit(name, "") == printed


@pytest.mark.parametrize(
    ("value", "unit", "form", "words", "bare"),
    [
        (2.0, "m/rad^2", "", "2000 mm/rad²", "2"),
        (math.pi, "rad", "", "180°", "180°"),
        (0.123461, "", ".4%", "12.35 %", "12.35 %"),
        (1.23456, "N m", "", "1.235 N m", "1.2346"),
        (1.23456, "m", ".2f", "1.23 m", "1.23"),
        (None, "m", "", None, None),
    ],
)
def test_a_number_with_the_unit_of_its_quantity(
    value: object, unit: str, form: str, words: str | None, bare: str | None
) -> None:
    assert number_text(value, unit, form) == words
    assert number_text(value, unit, form, dimensionless=True) == bare


@pytest.mark.parametrize(
    ("text", "printed"),
    [
        ("torque 3.4 N m; 0.02 N m s, 60000 N/m", "torque 3.4 N·m; 0.02 N·m·s, 60000 N/m"),
        ("1 N m s^2, 5 N s/m, 2 N m/rad", "1 N·m·s², 5 N·s/m, 2 N·m/rad"),
        ("chords within 1 um, sum 3", "chords within 1 µm, sum 3"),
        ("the mass m of 3 kg moves s of 2 m; h^2/r", "the mass m of 3 kg moves s of 2 m; h^2/r"),
    ],
)
def test_units_in_print(text: str, printed: str) -> None:
    """Products with a dot, powers raised, micrometres with a Greek letter; words are left alone."""
    assert units_in_print(text) == printed
    assert units_in_print(printed) == printed


@pytest.mark.parametrize("unit", ["N m s", "kg m^2", "N s/m", "um"])
def test_a_file_may_give_a_unit_as_it_is_printed(unit: str) -> None:
    si = "m" if unit == "um" else unit
    quantity = Unit(si, "number")
    assert quantity.parse_quantity(f"2 {units_in_print(unit)}") == quantity.parse_quantity(f"2 {unit}")


@pytest.mark.parametrize(
    ("value", "unit", "printed"),
    [
        (3000.0, "N m", "3 kN·m"),
        (3.0, "N m", "3 N·m"),
        (0.045, "kg m", "45 kg·mm"),
        (0.0025, "kg m^2", "25 kg·cm²"),
        (2e-6, "m", "2 µm"),
        (9.81, "m/s^2", "9.81 m/s²"),
        (-5e4, "N/m", "-50 N/mm"),
    ],
)
def test_a_data_sheet_has_units_in_print(value: float, unit: str, printed: str) -> None:
    assert engineering_text(value, unit) == printed


@pytest.mark.slow
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
        ("-13.766 rad/s, 12345.678 rpm", "-13.77 rad/s, 12350 rpm"),
        ("1.234567e-05 m and 0.000123456 m", "1.235e-05 m and 0.0001235 m"),
        ("9.99996 s", "10.00 s"),
        ("25000 turns, 0.0195 N m s, version 1.23456.7, u = 2.5.", "25000 turns, 0.0195 N m s, version 1.23456.7, u = 2.5."),
    ],
)
def test_numbers_of_a_sentence_have_four_digits(text: str, expected: str) -> None:
    assert round_numbers(text) == expected


@pytest.mark.parametrize(
    ("value", "unit", "words"),
    [
        (37479.6, "h", "37,480 h"),
        (9999.4, "h", "9999 h"),
        (9999.6, "h", "10,000 h"),
        (1.2e7, "h", "1.2e+07 h"),
        (109_344.0, "N", "109.3 kN"),
        (999.0, "N", "999 N"),
        (0.0, "N m", "0 N m"),
        (-2500.0, "N m", "-2.5 kN m"),
        (4.5, "kg m", "4.5 kg m"),
    ],
)
def test_numbers_of_machines_have_units_of_the_trade_and_no_exponents(value: float, unit: str, words: str) -> None:
    assert number_text(value, unit) == words


def test_counts_in_a_format_have_no_exponents_either() -> None:
    assert number_text(11740.2, "", ".4g") == "11,740"
    assert number_text(11740.2, "", ".2e") == "1.17e+04"


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("at no-load speed = 104.72 rad/s rising", "at no-load speed = 1000 rpm (104.72 rad/s) rising"),
        ("from 80 to 160 rad/s", "from 80 to 160 rad/s"),
        ("rate = 0.5 rad/s^2", "rate = 0.5 rad/s^2"),
        ("rate = 0.5 rad/s per s", "rate = 0.5 rad/s per s"),
        ("k = 104.72 rad/s (1000 rpm)", "k = 1000 rpm (104.72 rad/s)"),
    ],
)
def test_values_in_rad_a_second_begin_with_rpm(text: str, words: str) -> None:
    assert rpm_first(text) == words


@pytest.mark.parametrize(
    ("speed", "words"),
    [
        ("1205 rpm", "1203 rpm (125.99 rad/s) of 1205 rpm (126.19 rad/s) without vibration"),
        ("1205 U/min", "1203 rpm (125.99 rad/s) of 1205 rpm (126.19 rad/s) without vibration"),
        ("126.18730 rad/s", "125.99 rad/s (1203 rpm) of 126.19 rad/s (1205 rpm) without vibration"),
    ],
)
def test_speeds_begin_with_rpm_where_the_file_has_rpm(speed: str, words: str, tmp_path: Path) -> None:
    file = tmp_path / "rotor.toml"
    file.write_text(ROTOR.replace("SPEED", speed), encoding="utf-8")
    lines = report(run_file(file))
    assert f"  speed        {words}" in lines
    heading = draw(run_file(file)).axes[0].figure.get_suptitle()  # type: ignore[union-attr]
    assert lines[1].removeprefix("verdict: ") in " ".join(heading.split())
