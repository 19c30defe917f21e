"""The turning points of a machine's signals, called with a machine and plain numbers, against the forced vibration by hand."""

from __future__ import annotations

import numpy as np
import pytest

from wucht import Machine, parts
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.observed_loads import LoadHistory, load_histories
from wucht.dynamics.run_ups.run_up import RunUpCase
from wucht.dynamics.work import Work

MASS, UNBALANCE, STIFFNESS, DAMPING, SPEED, SETTLED = 10.0, 9e-3, 1e5, 400.0, 80.0, 1.0


@pytest.mark.parametrize(
    ("name", "unit", "of_amplitude"),
    [("displacement", "m", 1.0), ("spring-force", "N", STIFFNESS), ("acceleration", "m/s^2", SPEED**2)],
)
def test_amplitudes_are_those_of_the_forced_vibration(name: str, unit: str, of_amplitude: float) -> None:
    """m e W^2/|c - M W^2 + i d W|, from the time on at which the free vibration, exp(-d t/2 M), is gone."""
    machine = Machine(
        parts.Carrier(mass=1.0, directions="x", stiffness=STIFFNESS, damping=DAMPING),
        [parts.Rotor(name="rotor", mass=MASS - 1, eccentricity=UNBALANCE / (MASS - 1), inertia=0.03)],
        drives=[parts.ConstantSpeed(speed=SPEED)],
    )
    case = RunUpCase.of(machine, {}, RunSettings(until=SETTLED + 1.0))
    signal = machine_signal(machine, name, None)
    *_, last = load_histories(case, signal, Work())
    values = last.values[last.time > SETTLED][:-1]  # the last one is where the run ends
    amplitude = UNBALANCE * SPEED**2 / abs(STIFFNESS - MASS * SPEED**2 + 1j * DAMPING * SPEED)
    assert (signal.unit, len(values)) == (unit, pytest.approx(2 * SPEED / (2 * np.pi), abs=1.5)), "two a turn"
    assert np.abs(values) == pytest.approx(np.full(len(values), of_amplitude * amplitude), rel=1e-4)


def test_of_a_long_history_200_intervals_have_their_mean_least_and_greatest_value() -> None:
    time = np.sort(np.random.default_rng(1).uniform(5.0, 25.0, 2000))
    time[0] = 5.0
    values = np.random.default_rng(2).standard_normal(2000)
    values[time > 20.0] += 3.0
    at, mean, low, high = LoadHistory(time, values, 25.0).course()
    middles = 5.0 + 0.1 * (np.arange(200) + 0.5)
    inside = [values[(time >= m - 0.05) & (time < m + 0.05)] for m in middles]
    present = [k for k, part in enumerate(inside) if len(part)]
    assert at == pytest.approx(middles[present])
    assert low == pytest.approx([inside[k].min() for k in present])
    assert high == pytest.approx([inside[k].max() for k in present])
    fine = 5.0 + 20.0 * (np.arange(400_000) + 0.5) / 400_000
    means = np.interp(fine, time, values).reshape(200, -1).mean(axis=1)
    assert mean == pytest.approx(means[present], abs=2e-3), "of straight lines through the turning points"
    assert all(len(x) == 1600 for x in LoadHistory(time[:1600], values[:1600], 25.0).course()), "few are listed"
