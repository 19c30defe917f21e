"""File -> question: a study file or catalogue name, with values set from the command line."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.checking import table
from wucht.errors import InputError
from wucht.files.catalogue import load_document
from wucht.files.documents import Document, flatten
from wucht.studies.registry import Study, asked_study, studies
from wucht.studies.runner import RESULT, run
from wucht.studies.spec import Spec
from wucht.studies.subjects import subject_of
from wucht.studies.work import Report

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class StudyFile:
    """A study file read: the question, its subject, and the whole input as written."""

    path: Path
    name: str
    spec: Spec
    subject: Any
    document: Document


def read_study(name: str, settings: Mapping[str, Any] | None = None) -> StudyFile:
    """Read a study file or catalogue entry.

    settings: values by path; those that begin with ``study.`` belong to the table ``[study]``, all others to the subject.
    Raises ``InputError``: file, key, what was given, what is allowed.
    """
    document, path = load_document(name)
    own = flatten(settings or {})
    try:
        asked = _asked(document, own)
        study = asked_study(asked)
        of_subject = {k: v for k, v in own.items() if not k.startswith("study.")}
        subject, described = subject_of(study.spec).read(document, path, name, of_subject)
        spec = study.spec.read(asked)
    except InputError as error:
        raise error.within(str(path), ": ") from None
    return StudyFile(path, name, spec, subject, {"study": asked, **described})


def run_file(
    name: str | Path,
    settings: Mapping[str, Any] | None = None,
    *,
    folder: Path | None = None,
    resume: bool = False,
    progress: Report | None = None,
) -> xr.Dataset:
    """Read a study file or catalogue entry and answer it.

    Parameters
    ----------
    name : path of a study file, or a catalogue name
    settings : mapping, optional
        Values by path, such as ``{"drive.slope": "0.02 N m s", "study.until": 20.0}``.
    folder, resume, progress : see ``run``

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
    return answer(read_study(str(name), settings), folder=folder, resume=resume, progress=progress)


def answer(
    asked: StudyFile,
    *,
    folder: Path | None = None,
    files: Sequence[str] = (RESULT,),
    resume: bool = False,
    progress: Report | None = None,
) -> xr.Dataset:
    """Answer a study file that was read: ``run``, whose errors name the file."""
    try:
        return run(
            asked.spec, asked.subject, folder=folder, files=files, resume=resume, progress=progress, document=asked.document
        )
    except InputError as error:
        option = error.where.startswith("-")  # -o, --resume: the file is not at fault
        raise error if option else error.within(str(asked.path), ": ") from None


def _asked(document: Document, settings: Mapping[str, Any]) -> Document:
    """The table ``[study]`` with what is set in it; without one a run-up is asked for."""
    written = dict(table(document, "study", "study")) if "study" in document else {"kind": "run-up"}
    known = studies()
    asked = _of_kind(written, settings.get("study.kind", written.get("kind")), known)
    kind = settings.get("study.kind", asked.get("kind"))
    one_of = known[kind].spec.one_of if isinstance(kind, str) and kind in known else ()
    for key, value in settings.items():
        if key.startswith("study."):
            _set(asked, key.removeprefix("study.").split("."), value, one_of)
    return asked


def _of_kind(written: Document, kind: Any, known: Mapping[str, Study]) -> Document:
    """The table ``[study]``; of a file written for another kind only what this kind knows too."""
    if kind == written.get("kind") or not isinstance(kind, str) or kind not in known:
        return dict(written)
    spec = known[kind].spec
    allowed = set(spec.keys()) - set(spec.meaning)
    return {k: v for k, v in written.items() if k in allowed}


def _set(asked: Document, keys: list[str], value: Any, one_of: tuple[tuple[str, ...], ...]) -> None:
    for group in one_of:
        if keys[0] in group:  # one choice: setting one key replaces what the file says with another
            for other in group:
                asked.pop(other, None)
    for key in keys[:-1]:
        inner = asked.setdefault(key, {})
        if not isinstance(inner, dict):
            inner = asked[key] = {"angle": inner}
        asked = inner
    asked[keys[-1]] = value
