"""Parameters that studies vary, of a machine or of user equations: looked up by path, read in their unit, checked."""

from __future__ import annotations

from collections.abc import Sequence

from wucht.errors import InputError, nearest
from wucht.machines.subject import Subject
from wucht.schema import Parameter, Unit, read_quantity

Value = float | str  # in the unit of a parameter of the subject


def parameter_of(subject: Subject, path: str, key: str = "along") -> Parameter:
    """Return the parameter of a path. Raises ``InputError`` at ``study.<key>`` if there is none, or it follows a schedule."""
    if path not in subject.parameters:
        raise InputError(
            f"study.{key}", path, f"unknown parameter; {nearest(path, subject.parameters)}", code="unknown-parameter"
        )
    if any(s.parameter == path for s in subject.schedules):
        raise InputError(f"study.{key}", path, "not allowed: this parameter follows a schedule", code="scheduled")
    return subject.parameters[path]


def values_of(subject: Subject, along: Parameter, entries: Sequence[Value], key: str = "values") -> tuple[float, ...]:
    """Return values of a parameter in SI units. Raises ``InputError`` at ``study.<key>[i]`` for one that is not allowed."""
    unit, values = Unit(along.unit, along.long_name), []
    for i, value in enumerate(entries):
        values.append(read_quantity(unit, value, f"study.{key}[{i}]"))
        subject.check_values({along.path: values[-1]}, f"study.{key}[{i}]")
    return tuple(values)


def checked_range(subject: Subject, along: Parameter, pair: Sequence[Value], key: str = "range") -> tuple[float, float]:
    """Return low and high of a range of a parameter, in SI, both allowed by the machine.

    Raises ``InputError`` as ``range_of``, and at ``study.<key>[i]`` for an end that is not allowed.
    """
    ends = range_of(Unit(along.unit, along.long_name), pair, key)
    for i, value in enumerate(ends):
        subject.check_values({along.path: value}, f"study.{key}[{i}]")
    return ends


def range_of(unit: Unit, pair: Sequence[Value], key: str = "range") -> tuple[float, float]:
    """Return a pair [low, high] in SI units. Raises ``InputError`` where low is not below high."""
    low, high = (read_quantity(unit, value, f"study.{key}[{i}]") for i, value in enumerate(pair))
    if not low < high:
        raise InputError(f"study.{key}", list(pair), "must be a pair [low, high] with low below high")
    return low, high
