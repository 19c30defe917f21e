"""Frozen data as a Zarr group: numbers, text, arrays, tuples, dictionaries, and dataclasses of them. Reading executes nothing.

The numbers of all arrays of one type stand one after the other in one array of the group; what they belong to is said by its
attribute ``tree``, and whether all of them are there by ``digest``: whatever is cut off, mixed up or half written is not read.
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

_KINDS = "biufc"  # of arrays: truth values, integers, real and complex numbers
_AT_ONCE = 2**20  # numbers that are written at once
Arrays = dict[str, list[np.ndarray]]  # by type: one after the other


def write(path: Path, values: Mapping[str, Any]) -> None:
    """Write named values as a group that is not there yet. Raises ``WuchtError`` for what is no frozen data, ``OSError``."""
    import zarr

    arrays: Arrays = {}
    tree = json.dumps({name: _packed(value, arrays) for name, value in values.items()})
    kept = {kind: parts for kind, parts in arrays.items() if sum(part.size for part in parts)}
    group = zarr.create_group(path, attributes={"tree": tree, "types": list(kept), "digest": _digest(tree, kept)})
    for kind, parts in kept.items():
        count = sum(part.size for part in parts)
        array = group.create_array(kind, shape=(count,), dtype=kind, chunks=(min(count, _AT_ONCE),))
        for k, block in enumerate(_blocks(parts)):
            array[k * _AT_ONCE : k * _AT_ONCE + len(block)] = block


def _blocks(parts: Sequence[np.ndarray]) -> Iterator[np.ndarray]:
    """The numbers of all parts, so many at once: together they may be more than there is room for a second time."""
    waiting, count = list[np.ndarray](), 0
    for part in parts:
        rest = part.ravel()
        while len(rest):
            taken = rest[: _AT_ONCE - count]
            waiting.append(taken)
            rest, count = rest[len(taken) :], count + len(taken)
            if count == _AT_ONCE:
                yield np.concatenate(waiting)
                waiting, count = [], 0
    if waiting:
        yield np.concatenate(waiting)


def read(path: Path) -> dict[str, Any]:
    """The values of a group. Classes are looked up among those that are loaded. Raises ``WuchtError`` for anything else."""
    import zarr

    try:
        group = zarr.open_group(path, mode="r")
        tree = str(group.attrs["tree"])
        joined = {kind: np.asarray(group[kind][:]) for kind in group.attrs["types"]}
        if _digest(tree, {kind: [whole] for kind, whole in joined.items()}) != group.attrs["digest"]:
            raise ValueError("numbers are missing")
        return {name: _unpacked(value, joined) for name, value in json.loads(tree).items()}
    except Exception as error:
        # Whatever a damaged group makes the readers beneath stumble over: to the user it is one thing.
        raise WuchtError(f"{path} cannot be read: {error}", code="incomplete") from None


def size(value: Any) -> int:
    """The bytes of all arrays in frozen data."""
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


def _packed(value: Any, arrays: Arrays) -> Any:  # noqa: PLR0911
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Enum)):
        return value
    if isinstance(value, np.generic):
        return _packed(value.item(), arrays)
    if isinstance(value, np.ndarray | complex):
        return _packed_array(np.asarray(value), arrays)
    if isinstance(value, Enum):
        return {"enum": _name(type(value)), "value": value.value}
    if isinstance(value, Mapping):
        return {"map": [[_packed(k, arrays), _packed(v, arrays)] for k, v in value.items()]}
    if isinstance(value, tuple | list):
        return {"list": [_packed(v, arrays) for v in value], "tuple": isinstance(value, tuple)}
    if is_dataclass(value) and not isinstance(value, type):
        return {"class": _name(type(value)), "fields": {f.name: _packed(getattr(value, f.name), arrays) for f in fields(value)}}
    raise WuchtError(
        f"a {type(value).__name__} cannot be kept: units of work return frozen dataclasses, arrays and numbers", code="unit"
    )


def _packed_array(array: np.ndarray, arrays: Arrays) -> Any:
    if array.dtype.kind == "U":
        return {"text": array.ravel().tolist(), "type": array.dtype.str, "shape": array.shape}
    if array.dtype.kind not in _KINDS or not array.dtype.isnative:
        raise WuchtError(f"an array of {array.dtype} cannot be kept: units of work return arrays of numbers and text")
    parts = arrays.setdefault(array.dtype.name, [])
    begin = sum(part.size for part in parts)
    parts.append(array)  # flat only when it is written, one after the other: that may be a copy
    return {"array": array.dtype.name, "begin": begin, "shape": array.shape}


def _unpacked(value: Any, arrays: Mapping[str, np.ndarray]) -> Any:  # noqa: PLR0911
    if not isinstance(value, dict):
        return value
    if "text" in value:
        return np.array(value["text"], value["type"]).reshape(value["shape"])
    if "array" in value:
        shape, begin = value["shape"], value["begin"]
        numbers = arrays.get(value["array"], np.zeros(0, value["array"]))[begin : begin + math.prod(shape)]
        array = numbers.reshape(shape).copy()  # by itself: what is read of one value does not keep all others in memory
        return array if array.ndim else array.item()
    if "map" in value:
        return {_unpacked(k, arrays): _unpacked(v, arrays) for k, v in value["map"]}
    if "list" in value:
        return (tuple if value["tuple"] else list)(_unpacked(v, arrays) for v in value["list"])
    if "enum" in value:
        return _class(value["enum"])(value["value"])
    return _class(value["class"])(**{k: _unpacked(v, arrays) for k, v in value["fields"].items()})


def _name(cls: type) -> str:
    return f"{cls.__module__}:{cls.__qualname__}"


def _class(name: str) -> Any:
    """A dataclass or enumeration that is loaded. Raises ``ValueError``."""
    module, _, rest = name.partition(":")
    cls: Any = sys.modules.get(module)
    for step in rest.split("."):
        cls = getattr(cls, step, None)
    if not isinstance(cls, type) or not (is_dataclass(cls) or issubclass(cls, Enum)):
        raise ValueError(f"{name} is not loaded")
    return cls
