"""Work in named, deterministic units: computed once and then remembered, with progress, on this machine or on several."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any, ParamSpec, Protocol, TypeVar

from wucht.errors import WuchtError

T = TypeVar("T")
F = TypeVar("F")
P = ParamSpec("P")
Report = Callable[[float, str], None]  # the share that is done (0 to 1), and what is under way
TaskReport = Callable[[float], None]  # the share of a task that is done, 0 to 1; may raise ``KeyboardInterrupt``
Task = Callable[[TaskReport], T]


class Memory(Protocol):
    """Where units of work that are done are kept, by name."""

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a unit: read back, or computed now and kept."""
        ...

    def knows(self, name: str) -> bool:
        """Whether a unit can be read back."""
        ...

    def keep(self, name: str, outcome: Any) -> None:
        """Keep the result of a unit that was computed."""
        ...


class NoMemory:
    """Keeps nothing: each unit is computed when it is needed."""

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """See ``Memory``."""
        return compute()

    def knows(self, name: str) -> bool:
        """See ``Memory``."""
        return False

    def keep(self, name: str, outcome: Any) -> None:
        """See ``Memory``."""


class Cluster(Protocol):
    """Computes tasks on several machines."""

    def computed(self, tasks: Mapping[str, Task[Any]], report: Report) -> Iterator[tuple[str, Any]]:
        """The results of tasks by name, in the order in which they are ready."""
        ...


@dataclass(frozen=True)
class Work:
    """cluster: whose workers compute what is independent; None: this process does. name: before the names of its units.
    begin, end: the share of the whole study that this part is."""

    memory: Memory = field(default_factory=NoMemory)
    reporter: Report | None = None
    cluster: Cluster | None = None
    name: str = ""
    begin: float = 0.0
    end: float = 1.0

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a deterministic unit of work, a frozen dataclass: computed once, then remembered."""
        return self.memory.unit(self.name + name, compute)

    def units(self, tasks: Mapping[str, Task[T]], what: str = "") -> Iterator[tuple[str, T]]:
        """The results of units that do not depend on each other, of about the same size, by name; as they come, in any order.

        tasks: functions that can be pickled, of frozen data alone; each is given what to tell the share of it that is done,
        which raises ``KeyboardInterrupt`` where it is to be given up. what: they are, for the progress.
        """
        if self.cluster is None:
            for k, (name, task) in enumerate(tasks.items()):
                part = self.part("", k / len(tasks), (k + 1) / len(tasks))
                outcome = part.unit(name, partial(part._computed, task, what))
                part.report(1.0, what)
                yield name, outcome
            return
        known = [name for name in tasks if self.memory.knows(self.name + name)]
        for name in known:
            yield name, self.memory.unit(self.name + name, partial(tasks[name], _unheard))
        rest = self.part("", len(known) / max(len(tasks), 1), 1.0)
        left = {name: task for name, task in tasks.items() if name not in known}
        for name, outcome in self.cluster.computed(left, lambda share, who: rest.report(share, f"{what}{who}")):
            self.memory.keep(self.name + name, outcome)
            yield name, outcome

    def _computed(self, task: Task[T], what: str) -> T:
        self.report(0.0, what)
        return task(lambda share: self.report(share, what))

    def report(self, share: float, what: str = "") -> None:
        """How far this part is, 0 to 1. Raises ``KeyboardInterrupt`` where the user has asked to stop."""
        if self.reporter is not None:
            self.reporter(self.begin + (self.end - self.begin) * min(max(share, 0.0), 1.0), what)

    @property
    def unkept(self) -> Work:
        """The same work, of which nothing is kept: for parts of a unit."""
        return replace(self, memory=NoMemory())

    def part(self, name: str, begin: float, end: float) -> Work:
        """A part of this work, from one share of it to another, with names of its own."""
        width = self.end - self.begin
        path = f"{self.name}{name}/" if name else self.name
        return replace(self, name=path, begin=self.begin + begin * width, end=self.begin + end * width)


def or_why(make: Callable[P, T], *args: P.args, **kwargs: P.kwargs) -> T | str:
    """What a function makes, or the sentence why it cannot."""
    try:
        return make(*args, **kwargs)
    except WuchtError as error:
        return str(error)


def with_made(findings: F, into: str, made: Any, missing: str = "") -> F:
    """Findings with one more in a field that is a tuple, or among ``lost`` with the sentence why there is none.

    missing: what that sentence begins with.
    """
    name, more = ("lost", missing + made) if isinstance(made, str) else (into, made)
    extended: F = replace(findings, **{name: (*getattr(findings, name), more)})  # type: ignore[type-var]
    return extended


def _unheard(share: float) -> None:
    """Of a task whose progress nobody follows."""
