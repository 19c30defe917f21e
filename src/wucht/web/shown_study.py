"""The study file of what a page shows -> the question, and its verdict. No file is read, and no code of the text is run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from wucht.dynamics.work import Report
from wucht.errors import InputError
from wucht.files.building import machine_from, with_settings
from wucht.files.documents import document_of, refuse_bare_frequencies, settings_in
from wucht.schema import refuse_unknown, require_table, text
from wucht.studies.study_file import DEFAULT_KIND, StudyFile, machine_study, run_study

_NAME = "study"


@dataclass(frozen=True)
class ShownVerdict:
    """label, sentence: as ``wucht run`` prints them; complete: whether the run went on to its end."""

    label: str
    sentence: str
    complete: bool


def shown_study(toml: str) -> StudyFile:
    """Return the question in the study file that a page shows.

    Parameters
    ----------
    toml : str
        A run-up, with the whole machine: as a page writes it, its ``use`` and measured tables are resolved.

    Returns
    -------
    StudyFile
        Its ``spec`` and ``subject`` can be run.

    Raises
    ------
    InputError
        For a wrong key or value, for another question than a run-up, and for what would have to be read from a file.
    """
    document = document_of(toml, Path(_NAME))
    refuse_unknown(document, ("title", "machine", "study"), "")
    table = dict(require_table(document, "machine", "machine"))
    if "use" in table:
        raise InputError("machine.use", table["use"], "not allowed here: no file is read, so the whole machine must be given")
    study = require_table(document, "study", "study") if "study" in document else {}
    if study.get("kind", DEFAULT_KIND) != DEFAULT_KIND:
        raise InputError("study.kind", study["kind"], f"must be {DEFAULT_KIND!r}: nothing else is judged here")
    description = with_settings(table, settings_in(table))
    refuse_bare_frequencies(description, "machine")
    machine = machine_from(description, text(document, "title", "") or "")
    question = machine_study(_NAME, machine, {"study": study} if study else {})
    return replace(question, document=dict(question.document) | {"machine": description})


def shown_verdict(toml: str, progress: Report) -> ShownVerdict:
    """Run the machine of a page up, and judge the run as ``wucht run`` does.

    Parameters
    ----------
    toml : str
        See ``shown_study``.
    progress : callable
        Called with the completed share and the current step; it may raise ``KeyboardInterrupt`` to stop the run.

    Returns
    -------
    ShownVerdict

    Raises
    ------
    InputError
        See ``shown_study``.
    RunError
        Where the memory does not suffice.
    """
    question = shown_study(toml)
    _refuse_several_runs(question.document["study"])
    result = run_study(question, progress=progress)
    failure = str(result.attrs["failure"])
    label, sentence = str(result.wucht.summary["outcome"]), failure or str(result.wucht.sentence)
    return ShownVerdict(label, sentence, bool(result.attrs["finished"] or failure))


def _refuse_several_runs(study: Mapping[str, object]) -> None:
    for key in ("starts", "along", "values"):
        if key in study:
            raise InputError(f"study.{key}", None, "not allowed here: one run is judged")
