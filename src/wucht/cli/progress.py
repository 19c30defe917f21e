"""Progress on stderr: a moving bar on a terminal only, and only if the run takes longer than a moment."""

from __future__ import annotations

import sys
import threading
import time
from contextlib import suppress
from typing import TYPE_CHECKING

from wucht.file_names import printable

if TYPE_CHECKING:
    import rich.progress

_PATIENCE_S = 0.5
_SILENCE_S = 5.0  # at most, while a run has nothing to report yet


class Progress:
    """Progress of one run: on a terminal a bar, elsewhere a single line; also while a run has nothing to report yet."""

    def __init__(self, title: str) -> None:
        self._title, self._start_time, self._is_announced = printable(title), time.perf_counter(), False
        self._bar: rich.progress.Progress | None = None
        self._one_at_a_time = threading.Lock()
        self._alarm = threading.Timer(_SILENCE_S, self._begin)
        self._alarm.daemon = True

    def __enter__(self) -> Progress:
        self._alarm.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._alarm.cancel()
        with self._one_at_a_time:
            self._is_announced = True  # nothing is printed after the end
            if self._bar is not None:
                self._bar.stop()

    def update(self, share: float, label: str) -> None:
        """Show the completed share of the work (0 to 1) and the name of the current step."""
        if time.perf_counter() - self._start_time < _PATIENCE_S:
            return
        self._begin()
        if self._bar is not None:
            from rich.markup import escape

            description = f"{self._title}: {label}" if label else self._title
            self._bar.update(self._bar.task_ids[0], completed=share, description=escape(description))

    def _begin(self) -> None:
        """Announce once that the run is under way."""
        with self._one_at_a_time:
            if self._is_announced:
                return
            self._is_announced = True
            if not sys.stderr.isatty():
                with suppress(OSError):  # no space for the message: the result does not depend on it
                    sys.stderr.write(f"running {self._title} ...\n")
                    sys.stderr.flush()
                return
            import rich.progress as rich_progress
            from rich.console import Console
            from rich.markup import escape

            self._bar = rich_progress.Progress(console=Console(stderr=True), transient=True)
            self._bar.add_task(escape(self._title), total=1.0)
            self._bar.start()
