"""The quantity that is swept: which it is, what it does to the machine, and within which limits."""

from __future__ import annotations

from typing import Any

import pytest
from tests.refusals import refused

from wucht.dynamics.entrainment.entrainment_case import (
    AMPLITUDE,
    DETUNING,
    EntrainmentCase,
    check_entrainable,
    no_load_speed,
    swept_parameter,
)
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine

ROTOR = {"kind": "rotor", "mass": 1.0, "unbalance": 1e-3, "inertia": 1e-3}
CARRIER = {"mass": 5.0, "directions": "x", "stiffness": 50.0, "damping": 1.0}


def exciters(*speeds: float, **more: Any) -> Any:
    names = [f"e{k}" for k in range(1, len(speeds) + 1)]
    drives = [{"on": n, "kind": "linear", "slope": 1e-2, "no_load_speed": s} for n, s in zip(names, speeds, strict=True)]
    return machine_from({"carrier": CARRIER, "bodies": [ROTOR | {"name": n} for n in names], "drives": drives} | more)


@pytest.mark.parametrize(("first", "second"), [(12.0, 13.0), (12.0, -13.0), (-12.0, -13.0), (-12.0, 13.0)])
def test_a_detuning_moves_two_motors_apart_about_the_mean_of_their_speeds(first: float, second: float) -> None:
    """By half each, in magnitude, whichever way they turn."""
    swept = swept_parameter(exciters(first, second))
    assert (swept.name, swept.unit, swept.nominal_value, swept.size) == (DETUNING, "rad/s", 1.0, 12.5)
    one, other = first / 12, second / 13
    paths = ("drives.e1.no_load_speed", "drives.e2.no_load_speed")
    assert swept.values(1.0) == dict(zip(paths, (first, second), strict=True))
    assert swept.values(4.0) == dict(zip(paths, (one * 10.5, other * 14.5), strict=True))
    machine = swept.machine_at(exciters(first, second), 4.0)
    assert [machine.values[path] for path in paths] == [one * 10.5, other * 14.5]
    assert swept_parameter(exciters(first, second), DETUNING) == swept


def test_what_is_swept_by_default() -> None:
    """Of three exciters the main one's speed; under a vibration the speed of the motor, without one the amplitude."""
    three = swept_parameter(exciters(12.0, 13.0, 14.0))
    assert (three.name, three.nominal_value, three.shares) == (
        "drives.e1.no_load_speed", 12.0, {"drives.e1.no_load_speed": (0.0, 1.0)},
    )  # fmt: skip
    shaken = load_machine("sperling-vibration/figure-2a")
    assert swept_parameter(shaken).name == "drive.no_load_speed"
    motion = {"direction": "x", "amplitude": "2 mm", "frequency": "10 rad/s"}
    loose = machine_from({"carrier": {"directions": "x", "motion": motion}, "bodies": [ROTOR | {"name": "e1"}]})
    assert (swept_parameter(loose).name, swept_parameter(loose).nominal_value) == (AMPLITUDE, 2e-3)
    assert swept_parameter(loose).widest(loose) == (0.0, pytest.approx(2e-2))
    with refused("study.along", given=DETUNING):
        swept_parameter(shaken, DETUNING)
    named = swept_parameter(shaken, "rotor.inertia")
    assert named.nominal_value == shaken.values["rotor.inertia"] and named.values(3.0) == {"rotor.inertia": 3.0}


def test_a_motor_without_a_no_load_speed_has_to_be_told_what_is_swept() -> None:
    motor = {"on": "e1", "kind": "constant-torque", "torque": 1.0}
    two = machine_from({
        "carrier": CARRIER, "bodies": [ROTOR | {"name": n} for n in ("e1", "e2")],
        "drives": [motor, {"on": "e2", "kind": "linear", "slope": 1e-2, "no_load_speed": 9.0}],
    })  # fmt: skip
    with refused("study.along", code="missing"):
        swept_parameter(two)
    assert no_load_speed(two, two.rotors[0]) is None and no_load_speed(two, two.rotors[1]) == "drives.e2.no_load_speed"
    ramp = {"parameter": "drives.e2.no_load_speed", "points": [[0.0, 5.0], [1.0, 9.0]]}
    scheduled = exciters(8.0, 9.0, schedules=[ramp])
    assert no_load_speed(scheduled, scheduled.rotors[1]) is None, "a schedule prescribes it"


def test_limits_of_a_case_contain_the_value_of_the_machine() -> None:
    machine = exciters(12.0, 13.0)
    swept = swept_parameter(machine)
    wide = EntrainmentCase.of(machine, swept, {}, 25)
    assert (wide.limits, wide.range) == ((-50 * 12.5, 50 * 12.5), None)
    above = EntrainmentCase.of(machine, swept, {}, 25, range=(2.0, 5.0), resolution=0.1, until=9.0)
    assert (above.limits, above.range, above.resolution, above.until, above.points) == ((1.0, 5.0), (2.0, 5.0), 0.1, 9.0, 25)
    assert EntrainmentCase.of(machine, swept, {}, 25, range=(-5.0, -2.0)).limits == (-5.0, 1.0)


def test_values_that_a_machine_does_not_allow() -> None:
    shaken = load_machine("sperling-vibration/figure-2a")
    amplitude = swept_parameter(shaken, AMPLITUDE)
    with refused("study.range[0]", given=-1e-3):
        EntrainmentCase.of(shaken, amplitude, {}, 25, range=(-1e-3, 1e-3))
    assert EntrainmentCase.of(shaken, amplitude, {}, 25, range=(0.0, 1e-3)).range == (0.0, 1e-3)
    mass = swept_parameter(shaken, "rotor.inertia")
    with refused("study.range[1]", given=-1.0, code="limits"):
        EntrainmentCase.of(shaken, mass, {}, 25, range=(1.0, -1.0))
    with refused("study.range", code="missing"):
        EntrainmentCase.of(shaken, mass, {}, 25)


def test_the_machine_after_its_schedules() -> None:
    ramp = {"parameter": "drives.e1.slope", "points": [[0.0, 1e-2], [7.0, 2e-2]]}
    machine = exciters(12.0, 13.0, schedules=[ramp])
    case = EntrainmentCase.of(machine, swept_parameter(machine), {}, 25)
    assert case.steady.values["drives.e1.slope"] == 2e-2 and not case.steady.schedules


def test_machines_in_which_nothing_is_entrained() -> None:
    with refused("machine"):
        check_entrainable(exciters(12.0))
    held = [
        {"on": "e1", "kind": "constant-speed", "speed": 5.0},
        {"on": "e2", "kind": "linear", "slope": 1, "no_load_speed": 9},
    ]
    bodies = [ROTOR | {"name": n} for n in ("e1", "e2", "e3")]
    with refused("machine.drive", "e1"):
        check_entrainable(machine_from({"carrier": CARRIER, "bodies": bodies, "drives": held}))
    check_entrainable(exciters(12.0, 13.0))
