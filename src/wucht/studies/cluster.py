"""Units of work on several machines: the workers of a scheduler of dask.distributed compute them, this process stores them.

Only the network is shared: a task is sent to a worker as bytes, with all that it needs, and its result is returned. The task
of a worker that died is computed by another one.
"""

from __future__ import annotations

import logging
import pickle
import time as clock
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from functools import cache
from hashlib import sha256
from itertools import islice
from pathlib import Path
from queue import Empty, SimpleQueue
from typing import TYPE_CHECKING, Any, TypeVar
from uuid import uuid4

import numpy as np

from wucht.dynamics.work import Task, TaskReport
from wucht.errors import InputError, RunError, nearest
from wucht.results.provenance import versions

if TYPE_CHECKING:
    from distributed import Client, Future, Worker

T = TypeVar("T")
_AHEAD = 2  # submitted tasks per thread of the workers: one running, one waiting
_ANSWER_S = 5.0  # time within which a scheduler must answer
_PROTOCOLS = ("tcp", "tls", "ucx", "ws", "wss")
_LAST_PORT, _DIGITS = 65535, 6  # leading digits of a port that are parsed
_TICK_S = 0.1  # between two checks for an interrupt by the user
_POLL_S = 2.0  # between two queries of the workers
_REPORT_S = 1.0  # between two progress reports of a worker


class DaskCluster:
    """The workers of a scheduler, opened by ``cluster_at``."""

    def __init__(self, client: Client, address: str) -> None:
        self._client, self._address = client, address
        self._poll_time, self._threads = -_POLL_S, dict[str, int]()

    def compute(self, tasks: Mapping[str, Task[T]], report: Callable[[float, str], None]) -> Iterator[tuple[str, T]]:
        """Yield the results of tasks by name, in the order of completion.

        report: called with the completed share of all tasks and the number of workers. After ``KeyboardInterrupt``, which it
        may raise, completed results are still yielded, the others are cancelled, and then the interrupt is raised.

        Raises
        ------
        RunError
            If the scheduler disappears, a worker has another version or lacks a module, or a task kills several workers.
        """
        waiting, under_way, done = iter(tasks.items()), dict[Any, str](), 0
        shares, ready_futures = dict[str, float](), SimpleQueue[Any]()
        topic, environment = f"wucht-{uuid4().hex}", _environment()
        self._client.subscribe_topic(topic, lambda event: shares.update(dict([event[1]])))
        try:
            while True:
                workers = self._workers()
                for name, task in islice(waiting, max(0, _AHEAD * max(1, sum(workers.values())) - len(under_way))):
                    payload, key = pickle.dumps(task), f"{topic}-{name}"
                    future = self._client.submit(_compute_on_worker, payload, environment, topic, name, key=key, pure=False)
                    under_way[future] = name
                    future.add_done_callback(ready_futures.put)
                if not under_way:
                    return
                share = (done + sum(shares.get(name, 0.0) for name in under_way.values())) / len(tasks)
                report(share, f", {_worker_count(workers)}" if workers else f", waiting for workers at {self._address}")
                try:
                    future = ready_futures.get(timeout=_TICK_S)
                    outcome = self._outcome(future, under_way[future])
                except Empty:
                    continue
                except TimeoutError:  # it was lost with its worker before it arrived
                    ready_futures.put(future)
                    continue
                done += 1
                yield under_way.pop(future), outcome
        except KeyboardInterrupt:
            for future in [f for f in under_way if f.status == "finished"]:
                yield under_way[future], self._outcome(future, under_way.pop(future))
            raise
        finally:
            if self._client.status == "running":
                self._client.cancel(list(under_way))
                self._client.unsubscribe_topic(topic)

    def _workers(self) -> dict[str, int]:
        """Threads by worker. Raises ``RunError`` if the scheduler has disappeared."""
        if clock.monotonic() - self._poll_time > _POLL_S:
            try:
                self._threads = dict(self._client.nthreads()) if self._client.status == "running" else {}
            except OSError:
                self._threads = {}
            if self._client.status != "running":
                raise self._scheduler_gone()
            self._poll_time = clock.monotonic()
        return self._threads

    def _outcome(self, future: Future, name: str) -> Any:
        """The result of a task. Raises the error of the task, or ``TimeoutError`` if the result has not arrived yet."""
        import asyncio
        from concurrent import futures

        from distributed import KilledWorker

        try:
            return future.result(timeout=_TICK_S)
        except (asyncio.CancelledError, futures.CancelledError):
            raise self._scheduler_gone() from None
        except KilledWorker as error:
            advice = "they may lack memory; --resume computes the rest"
            raise RunError(f"workers have died repeatedly while they computed {name} ({error.last_worker}): {advice}") from None
        except ImportError as error:
            raise RunError(f"a worker cannot compute: {error}; install the same wucht[cluster] there") from None

    def _scheduler_gone(self) -> RunError:
        return RunError(
            f"the scheduler at {self._address} is gone; --resume continues from the completed work", code="scheduler-gone"
        )


def _worker_count(workers: Mapping[str, int]) -> str:
    return f"{len(workers)} worker{'s' if len(workers) > 1 else ''}"


