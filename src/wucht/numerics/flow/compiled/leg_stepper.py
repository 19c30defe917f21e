"""The stepper of the engine ``compiled``: one leg by Dormand and Prince's method, for any system, compiled once.

Rates and event functions are machine code of the system, called by their addresses; all arrays are memory of the caller, so
that no object of Python is touched and the interpreter's lock is not held. Events are located on the dense output. Each leg
begins with a step size that follows from its state alone, so that a run in parts has the numbers of a whole one.
E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, sections II.4 (step sizes),
II.6 (dense output) and II.10 (error). All is in the part of Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from wucht.numerics.flow.compiled.dormand_prince import ALL_STAGES, DENSE_ROW, DENSE_ROWS, ERROR_ROWS, STAGES

Reals = np.ndarray
Integers = np.ndarray
Function = (
    Callable[[float, np.ndarray, np.ndarray], np.ndarray] | int
)  # of time, state and constants; machine code: its address

_ROWS = DENSE_ROWS + 3  # of the dense output

BLOCK = 4  # states are summed together, in registers
_PARTS = 4  # of a step, at whose ends the signs of event functions are compared
_SCRATCH = _PARTS + 1  # the row of values that no part needs
VALUE_ROWS = _SCRATCH + 1
_VERTICES = 3  # parabolas, until an event function that nears zero within a part is taken to have stayed on its side
_EPS = 2.0**-52
_TINY = 1e-300
_SAFETY, _MIN_FACTOR, _MAX_FACTOR = 0.9, 0.2, 6.0  # of step sizes
_ABSOLUTE = 1e-2  # of the relative tolerance
_EXPONENT = -1.0 / 8.0
_CURVATURE = 0.1  # third and fourth differences, of the size of an event function, that limit steps
_NOTICEABLE = 1e-9  # size of event functions below which they may be rounding, and do not limit steps
_SHORTER, _LONGER, _MOST_SHORTENINGS = 0.5, 1.2, 12  # factors of the step length that event functions allow; times in a row
_SHORTEST = 1e-9  # step that event functions limit, of the time: rounding shows in the functions of shorter ones
_OF_ROUNDING = 0.1  # error with which a step that rounding limits is accepted: the next one is a fifth longer

END, EVENT, NO_STEPS_LEFT, NOT_FINITE, NO_ROOM = range(5)  # how a leg ends; no room: for its hits
_NOT_FOLLOWED = -1  # of a step: it is too long for an event function
SAMPLE_COUNT, HIT_COUNT, STEP_COUNT, STOPPING_EVENT = range(4)  # places in the counts
_NEVER = 2.0  # a part of a step


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
    values (6, m): of the event functions. lowest (m,): of their values at the ends of the parts of steps. counts (4,).
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


def evaluate(function: Function, time: float, state: Reals, constants: Reals, values: Reals, first: int) -> None:
    """Store the values of a function from a place on."""
    assert callable(function)
    results = function(time, state, constants)
    values[first : first + len(results)] = results


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


def _dense_point(x: float, state: Reals, dense: Reals, width: int, point: Reals) -> None:
    """Compute the state at a part x of the step."""
    y = 1.0 - x
    for i in range(0, width, BLOCK):
        a = b = c = d = 0.0
        for row in range(_ROWS - 1, -1, -1):
            factor, place = x if row % 2 == 0 else y, row * width + i
            a = (a + dense[place]) * factor
            b = (b + dense[place + 1]) * factor
            c = (c + dense[place + 2]) * factor
            d = (d + dense[place + 3]) * factor
        point[i], point[i + 1] = state[i] + a, state[i + 1] + b
        point[i + 2], point[i + 3] = state[i + 2] + c, state[i + 3] + d


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


def _attempt(leg: LegMemory, time: float, step: float) -> float:
    """Attempt a step from a state whose rates are known; return its error, at most 1 where it is accepted: section II.10."""
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
            leg.point[i] = leg.state[i] * (1.0 + (_EPS if i % (2 * digit) < digit else -_EPS))
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


def _event_value(leg: LegMemory, index: int, value: float, time: float) -> float:
    """Return the value of an event function that counts: just after an event it is rounding noise, its sign is known."""
    if time <= leg.cool_ends[index]:
        sign = leg.cool_signs[index] if leg.cool_signs[index] != 0.0 else -float(leg.event_kinds[index])
        return sign * (abs(value) + _TINY)
    return value


def _value_within(leg: LegMemory, index: int, time: float, step: float, x: float) -> float:
    """Return the value of an event function at a part x of the step; ``point`` is then the state there."""
    _dense_point(x, leg.state, leg.dense, leg.width, leg.point)
    evaluate(leg.functions, time + x * step, leg.point, leg.event_constants, leg.values, _SCRATCH * leg.m)
    value: float = leg.values[_SCRATCH * leg.m + index]
    return _event_value(leg, index, value, time + x * step)


def _root(
    leg: LegMemory, index: int, time: float, step: float, low: float, low_value: float, high: float, high_value: float
) -> float:
    """Return the part of the step at which an event function passes zero, to rounding: secants within a bracket."""
    if low_value == 0.0:
        return low
    smallest, side = 2.0 * _EPS * max(1.0, abs(time) / step), 0
    for count in range(200):
        if high - low <= smallest:
            break
        x = (low * high_value - high * low_value) / (high_value - low_value)
        if count % 4 == 3 or not low < x < high:
            x = 0.5 * (low + high)
        x = min(max(x, low + 0.5 * smallest), high - 0.5 * smallest)
        value = _value_within(leg, index, time, step, x)
        if value == 0.0:
            return x
        if (value > 0.0) == (high_value > 0.0):
            high, high_value = x, value
            if side == 1:  # the other end has stayed: the next secant shall pass it
                low_value *= 0.5
            side = 1
        else:
            low, low_value = x, value
            if side == -1:
                high_value *= 0.5
            side = -1
    return high


def _interior_crossing(leg: LegMemory, index: int, time: float, step: float, part: int) -> float:
    """Return a place in a part of the step at which an event function has the other sign than at both of its ends, or never.

    The place is sought at the vertices of parabolas through the function's values.
    """
    low, high, neighbour = part / _PARTS, (part + 1) / _PARTS, part - 1 if part > 0 else part + 2
    low_value, high_value = leg.values[part * leg.m + index], leg.values[(part + 1) * leg.m + index]
    third, third_value = neighbour / _PARTS, leg.values[neighbour * leg.m + index]
    for _ in range(_VERTICES):
        slope = (high_value - low_value) / (high - low)
        curvature = ((third_value - low_value) / (third - low) - slope) / (third - high)
        if curvature * low_value <= 0.0:  # it is bent towards zero: its ends are the nearest
            return _NEVER
        x: float = 0.5 * (low + high) - 0.5 * slope / curvature
        vertex_value = low_value + (x - low) * (slope + curvature * (x - high))
        if not low < x < high or (abs(vertex_value) > 0.1 * abs(low_value) and vertex_value * low_value > 0.0):
            return _NEVER
        value = _value_within(leg, index, time, step, x)
        if value * low_value < 0.0:
            return x
        third, third_value = x, value
    return _NEVER


def _begin_events(leg: LegMemory, time: float) -> None:
    """Compute the values of the event functions at the beginning of a leg."""
    evaluate(leg.functions, time, leg.state, leg.event_constants, leg.values, 0)
    for i in range(leg.m):
        value = _event_value(leg, i, leg.values[i], time)
        leg.values[i] = value if value != 0.0 else -float(leg.event_kinds[i]) * _TINY


def _evaluate_events(leg: LegMemory, time: float, step: float, next_time: float) -> None:
    """Compute the values of the event functions at the ends of the parts of a step."""
    for part in range(1, _PARTS + 1):
        part_time = next_time if part == _PARTS else time + part / _PARTS * step
        if part == _PARTS:
            evaluate(leg.functions, part_time, leg.next_state, leg.event_constants, leg.values, part * leg.m)
        else:
            _dense_point(part / _PARTS, leg.state, leg.dense, leg.width, leg.point)
            evaluate(leg.functions, part_time, leg.point, leg.event_constants, leg.values, part * leg.m)
        for i in range(leg.m):
            value, previous = _event_value(leg, i, leg.values[part * leg.m + i], part_time), leg.values[(part - 1) * leg.m + i]
            if value == 0.0 and previous != 0.0:  # it passes zero where it leaves it
                value = math.copysign(_TINY, previous)
            leg.values[part * leg.m + i] = value


def _are_followed(leg: LegMemory) -> bool:
    """Return whether the event functions change little within the parts of a step: none passes zero twice within one.

    Steps follow the states alone. A function is followed if its third and fourth differences are small beside it: those
    of a wave are so as long as a step is at most a third of it.
    """
    for i in range(leg.m):
        a, b, c = leg.values[i], leg.values[leg.m + i], leg.values[2 * leg.m + i]
        d, e = leg.values[3 * leg.m + i], leg.values[4 * leg.m + i]
        size = max(abs(a), abs(b), abs(c), abs(d), abs(e), _NOTICEABLE)
        third = max(abs(d - a + 3.0 * (b - c)), abs(e - b + 3.0 * (c - d)))
        if max(third, abs(a + e - 4.0 * (b + d) + 6.0 * c)) > _CURVATURE * size:
            return False
    return True


def _record_hit(leg: LegMemory, index: int, time: float, x: float, step: float) -> None:
    if leg.counts[HIT_COUNT] < leg.room:
        first = leg.counts[HIT_COUNT] * (leg.n + 1)
        leg.hit_events[leg.counts[HIT_COUNT]] = index
        leg.hits[first] = time + x * step
        _dense_point(x, leg.state, leg.dense, leg.width, leg.point)
        for j in range(leg.n):
            leg.hits[first + 1 + j] = leg.point[j]
    leg.counts[HIT_COUNT] += 1


def _record_crossing(
    leg: LegMemory,
    index: int,
    time: float,
    step: float,
    low: float,
    low_value: float,
    high: float,
    high_value: float,
    stop: float,
) -> float:
    """Record an event if its function passes zero between two places; return where the step stops. stop: so far."""
    crosses = high_value != 0.0 and (low_value == 0.0 or (low_value < 0.0) != (high_value < 0.0))
    if not crosses or leg.event_kinds[index] == (-1 if high_value > 0.0 else 1):
        return stop
    x = _root(leg, index, time, step, low, low_value, high, high_value)
    if leg.event_kinds[leg.m + index] == 1:
        if x < stop:
            leg.counts[STOPPING_EVENT] = index
        return min(x, stop)
    if x <= stop:
        _record_hit(leg, index, time, x, step)
    return stop


def _locate_events(leg: LegMemory, time: float, step: float) -> float:
    """Record the events of a step; return the part of it at which one interrupts, or never.

    The first row of the values of event functions, those at the beginning, is replaced by that at the end.
    """
    stop = _NEVER
    for part in range(_PARTS):
        for kind in range(1, -1, -1):  # those that interrupt first
            for i in range(leg.m):
                if leg.event_kinds[leg.m + i] != kind:
                    continue
                low, low_value = part / _PARTS, leg.values[part * leg.m + i]
                high, high_value = (part + 1) / _PARTS, leg.values[(part + 1) * leg.m + i]
                if low_value * high_value > 0.0:
                    middle = _interior_crossing(leg, i, time, step, part)
                    if middle < high:
                        stop = _record_crossing(leg, i, time, step, low, low_value, middle, -high_value, stop)
                        stop = _record_crossing(leg, i, time, step, middle, -low_value, high, high_value, stop)
                else:
                    stop = _record_crossing(leg, i, time, step, low, low_value, high, high_value, stop)
        if stop < _NEVER:
            break
    for i in range(leg.m):
        for part in range(_PARTS + 1):
            if part / _PARTS <= stop:
                leg.lowest[i] = min(leg.lowest[i], leg.values[part * leg.m + i])
        leg.values[i] = leg.values[_PARTS * leg.m + i]
    return stop


def _record_samples(leg: LegMemory, time: float, step: float, next_time: float, last_time: float) -> None:
    """Record the samples of a step up to a time."""
    sample = leg.counts[SAMPLE_COUNT]
    while sample < leg.grid_count and leg.grid[sample] <= last_time:
        is_within = leg.grid[sample] < next_time
        if is_within:
            _dense_point((leg.grid[sample] - time) / step, leg.state, leg.dense, leg.width, leg.point)
        for i in range(leg.n):
            leg.samples[sample * leg.n + i] = leg.point[i] if is_within else leg.next_state[i]
        sample += 1
    leg.counts[SAMPLE_COUNT] = sample


def _begin(leg: LegMemory, time: float) -> bool:
    """Record the samples at the beginning, and compute what the first step needs; return whether it is finite."""
    for place in range(STOPPING_EVENT):
        leg.counts[place] = 0
    leg.counts[STOPPING_EVENT] = -1
    for i in range(leg.width):
        leg.next_state[i] = leg.state[i]
    _record_samples(leg, time, 1.0, time, time)
    evaluate(leg.rates, time, leg.state, leg.constants, leg.k, 0)
    if leg.m > 0:
        _begin_events(leg, time)
    return _is_finite(leg.k, 0, leg.n)


def _accept(leg: LegMemory, time: float, step: float, next_time: float, may_shorten: bool) -> int:
    """Record the events and samples of a step and go to its end, or to the event that interrupts; return whether one does.

    may_shorten: the step is given back where it is too long for an event function.
    """
    stop = _NEVER
    if leg.m > 0 or leg.grid[leg.counts[SAMPLE_COUNT]] < next_time:
        _compute_dense(leg, time, step)
    if leg.m > 0:
        _evaluate_events(leg, time, step, next_time)
        if may_shorten and not _are_followed(leg):
            return _NOT_FOLLOWED
        stop = _locate_events(leg, time, step)
    last_time = time + stop * step if stop < _NEVER else next_time
    _record_samples(leg, time, step, next_time, last_time)
    if stop < _NEVER:
        _dense_point(stop, leg.state, leg.dense, leg.width, leg.next_state)
    leg.clock[0] = last_time
    for i in range(leg.n):
        leg.state[i] = leg.next_state[i]
        leg.k[i] = leg.k[STAGES * leg.width + i]
    if leg.counts[HIT_COUNT] > leg.room:
        return NO_ROOM
    return EVENT if stop < _NEVER else END


def advance(leg: LegMemory) -> int:
    """Advance over the grid, or until an event interrupts; return how it ended."""
    time, end = leg.clock[0], leg.grid[leg.grid_count - 1]
    is_finite = _begin(leg, time)
    if leg.counts[SAMPLE_COUNT] == leg.grid_count:
        return END
    ending, is_shortened = END if is_finite else NOT_FINITE, False
    step, longest, shortenings = _first_step(leg, time, end - time), end - time, 0
    while ending == END and time < end:
        if leg.counts[STEP_COUNT] >= leg.most_steps:
            return NO_STEPS_LEFT
        leg.counts[STEP_COUNT] += 1
        is_last = time + 1.01 * step >= end
        if is_last:
            step = end - time
        next_time = end if is_last else time + step
        error = _attempt(leg, time, step)
        if error > 1.0 and error <= _rounding_error(leg, time, step):
            error = _OF_ROUNDING
        if error <= 1.0:
            evaluate(leg.rates, next_time, leg.next_state, leg.constants, leg.k, STAGES * leg.width)
        if error <= 1.0 and _is_finite(leg.k, STAGES * leg.width, leg.n):
            may_shorten = shortenings < _MOST_SHORTENINGS and step > _SHORTEST * max(1.0, abs(time))
            ending = _accept(leg, time, step, next_time, may_shorten)
            if ending == _NOT_FOLLOWED:
                ending, longest, step = END, step, _SHORTER * step
                shortenings += 1
                continue
            factor = _MAX_FACTOR if error == 0.0 else min(_MAX_FACTOR, max(_MIN_FACTOR, _SAFETY * error**_EXPONENT))
            longest *= _LONGER
            step = min(longest, step * (min(1.0, factor) if is_shortened else factor))
            time, is_shortened, shortenings = leg.clock[0], False, 0
        else:
            step *= max(_MIN_FACTOR, _SAFETY * error**_EXPONENT) if error > 1.0 else _MIN_FACTOR
            is_shortened = True
            if step <= 4.0 * _EPS * abs(time) or step < _TINY:
                ending = NOT_FINITE
    return ending
