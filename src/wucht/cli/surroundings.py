"""What a process of the command line is started in: its streams, signals, and settings that are meant for other programs."""

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

_EPOCH = "SOURCE_DATE_EPOCH"  # which libraries read when they are loaded, and when a figure is written
_LAST_SECOND = 253402300799  # of the year 9999, the last that a date has
_THREADS = ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS")  # which OpenBLAS reads when NumPy is loaded, the first before the second
_KB, _KB_A_THREAD = 1_300_000, 85_000  # of address space: of the studies that need most to begin, and for each further thread
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STDERR = 2
_HEARD = b"\nstopping: what was found is saved as soon as the step under way is done; once more ends at once, without that\n"


def open_streams() -> None:
    """Make sure that there are standard streams, and that they take any text.

    One that is closed leads nowhere, and no file that is opened later gets its number; what the alphabet of stdout does not
    have is replaced.
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
    """Have matplotlib loaded without the user's own settings: figures are the same everywhere, and wrong ones do no harm."""
    os.environ["MPLBACKEND"] = "agg"
    found = importlib.util.find_spec("matplotlib")
    if found is None or found.origin is None:
        return
    own = Path(found.origin).with_name("mpl-data")
    os.environ["MATPLOTLIBRC"] = str(own / "matplotlibrc")
    if Path("matplotlibrc").exists() and own.is_dir():  # one in the working directory comes before all others
        with chdir(own):
            importlib.import_module("matplotlib")


def check_environment() -> None:
    """Raises ``InputError`` for an environment variable with which a run would fail after it has computed everything."""
    given = os.environ.get(_EPOCH)
    if given is not None and not (given.isascii() and given.isdigit() and int(given[:20]) <= _LAST_SECOND):
        allowed = f"this environment variable must be seconds since 1970, a number from 0 to {_LAST_SECOND}, or not be set"
        raise InputError(_EPOCH, given, allowed)


def fit_address_space() -> None:
    """Have OpenBLAS take no more threads than there is address space for, where it is limited (``ulimit -v``).

    To be called before NumPy is loaded: where OpenBLAS gets no memory it tries again for ever, and no signal ends it. Only on
    Linux is it known what is needed.

    Raises
    ------
    InputError
        Where not even one thread has room.
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
    """While active, a signal is answered at once, and raised as ``KeyboardInterrupt`` by the function that is given.

    It acts at once as long as that function has not been called, when there is nothing to save; a second one always does.
    What a library makes of that, such as an import that fails half-way, is one too; and where it is swallowed, the function
    raises it.
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
