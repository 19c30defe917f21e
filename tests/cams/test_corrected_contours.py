"""Contours beside the original ones: how far they moved, rounded points, and the flanks of a groove."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from wucht.cams.corrected_contours import CheckedContour, round_points, signed_distance
from wucht.cams.drive import cam_drive_from
from wucht.studies.cam_answers import CURVES

pytestmark = pytest.mark.usefixtures("coarse_angles")
ANGLES = 2 * math.pi * np.arange(36) / 36


def test_a_displacement_is_positive_outside() -> None:
    circle = lambda phi, order=0: np.exp(1j * np.asarray(phi)) * (1j) ** order  # noqa: E731
    normals = np.exp(1j * ANGLES)
    for by in (0.02, -0.03):
        assert signed_distance(circle, (1 + by) * normals, normals) == pytest.approx(np.full(36, by), abs=1e-9)


@pytest.mark.parametrize(
    ("decimals", "rounded"), [(5, 0.01234568 - 0.09876543j), (3, 0.012346 - 0.098765j), (0, 0.012 - 0.099j)]
)
def test_points_are_rounded_to_decimals_of_a_millimetre(decimals: int, rounded: complex) -> None:
    """Of 0.0123456789 m, 12.3456789 mm, in either coordinate."""
    exact = np.array([0.0123456789 - 0.0987654321j, 0.0])
    assert round_points(exact, decimals) == pytest.approx(np.array([rounded, 0.0]), abs=1e-14)


def test_the_contour_of_a_groove_is_hollow_outside_and_bulges_inside() -> None:
    """Of a cam that hardly moves its rod: circles, a roller's radius inside and outside of the distance."""
    law = {"kind": "harmonic", "coefficients": {"cosine": ["1 um"]}}
    rod = {"kind": "translating-roller", "distance": "60 mm", "roller_radius": "12 mm", "groove": True}
    drive = cam_drive_from({"law": law, "follower": rod}, "Groove", Path())
    cams = drive.make_cams(drive.motion_law.function)
    for name, radius, material in (("cam", 0.048, 1), ("outer", 0.072, -1)):
        cam = cams[name]
        flank = CheckedContour.of(name, cam, cam, ANGLES)
        assert np.abs(cam.contour(ANGLES)) == pytest.approx(np.full(36, radius), rel=1e-4)
        assert CURVES["curvature"][2](cam, ANGLES) == pytest.approx(np.full(36, material / radius), rel=1e-2)
        outwards = (cam.normal(ANGLES).conj() * cam.contour(ANGLES)).real
        assert outwards == pytest.approx(np.full(36, radius), rel=1e-3)
        assert flank.chord == pytest.approx(radius * (1 - math.cos(math.pi / 36)), rel=1e-3)
        assert (flank.displacement == 0).all()
