"""The variables of a motion that is made by hand: which row of the states each is, over which axis, and in which unit."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht import Machine, load_machine
from wucht.files.building import machine_from
from wucht.machines.operation import natural_frequencies
from wucht.numerics.observers.records import Spans
from wucht.studies import motion_variables as module
from wucht.studies.answer import Answer

TIME = np.array([0.0, 0.25, 0.5, 0.75, 1.0])
ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "inertia": 0.03, "unbalance": 2e-3}
BALL = {"kind": "pendulum", "about": "drum", "mass": 0.01, "length": 0.1}
CARRIER = {"mass": 1.0, "stiffness": 3e4, "damping": 20.0}


def machine(*bodies: dict[str, Any], no_load_speed: float = 100.0, **carrier: Any) -> Machine:
    drive = {"kind": "linear", "on": "drum", "slope": 0.04, "no_load_speed": no_load_speed}
    return machine_from({"carrier": CARRIER | carrier, "bodies": [ROTOR, *bodies], "drive": drive})


def rows(of: Machine, **given: Any) -> dict[str, np.ndarray]:
    """All states and outputs are unlike numbers, but for those that are given."""
    outputs = ["motor_torque", "drive_torque", "motor_power", "stored_energy", *(f"bearing_force_{d}" for d in of.labels)]
    outputs += [f"orbit.{v}{n}" for n in of.orbit for v in ("", "v")]
    made = {name: np.full(len(TIME), 1.0 + k) for k, name in enumerate([*of.state_names, *outputs])}
    return made | {name: np.asarray(x, float) for name, x in given.items()}


def turning(of: Machine, **angles: Any) -> dict[str, np.ndarray]:
    """Bodies at these angles, whose speeds are ten times as large."""
    by_name = {b.name: b.coordinate for b in of.bodies}
    given = {by_name[n].position.name: np.asarray(a, float) for n, a in angles.items()}
    return rows(of, **given | {by_name[n].velocity.name: 10 * np.asarray(a, float) for n, a in angles.items()})


def values(quantities: list[Any]) -> dict[str, np.ndarray]:
    return {q.name: np.asarray(q.value) for q in quantities if q.value is not None}


DRUM = np.array([0.0, 1.0, 2.0, 3.0, 4.0])


def test_angles_and_speeds_are_those_of_the_bodies_in_their_order() -> None:
    of = machine(BALL | {"name": "b1"}, BALL | {"name": "b2"})
    row = turning(of, drum=DRUM, b1=DRUM + 2.0, b2=DRUM - 1.0)
    made = {q.name: q for q in module._rotation(of, row, TIME)}
    assert np.asarray(made["angle"].value).tolist() == [DRUM.tolist(), (DRUM + 2).tolist(), (DRUM - 1).tolist()]
    assert np.asarray(made["speed"].value) == pytest.approx(10 * np.asarray(made["angle"].value))
    assert [made[name].unit for name in ("angle", "speed", "free_speed", "motor_torque", "motor_power")] == [
        "rad", "rad/s", "rad/s", "N m", "W",
    ]  # fmt: skip
    for name in ("motor_torque", "drive_torque", "motor_power"):
        assert np.array_equal(made[name].value, row[name]), name
    assert made["free_speed"].value == pytest.approx(100.0)
    phase = np.asarray(made["phase"].value)
    assert np.isnan(phase[0]).all() and phase[1] == pytest.approx(2.0) and phase[2] == pytest.approx(2 * math.pi - 1.0)


def test_without_bodies_about_it_a_rotor_has_no_phases() -> None:
    assert "phase" not in values(module._rotation(machine(), turning(machine(), drum=DRUM), TIME))


def test_the_free_speed_of_a_clockwise_rotor_is_negative() -> None:
    of = machine(no_load_speed=-100.0)
    assert values(module._rotation(of, turning(of, drum=-DRUM), TIME))["free_speed"] == pytest.approx(-100.0)


@pytest.mark.parametrize(
    ("phases", "share"),
    [
        ((0.0, 0.0), 2.0),
        ((math.pi, math.pi), 0.0),
        ((math.pi / 2, -math.pi / 2), 1.0),
        ((math.pi / 2, math.pi / 2), math.sqrt(2)),
    ],
)
def test_the_residual_unbalance_is_the_sum_of_the_vectors_over_that_of_the_rotor(phases: Any, share: float) -> None:
    """Two pendulums of 1 g m each about a rotor of 2 g m, whichever way it turns."""
    of = machine(BALL | {"name": "b1"}, BALL | {"name": "b2"})
    for way in (1, -1):
        angles = {"drum": way * DRUM, "b1": way * DRUM + phases[0], "b2": way * DRUM + phases[1]}
        assert module._residual(of, rows(of), angles, np.linspace(0.0, 1.0, 5)) == pytest.approx(np.full(5, share), abs=1e-12)


def test_rotors_that_lock_have_their_phase_to_the_first() -> None:
    """In the sense in which each turns, in [0, 2 pi)."""
    second = ROTOR | {"name": "e2"}
    drives = [{"kind": "linear", "on": name, "slope": 0.04, "no_load_speed": 100.0} for name in ("drum", "e2")]
    of = machine_from({"carrier": CARRIER, "bodies": [ROTOR, second], "drives": drives})
    made = values(module._rotation(of, turning(of, drum=DRUM, e2=-DRUM - 0.5), TIME))
    assert np.isnan(made["rotor_phase"][0]).all() and made["rotor_phase"][1] == pytest.approx(0.5)
    assert "vibration_frequency" not in made
    same = values(module._rotation(of, turning(of, drum=DRUM, e2=DRUM - 0.5), TIME))
    assert same["rotor_phase"][1] == pytest.approx(2 * math.pi - 0.5)


def test_the_vibration_of_the_carrier_by_its_directions() -> None:
    of = machine()
    x, y = of.carrier
    given = {x.position.name: DRUM, y.position.name: 2 * DRUM, x.velocity.name: 3 * DRUM, y.velocity.name: 4 * DRUM}
    given |= {"bearing_force_x": 5 * DRUM, "bearing_force_y": 6 * DRUM}
    given |= {"orbit.x": 3 * DRUM, "orbit.y": 4 * DRUM, "orbit.vx": 0 * DRUM + 12, "orbit.vy": 0 * DRUM + 16}
    made = {q.name: q for q in module._vibration(of, rows(of, **given), TIME, 7.5)}
    assert np.asarray(made["displacement"].value).tolist() == [DRUM.tolist(), (2 * DRUM).tolist()]
    assert np.asarray(made["velocity"].value).tolist() == [(3 * DRUM).tolist(), (4 * DRUM).tolist()]
    assert np.asarray(made["bearing_force"].value).tolist() == [(5 * DRUM).tolist(), (6 * DRUM).tolist()]
    assert made["radius"].value == pytest.approx(5 * DRUM) and made["peak_amplitude"].value == 7.5
    assert [made[n].unit for n in ("displacement", "velocity", "bearing_force", "radius", "amplitude", "peak_amplitude")] == [
        "m", "m/s", "N", "m", "m", "m",
    ]  # fmt: skip


def swinging(speed: float, natural: dict[str, float], shaken: float | None = None) -> np.ndarray:
    """Of |sin 4 pi t|, whose valleys are a quarter of a unit of time apart, sampled a hundred times in each."""
    time = np.linspace(0.0, 4.0, 1601)
    return module._envelope(time, np.abs(np.sin(4 * math.pi * time)), np.full(1601, speed), natural, shaken, None)


def test_valleys_within_a_turn_are_filled_and_slower_ones_are_not() -> None:
    inside = slice(200, -200)
    for speed in (22.0, -22.0):  # a turn takes 0.286
        assert swinging(speed, {})[inside].min() == pytest.approx(1.0, abs=1e-4), speed
    assert swinging(200.0, {})[inside].min() < 0.3, "a turn takes 0.03"
    assert swinging(0.0, {"x": 22.0, "r": 0.0})[inside].min() == pytest.approx(1.0, abs=1e-4), "a free vibration"
    assert swinging(0.0, {"x": 200.0, "y": 22.0})[inside].min() == pytest.approx(1.0, abs=1e-4), "of the slowest"
    assert swinging(200.0, {"x": 22.0})[inside].min() < 0.3, "the rotor is faster"
    for shaken in (22.0, -22.0):
        assert swinging(200.0, {}, shaken)[inside].min() == pytest.approx(1.0, abs=1e-4), "a period of the vibration"
    assert swinging(22.0, {}, 200.0)[inside].min() == pytest.approx(1.0, abs=1e-4)
    assert swinging(0.0, {}).min() == 0.0, "at rest nothing is filled"
    rest = module._envelope(np.linspace(0.0, 1.0, 9), np.zeros(9), np.ones(9), {}, None, None)
    assert not rest.any()


def test_the_balance_of_energy_is_that_of_the_works() -> None:
    """Supplied 6 J, dissipated 1 J and stored 4 J: a joule of the largest, 6, is missing at the end."""
    of = machine()
    supplied, dissipated = np.array([0.0, 2.0, 3.0, 4.0, 6.0]), np.array([0.0, 0.5, 0.5, 0.5, 1.0])
    names = [q.name for q in of.system.quadratures]
    works = {name: np.zeros(5) for name in names} | {"supplied_work": supplied, "dissipated_work": dissipated}
    trajectory: Any = SimpleNamespace(quadratures=works)
    stored = supplied - dissipated - np.array([0.0, 0.0, 0.0, 0.0, 1.0])
    made = {q.name: q for q in module._energy(of, {"stored_energy": stored}, trajectory)}
    assert np.array_equal(made["stored_energy"].value, stored) and made["stored_energy"].unit == "J"
    residual = np.asarray(made["energy_residual"].value)
    assert residual[:4] == pytest.approx(0.0, abs=1e-15) and residual[4] == pytest.approx(1 / 6)
    assert np.array_equal(made["supplied_work"].value, supplied) and np.array_equal(made["dissipated_work"].value, dissipated)


def test_limits_in_spans_are_those_of_speed_and_distance() -> None:
    spans = Spans(*(np.array([k, k + 0.5]) for k in range(8)))
    made = {q.name: (np.asarray(q.value).tolist(), q.unit) for q in module.envelopes(machine(), spans)}
    assert made == {
        "span_end": ([0.0, 0.5], "s"), "least_speed": ([4.0, 4.5], "rad/s"), "greatest_speed": ([5.0, 5.5], "rad/s"),
        "least_radius": ([6.0, 6.5], "m"), "greatest_radius": ([7.0, 7.5], "m"),
    }  # fmt: skip


def test_natural_frequencies_and_parameters_by_their_names() -> None:
    of = machine(stiffness=[3e4, 12e4])
    natural = natural_frequencies(of)
    assert natural == pytest.approx({"x": 100.0, "y": 200.0}), "3 kg in all"
    a = Answer(of.units)
    module.state_natural_vibrations(a, of)
    module.state_parameters(a, of)
    made = a.to_dataset()
    assert dict(zip(made["mode"].values, made.natural_frequency.values, strict=True)) == natural
    assert made.wucht.summary["natural_frequencies"] == natural
    assert made.natural_frequency.attrs["units"] == made.wucht.unit_at("natural_frequencies.x") == "rad/s"
    assert dict(zip(made.parameter.values, made.parameters.values, strict=True)) == dict(of.values)


def test_several_rotors_have_a_bearing_force_and_a_power_each() -> None:
    """By rotor and direction."""
    drives = [{"kind": "linear", "on": name, "slope": 0.04, "no_load_speed": 100.0} for name in ("drum", "e2")]
    of = machine_from({"carrier": CARRIER, "bodies": [ROTOR, ROTOR | {"name": "e2"}], "drives": drives})
    forces = {
        f"bearing_force[{name}]_{d}": (k + 10 * i) * np.ones(5)
        for k, name in enumerate(("drum", "e2"))
        for i, d in enumerate("xy")
    }
    powers = {f"motor_power[{name}]": (3.0 + k) * np.ones(5) for k, name in enumerate(("drum", "e2"))}
    row = turning(of, drum=DRUM, e2=DRUM) | forces | powers
    works = {q.name: np.zeros(5) for q in of.system.quadratures}
    trajectory: Any = SimpleNamespace(time=TIME, quadratures=works)
    made = values(module.motion_quantities(of, row, trajectory, 0.0))
    assert made["rotor_bearing_force"][:, :, 0].tolist() == [[0.0, 10.0], [1.0, 11.0]]
    assert made["rotor_power"][:, 0].tolist() == [3.0, 4.0]
    assert (made["rotor"].tolist(), made["plane"].tolist(), made["body"].tolist()) == (
        ["drum", "e2"],
        ["x", "y"],
        ["drum", "e2"],
    )
    assert made["direction"].tolist() == ["x", "y"] and made["time"].tolist() == TIME.tolist()
    alone = machine()
    single: Any = SimpleNamespace(time=TIME, quadratures={q.name: np.zeros(5) for q in alone.system.quadratures})
    of_one = values(module.motion_quantities(alone, turning(alone, drum=DRUM), single, 0.0))
    assert not {"rotor_bearing_force", "rotor_power", "mount_x"} & set(of_one)


def test_the_places_of_mounts_are_those_of_the_file() -> None:
    made = values(module._mounts(load_machine("practice/screen")))
    assert (made["mount_x"].tolist(), made["mount_y"].tolist()) == ([-0.9, 0.9], [-0.2, -0.2])


def test_a_mass_in_its_guide_adds_to_the_unbalance_of_its_body() -> None:
    """0.2 kg that have moved by 5 mm beside a pendulum of 5 g m (0.1 m times 0.05 kg, and none of the mass at its stop)."""
    guided = {
        "kind": "switchable-pendulum", "name": "p", "about": "drum", "mass": 0.3, "damping": 0.02, "moving_mass": 0.2,
        "inner_stop": 0.05, "outer_stop": 0.09, "stiffness": 300.0, "preload": 20.0, "permanent_unbalance": 0.0,
    }  # fmt: skip
    of = machine(guided)
    coordinate = of.sliders[0].coordinate
    out = np.array([0.0, 0.0, 5e-3, 10e-3, 20e-3])
    row = turning(of, drum=DRUM, p=DRUM + math.pi) | {coordinate.position.name: out, coordinate.velocity.name: 7 * out}
    made = {q.name: q for q in module._rotation(of, row, TIME)}
    assert np.asarray(made["slider_displacement"].value).tolist() == [out.tolist()]
    assert np.asarray(made["slider_velocity"].value) == pytest.approx(7 * out[None])
    assert (made["slider_displacement"].unit, made["slider_velocity"].unit) == ("m", "m/s")
    assert made["residual_unbalance"].value == pytest.approx(np.abs(2e-3 - 0.2 * out) / 2e-3)
    works: Any = SimpleNamespace(time=TIME, quadratures={q.name: np.zeros(5) for q in of.system.quadratures})
    assert values(module.motion_quantities(of, row, works, 0.0))["slider"].tolist() == ["p"]


def test_a_shaken_machine_has_the_phase_of_its_rotor_to_the_vibration() -> None:
    of = load_machine("sperling-vibration/figure-2a")
    frequency, rotor = of.shaking_frequency, of.rotor
    assert frequency is not None
    angle = {rotor.coordinate.position.name: frequency * TIME + 0.75, rotor.coordinate.velocity.name: np.full(5, frequency)}
    made = {q.name: q for q in module._rotation(of, rows(of, **angle), TIME)}
    place = [b.name for b in of.bodies].index(rotor.name)
    assert np.asarray(made["rotor_phase"].value)[place] == pytest.approx(0.75)
    assert made["vibration_frequency"].value == frequency and made["rotor_phase"].long_name.endswith("to the vibration")


def test_the_amplitude_is_the_line_through_the_peaks_at_the_speed_of_the_rotor(monkeypatch: pytest.MonkeyPatch) -> None:
    """It begins at zero where the axis begins at rest."""
    asked: list[Any] = []

    def line(time: np.ndarray, peaks: np.ndarray, *of: Any) -> np.ndarray:
        asked.append((time, *of))
        return peaks

    monkeypatch.setattr(module, "_envelope", line)
    of = machine(stiffness=[3e4, 12e4])
    speed, still = of.rotor.coordinate.velocity.name, {f"orbit.{n}": np.zeros(5) for n in ("x", "y", "vx", "vy")}
    for moving in ({"orbit.x": DRUM}, {"orbit.x": DRUM + 1.0}, {"orbit.vy": DRUM + 1.0}):
        module._vibration(of, rows(of, **still | moving | {speed: -10 * DRUM}), TIME, 1.0)
    assert [one[-1] for one in asked] == [0.0, None, None]
    for time, rate, natural, shaken, _ in asked:
        assert (time is TIME, rate.tolist(), shaken) == (True, (-10 * DRUM).tolist(), None)
        assert natural == pytest.approx({"x": 100.0, "y": 200.0})


def test_what_a_schedule_changes_is_as_at_the_end_of_the_run() -> None:
    """The no-load speed goes from 100 to 50."""
    table = {"parameter": "drive.no_load_speed", "points": [(0.0, 100.0), (0.5, 50.0)], "interpolation": "linear"}
    drive = {"kind": "linear", "slope": 0.04, "no_load_speed": 100.0}
    of = machine_from({"carrier": CARRIER, "bodies": [ROTOR], "drive": drive, "schedules": [table]})
    assert values(module._rotation(of, turning(of, drum=DRUM), TIME))["free_speed"] == pytest.approx(50.0)
