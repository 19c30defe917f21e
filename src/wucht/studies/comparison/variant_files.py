"""The variants of a comparison as the table ``[study]`` names them: studies in files, and existing results."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

from wucht.errors import InputError
from wucht.files.catalogue import ABOUT
from wucht.files.documents import Document, flatten
from wucht.results.output_folder import load_result, result_file
from wucht.results.store import RESULT
from wucht.schema import refuse_unknown
from wucht.studies.comparison.study import Comparison
from wucht.studies.comparison.variants import ComparedVariants, Variant, varied_key
from wucht.studies.registry import study_of
from wucht.studies.study_file import StudyFile, machine_study, read_study
from wucht.studies.subjects import Description, subject_of

_NESTED_ERROR = "this is a comparison; name the files that it compares"


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
            variants_of_study(source, partial(machine_study, source, machines[source]), common_settings, spec)
            if source in machines
            else _variants_from_source(source, path.parent, common_settings, spec)
            for source in spec.of
        ]
        variants = uniquely_named([v for group in groups for v in group])
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
    return variants_of_study(source, partial(read_study, name), common_settings, spec)


def variants_of_study(
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


def uniquely_named(variants: list[Variant]) -> tuple[Variant, ...]:
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
