"""Changes of segment of piecewise functions, within a leg, in the part of Python that ``kernel_translation`` translates.

A segment's numbers (its ends and its polynomials) are the last constants of all code of a system: to change it is to copy a row
of a table. The rules are those of ``segment_locator`` and ``coincidences``; where a requested event may happen at the same
instant, the leg ends, and these decide.
"""

from __future__ import annotations

from wucht.numerics.flow.compiled.leg_memory import EPS, SAMPLE_COUNT, SCRATCH, STOPPING_EVENT, LegMemory, evaluate

AHEAD, AHEAD_FROM_REST = 1e-9, 1e-5  # relative to the time: how far to look ahead where an argument lies on a breakpoint
END_MARGIN = 2e-15  # of the largest number that occurs: smallest distance of a segment's end beyond its argument
ROUNDING = 1000.0 * EPS  # of the largest number that occurs, and of the time: a nearer argument is on its breakpoint
AT_BREAKPOINT = 1e-12  # for the ends' functions, and relative to the time
HIGH, HAS_LOW, HAS_HIGH = 1, 2, 3  # places in a row; the low end is the first
FIRST_OF_SEGMENT = 2.0  # step, of the duration of the segment before
# A motion slides after so many changes of segment in succession, each after a shorter advance: of the time, or of a leg.
STILL, MOST_STILL = 1e-10, 200
STILL_IN_LEG, _FACTOR_IN_LEG = 1e-9, 100  # times as many in a leg: a fast motion that dies out is not one that slides
MOST_CHANGES = MOST_STILL * _FACTOR_IN_LEG
_FAR = 1e300
_BEFORE, _LATER, _GAINS = 1, 2, 3  # rows of instants: a little earlier or later, of one length of these, before a change


def _look(leg: LegMemory, time: float, direction: float) -> None:
    """Compute the values of an instant, and those a little later, or earlier: where they change at all."""
    count = leg.instant_count
    evaluate(leg.instant, time, leg.state, leg.instant_constants, leg.instants, 0)
    for i in range(count):
        leg.instants[_BEFORE * count + i] = leg.instants[i]
    for attempt in range(2):
        step = direction * (AHEAD if attempt == 0 else AHEAD_FROM_REST) * max(1.0, abs(time))
        evaluate(leg.rates, time, leg.state, leg.constants, leg.errors, 0)
        for i in range(leg.n):
            leg.point[i] = leg.state[i] + 0.5 * step * leg.errors[i]
        evaluate(leg.rates, time + 0.5 * step, leg.point, leg.constants, leg.errors, 0)
        for i in range(leg.n):
            leg.point[i] = leg.state[i] + step * leg.errors[i]
        evaluate(leg.instant, time + step, leg.point, leg.instant_constants, leg.instants, _LATER * count)
        resting = 0  # functions and arguments that have not changed
        for i in range(count):
            if leg.instants[_BEFORE * count + i] == leg.instants[i]:
                leg.instants[_BEFORE * count + i] = leg.instants[_LATER * count + i]
                is_size = leg.request_count <= i < 2 * leg.request_count
                if leg.instants[_LATER * count + i] == leg.instants[i] and i < count - leg.gain_count and not is_size:
                    resting += 1
        if resting == 0:
            break


def _is_to_be_decided(leg: LegMemory, time: float) -> bool:
    """Return whether a requested event, or a sample of a work that jumps, may lie at this instant."""
    sample = leg.counts[SAMPLE_COUNT]
    if leg.gain_count > 0 and sample > 0 and abs(leg.grid[sample - 1] - time) <= AT_BREAKPOINT * max(1.0, abs(time)):
        return True
    if leg.request_count == 0:
        return False
    _look(leg, time, -1.0)
    for i in range(leg.request_count):
        change = abs(leg.instants[i] - leg.instants[leg.instant_count + i]) / AHEAD
        noise = ROUNDING * max(leg.instants[leg.request_count + i], change)
        if leg.cool_ends[i] >= time or (change > 0.0 and abs(leg.instants[i]) <= noise):
            return True
    return False


