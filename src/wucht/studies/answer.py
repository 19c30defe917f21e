"""The answer of a study: its numbers, curves and tables, and the lines and sentences in which people read it.

A number is stated once, with the line that shows it beside it. The Dataset, the summary with the units of its numbers, the
report, tables, CSV files and the pages of the docs follow from the answer.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager
from copy import copy
from typing import TYPE_CHECKING, Any, Self, TypeVar

import numpy as np

from wucht.machines.structure import Units
from wucht.results.accessor import register_accessor
from wucht.results.formatting import number_text
from wucht.results.quantities import Quantity, dataset_from_quantities, group, quantities_by_name
from wucht.results.report import MOST_LINES
from wucht.results.store import to_json

if TYPE_CHECKING:
    import xarray as xr

T = TypeVar("T")
Column = tuple[Any, ...]  # values, name in words, unit
Line = tuple[str | None, str, dict[str, str]]  # heading, text, texts for its fields

_LAST_LINES = 40  # of a report that is too long: on the whole, after a line for each run


class Answer:
    """The answer of a study, as far as it is known.

    A unit is SI, or a kind of quantity, ``time``, ``length``, ``torque``, ``power``, ``energy``, ``force`` or ``speed``, whose
    unit is that of the subject, and empty where that has none; ``1/time`` likewise. A ratio, a count or a word has none.

    Parameters
    ----------
    units : Units, optional
        Units of the subject, ``machine.units``; by default SI.
    fill : callable, optional
        Called with the answer once it is needed, and states it: of the answers after each leg of a run most never are.

    Attributes
    ----------
    sentence : str
        The answer in one sentence.
    verdict : str, optional
        What the report says in its place; empty: nothing.
    failure : str, optional
        Reason why the answer is not complete.
    """

    def __init__(self, units: Units | None = None, fill: Callable[[Answer], object] | None = None) -> None:
        self.sentence = ""
        self.verdict: str | None = None
        self.failure: str | None = None
        self._units = units or Units()
        self._fill = fill
        self._quantities: list[Quantity] = []
        self._path = ""
        self._lines: list[Line] = []
        self._warnings: list[str] = []
        self._assumptions: list[str] = []
        self._attributes: dict[str, Any] = {}

    def number(self, name: str, value: T, what: str, unit: str = "", **facts: Any) -> T:
        """State a number of the summary, and return it.

        Parameters
        ----------
        name : str
            Its key.
        value : number, text, list or mapping
            None if there is none.
        what : str
            Its name in words, a noun phrase.
        unit : str
            Of a list or a table that of all its numbers.
        facts
            ``headline``: true if it is among the main numbers of a comparison, of a table their names; ``parts``: of a table,
            or a list of such, name in words and unit of each of its keys.
        """
        self._quantities.append(Quantity(name, value, what, self.unit(unit), **facts))
        return value

    def curve(self, name: str, values: Any, what: str, unit: str = "", over: str | None = None, **facts: Any) -> None:
        """State a variable of the Dataset.

        Parameters
        ----------
        name, what, unit
            As of ``number``.
        values : array, list or number
        over : str, optional
            Its dimensions, separated by blanks; empty for a single number; by default it is a coordinate over itself.
        facts
            ``coordinate``, true of a coordinate over another dimension; ``in_summary``, true of a key of the summary as well;
            ``attributes``, further attributes of the variable; ``headline`` and ``parts`` as of ``number``.
        """
        self._quantities.append(Quantity(name, values, what, self.unit(unit), name if over is None else over, **facts))

    def table(
        self,
        name: str,
        what: str,
        /,
        over: str = "",
        kinds: Mapping[str, type] | None = None,
        headline: Sequence[str] = (),
        **columns: Column,
    ) -> None:
        """State a list of tables of the summary, whose columns may be variables of the Dataset as well.

        Parameters
        ----------
        name, what
            As of ``number``.
        over : str, optional
            Dimension of the variables, whose names begin with it: the column ``speed`` over ``point`` is ``point_speed``.
        kinds : mapping, optional
            The columns that are variables, in their order, and their types: ``float`` (None is not a number), ``str``,
            ``np.int8`` (flags). By default all, with the types of their values.
        headline : sequence of str
            Columns that are among the main numbers of a comparison.
        columns
            Values, name in words and unit of each column. One that is empty beside others is not in the rows: it is only
            described.
        """
        self.table_of(name, what, columns, over, kinds, headline)

    def table_of(
        self,
        name: str,
        what: str,
        columns: Mapping[str, Column],
        over: str = "",
        kinds: Mapping[str, type] | None = None,
        headline: Sequence[str] = (),
        optional: Sequence[str] = (),
    ) -> None:
        """State a list of tables, the names of whose columns users choose, such as the path of a parameter.

        Parameters
        ----------
        name, what, columns, over, kinds, headline
            As of ``table``.
        optional : sequence of str
            Columns that a row lacks where their value is None.
        """
        plain = {name: v.tolist() if isinstance(v, np.ndarray) else list(v) for name, (v, *_) in columns.items() if len(v)}
        rows = [
            {column: value for column, value in zip(plain, row, strict=True) if value is not None or column not in optional}
            for row in zip(*plain.values(), strict=True)
        ]
        parts = {column: (words, self.unit(*unit)) for column, (_, words, *unit) in columns.items()}
        self._quantities.append(Quantity(name, rows, what, parts=parts, headline=headline or False))
        for column in (columns if kinds is None else kinds) if over else ():
            values, words, *unit = columns[column]
            of_kind = np.asarray(values) if kinds is None else np.array(plain.get(column, []), kinds[column])
            self.curve(f"{over}_{column}", of_kind, words, "".join(unit), over)

    @contextmanager
    def group(self, name: str, what: str) -> Iterator[None]:
        """State a table of the summary: within it the numbers are its keys, and the fields of lines are these numbers."""
        quantities, path = self._quantities, self._path
        self._quantities, self._path = [], f"{path}.{name}".strip(".")
        try:
            yield
            quantities.append(group(name, self._quantities, what))
        finally:
            self._quantities, self._path = quantities, path

    def add(self, quantities: Iterable[Quantity]) -> None:
        """State quantities that several studies share."""
        self._quantities += quantities

    def line(self, heading: str | None, text: str, at: str = "", **texts: str) -> None:
        """Add a line to the report. It is left out if one of its numbers is None.

        Parameters
        ----------
        heading : str, optional
            Text in the column beside it. None: the line itself is a heading, of those that follow.
        text : str
            With fields: ``{breakdown.speed}``, a number of the summary by its path, with its unit; ``{jumps[0].speed}``, of a
            list; ``{slip:%}``, a share in percent; ``{turns:.3g}``, with a format, ``.Ng``, ``.Nf``, ``.Ne``, and ``%`` after
            them. Numbers of a table are listed with their names.
        at : str, optional
            Path before those of the fields, such as ``jumps[0]``; of a list that is stated, ``jumps``, a line for each item.
        texts
            Texts for fields of these names.
        """
        items = next((q.value for q in self._quantities if q.name == at and isinstance(q.value, list)), None)
        for path in [at] if items is None else [f"{at}[{k}]" for k in range(len(items))]:
            within = ".".join(filter(None, (self._path, path)))
            self._lines.append((heading, _at_path(text, within, texts) if within else text, texts))

    def warn(self, *sentences: str) -> None:
        """Add doubts."""
        self._warnings += sentences

    def assume(self, *statements: str) -> None:
        """Add assumptions, beside those that all studies of these equations make."""
        self._assumptions += statements

    def attribute(self, **attributes: Any) -> None:
        """Add attributes of the Dataset: texts and numbers."""
        self._attributes |= attributes

    def unit(self, unit: str = "") -> str:
        """Return the unit of a kind of quantity, ``time`` or ``1/time``; any other text is a unit itself."""
        kind = unit.removeprefix("1/")
        if not hasattr(self._units, kind):
            return unit
        subject_unit: str = getattr(self._units, kind)
        return unit.replace(kind, subject_unit) if subject_unit else ""

    def number_in_words(self, value: float | None, unit: str = "") -> str:
        """Return a number as lines print it, for a sentence: with the subject's unit of its kind, ``none`` without a value."""
        if value is None or not math.isfinite(value):
            return "none"
        return str(number_text(value, self.unit(unit), "", not self._units.speed))

    def fill(self) -> Self:
        """State what is not stated yet, and return the answer: for a study that joins or compares several."""
        if self._fill is not None:
            before = {name: copy(fact) if isinstance(fact, list | dict) else fact for name, fact in vars(self).items()}
            fill, self._fill = self._fill, None
            try:
                fill(self)
            except BaseException:  # also Ctrl-C: what is stated by half is stated anew where it is needed next
                vars(self).update(before)
                raise
        return self

    @property
    def quantities(self) -> Sequence[Quantity]:
        """All numbers, curves and tables that are stated."""
        return tuple(self._quantities)

    @property
    def warnings(self) -> Sequence[str]:
        """The doubts that are stated."""
        return tuple(self._warnings)

    @property
    def attributes(self) -> Mapping[str, Any]:
        """The further attributes of the Dataset."""
        return dict(self._attributes)

    @property
    def summary(self) -> dict[str, Any]:
        """The summary of the contract. Raises ``WuchtError`` if two of its quantities have the same name."""
        return {"sentence": self.sentence} | {name: quantity.value for name, quantity in self._keys.items()}

    @property
    def _keys(self) -> dict[str, Quantity]:
        return quantities_by_name(q for q in self._quantities if q.dimensions is None or q.in_summary)

    def to_dataset(self) -> xr.Dataset:
        """Return the Dataset of the answer.

        Its attributes are texts and numbers, so that ``to_netcdf`` writes them; the accessor ``wucht`` reads them. Raises
        ``WuchtError`` if two variables, or two keys of the summary, have the same name.
        """
        self.fill()
        register_accessor()
        result = dataset_from_quantities(self._quantities)
        result.attrs = {
            "summary": to_json(self.summary, indent=None),
            "quantities": to_json({name: quantity.facts for name, quantity in self._keys.items()}, indent=None),
            "sentence": self.sentence,
            "warnings": to_json(self._warnings, indent=None),
            "assumed": to_json(self._assumptions, indent=None),
            "failure": self.failure or "",
            **self._attributes,
            "lines": to_json({"verdict": self.verdict, "lines": _limited_lines(self._lines)}, indent=None),
        }
        return result


def _limited_lines(lines: Sequence[Line]) -> Sequence[Line]:
    """Return as many lines as a report has at most: the first and the last ones, and one for all between them."""
    if len(lines) <= MOST_LINES:
        return lines
    count = len(lines) - MOST_LINES + 1
    between = ("", f"and {count} more lines: their numbers are in the Dataset", dict[str, str]())
    return [*lines[: MOST_LINES - 1 - _LAST_LINES], between, *lines[-_LAST_LINES:]]


def _at_path(text: str, path: str, texts: Mapping[str, str]) -> str:
    """A text with a path before those of its fields, but for fields of texts."""
    return re.sub(r"\{([^{}:]+)", lambda field: field[0] if field[1] in texts else f"{{{path}.{field[1]}", text)
