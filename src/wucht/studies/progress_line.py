"""The progress of a study in a notebook, or in IPython on a terminal: one line, which is gone when the study ends."""

from __future__ import annotations

import sys
import time as clock
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import Any

from wucht.dynamics.work import Report

_PATIENCE_S = 0.5  # a study that takes no longer shows nothing
_PAUSE_S = 0.2  # between two changes of the line


@contextmanager
def progress_line(title: str) -> Iterator[Report | None]:
    """Show the progress of a study while the block lasts; None, and nothing is shown, anywhere but in IPython."""
    show = _shown_in(getattr(sys.modules.get("IPython"), "get_ipython", lambda: None)())
    if show is None:
        yield None
        return
    begin = clock.perf_counter()
    last_change = begin + _PATIENCE_S - _PAUSE_S

    def report(share: float, label: str) -> None:
        nonlocal last_change
        now = clock.perf_counter()
        if now - last_change > _PAUSE_S:
            last_change = now
            show(f"{title}: {100 * min(share, 1.0):.0f} %{f', {label}' if label else ''}, {now - begin:.0f} s")

    try:
        yield report
    finally:
        if last_change > begin + _PATIENCE_S:
            show("")


def _shown_in(shell: Any) -> Callable[[str], None] | None:
    """The function that writes the line: an output of a notebook that changes, or a line of a terminal."""
    if hasattr(shell, "kernel"):
        return _notebook_line()
    return _write_terminal_line if shell is not None and sys.stderr.isatty() else None


def _notebook_line() -> Callable[[str], None]:
    from IPython.display import display

    handles: list[Any] = []

    def show(text: str) -> None:
        data = {"text/plain": text}
        if handles:
            handles[0].update(data, raw=True)
        else:
            handles.append(display(data, raw=True, display_id=True))  # type: ignore[no-untyped-call]

    return show


def _write_terminal_line(text: str) -> None:
    sys.stderr.write(f"\r\033[K{text}")  # back to its begin, and what was there is erased
    sys.stderr.flush()
