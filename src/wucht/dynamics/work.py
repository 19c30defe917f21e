"""Work in named, deterministic units: computed once and then stored, with progress, on this computer or on several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ParamSpec, Protocol, TypeVar

from wucht.errors import WuchtError

T = TypeVar("T")
F = TypeVar("F")
P = ParamSpec("P")
Report = Callable[[float, str], None]  # the share that is done (0 to 1), and the current activity
TaskReport = Callable[[float], None]  # the share of a task that is done, 0 to 1; may raise ``KeyboardInterrupt``
Task = Callable[[TaskReport], T]
PREPARATION = "preparation"  # the activity before a run, whose time is none of its pace


class LeastShare(float):
    """A share of which no duration follows: at least so much is done, of work that may end at any time.

    Such are runs until settled, whose share is that of the longest one, and units in progress, which may be made of such runs.
    """


class Memory(Protocol):
    """Store of completed units of work, by name."""

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """Return the result of a unit: read back, or computed now and stored."""
        ...

    def knows(self, name: str) -> bool:
        """True if a unit can be read back."""
        ...

    def keep(self, name: str, outcome: Any) -> None:
        """Store the result of a computed unit."""
        ...


class NoMemory:
    """Memory that stores nothing: each unit is computed when it is needed."""

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """See ``Memory``."""
        return compute()

    def knows(self, name: str) -> bool:
        """See ``Memory``."""
        return False

    def keep(self, name: str, outcome: Any) -> None:
        """See ``Memory``."""


class Cluster(Protocol):
    """Computation of tasks on several computers."""

    def compute(self, tasks: Mapping[str, Task[Any]], report: Report) -> Iterator[tuple[str, Any]]:
        """Yield the results of tasks by name, in the order in which they are ready."""
        ...


@dataclass(frozen=True)
class Work:
    """Part of the work of an engine: where its units are stored and computed, and to whom progress is reported.

    ``Work()`` computes everything in this process, stores nothing and reports nothing.

    Parameters
    ----------
    memory : Memory, optional
        Store of completed units.
    reporter : callable, optional
        Called with the share that is done, 0 to 1, and a text.
    cluster : Cluster, optional
        Whose workers compute independent units; None: this process.
    name : str, optional
        Prefix of the names of its units.
    begin, end : float, optional
        The share of the whole study.
    is_open_ended : bool, optional
        True if it may end before its reports say so: they are of ``LeastShare``.
    """

    memory: Memory = field(default_factory=NoMemory)
    reporter: Report | None = None
    cluster: Cluster | None = None
    name: str = ""
    begin: float = 0.0
    end: float = 1.0
    is_open_ended: bool = False

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """Return the result of a deterministic unit of work, a frozen dataclass: computed once, then stored."""
        return self.memory.unit(self.name + name, compute)

    def units(self, tasks: Mapping[str, Task[T]], label: str = "") -> Iterator[tuple[str, T]]:
        """Yield the results of independent units of about the same size, by name; as they come, in any order.

        tasks: functions that can be pickled, of frozen data alone; each is called with a function that reports its share done,
        which raises ``KeyboardInterrupt`` to abandon it. label: of the units, for the progress.
        """
        if self.cluster is None:
            for k, (name, task) in enumerate(tasks.items()):
                part = self.part("", k / len(tasks), (k + 1) / len(tasks))
                outcome = part.unit(name, partial(part._compute, task, label))
                part.report(1.0, label)
                yield name, outcome
            return
        stored_names = [name for name in tasks if self.memory.knows(self.name + name)]
        for name in stored_names:
            yield name, self.memory.unit(self.name + name, partial(tasks[name], _ignore_progress))
        rest = self.part("", len(stored_names) / max(len(tasks), 1), 1.0)
        remaining_tasks = {name: task for name, task in tasks.items() if name not in stored_names}
        complete, largest, text = 0.0, 0.0, label  # complete: less than was reported where others are nearly complete, too

        def report_under_way(share: float, worker_text: str) -> None:
            nonlocal largest, text
            text = f"{label}{worker_text}"
            if complete > largest:
                rest.report(complete, text)
            largest = max(largest, complete, share)
            rest.open_ended.report(largest, text)

        for number, (name, outcome) in enumerate(self.cluster.compute(remaining_tasks, report_under_way), 1):
            self.memory.keep(self.name + name, outcome)
            complete = number / len(remaining_tasks)
            yield name, outcome
        if remaining_tasks:
            rest.report(1.0, text)

    def _compute(self, task: Task[T], label: str) -> T:
        self.report(0.0, label)
        under_way = self.open_ended
        return task(lambda share: under_way.report(share, label))

    def report(self, share: float, label: str = "") -> None:
        """Report how far this part is, 0 to 1. Raises ``KeyboardInterrupt`` where the user has requested to stop."""
        if self.reporter is not None:
            done = self.begin + (self.end - self.begin) * min(max(share, 0.0), 1.0)
            self.reporter(LeastShare(done) if self.is_open_ended else done, label)

    @property
    def without_memory(self) -> Work:
        """Same work without storage: for parts of a unit."""
        return replace(self, memory=NoMemory())

    @property
    def open_ended(self) -> Work:
        """Same work where it may end before its reports say so."""
        return replace(self, is_open_ended=True)

    def part(self, name: str, begin: float, end: float) -> Work:
        """Return a part of this work, from one share of it to another, with a prefix for its names."""
        width = self.end - self.begin
        path = f"{self.name}{name}/" if name else self.name
        return replace(self, name=path, begin=self.begin + begin * width, end=self.begin + end * width)


def result_or_reason(make: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | str:
    """Return the result of a function, or the sentence why there is none."""
    try:
        return make(*args, **kwargs)
    except WuchtError as error:
        return str(error)


def with_result(findings: F, into: str, result: Any, missing: str = "") -> F:
    """Add a result to a field of findings that is a tuple, or the sentence why there is none to ``omissions``.

    missing: beginning of that sentence.
    """
    name, more = ("omissions", missing + result) if isinstance(result, str) else (into, result)
    extended_findings: F = replace(findings, **{name: (*getattr(findings, name), more)})  # type: ignore[type-var]
    return extended_findings


def _ignore_progress(share: float) -> None:
    """Ignore the progress of a task."""