@contextmanager
def cluster_at(address: str | None) -> Iterator[DaskCluster | None]:
    """Connect to the workers of the scheduler at an address while the block lasts; None without an address.

    Raises ``InputError`` for an invalid address, if no scheduler answers or it has another version, and without
    dask.distributed.
    """
    if address is None:
        yield None
        return
    if (problem := address_error(address)) is not None:
        raise InputError(
            "--scheduler", address, f"must be the address of a scheduler, such as tcp://host:8786: {problem}", code="address"
        )
    try:
        from distributed import Client
    except ImportError:
        raise InputError(
            "--scheduler", address, "needs dask.distributed: pip install 'wucht[cluster]'", code="no-extra"
        ) from None
    with _silent("distributed", "distributed.client"):  # their messages are replaced by sentences
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")  # about versions, which are compared below
                client = Client(address.removesuffix("/"), timeout=_ANSWER_S, set_as_default=False)
        except (ValueError, TypeError) as error:
            needs = "its protocol needs a part of dask.distributed that is not installed or not configured here"
            raise InputError("--scheduler", address, f"{needs}: {error}", code="unsupported") from None
        except OSError as error:
            remedy = "`dask scheduler --host 127.0.0.1` starts one"
            requirement = f"no scheduler answers there within {_ANSWER_S:g} s ({error}); {remedy}"
            raise InputError("--scheduler", address, requirement, code="no-answer") from None
        try:
            _check_versions(client, address)
            yield DaskCluster(client, address)
        finally:
            client.close()


def address_error(address: str) -> str | None:
    """Describe what an address lacks of ``PROTOCOL://HOST:PORT``, None if nothing."""
    protocol, separator, place = address.partition("://")
    if not separator:
        return f"it does not begin with a protocol, one of {', '.join(_PROTOCOLS)}"
    if protocol not in _PROTOCOLS:
        return f"unknown protocol; {nearest(protocol, _PROTOCOLS)}"
    return _host_error(place.removesuffix("/"))


def _host_error(place: str) -> str | None:
    """Describe what is wrong with ``HOST:PORT``; an IPv6 address, which contains colons, must be in brackets."""
    host, colon, port = place.partition(":")
    if place.startswith("["):
        host, bracket, rest = place[1:].partition("]")
        colon, port = rest[:1], rest[1:]
        if not bracket:
            return "the bracket of its host is not closed"
    if not host or any(letter.isspace() for letter in host):
        return "the name of a host cannot have blanks" if host else "it has no host"
    if colon != ":":
        return "it has no port"
    if not (port.isascii() and port.isdigit() and 1 <= int(port[:_DIGITS]) <= _LAST_PORT):
        return f"its port must be a whole number from 1 to {_LAST_PORT}; an IPv6 address must be in brackets"
    return None


@contextmanager
def _silent(*loggers: str) -> Iterator[None]:
    """Silence these loggers, except for critical messages, while the block lasts."""
    before = {name: logging.getLogger(name).level for name in loggers}
    try:
        for name in loggers:
            logging.getLogger(name).setLevel(logging.CRITICAL)
        yield
    finally:
        for name, level in before.items():
            logging.getLogger(name).setLevel(level)


def _check_versions(client: Client, address: str) -> None:
    """Raise ``InputError`` if the scheduler, which unpickles tasks, or a worker has another version of wucht or none."""
    local_version = versions()["wucht"]
    remote_versions = client.get_versions(packages=["wucht"])
    places = {
        "the scheduler": remote_versions["scheduler"],
        **{f"the worker {k}": v for k, v in remote_versions["workers"].items()},
    }
    for place, info in places.items():
        version = info["packages"].get("wucht") if info else None
        if version != local_version:
            has = f"wucht {version}" if version else "no wucht"
            raise InputError(
                "--scheduler", address, f"{place} has {has}; this process has wucht {local_version}", code="other-version"
            )


def _environment() -> dict[str, str]:
    """Versions of everything that could change a result, except the processor."""
    return versions() | {"code of wucht": _code()}


@cache
def _code() -> str:
    """Digest of wucht's source files: a checkout can change without its version."""
    package, digest = Path(__file__).parents[1], sha256()
    for file in sorted(package.rglob("*.py")):
        digest.update(file.relative_to(package).as_posix().encode())
        digest.update(file.read_bytes())
    return digest.hexdigest()[:8]


def _compute_on_worker(payload: bytes, expected_environment: Mapping[str, str], topic: str, name: str) -> Any:
    """Compute a task on a worker, if its versions are those of the submitting process."""
    from distributed import Reschedule, get_worker

    worker = get_worker()
    environment = _environment()
    version_pairs = {
        k: (version, environment.get(k)) for k, version in expected_environment.items() if environment.get(k) != version
    }
    if version_pairs:
        differ = ", ".join(f"{k} {theirs} (here {ours})" for k, (ours, theirs) in version_pairs.items())
        raise RunError(
            f"the worker {worker.address} has {differ}: all must have the same, for the same result", code="other-versions"
        )
    try:
        task: Task[Any] = pickle.loads(payload)
    except (ImportError, AttributeError) as error:
        advice = "modules given by --import must be installed there"
        raise RunError(f"the worker {worker.address} cannot load its task ({error}): {advice}", code="not-loaded") from None
    try:
        with np.errstate(all="ignore"):
            return task(_progress_reporter(worker, topic, name))
    except KeyboardInterrupt:
        raise Reschedule from None  # ignored by the scheduler for a cancelled task


def _progress_reporter(worker: Worker, topic: str, name: str) -> TaskReport:
    """Function that reports the progress of a task, and raises ``KeyboardInterrupt`` when the task was cancelled."""
    key, report_time = worker.get_current_task(), clock.monotonic()

    def report_share(share: float) -> None:
        nonlocal report_time
        task_state = worker.state.tasks.get(key)
        if task_state is None or task_state.state == "cancelled":
            raise KeyboardInterrupt
        if clock.monotonic() - report_time > _REPORT_S:
            report_time = clock.monotonic()
            worker.log_event(topic, (name, share))

    return report_share
