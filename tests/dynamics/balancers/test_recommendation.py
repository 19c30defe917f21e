"""Which balancer is recommended, and whether it or the motor sets the settling time."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.balancers.balancer_candidate import BalancerCandidate
from wucht.dynamics.balancers.candidates import CandidateResults
from wucht.dynamics.balancers.recommendation import failing_shares, motor_sets, motor_time
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.dynamics.verdicts.outcomes import OUTCOMES
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
