"""What was derived once is kept for the next process, as heyoka keeps compiled code: in the user's cache folder.

A result is found by the values of its inputs, and only while the program is what it was: its files, Python and SymPy. Set
``WUCHT_CACHE_DIR`` for another folder. What is there was written by the user's own processes, and is read with ``pickle``.
"""

from __future__ import annotations

import os
import pickle
import sys
import threading
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

_Result = TypeVar("_Result")
_KNOWN = {"wucht", "sympy", "builtins"}  # modules whose classes belong to the state of the program
_PROGRAMS = 4  # states of the program whose results are kept: those used last


def derived_once(function: Callable[..., _Result]) -> Callable[..., _Result]:
    """A pure function of frozen data, given by position, that is called once for all processes.

    Inputs and results are frozen dataclasses, SymPy's expressions, sequences, text and numbers. What it raises is not kept, nor
    what it makes of the user's own classes: their code may change from one process to the next.
    """

    @wraps(function)
    def derived(*inputs: Any) -> _Result:
        try:
            key = sha256(_written(inputs, True)).hexdigest()[:40]
        except (pickle.PicklingError, TypeError, AttributeError):
            return function(*inputs)
        path = _folder() / f"{function.__module__}.{function.__name__}-{key}"
        with suppress(Exception):  # not there, or damaged: then pickle raises whatever it stumbles over
            kept: _Result = pickle.loads(path.read_bytes())
            return kept
        result = function(*inputs)
        beside = path.with_suffix(f".{os.getpid()}-{threading.get_ident()}")
        with suppress(OSError):  # no room, or no right to write there: another process derives it again
            beside.write_bytes(_written(result, False))
            beside.replace(path)
        with suppress(OSError):
            beside.unlink(missing_ok=True)
        return result

    return derived


class _Pickler(pickle.Pickler):
    """Of a dataclass the fields alone: what it has computed of itself may hold hashes, which differ between processes."""

    def __init__(self, file: BytesIO, as_key: bool) -> None:
        super().__init__(file, protocol=5)
        self._as_key = as_key
        self.fast = as_key  # the same bytes whether equal parts are one object or two

    def reducer_override(self, value: Any) -> Any:
        if isinstance(value, type):
            if self._as_key and value.__module__.split(".")[0] not in _KNOWN:
                raise pickle.PicklingError(f"{value.__qualname__} is a class of the user's own")
            return NotImplemented
        if is_dataclass(value):
            own = [f.name for f in fields(value) if f.compare or not self._as_key]
            return __newobj__, (type(value),), {name: getattr(value, name) for name in own}
        if self._as_key and hasattr(value, "model_fields_set"):  # a set, whose order differs between processes
            return __newobj__, (type(value),), dict(vars(value))
        return NotImplemented


def _written(value: Any, as_key: bool) -> bytes:
    file = BytesIO()
    _Pickler(file, as_key).dump(value)
    return file.getvalue()


@cache
def _folder() -> Path:
    """The folder for the program as it is; it need not exist where it cannot be made."""
    import sympy

    files = [os.path.join(folder, name) for folder, _, names in os.walk(Path(__file__).parent) for name in names]  # noqa: PTH118
    states = sorted((path, os.stat(path).st_mtime_ns) for path in files if path.endswith(".py"))  # noqa: PTH116
    state = sha256(repr((sys.version, sympy.__version__, states)).encode()).hexdigest()[:16]
    folder = cache_folder() / f"derived-{state}"
    with suppress(OSError):
        folder.mkdir(parents=True, exist_ok=True)
        os.utime(folder)
        for old in sorted(folder.parent.glob("derived-*"), key=lambda p: -p.stat().st_mtime)[_PROGRAMS:]:
            rmtree(old, ignore_errors=True)
    return folder


def cache_folder() -> Path:
    """The folder of all that is kept between processes: the user's own, or ``WUCHT_CACHE_DIR``."""
    given = os.environ.get("WUCHT_CACHE_DIR")
    if given:
        return Path(given)
    from platformdirs import user_cache_path

    return user_cache_path("wucht", appauthor=False)
