"""What the names of axes mean, and what is refused."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from tests.refusals import Refusal, refused

from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_variations import start_states
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.basin.computation import axis_of, prepare
from wucht.studies.basin.spec import Basin

R1, NUMBERS = load_machine("drozdetskaya-2020/r1"), load_machine("drozdetskaya-2020/table-5.1")
TURN = 2 * math.pi
PSI, DELTA = [0.0, TURN, 4], [0.0, math.pi, 4]


def driven(*, gravity: float = 0.0, more: dict[str, Any] | None = None) -> Machine:
    """A drum with a ball."""
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0, "gravity": gravity},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2},
            {"kind": "pendulum", "name": "ball", "about": "drum", "mass": 0.1, "length": 0.1, "damping": 0.01},
        ],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
        **(more or {}),
    })  # fmt: skip


SCHEDULED = driven(more={"schedules": [{"parameter": "drive.slope", "points": [[0.0, 0.0], [1.0, 0.02]]}]})
AT_REST = driven(more={"drive": {"kind": "constant-torque", "torque": 0.0}})
HELD = driven(more={"drive": {"kind": "constant-speed", "speed": 100.0}})


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
    axis = axis_of(R1, name, (*range_, 8))
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
    axis = axis_of(R1, "carrier.x", ("-2 mm", "2 mm", 4))
    assert np.allclose(axis.centres(), [-1.5e-3, -0.5e-3, 0.5e-3, 1.5e-3])
    assert np.allclose(axis.centres(1).reshape(4, 2) - axis.centres()[:, None], [-0.25e-3, 0.25e-3])


def test_each_cell_starts_as_a_run_up_would() -> None:
    """Row by row, the second axis being the rows; what the axes do not say is as in ``start``."""
    axes = {"p2.speed": [0.0, 4.0, 2], "carrier.x": [0.0, 2e-3, 2]}
    start = {"p1": 0.3, "p2": -0.5, "carrier": {"y": 1e-3}}
    plan = prepare(Basin(axes=axes, start=start), R1)
    states, values = plan.starts(0, np.arange(4))
    assert values == {}
    for m, (speed, x) in enumerate([(1.0, 5e-4), (3.0, 5e-4), (1.0, 15e-4), (3.0, 15e-4)]):
        alone = {"p1": 0.3, "p2": {"angle": -0.5, "speed": speed}, "carrier": {"y": 1e-3, "x": x}}
        assert np.array_equal(states[:, m], initial_state(R1, alone))


def test_parameters_move_the_place_of_rest() -> None:
    """The carrier starts where it rests under its weight: m g/k, with the cell's own stiffness."""
    machine = driven(gravity=9.81)
    plan = prepare(Basin(axes={"carrier.stiffness": [1e4, 3e4, 2], "ball": [0.0, TURN, 2]}), machine)
    states, values = plan.starts(0, np.arange(4))
    assert values["carrier.stiffness"].tolist() == [1.5e4, 2.5e4, 1.5e4, 2.5e4]
    row = machine.state_names.index("carrier.y")
    assert np.allclose(states[row], -3.1 * 9.81 / values["carrier.stiffness"])


def test_paths_as_toml_reads_them() -> None:
    """``drive.slope = [...]`` is a table in a table."""
    nested = Basin(axes={"drive": {"slope": ["0 N m s", 1.0, 4]}, "p1": {"speed": [0.0, 1.0, 5.0]}})
    assert nested.axes == {"drive.slope": ("0 N m s", 1.0, 4), "p1.speed": (0.0, 1.0, 5)}


