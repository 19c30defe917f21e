"""What could be asked after a run: a command that is accepted for the file that was run."""

from __future__ import annotations

import shlex
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any
from warnings import catch_warnings

from wucht.cli.options import parse_settings
from wucht.errors import WuchtError

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.study_file import StudyFile


def next_command(
    study: StudyFile, result: xr.Dataset, folder: Path, name: str | None, settings: Sequence[str], imports: Sequence[str]
) -> str:
    """Return a command that could follow a finished run, with a comment on what it answers.

    Parameters
    ----------
    study : StudyFile
        The question that was answered.
    result : xarray.Dataset
    folder : Path
        Its folder.
    name : str, optional
        The file or catalogue name as it was given; None where there is not one file, as of a comparison.
    settings, imports : sequences of str
        The values of ``--set`` and ``--import`` of the run, which hold for the next one, too.

    Returns
    -------
    str
        The first question of the study's spec that follows from the answer and is accepted for the file; where there is none,
        the command that writes a report.
    """
    from wucht.studies.machine_facts import facts_of_machine, motors_that_start
    from wucht.studies.next_question import next_settings

    accessor = result.wucht
    facts = facts_of_machine(study.subject) | {"motors_that_start": motors_that_start(study.subject, accessor.summary)}
    proposals = () if name is None else next_settings(study.spec.next_questions, accessor.summary, accessor.spec | facts)
    for new_settings, answer in proposals:
        combination = _merged_settings(study, settings, new_settings)
        if name is not None and combination is not None:
            options = [word for item in combination for word in ("--set", item)] + [w for m in imports for w in ("--import", m)]
            return f"{shlex.join(['wucht', 'run', name, *options])}  # {answer}"
    report = shlex.join(["wucht", "report", str(folder), "-o", "report.html"])
    return f"{report}  # one file to send, with the figure, the machine and all numbers"


def _merged_settings(study: StudyFile, settings: Sequence[str], new_settings: Mapping[str, str]) -> list[str] | None:
    """The settings of the run with the new ones, as far as the next study has their keys; None if it does not accept them."""
    from wucht.studies.registry import studies
    from wucht.studies.study_file import read_study

    kind = new_settings.get("study.kind", study.spec.kind)
    spec = studies()[kind].study
    left_out = {*new_settings, "study.kind"} if kind != study.spec.kind else {*new_settings}
    combination = [item for item in settings if not _is_dropped(item, left_out, spec if kind != study.spec.kind else None)]
    combination += [f"{key}={value}" for key, value in new_settings.items()]
    try:
        with catch_warnings(action="ignore"):  # they were printed when the study was first read
            following = read_study(str(study.path), parse_settings(combination))
        following.spec.prepare(following.subject)  # which checks what depends on the machine
    except WuchtError:
        return None
    return combination


def _is_dropped(item: str, left_out: set[str], spec: Any) -> bool:
    """True if a setting is replaced, or belongs to a key that the next study lacks or means otherwise."""
    key = item.partition("=")[0].strip()
    if key in left_out:
        return True
    first = key.removeprefix("study.").split(".")[0]
    return spec is not None and key.startswith("study.") and (first not in set(spec.keys()) - set(spec.meaning))
