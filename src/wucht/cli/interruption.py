"""Ctrl-C, or a batch system's SIGTERM: the run is asked to stop where it can be saved, instead of being cut off anywhere."""

from __future__ import annotations

import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager

_SIGNALS = (signal.SIGINT, signal.SIGTERM)


@contextmanager
def interruptible() -> Iterator[Callable[[], None]]:
    """While active, the first signal is remembered, and raised as ``KeyboardInterrupt`` by the function that is given; a second
    one acts at once."""
    asked: list[int] = []

    def remember(number: int, _frame: object) -> None:
        asked.append(number)
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def check() -> None:
        if asked:
            raise KeyboardInterrupt

    before = {s: signal.signal(s, remember) for s in _SIGNALS}
    try:
        yield check
    finally:
        for s, handler in before.items():
            signal.signal(s, handler)
