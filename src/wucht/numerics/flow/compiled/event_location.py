"""Events of a step: where their functions pass zero on the dense output.

E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, section II.6. In the part of
Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

import math

from wucht.numerics.flow.compiled.leg_memory import (
    EPS,
    HIT_COUNT,
    NEVER,
    PARTS,
    SCRATCH,
    STOPPING_EVENT,
    TINY,
    LegMemory,
    dense_point,
    evaluate,
)

_VERTICES = 3  # parabolas, until an event function that nears zero within a part is taken to have stayed on its side
CURVATURE = 0.1  # third and fourth differences, of the size of an event function, that limit steps
# Factors of the step length that event functions allow, and times in a row that they shorten a step, and a first one.
SHORTER, LONGER, MOST_SHORTENINGS, MOST_OF_FIRST = 0.5, 1.2, 12, 40
SHORTEST = 1e-9  # step that they limit, of the time: rounding shows in the functions of shorter ones
_PLACES, _GOLDEN = 4, 0.6180339887498949  # within a step, multiples of this less whole ones: near no multiple of its parts
NOTICEABLE = 1e-9  # size of event functions below which they may be rounding, and do not limit steps


def _event_value(leg: LegMemory, index: int, value: float, time: float) -> float:
    """Return the value of an event function that counts: just after an event it is rounding noise, its sign is known."""
    if time <= leg.cool_ends[index]:
        sign = leg.cool_signs[index] if leg.cool_signs[index] != 0.0 else -float(leg.event_kinds[index])
        return sign * (abs(value) + TINY)
    return value


def _value_within(leg: LegMemory, index: int, time: float, step: float, x: float) -> float:
    """Return the value of an event function at a part x of the step; ``point`` is then the state there."""
    dense_point(x, leg.state, leg.dense, leg.width, leg.point)
    evaluate(leg.functions, time + x * step, leg.point, leg.event_constants, leg.values, SCRATCH * leg.m)
    value: float = leg.values[SCRATCH * leg.m + index]
    return _event_value(leg, index, value, time + x * step)


def _root(
    leg: LegMemory, index: int, time: float, step: float, low: float, low_value: float, high: float, high_value: float
) -> float:
    """Return the part of the step at which an event function passes zero, to rounding: secants within a bracket."""
    if low_value == 0.0:
        return low
    smallest, side = 2.0 * EPS * max(1.0, abs(time) / step), 0
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


def _may_pass_zero(low_value: float, high_value: float, third_value: float, part: int) -> bool:
    """Return whether a function passes zero in a part of a step, or a parabola has its vertex there and is bent away from zero.

    third_value: at the end of the part before, for the first part of that after.
    """
    bend = third_value - 2.0 * low_value + high_value if part > 0 else low_value - 2.0 * high_value + third_value
    return low_value * high_value <= 0.0 or (bend * low_value > 0.0 and 2.0 * abs(high_value - low_value) < abs(bend))


def _interior_crossing(leg: LegMemory, index: int, time: float, step: float, part: int) -> float:
    """Return a place in a part of the step at which an event function has the other sign than at both of its ends, or never.

    The place is sought at the vertices of parabolas through the function's values.
    """
    low, high, neighbour = part / PARTS, (part + 1) / PARTS, part - 1 if part > 0 else part + 2
    low_value, high_value = leg.values[part * leg.m + index], leg.values[(part + 1) * leg.m + index]
    third, third_value = neighbour / PARTS, leg.values[neighbour * leg.m + index]
    for _ in range(_VERTICES):
        slope = (high_value - low_value) / (high - low)
        curvature = ((third_value - low_value) / (third - low) - slope) / (third - high)
        if curvature * low_value <= 0.0:  # it is bent towards zero: its ends are the nearest
            return NEVER
        x: float = 0.5 * (low + high) - 0.5 * slope / curvature
        vertex_value = low_value + (x - low) * (slope + curvature * (x - high))
        if not low < x < high or (abs(vertex_value) > 0.1 * abs(low_value) and vertex_value * low_value > 0.0):
            return NEVER
        value = _value_within(leg, index, time, step, x)
        if value * low_value < 0.0:
            return x
        third, third_value = x, value
    return NEVER


def begin_events(leg: LegMemory, time: float) -> None:
    """Compute the values of the event functions at the beginning of a leg."""
    evaluate(leg.functions, time, leg.state, leg.event_constants, leg.values, 0)
    for i in range(leg.m):
        value = _event_value(leg, i, leg.values[i], time)
        leg.values[i] = value if value != 0.0 else -float(leg.event_kinds[i]) * TINY


def evaluate_events(leg: LegMemory, time: float, step: float, next_time: float) -> None:
    """Compute the values of the event functions at the ends of the parts of a step."""
    for part in range(1, PARTS + 1):
        part_time = next_time if part == PARTS else time + part / PARTS * step
        if part == PARTS:
            evaluate(leg.functions, part_time, leg.next_state, leg.event_constants, leg.values, part * leg.m)
        else:
            dense_point(part / PARTS, leg.state, leg.dense, leg.width, leg.point)
            evaluate(leg.functions, part_time, leg.point, leg.event_constants, leg.values, part * leg.m)
        for i in range(leg.m):
            value, previous = _event_value(leg, i, leg.values[part * leg.m + i], part_time), leg.values[(part - 1) * leg.m + i]
            if value == 0.0 and previous != 0.0:  # it passes zero where it leaves it
                value = math.copysign(TINY, previous)
            leg.values[part * leg.m + i] = value


def are_followed(leg: LegMemory) -> bool:
    """Return whether the event functions change little within the parts of a step: none passes zero twice within one.

    Steps follow the states alone. A function is followed if its third and fourth differences are small beside it: those
    of a wave are so as long as a step is at most a third of it.
    """
    for i in range(leg.m):
        a, b, c = leg.values[i], leg.values[leg.m + i], leg.values[2 * leg.m + i]
        d, e = leg.values[3 * leg.m + i], leg.values[4 * leg.m + i]
        size = max(abs(a), abs(b), abs(c), abs(d), abs(e), NOTICEABLE)
        third = max(abs(d - a + 3.0 * (b - c)), abs(e - b + 3.0 * (c - d)))
        if max(third, abs(a + e - 4.0 * (b + d) + 6.0 * c)) > CURVATURE * size:
            return False
    return True


def are_interpolated(leg: LegMemory, time: float, step: float) -> bool:
    """Return whether the event functions between the parts of a step are those that the parts' ends show.

    A first step follows the rates at one instant: of a wave it may span so many that its parts are whole ones.
    """
    x = 0.0
    for _ in range(_PLACES):
        x = x + _GOLDEN if x + _GOLDEN < 1.0 else x + _GOLDEN - 1.0
        dense_point(x, leg.state, leg.dense, leg.width, leg.point)
        evaluate(leg.functions, time + x * step, leg.point, leg.event_constants, leg.values, SCRATCH * leg.m)
        for i in range(leg.m):
            if not _is_interpolated(leg, i, PARTS * x):
                return False
    return True


def _is_interpolated(leg: LegMemory, index: int, s: float) -> bool:
    """Return whether a value is near the polynomial through those at the parts' ends. s: its place, in parts."""
    a, b, c = leg.values[index], leg.values[leg.m + index], leg.values[2 * leg.m + index]
    d, e, value = leg.values[3 * leg.m + index], leg.values[4 * leg.m + index], leg.values[SCRATCH * leg.m + index]
    size = max(abs(a), abs(b), abs(c), abs(d), abs(e), abs(value), NOTICEABLE)
    polynomial = (
        d - a + 3.0 * (b - c) + (s - 3.0) / 4.0 * (a + e - 4.0 * (b + d) + 6.0 * c)
    )  # Newton's form, from its last terms
    polynomial = c - 2.0 * b + a + (s - 2.0) / 3.0 * polynomial
    polynomial = a + s * (b - a + (s - 1.0) / 2.0 * polynomial)
    is_near: bool = abs(polynomial - value) <= CURVATURE * size
    return is_near


