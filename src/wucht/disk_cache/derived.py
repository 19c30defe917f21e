"""Results of pure functions, kept for the next process: called once for all processes with equal inputs.

A result is identified by the values of its inputs and the state of the program: its files, Python, SymPy, NumPy and Pint.
"""

from __future__ import annotations

import os
import pickle
import sys
from collections.abc import Callable
from contextlib import suppress
from copyreg import __newobj__  # type: ignore[attr-defined]
from dataclasses import fields, is_dataclass
from functools import cache, wraps
from hashlib import sha256
from io import BytesIO
from pathlib import Path
from shutil import rmtree
from typing import Any, TypeVar

from wucht.disk_cache.entries import cache_folder, read_entry, store_entry
from wucht.disk_cache.plain_data import from_bytes, to_bytes
from wucht.disk_cache.private_files import make_folder, privacy_problem, warn_once
from wucht.disk_cache.user_key import key_for

_Result = TypeVar("_Result")
_STABLE_PACKAGES = {"wucht", "sympy", "builtins"}  # packages whose classes belong to the state of the program
_LIBRARIES = ("sympy", "numpy", "pint")  # of whose versions results depend; those of LLVM are inputs
_STATE_DIGITS = 16
_PROGRAMS = 4  # states of the program whose results are kept: those used last


def derived_once(function: Callable[..., _Result]) -> Callable[..., _Result]:
    """A pure function of frozen data, given by position, that is called once for all processes.

    Inputs and results are frozen dataclasses, SymPy's expressions, sequences, text and numbers; a result may be bytes. Errors
    are not cached, nor results for classes of the user: their code may change from one process to the next.
    """

    @wraps(function)
    def cached_function(*inputs: Any) -> _Result:
        folder = _usable_folder(cache_folder())
        if folder is None:
            return function(*inputs)
        try:
            key = sha256(_key_bytes(inputs)).hexdigest()[:40]
        except (pickle.PicklingError, TypeError, AttributeError):
            return function(*inputs)
        name = f"{folder}/{function.__module__}.{function.__name__}-{key}"
        with suppress(OSError, ValueError):  # not there, or not written by this user's processes
            stored_result: _Result = from_bytes(read_entry(name))
            return stored_result
        result = function(*inputs)
        with suppress(OSError, TypeError):  # no room, or no right to write there, or no frozen data: it is derived again
            store_entry(name, to_bytes(result))
        return result

    return cached_function


def _usable_folder(root: Path) -> str | None:
    """Name of the folder for the present state of the program; None where the cache cannot be used.

    Warns, once in a process, of a folder that is not the user's alone.
    """
    if key_for(root) is None:
        return None
    name = _program_folder(root)
    try:
        problem = privacy_problem(root / name, (root / name).lstat())
    except (OSError, RuntimeError):
        return None
    if problem is not None:
        warn_once(f"the cache folder {root / name} {problem}: it is not used; see WUCHT_CACHE_DIR")
    return None if problem else name


class _KeyPickler(pickle.Pickler):
    """Writes inputs for a key, which is never read: of a dataclass only the fields that it is compared by.

    Its cached properties may hold hashes, which differ between processes.
    """

    def __init__(self, file: BytesIO) -> None:
        super().__init__(file, protocol=5)
        self.fast = True  # the same bytes whether equal parts are one object or two

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, type):
            if value.__module__.split(".")[0] not in _STABLE_PACKAGES:
                raise pickle.PicklingError(f"{value.__qualname__} is a class of the user")
            return NotImplemented
        if is_dataclass(value):
            return __newobj__, (type(value),), {f.name: getattr(value, f.name) for f in fields(value) if f.compare}
        if hasattr(value, "model_fields_set"):  # a set, whose order differs between processes
            return __newobj__, (type(value),), dict(vars(value))
        return NotImplemented


def _key_bytes(inputs: tuple[Any, ...]) -> bytes:
    file = BytesIO()
    _KeyPickler(file).dump(inputs)
    return file.getvalue()


@cache
def _program_folder(root: Path) -> str:
    """Name of the folder for the present state of the program, made if possible; old ones are removed."""
    from importlib.metadata import version

    versions = sys.version, *map(version, _LIBRARIES)
    state = sha256(repr((versions, program_state())).encode()).hexdigest()[:_STATE_DIGITS]
    folder = root / f"derived-{state}"
    with suppress(OSError):
        make_folder(root)
        make_folder(folder)
        os.utime(folder)
        ours = "derived-" + _STATE_DIGITS * "[0-9a-f]"  # the folder may be one with other work of the user
        for old in sorted(root.glob(ours), key=lambda p: -p.stat().st_mtime)[_PROGRAMS:]:
            rmtree(old, ignore_errors=True)
    return folder.name


def program_state() -> str:
    """A digest of the contents of all source files: their times may be the same for all, as in reproducible builds."""
    package = os.path.dirname(os.path.dirname(__file__))  # noqa: PTH120 - pathlib takes twice as long here
    names = [os.path.join(folder, name) for folder, _, names in os.walk(package) for name in names if name.endswith(".py")]  # noqa: PTH118
    digest = sha256()
    for name in sorted(names):
        with open(name, "rb") as file:  # noqa: PTH123
            digest.update(repr((name[len(package) :], sha256(file.read()).digest())).encode())
    return digest.hexdigest()
