"""File -> Machine: the machine part of a study file, checked key by key."""

from __future__ import annotations

import copy
from typing import Any

from wucht.checking import checked, choice, refuse_unknown, table, text
from wucht.errors import InputError
from wucht.files.documents import Document, no_nan
from wucht.files.reading import read_bodies, read_carrier, read_shafts
from wucht.files.settings import with_settings
from wucht.machines.assembly import BESIDE_A_MODEL
from wucht.machines.machine import Machine
from wucht.machines.models import models
from wucht.machines.parts import drives, loads

KEYS = (
    "title", "use", "set", "model", "parameters", "carrier", "bodies", "drive", "drives", "load", "loads", "tracks", "schedules"
)  # fmt: skip


def machine_from(document: Document, title: str = "") -> Machine:
    """The machine described by a table ``[machine]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``machine`` on.
    """
    document = copy.deepcopy(document)
    settings = document.pop("set", {})
    if not isinstance(settings, dict):
        raise InputError("machine.set", settings, "allowed is a table: set = { PATH = VALUE }")
    no_nan(document, "machine")
    refuse_unknown(document, KEYS, "machine")
    document = with_settings(document, settings)
    title = text(document, "title", "machine") or title
    document.pop("title", None)
    return _from_model(document, title) if "model" in document else _from_parts(document, title)


def _from_model(document: Document, title: str) -> Machine:
    name = choice(document, "model", "machine", models())
    for key in ("carrier", "bodies", "drive", "drives", "load", "loads", "tracks"):
        if key in document:
            raise InputError(f"machine.{key}", None, BESIDE_A_MODEL.format(name))
    model = checked(models()[name], table(document, "parameters", "machine.parameters"), "machine.parameters")
    return _built(document, model, title=title)


def _from_parts(document: Document, title: str) -> Machine:
    if "parameters" in document:
        raise InputError("machine.parameters", None, "allowed only with model = ...; SI machines carry values in their parts")
    bodies, where = read_bodies(document)
    carrier = read_carrier(document)
    of_drives, at = read_shafts(document, "drive", drives())
    of_loads, there = read_shafts(document, "load", loads())
    return _built(
        document, carrier, bodies, of_drives, of_loads, tracks=document.get("tracks"), title=title, where=where | at | there
    )


def _built(document: Document, *parts: Any, **others: Any) -> Machine:
    """The machine of these parts. Raises ``InputError``, seen from the file."""
    try:
        return Machine(*parts, schedules=document.get("schedules", ()), **others)
    except InputError as error:
        raise error.within("machine") from None
