"""Writing results, each file beside its place and then moved there, so that it is never incomplete; their variables as CSV.

Variables over the same values (time, a parameter, both parameters of a map) are the columns of one file; variables of several
bodies or directions have a column for each that has values. Text and numbers without such values are in a separate file.
"""

from __future__ import annotations

import csv
import ctypes
import json
import math
import time
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any
from uuid import uuid4

import numpy as np

from wucht.errors import InputError, RunError
from wucht.file_names import replace_non_utf8, safe_name
from wucht.results.provenance import with_checksums

if TYPE_CHECKING:
    import xarray as xr

RESULT = "result.nc"  # in an output folder
_ABANDONED_S = 3600.0  # age of a temporary file after which its process must have been killed
_TEXT = "OSU"  # kinds of NumPy
_FORMULA = ("=", "+", "@", "-", "\t", "\r")  # first letters of a formula in a spreadsheet


def prepare_folder(folder: Path, names: Iterable[str] = ()) -> Path:
    """Create the output folder for files of these names. Raises ``InputError`` if they cannot be written there."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        probe = _temporary_path(folder / "probe")
        probe.write_text("")
        probe.unlink()
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


def _temporary_path(path: Path) -> Path:
    """A temporary path beside a file, unique among all processes and machines."""
    return path.with_name(f".{path.name}.{uuid4().hex}.part")


def replace_file(path: Path, write: Callable[[Path], object]) -> Path:
    """Write a file beside its place and move it there. Raises ``RunError`` if that is not possible."""
    temporary_file = _temporary_path(path)
    try:
        write(temporary_file)
        temporary_file.replace(path)
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
    return value


def save_csv(result: xr.Dataset, folder: Path) -> list[Path]:
    """Write a Dataset as CSV files ``STUDY-DIMENSIONS.csv`` beside its NetCDF.

    The first line has names and units, as in ``time [s],speed drum [rad/s]``; NaN is written as an empty cell, and text that a
    spreadsheet would take for a formula is preceded by a quotation mark. Returns the files. Raises ``RunError`` if they cannot
    be written.
    """
    tables: dict[tuple[str, ...], list[str]] = {}
    for name in [*result.data_vars, *(c for c in result.coords if not _is_scale(result, str(c)))]:
        tables.setdefault(_rows(result, tuple(map(str, result[name].dims))), []).append(str(name))
    paths = []
    for rows, names in sorted(tables.items(), key=lambda item: len(item[0]) == 0):
        path = folder / f"{safe_name('-'.join([str(result.attrs['study']), *(rows or ('numbers',))]))}.csv"
        lines = _table(result, rows, names) if rows else _numbers(result, names)
        paths.append(replace_file(path, lambda beside, lines=lines: _write(beside, lines)))  # type: ignore[misc]
    return paths


def _rows(result: xr.Dataset, dims: tuple[str, ...]) -> tuple[str, ...]:
    """The dimensions of a table's rows: not those of names, unless there are no others."""
    return tuple(d for d in dims if not _is_names(result, d)) or dims


def _is_names(result: xr.Dataset, dim: str) -> bool:
    return _is_scale(result, dim) and result[dim].dtype.kind in _TEXT


def _is_scale(result: xr.Dataset, name: str) -> bool:
    """True if the name is that of a coordinate of its dimension: other variables may have it too."""
    return name in result.coords and result[name].dims == (name,)


def _table(result: xr.Dataset, rows: tuple[str, ...], names: list[str]) -> list[list[Any]]:
    """Header and rows of the variables over the same dimensions."""
    shape = tuple(result.sizes[d] for d in rows)
    columns: dict[str, np.ndarray] = {}
    for dim, index in zip(rows, np.indices(shape), strict=True):
        if _is_scale(result, dim):
            columns[_header(result, dim)] = result[dim].values[index].ravel()
        elif len(rows) > 1:
            columns[f"{dim} index" if dim in result.variables else dim] = index.ravel()
    for name in names:
        variable = result[name].transpose(*rows, ...)
        label_values = [result[d].values for d in variable.dims[len(rows) :]]
        labels = [" ".join(map(str, label)) for label in _combinations(label_values)]
        values = variable.values.reshape(int(np.prod(shape)), len(labels))
        columns |= {
            _header(result, name, label): values[:, k] for k, label in enumerate(labels) if _has_values(values[:, k], label)
        }
    cell_columns = [_cell_texts(values) for values in columns.values()]
    return [list(columns), *map(list, zip(*cell_columns, strict=True))]


def _has_values(values: np.ndarray, label: str) -> bool:
    """True if a column has values: a body that turns about no other has no phase, and its column is left out."""
    return not label or values.dtype.kind != "f" or bool(np.isfinite(values).any())


def _combinations(names: list[np.ndarray]) -> list[tuple[Any, ...]]:
    """All combinations of names of several dimensions, the last one fastest."""
    combinations: list[tuple[Any, ...]] = [()]
    for one in names:
        combinations = [(*before, name) for before in combinations for name in one]
    return combinations


def _numbers(result: xr.Dataset, names: list[str]) -> list[list[Any]]:
    """Header and rows of variables without such dimensions."""
    rows = [[name, *_cell_texts(result[name].values[None]), result[name].attrs.get("units", "")] for name in names]
    return [["name", "value", "unit"], *rows]


def _header(result: xr.Dataset, name: str, label: str = "") -> str:
    unit = result[name].attrs.get("units", "")
    return " ".join([name, *([label] if label else []), *([f"[{unit}]"] if unit else [])])


def _cell_texts(values: np.ndarray) -> list[Any]:
    """Numbers with all their digits, NaN as an empty text."""
    if values.dtype.kind != "f":
        return [value.decode() if isinstance(value, bytes) else value for value in values.tolist()]
    return ["" if math.isnan(value) else repr(value) for value in values.tolist()]


def _write(path: Path, lines: list[list[Any]]) -> None:
    with path.open("w", newline="", encoding="utf-8") as file:
        csv.writer(file, lineterminator="\n").writerows([_escape_formula(cell) for cell in line] for line in lines)


def _escape_formula(cell: Any) -> Any:
    """Protect a cell from being read as a formula: text that begins like one gets a quotation mark before it."""
    if not isinstance(cell, str) or not cell.startswith(_FORMULA):
        return cell
    try:
        float(cell)
    except ValueError:
        return f"'{cell}"
    return cell
