"""The live machine in a cell of a notebook: the page, in a frame of its own, which sends the study file of what it shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import cache
from pathlib import Path
from typing import Any

from wucht.errors import InputError, WuchtError
from wucht.files.machine_tables import machine_table
from wucht.machines.machine import Machine
from wucht.studies.study import Study
from wucht.studies.study_file import machine_study
from wucht.web.live_page import PageText, built_file
from wucht.web.shared_study import shared_page, study_page
from wucht.web.shown_study import shown_study


def live(
    machine: Machine | str | Path, start: Mapping[str, Any] | None = None, until: float | str | None = None, height: int = 720
) -> Any:
    """Show a machine in a cell of a notebook: it moves, and answers while the hand still moves.

    Parameters
    ----------
    machine : Machine, path of a study file, or a catalogue name
    start : mapping, optional
        As in a study file: ``{"p1": "0.3 rad"}``; by default that of the file, or at rest.
    until : float or str, optional
        The end of the run, in s or with a unit; by default that of the file, or until the machine has settled.
    height : int, optional
        Of the cell, in pixels.

    Returns
    -------
    anywidget.AnyWidget
        Its trait ``study`` is the study file of what is shown, as text; it is empty where no file can say what the machine is.
        Its method ``question`` returns what ``wucht.run`` takes: ``wucht.run(*widget.question())``.

    Raises
    ------
    InputError
        For a wrong name, file, key or value, for a machine that cannot be exported, and where ``wucht[notebook]`` is missing.
    WuchtError
        Where the page was not built when this package was installed.
    """
    widget = _widget_class()
    options = {"study.start": start, "study.until": until}
    settings = {key: value for key, value in options.items() if value is not None}
    if isinstance(machine, Machine):
        page = _machine_page(machine, settings)
    elif isinstance(machine, str | Path):
        page = shared_page(str(machine), settings, is_embedded=True)
    else:
        raise InputError("machine", machine, "must be a wucht.Machine, the path of a study file, or a catalogue name")
    return widget(page=page, height=height)


def _machine_page(machine: Machine, settings: Mapping[str, Any]) -> str:
    """The page of a machine that is in no file: its study file is written from its parts, as far as they say what it is."""
    study_file = machine_study(machine.title or "machine", machine, settings)
    try:
        study_file = replace(study_file, document=study_file.document | {"machine": machine_table(machine)})
        reason = ""
    except WuchtError as error:
        reason = str(error)
    page_text = PageText(machine.title, is_embedded=True, reason=reason)
    return study_page(study_file, page_text, is_judged=True)


@cache
def _widget_class() -> Any:
    """The class of the widget. Raises ``InputError`` where anywidget is missing."""
    try:
        import anywidget
        import traitlets
    except ModuleNotFoundError:
        raise InputError("live", None, "this needs the extra: pip install wucht[notebook]", code="no-extra") from None

    class LiveWidget(anywidget.AnyWidget):  # type: ignore[misc]
        """The page of a machine in a cell. page: HTML; study: the study file of what is shown; height: in pixels."""

        _esm = built_file("widget.js")
        page = traitlets.Unicode("").tag(sync=True)
        study = traitlets.Unicode("").tag(sync=True)
        height = traitlets.Int(720, min=100).tag(sync=True)

        def question(self) -> tuple[Study, Machine]:
            """Return the question and the machine that are shown. Raises ``InputError``."""
            if not self.study:
                raise InputError(
                    "study", None, "no study file was received from the page yet: show the widget in a cell of a notebook first"
                )
            study_file = shown_study(self.study)
            return study_file.spec, study_file.subject

    return LiveWidget
