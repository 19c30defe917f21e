"""A study file or catalogue entry -> the page of its machine, with the verdict of Python's run."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any, cast

from wucht.dynamics.live_machine import export_obstacles
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import owners
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.errors import InputError
from wucht.files.building import given_keys
from wucht.files.catalogue import load_document, machine_of, short_name
from wucht.files.documents import Document
from wucht.files.toml_text import toml_text
from wucht.machines.parts.base import Body
from wucht.reports.html_report import place_of_page
from wucht.results.store import replace_file
from wucht.studies.study_file import DEFAULT_KIND, StudyFile, machine_study, read_study, run_study
from wucht.web.cards import card_of
from wucht.web.live_page import PageText, live_page


def shared_page(
    name: str,
    settings: Mapping[str, Any] | None = None,
    verdict: bool | None = None,
    *,
    server: str | None = None,
    is_embedded: bool = False,
) -> str:
    """Return the page of the machine of a study file or catalogue entry.

    Parameters
    ----------
    name : path of a study file, or a catalogue name
    settings : mapping, optional
        Values by path, as for ``read_study``.
    verdict : bool, optional
        Whether Python runs the machine up for a verdict; by default where that is the file's question.
    server, is_embedded : see ``PageText``

    Returns
    -------
    str

    Raises
    ------
    InputError
        For a wrong name, file, key or value, and for a machine that cannot be exported.
    WuchtError
        Where the page was not built when this package was installed.
    """
    study_file, is_question = shareable_study(name, settings)
    is_judged = is_question and is_one_run(study_file) if verdict is None else verdict
    name_in_page = short_name(study_file.path)
    page_text = PageText(str(name_in_page), card=card_of(name_in_page.as_posix()), server=server, is_embedded=is_embedded)
    try:
        return study_page(study_file, page_text, is_judged)
    except InputError as error:
        raise error if error.file else error.with_file(study_file.path) from None


def shareable_study(name: str, settings: Mapping[str, Any] | None = None) -> tuple[StudyFile, bool]:
    """Return the run-up that the page of a study file or catalogue entry shows, without its equations.

    Parameters
    ----------
    name : path of a study file, or a catalogue name
    settings : mapping, optional
        Values by path, as for ``read_study``.

    Returns
    -------
    StudyFile, bool
        And whether the file asks for it. Of another question its start and end are used.

    Raises
    ------
    InputError
        For a wrong name, file, key or value, for a file without a machine, and for one whose bodies are released.
    """
    document, path = load_document(name)
    if "machine" not in document:
        raise InputError("machine", None, "a live machine needs a table [machine]: this file has none").with_file(path)
    try:
        study_file, is_question = _run_up_of(document, path, name, settings or {})
        _refuse_releases(study_file)
        return study_file, is_question
    except InputError as error:
        raise error if error.file else error.with_file(path) from None


def is_one_run(study_file: StudyFile) -> bool:
    """Whether the question of a run-up is about one run."""
    spec = cast(Any, study_file.spec)
    return not spec.starts and not spec.values


def study_page(study_file: StudyFile, page_text: PageText, is_judged: bool) -> str:
    """Return the page of a run-up.

    Parameters
    ----------
    study_file : StudyFile
        Without a table ``[machine]`` in its document the page has no study file to copy.
    page_text : PageText
        With the texts that are not in the study file.
    is_judged : bool
        Whether Python runs the machine up for a verdict.

    Returns
    -------
    str

    Raises
    ------
    InputError
        For a start that does not fit the machine, and for a machine that cannot be exported.
    WuchtError
        Where the page was not built when this package was installed.
    """
    machine, spec = study_file.subject, cast(Any, study_file.spec)  # that of a run-up
    _refuse_releases(study_file)
    if obstacles := export_obstacles(machine):
        raise InputError("machine", None, f"not allowed in a live machine: {'; '.join(obstacles)}", code="not-exported")
    start = spec.start if not spec.starts else spec.starts[0]
    run = RunUpCase.of(machine, start, replace(spec.settings, model="full", inertia=None))
    description = study_file.document.get("machine")
    result = run_study(study_file) if is_judged else None
    text = replace(
        page_text,
        machine="" if description is None else toml_text({"title": machine.title, "machine": description}),
        study=_study_text(study_file),
        start=_start_text(with_default_start(machine, start)),  # as shown, whatever is changed in the page
        start_of_parts=_start_text({name: start[name] for name in owners(machine) if name in start}),
        verdict=None if result is None else (str(result.wucht.summary["outcome"]), str(result.wucht.sentence)),
        file_keys=None if machine.dimensionless or description is None else given_keys(description),
    )
    end = run.horizon.first if result is None else float(result["time"].values[-1])
    return live_page(run.machine, run.models[0].initial, end, run.horizon.span, text)


def write_page(name: str, file: Path, settings: Mapping[str, Any] | None = None, verdict: bool | None = None) -> Path:
    """Write the page of a study file or catalogue entry; see ``shared_page``. An earlier file is replaced as a whole.

    Raises ``InputError`` if the file is a folder or no page of HTML, ``RunError`` if it cannot be written.
    """
    place = place_of_page(file, "machine.html")
    content = shared_page(name, settings, verdict).encode("utf-8")
    return replace_file(place, lambda temporary_file: temporary_file.write_bytes(content))


def _refuse_releases(study_file: StudyFile) -> None:
    """Raise ``InputError`` at the first of the bodies that are released during the run."""
    machine = study_file.subject
    first, *later_names = [b.name for b in machine.bodies if b.release is not None] or [""]
    if not first:
        return
    parts = [p for p in machine.parts if isinstance(p, Body)]
    index = [p.name for p in parts].index(first)
    release = parts[index].release
    further = f"; {', '.join(later_names)} {'has' if len(later_names) == 1 else 'have'} one, too" if later_names else ""
    raise InputError(
        f"machine.bodies[{index}] ({first}).release",
        None if release is None else release.model_dump(exclude_none=True),
        f"not allowed in a live machine, whose bodies are free from the start{further}",
        code="not-exported",
    )


def _run_up_of(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[StudyFile, bool]:
    """Return the run-up of a file's machine, and whether the file asks for it. Of another question start and end are used."""
    question = document.get("study", {})
    if question.get("kind", DEFAULT_KIND) == DEFAULT_KIND:
        return read_study(name, settings), True
    usable = {f"study.{k}": question[k] for k in ("start", "until") if isinstance(question.get(k), dict | str | float | int)}
    of_study = usable | {k: v for k, v in settings.items() if k.startswith("study.")}
    machine, description = machine_of(document, path, name, {k: v for k, v in settings.items() if k not in of_study})
    study_file = machine_study(name, machine, of_study)
    return replace(study_file, path=path, document=study_file.document | {"machine": description}), False


def _start_text(start: Mapping[str, Any]) -> str:
    return toml_text({"study": {"start": dict(start)}}).removeprefix("[study]\n").lstrip() if start else ""


def _study_text(study_file: StudyFile) -> str:
    """Return the table of the question, without its start and what makes several runs of it."""
    table = {k: v for k, v in study_file.document["study"].items() if k not in ("start", "starts", "along", "values", "until")}
    return toml_text({"study": table})
