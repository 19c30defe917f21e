"""The study ``entrainment``: what is swept, refusals, edges by bisection, interruption; the command."""

from __future__ import annotations

import math
import re
from bisect import insort
from collections.abc import Callable
from typing import Any

import numpy as np
import pytest
from tests.refusals import check_refusal, refused

from wucht import Entrainment, Machine, load_machine, run
from wucht.dynamics.entrainment.entrainment_case import swept_parameter
from wucht.dynamics.entrainment.entrainment_equations import EntrainmentEquations
from wucht.dynamics.entrainment.existence import Continuation
from wucht.dynamics.entrainment.runs_from_start import CaptureBand, RunFromStart, capture_band, values_to_run
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.machines.operation import free_speed, sense_of

ROTOR = {"kind": "rotor", "mass": 0.1, "eccentricity": 0.01, "inertia": 2e-5}
E1, E2 = ROTOR | {"name": "e1"}, ROTOR | {"name": "e2"}
CARRIER = {"mass": 0.8, "directions": "x", "stiffness": 355.0, "damping": 0.4}
SHAKEN = {"mass": 1.0, "directions": "x", "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6.0}}
START = {"e1": {"speed": 12.0}, "e2": {"angle": 0.5, "speed": 12.0}}


def drive(on: str, speed: float = 12.0, **other: Any) -> dict[str, Any]:
    return {"on": on, "kind": "linear", "slope": 3e-5, "no_load_speed": speed} | other


def pair(*speeds: float, **carrier: Any) -> Machine:
    drives = [drive(n, w) for n, w in zip(("e1", "e2"), speeds or (12.0, 12.5), strict=True)]
    return machine_from({"carrier": CARRIER | carrier, "bodies": [E1, E2], "drives": drives})


def bild_2() -> Machine:
    return load_machine("sperling-vibration/figure-2a")


def summary(machine: Machine, **table: Any) -> dict[str, Any]:
    return run(Entrainment.from_table(table), machine).wucht.summary


# The swept parameter


def test_what_is_swept_by_default() -> None:
    assert swept_parameter(bild_2()).name == "drive.no_load_speed"
    assert swept_parameter(pair()).name == "detuning"
    assert swept_parameter(load_machine("sperling-vibration/sustained-rotation")).name == "carrier.motion.amplitude"
    three = machine_from({
        "carrier": CARRIER, "bodies": [E1, E2, ROTOR | {"name": "e3"}], "drives": [drive(n) for n in ("e1", "e2", "e3")],
    })  # fmt: skip
    assert swept_parameter(three).name == "drives.e1.no_load_speed"


def test_the_detuning_leaves_the_mean_and_the_senses() -> None:
    """Exciters that turn against each other: the second motor is the faster one where the detuning is positive."""
    machine = pair(12.0, -13.0)
    swept = swept_parameter(machine, "detuning")
    assert swept.nominal_value == pytest.approx(1.0)
    assert swept.machine_at(machine, swept.nominal_value).values == pytest.approx(machine.values)
    moved = swept.machine_at(machine, 3.0)
    assert [free_speed(moved, r) for r in moved.rotors] == pytest.approx([11.0, -14.0])
    assert [sense_of(moved, r) for r in moved.rotors] == [1.0, -1.0]


# Refusals


BILD_2 = "sperling-vibration/figure-2a"
REFUSED: list[tuple[str, dict[str, Any]]] = [
    ("drozdetskaya-2020/r1", {}), (BILD_2, {"along": "drive.slop"}), (BILD_2, {"along": "detuning"}),
    (BILD_2, {"along": "drive.slope"}), (BILD_2, {"range": [6.0, 5.0]}), (BILD_2, {"range": ["1 kg", "2 kg"]}),
    (BILD_2, {"along": "drive.slope", "range": [-1.0, 1.0]}), (BILD_2, {"resolution": 0}), (BILD_2, {"start": {"rotr": 1}}),
]  # fmt: skip


@pytest.mark.parametrize(("name", "table"), REFUSED)
def test_bad_input_is_refused(name: str, table: dict[str, Any]) -> None:
    machine = load_machine(name)
    check_refusal(f"entrainment of {name}: {table}", lambda: Entrainment.from_table(table).prepare(machine))


def test_a_drive_that_prescribes_the_speed_is_refused() -> None:
    given = {"on": "e3", "kind": "constant-speed", "speed": 12.0}
    machine = machine_from({
        "carrier": CARRIER, "bodies": [E1, E2, ROTOR | {"name": "e3"}], "drives": [drive("e1"), drive("e2"), given],
    })  # fmt: skip
    with refused("machine.drive", "e3", given=None):
        Entrainment.from_table({}).prepare(machine)


def test_a_drive_without_no_load_speed_needs_along() -> None:
    motor = {"on": "e1", "kind": "constant-torque", "torque": 1e-4}
    machine = machine_from({"carrier": SHAKEN, "bodies": [E1 | {"bearing_damping": 1e-5}], "drive": motor})
    with refused("study.along", given=None, code="missing"):
        Entrainment.from_table({}).prepare(machine)
    given = Entrainment.from_table({"along": "drive.torque", "range": [0.0, 1e-3]})
    assert given.prepare(machine).parameter.name == "drive.torque"


# The band from the start


def stepped(*bands: tuple[float, float]) -> Callable[[float], RunFromStart]:
    """A machine that is entrained within some bands."""

    def run(value: float) -> RunFromStart:
        entrained = any(low <= value <= high for low, high in bands)
        return RunFromStart(value, 1.0, 1.0, np.zeros(2), is_entrained=entrained, mean_speed=1.0, window=(0.0, 1.0))

    return run


def band(
    run: Callable[[float], RunFromStart], own: float, low: float = 0.0, high: float = 10.0, points: int = 11
) -> CaptureBand | None:
    runs = [run(float(value)) for value in np.linspace(low, high, points)]
    for value in values_to_run(runs, own, 1e-6):
        assert low < value < high
        insort(runs, run(value), key=lambda r: r.value)
    return capture_band(runs, own)


@pytest.mark.parametrize(
    ("bands", "own", "edges", "islands"),
    [
        ([(2.3, 7.9)], 5.0, (2.3, 7.9), 0),
        ([(0.5, 2.5), (4.6, 9.4)], 1.5, (0.5, 2.5), 1),
        ([(0.5, 2.5), (4.6, 9.4)], 3.0, (4.6, 9.4), 1),  # else the widest
        ([(2.0, 6.4), (6.6, 6.9)], 5.0, (2.0, 6.4), 1),  # the scan steps over the gap; the probes around the edge do not
    ],
)
def test_the_band_of_the_machine_by_bisection(
    bands: list[tuple[float, float]], own: float, edges: tuple[float, float], islands: int
) -> None:
    found = band(stepped(*bands), own)
    assert found is not None and found.edges == pytest.approx(edges, abs=1e-6) and len(found.islands) == islands


def test_an_edge_beyond_the_range_is_none() -> None:
    below = band(stepped((-1.0, 7.9)), 5.0)
    assert below is not None and below.edges[0] is None and below.edges[1] == pytest.approx(7.9, abs=1e-6)
    assert band(stepped(), 5.0) is None


# Branches of the averaged equations


def test_a_band_far_from_the_vibration() -> None:
    """A carrier that takes much power at the frequency: the motor must be set far beyond it, 2 (power)/(frequency) further."""
    carrier = {
        "mass": 1.0, "directions": "xy", "stiffness": [0.0, 400.0], "damping": [0.0, 2.0],
        "motion": {"direction": "x", "amplitude": 1e-3, "frequency": 6 * math.pi},
    }  # fmt: skip
    machine = machine_from({"carrier": carrier, "bodies": [ROTOR | {"name": "r"}], "drive": drive("r", 19.0)})
    averaged = EntrainmentEquations(machine, swept_parameter(machine, "drive.no_load_speed"), {"r": 1.0}, (-900.0, 900.0))
    path, w = Continuation(averaged), 6 * math.pi
    (branch,) = path.branches([19.0, w], None, Work())
    (stretch,) = path.stable_ranges([branch])
    y = w**2 * 1e-3 / (400 - 1.1 * w**2 + 2j * w)  # the carrier's motion across; its damper brakes, the one along x turns
    brake, torque = 2 * w * abs(y) ** 2 / 2, 1e-3 * w**2 * 1e-3 / 2
    assert stretch.ends == pytest.approx((w + (brake - torque) / 3e-5, w + (brake + torque) / 3e-5), rel=1e-11)


def test_a_band_is_found_from_a_value_far_outside_it() -> None:
    """Bild 2: no equilibrium at 100 rad/s; the edges are folds: (21), w +- m r a w^2 / (2 slope)."""
    machine = bild_2()
    averaged = EntrainmentEquations(machine, swept_parameter(machine, "drive.no_load_speed"), {"rotor": 1.0}, (-300.0, 300.0))
    path = Continuation(averaged)
    assert averaged.equilibria(100.0) == []
    branches = path.branches([100.0], None, Work())
    (stretch,) = path.stable_ranges(branches)
    w = 2 * math.pi
    width = 0.1 * 0.01 * 1e-3 * w**2 / 2 / 1e-5
    assert stretch.kinds == ("fold", "fold")
    assert stretch.ends == pytest.approx((w - width, w + width), rel=1e-11)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_phase_to_the_vibration_counts_in_the_rotors_sense(sense: float) -> None:
    """A rotor that is 0.7 rad ahead of the vibration, at any time: at +-(w t + 0.7)."""
    machine, w = bild_2().with_values({"drive.no_load_speed": sense * 5.5}), 2 * math.pi
    averaged = EntrainmentEquations(machine, swept_parameter(machine, "drive.no_load_speed"), {"rotor": sense}, (-300.0, 300.0))
    rotor, time, state = machine.rotor.coordinate, 1.3, np.zeros(len(machine.state_names))
    state[[machine.row(rotor.position), machine.row(rotor.velocity)]] = sense * (w * time + 0.7), sense * w
    found = averaged.wrap_phases(averaged.state_at(machine, time, state, w))
    assert found[averaged.phase_rows["rotor"]] == pytest.approx(0.7, abs=1e-9)
    assert found[~averaged.phases] == pytest.approx([w])


# The study


@pytest.mark.slow
def test_a_long_run_up_is_waited_for() -> None:
    """A heavy rotor needs 200 s to reach the frequency: after the first look, at 210 s, it would not count as entrained."""
    heavy = bild_2().with_values({"rotor.inertia": 1e-3, "carrier.motion.amplitude": 4e-3, "drive.no_load_speed": 6.6})
    s = summary(heavy, points=5, range=[6.5, 6.7], resolution=0.1)
    assert s["outcome"] == "entrained"


@pytest.mark.slow
def test_without_averaged_equations_the_full_ones_answer() -> None:
    """A pivot that turns with its rotor leaves none: the range must be given, and a warning says so."""
    hung = {
        "kind": "pendulum", "name": "p", "about": "e1", "mass": 0.01, "length": 0.01, "damping": 1e-4,
        "suspension": [2e-3, 0.0],
    }  # fmt: skip
    machine = machine_from({"carrier": CARRIER, "bodies": [E1, E2, hung], "drives": [drive("e1"), drive("e2", 12.2)]})
    with refused("study.range", code="not-chosen"):
        run(Entrainment.from_table({"start": START}), machine)
    table = {"start": START, "range": [-1.0, 1.0], "points": 5}
    result = run(Entrainment.from_table(table), machine)
    s = result.wucht.summary
    assert s["existence_band"] is None
    assert s["outcome"] == "synchronised"
    assert s["stable"]
    assert re.search("the averaged equations are left out: there are no averaged equations", result.attrs["warnings"])


@pytest.mark.slow
def test_bodies_count_as_released() -> None:
    """An exciter that is locked for a second takes part in the synchronous motion."""
    late = E2 | {"release": {"time": 1.0}}
    machine = machine_from({"carrier": CARRIER, "bodies": [E1, late], "drives": [drive("e1"), drive("e2", 12.2)]})
    s = summary(machine, start={"e1": {"speed": 12.0}}, points=5, range=[-1.0, 1.0], resolution=0.1)
    assert s["outcome"] == "synchronised"
    assert s["stable"]
    assert s["phase"] == pytest.approx(s["phase_slow"], abs=1e-3)


def test_amplitudes_below_zero_are_refused() -> None:
    machine = load_machine("sperling-vibration/sustained-rotation")
    with refused("study.range[0]", given=-3.0):
        Entrainment.from_table({"along": "carrier.motion.amplitude", "range": [-3, 3]}).prepare(machine)
