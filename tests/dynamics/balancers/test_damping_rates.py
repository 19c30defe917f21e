"""The damping with the greatest rate of decay, from rates that are known."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.balancers import damping_optimum as module
from wucht.errors import InputError

DAMPINGS = np.geomspace(0.1, 10.0, 9)


def rates(patch: pytest.MonkeyPatch, rate: Any) -> Any:
    patch.setattr(module, "states_at_speed", lambda machine: ("states", machine))
    patch.setattr(module, "decay_rate", lambda machine, states: rate(machine) if states == ("states", "m") else None)
    return module.decay_rates(SimpleNamespace(machine="m", candidate_machine=lambda values: values[0]), DAMPINGS)  # type: ignore[arg-type]


def test_the_greatest_rate_is_at_its_corner(monkeypatch: pytest.MonkeyPatch) -> None:
    found, greatest_at = rates(monkeypatch, lambda b: min(b, 4 / b))
    assert found == pytest.approx(np.minimum(DAMPINGS, 4 / DAMPINGS))
    assert greatest_at == pytest.approx(2.0, rel=2e-3)


def test_it_may_be_at_an_end(monkeypatch: pytest.MonkeyPatch) -> None:
    assert rates(monkeypatch, lambda b: b)[1] == pytest.approx(10.0)
    assert rates(monkeypatch, lambda b: -b)[1] == pytest.approx(0.1)
    assert np.isnan(rates(monkeypatch, lambda b: np.nan)[1])


def test_without_averaged_equations_there_is_no_rate(monkeypatch: pytest.MonkeyPatch) -> None:
    def none(_: Any) -> None:
        raise InputError("machine", None, "has none")

    monkeypatch.setattr(module, "states_at_speed", none)
    found, greatest_at = module.decay_rates(SimpleNamespace(machine="m"), DAMPINGS)  # type: ignore[arg-type]
    assert found.shape == (9,) and np.isnan(found).all() and np.isnan(greatest_at)
