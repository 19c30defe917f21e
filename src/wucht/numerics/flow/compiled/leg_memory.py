"""The memory of a leg, in which its stepper works: numbers, addresses of machine code, arrays of the caller."""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from wucht.numerics.flow.compiled.dormand_prince import DENSE_ROWS

Reals = np.ndarray
Integers = np.ndarray
Function = (
    Callable[[float, np.ndarray, np.ndarray], np.ndarray] | int
)  # of time, state and constants; machine code: its address

ROWS = DENSE_ROWS + 3  # of the dense output
BLOCK = 4  # states are summed together, in registers
PARTS = 4  # of a step, at whose ends the signs of event functions are compared
SCRATCH = PARTS + 1  # the row of values that no part needs
VALUE_ROWS = SCRATCH + 1
EPS = 2.0**-52
TINY = 1e-300
NEVER = 2.0  # a part of a step

END, EVENT, NO_STEPS_LEFT, NOT_FINITE, NO_ROOM, STANDING_STILL = range(6)  # how a leg ends; no room: for its hits
SAMPLE_COUNT, HIT_COUNT, STEP_COUNT, STOPPING_EVENT = range(4)  # places in the counts


class LegMemory(NamedTuple):
    """A leg and the memory for it.

    rates, functions: code of the system and of its events. n, m: numbers of states and events. width: n, filled up to whole
    blocks. grid_count: samples. room: for hits. is_angle (n,): 1 for states whose size is no measure of a motion. constants,
    event_constants: of both codes. nodes (16,), row_weights, row_places, row_begins: the
    coefficients without zeros, see ``dormand_prince``. event_kinds (2, m): directions; 1 where events interrupt.
    cool_ends, cool_signs (m,): cool-downs. grid (grid_count,). clock (1,): the time. state (width,). samples (grid_count, n).
    hit_events (room,), hits (room, 1 + n): events, times, states. k (16, width): rates of the stages. dense (7, width):
    coefficients of the dense output. point, next_state, errors, zero (width,): a state within the step, that at its end, and
    memory.
    values (6, m): of the event functions. lowest (m,): of these. counts (4,).

    Of the m events the first request_count are a run's own, the others the upper and lower ends of segments; event_segments
    (m,): the number of their segmentation. instant: code of the values that decide at an instant: the functions of the run's
    events, the sizes of their rounding, the arguments of the piecewise functions, and gain_count gains of quadratures; instants
    (4, instant_count) is memory for them. rates_tail, event_tail, instant_tail: where the numbers of segments begin in the
    constants of each code.
    segment (segmentation_count,): those in use. segment_rows: their numbers, a row a segment; segment_begins: where those of a
    segmentation begin; segment_places: where its numbers begin in the tails, and the end of the last. breakpoints,
    breakpoint_begins: likewise. scales (segmentation_count,): of their ends' functions. size_states, size_begins: the states, n
    for the time, from which each argument is computed. lowest_arguments (segmentation_count,): below the upper end.
    """

    rates: Function
    functions: Function
    n: int
    width: int
    m: int
    grid_count: int
    room: int
    most_steps: int
    tolerance: float
    is_angle: Reals
    constants: Reals
    event_constants: Reals
    nodes: Reals
    row_weights: Reals
    row_places: Integers  # of stages in k
    row_begins: Integers
    event_kinds: Integers
    cool_ends: Reals
    cool_signs: Reals
    grid: Reals
    clock: Reals
    state: Reals
    samples: Reals
    hit_events: Integers
    hits: Reals
    k: Reals
    dense: Reals
    point: Reals
    next_state: Reals
    errors: Reals
    zero: Reals
    values: Reals
    lowest: Reals
    counts: Integers
    request_count: int
    segmentation_count: int
    instant: Function
    instant_count: int
    gain_count: int
    rates_tail: int
    event_tail: int
    instant_tail: int
    instant_constants: Reals
    instants: Reals
    event_segments: Integers
    segment: Integers
    segment_rows: Reals
    segment_begins: Integers
    segment_places: Integers
    breakpoints: Reals
    breakpoint_begins: Integers
    scales: Reals
    size_states: Integers
    size_begins: Integers
    lowest_arguments: Reals


def evaluate(function: Function, time: float, state: Reals, constants: Reals, values: Reals, first: int) -> None:
    """Store the values of a function from a place on."""
    assert callable(function)
    results = function(time, state, constants)
    values[first : first + len(results)] = results


def dense_point(x: float, state: Reals, dense: Reals, width: int, point: Reals) -> None:
    """Compute the state at a part x of the step."""
    y = 1.0 - x
    for i in range(0, width, BLOCK):
        a = b = c = d = 0.0
        for row in range(ROWS - 1, -1, -1):
            factor, place = x if row % 2 == 0 else y, row * width + i
            a = (a + dense[place]) * factor
            b = (b + dense[place + 1]) * factor
            c = (c + dense[place + 2]) * factor
            d = (d + dense[place + 3]) * factor
        point[i], point[i + 1] = state[i] + a, state[i + 1] + b
        point[i + 2], point[i + 3] = state[i + 2] + c, state[i + 3] + d
