"""The stepper: one leg by Dormand and Prince's method, for any system, compiled once.

Rates and event functions are machine code of the system, called by their addresses; all arrays are memory of the caller, so
that no object of Python is touched and the interpreter's lock is not held. Events are located on the dense output. Each leg
begins with a step size that follows from its state alone, so that a run in parts has the numbers of a whole one.
E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, sections II.4 (step sizes),
II.6 (dense output) and II.10 (error). All is in the part of Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

import math

from wucht.numerics.flow.compiled.dormand_prince import ALL_STAGES, DENSE_ROW, DENSE_ROWS, ERROR_ROWS, OF_ROUNDING, STAGES
from wucht.numerics.flow.compiled.event_location import (
    LONGER,
    MOST_OF_FIRST,
    MOST_SHORTENINGS,
    SHORTER,
    SHORTEST,
    are_followed,
    are_interpolated,
    begin_events,
    evaluate_events,
    locate_events,
)
from wucht.numerics.flow.compiled.leg_memory import (
    BLOCK,
    END,
    EPS,
    EVENT,
    HIT_COUNT,
    NEVER,
    NO_ROOM,
    NO_STEPS_LEFT,
    NOT_FINITE,
    SAMPLE_COUNT,
    STANDING_STILL,
    STEP_COUNT,
    STOPPING_EVENT,
    TINY,
    LegMemory,
    Reals,
    dense_point,
    evaluate,
)
from wucht.numerics.flow.compiled.segment_changes import (
    FIRST_OF_SEGMENT,
    MOST_CHANGES,
    STILL,
    STILL_IN_LEG,
    change_segments,
    changes_at_standstill,
    fold_lowest_arguments,
)

_SAFETY, _MIN_FACTOR, _MAX_FACTOR = 0.9, 0.2, 6.0  # of step sizes
_ABSOLUTE = 1e-2  # of the relative tolerance
_EXPONENT = -1.0 / 8.0
_NOT_FOLLOWED = -1  # of a step: it is too long for an event function
_FAR = 1e300


def _add_stages(leg: LegMemory, row: int, step: float, begin: Reals, end: Reals) -> None:
    """Add the rates of stages, times the step and the weights of a row, to a state."""
    for i in range(0, leg.width, BLOCK):
        a = b = c = d = 0.0
        for j in range(leg.row_begins[row], leg.row_begins[row + 1]):
            weight, place = leg.row_weights[j], leg.row_places[j] + i
            a += weight * leg.k[place]
            b += weight * leg.k[place + 1]
            c += weight * leg.k[place + 2]
            d += weight * leg.k[place + 3]
        end[i], end[i + 1] = begin[i] + step * a, begin[i + 1] + step * b
        end[i + 2], end[i + 3] = begin[i + 2] + step * c, begin[i + 3] + step * d


def _is_finite(values: Reals, first: int, count: int) -> bool:
    total = 0.0
    for i in range(count):
        total += 0.0 * values[first + i]
    return total == 0.0


def _allowed_error(leg: LegMemory, i: int, value: float, next_value: float) -> float:
    if leg.is_angle[i] != 0.0:
        return leg.tolerance
    return leg.tolerance * (_ABSOLUTE + max(abs(value), abs(next_value)))


def _first_step(leg: LegMemory, time: float, span: float) -> float:
    """Return a first step size, from the rates at the beginning and after a small step: section II.4."""
    size = speed = change = 0.0
    for i in range(leg.n):
        scale = _allowed_error(leg, i, leg.state[i], leg.state[i])
        size += (leg.state[i] / scale) ** 2
        speed += (leg.k[i] / scale) ** 2
    size, speed = math.sqrt(size / leg.n), math.sqrt(speed / leg.n)
    small = 1e-6 if size < 1e-5 or speed < 1e-5 else 0.01 * size / speed
    small = min(small, span)
    for i in range(leg.n):
        leg.point[i] = leg.state[i] + small * leg.k[i]
    evaluate(leg.rates, time + small, leg.point, leg.constants, leg.next_state, 0)
    for i in range(leg.n):
        scale = _allowed_error(leg, i, leg.state[i], leg.state[i])
        change += ((leg.next_state[i] - leg.k[i]) / scale) ** 2
    largest = max(speed, math.sqrt(change / leg.n) / small)
    step = max(1e-6, small * 1e-3) if largest <= 1e-15 else (0.01 / largest) ** -_EXPONENT
    if not step > 0.0:  # the rates are not finite there
        step = small
    return min(100.0 * small, step, span)


def _compute_stage(leg: LegMemory, stage: int, time: float, step: float) -> None:
    _add_stages(leg, stage, step, leg.state, leg.point)
    evaluate(leg.rates, time + leg.nodes[stage] * step, leg.point, leg.constants, leg.k, stage * leg.width)


def _attempt(leg: LegMemory, time: float, step: float, next_time: float) -> float:
    """Attempt a step from a state whose rates are known, and compute those at its end; return its error, as ``_step_error``."""
    error = _step_error(leg, time, step)
    if error > 1.0 and error <= _rounding_error(leg, time, step):
        error = OF_ROUNDING
    if error > 1.0:
        return error
    evaluate(leg.rates, next_time, leg.next_state, leg.constants, leg.k, STAGES * leg.width)
    return error if error <= 1.0 and _is_finite(leg.k, STAGES * leg.width, leg.n) else _FAR


def _step_error(leg: LegMemory, time: float, step: float) -> float:
    """Return the error of a step from a state whose rates are known, at most 1 where it is accepted: section II.10."""
    for stage in range(1, STAGES):
        _compute_stage(leg, stage, time, step)
    _add_stages(leg, STAGES, step, leg.state, leg.next_state)
    _add_stages(leg, ERROR_ROWS, 1.0, leg.zero, leg.errors)
    _add_stages(leg, ERROR_ROWS + 1, 1.0, leg.zero, leg.point)
    squares_5 = squares_3 = 0.0
    for i in range(leg.n):
        inverse = 1.0 / _allowed_error(leg, i, leg.state[i], leg.next_state[i])
        squares_5 += (leg.errors[i] * inverse) ** 2
        squares_3 += (leg.point[i] * inverse) ** 2
    if squares_5 == 0.0:
        return 0.0
    return step * squares_5 / math.sqrt((squares_5 + 0.01 * squares_3) * leg.n)


def _rounding_error(leg: LegMemory, time: float, step: float) -> float:
    """Return the error, as ``_attempt`` does, that rounding of the state alone makes in a step.

    A stiff contact of two bodies that have turned a thousand times feels the last digits of their angles: a shorter step does
    not make its error smaller than those do. Any two states change in opposite directions once: their places differ in a digit.
    """
    largest = 0.0
    digit = 1
    while digit < 2 * leg.n:
        squares = 0.0
        for i in range(leg.n):
            leg.point[i] = leg.state[i] * (1.0 + (EPS if i % (2 * digit) < digit else -EPS))
        evaluate(leg.rates, time, leg.point, leg.constants, leg.errors, 0)
        for i in range(leg.n):
            squares += ((leg.errors[i] - leg.k[i]) / _allowed_error(leg, i, leg.state[i], leg.next_state[i])) ** 2
        largest = max(largest, squares)
        digit = 2 * digit
    return step * math.sqrt(largest / leg.n)


def _compute_dense(leg: LegMemory, time: float, step: float) -> None:
    """Compute the coefficients of the dense output of a step: section II.6."""
    for stage in range(STAGES + 1, ALL_STAGES):
        _compute_stage(leg, stage, time, step)
    for i in range(leg.n):
        gain = leg.next_state[i] - leg.state[i]
        leg.dense[i] = gain
        leg.dense[leg.width + i] = step * leg.k[i] - gain
        leg.dense[2 * leg.width + i] = 2.0 * gain - step * (leg.k[STAGES * leg.width + i] + leg.k[i])
    for row in range(DENSE_ROWS):
        _add_stages(leg, DENSE_ROW + row, step, leg.zero, leg.point)
        for i in range(leg.n):
            leg.dense[(3 + row) * leg.width + i] = leg.point[i]


def _record_samples(leg: LegMemory, time: float, step: float, next_time: float, last_time: float) -> None:
    """Record the samples of a step up to a time."""
    sample = leg.counts[SAMPLE_COUNT]
    while sample < leg.grid_count and leg.grid[sample] <= last_time:
        is_within = leg.grid[sample] < next_time
        if is_within:
            dense_point((leg.grid[sample] - time) / step, leg.state, leg.dense, leg.width, leg.point)
        for i in range(leg.n):
            leg.samples[sample * leg.n + i] = leg.point[i] if is_within else leg.next_state[i]
        sample += 1
    leg.counts[SAMPLE_COUNT] = sample


def _begin(leg: LegMemory) -> int:
    """Record the samples at the beginning, and compute what the first step needs; return END, or that it is not finite."""
    time = leg.clock[0]
    for place in range(STOPPING_EVENT):
        leg.counts[place] = 0
    leg.counts[STOPPING_EVENT] = -1
    for i in range(leg.width):
        leg.next_state[i] = leg.state[i]
    _record_samples(leg, time, 1.0, time, time)
    return _compute_start(leg, time)


def _compute_start(leg: LegMemory, time: float) -> int:
    """Compute the rates and the event functions at the start of a step; return END, or that the rates are not finite."""
    evaluate(leg.rates, time, leg.state, leg.constants, leg.k, 0)
    if leg.m > 0:
        begin_events(leg, time)
    return END if _is_finite(leg.k, 0, leg.n) else NOT_FINITE


def _accept(leg: LegMemory, time: float, step: float, next_time: float, may_shorten: bool, is_first: bool) -> int:
    """Record the events and samples of a step and go to its end, or to the event that interrupts; return whether one does.

    may_shorten: the step is given back where it is too long for an event function. is_first: it follows a first step size.
    """
    stop = NEVER
    if leg.m > 0 or leg.grid[leg.counts[SAMPLE_COUNT]] < next_time:
        _compute_dense(leg, time, step)
    if leg.m > 0:
        evaluate_events(leg, time, step, next_time)
        if may_shorten and (not are_followed(leg) or (is_first and not are_interpolated(leg, time, step))):
            return _NOT_FOLLOWED
        stop = locate_events(leg, time, step)
    last_time = time + stop * step if stop < NEVER else next_time
    _record_samples(leg, time, step, next_time, last_time)
    if stop < NEVER:
        dense_point(stop, leg.state, leg.dense, leg.width, leg.next_state)
    leg.clock[0] = last_time
    for i in range(leg.n):
        leg.state[i] = leg.next_state[i]
        leg.k[i] = leg.k[STAGES * leg.width + i]
    if leg.counts[HIT_COUNT] > leg.room:
        return NO_ROOM
    return EVENT if stop < NEVER else END


def _longer(error: float, is_shortened: bool) -> float:
    """Return the factor of the next step's size after one that was accepted. is_shortened: it was tried before."""
    factor = _MAX_FACTOR if error == 0.0 else min(_MAX_FACTOR, max(_MIN_FACTOR, _SAFETY * error**_EXPONENT))
    return min(1.0, factor) if is_shortened else factor


