"""Steps of lanes by Dormand and Prince's method, their errors and their dense output.

E. Hairer, S. P. Norsett, G. Wanner, "Solving Ordinary Differential Equations I", Springer 1993, sections II.4 (step sizes),
II.6 (dense output) and II.10 (error). In the part of Python that ``kernel_translation`` translates.
"""

from __future__ import annotations

from wucht.numerics.flow.compiled.dormand_prince import ALL_STAGES, DENSE_ROW, DENSE_ROWS, ERROR_ROWS, OF_ROUNDING, STAGES
from wucht.numerics.flow.compiled.lane_memory import (
    LaneArray,
    Lanes,
    LanesMemory,
    Marks,
    any_lane,
    evaluate_lanes,
    larger,
    root,
    select,
    smaller,
)
from wucht.numerics.flow.compiled.leg_memory import EPS

# First and last of the stages whose states are those at 0.31, 0.65 and 0.6 of a step: to 1e-3, where that is a third of a turn.
_FIRST_PEAK_STAGE, _LAST_PEAK_STAGE = 7, 9
_ABSOLUTE = 1e-2  # of the relative tolerance
_OFTEN = 2.0  # a step that was shortened so many times may be one that rounding limits


def _add_stages(m: LanesMemory, row: int, step: Lanes, end: LaneArray) -> None:
    """Add the rates of stages, times the step and the weights of a row, to the states."""
    _sum_stages(m, row, end, 0)
    for i in range(m.n):
        end[i] = m.state[i] + step * end[i]


def _sum_stages(m: LanesMemory, row: int, sums: LaneArray, first: int) -> None:
    """Sum the rates of stages with the weights of a row: of two states at once, which keeps more of the processor busy."""
    for i in range(0, m.n - 1, 2):
        sum_0 = 0.0 * m.k[i]
        sum_1 = 0.0 * m.k[i]
        for j in range(m.row_begins[row], m.row_begins[row + 1]):
            weight, place = m.row_weights[j], m.row_places[j] + i
            sum_0 += weight * m.k[place]
            sum_1 += weight * m.k[place + 1]
        sums[first + i], sums[first + i + 1] = sum_0, sum_1
    if m.n % 2 == 1:
        last = 0.0 * m.k[m.n - 1]
        for j in range(m.row_begins[row], m.row_begins[row + 1]):
            last += m.row_weights[j] * m.k[m.row_places[j] + m.n - 1]
        sums[first + m.n - 1] = last


def dense_value(m: LanesMemory, i: int, x: Lanes, y: Lanes) -> Lanes:
    """Return a state at parts x = 1 - y of the steps."""
    value = m.dense[6 * m.n + i] * x
    value = (value + m.dense[5 * m.n + i]) * y
    value = (value + m.dense[4 * m.n + i]) * x
    value = (value + m.dense[3 * m.n + i]) * y
    value = (value + m.dense[2 * m.n + i]) * x
    value = (value + m.dense[m.n + i]) * y
    result: Lanes = m.state[i] + (value + m.dense[i]) * x
    return result


def finite_lanes(values: LaneArray, first: int, count: int) -> Marks:
    """Mark the lanes on which so many values are finite."""
    total = 0.0 * values[first]
    for i in range(1, count):
        total += 0.0 * values[first + i]
    finite: Marks = total == 0.0
    return finite


def _allowed_error(m: LanesMemory, i: int, value: Lanes, next_value: Lanes) -> Lanes:
    if m.is_angle[i] != 0.0:
        return m.tolerance + 0.0 * value
    return m.tolerance * (_ABSOLUTE + larger(abs(value), abs(next_value)))


def root_8(x: Lanes) -> Lanes:
    """Return the eighth root."""
    return root(root(root(x)))


def first_steps(m: LanesMemory, span: Lanes) -> Lanes:
    """Return first step sizes, from the rates at the beginning and after a small step: section II.4."""
    size = 0.0 * span
    speed = 0.0 * span
    for i in range(m.n):
        scale = _allowed_error(m, i, m.state[i], m.state[i])
        size += (m.state[i] / scale) ** 2
        speed += (m.k[i] / scale) ** 2
    size, speed = root(size / m.n), root(speed / m.n)
    small = smaller(select((size < 1e-5) | (speed < 1e-5), 1e-6, 0.01 * size / speed), span)
    for i in range(m.n):
        m.point[i] = m.state[i] + small * m.k[i]
    m.moment[0] = m.clock[0] + small
    evaluate_lanes(m.rates, m.moment, m.point, m.rate_constants, m.next_state, 0)
    change = 0.0 * span
    for i in range(m.n):
        scale = _allowed_error(m, i, m.state[i], m.state[i])
        change += ((m.next_state[i] - m.k[i]) / scale) ** 2
    largest = larger(speed, root(change / m.n) / small)
    step = select(largest <= 1e-15, larger(1e-6, small * 1e-3), root_8(0.01 / largest))
    step = select(step > 0.0, step, small)  # the rates are not finite there
    return smaller(smaller(100.0 * small, step), span)


