"""A function at many points, on the lanes of vectors, in the part of Python that ``kernel_translation`` translates."""

from __future__ import annotations

from typing import NamedTuple

from wucht.numerics.flow.compiled.lane_memory import Function, LaneArray, Reals, evaluate_lanes


class PointsMemory(NamedTuple):
    """Points at which a function is evaluated, and the memory for it."""

    function: Function
    width: int  # of vectors
    n: int  # states
    constant_count: int
    result_count: int
    point_count: int  # N
    time: float
    states: Reals  # (n, N)
    constants: Reals  # (constant_count,)
    results: Reals  # (result_count, N)
    moment: LaneArray  # (1,)
    state: LaneArray  # (n,)
    constant: LaneArray  # (constant_count,)
    values: LaneArray  # (result_count,)


def evaluate_points(m: PointsMemory) -> int:
    """Evaluate the function at all points; return how many they are."""
    m.moment[0] = m.time
    for i in range(m.constant_count):
        m.constant[i] = m.constants[i]
    first = 0
    while first < m.point_count:
        for lane in range(m.width):  # spare lanes repeat the last point
            point = first + lane if first + lane < m.point_count else m.point_count - 1
            for i in range(m.n):
                m.state[i][lane] = m.states[i * m.point_count + point]
        evaluate_lanes(m.function, m.moment, m.state, m.constant, m.values, 0)
        for lane in range(m.width):
            if first + lane < m.point_count:
                for i in range(m.result_count):
                    m.results[i * m.point_count + first + lane] = m.values[i][lane]
        first += m.width
    return first
