"""Units at the edge: what a string means, and what is refused."""

import math
import re

import pytest

from wucht.schema import LARGEST, Unit, units


def test_a_frequency_counts_turns() -> None:
    for given in ("50 Hz", 50, "50", "3000 rpm", "0.05 kHz", "18000 deg/s", "50 turn/s"):
        assert Unit("Hz", "frequency").parse_quantity(given) == pytest.approx(50, rel=1e-14), given


def test_turns_a_minute_as_loggers_write_them() -> None:
    for unit in (
        "RPM", "Rpm", "upm", "UPM", "U/min", "u/min", "Umdr/min", "Umdr./min", "Umdrehungen/min", "r/min", "rev/min", "REV/MIN",
        "1/min", "1 / min", "/min", "min^-1", "min-1", "min⁻¹", "U min^-1",
    ):  # fmt: skip
        assert Unit("rad/s", "speed").parse_quantity(f"3000 {unit}") == pytest.approx(100 * math.pi, rel=1e-14), unit
        assert Unit("Hz", "frequency").parse_quantity(f"3000 {unit}") == pytest.approx(50, rel=1e-14), unit


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
        ("ohm", 1e-3, ["mOhm", "mΩ", "mohm", "mV/A"]),
        ("V", 1e3, ["kV"]),
        ("H", 1, ["V s/A", "ohm s"]),
        ("Wb", 1, ["V s", "V s/rad", "N m/A"]),
    ],
)  # fmt: skip
def test_units_as_people_write_them(si, factor, spellings):
    """To Pint ``Nm`` is the fineness of a yarn, ``grad`` a gradian, and most of the others nothing."""
    for spelling in spellings:
        assert Unit(si, "quantity").parse_quantity(f"2 {spelling}") == pytest.approx(2 * factor, rel=1e-14), spelling


@pytest.mark.parametrize(
    ("si", "given", "sentence"),
    [
        ("kg", "2,5 kg", "such as '1 kg'.*write a decimal point, no comma"),
        ("kg", "1 000 kg", "write the digits of a number together"),
        ("N/m", "2.5 * 10^5 N/m", "write powers of ten as 1e3"),
        ("kg", "2 Kg", "such as '1 kg'; 'Kg' is not a known unit"),
        ("N m", "2 nm", "such as '1 N m'; this one is a length"),
        ("V", "3 A", "this one is a current"),
        ("kg", "3 K", r"this one is a quantity of dimension \[temperature\]"),
        ("Hz", "50 1/s", "a number in Hz .* cannot be read .*write rpm, Hz or rad/s"),
        ("Hz", math.inf, "must be a finite quantity in Hz"),
        ("1/s", "5 Hz", "Hz counts turns, so that 'Hz' is not clear: write it with s or rad/s"),
        ("rad/s", "5 s^-1", "'s\\^-1' does not say whether turns or radians: write rpm, Hz or rad/s"),
        ("rad/s", "5 m/m/s", "does not say whether turns or radians"),
        ("rad", "50 rpm", "must be a quantity"),
        ("kg", "heavy", "a decimal point, no comma"),
        ("kg", True, "must be a quantity, a number in kg"),
        ("kg", 10**400, "this one is too large"),
        ("", "3 mm", "must be a quantity, a number without unit"),
        ("", "5 dB", "has an offset or a logarithmic scale"),
        ("Wb", "5 V/" + " " * 300_000 + "x", "is not a known unit"),  # once eight minutes: a pattern of products
    ],
    ids=range(19),
)
def test_a_refusal_says_what_to_write(si, given, sentence):
    with pytest.raises(ValueError, match=sentence):
        Unit(si, "quantity").parse_quantity(given)


def test_turns_a_minute_below_the_stroke_are_written_rpm():
    """As data sheets of motors have a constant of the voltage; to Pint 1/min counts radians, wrong by 2 pi."""
    for unit, si in (("V", "Wb"), ("Nm", "N m s")):
        for speed in ("(1/min)", "min^-1", "min⁻¹", "(min^-1)", "(U/min)", "( 1 / min )"):
            with pytest.raises(ValueError, match="write rpm or rad/s below the stroke"):
                Unit(si, "quantity").parse_quantity(f"5 {unit}/{speed}")
    assert Unit("Wb", "quantity").parse_quantity("5 V/rpm") == pytest.approx(5 * 30 / math.pi)
    assert Unit("m/s^2", "quantity").parse_quantity("5 mm/s/min") == pytest.approx(5e-3 / 60)


def test_common_units_have_the_bits_of_pint(monkeypatch):
    common = units.COMMON
    monkeypatch.setattr(units, "COMMON", {})
    for (unit, si), known in common.items():
        assert Unit(si, "quantity").parse_quantity(f"1 {unit}") == known


@pytest.mark.parametrize(
    ("given", "si"), [("1 kg^9^9^9^9", "kg"), ("1 kg^999999999", "kg"), ("1 N", "N^9^9^9^9"), ("1 " + "kg " * 1000, "kg")]
)
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
