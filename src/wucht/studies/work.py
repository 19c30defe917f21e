"""What a study sees of its runner while it works: units that are remembered, progress, and whether to stop."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, replace
from typing import TypeVar

from wucht.studies.memory import Memory

T = TypeVar("T")
Report = Callable[[float, str], None]  # the share that is done (0 to 1), and what is under way


@dataclass(frozen=True)
class Work:
    """name: before the names of its units. begin, end: the share of the whole study that this part is."""

    memory: Memory = field(default_factory=Memory)
    reporter: Report | None = None
    name: str = ""
    begin: float = 0.0
    end: float = 1.0

    def unit(self, name: str, compute: Callable[[], T]) -> T:
        """The result of a deterministic unit of work, a frozen dataclass: computed once, then remembered."""
        return self.memory.unit(self.name + name, compute)

    def report(self, share: float, what: str = "") -> None:
        """How far this part is, 0 to 1. Raises ``KeyboardInterrupt`` where the user has asked to stop."""
        if self.reporter is not None:
            self.reporter(self.begin + (self.end - self.begin) * min(max(share, 0.0), 1.0), what)

    def part(self, name: str, begin: float, end: float) -> Work:
        """A part of this work, from one share of it to another, with names of its own."""
        width = self.end - self.begin
        return replace(self, name=f"{self.name}{name}/", begin=self.begin + begin * width, end=self.begin + end * width)
