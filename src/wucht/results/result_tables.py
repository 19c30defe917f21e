"""Tables of a result: variables over the same values, lists of tables in its summary, and its single numbers.

Variables over the same values (time, a parameter, both parameters of a map) are the columns of one table, named by its
dimensions: ``time``, ``drum.speed-carrier.stiffness``. Variables of several bodies or directions have a column for each that
has values. A list of tables in the summary is a table under its key: ``orbits``. All else is a row of the table ``numbers``.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from itertools import product
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.errors import InputError, nearest

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

NUMBERS = "numbers"
_TEXT = "OSU"  # kinds of NumPy


@dataclass(frozen=True, eq=False)
class TableColumn:
    """A column of a table. values (N,): missing numbers are NaN; texts, and values of several types, are objects."""

    name: str
    values: np.ndarray
    unit: str = ""

    @property
    def heading(self) -> str:
        """Name and unit, such as ``speed drum [rad/s]``."""
        return f"{self.name} [{self.unit}]" if self.unit else self.name


def table_frame(columns: Sequence[TableColumn]) -> pd.DataFrame:
    """Return a table as a DataFrame, whose ``attrs["units"]`` has the unit of each column by its heading."""
    import pandas as pd_

    frame = pd_.DataFrame({column.heading: column.values for column in columns})
    frame.attrs["units"] = {column.heading: column.unit for column in columns}
    return frame


def table_names(result: xr.Dataset) -> list[str]:
    """Return the names of all tables of a result: of its variables, of its summary, and ``numbers``."""
    return [*map("-".join, _variables_by_rows(result)), *_summary_keys(result), NUMBERS]


def result_table(result: xr.Dataset, name: str) -> tuple[TableColumn, ...]:
    """Return the columns of the table of this name: at least one, with different headings, all of one length.

    Raises ``InputError`` where the result has none.
    """
    if name == NUMBERS:
        return _numbers_table(result)
    for rows, variables in _variables_by_rows(result).items():
        if name == "-".join(rows):
            return _unique_columns(_variable_columns(result, rows, variables))
    key = _summary_keys(result).get(name)
    if key is None:
        raise InputError("table", name, f"the result has no such table; {nearest(name, table_names(result))}")
    return _summary_table(result, key)


def _variables_by_rows(result: xr.Dataset) -> dict[tuple[str, ...], list[str]]:
    """The variables of each table by the dimensions of its rows, coordinates first; without those of single numbers."""
    variables: dict[tuple[str, ...], list[str]] = {}
    for name in [*result.data_vars, *(c for c in result.coords if not _is_scale(result, str(c)))]:
        if rows := _row_dimensions(result, tuple(map(str, result[name].dims))):
            variables.setdefault(rows, []).append(str(name))
    return {rows: sorted(names, key=lambda name: name not in result.coords) for rows, names in variables.items()}


def _row_dimensions(result: xr.Dataset, dims: tuple[str, ...]) -> tuple[str, ...]:
    """The dimensions of a table's rows: not those of names, unless there are no others."""
    return tuple(d for d in dims if not (_is_scale(result, d) and result[d].dtype.kind in _TEXT)) or dims


def _is_scale(result: xr.Dataset, name: str) -> bool:
    """True if the name is that of a coordinate of its dimension: other variables may have it too."""
    return name in result.coords and result[name].dims == (name,)


def _variable_columns(result: xr.Dataset, rows: tuple[str, ...], names: Sequence[str]) -> Iterator[TableColumn]:
    """Yield the columns of variables over the same dimensions, those of the dimensions first."""
    shape = tuple(result.sizes[d] for d in rows)
    for dim, index in zip(rows, np.indices(shape), strict=True):
        if _is_scale(result, dim):
            yield TableColumn(dim, _decode_texts(result[dim].values[index].ravel()), _unit(result, dim))
        elif len(rows) > 1:
            yield TableColumn(f"{dim} index" if dim in result.variables else dim, index.ravel())
    for name in names:
        variable = result[name].transpose(*rows, ...)
        labels = [" ".join(map(str, label)) for label in product(*(result[d].values for d in variable.dims[len(rows) :]))]
        values = variable.values.reshape(int(np.prod(shape)), len(labels))
        for k, label in enumerate(labels):
            if _has_values(values[:, k], label):
                yield TableColumn(f"{name} {label}" if label else name, _decode_texts(values[:, k]), _unit(result, name))


