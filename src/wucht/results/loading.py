"""Reading results: from a file, or from the output folder that has it."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from wucht.errors import InputError
from wucht.results.accessor import register
from wucht.results.integrity import unsealed
from wucht.results.output_folder import latest
from wucht.results.store import RESULT

if TYPE_CHECKING:
    import xarray as xr


def result_file(path: Path) -> Path:
    """The file of a result: the path itself, or that in an output folder."""
    return path / RESULT if path.is_dir() else path


def load(path: Path) -> xr.Dataset:
    """Read a result. What a run that was killed had begun to put into its folder is put there first.

    Raises ``InputError`` if there is no such file, it is none of ours, or it was changed since it was written.
    """
    import h5py
    import xarray as xr_

    register()
    path = result_file(path)
    file = latest(path)
    if not file.is_file():
        raise InputError.of_file(path, "this is no file" if path.exists() else "there is no such file")
    try:
        with h5py.File(file) as opened:  # where this fails, h5netcdf leaves a file half open, and says so on stderr
            opened.attrs.get("_nc3_strict")
        result = xr_.load_dataset(file, engine="h5netcdf")
    except Exception as error:
        # The readers beneath raise whatever a damaged file makes them stumble over; to the user it is one thing.
        lines = str(error).splitlines() or [type(error).__name__]
        raise InputError.of_file(path, f"this is no NetCDF file that can be read: {lines[0]}") from None
    if "study" not in result.attrs:
        raise InputError.of_file(path, "this file was not written by wucht: it names no study")
    try:
        return unsealed(result)
    except InputError as error:
        raise error.in_file(path) from None
