"""Environment variables, each read with its type, and the sentence for one that cannot be read."""

from __future__ import annotations

import os
import re
import warnings
from datetime import UTC, datetime
from functools import cached_property
from threading import Lock
from typing import Any

from wucht.errors import InputError

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")  # read by OpenBLAS when NumPy is loaded, the first before the second
# NumExpr, which pandas loads where it is installed, ends in a traceback for lists and for what is no number.
_LIBRARIES_THREADS = (*_THREADS, "NUMEXPR_NUM_THREADS", "NUMEXPR_MAX_THREADS")
_LEVELS = re.compile(r"\s*0*([1-9]\d{0,5})\s*(?:,\s*0*[1-9]\d{0,5}\s*)*", re.ASCII)
_EPOCH = "SOURCE_DATE_EPOCH"  # read by other libraries too: when they are loaded, and when a figure is written
_LAST_SECOND = 253402300799  # of the year 9999, the last that a date can have


def environment_of_libraries() -> dict[str, str]:
    """Return the environment with numbers of threads that libraries can read; of OpenBLAS one, unless the user sets another.

    Returns
    -------
    dict of str
        Of a list the first number, which OpenMP uses for the outer of nested levels. What is no number is left out, and a
        warning names it. One thread: the matrices are small, and threads take longer to begin and to wait for each other than
        the equations take.
    """
    environment = dict(os.environ)
    for name in _LIBRARIES_THREADS:
        value = environment.pop(name, "")
        if levels := _LEVELS.fullmatch(value):
            environment[name] = levels[1]
        elif value.strip():
            requirement = "this environment variable must be a number of threads from 1 on, or several with commas, such as 4,2"
            warnings.warn(f"{InputError(name, value, requirement)}; it is not used", stacklevel=2)
    return environment if any(name in environment for name in _THREADS) else environment | {_THREADS[0]: "1"}


def set_threads(most: int | None = None) -> None:
    """Set the threads as in ``environment_of_libraries``, of OpenBLAS at most so many. To be called before NumPy is loaded."""
    environment = environment_of_libraries()
    for name in _LIBRARIES_THREADS:
        os.environ.pop(name, None)
        if name in environment:
            os.environ[name] = environment[name]
    if most is not None:
        threads = next(environment[name] for name in _THREADS if name in environment)
        os.environ[_THREADS[0]] = str(min(int(threads), most))


class OneThread:
    """A limit of OpenBLAS to one thread while runs last, where NumPy is loaded already; a number that the user sets holds.

    Runs in several threads share it: the first sets it, the last one restores what was before.
    """

    def __init__(self) -> None:
        self._lock, self._run_count, self._limit = Lock(), 0, None

    def __enter__(self) -> None:
        with self._lock:
            if self._run_count == 0 and not any(name in os.environ for name in _THREADS):
                self._limit = self._libraries.limit(limits=1, user_api="blas")
            self._run_count += 1

    def __exit__(self, *_error: object) -> None:
        with self._lock:
            self._run_count -= 1
            if self._run_count == 0 and self._limit is not None:
                self._limit.restore_original_limits()
                self._limit = None

    @cached_property
    def _libraries(self) -> Any:
        import scipy.linalg  # noqa: F401 - SciPy has an OpenBLAS of its own
        from threadpoolctl import ThreadpoolController

        return ThreadpoolController()


ONE_THREAD = OneThread()


def date_of_files() -> datetime:
    """Return the date that files state which are written now, in UTC.

    Returns
    -------
    datetime.datetime
        That of the environment variable SOURCE_DATE_EPOCH, in seconds since 1970, so that equal input gives equal files; now
        where it is not set.

    Raises
    ------
    InputError
        (SOURCE_DATE_EPOCH) Where it is no such number: other libraries read it too, and fail when a figure is written.
    """
    value = os.environ.get(_EPOCH)
    if value is None:
        return datetime.now(UTC)
    seconds = re.fullmatch(r"0*(\d{1,12})", value, re.ASCII)
    if seconds is None or int(seconds[1]) > _LAST_SECOND:
        requirement = f"this environment variable must be seconds since 1970, a number from 0 to {_LAST_SECOND}, or not be set"
        raise InputError(_EPOCH, value, requirement)
    return datetime.fromtimestamp(int(seconds[1]), UTC)
