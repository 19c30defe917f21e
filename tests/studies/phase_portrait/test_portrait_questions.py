"""Questions of ``phase-portrait`` whose keys do not fit each other, or are no tables, pairs or names."""

from __future__ import annotations

from typing import Any

import pytest
from tests.refusals import refused

import wucht


@pytest.mark.parametrize(
    ("asked", "where", "says"),
    [
        ({"ranges": 3}, "study.ranges", "must be a table: ranges = { STATE = [low, high], ... }"),
        ({"ranges": {"x": 3}}, "study.ranges", "must give a pair [low, high] for x"),
        ({"ranges": {"x": [1, 2, 3]}}, "study.ranges", "must give a pair [low, high] for x"),
        ({"together": "p1"}, "study.together", 'must be true, or the names of bodies: together = ["p1", "p2"]'),
        ({"together": ["p1"]}, "study.together", 'must be true, or the names of bodies: together = ["p1", "p2"]'),
        ({"together": ["p1", 2]}, "study.together", 'must be true, or the names of bodies: together = ["p1", "p2"]'),
        ({"along": "mu"}, "study.values", "missing"),
        ({"values": [1.0]}, "study.along", "missing"),
        ({"along": "mu", "values": [0.01 * k for k in range(61)]}, "study.values", "there must be at most 60 portraits"),
        ({"trajectories": 401}, "study.trajectories", "there must be at most 400"),
    ],
)
def test_questions_that_do_not_fit(asked: dict[str, Any], where: str, says: str) -> None:
    with refused(where, code="missing") if says == "missing" else refused(where, says):
        wucht.PhasePortrait(**asked)


def test_questions_that_fit() -> None:
    asked = wucht.PhasePortrait(
        together=["p1", "p2"], ranges={"x": [0, 1]}, along="mu", values=[0.01 * k for k in range(60)], trajectories=400
    )
    assert asked.together == ("p1", "p2") and asked.ranges == {"x": (0, 1)} and len(asked.values) == 60
    assert wucht.PhasePortrait(together=True).together is True


def test_whether_the_main_rotor_turns_at_a_given_speed() -> None:
    assert wucht.PhasePortrait().turning() == ""
    assert wucht.PhasePortrait(speed=20.0).turning() == "the main rotor held at study.speed"
