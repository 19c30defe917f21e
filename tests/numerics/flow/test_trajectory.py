"""A trajectory of parts: each sample once, whether or not a part begins with the last sample of the part before."""

from itertools import pairwise

import numpy as np
import pytest
import sympy as sp

from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.system import Output, System

x = sp.Symbol("x", real=True)
CLOCK = System((x,), (sp.S.One,), quadratures=(Output("area", x),))
GRID = np.linspace(0.0, 1.0, 11)


def _assert_clock(run, time):
    assert run.time.tolist() == list(time)
    assert run.states[0] == pytest.approx(time, abs=1e-12)
    assert run.quadratures["area"] == pytest.approx(np.square(time) / 2, abs=1e-12)


@pytest.mark.parametrize("cuts", [(0, 5, 10), (0, 1, 2, 9, 10), (0, 0, 3, 3, 10, 10), (0, *range(11))])
def test_a_sample_that_two_parts_share_counts_once(cuts):
    flow, parts = compile_system(CLOCK), []
    for begin, end in pairwise(cuts):
        state = parts[-1].end_state if parts else [0.0]
        parts.append(integrate(flow, state, [], GRID[begin : end + 1]))
    _assert_clock(Trajectory.of(parts), GRID)


def test_a_part_that_begins_at_an_event_between_two_samples_keeps_all_of_its_own():
    stop = Event("stop", x - sp.Rational(11, 20), terminal=True)
    first = integrate(compile_system(CLOCK, events=(stop,)), [0.0], [], GRID)
    assert first.stopped_by == "stop"
    time = np.array([first.end_time, *GRID[6:]])
    rest = integrate(compile_system(CLOCK), first.end_state, [], time)
    _assert_clock(first.join(rest), [*GRID[:6], *time])


def counted(n: int) -> Trajectory:
    time = np.arange(float(n))
    return Trajectory(time, np.array([time, 10 * time]), {"area": -time}, np.zeros(0), float(n - 1), np.zeros(3))


@pytest.mark.parametrize(
    ("n", "count", "with_last", "kept"),
    [
        (7, 3, False, [0, 3, 6]), (8, 3, False, [0, 3, 6]), (8, 3, True, [0, 3, 6, 7]), (7, 3, True, [0, 3, 6]),
        (2, 5, True, [0, 1]), (2, 5, False, [0]), (1, 5, True, [0]),
    ],
)  # fmt: skip
def test_every_third_sample_and_the_last_one(n, count, with_last, kept):
    part = counted(n).subsample(count, with_last)
    assert part.time.tolist() == part.states[0].tolist() == kept and part.end_time == n - 1
    assert part.states[1].tolist() == [10 * k for k in kept] and part.quadratures["area"].tolist() == [-k for k in kept]


def test_the_last_samples():
    part = counted(5).tail(2)
    assert (
        part.time.tolist() == [3, 4]
        and part.states.tolist() == [[3, 4], [30, 40]]
        and part.quadratures["area"].tolist() == [-3, -4]
    )
    assert counted(5).tail(9).time.tolist() == [0, 1, 2, 3, 4] and counted(5).tail(0).time.tolist() == []
