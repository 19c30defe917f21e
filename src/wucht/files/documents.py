"""Documents, nested dictionaries of TOML files: read, values addressed by path, and a title that states changed values."""

from __future__ import annotations

import hashlib
import re
import stat
import tomllib
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path
from typing import Any

from wucht.errors import InputError
from wucht.schema import python_value

Document = dict[str, Any]
DEEPEST = 40  # nested tables and lists
# Texts, comments and words of TOML, none of which is read twice; a key of too many parts begins where a word or text does.
_PART = r'(?:[\w-]++|"(?:[^"\\\n]|\\[^\n])*+"?|' + r"'[^'\n]*+'?)[ \t]*+"
_MORE_PARTS = rf"(?:\.[ \t]*+{_PART}){{{DEEPEST}}}"
_TEXT = r'"""(?:[^"\\]|\\.|"(?!""))*+(?:"{3,5}|\Z)|' + r"'''(?:[^']|'(?!''))*+(?:'{3,5}|\Z)"
_LONG_KEY = re.compile(_MORE_PARTS)
_WORDS = re.compile(rf"{_TEXT}|#[^\n]*+|(?P<key>{_PART}){_MORE_PARTS}|{_PART}", re.DOTALL)
_LONG_NUMBER = re.compile(r"\d[\d_]{4000}")
LARGEST = 1_000_000_000  # bytes of a text file: its rows then take several times that in memory
_LARGEST_TOML = 40_000_000  # likewise of a study file, of which a second reads 5 MB: a million points of a schedule
_MOST = 3  # values named one by one
_FOLDERS: ContextVar[tuple[Path, ...]] = ContextVar("folders", default=())


@contextmanager
def files_below(*folders: Path) -> Iterator[None]:
    """Let ``read_text`` refuse files outside these folders, wherever links lead: for documents that are not the user's own."""
    token = _FOLDERS.set(tuple(folder.resolve() for folder in folders))
    try:
        yield
    finally:
        _FOLDERS.reset(token)


def read_text(path: Path, missing: str = "there is no such file", encoding: str = "utf-8-sig", largest: int = LARGEST) -> str:
    """The text of a file, without the byte order mark that some editors put before it.

    missing: the sentence for a missing file. largest: size in bytes. Raises ``InputError`` for one that cannot be read.
    """
    try:
        if (folders := _FOLDERS.get()) and not any(path.resolve().is_relative_to(folder) for folder in folders):
            raise InputError.file_error(path, f"only files below {folders[0]} are read here", code="outside")
        about = path.stat()
        if not (stat.S_ISREG(about.st_mode) or stat.S_ISDIR(about.st_mode)):  # a device may never end
            raise InputError.file_error(path, "this is not a file")
        if about.st_size > largest:
            sizes = [f"{n / 1e9:.3g} GB" if n >= 1e9 else f"{n / 1e6:.3g} MB" for n in (about.st_size, largest)]
            raise InputError.file_error(path, f"the file has {sizes[0]}; at most {sizes[1]} are read")
        return path.read_text(encoding=encoding) if about.st_size else ""  # one of the system, without a size, may never end
    except FileNotFoundError:
        raise InputError.file_error(path, missing, code="no-file") from None
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text; save it as UTF-8"
        raise InputError.file_error(path, f"the file cannot be read: {reason}", code="unreadable") from None


def contents_digest(path: Path) -> str:
    """Digest of the contents of a file. Empty where it cannot be read, which is reported when it is read."""
    try:
        if not path.is_file():  # a device may never end
            return ""
        if not path.stat().st_size:  # likewise one of the system
            return hashlib.sha256().hexdigest()
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def read_toml(path: Path) -> Document:
    """The document in a TOML file. Raises ``InputError`` for an unreadable file or invalid TOML."""
    if path.is_dir():
        raise InputError.file_error(path, "this is a folder; a study file is needed")
    return document_of(read_text(path, largest=_LARGEST_TOML), path)


