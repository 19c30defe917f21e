"""Result -> workshop files of the corrected cam, and a line for each."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.cam_files import WorkshopCurve
from wucht.cams.workshop.heading import CAM_VERSIONS
from wucht.cams.workshop.points import SPACING, chord_points
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries
from wucht.studies.cam_workshop import CamOfResult, FileOptions, drive_of, file_lines

if TYPE_CHECKING:
    import xarray as xr


def export(result: xr.Dataset, folder: Path) -> list[str]:
    """Write the points to mill of the corrected cam, drawings and cam tables, with the study's chord tolerance and decimals.

    Without a follower there are cam tables alone. Raises ``InputError`` (study.chord_tolerance), and ``RunError`` where a file
    cannot be written or does not read back as written.
    """
    speed = FourierSeries.of(result.wucht.summary["mean_speed"], result.speed_cosine.values, result.speed_sine.values)
    cam_of_result, study = CamOfResult(drive_of(result), ShaftMotion(speed), True), result.wucht.question["study"]
    for name in cam_of_result.cams:
        contour = result.sel(version=CAM_VERSIONS[True], cam=name)
        cam_of_result.check_points(name, result.cam_angle.values, contour.contour_x.values + 1j * contour.contour_y.values)
    options = FileOptions(study["chord_tolerance"], SPACING, study["decimals"])
    try:
        points = {
            name: chord_points(WorkshopCurve(cam.contour), options.tolerance, options.spacing)
            for name, cam in cam_of_result.cams.items()
        }
    except InputError as error:
        if error.location != "tolerance":
            raise
        raise InputError("study.chord_tolerance", error.value, error.explanation) from None
    return file_lines(cam_of_result.write(points, folder, options))
