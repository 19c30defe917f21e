"""Changes of segment on lanes: a lane whose step may end at a breakpoint is handled alone, as ``leg_stepper`` handles a leg.

All lanes take their steps together, and the functions of events are computed for all of them. What is near zero is rare: then
the numbers of the lane are copied into a leg's memory, where the event is located and the segment changed, and back. In the
part of Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

from wucht.numerics.flow.compiled.event_location import (
    MOST_OF_FIRST,
    MOST_SHORTENINGS,
    SHORTEST,
    are_followed,
    are_interpolated,
    begin_events,
    evaluate_events,
    locate_events,
)
from wucht.numerics.flow.compiled.lane_memory import LanesMemory
from wucht.numerics.flow.compiled.leg_memory import NEVER, ROWS, STOPPING_EVENT, LegMemory, dense_point
from wucht.numerics.flow.compiled.segment_changes import (
    FIRST_OF_SEGMENT,
    STILL,
    STILL_IN_LEG,
    begin_segments,
    change_segments,
    changes_at_standstill,
)

NO_EVENT = -1  # at which a step stops


def _copy_to_leg(m: LanesMemory, leg: LegMemory, lane: int) -> None:
    """Copy what an event depends on."""
    leg.counts[STOPPING_EVENT] = NO_EVENT
    for i in range(m.n):
        leg.state[i] = m.state[i][lane]
    for i in range(m.event_constant_count):
        leg.event_constants[i] = m.event_constants[i][lane]
    for i in range(m.event_count):
        leg.values[i] = m.first_event_values[i][lane]
        leg.cool_ends[i], leg.cool_signs[i] = m.cool_ends[i][lane], m.cool_signs[i][lane]


def _copy_constants_to_leg(m: LanesMemory, leg: LegMemory, lane: int) -> None:
    """Copy what a change of segment depends on beside that."""
    for i in range(m.rate_constant_count):
        leg.constants[i] = m.rate_constants[i][lane]
    for i in range(m.instant_constant_count):
        leg.instant_constants[i] = m.instant_constants[i][lane]
    for j in range(leg.segmentation_count):
        leg.segment[j] = m.segments[j * m.width + lane]


def _copy_segments_to_lane(m: LanesMemory, leg: LegMemory, lane: int) -> None:
    """Copy the segments in use, and the values of the event functions that begin with them."""
    sampler_tail = m.sampler_constant_count - m.segment_width
    peak_tail = m.peak_constant_count - m.segment_width
    for i in range(m.segment_width):
        m.rate_constants[leg.rates_tail + i][lane] = leg.constants[leg.rates_tail + i]
        m.sampler_constants[sampler_tail + i][lane] = leg.constants[leg.rates_tail + i]
        m.peak_constants[peak_tail + i][lane] = leg.constants[leg.rates_tail + i]
        m.event_constants[leg.event_tail + i][lane] = leg.event_constants[leg.event_tail + i]
        m.instant_constants[leg.instant_tail + i][lane] = leg.instant_constants[leg.instant_tail + i]
    for j in range(leg.segmentation_count):
        m.segments[j * m.width + lane] = leg.segment[j]
    for i in range(m.event_count):
        m.first_event_values[i][lane] = leg.values[i]
        m.cool_ends[i][lane], m.cool_signs[i][lane] = leg.cool_ends[i], leg.cool_signs[i]


def begin_lane(m: LanesMemory, leg: LegMemory, lane: int) -> None:
    """Locate the segments with which the motion of a lane begins."""
    time = m.clock[0][lane]
    _copy_to_leg(m, leg, lane)
    _copy_constants_to_leg(m, leg, lane)
    begin_segments(leg, time)
    begin_events(leg, time)
    _copy_segments_to_lane(m, leg, lane)
    m.longest[0][lane] = m.grid[m.grid_count - 1] - time
    m.shortenings[0][lane], m.last_change[0][lane], m.is_first[0][lane] = 0.0, time, 1.0
    m.stops[lane], m.standstills[lane] = NO_EVENT, 0


def follow_lane(m: LanesMemory, leg: LegMemory, lane: int) -> None:
    """Locate the event at which the step of a lane ends, if there is one; or mark the step as too long."""
    time, step = m.clock[0][lane], m.trial_size[0][lane]
    _copy_to_leg(m, leg, lane)
    for i in range(m.n):
        leg.next_state[i] = m.next_state[i][lane]
        for row in range(ROWS):
            leg.dense[row * leg.width + i] = m.dense[row * m.n + i][lane]
    evaluate_events(leg, time, step, m.next_time[0][lane])
    is_first = m.is_first[0][lane] != 0.0
    most = MOST_OF_FIRST if is_first else MOST_SHORTENINGS
    may_shorten = m.shortenings[0][lane] < most and step > SHORTEST * max(1.0, abs(time))
    if may_shorten and (not are_followed(leg) or (is_first and not are_interpolated(leg, time, step))):
        m.is_too_long[0][lane] = 1.0
        return
    stop = locate_events(leg, time, step)
    for i in range(m.event_count):
        m.event_values[i][lane] = leg.values[i]
    if stop < NEVER:
        m.share[0][lane], m.next_time[0][lane], m.stops[lane] = stop, time + stop * step, leg.counts[STOPPING_EVENT]
        dense_point(stop, leg.state, leg.dense, leg.width, leg.next_state)
        for i in range(m.n):
            m.next_state[i][lane] = leg.next_state[i]


def change_lane(m: LanesMemory, leg: LegMemory, lane: int) -> None:
    """Begin the segment beyond the end at which the step of a lane has stopped."""
    time = m.clock[0][lane]
    _copy_to_leg(m, leg, lane)
    _copy_constants_to_leg(m, leg, lane)
    leg.counts[STOPPING_EVENT] = m.stops[lane]
    change_segments(leg, time)
    begin_events(leg, time)
    _copy_segments_to_lane(m, leg, lane)
    duration, end = time - m.last_change[0][lane], m.grid[m.grid_count - 1]
    least = STILL_IN_LEG * (end - m.grid[0])
    m.standstills[lane] = changes_at_standstill(leg, time, duration, least, m.standstills[lane])
    m.longest[0][lane], m.last_change[0][lane] = end - time, time
    # A size of 0: the next step begins as the first one does; else one far beyond the segment would be rounded.
    is_still = duration < STILL * max(1.0, abs(time))
    m.size[0][lane] = 0.0 if is_still else min(m.size[0][lane], FIRST_OF_SEGMENT * duration)
    m.is_first[0][lane] = 1.0 if is_still else 0.0
