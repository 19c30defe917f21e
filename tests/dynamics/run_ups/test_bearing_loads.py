"""Loads of bearings in run-ups, called with a machine and plain numbers: two methods, and forces in closed form."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from wucht import Machine, parts
from wucht.dynamics.run_ups.bearing_loads import (
    BearingLife,
    heavy_load_warnings,
    lives_at_end,
    lives_of,
    loads_at_end,
)
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import rotor_signal
from wucht.dynamics.run_ups.observed_loads import load_histories
from wucht.dynamics.run_ups.run_up import RunUpCase, run_to_end
from wucht.dynamics.work import Work

UNBALANCE, MASS, SPEED, GRAVITY = 0.02, 3.0, 50.0, 9.81


def shaft(directions: str = "fixed", **bearing: Any) -> Machine:
    stiff = {} if directions == "fixed" else {"stiffness": 1e9}
    drum = parts.Rotor(name="drum", mass=MASS, unbalance=UNBALANCE, inertia=0.1, bearing=bearing or None)
    carrier = parts.Carrier(mass=1e9, directions=directions, gravity=GRAVITY, **stiff)
    return Machine(carrier, [drum], [parts.ConstantSpeed(speed=SPEED)])


def magnitudes() -> np.ndarray:
    """|U w^2 e(phi) - m g e_y| over a turn."""
    angle = 2 * np.pi * np.arange(10_000) / 10_000
    size: np.ndarray = np.hypot(UNBALANCE * SPEED**2 * np.cos(angle), UNBALANCE * SPEED**2 * np.sin(angle) - MASS * GRAVITY)
    return size


@pytest.mark.parametrize("directions", ["fixed", "y"])
def test_a_rotating_force_and_the_weight(directions: str) -> None:
    """50 N go round, 29.4 N hang: between 20.6 and 79.4 N, with the mean -29.4 N in y."""
    machine = shaft(directions, C=1000.0, p=3.0)
    motion = run_to_end(machine, {}, RunSettings(until=4.0))
    window = motion.verdict.window
    turns = (window[1] - window[0]) * SPEED / (2 * math.pi)
    assert turns == pytest.approx(round(turns), abs=1e-6)
    (load,) = loads_at_end(machine, motion.machine_motion, window).values()
    size = magnitudes()
    assert load.steady == pytest.approx(size.mean(), rel=1e-3)
    assert load.vector == pytest.approx((0.0, -MASS * GRAVITY), abs=0.05)
    assert load.largest == pytest.approx(size.max(), rel=1e-3) and load.peak == pytest.approx(load.largest, rel=1e-4)
    (life,) = lives_at_end(machine, motion.machine_motion, window).values()
    equivalent = (size**3).mean() ** (1 / 3)
    assert life.load == pytest.approx(equivalent, rel=1e-3)
    assert life.hours == pytest.approx((1000.0 / equivalent) ** 3 * 1e6 * 2 * math.pi / SPEED / 3600, rel=3e-3)


def test_a_share_of_the_force_lives_longer() -> None:
    """Half the force: eight times the life, and with 10/3 the tenfold."""
    for p, factor in ((3.0, 8.0), (10 / 3, 2 ** (10 / 3))):
        lives = []
        for share in (1.0, 0.5):
            machine = shaft(C=1000.0, p=p, share=share)
            motion = run_to_end(machine, {}, RunSettings(until=1.0))
            lives.append(lives_at_end(machine, motion.machine_motion, motion.verdict.window)["drum"])
        assert lives[1].load == pytest.approx(0.5 * lives[0].load, rel=1e-12)
        assert lives[1].hours == pytest.approx(factor * lives[0].hours, rel=1e-9)


def test_a_speed_of_two_levels() -> None:
    """2 s at 40 rad/s, 2 s at 80, and a second between them: U w^2 inward and U w' across, over the angle."""
    points = [[0.0, 40.0], [2.0, 40.0], [3.0, 80.0], [5.0, 80.0]]
    drum = parts.Rotor(name="drum", mass=MASS, unbalance=UNBALANCE, inertia=0.1, bearing={"C": 1000.0})
    carrier, schedule = parts.Carrier(mass=1.0, directions="fixed"), {"parameter": "drive.speed", "points": points}
    machine = Machine(carrier, [drum], [parts.ConstantSpeed(speed=40.0)], schedules=[schedule])
    case = RunUpCase.of(machine, {}, RunSettings(until=5.0))
    *_, last = load_histories(case, rotor_signal(machine, "drum", None), Work(), bearings_from=0.0)
    ramp = np.linspace(40.0, 80.0, 10_001)  # over a second: 40 rad/s^2
    on_ramp = float((np.hypot(UNBALANCE * ramp**2, UNBALANCE * 40.0) ** 3 * ramp).mean())
    power = 2 * 40.0 * (UNBALANCE * 40.0**2) ** 3 + on_ramp + 2 * 80.0 * (UNBALANCE * 80.0**2) ** 3
    life = lives_of(machine, last.duties)["drum"]
    assert life.load == pytest.approx((power / 300.0) ** (1 / 3), rel=2e-4)
    assert life.hours == pytest.approx((1000.0 / life.load) ** 3 * 1e6 / (300.0 / (2 * math.pi) / 5.0) / 3600, rel=2e-4)


def test_what_iso_281_does_not_cover() -> None:
    lives = {"a": BearingLife(501.0, 10.0, 1000.0), "b": BearingLife(500.0, 10.0, 1000.0), "c": BearingLife(None, None, 1.0)}
    (warning,) = heavy_load_warnings(lives)
    assert "'a', 501 N, is more than half of its rating C = 1000 N" in warning
