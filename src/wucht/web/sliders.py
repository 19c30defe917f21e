"""Controls of a page: which numbers of a machine can be moved, in which unit, between which limits."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from itertools import pairwise
from typing import Any

from pydantic.fields import FieldInfo

from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body, Drive, Load, Part
from wucht.machines.parts.roller import Roller
from wucht.machines.parts.track import TrackBody
from wucht.results.formatting import engineering_unit, units_in_print
from wucht.schema import Parameter, TableModel
from wucht.schema.checking import unit_of

_SLIDER_FACTOR, _SIGNED_SLIDER_FACTOR = 4.0, 3.0  # times the value: the end of a slider; of a quantity that may be negative
_HALF_TURN = math.pi
_OPEN_END_MARGIN = 1e-3  # of its length: so far from an end that is not allowed a slider begins
_CONTACT_KEYS = ("radius", "track_radius", "diameter", "length")  # of bodies on a track: where they touch follows from them
_WIDEST_RANGE = 1e4  # in SI: a slider between limits that are farther apart could not be set to a value
_POSITIVE = ("N/m", "N s/m", "N m s", "N m/rad")
_POSITION_KEYS = ("at", "position")
_SHAPE_FACTOR_OF_BALL = 0.4
# Of quantities that are zero and that no other of the machine compares with: the largest value of the slider, in SI.
_DEFAULT_TOPS = {
    "kg": 1.0,
    "m": 0.01,
    "m/s^2": 20.0,
    "kg m": 0.1,
    "kg m^2": 0.1,
    "N m s": 0.1,
    "N s/m": 100.0,
    "N/m": 1e4,
    "N m": 1.0,
}


@dataclass(frozen=True)
class Limits:
    """What a field allows: low <= value <= high, the low end itself only if it is not open; whole numbers only."""

    low: float = -math.inf
    high: float = math.inf
    is_open: bool = False
    is_whole: bool = False

    @classmethod
    def of(cls, field: FieldInfo) -> Limits:
        """The limits of a field of a table."""
        limits = {
            name: [float(x) for m in field.metadata if (x := getattr(m, name, None)) is not None]
            for name in ("gt", "ge", "lt", "le")
        }
        low = max([*limits["gt"], *limits["ge"]], default=-math.inf)
        high = min([*limits["lt"], *limits["le"]], default=math.inf)
        return cls(low, high, bool(limits["gt"]), str(field.title).startswith("number of"))


@dataclass(frozen=True)
class Control:
    """A number that can be moved, shown as (value in SI) / size in a unit.

    indices: of the parameters (of equal bodies, several). low, high: what is allowed, None where there is no limit; the low end
    itself is not allowed if it is open. bottom, top: of the slider, on a logarithmic scale or not.
    """

    name: str
    indices: tuple[int, ...]
    unit: str
    size: float
    low: float | None
    high: float | None
    open: bool
    whole: bool
    bottom: float
    top: float
    logarithmic: bool


def parameter_groups(machine: Machine, names: Sequence[str], file_keys: frozenset[str] | None = None) -> list[dict[str, Any]]:
    """Return the controls of a machine's parameters by part, the drives first; equal bodies have theirs in common.

    names: of the parameters of the equations, in order. Parameters that follow a schedule cannot be moved: ``over_time``.
    file_keys: keys of the file's machine, None for all; what follows from them cannot be moved, nor what a nameplate gives.
    """
    with_schedule = {s.parameter for s in machine.schedules}
    largest = _largest_by_unit(machine)
    groups: list[dict[str, Any]] = []
    for parts in _equal_parts(machine):
        tables = [dict(_fields(part, part.path)) for part in parts]
        controls = []
        for paths in zip(*tables, strict=True):
            field = tables[0][paths[0]]
            is_free = all(p in machine.parameters and p in names for p in paths) and not with_schedule & set(paths)
            if is_free and _is_movable(machine, parts[0], paths[0], field, file_keys):
                indices = tuple(names.index(p) for p in paths)
                controls.append(_control(machine.parameters[paths[0]], indices, Limits.of(field), largest))
        if controls:
            over_time = [_label(machine.parameters[path]) for path in tables[0] if path in with_schedule]
            groups.append({"title": _title(machine, parts), "controls": [asdict(c) for c in controls], "over_time": over_time})
    return groups


def derived_parameters(machine: Machine, names: Sequence[str], file_keys: frozenset[str] | None) -> list[int]:
    """Return the indices of numbers that follow from others in the file, and stay here; not those of nameplates."""
    fields = {path: field for p in machine.parts if not _has_nameplate(p, file_keys) for path, field in _fields(p, p.path)}
    of_parts = [p for p in machine.parameters if p in fields and _is_derived(machine, p, fields[p], file_keys)]
    tracks = [p for p in machine.parameters if p.endswith(".contact_frequency") and p not in (file_keys or machine.parameters)]
    return [names.index(path) for path in (*of_parts, *tracks) if path in names]


def _is_movable(machine: Machine, part: Part, path: str, field: FieldInfo, file_keys: frozenset[str] | None) -> bool:
    if isinstance(part, TrackBody) and part.track is not None and path.rpartition(".")[2] in _CONTACT_KEYS:
        return False
    if _has_nameplate(part, file_keys) and not path.startswith(f"{part.path}.transmission."):
        return False
    return not _is_derived(machine, path, field, file_keys)


def _has_nameplate(part: Part, file_keys: frozenset[str] | None) -> bool:
    return file_keys is not None and f"{part.path}.nameplate" in file_keys


def _is_derived(machine: Machine, path: str, field: FieldInfo, file_keys: frozenset[str] | None) -> bool:
    """True if the file neither gives a number nor leaves it at its default."""
    if file_keys is None or any(path == key or path.startswith(f"{key}.") for key in file_keys):
        return False
    return bool(machine.values[path] != field.default)


def _equal_parts(machine: Machine) -> list[list[Part]]:
    """Return the parts in the order in which a page shows them, bodies with equal numbers together."""
    order = {Drive: 0, Load: 1, Body: 2}
    parts = sorted(machine.parts, key=lambda p: next((k for kind, k in order.items() if isinstance(p, kind)), 3))
    together: list[list[Part]] = []
    for part in parts:
        alike = next((group for group in together if _are_alike(group[0], part)), None)
        if alike is None:
            together.append([part])
        else:
            alike.append(part)
    return together


def _are_alike(first: Part, second: Part) -> bool:
    if not (isinstance(first, Body) and isinstance(second, Body)) or first.kind != second.kind:
        return False
    if "about" not in type(first).model_fields:  # rotors differ in what they drive, even where their numbers are equal
        return False
    names = {"name", "start", "angle"}
    return first.model_dump(exclude=names) == second.model_dump(exclude=names)


def _title(machine: Machine, parts: Sequence[Part]) -> str:
    part = parts[0]
    if isinstance(part, Body):
        names = [p.name for p in parts if isinstance(p, Body)]
        noun = (
            "ball" if isinstance(part, Roller) and part.shape_factor == _SHAPE_FACTOR_OF_BALL else part.kind.replace("-", " ")
        )
        return f"{noun} {names[0]}" if len(names) == 1 else f"{noun}s {_list_of_names(machine, names)} (identical)"
    if isinstance(part, Drive | Load):
        return f"{'motor' if isinstance(part, Drive) else part.group} of {part.on}"
    return part.path.replace("s.", " ", 1) or "machine"


def _list_of_names(machine: Machine, names: Sequence[str]) -> str:
    """Return the names of several bodies as text; of many that follow each other in the machine the first and the last."""
    *before, last = names
    order = [b.name for b in machine.bodies]
    begin = order.index(names[0]) if names[0] in order else 0
    if len(names) > 2 and order[begin : begin + len(names)] == list(names):
        return f"{names[0]} to {last}"
    return f"{', '.join(before)} and {last}"


def _fields(table: TableModel, path: str) -> Iterator[tuple[str, FieldInfo]]:
    """Yield the path and field of each number of a part, as ``TableModel.parameters_at`` names them."""
    for name, field in type(table).model_fields.items():
        value, key = getattr(table, name), f"{path}.{field.alias or name}".removeprefix(".")
        if isinstance(value, TableModel):
            yield from _fields(value, key)
        elif unit_of(field) is None:
            for i, inner in enumerate(value if isinstance(value, tuple) else (), 1):
                yield from _fields(inner, f"{key}.{i}") if isinstance(inner, TableModel) else ()
        elif isinstance(value, tuple):
            yield from ((f"{key}.{direction}", field) for direction in "xy")
        elif value is not None:
            yield key, field


def _largest_by_unit(machine: Machine) -> dict[str, float]:
    largest: dict[str, float] = {}
    for p in machine.parameters.values():
        largest[p.unit] = max(largest.get(p.unit, 0.0), abs(p.value))
    return largest


def _control(p: Parameter, indices: tuple[int, ...], limits: Limits, largest: Mapping[str, float]) -> Control:
    bottom, top, logarithmic = slider_range(p.value, p.unit, limits, largest)
    unit, size = engineering_unit(p.value or top, p.unit)
    return Control(
        _label(p), indices, units_in_print(unit), size,
        limits.low if math.isfinite(limits.low) else None, limits.high if math.isfinite(limits.high) else None,
        limits.is_open, limits.is_whole, bottom, top, logarithmic,
    )  # fmt: skip


def _label(p: Parameter) -> str:
    """Return the name of a parameter within its part: with the number of the table that has it, and its direction."""
    *owners, end = p.path.split(".")
    number = next((f"{table.removesuffix('s')} {k}: " for table, k in pairwise(owners) if k.isdigit()), "")
    if not owners or end not in ("x", "y"):
        return f"{number}{p.long_name}"
    return f"{number}{end} position" if owners[-1] in _POSITION_KEYS else f"{number}{p.long_name} in {end}"


def slider_range(value: float, unit: str, limits: Limits, largest: Mapping[str, float]) -> tuple[float, float, bool]:
    """Return the ends of a slider in SI, and whether its scale is logarithmic: where a positive value has no upper limit."""
    size = abs(value) or largest.get(unit, 0.0) or _DEFAULT_TOPS.get(unit, 1.0)
    if unit in _POSITIVE and not limits.low > 0:  # a negative one is allowed, and means little
        limits = replace(limits, low=0.0)
    if limits.is_whole:
        low, high = max(limits.low, 1.0), max(_SLIDER_FACTOR * size, 8.0)
    elif unit == "rad" and not math.isfinite(limits.low):
        low, high = -_HALF_TURN, _HALF_TURN
    elif limits.high - limits.low < _WIDEST_RANGE:
        low, high = limits.low, limits.high
    elif value > 0 and limits.low >= 0:
        return max(value / _SLIDER_FACTOR, limits.low), min(value * _SLIDER_FACTOR, limits.high), True
    elif limits.low >= 0:
        low, high = limits.low, size
    elif unit == "m" or (value == 0 and unit != "m/s^2"):
        low, high = -_SIGNED_SLIDER_FACTOR * size, _SIGNED_SLIDER_FACTOR * size
    else:
        low, high = sorted((0.0, math.copysign(_SIGNED_SLIDER_FACTOR * size if value else size, value)))
    high = min(high, limits.high)
    return low + (_OPEN_END_MARGIN * (high - low) if limits.is_open and low == limits.low else 0.0), high, False
