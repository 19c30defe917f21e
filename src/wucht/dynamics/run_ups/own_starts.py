"""Where the states of parts' own start: the lining of a friction damper, the integral part of a controller."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from typing import Any

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.mechanics.energies import Internal
from wucht.schema import Unit, article, read_quantity, refuse_unknown

_ROUNDING = 1e-9  # of the size


def owners(machine: Machine) -> list[str]:
    """The keys of a start under which such states stand: names of attachments, ``drive`` or ``drives``."""
    return list(dict.fromkeys(x.path.split(".")[0] for x in machine.internal))


def own_starts(machine: Machine, start: Mapping[str, Any], where: str) -> dict[str, float]:
    """The values of all such states by name; 0 where the start does not say. Raises ``InputError``."""
    known = {tuple(x.state.name.split(".")): x for x in machine.internal}
    values = {x.state.name: 0.0 for x in known.values()}
    for name in owners(machine):
        if name in start:
            for x, given, at in _stated(known, (name,), start[name], where):
                values[x.state.name] = _value(machine, x, given, at)
    return values


def _stated(
    known: Mapping[tuple[str, ...], Internal], keys: tuple[str, ...], given: Any, where: str
) -> Iterator[tuple[Internal, Any, str]]:
    """What is given in a table of a start and those inside: of which state, and where."""
    at = ".".join((where, *keys))
    if keys in known:
        yield known[keys], given, at
        return
    inner = list(dict.fromkeys(k[len(keys)] for k in known if k[: len(keys)] == keys))
    if not isinstance(given, Mapping):
        raise InputError(at, given, f"must be a table such as {{ {inner[0]} = {_example(known, keys, inner[0])} }}")
    refuse_unknown(given, inner, at)
    for key, value in given.items():
        yield from _stated(known, (*keys, key), value, where)


def _example(known: Mapping[tuple[str, ...], Internal], keys: tuple[str, ...], key: str) -> str:
    state = known.get((*keys, key))
    return "{ ... }" if state is None else f'"0 {state.own.unit}"'


def _value(machine: Machine, x: Internal, given: Any, where: str) -> float:
    """In SI, within the size that the state can have."""
    value, (size,) = read_quantity(Unit(x.own.unit, x.own.what), given, where), machine.evaluate(x.size)
    if abs(value) > size * (1 + _ROUNDING):
        limits = f"between -{size:g} and {size:g} {x.own.unit}"
        raise InputError(where, given, f"must be {article(x.own.what)} {limits}: it cannot become larger")
    return value
