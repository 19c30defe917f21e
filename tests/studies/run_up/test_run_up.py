"""The study run-up: its keys, where it ends, and motions whose solution is known on paper."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal, refused

from wucht import RunUp
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE
from wucht.studies.runner import run

Study = Callable[..., Path]
DRIVE = '[machine.drive]\non = "drum"\nkind = "linear"\nslope = "0.04 N m s"\nno_load_speed = "200 rad/s"\n'
PENDULUM = """\
[[machine.bodies]]
kind = "pendulum"
name = "p1"
about = "drum"
mass = "125 g"
length = "104 mm"
damping = "0.17 N m s"

"""
ALONE = (PENDULUM, "", PENDULUM.replace("p1", "p2"), "")


def _run(machine: Machine, **keys: Any) -> tuple[xr.Dataset, dict[str, Any]]:
    result = run(RunUp.from_table({"kind": "run-up", **keys}), machine)
    return result, result.wucht.summary


@pytest.fixture
def drum(study: Study) -> Machine:
    return load_machine(str(study()))


# Keys


READ: dict[str, tuple[Mapping[str, Any], dict[str, Any]]] = {
    "nothing: until settled": ({}, {"until": None, "turns": None, "tolerance": DEFAULT_TOLERANCE, "engine": None}),
    "until": ({"until": "1 minute"}, {"until": 60.0, "turns": None}),
    "until a number": ({"until": 3}, {"until": 3.0}),
    "until settled": ({"until": "settled"}, {"until": None, "turns": None}),
    "until turns": ({"until": {"turns": 3}}, {"until": None, "turns": 3.0}),
    "turns": ({"turns": 300}, {"turns": 300.0}),
    "half a turn": ({"turns": 0.5}, {"turns": 0.5}),
    "settled": ({"settled": True}, {"until": None, "turns": None}),
    "tolerance": ({"tolerance": 1e-9}, {"tolerance": 1e-9}),
    "speed limit": ({"speed_limit": "3000 rpm"}, {"speed_limit": pytest.approx(100 * math.pi)}),
    "engine": ({"engine": "radau"}, {"engine": "radau"}),
    "model": ({"model": "full"}, {}),
    "start": ({"start": {"p1": "0.3 rad"}}, {"start": {"p1": "0.3 rad"}}),
}


@pytest.mark.parametrize(("keys", "expected"), READ.values(), ids=READ.keys())
def test_keys_are_read(drum: Machine, keys: Mapping[str, Any], expected: dict[str, Any]) -> None:
    question = RunUp.from_table({"kind": "run-up", **keys})
    assert {k: getattr(question, k) for k in expected} == expected


REFUSED = {
    "unknown": {"untill": 1},
    "three ends": {"until": 1, "turns": 1},
    "no end": {"settled": False},
    "model": {"model": "fast"},
    "order": {"model": "slow", "order": 3},
    "inertia": {"model": "slow", "inertia": "no"},
    "order of the full": {"order": 2},
    "until 0": {"until": 0},
    "until NaN": {"until": math.nan},
    "tolerance 0": {"tolerance": 0},
    "tolerance too small": {"tolerance": 1e-17},
    "tolerance too large": {"tolerance": 0.1},
    "speed limit": {"speed_limit": -1},
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_keys_are_refused(case: str) -> None:
    check_refusal(f"run-up: {case}", lambda: RunUp.from_table(REFUSED[case]))


def test_a_dimensionless_time_has_no_unit() -> None:
    machine = load_machine("drozdetskaya-2020/table-5.1")
    assert RunUp.from_table({"until": 100}).until == 100.0
    with refused("study.until", code="dimension"):
        run(RunUp.from_table({"until": "100 s"}), machine)


# Where a run ends


def test_until_a_time_ends_there(drum: Machine) -> None:
    result, short = _run(drum, until="0.7 s")
    assert result.time.values[0] == 0.0
    assert result.time.values[-1] == pytest.approx(0.7, abs=1e-12)
    assert np.ptp(np.diff(result.time)) < 1e-12, "samples are evenly spaced"
    assert result.attrs["finished"] == 1
    assert short["outcome"] == "unidentified"


@pytest.mark.parametrize(("turns", "speed"), [(7, 200.0), (0.5, 200.0), (7, -200.0)])
def test_turns_of_the_main_rotor(study: Study, turns: float, speed: float) -> None:
    machine = load_machine(str(study('"200 rad/s"', str(speed))))
    result, _ = _run(machine, turns=turns, start={"drum": 0.4, "p1": 0.3})
    turned = float(result.angle.sel(body="drum")[-1] - result.angle.sel(body="drum")[0])
    step = float(result.time[1] - result.time[0]) * abs(speed)
    assert math.copysign(turned, 1) == pytest.approx(2 * math.pi * turns, abs=step)
    assert math.copysign(1, turned) == math.copysign(1, speed)
    assert result.attrs["end_time"] >= result.time.values[-1]


def test_turns_that_are_never_reached_end_the_run(study: Study) -> None:
    machine = load_machine(str(study(DRIVE, "", 'inertia = "0.03 kg m^2"', "inertia = 0.03\nbearing_damping = 0.03")))
    result, short = _run(machine, turns=100, start={"drum": {"speed": 10}})
    assert result.attrs["finished"] == 1
    assert short["outcome"] in ("stopped", "unidentified")


def test_until_settled_is_settled(drum: Machine) -> None:
    result, short = _run(drum, settled=True, start={"p1": 0.3, "p2": -0.5})
    assert short["outcome"] == "compensated"
    assert short["settling_time"] < result.time.values[-1]
    longer, again = _run(drum, until=2 * float(result.time[-1]), start={"p1": 0.3, "p2": -0.5})
    assert again["final_speed"] == pytest.approx(short["final_speed"], rel=1e-4)
    assert again["final_phases"] == pytest.approx(short["final_phases"], abs=1e-2)
    assert longer.time.values[-1] > result.time.values[-1]


def test_the_advice_helps(study: Study) -> None:
    machine = load_machine(str(study(*ALONE, "0.04 N m s", "4 N m s")))
    until, outcomes = 0.05, []
    for _ in range(12):
        _, short = _run(machine, until=until)
        outcomes.append(short["outcome"])
        if short["outcome"] != "unidentified":
            break
        advised = float(short["advice"].split("at least until ")[1].split()[0].rstrip(","))
        assert advised > until, "the advice is a longer run"
        until = advised
    assert outcomes[0] == "unidentified"
    assert outcomes[-1] == "passed"


def test_a_speed_limit_ends_a_runaway(drum: Machine) -> None:
    result, short = _run(drum, until=20, speed_limit="50 rad/s")
    assert short["outcome"] == "runaway"
    assert result.attrs["end_time"] < 20
    assert float(np.abs(result.speed.sel(body="drum")).max()) <= 50.0 * (1 + 1e-6)


def test_a_speed_limit_that_is_not_reached_changes_nothing(drum: Machine) -> None:
    limited, plain = _run(drum, until=1, speed_limit=1000), _run(drum, until=1)
    assert limited[1]["outcome"] == plain[1]["outcome"]
    np.testing.assert_allclose(limited[0].speed, plain[0].speed, rtol=1e-9, atol=1e-9)


NOTHING = {"no drive": (DRIVE, ""), "no slope": ('"0.04 N m s"', "0"), "no speed": ('"200 rad/s"', "0")}


@pytest.mark.parametrize("changes", NOTHING.values(), ids=NOTHING.keys())
def test_what_nothing_turns_is_refused(study: Study, changes: tuple[str, str]) -> None:
    machine = load_machine(str(study(*changes)))
    with refused("machine.drive", "study.start", code="nothing-turns"):
        _run(machine, until=1)
    _, short = _run(machine, until=0.1, start={"drum": {"speed": 10}})
    assert short["outcome"] == "unidentified"


# Solutions on paper


def test_a_balanced_rotor_runs_up_exponentially(study: Study) -> None:
    machine = load_machine(str(study(*ALONE, '"1 mm"', "0")))
    result, short = _run(machine, until="5 s", tolerance=1e-14)  # the residual follows it
    # J phi'' = U (Omega - phi'), from rest: phi' = Omega (1 - exp(-U t/J))
    expected = 200 * (1 - np.exp(-0.04 * result.time.values / 0.03))
    np.testing.assert_allclose(result.speed.sel(body="drum"), expected, rtol=1e-10, atol=1e-10)
    # the motor has given U (Omega - phi') phi', integrated
    e = np.exp(-0.04 * result.time.values / 0.03)
    work = 0.03 * 200**2 * ((1 - e) - (1 - e**2) / 2)
    np.testing.assert_allclose(result.supplied_work, work, rtol=1e-9, atol=1e-9)
    assert float(np.abs(result.displacement).max()) == 0.0
    assert short["peak_amplitude"] == 0.0
    assert short["energy_residual"] < 1e-12


def test_a_bearing_brings_a_rotor_to_rest(study: Study) -> None:
    changes = (DRIVE, "", '"1 mm"', "0", 'inertia = "0.03 kg m^2"', "inertia = 0.03\nbearing_damping = 0.03")
    result, short = _run(load_machine(str(study(*ALONE, *changes))), until=30, start={"drum": {"speed": 100}})
    expected = 100 * np.exp(-result.time.values)  # J phi'' = -b phi'
    np.testing.assert_allclose(result.speed.sel(body="drum"), expected, rtol=1e-9, atol=1e-11)
    assert short["outcome"] == "stopped"
    assert result.dissipated_work.values[-1] == pytest.approx(0.03 * 100**2 / 2, rel=1e-9)
    for key in ("modulation_period", "modulation_period_phi"):
        assert short[key] is None


def test_a_heavy_rotor_swings_below_the_axis(study: Study) -> None:
    changes = (DRIVE, "", '"1e5 N/m"', '"1e10 N/m"', '"1 kg"', '"1000 t"\ngravity = "9.81 m/s^2"', '"1 mm"', '"10 mm"')
    machine = load_machine(str(study(*ALONE, *changes)))
    result, short = _run(machine, until=30, start={"drum": "-80 deg"}, tolerance=1e-10)
    assert short["outcome"] == "oscillating"
    angle = result.angle.sel(body="drum").values + math.pi / 2
    assert np.abs(angle).max() == pytest.approx(math.radians(10), rel=1e-3)
    # small swing about the bottom: w^2 = m g e/J, T = 2 pi/w (1 + a^2/16)
    period = 2 * math.pi / math.sqrt(9 * 9.81 * 0.01 / 0.03) * (1 + math.radians(10) ** 2 / 16)
    falls = np.flatnonzero((angle[:-1] > 0) & (angle[1:] <= 0))
    assert np.diff(result.time.values[falls]).mean() == pytest.approx(period, rel=1e-3)


def test_two_pendulums_stand_where_they_compensate() -> None:
    _, short = _run(load_machine("drozdetskaya-2020/r1-u40"), until=60, start={"p1": 0.3, "p2": -0.5})
    assert short["outcome"] == "compensated"
    # M e + 2 m l cos(phase) = 0: cos(phase) = -9.75e-3/0.026
    expected = math.acos(-0.375)
    assert sorted(short["final_phases"].values()) == pytest.approx([expected, 2 * math.pi - expected], abs=1e-5)
    assert short["final_speed"] == pytest.approx(200.0, rel=1e-6)
    assert short["final_residual_unbalance"] < 1e-6
    assert short["final_amplitude"] < 1e-8


def test_a_prescribed_speed_gives_the_resonance_curve(study: Study) -> None:
    drive = '[machine.drive]\nkind = "constant-speed"\nspeed = "120 rad/s"\n'
    result, short = _run(load_machine(str(study(*ALONE, DRIVE, drive))), until=3)
    u, m, c, b, w = 9e-3, 10.0, 1e5, 200.0, 120.0
    amplitude = u * w**2 / math.hypot(c - m * w**2, b * w)
    assert short["final_amplitude"] == pytest.approx(amplitude, rel=1e-6)
    assert short["final_speed"] == pytest.approx(120.0, rel=1e-12)
    assert short["outcome"] == "passed"
    # the motor covers what the damper takes: b w^2 a^2
    assert float(result.motor_power[-1]) == pytest.approx(b * w**2 * amplitude**2, rel=1e-6)


def test_a_rotor_that_is_held_does_not_turn(study: Study) -> None:
    drive = '[machine.drive]\nkind = "constant-speed"\nspeed = 0\n'
    machine = load_machine(str(study(DRIVE, drive)))
    with refused("machine.drive", "study.start", code="nothing-turns"):
        _run(machine, until=1)
    result, short = _run(machine, until=20, start={"p1": {"speed": 10}})
    assert short["outcome"] == "stopped"
    assert short["final_speed"] == 0.0
    assert float(result.speed.sel(body="p1")[-1]) == pytest.approx(0.0, abs=1e-6)


def test_a_mirror_image_runs_the_mirrored_way(study: Study) -> None:
    right, first = _run(load_machine(str(study())), until=1, start={"p1": 0.3, "p2": -0.5})
    left, second = _run(load_machine(str(study('"200 rad/s"', "-200"))), until=1, start={"p1": -0.3, "p2": 0.5})
    np.testing.assert_allclose(left.angle, -right.angle, rtol=1e-7, atol=1e-7)
    np.testing.assert_allclose(left.radius, right.radius, rtol=1e-6, atol=1e-10)
    assert second["outcome"] == first["outcome"]
    assert second["final_speed"] == pytest.approx(-first["final_speed"], rel=1e-7)
    # the speeds of the window change places with their signs
    assert sorted([second["min_speed"], second["max_speed"]]) == pytest.approx(
        [-first["max_speed"], -first["min_speed"]], rel=1e-6
    )


def test_a_mirror_image_compensates_too() -> None:
    question = {"until": 30, "start": {"p1": 0.3, "p2": -0.5}}
    mirrored = {"until": 30, "start": {"p1": -0.3, "p2": 0.5}}
    _, right = _run(load_machine("drozdetskaya-2020/r1-u80"), **question)
    _, left = _run(load_machine("drozdetskaya-2020/r1-u80", {"drive.no_load_speed": -200}), **mirrored)
    assert left["outcome"] == right["outcome"] == "compensated"
    assert left["final_speed"] == pytest.approx(-right["final_speed"], rel=1e-6)
    assert left["settling_time"] == pytest.approx(right["settling_time"], rel=1e-3)
    for name, phase in right["final_phases"].items():
        assert left["final_phases"][name] == pytest.approx(2 * math.pi - phase, abs=1e-4)


def test_the_implicit_integrator_gives_the_same(drum: Machine) -> None:
    keys = {"until": 0.3, "start": {"p1": 0.3, "p2": -0.5}, "tolerance": 1e-10}
    reference, result = _run(drum, **keys)[0], _run(drum, engine="radau", **keys)[0]
    assert (reference.attrs["engine"], result.attrs["engine"]) == ("compiled", "radau")
    np.testing.assert_allclose(result.angle, reference.angle, rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(result.displacement, reference.displacement, atol=1e-8)


def test_samples_are_dense_enough_for_peaks(drum: Machine) -> None:
    result, short = _run(drum, until=2, start={"p1": 0.3, "p2": -0.5})
    fine = run(RunUp(until=2.0, start={"p1": 0.3, "p2": -0.5}, tolerance=1e-12), drum)
    assert short["peak_amplitude"] == pytest.approx(float(fine.radius.max()), rel=0.01)
    fastest = float(np.abs(result.speed).max())
    assert float(result.time[1] - result.time[0]) <= 2 * math.pi / fastest / 20


def test_progress_is_reported_and_does_not_go_back(drum: Machine) -> None:
    reported: list[float] = []
    run(RunUp(until=1.0), drum, progress=lambda share, _what: reported.append(share))
    assert reported == sorted(reported)
    assert reported[-1] == pytest.approx(1.0)
    assert all(share <= 1 + 1e-12 for share in reported)


def test_the_dataset_keeps_its_conventions(drum: Machine) -> None:
    result, _ = _run(drum, until=0.1)
    assert result.sizes["body"] == 3
    assert np.isfinite(result.phase.values).any(axis=1).tolist() == [False, True, True]
    assert result.direction.values.tolist() == ["x", "y"]
    units = {"time": "s", "angle": "rad", "speed": "rad/s", "displacement": "m", "amplitude": "m", "motor_torque": "N m"}
    assert {name: result[name].attrs["units"] for name in units} == units
    phases = result.phase.sel(body=["p1", "p2"])
    assert ((phases >= 0) & (phases < 2 * math.pi)).all()
    bare = run(RunUp(until=10.0), load_machine("drozdetskaya-2020/table-5.1"))
    assert {bare[name].attrs["units"] for name in ("time", "speed", "amplitude", "motor_torque")} == {""}
