"""Units at the edge: what a string means, and what is refused."""

import math
import re

import pytest

from wucht.schema import LARGEST, Unit, units


@pytest.mark.parametrize(
    "given", ["50 Hz", 50, 50.0, "50", "3000 rpm", "314.1592653589793 rad/s", "0.05 kHz", "18000 deg/s", "50 turn/s"]
)
def test_a_frequency_counts_turns(given):
    assert Unit("Hz", "frequency").parse_quantity(given) == pytest.approx(50, rel=1e-14)


@pytest.mark.parametrize(
    "unit",
    [
        "RPM", "Rpm", "upm", "UPM", "U/min", "u/min", "Umdr/min", "Umdr./min", "Umdrehungen/min", "r/min", "rev/min",
        "REV/MIN", "1/min", "1 / min", "/min", "min^-1", "min-1", "min⁻¹", "U min^-1",
    ],
)  # fmt: skip
def test_turns_a_minute_as_loggers_write_them(unit):
    assert Unit("rad/s", "speed").parse_quantity(f"3000 {unit}") == pytest.approx(100 * math.pi, rel=1e-14)
    assert Unit("Hz", "frequency").parse_quantity(f"3000 {unit}") == pytest.approx(50, rel=1e-14)


@pytest.mark.parametrize(
    ("given", "si", "value"),
    [
        ("50 U/s", "rad/s", 100 * math.pi),
        ("50 rev/s", "rad/s", 100 * math.pi),
        ("180 Grad/s", "rad/s", math.pi),
        ("2 rev", "rad", 4 * math.pi),
        ("2 U", "rad", 4 * math.pi),
        ("2 Umdr", "rad", 4 * math.pi),
        ("180 Grad", "rad", math.pi),
    ],
)
def test_turns_and_degrees_as_loggers_write_them(given, si, value):
    """To Pint a U is an enzyme unit, and a Grad 1e9 rad."""
    assert Unit(si, "quantity").parse_quantity(given) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("si", "factor", "spellings"),
    [
        ("N m", 1, ["N m", "Nm", "N*m", "N·m", "N.m", "N * m"]),
        ("N m", 1e3, ["kNm", "kN m", "kN.m"]),
        ("N m", 1e-3, ["mNm", "Nmm", "N mm"]),
        ("N m", 1e-2, ["Ncm"]),
        ("N s/m", 1, ["Ns/m", "N*s/m", "N.s/m", "N/(m/s)", "kg/s"]),
        ("N s/m", 1e3, ["kNs/m", "Ns/mm"]),
        ("N m s", 1, ["Nms", "Nm s", "N m s", "Nm*s", "Nms/rad", "Nm/(rad/s)", "kg m^2/s", "kgm²/s"]),
        ("N m/rad", 1, ["Nm/rad", "Nm"]),
        ("N m/rad", 180 / math.pi, ["Nm/°", "Nm/deg", "Nm/grad", "N m/Grad"]),
        ("kg m^2", 1, ["kg m^2", "kg m2", "kg m²", "kgm^2", "kgm2", "kgm²", "kg*m^2", "kg*m2", "kg.m2", "kg m**2", "Nms²"]),
        ("kg m^2", 1e-7, ["gcm2", "g cm²", "g*cm^2"]),
        ("kg m^2", 1e-6, ["kg mm2", "kgmm²"]),
        ("kg m^2", 1e3, ["t m2", "tm²"]),
        ("kg m", 1, ["kgm", "kg*m"]),
        ("kg m", 1e-6, ["gmm", "g mm", "g.mm"]),
        ("m/s^2", 1, ["m/s2", "m/s²", "m/s^2", "m s^-2", "m s⁻²", "m·s⁻²"]),
        ("N s/m", 1, ["N s m⁻¹", "kg s⁻¹"]),
        ("rad", math.pi / 180, ["°", "deg", "grad", "Grad"]),
        ("rad", math.pi / 200, ["gon"]),
        ("rad/s", math.pi / 180, ["°/s", "deg/s", "grad/s", "Grad/s"]),
        ("ohm", 1e-3, ["mOhm", "mΩ", "mohm"]),
    ],
)  # fmt: skip
def test_units_as_people_write_them(si, factor, spellings):
    """To Pint ``Nm`` is the fineness of a yarn, ``grad`` a gradian, and most of the others nothing."""
    for spelling in spellings:
        assert Unit(si, "quantity").parse_quantity(f"2 {spelling}") == pytest.approx(2 * factor, rel=1e-14), spelling


