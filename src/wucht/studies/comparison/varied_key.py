"""A key that is varied, in words and with its unit: what tables, legends and scales say instead of its path."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from typing import Any

from wucht.dynamics.run_ups.varied import start_states
from wucht.machines.machine import Machine
from wucht.results.formatting import unit_in_print, value_in_words
from wucht.schema import Parameter, Unit, unit_of
from wucht.studies.study_file import StudyFile

_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*(\D.*?)\s*")
_QUESTION, _START = "study.", "study.start."


@dataclass(frozen=True)
class VariedKey:
    """what: in words. unit: of its values, in SI; None where it holds no quantity. written: the unit in which all are given."""

    path: str
    what: str
    unit: str | None
    written: str = ""

    @property
    def printed(self) -> tuple[float, str]:
        """The factor by which values are printed, and their unit there: that in which they are written, if it is one."""
        if self.written:
            return 1 / Unit(self.unit or "", self.what).parse(f"1 {self.written}"), self.written
        return unit_in_print(self.unit or "")

    def in_si(self, given: Any) -> Any:
        """A value as a number in SI, or several; what is none, as it was given."""
        if self.unit is None:
            return given
        if isinstance(given, list | tuple):
            return [self.in_si(one) for one in given]
        with suppress(ValueError):
            return Unit(self.unit, self.what).parse(given)
        return given

    def at(self, value: Any) -> str:
        """A value (in SI) in words: ``eccentricity of drum = 1.5 mm``."""
        return f"{self.what} = {value_in_words(value, *self.printed)}"


def varied_key(asked: StudyFile, path: str, values: Sequence[Any], dimensionless: bool) -> VariedKey:
    """A key by its path, of a study file that has been read: a parameter, a key of the question, or any other."""
    key = _key(asked, path, dimensionless)
    return replace(key, written=_written(key, values))


def _written(key: VariedKey, values: Sequence[Any]) -> str:
    """The unit in which all values of a quantity are written; empty where they have different ones, or none."""
    found = {match[1] if isinstance(v, str) and (match := _NUMBER.fullmatch(v)) else "" for v in values}
    unit = found.pop() if len(found) == 1 and key.unit else ""
    return unit if unit and isinstance(key.in_si(f"1 {unit}"), float) else ""


def _key(asked: StudyFile, path: str, dimensionless: bool) -> VariedKey:
    states = start_states(asked.subject) if path.startswith(_START) and isinstance(asked.subject, Machine) else {}
    if (state := states.get(path.removeprefix(_START))) is not None:
        return VariedKey(path, state.what, state.unit.si)
    if path.startswith(_QUESTION):
        name = path.removeprefix(_QUESTION)
        unit = unit_of(type(asked.spec).model_fields.get(name))
        words = "study" if name == "kind" else name.replace("_", " ").replace(".", " ")
        return VariedKey(path, words, None if unit is None else "" if dimensionless else unit.si)
    known: Any = getattr(asked.subject, "parameters", {})
    parameters: Mapping[str, Parameter] = known if isinstance(known, Mapping) else {}
    if path in parameters:
        return VariedKey(path, parameters[path].called, parameters[path].unit)
    if f"{path}.x" in parameters:  # one value for both directions, or a pair
        one = parameters[f"{path}.x"]
        return VariedKey(path, Parameter(path, one.value, one.unit, one.symbol, one.what).words, one.unit)
    return VariedKey(path, Parameter(path, 0.0, "", "", path.rpartition(".")[2].replace("_", " ")).words, None)
