"""Progress and names of parts of a work, one by one and on a cluster; and results or the reasons why there are none."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

import pytest

from wucht.dynamics.work import LeastShare, NoMemory, Work, result_or_reason, with_result
from wucht.errors import InputError


class Stored:
    """A memory that knows some units."""

    def __init__(self, **known: Any) -> None:
        self.known, self.names = {name.replace("_", "/"): value for name, value in known.items()}, list[str]()

    def unit(self, name: str, compute: Callable[[], Any]) -> Any:
        self.names.append(name)
        return self.known[name] if name in self.known else compute()

    def knows(self, name: str) -> bool:
        return name in self.known

    def keep(self, name: str, outcome: Any) -> None:
        self.known[name] = outcome


def halfway(value: str) -> Callable[[Callable[[float], None]], str]:
    def task(report: Callable[[float], None]) -> str:
        report(0.5)
        return value

    return task


def test_parts_of_parts() -> None:
    reports = list[tuple[float, str]]()
    whole = Work(Stored(), lambda share, label: reports.append((share, label)))
    part = whole.part("a", 0.2, 0.6).part("", 0.5, 1.0).part("b", 0.5, 0.75)
    assert (part.name, part.begin, part.end) == ("a/b/", pytest.approx(0.5), pytest.approx(0.55))
    for share in (-1.0, 0.0, 0.5, 1.0, 2.0):
        part.report(share, "x")
    assert [share for share, _ in reports] == pytest.approx([0.5, 0.5, 0.525, 0.55, 0.55])
    assert part.unit("c", lambda: 7) == 7 and whole.memory.names == ["a/b/c"]  # type: ignore[attr-defined]
    assert isinstance(part.without_memory.memory, NoMemory) and part.without_memory.name == "a/b/"


def test_units_one_after_the_other() -> None:
    reports = list[float]()
    work = Work(Stored(w_one=10), lambda share, label: reports.append(share), name="w/", begin=0.5)
    assert list(work.units({"one": halfway("no"), "two": halfway("yes")}, "l")) == [("one", 10), ("two", "yes")]
    assert reports == pytest.approx([0.75, 0.75, 0.875, 1.0]), "what is stored is done at once"
    assert [isinstance(share, LeastShare) for share in reports] == [False, False, True, False], "a unit may end at any time"
    assert list(Work().units({})) == []


def test_units_on_a_cluster() -> None:
    """Three of four are stored; of the last one's task the cluster reports half."""
    reports, memory = list[tuple[float, str]](), Stored(w_a=1, w_b=2, w_c=3)

    class Workers:
        def compute(self, tasks: Any, report: Any) -> Iterator[tuple[str, Any]]:
            assert list(tasks) == ["d"]
            report(0.5, ", 2 workers")
            yield "d", 4

    work = Work(memory, lambda share, label: reports.append((share, label)), Workers(), "w/")
    tasks = {name: halfway("new") for name in "abcd"}
    assert list(work.units(tasks, "runs")) == [("a", 1), ("b", 2), ("c", 3), ("d", 4)]
    assert reports == [(pytest.approx(0.875), "runs, 2 workers"), (1.0, "runs, 2 workers")] and memory.known["w/d"] == 4
    assert [isinstance(share, LeastShare) for share, _ in reports] == [True, False]


def test_on_a_cluster_no_share_is_less_than_the_one_before() -> None:
    """Two of three are nearly complete when the first one is."""
    reports = list[float]()

    class Workers:
        def compute(self, tasks: Any, report: Any) -> Iterator[tuple[str, Any]]:
            report(0.6, "")
            yield "a", 1
            report(0.65, "")
            yield "b", 2
            report(2 / 3, "")
            yield "c", 3

    work = Work(Stored(), lambda share, _: reports.append(share), Workers(), "w/")
    assert len(list(work.units({name: halfway("new") for name in "abc"}))) == 3
    assert reports == pytest.approx([0.6, 0.65, 2 / 3, 2 / 3, 1.0]) == sorted(reports)
    assert [isinstance(share, LeastShare) for share in reports] == [True, True, False, True, False]


def test_the_parts_of_open_ended_work_are_open_ended() -> None:
    reports = list[float]()
    work = Work(reporter=lambda share, _: reports.append(share))
    work.part("a", 0.0, 0.5).open_ended.part("b", 0.5, 1.0).report(1.0)
    work.report(0.5)
    assert reports == [0.5, 0.5] and [isinstance(share, LeastShare) for share in reports] == [True, False]


@dataclass(frozen=True)
class Findings:
    values: tuple[int, ...] = ()
    omissions: tuple[str, ...] = ()


def test_a_result_or_the_reason() -> None:
    def fails(number: int) -> int:
        raise InputError("study.range", number, "not allowed")

    assert result_or_reason(lambda x, y: x + y, 1, y=2) == 3
    reason = result_or_reason(fails, 5)
    assert isinstance(reason, str) and "study.range" in reason
    with pytest.raises(ZeroDivisionError):
        result_or_reason(lambda: 1 / 0)
    found = with_result(with_result(Findings((1,)), "values", 2), "values", "why", "left out: ")
    assert found == Findings((1, 2), ("left out: why",)) and replace(found, omissions=()) == Findings((1, 2))