def _size(leg: LegMemory, time: float, j: int) -> float:
    """Return the largest number from which an argument is computed: its rounding is a few units of that."""
    largest = 0.0
    for k in range(leg.size_begins[j], leg.size_begins[j + 1]):
        largest = max(largest, abs(time if leg.size_states[k] == leg.n else leg.state[leg.size_states[k]]))
    return largest


def _segment_of_argument(leg: LegMemory, time: float, j: int) -> int:
    """Return the segment of an argument; on a breakpoint that to which it moves."""
    place = 2 * leg.request_count + j
    value, ahead = leg.instants[place], leg.instants[leg.instant_count + place]
    first = leg.breakpoint_begins[j]
    count: int = leg.breakpoint_begins[j + 1] - first
    above: int = leg.segment[j]
    while above < count and leg.breakpoints[first + above] <= value:
        above += 1
    while above > 0 and leg.breakpoints[first + above - 1] > value:
        above -= 1
    nearest = above if above < count else count - 1
    if above > 0 and value - leg.breakpoints[first + above - 1] <= abs(leg.breakpoints[first + nearest] - value):
        nearest = above - 1
    distance = abs(value - leg.breakpoints[first + nearest])
    if ahead != value and distance <= ROUNDING * max(leg.scales[j], _size(leg, time, j), abs(ahead - value) / AHEAD):
        return nearest + 1 if ahead > value else nearest
    return above


def _use_segment(leg: LegMemory, j: int, segment: int) -> None:
    """Copy the numbers of a segment to the constants."""
    leg.segment[j] = segment
    place = leg.segment_places[j]
    width = leg.segment_places[j + 1] - place
    first = leg.segment_begins[j] + segment * width
    for k in range(width):
        leg.constants[leg.rates_tail + place + k] = leg.segment_rows[first + k]
        leg.event_constants[leg.event_tail + place + k] = leg.segment_rows[first + k]
        leg.instant_constants[leg.instant_tail + place + k] = leg.segment_rows[first + k]


def _locate_other_segments(leg: LegMemory, time: float, at_end: int) -> None:
    """Use the segments of the arguments, but the one just begun, until none changes: they may depend on one another's.

    at_end: the number of that one, negative for none.
    """
    place = 2 * leg.request_count + at_end
    argument = 0.0
    for attempt in range(leg.segmentation_count + 1):
        _look(leg, time, 1.0)
        if attempt == 0 and at_end >= 0:
            argument = leg.instants[place]
        has_changed = 0
        for j in range(leg.segmentation_count):
            if j != at_end or leg.instants[place] != argument:
                segment = _segment_of_argument(leg, time, j)
                if segment != leg.segment[j]:
                    _use_segment(leg, j, segment)
                    has_changed = 1
        if has_changed == 0:
            break


def _open_ends(leg: LegMemory, time: float, j: int) -> None:
    """Place the ends of a segment beyond its argument: an event function that begins a step at zero would be missed."""
    value, place = leg.instants[2 * leg.request_count + j], leg.event_tail + leg.segment_places[j]
    margin = END_MARGIN * max(leg.scales[j], _size(leg, time, j))
    first = leg.segment_begins[j] + leg.segment[j] * (leg.segment_places[j + 1] - leg.segment_places[j])
    if leg.segment_rows[first + HAS_LOW] > 0.0:
        leg.event_constants[place] = min(leg.segment_rows[first], value - margin)
    if leg.segment_rows[first + HAS_HIGH] > 0.0:
        leg.event_constants[place + HIGH] = max(leg.segment_rows[first + HIGH], value + margin)


