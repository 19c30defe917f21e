"""Probabilities of runs that are made by hand: counts, shares, words, failures, and the report."""

from __future__ import annotations

import math
from dataclasses import replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.hand_made import titled, warnings_of
from tests.refusals import refused

from known_basins import MACHINE
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.studies.capture_probability import computation
from wucht.studies.capture_probability.computation import Findings, Plan, ProbabilityPoint, clopper_pearson, prepare
from wucht.studies.capture_probability.dataset import _distribution_in_words, _sample_word, dataset, report
from wucht.studies.capture_probability.distributions import Indices
from wucht.studies.capture_probability.spec import CaptureProbability

NUMBER = {str(o): k for k, o in enumerate(OUTCOMES)}
RANDOM = {"psi": {"uniform": [0.0, 6.0]}, "delta": {"normal": [1.0, 0.1]}}


def planned(**asked: Any) -> Plan:
    given = {"along": "u", "range": [1.0, 3.0], "points": 3, "random": RANDOM, "model": "slow", "samples": 64, "until": 500.0}
    return prepare(CaptureProbability(**given | asked), MACHINE)


@pytest.fixture(scope="module")
def plan() -> Plan:
    return planned(probability=0.5)


def members(names: list[str], failures: tuple[tuple[int, str], ...] = ()) -> MemberOutcomes:
    n = len(names)
    return MemberOutcomes(np.array([NUMBER[x] for x in names], np.int8), np.ones(n), np.ones(n), np.ones(n), failures)


def point(value: float, names: list[str], searched: bool = False, **other: Any) -> ProbabilityPoint:
    counted = (NUMBER["compensated"], NUMBER["passed"])
    return ProbabilityPoint(value, members(names, **other), 4, counted, 0.95, searched)


# Of each four runs two are counted, one is not, one has no verdict.
MIXED = ["compensated", "captured", "passed", "unidentified"] * 16
ALL, NONE, OPEN = ["passed"] * 64, ["captured"] * 64, ["failed"] * 64


def found(*points: ProbabilityPoint, **other: Any) -> Findings:
    return Findings(points, **other)


def test_the_numbers_of_a_point(plan: Plan) -> None:
    one = point(1.0, MIXED)
    assert one.inside.tolist() == [2] * 16 and one.open.tolist() == [1] * 16
    assert one.estimate == pytest.approx(2 / 3), "of those with a verdict"
    assert math.isnan(point(1.0, OPEN).estimate)
    every, none = point(1.0, ALL).bounds, point(1.0, NONE).bounds
    assert (every.low, every.high) == pytest.approx((0.025 ** (1 / 64), 1.0)) and every.value == 1.0
    assert (none.low, none.high) == pytest.approx((0.0, 1 - 0.025 ** (1 / 64)))
    uneven = point(1.0, ["compensated"] * 4 + ["captured"] * 60)
    assert uneven.inside.tolist() == [4] + [0] * 15, "replicates are in a row"
    assert clopper_pearson(0.0, 64.0, 0.025)[1] == pytest.approx(none.high)


def test_the_dataset_and_the_summary(plan: Plan) -> None:
    points = point(1.0, NONE), point(1.5, MIXED, True), point(2.0, ALL), point(3.0, ALL)
    result = titled(dataset(plan, found(*points)))
    assert result.parameter.values.tolist() == [1.0, 1.5, 2.0, 3.0] and result.searched.values.tolist() == [0, 1, 0, 0]
    assert result.estimate.values == pytest.approx([0.0, 2 / 3, 1.0, 1.0])
    assert result.not_identified.values.tolist() == [0.0, 0.25, 0.0, 0.0]
    for name in ("low", "high"):
        assert result[name].values == pytest.approx([getattr(p.bounds, name) for p in points])
    s = result.wucht.summary
    assert (s["runs"], s["samples"], s["searched"], s["values"], s["replicates"]) == (256, 64, 1, [3, 3], 16)
    assert (s["smallest"], s["wanted"], s["range"], s["confidence"]) == (2.0, 0.5, [1.0, 3.0], 0.95)
    row = s["probability"][1]
    assert row["fractions"] == {"compensated": 0.25, "passed": 0.25, "captured": 0.25, "unidentified": 0.25}
    assert row["u"] == 1.5 and row["not_identified"] == 0.25 and row["low"] < 2 / 3 < row["high"]
    assert s["sentence"].startswith("with 95 % confidence at least 0.5 of the starts end as compensated or passed from")
    assert not s["sentence"].endswith("the lowest computed value")
    lowest = dataset(plan, found(*(point(v, ALL) for v in (1.0, 2.0, 3.0)))).attrs["sentence"]
    assert lowest.endswith(", the lowest computed value")


