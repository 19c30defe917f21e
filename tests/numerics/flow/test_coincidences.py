"""Events that coincide: with breakpoints, contacts, each other, terminal events, the ends of legs and samples, in any order.

The motion is piecewise linear over time, so that the exact instants are known. Breakpoints of two arguments (a position, the
time), the contact of a third and all events lie at six instants, equal but for rounding; which of them meet where is drawn.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass
from functools import lru_cache

import numpy as np
import pytest
import sympy as sp
from hypothesis import given, settings
from hypothesis import strategies as st

from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integration import integrate
from wucht.piecewise import Pieces, PiecewiseCubic, step
from wucht.system import TIME, System

NODES = 6  # instants at which things may happen; the first is at 1 of the arguments, the run begins at 0 and ends at 7
FAR = 1e6
x, y, z, c, n = sp.symbols("x y z c n", real=True)
pace, y_slopes, z_slopes = sp.Symbol("pace", real=True), *(sp.symbols(f"{k}:{NODES + 1}", real=True) for k in ("p", "q"))
MORE = sp.symbols("begin size scale at_time at_place end_time end_place off stiffness", real=True)
begin, size, scale, at_time, at_place, end_time, end_place, off, stiffness = MORE
PARAMETERS = (pace, *y_slopes, *z_slopes, *MORE)


def rate(slopes: Sequence[sp.Symbol], argument: sp.Expr, name: str) -> sp.Expr:
    jumps = [s * PiecewiseCubic(argument, step(f"{name}{k}", float(k), 0.0, 1.0)) for k, s in enumerate(slopes) if k]
    return sp.Add(slopes[0], *jumps)


CONTACT = Pieces("contact", [0.0], [(0.0, -1.0, 0.0, 0.0), (0.0, 0.0, 0.0, 0.0)])
SYSTEM = System(
    (x, y, z, c, n),
    (
        pace,
        rate(y_slopes, x / size, "of place "),
        rate(z_slopes, (TIME - begin) * pace / size, "of time "),
        stiffness * PiecewiseCubic(y, CONTACT),
        sp.S.Zero,
    ),
    PARAMETERS,
)


def counts(number: int):
    """An action that counts, and changes nothing else."""
    return lambda time, state, parameters: (state + np.array([0.0, 0.0, 0.0, 0.0, number]), parameters)


WAYS = {"rises": 1, "falls": -1, "any": 0}
RECORDED = {
    "y": y, "z": z, "time": scale * (TIME - at_time), "place": scale * (x - at_place),
    "product": scale * (x - at_place) * (2 + x),
}  # fmt: skip
ACTS = (("time", TIME - at_time, 0, 1.0), ("place", scale * (x - at_place), 1, 100.0), ("y", scale * y, -1, 1e4))
ENDS = (("time", scale * (TIME - end_time), 1), ("place", x - end_place, 0), ("z", z + off, 0))


@lru_cache
def compiled(engine: str, acts: bool, ends: bool) -> CompiledSystem:
    events = [Event(f"{name} {way}", f, sign) for name, f in RECORDED.items() for way, sign in WAYS.items()]
    events += [Event(f"act {name}", f, sign, action=counts(number)) for name, f, sign, number in ACTS if acts]
    events += [Event(f"end {name}", f, sign, terminal=True) for name, f, sign in ENDS if ends]
    return compile_system(SYSTEM, 1e-12, tuple(events), engine)


@dataclass(frozen=True)
class Course:
    """A function that is linear between the instants: its values there."""

    times: np.ndarray
    values: np.ndarray

    def passages(self, direction: int) -> list[float]:
        """The times at which it passes zero; where it only touches zero it does not."""
        times, last = [], (self.times[0], self.values[0])
        for t, v in itertools.islice(zip(self.times, self.values, strict=True), 1, None):
            if v != 0:
                if v * last[1] < 0 and direction * v >= 0:
                    between = [s for s, u in zip(self.times, self.values, strict=True) if last[0] < s < t and u == 0]
                    times.append(between[0] if between else last[0] + (t - last[0]) * last[1] / (last[1] - v))
                last = (t, v)
        return times

    def integral_below(self) -> float:
        """The integral of its negative part."""
        total = 0.0
        for (t, v), (s, u) in itertools.pairwise(zip(self.times, self.values, strict=True)):
            if v * u >= 0:
                total += (s - t) * max(0.0, -(v + u) / 2)
            else:
                total += (s - t) * min(v, u) ** 2 / (2 * abs(v - u))
        return total


def slopes(values: np.ndarray, times: np.ndarray) -> list[float]:
    """The first slope, and the changes of the slope at the instants."""
    steep = np.diff(values) / np.diff(times)
    return [steep[0], *np.diff(steep)]


@st.composite
def courses(draw: st.DrawFn) -> list[int]:
    """Values at the instants: no two zeros in a row, none at either end."""
    signs = [draw(st.sampled_from([-1, 1]))]
    for _ in range(NODES):
        signs.append(draw(st.sampled_from([-1, 1] if signs[-1] == 0 else [-1, 0, 0, 1])))
    return [*signs, draw(st.sampled_from([-1, 1]))]


NODE = st.integers(1, NODES)
POSITIVE = st.floats(0.05, 20.0)


@settings(max_examples=60, deadline=None)
@given(
    y_signs=courses(), z_signs=courses(), size_=POSITIVE, pace_=POSITIVE, amplitude=POSITIVE,
    scale_=st.sampled_from([1.0, 1e6, 1e-3]), at=NODE, ends_at=st.tuples(*[st.none() | NODE] * 2), z_ends=st.booleans(),
    acts=st.booleans(), ends=st.booleans(), borders=st.sets(NODE), samples=st.sets(NODE), inner=st.integers(0, 30),
    begin_=st.sampled_from([0.0, 100.0, 1e4]),
)  # fmt: skip
@pytest.mark.parametrize("engine", ["compiled", pytest.param("radau", marks=pytest.mark.slow)])
def test_every_passage_counts_once(
    engine: str, y_signs: list[int], z_signs: list[int], size_: float, pace_: float, amplitude: float, scale_: float, at: int,
    ends_at: tuple[int | None, int | None], z_ends: bool, acts: bool, ends: bool, borders: set[int], samples: set[int],
    inner: int, begin_: float,
) -> None:  # fmt: skip
    places = size_ * np.arange(NODES + 2)
    times = begin_ + places / pace_
    y_course, z_course = (Course(times, amplitude * np.array(signs, float)) for signs in (y_signs, z_signs))
    values = dict.fromkeys(PARAMETERS, 0.0) | {pace: pace_, size: size_, scale: scale_, stiffness: 3.0}
    values |= dict(zip((*y_slopes, *z_slopes), [*slopes(y_course.values, times), *slopes(z_course.values, times)], strict=True))
    values |= {begin: begin_, at_time: times[at], at_place: places[at], off: 0.0 if z_ends else FAR}
    values |= {end_time: times[ends_at[0]] if ends_at[0] else FAR, end_place: places[ends_at[1]] if ends_at[1] else FAR}
    flow = compiled(engine, acts, ends)

    grid = np.unique(
        np.concatenate([np.linspace(begin_, times[-1], inner + 2), times[[0, -1]], times[sorted(samples | borders)]])
    )
    stops = [*(times[k] for k in sorted(borders)), times[-1]]
    state, parameters, time = np.array([0.0, y_course.values[0], z_course.values[0], 0.0, 0.0]), list(values.values()), begin_
    hits, ended_by = [], []
    for stop in stops:
        while time < stop:
            within = grid[(grid > time) & (grid <= stop)]
            run = integrate(flow, state, parameters, np.array([time, *within]))
            assert run.failure is None
            hits += [(h.name, h.time) for h in run.hits]
            ended_by += [(run.stopped_by, run.end_time)] if run.stopped_by else []
            time, state, parameters = run.end_time, run.end_state, run.final_parameter_values
            if run.stopped_by is None:
                break

    there = Course(times, np.arange(NODES + 2.0) - at)
    expected = {
        f"{name} {way}": {"y": y_course, "z": z_course}.get(name, there).passages(sign)
        for name in RECORDED for way, sign in WAYS.items()
    }  # fmt: skip
    total = 0.0
    if acts:
        acting = {"time": there.passages(0), "place": there.passages(1), "y": y_course.passages(-1)}
        expected |= {f"act {name}": acting[name] for name in acting}
        total = sum(number * len(acting[name]) for name, _, _, number in ACTS)
    ends_expected: dict[str, list[float]] = {}
    if ends:
        ends_expected = {
            "end time": [times[ends_at[0]]] if ends_at[0] else [], "end place": [times[ends_at[1]]] if ends_at[1] else [],
            "end z": z_course.passages(0) if z_ends else [],
        }  # fmt: skip
        expected |= ends_expected
    for name, passages in expected.items():
        reported = [t for hit, t in hits if hit == name]
        assert reported == pytest.approx(passages, rel=1e-11, abs=1e-9), name
    assert [t for _, t in hits] == pytest.approx(sorted(t for _, t in hits), rel=1e-11)
    at_ends = sorted({round(t, 6) for ts in ends_expected.values() for t in ts})
    assert [t for _, t in ended_by] == pytest.approx(at_ends, rel=1e-9, abs=1e-6)
    assert state[4] == total
    final = [places[-1], y_course.values[-1], z_course.values[-1]]
    rounding = 1e-9 + 1e-14 * begin_ * (1 + pace_ / size_) * 10
    assert state[:3] == pytest.approx(final, rel=rounding, abs=rounding * amplitude)
    assert state[3] == pytest.approx(3.0 * y_course.integral_below(), rel=10 * rounding, abs=rounding * amplitude)
