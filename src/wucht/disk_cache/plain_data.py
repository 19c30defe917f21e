"""Frozen data of SymPy's expressions as bytes, and back: JSON that names classes, so that reading runs no program.

A value is a list of nodes, each after those that it refers to by their places. Expressions are built as they were, without
SymPy's evaluation of their arguments, which takes ten times as long.
"""

from __future__ import annotations

import json
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import fields, is_dataclass
from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    import sympy as sp

_PACKAGES = ("wucht", "sympy")  # of whose classes the data may be
_BYTES, _JSON = b"b", b"j"  # first byte of the form
_INLINE = (str, float, bool, type(None))  # written in the node that refers to them; whole numbers are places
_COLLECTIONS: dict[str, Callable[[list[Any]], Any]] = {"tuple": tuple, "list": list, "frozenset": frozenset, "set": set}


def to_bytes(value: Any) -> bytes:
    """Write bytes, or frozen data: numbers, text, collections, expressions and dataclasses of wucht. Raises ``TypeError``."""
    if isinstance(value, bytes):
        return _BYTES + value
    writer = _Writer()
    return _JSON + json.dumps([writer.place(value), writer.nodes], separators=(",", ":")).encode()


def from_bytes(content: bytes) -> Any:
    """Read what ``to_bytes`` has written. Raises ``ValueError`` for a class of another package."""
    if content[:1] == _BYTES:
        return content[1:]
    last, nodes = json.loads(content[1:])
    return _Reader(nodes).value(last)


class _Writer:
    """The nodes of a value."""

    def __init__(self) -> None:
        import sympy as sp

        self.nodes: list[list[Any]] = []
        self._basic = sp.Basic
        self._places: dict[int, tuple[int, Any]] = {}  # by identity, with the expression: so that no other one takes its place

    def place(self, value: Any) -> Any:
        """The place of a value, or the value itself."""
        if isinstance(value, _INLINE):
            return value
        if (earlier := self._places.get(id(value))) is not None:
            return earlier[0]
        self.nodes.append(self._node(value))
        self._places[id(value)] = len(self.nodes) - 1, value
        return len(self.nodes) - 1

    def _node(self, value: Any) -> list[Any]:
        if isinstance(value, int):
            return ["int", str(value)]
        if type(value).__name__ in _COLLECTIONS:
            return [type(value).__name__, *map(self.place, value)]
        if isinstance(value, dict):
            return ["dict", *(self.place(part) for pair in value.items() for part in pair)]
        if isinstance(value, self._basic):
            return self._expression(value)
        if is_dataclass(value) and not isinstance(value, type):
            values = [self.place(getattr(value, f.name)) for f in fields(value)]
            return ["dataclass", _class_name(type(value)), [f.name for f in fields(value)], *values]
        raise TypeError(f"a {type(value).__name__} cannot be stored")

    def _expression(self, value: sp.Basic) -> list[Any]:
        """A class and its arguments, as SymPy states them for copies."""
        options: dict[str, Any] = {}
        if hasattr(value, "__getnewargs_ex__"):
            arguments, options = value.__getnewargs_ex__()
        else:
            arguments = value.__getnewargs__()
        places = [self.place(a) for a in arguments]
        return ["expression", _class_name(type(value)), {k: self.place(v) for k, v in options.items()}, *places]


class _Reader:
    """The values of nodes, in their order."""

    def __init__(self, nodes: list[list[Any]]) -> None:
        import sympy as sp

        self._basic, self._unevaluated = sp.Basic, (sp.Add, sp.Mul, sp.Pow, sp.Function)  # which take the option
        self._makers: dict[str, tuple[type, dict[str, bool]]] = {}
        self._values: list[Any] = []
        for node in nodes:
            self._values.append(self._read(node))

    def value(self, place: Any) -> Any:
        """The value at a place, or the value itself."""
        return self._values[place] if type(place) is int else place

    def _read(self, node: list[Any]) -> Any:
        kind = node[0]
        if kind == "expression":
            made_class, more_options = self._maker(node[1])
            options = {name: self.value(place) for name, place in node[2].items()}
            return made_class(*map(self.value, node[3:]), **options, **more_options)
        if kind == "int":
            return int(node[1])
        if kind == "dict":
            parts = list(map(self.value, node[1:]))
            return dict(zip(parts[::2], parts[1::2], strict=True))
        if kind == "dataclass":
            made_class, _ = self._maker(node[1])
            instance: Any = object.__new__(made_class)
            for name, place in zip(node[2], node[3:], strict=True):
                object.__setattr__(instance, name, self.value(place))
            return instance
        return _COLLECTIONS[kind](list(map(self.value, node[1:])))

    def _maker(self, name: str) -> tuple[type, dict[str, bool]]:
        """A class, and the option with which it makes an expression as it was."""
        if name not in self._makers:
            made_class = _class(name)
            if not (issubclass(made_class, self._basic) or is_dataclass(made_class)):
                raise ValueError(f"{name} is neither a class of expressions nor a dataclass")
            self._makers[name] = made_class, {"evaluate": False} if issubclass(made_class, self._unevaluated) else {}
        return self._makers[name]


def _class_name(of: type) -> str:
    """Module and name of a class. Raises ``TypeError`` for a class that is not found by them."""
    name = f"{of.__module__}:{of.__qualname__}"
    try:
        candidate = _class(name)
    except ValueError:
        candidate = None
    if candidate is not of:
        raise TypeError(f"{of.__qualname__} is not a class of {' or '.join(_PACKAGES)}")
    return name


def _class(name: str) -> type:
    """The class of a name. Raises ``ValueError`` if there is none, or it is of another package."""
    module_name, _, qualified_name = name.partition(":")
    value: Any = None
    if module_name.split(".")[0] in _PACKAGES:
        with suppress(ImportError, AttributeError):
            value = sys.modules.get(module_name) or import_module(module_name)
            for part in qualified_name.split("."):
                value = getattr(value, part)
    if not isinstance(value, type):
        raise ValueError(f"{name} is not a class of {' or '.join(_PACKAGES)}")
    return value
