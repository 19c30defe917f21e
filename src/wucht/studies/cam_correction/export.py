"""Result -> workshop files of the corrected cam."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wucht.cams.drive_cams import DriveCams
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.cam_files import WorkshopFile
from wucht.cams.workshop.heading import CAM_VERSIONS
from wucht.cams.workshop.points import SPACING
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.cam_workshop import check_points, drive_of, mill_points, write_files

if TYPE_CHECKING:
    import xarray as xr


def write_corrected_cam(result: xr.Dataset, folder: Path) -> list[WorkshopFile]:
    """Write the points to mill of the corrected cam, drawings and cam tables, with the study's chord tolerance and decimals.

    Without a follower there are cam tables alone. Raises ``InputError`` (study.chord_tolerance), and ``RunError`` where a file
    cannot be written or does not read back as written.
    """
    speed = FourierSeries.of(result.wucht.summary["mean_speed"], result.speed_cosine.values, result.speed_sine.values)
    cams, study = DriveCams.of(drive_of(result), ShaftMotion(speed), True), result.wucht.question["study"]
    for name, cam in cams.cams.items():
        contour = result.sel(version=CAM_VERSIONS[True], cam=name)
        check_points(cam, result.cam_angle.values, contour.contour_x.values + 1j * contour.contour_y.values)
    tolerance = study["chord_tolerance"]
    points = mill_points(cams.cams, tolerance, SPACING)
    return write_files(cams, points, folder, tolerance, SPACING, study["decimals"])
