"""Writing and reading results. A file is written beside its place and moved there, so that it is never half there."""

from __future__ import annotations

import json
import math
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError

if TYPE_CHECKING:
    import xarray as xr


def prepare_folder(folder: Path) -> Path:
    """Create the output folder. Raises ``InputError`` if nothing can be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = folder / ".wucht-probe"
        probe.write_text("")
        probe.unlink()
    except OSError as error:
        raise InputError("-o", str(folder), f"nothing can be written there: {error.strerror}") from None
    return folder


def save(result: xr.Dataset, path: Path) -> Path:
    """Write a Dataset as NetCDF."""
    beside = path.with_name(f".{path.name}.part")
    result.to_netcdf(beside, engine="h5netcdf")
    beside.replace(path)
    return path


def load(path: Path) -> xr.Dataset:
    """Read a Dataset. Raises ``InputError`` if the file is none of ours."""
    import xarray as xr_

    if not path.is_file():
        raise InputError(str(path), None, "there is no such file")
    try:
        result = xr_.load_dataset(path, engine="h5netcdf")
    except (OSError, ValueError) as error:
        raise InputError(str(path), None, f"this is no NetCDF file that can be read: {error}") from None
    if "study" not in result.attrs:
        raise InputError(str(path), None, "this file was not written by wucht: it names no study")
    return result


def save_summary(document: Mapping[str, Any], path: Path) -> Path:
    """Write ``summary.json``."""
    beside = path.with_name(f".{path.name}.part")
    beside.write_text(to_json(document) + "\n", encoding="utf-8")
    beside.replace(path)
    return path


def to_json(document: Any, indent: int | None = 2) -> str:
    """JSON with SI floats; missing numbers (None, NaN, infinite) are null."""
    return json.dumps(_clean(document), indent=indent, ensure_ascii=False)


def _clean(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {str(k): _clean(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(v) for v in value]
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
