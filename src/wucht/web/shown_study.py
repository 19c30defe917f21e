"""The study file of what a page shows -> the question, and its verdict. No file is read, and no code of the text is run."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any, cast

import numpy as np

from wucht.dynamics.run_ups.horizon import numbers_per_sample
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.work import Report, Work
from wucht.errors import InputError
from wucht.files.building import machine_from, with_settings
from wucht.files.documents import Document, document_of, refuse_bare_frequencies, settings_in
from wucht.files.equal_bodies import count_of_bodies
from wucht.schema import refuse_unknown, require_table, text
from wucht.studies.resource_limits import refuse_numbers, refuse_turns
from wucht.studies.study_file import DEFAULT_KIND, StudyFile, machine_study

MOST_BODIES = 100  # of a machine whose equations somebody waits for before a page: of these they take 20 s
_NAME = "study"


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
    refuse_many_bodies(table)
    description = with_settings(table, settings_in(table))
    refuse_many_bodies(description)
    refuse_bare_frequencies(description, "machine")
    machine = machine_from(description, text(document, "title", "") or "")
    question = machine_study(_NAME, machine, {"study": study} if study else {})
    return replace(question, document=dict(question.document) | {"machine": description})


def refuse_many_bodies(description: Document) -> None:
    """Raise ``InputError`` for the table of a machine that has more bodies than a page shows while somebody waits for it."""
    count = count_of_bodies(description)
    if count > MOST_BODIES:
        explanation = f"at most {MOST_BODIES} bodies are shown here; use `wucht run`, or `wucht share` for a page"
        raise InputError("machine.bodies", count, explanation, code="limits")


def shown_verdict(toml: str, progress: Report) -> tuple[str, str]:
    """Run the machine of a page up, and judge the run as ``wucht run`` does; nothing else of the run is worked out.

    Parameters
    ----------
    toml : str
        See ``shown_study``.
    progress : callable
        Called with the completed share and the current step; it may raise ``KeyboardInterrupt`` to stop the run.

    Returns
    -------
    label, sentence : str

    Raises
    ------
    InputError
        See ``shown_study``; for several runs, and for one that takes too long or too much memory.
    """
    question = shown_study(toml)
    machine, spec = question.subject, cast(Any, question.spec)  # that of a run-up
    if several := [key for key in ("starts", "along", "values") if key in question.document["study"]]:
        raise InputError(f"study.{several[0]}", None, "not allowed here: one run is judged")
    if machine.dimensionless:
        spec.refuse_units()
    refuse_turns(spec, machine)
    settings = replace(spec.settings, model="full") if spec.settings.model == "both" else spec.settings
    with np.errstate(all="ignore"):  # a failed run is reported by a sentence, not by warnings about overflow
        case = RunUpCase.of(machine, spec.start, settings)
        refuse_numbers(case.horizon.samples * numbers_per_sample(case.machine))
        *_, (motion, *_) = run_up(case, Work(reporter=progress))
        return str(motion.verdict.outcome), motion.trajectory.failure or motion.verdict.sentence
