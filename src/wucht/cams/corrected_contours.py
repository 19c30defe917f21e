"""Contours of cams beside the original ones, and the motion that their points make, computed independently of the law."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.drive_cams import DriveCams
from wucht.cams.milled_cam import milled_motion
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.shape import Shape, shapes
from wucht.cams.workshop.closed_curve import CamCurve, curve_distances
from wucht.cams.workshop.points import chord_deviation
from wucht.errors import WuchtError
from wucht.numerics.fourier_series import FourierSeries, even_angles

_RECOVERY_TIMES = 1024  # times at which the follower on the milled points is computed
_SEARCH_OFFSET = 2e-3  # of the stroke: the search begins beside the expected position


@dataclass(frozen=True, eq=False)
class CheckedContour:
    """Contour of a cam at cam angles (N,). displacement: distance in m of its points outside the original contour.

    chord: largest distance in m between chords and contour. shape: its sizes.
    """

    displacement: np.ndarray
    chord: float
    shape: Shape

    @classmethod
    def of(cls, name: str, cam: Cam, original: Cam, angles: np.ndarray) -> CheckedContour:
        """Return the contour. Raises ``InputError`` where a corrected cam is cut away; the original one may be."""
        is_original = cam is original
        shape = shapes({name: cam}, allow_undercut=is_original)[name]
        distance = np.zeros(len(angles))
        if not is_original:
            distance = signed_distance(original.contour, cam.contour(angles), cam.normal(angles))
        return cls(distance, chord_deviation(cam.contour, angles), shape)


def signed_distance(curve: CamCurve, points: np.ndarray, normals: np.ndarray) -> np.ndarray:
    """Return the distance in m of points (N,) from a curve, positive outside."""
    far = curve_distances(curve, points)
    return np.where(curve_distances(curve, points - far * normals) <= far, far, -far)


def round_points(points: np.ndarray, decimals: int) -> np.ndarray:
    """Return points (N,) in m, complex, with their coordinates rounded to decimals of a mm."""
    step = 1e-3 * 10.0**-decimals
    return np.asarray(step * (np.round(points.real / step) + 1j * np.round(points.imag / step)))


@dataclass(frozen=True, eq=False)
class Proof:
    """Acceleration over omega^2 from the points of a cam, and from these rounded; None where it fails, with notes."""

    recovered: FourierSeries | None
    rounded: FourierSeries | None
    notes: tuple[str, ...]

    @classmethod
    def of(cls, cams: DriveCams, shaft: ShaftMotion, name: str, points: np.ndarray, decimals: int, count: int) -> Proof:
        """Recover the motion of the output from points (N,) of a cam, up to this number of orders."""
        spectra, notes = list[FourierSeries | None](), list[str]()
        for positions in (points, round_points(points, decimals)):
            try:
                spectra.append(_recovered_acceleration(cams, shaft, cams.cams[name], positions, count))
            except WuchtError as error:
                spectra.append(None)
                notes.append(
                    f"No motion could be recovered from {len(points)} points of the contour ({name}): {error}; take more."
                )
        return cls(spectra[0], spectra[1], tuple(notes))


def _recovered_acceleration(cams: DriveCams, shaft: ShaftMotion, cam: Cam, points: np.ndarray, count: int) -> FourierSeries:
    """Recover psi(t) from points by contact with the follower and the linkage: a computation independent of the law."""
    phi, closure = shaft.angle(even_angles(_RECOVERY_TIMES)), cams.drive.closure
    expected_motion = cams.follower_law(phi)
    first_guess = expected_motion + _SEARCH_OFFSET * float(np.ptp(expected_motion)) * np.cos(phi)
    lever_motion = milled_motion(points, cam.follower, phi, first_guess, cam.clockwise)
    output = lever_motion if closure is None else closure.output_at(lever_motion)
    # Twice differentiated, the rounding of orders far above the examined ones would dominate.
    acceleration = FourierSeries.from_samples(output).derivative(2)
    return FourierSeries(0.0, acceleration.cosine[:count], acceleration.sine[:count])
