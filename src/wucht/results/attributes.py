"""The attributes of a result, read once, each with its type: in a file they may be anything.

What an answer consists of is indispensable: numbers with their units, the question, warnings, assumptions. An error names the
attribute. How it was computed is not: where that cannot be read, the result is read without it, and a sentence says so.
"""

from __future__ import annotations

import json
import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from datetime import datetime
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from wucht.errors import InputError

if TYPE_CHECKING:
    import xarray as xr

_Value = TypeVar("_Value")
_Reader = Callable[[Any], _Value]
_IN_EVERY_RESULT = ("summary", "sentence", "warnings", "failure")  # what a study states itself
_IN_EVERY_FILE = (*_IN_EVERY_RESULT, "study", "title", "finished", "dimensionless", "input")


@dataclass(frozen=True)
class ResultAttributes:
    """Attributes of a result, see ``ResultAccessor``; those that a result of an earlier version lacks are empty.

    creation, versions, document: when and with which programs it was computed, and its study file; report: its verdict and
    lines, see ``results.report``. None where there is none, or it cannot be read. faults: sentences on these.
    """

    study: str
    title: str
    sentence: str
    failure: str
    is_finished: bool
    is_dimensionless: bool
    question: dict[str, dict[str, Any]]
    summary: dict[str, Any]
    quantities: dict[str, dict[str, Any]]
    assumptions: list[str]
    warnings: list[str]
    notes: list[str]
    contents: list[str]
    parts: list[dict[str, Any]]
    creation: datetime | None
    versions: dict[str, str] | None
    document: dict[str, Any] | None
    report: dict[str, Any] | None
    faults: tuple[str, ...]


def read_attributes(attributes: Mapping[str, Any], *, in_file: bool = False) -> ResultAttributes:
    """Read the attributes of a result.

    Parameters
    ----------
    attributes : mapping
        Of the Dataset.
    in_file : bool
        True for those of a file, which have been completed. While a study composes its answer some are still missing.

    Returns
    -------
    ResultAttributes

    Raises
    ------
    InputError
        For an indispensable attribute that is missing (code ``missing``) or cannot be read: its name, the value, what is
        expected.
    """
    for name in _IN_EVERY_FILE if in_file else _IN_EVERY_RESULT:
        if name not in attributes:
            raise InputError(name, None, "this attribute of the result is missing", code="missing")
    faults = list[str]()

    def read(name: str, reader: _Reader[_Value], default: _Value) -> _Value:
        return _read(attributes, name, reader) if name in attributes else default

    def read_origin(name: str, reader: _Reader[_Value]) -> _Value | None:
        try:
            return read(name, reader, None)
        except InputError as error:
            faults.append(f"{error}; the result is read without it")
            return None

    return ResultAttributes(
        study=read("study", _text, ""),
        title=read("title", _text, ""),
        sentence=read("sentence", _text, ""),
        failure=read("failure", _text, ""),
        is_finished=bool(read("finished", _number, 0.0)),
        is_dimensionless=bool(read("dimensionless", _number, 0.0)),
        question=read("input", _question, {"study": {}, "machine": {}}),
        summary=read("summary", _table, {}),
        quantities=read("quantities", _quantities, {}),
        assumptions=read("assumed", _texts, []),
        warnings=read("warnings", _texts, []),
        notes=read("notes", _texts, []),
        contents=read("contents", _texts, []),
        parts=read("parts", _parts, []),
        creation=read_origin("created", _date),
        versions=read_origin("versions", _versions),
        document=read_origin("document", _table),
        report=read_origin("lines", _report),
        faults=tuple(faults),
    )


def number_in(result: xr.Dataset, name: str) -> float:
    """A further attribute that is a finite number. Raises ``InputError`` where it is missing or something else."""
    return _attribute(result, name, _number)


def text_in(result: xr.Dataset, name: str) -> str:
    """A further attribute that is a text. Raises ``InputError`` where it is missing or something else."""
    return _attribute(result, name, _text)


def table_in(result: xr.Dataset, name: str) -> dict[str, Any]:
    """A further attribute that is a table, as JSON. Raises ``InputError`` where it is missing or something else."""
    return _attribute(result, name, _table)


