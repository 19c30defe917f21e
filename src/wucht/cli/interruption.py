"""Ctrl-C, or a batch system's SIGTERM: the run is asked to stop where it can be saved, instead of being cut off anywhere."""

from __future__ import annotations

import os
import signal
from collections.abc import Callable, Iterator
from contextlib import contextmanager, suppress

from wucht.errors import WuchtError

_SIGNALS = (signal.SIGINT, signal.SIGTERM)
_STDERR = 2
_HEARD = b"\nstopping: what was found is saved as soon as the step under way is done; once more ends at once, without that\n"


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