def test_the_usual_spellings_do_without_pint(monkeypatch):
    monkeypatch.setattr(units, "_registry", lambda: pytest.fail("Pint is loaded"))
    for si, unit in (("N m", "Nm"), ("N s/m", "Ns/m"), ("N m s", "Nms"), ("kg m^2", "kgm²"), ("rad", "°"), ("rad/s", "1/min")):
        assert Unit(si, "quantity").parse_quantity(f"3 {unit}") > 0


@pytest.mark.parametrize(
    ("si", "given", "sentence"),
    [
        ("kg", "2,5 kg", "such as '1 kg'.*write a decimal point, no comma"),
        ("rad/s", "2,5 rpm", "write a decimal point, no comma"),
        ("kg", "1.000,5 kg", "write a decimal point, no comma"),
        ("kg", "1 000 kg", "write the digits of a number together"),
        ("kg", "1'000 kg", "write the digits of a number together"),
        ("N/m", "2.5 * 10^5 N/m", "write powers of ten as 1e3"),
        ("N/m", "10^5 N/m", "write powers of ten as 1e3"),
        ("kg", "2 Kg", "such as '1 kg'; 'Kg' is not a known unit"),
        ("N m", "2 nm", "such as '1 N m'; this one is a length"),
        ("N", "2 Nm", "this one is a torque"),
    ],
)
def test_what_is_refused_says_what_to_write(si, given, sentence):
    with pytest.raises(ValueError, match=sentence):
        Unit(si, "quantity").parse_quantity(given)


@pytest.mark.parametrize(
    ("si", "given"), [("rad/s", "50 U"), ("rad", "50 1/min"), ("rad", "50 rpm"), ("s", "50 U"), ("kg", "1 1/min")]
)
def test_turns_are_no_other_quantity(si, given):
    with pytest.raises(ValueError, match="must be a quantity"):
        Unit(si, "quantity").parse_quantity(given)


def test_a_long_unit_is_refused_at_once():
    """300,000 blanks took eight minutes: a pattern of products."""
    with pytest.raises(ValueError, match="is not a known unit"):
        Unit("Wb", "quantity").parse_quantity("5 V/" + " " * 300_000 + "x")


@pytest.mark.parametrize("unit", ["dB", "Np", "octave", "decade"])
def test_a_logarithmic_scale_is_no_factor(unit):
    """5 dB, to Pint 10^(5/10), is not five times 1 dB."""
    with pytest.raises(ValueError, match="has an offset or a logarithmic scale"):
        Unit("", "quantity").parse_quantity(f"5 {unit}")


@pytest.mark.parametrize(
    "speed", ["(1/min)", "min^-1", "min-1", "min⁻¹", "min**-1", "(min^-1)", "(U/min)", "(r/min)", "(rev/min)", "( 1 / min )"]
)
@pytest.mark.parametrize(("unit", "si"), [("V", "Wb"), ("mV", "Wb"), ("Nm", "N m s"), ("Nm", "N m s/rad")])
def test_turns_a_minute_below_the_stroke_are_written_rpm(unit, si, speed):
    """As data sheets of motors have a constant of the voltage; to Pint 1/min counts radians, wrong by 2 pi."""
    with pytest.raises(ValueError, match="write rpm or rad/s below the stroke"):
        Unit(si, "quantity").parse_quantity(f"5 {unit}/{speed}")
    assert Unit(si, "quantity").parse_quantity("5 N m/rpm" if unit == "Nm" else f"5 {unit}/rpm") > 0
    assert Unit("m/s^2", "quantity").parse_quantity("5 mm/s/min") == pytest.approx(5e-3 / 60)


