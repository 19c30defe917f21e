"""What a folder has of a question that is asked again: its result, its units of work, or those of another question."""

from __future__ import annotations

import json
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from wucht.errors import InputError
from wucht.results.loading import load
from wucht.results.store import to_json
from wucht.studies.memory import questions_of
from wucht.studies.spec import Spec
from wucht.studies.subjects import subject_of

if TYPE_CHECKING:
    import xarray as xr


_MOST_DIFFERENCES = 3


def question_of(spec: Spec, subject: Any) -> dict[str, Any]:
    """What is asked of what, as JSON: two questions that are equal, but for titles, have the same answer.

    Raises ``InputError`` where the question cannot be asked of the subject.
    """
    facts = subject_of(spec).describe(subject).facts
    question: dict[str, Any] = json.loads(to_json({"study": spec.asked_of(subject), "machine": facts}))
    return question


def earlier(file: Path, spec: Spec, question: Mapping[str, Any]) -> tuple[xr.Dataset | None, list[str]]:
    """The finished result of the same question, if this file has it; and a note on one of another horizon.

    Raises ``InputError`` where the file, or the units of work beside it, are those of another question, and where the file was
    changed.
    """
    try:
        folder, result = file.parent, load(file) if file.exists() else None
    except InputError as error:
        raise error.within("--resume", ": ") from None
    answered = None if result is None else untitled(result.wucht.question)
    if result is not None and result.attrs["finished"] and answered == question:
        return result, []
    kept = questions_of(folder) or ([] if answered is None else [answered])
    if not kept or question in kept:
        return None, []
    asked = kept[0]
    before, now = asked["study"].get("kind"), spec.kind
    if before != now:
        raise InputError(
            "--resume", None, f"the result in {folder} answers study.kind = {before!r}, not {now!r}", code="other-study"
        )
    differing = differences(asked, question)
    if all(key.removeprefix("study.").split(".")[0] in spec.horizon for key in differing):
        return None, [f"{', '.join(differing)}: another than that of the result in the folder; it was begun anew"]
    shown = "; ".join(list(differing.values())[:_MOST_DIFFERENCES])
    more = f" and {len(differing) - _MOST_DIFFERENCES} more" if len(differing) > _MOST_DIFFERENCES else ""
    raise InputError("--resume", None, f"the result in {folder} answers another question: {shown}{more}", code="other-question")


def untitled(question: Any) -> Any:
    """A question without the titles of its subjects, which no answer depends on."""
    if isinstance(question, Mapping):
        return {key: untitled(value) for key, value in question.items() if key != "title"}
    return [untitled(each) for each in question] if isinstance(question, list) else question


def differences(before: Any, now: Any, path: str = "") -> dict[str, str]:
    """In which keys two questions differ, and how. ``contents`` is the hash of a table's file."""
    if isinstance(before, Mapping) and isinstance(now, Mapping):
        differing: dict[str, str] = {}
        for key in [*before, *(k for k in now if k not in before)]:
            if key == "contents" and before.get(key) != now.get(key):
                if _file_of(before) == _file_of(now):
                    differing[f"{path}file"] = f"the record {_file_of(now)} has changed"
                continue
            inner = path if key in ("machine", "parameters") else f"{path}{key}."
            differing |= differences(before.get(key), now.get(key), inner)
        return differing
    name = path.removesuffix(".")
    if name == "structure" and before != now:
        return {name: "the parts, curves, schedules or equations of the subject have changed"}
    return {} if before == now else {name: f"{name} was {_brief(before)}, now {_brief(now)}"}


def _file_of(table: Mapping[str, Any]) -> str | None:
    """The file that a table names, itself or a table in it."""
    named = [t.get("file") for t in (table, *table.values()) if isinstance(t, Mapping)]
    return next((str(n) for n in named if n is not None), None)


def _brief(value: Any) -> str:
    text = "not given" if value is None else repr(value)
    return text if len(text) <= 40 else f"{text[:36]} ..."
