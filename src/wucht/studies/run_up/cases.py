"""Many runs asked for at once: from several starts, or with several values of a parameter."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.quantities import Unit
from wucht.studies.keys import allowed_value, parameter, quantity

MOST_CASES = 500


def read_cases(
    table: Mapping[str, Any], machine: Machine
) -> tuple[tuple[Mapping[str, Any], ...], str | None, tuple[float, ...]]:
    """``starts``, ``along`` and ``values`` of the table ``[study]``. Raises ``InputError``."""
    starts, values = table.get("starts", []), table.get("values", [])
    if not isinstance(starts, list) or not all(isinstance(s, Mapping) for s in starts):
        raise InputError("study.starts", starts, "allowed is a list of tables: starts = [{ BODY = ANGLE }, ...]")
    if starts and table.get("start"):
        raise InputError("study.starts", None, "allowed is either start or starts")
    if not isinstance(values, list):
        raise InputError("study.values", values, "allowed is a list of values of the parameter that along names")
    if bool(values) != ("along" in table):
        missing = "values" if "along" in table else "along"
        raise InputError(f"study.{missing}", None, "this key is missing; along = PATH and values = [...] belong together")
    if len(starts or [0]) * len(values or [0]) > MOST_CASES:
        raise InputError("study.values", len(values), f"allowed are {MOST_CASES} runs at most, starts times values")
    if not values:
        return tuple(dict(s) for s in starts), None, ()
    path = parameter(table, "along", machine)
    unit = Unit(path.unit, path.what)
    read = [quantity({f"values[{i}]": v}, f"values[{i}]", unit) for i, v in enumerate(values)]
    found = tuple(v for v in read if v is not None)
    for i, value in enumerate(found):
        allowed_value(machine, path.path, value, f"study.values[{i}]")
    return tuple(dict(s) for s in starts), path.path, found
