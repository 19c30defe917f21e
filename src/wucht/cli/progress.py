"""Progress on stderr: a moving bar on a terminal only, and only if the run takes longer than a moment."""

from __future__ import annotations

import math
import sys
import threading
import time
from contextlib import suppress
from typing import TYPE_CHECKING

from wucht.dynamics.work import PREPARATION, LeastShare
from wucht.file_names import printable

if TYPE_CHECKING:
    import rich.progress

_PATIENCE_S = 0.5
_SILENCE_S = 5.0  # at most, while a run has nothing to report yet
_PACE_S = 1.0  # of computing, after which its duration is estimated; again each time that this has doubled
_SINGLE_STEP_S = 60.0  # a step that takes so long is the pace, though code that is compiled but once may be part of it
_LONG_S = 60.0  # a run that takes longer is announced with what it will take
_FACTOR, _FALSE_ALARM = 2.0, 0.1  # times what was announced: what is longer or shorter than that is announced, too
_UNITS = (("s", 1.0), ("min", 60.0), ("h", 3600.0), ("days", 86400.0))
_TURNOVER = 1.5  # units: from there on a duration is given in the larger one


def duration_in_words(seconds: float) -> str:
    """Return a duration to two digits in the unit that suits it: ``4 min``."""
    unit, size = next((u for u in reversed(_UNITS) if seconds >= _TURNOVER * u[1]), _UNITS[0])
    number = seconds / size
    digits = max(0, 2 - len(str(int(number)))) if number < 10 else 0
    return f"{number:.{digits}f} {unit}"


class Forecast:
    """Estimate of the remaining duration of a run, from the pace of its latest part.

    A part is some steps from one share to the next. The slowest one is left out where that makes the run shorter: in the first
    ones much is done but once, such as compiling code, for which a run of seconds must not be announced as one of hours. For
    the same reason shares of a unit of work that is in progress are no measure (``LeastShare``): it may end at any time.
    """

    def __init__(self) -> None:
        self._begin: tuple[float, float] | None = None  # of the part, as (time, share)
        self._last = self._slowest = (0.0, 0.0)  # report, and step, as (duration, gain)
        self._steps = 0
        self._pause, self._announced_end = _PACE_S, 0.0

    def remaining(self, time: float, share: float) -> float | None:
        """Return the remaining seconds where they should be announced: a long run, or one for which other ones were announced.

        time: since the beginning of the run, in s; share: that is done.
        """
        if isinstance(share, LeastShare):
            return None
        if self._begin is None or share < self._last[1]:
            self._begin_part(time, share)
        if share > self._last[1]:
            step = time - self._last[0], share - self._last[1]
            self._last, self._slowest, self._steps = (time, share), max(self._slowest, step), self._steps + 1
        pace = self._pace()
        if pace is None:
            return None
        remaining = (1 - share) * pace
        self._begin_part(time, share)
        self._pause *= 2
        if not self._is_news(remaining, max(self._announced_end - time, 0.0)):
            return None
        self._announced_end = time + remaining
        return remaining

    def _is_news(self, remaining: float, expectation: float) -> bool:
        """True where remaining seconds differ from what is expected after the last announcement, or the run is a long one."""
        if not self._announced_end:
            return remaining > _LONG_S
        return remaining > _FACTOR * max(expectation, _LONG_S) or remaining < _FALSE_ALARM * expectation

    def _begin_part(self, time: float, share: float) -> None:
        self._begin = self._last = time, share
        self._slowest, self._steps = (0.0, 0.0), 0

    def _pace(self) -> float | None:
        """Return the seconds that the whole would take at the pace of the present part, None where it is too short for that."""
        assert self._begin is not None
        duration, gain = (last - first for last, first in zip(self._last, self._begin, strict=True))
        if duration < (max(self._pause, _SINGLE_STEP_S) if self._steps == 1 else self._pause):
            return None
        rest = duration - self._slowest[0], gain - self._slowest[1]
        return min(duration / gain, rest[0] / rest[1] if self._steps > 1 else math.inf)


class Progress:
    """Progress of one run: on a terminal a bar, elsewhere a single line; also while a run has nothing to report yet."""

    def __init__(self, title: str) -> None:
        self._title, self._start_time, self._is_announced = printable(title), time.perf_counter(), False
        self._has_ended = False
        self._bar: rich.progress.Progress | None = None
        self._one_at_a_time = threading.Lock()
        self._forecast = Forecast()
        self._alarm = threading.Timer(_SILENCE_S, self._begin)
        self._alarm.daemon = True

    def __enter__(self) -> Progress:
        self._alarm.start()
        return self

    def __exit__(self, *_: object) -> None:
        self._alarm.cancel()
        with self._one_at_a_time:
            self._is_announced = self._has_ended = True  # nothing is printed after the end
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
        if label == PREPARATION:
            return
        remaining = self._forecast.remaining(time.perf_counter() - self._start_time, share)
        if remaining is not None:
            self.announce(f"up to about {duration_in_words(remaining)} to go, at the pace so far")

    def announce(self, text: str) -> None:
        """Print a line on what the run will take, before it is spent."""
        self._begin()
        line = f"{self._title}: {printable(text)}"
        with self._one_at_a_time:
            if self._has_ended:
                return
            if self._bar is not None:
                from rich.markup import escape

                self._bar.console.print(escape(line), highlight=False, soft_wrap=True)
                return
            _write_line(line)

    def _begin(self) -> None:
        """Announce once that the run is under way."""
        with self._one_at_a_time:
            if self._is_announced:
                return
            self._is_announced = True
            if not sys.stderr.isatty():
                _write_line(f"running {self._title} ...")
                return
            import rich.progress as rich_progress
            from rich.console import Console
            from rich.markup import escape

            self._bar = rich_progress.Progress(console=Console(stderr=True), transient=True)
            self._bar.add_task(escape(self._title), total=1.0)
            self._bar.start()


def _write_line(line: str) -> None:
    with suppress(OSError):  # no space for the message: the result does not depend on it
        sys.stderr.write(f"{line}\n")
        sys.stderr.flush()
