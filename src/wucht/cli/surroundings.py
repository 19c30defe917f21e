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

from wucht.environment import date_of_files, set_threads
from wucht.errors import InputError, WuchtError

_KB, _KB_A_THREAD = 1_300_000, 85_000  # of address space: for the start of the largest studies, and for each further thread
_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STDERR = 2
_STOP_MESSAGE = b"\nstopping after the current step; Ctrl-C again stops at once, without saving\n"


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
    sys.stdout = sys.stdout or _null_stream()
    sys.stderr = sys.stderr or _null_stream()


def _null_stream() -> io.TextIOWrapper:
    return Path(os.devnull).open("w", encoding="utf-8", errors="replace")


def without_figure_settings() -> None:
    """Load matplotlib without the user's settings: figures are the same everywhere, and faulty settings do no harm."""
    os.environ["MPLBACKEND"] = "agg"
    module_spec = importlib.util.find_spec("matplotlib")
    if module_spec is None or module_spec.origin is None:
        return
    data_folder = Path(module_spec.origin).with_name("mpl-data")
    os.environ["MATPLOTLIBRC"] = str(data_folder / "matplotlibrc")
    if Path("matplotlibrc").exists() and data_folder.is_dir():  # a file in the working directory would take precedence
        with chdir(data_folder):
            importlib.import_module("matplotlib")


@contextmanager
def without_dask() -> Iterator[None]:
    """Hide dask from xarray, which imports it wherever it is installed: a tenth of the time of a command without use for it.

    Nothing changes where either is loaded already, nor where there are studies of another package, which may compute with it.
    """
    from wucht.studies.registry import studies

    has_foreign_studies = any(not entry.place.startswith("wucht.") for entry in studies().values())
    if has_foreign_studies or "dask" in sys.modules or "xarray" in sys.modules:
        yield
        return
    sys.modules["dask"] = None  # type: ignore[assignment]  # Python's way to say that there is no such module
    try:
        yield
    finally:
        del sys.modules["dask"]


def check_environment() -> None:
    """Raise ``InputError`` for an environment variable with which a run would fail after all has been computed."""
    date_of_files()


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
    set_threads(1 + (limit // 1024 - _KB) // _KB_A_THREAD)


@contextmanager
def interrupt_check() -> Iterator[Callable[[], None]]:
    """Turn signals into ``KeyboardInterrupt``, which the yielded function raises when it is called next.

    Until that function has been called for the first time there is nothing to save, and a signal interrupts at once; a second
    signal always does. An error that a library makes of it, such as an import that fails half-way, counts as the interrupt;
    where a library swallows it, the function raises it.
    """
    signals, check_calls = list[int](), set[bool]()

    def remember(number: int, _frame: object) -> None:
        signals.append(number)
        if not check_calls:
            raise KeyboardInterrupt
        with suppress(OSError):
            os.write(_STDERR, _STOP_MESSAGE)  # not by sys.stderr, in which the signal may have arrived
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def check() -> None:
        check_calls.add(True)
        if signals:
            raise KeyboardInterrupt

    before = {s: signal.signal(s, remember) for s in _SIGNALS}
    try:
        yield check
    except WuchtError:
        raise
    except Exception:
        if signals:
            raise KeyboardInterrupt from None
        raise
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)
