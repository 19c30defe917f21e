"""Result -> workshop files of a contour, and a line for each."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.cams.correction import CorrectedLaw
from wucht.cams.drive import CamDrive, drive_from, laws
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.cam_files import WorkshopFile, write_cam_files, write_law_files
from wucht.cams.workshop.lists import Separator
from wucht.cams.workshop.plc import Form
from wucht.cams.workshop.points import PointList
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries
from wucht.results.store import prepare_folder

if TYPE_CHECKING:
    import xarray as xr

_CONTOUR_TOLERANCE = 1e-9  # of the cam's size: distance that points of a result may have from the contour computed anew
_STROKE_TOLERANCE = 1e-5  # the tolerance of cam tables
_TABLES = ("law", "follower", "linkage")


def export(result: xr.Dataset, folder: Path) -> list[str]:
    """Write points to mill, drawings and cam tables; see ``write_workshop``."""
    return [_line(file) for file in write_workshop(result, folder)]


def _line(file: WorkshopFile) -> str:
    line = f"{file.path}  {file.content}, {file.count}: read back within {_deviation_text(file.deviation, file.unit)}"
    return line if file.motion is None else f"{line}; a follower on it deviates from its law by {file.motion:.1e}"


def _deviation_text(deviation: float, unit: str) -> str:
    return f"{1e6 * deviation:.2g} um" if unit == "m" else f"{math.degrees(deviation):.1e}°"


def write_workshop(
    result: xr.Dataset,
    folder: Path,
    *,
    forms: Iterable[Form] = (Form.CSV, Form.TWINCAT, Form.CODESYS),
    separator: Separator = Separator.BLANK,
    drawing: bool | None = None,
    table_tolerance: float | None = None,
    table_decimals: int = 6,
) -> list[WorkshopFile]:
    """Write the points to mill of each cam, drawings, and the cam tables of the output's law; read all of them back.

    forms: of the cam tables. separator: in the lists. drawing: whether there are DXF files, None where the extra [cad] is
    installed. table_tolerance: of the cam tables, in rad or m, 1e-5 of the stroke where it is not given; table_decimals: of
    their positions in deg or mm. Lists and drawings keep the chord tolerance and the decimals of the study.

    Returns the files, each with the deviation of its content when read back. Raises ``InputError`` where the result has
    no points to mill, ``RunError`` where a file cannot be written or does not read back as written.
    """
    summary = result.wucht.summary
    if summary["undercut"] or not result.sizes["mill_point"]:
        raise InputError("result", None, "it has no points to mill: part of the contour is cut away", code="no-points")
    drive = drive_of(result)
    law: Law = drive.motion_law.law
    if summary["corrected"] is not None:
        law = CorrectedLaw(law, ShaftMotion(FourierSeries.of(**summary["corrected"])))
    folder = prepare_folder(folder)
    files: list[WorkshopFile] = []
    for name, cam in drive.cams(law).items():
        points = points_to_mill(result, name)
        if np.abs(cam.contour(points.phi) - points.position).max() > _CONTOUR_TOLERANCE * np.abs(points.position).max():
            reason = "its points do not lie on the contour of its drive: run the study again"
            raise InputError("result", None, reason, code="deviates")
        files += write_cam_files(
            folder, name, cam, points, summary["chord_tolerance"], summary["decimals"],
            spacing=summary["spacing"], separator=separator, drawing=drawing,
        )  # fmt: skip
    stroke = float(np.ptp(law(np.linspace(0, 2 * np.pi, 4097))))
    tolerance = _STROKE_TOLERANCE * stroke if table_tolerance is None else table_tolerance
    return files + write_law_files(folder, law, drive.motion_law.unit, tolerance, forms=forms, decimals=table_decimals)


def points_to_mill(result: xr.Dataset, cam: str) -> PointList:
    """Return the points to mill of one cam of a result. Raises ``InputError``."""
    names = [str(name) for name in result.cam.values]
    if cam not in names:
        raise InputError("cam", cam, f"the result has no such cam; known: {', '.join(names)}")
    points = result.isel(mill_point=np.flatnonzero(result.mill_cam.values == names.index(cam)))
    normal = points.mill_normal_x.values + 1j * points.mill_normal_y.values
    return PointList(points.mill_angle.values, points.mill_x.values + 1j * points.mill_y.values, normal)


def drive_of(result: xr.Dataset) -> CamDrive:
    """Return the cam drive of a result, without its shaft and its speed. Raises ``InputError``."""
    facts: Mapping[str, Any] = result.wucht.machine
    tables = {name: dict(facts[name]) for name in _TABLES if name in facts}
    tables["law"] = _law_table(tables["law"])
    return drive_from(tables, str(facts["title"]), Path())


def _law_table(law: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table [law] with the keys that a file uses."""
    fields = laws()[law["kind"]].model_fields
    return {(fields[key].alias or key) if key in fields else key: value for key, value in law.items()}
