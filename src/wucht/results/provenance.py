"""Origin of a result (whole input, versions, wall time) and its integrity (checksums, attributes)."""

from __future__ import annotations

import json
import platform
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from importlib.metadata import PackageNotFoundError, version
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.environment import date_of_files
from wucht.errors import InputError
from wucht.results.attributes import read_attributes, table_in

if TYPE_CHECKING:
    import xarray as xr

CHECKSUMS = "checksums"  # attribute of a result.nc
_ATTRIBUTES = "its attributes"  # no variable can have this name: it has a blank
_NO_CHECKSUMS = "unsealed"  # in the encoding of a Dataset: its file had no checksums
_CHANGE_MESSAGE = "changed or damaged since it was written"
_PACKAGES = ("wucht", "numpy", "scipy", "sympy", "llvmlite", "xarray")


def with_checksums(result: xr.Dataset) -> xr.Dataset:
    """Add checksums of the variables and attributes to a result, as it is written to a file."""
    bare = _without_checksums(result)
    return bare.assign_attrs({CHECKSUMS: json.dumps(_checksums(bare))})


def verify_checksums(result: xr.Dataset) -> xr.Dataset:
    """Check the checksums of a result that was read from a file, and remove them, so that a changed result can be saved.

    Raises ``InputError`` with the name of the variable whose values, units or dimensions differ from the written ones, or of
    the attribute that cannot be read. A file without checksums is accepted.
    """
    bare = _without_checksums(result)
    if CHECKSUMS in result.attrs:
        recorded_sums = table_in(result, CHECKSUMS)
        checksums = _checksums(bare)
        for name in (*checksums, *recorded_sums):
            if checksums.get(name) != recorded_sums.get(name):
                raise InputError(name, None, _CHANGE_MESSAGE)
    read_attributes(bare.attrs, in_file=True)
    bare.encoding[_NO_CHECKSUMS] = CHECKSUMS not in result.attrs
    return bare


@contextmanager
def refuse_edited_values(result: xr.Dataset) -> Iterator[None]:
    """Turn errors about inconsistent values into ``InputError`` while the block lasts, if the result was read from a file
    without checksums: it may have been edited. In a file as wucht wrote it, they are errors of wucht."""
    try:
        yield
    except (ArithmeticError, AttributeError, LookupError, RuntimeError, TypeError, ValueError) as error:
        if not result.encoding.get(_NO_CHECKSUMS):
            raise
        problem = f"its values do not fit together ({type(error).__name__}: {str(error).partition(chr(10))[0]})"
        raise InputError(result.attrs["study"], None, f"this is not a complete result of this study: {problem}") from error


def _without_checksums(result: xr.Dataset) -> xr.Dataset:
    bare = result.copy(deep=False)
    bare.attrs = {name: value for name, value in result.attrs.items() if name != CHECKSUMS}
    return bare


def _checksums(result: xr.Dataset) -> dict[str, str]:
    """Checksums by name. Properties that NetCDF does not keep (the width of a text, the sign of a NaN) do not count."""
    of_variables = {
        str(name): _checksum(_values(v.values), [list(map(str, v.dims)), v.shape, _type(v.dtype), _attributes(v.attrs)])
        for name, v in result.variables.items()
    }
    return of_variables | {_ATTRIBUTES: _checksum(b"", _attributes(result.attrs))}


def _checksum(values: bytes | memoryview, facts: Any) -> str:
    digest = sha256(json.dumps(facts).encode())
    digest.update(values)
    return digest.hexdigest()


def _type(kind: np.dtype) -> str:
    return "text" if kind.kind in "OSU" else kind.newbyteorder("<").str


def _values(values: np.ndarray) -> bytes | memoryview:
    if values.dtype.kind in "OSU":
        texts = [t.decode(errors="replace") if isinstance(t, bytes) else str(t) for t in values.ravel().tolist()]
        return json.dumps(texts).encode()
    if values.dtype.kind in "fc" and (missing := np.isnan(values)).any():
        values = np.where(missing, np.asarray(np.nan, values.dtype), values)
    return np.ascontiguousarray(values, values.dtype.newbyteorder("<")).reshape(-1).view(np.uint8).data


def _attributes(attributes: Mapping[str, Any]) -> list[Any]:
    """Names and values of attributes in a form that is the same before writing and after reading."""
    return sorted([str(name), repr(np.atleast_1d(np.asarray(value)).tolist())] for name, value in attributes.items())


@cache
def versions() -> dict[str, str]:
    """The versions of wucht, Python and the libraries that compute."""
    package_versions = {"python": platform.python_version()}
    for package in _PACKAGES:
        try:
            package_versions[package] = version(package)
        except PackageNotFoundError:
            package_versions[package] = "not installed"
    return package_versions


def provenance(question: Mapping[str, Any], elapsed_s: float) -> dict[str, str | float]:
    """Attributes of a Dataset that record its origin. question: the spec and its subject."""
    return {
        "input": json.dumps(question, default=str),
        "versions": json.dumps(versions()),
        "created": date_of_files().isoformat(timespec="seconds"),
        "elapsed_s": elapsed_s,
    }
