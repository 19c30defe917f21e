"""The turning points of a machine's signals against the forced vibration in closed form."""

from __future__ import annotations

import numpy as np
import pytest

from wucht import Machine, parts
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.machine_signals import machine_signal
from wucht.dynamics.run_ups.observed_loads import load_histories
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
