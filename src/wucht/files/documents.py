"""Documents: TOML files read, and values addressed by path. A document is the nested dictionary of a TOML file."""

from __future__ import annotations

import hashlib
import stat
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from wucht.errors import InputError

Document = dict[str, Any]
LARGEST = 1_000_000_000  # bytes of a text file: its rows then take several times that in memory


def read_text(path: Path, missing: str = "there is no such file", encoding: str = "utf-8") -> str:
    """The text of a file. Raises ``InputError`` for one that cannot be read; missing: the sentence where there is none."""
    try:
        about = path.stat()
        if not (stat.S_ISREG(about.st_mode) or stat.S_ISDIR(about.st_mode)):  # a device may never come to an end
            raise InputError(str(path), None, "this is no file")
        if about.st_size > LARGEST:
            raise InputError(
                str(path), None, f"the file has {about.st_size / 1e9:.3g} GB; at most {LARGEST / 1e9:g} GB are read"
            )
        return path.read_text(encoding=encoding)
    except FileNotFoundError:
        raise InputError(str(path), None, missing) from None
    except (OSError, UnicodeDecodeError) as error:
        reason = error.strerror if isinstance(error, OSError) else "it is not UTF-8 text"
        raise InputError(str(path), None, f"the file cannot be read: {reason}") from None


def contents_of(path: Path) -> str:
    """What tells the contents of a file from others. Empty where it cannot be read: whoever reads it says so."""
    try:
        if not path.is_file():  # a device may never come to an end
            return ""
        with path.open("rb") as file:
            return hashlib.file_digest(file, "sha256").hexdigest()
    except OSError:
        return ""


def read_toml(path: Path) -> Document:
    """The document in a TOML file. Raises ``InputError`` for an unreadable file or one that is no TOML."""
    if path.is_dir():
        raise InputError(str(path), None, "this is a folder; a study file is needed")
    text = read_text(path)
    try:
        return tomllib.loads(text)
    except ValueError as error:  # TOMLDecodeError among others, such as integers of thousands of digits
        raise InputError(str(path), None, f"the file is no valid TOML: {str(error).splitlines()[0]}") from None
    except RecursionError:
        raise InputError(str(path), None, "the file is no valid TOML: it is nested too deeply") from None


def flatten(settings: Mapping[str, Any], prefix: str = "") -> dict[str, Any]:
    """``{"drive": {"slope": 1}}`` and ``{"drive.slope": 1}`` both become ``{"drive.slope": 1}``."""
    flat: dict[str, Any] = {}
    for key, value in settings.items():
        flat |= flatten(value, f"{prefix}{key}.") if isinstance(value, Mapping) and value else {prefix + key: value}
    return flat


def settings_in(described: Document, key: str = "machine") -> dict[str, Any]:
    """The table ``set`` taken out of the table of this key, flattened. Raises ``InputError`` if it is no table."""
    settings = described.pop("set", {})
    if not isinstance(settings, dict):
        raise InputError(f"{key}.set", settings, "must be a table: set = { PATH = VALUE }")
    return flatten(settings)