def test_sentences_while_it_is_not_complete_or_without_a_target(plan: Plan) -> None:
    low, high = 100 * 0.025 ** (1 / 64), 100 * (1 - 0.025 ** (1 / 64))
    none, every = f"0 to {high:.3g} %", f"{low:.3g} to 100 %"
    part = dataset(plan, found(point(1.0, NONE), point(2.0, ALL)))
    assert part.attrs["sentence"].startswith(f"with 95 % confidence {none} of the starts end as compensated or passed at ")
    assert f", {every} at " in part.attrs["sentence"] and part.wucht.summary["smallest"] is None
    assert warnings_of(part)[0].startswith("1 of the 3 values of ")
    one = dataset(plan, found(point(1.0, NONE)))
    assert every not in one.attrs["sentence"] and one.attrs["sentence"].count(" at ") == 1
    assert dataset(plan, Findings()).attrs["sentence"] == ""
    assert report(titled(dataset(plan, Findings())))[1] == "verdict: nothing is computed yet"
    never = dataset(plan, found(*(point(v, NONE) for v in (1.0, 2.0, 3.0))))
    assert never.attrs["sentence"].startswith("0.5 is not reached up to ") and never.attrs["sentence"].count(none) == 1


def test_runs_without_a_verdict_are_told_where_they_are_most(plan: Plan) -> None:
    two = ["unidentified", "failed", "captured", "passed"] * 16
    free = replace(plan, spec=plan.spec.model_copy(update={"until": None}))
    points = point(1.0, MIXED), point(2.0, two), point(3.0, ALL)
    (told,) = (w for w in warnings_of(dataset(plan, found(*points))) if "no verdict" in w)
    assert told.startswith("up to 50 % of the runs (at ") and plan.along.value_text(2.0, 5) in told
    assert told.endswith("; a longer study.until may identify them")
    (told,) = (w for w in warnings_of(dataset(free, found(*points))) if "no verdict" in w)
    assert told.endswith("which widens the band")


def test_failures_have_their_places(plan: Plan) -> None:
    """Of the first value two, of the sensitivity two: three are told with the numbers of their own samples."""
    cross = np.stack([np.arange(100.0, 110.0), np.arange(200.0, 210.0)])
    with_cross = replace(plan, at=2.0, cross=cross)
    nothing = np.full(2, np.nan)
    made = found(
        point(1.0, OPEN, failures=((3, "it burst"), (5, "it melted"))), point(2.0, ALL), point(3.0, ALL),
        cross=members(["failed"] * 10, ((7, "it froze"), (8, "it froze"))), indices=Indices(*[nothing] * 4, 2, 8),
    )  # fmt: skip
    result = dataset(with_cross, made)
    told = [w for w in warnings_of(result) if "failed" in w]
    a, b = plan.samples[:, 3], plan.samples[:, 5]
    at = [plan.along.value_text(v, 5) for v in (1.0, 1.0, 2.0)]
    assert told == [
        f"the run at {at[0]}, psi = {a[0]:.6g}, delta = {a[1]:.6g} failed: it burst",
        f"the run at {at[1]}, psi = {b[0]:.6g}, delta = {b[1]:.6g} failed: it melted",
        f"the run at {at[2]}, psi = 107, delta = 207 failed: it froze", "1 more runs failed",
    ]  # fmt: skip
    assert result.wucht.summary["runs"] == 3 * 64 + 10
    assert any(w.startswith("75 % of the sensitivity's points have runs without a verdict") for w in warnings_of(result))
    assert any("no random quantity matters there" in w for w in warnings_of(result))
    assert result.wucht.summary["sensitivity"] == {"at": 2.0, "runs": 10, "used": [2, 8], "indices": None}
    assert any(line.endswith("no random quantity matters: all runs have the same outcome") for line in report(titled(result)))


