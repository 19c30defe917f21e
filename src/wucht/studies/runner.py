"""The one runner of all studies: time, progress, saving, resuming.

A study prepares a plan, and its ``run`` yields what is found, more and more complete. The runner keeps each unit of work that
is done, saves the result now and then, and hands units back when the same question is asked again.
"""

from __future__ import annotations

import json
import time as clock
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, nullcontext, suppress
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.dynamics.work import Report, Work
from wucht.errors import InputError, WuchtError
from wucht.plots.arranging import arrange
from wucht.plots.page import PRINT, Page, made_for
from wucht.plots.sheet import state
from wucht.results.accessor import register
from wucht.results.output_folder import NEW, claimed, commit
from wucht.results.output_folder import load as read_result
from wucht.results.provenance import provenance, refusing_edited
from wucht.results.store import RESULT, prepare_folder, return_free_memory, save, to_json
from wucht.studies.assumptions import assumptions
from wucht.studies.cluster import Cluster, cluster_at
from wucht.studies.memory import Memory, earlier, question_of, questions_of, untitled
from wucht.studies.registry import Study, studies, study_of
from wucht.studies.room import out_of_memory, refuse_numbers, refuse_turns
from wucht.studies.spec import Spec
from wucht.studies.subjects import Description, subject_of

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

Writer = Callable[["xr.Dataset", Path], object]
_SAVE_EVERY_S = 5.0  # a result that is not complete, so that it can be looked at; at most a tenth of the time goes into it


@np.errstate(all="ignore")  # a run that fails says so in a sentence, not by warnings about overflow
def run(
    spec: Spec,
    subject: Any,
    *,
    folder: Path | str | None = None,
    files: Sequence[str] = (RESULT,),
    resume: bool = False,
    progress: Report | None = None,
    document: Mapping[str, Any] | None = None,
    scheduler: str | None = None,
    write: Writer | None = None,
) -> xr.Dataset:
    """Answer a question.

    Parameters
    ----------
    spec : Spec
        What is asked, such as ``wucht.RunUp(until="20 s")``.
    subject : Machine or whatever the spec is asked of
    folder : path, optional
        Where ``result.nc`` and, until the study is finished, its units of work are kept. An earlier result there is replaced
        when the study ends or is interrupted; until then what was computed lies in its sub-folder ``.wucht-new``. Where the
        study or a file fails, the earlier result stays as it was.
    files : names of files that will be written there
    resume : bool
        Take up the units of work that the folder has of this question.
    progress : callable, optional
        Called with the share that is done (0 to 1) and what is under way. It may raise ``KeyboardInterrupt`` to stop the study:
        the result has what was computed until then, and its attribute ``finished`` is 0.
    document : mapping, optional
        The study file, for the record.
    scheduler : str, optional
        Address of a scheduler of dask.distributed, such as ``"tcp://host:8786"``: its workers compute. By default this process
        does. Only of studies whose specs are ``tiled``.
    write : callable, optional
        Writes what belongs to the result, such as its figure: called with the result and the folder for it. With ``result.nc``
        its files replace the earlier ones.

    Returns
    -------
    xarray.Dataset
        Variables with ``long_name`` and ``units``; ``result.wucht`` has the summary. A run that fails is recorded in it.

    Raises
    ------
    InputError
        Where the question does not fit the subject, or the machine that computes; where another run writes into the folder, or
        it has the units of another question, or no scheduler answers.
    RunError
        Where the memory is full, workers are of another version, or the scheduler goes away.
    """
    if not isinstance(spec, Spec):
        raise InputError("study", str(spec), 'must be what is asked, such as wucht.RunUp(until="20 s")')
    if scheduler is not None and not spec.tiled:
        tiled = ", ".join(kind for kind, study in studies().items() if study.tiled)
        raise InputError("--scheduler", scheduler, f"{spec.kind} is computed by one process; studies with tiles are {tiled}")
    place = None if folder is None else Path(folder)
    with cluster_at(scheduler) as cluster, nullcontext() if place is None else claimed(place):
        try:
            return _answered(spec, subject, place, files, resume, progress, document, cluster, write)
        except MemoryError as error:
            raise out_of_memory(error) from None


def _answered(
    spec: Spec,
    subject: Any,
    folder: Path | None,
    files: Sequence[str],
    resume: bool,
    progress: Report | None,
    document: Mapping[str, Any] | None,
    cluster: Cluster | None,
    write: Writer | None,
) -> xr.Dataset:
    register()
    begun, study = clock.perf_counter(), study_of(spec.kind)
    study.check()
    subject_is = subject_of(spec).describe(subject)
    if subject_is.dimensionless:
        spec.refuse_units()
    refuse_turns(spec, subject)
    plan = study.prepare(spec, subject)
    refuse_numbers(study.numbers(plan))
    solve = study.run  # loaded before units are read back, which are of its classes
    question = question_of(spec, subject)
    memory, notes, asked = Memory(), list[str](), untitled(question)
    if folder is not None:
        folder = prepare_folder(folder, files)
        new = prepare_folder(folder / NEW)
        if resume:
            finished, notes = earlier(folder / RESULT, spec, asked)
            if finished is not None:
                _commit(finished, folder, write)
                return finished
        resumed = resume and asked in questions_of(folder)
        memory = (Memory.resumed if resumed else Memory.begun)(folder, asked)

    def result(findings: Any, finished: bool) -> xr.Dataset:
        return_free_memory()
        made: xr.Dataset = study.dataset(plan, findings)
        own = [w for w in made.wucht.warnings if w not in subject_is.warnings]
        return made.assign_attrs(
            _common(spec, subject, subject_is, made)
            | provenance(question, clock.perf_counter() - begun)
            | {
                "warnings": to_json([*subject_is.warnings, *own, *notes], indent=None),
                "finished": int(finished and not made.attrs["failure"]),
            }
            | ({} if document is None else {"document": json.dumps(document, default=str)})
        )

    def save_unfinished(findings: Any) -> None:
        if folder is not None:
            memory.flush()
            save(result(findings, False), new / RESULT)

    try:
        findings, interrupted = _last(study, solve(plan, Work(memory, progress, cluster)), save_unfinished)
        if interrupted:
            memory.flush()
            notes.append("interrupted: this is what was found until then; --resume continues from there")
        if memory.is_large:
            memory.flush()
        final, findings = result(findings, not interrupted), None  # which may be larger than the result: no more needed
        if folder is not None:
            save(final, new / RESULT)
            _commit(final, folder, write)
    except BaseException:
        with suppress(WuchtError):  # that of the study says more
            memory.flush()
        raise
    if not interrupted:
        memory.forget()
    return final


