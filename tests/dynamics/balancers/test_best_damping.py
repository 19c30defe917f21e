"""The damping of the shortest settling time, of those with which most runs get through."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from wucht.dynamics.balancers.candidates import CandidateResults
from wucht.dynamics.balancers.damping_optimum import damping_curve

DAMPINGS = np.array([0.1, 0.2, 0.3, 0.4])


def curve(settling: list[float], captured: list[float]) -> float:
    objectives = np.column_stack([settling, np.zeros(4), np.zeros(4), captured])
    nothing = np.zeros(4)
    seen = replace(CandidateResults.unknown(4, 1, 1), numbers=DAMPINGS[:, None], objectives=objectives)
    return damping_curve(DAMPINGS, seen, (nothing, 0.25)).optimum


@pytest.mark.parametrize(
    ("settling", "captured", "best"),
    [
        ([5.0, 3.0, 4.0, 6.0], [0.0, 0.0, 0.0, 0.0], 0.2),
        ([1.0, 3.0, 4.0, 2.0], [0.5, 0.0, 0.0, 0.1], 0.2),
        ([1.0, math.nan, 4.0, 2.0], [0.2, 0.2, 0.2, 0.1], 0.4),
    ],
)
def test_the_shortest_time_of_those_through_which_most_get(settling: list[float], captured: list[float], best: float) -> None:
    assert curve(settling, captured) == best


def test_where_none_settles_there_is_none() -> None:
    assert math.isnan(curve([math.nan] * 4, [0.0] * 4))
