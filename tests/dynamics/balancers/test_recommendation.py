"""Which balancer is recommended, whether it or the motor sets the settling time, and what chance explains."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.balancers import candidates
from wucht.dynamics.balancers.balancer_candidate import BalancerCandidate
from wucht.dynamics.balancers.candidates import CAPTURE, PEAK, RESIDUAL, SETTLING, CandidateResults
from wucht.dynamics.balancers.damping_optimum import damping_curve
from wucht.dynamics.balancers.recommendation import failing_shares, motor_sets, motor_time
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.files.building import machine_from
from wucht.machines.machine import Machine


def outcomes(**shares: float) -> np.ndarray:
    return np.array([shares.get(str(o).replace("-", "_"), 0.0) for o in OUTCOMES])


def test_what_fails() -> None:
    """All that is not compensated; runs without a verdict perhaps."""
    assert failing_shares(outcomes(compensated=0.75, passed=0.125, unidentified=0.0625, failed=0.0625)) == (0.125, 0.25)
    assert failing_shares(outcomes(compensated=1.0)) == (0.0, 0.0)


@pytest.mark.parametrize(("compensated", "balances"), [(0.5, False), (0.5625, True)])
def test_a_balancer_balances_more_than_half_of_its_runs(compensated: float, balances: bool) -> None:
    shares = outcomes(compensated=compensated, passed=1 - compensated)
    results = replace(CandidateResults.unknown(1, 1, 16), outcomes=shares[None])
    assert BalancerCandidate(2, np.zeros(1), results).balances is balances


def machine(**more: Any) -> Machine:
    return machine_from(
        {
            "carrier": {"mass": 1.0, "stiffness": 1e5, "damping": 200.0},
            "bodies": [
                {"kind": "rotor", "name": "drum", "mass": 9.0, "eccentricity": 1e-4, "inertia": 0.03},
                {"kind": "pendulum", "name": "p", "about": "drum", "mass": 0.01, "length": 0.1, "damping": 0.01},
            ],
            "drive": {"on": "drum", "kind": "linear", "slope": 0.01, "no_load_speed": 200.0},
        }
        | more
    )


@pytest.mark.parametrize(("begin", "ratio"), [(0.0, 200.0), (100.0, 100.0), (199.5, None)])
def test_the_time_of_the_motor_in_closed_form(begin: float, ratio: float | None) -> None:
    """J dw/dt = k (w0 - w): within 0.5 % of w0 after J/k ln(ratio); the pendulum's m l^2 turns with the drum.

    To the 2 % of the engine's sum over speeds.
    """
    time = 0.0 if ratio is None else 0.0301 / 0.01 * math.log(ratio)
    assert motor_time(machine(), {"drum": {"speed": begin}}) == pytest.approx(time, rel=2e-2, abs=1e-12)


def test_a_run_up_takes_as_long() -> None:
    """Of a drum that is hardly unbalanced, whose resonance costs little."""
    settling = run_to_end(machine(), {}, RunSettings()).verdict.settling_time
    assert settling == pytest.approx(motor_time(machine(), {}), rel=0.05)


def test_a_schedule_and_a_prescribed_speed() -> None:
    ramp = {"parameter": "drive.no_load_speed", "points": [[0.0, 0.0], [50.0, 200.0]], "interpolation": "linear"}
    assert motor_time(machine(schedules=[ramp]), {}) == 50.0
    assert motor_time(machine(drive={"on": "drum", "kind": "constant-speed", "speed": 200.0}), {}) == 0.0


@pytest.mark.parametrize(
    ("time", "settling", "sets"),
    [(7.9, 10.0, False), (8.0, 10.0, True), (20.0, 10.0, True), (0.0, 0.0, False), (0.0, 10.0, False), (8.0, None, False)],
)
def test_when_the_motor_sets_the_settling_time(time: float, settling: float | None, sets: bool) -> None:
    assert motor_sets(time, settling) is sets


SEARCH = replace(CandidateResults.unknown(1, 1, 8), objectives=np.array([[10.0, 0.0, 1e-3, 0.0]]), error=np.array([0.4]))


@pytest.mark.parametrize(
    ("column", "within", "beyond"),
    [
        (SETTLING, 10 + 1.0 + 2.6 * np.hypot(0.4, 0.3) - 1e-6, 10 + 1.0 + 2.6 * np.hypot(0.4, 0.3) + 1e-6),
        (RESIDUAL, 0.99e-2 * 8e-3, 1.01e-2 * 8e-3),
        (PEAK, 1.19e-3, 1.21e-3),
        (CAPTURE, 19 / 32, 20 / 32),
    ],
)
def test_chance_explains_some_of_the_difference(column: int, within: float, beyond: float) -> None:
    """A tenth of the time and 2.6 standard errors, a hundredth of the unbalance, a fifth of the peak; of a share, one run and
    2.6 standard deviations of the difference of a share of 8 and one of 32."""
    for seen, is_off in ((within, False), (beyond, True), (np.nan, True)):
        objectives = SEARCH.objectives.copy()
        objectives[0, column] = seen
        check = replace(SEARCH, objectives=objectives, error=np.array([0.3]))
        off = BalancerCandidate(2, np.zeros(1), SEARCH, check).deviations(8e-3, 8) > 1
        assert off.tolist() == [is_off and k == column for k in range(4)]


PASSED, CAPTURED, OPEN = (OUTCOMES.index(o) for o in (Outcome.COMPENSATED, Outcome.CAPTURED, Outcome.UNIDENTIFIED))


def test_the_curve_over_the_damping() -> None:
    """Where fewer runs pass its settling times are drawn, but are not the shortest."""
    objectives = np.column_stack([[1.0, 3.0, 4.0], np.zeros(3), np.zeros(3), [0.5, 0.25, 0.25]])
    dampings = np.array([0.1, 0.2, 0.3])
    results = replace(CandidateResults.unknown(3, 1, 4), numbers=dampings[:, None], objectives=objectives)
    curve = damping_curve(dampings, results, (np.array([7.0, 8.0, 9.0]), 0.25))
    assert (curve.settling_time.tolist(), curve.share_through.tolist()) == ([1.0, 3.0, 4.0], [0.5, 0.75, 0.75])
    assert (curve.rate.tolist(), curve.optimum, curve.rate_optimum) == ([7.0, 8.0, 9.0], 0.2, 0.25)
    assert curve.damping.tolist() == dampings.tolist()


def median(outcomes: list[int], settling: list[float], end: float = 50.0) -> tuple[float, float]:
    n = len(outcomes)
    return candidates._median_settling(MemberOutcomes(np.array(outcomes), np.array(settling), np.zeros(n), np.full(n, end)))


def test_a_median_settling_time() -> None:
    """Of all runs, those that are captured take for ever; one without a verdict as long as it was followed."""
    failed = OUTCOMES.index(Outcome.FAILED)
    assert median([PASSED] * 3, [1.0, 3.0, 8.0])[0] == 3.0
    assert median([PASSED, PASSED, CAPTURED], [1.0, 3.0, np.nan])[0] == 3.0
    assert np.isnan(median([PASSED, CAPTURED, CAPTURED], [1.0, np.nan, np.nan])).all()
    assert median([PASSED, OPEN, OPEN], [1.0, np.nan, np.nan]) == (
        50.0, pytest.approx(math.sqrt(math.pi / 2) * np.std([1.0, 50.0, 50.0]) / math.sqrt(3)),
    )  # fmt: skip
    assert np.isnan(median([OPEN] * 3, [np.nan] * 3)).all(), "none has passed"
    assert np.isnan(median([PASSED, PASSED, failed], [1.0, 3.0, np.nan])).all()
