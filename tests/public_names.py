"""The names that users import, as docs/api/public.txt states them, and a line that describes one.

`python -m tests.public_names NAME...` prints the lines of names, as they are to stand in the list.
"""

from __future__ import annotations

import inspect
import sys
from enum import Enum
from importlib import import_module
from pathlib import Path
from typing import Any

from pydantic import BaseModel

LIST = Path(__file__).parents[1] / "docs" / "api" / "public.txt"
PACKAGES = (
    "wucht", "wucht.parts", "wucht.extending", "wucht.extending_0_1", "wucht.numerics.flow", "wucht.numerics.continuation",
    "wucht.numerics.periodic", "wucht.mechanics", "wucht.cams", "wucht.fatigue", "wucht.measurements",
)  # fmt: skip


def listed_lines() -> dict[str, str]:
    """The lines of the list, by the name with which each begins."""
    lines = [line for line in LIST.read_text(encoding="utf-8").splitlines() if line and not line.startswith("#")]
    return {line.partition("(")[0].partition(":")[0].partition(" ")[0]: line for line in lines}


def exported_names(package: str) -> set[str]:
    """What a package exports; of parts those of wucht, not of other packages."""
    module = public_package(package)
    if package == "wucht.parts":
        return {name for name in dir(module) if getattr(module, name).__module__.startswith("wucht.")}
    return {*module.__all__} - {"__version__", "parts"}


def package_of(name: str) -> str:
    """The package that exports a name, or the class of it."""
    return max((package for package in PACKAGES if name.startswith(f"{package}.")), key=len)


def public_package(package: str) -> Any:
    """A package by its public name: ``wucht.parts`` is one, too."""
    return import_module("wucht").parts if package == "wucht.parts" else import_module(package)


def line_of(name: str) -> str:
    """Describe a name: the parameters of what is called, those with ``=`` optional, and the type of what it gives.

    Of a table, whose parameters are keys of files, and of an enumeration the name alone.
    """
    package = package_of(name)
    words = name.removeprefix(f"{package}.").split(".")
    if len(words) == 1:
        value = getattr(public_package(package), words[0])
        if not (inspect.isclass(value) or inspect.isfunction(value) or hasattr(value, "__wrapped__")):
            return name
        return name if inspect.isclass(value) and issubclass(value, BaseModel | Enum) else f"{name}{_signature(value)}"
    (owner_name, attribute) = words
    owner = getattr(public_package(package), owner_name)
    member = inspect.getattr_static(owner, attribute, None)
    if isinstance(member, classmethod | staticmethod) or inspect.isfunction(member):
        return f"{name}{_signature(getattr(owner, attribute), bound=not inspect.isfunction(member))}"
    function = getattr(member, "fget", None) or getattr(member, "func", None)  # a property, a cached one
    kind = function.__annotations__["return"] if function else _annotations(owner)[attribute]
    return f"{name}: {kind}"


def _annotations(owner: type) -> dict[str, Any]:
    return {name: kind for cls in reversed(owner.__mro__) for name, kind in vars(cls).get("__annotations__", {}).items()}


def _signature(function: Any, bound: bool = True) -> str:
    """Names of parameters alone: what stands in their annotations and defaults may change."""
    signature, words, is_keyword = inspect.signature(function), list[str](), False
    for p in list(signature.parameters.values())[not bound :]:
        if p.kind is p.KEYWORD_ONLY and not is_keyword and not any(w.startswith("*") for w in words):
            words.append("*")
        is_keyword = p.kind is p.KEYWORD_ONLY
        star = {p.VAR_POSITIONAL: "*", p.VAR_KEYWORD: "**"}.get(p.kind, "")
        words.append(f"{star}{p.name}{'' if p.default is p.empty or star else '='}")
    given = "" if inspect.isclass(function) or signature.return_annotation is signature.empty else signature.return_annotation
    return f"({', '.join(words)})" + (f" -> {given}" if given else "")


if __name__ == "__main__":
    sys.stdout.writelines(f"{line_of(word)}\n" for word in sys.argv[1:])
