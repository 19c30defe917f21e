"""A cache on disk of derived equations for the next process, in the user's cache folder, as heyoka caches compiled code.

A result is identified by the values of its inputs and the state of the program: its files, Python and SymPy.
Set ``WUCHT_CACHE_DIR`` for another folder. Files are read with ``pickle``, so only those that the user's processes wrote: file
and folder belong to the user and nobody else may write them (on Windows: they are below the user's profile), a digest proves
that the file is complete, and the result is of the type that the function returns. Otherwise it is derived again.
"""

from __future__ import annotations

import os
import pickle
import stat
import sys
import threading
import warnings
from collections.abc import Callable
from contextlib import suppress
from copyreg import __newobj__  # type: ignore[attr-defined]
from dataclasses import fields, is_dataclass
from functools import cache, wraps
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from shutil import rmtree
from types import UnionType
from typing import Any, TypeVar, get_args, get_origin, get_type_hints

_Result = TypeVar("_Result")
_STABLE_PACKAGES = {"wucht", "sympy", "builtins"}  # packages whose classes belong to the state of the program
_WINDOWS = sys.platform == "win32"
_BINARY = getattr(os, "O_BINARY", 0)  # on Windows
_READ_FLAGS, _CREATE_FLAGS = (
    os.O_RDONLY | getattr(os, "O_NOFOLLOW", 0) | _BINARY,
    os.O_WRONLY | os.O_CREAT | os.O_TRUNC | _BINARY,
)
_DIGEST = 32  # bytes before the pickled content
_PROGRAMS = 4  # states of the program whose results are kept: those used last


def derived_once(function: Callable[..., _Result]) -> Callable[..., _Result]:
    """A pure function of frozen data, given by position, that is called once for all processes.

    Inputs and results are frozen dataclasses, SymPy's expressions, sequences, text and numbers. Exceptions are not cached, nor
    results for classes of the user: their code may change from one process to the next.
    """

    @wraps(function)
    def cached_function(*inputs: Any) -> _Result:
        try:
            key = sha256(_pickle_bytes(inputs, True)).hexdigest()[:40]
        except (pickle.PicklingError, TypeError, AttributeError):
            return function(*inputs)
        folder = _folder()
        if not _is_private(folder):
            return function(*inputs)
        path = folder / f"{function.__module__}.{function.__name__}-{key}"
        with suppress(Exception):  # not there, or damaged: then pickle may raise anything
            stored_result: _Result = pickle.loads(read_stored(path))
            if _has_return_type(function, stored_result):
                return stored_result
        result = function(*inputs)
        with suppress(OSError):  # no room, or no right to write there: another process derives it again
            store(path, _pickle_bytes(result, False))
        return result

    return cached_function


def _has_return_type(function: Callable[..., Any], value: object) -> bool:
    """True if a value is of the type that the function returns."""
    annotation = get_type_hints(function)["return"]
    kinds = get_args(annotation) if isinstance(annotation, UnionType) else (annotation,)
    return isinstance(value, tuple(get_origin(kind) or kind for kind in kinds))


def _digest(path: Path, content: bytes) -> bytes:
    """Digest of content and file name, so that a renamed file is not taken for another."""
    return sha256(path.name.encode() + content).digest()


def read_stored(path: Path) -> bytes:
    """Content of a stored file. Raises ``OSError`` or ``ValueError`` where it is not there, not private or damaged."""
    with os.fdopen(os.open(path, _READ_FLAGS), "rb") as file:
        if not _is_private_file(os.fstat(file.fileno())):
            raise ValueError
        content = file.read()
    digest, content = content[:_DIGEST], content[_DIGEST:]
    if digest != _digest(path, content):
        raise ValueError
    return content


