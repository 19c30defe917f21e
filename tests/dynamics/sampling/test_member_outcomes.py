"""Outcomes of members in parts and selections, and the envelopes of those that are screened, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sampling import ensembles
from wucht.dynamics.sampling.attractors import Attractor
from wucht.dynamics.sampling.ensembles import MemberOutcomes, run_possible
from wucht.dynamics.sampling.screening_observer import (
    PARTS,
    SAMPLES,
    _arrival_time,
    _extend_envelopes,
    _settling_time,
)
from wucht.dynamics.verdicts.outcomes import OUTCOMES, SPEED_TOLERANCE, UNBALANCE_TOLERANCE, Outcome
from wucht.errors import InputError

ARRAYS = ("outcome", "settling_time", "peak_amplitude", "end_time")


def members(*outcomes: int, failures: tuple[tuple[int, str], ...] = ()) -> MemberOutcomes:
    """Each array is a multiple of the outcomes."""
    of = np.array(outcomes)
    return MemberOutcomes(of, 10.0 * of, 100.0 * of, 1000.0 * of, failures)


def numbers(of: MemberOutcomes) -> list[int]:
    """The outcomes, with which all arrays agree."""
    for factor, name in zip((1, 10, 100, 1000), ARRAYS, strict=True):
        assert getattr(of, name).tolist() == (factor * of.outcome).tolist(), name
    return [int(x) for x in of.outcome]


def test_parts_in_a_row() -> None:
    whole = MemberOutcomes.join(
        [members(1, 2, failures=((1, "a"),)), members(3), members(4, 5, 6, failures=((0, "b"), (2, "c")))]
    )
    assert numbers(whole) == [1, 2, 3, 4, 5, 6] and whole.failures == ((1, "a"), (3, "b"), (5, "c"))


def test_new_outcomes_of_some() -> None:
    of, at = members(1, 2, 3, 4, failures=((0, "old"), (3, "replaced"))), np.array([3, 1])
    new = of.with_outcomes(at, members(8, 9, failures=((0, "new"), (1, "other"))))
    assert numbers(new) == [1, 9, 3, 8] and new.failures == ((0, "old"), (1, "other"), (3, "new"))
    assert numbers(of) == [1, 2, 3, 4], "it stays as it was"
    assert of.with_failures({3: "z", 1: "y"}).failures == ((1, "y"), (3, "z"))


def test_a_selection_counts_anew() -> None:
    of = members(1, 2, 3, 4, failures=((0, "a"), (2, "b"), (3, "c")))
    chosen = of.select(np.array([3, 1, 2]))
    assert numbers(chosen) == [4, 2, 3] and chosen.failures == ((0, "c"), (2, "b"))


def test_how_many_there_are_of_each() -> None:
    k, last = OUTCOMES.index(Outcome.COMPENSATED), len(OUTCOMES) - 1
    assert members(last, k, k).counts() == {Outcome.COMPENSATED: 2, OUTCOMES[-1]: 1}


def test_members_that_cannot_be_run_have_failed(monkeypatch: pytest.MonkeyPatch) -> None:
    """The second of three overlaps: its values are not run, and the others keep their places."""

    def machine_in_state(machine: Any, start: np.ndarray) -> None:
        if start[0] == 1.0 and machine == {"k": 20.0}:
            raise InputError("study", None, "they overlap")

    monkeypatch.setattr(ensembles, "machine_in_state", machine_in_state)
    machine: Any = SimpleNamespace(tracks=("track",), with_values=lambda values: values)

    def run(starts: np.ndarray, values: Any) -> MemberOutcomes:
        assert starts.tolist() == [[0.0, 2.0]] and values["k"].tolist() == [10.0, 30.0]
        return members(4, 5)

    found = run_possible(run, machine, np.array([[0.0, 1.0, 2.0]]), {"k": np.array([10.0, 20.0, 30.0])})
    assert found.outcome.tolist() == [4, OUTCOMES.index(Outcome.FAILED), 5] and found.failures == ((1, "they overlap"),)
    assert found.end_time.tolist() == [4000.0, 0.0, 5000.0] and np.isnan(found.settling_time[1])
    alone = run_possible(run, machine, np.array([[1.0]]), {"k": np.array([20.0])})
    assert alone.outcome.tolist() == [OUTCOMES.index(Outcome.FAILED)]


def envelopes(speed: np.ndarray, residual: np.ndarray) -> np.ndarray:
    """Of one member, whose least and largest values are the same in each part."""
    return np.array([speed, speed, residual, residual])[:, :, None]


def level(value: float = 0.0) -> np.ndarray:
    return np.full(PARTS, value)


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("way", [1.0, -1.0])
@pytest.mark.parametrize(("free", "scale"), [(200.0, 200.0), (-200.0, 200.0), (math.nan, 100.0)])
def test_a_speed_has_settled_where_it_stays_near_its_end(sense: float, way: float, free: float, scale: float) -> None:
    """Until the 31st part of 320 s it is 1.01 of the tolerance away, or 0.99: a share of the free speed, else of its own."""
    for share, time in ((1.01, 30 / PARTS * 320.0), (0.99, 0.0)):
        speed = level(sense * 100.0)
        speed[:30] += way * share * SPEED_TOLERANCE * scale
        assert _settling_time(envelopes(speed, level()), 320.0, np.array([free])).tolist() == [pytest.approx(time)]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_an_unbalance_has_settled_where_it_stays_near_its_end(way: float) -> None:
    for share, time in ((1.01, 40 / PARTS * 320.0), (0.99, 0.0)):
        residual = level(0.5)
        residual[:40] += way * share * UNBALANCE_TOLERANCE
        assert _settling_time(envelopes(level(100.0), residual), 320.0, np.array([100.0])).tolist() == [pytest.approx(time)]


def test_settling_counts_from_the_middle_of_the_last_part() -> None:
    """The last part ranges by 1.6 tolerances: one more than 1.8 tolerances above its middle has not settled, below neither."""
    tolerance = SPEED_TOLERANCE * 100.0
    for extra, part in ((0.9, 0), (1.1, 12), (-0.9, 0), (-1.1, 12)):
        low, high = level(100.0), level(100.0)
        low[-1], high[-1] = 100.0 - 0.8 * tolerance, 100.0 + 0.8 * tolerance
        low[:12] += min(extra, 0.0) * tolerance
        high[:12] += max(extra, 0.0) * tolerance
        of = np.array([low, high, level(), level()])[:, :, None]
        assert _settling_time(of, float(PARTS), np.array([100.0])).tolist() == [pytest.approx(part)]


def attractor(**more: Any) -> Attractor:
    points = np.array([[0.0, 0.0], [1.0, 0.0]])
    given = {"outcome": 3, "sizes": np.array([10.0, 2.0]), "reach": 0.1, "sense": 1, "low": 90.0, "high": 110.0}
    return Attractor(points=points, **(given | {"period": 7.0, "peak_distance_squared": 0.25} | more))


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_member_arrives_where_it_stays_in_the_range_and_a_period_later(sense: float) -> None:
    margin = SPEED_TOLERANCE * 100.0
    for speed, part in ((110.0 + 1.1 * margin, 20), (110.0 + 0.9 * margin, 0), (90.0 - 1.1 * margin, 20), (89.9, 0)):
        of = level(sense * 100.0)
        of[:20] = sense * speed
        time = _arrival_time(envelopes(of, level()), float(PARTS), attractor(), np.array([sense * 100.0]))
        assert time.tolist() == [pytest.approx(part + 7.0)]


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(
    ("low", "high", "duration", "stays"),
    [
        (90.0, 110.0, 5.0, True), (95.0, 106.0, 5.0, True), (95.0, 104.0, 5.0, False), (95.0, 106.0, 8.0, False),
        (91.0, 110.0, 8.0, True), (88.5, 110.0, 8.0, True), (87.5, 110.0, 8.0, False), (90.0, 112.5, 8.0, False),
        (-110.0, -90.0, 8.0, False),
    ],
)  # fmt: skip
def test_who_goes_through_the_range_of_its_speed_stays_near_it(
    sense: int, low: float, high: float, duration: float, stays: bool
) -> None:
    """Half of the range in less than a period, nine tenths in more; and no more than a tenth of it outside."""
    samples = np.tile(np.array([[5.0, 10.5, 0.0], [0.0, 0.0, 0.5]]), (40, 1, 1))
    speeds = np.sort(sense * np.array([low, high]))[:, None] * np.ones(3)
    candidates = np.array([1, 2, 0])
    found = attractor(sense=sense).resident_members(lambda x: np.moveaxis(x, 1, 2), samples, speeds, duration, candidates)
    assert found.tolist() == ([1] if stays else []), "the second is 0.05 of its sizes away, the others half and a quarter"


def test_envelopes_in_half_as_many_parts_have_the_extremes_of_two() -> None:
    speed = np.arange(float(PARTS))[:, None] * np.array([1.0, -1.0])
    first = _extend_envelopes(None, speed, 10 * speed)
    assert [row[:2, 0].tolist() for row in first] == [[0.0, 1.0], [0.0, 1.0], [0.0, 10.0], [0.0, 10.0]]
    new = np.full((SAMPLES, 2), 7.0)
    longer = _extend_envelopes(first, new, 2 * new)
    assert [row[:2, 0].tolist() for row in longer] == [[0.0, 2.0], [1.0, 3.0], [0.0, 20.0], [10.0, 30.0]]
    assert [row[:2, 1].tolist() for row in longer] == [[-1.0, -3.0], [0.0, -2.0], [-10.0, -30.0], [0.0, -20.0]]
    assert [row[SAMPLES:].tolist() for row in longer] == [new.tolist()] * 2 + [(2 * new).tolist()] * 2
