"""What is compared: study files with what is set in each variant, and results that are there already."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.checking import refuse_unknown
from wucht.errors import InputError
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, flatten
from wucht.machines.machine import Machine
from wucht.results.store import RESULT, load, result_file
from wucht.studies.comparison.spec import Comparison
from wucht.studies.study_file import StudyFile, read_study
from wucht.studies.subjects import Description, subject_of

if TYPE_CHECKING:
    import xarray as xr

_NESTED = "this is a comparison itself; name what it compares"


@dataclass(frozen=True)
class Variant:
    """One of them. varied: by path, in SI where it is a number. asked: its study; result: it is there already; refused: what
    is wrong with it."""

    label: str
    source: str
    varied: Mapping[str, Any]
    asked: StudyFile | None = None
    result: xr.Dataset | None = None
    refused: str = ""

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
            stored: dict[str, Any] = json.loads(self.result.attrs["input"])
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
        title = document.get("title") or f"Comparison of {_listed(spec)}"
        return Variants(str(title), _labelled([v for group in groups for v in group])), {}

    def describe(self, subject: Any) -> Description:
        """See ``Subject``."""
        if not isinstance(subject, Variants):
            raise InputError("study.of", subject, "this study is asked of what its table [study] names; see wucht.compare")
        facts = {"title": subject.title, "variants": [{"label": v.label} | v.facts for v in subject.variants]}
        return Description(subject.title, all(v.dimensionless for v in subject.variants), facts)


def _listed(spec: Comparison) -> str:
    over = f" over {' and '.join(spec.vary)}" if spec.vary else ""
    return ", ".join(map(_name, spec.of)) + over


def _of_source(source: str, folder: Path, shared: Mapping[str, Any], spec: Comparison) -> list[Variant]:
    """The variants of a file, or the result in a folder. Raises ``InputError`` where none of them can be asked."""
    place = folder / source
    if place.suffix == ".nc" or (place.is_dir() and result_file(place).is_file()):
        if shared or spec.vary:
            raise InputError("study.of", source, "this is a result: nothing can be set or varied in it; name the study file")
        result = load(place)
        if result.attrs["study"] == Comparison.kind:
            raise InputError("study.of", source, _NESTED)
        return [Variant(source, source, {}, result=result)]
    name, variants, errors = str(place) if place.is_file() else source, list[Variant](), list[InputError]()
    for combination in spec.combinations:
        label = ", ".join(f"{path} = {_shown(value)}" for path, value in combination.items())
        try:
            asked = read_study(name, {**shared, **combination})
        except InputError as error:
            errors.append(error)
            variants.append(Variant(label, source, combination, refused=str(error)))
            continue
        if asked.spec.kind == Comparison.kind:
            raise InputError("study.of", source, _NESTED)
        variants.append(Variant(label, source, {p: _in_si(asked, p, v) for p, v in combination.items()}, asked))
    if len(errors) == len(variants):
        raise errors[0]
    return variants


def _in_si(asked: StudyFile, path: str, given: Any) -> Any:
    """The value of a varied key: of a parameter in SI, of anything else as it was given."""
    values = asked.subject.values if isinstance(asked.subject, Machine) else {}
    return float(values[path]) if path in values else given


def _shown(value: Any) -> str:
    return f"{value:.6g}" if isinstance(value, int | float) and not isinstance(value, bool) else str(value)


def _labelled(variants: list[Variant]) -> tuple[Variant, ...]:
    """With labels that differ: the value alone where there is one file, else its name too."""
    sources = {v.source: _name(v.source) for v in variants}
    labels: list[str] = []
    for v in variants:
        unique = list(sources.values()).count(sources[v.source]) == 1
        own = [sources[v.source] if unique else v.source] if len(sources) > 1 or not v.varied else []
        label = "; ".join([*own, *([v.label] if v.varied else [])])
        count = sum(known == label or known.startswith(f"{label} (") for known in labels)
        labels.append(f"{label} ({count + 1})" if count else label)
    return tuple(replace(v, label=label) for v, label in zip(variants, labels, strict=True))


def _name(source: str) -> str:
    """The last name of a path: of the study file, or of the folder of the result."""
    path = Path(source)
    return (path.parent if path.name == RESULT else path).name.removesuffix(".toml") or source


VARIANTS = OfVariants()