def test_indices_in_the_dataset_and_the_report(plan: Plan) -> None:
    """The most influential first."""
    columns = (np.array([0.1, 0.4]), np.array([0.01, 0.04]), np.array([0.2, 0.75]), np.array([0.02, 0.05]))
    made = found(point(1.0, ALL), indices=Indices(*columns, 8, 8), cross=members(ALL))
    result = titled(dataset(replace(plan, at=2.0, cross=np.zeros((2, 64))), made))
    for name, values in zip(("first_order", "first_order_off", "total", "total_off"), columns, strict=True):
        assert result[name].values == pytest.approx(values)
    assert result.quantity.values.tolist() == ["psi", "delta"]
    assert result.wucht.summary["sensitivity"]["indices"]["delta"] == {
        "first_order": 0.4, "first_order_off": 0.04, "total": 0.75, "total_off": 0.05,
    }  # fmt: skip
    lines = [line.strip() for line in report(result)]
    first = lines.index("delta: 0.40 ± 0.04 alone, 0.75 ± 0.05 with interactions")
    assert lines[first + 1] == "psi: 0.10 ± 0.01 alone, 0.20 ± 0.02 with interactions"
    assert not any("left out of the indices" in w for w in warnings_of(result))


def test_the_lines_of_the_report(plan: Plan) -> None:
    points = point(1.0, OPEN), point(1.5, MIXED, True), point(2.0, ALL), point(3.0, ALL)
    lines = report(titled(dataset(plan, found(*points))))
    low, high = (100 * x for x in (points[1].bounds.low, points[1].bounds.high))
    assert lines[2:8] == [
        "  random       psi uniform: low 0.0, high 6.0", "               delta normal: mean 1.0, deviation 0.1",
        "  probability  u = 1: not known (0 to 100 %), 100 % without a verdict",
        f"               u = 1.5: 66.7 % ({low:.3g} to {high:.3g} %), 25 % without a verdict",
        f"               u = 2: 100 % ({100 * points[2].bounds.low:.3g} to 100 %)",
        f"               u = 3: 100 % ({100 * points[3].bounds.low:.3g} to 100 %)",
    ]  # fmt: skip
    assert lines[8] == "  runs         256: 64 at each of 4 values, 1 of them for the search"


@pytest.mark.parametrize(("states", "word"), [
    ([object(), object()], "starts"), ([None, None], "machines"), ([object(), None], "runs"),
])  # fmt: skip
def test_what_is_counted(states: list[Any], word: str) -> None:
    some: Any = SimpleNamespace(random_quantities=[SimpleNamespace(state=s) for s in states])
    assert _sample_word(some) == word


def test_distributions_in_words() -> None:
    cut = {"between": ["1 mm", "4 mm"], "normal": ["2 mm", "1 mm"]}
    assert _distribution_in_words(cut) == "normal: mean 2 mm, deviation 1 mm, between 1 mm and 4 mm"
    assert _distribution_in_words({"triangular": [0, 1, 3]}) == "triangular: low 0, mode 1, high 3"


def test_shares_of_the_work(plan: Plan) -> None:
    """Three values of 64 runs; the search two fifths of them; the sensitivity as many as it has."""
    assert computation._shares(plan) == pytest.approx((1 / 1.4, 1.0, 1.0))
    with_cross = replace(planned(), cross=np.zeros((2, 64)))
    assert computation._shares(with_cross) == pytest.approx((0.75, 0.75, 1.0))


def test_a_distribution_that_reaches_what_the_machine_forbids() -> None:
    random = {"psi": {"uniform": [0.0, 6.0]}, "sigma": {"uniform": [1.0, 2.0]}}
    assert planned(random=random).samples[1].min() >= 1.0
    with refused("study.random.sigma", "between"):
        planned(random=random | {"sigma": {"uniform": [-0.5, 1.0]}})


@pytest.mark.parametrize(("key", "low", "high"), [("samples", 64, 2**20), ("points", 2, 1000)])
def test_numbers_that_are_allowed(key: str, low: int, high: int) -> None:
    given = {"along": "u", "range": [1.0, 3.0], "random": RANDOM, "model": "slow"}
    for value in (low, high):
        assert getattr(CaptureProbability(**given | {key: value}), key) == value
    step = 16 if key == "samples" else 1
    for value in (low - step, high + step):
        with refused(f"study.{key}", given=value):
            CaptureProbability(**given | {key: value})


def test_samples_that_are_no_power_of_two_are_warned_of() -> None:
    assert not any("power of two" in w for w in planned(samples=128).warnings)
    (told,) = (w for w in planned(samples=112).warnings if "power of two" in w)
    assert told.endswith("with 64 or 128")
