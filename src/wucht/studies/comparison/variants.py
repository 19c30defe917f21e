"""The variants of a comparison, and their varied keys with descriptions and units."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

from wucht.dynamics.run_ups.run_variations import start_states
from wucht.machines.machine import Machine
from wucht.results.formatting import unit_in_print, value_in_words
from wucht.schema import Parameter, Unit, unit_of
from wucht.studies.study_file import StudyFile
from wucht.studies.subjects import Description, subject_of

if TYPE_CHECKING:
    import xarray as xr


_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*(\D.*?)\s*")
_QUESTION, _START = "study.", "study.start."


@dataclass(frozen=True)
class VariedKey:
    """Varied key. unit: of its values, in SI; None where it holds no quantity. written_unit: unit in which all are given."""

    path: str
    description: str
    unit: str | None
    written_unit: str = ""

    @property
    def printed_scale(self) -> tuple[float, str]:
        """Factor and unit of printed values: the unit in which they are written, if all have the same."""
        if self.written_unit:
            return 1 / Unit(self.unit or "", self.description).parse_quantity(f"1 {self.written_unit}"), self.written_unit
        return unit_in_print(self.unit or "")

    def to_si(self, value: Any) -> Any:
        """Return a value, or several, in SI; a value that is no quantity is unchanged."""
        if self.unit is None:
            return value
        if isinstance(value, list | tuple):
            return [self.to_si(one) for one in value]
        with suppress(ValueError):
            return Unit(self.unit, self.description).parse_quantity(value)
        return value

    def assignment_text(self, value: Any) -> str:
        """Return a value (in SI) in words: ``eccentricity of drum = 1.5 mm``."""
        return f"{self.description} = {value_in_words(value, *self.printed_scale)}"


def varied_key(study_file: StudyFile, path: str, values: Sequence[Any], dimensionless: bool) -> VariedKey:
    """Return a key by its path, of a study file: a parameter, a key of the study, or any other."""
    key = _key(study_file, path, dimensionless)
    return replace(key, written_unit=_common_unit(key, values))


def _common_unit(key: VariedKey, values: Sequence[Any]) -> str:
    """Return the unit in which all values of a quantity are written; empty where they have different ones, or none."""
    units = {match[1] if isinstance(v, str) and (match := _NUMBER.fullmatch(v)) else "" for v in values}
    unit = units.pop() if len(units) == 1 and key.unit else ""
    return unit if unit and isinstance(key.to_si(f"1 {unit}"), float) else ""


def _key(study_file: StudyFile, path: str, dimensionless: bool) -> VariedKey:
    states = start_states(study_file.subject) if path.startswith(_START) and isinstance(study_file.subject, Machine) else {}
    if (state := states.get(path.removeprefix(_START))) is not None:
        return VariedKey(path, state.description, state.unit.si)
    if path.startswith(_QUESTION):
        name = path.removeprefix(_QUESTION)
        unit = unit_of(type(study_file.spec).model_fields.get(name))
        words = "study" if name == "kind" else name.replace("_", " ").replace(".", " ")
        return VariedKey(path, words, None if unit is None else "" if dimensionless else unit.si)
    subject_parameters: Any = getattr(study_file.subject, "parameters", {})
    parameters: Mapping[str, Parameter] = subject_parameters if isinstance(subject_parameters, Mapping) else {}
    if path in parameters:
        return VariedKey(path, parameters[path].sentence_name, parameters[path].unit)
    if f"{path}.x" in parameters:  # one value for both directions, or a pair
        one = parameters[f"{path}.x"]
        return VariedKey(path, Parameter(path, one.value, one.unit, one.symbol, one.long_name).full_name, one.unit)
    return VariedKey(path, Parameter(path, 0.0, "", "", path.rpartition(".")[2].replace("_", " ")).full_name, None)


@dataclass(frozen=True)
class Variant:
    """Variant of a comparison.

    name: distinguishes it from those of other files. varied_values: by path, in SI where they are numbers; keys: their
    descriptions. study_file: its study; result: if it exists already; refusal: why its study cannot be run.
    """

    name: str
    source: str
    varied_values: Mapping[str, Any]
    keys: tuple[VariedKey, ...] = ()
    study_file: StudyFile | None = None
    result: xr.Dataset | None = None
    refusal: str = ""

    @property
    def label(self) -> str:
        """Name, and varied values in words with units."""
        return "; ".join(
            [*([self.name] if self.name else []), *(key.assignment_text(self.varied_values[key.path]) for key in self.keys)]
        )

    @cached_property
    def _description(self) -> Description | None:
        return None if self.study_file is None else subject_of(self.study_file.spec).describe(self.study_file.subject)

    @property
    def kind(self) -> str:
        """Kind of its study; empty where it is not known."""
        if self.result is not None:
            return str(self.result.attrs["study"])
        return "" if self.study_file is None else self.study_file.spec.kind

    @property
    def title(self) -> str:
        """Title of the machine."""
        if self.result is not None:
            return str(self.result.attrs["title"])
        return "" if self._description is None else self._description.title

    @property
    def facts(self) -> dict[str, Any]:
        """Facts on the study and its subject."""
        if self.result is not None:
            question: dict[str, Any] = self.result.wucht.question
            return question
        if self.study_file is None or self._description is None:
            return {"refused": self.refusal}
        return {"study": self.study_file.spec.table_for(self.study_file.subject), "machine": self._description.facts}

    @property
    def dimensionless(self) -> bool:
        """True if its numbers have no units."""
        if self.result is not None:
            return bool(self.result.attrs["dimensionless"])
        return self._description is not None and self._description.dimensionless


@dataclass(frozen=True)
class ComparedVariants:
    """All variants, in the order of the files."""

    title: str
    variants: tuple[Variant, ...]
