"""The one runner of all studies: time, progress, saving, resuming.

A study prepares, and its ``solve`` yields an answer whenever it has become more complete. The runner stores each completed unit
of work, saves the result from time to time, and returns the stored units when the question is repeated.
"""

from __future__ import annotations

import gc
import json
import time as clock
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from functools import partial
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.work import PREPARATION, Cluster, Report, Work
from wucht.environment import ONE_THREAD
from wucht.errors import InputError, WuchtError
from wucht.results.accessor import register_accessor
from wucht.results.attempts import Attempts, with_attempt_warnings
from wucht.results.output_folder import NEW, claim_folder, commit, remove_partial, save_partial
from wucht.results.output_folder import load_result as read_result
from wucht.results.provenance import provenance, refuse_edited_values
from wucht.results.report import is_of_version_0_1, lines_in_print, report_of
from wucht.results.store import RESULT, file_name, partial_name, prepare_folder, return_free_memory, save, to_json
from wucht.schema.key_values import is_whole
from wucht.studies.answer import Answer
from wucht.studies.assumptions import assumptions
from wucht.studies.cluster import cluster_at
from wucht.studies.figures import draw
from wucht.studies.figures import study_of_result as _study_of_result
from wucht.studies.memory import UnitMemory, begin_units, earlier_result, question_of, without_titles
from wucht.studies.processes import LocalProcesses
from wucht.studies.registry import studies
from wucht.studies.resource_limits import equations_note, memory_error, refuse_numbers, refuse_turns
from wucht.studies.study import Study
from wucht.studies.subjects import Description, is_name, named_subject, subject_of

if TYPE_CHECKING:
    import xarray as xr

__all__ = ["draw", "export", "load", "report", "run"]
Writer = Callable[["xr.Dataset", Path], object]
Presenter = Callable[["xr.Dataset", Path], Sequence[str] | None]
_SAVE_EVERY_S = 5.0  # an incomplete result, so that it can be inspected; saving takes at most a tenth of the time


@np.errstate(all="ignore")  # a failed run is reported by a sentence, not by warnings about overflow
def run(
    spec: Study,
    subject: Any,
    *,
    folder: Path | str | None = None,
    files: Sequence[str] = (RESULT,),
    resume: bool = False,
    progress: Report | None = None,
    document: Mapping[str, Any] | None = None,
    scheduler: str | None = None,
    processes: int = 1,
    write: Presenter | None = None,
    summarise: Writer | None = None,
    announce: Callable[[str], None] | None = None,
) -> xr.Dataset:
    """Answer a question.

    Parameters
    ----------
    spec : Study
        The question, such as ``wucht.RunUp(until="20 s")``.
    subject : Machine or other subject of the study
        Or the path of a file, or a catalogue name, that has it: ``"practice/screen"``.
    folder : path, optional
        Folder for ``result.nc`` and, until the study is finished, its units of work. An earlier result there is replaced by a
        complete one only. Until then, and where the study is interrupted or fails, its result so far is ``result.partial.nc``.
    files : names of files that will be written there
    resume : bool
        Reuse the units of work of this question in the folder.
    progress : callable, optional
        Called with the completed share (0 to 1) and the name of the current step. It may raise ``KeyboardInterrupt`` to stop
        the study: the result then has the answer so far, and its attribute ``finished`` is 0.
    document : mapping, optional
        The study file, stored in the result.
    scheduler : str, optional
        Address of a scheduler of dask.distributed, such as ``"tcp://host:8786"``: its workers compute instead of this
        process. Only for studies that are ``tiled``.
    processes : int
        Processes of this computer that compute, likewise.
    write : callable, optional
        Writes files that show the result, such as its figure: called with the result, which is in its place by then, and the
        folder for them. It returns sentences on what could not be written; they, and an error that it raises, become warnings
        of the result.
    summarise : callable, optional
        Writes the summary, which is put in its place together with the result: called likewise, and again after ``write``.
    announce : callable, optional
        Called with a sentence on what comes before the first progress, if that takes long, and on what is resumed.

    Returns
    -------
    xarray.Dataset
        Variables with ``long_name`` and ``units``; ``result.wucht`` has the summary. A failed run is recorded in it.

    Raises
    ------
    InputError
        If the question does not fit the subject or the computer's memory; if another run writes into the folder, or it has the
        units of another question, or no scheduler answers.
    RunError
        If the memory is full, workers have another version, or the scheduler disappears.
    """
    if not isinstance(spec, Study):
        raise InputError("study", str(spec), 'must be a question, such as wucht.RunUp(until="20 s")')
    if not is_whole(processes) or processes < 1 or (processes > 1 and scheduler is not None):
        raise InputError("processes", processes, "must be a whole number from 1 on, and 1 where a scheduler has the workers")
    if (scheduler is not None or processes > 1) and not spec.tiled:
        tiled_kinds = ", ".join(kind for kind, study in studies().items() if study.has_tiles)
        key, value = ("processes", processes) if scheduler is None else ("--scheduler", scheduler)
        computers = "processes" if scheduler is None else "machines"
        raise InputError(key, value, f"{spec.kind} runs in one process; several {computers} can compute {tiled_kinds}")
    if is_name(spec, subject):
        subject = named_subject(spec, subject)
    place = None if folder is None else Path(folder)
    with ONE_THREAD, cluster_at(scheduler) as cluster, nullcontext() if place is None else claim_folder(place):
        try:
            workers = LocalProcesses(processes) if processes > 1 else cluster
            return _compute_result(spec, subject, place, files, resume, progress, document, workers, write, summarise, announce)
        except MemoryError as error:
            raise memory_error(error) from None


