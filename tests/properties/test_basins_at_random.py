"""What becomes of a start: whichever of two equal pendulums is called the first, and wherever the rotor begins."""

from __future__ import annotations

import math
from typing import Literal

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_run import outcomes_of
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.files.catalogue import load_machine


@pytest.mark.parametrize(
    ("model", "u"),
    [
        ("slow", 1.0),
        pytest.param("slow", 2.5, marks=pytest.mark.slow),
        pytest.param("full", 2.5, marks=pytest.mark.slow),
        pytest.param("full", 3.0, marks=pytest.mark.slow),
    ],
)
def test_equal_pendulums_may_be_exchanged(model: Literal["full", "slow"], u: float) -> None:
    """(psi, delta) -> (psi + pi, 2 pi - delta)."""
    machine, random = load_machine("drozdetskaya-2020/table-5.1", {"u": u}), np.random.default_rng(7)
    psi, delta = random.uniform(0, 2 * math.pi, (2, 100))
    pairs = [(psi, delta), (psi + math.pi, 2 * math.pi - delta)]
    starts = [
        np.array([initial_state(machine, {"psi": p, "delta": d}) for p, d in zip(*pair, strict=True)]).T for pair in pairs
    ]
    a, b = (outcomes_of(EnsembleQuestion(machine, model=model), each, {}) for each in starts)
    assert len(a.counts()) == 2
    assert np.array_equal(a.outcome, b.outcome)
    assert np.allclose(a.peak_amplitude, b.peak_amplitude, rtol=1e-3)
    turned = starts[0] + 0.7 * np.array([[name.endswith(".angle")] for name in machine.state_names])
    c = outcomes_of(EnsembleQuestion(machine, model=model), turned, {})
    assert np.array_equal(a.outcome, c.outcome)
