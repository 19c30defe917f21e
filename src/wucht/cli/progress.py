"""A line on stderr that moves: only where someone looks, and only if the run takes a moment."""

from __future__ import annotations

import sys
import time
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    import rich.progress

_PATIENCE_S = 0.5


class Progress:
    """Progress of one run. On a terminal a bar, elsewhere a single line."""

    def __init__(self, title: str) -> None:
        self._title, self._begun, self._said = title, time.perf_counter(), False
        self._bar: rich.progress.Progress | None = None

    def __enter__(self) -> Progress:
        return self

    def __exit__(self, *_: object) -> None:
        if self._bar is not None:
            self._bar.stop()

    def update(self, share: float, what: str) -> None:
        """Show which share of the work is done (0 to 1), and what is under way."""
        if time.perf_counter() - self._begun < _PATIENCE_S:
            return
        if not sys.stderr.isatty():
            if not self._said:
                sys.stderr.write(f"running {self._title} ...\n")
                self._said = True
            return
        if self._bar is None:
            import rich.progress as shown
            from rich.console import Console

            self._bar = shown.Progress(console=Console(stderr=True), transient=True)
            self._bar.start()
            self._bar.add_task(self._title, total=1.0)
        described = f"{self._title}: {what}" if what else self._title
        self._bar.update(self._bar.task_ids[0], completed=share, description=described)
