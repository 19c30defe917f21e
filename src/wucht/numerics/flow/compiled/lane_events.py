"""Events of the steps of lanes: in which steps a function may pass zero, for all lanes at once.

First by its values at some stages; where that leaves it open, by those at the ends of the parts of a step on the dense output,
with the rules of ``event_location``. What remains is rare: such a lane is handled alone (``lane_segments``). In the part of
Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

from wucht.numerics.flow.compiled.event_location import CURVATURE, NOTICEABLE
from wucht.numerics.flow.compiled.lane_memory import Lanes, LanesMemory, Marks, evaluate_lanes, larger, smaller
from wucht.numerics.flow.compiled.lane_steps import dense_value
from wucht.numerics.flow.compiled.leg_memory import PARTS

_MARGIN = 1.0  # of the range of an event function at five places of a step: farther from zero it does not pass it within


def mark_near_lanes(m: LanesMemory, success: Marks) -> Marks:
    """Mark the lanes in whose steps an event function may pass zero: first steps, and those in which one comes near it."""
    evaluate_lanes(m.event_functions, m.next_time, m.next_state, m.event_constants, m.event_values, 0)
    is_near: Marks = success & (m.is_first[0] != 0.0)
    for j in range(m.event_count):
        high = larger(m.highest_event_values[j], m.event_values[j])
        low = smaller(m.lowest_event_values[j], m.event_values[j])
        margin = _MARGIN * (high - low)
        is_near = is_near | (success & (high + margin >= 0.0) & (low - margin <= 0.0))
    return is_near


def _compute_values_at_parts(m: LanesMemory, time: Lanes, step: Lanes) -> None:
    """Compute the event functions at the ends of the parts within a step."""
    for part in range(1, PARTS):
        x = part / PARTS + 0.0 * step
        y = 1.0 - x
        for i in range(m.n):
            m.point[i] = dense_value(m, i, x, y)
        m.moment[0] = time + x * step
        evaluate_lanes(m.event_functions, m.moment, m.point, m.event_constants, m.event_parts, (part - 1) * m.event_count)


def _may_turn(low: Lanes, high: Lanes, bend: Lanes) -> Marks:
    """Mark where a parabola has its vertex between two values of one sign, and is bent away from zero there."""
    marks: Marks = (bend * low > 0.0) & (2.0 * abs(high - low) < abs(bend))
    return marks


def mark_lanes_with_events(m: LanesMemory, time: Lanes, step: Lanes, is_near: Marks) -> Marks:
    """Mark those of near lanes in whose steps a function passes zero, may turn beyond it, or is not followed by the parts."""
    _compute_values_at_parts(m, time, step)
    has_event: Marks = m.is_first[0] != 0.0
    first_end = time + 1.0 / PARTS * step
    for j in range(m.event_count):
        a, b, c = m.first_event_values[j], m.event_parts[j], m.event_parts[m.event_count + j]
        d, e = m.event_parts[2 * m.event_count + j], m.event_values[j]
        has_event = has_event | (a * b <= 0.0) | (b * c <= 0.0) | (c * d <= 0.0) | (d * e <= 0.0)
        bend_b, bend_c, bend_d = a - 2.0 * b + c, b - 2.0 * c + d, c - 2.0 * d + e
        has_event = (
            has_event | _may_turn(a, b, bend_b) | _may_turn(b, c, bend_b) | _may_turn(c, d, bend_c) | _may_turn(d, e, bend_d)
        )
        size = larger(larger(larger(abs(a), abs(b)), larger(abs(c), abs(d))), larger(abs(e), NOTICEABLE))
        third = larger(abs(d - a + 3.0 * (b - c)), abs(e - b + 3.0 * (c - d)))
        has_event = has_event | (larger(third, abs(a + e - 4.0 * (b + d) + 6.0 * c)) > CURVATURE * size)
        has_event = has_event | (first_end <= m.cool_ends[j])
    marks: Marks = is_near & has_event
    return marks
