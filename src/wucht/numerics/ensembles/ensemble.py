"""Ensembles: many starts and parameter sets of one compiled System, tile by tile, one integrator a thread.

The result of a member depends only on its start, its parameters and the pace: to the last bit the same for any order of the
members, any number of threads and any size of the tiles.
"""

from __future__ import annotations

import itertools
import os
import threading
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor, wait
from dataclasses import replace
from functools import cache
from typing import TypeVar

from wucht.errors import WuchtError
from wucht.numerics.ensembles.members import EnsembleResult, Members, Observer, Pacing, Source
from wucht.numerics.ensembles.tile import Tick, run_tile
from wucht.numerics.flow.compiled_batch import CompiledBatch, Quantities, compile_batch
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE
from wucht.system import System

R = TypeVar("R")
# States of all members of a tile: enough for NumPy to observe them together at little cost, few enough to store some hundred
# samples of each; no power of two, so that successive samples of a member do not fall into the same few lines of the cache.
_STATES_PER_TILE = 5952
_TILES_PER_THREAD = 2  # that are in progress, or done and not yet yielded
_TICK_S = 0.1  # between two reports
Report = Callable[[float], None]  # the share that is done, 0 to 1


def compile_ensemble(
    system: System, tolerance: float = DEFAULT_TOLERANCE, quantities: Quantities | None = None
) -> CompiledBatch:
    """Compile a System for ensembles, without its outputs and quadratures; quantities are observed instead of the states."""
    return compile_batch(replace(system, outputs=(), quadratures=()), tolerance, quantities)


def run_ensemble(
    ensemble: CompiledBatch,
    members: Source,
    observer: Observer[R],
    pace: Pacing,
    threads: int | None = None,
    report: Report | None = None,
) -> EnsembleResult[R]:
    """Integrate all members until each has settled, failed or reached the limit of time; ``tiles`` for more than fit in memory.

    Parameters
    ----------
    ensemble : CompiledBatch
    members : Source
        ``Members``, at least one.
    observer : Observer
    pace : Pacing
        Such as a ``Pace``.
    threads : int, optional
        As many as there are processors, if not given.
    report : callable, optional
        Called with the completed share; may raise ``KeyboardInterrupt``.

    Raises
    ------
    WuchtError
        For no member, or members that do not fit the System.
    """
    return EnsembleResult.join([*tiles(ensemble, members, observer, pace, threads=threads, report=report)])


def tiles(
    ensemble: CompiledBatch,
    members: Source,
    observer: Observer[R],
    pace: Pacing,
    size: int | None = None,
    threads: int | None = None,
    report: Report | None = None,
) -> Iterator[EnsembleResult[R]]:
    """Integrate all members tile by tile, and yield their results in order: only a few per thread are in memory.

    After Ctrl-C (``KeyboardInterrupt`` while the caller waits for the next tile, or raised by ``report``) the threads stop, the
    completed tiles are still yielded, and then the interrupt is raised.

    Parameters
    ----------
    size : int, optional
        Members per tile: tile i has those from ``i * size`` on. If not given, so many that all threads have work and memory
        suffices.
    """
    count, thread_count = len(members), processor_count() if threads is None else threads
    size = _members_per_tile(count, thread_count, ensemble) if size is None else size
    if count < 1 or size < 1 or thread_count < 1:
        raise WuchtError(
            f"{count} members in tiles of {size} on {thread_count} threads: there must be at least one of each", code="none"
        )

    def compute(first: int, tick: Tick) -> EnsembleResult[R]:
        part = _checked_members(members.part(first, min(first + size, count)), ensemble.system)
        integrator = ensemble.acquire()
        result = run_tile(integrator, part, observer, pace, tick)
        ensemble.release(integrator)
        return result

    return _compute_in_threads(compute, range(0, count, size), thread_count, report)


def _members_per_tile(count: int, threads: int, ensemble: CompiledBatch) -> int:
    """Return the number of members per tile: whole batches, and of equal tiles as many for each thread."""
    width, threads = ensemble.width, max(1, threads)
    largest = max(1, _STATES_PER_TILE // (len(ensemble.system.states) * width)) * width
    tile_count = max(_TILES_PER_THREAD, -(-count // (threads * largest))) * threads
    return -(-count // (tile_count * width)) * width


def processor_count() -> int:
    """Return how many processors this process may use."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else os.cpu_count() or 1


def _checked_members(members: Members, system: System) -> Members:
    """Return the members. Raises ``WuchtError`` where their shape does not fit the System."""
    member_shape, system_shape = (
        (members.starts.shape[1], members.parameter_values.shape[1]),
        (len(system.states), len(system.parameters)),
    )
    if member_shape != system_shape:
        raise WuchtError(
            f"members have {member_shape[0]} states and {member_shape[1]} parameters, the equations "
            f"{system_shape[0]} and {system_shape[1]}:"
            f" {', '.join((*system.state_names, *system.parameter_names))}",
            code="shape",
        )
    return members


class _CancelledError(Exception):
    """Ends the work of a thread after a stop request."""


def _compute_in_threads(
    compute: Callable[[int, Tick], EnsembleResult[R]], firsts: Sequence[int], threads: int, report: Report | None
) -> Iterator[EnsembleResult[R]]:
    """Compute the tiles from these members on, yielded in order, with only a few per thread in progress."""
    shares, stop_request = dict.fromkeys(firsts, 0.0), threading.Event()

    def job(first: int) -> EnsembleResult[R]:
        def tick(share: float) -> None:
            shares[first] = share
            if stop_request.is_set():
                raise _CancelledError

        tick(0.0)
        result = compute(first, tick)
        shares[first] = 1.0
        return result

    pool, remaining_firsts, futures = _pool(threads, os.getpid()), iter(firsts), deque[Future[EnsembleResult[R]]]()
    try:
        while True:
            for first in itertools.islice(remaining_firsts, _TILES_PER_THREAD * threads - len(futures)):
                futures.append(pool.submit(job, first))
            if not futures:
                break
            future = futures[0]
            while True:
                is_done = future.done()
                if report is not None:
                    report(sum(shares.values()) / len(firsts))
                if is_done:
                    break
                wait([future], _TICK_S)
            result = future.result()
            futures.popleft()
            del future
            yield result
    except KeyboardInterrupt:
        stop_request.set()
        for future in _finish(futures):
            if future.exception() is None:
                yield future.result()
        raise
    finally:
        stop_request.set()
        _finish(futures)


@cache
def _pool(threads: int, _process: int) -> ThreadPoolExecutor:
    """Return threads that are reused for the next ensemble: for each new one the C library would retain memory.

    A copy of the process has none of these threads, and gets new ones.
    """
    return ThreadPoolExecutor(threads, "ensemble")


def _finish(futures: Iterable[Future[EnsembleResult[R]]]) -> list[Future[EnsembleResult[R]]]:
    """Cancel futures that have not begun; wait for the others and return them."""
    active = [f for f in futures if not f.cancel()]
    wait(active)
    return active
