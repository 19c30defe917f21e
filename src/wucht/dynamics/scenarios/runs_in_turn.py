"""Runs that follow each other: of cases one after another, each of them a part of the work."""

from __future__ import annotations

from collections.abc import Callable, Iterator, Sequence
from typing import TypeVar

from wucht.dynamics.work import Work

Case = TypeVar("Case")
Run = TypeVar("Run")


def runs_in_turn(
    cases: Sequence[Case], run: Callable[[Case, Work], Iterator[Run]], work: Work, name: str
) -> Iterator[tuple[Run, ...]]:
    """Yield the runs so far, whenever the last of them has gone further.

    Parameters
    ----------
    cases : sequence
    run : callable
        Yields the run of a case, more and more complete.
    work : Work
    name : str
        Of a case, for the names of its units where there are several.
    """
    complete, count = list[Run](), len(cases)
    for k, case in enumerate(cases):
        part = work.part(f"{name} {k + 1}" if count > 1 else "", k / count, (k + 1) / count)
        for latest in run(case, part):
            yield *complete, latest
        complete.append(latest)
