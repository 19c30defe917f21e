"""The variants of a comparison, and their varied keys with descriptions and units."""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.dynamics.run_ups.varied import start_states
from wucht.errors import InputError
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, flatten
from wucht.machines.machine import Machine
from wucht.results.formatting import unit_in_print, value_in_words
from wucht.results.output_folder import load, result_file
from wucht.results.store import RESULT
from wucht.schema import Parameter, Unit, refuse_unknown, unit_of
from wucht.studies.comparison.spec import Comparison
from wucht.studies.registry import study_of
from wucht.studies.study_file import StudyFile, read_study
from wucht.studies.subjects import Description, subject_of

if TYPE_CHECKING:
    import xarray as xr


_NUMBER = re.compile(r"\s*[-+]?[\d.]+(?:[eE][-+]?\d+)?\s*(\D.*?)\s*")
_QUESTION, _START = "study.", "study.start."


@dataclass(frozen=True)
class VariedKey:
    """Varied key. unit: of its values, in SI; None where it holds no quantity. written_unit: unit in which all are given."""

    path: str
    what: str
    unit: str | None
    written: str = ""

    @property
    def printed(self) -> tuple[float, str]:
        """Factor and unit of printed values: the unit in which they are written, if all have the same."""
        if self.written:
            return 1 / Unit(self.unit or "", self.what).parse(f"1 {self.written}"), self.written
        return unit_in_print(self.unit or "")

    def in_si(self, given: Any) -> Any:
        """Return a value, or several, in SI; a value that is no quantity is unchanged."""
        if self.unit is None:
            return given
        if isinstance(given, list | tuple):
            return [self.in_si(one) for one in given]
        with suppress(ValueError):
            return Unit(self.unit, self.what).parse(given)
        return given

    def at(self, value: Any) -> str:
        """Return a value (in SI) in words: ``eccentricity of drum = 1.5 mm``."""
        return f"{self.what} = {value_in_words(value, *self.printed)}"


def varied_key(asked: StudyFile, path: str, values: Sequence[Any], dimensionless: bool) -> VariedKey:
    """Return a key by its path, of a study file: a parameter, a key of the study, or any other."""
    key = _key(asked, path, dimensionless)
    return replace(key, written=_written(key, values))


def _written(key: VariedKey, values: Sequence[Any]) -> str:
    """Return the unit in which all values of a quantity are written; empty where they have different ones, or none."""
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


_NESTED = "this is a comparison; name the files that it compares"


@dataclass(frozen=True)
class Variant:
    """Variant of a comparison.

    name: distinguishes it from those of other files. varied_values: by path, in SI where they are numbers; keys: their
    descriptions. study_file: its study; result: if it exists already; refusal: error of an invalid variant.
    """

    name: str
    source: str
    varied: Mapping[str, Any]
    keys: tuple[VariedKey, ...] = ()
    asked: StudyFile | None = None
    result: xr.Dataset | None = None
    refused: str = ""

    @property
    def label(self) -> str:
        """Name, and varied values in words with units."""
        return "; ".join([*([self.name] if self.name else []), *(key.at(self.varied[key.path]) for key in self.keys)])

    @property
    def title(self) -> str:
        """Title of the machine."""
        if self.result is not None:
            return str(self.result.attrs["title"])
        return "" if self.asked is None else subject_of(self.asked.spec).describe(self.asked.subject).title

    @property
    def facts(self) -> dict[str, Any]:
        """Facts on the study and its subject."""
        if self.result is not None:
            stored: dict[str, Any] = self.result.wucht.question
            return stored
        if self.asked is None:
            return {"refused": self.refused}
        subject = self.asked.subject
        return {"study": self.asked.spec.asked_of(subject), "machine": subject_of(self.asked.spec).describe(subject).facts}

    @property
    def dimensionless(self) -> bool:
        """True if its numbers have no units."""
        if self.result is not None:
            return bool(self.result.attrs["dimensionless"])
        return self.asked is not None and subject_of(self.asked.spec).describe(self.asked.subject).dimensionless


