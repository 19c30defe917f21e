"""When a motion has settled, of motions that are given: from when on its speed stays where it ends."""

from __future__ import annotations

import math

import numpy as np
import pytest

from wucht import RunUp, report, run
from wucht.dynamics.verdicts.judging import judge
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver
from wucht.dynamics.verdicts.outcomes import AMPLITUDE_TOLERANCE, Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.files.building import machine_from
from wucht.machines.machine import Machine
from wucht.numerics.observers.turns import Samples

FREE = 200.0
MARGIN = 0.005 * FREE
TIME = np.linspace(0.0, 60.0, 60_001)
BEGIN = 20.0
TURN = 2 * math.pi / 80


def _verdict(speed: np.ndarray, sense: float) -> Verdict:
    """On a motion with this speed (N,) over ``TIME``, turning so, of a machine with its resonance at 100 rad/s."""
    machine = machine_from({
        "carrier": {"stiffness": 1e5, "damping": 200.0},
        "bodies": [{"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.03}],
        "drive": {"kind": "linear", "slope": 0.04, "no_load_speed": sense * FREE},
    })  # fmt: skip
    angle = np.append(0.0, np.cumsum((speed[:-1] + speed[1:]) / 2 * np.diff(TIME)))
    watch = MotionObserver(machine, 2 * math.pi / FREE, Noise.of())
    return judge(
        machine, watch.update_from_samples(watch.begin(), Samples.of(TIME, (sense * angle, sense * speed))), sense * FREE
    )


@pytest.mark.parametrize("period", [1.5, 4.0])
@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_modulated_motion_has_settled_one_period_after_its_range_was_last_left(period: float, sense: float) -> None:
    """Sped up evenly until it beats between 85 and 95 rad/s: from 84 rad/s on it is within that range, widened by 1 rad/s."""
    beat = 90 + 5 * np.sin(2 * math.pi / period * (TIME - BEGIN))
    verdict = _verdict(np.where(TIME < BEGIN, 90 * TIME / BEGIN, beat), sense)
    assert verdict.outcome is Outcome.CAPTURED_MODULATED
    assert verdict.settling_time == pytest.approx(BEGIN * (85 - MARGIN) / 90 + period, abs=2 * TURN)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_steady_motion_has_settled_where_its_speed_was_last_left(sense: float) -> None:
    """Sped up evenly to 90 rad/s: from 89 rad/s on."""
    verdict = _verdict(90 * np.minimum(TIME / BEGIN, 1.0), sense)
    assert verdict.outcome is Outcome.CAPTURED
    assert verdict.settling_time == pytest.approx(BEGIN * (90 - MARGIN) / 90, abs=2 * TURN)


def test_a_motion_that_leaves_its_range_again_has_settled_after_that() -> None:
    """At 30 s it falls to 70 rad/s for a tenth of a second."""
    beat = 90 + 5 * np.sin(2 * math.pi / 1.5 * TIME)
    verdict = _verdict(np.where(np.abs(TIME - 30) < 0.05, 70.0, beat), 1.0)
    assert verdict.outcome is Outcome.CAPTURED_MODULATED
    assert verdict.settling_time == pytest.approx(30.05 + 1.5, abs=2 * TURN)


def at_constant_speed(damping: float) -> Machine:
    """At 200 rad/s, beyond the resonance."""
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": damping},
        "bodies": [{"kind": "rotor", "name": "d", "mass": 1.0, "unbalance": 1e-3, "inertia": 0.1}],
        "drive": {"kind": "constant-speed", "speed": 200.0},
    })  # fmt: skip


@pytest.mark.parametrize(("until", "settled"), [(2.4, False), (2.8, True)])
def test_an_amplitude_that_still_changes_has_not_settled(until: float, settled: bool) -> None:
    """It is within its limits from 2.44 s on, by the test below; after 2.8 s for more than two windows of 0.14 s."""
    summary = run(RunUp(until=until), at_constant_speed(4.0)).wucht.summary
    assert (summary["amplitude_settling_time"] is not None) is settled
    assert summary["settling_time"] < 0.1


@pytest.mark.parametrize("damping", [4.0, 8.0])
def test_the_amplitude_settles_later_than_the_speed(damping: float) -> None:
    """At constant speed the axis, at rest at first, moves by r (exp(i w t) - exp(-d t) (cos v t + (d + i w)/v sin v t)).

    r = U w^2/(k - M w^2 + i c w), d = c/2M, v^2 = k/M - d^2; the largest distance over a turn, here of that formula.
    """
    mass, stiffness, unbalance, speed = 2.0, 1e4, 1e-3, 200.0
    result = run(RunUp(until=8.0), at_constant_speed(damping))
    summary = result.wucht.summary
    t = np.linspace(0.0, 8.0, 400_001)
    decay = damping / (2 * mass)
    natural = math.sqrt(stiffness / mass - decay**2)
    free = np.exp(-decay * t) * (np.cos(natural * t) + (decay + 1j * speed) / natural * np.sin(natural * t))
    steady = unbalance * speed**2 / (stiffness - mass * speed**2 + 1j * damping * speed)
    distance = np.abs(steady * (np.exp(1j * speed * t) - free))
    settled = t[np.abs(distance - abs(steady)) > 0.01 * distance.max()].max()
    assert settled > 2.0
    assert summary["amplitude_settling_time"] == pytest.approx(settled, abs=2 * 2 * math.pi / speed)
    assert summary["settling_time"] < 0.1
    line = next(x for x in report(result) if "settled at" in x)
    times = f"{summary['settling_time']:.4g} s; the amplitude at {summary['amplitude_settling_time']:.4g} s"
    assert line == f"  settled at   {times}", "the settling time that comparisons show comes first"


def test_where_a_ball_lags_only_the_speed_has_settled() -> None:
    """A ball in thin oil stays at the resonance of 100 rad/s while the rotor turns at 300 rad/s: the amplitude beats on."""
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 4.0},
        "bodies": [
            {"kind": "rotor", "name": "d", "mass": 0.1, "unbalance": 1e-4, "inertia": 0.01},
            {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.01, "length": 0.01, "damping": 1e-8},
        ],
        "drive": {"on": "d", "kind": "constant-speed", "speed": 300.0},
    })  # fmt: skip
    result = run(RunUp(until=20.0, start={"p": {"angle": 0.3, "speed": 90.0}}), machine)
    summary = result.wucht.summary
    assert summary["outcome"] == "balancer-captured"
    assert summary["amplitude_settling_time"] is None
    assert summary["max_amplitude"] > (1 + 2 * AMPLITUDE_TOLERANCE) * summary["min_amplitude"]
    assert any(line.endswith(" s, the speed") for line in report(result) if "settled at" in line)
