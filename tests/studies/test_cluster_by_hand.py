"""Workers and schedulers that are made by hand: what a worker checks, tells and refuses, and what the process makes of it."""

from __future__ import annotations

import asyncio
import pickle
import time as clock
from collections.abc import Callable
from types import SimpleNamespace
from typing import Any

import pytest
from tests.refusals import refused

from wucht import RunError
from wucht.studies import cluster
from wucht.studies.cluster import (
    DaskCluster,
    _check_versions,
    _compute_on_worker,
    _environment,
    _progress_reporter,
    address_error,
)

distributed = pytest.importorskip("distributed")


class Work:
    """A worker, with one task under way."""

    address = "tcp://w:1"

    def __init__(self, state: str | None = "executing") -> None:
        self.events = list[Any]()
        self.state = SimpleNamespace(tasks={} if state is None else {"key": SimpleNamespace(state=state)})

    def get_current_task(self) -> str:
        return "key"

    def log_event(self, topic: str, what: Any) -> None:
        self.events.append((topic, what))


def half(report: Callable[[float], None]) -> float:
    """A task."""
    report(0.25)
    return 0.5


def stopped(report: Callable[[float], None]) -> float:
    """A task that is stopped."""
    raise KeyboardInterrupt


@pytest.fixture
def worker(monkeypatch: pytest.MonkeyPatch) -> Work:
    made = Work()
    monkeypatch.setattr(distributed, "get_worker", lambda: made)
    return made


def test_a_worker_computes_what_it_is_given(worker: Work, monkeypatch: pytest.MonkeyPatch) -> None:
    assert _compute_on_worker(pickle.dumps(half), _environment(), "topic", "name") == 0.5
    assert worker.events == [], "within a second nothing is told"
    monkeypatch.setattr(cluster, "_REPORT_S", -1.0)
    assert _compute_on_worker(pickle.dumps(half), _environment(), "topic", "name") == 0.5
    assert worker.events == [("topic", ("name", 0.25))]


def test_a_worker_with_something_else_refuses(worker: Work) -> None:
    asked = _environment() | {"numpy": "0.1", "package-of-mine": "2"}
    with pytest.raises(RunError) as raised:
        _compute_on_worker(pickle.dumps(half), asked, "topic", "name")
    differ = f"numpy {_environment()['numpy']} (here 0.1), package-of-mine None (here 2)"
    assert str(raised.value) == f"the worker tcp://w:1 has {differ}: all must have the same, for the same result"
    assert raised.value.code == "other-versions"


@pytest.mark.parametrize("name", [b"own_module_of_nobody\nTask", b"wucht.studies.cluster\nTaskOfNobody"])
def test_a_worker_that_cannot_load_the_task(worker: Work, name: bytes) -> None:
    with pytest.raises(RunError, match=r"^the worker tcp://w:1 cannot load its task \(") as raised:
        _compute_on_worker(b"c" + name + b"\n.", _environment(), "topic", "name")
    assert raised.value.code == "not-loaded" and str(raised.value).endswith("modules given by --import must be installed there")


def test_a_task_that_is_stopped_is_scheduled_anew(worker: Work) -> None:
    with pytest.raises(distributed.Reschedule):
        _compute_on_worker(pickle.dumps(stopped), _environment(), "topic", "name")


def test_how_far_a_task_is_is_told_once_a_second(monkeypatch: pytest.MonkeyPatch) -> None:
    now, worker = [100.0], Work()
    monkeypatch.setattr(clock, "monotonic", lambda: now[0])
    tell: Any = _progress_reporter(worker, "topic", "name")  # type: ignore[arg-type]
    for at, share in ((101.0, 0.1), (101.1, 0.2), (102.0, 0.3), (102.2, 0.4), (103.1, 0.5)):
        now[0] = at
        tell(share)
    assert [share for _, (_, share) in worker.events] == [0.2, 0.4]


@pytest.mark.parametrize("state", [None, "cancelled"])
def test_a_task_for_which_nobody_waits_is_stopped(state: str | None) -> None:
    worker = Work(state)
    with pytest.raises(KeyboardInterrupt):
        _progress_reporter(worker, "topic", "name")(0.5)  # type: ignore[arg-type]
    assert worker.events == []


def test_other_versions_are_refused() -> None:
    ours = _environment()["wucht"]

    def client(scheduler: Any, **workers: Any) -> Any:
        versions = {"scheduler": scheduler, "workers": workers}
        return SimpleNamespace(get_versions=lambda packages: versions if packages == ["wucht"] else None)

    here = {"packages": {"wucht": ours}}
    _check_versions(client(here, a=here), "address")
    for made, says in (
        (client({"packages": {"wucht": "0.0.1"}}), "the scheduler has wucht 0.0.1; this process has wucht " + ours),
        (client(here, a=here, b={"packages": {}}), "the worker b has no wucht; this process has"),
        (client(None), "the scheduler has no wucht"),
    ):
        with refused("--scheduler", says, given="address", code="other-version"):
            _check_versions(made, "address")