@dataclass(frozen=True)
class Variants:
    """All variants, in the order of the files."""

    title: str
    variants: tuple[Variant, ...]


class OfVariants:
    """Subject of a comparison: the files and results that the table ``[study]`` names."""

    def read(self, document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Variants, Document]:
        """Read the variants, see ``Subject``. settings: further keys set in all variants."""
        for key in ("machine", "system"):
            if key in document:
                raise InputError(key, None, "not allowed here: study.of names the compared files")
        refuse_unknown(document, ABOUT, "")
        spec = Comparison.read(document["study"])
        shared = spec.set | flatten(settings)
        groups = [_of_source(source, path.parent, shared, spec) for source in spec.of]
        variants = _named([v for group in groups for v in group])
        return Variants(str(document.get("title") or _title(spec, variants)), variants), {}

    def describe(self, subject: Any) -> Description:
        """Describe the variants, see ``Subject``."""
        if not isinstance(subject, Variants):
            raise InputError("study.of", subject, "this study needs the files that its table [study] names; see wucht.compare")
        facts = {"title": subject.title, "variants": [{"label": v.label} | v.facts for v in subject.variants]}
        return Description(subject.title, all(v.dimensionless for v in subject.variants), facts)


def _title(spec: Comparison, variants: Sequence[Variant]) -> str:
    keys = variants[0].keys
    over = f", varied: {'; '.join(key.what for key in keys)}" if keys else ""
    return f"Comparison of {', '.join(map(_name, spec.of))}{over}"


def _of_source(source: str, folder: Path, shared: Mapping[str, Any], spec: Comparison) -> list[Variant]:
    """Return the variants of a file, or the result in a folder. Raises ``InputError`` where none of them is valid."""
    place = folder / source
    if place.suffix == ".nc" or (place.is_dir() and result_file(place).is_file()):
        if shared or spec.vary:
            raise InputError("study.of", source, "this is a result: nothing can be set or varied in it; name the study file")
        result = load(place)
        try:
            study_of(result.attrs["study"])
        except InputError as error:
            raise error.in_file(result_file(place)) from None
        if result.attrs["study"] == Comparison.kind:
            raise InputError("study.of", source, _NESTED)
        return [Variant("", source, {}, result=result)]
    name = str(place) if place.is_file() else source
    asked, errors = list[StudyFile | InputError](), list[InputError]()
    for combination in spec.combinations:
        try:
            asked.append(read_study(name, {**shared, **combination}))
        except InputError as error:
            asked.append(error)
            errors.append(error)
    read = [one for one in asked if isinstance(one, StudyFile)]
    if not read:
        raise errors[0]
    if any(one.spec.kind == Comparison.kind for one in read):
        raise InputError("study.of", source, _NESTED)
    bare = subject_of(read[0].spec).describe(read[0].subject).dimensionless
    keys = tuple(varied_key(read[0], path, values, bare) for path, values in spec.vary.items())
    variants = [Variant("", source, {k.path: k.in_si(values[k.path]) for k in keys}, keys) for values in spec.combinations]
    return [
        replace(v, asked=one) if isinstance(one, StudyFile) else replace(v, refused=str(one))
        for v, one in zip(variants, asked, strict=True)
    ]


def _named(variants: list[Variant]) -> tuple[Variant, ...]:
    """Name the variants uniquely: no names are needed where there is one file and varied values distinguish all."""
    sources = {v.source: _name(v.source) for v in variants}
    named, count = list[Variant](), Counter[str]()
    for v in variants:
        unique = list(sources.values()).count(sources[v.source]) == 1
        own = replace(v, name=(sources[v.source] if unique else v.source) if len(sources) > 1 or not v.varied else "")
        count[own.label] += 1
        again = count[own.label]
        named.append(own if again == 1 else replace(own, name=f"{own.name} ({again})".strip()))
    return tuple(named)


def _name(source: str) -> str:
    """Return the last name of a path: of the study file, or of the folder of the result."""
    path = Path(source)
    return (path.parent if path.name == RESULT else path).name.removesuffix(".toml") or source


VARIANTS = OfVariants()
