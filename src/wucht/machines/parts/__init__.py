"""The parts of a machine: one class a file, each with its formulas. A new part is a new file here and nothing else."""

from __future__ import annotations

from functools import cache
from importlib import import_module
from pkgutil import iter_modules

from wucht.machines.parts.base import Body, Drive, Load, Part


@cache
def _load() -> None:
    for module in iter_modules(__path__):
        import_module(f"{__name__}.{module.name}")


def known(family: type) -> dict[str, type[Part]]:
    """All kinds of bodies, drives or loads: every ``family`` class that has a ``kind``, here or in the user's own code."""
    _load()
    kinds: dict[str, type[Part]] = {}
    pending: list[type[Part]] = [family]
    while pending:
        cls = pending.pop()
        pending += cls.__subclasses__()
        if "kind" in vars(cls) and cls.kind:
            kinds[cls.kind] = cls
    return dict(sorted(kinds.items()))


def bodies() -> dict[str, type[Part]]:
    """The kinds of bodies by name."""
    return known(Body)


def drives() -> dict[str, type[Part]]:
    """The kinds of drives by name."""
    return known(Drive)


def loads() -> dict[str, type[Part]]:
    """The kinds of loads by name."""
    return known(Load)