def _compute_result(
    spec: Study,
    subject: Any,
    folder: Path | None,
    files: Sequence[str],
    resume: bool,
    progress: Report | None,
    document: Mapping[str, Any] | None,
    cluster: Cluster | None,
    write: Presenter | None,
    summarise: Writer | None,
    announce: Callable[[str], None] | None,
) -> xr.Dataset:
    register_accessor()
    start_time = clock.perf_counter()
    if announce is not None and (note := equations_note(subject)) is not None:
        announce(note)  # first of all: with so many bodies the checks take seconds, too
    description = subject_of(spec).describe(subject)
    if description.dimensionless:
        spec.refuse_units()
    refuse_turns(spec, subject)
    watch = partial(Work(reporter=progress).report, 0.0, PREPARATION)
    prepared = spec.prepare_watched(subject, watch)
    refuse_numbers(spec.stored_numbers(prepared))
    question = question_of(spec, subject, description)
    memory, notes, untitled_question = UnitMemory(), list[str](), without_titles(question)
    if folder is not None:
        folder = prepare_folder(folder, [*files, *map(partial_name, files)])
        if resume:
            complete_result, notes = earlier_result(folder, spec, untitled_question)
            if complete_result is not None:
                (announce or str)(f"the result in {folder} is complete: it is not computed again")
                UnitMemory(folder, untitled_question).forget()  # a kill may have come before the first run did so
                return _show(complete_result, folder, write, summarise)
        memory = begin_units(folder, untitled_question, resume, announce or str)

    def assemble_result(answer: Answer, is_finished: bool) -> xr.Dataset:
        return_free_memory()
        dataset = answer.to_dataset()
        study_warnings = [w for w in dataset.wucht.warnings if w not in description.warnings]
        return dataset.assign_attrs(
            _common_attributes(spec, subject, description, dataset)
            | provenance(question, clock.perf_counter() - start_time)
            | {
                "warnings": to_json([*description.warnings, *study_warnings, *notes], indent=None),
                "finished": int(is_finished and not dataset.attrs["failure"]),
            }
            | ({} if document is None else {"document": json.dumps(document, default=str)})
        )

    def save_unfinished(answer: Answer) -> None:
        if folder is not None:
            memory.flush()
            save_partial(assemble_result(answer, False), folder)
            gc.collect()  # a Dataset and its accessor refer to each other

    with memory.kept_on_error():
        answers = spec.solve(subject, prepared, Work(memory, progress, cluster))
        answer, is_interrupted = _last_answer(spec, answers, save_unfinished)
        if is_interrupted:
            memory.flush()
            remedy = "only a run with a folder can be resumed" if folder is None else "--resume continues from there"
            notes.append(f"interrupted: the result is incomplete; {remedy}")
        final = assemble_result(answer, not is_interrupted)
        del answer, answers  # what they have may be larger than the result
        if folder is not None:
            save(final, prepare_folder(folder / NEW) / file_name(RESULT, final))
            _commit(final, folder, summarise)
    if folder is not None and final.attrs["finished"]:
        remove_partial(folder)
    if not is_interrupted:
        memory.forget()
    return final if folder is None else _show(final, folder, write, summarise)


