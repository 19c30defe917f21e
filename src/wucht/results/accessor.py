"""``result.wucht``: the summary, question, notes and tables of every result, without JSON."""

from __future__ import annotations

import re
from functools import cache
from html import escape
from typing import TYPE_CHECKING, Any
from warnings import warn

from wucht.errors import InputError, WuchtError
from wucht.results.attributes import read_attributes
from wucht.results.result_tables import NUMBERS, result_table, table_frame, table_names
from wucht.schema.units import is_in_rpm

if TYPE_CHECKING:
    import pandas as pd
    import xarray as xr

_FEW = 12  # numbers of a summary in the table of a notebook


class ResultAccessor:
    """A result as an object. It reads the attributes of the Dataset, each once and with its type.

    Attributes
    ----------
    study : str
        Kind of the study, such as ``run-up``.
    title : str
        Title of the machine or other subject.
    question : dict
        ``spec`` and ``machine``, under the keys ``study`` and ``machine``.
    spec : dict
        The question: the keys of ``[study]``.
    machine : dict
        The subject: title, parameters by path (SI floats), bodies (name, kind, the body they turn about).
    summary : dict
        The numbers of the contract, SI floats, None for missing ones.
    quantities : dict
        For each key of the summary its description (``what``), its ``unit``, and of a table its ``parts``. Empty for results of
        earlier versions.
    sentence : str
        The answer in words.
    assumed : list of str
        Assumptions of the answer: the equations, the speeds, where bodies are held.
    warnings, notes : list of str
        Doubts; origins of derived parameters, such as a motor's circuit from its nameplate.
    parts : list of dict
        Of a machine, the parts with ``path``, ``kind``, the body each acts ``on``, and for each of its ``parameters`` its name
        in words (``what``) and ``unit``. Empty for other subjects, and for results of earlier versions.
    contents : list of str
        Variables of the result when it was written.
    failure : str
        Reason why the result is not complete, empty if nothing failed.
    finished : bool
        True if the study reached its end.
    dimensionless : bool
        True if the numbers have no units.
    speaks_rpm : bool
        True if speeds in the study file are in revolutions per minute: texts then begin with these.
    created : datetime or None
        When it was computed. This, ``versions`` and ``document`` are None where they are missing or cannot be read.
    versions : dict or None
        Versions of the programs that computed it, by name.
    document : dict or None
        The study file.
    stored_report : dict or None
        The lines of the report, as they are stored; ``wucht.report`` fills them. None as the preceding three.
    faults : tuple of str
        Sentences on those of these four that cannot be read.
    tables : list of str
        Names of the tables that ``table`` returns.
    summary_table, branches, branch_points : DataFrame
        Three of them: all single numbers, a row for each branch, and the points along all branches.

    Raises
    ------
    WuchtError
        If the Dataset is no result of a study.
    InputError
        For another attribute than these four that cannot be read.
    """

    def __init__(self, result: xr.Dataset) -> None:
        self._result = result
        try:
            attributes = read_attributes(result.attrs)
        except InputError as error:
            if error.code == "missing":
                sentence = f"this Dataset is not a result of a study: it has no attribute {error.key}"
                raise WuchtError(sentence, code="no-result") from None
            raise
        self.question, self.summary, self.quantities = attributes.question, attributes.summary, attributes.quantities
        self.spec, self.machine, self.parts = self.question["study"], self.question["machine"], attributes.parts
        self.study, self.title, self.sentence = attributes.study, attributes.title, attributes.sentence
        self.assumed, self.warnings, self.notes = attributes.assumptions, attributes.warnings, attributes.notes
        self.contents, self.failure = attributes.contents, attributes.failure
        self.finished, self.dimensionless = attributes.is_finished, attributes.is_dimensionless
        self.created, self.versions, self.document = attributes.creation, attributes.versions, attributes.document
        self.stored_report, self.faults = attributes.report, attributes.faults
        self.speaks_rpm = _has_rpm(self.document)

    def unit_at(self, path: str) -> str:
        """The unit of a number of the summary by its path, such as ``working_points[0].speed``.

        The unit of the last step of the path that is a key or one of its parts; empty for numbers without a unit.
        """
        return str(self._facts_at(path).get("unit", ""))

    def description_at(self, path: str) -> str:
        """The name in words of a number of the summary by its path, see ``unit_at``; empty where it is not known."""
        return str(self._facts_at(path).get("what", "verdict" if path == "sentence" else ""))

    def _facts_at(self, path: str) -> dict[str, Any]:
        """The facts about the last step of a path that is a key or one of its parts."""
        first, _, rest = re.sub(r"\[\d+\]", "", path).partition(".")
        quantity = self.quantities.get(first, {})
        # Names of parts may have dots, as paths of parameters have.
        parts = [(f".{rest}.".rfind(f".{name}."), name) for name in quantity.get("parts", {})]
        at, last = max(parts, key=lambda part: part[0], default=(-1, ""))
        facts: dict[str, Any] = quantity if at < 0 else quantity["parts"][last]
        return facts

    @property
    def tables(self) -> list[str]:
        """Names of the tables of the result."""
        return table_names(self._result)

    def table(self, name: str) -> pd.DataFrame:
        """Return a table of the result.

        Parameters
        ----------
        name : str
            One of ``tables``: the dimensions of its rows, such as ``time``, for variables over the same values; the key of a
            list in the summary, such as ``orbits``; or ``numbers``, see ``summary_table``.

        Returns
        -------
        pandas.DataFrame
            Its columns have names and units, such as ``speed drum [rad/s]``, as in the CSV files; ``attrs["units"]`` has the
            unit of each. Variables of several bodies or directions have a column for each.

        Raises
        ------
        InputError
            If there is no such table.
        """
        return table_frame(result_table(self._result, name))

    @property
    def summary_table(self) -> pd.DataFrame:
        """The single numbers and texts of the result by name: ``value``, ``unit`` and ``description``.

        Numbers within tables have their paths, such as ``final_phases.p1``; of a list that is a table itself, the number of
        rows.
        """
        return self.table(NUMBERS).set_index("name")

    @property
    def branches(self) -> pd.DataFrame:
        """The table ``branches``: range and stability of each branch, a row for each; ``branch_points`` where there is none.

        Warns until version 0.3.0 where it was ``branch_points`` before. Raises ``InputError`` if the result has no branches.
        """
        if "branches" not in self.tables:
            return self.branch_points
        advice = "result.wucht.branches is the table of this name, a row for each branch; the points are branch_points"
        warn(advice, FutureWarning, stacklevel=2)
        return self.table("branches")

    @property
    def branch_points(self) -> pd.DataFrame:
        """The points along all branches of a result, with the number of its ``branch`` in each row.

        Raises ``InputError`` if the result has no branches.
        """
        if "branch" not in self._result.variables or not self._result["branch"].dims:
            raise InputError(
                "branches", None, f"a result of {self.study} has no branches; its tables: {', '.join(self.tables)}"
            )
        return self.table("-".join(map(str, self._result["branch"].dims)))

    def to_dataframe(self) -> pd.DataFrame:
        """Return all tables in one, below each other, the first index being the name of the ``table``.

        Its size is the sum of their sizes. ``Dataset.to_dataframe`` of xarray combines every value of each dimension with
        those of all others, whether or not they belong together.
        """
        import pandas as pd_

        tables = {name: self.table(name) for name in self.tables}
        frame = pd_.concat(tables, names=["table", "row"])
        frame.attrs["units"] = {heading: unit for table in tables.values() for heading, unit in table.attrs["units"].items()}
        return frame

    @property
    def headlines(self) -> list[str]:
        """Paths of the main numbers of the summary."""
        paths = list[str]()
        for name, facts in self.quantities.items():
            parts = facts.get("headline", False)
            paths += [name] if parts is True else [f"{name}.{part}" for part in parts or ()]
        return paths

    def __repr__(self) -> str:
        lines = [f"{self.study} of {self.title}: {self.sentence}"]
        lines += [] if self.finished else [f"not finished{f': {self.failure}' if self.failure else ''}"]
        return "\n".join([*lines, *(f"note: {n}" for n in self.notes), *(f"warning: {w}" for w in self.warnings)])

    def _repr_html_(self) -> str:
        entries = [
            (k, v if isinstance(v, str) else f"{v:.6g}") for k, v in self.summary.items() if type(v) in (int, float, str)
        ]
        rows = "".join(f"<tr><th>{escape(k)}</th><td>{escape(v)}</td></tr>" for k, v in entries[:_FEW])
        notes = "".join(f"<li>{escape(w)}</li>" for w in (*self.notes, *self.warnings))
        heading = f"{escape(self.study)} of {escape(str(self.title))}"
        return f"<b>{heading}</b><p>{escape(self.sentence)}</p><table>{rows}</table><ul>{notes}</ul>"


def _has_rpm(entry: Any) -> bool:
    if isinstance(entry, dict):
        return any(map(_has_rpm, entry.values()))
    return any(map(_has_rpm, entry)) if isinstance(entry, list) else isinstance(entry, str) and is_in_rpm(entry)


@cache
def register_accessor() -> None:
    """Register ``Dataset.wucht`` with xarray."""
    import xarray as xr_

    xr_.register_dataset_accessor("wucht")(ResultAccessor)  # type: ignore[no-untyped-call]
