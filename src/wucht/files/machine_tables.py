"""Machine -> the table [machine] of a file: of one that was built in Python, so that its question can be saved and sent."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

from pydantic import BaseModel

from wucht.errors import WuchtError
from wucht.files.building import machine_from
from wucht.files.documents import Document
from wucht.machines.machine import Machine
from wucht.machines.models import DimensionlessMachine
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.support import Support
from wucht.machines.schedules import Schedule
from wucht.schema import unit_of

_GROUPS = ((Body, "bodies"), (Drive, "drives"), (Load, "loads"), (Attachment, "attachments"))


def machine_table(machine: Machine) -> Document:
    """Return the table ``[machine]`` of a machine, from which the same machine is read back.

    Parameters
    ----------
    machine : Machine
        Of parts, whatever they were built from; values in the table are numbers in SI.

    Returns
    -------
    Document

    Raises
    ------
    WuchtError
        Where no file says what the machine is: of parts that are in no table, or were changed after they were assembled.

    Examples
    --------
    >>> from wucht import load_machine
    >>> machine_table(load_machine("drozdetskaya-2020/table-5.1"))["model"]
    'self-balancing-rotor'
    """
    table = _parts_table(machine) | {"title": machine.title or "machine"}
    if machine.schedules:
        table["schedules"] = [_schedule_table(s) for s in machine.schedules]
    try:
        copy = machine_from(table)
        different_values = {path: v for path, v in machine.values.items() if copy.values.get(path) != v}
        if different_values:
            table["set"] = {
                path: _setting(path, value, machine.parameters[path].unit) for path, value in different_values.items()
            }
            copy = machine_from(table)
    except WuchtError as error:
        raise _no_table_error(str(error)) from None
    if reason := next(_differences(machine, copy), ""):
        raise _no_table_error(reason)
    return table


def _no_table_error(reason: str) -> WuchtError:
    return WuchtError(f"no study file can be written for this machine: {reason}", code="no-file-of-machine")


def _differences(machine: Machine, copy: Machine) -> Iterator[str]:
    """What is not the same in a machine that was read back."""
    if copy.values != machine.values:
        yield "its values are not those of its parts"
    if copy.state_names != machine.state_names or copy.system != machine.system:
        yield "its equations are not those of its parts"
    if copy.start_angles != machine.start_angles or copy.start_positions != machine.start_positions:
        yield "its bodies begin elsewhere"


def _parts_table(machine: Machine) -> Document:
    table: Document = {}
    for part in machine.parts:
        if isinstance(part, DimensionlessMachine):
            return {"model": part.kind, "parameters": _part_table(part)}
        if isinstance(part, Support):
            table["carrier"] = _part_table(part)
        for family, key in _GROUPS:
            if isinstance(part, family):
                table.setdefault(key, []).append({"kind": part.kind} | _part_table(part))
    given_tracks = {t.name: {"contact_frequency": f"{t.frequency!r} rad/s"} for t in machine.tracks if t.is_frequency_given}
    return table | ({"tracks": given_tracks} if given_tracks else {})


def _part_table(part: Part) -> Document:
    """The keys that were given, with numbers in SI."""
    return {key: value for key, value in _fields(part) if value is not None}


def _fields(table: BaseModel) -> Iterator[tuple[str, Any]]:
    for name, field in type(table).model_fields.items():
        if name in table.model_fields_set and not field.exclude:
            unit = unit_of(field)
            yield field.alias or name, _plain(getattr(table, name), "" if unit is None else unit.si, name)


def _plain(value: Any, unit: str, name: str) -> Any:
    """A value as a file has it: tables and lists of them, and frequencies, which need their unit, as text."""
    if isinstance(value, BaseModel):
        return {key: inner for key, inner in _fields(value) if inner is not None}
    if isinstance(value, list | tuple):
        return [_plain(one, unit, name) for one in value]
    return _setting(name, value, unit) if isinstance(value, float) else value


def _setting(path: str, value: float, unit: str) -> Any:
    return f"{value!r} {unit}" if path.endswith("frequency") and unit == "rad/s" else value


def _schedule_table(schedule: Schedule) -> Document:
    """The points of a schedule, and how it goes from one to the next."""
    pieces = schedule.pieces
    slopes = [row[1] for row in pieces.coefficients[1:-1]]
    cubic = any(row[2] or row[3] for row in pieces.coefficients)
    interpolation = "smooth" if cubic else "linear" if any(slopes) else "steps"
    points = [[time, float(pieces(time))] for time in pieces.breakpoints]
    return {"parameter": schedule.parameter, "points": points, "interpolation": interpolation}
