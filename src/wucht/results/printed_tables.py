"""Tables of a result for people: its answers, and its course over time on few rows, in the units in which engineers write."""

from __future__ import annotations

import math
import re
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.formatting import engineering_unit
from wucht.results.result_tables import TableColumn, is_list_of_tables, leaves, objects, result_table, table_names

if TYPE_CHECKING:
    import xarray as xr

TIME = "time"
MOST_TIMES = 500  # rows of the course over time
_DIGITS = 6
_NUMBERS = "fiub"  # kinds of NumPy
_TURN = 360.0  # degrees
_OF_ROTATION = re.compile(r"\(r: ([\w/]+)\)")  # in the name of a variable over directions: its unit in the direction r
_ROTATION_UNITS = {"moment": "N m"}


def answers_table(result: xr.Dataset) -> tuple[TableColumn, ...]:
    """Return the single numbers and texts of the summary: name in words, value, unit as it is printed, and key."""
    accessor = result.wucht
    rows = list[tuple[str, Any, str, str]]()
    for key, value in accessor.summary.items():
        if is_list_of_tables(value, accessor.quantities.get(key, {})):
            continue
        for path, leaf in leaves(value, key):
            what = accessor.description_at(path) or path
            name = what if path == key or path.startswith(f"{key}[") else f"{what}: {path.removeprefix(f'{key}.')}"
            printed_value, unit = _printed_number(leaf, accessor.unit_at(path), "phase" in what)
            if leaf is not None:
                rows.append((name, printed_value, unit, path))
    columns = ("name", "value", "unit", "key")
    return tuple(TableColumn(name, objects([row[k] for row in rows])) for k, name in enumerate(columns))


def time_table(result: xr.Dataset, most: int = MOST_TIMES) -> tuple[TableColumn, ...] | None:
    """Return the course over time: with more samples than ``most``, mean, least and largest value over equal intervals.

    Parameters
    ----------
    result : xarray.Dataset
    most : int
        Largest number of rows.

    Returns
    -------
    tuple of TableColumn, or None
        None where the result has no table over time. A mean is weighted with the time for which each sample stands. A phase
        turns on over 360 degrees within an interval; its mean is between 0 and 360.
    """
    if TIME not in table_names(result):
        return None
    table = result_table(result, TIME)
    time = next((column for column in table if column.name == TIME), None)
    if time is None or len(time.values) < 1:
        return table
    series = [column for column in table if column is not time]
    if len(time.values) <= most:
        return time, *(one for column in series for one in _column(result, column, column.values[:, None], ("",)))
    intervals = _intervals(time.values, most)
    times = _means_and_limits(time.values, time.values, intervals)
    columns = [TableColumn("time, mean", times[:, 0], time.unit)]
    for column in (column for column in series if column.values.dtype.kind in _NUMBERS):
        values = column.values.astype(float)
        values = _continuous_phases(values) if _is_phase(column) else values
        numbers = _means_and_limits(values, time.values, intervals)
        columns += _column(result, column, numbers, (", mean", ", least", ", largest"))
    return tuple(columns)


def _intervals(time: np.ndarray, most: int) -> np.ndarray:
    """The interval of each sample (N,), of so many equally long ones; numbers of those that have samples only, from 0."""
    edges = np.linspace(time[0], time[-1], most + 1)[1:-1]
    return np.unique(np.searchsorted(edges, time, side="right"), return_inverse=True)[1]


def _means_and_limits(values: np.ndarray, time: np.ndarray, intervals: np.ndarray) -> np.ndarray:
    """Mean, least and largest of the finite values in each interval (M, 3); not a number where there are none."""
    steps = np.diff(time)
    weights = np.maximum((np.r_[steps, 0.0] + np.r_[0.0, steps]) / 2, np.finfo(float).tiny)  # samples at one time: a jump
    is_known, count = np.isfinite(values), intervals[-1] + 1
    weights, known_values = np.where(is_known, weights, 0.0), np.where(is_known, values, 0.0)
    total = np.bincount(intervals, weights, count)
    sums = np.bincount(intervals, weights * known_values, count)
    starts = np.flatnonzero(np.diff(intervals, prepend=-1))
    has_values = np.add.reduceat(is_known, starts) > 0
    least = np.minimum.reduceat(np.where(is_known, values, np.inf), starts)
    largest = np.maximum.reduceat(np.where(is_known, values, -np.inf), starts)
    mean = np.divide(sums, total, out=np.full(count, np.nan), where=has_values)
    limits = np.where(has_values[:, None], np.column_stack([least, largest]), np.nan)
    return np.column_stack([mean, limits])


def _continuous_phases(phases: np.ndarray) -> np.ndarray:
    """Phases without jumps by a turn; not a number where one is not known."""
    is_known, whole = np.isfinite(phases), phases.copy()
    whole[is_known] = np.unwrap(phases[is_known])
    return whole


def _is_phase(column: TableColumn) -> bool:
    return column.unit == "rad" and "phase" in column.name


def _column(result: xr.Dataset, column: TableColumn, values: np.ndarray, endings: tuple[str, ...]) -> list[TableColumn]:
    """Columns (N,) of a series in the unit in which its largest value is printed. values (N, K): a column for each ending."""
    if column.values.dtype.kind not in _NUMBERS:
        return [column]
    unit, numbers = _unit(result, column), values.astype(float)
    finite = np.abs(numbers[np.isfinite(numbers)])
    if not result.wucht.dimensionless or unit == "rad":
        unit, size = engineering_unit(float(finite.max(initial=0.0)), unit)
        unit, numbers = _plain_unit(unit), numbers / size
    if _is_phase(column):
        with np.errstate(invalid="ignore"):
            numbers = numbers - _TURN * np.floor(numbers[:, :1] / _TURN)
    return [TableColumn(f"{column.name}{ending}", numbers[:, k], unit) for k, ending in enumerate(endings)]


def _unit(result: xr.Dataset, column: TableColumn) -> str:
    """The SI unit of a series: of one in the direction r another than in x and y, as the name of its variable says."""
    name, _, label = column.name.partition(" ")
    words = str(result[name].attrs.get("long_name", "")) if name in result.variables else ""
    of_rotation = _OF_ROTATION.search(words) if label == "r" else None
    return column.unit if of_rotation is None else _ROTATION_UNITS.get(of_rotation[1], of_rotation[1])


def _printed_number(value: Any, unit: str, is_phase: bool) -> tuple[Any, str]:
    """A number in the unit in which it is printed, rounded as there; a phase between 0 and 360 degrees."""
    if isinstance(value, bool) or not isinstance(value, int | float) or not math.isfinite(value):
        return value, unit
    name, size = engineering_unit(value, unit)
    number = value / size
    number = number % _TURN if is_phase and unit == "rad" else number
    return (value if isinstance(value, int) and size == 1 else float(f"{number:.{_DIGITS}g}")), _plain_unit(name)


def _plain_unit(unit: str) -> str:
    return {"°": "deg"}.get(unit, unit)
