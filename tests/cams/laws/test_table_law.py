"""A law through the points of a table."""

import math

import numpy as np
import pytest
from tests.refusals import refused

from wucht.cams.laws.table_law import TableLaw
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries

TURN = 2 * math.pi
MOTION = FourierSeries.of(0.1, [1.0, -0.3], [0.2, 0.1])
EVERYWHERE = np.linspace(-10, 10, 501)


def uneven(count, first=0.0):
    """Angles whose distances vary by a factor of 3."""
    k = np.arange(count) / count
    return first + TURN * k - 0.5 * np.sin(TURN * k)


@pytest.mark.parametrize("degree", [3, 5])
@pytest.mark.parametrize("first", [0.0, -2.0])
def test_the_table_is_met(degree, first):
    phi = uneven(13, first)
    law = TableLaw(phi, MOTION(phi), degree)
    for turns in (-2, 0, 1):
        assert law(phi + TURN * turns) == pytest.approx(MOTION(phi), abs=1e-13)


@pytest.mark.parametrize(("degree", "errors"), [(5, (4e-7, 8e-6, 3e-4, 8e-3)), (3, (2e-5, 3e-4, 2e-2, 6e-1))])
def test_between_the_points_and_derivatives(degree, errors):
    """Against the motion itself, to what a spline of that degree through 48 uneven points can do."""
    phi = uneven(48, 1.0)
    law = TableLaw(phi, MOTION(phi), degree)
    for order, error in enumerate(errors):
        off = np.abs(law(EVERYWHERE, order) - MOTION(EVERYWHERE, order)).max()
        assert error / 10 < off < error


@pytest.mark.parametrize("end", [TURN, TURN - 3e-7, TURN + 3e-7])
def test_the_first_point_may_stand_there_again(end):
    """Also where the table rounds 2 pi to 6.283185."""
    phi = uneven(12)
    law = TableLaw(np.append(phi, end), np.append(MOTION(phi), MOTION(0.0) + 1e-9))
    assert np.array_equal(law(EVERYWHERE, 3), TableLaw(phi, MOTION(phi))(EVERYWHERE, 3))


@pytest.mark.parametrize(
    ("phi", "psi", "degree", "refusal"),
    [
        (np.arange(6), np.arange(6), 4, refused("law.degree", "5", "3", given=4)),
        (np.arange(6), np.arange(5), 5, refused("law.file", "5", "6", code="count")),
        (np.arange(6), [0, 1, math.nan, 3, 4, 5], 5, refused("law.file", "point 3", code="not-finite")),
        (
            np.radians([0, 20, 10, 30, 40, 50]),
            np.zeros(6),
            5,
            refused("law.file", given="10 deg after 20 deg", code="not-increasing"),
        ),
        (
            np.radians([0, 20, 20, 30, 40, 50]),
            np.zeros(6),
            5,
            refused("law.file", given="20 deg after 20 deg", code="not-increasing"),
        ),
        (np.linspace(0, 7, 8), np.zeros(8), 5, refused("law.file", "360 deg", given="401.070457 deg", code="too-long")),
        (np.linspace(0, TURN, 9), [0, 1, 2, 3, 2, 1, 0, 0, 0.1], 5, refused("law.file", "0", given=0.1, code="not-closed")),
        (np.arange(5), np.arange(5), 5, refused("law.file", "degree 5", "6", given="5 points", code="too-few")),
        (np.linspace(0, TURN, 4), np.zeros(4), 3, refused("law.file", "degree 3", "4", given="3 points", code="too-few")),
        ([], [], 5, refused("law.file", "degree 5", "6", given="0 points", code="too-few")),
    ],
)
def test_wrong_tables(phi, psi, degree, refusal):
    with refusal:
        TableLaw(np.array(phi), np.array(psi), degree)


@pytest.mark.parametrize("degree", [3, 5])
def test_as_few_points_as_the_degree_needs(degree):
    phi = np.arange(degree + 1) / (degree + 1) * TURN
    assert TableLaw(phi, np.cos(phi), degree)(phi) == pytest.approx(np.cos(phi), abs=1e-13)


@pytest.mark.parametrize("turned", [1, -1])
@pytest.mark.parametrize("upside_down", [1, -1])
def test_uneven_points_and_their_mirror_images_make_up_a_turn(turned, upside_down):
    """Points 1 to 40 deg apart, 60 deg open; the one steep flank goes up or down, as the motion from the last to the first."""
    angles = turned * np.radians([0, 1, 2, 5, 15, 25, 60, 100, 140, 180, 220, 260, 300])
    outputs = upside_down * np.array([0.0, 0.1, 0.2, 0.5, 1.0, 1.0, 0.98, 0.97, 0.96, 0.95, 0.94, 0.93, 0.92])
    order = np.argsort(angles)
    law = TableLaw(angles[order], outputs[order], 3)
    assert law(angles) == pytest.approx(outputs, abs=1e-12)


@pytest.mark.parametrize(
    ("angles", "outputs", "sentence"),
    [
        (np.linspace(0, 3.5, 40), np.sin(np.linspace(0, 3.5, 40)), "there are none from 200.535 to 360 deg"),
        (np.linspace(0, 5.9, 60), np.linspace(0, 1, 60), "from 338.045 to 360 deg it jumps back"),
    ],
)
def test_points_make_up_a_whole_turn(angles, outputs, sentence):
    with pytest.raises(InputError, match=sentence):
        TableLaw(angles, outputs)
    closed = np.linspace(0, 6.0, 60)
    assert TableLaw(closed, 1 - np.cos(closed))(6.1) == pytest.approx(1 - math.cos(6.1), abs=1e-3)
