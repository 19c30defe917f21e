"""The variants that are compared, and the keys that are varied, in words and with their units."""

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


_NESTED = "this is a comparison itself; name what it compares"


@dataclass(frozen=True)
class Variant:
    """One of them. name: what tells it from others but for what is varied. varied: by path, in SI where it is a number; keys:
    what these are. asked: its study; result: it is there already; refused: what is wrong with it."""

    name: str
    source: str
    varied: Mapping[str, Any]
    keys: tuple[VariedKey, ...] = ()
    asked: StudyFile | None = None
    result: xr.Dataset | None = None
    refused: str = ""

    @property
    def label(self) -> str:
        """What it is called: its name, and what is varied, in words with units."""
        return "; ".join([*([self.name] if self.name else []), *(key.at(self.varied[key.path]) for key in self.keys)])

    @property
    def title(self) -> str:
        """Of the machine."""
        if self.result is not None:
            return str(self.result.attrs["title"])
        return "" if self.asked is None else subject_of(self.asked.spec).describe(self.asked.subject).title

    @property
    def facts(self) -> dict[str, Any]:
        """What is asked, of what."""
        if self.result is not None:
            stored: dict[str, Any] = self.result.wucht.question
            return stored
        if self.asked is None:
            return {"refused": self.refused}
        subject = self.asked.subject
        return {"study": self.asked.spec.asked_of(subject), "machine": subject_of(self.asked.spec).describe(subject).facts}

    @property
    def dimensionless(self) -> bool:
        """Whether its numbers have no units."""
        if self.result is not None:
            return bool(self.result.attrs["dimensionless"])
        return self.asked is not None and subject_of(self.asked.spec).describe(self.asked.subject).dimensionless


@dataclass(frozen=True)
class Variants:
    """All of them, in the order of the files."""

    title: str
    variants: tuple[Variant, ...]


class OfVariants:
    """The files and results that the table ``[study]`` names."""

    def read(self, document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Variants, Document]:
        """See ``Subject``. settings: keys that are set in all of them too."""
        for key in ("machine", "system"):
            if key in document:
                raise InputError(key, None, "not allowed here: study.of names the files of what is compared")
        refuse_unknown(document, ABOUT, "")
        spec = Comparison.read(document["study"])
        shared = spec.set | flatten(settings)
        groups = [_of_source(source, path.parent, shared, spec) for source in spec.of]
        variants = _named([v for group in groups for v in group])
        return Variants(str(document.get("title") or _title(spec, variants)), variants), {}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if not isinstance(subject, Variants):
            raise InputError("study.of", subject, "this study is asked of what its table [study] names; see wucht.compare")
        facts = {"title": subject.title, "variants": [{"label": v.label} | v.facts for v in subject.variants]}
        return Description(subject.title, all(v.dimensionless for v in subject.variants), facts)


def _title(spec: Comparison, variants: Sequence[Variant]) -> str:
    keys = variants[0].keys
    over = f", varied: {'; '.join(key.what for key in keys)}" if keys else ""
    return f"Comparison of {', '.join(map(_name, spec.of))}{over}"


def _of_source(source: str, folder: Path, shared: Mapping[str, Any], spec: Comparison) -> list[Variant]:
    """The variants of a file, or the result in a folder. Raises ``InputError`` where none of them can be asked."""
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
    """With names that tell them from each other: none where there is one file, and what is varied tells it all."""
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
    """The last name of a path: of the study file, or of the folder of the result."""
    path = Path(source)
    return (path.parent if path.name == RESULT else path).name.removesuffix(".toml") or source


VARIANTS = OfVariants()
