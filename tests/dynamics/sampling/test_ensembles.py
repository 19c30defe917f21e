"""Where members begin: as a study file of each would say it."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import varied_quantity
from wucht.dynamics.sampling.ensembles import initial_states, start_at
from wucht.files.catalogue import load_machine


@pytest.mark.parametrize(
    ("name", "start", "names"),
    [
        ("drozdetskaya-2020/table-5.1", {"rotor": {"speed": 0.3}}, ("psi", "delta")),
        ("drozdetskaya-2020/table-5.1", {"p2": 1.0, "carrier": {"x": 0.2}}, ("rotor", "p1.speed", "carrier.vy")),
        ("sperling-rollers/table-1", {}, ("r1", "r2.speed", "carrier.x")),
    ],
)
def test_many_begin_as_each_alone(name: str, start: dict[str, object], names: tuple[str, ...]) -> None:
    machine = load_machine(name)
    varied = [varied_quantity(machine, n, "axes") for n in names]
    places = np.random.default_rng(1).uniform(-5.0, 5.0, (len(names), 7))
    states, values = initial_states(machine, start, varied, places, "study")
    assert not values
    for m, place in enumerate(places.T.tolist()):
        alone = initial_state(machine, start_at(start, varied, place))
        np.testing.assert_allclose(states[:, m], alone, rtol=0, atol=4e-15)
        assert (states[:, m] != states[:, (m + 1) % 7]).sum() >= 2
