"""Ensembles: closed forms, and bits that depend on nothing but the member itself."""

from __future__ import annotations

import signal
import threading
import time
import tracemalloc
import weakref
from collections.abc import Callable
from dataclasses import dataclass, fields, replace
from itertools import pairwise

import numpy as np
import pytest
import sympy as sp
from tests.refusals import rejected

from wucht.errors import RunError
from wucht.numerics.ensembles.ensemble import compile_ensemble, run_ensemble, tiles
from wucht.numerics.ensembles.members import (
    Chunk,
    EnsembleResult,
    Members,
    Pace,
    Status,
)
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.system import TIME, Output, System

x, v, w, d, q = sp.symbols("x v w d q", real=True)
# A damped pendulum that is pushed; with q it runs away.
PENDULUM = System(
    (x, v), (v, -(w**2) * sp.sin(x) - 2 * d * v + sp.cos(3 * TIME) / 50 + q * x**2), (w, d, q),
    outputs=(Output("height", -sp.cos(x)),), quadratures=(Output("lost", 2 * d * v**2),),
)  # fmt: skip
DECAY = System((x,), (-w * x,), (w,))
PACE = Pace(5.0, 20, 40.0)


@dataclass(frozen=True)
class Seen:
    """By member. top: of the first state. total: sums over all samples (n, L), which rounding changes with the order.
    count: of chunks. parameter: the first one, which the observer keeps to itself."""

    top: np.ndarray
    total: np.ndarray
    count: np.ndarray
    parameter: np.ndarray


@dataclass(frozen=True)
class Watch:
    """Settled where all samples of a chunk are smaller than this."""

    below: float = 0.0

    def begin(self, members: Members) -> Seen:
        zero = np.zeros(len(members))
        return Seen(np.abs(members.starts[:, 0]), np.cos(members.starts.T), zero, members.parameter_values[:, 0])

    def update(self, record: Seen, chunk: Chunk) -> tuple[Seen, np.ndarray]:
        samples = chunk.samples
        top = np.maximum(record.top, np.abs(samples[:, 0]).max(axis=0))
        total = record.total + np.cos(samples).sum(axis=0) + np.sin(samples[:, 0]).sum(axis=0)
        settled = np.abs(samples).max(axis=(0, 1)) < self.below
        return Seen(top, total, record.count + 1, record.parameter), settled

    def final_record(self, record: Seen) -> Seen:
        return record


def drawn(count: int) -> Members:
    rng = np.random.default_rng(3)
    parameters = np.column_stack([rng.uniform(0.5, 1.5, count), rng.uniform(0.05, 0.5, count), np.zeros(count)])
    return Members.of(rng.uniform(-1, 1, (count, 2)), parameters)


def same(a: EnsembleResult[Seen], b: EnsembleResult[Seen]) -> bool:
    """Bits."""
    arrays = [(getattr(a, n), getattr(b, n)) for n in ("times", "states", "status")]
    arrays += [(getattr(a.record, f.name), getattr(b.record, f.name)) for f in fields(Seen)]
    return a.sentences == b.sentences and all(np.array_equal(*pair) for pair in arrays)


