"""Frozen data as a file: numbers, text, arrays, tuples, dictionaries, and dataclasses of them. Reading executes nothing.

It is an archive of NumPy (npz) with an entry for each array, and ``tree.json``, which assigns them to the values. Each entry
has a checksum, and the list of entries stands at the end: truncated or changed data are not read.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any
from zipfile import ZIP_DEFLATED, ZIP_STORED, ZipFile, ZipInfo
from zlib import compress

import numpy as np

from wucht.errors import WuchtError

_KINDS = "biufcU"  # of arrays: booleans, integers, real and complex numbers, text
_TREE = "tree.json"
_SAMPLE = 1000  # numbers that tell whether an array can be compressed


def write_values(path: Path, values: Mapping[str, Any]) -> None:
    """Write named values. Raises ``WuchtError`` for anything but frozen data, and ``OSError``."""
    arrays = list[np.ndarray]()
    tree = json.dumps({name: _pack(value, arrays) for name, value in values.items()})
    with ZipFile(path, "w") as file:
        file.writestr(ZipInfo(_TREE), tree, ZIP_DEFLATED)
        for number, array in enumerate(arrays):  # in pieces: memory may not suffice for a second copy
            info = ZipInfo(f"{number}.npy")
            info.compress_type = _compression(array)
            with file.open(info, "w", force_zip64=True) as entry:
                np.lib.format.write_array(entry, array, allow_pickle=False)


def _compression(array: np.ndarray) -> int:
    """Of an entry: many numbers that do not become much smaller, as most do not, would take much time for nothing."""
    sample = array.flat[:: max(1, array.size // _SAMPLE)].tobytes()
    is_worth_it = array.size <= _SAMPLE or len(compress(sample)) < 0.75 * len(sample)
    return ZIP_DEFLATED if is_worth_it else ZIP_STORED


def read_value(path: Path, name: str) -> Any:
    """Read a value by its name. Classes must be loaded already. Raises ``WuchtError`` for anything else."""
    try:
        with np.load(path, allow_pickle=False) as arrays:
            return _unpack(json.loads(arrays[_TREE])[name], arrays)
    except Exception as error:
        # A damaged file can cause any error in the libraries beneath: to the user they mean the same.
        raise WuchtError(f"{path} cannot be read: {error}", code="incomplete") from None


def size(value: Any) -> int:
    """Size in bytes of all arrays in frozen data."""
    if isinstance(value, np.ndarray):
        return value.nbytes
    if isinstance(value, Mapping):
        return sum(map(size, value.values()))
    if isinstance(value, tuple | list):
        return sum(map(size, value))
    if is_dataclass(value) and not isinstance(value, type):
        return sum(size(getattr(value, f.name)) for f in fields(value))
    return 0


def _pack(value: Any, arrays: list[np.ndarray]) -> Any:  # noqa: PLR0911
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Enum)):
        return value
    if isinstance(value, np.generic):
        return _pack(value.item(), arrays)
    if isinstance(value, complex) or (isinstance(value, np.ndarray) and value.dtype.kind in _KINDS):
        arrays.append(np.asarray(value))
        return {"array": len(arrays) - 1}
    if isinstance(value, Enum):
        return {"enum": _name(type(value)), "value": value.value}
    if isinstance(value, Mapping):
        return {"map": [[_pack(k, arrays), _pack(v, arrays)] for k, v in value.items()]}
    if isinstance(value, tuple | list):
        return {"list": [_pack(v, arrays) for v in value], "tuple": isinstance(value, tuple)}
    if is_dataclass(value) and not isinstance(value, type):
        return {"class": _name(type(value)), "fields": {f.name: _pack(getattr(value, f.name), arrays) for f in fields(value)}}
    raise WuchtError(
        f"a {type(value).__name__} cannot be stored: units of work return frozen dataclasses, arrays of numbers and text, and "
        "numbers",
        code="unit",
    )


def _unpack(value: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        array = arrays[f"{value['array']}.npy"]
        return array if array.ndim else array.item()
    if "map" in value:
        return {_unpack(k, arrays): _unpack(v, arrays) for k, v in value["map"]}
    if "list" in value:
        return (tuple if value["tuple"] else list)(_unpack(v, arrays) for v in value["list"])
    if "enum" in value:
        return _class(value["enum"])(value["value"])
    return _class(value["class"])(**{k: _unpack(v, arrays) for k, v in value["fields"].items()})


def _name(cls: type) -> str:
    return f"{cls.__module__}:{cls.__qualname__}"


def _class(name: str) -> Any:
    """Look up a dataclass or enumeration among the loaded modules. Raises ``ValueError``."""
    module, _, rest = name.partition(":")
    cls: Any = sys.modules.get(module)
    for step in rest.split("."):
        cls = getattr(cls, step, None)
    if not isinstance(cls, type) or not (is_dataclass(cls) or issubclass(cls, Enum)):
        raise ValueError(f"{name} is not loaded")
    return cls
