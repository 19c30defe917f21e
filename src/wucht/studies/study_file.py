"""File -> question: read a study file or catalogue entry, with values set from the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.dynamics.work import Report
from wucht.errors import InputError
from wucht.files.catalogue import load_document, short_name
from wucht.files.documents import Document, flatten
from wucht.schema import require_table
from wucht.studies.registry import requested_study, studies
from wucht.studies.runner import run
from wucht.studies.spec import Spec
from wucht.studies.subjects import subject_of

if TYPE_CHECKING:
    import xarray as xr

DEFAULT_KIND = "run-up"  # of a file without a question


@dataclass(frozen=True)
class StudyFile:
    """Contents of a study file: the question, its subject, and the whole input as written.

    changes_kind: true if another kind of study than the file's is requested.
    """

    path: Path
    spec: Spec
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


def read_comparison(
    of: Sequence[str], settings: Mapping[str, Any] | None = None, vary: Mapping[str, Sequence[Any]] | None = None
) -> StudyFile:
    """Build the question that compares several studies, without a study file: see ``compare``. Raises ``InputError``."""
    study_table = {"kind": "comparison", "of": list(of), "set": dict(settings or {}), "vary": dict(vary or {})}
    return _read_document({"study": study_table}, Path("comparison"), "comparison", {}, [])


def _read_document(
    document: Document, path: Path, name: str, settings: Mapping[str, Any], dropped_keys: list[str]
) -> StudyFile:
    """Read a document. dropped_keys: is extended by the omitted keys, which were written for another kind of study."""
    study_table, omitted_keys = _study_table(document, settings)
    dropped_keys += omitted_keys
    spec = requested_study(study_table).spec
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
    of: Sequence[str | Path],
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
    of : paths of study files, catalogue names, and folders of results
    settings : mapping, optional
        Values by path, set in all of them; keys of their studies begin with ``study.``.
    vary : mapping, optional
        Lists of values of one or two paths: every combination is a variant of each file.
    folder, resume, progress : see ``run``

    Returns
    -------
    xarray.Dataset
        With the dimension ``variant``: numbers of the summaries, outcomes, failures, and curves.

    Raises
    ------
    InputError
        If an error holds for all variants of a file: with file, key, given value and requirement.

    Examples
    --------
    >>> compare(["drozdetskaya-2020/r1"], {"study.until": 6.0}, {"drive.slope": [0.0195, 0.039]}).outcome.values.tolist()
    ['unidentified', 'compensated']
    """
    study_file = read_comparison([str(one) for one in of], settings, vary)
    return run_study(study_file, folder=folder, resume=resume, progress=progress)


def run_study(study_file: StudyFile, **options: Any) -> xr.Dataset:
    """Run the study of a file that was read: ``run`` with its options, whose errors name the file."""
    try:
        return run(study_file.spec, study_file.subject, document=study_file.document, **options)
    except InputError as error:
        option = error.location.startswith("-")  # -o, --resume, --scheduler: not an error of the file
        raise error if option else error.with_file(study_file.path) from None


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
    spec = by_kind[kind].spec if isinstance(kind, str) and kind in by_kind else Spec
    if kind != study_table.get("kind") and spec is not Spec:
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