def settling(count: int = 203) -> tuple[Members, Callable[..., EnsembleResult[Seen]]]:
    """Members of which some settle early, some late, some not at all, and one runs away; and how to run them."""
    members = drawn(count)
    starts, parameters = members.starts.copy(), members.parameter_values.copy()
    starts[count // 2], parameters[count // 2] = [2.0, 0.0], [0.0, 0.0, 3.0]
    compiled = compile_ensemble(PENDULUM, 1e-9)

    def run(of: Members, size: int, threads: int) -> EnsembleResult[Seen]:
        found = tiles(compiled, of, Watch(0.06), PACE, size, threads)
        return EnsembleResult.join(list(found))

    return Members.of(starts, parameters), run


def test_decay_in_closed_form() -> None:
    """x = exp(-w t): times of settling, ends and records of members with rates of their own."""
    count = 30
    rates = np.linspace(0.1, 2.0, count)
    members = Members.of(np.ones((count, 1)), rates[:, None])
    compiled = compile_ensemble(DECAY, 1e-10)
    ends = run_ensemble(compiled, members, Watch(0.1), Pace(1.0, 4, 10.0), threads=2)
    # A chunk that begins at k is below 0.1 from its first sample on: exp(-w (k + 1/4)) < 0.1.
    chunks = np.ceil(np.log(10) / rates - 0.25) + 1
    assert ends.times.tolist() == np.minimum(chunks, 10).tolist()
    assert ends.status.tolist() == np.where(chunks <= 10, Status.SETTLED, Status.LIMIT).tolist()
    assert ends.record.count.tolist() == ends.times.tolist()
    assert ends.states[:, 0] == pytest.approx(np.exp(-rates * ends.times), abs=1e-9)
    assert ends.record.parameter.tolist() == rates.tolist()
    seen = [np.arange(1, 4 * t + 1) / 4 for t in ends.times]
    totals = [np.cos(1) + sum(f(np.exp(-w * t)).sum() for f in (np.cos, np.sin)) for w, t in zip(rates, seen, strict=True)]
    assert ends.record.total[0] == pytest.approx(totals, rel=1e-9)


def test_chunks_of_another_pace() -> None:
    """Each as long as all before it, with more samples."""

    class Doubling:
        chunks = 4

        def times(self, index: int) -> np.ndarray:
            return np.linspace(2.0 ** (index - 1) if index else 0.0, 2.0**index, 3 + index)

    rates = np.array([[0.2], [0.5], [1.0]])
    members, compiled = Members.of(np.ones((3, 1)), rates), compile_ensemble(DECAY, 1e-10)
    ends = run_ensemble(compiled, members, Watch(0.1), Doubling(), 1)
    assert ends.times.tolist() == [8, 8, 4]  # exp(-w t) at the first samples after 4 and after 2 is 0.383, 0.091 and 0.082
    assert ends.status.tolist() == [Status.LIMIT, Status.SETTLED, Status.SETTLED]
    assert ends.states[:, 0] == pytest.approx(np.exp(-rates[:, 0] * ends.times), abs=1e-9)


def test_one_by_one_gives_the_same() -> None:
    """Of a right-hand side that depends on time: each member integrated alone, its samples observed chunk by chunk."""
    members = drawn(5)
    found = run_ensemble(compile_ensemble(PENDULUM, 1e-11), members, Watch(0.1), PACE, 2)
    alone = compile_system(replace(PENDULUM, outputs=(), quadratures=()), 1e-11)
    for i, (start, values) in enumerate(zip(members.starts, members.parameter_values, strict=True)):
        states = integrate(alone, start, values, np.linspace(0.0, 40.0, 161)).states
        chunks = states[:, 1:].reshape(2, 8, 20)
        is_small = (np.abs(chunks) < 0.1).all(axis=(0, 2))
        count = int(is_small.argmax()) + 1 if is_small.any() else 8
        seen = chunks[:, :count].reshape(2, -1)
        assert found.times[i] == 5.0 * count
        assert found.states[i] == pytest.approx(seen[:, -1], abs=1e-9)
        assert found.record.total[:, i] == pytest.approx(
            np.cos(start) + np.cos(seen).sum(axis=1) + np.sin(seen[0]).sum(), abs=1e-7
        )
        assert found.record.top[i] == pytest.approx(max(abs(start[0]), np.abs(seen[0]).max()), abs=1e-9)
    assert len(set(found.times)) > 1


def test_bits_do_not_depend_on_tiles_or_threads() -> None:
    members, run = settling()
    first = run(members, 512, 1)
    assert all(first.count(s) > 0 for s in Status)
    assert len(set(first.times)) > 4
    for size, threads in ((1, 2), (7, 1), (7, 2), (64, 2)):
        assert same(run(members, size, threads), first)
    whole = run_ensemble(compile_ensemble(PENDULUM, 1e-9), members, Watch(0.06), PACE, 2)
    assert same(whole, first)


def test_one_that_runs_away_ends_where_it_was_sampled_last() -> None:
    """x' = x^2: x = 1/(1/x(0) - t). Sampled each quarter: before 5.1 at 5, before 1.6 at 1.5, before 0.2 at the start alone."""
    poles = np.array([5.1, 1.6, 0.2])
    compiled = compile_ensemble(System((x,), (w * x**2,), (w,)), 1e-10)
    ends = run_ensemble(compiled, Members.of(1 / poles[:, None], [1.0]), Watch(), Pace(1.0, 4, 10.0), 1)
    assert ends.status.tolist() == [Status.FAILED] * 3
    assert ends.times.tolist() == [5.0, 1.5, 0.0]
    assert ends.states[:, 0] == pytest.approx(1 / (poles - ends.times), rel=1e-6)


def test_what_does_not_fit_is_refused() -> None:
    compiled, pace = compile_ensemble(DECAY, 1e-8), Pace(1.0, 1, 1.0)
    one = Members.of(np.ones((1, 1)), [1.0])
    for members, refusal in (
        (Members.of(np.ones((2, 2)), [1.0]), rejected("shape", "2")),
        (Members.of(np.ones((2, 1)), [1.0, 2]), rejected("shape", "2")),
    ):
        with refusal:
            run_ensemble(compiled, members, Watch(), pace)
    for starts, parameters in (((4,), (2,)), ((4, 3), (5, 2)), ((4, 3), ())):
        with rejected("shape"):
            Members.of(np.zeros(starts), np.zeros(parameters))
    for numbers in ((0.0, 1, 1.0), (1.0, 0, 1.0), (1.0, 1, np.inf), (np.nan, 1, 1.0)):
        with rejected("pace"):
            Pace(*numbers)
    with rejected("none", "0"):
        run_ensemble(compiled, one.part(1, 2), Watch(), pace)


@dataclass(frozen=True)
class Slow(Watch):
    """Takes its time, and counts how often it was asked."""

    asked: list[int] | None = None

    def update(self, record: Seen, chunk: Chunk) -> tuple[Seen, np.ndarray]:
        self.asked.append(chunk.samples.shape[-1])
        time.sleep(0.02)
        return super().update(record, chunk)


def test_an_interrupt_stops_all_threads_and_loses_no_tile() -> None:
    """``report`` raises it when a third is done: what has been computed comes first."""
    rates, asked = np.linspace(0.1, 2.0, 200), list[int]()
    members = Members.of(np.ones((200, 1)), rates[:, None])

    def report(share: float) -> None:
        if share > 0.3:
            raise KeyboardInterrupt

    compiled, kept = compile_ensemble(DECAY, 1e-8), list[EnsembleResult[Seen]]()
    with pytest.raises(KeyboardInterrupt):
        for tile in tiles(compiled, members, Slow(asked=asked), Pace(1.0, 1, 2.0), 10, 2, report=report):
            kept.append(tile)
    ended = len(asked)
    numbers = [int(np.abs(np.exp(-2 * rates) - one.states[0, 0]).argmin()) for one in kept]
    assert numbers == sorted(set(numbers)) and all(number % 10 == 0 for number in numbers)
    assert 4 <= len(kept) < 12
    assert 2 * len(kept) <= ended <= 2 * len(kept) + 4  # chunks that were begun in tiles which were given up
    time.sleep(0.1)
    assert len(asked) == ended, "no thread is at work any more"


def test_ctrl_c_while_the_threads_work() -> None:
    """A signal to the main thread, sent by a thread at work."""

    class Interrupting(Slow):
        def update(self, record: Seen, chunk: Chunk) -> tuple[Seen, np.ndarray]:
            if len(self.asked) == 9:
                signal.pthread_kill(threading.main_thread().ident, signal.SIGINT)
            return super().update(record, chunk)

    rates, asked, kept = np.linspace(0.1, 2.0, 1000), list[int](), list[EnsembleResult[Seen]]()
    members = Members.of(np.ones((1000, 1)), rates[:, None])
    compiled = compile_ensemble(DECAY, 1e-8)
    with pytest.raises(KeyboardInterrupt):
        kept.extend(tiles(compiled, members, Interrupting(asked=asked), Pace(1.0, 1, 2.0), 10, 1))
    assert 8 <= len(asked) < 20
    assert len(kept) == len(asked) // 2
    assert np.concatenate([one.states[:, 0] for one in kept]) == pytest.approx(np.exp(-2 * rates[: 10 * len(kept)]), rel=1e-6)


def test_an_error_of_the_observer_comes_out() -> None:
    class Wrong(Watch):
        def update(self, record: Seen, chunk: Chunk) -> tuple[Seen, np.ndarray]:
            raise ZeroDivisionError

    class Unsaid(Watch):
        def update(self, record: Seen, chunk: Chunk) -> tuple[Seen, np.ndarray]:
            return record, np.array(False)

    class Short(Watch):
        def begin(self, members: Members) -> Seen:
            return replace(super().begin(members), top=np.zeros(3))

    members = Members.of(np.ones((40, 1)), [0.1])
    for watch, error in ((Wrong(), ZeroDivisionError), (Unsaid(), RunError), (Short(), RunError)):
        with pytest.raises(error):
            run_ensemble(compile_ensemble(DECAY, 1e-8), members, watch, Pace(1.0, 1, 4.0), 2)


@pytest.mark.slow
def test_memory_does_not_grow_with_the_count() -> None:
    """20,000 members, made tile by tile and let go: few tiles live at once, and less memory than a third of all samples."""

    class Drawn:
        def __init__(self) -> None:
            self.made, self.most = list[weakref.ref[Members]](), 0

        def __len__(self) -> int:
            return 20_000

        def part(self, first: int, last: int) -> Members:
            rates = np.linspace(0.1, 2.0, len(self))[first:last]
            part = Members.of(np.ones((last - first, 1)), rates[:, None])
            self.made.append(weakref.ref(part))
            self.most = max(self.most, sum(held() is not None for held in self.made))
            return part

    compiled, pace, source = compile_ensemble(DECAY, 1e-6), Pace(2.0, 40, 2.0), Drawn()
    next(iter(tiles(compiled, source, Watch(), pace, 512, 2)))
    tracemalloc.start()
    try:
        for number, result in enumerate(tiles(compiled, source, Watch(), pace, 512, 2)):
            rates = source.part(512 * number, 512 * number + 512).parameter_values[:, 0]
            assert result.states[:, 0] == pytest.approx(np.exp(-2 * rates), rel=1e-4)
        peak = tracemalloc.get_traced_memory()[1]
    finally:
        tracemalloc.stop()
    assert source.most <= 8  # those that are under way, and this test's own
    assert peak < 20_000 * 40 * 8 / 3


def test_chunks_follow_each_other_without_a_gap_and_end_at_the_limit() -> None:
    pace = Pace(0.1, 4, 0.75)
    times = [pace.times(i) for i in range(pace.chunks)]
    assert len(times) == 8
    assert all(a[-1] == b[0] for a, b in pairwise(times))
    assert times[0] == pytest.approx([0, 0.025, 0.05, 0.075, 0.1])
    assert times[-1][-1] == 0.75
    assert Pace(0.1, 4, 0.3).chunks == 3  # 3 * 0.1 is a rounding more than 0.3
    assert Pace(5.0, 4, 0.3).times(0)[-1] == 0.3


def test_a_rounding_makes_no_further_chunk() -> None:
    """2.1/0.3 is a rounding more than 7; a thousandth more is a chunk of its own."""
    assert 2.1 / 0.3 > 7 and Pace(0.3, 4, 2.1).chunks == 7 and Pace(0.3, 4, 2.1003).chunks == 8
    assert Pace(0.3, 4, 2.1).times(6)[-1] == 2.1 and Pace(0.3, 4, 2.1).times(5)[0] == 1.5


def test_starts_and_parameters_that_cannot_be_computed_with() -> None:
    system = System((x,), (-x / w,), (w,))
    members = Members.of(np.array([[1.0], [np.nan], [1.0], [1.0]]), np.array([[1.0], [1.0], [0.0], [2.0]]))
    ends = run_ensemble(compile_ensemble(system, 1e-8), members, Watch(), Pace(1.0, 2, 2.0), 1)
    assert ends.status.tolist() == [Status.LIMIT, Status.FAILED, Status.FAILED, Status.LIMIT]
    assert "is not finite" in ends.sentences[1]
    assert "w = 0" in ends.sentences[2]
    assert ends.times.tolist() == [2, 0, 0, 2]
    assert ends.states[[0, 3], 0] == pytest.approx(np.exp([-2, -1]), rel=1e-6)