def _compute_stage(m: LanesMemory, stage: int, time: Lanes, step: Lanes) -> None:
    _add_stages(m, stage, step, m.point)
    m.moment[0] = time + m.nodes[stage] * step
    evaluate_lanes(m.rates, m.moment, m.point, m.rate_constants, m.k, stage * m.n)


def attempt(m: LanesMemory, time: Lanes, step: Lanes) -> Lanes:
    """Attempt steps from states whose rates are known; return their errors, at most 1 where accepted: section II.10."""
    for j in range(m.peak_count):
        m.highest[j] = m.lowest[j] = m.places[j]
    for j in range(m.event_count):
        m.highest_event_values[j] = m.lowest_event_values[j] = m.first_event_values[j]
    for stage in range(1, STAGES):
        _compute_stage(m, stage, time, step)
        if m.peak_count > 0 and _FIRST_PEAK_STAGE <= stage <= _LAST_PEAK_STAGE:
            evaluate_lanes(m.peak_quantities, m.moment, m.point, m.peak_constants, m.peak_value, 0)
            for j in range(m.peak_count):
                m.highest[j] = larger(m.highest[j], m.peak_value[j])
                m.lowest[j] = smaller(m.lowest[j], m.peak_value[j])
        if m.event_count > 0 and _FIRST_PEAK_STAGE <= stage <= _LAST_PEAK_STAGE:
            evaluate_lanes(m.event_functions, m.moment, m.point, m.event_constants, m.event_values, 0)
            for j in range(m.event_count):
                m.highest_event_values[j] = larger(m.highest_event_values[j], m.event_values[j])
                m.lowest_event_values[j] = smaller(m.lowest_event_values[j], m.event_values[j])
    _add_stages(m, STAGES, step, m.next_state)
    _sum_stages(m, ERROR_ROWS, m.error_5, 0)
    _sum_stages(m, ERROR_ROWS + 1, m.error_3, 0)
    squares_5 = 0.0 * step
    squares_3 = 0.0 * step
    for i in range(m.n):
        inverse = 1.0 / _allowed_error(m, i, m.state[i], m.next_state[i])
        squares_5 += (m.error_5[i] * inverse) ** 2
        squares_3 += (m.error_3[i] * inverse) ** 2
    return select(squares_5 == 0.0, 0.0, step * squares_5 / root((squares_5 + 0.01 * squares_3) * m.n))


def compute_dense(m: LanesMemory, time: Lanes, step: Lanes) -> None:
    """Compute the coefficients of the dense output of steps: section II.6."""
    for stage in range(STAGES + 1, ALL_STAGES):
        _compute_stage(m, stage, time, step)
    for i in range(m.n):
        gain = m.next_state[i] - m.state[i]
        m.dense[i] = gain
        m.dense[m.n + i] = step * m.k[i] - gain
        m.dense[2 * m.n + i] = 2.0 * gain - step * (m.k[STAGES * m.n + i] + m.k[i])
    for row in range(DENSE_ROWS):
        _sum_stages(m, DENSE_ROW + row, m.dense, (3 + row) * m.n)
        for i in range(m.n):
            m.dense[(3 + row) * m.n + i] = step * m.dense[(3 + row) * m.n + i]


def _rounding_errors(m: LanesMemory, time: Lanes, step: Lanes) -> Lanes:
    """Return the errors that rounding of the states alone makes in steps: see ``_rounding_error`` of ``leg_stepper``."""
    largest = 0.0 * step
    m.moment[0] = time
    digit = 1
    while digit < 2 * m.n:
        squares = 0.0 * step
        for i in range(m.n):
            m.point[i] = m.state[i] * (1.0 + (EPS if i % (2 * digit) < digit else -EPS))
        evaluate_lanes(m.rates, m.moment, m.point, m.rate_constants, m.error_5, 0)
        for i in range(m.n):
            squares += ((m.error_5[i] - m.k[i]) / _allowed_error(m, i, m.state[i], m.next_state[i])) ** 2
        largest = larger(largest, squares)
        digit = 2 * digit
    errors: Lanes = step * root(largest / m.n)
    return errors


def without_rounding(m: LanesMemory, time: Lanes, step: Lanes, error: Lanes) -> Lanes:
    """Return the errors of steps, those small that are no larger than rounding."""
    is_often_shortened = (error > 1.0) & (m.is_shortened[0] >= _OFTEN)
    if any_lane(is_often_shortened):
        return select(is_often_shortened & (error <= _rounding_errors(m, time, step)), OF_ROUNDING, error)
    return error