def _record_hit(leg: LegMemory, index: int, time: float, x: float, step: float) -> None:
    if leg.counts[HIT_COUNT] < leg.room:
        first = leg.counts[HIT_COUNT] * (leg.n + 1)
        leg.hit_events[leg.counts[HIT_COUNT]] = index
        leg.hits[first] = time + x * step
        dense_point(x, leg.state, leg.dense, leg.width, leg.point)
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


def _least_between(leg: LegMemory, index: int, time: float, step: float, stop: float) -> float:
    """Return the least value of a function that turns within a step, before it stops: near the vertices of parabolas."""
    least = NEVER
    for part in range(PARTS - 1):
        a, b = leg.values[part * leg.m + index], leg.values[(part + 1) * leg.m + index]
        c = leg.values[(part + 2) * leg.m + index]
        bend = a - 2.0 * b + c
        if bend <= 0.0 or abs(a - c) >= 2.0 * bend:  # the vertex is none, or not between them
            continue
        x = (part + 1 + 0.5 * (a - c) / bend) / PARTS
        if x < stop and b - 0.125 * (a - c) * (a - c) / bend < leg.lowest[index]:
            least = min(least, _value_within(leg, index, time, step, x))
    return least


def _locate_in_part(leg: LegMemory, index: int, time: float, step: float, part: int, stop: float) -> float:
    """Record the events of a function in a part of a step; return where the step stops. stop: so far."""
    low, low_value = part / PARTS, leg.values[part * leg.m + index]
    high, high_value = (part + 1) / PARTS, leg.values[(part + 1) * leg.m + index]
    if low_value * high_value > 0.0:
        middle = _interior_crossing(leg, index, time, step, part)
        if middle < high:
            stop = _record_crossing(leg, index, time, step, low, low_value, middle, -high_value, stop)
            stop = _record_crossing(leg, index, time, step, middle, -low_value, high, high_value, stop)
        return stop
    return _record_crossing(leg, index, time, step, low, low_value, high, high_value, stop)


def locate_events(leg: LegMemory, time: float, step: float) -> float:
    """Record the events of a step; return the part of it at which one interrupts, or never.

    The first row of the values of event functions, those at the beginning, is replaced by that at the end.
    """
    stop = NEVER
    for part in range(PARTS):
        for kind in range(1, -1, -1):  # those that interrupt first
            for i in range(leg.m):
                low_value, high_value = leg.values[part * leg.m + i], leg.values[(part + 1) * leg.m + i]
                third_value = leg.values[(part - 1 if part > 0 else 2) * leg.m + i]
                if leg.event_kinds[leg.m + i] == kind and _may_pass_zero(low_value, high_value, third_value, part):
                    stop = _locate_in_part(leg, i, time, step, part, stop)
        if stop < NEVER:
            break
    for i in range(leg.m):
        for part in range(PARTS + 1):
            if part / PARTS <= stop:
                leg.lowest[i] = min(leg.lowest[i], leg.values[part * leg.m + i])
        if i >= leg.request_count and leg.event_kinds[i] == 1:
            leg.lowest[i] = min(leg.lowest[i], _least_between(leg, i, time, step, stop))
        leg.values[i] = leg.values[PARTS * leg.m + i]
    return stop