@pytest.mark.parametrize(
    ("asked", "where", "refusal"),
    [
        ({"axes": {"psi": PSI, "delta": DELTA, "u": [0, 1, 4]}}, "study.axes",
         refused("study.axes", given=['psi', 'delta', 'u'])),
        ({"axes": {"psi": PSI}}, "study.axes", refused("study.axes", given=['psi'])),
        ({"axes": {"p1.speed": PSI, "p1": {"speed": DELTA}}}, "study.axes",
         refused("study.axes", given=['p1.speed', 'p1.speed'])),
        ({"axes": [PSI, DELTA]}, "study.axes", refused("study.axes", code="table")),
        ({}, "study.axes", refused("study.axes", code="missing")),
        ({"axes": {"psi": [0.0, 1.0], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0], code="shape")),
        ({"axes": {"psi": [0.0, 1.0, 4.5], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0, 4.5], code="whole-number")),
        ({"axes": {"psi": [0.0, 1.0, 1], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0, 1], code="whole-number")),
        ({"axes": {"psi": [0.0, 1.0, True], "delta": DELTA}}, "study.axes.psi",
         refused("study.axes.psi", given=[0.0, 1.0, True], code="whole-number")),
        ({"axes": {"psi": [0, 1, 4096], "delta": [0, 1, 4096]}}, "study.axes",
         refused("study.axes", "4194304", "4096", given="4096 x 4096")),
        ({"refine": 10}, "study.axes", refused("study.axes", "4194304", "4096", given="4 x 4, halved 10 times")),
        ({"refine": -1}, "study.refine", refused("study.refine", "10", given=-1)),
        ({"refine": 1.5}, "study.refine", refused("study.refine", given=1.5)),
        ({"inertia": True, "model": "full"}, "study.inertia", refused("study.inertia", "model = 'slow'", given=True)),
        ({"until": "0 s"}, "study.until", refused("study.until", code="limits")),
        ({"model": "both"}, "study.model", refused("study.model", code="unknown-name")),
    ],
)  # fmt: skip
def test_what_the_question_refuses(asked: dict[str, Any], where: str, refusal: Refusal) -> None:
    given = {"axes": {"psi": PSI, "delta": DELTA}} | asked if asked else {}
    with refusal as raised:
        Basin(**given)
    assert raised.value.location == where


@pytest.mark.parametrize(
    ("machine", "asked", "where", "refusal"),
    [
        (R1, {"axes": {"psy": PSI, "delta": DELTA}}, "study.axes.psy",
         refused("study.axes.psy", "psi", given="psy", code="unknown-name")),
        (R1, {"axes": {"psi": [1.0, 0.0, 4], "delta": DELTA}}, "study.axes.psi", refused("study.axes.psi", given=[1.0, 0.0])),
        (R1, {"axes": {"psi": ["1 kg", 2.0, 4], "delta": DELTA}}, "study.axes.psi[0]",
         refused("study.axes.psi[0]", code="dimension")),
        (R1, {"axes": {"psi": PSI, "p1": PSI}}, "study.axes.p1", refused("study.axes.p1", given=None)),
        (R1, {"axes": {"p1": PSI, "p1.angle": PSI}}, "study.axes.p1.angle",
         refused("study.axes.p1.angle", given="p1.angle", code="given-twice")),
        (R1, {"axes": {"psi": PSI, "delta": DELTA}, "start": {"psi": 0.1}}, "study.axes.psi",
         refused("study.axes.psi", "study.start", given="psi", code="given-twice")),
        (R1, {"axes": {"p1": PSI, "p2": PSI}, "start": {"p2": 0.1}}, "study.axes.p2",
         refused("study.axes.p2", "study.start", given="p2", code="given-twice")),
        (R1, {"axes": {"p1": PSI, "p2": PSI}, "start": {"p3": 0.1}}, "study.start.p3",
         refused("study.start.p3", code="unknown-key")),
        (R1, {"axes": {"p1": PSI, "drum.mass": [-2.0, 1.0, 4]}}, "study.axes.drum.mass",
         refused("study.axes.drum.mass", code="limits")),
        (HELD, {"axes": {"drum.speed": [0, 1, 4], "ball": PSI}}, "study.axes.drum.speed",
         refused("study.axes.drum.speed", given="drum.speed", code="prescribed")),
        (SCHEDULED, {"axes": {"drive.slope": [0, 1, 4], "ball": PSI}}, "study.axes.drive.slope",
         refused("study.axes.drive.slope", given="drive.slope", code="scheduled")),
        (driven(), {"axes": {"psi": PSI, "ball": PSI}}, "study.axes.psi",
         refused("study.axes.psi", given="psi", code="unknown-name")),
        (NUMBERS, {"axes": {"psi": ["0 s", 1, 4], "delta": DELTA}}, "study.axes.psi[0]",
         refused("study.axes.psi[0]", code="dimension")),
        (AT_REST, {"axes": {"ball": PSI, "drum.mass": [1.0, 2.0, 2]}}, "machine.drive",
         refused("machine.drive", code="nothing-turns")),
    ],
)  # fmt: skip
def test_what_does_not_fit_the_machine(machine: Machine, asked: dict[str, Any], where: str, refusal: Refusal) -> None:
    with refusal as raised:
        prepare(Basin(**asked), machine)
    assert raised.value.location == where
