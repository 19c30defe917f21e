"""Studies in the form of version 0.1, until 0.3.0: the class of the keys, and five functions in its module or package.

``prepare(spec, subject) -> plan``, ``run(plan, work) -> iterator of findings``, ``dataset(plan, findings) -> Dataset``,
``figure(Dataset) -> Figure``, ``report(Dataset) -> lines``. A long one is a package: ``prepare`` and ``run`` are in its module
``computation``, ``dataset`` and ``report`` in ``dataset``, or each is in a module of its name. A study of today is one class,
``wucht.extending.Study``.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from importlib import import_module
from importlib.util import find_spec
from inspect import signature
from pathlib import Path as FilePath
from types import ModuleType
from typing import TYPE_CHECKING, Any
from warnings import warn

from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.results.formatting import number_text
from wucht.results.quantities import Quantity, table
from wucht.studies.answer import Answer
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

__all__ = ["Quantity", "ReportLines", "Spec", "formats", "report_lines", "result_dataset", "table"]

Format = Callable[[float | None], str]
_FUNCTIONS = ("prepare", "run", "dataset", "figure", "report")
_MODULES = {"prepare": "computation", "run": "computation", "report": "dataset"}


class FindingsAnswer(Answer):
    """The answer of such a study: its Dataset is built when it is needed."""

    def __init__(self, build: Callable[[], xr.Dataset]) -> None:
        super().__init__()
        self._build = build

    def to_dataset(self) -> xr.Dataset:
        """See ``Answer``."""
        return self._build()


class Spec(Study):
    """The keys of a study whose functions stand beside the class, or in the modules of its package."""

    @classmethod
    def check_class(cls) -> None:
        """Warn: the form ends with 0.3.0. The functions stand after the class: they are checked in ``prepare``."""
        advice = f"the study {cls.kind!r} has the form of five functions, which ends with 0.3.0: make it one class, a Study"
        warn(advice, FutureWarning, stacklevel=4)

    @classmethod
    def _place(cls) -> str:
        return cls.__module__.removesuffix(".spec")

    @classmethod
    def _module(cls, part: str) -> ModuleType:
        whole = import_module(cls._place())
        for name in (part, _MODULES.get(part, part)) if hasattr(whole, "__path__") else ():
            if find_spec(f"{cls._place()}.{name}") is not None:
                return import_module(f"{cls._place()}.{name}")
        return whole

    @classmethod
    def _function(cls, name: str) -> Any:
        try:
            return getattr(cls._module(name), name)
        except AttributeError:
            raise WuchtError(f"the study {cls.kind!r} ({cls._place()}) has no function {name!r}") from None

    def prepare(self, subject: Any, watch: Callable[[], None] | None = None) -> Any:
        """See ``Study``. Raises ``WuchtError`` if a function of the study is missing."""
        for name in _FUNCTIONS:
            if not callable(self._function(name)):
                raise WuchtError(f"the study {self.kind!r} ({self._place()}): {name} must be a function")
        prepare = self._function("prepare")
        return prepare(self, subject, watch) if "watch" in signature(prepare).parameters else prepare(self, subject)

    def solve(self, subject: Any, prepared: Any, work: Work) -> Iterator[Answer]:
        """See ``Study``."""
        dataset = self._function("dataset")
        for findings in self._function("run")(prepared, work):
            yield FindingsAnswer(lambda findings=findings: dataset(prepared, findings))  # type: ignore[misc]

    def draw(self, result: xr.Dataset) -> Figure:
        """See ``Study``."""
        figure: Figure = self._function("figure")(result)
        return figure

    def report(self, result: xr.Dataset) -> list[str]:
        """See ``Study``."""
        lines: list[str] = self._function("report")(result)
        return lines

    def stored_numbers(self, prepared: Any) -> float:
        """See ``Study``: by ``numbers(plan)`` in the module of ``prepare``."""
        count_numbers = getattr(self._module("prepare"), "numbers", None)
        return float(count_numbers(prepared)) if count_numbers is not None else 0.0

    def export(self, result: xr.Dataset, folder: FilePath) -> list[str]:
        """See ``Study``: by ``export(Dataset, folder)`` in a module ``export``."""
        lines: list[str] = self._function("export")(result, folder)
        return lines

    @classmethod
    def exports(cls) -> bool:
        """True if there is such a module."""
        return hasattr(cls._module("export"), "export")


def result_dataset(
    quantities: Sequence[Quantity],
    sentence: str,
    warnings: Sequence[str] = (),
    assumptions: Sequence[str] = (),
    failure: str | None = None,
    **attributes: Any,
) -> xr.Dataset:
    """Build the Dataset of a result: an ``Answer`` without lines for its report.

    Parameters
    ----------
    quantities : sequence of Quantity
        Each name once among the variables, and once in the summary.
    sentence : str
        The result in words.
    warnings, assumptions : sequences of str
        Doubts; assumptions of the result beside those that its study states.
    failure : str, optional
        Reason why the result is not complete.
    attributes
        Further attributes of the Dataset: texts and numbers.

    Returns
    -------
    xarray.Dataset

    Raises
    ------
    WuchtError
        If two quantities have the same name.
    """
    a = Answer()
    a.sentence, a.failure = sentence, failure
    a.add(quantities)
    a.warn(*warnings)
    a.assume(*assumptions)
    a.attribute(**attributes)
    result = a.to_dataset()
    del result.attrs["lines"]
    return result


def formats(result: xr.Dataset, amplitude_unit: str = "m") -> tuple[Format, Format]:
    """Formats of the speeds and amplitudes of a result: with units, or as plain numbers for a dimensionless machine."""
    if result.attrs["dimensionless"]:
        return (_optional_format("{:.5g}".format),) * 2
    return _optional_format(partial(number_text, unit="rad/s")), _optional_format(partial(number_text, unit=amplitude_unit))


def report_lines(result: xr.Dataset, verdict: str, entries: Iterable[tuple[str, str]]) -> list[str]:
    """The lines of a report: the title, the verdict, and the entries with their names in a column."""
    return [result.attrs["title"], f"verdict: {verdict}", *(f"  {name:13}{line}" for name, line in entries)]


class ReportLines:
    """The lines of a report, with fields for numbers of the summary in the units of their quantities."""

    _FIELD = re.compile(r"\{([\w.]+)(?::([^{}]*))?\}")

    def __init__(self, result: xr.Dataset) -> None:
        self._result = result.wucht
        self.dimensionless: bool = self._result.dimensionless
        self._lines: list[tuple[str, str]] = []

    def add(self, heading: str, line: str, table: Mapping[str, Any] | None = None, key: str = "", **texts: str) -> None:
        """Add a line, unless one of its numbers is None.

        Parameters
        ----------
        heading : str
            Text in the column beside the line.
        line : str
            With fields: ``{breakdown.speed}``, a number of the summary by its path; ``{slip:%}``, a share in percent;
            ``{turns:.3g}``, with a given format. Numbers of a mapping are listed with their names.
        table, key
            For fields of a table in the summary: the table, and its key there, which gives the units.
        texts
            Texts for fields of these names.
        """
        before = f"{key}." if key else ""
        values: list[str | None] = []

        def fill_field(field: re.Match[str]) -> str:
            path, form = field[1], field[2] or ""
            if path in texts:
                return texts[path]
            value: Any = self._result.summary if table is None else table
            for step in path.split("."):
                value = value[step] if value is not None else None
            values.append(self.format_value(value, self._result.unit_at(before + path), form))
            return values[-1] or ""

        text = self._FIELD.sub(fill_field, line)
        if None not in values:
            self._lines.append((heading, text))

    def format_value(self, value: Any, unit: str, form: str = "") -> str | None:
        """Format a number with its unit, see ``number_text``."""
        return number_text(value, unit, form, self.dimensionless)

    def report(self, verdict: str) -> list[str]:
        """All lines, beginning with the title and the verdict."""
        return [self._result.title, f"verdict: {verdict}", *(f"  {heading:13}{line}" for heading, line in self._lines)]


def _optional_format(format_number: Callable[[float], str | None]) -> Format:
    return lambda value: "none" if value is None else str(format_number(value))
