"""Writing results, each file beside its place and then moved there, so that it is never incomplete."""

from __future__ import annotations

import ctypes
import errno
import json
import math
import tempfile
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np

from wucht.errors import InputError, RunError
from wucht.file_names import replace_non_utf8
from wucht.results.provenance import with_checksums

if TYPE_CHECKING:
    import xarray as xr

RESULT = "result.nc"  # in an output folder: always a complete one
_PARTIAL = ".partial"  # in the names of files of a result that is not complete, before their ending
_ABANDONED_S = 3600.0  # age of a temporary file after which its process must have been killed
_PATIENCE_S, _PAUSE_S = 5.0, 0.1  # while another program has a file open that is replaced


def partial_name(name: str) -> str:
    """The name that a file has while the result to which it belongs is not complete: ``result.partial.nc``."""
    path = Path(name)
    return path.with_suffix(f"{_PARTIAL}{path.suffix}").name


def file_name(name: str, result: xr.Dataset) -> str:
    """The name of a file of this result: another one than that of a complete result while it is not complete."""
    return name if result.attrs.get("finished", 1) else partial_name(name)


def prepare_folder(folder: Path, names: Iterable[str] = ()) -> Path:
    """Create the output folder for files of these names. Raises ``InputError`` if they cannot be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        tempfile.TemporaryFile(dir=folder).close()  # without a name on Linux: nothing is left of it where the process is killed
    except OSError as error:
        raise InputError("-o", str(folder), f"nothing can be written there: {error.strerror}") from None
    except ValueError as error:
        raise InputError("-o", str(folder), f"this cannot be the name of a folder: {error}") from None
    for name in names:
        if (folder / name).is_dir():
            raise InputError("-o", str(folder), f"a folder is in the place of the file {name}", code="folder")
        for leftover in folder.glob(f".{name}.*.part"):
            with suppress(OSError):
                if time.time() - leftover.stat().st_mtime > _ABANDONED_S:
                    leftover.unlink()
    return folder


def save(result: xr.Dataset, path: Path) -> Path:
    """Write a Dataset as NetCDF, with checksums of its variables.

    Composed in memory: HDF5 crashes the process if a file cannot be written to its end.
    """
    return_free_memory()
    whole = with_checksums(result).to_netcdf(engine="h5netcdf")
    return replace_file(path, lambda beside: beside.write_bytes(whole))


def return_free_memory() -> None:
    """Return freed memory to the system: glibc keeps blocks of up to 32 MB, too fragmented for large arrays."""
    with suppress(OSError, AttributeError):  # another C library
        ctypes.CDLL(None).malloc_trim(0)


def move(source: Path, target: Path) -> None:
    """Move a file or folder, with retries for some seconds if a program has it open, as on Windows and network drives."""
    end = time.monotonic() + _PATIENCE_S
    while True:
        try:
            source.replace(target)
        except OSError as error:
            if error.errno not in (errno.EACCES, errno.EBUSY, errno.EPERM) or time.monotonic() > end:
                raise
            time.sleep(_PAUSE_S)
        else:
            return


def replace_file(path: Path, write: Callable[[Path], object]) -> Path:
    """Write a file beside its place and move it there. Raises ``RunError`` if that is not possible."""
    temporary_file = path.with_name(f".{path.name}.{uuid4().hex}.part")  # unique among all processes and machines
    try:
        write(temporary_file)
        move(temporary_file, path)
    except OSError as error:
        raise RunError(f"{path} cannot be written: {error.strerror or error}", code="not-written") from None
    finally:
        with suppress(OSError):
            temporary_file.unlink(missing_ok=True)
    return path


def save_summary(document: Mapping[str, Any], path: Path) -> Path:
    """Write ``summary.json``."""
    return replace_file(path, lambda beside: beside.write_text(to_json(document) + "\n", encoding="utf-8"))


def to_json(document: Any, indent: int | None = 2) -> str:
    """Convert to JSON with SI floats, to be written in UTF-8; missing numbers (None, NaN, infinite) are null."""
    return json.dumps(_clean(document), indent=indent, ensure_ascii=False)


def _clean(value: Any) -> Any:
    if isinstance(value, Mapping):
        return {replace_non_utf8(str(k)): _clean(v) for k, v in value.items()}
    if isinstance(value, list | tuple):
        return [_clean(v) for v in value]
    if isinstance(value, str):
        return replace_non_utf8(value)
    if isinstance(value, float):
        return value if math.isfinite(value) else None
    if isinstance(value, np.generic | np.ndarray):
        return _clean(value.tolist())
    return value