@pytest.mark.parametrize(
    ("noun", "written"),
    [
        ("angle", "an angle"),
        ("unit", "a unit"),
        ("mass of the lever", "a mass of the lever"),
        ("stiffness", "a stiffness"),
        ("axis", "an axis"),
        ("radius of the pulses", "a radius of the pulses"),
        ("number of orders", "a number of orders"),
        ("Young's modulus of the cam", "a Young's modulus of the cam"),
        ("orders that are kept", "orders that are kept"),
        ("sine coefficients", "sine coefficients"),
        ("points (time, displacement)", "points (time, displacement)"),
    ],
)
def test_article(noun, written):
    assert units.article(noun) == written


@pytest.mark.parametrize(("unit", "si"), units.COMMON)
def test_common_units_have_the_bits_of_pint(unit, si, monkeypatch):
    known = units.COMMON[unit, si]
    monkeypatch.setattr(units, "COMMON", {})
    assert Unit(si, "quantity").parse_quantity(f"1 {unit}") == known


@pytest.mark.parametrize("given", ["50 Hz", "3000 rpm", "314.1592653589793 rad/s", 100 * math.pi])
def test_an_angular_speed_counts_radians(given):
    assert Unit("rad/s", "speed").parse_quantity(given) == pytest.approx(100 * math.pi, rel=1e-14)


@pytest.mark.parametrize(
    ("given", "message"),
    [
        ("50 1/s", "a number in Hz .* cannot be read .*write rpm, Hz or rad/s"),
        ("50 s^-1", "does not say whether turns or radians"),
        ("50 s", "this one is a time"),
        ("50 Hz/s", "this one is a"),
        ("50 hurz", "'hurz' is not a known unit"),
        (math.inf, "finite frequency in Hz"),
    ],
)
def test_a_frequency_that_is_none_is_refused(given, message):
    with pytest.raises(ValueError, match=message):
        Unit("Hz", "frequency").parse_quantity(given)


@pytest.mark.parametrize(
    ("si", "given", "value"),
    [
        ("V", "0.4 kV", 400),
        ("V", "230 V", 230),
        ("ohm", "0.5 ohm", 0.5),
        ("ohm", "50 mΩ", 0.05),
        ("ohm", "3 V/A", 3),
        ("H", "20 mH", 0.02),
        ("H", "3 V s/A", 3),
        ("H", "3 ohm s", 3),
        ("Wb", "3 Wb", 3),
        ("Wb", "3 V s", 3),
        ("Wb", "3 V s/rad", 3),
        ("Wb", "3 N m/A", 3),
        ("V s", "3 mWb", 0.003),
        ("N m s", "3 N m/(rad/s)", 3),
        ("N m s^2", "3 kg m^2", 3),
    ],
)
def test_electrical_units(si, given, value):
    assert Unit(si, "quantity").parse_quantity(given) == pytest.approx(value, rel=1e-14)


@pytest.mark.parametrize(
    ("si", "given", "message"),
    [
        ("V", "3 A", "this one is a current"),
        ("A", "3 V", "this one is a voltage"),
        ("V", "3 mH", "this one is an inductance"),
        ("H", "3 ohm", "this one is a resistance"),
        ("ohm", "3 Wb", "this one is a magnetic flux"),
        ("kg", "3 N m", "this one is a torque"),
        ("kg", "3 kg m^2", "this one is a moment of inertia"),
        ("kg", "3 kg m", "this one is an unbalance"),
        ("kg", "3 K", r"this one is a quantity of dimension \[temperature\]"),
    ],
)
def test_another_dimension_is_named(si, given, message):
    with pytest.raises(ValueError, match=message):
        Unit(si, "quantity").parse_quantity(given)


