"""The memory of lanes: many motions at once, one on each lane of vectors, and instructions on vectors.

All is in the part of Python that ``kernel_translation`` translates; ``evaluate_lanes`` to ``any_lane`` are instructions there.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

Reals = np.ndarray
Integers = np.ndarray
Lanes = np.ndarray  # (width,)
Marks = np.ndarray  # (width,) of bool
LaneArray = np.ndarray  # (count, width)
Function = Callable[[np.ndarray, np.ndarray, np.ndarray], np.ndarray] | int  # of times, states, constants; or its address


class LanesMemory(NamedTuple):
    """M members that are advanced over a grid of times, and the memory for it."""

    # Code of the system, of quantities that are sampled, and of those whose largest values are sought.
    rates: Function
    samplers: Function
    peak_quantities: Function
    width: int  # of vectors
    n: int  # states
    rate_constant_count: int  # constants of each code
    sampler_constant_count: int
    peak_constant_count: int
    value_count: int  # quantities
    peak_count: int
    peak_state_count: int
    member_count: int  # M
    grid_count: int  # times, the first of which is the beginning
    most_steps: int  # of a member
    rounds: int  # steps of all lanes in one call
    tolerance: float
    peak_states: Integers  # (peak_state_count,): on which the peak quantities depend
    is_angle: Reals  # (n,): 1 for states whose size is no measure of a motion
    # Of piecewise functions: code of the events at the ends of segments, all counts 0 where there are none.
    event_functions: Function
    event_count: int
    event_constant_count: int
    instant_constant_count: int
    segment_width: int  # numbers of the segments in use, the last constants of each code
    constants: Reals  # (constants of all codes, M)
    nodes: Reals  # (16,), and the rows of coefficients without zeros: see ``dormand_prince``
    row_weights: Reals
    row_places: Integers  # of stages in k
    row_begins: Integers
    grid: Reals  # (grid_count,)
    states: Reals  # (n, M): at the beginning, then at the end; of one that fails, at its last sample
    samples: Reals  # (grid_count - 1, value_count, M)
    progress: Reals  # (1 + peak_count, M): sizes of the next steps, 0 where not known, and the largest values so far
    times: Reals  # (M,): when each ended
    sample_times: Reals  # (M,): of its last sample
    endings: Integers  # (M,): how each ended
    members: Integers  # (width,): of lanes
    rows: Integers  # (width,): their next samples
    counts: Integers  # (3,)
    queue_members: Integers  # (width,): of the samples that wait until they fill a vector
    queue_rows: Integers
    # A number for each lane: of ``clock`` to ``last_sample_time`` one vector.
    clock: LaneArray
    size: LaneArray  # of the step
    is_busy: LaneArray  # 0 or 1, as the next three
    is_new: LaneArray
    is_shortened: LaneArray
    mark: LaneArray
    steps: LaneArray  # so far
    next_sample_time: LaneArray
    moment: LaneArray  # a time to evaluate at
    last_sample_time: LaneArray
    state: LaneArray  # (n,), as the others but k and dense
    next_state: LaneArray  # at the end of the step
    point: LaneArray  # within the step
    last_sample: LaneArray
    error_5: LaneArray
    error_3: LaneArray
    k: LaneArray  # (16 n,): rates of the stages
    dense: LaneArray  # (7 n,): coefficients of the dense output
    rate_constants: LaneArray
    sampler_constants: LaneArray
    peak_constants: LaneArray
    values: LaneArray  # (value_count,): of a sample
    queue_time: LaneArray
    queue_states: LaneArray  # (n,)
    queue_constants: LaneArray
    peak_value: LaneArray  # (peak_count,): at a place of a step
    highest: LaneArray  # (peak_count,): at its beginning and some stages
    lowest: LaneArray
    places: LaneArray  # (5 peak_count,): at all of them
    best: LaneArray  # (peak_count,): the largest so far
    share: LaneArray  # of the step up to an event, 1 without one: from here to ``last_change`` one vector
    trial_size: LaneArray  # step size
    next_time: LaneArray  # at the end of the step, or at the event
    is_too_long: LaneArray  # 0 or 1: the step, for an event function
    is_first: LaneArray  # 0 or 1: the size of the step is a first one
    longest: LaneArray  # step that event functions allow
    shortenings: LaneArray  # in a row
    last_change: LaneArray  # time
    event_values: LaneArray  # (event_count,), as the next six: at the end of the step
    first_event_values: LaneArray  # at its beginning
    highest_event_values: LaneArray  # at some stages
    lowest_event_values: LaneArray
    event_parts: LaneArray  # (3 event_count,): at the ends of the parts within it
    cool_ends: LaneArray  # see ``LegMemory``
    cool_signs: LaneArray
    event_constants: LaneArray
    instant_constants: LaneArray
    segments: Integers  # (segmentation_count, width): those in use
    stops: Integers  # (width,): the event at which the step ends, or NO_EVENT
    standstills: Integers  # (width,): changes of segment in succession, see ``changes_at_standstill``


def evaluate_lanes(
    function: Function, time: LaneArray, state: LaneArray, constants: LaneArray, values: LaneArray, first: int
) -> None:
    """Store the values of a function from a place on."""
    assert callable(function)
    results = function(time, state, constants)
    values[first : first + len(results)] = results


def select(marks: Marks, first: Lanes | float, second: Lanes | float) -> Lanes:
    """Select the first where marked, else the second."""
    return np.where(marks, first, second)


def larger(first: Lanes | float, second: Lanes | float) -> Lanes:
    """Return the larger of two, lane by lane."""
    return np.maximum(first, second)


def smaller(first: Lanes | float, second: Lanes | float) -> Lanes:
    """Return the smaller of two, lane by lane."""
    return np.minimum(first, second)


def root(x: Lanes) -> Lanes:
    """Return the square root."""
    return np.asarray(np.sqrt(x))


def ceiling(x: Lanes) -> Lanes:
    """Return the next whole number."""
    return np.asarray(np.ceil(x))


def any_lane(marks: Marks) -> bool:
    """Return whether a lane is marked."""
    return bool(np.any(marks))
