"""``wucht answer``: all that the designer of a machine asks, one study after the other, as one report."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

import wucht
from wucht.cli.options import Imports, Settings, StudyName
from wucht.errors import InputError, WuchtError

if TYPE_CHECKING:
    from wucht.machines.purpose import Purpose
    from wucht.studies.study_file import StudyFile

_REPORT = "report.html"


@dataclass(frozen=True)
class DesignerQuestion:
    """A question about the machine of a file. settings: beside those of the command; folder: of its result."""

    kind: str
    settings: dict[str, str]
    folder: Path


@dataclass
class Answers:
    """Answers so far, by the kind of study.

    documents: contents of their summaries; sentences: as they are printed; refusals, failures: reasons why there is none, or
    not a complete one.
    """

    documents: dict[str, dict[str, Any]] = field(default_factory=dict)
    sentences: dict[str, str] = field(default_factory=dict)
    refusals: dict[str, InputError] = field(default_factory=dict)
    failures: dict[str, str] = field(default_factory=dict)
    is_interrupted: bool = False


def answer(
    study: StudyName,
    set_: Settings = None,
    out: Annotated[Path | None, typer.Option("-o", "--out", help="Output folder; default results/NAME.")] = None,
    as_json: Annotated[bool, typer.Option("--json", help="Print exactly one JSON object.")] = False,
    resume: Annotated[
        bool, typer.Option("--resume", help="Keep the complete results in the output folder, and continue.")
    ] = False,
    import_: Imports = None,
) -> None:
    """Ask all that the designer of a machine asks, and write the answers as one report."""
    from wucht.cli.options import parse_settings
    from wucht.cli.surroundings import interrupt_check
    from wucht.files.catalogue import short_name
    from wucht.reports.html_report import write_report
    from wucht.results.store import prepare_folder, to_json
    from wucht.studies.study_file import read_study

    start_time = time.perf_counter()
    study_file = read_study(study, parse_settings(set_ or []))
    folder, purpose = out or Path("results") / short_name(study_file.path), _purpose(study_file)
    prepare_folder(folder, [_REPORT])
    questions, answers = list(_questions(study_file, purpose, folder)), Answers()
    heading = f"{study_file.subject.title}: a {purpose}, {len(questions)} questions"
    with interrupt_check() as check:
        for number, question in enumerate(questions, 1):
            _ask(question, f"{number}/{len(questions)} {question.kind}", study, set_ or [], resume, answers, check)
            if not as_json:
                for line in [*([heading] if number == 1 else []), *_answer_lines(question, answers)]:
                    typer.echo(line)
            if answers.is_interrupted:
                break
    if answers.refusals and not (answers.documents or answers.failures or answers.is_interrupted):
        raise next(iter(answers.refusals.values()))
    with_result = [question.folder for question in questions if question.kind in answers.documents]
    report = write_report(with_result, folder / _REPORT, study_file.subject.title) if with_result else None
    error, code = _ending(answers, len(questions))
    if as_json:
        document = _document(study_file, answers, [str(report)] if report else [], time.perf_counter() - start_time)
        sys.stdout.write(to_json(document | ({"error": error, "exit_code": code} if code else {})) + "\n")
    elif report:
        typer.echo(f"report: {report}")
    if code:
        sys.stderr.write(f"wucht: {error}\n")
        raise typer.Exit(code)


def _purpose(study_file: StudyFile) -> Purpose:
    """What the machine of a file is built for. Raises ``InputError`` where neither the file nor its parts tell."""
    from wucht.files.building import purpose_in
    from wucht.machines.machine import Machine
    from wucht.machines.purpose import Purpose, purpose_of_parts

    if not isinstance(study_file.subject, Machine):
        explanation = "only of a machine it is known what its designer asks; `wucht run` answers the question of this file"
        raise InputError.file_error(study_file.path, explanation, code="no-machine")
    purpose = purpose_in(study_file.document.get("machine", {})) or purpose_of_parts(study_file.subject)
    if purpose is None:
        allowed = ", ".join(f'"{one}"' for one in Purpose)
        explanation = f"the parts do not tell what this machine is; give the key purpose in [machine], one of {allowed}"
        raise InputError("machine.purpose", None, explanation, code="missing").with_file(study_file.path)
    return purpose


def _questions(study_file: StudyFile, purpose: Purpose, folder: Path) -> Iterator[DesignerQuestion]:
    """The question of the file, and those that designers of such machines ask: one of each kind of study."""
    from wucht.studies.designer_questions import QUESTIONS
    from wucht.studies.machine_facts import facts_of_machine

    yield DesignerQuestion(study_file.spec.kind, {}, folder / study_file.spec.kind)
    facts = facts_of_machine(study_file.subject)
    for question in QUESTIONS[purpose]:
        settings = question.settings_after({}, facts)
        if settings is not None and (kind := settings["study.kind"]) != study_file.spec.kind:
            yield DesignerQuestion(kind, settings, folder / kind)


def _ask(
    question: DesignerQuestion,
    title: str,
    study: str,
    settings: list[str],
    resume: bool,
    answers: Answers,
    check: Callable[[], None],
) -> None:
    """Answer one question, and note its answer, or why there is none. Raises ``InputError`` for an option that is wrong."""
    from wucht.cli.options import parse_settings
    from wucht.cli.run import run_and_show
    from wucht.results.report import answer_in_print
    from wucht.studies.study_file import read_study

    all_settings = [*settings, *(f"{key}={value}" for key, value in question.settings.items())]

    def read_question() -> StudyFile:
        return read_study(study, parse_settings(all_settings))

    try:
        check()
        result, presentation = run_and_show(title, read_question, lambda *_: "", question.folder, resume=resume, check=check)
    except KeyboardInterrupt:
        answers.is_interrupted = True
        return
    except InputError as error:
        if error.location.startswith("-"):
            raise
        answers.refusals[question.kind] = error
        return
    except WuchtError as error:
        answers.failures[question.kind] = str(error)
        return
    answers.documents[question.kind], answers.sentences[question.kind] = presentation.document, answer_in_print(result)
    if result.attrs["failure"]:
        answers.failures[question.kind] = str(result.attrs["failure"])
    answers.is_interrupted = not result.attrs["finished"] and not result.attrs["failure"]


def _answer_lines(question: DesignerQuestion, answers: Answers) -> Iterator[str]:
    kind = question.kind
    if kind in answers.failures:
        yield f"  {kind:20} failed: {answers.failures[kind]}"
    elif kind in answers.refusals:
        yield f"  {kind:20} left out: {_reason(answers.refusals[kind])}"
    elif kind in answers.sentences:
        yield f"  {kind:20} {answers.sentences[kind]}"


def _reason(refusal: InputError) -> str:
    """A refusal without the file, which is the same for all questions."""
    return f"{refusal.key}: {refusal.explanation}" if refusal.key else refusal.explanation


def _ending(answers: Answers, count: int) -> tuple[str, int]:
    """The sentence and the exit code of what did not end as it should; code 0: all did."""
    if answers.is_interrupted:
        done = sum(not document.get("error") for document in answers.documents.values())
        return f"interrupted: {done} of {count} questions have an answer; --resume continues from there", 130
    if answers.failures:
        kinds = "; ".join(f"{kind}: {reason}" for kind, reason in answers.failures.items())
        return f"{len(answers.failures)} of {count} questions failed: {kinds}", 1
    return "", 0


def _document(study_file: StudyFile, answers: Answers, reports: list[str], elapsed_s: float) -> dict[str, Any]:
    """The object of ``--json``."""
    documents = answers.documents
    return {
        "study": "answer",
        "machine": study_file.subject.title,
        "summary": {kind: document["summary"] for kind, document in documents.items()},
        "left_out": {kind: str(error) for kind, error in answers.refusals.items()},
        "failed": answers.failures,
        "warnings": list(dict.fromkeys(warning for document in documents.values() for warning in document["warnings"])),
        "files": [*reports, *(file for document in documents.values() for file in document["files"])],
        "version": wucht.__version__,
        "elapsed_s": round(elapsed_s, 3),
    }
