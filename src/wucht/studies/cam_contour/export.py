"""The files of a contour for the workshop, a line for each."""

from __future__ import annotations

import math
from pathlib import Path
from typing import TYPE_CHECKING

from wucht.cams.workshop.cam_files import WorkshopFile
from wucht.studies.cam_contour.write_workshop import write_workshop

if TYPE_CHECKING:
    import xarray as xr


def export(result: xr.Dataset, folder: Path) -> list[str]:
    """Write points to mill, drawings and cam tables; see ``write_workshop``."""
    return [_line(file) for file in write_workshop(result, folder)]


def _line(file: WorkshopFile) -> str:
    line = f"{file.path}  {file.what}, {file.count}: read back within {_shown(file.deviation, file.unit)}"
    return line if file.motion is None else f"{line}; a follower on it leaves its law by {file.motion:.1e}"


def _shown(deviation: float, unit: str) -> str:
    return f"{1e6 * deviation:.2g} um" if unit == "m" else f"{math.degrees(deviation):.1e}°"