def test_an_address_may_end_with_a_slash() -> None:
    for address in ("tcp://host:8786", "tcp://host:8786/", "tcp://[fe80::1]:8786/"):
        assert address_error(address) is None
    assert str(address_error("tcp://host:8786//")).startswith("its port must be a whole number")


# --- the process that asks ---


class Future:
    def __init__(self, result: Any, status: str = "finished") -> None:
        self.status, self._results, self.added = status, iter(result if isinstance(result, list) else [result]), list[Any]()

    def add_done_callback(self, call: Any) -> None:
        if self.status == "finished":
            call(self)

    def result(self, timeout: float) -> Any:
        outcome = next(self._results)
        if isinstance(outcome, BaseException):
            raise outcome
        return outcome


class Client:
    """Of two threads; futures in the order in which tasks are submitted."""

    status = "running"

    def __init__(self, *futures: Future) -> None:
        self._futures, self.cancelled, self.topics = iter(futures), list[Any](), list[str]()

    def subscribe_topic(self, topic: str, call: Any) -> None:
        self.topics.append(topic)
        self.tell = call

    def unsubscribe_topic(self, topic: str) -> None:
        self.topics.remove(topic)

    def nthreads(self) -> dict[str, int]:
        return {"a": 2}

    def submit(self, function: Any, *given: Any, key: str, pure: bool) -> Future:
        assert function is _compute_on_worker and not pure and key.endswith(f"-{given[3]}")
        return next(self._futures)

    def cancel(self, futures: list[Any]) -> None:
        self.cancelled += futures


def computed(client: Client, count: int, report: Any = lambda *_: None) -> list[Any]:
    tasks = {f"t{k}": half for k in range(count)}
    return list(DaskCluster(client, "tcp://s:1").compute(tasks, report))  # type: ignore[arg-type]


def test_results_come_with_their_names_and_the_share_is_told() -> None:
    told = list[Any]()
    client = Client(Future(1), Future(2), Future(3))
    assert computed(client, 3, lambda share, what: told.append((share, what))) == [("t0", 1), ("t1", 2), ("t2", 3)]
    assert [share for share, _ in told] == pytest.approx([0, 1 / 3, 2 / 3]) and {what for _, what in told} == {", 1 worker"}
    assert client.cancelled == client.topics == []


def test_a_result_that_went_down_with_its_worker_is_waited_for() -> None:
    assert computed(Client(Future([TimeoutError(), TimeoutError(), 1])), 1) == [("t0", 1)]


def test_after_an_interrupt_what_is_done_still_comes() -> None:
    calls, slow = list[int](), Future(9, "pending")
    client = Client(Future(1), slow, Future(3), Future(4))

    def stop(*_: Any) -> None:
        calls.append(1)
        if len(calls) == 2:
            raise KeyboardInterrupt

    tasks, come = {f"t{k}": half for k in range(4)}, list[Any]()
    with pytest.raises(KeyboardInterrupt):
        for one in DaskCluster(client, "tcp://s:1").compute(tasks, stop):  # type: ignore[arg-type]
            come.append(one)
    assert come == [("t0", 1), ("t2", 3), ("t3", 4)] and client.cancelled == [slow] and client.topics == []


GONE = "the scheduler at tcp://s:1 is gone; --resume continues from the completed work"


@pytest.mark.parametrize(
    ("raised", "says"),
    [
        (asyncio.CancelledError(), GONE),
        (
            distributed.KilledWorker("t0", SimpleNamespace(address="tcp://w:1"), 3),
            "workers have died repeatedly while they computed t0 (",
        ),
        (ImportError("no sympy"), "a worker cannot compute: no sympy; install the same wucht[cluster] there"),
    ],
)
def test_why_there_is_no_result(raised: BaseException, says: str) -> None:
    client = Client(Future(raised))
    with pytest.raises(RunError) as error:
        computed(client, 1)
    assert str(error.value).startswith(says) and client.topics == []
    assert (error.value.code == "scheduler-gone") is (says == GONE)


def test_a_scheduler_that_goes_away() -> None:
    class Away(Client):
        def nthreads(self) -> dict[str, int]:
            self.status = "closed"
            raise OSError("gone")

    client = Away()
    with pytest.raises(RunError) as error:
        computed(client, 1)
    assert (str(error.value), error.value.code) == (GONE, "scheduler-gone")
    assert len(client.topics) == 1, "nobody is there to be told"


def test_without_workers_it_waits() -> None:
    class Empty(Client):
        def nthreads(self) -> dict[str, int]:
            return {}

    told = list[str]()
    assert computed(Empty(Future(1)), 1, lambda _, what: told.append(what)) == [("t0", 1)]
    assert told == [", waiting for workers at tcp://s:1"]
    assert cluster._worker_count({"a": 1, "b": 1}) == "2 workers"