def document_of(text: str, path: Path) -> Document:
    """The document in a text of TOML. path: of the file in errors. Raises ``InputError`` for invalid TOML."""
    _refuse_long_keys(text, path)
    try:
        document = tomllib.loads(text)
    except tomllib.TOMLDecodeError as error:
        raise InputError.file_error(path, f"the file is not valid TOML: {str(error).splitlines()[0]}") from None
    except ValueError:  # Python refuses to read such integers
        long_number = _LONG_NUMBER.search(text)
        line = f" (at line {text.count(chr(10), 0, long_number.start()) + 1})" if long_number else ""
        raise InputError.file_error(path, f"the file is not valid TOML: a number of thousands of digits{line}") from None
    except RecursionError:
        raise InputError.file_error(path, "the file is not valid TOML: it is nested too deeply") from None
    for key, value in document.items():
        if _is_deep({key: value}):  # by keys of many parts
            raise InputError(key, None, f"at most {DEEPEST} tables and lists may be nested").with_file(path)
    return document


def _refuse_long_keys(text: str, path: Path) -> None:
    """Raise ``InputError`` for a key ``a.b.c...`` of too many parts: tomllib's time goes with their number squared."""
    if not _LONG_KEY.search(text):  # nor in a text or a comment, where it would be none
        return
    for word in _WORDS.finditer(text):
        if word["key"]:
            line = text.count("\n", 0, word.start()) + 1
            explanation = f"at most {DEEPEST} tables and lists may be nested (at line {line})"
            raise InputError(word["key"].strip(), None, explanation).with_file(path)


def _is_deep(document: Document) -> bool:
    """True if more than ``DEEPEST`` tables and lists are nested."""
    level: list[Any] = [document]
    for _ in range(DEEPEST):
        level = [inner for outer in level for inner in (outer.values() if isinstance(outer, dict) else outer)]
        level = [inner for inner in level if isinstance(inner, dict | list)]
        if not level:
            return False
    return True


def flatten(settings: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """``{"drive": {"slope": 1}}`` and ``{"drive.slope": 1}`` both become ``{"drive.slope": 1}``."""
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        flat |= (
            flatten(value, f"{prefix}{key}.") if isinstance(value, Mapping) and value else {prefix + key: python_value(value)}
        )
    return flat


def refuse_bare_frequencies(document: Mapping[str, Any], location: str = "") -> None:
    """Raises ``InputError`` where a table of a file gives a frequency without a unit, which could be turns or radians.

    A key ``frequency``, or one that ends so, of the table or one inside. That of a drive is the frequency of the mains, always
    in Hz; 0 is 0 in any unit. For files and settings by path: parts built in Python take a number in SI.
    """
    for key, value in document.items():
        at = f"{location}.{key}" if location else key
        if isinstance(value, Mapping) and key not in _OF_THE_MAINS:
            refuse_bare_frequencies(value, at)
        elif isinstance(value, list) and key not in _OF_THE_MAINS:
            for i, inner in enumerate(value):
                refuse_bare_frequencies(inner, f"{at}[{i}]") if isinstance(inner, Mapping) else None
        elif key.endswith("frequency") and _is_bare_number(value):
            explanation = f"without a unit this could be turns or radians; write '{value} Hz' or '{value} rad/s'"
            raise InputError(at, value, explanation)


def _is_bare_number(value: Any) -> bool:
    """True if the value is a number other than 0, or a text of such a number alone."""
    try:
        return not isinstance(value, bool) and isinstance(value, int | float | str) and float(value) != 0
    except (ValueError, OverflowError):
        return False


_OF_THE_MAINS = ("drive", "drives")


def settings_in(description: Document, key: str = "machine") -> dict[str, Any]:
    """Remove the table ``set`` from the table of this key, and return it flattened. Raises ``InputError`` if it is no table."""
    settings = description.pop("set", {})
    if not isinstance(settings, dict):
        raise InputError(f"{key}.set", settings, "must be a table: set = { PATH = VALUE }")
    return flatten(settings)


def changed_title(title: str, changes: Mapping[str, Any]) -> str:
    """The title with values changed by path.

    A value in the title itself, as ``u = 2.5``, is replaced, and its old value is stated; others are added in brackets.
    """
    additions: list[str] = []
    for path, value in changes.items():
        now = f"{path} = {_value_text(value)}"
        match = re.search(rf"(?<![\w.]){re.escape(path)} = ([-+]?\d[\w.+-]*)", title)
        if match:
            title = f"{title[: match.start()]}{now} (changed from {match[1]}){title[match.end() :]}"
        else:
            additions.append(now)
    more = f" and {len(additions) - _MOST} more" if len(additions) > _MOST else ""
    return f"{title} (changed: {', '.join(additions[:_MOST])}{more})" if additions else title


def _value_text(value: Any) -> str:
    if isinstance(value, float):
        return f"{value:g}"
    return str(value) if isinstance(value, str | int) else "..."
