"""Frozen data in one file: numbers, text, arrays, tuples, dictionaries, and dataclasses of them. Reading executes nothing."""

from __future__ import annotations

import json
import sys
from collections.abc import Mapping
from dataclasses import fields, is_dataclass
from enum import Enum
from pathlib import Path
from typing import Any
from zipfile import BadZipFile

import numpy as np

from wucht.errors import WuchtError


def write(path: Path, values: Mapping[str, Any]) -> None:
    """Write named values. Raises ``WuchtError`` for what is no frozen data."""
    arrays: dict[str, np.ndarray] = {}
    tree = json.dumps({name: _packed(value, arrays) for name, value in values.items()})
    with path.open("wb") as file:
        np.savez(file, tree=np.array(tree), **arrays)  # type: ignore[arg-type]


def read(path: Path) -> dict[str, Any]:
    """The values of a file. Classes are looked up among those that are loaded. Raises ``WuchtError`` for another file."""
    try:
        with np.load(path, allow_pickle=False) as file:
            arrays = {name: file[name] for name in file.files}
        tree = json.loads(str(arrays.pop("tree")))
        return {name: _unpacked(value, arrays) for name, value in tree.items()}
    except (OSError, ValueError, KeyError, TypeError, AttributeError, EOFError, BadZipFile) as error:
        raise WuchtError(f"{path} cannot be read: {error}") from None


def _packed(value: Any, arrays: dict[str, np.ndarray]) -> Any:  # noqa: PLR0911
    if value is None or (isinstance(value, bool | int | float | str) and not isinstance(value, Enum)):
        return value
    if isinstance(value, np.generic):
        return _packed(value.item(), arrays)
    if isinstance(value, np.ndarray | complex):
        arrays[name := f"a{len(arrays)}"] = np.asarray(value)
        return {"array": name}
    if isinstance(value, Enum):
        return {"enum": _name(type(value)), "value": value.value}
    if isinstance(value, Mapping):
        return {"map": [[_packed(k, arrays), _packed(v, arrays)] for k, v in value.items()]}
    if isinstance(value, tuple | list):
        return {"list": [_packed(v, arrays) for v in value], "tuple": isinstance(value, tuple)}
    if is_dataclass(value) and not isinstance(value, type):
        return {"class": _name(type(value)), "fields": {f.name: _packed(getattr(value, f.name), arrays) for f in fields(value)}}
    raise WuchtError(f"a {type(value).__name__} cannot be kept: units of work return frozen dataclasses, arrays and numbers")


def _unpacked(value: Any, arrays: Mapping[str, np.ndarray]) -> Any:
    if not isinstance(value, dict):
        return value
    if "array" in value:
        array = arrays[value["array"]]
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
