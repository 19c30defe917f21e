"""Writing results. A file is written beside its place and moved there, so that it is never half there."""

from __future__ import annotations

import ctypes
import json
import math
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

from wucht.errors import InputError, RunError
from wucht.file_names import in_utf8
from wucht.results.integrity import sealed

if TYPE_CHECKING:
    import xarray as xr


RESULT = "result.nc"  # in an output folder
_ABANDONED_S = 3600.0  # a file that was not moved to its place for so long is one of a process that was killed


def prepare_folder(folder: Path, names: Iterable[str] = ()) -> Path:
    """Create the output folder for files of these names. Raises ``InputError`` if they cannot be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = _beside(folder / "probe")
        probe.write_text("")
        probe.unlink()
    except OSError as error:
        raise InputError("-o", str(folder), f"nothing can be written there: {error.strerror}") from None
    except ValueError as error:
        raise InputError("-o", str(folder), f"this cannot be the name of a folder: {error}") from None
    for name in names:
        if (folder / name).is_dir():
            raise InputError("-o", str(folder), f"a folder is in the place of the file {name}", code="folder")
        for left in folder.glob(f".{name}.*.part"):
            with suppress(OSError):
                if time.time() - left.stat().st_mtime > _ABANDONED_S:
                    left.unlink()
    return folder


def save(result: xr.Dataset, path: Path) -> Path:
    """Write a Dataset as NetCDF, with checksums of its variables.

    Put together in memory: HDF5 does not get over a file that cannot be written to its end, and takes the process with it.
    """
    return_free_memory()
    whole = sealed(result).to_netcdf(engine="h5netcdf")
    return replacing(path, lambda beside: beside.write_bytes(whole))


def return_free_memory() -> None:
    """Give what was freed back to the system: glibc keeps blocks of up to 32 MB, in pieces between which nothing large fits."""
    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


def _beside(path: Path) -> Path:
    """A name that no other process has, on whatever machine."""
    return path.with_name(f".{path.name}.{uuid4().hex}.part")


def replacing(path: Path, write: Callable[[Path], object]) -> Path:
    """Write a file beside its place and move it there. Raises ``RunError`` where that cannot be done."""
    beside = _beside(path)
    try:
        write(beside)
        beside.replace(path)
    except OSError as error:
        raise RunError(f"{path} cannot be written: {error.strerror or error}", code="not-written") from None
    finally:
        with suppress(OSError):
            beside.unlink(missing_ok=True)
    return path


def save_summary(document: Mapping[str, Any], path: Path) -> Path:
    """Write ``summary.json``."""
    return replacing(path, lambda beside: beside.write_text(to_json(document) + "\n", encoding="utf-8"))


def to_json(document: Any, indent: int | None = 2) -> str:
    """JSON with SI floats, to be written in UTF-8; missing numbers (None, NaN, infinite) are null."""
    return json.dumps(_clean(document), indent=indent, ensure_ascii=False)


def _clean(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {in_utf8(str(k)): _clean(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(v) for v in value]
    if isinstance(value, str):
        return in_utf8(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    return value
