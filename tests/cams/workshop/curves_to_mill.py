"""Curves whose points, normals and lengths are known, and a motion law, for the tests of the workshop."""

import math

import numpy as np

from wucht.numerics.fourier_series import FourierSeries

RADIUS = 0.05
LAW = FourierSeries.of(0.1, [0.05, 0.02], [0.03, 0.0, 0.01])  # rad, or m


def ellipse(a=RADIUS, b=RADIUS, centre=0.0):
    """x = a cos phi, y = b sin phi about a centre: clockwise where b < 0."""

    def curve(phi, order=0):
        turned = np.asarray(phi, float) + order * math.pi / 2
        return a * np.cos(turned) + 1j * b * np.sin(turned) + (centre if order == 0 else 0.0)

    return curve


def lobes(phi, order=0):
    """r = 50 + 5 cos 3 phi mm, counter-clockwise: flat in the middle between the lobes."""
    return sum(
        c * (1j * k) ** order * np.exp(1j * k * np.asarray(phi, float)) for k, c in ((1, 0.05), (4, 0.0025), (-2, 0.0025))
    )


def hollow(phi, order=0):
    """r = 50 + 12 cos 3 phi mm: hollow between the lobes."""
    return sum(c * (1j * k) ** order * np.exp(1j * k * np.asarray(phi, float)) for k, c in ((1, 0.05), (4, 0.006), (-2, 0.006)))


CURVES = {
    "circle": ellipse(),
    "eccentric circle": ellipse(centre=0.01 + 0.02j),
    "clockwise circle": ellipse(b=-RADIUS),
    "ellipse": ellipse(0.08, 0.02),
    "lobes": lobes,
    "hollow": hollow,
}


def broken(phi, order=0):
    """A circle that is missing a quarter."""
    return np.where(np.mod(phi, 2 * math.pi) > 1.5 * math.pi, np.nan, ellipse()(phi, order))


def cusped(phi, order=0):
    """A cardioid: its derivative vanishes at phi = pi."""
    return 0.05 * (
        (1j) ** order * np.exp(1j * np.asarray(phi, float)) + (2j) ** order * np.exp(2j * np.asarray(phi, float)) / 2
    )
