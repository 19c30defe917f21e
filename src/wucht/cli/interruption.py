"""Ctrl-C, or a batch system's SIGTERM: the run is asked to stop where it can be saved, instead of being cut off anywhere."""

from __future__ import annotations

import signal
from types import FrameType


class Interruption:
    """While active, the first signal is remembered and raised by ``check``; a second one acts at once."""

    _SIGNALS = (signal.SIGINT, signal.SIGTERM)

    def __init__(self) -> None:
        self._asked = False

    def __enter__(self) -> Interruption:
        self._before = {s: signal.signal(s, self._remember) for s in self._SIGNALS}
        return self

    def __exit__(self, *_: object) -> None:
        for s, handler in self._before.items():
            signal.signal(s, handler)

    def _remember(self, _signal: int, _frame: FrameType | None) -> None:
        self._asked = True
        signal.signal(signal.SIGINT, signal.default_int_handler)
        signal.signal(signal.SIGTERM, signal.SIG_DFL)

    def check(self) -> None:
        """Raises ``KeyboardInterrupt`` if the run was asked to stop."""
        if self._asked:
            raise KeyboardInterrupt
