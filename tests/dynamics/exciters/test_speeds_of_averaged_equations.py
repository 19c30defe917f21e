"""The mean speed by the averaged equations, from steady states that are known by heart."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.exciters import speed_readings as module
from wucht.dynamics.exciters.speed_readings import STEADY, UNSTABLE, AveragedSpeed, averaged_speed
from wucht.errors import InputError

MACHINE: Any = SimpleNamespace(rotor=SimpleNamespace(name="drum"))


def known(
    patch: pytest.MonkeyPatch, near: float, states: dict[float, bool | None], sense: float = 1.0, given: float | None = None
) -> AveragedSpeed:
    """states: speeds and whether they are stable."""
    slow = SimpleNamespace(senses={"drum": sense})
    patch.setattr(module, "machine_at_speed", lambda machine, speed: machine)
    patch.setattr(module, "averaged_equations_of", lambda machine, inertia: slow)
    patch.setattr(module.SteadyTorques, "from_averaged_equations", lambda _: SimpleNamespace(fixed_speed=given))
    patch.setattr(module, "driven_speeds", lambda _: ((1.0, 300.0), False))
    some = [SimpleNamespace(speed=speed) for speed in states]
    patch.setattr(
        module, "all_states", lambda torques, low, high: SimpleNamespace(states=some if (low, high) == (1.0, 300.0) else [])
    )
    stable = SimpleNamespace(stability=lambda state: SimpleNamespace(stable=states[state.speed]))
    patch.setattr(module, "AveragedStability", lambda *_: stable)
    return averaged_speed(MACHINE, near, False, np.empty(0), (1.0, 1.0), 1e-10, None)


@pytest.mark.parametrize(
    ("near", "sense", "states", "expected"),
    [
        (95.0, 1.0, {90.0: True, 110.0: True}, AveragedSpeed(90.0, STEADY)),
        (105.0, 1.0, {90.0: True, 110.0: True}, AveragedSpeed(110.0, STEADY)),
        (-105.0, -1.0, {90.0: True, 110.0: True}, AveragedSpeed(-110.0, STEADY)),
        (105.0, 1.0, {90.0: False, 110.0: None}, AveragedSpeed(110.0, STEADY)),
        (95.0, 1.0, {90.0: False, 110.0: True, 200.0: True}, AveragedSpeed(90.0, UNSTABLE, next_stable=110.0)),
        (-95.0, -1.0, {90.0: False, 110.0: True}, AveragedSpeed(-90.0, UNSTABLE, next_stable=-110.0)),
        (95.0, 1.0, {90.0: False, 110.0: False}, AveragedSpeed(90.0, UNSTABLE)),
        (95.0, 1.0, {}, AveragedSpeed(None, reason="the averaged equations have no steady state")),
    ],
)
def test_the_steady_state_that_is_nearest(
    monkeypatch: pytest.MonkeyPatch, near: float, sense: float, states: dict[float, bool | None], expected: AveragedSpeed
) -> None:
    assert known(monkeypatch, near, states, sense) == expected


def test_where_there_is_none(monkeypatch: pytest.MonkeyPatch) -> None:
    prescribed = AveragedSpeed(None, reason="the drive prescribes the speed")
    assert known(monkeypatch, 95.0, {90.0: True}, given=100.0) == prescribed

    def none(*_: Any) -> None:
        raise InputError("machine", None, "has none")

    monkeypatch.setattr(module, "averaged_equations_of", none)
    found = averaged_speed(MACHINE, 95.0, False, np.empty(0), (1.0, 1.0), 1e-10, None)
    assert found == AveragedSpeed(None, reason="machine: has none")
    model = SimpleNamespace(system=None, initial=None, parameter_values=None)
    monkeypatch.setattr(module, "slow_model", lambda *_: model)
    monkeypatch.setattr(module, "compile_system", lambda *_: None)
    motion = SimpleNamespace(reraise_interrupt=lambda: SimpleNamespace(failure="it burst"))
    monkeypatch.setattr(module, "integrate", lambda *_: motion)
    assert averaged_speed(MACHINE, 95.0, True, np.empty(0), (1.0, 1.0), 1e-10, None) == AveragedSpeed(None, reason="it burst")
