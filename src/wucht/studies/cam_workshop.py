"""Files for the workshop of a result of ``cam-contour`` or ``cam-correction``, and the cam drive and the cam that it has."""

from __future__ import annotations

import math
from collections.abc import Iterable, Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
from pydantic import BaseModel

from wucht.cams.cam import Cam
from wucht.cams.drive import CamDrive, cam_drive_from, laws
from wucht.cams.drive_cams import DriveCams
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.workshop.cam_files import WorkshopFile, write_cam_files, write_law_files
from wucht.cams.workshop.heading import Heading
from wucht.cams.workshop.points import PointList, chord_points
from wucht.environment import date_of_files
from wucht.errors import InputError
from wucht.numerics.fourier_series import FourierSeries
from wucht.results.provenance import versions
from wucht.results.store import prepare_folder
from wucht.schema import models_in

if TYPE_CHECKING:
    import xarray as xr

_CONTOUR_TOLERANCE = 1e-9  # of the cam's size: distance that points of a result may have from the contour computed anew
_STROKE_TOLERANCE = 1e-5  # of the stroke: the tolerance of cam tables
_STROKE_SAMPLES = 4097
_TABLES = ("law", "follower", "linkage")


def mill_points(cams: Mapping[str, Cam], tolerance: float, spacing: float) -> dict[str, PointList]:
    """Return the points to mill of each cam, with the longest chord that is permitted.

    Raises ``InputError`` (study.chord_tolerance, study.spacing).
    """
    try:
        return {name: chord_points(cam.contour, tolerance, spacing) for name, cam in cams.items()}
    except InputError as error:
        key = "chord_tolerance" if error.location == "tolerance" else error.location
        raise InputError(f"study.{key}", error.value, error.explanation) from None


def check_points(cam: Cam, phi: np.ndarray, position: np.ndarray) -> None:
    """Raise ``InputError`` where points (N,) of a result, complex in m, do not lie on the contour of their cam."""
    if np.abs(cam.contour(phi) - position).max() > _CONTOUR_TOLERANCE * np.abs(position).max():
        reason = "its points do not lie on the contour of its drive: run the study again"
        raise InputError("result", None, reason, code="deviates")


def write_files(
    cams: DriveCams, points: Mapping[str, PointList], folder: Path, tolerance: float, spacing: float, decimals: int
) -> list[WorkshopFile]:
    """Write the files of each cam at its points, and the cam tables of the law; read all of them back.

    tolerance: of the chords of lists and drawings, and spacing: the longest chord, in m. decimals: of coordinates in mm. The
    tables keep 1e-5 of the stroke. Raises ``InputError`` (SOURCE_DATE_EPOCH), and ``RunError`` where a file cannot be written
    or does not read back as written.
    """
    stroke = float(np.ptp(cams.law(np.linspace(0, 2 * math.pi, _STROKE_SAMPLES))))
    heading = Heading(
        cams.drive.title, _law_in_words(cams.drive, stroke), cams.shaft, cams.is_corrected, date_of_files(), versions()["wucht"]
    )
    folder, files = prepare_folder(folder), list[WorkshopFile]()
    for name, cam in cams.cams.items():
        files += write_cam_files(folder, name, cam, points[name], tolerance, decimals, spacing=spacing, heading=heading)
    table_tolerance = _STROKE_TOLERANCE * stroke
    return files + write_law_files(folder, cams.law, cams.drive.motion_law.unit, table_tolerance, heading=heading)


def _law_in_words(drive: CamDrive, stroke: float) -> str:
    count, unit = drive.motion_law.count, drive.motion_law.unit
    harmonics = "" if count is None else f", {count} harmonics"
    travel = f"{math.degrees(stroke):.6g} deg" if unit == "rad" else f"{1e3 * stroke:.6g} mm"
    return f"{drive.law.kind}{harmonics}, {travel} from the least to the greatest position"


def stated_shaft_motion(summary: Mapping[str, Any]) -> ShaftMotion | None:
    """Return the motion of the shaft that the summary of a contour has, None where no table states it."""
    speed = summary["corrected"] or summary.get("speed")  # results of earlier versions lack the latter
    return None if speed is None else ShaftMotion(FourierSeries.of(**speed))


def drive_of(result: xr.Dataset) -> CamDrive:
    """Return the cam drive of a result, without its shaft and its speed. Raises ``InputError``."""
    facts: Mapping[str, Any] = result.wucht.machine
    tables = {name: dict(facts[name]) for name in _TABLES if name in facts}
    tables["law"] = _with_file_keys(laws()[tables["law"]["kind"]], tables["law"])
    return cam_drive_from(tables, str(facts["title"]), Path())


def _with_file_keys(cls: type[BaseModel], table: Mapping[str, Any]) -> dict[str, Any]:
    """Return a table with the keys that a file uses, and so the tables inside."""
    entries = dict[str, Any]()
    for name, value in table.items():
        field = cls.model_fields.get(name)
        inner = models_in(field.annotation) if field is not None else []
        of_file = [_with_file_keys(inner[0], one) for one in value] if inner and isinstance(value, list) else value
        entries[field.alias or name if field is not None else name] = of_file
    return entries


def file_lines(files: Iterable[WorkshopFile]) -> list[str]:
    """Return a line for each file: its name, its content, and the deviation of what was read back."""
    return [_line(file) for file in files]


def _line(file: WorkshopFile) -> str:
    line = f"{file.path}  {file.content}, {file.count}: read back within {_deviation_text(file.deviation, file.unit)}"
    return line if file.motion is None else f"{line}; a follower on it deviates from its law by {file.motion:.1e}"


def _deviation_text(deviation: float, unit: str) -> str:
    return f"{1e6 * deviation:.2g} µm" if unit == "m" else f"{math.degrees(deviation):.1e}°"