def begin_segments(leg: LegMemory, time: float) -> None:
    """Locate the segments in use at the beginning of a motion: see ``SegmentLocator.start``."""
    for j in range(leg.segmentation_count):
        _use_segment(leg, j, 0)
    for i in range(leg.m):
        leg.cool_ends[i], leg.cool_signs[i] = -_FAR, 0.0
    for _ in range(leg.segmentation_count):  # rates may be infinite on wrong segments: first those of the arguments alone
        evaluate(leg.instant, time, leg.state, leg.instant_constants, leg.instants, 0)
        for i in range(leg.instant_count):
            leg.instants[leg.instant_count + i] = leg.instants[i]
        for j in range(leg.segmentation_count):
            _use_segment(leg, j, _segment_of_argument(leg, time, j))
    _locate_other_segments(leg, time, -1)
    for j in range(leg.segmentation_count):
        _open_ends(leg, time, j)


def fold_lowest_arguments(leg: LegMemory) -> None:
    """Update the lowest value of each argument by that of the upper end's function, which begins anew."""
    for i in range(leg.request_count, leg.m):
        j = leg.event_segments[i]
        place = leg.event_tail + leg.segment_places[j]
        if leg.event_kinds[i] == 1 and leg.event_constants[place + HAS_HIGH] > 0.0:
            value = leg.lowest[i] * leg.scales[j] + leg.event_constants[place + HIGH]
            leg.lowest_arguments[j] = min(leg.lowest_arguments[j], value)
        leg.lowest[i] = _FAR


def _cool_down(leg: LegMemory, time: float) -> None:
    """Begin cool-downs: an argument within rounding of an end of its segment counts as inside."""
    evaluate(leg.functions, time, leg.state, leg.event_constants, leg.values, SCRATCH * leg.m)
    for i in range(leg.m):
        leg.cool_ends[i] = -_FAR
        if i >= leg.request_count and abs(leg.values[SCRATCH * leg.m + i]) <= AT_BREAKPOINT:
            leg.cool_ends[i] = time + AT_BREAKPOINT * max(1.0, abs(time))
            leg.cool_signs[i] = -float(leg.event_kinds[i])


def change_segments(leg: LegMemory, time: float) -> bool:
    """Begin the segment beyond the end at which a step stopped; return false where the leg has to end.

    Where two arguments reach a breakpoint together only one event may be reported, and an argument that has just passed a
    breakpoint may by rounding lie before it: so the other segments are located from their arguments now and a little later.
    """
    event: int = leg.counts[STOPPING_EVENT]
    if event < leg.request_count or _is_to_be_decided(leg, time):
        return False
    fold_lowest_arguments(leg)
    at_end, gains = leg.event_segments[event], leg.instant_count - leg.gain_count
    if leg.gain_count > 0:
        evaluate(leg.instant, time, leg.state, leg.instant_constants, leg.instants, _GAINS * leg.instant_count)
    _use_segment(leg, at_end, leg.segment[at_end] + leg.event_kinds[event])
    _locate_other_segments(leg, time, at_end)
    for j in range(leg.segmentation_count):
        _open_ends(leg, time, j)
    if leg.gain_count > 0:
        evaluate(leg.instant, time, leg.state, leg.instant_constants, leg.instants, 0)
        for k in range(gains, leg.instant_count):
            jump = leg.instants[k] - leg.instants[_GAINS * leg.instant_count + k]
            leg.state[leg.n - leg.gain_count + k - gains] += jump
    _cool_down(leg, time)
    return True


def changes_at_standstill(leg: LegMemory, time: float, duration: float, least: float, changes: int) -> int:
    """Count the changes in succession after one that followed a segment of a duration: one where time stands still as many.

    Those of arguments of the time alone are none: they cannot slide. least: duration that is no standstill.
    """
    at_end, is_of_states = leg.event_segments[leg.counts[STOPPING_EVENT]], 0
    for k in range(leg.size_begins[at_end], leg.size_begins[at_end + 1]):
        if leg.size_states[k] < leg.n:
            is_of_states = 1
    if duration < STILL * max(1.0, abs(time)):
        return changes + is_of_states * _FACTOR_IN_LEG
    return changes + is_of_states if duration < least else 0
