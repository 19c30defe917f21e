"""The catalogue: machines and equations, of the papers and of practice, each a TOML file addressed without its ending."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path
from typing import Any, TypeVar

from wucht.errors import InputError, nearest
from wucht.file_names import printable, safe_name
from wucht.files.building import MACHINE_KEYS, machine_from, with_settings
from wucht.files.documents import Document, changed_title, flatten, read_toml, refuse_bare_frequencies, settings_in
from wucht.files.equal_bodies import of_all_first
from wucht.files.own_equations import OwnEquations, equations_from, with_values
from wucht.files.tables import with_tables
from wucht.machines.machine import Machine
from wucht.schema import refuse_unknown, table, text

T = TypeVar("T")
FOLDER = Path(__file__).parent.parent / "machines" / "catalogue"
ABOUT = ("title", "source", "notes", "study")
TOP_LEVEL = (*ABOUT, "machine", "system", "law", "follower", "linkage", "speed", "shaft")
# Keys that may be written above their table by mistake.
_INSIDE = dict.fromkeys(MACHINE_KEYS, "machine") | dict.fromkeys(("kind", "until", "settled", "start"), "study")


def names() -> list[str]:
    """All catalogue names, such as ``drozdetskaya-2020/table-5.1``."""
    return sorted(str(p.relative_to(FOLDER).with_suffix("")) for p in FOLDER.rglob("*.toml"))


def short_name(path: Path) -> Path:
    """Short name of a file, independent of its folder: its catalogue name, else its name without the ending."""
    own = path.resolve()
    if own.is_relative_to(FOLDER):
        return own.relative_to(FOLDER).with_suffix("")
    return Path(safe_name(path.name.removesuffix(".toml")))


def locate(name: str, beside: Path | None = None) -> Path:
    """The file of a catalogue name or a path (relative to ``beside``). Raises ``InputError`` with the nearest known name."""
    direct = Path(name) if beside is None else beside / name
    try:
        if direct.is_file():
            return direct
        known = names()
        if name.removesuffix(".toml") in known:
            return FOLDER / f"{name.removesuffix('.toml')}.toml"
        if direct.exists():
            raise InputError.of_file(direct, "this is no file; a study file or a catalogue name is needed")
    except (OSError, ValueError) as error:
        raise InputError(name, None, f"this cannot be the name of a file: {error}") from None
    if direct.suffix == ".toml":
        raise InputError.of_file(direct, "there is no such file")
    raise InputError(name, None, f"neither a file nor a catalogue name; {nearest(name, known)}", code="unknown-name")


def load_document(name: str, beside: Path | None = None) -> tuple[Document, Path]:
    """The document behind a name, its top level checked, and its file. Raises ``InputError``."""
    path = locate(name, beside)
    document = read_toml(path)
    try:
        for key in (k for k in document if k not in TOP_LEVEL and k in _INSIDE):
            raise InputError(key, document[key], f"this key belongs in the table [{_INSIDE[key]}]")
        refuse_unknown(document, TOP_LEVEL, "")
        for key in ("title", "source", "notes"):
            text(document, key, "")
    except InputError as error:
        raise error.in_file(path) from None
    return document, path


def used_table(document: Document, path: Path, key: str) -> tuple[Document, Document]:
    """The table ``[machine]`` or ``[system]`` of a document with ``use`` resolved, and the settings beyond its title.

    The title is that of the table, else of its file, else of the table it uses; none where none of them has one. Settings of
    tables up to the one with the title are merged into its ``set``; the others, which the title does not cover, are returned
    beside it. Schedules that a machine adds to the one it uses come before those of that one, and replace those of the same
    parameters. Raises ``InputError``, which names the file if it is not this one.
    """
    seen, settings, titles, added = [path.resolve()], list[Document](), list[Any](), list[list[Document]]()
    used: Path | None = path
    while used is not None:
        try:
            described = dict(table(document, key, key))
            settings.append(settings_in(described, key))
            titles.append(text(described, "title", key) or document.get("title"))
            added.append(_added_schedules(described) if key == "machine" and "use" in described else [])
            used = _used(described, path, key, seen) if "use" in described else None
            described = with_tables(described, path.parent) if key == "machine" and used is None else described
        except InputError as error:
            raise error if len(seen) == 1 else error.in_file(path) from None
        if used is not None:
            document, path = load_document(str(used))
            seen.append(path.resolve())
    titled = next((k for k, title in enumerate(titles) if title), None)
    over_time = {str(s.get("parameter")): "over time" for of_file in added[:titled] for s in of_file}
    title = {} if titled is None else {"title": changed_title(str(titles[titled]), over_time)}
    described = _with_schedules(described, added) | title
    return described | {"set": _merged(settings[titled:])}, _merged(settings[:titled] if titled else [])


def _added_schedules(described: Document) -> list[Document]:
    """Remove the schedules from a table that uses another. Raises ``InputError`` if they are not tables."""
    given = described.pop("schedules", [])
    if not isinstance(given, list) or not all(isinstance(s, dict) for s in given):
        raise InputError("machine.schedules", given, "must be tables: [[machine.schedules]]")
    return given


def _with_schedules(described: Document, added: Sequence[Sequence[Document]]) -> Document:
    """The machine with schedules of files that use each other; those of the first take precedence."""
    for of_file in (s for s in reversed(added) if s):
        own, before = [s.get("parameter") for s in of_file], described.get("schedules", [])
        if isinstance(before, list):  # anything else is refused when the machine is built
            described = described | {"schedules": [*of_file, *(s for s in before if _parameter(s) not in own)]}
    return described


def _parameter(schedule: Any) -> Any:
    return schedule.get("parameter") if isinstance(schedule, dict) else None


def _merged(settings: Sequence[Document]) -> Document:
    """The settings of tables that use each other; those of the first take precedence."""
    return {name: value for level in reversed(settings) for name, value in level.items()}


def _with_changes(described: Document, changes: Document, change: Callable[[Document, Document], Document]) -> Document:
    """The table with values changed, and a title that states them. Raises ``InputError``."""
    changed, differing = described, Document()
    for path, value in changes.items():
        before, changed = changed, change(changed, {path: value})
        differing |= {path: value} if changed != before else {}
    return changed | {"title": changed_title(str(described["title"]), differing)}


def _used(described: Document, path: Path, key: str, seen: Sequence[Path]) -> Path:
    """The file that a table uses; visited_paths: the files that led here, to detect a cycle."""
    extra = sorted(set(described) - {"use", "title"})
    if extra:
        allowed = "set, schedules and title" if key == "machine" else "set and title"
        raise InputError(f"{key}.{extra[0]}", None, f"not allowed beside use; allowed are {allowed}")
    name = text(described, "use", key) or ""
    try:
        used = locate(name, path.parent)
    except InputError as error:
        raise InputError(f"{key}.use", name, error.allowed) from None
    if used.resolve() in seen:
        raise InputError(f"{key}.use", name, "these files use each other in a circle")
    return used


def described_machine(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> Document:
    """The table ``[machine]`` as it is to be built: ``use`` resolved, settings applied, titled. Raises ``InputError``."""
    described, changes = used_table(document, path, "machine")
    described.setdefault("title", printable(Path(name).stem))
    described = with_settings(described, settings_in(described))
    chosen = _with_changes(described, of_all_first(described, changes | flatten(settings)), with_settings)
    refuse_bare_frequencies(chosen, "machine")
    return with_tables(chosen, path.parent)


def described_equations(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> Document:
    """The table ``[system]`` as it is to be read: ``use`` resolved, settings applied, titled. Raises ``InputError``."""
    described, changes = used_table(document, path, "system")
    described.setdefault("title", printable(Path(name).stem))
    described = with_values(described, settings_in(described, "system"))
    return _with_changes(described, changes | flatten(settings), with_values)


def machine_of(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Document]:
    """The machine of a document, and its table ``[machine]`` as it is built.

    Raises ``InputError``, at the file behind ``use`` in which something is wrong.
    """
    return _at_fault(_machine, "machine", document, path, name, settings)


def equations_of(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[OwnEquations, Document]:
    """The equations of a document, and its table ``[system]`` as it is built."""
    return _at_fault(_equations, "system", document, path, name, settings)


def _machine(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Document]:
    described = described_machine(document, path, name, settings)
    return machine_from(described), described


def _equations(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[OwnEquations, Document]:
    described = described_equations(document, path, name, settings)
    return equations_from(described), described


def _at_fault(
    build: Callable[[Document, Path, str, Mapping[str, Any]], T],
    key: str,
    document: Document,
    path: Path,
    name: str,
    settings: Mapping[str, Any],
) -> T:
    """Build from a document. An ``InputError`` is located at the innermost file behind ``use`` that has it by itself."""
    try:
        return build(document, path, name, settings)
    except InputError as error:
        fault = error
        for used, used_path in [] if error.file else _behind(document, path, key):
            try:
                build(used, used_path, str(used_path), {})
                break
            except InputError as own:
                if own.file or (own.key, own.shown) != (error.key, error.shown):
                    break
                fault = own.in_file(used_path)
        raise fault from None


def _behind(document: Document, path: Path, key: str) -> list[tuple[Document, Path]]:
    """The documents that a document uses, and those use, with their files, as far as they can be read."""
    found, seen = list[tuple[Document, Path]](), [path.resolve()]
    with suppress(InputError):
        while "use" in (described := table(document, key, key)):
            document, path = load_document(str(_used({"use": described["use"]}, path, key, seen)))
            seen.append(path.resolve())
            found.append((document, path))
    return found


def load_equations(name: str, settings: Mapping[str, Any] | None = None) -> OwnEquations:
    """The equations ``[system]`` of a catalogue name or study file.

    Parameters
    ----------
    name : path of a study file, or a catalogue name
    settings : mapping, optional
        Parameters by name.

    Returns
    -------
    UserSystem

    Raises
    ------
    InputError
        For a wrong name, file, key or value.

    Examples
    --------
    >>> load_equations("drozdetskaya-2020/figure-2.13", {"mu": 1.2}).values
    {'mu': 1.2}
    """
    return _loaded(name, lambda document, path: equations_of(document, path, name, settings or {})[0])


def load_machine(name: str, settings: Mapping[str, Any] | None = None) -> Machine:
    """The machine of a catalogue name or study file.

    Parameters
    ----------
    name : path of a study file, or a catalogue name
    settings : mapping, optional
        Parameters by path, in SI or as text with a unit, such as ``{"drive.slope": "0.02 N m s"}``; a frequency, but for that
        of a motor's mains, as text with its unit.

    Returns
    -------
    Machine

    Raises
    ------
    InputError
        For a wrong name, file, key or value.

    Examples
    --------
    >>> load_machine("drozdetskaya-2020/table-5.1", {"u": 1.5}).values["u"]
    1.5
    """
    return _loaded(name, lambda document, path: machine_of(document, path, name, settings or {})[0])


def _loaded(name: str, build: Callable[[Document, Path], T]) -> T:
    """Build from the document of a name; errors name its file."""
    document, path = load_document(name)
    try:
        return build(document, path)
    except InputError as error:
        raise error.in_file(path) from None
