"""Largest values of quantities, located within the steps of lanes.

In the part of Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

from wucht.numerics.flow.compiled.lane_memory import (
    Lanes,
    LanesMemory,
    Marks,
    any_lane,
    evaluate_lanes,
    larger,
    select,
    smaller,
)
from wucht.numerics.flow.compiled.lane_steps import dense_value

PLACES = 4  # of a step, at which quantities with a largest value are computed where one may be
_RANGE_MARGIN = 0.25  # of the range of five places of a step: so much larger a quantity may be between two of them
_PEAK_FACTOR = 1.0 + 1e-4  # times as large as the largest so far: else a place is not located more closely
_VERTEX_FACTOR = 1.3  # times the gain at a parabola's vertex may be there


def _compute_quantities(m: LanesMemory, time: Lanes, step: Lanes, x: Lanes) -> None:
    """Compute the quantities whose largest values are sought, from the states that they depend on, at parts x of the steps."""
    y = 1.0 - x
    for j in range(m.peak_state_count):
        m.point[m.peak_states[j]] = dense_value(m, m.peak_states[j], x, y)
    m.moment[0] = time + x * step
    evaluate_lanes(m.peak_quantities, m.moment, m.point, m.peak_constants, m.peak_value, 0)


def update_peaks(m: LanesMemory, time: Lanes, step: Lanes, may_peak: Marks) -> None:
    """Compute quantities at the places within steps, and locate those that are larger than all before."""
    for place in range(1, PLACES):
        _compute_quantities(m, time, step, place / PLACES * m.share[0])
        for j in range(m.peak_count):
            value = m.peak_value[j]
            m.places[place * m.peak_count + j] = value
            m.best[j] = select(may_peak & (value > m.best[j]), value, m.best[j])
    for j in range(m.peak_count):
        for place in range(1, PLACES):
            _locate_peak(m, j, place, time, step, may_peak)


def _locate_peak(m: LanesMemory, j: int, place: int, time: Lanes, step: Lanes, success: Marks) -> None:
    """Compute a quantity at the vertex of the parabola through three places, if it may be larger there than all before."""
    low = m.places[(place - 1) * m.peak_count + j]
    value = m.places[place * m.peak_count + j]
    high = m.places[(place + 1) * m.peak_count + j]
    bend, slope = 2.0 * value - low - high, high - low
    shift = 0.5 * slope / bend
    gain = 0.125 * slope * slope / bend
    may_peak = success & (bend > 0.0) & (abs(shift) <= 1.0) & (value + _VERTEX_FACTOR * gain > _PEAK_FACTOR * m.best[j])
    if any_lane(may_peak):
        _compute_quantities(m, time, step, (place + shift) / PLACES * m.share[0])
        m.best[j] = select(may_peak & (m.peak_value[j] > m.best[j]), m.peak_value[j], m.best[j])


def compute_peaks(m: LanesMemory, next_time: Lanes, success: Marks) -> Marks:
    """Compute the quantities with a largest value at the ends of steps; mark the steps within which one may be larger."""
    may_peak: Marks = success & ~success
    if m.peak_count > 0:
        m.moment[0] = next_time
        evaluate_lanes(m.peak_quantities, m.moment, m.next_state, m.peak_constants, m.peak_value, 0)
        for j in range(m.peak_count):
            high, low = larger(m.highest[j], m.peak_value[j]), smaller(m.lowest[j], m.peak_value[j])
            may_peak = may_peak | (success & (high + _RANGE_MARGIN * (high - low) > _PEAK_FACTOR * m.best[j]))
            m.places[PLACES * m.peak_count + j] = m.peak_value[j]
            m.best[j] = select(success & (m.peak_value[j] > m.best[j]), m.peak_value[j], m.best[j])
    return may_peak
