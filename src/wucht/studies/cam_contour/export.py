"""Result -> workshop files of a contour."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from wucht.cams.drive_cams import DriveCams
from wucht.cams.workshop.cam_files import WorkshopFile
from wucht.cams.workshop.points import PointList
from wucht.errors import InputError
from wucht.studies.cam_workshop import check_points, drive_of, stated_shaft_motion, write_files

if TYPE_CHECKING:
    import xarray as xr


def write_workshop(result: xr.Dataset, folder: Path) -> list[WorkshopFile]:
    """Write the points to mill of each cam, drawings, and the cam tables of the output's law; read all of them back.

    The cam is the original or the corrected one, as ``study.corrected`` says. Lists and drawings keep the chord tolerance and
    the decimals of the study.

    Returns the files, each with the deviation of its content when read back. Raises ``InputError`` where the result has
    no points to mill, ``RunError`` where a file cannot be written or does not read back as written.
    """
    summary = result.wucht.summary
    if summary["undercut"] or not result.sizes["mill_point"]:
        raise InputError("result", None, "it has no points to mill: part of the contour is cut away", code="no-points")
    cams = DriveCams.of(drive_of(result), stated_shaft_motion(summary), summary["corrected"] is not None)
    points = {name: points_to_mill(result, name) for name in cams.cams}
    for name, cam in cams.cams.items():
        check_points(cam, points[name].phi, points[name].position)
    return write_files(cams, points, folder, summary["chord_tolerance"], summary["spacing"], summary["decimals"])


def points_to_mill(result: xr.Dataset, cam: str) -> PointList:
    """Return the points to mill of one cam of a result. Raises ``InputError``."""
    names = [str(name) for name in result.cam.values]
    if cam not in names:
        raise InputError("cam", cam, f"the result has no such cam; known: {', '.join(names)}")
    points = result.isel(mill_point=np.flatnonzero(result.mill_cam.values == names.index(cam)))
    normal = points.mill_normal_x.values + 1j * points.mill_normal_y.values
    return PointList(points.mill_angle.values, points.mill_x.values + 1j * points.mill_y.values, normal)
