"""All the files of a cam for the workshop, each read back and compared with the cam: lists, a drawing, tables of the law."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass
from importlib.util import find_spec
from pathlib import Path

import numpy as np

from wucht.cams.cam import Cam
from wucht.cams.laws import Law
from wucht.cams.milled_cam import milled_motion
from wucht.cams.workshop.closed_curve import CamCurve, curve_distances
from wucht.cams.workshop.dxf import read_back, write_dxf
from wucht.cams.workshop.heading import Heading
from wucht.cams.workshop.lists import Separator, read_list, write_list
from wucht.cams.workshop.plc import (
    Form,
    Interpolation,
    SlaveUnit,
    cam_table,
    largest_deviation,
    read_cam_table,
    write_cam_table,
)
from wucht.cams.workshop.points import PointList, chord_points
from wucht.errors import RunError
from wucht.numerics.angles import valleys
from wucht.numerics.fourier_series import even_angles

_BETWEEN = 16  # parts of each chord at which a list is compared with its curve
_ANGLES = 720  # at which the motion that milled points make is compared with the law
_EXACT = 1e-6  # of an allowed deviation: arithmetic
_SUFFIX = {Form.CSV: ".csv", Form.TWINCAT: ".TcGVL.txt", Form.CODESYS: ".codesys.txt", Form.CODESYS_ASCII: ".ascii.txt"}
COLUMNS = ("phi", "x", "y", "nx", "ny")


@dataclass(frozen=True)
class WorkshopFile:
    """A file that was written and read again.

    content: of the file. count: of points or rows; of a drawing of all lines. deviation: the largest one of the values read
    from their reference: chords and splines from their curve in m, an interpolated table from its law in m or rad (``unit``).
    allowed_deviation: its limit. motion: of a contour's list, the deviation from its law of a follower on a smooth spline
    through the points read, in the unit of the law; large where uneven points make the spline oscillate. None of others.
    """

    path: Path
    content: str
    count: int
    deviation: float
    allowed_deviation: float
    unit: str = "m"
    motion: float | None = None


def write_cam_files(
    folder: Path,
    name: str,
    cam: Cam,
    points: PointList,
    tolerance: float,
    decimals: int,
    *,
    spacing: float = math.inf,
    separator: Separator = Separator.BLANK,
    drawing: bool | None = None,
    heading: Heading | None = None,
) -> list[WorkshopFile]:
    """Write NAME.txt with the contour's points, NAME-pitch.txt with those of the roller's centre, and NAME.dxf.

    points: of the contour, which keep the chord tolerance in m; those of the roller's centre keep it too, none farther
    apart than spacing in m. decimals: of their coordinates in mm. drawing: True for a DXF file; None: where the extra [cad] is
    installed. heading: of the cam, for each file. Raises ``RunError`` where a file cannot be written, or deviates from its
    content, and ``InputError`` as its parts do.
    """
    cam_name = name if heading is None or not heading.cam_version else f"{heading.cam_version} {name}"

    def write_points(file: str, content: str, curve: CamCurve, at: PointList, cam: Cam | None) -> WorkshopFile:
        return _write_point_list(folder / file, content, curve, at, tolerance, decimals, separator, cam, heading)

    files = [write_points(f"{name}.txt", f"contour of the {cam_name}", cam.contour, points, cam)]
    # Of an edge, a roller of the radius 0, the pitch curve is the contour.
    pitch = None if cam.outer or not cam.roller_radius else cam.pitch_curve
    if pitch is not None and cam.roller_radius is not None:
        pitch_points = chord_points(pitch, tolerance, spacing)
        content = f"pitch curve of the {cam_name}, roller radius {1e3 * cam.roller_radius:.12g} mm"
        files.append(write_points(f"{name}-pitch.txt", content, pitch, pitch_points, None))
    if drawing or (drawing is None and find_spec("ezdxf") is not None):
        roller = cam.roller_radius if pitch is not None else None
        base = float(valleys(lambda phi: np.abs(cam.contour(phi)))[1].min())
        path = folder / f"{name}.dxf"
        write_dxf(path, cam.contour, tolerance, pitch, base, roller, heading)
        counts, deviations = zip(*read_back(path, cam.contour, pitch).values(), strict=True)
        content = f"drawing of the {cam_name}"
        files.append(_checked_file(WorkshopFile(path, content, sum(counts), max(deviations), tolerance)))
    return files


def _write_point_list(
    path: Path,
    content: str,
    curve: CamCurve,
    points: PointList,
    tolerance: float,
    decimals: int,
    separator: Separator,
    cam: Cam | None,
    heading: Heading | None = None,
) -> WorkshopFile:
    write_list(path, points, content, COLUMNS, separator, decimals, tolerance, heading)
    reading = read_list(path)
    shares = np.arange(_BETWEEN) / _BETWEEN
    chords = reading.position[:, None] + (np.roll(reading.position, -1) - reading.position)[:, None] * shares
    deviation = float(curve_distances(curve, chords.ravel()).max())
    rounding = 1e-3 * 10.0**-decimals / math.sqrt(2)
    motion = None if cam is None else _motion_deviation(cam, reading.position)
    return _checked_file(WorkshopFile(path, content, len(reading.position), deviation, tolerance + rounding, motion=motion))


def _motion_deviation(cam: Cam, position: np.ndarray) -> float:
    """Return the deviation of a follower on a spline through the points from the law; infinite where it loses contact."""
    phi = even_angles(_ANGLES)
    law_values = cam.law(phi)
    try:
        motion = milled_motion(position, cam.follower, phi, law_values, cam.clockwise)
    except RunError:
        return math.inf
    return float(np.abs(motion - law_values).max())


def write_law_files(
    folder: Path,
    law: Law,
    unit: str,
    tolerance: float,
    *,
    name: str = "Cam",
    forms: Iterable[Form] = (Form.CSV, Form.TWINCAT, Form.CODESYS),
    decimals: int = 6,
    heading: Heading | None = None,
) -> list[WorkshopFile]:
    """Write the law as cam tables of controllers, for an electronic cam that makes the same motion.

    unit: of the law, rad or m; tolerance: in it. decimals: of the slave in deg or mm. heading: of the cam. Raises as
    ``write_cam_files``.
    """
    slave, files = SlaveUnit.DEGREE if unit == "rad" else SlaveUnit.MILLIMETRE, list[WorkshopFile]()
    for form in forms:
        between = Interpolation.LINEAR if form is Form.CODESYS_ASCII else Interpolation.QUINTIC
        path = folder / f"law{_SUFFIX[form]}"
        write_cam_table(path, cam_table(law, slave, tolerance, between, decimals), form, name, heading)
        reading = read_cam_table(path, form, slave)
        cam_name = f" of the {heading.cam_version} cam" if heading is not None and heading.cam_version else ""
        content = f"cam table{cam_name} ({form.value}, {between.name.lower()} interpolation)"
        files.append(
            _checked_file(WorkshopFile(path, content, len(reading.phi), largest_deviation(reading, law), tolerance, unit))
        )
    return files


def _checked_file(file: WorkshopFile) -> WorkshopFile:
    if file.deviation > file.allowed_deviation * (1 + _EXACT) + 1e-15:
        message = (
            f"it deviates by {file.deviation:.4g} {file.unit} from its reference; at most "
            f"{file.allowed_deviation:.4g} {file.unit} is allowed"
        )
        raise RunError(f"{file.path} was written, but read back {message}", code="deviates")
    return file
