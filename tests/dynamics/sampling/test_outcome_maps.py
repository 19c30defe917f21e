"""Maps of outcomes: what the names of axes mean, where runs start, and in which units of work they are made."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import start_states, varied_quantity
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, initial_states
from wucht.dynamics.sampling.outcome_maps import MapAxis, OutcomeMap
from wucht.dynamics.sampling.outcome_runs import OutcomeRuns
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine

R1 = load_machine("drozdetskaya-2020/r1")
TURN = 2 * math.pi


def map_axis(machine: Machine, name: str, definition: Any) -> MapAxis:
    *ends, cells = definition
    return MapAxis.of(varied_quantity(machine, name, "axes"), ends, "axes", cells=cells, dimension=name)


def outcome_map(machine: Machine, axes: dict[str, Any], start: dict[str, Any] | None = None, **settings: Any) -> OutcomeMap:
    x, y = (map_axis(machine, name, definition) for name, definition in axes.items())
    paths = tuple(axis.name for axis in (x, y) if axis.state is None)
    return OutcomeMap(OutcomeRuns(EnsembleQuestion(machine, paths, **settings), start or {}), (x, y))


def starts_of(map_: OutcomeMap) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """The initial states and parameters in the first four cells."""
    assert isinstance(map_.runs, OutcomeRuns)
    question, start, places = map_.runs.question, map_.runs.start, map_.places(0, np.arange(4))
    return initial_states(question.machine, start, map_.quantities, places, "study.axes")


@pytest.mark.parametrize(
    ("name", "range_", "unit", "periodic"),
    [
        ("psi", [0.0, TURN], "rad", True),
        ("psi", ["-180 deg", "180 deg"], "rad", True),
        ("psi", [0.0, 6.2832], "rad", True),
        ("psi", [0.0, 6.2], "rad", False),
        ("psi", [0.0, 2 * TURN], "rad", True),
        ("delta", [0.0, TURN], "rad", False),  # after one turn of delta each body has gone half of one
        ("delta", [0.0, 2 * TURN], "rad", True),
        ("p1", ["0 deg", "360 deg"], "rad", True),
        ("p2.angle", [0.0, TURN], "rad", True),
        ("drum.speed", ["0 rpm", "60 rpm"], "rad/s", False),
        ("carrier.x", ["-1 mm", "1 mm"], "m", False),
        ("carrier.vy", [-1.0, 1.0], "m/s", False),
        ("drive.slope", [0.0, TURN], "N m s", False),
    ],
)
def test_a_whole_turn_is_periodic(name: str, range_: list[Any], unit: str, periodic: bool) -> None:
    axis = map_axis(R1, name, (*range_, 8))
    assert (axis.unit, axis.is_periodic) == (unit, periodic)
    assert len(axis.centres(2)) == 32


def test_what_is_periodic_is_the_same_start() -> None:
    """A period on, all angles are whole turns on; half a period on, they are not."""
    for name, state in start_states(R1).items():
        if state.period is not None and name in ("psi", "delta", "p1", "p2"):
            begin, later, half = (initial_state(R1, {name: 0.4 + k * state.period}) for k in (0.0, 1.0, 0.5))
            assert np.allclose(np.exp(1j * begin), np.exp(1j * later))
            assert not np.allclose(np.exp(1j * begin), np.exp(1j * half))


def test_centres() -> None:
    """Halving puts the centres a quarter of a cell beside those before."""
    axis = map_axis(R1, "carrier.x", ("-2 mm", "2 mm", 4))
    assert np.allclose(axis.centres(), [-1.5e-3, -0.5e-3, 0.5e-3, 1.5e-3])
    assert np.allclose(axis.centres(1).reshape(4, 2) - axis.centres()[:, None], [-0.25e-3, 0.25e-3])


def test_each_cell_starts_as_a_run_up_would() -> None:
    """Row by row, the second axis being the rows; what the axes do not say is as in ``start``."""
    axes = {"p2.speed": [0.0, 4.0, 2], "carrier.x": [0.0, 2e-3, 2]}
    start = {"p1": 0.3, "p2": -0.5, "carrier": {"y": 1e-3}}
    states, values = starts_of(outcome_map(R1, axes, start))
    assert values == {}
    for m, (speed, x) in enumerate([(1.0, 5e-4), (3.0, 5e-4), (1.0, 15e-4), (3.0, 15e-4)]):
        alone = {"p1": 0.3, "p2": {"angle": -0.5, "speed": speed}, "carrier": {"y": 1e-3, "x": x}}
        assert np.array_equal(states[:, m], initial_state(R1, alone))


def test_parameters_move_the_place_of_rest() -> None:
    """The carrier starts where it rests under its weight: m g/k, with the cell's own stiffness."""
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0, "gravity": 9.81},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2},
            {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.01},
        ],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
    })  # fmt: skip
    states, values = starts_of(outcome_map(machine, {"carrier.stiffness": [1e4, 3e4, 2], "ball": [0.0, TURN, 2]}))
    assert values["carrier.stiffness"].tolist() == [1.5e4, 2.5e4, 1.5e4, 2.5e4]
    row = machine.state_names.index("carrier.y")
    assert np.allclose(states[row], -3.1 * 9.81 / values["carrier.stiffness"])
