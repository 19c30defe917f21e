"""File -> question: read a study file or catalogue entry, with values set from the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.dynamics.work import Report
from wucht.errors import InputError
from wucht.file_names import printable
from wucht.files.catalogue import load_document, short_name
from wucht.files.documents import Document, flatten
from wucht.machines.machine import Machine
from wucht.schema import require_table
from wucht.studies.registry import requested_study, studies
from wucht.studies.runner import run
from wucht.studies.study import Study
from wucht.studies.subjects import subject_of

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_KIND = "run-up"  # of a file without a question


@dataclass(frozen=True)
class StudyFile:
    """Contents of a study file: the question, its subject, and the whole input as written; empty where that is in no file.

    changes_kind: true if another kind of study than the file's is requested.
    """

    path: Path
    spec: Study
    subject: Any
    document: Document
    changes_kind: bool

    @property
    def name(self) -> Path:
        """Folder of its result: the catalogue or file name, with a subfolder for another kind of study than the file's."""
        base = short_name(self.path)
        return base / self.spec.kind if self.changes_kind else base


def read_study(name: str, settings: Mapping[str, Any] | None = None) -> StudyFile:
    """Read a study file or catalogue entry.

    settings: values by path; those that begin with ``study.`` belong to the table ``[study]``, all others to the subject.
    Raises ``InputError`` with file, key, given value and requirement.
    """
    document, path = load_document(name)
    dropped_keys: list[str] = []
    try:
        return _read_document(document, path, name, flatten(settings or {}), dropped_keys)
    except InputError as error:
        raise _explain_dropped(error, dropped_keys).with_file(path) from None


def machine_study(name: str, machine: Machine, settings: Mapping[str, Any]) -> StudyFile:
    """Build the question about a machine that is in no file. settings, errors: see ``read_study``, with a name for the file."""
    try:
        study_table, _ = _study_table({}, flatten(settings))
        spec = requested_study(study_table).study
        subject = machine.with_values({k: v for k, v in flatten(settings).items() if not k.startswith("study.")})
        subject_of(spec).describe(subject)
        return StudyFile(Path(name), spec.from_table(study_table), subject, {"study": study_table}, False)
    except InputError as error:
        raise error.with_file(name) from None


def read_comparison(
    of: Sequence[str | Path | Machine],
    settings: Mapping[str, Any] | None = None,
    vary: Mapping[str, Sequence[Any]] | None = None,
) -> StudyFile:
    """Build the question that compares several studies, without a study file: see ``compare``. Raises ``InputError``."""
    for key, value in (("study.set", settings), ("study.vary", vary)):
        if value is not None and not isinstance(value, Mapping):
            requirement = "must be values by their paths; several files or machines are a list: compare([first, second])"
            raise InputError(key, getattr(value, "title", value), requirement)
    names, machines = list[str](), dict[str, Machine]()
    for one in of:
        if isinstance(one, Machine):
            names.append(_machine_name(one.title, names))
            machines[names[-1]] = one
        elif isinstance(one, str | Path):
            names.append(str(one))
        else:
            raise InputError(
                "study.of", one, "must be a study file, a catalogue name, a folder of a result, or a wucht.Machine"
            )
    study_table = {"kind": "comparison", "of": names, "set": dict(settings or {}), "vary": dict(vary or {})}
    document = {"study": study_table} | ({"machines": machines} if machines else {})
    study_file = _read_document(document, Path("comparison"), "comparison", {}, [])
    return replace(study_file, document={}) if machines else study_file  # no file could repeat it


def _machine_name(title: str, names: Sequence[str]) -> str:
    """A name of a machine in a comparison, from its title: other than those of the others, and without folders."""
    base = printable(title).replace("/", "-").replace("\\", "-").strip() or "machine"
    return next(name for name in (base, *(f"{base} ({k})" for k in range(2, len(names) + 3))) if name not in names)


def _read_document(
    document: Document, path: Path, name: str, settings: Mapping[str, Any], dropped_keys: list[str]
) -> StudyFile:
    """Read a document. dropped_keys: is extended by the omitted keys, which were written for another kind of study."""
    study_table, omitted_keys = _study_table(document, settings)
    dropped_keys += omitted_keys
    spec = requested_study(study_table).study
    of_subject = {k: v for k, v in settings.items() if not k.startswith("study.")}
    subject, tables = subject_of(spec).from_document(document | {"study": study_table}, path, name, of_subject)
    changes_kind = study_table["kind"] != document.get("study", {"kind": DEFAULT_KIND}).get("kind")
    return StudyFile(path, spec.from_table(study_table), subject, {"study": study_table, **tables}, changes_kind)


