"""Environment variables, each read with its type, and the sentence for one that cannot be read."""

from __future__ import annotations

import os
import re
import warnings
from datetime import UTC, datetime

from wucht.errors import InputError

_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")  # read by OpenBLAS when NumPy is loaded, the first before the second
_LEVELS = re.compile(r"\s*0*([1-9]\d{0,5})\s*(?:,\s*0*[1-9]\d{0,5}\s*)*", re.ASCII)
_EPOCH = "SOURCE_DATE_EPOCH"  # read by other libraries too: when they are loaded, and when a figure is written
_LAST_SECOND = 253402300799  # of the year 9999, the last that a date can have


def threads_of_user() -> int | None:
    """Return the number of threads of linear algebra that the user sets.

    Returns
    -------
    int or None
        That of OPENBLAS_NUM_THREADS, otherwise of OMP_NUM_THREADS; of a list the first one, which OpenMP uses for the outer
        of nested levels. None where neither is set or can be read: a warning names one that cannot.
    """
    for name in _THREADS:
        value = os.environ.get(name, "")
        if levels := _LEVELS.fullmatch(value):
            return int(levels[1])
        if value.strip():
            requirement = "this environment variable must be a number of threads from 1 on, or several with commas, such as 4,2"
            warnings.warn(f"{InputError(name, value, requirement)}; it is not used", stacklevel=2)
    return None


def use_one_thread() -> None:
    """Let OpenBLAS use one thread, unless the user sets another number. To be called before NumPy is loaded.

    The matrices are small: threads take longer to begin and to wait for each other than the equations take.
    """
    os.environ.update(one_thread())


def one_thread() -> dict[str, str]:
    """Return the variables with which OpenBLAS uses one thread; none where the user sets another number."""
    return {} if threads_of_user() else {_THREADS[0]: "1"}


def limit_threads(most: int) -> None:
    """Let OpenBLAS use at most so many threads. To be called before NumPy is loaded."""
    os.environ[_THREADS[0]] = str(min(threads_of_user() or 1, most))


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