def _last_answer(spec: Study, answers: Iterable[Answer], save_unfinished: Callable[[Answer], None]) -> tuple[Answer, bool]:
    """The most complete answer, and True if Ctrl-C was pressed after the first one."""
    latest, save_time, pause = None, clock.perf_counter(), _SAVE_EVERY_S
    try:
        for latest in answers:
            if not isinstance(latest, Answer):
                what = f"{spec.kind!r} ({type(spec).__module__})"
                raise WuchtError(f"the study {what} has no answer: 'solve' must yield an Answer, not {latest!r:.40}")
            if clock.perf_counter() - save_time > pause:
                before = clock.perf_counter()
                save_unfinished(latest)
                save_time = clock.perf_counter()
                pause = max(_SAVE_EVERY_S, 9 * (save_time - before))
    except KeyboardInterrupt:
        if latest is None:
            raise
        return latest, True
    if latest is None:
        raise WuchtError(f"the study {spec.kind!r} ({type(spec).__module__}) has no answer: 'solve' must yield at least once")
    return latest, False


def _show(result: xr.Dataset, folder: Path, write: Presenter | None, summarise: Writer | None) -> xr.Dataset:
    """Write the files that show a result, which is in its folder already. What fails becomes a warning of the result."""
    if write is None:
        return result
    return_free_memory()
    new, attempts = prepare_folder(folder / NEW), Attempts()
    with attempts.attempt("the files that show it"):
        attempts.warnings += write(result, new) or []
    shown_result = with_attempt_warnings(result, attempts.warnings)
    if shown_result is not result:
        save(shown_result, new / file_name(RESULT, shown_result))
    _commit(shown_result, folder, summarise)
    return shown_result


def _commit(result: xr.Dataset, folder: Path, summarise: Writer | None) -> None:
    """Put the new files of a result in their places, with a summary."""
    if summarise is not None:
        summarise(result, folder / NEW)
    commit(folder)


def _common_attributes(spec: Study, subject: Any, description: Description, dataset: xr.Dataset) -> dict[str, Any]:
    """Attributes of every result, complete or not."""
    module = type(spec).__module__
    return {
        "study": spec.kind,
        "contents": to_json([str(name) for name in dataset.variables], indent=None),
        "title": description.title,
        "dimensionless": int(description.dimensionless),
        "assumed": to_json([*assumptions(spec, subject), *dataset.wucht.assumed], indent=None),
        "notes": to_json(list(description.notes), indent=None),
        "parts": to_json(list(description.parts), indent=None),
        **({} if module.startswith("wucht.") else {"study_module": module}),
    }


def load(path: Path | str) -> xr.Dataset:
    """Read a result.

    Parameters
    ----------
    path : path of a ``result.nc``, or of the output folder that has one

    Returns
    -------
    xarray.Dataset
        With the accessor ``result.wucht``.

    Raises
    ------
    InputError
        If there is no such file, or it was not written by wucht.
    """
    return read_result(Path(path))


def report(result: xr.Dataset) -> list[str]:
    """Report the answer of a result in words, from the Dataset alone.

    Parameters
    ----------
    result : xarray.Dataset

    Returns
    -------
    list of str
        Line by line, as the command line prints it. They are data of the result: its study need not be installed.

    Raises
    ------
    InputError
        As ``draw`` does; for an unknown study where the result has no lines.
    """
    is_known = result.attrs.get("study") in studies() or result.wucht.stored_report is None
    if is_known and not is_of_version_0_1(result):
        with _study_of_result(result) as entry:
            return lines_in_print(entry.drawer.report(result), result)
    with refuse_edited_values(result):
        return lines_in_print(report_of(result), result)


def export(result: xr.Dataset, folder: Path | str) -> list[str]:
    """Export a result to files for other programs: of a cam the points to mill, drawings and tables for controllers.

    Parameters
    ----------
    result : xarray.Dataset
    folder : path
        Folder for the files; made if it is missing.

    Returns
    -------
    list of str
        A line for each file: its name, and the deviation of the file's content, read back, from the result.

    Raises
    ------
    InputError
        As ``draw`` does; for a study without such files.
    """
    with _study_of_result(result) as entry:
        if not entry.study.exports():
            kinds = " and ".join(kind for kind, candidate in studies().items() if candidate.study.exports())
            explanation = f"results of this study cannot be exported to files of a workshop; those of {kinds} can"
            raise InputError(entry.kind, None, explanation, code="not-exported")
        return entry.drawer.export(result, Path(folder))
