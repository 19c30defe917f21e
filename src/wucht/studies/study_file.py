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
from wucht.schema import table
from wucht.studies.registry import asked_study, studies
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
    other: bool

    @property
    def name(self) -> Path:
        """Folder of its result: the catalogue or file name, with a subfolder for another kind of study than the file's."""
        own = short_name(self.path)
        return own / self.spec.kind if self.other else own


def read_study(name: str, settings: Mapping[str, Any] | None = None) -> StudyFile:
    """Read a study file or catalogue entry.

    settings: values by path; those that begin with ``study.`` belong to the table ``[study]``, all others to the subject.
    Raises ``InputError`` with file, key, given value and requirement.
    """
    document, path = load_document(name)
    dropped: list[str] = []
    try:
        return _read(document, path, name, flatten(settings or {}), dropped)
    except InputError as error:
        raise _with_dropped(error, dropped).in_file(path) from None


def read_comparison(
    of: Sequence[str], settings: Mapping[str, Any] | None = None, vary: Mapping[str, Sequence[Any]] | None = None
) -> StudyFile:
    """Build the question that compares several studies, without a study file: see ``compare``. Raises ``InputError``."""
    asked = {"kind": "comparison", "of": list(of), "set": dict(settings or {}), "vary": dict(vary or {})}
    return _read({"study": asked}, Path("comparison"), "comparison", {}, [])


def _read(document: Document, path: Path, name: str, settings: Mapping[str, Any], dropped: list[str]) -> StudyFile:
    """Read a document. dropped_keys: is extended by the omitted keys, which were written for another kind of study."""
    asked, left_out = _asked(document, settings)
    dropped += left_out
    spec = asked_study(asked).spec
    of_subject = {k: v for k, v in settings.items() if not k.startswith("study.")}
    subject, described = subject_of(spec).read(document | {"study": asked}, path, name, of_subject)
    other = asked["kind"] != document.get("study", {"kind": DEFAULT_KIND}).get("kind")
    return StudyFile(path, spec.read(asked), subject, {"study": asked, **described}, other)


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
    return answer(read_study(str(name), settings), folder=folder, resume=resume, progress=progress, scheduler=scheduler)


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
    asked = read_comparison([str(one) for one in of], settings, vary)
    return answer(asked, folder=folder, resume=resume, progress=progress)


def answer(asked: StudyFile, **options: Any) -> xr.Dataset:
    """Answer a study file that was read: ``run`` with its options, whose errors name the file."""
    try:
        return run(asked.spec, asked.subject, document=asked.document, **options)
    except InputError as error:
        option = error.where.startswith("-")  # -o, --resume, --scheduler: not an error of the file
        raise error if option else error.in_file(asked.path) from None


def _with_dropped(error: InputError, dropped: list[str]) -> InputError:
    """Explain the error of a missing key that the file has, but for another kind of study."""
    if error.given is not None or error.where.removeprefix("study.") not in dropped:
        return error
    why = f"the values of {', '.join(dropped)} in the file were written for another kind of study and are ignored; use --set"
    return InputError(error.where, None, f"{error.allowed}; {why} {error.where}=...")


def _asked(document: Document, settings: Mapping[str, Any]) -> tuple[Document, list[str]]:
    """The table ``[study]`` with the settings, and the omitted keys; without a table the study is a run-up.

    From a file written for another kind only the keys in common are used.
    """
    asked = dict(table(document, "study", "study")) if "study" in document else {"kind": DEFAULT_KIND}
    kind, known = settings.get("study.kind", asked.get("kind")), studies()
    written = asked
    spec = known[kind].spec if isinstance(kind, str) and kind in known else Spec
    if kind != asked.get("kind") and spec is not Spec:
        allowed = set(spec.keys()) - set(spec.meaning)
        asked = {k: v for k, v in asked.items() if k in allowed}
    for key, value in settings.items():
        if key.startswith("study."):
            _set(asked, key.removeprefix("study.").split("."), value, spec.one_of)
    return asked, [k for k in written if k not in asked]


def _set(asked: Document, keys: list[str], value: Any, one_of: tuple[tuple[str, ...], ...]) -> None:
    for group in one_of:
        if keys[0] in group:  # one choice: setting one key replaces the others in the file
            for other in group:
                asked.pop(other, None)
    for key in keys[:-1]:
        inner = asked.setdefault(key, {})
        if not isinstance(inner, dict):
            inner = asked[key] = {"angle": inner}
        asked = inner
    asked[keys[-1]] = value
