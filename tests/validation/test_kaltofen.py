"""004: K. Kaltofen, Saubere HS-Bewegungen bei periodisch schwankender Antriebswinkelgeschwindigkeit.

The paper prints no numbers (its ordinates carry no scale): what can be checked are its equations and what its figures show.
"""

import math

import numpy as np
import pytest

from wucht.cams.correction import CorrectedLaw, MotionOverTime, orders, share_above_order
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries

OMEGA = 500 * math.pi / 30
LAW = equiripple(5, math.radians(120), math.radians(24))  # Bild 1: dwell and return by five harmonics
PHI = np.linspace(0, 2 * math.pi, 400)
TAU = np.linspace(-1, 8, 300)


def shaft(scale=1.0):
    """Bild 3: a speed of orders 2 to 5."""
    return ShaftMotion(
        FourierSeries.of(OMEGA, scale * np.array([0, 2.4, 1, 0.5, 0.3]), scale * np.array([0, 1, -1.3, 0.2, 0.4]))
    )


def test_acceleration_over_time_is_that_of_the_paper():
    """004 (3): psi'' phi'^2 + psi' phi''."""
    of = shaft()
    phi, first, second = (of.angle(PHI, n) for n in range(3))
    assert MotionOverTime(LAW, of)(PHI, 2) == pytest.approx(LAW(phi, 2) * first**2 + LAW(phi, 1) * second)


def test_equation_4_of_the_paper_with_the_errata():
    """004 (4): with a_j, b_j in rad/s and omega = 2 pi/T, up to a constant."""
    of, t, a, b = shaft(), TAU / OMEGA, [0, 2.4, 1, 0.5, 0.3], [0, 1, -1.3, 0.2, 0.4]
    terms = [
        (x * np.sin(j * OMEGA * t) - y * np.cos(j * OMEGA * t)) / (j * OMEGA)
        for j, (x, y) in enumerate(zip(a, b, strict=True), 1)
    ]
    phi = OMEGA * t + sum(terms)
    assert np.ptp(of.angle(TAU) - phi) < 1e-12


def test_the_original_cam_gains_the_orders_up_to_n_plus_m_and_the_corrected_one_has_none():
    """Bild 2: orders 6 to 9 of a law of five; Bild 4: none."""
    of = shaft()
    original, corrected = (orders(MotionOverTime(law, of)) for law in (LAW, CorrectedLaw(LAW, of)))
    assert original.amplitudes[5:10].max() > 0.1 * original.amplitudes[0]
    assert share_above_order(corrected, 5) < 1e-13
    assert corrected.amplitudes[:5] == pytest.approx(orders(LAW).amplitudes[:5])


def test_orders_beyond_n_scale_with_the_fluctuation_and_those_beyond_twice_n_with_its_square():
    """The highest order is n + m to first order of the fluctuation alone (errata, 004)."""
    found = [orders(MotionOverTime(LAW, shaft(scale))).amplitudes for scale in (0.1, 0.05)]
    assert found[0][5:10].max() / found[1][5:10].max() == pytest.approx(2, rel=0.05)
    assert found[0][10:15].max() / found[1][10:15].max() == pytest.approx(4, rel=0.05)
