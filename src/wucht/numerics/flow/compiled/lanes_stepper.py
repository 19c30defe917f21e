"""The stepper of ensembles: many motions at once by Dormand and Prince's method, one on each lane of vectors.

Each lane has its own time, step size, state and constants, and takes the next member when its member has come to the end: the
numbers of a member depend on nothing else. While it steps, quantities are observed: their values at the times of a grid, and
the largest values of some. Steps end at the times of a grid whose times are farther from each other than half a step; within a
longer step, and to locate a largest value, states come from the dense output, which costs half as much as a step. Each lane has
its own segments of piecewise functions, and ends its steps at its own breakpoints (``lane_segments``).
E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, sections II.4 (step sizes),
II.6 (dense output) and II.10 (error). All is in the part of Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

import numpy as np

from wucht.numerics.flow.compiled.dormand_prince import STAGES
from wucht.numerics.flow.compiled.event_location import LONGER, SHORTER
from wucht.numerics.flow.compiled.lane_events import mark_lanes_with_events, mark_near_lanes
from wucht.numerics.flow.compiled.lane_memory import (
    Lanes,
    LanesMemory,
    Marks,
    any_lane,
    ceiling,
    evaluate_lanes,
    larger,
    select,
    smaller,
)
from wucht.numerics.flow.compiled.lane_peaks import PLACES, compute_peaks, update_peaks
from wucht.numerics.flow.compiled.lane_segments import NO_EVENT, begin_lane, change_lane, follow_lane
from wucht.numerics.flow.compiled.lane_steps import (
    attempt,
    compute_dense,
    dense_value,
    finite_lanes,
    first_steps,
    root_8,
    without_rounding,
)
from wucht.numerics.flow.compiled.leg_memory import (
    END,
    EPS,
    NO_STEPS_LEFT,
    NOT_FINITE,
    STANDING_STILL,
    TINY,
    LegMemory,
)
from wucht.numerics.flow.compiled.segment_changes import MOST_CHANGES

# Shares of the step size: a time of the grid that is nearer is stepped over; a step is stretched by no more to end at one.
_SHORTEST_STEP_SHARE, _LARGEST_STRETCH = 0.6, 1.05
_SAFETY, _MIN_FACTOR, _MAX_FACTOR = 0.9, 0.2, 6.0  # of step sizes
_NEVER = np.inf
_REFILL_SHARE = 8  # lanes are given new members when one in so many is idle

NEXT, ACTIVE, WAITING = range(3)  # places in the counts: the next member, how many lanes have one, samples in the queue
NONE_BEGUN = -1  # in the counts
IDLE = -1  # member of a lane that has none


def _record_samples(m: LanesMemory, time: Lanes, step: Lanes, next_time: Lanes, success: Marks) -> None:
    """Put the samples of accepted steps into the queue; those within a step come from its dense output."""
    has_sample = success & (m.next_sample_time[0] <= next_time)
    while any_lane(has_sample):
        is_inside = m.next_sample_time[0] < next_time
        if any_lane(has_sample & is_inside):
            x = smaller((m.next_sample_time[0] - time) / step, 1.0)
            y = 1.0 - x
            for i in range(m.n):
                m.point[i] = select(is_inside, dense_value(m, i, x, y), m.next_state[i])
        else:
            for i in range(m.n):
                m.point[i] = m.next_state[i]
        m.last_sample_time[0] = select(has_sample, m.next_sample_time[0], m.last_sample_time[0])
        for i in range(m.n):
            m.last_sample[i] = select(has_sample, m.point[i], m.last_sample[i])
        m.mark[0] = select(has_sample, 1.0, 0.0)
        for lane in range(m.width):
            if m.mark[0][lane] != 0.0:
                row, slot = m.rows[lane], m.counts[WAITING]
                m.queue_members[slot], m.queue_rows[slot] = m.members[lane], row
                m.queue_time[0][slot] = m.next_sample_time[0][lane]
                for i in range(m.n):
                    m.queue_states[i][slot] = m.point[i][lane]
                for i in range(m.sampler_constant_count):
                    m.queue_constants[i][slot] = m.sampler_constants[i][lane]
                m.counts[WAITING] = slot + 1
                if slot + 1 == m.width:  # as many as a vector has numbers are computed together
                    _flush_queue(m)
                m.rows[lane] = row + 1
                m.next_sample_time[0][lane] = m.grid[row + 2] if row + 2 < m.grid_count else _NEVER
        has_sample = success & (m.next_sample_time[0] <= next_time)


def _flush_queue(m: LanesMemory) -> None:
    """Compute the quantities of the samples in the queue, and store them."""
    evaluate_lanes(m.samplers, m.queue_time, m.queue_states, m.queue_constants, m.values, 0)
    for slot in range(m.counts[WAITING]):
        for j in range(m.value_count):
            m.samples[(m.queue_rows[slot] * m.value_count + j) * m.member_count + m.queue_members[slot]] = m.values[j][slot]
    m.counts[WAITING] = 0


def _load_constants(m: LanesMemory, lane: int, member: int) -> None:
    """Give a lane the constants of its member."""
    first = member
    for i in range(m.rate_constant_count):
        m.rate_constants[i][lane] = m.constants[first + i * m.member_count]
    first += m.rate_constant_count * m.member_count
    for i in range(m.sampler_constant_count):
        m.sampler_constants[i][lane] = m.constants[first + i * m.member_count]
    first += m.sampler_constant_count * m.member_count
    for i in range(m.peak_constant_count):
        m.peak_constants[i][lane] = m.constants[first + i * m.member_count]
    first += m.peak_constant_count * m.member_count
    for i in range(m.event_constant_count):
        m.event_constants[i][lane] = m.constants[first + i * m.member_count]
    first += m.event_constant_count * m.member_count
    for i in range(m.instant_constant_count):
        m.instant_constants[i][lane] = m.constants[first + i * m.member_count]


def _load_member(m: LanesMemory, lane: int, member: int) -> None:
    """Begin the motion of a member on a lane."""
    m.members[lane], m.rows[lane] = member, 0
    for i in range(m.n):
        m.state[i][lane] = m.last_sample[i][lane] = m.states[i * m.member_count + member]
    _load_constants(m, lane, member)
    m.size[0][lane] = m.progress[member]
    for j in range(m.peak_count):
        m.best[j][lane] = m.progress[(1 + j) * m.member_count + member]
    m.clock[0][lane] = m.last_sample_time[0][lane] = m.grid[0]
    m.next_sample_time[0][lane], m.steps[0][lane] = m.grid[1], 0.0
    m.is_new[0][lane], m.is_busy[0][lane], m.is_shortened[0][lane] = 1.0, 1.0, 0.0


def _fill_lanes(m: LanesMemory, leg: LegMemory) -> None:
    """Give idle lanes the next members, and compute what their first steps need."""
    for lane in range(m.width):
        m.is_new[0][lane] = 0.0
        if m.members[lane] == IDLE and m.counts[NEXT] < m.member_count:
            member = m.counts[NEXT]
            m.counts[NEXT] += 1
            m.counts[ACTIVE] += 1
            _load_member(m, lane, member)
            if m.event_count > 0:
                begin_lane(m, leg, lane)
    evaluate_lanes(m.rates, m.clock, m.state, m.rate_constants, m.k, 0)
    is_new = m.is_new[0] != 0.0
    needs_size = is_new & (m.size[0] <= 0.0)
    if any_lane(needs_size):
        m.size[0] = select(needs_size, first_steps(m, m.grid[m.grid_count - 1] - m.clock[0]), m.size[0])
    _begin_peaks(m)


def _begin_peaks(m: LanesMemory) -> None:
    """Compute the quantities with a largest value where steps begin: a change of segment may have made them larger."""
    if m.peak_count > 0:
        evaluate_lanes(m.peak_quantities, m.clock, m.state, m.peak_constants, m.peak_value, 0)
        for j in range(m.peak_count):
            m.best[j] = select(m.peak_value[j] > m.best[j], m.peak_value[j], m.best[j])
            m.places[j] = m.peak_value[j]


def _release_lanes(m: LanesMemory, ending: int, has_ended: Marks) -> None:
    """Store the results of members that have ended, and make their lanes idle."""
    m.mark[0] = select(has_ended, 1.0, 0.0)
    for lane in range(m.width):
        if m.mark[0][lane] != 0.0:
            member = m.members[lane]
            is_complete = ending == END
            for i in range(m.n):
                m.states[i * m.member_count + member] = m.state[i][lane] if is_complete else m.last_sample[i][lane]
            m.progress[member] = m.size[0][lane]
            for j in range(m.peak_count):
                m.progress[(1 + j) * m.member_count + member] = m.best[j][lane]
            m.times[member], m.sample_times[member] = m.clock[0][lane], m.last_sample_time[0][lane]
            m.endings[member] = ending
            m.members[lane], m.is_busy[0][lane] = IDLE, 0.0
            m.counts[ACTIVE] -= 1


def _follow_events(m: LanesMemory, leg: LegMemory, time: Lanes, step: Lanes, success: Marks) -> bool:
    """Locate the events at which accepted steps end; return whether the dense output was computed."""
    is_near = mark_near_lanes(m, success)
    m.share[0], m.is_too_long[0] = 1.0, 0.0
    has_dense = any_lane(is_near)
    if has_dense:
        compute_dense(m, time, step)
        m.mark[0] = select(mark_lanes_with_events(m, time, step, is_near), 1.0, 0.0)
        for lane in range(m.width):
            if m.mark[0][lane] != 0.0:
                follow_lane(m, leg, lane)
    is_accepted = success & (m.is_too_long[0] == 0.0)
    for j in range(m.event_count):
        m.first_event_values[j] = select(is_accepted, m.event_values[j], m.first_event_values[j])
    return has_dense


def _change_segments(m: LanesMemory, leg: LegMemory, step: Lanes, success: Marks) -> None:
    """Limit the next steps as event functions require, and begin the segments of the lanes that have stopped at an event."""
    is_too_long = m.is_too_long[0] != 0.0
    m.longest[0] = select(success, LONGER * m.longest[0], select(is_too_long, step, m.longest[0]))
    m.size[0] = smaller(select(is_too_long, SHORTER * step, m.size[0]), m.longest[0])
    m.is_first[0] = select(success, 0.0, m.is_first[0])
    m.shortenings[0] = select(success, 0.0, m.shortenings[0] + m.is_too_long[0])
    has_changed = False
    for lane in range(m.width):
        if m.stops[lane] != NO_EVENT:
            change_lane(m, leg, lane)
            m.stops[lane], has_changed = NO_EVENT, True
    if has_changed:
        evaluate_lanes(m.rates, m.clock, m.state, m.rate_constants, m.k, 0)
        _begin_peaks(m)


def _release_sliding_lanes(m: LanesMemory) -> None:
    """End the members whose segments change again and again while time stands still."""
    for lane in range(m.width):
        m.mark[0][lane] = 1.0 if m.members[lane] != IDLE and m.standstills[lane] > MOST_CHANGES else 0.0
    has_ended = m.mark[0] != 0.0
    if any_lane(has_ended):
        _release_lanes(m, STANDING_STILL, has_ended)


def _propose_sizes(m: LanesMemory, step: Lanes, error: Lanes, success: Marks) -> None:
    """Compute the sizes of the next steps: section II.4."""
    proposal = _SAFETY / root_8(error)
    growth = select(error == 0.0, _MAX_FACTOR, smaller(larger(proposal, _MIN_FACTOR), _MAX_FACTOR))
    growth = select(m.is_shortened[0] != 0.0, smaller(growth, 1.0), growth)
    reduction = select(error > 1.0, larger(proposal, _MIN_FACTOR), _MIN_FACTOR)
    size = step * select(success, growth, reduction)
    m.size[0] = select(success & (growth >= _MAX_FACTOR), larger(size, m.size[0]), size)
    m.is_shortened[0] = select(success, 0.0, m.is_shortened[0] + 1.0)


def _advance_once(m: LanesMemory, leg: LegMemory, end: float) -> None:
    """Attempt a step on each lane."""
    time = m.clock[0]
    is_busy = m.is_busy[0] != 0.0
    if m.event_count > 0 and any_lane(is_busy & (m.size[0] <= 0.0)):
        m.size[0] = select(is_busy & (m.size[0] <= 0.0), first_steps(m, end - time), m.size[0])
    goal = smaller(m.next_sample_time[0], end)
    distance = goal - time
    parts = ceiling(distance / (_LARGEST_STRETCH * m.size[0]))
    is_divided = distance >= _SHORTEST_STEP_SHARE * m.size[0]
    step = smaller(select(is_divided, distance / larger(parts, 1.0), m.size[0]), end - time)
    next_time = select(is_divided & (parts <= 1.0), goal, time + step)
    is_last = next_time + 0.01 * step >= end
    step, next_time = select(is_last, end - time, step), select(is_last, end, next_time)
    error = attempt(m, time, step)
    if m.event_count > 0:
        error = without_rounding(m, time, step, error)
    m.moment[0] = next_time
    evaluate_lanes(m.rates, m.moment, m.next_state, m.rate_constants, m.k, STAGES * m.n)
    success = is_busy & (error <= 1.0) & finite_lanes(m.k, STAGES * m.n, m.n)
    has_dense = False
    if m.event_count > 0:
        m.trial_size[0], m.next_time[0] = step, next_time
        has_dense = _follow_events(m, leg, time, step, success)
        success, next_time = success & (m.is_too_long[0] == 0.0), m.next_time[0]
    may_peak = compute_peaks(m, next_time, success)
    has_candidates = any_lane(may_peak)
    if not has_dense and (has_candidates or any_lane(success & (m.next_sample_time[0] < next_time))):
        compute_dense(m, time, step)
    if has_candidates:
        update_peaks(m, time, step, may_peak)
    for j in range(m.peak_count):
        m.places[j] = select(success, m.places[PLACES * m.peak_count + j], m.places[j])
    _record_samples(m, time, step, next_time, success)
    for i in range(m.n):
        m.state[i] = select(success, m.next_state[i], m.state[i])
        m.k[i] = select(success, m.k[STAGES * m.n + i], m.k[i])
    m.clock[0] = select(success, next_time, time)
    _propose_sizes(m, step, error, success)
    m.steps[0] = m.steps[0] + 1.0
    is_at_end = is_busy & (m.clock[0] >= end)
    if m.event_count > 0:
        _change_segments(m, leg, step, success)
    is_broken = is_busy & ~success & ((m.size[0] <= 4.0 * EPS * abs(time)) | (m.size[0] < TINY))
    has_no_steps_left = is_busy & ~is_at_end & ~is_broken & (m.steps[0] >= float(m.most_steps))
    if any_lane(is_at_end | is_broken | has_no_steps_left):
        _release_lanes(m, END, is_at_end)
        _release_lanes(m, NOT_FINITE, is_broken)
        _release_lanes(m, NO_STEPS_LEFT, has_no_steps_left)
    if m.event_count > 0:
        _release_sliding_lanes(m)


def _begin(m: LanesMemory) -> None:
    """Make all lanes idle, with states that are numbers."""
    m.counts[NEXT], m.counts[ACTIVE], m.counts[WAITING] = 0, 0, 0
    for lane in range(m.width):
        m.members[lane] = IDLE
        m.is_busy[0][lane], m.size[0][lane], m.clock[0][lane], m.next_sample_time[0][lane] = 0.0, 1.0, m.grid[0], _NEVER
        m.share[0][lane] = 1.0
        if m.event_count > 0:
            m.stops[lane] = NO_EVENT
        for i in range(m.n):
            m.state[i][lane] = 0.0


def advance_lanes(m: LanesMemory, leg: LegMemory) -> int:
    """Advance members over the grid, for so many rounds; return how many lanes are still in use: to be called until none is."""
    end = m.grid[m.grid_count - 1]
    if m.counts[NEXT] == NONE_BEGUN:
        _begin(m)
        _fill_lanes(m, leg)
    for _ in range(m.rounds):
        if m.counts[ACTIVE] == 0:
            break
        _advance_once(m, leg, end)
        if m.counts[NEXT] < m.member_count and (m.width - m.counts[ACTIVE]) * _REFILL_SHARE >= m.width:
            _fill_lanes(m, leg)
    if m.counts[ACTIVE] == 0:
        _flush_queue(m)
    active: int = m.counts[ACTIVE]
    return active
