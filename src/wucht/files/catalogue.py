"""The catalogue: machines and equations, of the papers and of practice, each a TOML file addressed without its ending."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from difflib import SequenceMatcher
from pathlib import Path
from typing import Any, TypeVar

from wucht.errors import InputError
from wucht.file_names import printable, safe_name
from wucht.files.building import MACHINE_KEYS, machine_from, with_settings
from wucht.files.documents import Document, changed_title, flatten, read_toml, refuse_bare_frequencies, settings_in
from wucht.files.equal_bodies import group_settings_first
from wucht.files.tables import with_tables
from wucht.files.user_system import UserSystem, equations_from, with_values
from wucht.machines.machine import Machine
from wucht.schema import refuse_unknown, require_table, text

T = TypeVar("T")
FOLDER = Path(__file__).parent.parent / "machines" / "catalogue"
ABOUT = ("title", "source", "notes", "study")
TOP_LEVEL = (*ABOUT, "machine", "system", "law", "follower", "linkage", "speed", "shaft")
_MOST_NEAR, _LONGEST = 3, 60  # names in a sentence; characters of an unknown one that are compared
_ALIKE, _ALIKE_IN_FOLDER = 0.6, 0.5  # likeness of names that are suggested; of short names in the same folder, r3 and r1
# Keys that may be written above their table by mistake.
_INSIDE = dict.fromkeys(MACHINE_KEYS, "machine") | dict.fromkeys(("kind", "until", "settled", "start"), "study")


def names() -> list[str]:
    """All catalogue names, such as ``drozdetskaya-2020/table-5.1``."""
    return sorted(str(p.relative_to(FOLDER).with_suffix("")) for p in FOLDER.rglob("*.toml"))


def short_name(path: Path) -> Path:
    """Short name of a file, independent of its folder: its catalogue name, else its name without the ending."""
    full_path = path.resolve()
    if full_path.is_relative_to(FOLDER):
        return full_path.relative_to(FOLDER).with_suffix("")
    return Path(safe_name(path.name.removesuffix(".toml")))


def locate(name: str, beside: Path | None = None) -> Path:
    """The file of a catalogue name or a path (relative to ``beside``). Raises ``InputError`` with the names most like it."""
    direct = Path(name) if beside is None else beside / name
    try:
        if direct.is_file():
            return direct
        known_names = names()
        if name.removesuffix(".toml") in known_names:
            return FOLDER / f"{name.removesuffix('.toml')}.toml"
        if direct.exists():
            requirement = "this is not a file; a study file or a catalogue name is needed"
            raise InputError.file_error(direct, requirement, code="no-file")
    except (OSError, ValueError) as error:
        raise InputError(name, None, f"this cannot be the name of a file: {error}") from None
    if direct.suffix == ".toml":
        raise InputError.file_error(direct, "there is no such file", code="no-file")
    requirement = f"must be a study or machine file, or a catalogue name; {nearest_names(name, known_names)}"
    raise InputError("FILE", name, requirement, code="unknown-name")


def nearest_names(name: str, known_names: Iterable[str]) -> str:
    """Return the clause that helps with an unknown name.

    Parameters
    ----------
    name : str
    known_names : iterable of str
        Names that ``wucht list`` prints: of the catalogue, and of studies and parts where these are allowed.

    Returns
    -------
    str
        At most three names that are like it, or contain it, and the command that prints all.
    """
    short, all_names = name[:_LONGEST].strip().lower(), sorted(known_names)
    by_likeness = sorted(((_likeness(short, one), one) for one in all_names), key=lambda pair: -pair[0][0])
    similar = [one for (likeness, least), one in by_likeness if likeness >= least]
    containing = [one for one in all_names if short and short in one]
    suggestion = ", ".join(map(repr, list(dict.fromkeys([*similar, *containing]))[:_MOST_NEAR]))
    return f"{f'did you mean {suggestion}? ' if suggestion else ''}`wucht list` prints all names"


def _likeness(name: str, known_name: str) -> tuple[float, float]:
    """Return the likeness of two names, and the least with which one is suggested.

    Folders are compared apart from what is in them: names in one folder are alike by its name alone.
    """
    (folder, _, last), (known_folder, _, known_last) = name.rpartition("/"), known_name.rpartition("/")
    likeness = SequenceMatcher(None, known_last, last).ratio()
    if folder:
        likeness = min(likeness, SequenceMatcher(None, known_folder, folder).ratio())
    return likeness, _ALIKE_IN_FOLDER if folder and folder == known_folder else _ALIKE


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
        raise error.with_file(path) from None
    return document, path


def resolve_use(document: Document, path: Path, key: str) -> tuple[Document, Document]:
    """The table ``[machine]`` or ``[system]`` of a document with ``use`` resolved, and the settings beyond its title.

    The title is that of the table, else of its file, else of the table it uses; none where none of them has one. Settings of
    tables up to the one with the title are merged into its ``set``; the others, which the title does not cover, are returned
    beside it. Schedules that a machine adds to the one it uses come before those of that one, and replace those of the same
    parameters. Raises ``InputError``, which names the file if it is not this one.
    """
    visited_paths, settings, titles, added_schedules = [path.resolve()], list[Document](), list[Any](), list[list[Document]]()
    purposes = list[Document]()
    used_path: Path | None = path
    while used_path is not None:
        try:
            description = dict(require_table(document, key, key))
            settings.append(settings_in(description, key))
            titles.append(text(description, "title", key) or document.get("title"))
            purposes.append({"purpose": description["purpose"]} if "purpose" in description else {})
            added_schedules.append(_take_schedules(description) if key == "machine" and "use" in description else [])
            used_path = _used_file(description, path, key, visited_paths) if "use" in description else None
            description = with_tables(description, path.parent) if key == "machine" and used_path is None else description
        except InputError as error:
            raise error if len(visited_paths) == 1 else error.with_file(path) from None
        if used_path is not None:
            document, path = load_document(str(used_path))
            visited_paths.append(path.resolve())
    title_level = next((k for k, title in enumerate(titles) if title), None)
    over_time = {str(s.get("parameter")): "over time" for of_file in added_schedules[:title_level] for s in of_file}
    title = {} if title_level is None else {"title": changed_title(str(titles[title_level]), over_time)}
    purpose = next(filter(None, purposes), {})
    description = _with_schedules(description, added_schedules) | title | purpose
    return description | {"set": _merge_settings(settings[title_level:])}, _merge_settings(
        settings[:title_level] if title_level else []
    )


def _take_schedules(description: Document) -> list[Document]:
    """Remove the schedules from a table that uses another. Raises ``InputError`` if they are not tables."""
    schedules = description.pop("schedules", [])
    if not isinstance(schedules, list) or not all(isinstance(s, dict) for s in schedules):
        raise InputError("machine.schedules", schedules, "must be tables: [[machine.schedules]]")
    return schedules


def _with_schedules(description: Document, added_schedules: Sequence[Sequence[Document]]) -> Document:
    """The machine with schedules of files that use each other; those of the first take precedence."""
    for of_file in (s for s in reversed(added_schedules) if s):
        replaced_parameters, before = [s.get("parameter") for s in of_file], description.get("schedules", [])
        if isinstance(before, list):  # anything else is refused when the machine is built
            description = description | {
                "schedules": [*of_file, *(s for s in before if _parameter(s) not in replaced_parameters)]
            }
    return description


def _parameter(schedule: Any) -> Any:
    return schedule.get("parameter") if isinstance(schedule, dict) else None


def _merge_settings(settings: Sequence[Document]) -> Document:
    """The settings of tables that use each other; those of the first take precedence."""
    return {name: value for level in reversed(settings) for name, value in level.items()}


def _with_changes(description: Document, changes: Document, change: Callable[[Document, Document], Document]) -> Document:
    """The table with values changed, and a title that states them. Raises ``InputError``."""
    result, differing = description, Document()
    for path, value in changes.items():
        before, result = result, change(result, {path: value})
        differing |= {path: value} if result != before else {}
    return result | {"title": changed_title(str(description["title"]), differing)}


def _used_file(description: Document, path: Path, key: str, visited_paths: Sequence[Path]) -> Path:
    """The file that a table uses; visited_paths: the files that led here, to detect a cycle."""
    extra = sorted(set(description) - {"use", "title", *(["purpose"] if key == "machine" else [])})
    if extra:
        allowed_keys = "set, schedules, title and purpose" if key == "machine" else "set and title"
        raise InputError(f"{key}.{extra[0]}", None, f"not allowed beside use; allowed are {allowed_keys}")
    name = text(description, "use", key) or ""
    try:
        used_path = locate(name, path.parent)
    except InputError as error:
        raise InputError(f"{key}.use", name, error.explanation, code=error.code) from None
    if used_path.resolve() in visited_paths:
        raise InputError(f"{key}.use", name, "these files use each other in a circle")
    return used_path


def described_machine(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> Document:
    """The table ``[machine]`` as it is to be built: ``use`` resolved, settings applied, titled. Raises ``InputError``."""
    description, changes = resolve_use(document, path, "machine")
    description.setdefault("title", printable(Path(name).stem))
    description = with_settings(description, settings_in(description))
    chosen = _with_changes(description, group_settings_first(description, changes | flatten(settings)), with_settings)
    refuse_bare_frequencies(chosen, "machine")
    return with_tables(chosen, path.parent)


def described_equations(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> Document:
    """The table ``[system]`` as it is to be read: ``use`` resolved, settings applied, titled. Raises ``InputError``."""
    description, changes = resolve_use(document, path, "system")
    description.setdefault("title", printable(Path(name).stem))
    description = with_values(description, settings_in(description, "system"))
    return _with_changes(description, changes | flatten(settings), with_values)


def machine_of(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Document]:
    """The machine of a document, and its table ``[machine]`` as it is built.

    Raises ``InputError``, at the file behind ``use`` in which something is wrong.
    """
    return _build_locating_errors(_machine, "machine", document, path, name, settings)


def equations_of(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[UserSystem, Document]:
    """The equations of a document, and its table ``[system]`` as it is built."""
    return _build_locating_errors(_equations, "system", document, path, name, settings)


def _machine(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[Machine, Document]:
    description = described_machine(document, path, name, settings)
    return machine_from(description), description


def _equations(document: Document, path: Path, name: str, settings: Mapping[str, Any]) -> tuple[UserSystem, Document]:
    description = described_equations(document, path, name, settings)
    return equations_from(description), description


def _build_locating_errors(
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
        for used_document, used_path in [] if error.file else _used_documents(document, path, key):
            try:
                build(used_document, used_path, str(used_path), {})
                break
            except InputError as inner_error:
                if inner_error.file or (inner_error.key, inner_error.value_text) != (error.key, error.value_text):
                    break
                fault = inner_error.with_file(used_path)
        raise fault from None


def _used_documents(document: Document, path: Path, key: str) -> list[tuple[Document, Path]]:
    """The documents that a document uses, and those use, with their files, as far as they can be read."""
    documents, visited_paths = list[tuple[Document, Path]](), [path.resolve()]
    with suppress(InputError):
        while "use" in (description := require_table(document, key, key)):
            document, path = load_document(str(_used_file({"use": description["use"]}, path, key, visited_paths)))
            visited_paths.append(path.resolve())
            documents.append((document, path))
    return documents


def load_equations(name: str | Path, settings: Mapping[str, Any] | None = None) -> UserSystem:
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
    return _load(name, lambda document, path: equations_of(document, path, str(name), settings or {})[0])


def load_machine(name: str | Path, settings: Mapping[str, Any] | None = None) -> Machine:
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
    return _load(name, lambda document, path: machine_of(document, path, str(name), settings or {})[0])


def _load(name: str | Path, build: Callable[[Document, Path], T]) -> T:
    """Build from the document of a name; errors name its file."""
    document, path = load_document(str(name))
    try:
        return build(document, path)
    except InputError as error:
        raise error.with_file(path) from None
