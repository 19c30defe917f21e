"""Frozen data as a Zarr group: numbers, text, arrays, tuples, dictionaries, and dataclasses of them. Reading executes nothing.

The numbers of all arrays of one type are stored one after the other in one array of the group. Its attribute ``tree`` assigns
them to the values, and ``digest`` checks that they are complete: truncated, mixed or half-written data are not read.
"""

from __future__ import annotations

import json
import math
import sys
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import fields, is_dataclass
from enum import Enum
from hashlib import sha256
from pathlib import Path
from typing import Any

import numpy as np

from wucht.errors import WuchtError

_KINDS = "biufc"  # of arrays: booleans, integers, real and complex numbers
_AT_ONCE = 2**20  # numbers per chunk
Arrays = dict[str, list[np.ndarray]]  # by type, in order


def write_values(path: Path, values: Mapping[str, Any]) -> None:
    """Write named values as a new group. Raises ``WuchtError`` for anything but frozen data, and ``OSError``."""
    import zarr

    arrays: Arrays = {}
    tree = json.dumps({name: _pack(value, arrays) for name, value in values.items()})
    filled_arrays = {kind: parts for kind, parts in arrays.items() if sum(part.size for part in parts)}
    group = zarr.create_group(
        path, attributes={"tree": tree, "types": list(filled_arrays), "digest": _digest(tree, filled_arrays)}
    )
    for kind, parts in filled_arrays.items():
        count = sum(part.size for part in parts)
        array = group.create_array(kind, shape=(count,), dtype=kind, chunks=(min(count, _AT_ONCE),))
        for k, block in enumerate(_blocks(parts)):
            array[k * _AT_ONCE : k * _AT_ONCE + len(block)] = block


def _blocks(parts: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    """Yield the numbers of all parts in chunks: memory may not suffice for a second copy of them all."""
    waiting, count = list[np.ndarray](), 0
    for part in parts:
        rest = part.ravel()
        while len(rest):
            piece = rest[: _AT_ONCE - count]
            waiting.append(piece)
            rest, count = rest[len(piece) :], count + len(piece)
            if count == _AT_ONCE:
                yield np.concatenate(waiting)
                waiting, count = [], 0
    if waiting:
        yield np.concatenate(waiting)


def read_values(path: Path) -> dict[str, Any]:
    """Read the values of a group. Classes must be loaded already. Raises ``WuchtError`` for anything else."""
    import zarr

    try:
        group = zarr.open_group(path, mode="r")
        tree = str(group.attrs["tree"])
        arrays = {kind: np.asarray(group[kind][:]) for kind in group.attrs["types"]}
        if _digest(tree, {kind: [whole] for kind, whole in arrays.items()}) != group.attrs["digest"]:
            raise ValueError("numbers are missing")
        return {name: _unpack(value, arrays) for name, value in json.loads(tree).items()}
    except Exception as error:
        # A damaged group can cause any error in the libraries beneath: to the user they mean the same.
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


def _digest(tree: str, arrays: Mapping[str, Sequence[np.ndarray]]) -> str:
    digest = sha256(tree.encode())
    for kind in sorted(arrays):
        digest.update(kind.encode())
        for part in arrays[kind]:
            digest.update(np.ascontiguousarray(part).reshape(-1).view(np.uint8).data)
    return digest.hexdigest()


def _pack(value: Any, arrays: Arrays) -> Any:  # noqa: PLR0911
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Enum)):
        return value
    if isinstance(value, np.generic):
        return _pack(value.item(), arrays)
    if isinstance(value, np.ndarray | complex):
        return _pack_array(np.asarray(value), arrays)
    if isinstance(value, Enum):
        return {"enum": _name(type(value)), "value": value.value}
    if isinstance(value, Mapping):
        return {"map": [[_pack(k, arrays), _pack(v, arrays)] for k, v in value.items()]}
    if isinstance(value, tuple | list):
        return {"list": [_pack(v, arrays) for v in value], "tuple": isinstance(value, tuple)}
    if is_dataclass(value) and not isinstance(value, type):
        return {"class": _name(type(value)), "fields": {f.name: _pack(getattr(value, f.name), arrays) for f in fields(value)}}
    raise WuchtError(
        f"a {type(value).__name__} cannot be stored: units of work return frozen dataclasses, arrays and numbers", code="unit"
    )


def _pack_array(array: np.ndarray, arrays: Arrays) -> Any:
    if array.dtype.kind == "U":
        return {"text": array.ravel().tolist(), "type": array.dtype.str, "shape": array.shape}
    if array.dtype.kind not in _KINDS or not array.dtype.isnative:
        raise WuchtError(f"an array of {array.dtype} cannot be stored: units of work return arrays of numbers and text")
    parts = arrays.setdefault(array.dtype.name, [])
    begin = sum(part.size for part in parts)
    parts.append(array)  # flattened only when it is written, as that may copy it
    return {"array": array.dtype.name, "begin": begin, "shape": array.shape}


def _unpack(value: Any, arrays: Mapping[str, np.ndarray]) -> Any:  # noqa: PLR0911
    if not isinstance(value, dict):
        return value
    if "text" in value:
        return np.array(value["text"], value["type"]).reshape(value["shape"])
    if "array" in value:
        shape, begin = value["shape"], value["begin"]
        numbers = arrays.get(value["array"], np.zeros(0, value["array"]))[begin : begin + math.prod(shape)]
        array = numbers.reshape(shape).copy()  # a copy, so that one value does not keep all others in memory
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
