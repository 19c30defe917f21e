"""The variants of a comparison, and their varied keys with descriptions and units."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.dynamics.run_ups.run_variations import start_states
from wucht.errors import InputError
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, flatten
from wucht.machines.machine import Machine
from wucht.results.formatting import unit_in_print, value_in_words
from wucht.results.output_folder import load_result, result_file
from wucht.results.store import RESULT
from wucht.schema import Parameter, Unit, refuse_unknown, unit_of
from wucht.studies.comparison.spec import Comparison
from wucht.studies.registry import study_of
from wucht.studies.study_file import StudyFile, machine_study, read_study
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


_NESTED_ERROR = "this is a comparison; name the files that it compares"


@dataclass(frozen=True)
class Variant:
    """Variant of a comparison.

    name: distinguishes it from those of other files. varied_values: by path, in SI where they are numbers; keys: their
    descriptions. study_file: its study; result: if it exists already; refusal: error of an invalid variant.
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

    @property
    def title(self) -> str:
        """Title of the machine."""
        if self.result is not None:
            return str(self.result.attrs["title"])
        return "" if self.study_file is None else subject_of(self.study_file.spec).describe(self.study_file.subject).title

    @property
    def facts(self) -> dict[str, Any]:
        """Facts on the study and its subject."""
        if self.result is not None:
            question: dict[str, Any] = self.result.wucht.question
            return question
        if self.study_file is None:
            return {"refused": self.refusal}
        subject = self.study_file.subject
        return {
            "study": self.study_file.spec.table_for(subject),
            "machine": subject_of(self.study_file.spec).describe(subject).facts,
        }

    @property
    def dimensionless(self) -> bool:
        """True if its numbers have no units."""
        if self.result is not None:
            return bool(self.result.attrs["dimensionless"])
        return self.study_file is not None and subject_of(self.study_file.spec).describe(self.study_file.subject).dimensionless


@dataclass(frozen=True)
class ComparedVariants:
    """All variants, in the order of the files."""

    title: str
    variants: tuple[Variant, ...]


class VariantsSubject:
    """Subject of a comparison: the files and results that the table ``[study]`` names."""

    def from_document(
        self, document: Document, path: Path, name: str, settings: Mapping[str, Any]
    ) -> tuple[ComparedVariants, Document]:
        """Read the variants, see ``Subject``. settings: further keys set in all variants."""
        machines = document.get("machines", {})  # of wucht.compare by name, which are in no file
        for key in ("machine", "system"):
            if key in document:
                raise InputError(key, None, "not allowed here: study.of names the compared files")
        refuse_unknown(document, (*ABOUT, "machines"), "")
        spec = Comparison.from_table(document["study"])
        common_settings = spec.set | flatten(settings)
        groups = [
            _variants_of_study(source, partial(machine_study, source, machines[source]), common_settings, spec)
            if source in machines
            else _variants_from_source(source, path.parent, common_settings, spec)
            for source in spec.of
        ]
        variants = _uniquely_named([v for group in groups for v in group])
        return ComparedVariants(str(document.get("title") or _title(spec, variants)), variants), {}

    def describe(self, subject: Any) -> Description:
        """Describe the variants, see ``Subject``."""
        if not isinstance(subject, ComparedVariants):
            raise InputError("study.of", subject, "this study needs the files that its table [study] names; see wucht.compare")
        facts = {"title": subject.title, "variants": [{"label": v.label} | v.facts for v in subject.variants]}
        return Description(subject.title, all(v.dimensionless for v in subject.variants), facts)


def _title(spec: Comparison, variants: Sequence[Variant]) -> str:
    keys = variants[0].keys
    over = f", varied: {'; '.join(key.description for key in keys)}" if keys else ""
    return f"Comparison of {', '.join(map(_name, spec.of))}{over}"


def _variants_from_source(source: str, folder: Path, common_settings: Mapping[str, Any], spec: Comparison) -> list[Variant]:
    """Return the variants of a file, or the result in a folder. Raises ``InputError`` where none of them is valid."""
    place = folder / source
    if place.suffix == ".nc" or (place.is_dir() and result_file(place).is_file()):
        if common_settings or spec.vary:
            raise InputError("study.of", source, "this is a result: nothing can be set or varied in it; name the study file")
        result = load_result(place)
        try:
            study_of(result.attrs["study"])
        except InputError as error:
            raise error.with_file(result_file(place)) from None
        if result.attrs["study"] == Comparison.kind:
            raise InputError("study.of", source, _NESTED_ERROR)
        return [Variant("", source, {}, result=result)]
    name = str(place) if place.is_file() else source
    return _variants_of_study(source, partial(read_study, name), common_settings, spec)


def _variants_of_study(
    source: str, read: Callable[[Mapping[str, Any]], StudyFile], common_settings: Mapping[str, Any], spec: Comparison
) -> list[Variant]:
    """Return the variants of a study, read with settings by path. Raises ``InputError`` where none of them is valid."""
    attempts, errors = list[StudyFile | InputError](), list[InputError]()
    for combination in spec.combinations:
        try:
            attempts.append(read({**common_settings, **combination}))
        except InputError as error:
            attempts.append(error)
            errors.append(error)
    study_files = [one for one in attempts if isinstance(one, StudyFile)]
    if not study_files:
        raise errors[0]
    if any(one.spec.kind == Comparison.kind for one in study_files):
        raise InputError("study.of", source, _NESTED_ERROR)
    dimensionless = subject_of(study_files[0].spec).describe(study_files[0].subject).dimensionless
    keys = tuple(varied_key(study_files[0], path, values, dimensionless) for path, values in spec.vary.items())
    variants = [Variant("", source, {k.path: k.to_si(values[k.path]) for k in keys}, keys) for values in spec.combinations]
    return [
        replace(v, study_file=one) if isinstance(one, StudyFile) else replace(v, refusal=str(one))
        for v, one in zip(variants, attempts, strict=True)
    ]


def _uniquely_named(variants: list[Variant]) -> tuple[Variant, ...]:
    """Name the variants uniquely: no names are needed where there is one file and varied values distinguish all."""
    sources = {v.source: _name(v.source) for v in variants}
    unique_variants, count = list[Variant](), Counter[str]()
    for v in variants:
        unique = list(sources.values()).count(sources[v.source]) == 1
        variant = replace(
            v, name=(sources[v.source] if unique else v.source) if len(sources) > 1 or not v.varied_values else ""
        )
        count[variant.label] += 1
        again = count[variant.label]
        unique_variants.append(variant if again == 1 else replace(variant, name=f"{variant.name} ({again})".strip()))
    return tuple(unique_variants)


def _name(source: str) -> str:
    """Return the last name of a path: of the study file, or of the folder of the result."""
    path = Path(source)
    return (path.parent if path.name == RESULT else path).name.removesuffix(".toml") or source


VARIANTS = VariantsSubject()