def run_file(
    name: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    folder: Path | str | None = None,
    resume: bool = False,
    progress: Report | None = None,
    scheduler: str | None = None,
) -> xr.Dataset:
    """Read a study file or catalogue entry and answer it.

    Parameters
    ----------
    name : path of a study file, or a catalogue name
    settings : mapping, optional
        Values by path, such as ``{"drive.slope": "0.02 N m s", "study.until": 20.0}``.
    folder, resume, progress, scheduler : see ``run``

    Returns
    -------
    xarray.Dataset
        See ``run``.

    Raises
    ------
    InputError
        File, key, what was given, what is allowed.

    Examples
    --------
    >>> run_file("drozdetskaya-2020/r1", {"study.until": 20.0}).wucht.summary["outcome"]
    'captured-modulated'
    """
    return run_study(read_study(str(name), settings), folder=folder, resume=resume, progress=progress, scheduler=scheduler)


def compare(
    of: Sequence[str | Path | Machine] | str | Path | Machine,
    settings: Mapping[str, Any] | None = None,
    vary: Mapping[str, Sequence[Any]] | None = None,
    *,
    folder: Path | str | None = None,
    resume: bool = False,
    progress: Report | None = None,
) -> xr.Dataset:
    """Compare several machines or variants: the studies of all in one result.

    Parameters
    ----------
    of : paths of study files, catalogue names, folders of results, and machines
        The study of a ``Machine`` is a run-up, or what ``settings`` say: ``{"study.kind": "response", ...}``.
    settings : mapping, optional
        Values by path, set in all of them; keys of their studies begin with ``study.``. Of a ``Machine`` its ``parameters``
        can be set.
    vary : mapping, optional
        Lists of values of one or two paths: every combination is a variant of each file.
    folder, resume, progress : see ``run``

    Returns
    -------
    xarray.Dataset
        With the dimension ``variant``, whose coordinates are varied keys and ``variant_number``: numbers of the summaries,
        outcomes, failures, and curves.

    Raises
    ------
    InputError
        If an error holds for all variants of a file: with file, key, given value and requirement.

    Examples
    --------
    >>> compare(["drozdetskaya-2020/r1"], {"study.until": 6.0}, {"drive.slope": [0.0195, 0.039]}).outcome.values.tolist()
    ['unidentified', 'compensated']
    """
    study_file = read_comparison([of] if isinstance(of, str | Path | Machine) else of, settings, vary)
    return run_study(study_file, folder=folder, resume=resume, progress=progress)


def run_study(study_file: StudyFile, **options: Any) -> xr.Dataset:
    """Run the study of a file that was read: ``run`` with its options, whose errors name the file."""
    try:
        return run(study_file.spec, study_file.subject, document=study_file.document or None, **options)
    except InputError as error:
        option = error.location.startswith("-")  # -o, --resume, --scheduler: not an error of the file
        raise error if option else error.with_file(study_file.path) from None


def with_keys(spec: Study, values: Mapping[str, Any]) -> Study:
    """The question with other values of keys, by path without ``study.``. Raises ``InputError``."""
    study_table = spec.given_table()
    for key, value in values.items():
        _set_key(study_table, key.split("."), value, spec.one_of)
    return type(spec).from_table(study_table)


def _explain_dropped(error: InputError, dropped_keys: list[str]) -> InputError:
    """Explain the error of a missing key that the file has, but for another kind of study."""
    if error.value is not None or error.location.removeprefix("study.") not in dropped_keys:
        return error
    reason = (
        f"the values of {', '.join(dropped_keys)} in the file were written for another kind of study and are ignored; use --set"
    )
    return InputError(error.location, None, f"{error.explanation}; {reason} {error.location}=...", code=error.code)


def _study_table(document: Document, settings: Mapping[str, Any]) -> tuple[Document, list[str]]:
    """The table ``[study]`` with the settings, and the omitted keys; without a table the study is a run-up.

    From a file written for another kind only the keys in common are used.
    """
    study_table = dict(require_table(document, "study", "study")) if "study" in document else {"kind": DEFAULT_KIND}
    kind, by_kind = settings.get("study.kind", study_table.get("kind")), studies()
    written_table = study_table
    spec = by_kind[kind].study if isinstance(kind, str) and kind in by_kind else Study
    if kind != study_table.get("kind") and spec is not Study:
        common_keys = set(spec.keys()) - set(spec.meaning)
        study_table = {k: v for k, v in study_table.items() if k in common_keys}
    for key, value in settings.items():
        if key.startswith("study."):
            _set_key(study_table, key.removeprefix("study.").split("."), value, spec.one_of)
    return study_table, [k for k in written_table if k not in study_table]


def _set_key(target: Document, keys: list[str], value: Any, one_of: tuple[tuple[str, ...], ...]) -> None:
    for group in one_of:
        if keys[0] in group:  # one choice: setting one key replaces the others in the file
            for alternative in group:
                target.pop(alternative, None)
    for key in keys[:-1]:
        inner = target.setdefault(key, {})
        if not isinstance(inner, dict):
            inner = target[key] = {"angle": inner}
        target = inner
    target[keys[-1]] = value
