"""Cam tables stay within their tolerance of the law, as the controller interpolates them, with few rows."""

import math

import numpy as np
import pytest
from curves_to_mill import LAW
from tests.refusals import refused

from wucht.cams.workshop.plc import CamTable, Interpolation, Unit, cam_table, largest_deviation

LINEAR, QUINTIC = Interpolation.LINEAR, Interpolation.QUINTIC
FINE = np.linspace(0, 2 * math.pi, 77777)


@pytest.mark.parametrize("interpolation", Interpolation)
@pytest.mark.parametrize("unit", Unit)
@pytest.mark.parametrize("tolerance", [1e-3, 1e-5, 1e-6])
def test_the_tolerance_is_kept_and_made_use_of(interpolation, unit, tolerance):
    table = cam_table(LAW, unit, tolerance, interpolation, decimals=7)
    worst = np.abs(table(FINE) - LAW(FINE)).max()
    assert worst <= tolerance
    assert largest_deviation(table, LAW) == pytest.approx(worst, rel=0.01)
    # Twice as few rows do not keep it: the error falls with the second or the sixth power of their distance.
    assert worst * 2**interpolation.value > tolerance or len(table.phi) == 9
    assert table.interpolation is interpolation


def test_rows_of_linear_interpolation():
    """h^2 max|law''|/8 is the error; the rows are the next number that divides 360 deg into multiples of 0.0001 deg."""
    needed = 2 * math.pi * math.sqrt(np.abs(LAW(FINE, 2)).max() / (8 * 1e-5))
    rows = len(cam_table(LAW, Unit.DEGREE, 1e-5, LINEAR).phi) - 1
    assert needed <= rows < 1.3 * needed
    assert 3_600_000 % rows == 0


def test_as_many_rows_as_the_controller_takes_and_no_more():
    """Both ends of the turn are rows: so many intervals have one row more."""
    rows = len(cam_table(LAW, Unit.DEGREE, 1e-5, LINEAR).phi)
    assert len(cam_table(LAW, Unit.DEGREE, 1e-5, LINEAR, most=rows).phi) == rows
    with refused("tolerance", f"{rows - 1} rows"):
        cam_table(LAW, Unit.DEGREE, 1e-5, LINEAR, most=rows - 1)


@pytest.mark.parametrize("order", [0, 1, 2, 3])
def test_it_is_a_law_with_its_derivatives(order):
    """Differences of the table's own values, and the law's own derivatives."""
    table = cam_table(LAW, Unit.DEGREE, 1e-9, decimals=10)
    assert np.abs(table(FINE, order) - LAW(FINE, order)).max() <= (1e-9, 1e-7, 1e-5, 1e-2)[order]
    h, at = 1e-4, np.array([0.3, 1.0, 4.0, 6.0])
    if order:
        assert (table(at + h, order - 1) - table(at - h, order - 1)) / (2 * h) == pytest.approx(table(at, order), abs=1e-6)


def test_a_polynomial_of_fifth_degree_is_met_exactly():
    phi = np.array([0.0, 2.0, 2 * math.pi])
    p = np.polynomial.Polynomial([1, -2, 0.5, 0.1, -0.03, 0.004])
    table = CamTable(phi, p(phi), p.deriv()(phi), p.deriv(2)(phi), Unit.DEGREE, 6)
    at = np.linspace(0, 6.28, 50)
    for order in range(4):
        assert table(at, order) == pytest.approx(p.deriv(order)(at) if order else p(at), abs=1e-12)


def test_straight_lines_between_positions():
    table = CamTable(np.array([0.0, 2.0, 2 * math.pi]), np.array([1.0, 3.0, 1.0]), None, None, Unit.DEGREE, 6)
    assert table(np.array([0.5, 2.0, 2 * math.pi, -1.0])) == pytest.approx([1.5, 3.0, 1.0, 1 + 2 / (2 * math.pi - 2)])
    assert table(np.array([0.5, 3.0]), 1) == pytest.approx([1.0, -2 / (2 * math.pi - 2)])
    assert table(np.array([[0.5, 3.0]]), 2).tolist() == [[0.0, 0.0]]


@pytest.mark.parametrize("unit", Unit)
def test_the_values_are_those_of_the_file(unit):
    """Rounded in mm or deg; derivatives by the degree, with more decimals."""
    table = cam_table(LAW, unit, 1e-4, decimals=3)
    per, degree = unit.per_si, math.pi / 180
    for column, order, decimals in ((table.position, 0, 3), (table.velocity, 1, 6), (table.acceleration, 2, 8)):
        shown = column * per * degree**order * 10**decimals
        assert np.abs(shown - np.round(shown)).max() < 1e-5
        assert np.abs(column - LAW(table.phi, order)).max() <= 0.5001 * 10.0**-decimals / (per * degree**order)
    assert table.phi[[0, -1]].tolist() == [0.0, 2 * math.pi]
    assert table.position[0] == table.position[-1]
    assert (Unit.MILLIMETRE.per_si, Unit.DEGREE.per_si) == (1000.0, pytest.approx(57.29577951308232, rel=1e-15))


def test_it_closes_whichever_way_its_ends_are_rounded():
    """A law that is 170.0000005 mm at 0, by the rounding of floats a little less there and a little more after a turn."""

    def law(phi, order=0):
        return LAW(phi, order) + (np.where(np.asarray(phi) > 6.28, 1e-12, -1e-12) + 5e-10 if order == 0 else 0.0)

    table = cam_table(law, Unit.MILLIMETRE, 1e-6)
    assert table.position[0] == table.position[-1] == pytest.approx(0.17, abs=1e-10)


def test_derivatives_of_the_table():
    table = cam_table(LAW, Unit.DEGREE, 1e-6, decimals=8)
    assert largest_deviation(table, LAW, 1) < 1e-4
    assert largest_deviation(table, LAW, 2) < 1e-2


def lifting(phi, order=0):
    return np.asarray(phi, float) if order == 0 else np.full(np.shape(phi), float(order == 1))


def missing(phi, order=0):
    return np.where(np.asarray(phi) > 6, np.nan, LAW(phi, order))


@pytest.mark.parametrize(
    ("change", "refusal"),
    [
        ({"tolerance": 0.0}, refused("tolerance", given=0.0, code="not-positive")),
        ({"tolerance": math.nan}, refused("tolerance", given=float("nan"), code="not-positive")),
        ({"decimals": 13}, refused("decimals", given=13, code="decimals")),
        ({"decimals": 2, "tolerance": 4.9e-6}, refused("decimals", given=2)),
        ({"law": lifting}, refused("law", code="not-periodic")),
        ({"law": missing}, refused("law", code="not-finite")),
        ({"tolerance": 1e-6, "interpolation": LINEAR, "most": 500}, refused("tolerance", "500", given=1e-06)),
    ],
)
def test_what_will_not_do(change, refusal):
    with refusal:
        cam_table(**({"law": LAW, "unit": Unit.MILLIMETRE, "tolerance": 1e-5} | change))


def test_the_decimals_that_are_advised_will_do():
    with refused("decimals", given=1):
        cam_table(LAW, Unit.MILLIMETRE, 1e-6, decimals=1)
    assert largest_deviation(cam_table(LAW, Unit.MILLIMETRE, 1e-6, decimals=3), LAW) <= 1e-6
