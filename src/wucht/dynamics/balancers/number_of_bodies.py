"""A machine with another number of balancing bodies."""

from __future__ import annotations

from collections.abc import Sequence

from wucht.dynamics.sampling.searches import balancing
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body, Drive, Load
from wucht.machines.parts.support import Support
from wucht.machines.parts.track import Tracked

_SAME = 1e-9


def with_bodies(machine: Machine, count: int) -> Machine:
    """The machine with another number of balancing bodies, each like its first one. Raises ``InputError``."""
    names = balancing(machine)
    if count == len(names):
        return machine
    if machine.schedules:
        raise InputError("study.bodies", count, "allowed only for a machine without schedules", code="schedules")
    bodies = [p for p in machine.parts if isinstance(p, Body)]
    first = next(b for b in bodies if b.name == names[0])
    _check_equal(machine, names, count)
    others = [b for b in bodies if b.name not in names]
    if any(b.reference in names for b in others):
        raise InputError(
            "study.bodies", count, "allowed only where nothing turns about the balancing bodies", code="turned-about"
        )
    taken = {b.name for b in bodies}
    fresh = (f"{names[0]}_{i}" for i in range(2, count + len(taken) + 2))
    more = [n for n in fresh if n not in taken][: max(count - len(names), 0)]
    kept = [b for b in bodies if b.name in names[:count]]
    carrier = next(p for p in machine.parts if isinstance(p, Support))
    made = Machine(
        carrier,
        [*others, *map(_anywhere, kept), *(_anywhere(first.model_copy(update={"name": n})) for n in more)],
        [p for p in machine.parts if isinstance(p, Drive)],
        [p for p in machine.parts if isinstance(p, Load)],
        tracks={t.name: {"contact_frequency": t.frequency} for t in machine.tracks if t.given},
        title=machine.title,
    )
    # Values may have been changed after the parts were built.
    own = {path: value for path, value in machine.values.items() if path in made.parameters and ".offset" not in path}
    own |= {f"{n}.{key}": machine.values[f"{names[0]}.{key}"] for n in more for key in _keys(machine, names[0])}
    return made.with_unchecked(own)


def _anywhere(body: Body) -> Body:
    """The body without a place of its own at the start: that of another number of them is another."""
    return body.model_copy(update={"start": None}) if isinstance(body, Tracked) else body


def _keys(machine: Machine, body: str) -> list[str]:
    return [p.removeprefix(f"{body}.") for p in machine.values if p.startswith(f"{body}.")]


def _check_equal(machine: Machine, names: Sequence[str], count: int) -> None:
    """Raises ``InputError`` where the bodies differ: it would not be known like which of them others are."""
    kinds = {b.name: b.kind for b in machine.bodies}
    for name in names[1:]:
        same = kinds[name] == kinds[names[0]] and _keys(machine, name) == _keys(machine, names[0])
        for key in _keys(machine, names[0]) if same else ():
            a, b = machine.values[f"{names[0]}.{key}"], machine.values[f"{name}.{key}"]
            same = same and abs(a - b) <= _SAME * max(abs(a), abs(b))
        if not same:
            raise InputError(
                "study.bodies",
                count,
                f"allowed only for equal bodies; {name!r} differs from {names[0]!r}",
                code="different-bodies",
            )
