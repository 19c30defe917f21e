"""Quantities of a result, each stated once.

A study gives its result as quantities. The variables of the Dataset with their names and units, the keys of ``summary.json``,
the units of their numbers in comparisons, tables and reports, and the pages of the docs follow from them.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.errors import WuchtError

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True, eq=False)
class Quantity:
    """A quantity of a result.

    Parameters
    ----------
    name : str
        Name of the variable, and of the key in the summary.
    value : array, number, text, list or mapping
        None if there is none; as a variable that is not a number.
    long_name : str
        Its name in words, a noun phrase.
    unit : str
        SI; empty for a ratio, a count or a word. In the summary the unit of all numbers of a list or a table.
    dimensions : str, optional
        Dimensions of the variable, separated by blanks; empty for a single number. None: a key of the summary only.
    in_summary : bool
        True if a variable is a key of the summary, too.
    headline : bool or list of str
        True if it is among the main numbers of a comparison of results; of a table, the names of those numbers.
    parts : mapping
        Of a table in the summary, or a list of such: name in words and unit of each of its keys.
    coordinate : bool
        True if a variable is a coordinate. One with the name of its dimension always is.
    attributes : mapping
        Further attributes of the variable.
    """

    name: str
    value: Any
    long_name: str
    unit: str = ""
    dimensions: str | None = None
    in_summary: bool = False
    headline: bool | Sequence[str] = False
    parts: Mapping[str, tuple[str, str]] = field(default_factory=dict)
    coordinate: bool = False
    attributes: Mapping[str, Any] = field(default_factory=dict)

    @property
    def variable(self) -> tuple[tuple[str, ...], np.ndarray, dict[str, Any]]:
        """Dimensions, values and attributes of the variable of a Dataset."""
        values = np.asarray(np.nan if self.value is None else self.value)
        attributes = {"long_name": self.long_name, "units": self.unit, **self.attributes}
        return tuple((self.dimensions or "").split()), values, attributes

    @property
    def facts(self) -> dict[str, Any]:
        """Facts about a key of the summary beside its value, as JSON has them, without empty ones."""
        parts = {name: {"what": long_name} | ({"unit": unit} if unit else {}) for name, (long_name, unit) in self.parts.items()}
        facts = {"what": self.long_name, "unit": self.unit, "headline": self.headline, "parts": parts}
        return {name: fact for name, fact in facts.items() if fact}


def table(
    name: str,
    rows: Sequence[Mapping[str, Any]],
    long_name: str,
    parts: Mapping[str, tuple[str, str]],
    dimension: str = "",
    columns: Mapping[str, type] | None = None,
) -> list[Quantity]:
    """Quantities of a list of tables in the summary, some of whose columns are variables of the Dataset as well.

    Parameters
    ----------
    name, long_name
        Of the key in the summary, see ``Quantity``.
    rows : sequence of mappings
        The tables.
    parts : mapping
        Name in words and unit of each key of a table. For other keys readers of the result know neither.
    dimension : str
        Dimension of the variables, whose names begin with it: ``point_speed``.
    columns : mapping, optional
        The parts that are variables, and their types: ``float`` (None is not a number), ``str``, ``np.int8`` (flags).
    """
    quantities = [Quantity(name, [dict(row) for row in rows], long_name, parts=parts)]
    for part, kind in (columns or {}).items():
        column_is, unit = parts[part]
        quantities.append(
            Quantity(f"{dimension}_{part}", np.array([row[part] for row in rows], kind), column_is, unit, dimension)
        )
    return quantities


def group(name: str, quantities: Sequence[Quantity], long_name: str) -> Quantity:
    """A table in the summary, each of whose keys is a quantity; keys that are tables themselves contribute their parts.

    Raises ``WuchtError`` for equal names.
    """
    quantities = list(quantities_by_name(quantities).values())
    within = {part: facts for quantity in quantities for part, facts in quantity.parts.items()}
    parts = within | {quantity.name: (quantity.long_name, quantity.unit) for quantity in quantities}
    return Quantity(name, {quantity.name: quantity.value for quantity in quantities}, long_name, parts=parts)


def dataset_from_quantities(quantities: Iterable[Quantity]) -> xr.Dataset:
    """Build a Dataset of the quantities that have dimensions, without attributes. Raises ``WuchtError`` for equal names."""
    import xarray as xr_

    variables = quantities_by_name(q for q in quantities if q.dimensions is not None)
    coordinates = {name: q.variable for name, q in variables.items() if q.coordinate or q.dimensions == name}
    return xr_.Dataset({name: q.variable for name, q in variables.items() if name not in coordinates}, coords=coordinates)


def quantities_by_name(quantities: Iterable[Quantity]) -> dict[str, Quantity]:
    """Return quantities by their names. Raises ``WuchtError`` for equal names."""
    index: dict[str, Quantity] = {}
    for quantity in quantities:
        if index.setdefault(quantity.name, quantity) is not quantity:
            raise WuchtError(f"a result has two quantities with the name {quantity.name!r}", code="taken")
    return index
