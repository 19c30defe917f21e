"""Entries of the cache: named bytes that are read only if this user's processes wrote them under this name."""

from __future__ import annotations

import os
from pathlib import Path

from wucht.disk_cache.private_files import make_folder, read_file, temporary_beside, warn_once, write_new_file
from wucht.disk_cache.user_key import key_for

_CODE = 32  # bytes of authentication before the content
_LARGEST = 2**28  # bytes of an entry: many times those of a machine of a hundred bodies


def cache_folder() -> Path:
    """The folder of all cached data: the user's cache folder, or ``WUCHT_CACHE_DIR``."""
    folder = os.environ.get("WUCHT_CACHE_DIR")
    if folder:
        return Path(folder)
    from platformdirs import user_cache_path

    return user_cache_path("wucht", appauthor=False)


def read_entry(name: str) -> bytes:
    """Read an entry. name: its path in the cache folder, with ``/``.

    The bytes are those that were authenticated: the file is read once. Warns, once in a process, of entries that this user's
    processes did not write.

    Raises
    ------
    OSError
        If it is not there, cannot be read, or there is no key.
    ValueError
        If this user's processes did not write it, or not under this name.
    """
    folder = cache_folder()
    content, _ = read_file(folder / name, _LARGEST)
    code, content = content[:_CODE], content[_CODE:]
    from hmac import compare_digest

    if not compare_digest(code, _authentication_code(folder, name, content)):
        warn_once(
            f"the cache folder {folder} has entries that were not written with your key (they were changed, or copied from "
            "another account or computer): they are not loaded, but derived again"
        )
        raise ValueError(f"{name} cannot be authenticated")
    return content


def store_entry(name: str, content: bytes) -> None:
    """Store an entry, atomically: written beside it and renamed, readable by the user alone. Raises ``OSError``."""
    folder = cache_folder()
    code, path = _authentication_code(folder, name, content), folder / name
    if len(content) > _LARGEST - _CODE:
        return
    make_folder(folder)
    temporary = temporary_beside(path)
    try:
        write_new_file(temporary, code + content)
        temporary.replace(path)
    finally:
        temporary.unlink(missing_ok=True)


def _authentication_code(folder: Path, name: str, content: bytes) -> bytes:
    """HMAC of name and content, so that neither can be exchanged. Raises ``OSError`` where there is no key."""
    key = key_for(folder)
    if key is None:
        raise FileNotFoundError("there is no key for the cache")
    from hmac import digest

    return digest(key, name.encode() + b"\0" + content, "sha256")