def advance(leg: LegMemory) -> int:
    """Advance over the grid, or until a requested event interrupts; return how it ended."""
    ending = _begin(leg)
    if leg.counts[SAMPLE_COUNT] < leg.grid_count and ending == END:
        ending = _advance(leg)
    fold_lowest_arguments(leg)
    return ending


def _advance(leg: LegMemory) -> int:
    time, end, ending = leg.clock[0], leg.grid[leg.grid_count - 1], END
    least_of_leg = STILL_IN_LEG * (end - time)
    last_change, changes = time, 0
    step, longest, shortenings, is_shortened, is_first = _first_step(leg, time, end - time), end - time, 0, False, True
    while ending == END and time < end:
        if leg.counts[STEP_COUNT] >= leg.most_steps:
            return NO_STEPS_LEFT
        leg.counts[STEP_COUNT] += 1
        is_last = time + 1.01 * step >= end
        if is_last:
            step = end - time
        next_time = end if is_last else time + step
        error = _attempt(leg, time, step, next_time)
        if error > 1.0:
            step *= max(_MIN_FACTOR, _SAFETY * error**_EXPONENT)
            is_shortened = True
            if step <= 4.0 * EPS * abs(time) or step < TINY:
                ending = NOT_FINITE
            continue
        most = MOST_OF_FIRST if is_first else MOST_SHORTENINGS
        may_shorten = shortenings < most and step > SHORTEST * max(1.0, abs(time))
        ending = _accept(leg, time, step, next_time, may_shorten, is_first)
        if ending == _NOT_FOLLOWED:
            ending, longest, step = END, step, SHORTER * step
            shortenings += 1
            continue
        longest *= LONGER
        step = min(longest, step * _longer(error, is_shortened))
        time, is_shortened, shortenings, is_first = leg.clock[0], False, 0, False
        if ending == EVENT and change_segments(leg, time):
            duration, last_change, longest = time - last_change, time, end - time
            ending = _compute_start(leg, time)
            changes = changes_at_standstill(leg, time, duration, least_of_leg, changes)
            if duration < STILL * max(1.0, abs(time)):
                step, is_first = _first_step(leg, time, end - time), True
            else:  # a step far beyond the segment would be rounded as its polynomials are out there
                step = min(step, FIRST_OF_SEGMENT * duration)
            if changes > MOST_CHANGES:
                ending = STANDING_STILL
            elif not _is_finite(leg.instants, 2 * leg.request_count, leg.segmentation_count):
                ending = NOT_FINITE
    return ending
