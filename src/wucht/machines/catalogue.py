"""The catalogue: machines of the papers and of practice, each a TOML file in ``catalogue/``, addressed without its ending."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wucht.documents import Document, flatten, read_toml, refuse_unknown, table
from wucht.errors import InputError, nearest
from wucht.machines.files import machine_from, with_settings
from wucht.machines.machine import Machine

FOLDER = Path(__file__).parent / "catalogue"
TOP_LEVEL = ("title", "source", "notes", "machine", "study")
_DEEPEST = 8


def names() -> list[str]:
    """All catalogue names, such as ``drozdetskaya-2020/table-5.1``."""
    return sorted(str(p.relative_to(FOLDER).with_suffix("")) for p in FOLDER.rglob("*.toml"))


def locate(name: str, beside: Path | None = None) -> Path:
    """The file of a catalogue name or a path (relative to ``beside``). Raises ``InputError`` with the nearest known name."""
    direct = Path(name) if beside is None else beside / name
    if direct.is_file() or (direct.suffix == ".toml" and not _in_catalogue(name)):
        return direct
    if _in_catalogue(name):
        return FOLDER / f"{name}.toml"
    if direct.exists():
        raise InputError(str(direct), None, "this is no file; needed is a study file or a catalogue name")
    known = names()
    raise InputError(name, None, f"neither a file nor a catalogue name; {nearest(name, known)}")


def _in_catalogue(name: str) -> bool:
    return name in names()


def load_document(name: str, beside: Path | None = None) -> tuple[Document, Path]:
    """The document behind a name, its top level checked, and its file. Raises ``InputError``."""
    path = locate(name, beside)
    document = read_toml(path)
    try:
        refuse_unknown(document, TOP_LEVEL, "")
    except InputError as error:
        raise error.within(str(path), ": ") from None
    return document, path


def machine_table(document: Document, path: Path, depth: int = 0) -> Document:
    """The table ``[machine]`` of a document with ``use`` resolved and ``set`` applied. Raises ``InputError``."""
    described = dict(table(document, "machine", "machine"))
    if "use" not in described:
        return described
    extra = sorted(set(described) - {"use", "set", "title"})
    if extra:
        raise InputError(f"machine.{extra[0]}", None, "not allowed beside use; allowed there are set and title")
    if depth >= _DEEPEST:
        raise InputError("machine.use", described["use"], "these files use each other in a circle")
    inner, inner_path = load_document(str(described["use"]), path.parent)
    try:
        base = machine_table(inner, inner_path, depth + 1)
    except InputError as error:
        raise error.within(f"{inner_path}", ": ") from None
    base.setdefault("title", inner.get("title", ""))
    if "title" in described:
        base["title"] = described["title"]
    settings = described.get("set", {})
    if not isinstance(settings, dict):
        raise InputError("machine.set", settings, "allowed is a table: set = { PATH = VALUE }")
    return base | {"set": flatten(base.get("set", {})) | flatten(settings)}


def load_machine(name: str, settings: Mapping[str, Any] | None = None) -> Machine:
    """The machine of a catalogue name or study file, with parameters set by path.

    >>> load_machine("drozdetskaya-2020/table-5.1", {"u": 1.5}).values["u"]
    1.5

    Raises ``InputError`` for a wrong name, file, key or value.
    """
    document, path = load_document(name)
    try:
        described = machine_table(document, path)
        described.setdefault("title", document.get("title", name))
        own = flatten(described.pop("set", {})) | flatten(settings or {})
        return machine_from(with_settings(described, own))
    except InputError as error:
        raise error.within(str(path), ": ") from None