def _attribute(result: xr.Dataset, name: str, reader: _Reader[_Value]) -> _Value:
    if name not in result.attrs:
        raise InputError(name, None, "this attribute of the result is missing", code="missing")
    return _read(result.attrs, name, reader)


class _ExpectedError(ValueError):
    """What is expected in place of a value, after "must be" in a sentence."""


def _read(attributes: Mapping[str, Any], name: str, reader: _Reader[_Value]) -> _Value:
    value = attributes[name]
    try:
        return reader(value)
    except _ExpectedError as error:
        plain_value = value if isinstance(value, str) else np.asarray(value).tolist()
        raise InputError(name, plain_value, f"this attribute of the result must be {error}") from None


def _text(value: Any) -> str:
    if not isinstance(value, str):
        raise _ExpectedError("a text")
    return value


def _number(value: Any) -> float:
    if not isinstance(value, int | float | np.number | np.bool_) or not math.isfinite(value):
        raise _ExpectedError("a finite number")
    return float(value)


def _date(value: Any) -> datetime:
    try:
        return datetime.fromisoformat(_text(value))
    except ValueError:
        raise _ExpectedError("a date, such as 2026-05-01T12:00:00+00:00") from None


def _json_reader(what: str, has_form: Callable[[Any], bool]) -> _Reader[Any]:
    """The reader of a text of JSON. what: its content in a sentence; has_form: True for such a content."""

    def read(value: Any) -> Any:
        try:
            content = json.loads(_text(value))
        except (ValueError, RecursionError):
            raise _ExpectedError(f"{what}, as JSON") from None
        if not has_form(content):
            raise _ExpectedError(f"{what}, as JSON")
        return content

    return read


def _are_texts(*values: Any) -> bool:
    return all(isinstance(value, str) for value in values)


def _are_tables(*values: Any) -> bool:
    return all(isinstance(value, dict) for value in values)


def _is_list_of_texts(content: Any) -> bool:
    return isinstance(content, list) and _are_texts(*content)


def _is_table_of_texts(content: Any) -> bool:
    return _are_tables(content) and _are_texts(*content.values())


def _is_question(content: Any) -> bool:
    return _are_tables(content) and _are_tables(content.get("study"), content.get("machine"))


def _are_quantities(content: Any) -> bool:
    return _are_tables(content) and all(map(_is_quantity, content.values()))


def _is_quantity(facts: Any) -> bool:
    """True if the facts of a quantity have the form in which ``ResultAccessor`` reads them."""
    if not _are_tables(facts) or not _are_tables(parts := facts.get("parts", {})) or not _are_tables(*parts.values()):
        return False
    headline = facts.get("headline", False)
    has_headlines = isinstance(headline, bool) or _is_list_of_texts(headline)
    return has_headlines and all(_are_texts(one.get("what", ""), one.get("unit", "")) for one in (facts, *parts.values()))


def _is_report(content: Any) -> bool:
    return _are_tables(content) and isinstance(content.get("lines"), list) and isinstance(content.get("verdict"), str | None)


def _are_parts(content: Any) -> bool:
    return isinstance(content, list) and all(map(_is_part, content))


def _is_part(facts: Any) -> bool:
    """True if the facts of a part have the form in which they are read."""
    if not _are_tables(facts) or not _are_texts(*(facts.get(name) for name in ("path", "kind", "on"))):
        return False
    parameters = facts.get("parameters")
    return _are_tables(parameters) and all(
        _are_tables(one) and _are_texts(one.get("what"), one.get("unit")) for one in parameters.values()
    )


_table = _json_reader("a table", _are_tables)
_texts = _json_reader("a list of texts", _is_list_of_texts)
_versions = _json_reader("a table of programs and their versions", _is_table_of_texts)
_question = _json_reader("tables of the question and the machine", _is_question)
_quantities = _json_reader("a table of tables, one for each quantity", _are_quantities)
_report = _json_reader("a table with the lines of the report", _is_report)
_parts = _json_reader("a list of tables, one for each part of the machine", _are_parts)
