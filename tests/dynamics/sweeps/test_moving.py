"""What is read off a leg of a machine whose parameter is moved or held."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sweeps import moving
from wucht.dynamics.sweeps.moving import Mover, Place
from wucht.numerics.observers.energy_balance import EnergyBalance


def test_the_energy_that_is_missing_is_that_at_the_end_of_a_leg(monkeypatch: pytest.MonkeyPatch) -> None:
    """A rotor at a steady speed, whose balance is off by more from sample to sample."""
    phi, omega = (SimpleNamespace(name=name) for name in ("phi", "omega"))
    coordinate = SimpleNamespace(position=phi, velocity=omega, prescribed_velocity=None)
    machine = SimpleNamespace(rotor=SimpleNamespace(coordinate=coordinate), rotors=(), with_unchecked_values=lambda _: None)
    moved = SimpleNamespace(machine=machine, path="p", pace=SimpleNamespace(fastest=10.0), energy=1.0)
    compiled = SimpleNamespace(system=SimpleNamespace(state_names=("phi", "omega"), states=(phi, omega), quadratures=()))

    def run(_: Any, grid: np.ndarray, state: np.ndarray, parameters: np.ndarray) -> Any:
        return SimpleNamespace(time=grid, end_state=state, final_parameter_values=parameters, quadratures={})

    def rows(_: Any, t: Any) -> dict[str, np.ndarray]:
        return {"phi": 10 * t.time, "omega": np.full(len(t.time), 10.0), "stored_energy": np.zeros(len(t.time))}

    monkeypatch.setattr(Mover, "_run", run)
    monkeypatch.setattr(moving, "rows_of", rows)
    monkeypatch.setattr(moving, "advance_balance", lambda balance, stored, _: (balance, np.linspace(0.0, 3e-9, len(stored))))
    monkeypatch.setattr(moving, "axis_at_rest", lambda _: None)
    monkeypatch.setattr(moving.AxisMotion, "of", lambda *_: SimpleNamespace(peaks=np.array([0.25])))
    moved.compiled_system = compiled
    mover = Mover(moved, lambda _: None)  # type: ignore[arg-type]
    leg = mover.leg(Place(1.0, 5.0, (0.0, 10.0), (0.0, 0.0, 0.0), EnergyBalance()), 2.0, 6.0)
    assert leg.energy_residual == 3e-9
    assert (leg.place.time, leg.place.value, leg.speed, leg.amplitude) == (3.0, 6.0, pytest.approx(10.0), 0.25)
    assert 5.0 < leg.value < 6.0
