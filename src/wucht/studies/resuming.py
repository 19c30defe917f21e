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
from wucht.studies.question_differences import differences, untitled
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