@pytest.mark.parametrize(
    ("given", "si"),
    [
        ("1 kg^9^9^9^9", "kg"), ("1 kg**9**9**9", "kg"), ("1 kg^999999999", "kg"), ("1 N", "N^9^9^9^9"), ("1 N", "9**9**9"),
        ("1 kg^(9^9^9)", "kg"), ("1 " + "kg " * 1000, "kg"), ("1 kg^9.9^9.9^9", "kg"),
    ],
)  # fmt: skip
def test_powers_of_powers_are_refused_and_never_computed(given, si):
    """Pint would compute 9^9^9^9."""
    with pytest.raises(ValueError, match=r"a power in a unit is a number below 100|more than 60 characters"):
        Unit(si, "mass").parse_quantity(given)


@pytest.mark.parametrize(("given", "value"), [("2 kg^1 m^2 m^-2", 2.0), ("3 kg^(1.0)", 3.0), ("4 g**1", 0.004)])
def test_other_powers_are_read(given, value):
    assert Unit("kg", "mass").parse_quantity(given) == pytest.approx(value)


@pytest.mark.parametrize("si", ["N/m", "rad", "", "Hz"])
def test_what_is_beyond_all_physics_is_refused(si):
    """Products of several quantities are numbers still."""
    unit = Unit(si, "quantity")
    assert unit.parse_quantity(LARGEST) == LARGEST
    for given in (1.01e30, 1e308, f"1e300 {si}"):
        with pytest.raises(ValueError, match=rf"must be a quantity of at most 1e\+30( {re.escape(si)})?$"):
            unit.parse_quantity(given)
    with pytest.raises(ValueError, match=r"must be a quantity of at least -1e\+30"):
        unit.parse_quantity(-1e31)
    assert unit.accepts(1e31) and not unit.accepts("1 parsec per fortnight")


def test_what_is_divided_by_is_not_all_but_nothing():
    mass = Unit("kg", "mass")
    assert (mass.parse_positive(1e-30), mass.parse_positive("0 kg"), mass.parse_positive(-1)) == (1e-30, 0, -1)
    with pytest.raises(ValueError, match=r"must be a mass greater than 0 kg, and of at least 1e-30 kg"):
        mass.parse_positive(1e-320)


@pytest.mark.parametrize(
    ("si", "given", "message"),
    [
        ("1/s", "5 Hz", "Hz counts turns, so that 'Hz' is not clear: write it with s or rad/s"),
        ("N s/m", "5 N/(m Hz)", "Hz counts turns"),
        ("rad/s", "5 s^-1", "'s\\^-1' does not say whether turns or radians: write rpm, Hz or rad/s"),
        ("rad/s", "5 m/m/s", "does not say whether turns or radians"),
        ("kg", "1,5 kg", "write a decimal point, no comma"),
        ("kg", "1 500 kg", "write the digits of a number together"),
        ("kg", "3*10^3 kg", "write powers of ten as 1e3"),
        ("kg", "heavy", "a decimal point, no comma"),
        ("rad/s", "fast", "write rpm, Hz or rad/s"),
        ("Hz", "fast", "write rpm, Hz or rad/s"),
        ("kg", True, "must be a quantity, a number in kg"),
        ("kg", 10**400, "this one is too large"),
        ("", "3 mm", "must be a quantity, a number without unit"),
    ],
)
def test_every_refusal_says_what_to_write(si, given, message):
    with pytest.raises(ValueError, match=message):
        Unit(si, "quantity").parse_quantity(given)


@pytest.mark.parametrize(("si", "given"), [("1/s", "5 1/s"), ("1/s", "5 s^-1"), ("rad/s", "5 rad/s"), ("Hz", "5 Hz")])
def test_beside_them_what_is_clear_is_read(si, given):
    assert Unit(si, "quantity").parse_quantity(given) == pytest.approx(5.0, rel=1e-14)
