"""The environment of a command line process: its streams, signals, and settings that are meant for other programs."""

from __future__ import annotations

import importlib.util
import io
import os
import signal
import sys
from collections.abc import Callable, Iterator
from contextlib import chdir, contextmanager, suppress
from pathlib import Path

from wucht.errors import InputError, WuchtError

_EPOCH = "SOURCE_DATE_EPOCH"  # read by libraries when they are loaded, and when a figure is written
_LAST_SECOND = 253402300799  # of the year 9999, the last that a date can have
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")  # read by OpenBLAS when NumPy is loaded, the first before the second
_KB, _KB_A_THREAD = 1_300_000, 85_000  # of address space: for the start of the largest studies, and for each further thread
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STDERR = 2
_HEARD = b"\nstopping: the results so far are saved after the current step; Ctrl-C again stops at once, without saving\n"


def open_streams() -> None:
    """Make sure that there are standard streams, and that they take any text.

    A closed one is connected to the null device, so that no file opened later gets its number; characters that the encoding of
    stdout lacks are replaced.
    """
    for number in range(3):
        try:
            os.fstat(number)
        except OSError:
            os.open(os.devnull, os.O_RDWR)  # gets the lowest number that is free
    if isinstance(sys.stdout, io.TextIOWrapper):
        sys.stdout.reconfigure(errors="replace")
    sys.stdout = sys.stdout or _nowhere()
    sys.stderr = sys.stderr or _nowhere()


def _nowhere() -> io.TextIOWrapper:
    return Path(os.devnull).open("w", encoding="utf-8", errors="replace")


def without_settings_of_figures() -> None:
    """Load matplotlib without the user's settings: figures are the same everywhere, and faulty settings do no harm."""
    os.environ["MPLBACKEND"] = "agg"
    found = importlib.util.find_spec("matplotlib")
    if found is None or found.origin is None:
        return
    own = Path(found.origin).with_name("mpl-data")
    os.environ["MATPLOTLIBRC"] = str(own / "matplotlibrc")
    if Path("matplotlibrc").exists() and own.is_dir():  # a file in the working directory would take precedence
        with chdir(own):
            importlib.import_module("matplotlib")


def check_environment() -> None:
    """Raise ``InputError`` for an environment variable with which a run would fail after all has been computed."""
    given = os.environ.get(_EPOCH)
    if given is not None and not (given.isascii() and given.isdigit() and int(given[:20]) <= _LAST_SECOND):
        allowed = f"this environment variable must be seconds since 1970, a number from 0 to {_LAST_SECOND}, or not be set"
        raise InputError(_EPOCH, given, allowed)


def fit_address_space() -> None:
    """Limit the threads of OpenBLAS to the address space, where that is limited (``ulimit -v``).

    To be called before NumPy is loaded: if OpenBLAS gets no memory it retries for ever, and no signal ends it. The required
    amount is known on Linux only.

    Raises
    ------
    InputError
        If there is not enough for one thread.
    """
    if sys.platform != "linux":
        return
    from resource import RLIM_INFINITY, RLIMIT_AS, getrlimit

    limit, _ = getrlimit(RLIMIT_AS)
    if limit == RLIM_INFINITY:
        return
    if limit < _KB * 1024:
        raise InputError("ulimit -v", str(limit // 1024), f"the address space must be at least {_KB} kB, or unlimited")
    threads = len(os.sched_getaffinity(0))
    for name in reversed(_THREADS):
        with suppress(ValueError):
            threads = int(os.environ.get(name, threads))
    os.environ[_THREADS[0]] = str(max(1, min(threads, 1 + (limit // 1024 - _KB) // _KB_A_THREAD)))


@contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """Turn signals into ``KeyboardInterrupt``, which the yielded function raises when it is called next.

    Until that function has been called for the first time there is nothing to save, and a signal interrupts at once; a second
    signal always does. An error that a library makes of it, such as an import that fails half-way, counts as the interrupt;
    where a library swallows it, the function raises it.
    """
    asked, begun = list[int](), set[bool]()

    def remember(number: int, _frame: object) -> None:
        asked.append(number)
        if not begun:
            raise KeyboardInterrupt
        with suppress(OSError):
            os.write(_STDERR, _HEARD)  # not by sys.stderr, in which the signal may have arrived
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def check() -> None:
        begun.add(True)
        if asked:
            raise KeyboardInterrupt

    before = {s: signal.signal(s, remember) for s in _SIGNALS}
    try:
        yield check
    except WuchtError:
        raise
    except Exception:
        if asked:
            raise KeyboardInterrupt from None
        raise
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)