def _last(study: Study, findings: Iterable[Any], save_unfinished: Callable[[Any], None]) -> tuple[Any, bool]:
    """The most complete findings, and whether Ctrl-C was pressed after the first ones."""
    latest, saved, pause = None, clock.perf_counter(), _SAVE_EVERY_S
    try:
        for latest in findings:
            if clock.perf_counter() - saved > pause:
                before = clock.perf_counter()
                save_unfinished(latest)
                saved = clock.perf_counter()
                pause = max(_SAVE_EVERY_S, 9 * (saved - before))
    except KeyboardInterrupt:
        if latest is None:
            raise
        return latest, True
    if latest is None:
        raise WuchtError(
            f"the study {study.kind!r} ({study.package}) has no result: its function 'run' must yield at least once"
        )
    return latest, False


def _commit(result: xr.Dataset, folder: Path, write: Writer | None) -> None:
    """Put a result, and what is written of it, in the place of an earlier one."""
    if write is not None:
        return_free_memory()
        write(result, folder / NEW)
    commit(folder)


def _common(spec: Spec, subject: Any, about: Description, made: xr.Dataset) -> dict[str, Any]:
    """Attributes that every result has, whenever it is saved."""
    return {
        "study": spec.kind,
        "contents": to_json([str(name) for name in made.variables], indent=None),
        "title": about.title,
        "dimensionless": int(about.dimensionless),
        "assumed": to_json([*assumptions(spec, subject), *made.wucht.assumed], indent=None),
        "notes": to_json(list(about.notes), indent=None),
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
        If there is no such file, or it is none of ours.
    """
    return read_result(Path(path))


def draw(result: xr.Dataset, page: Page = PRINT) -> Figure:
    """The figure of a result, from the Dataset alone.

    Parameters
    ----------
    result : xarray.Dataset
    page : Page
        On what it is printed: ``PRINT``, or ``JOURNAL``, a column of 88 mm without a title. What would be taller there than
        230 mm has lower panels, or goes across both columns (180 mm).

    Returns
    -------
    matplotlib.figure.Figure

    Raises
    ------
    InputError
        For a study that is not known here, or a Dataset that lacks variables which the result had.
    """
    with _study_of_result(result) as study:
        for tried in (page, *page.instead):
            with made_for(tried):
                drawn: Figure = study.figure(result)
                state(drawn, result.wucht.assumed)
            if arrange(drawn).get_figheight() <= tried.tallest:
                break
    return drawn


def report(result: xr.Dataset) -> list[str]:
    """The answer of a result in words, from the Dataset alone.

    Parameters
    ----------
    result : xarray.Dataset

    Returns
    -------
    list of str
        Line by line, as the command line prints it.

    Raises
    ------
    InputError
        As ``draw`` does.
    """
    with _study_of_result(result) as study:
        lines: list[str] = study.report(result)
        assumed = "; ".join(result.wucht.assumed)
    return [*lines, f"  assumed      {assumed}"] if assumed else lines


def export(result: xr.Dataset, folder: Path | str) -> list[str]:
    """Write the files of a result that are for others: of a cam the points to mill, drawings and tables for controllers.

    Parameters
    ----------
    result : xarray.Dataset
    folder : path
        Where they are written; made if it is not there.

    Returns
    -------
    list of str
        A line for each file: its name, and how far what was read back lies from what it stands for.

    Raises
    ------
    InputError
        As ``draw`` does; for a study that has no such files.
    """
    with _study_of_result(result) as study:
        if not study.exports:
            raise InputError(study.kind, None, "this study has no files for others; cam-contour has")
        lines: list[str] = study.export(result, Path(folder))
    return lines


@contextmanager
def _study_of_result(result: xr.Dataset) -> Iterator[Study]:
    """The study of a result. What its functions stumble over in one that may have been edited is an ``InputError``."""
    kind, known = result.attrs.get("study"), studies()
    if kind not in known:
        raise InputError("study", kind, "there is no figure for this study")
    contents = result.wucht.contents if "contents" in result.attrs else ["contents"]
    missing = [n for n in contents if n not in result.variables]
    if missing:
        raise InputError(kind, None, f"this is no complete result of this study: {', '.join(missing)} is missing")
    with refusing_edited(result):
        yield known[kind]
