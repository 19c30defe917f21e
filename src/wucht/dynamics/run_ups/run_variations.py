"""Quantities that differ from run to run: start states and parameters, by their names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from wucht.dynamics.parameters import parameter_of
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.schema import Unit, full_name

_BARE = {"speed": "angle", "velocity": "displacement"}  # the meaning of a bare value in a start, by the other key of its table


@dataclass(frozen=True)
class StartState:
    """A state that a start may give.

    keys: its path in a start, each in the table of that before. period: of an angle, after which the motion is the same.

    is_limited: True if a machine does not allow all values of it.
    """

    keys: tuple[str, ...]
    unit: Unit
    description: str
    period: float | None = None
    is_limited: bool = False


@dataclass(frozen=True)
class VariedQuantity:
    """A quantity that differs from run to run. state: the start state it is, None for a parameter. unit: SI."""

    name: str
    state: StartState | None
    description: str
    unit: str

    @property
    def quantity(self) -> Unit:
        """The unit in which its values are read."""
        return Unit(self.unit, self.description) if self.state is None else self.state.unit


def start_states(machine: Machine) -> dict[str, StartState]:
    """Return the start states of a machine by name, as ``initial_state`` reads them, but for those that a drive prescribes.

    An angle has the period of a turn. psi and delta set two angles psi +- delta/2: these are as before after a turn of psi, but
    only after two of delta, as after one each body has gone half a turn.
    """
    units, turn = machine.units, 2 * math.pi
    angle, speed = Unit("rad" if units.time else "", "angle"), Unit(units.speed, "speed")
    states: dict[str, StartState] = {}
    for body in machine.bodies:
        if body.coordinate.prescribed_velocity is None:
            relation = f" to {body.about}" if body.about else ""
            at = StartState((body.name, "angle"), angle, f"angle of {body.name}{relation} at the start", turn)
            states |= {body.name: at, f"{body.name}.angle": at}
            states[f"{body.name}.speed"] = StartState((body.name, "speed"), speed, f"speed of {body.name} at the start")
    for slider in machine.sliders:
        out = StartState(
            (slider.name, "displacement"), Unit("m", "displacement"), f"displacement of {slider.name} at the start"
        )
        states.setdefault(slider.name, out)  # the bare name of a body that turns as well is its angle
        states[f"{slider.name}.displacement"] = out
        moving = StartState((slider.name, "velocity"), Unit("m/s", "velocity"), f"velocity of {slider.name} at the start")
        states[f"{slider.name}.velocity"] = moving
    for d in machine.free_labels:
        turning, length = d == "r", units.length
        displacement_unit = Unit("rad" if turning else length, "displacement")
        rate = Unit(("rad/s" if turning else "m/s") if length else "", "velocity")
        states[f"carrier.{d}"] = StartState(("carrier", d), displacement_unit, f"displacement {d} of the carrier at the start")
        states[f"carrier.v{d}"] = StartState(("carrier", f"v{d}"), rate, f"velocity {d} of the carrier at the start")
    for x in machine.internal:
        name, state_unit = x.state.name, x.description
        quantity, words = Unit(state_unit.unit, state_unit.what), f"{full_name(name, state_unit.what)} at the start"
        states[name] = StartState(tuple(name.split(".")), quantity, words, is_limited=True)
    pair = [b.name for b in machine.bodies if b.about == machine.rotor.name]
    if len(pair) == 2:
        pair_names = " and ".join(pair)
        states["psi"] = StartState(("psi",), angle, f"mean phase of {pair_names} at the start", turn)
        states["delta"] = StartState(("delta",), angle, f"phase difference of {pair_names} at the start", 2 * turn)
    return states


def varied_quantity(machine: Machine, name: str, key: str) -> VariedQuantity:
    """Return the quantity that a name denotes on a machine. Raises ``InputError`` at ``study.<key>``."""
    states, location = start_states(machine), f"study.{key}"
    if name in states and name in machine.parameters:
        raise InputError(
            location, name, "ambiguous: this is the name of both a start state and a parameter", code="two-meanings"
        )
    prescribed_bodies = [b.name for b in machine.bodies if b.coordinate.prescribed_velocity is not None]
    if name.removesuffix(".angle").removesuffix(".speed") in prescribed_bodies and name not in machine.parameters:
        raise InputError(location, name, "not allowed: the drive prescribes this body's motion", code="prescribed")
    if name not in states and name not in machine.parameters:
        hint = nearest(name, [*states, *machine.parameters])
        raise InputError(location, name, f"neither a start state nor a parameter; {hint}", code="unknown-name")
    if name in states:
        state = states[name]
        return VariedQuantity(name, state, state.description, state.unit.si)
    parameter = parameter_of(machine, name, key)
    return VariedQuantity(name, None, parameter.full_name, parameter.unit)


def check_given_once(quantities: Sequence[VariedQuantity], start: Mapping[str, Any], key: str, source_name: str) -> None:
    """Raise ``InputError`` at ``study.<key>.<name>`` if a start state is given twice: by two quantities, or by one and by the
    start (which fits alone). source_name: the source of a quantity in the sentence."""
    sources = dict.fromkeys(_start_keys(start), "study.start")
    for name, state in ((v.name, v.state) for v in quantities if v.state is not None):
        if state.keys in sources:
            message = f"this state is given by {sources[state.keys]} too; give it once"
            raise InputError(f"study.{key}.{name}", name, message, code="given-twice")
        sources[state.keys] = source_name


def _start_keys(start: Mapping[str, Any]) -> list[tuple[str, ...]]:
    """Return the keys of all entries of a start; a bare value is the angle of a body or the displacement of a slider."""
    paths: list[tuple[str, ...]] = []
    for name, entry in start.items():
        inner = [*_start_keys(entry)] if isinstance(entry, Mapping) else [(key,) for key in _BARE.values()]
        paths += [(name,), *((name, *keys) for keys in inner)]
    return paths


def with_states(start: Mapping[str, Any], states: Sequence[tuple[StartState, float]]) -> dict[str, Any]:
    """Return the start with the values of some states besides."""
    result = dict(start)
    for state, value in states:
        result = _with_value(result, state.keys, value)
    return result


def _with_value(table: Mapping[str, Any], keys: Sequence[str], value: float) -> dict[str, Any]:
    first, *rest = keys
    if not rest:
        return {**table, first: value}
    inner = table.get(first, {})
    return {**table, first: _with_value(inner if isinstance(inner, Mapping) else {_BARE[rest[0]]: inner}, rest, value)}