def store(path: Path, content: bytes) -> None:
    """Store content in a file, atomically: written beside it and renamed, readable by the user alone."""
    temporary_path = path.with_name(f"{path.name}.{os.getpid()}-{threading.get_ident()}")
    try:
        with os.fdopen(os.open(temporary_path, _CREATE_FLAGS, 0o600), "wb") as file:
            file.write(_digest(path, content) + content)
        temporary_path.replace(path)
    finally:
        temporary_path.unlink(missing_ok=True)


def _is_private_file(status: os.stat_result) -> bool:
    """True if a file belongs to the user and nobody else may write it; on Windows its folder decides."""
    return _WINDOWS or (status.st_uid == os.geteuid() and not status.st_mode & (stat.S_IWGRP | stat.S_IWOTH))


def _is_private(folder: Path) -> bool:
    """True if the content of a folder can be trusted. Where it exists and cannot, warn once in a process."""
    try:
        private = folder.resolve().is_relative_to(Path.home()) if _WINDOWS else _is_private_file(os.lstat(folder))
    except (OSError, RuntimeError):
        return False
    if not private:
        _warn_once(folder)
    return private


@cache
def _warn_once(folder: Path) -> None:
    reason = "is not in your profile folder" if _WINDOWS else "is not yours alone (others may write there)"
    warnings.warn(f"the cache folder {folder} {reason}: it is not used; see WUCHT_CACHE_DIR", RuntimeWarning, stacklevel=2)


class _Pickler(pickle.Pickler):
    """Pickles only the fields of a dataclass: its cached properties may hold hashes, which differ between processes."""

    def __init__(self, file: BytesIO, as_key: bool) -> None:
        super().__init__(file, protocol=5)
        self._as_key = as_key
        self.fast = as_key  # the same bytes whether equal parts are one object or two

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, type):
            if self._as_key and value.__module__.split(".")[0] not in _STABLE_PACKAGES:
                raise pickle.PicklingError(f"{value.__qualname__} is a class of the user")
            return NotImplemented
        if is_dataclass(value):
            field_names = [f.name for f in fields(value) if f.compare or not self._as_key]
            return __newobj__, (type(value),), {name: getattr(value, name) for name in field_names}
        if self._as_key and hasattr(value, "model_fields_set"):  # a set, whose order differs between processes
            return __newobj__, (type(value),), dict(vars(value))
        return NotImplemented


def _pickle_bytes(value: Any, as_key: bool) -> bytes:
    file = BytesIO()
    _Pickler(file, as_key).dump(value)
    return file.getvalue()


@cache
def _folder() -> Path:
    """The folder for the present state of the program; it need not exist where it cannot be made."""
    import sympy

    state = sha256(repr((sys.version, sympy.__version__, program_state())).encode()).hexdigest()[:16]
    folder = cache_folder() / f"derived-{state}"
    with suppress(OSError):
        make_folder(folder.parent)
        make_folder(folder)
        os.utime(folder)
        for old in sorted(folder.parent.glob("derived-*"), key=lambda p: -p.stat().st_mtime)[_PROGRAMS:]:
            rmtree(old, ignore_errors=True)
    return folder


def make_folder(folder: Path) -> None:
    """Make a folder that only the user can read, unless it is there. Raises ``OSError``."""
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)


def program_state() -> str:
    """A digest of the contents of all source files: their times may be the same for all, as in reproducible builds."""
    package = os.path.dirname(__file__)  # noqa: PTH120 - pathlib takes twice as long here
    names = [os.path.join(folder, name) for folder, _, names in os.walk(package) for name in names if name.endswith(".py")]  # noqa: PTH118
    digest = sha256()
    for name in sorted(names):
        with open(name, "rb") as file:  # noqa: PTH123
            digest.update(repr((name[len(package) :], sha256(file.read()).digest())).encode())
    return digest.hexdigest()


def cache_folder() -> Path:
    """The folder of all cached data: the user's cache folder, or ``WUCHT_CACHE_DIR``."""
    folder = os.environ.get("WUCHT_CACHE_DIR")
    if folder:
        return Path(folder)
    from platformdirs import user_cache_path

    return user_cache_path("wucht", appauthor=False)