def _has_values(values: np.ndarray, label: str) -> bool:
    """True if a column has values: a body that turns about no other has no phase, and its column is left out."""
    return not label or values.dtype.kind != "f" or bool(np.isfinite(values).any())


def _unit(result: xr.Dataset, name: str) -> str:
    return str(result[name].attrs.get("units", ""))


def _decode_texts(values: np.ndarray) -> np.ndarray:
    """Texts as objects, which a file may have as bytes."""
    if values.dtype.kind not in _TEXT:
        return values
    return np.array([v.decode("utf-8", "replace") if isinstance(v, bytes) else v for v in values.tolist()], object)


def _summary_keys(result: xr.Dataset) -> dict[str, str]:
    """The keys of the summary that hold a list of tables, by the name of its table: another than those of the variables."""
    accessor, variable_tables = result.wucht, {NUMBERS, *map("-".join, _variables_by_rows(result))}
    keys = [key for key, value in accessor.summary.items() if is_list_of_tables(value, accessor.quantities.get(key, {}))]
    return {f"{key}-summary" if key in variable_tables else key: key for key in keys}


def is_list_of_tables(value: Any, facts: Mapping[str, Any]) -> bool:
    """True for a list of tables; an empty list is one if the facts about it name columns."""
    return isinstance(value, list) and all(isinstance(row, Mapping) for row in value) and bool(any(value) or facts.get("parts"))


def _summary_table(result: xr.Dataset, key: str) -> tuple[TableColumn, ...]:
    """The entries of a list in the summary as rows; what is a table or a list itself has a column for each of its numbers."""
    accessor = result.wucht
    rows = [dict(leaves(row)) if row else {} for row in accessor.summary[key]]
    paths = dict.fromkeys(path for row in rows for path in row) or dict.fromkeys(accessor.quantities[key]["parts"])
    columns = (TableColumn(p, column_values([r.get(p) for r in rows]), accessor.unit_at(f"{key}.{p}")) for p in paths)
    return _unique_columns(columns)


def _unique_columns(columns: Iterable[TableColumn]) -> tuple[TableColumn, ...]:
    """Columns with different headings: of two with the same one, the last."""
    return tuple({column.heading: column for column in columns}.values())


def leaves(value: Any, path: str = "") -> Iterator[tuple[str, Any]]:
    """Yield the numbers and texts of a value of the summary by path, such as ``laws.exponents[0]``; empty ones are None."""
    if isinstance(value, Mapping) and value:
        for key, inner in value.items():
            yield from leaves(inner, f"{path}.{key}" if path else str(key))
    elif isinstance(value, list) and value:
        for k, inner in enumerate(value):
            yield from leaves(inner, f"{path}[{k}]")
    else:
        yield path, None if isinstance(value, Mapping | list) else value


def column_values(cells: Sequence[Any]) -> np.ndarray:
    """Return the cells of a column as an array (N,): of numbers where all are numbers or None, of bool, else of objects."""
    kinds = {type(cell) for cell in cells}
    if kinds in ({bool}, {int}):
        return np.array(cells)
    return np.array(cells, float) if kinds <= {int, float, type(None)} else objects(cells)


def _numbers_table(result: xr.Dataset) -> tuple[TableColumn, ...]:
    """Name, value, unit and description of every number of the summary, and of the variables that are single numbers."""
    accessor, rows = result.wucht, dict[str, tuple[Any, str, str]]()
    table_by_key = {key: name for name, key in _summary_keys(result).items()}
    for key, value in accessor.summary.items():
        if key in table_by_key:
            description = f"{accessor.description_at(key) or key}: number of rows of the table {table_by_key[key]}"
            rows[key] = len(value), "", description
        else:
            rows |= {path: (leaf, accessor.unit_at(path), accessor.description_at(path)) for path, leaf in leaves(value, key)}
    for name, variable in result.variables.items():
        if not variable.dims and rows.get(str(name), (None,))[0] is None:
            value = _decode_texts(variable.values[None]).tolist()[0]
            rows[str(name)] = value, _unit(result, str(name)), str(variable.attrs.get("long_name", ""))
    columns = {"name": list(rows)} | {
        name: [row[k] for row in rows.values()] for k, name in enumerate(("value", "unit", "description"))
    }
    return tuple(TableColumn(name, objects(cells)) for name, cells in columns.items())


def objects(cells: Sequence[Any]) -> np.ndarray:
    """Return the cells of a column of several types as an array (N,) of objects."""
    values = np.empty(len(cells), object)
    values[:] = cells
    return values
