"""The study run-up: its keys, where it ends, and motions whose solution is known on paper."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import check_refusal, refused

from wucht import RunUp
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.runner import report, run

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


REFUSED = {
    "unknown": {"untill": 1},
    "model": {"model": "fast"},
    "order": {"model": "slow", "order": 3},
    "inertia": {"model": "slow", "inertia": "no"},
    "until NaN": {"until": math.nan},
}


@pytest.mark.parametrize("case", REFUSED)
def test_wrong_keys_are_refused(case: str) -> None:
    check_refusal(f"run-up: {case}", lambda: RunUp.from_table(REFUSED[case]))


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


def test_until_settled_is_settled(drum: Machine) -> None:
    result, short = _run(drum, settled=True, start={"p1": 0.3, "p2": -0.5})
    assert short["outcome"] == "compensated"
    assert short["settling_time"] < result.time.values[-1]
    longer, again = _run(drum, until=2 * float(result.time[-1]), start={"p1": 0.3, "p2": -0.5})
    assert again["final_speed"] == pytest.approx(short["final_speed"], rel=1e-4)
    assert again["final_phases"] == pytest.approx(short["final_phases"], abs=1e-2)
    assert longer.time.values[-1] > result.time.values[-1]


def test_a_speed_limit_ends_a_runaway(drum: Machine) -> None:
    result, short = _run(drum, until=20, speed_limit="50 rad/s")
    assert short["outcome"] == "runaway"
    assert result.attrs["end_time"] < 20
    assert float(np.abs(result.speed.sel(body="drum")).max()) <= 50.0 * (1 + 1e-6)


@pytest.mark.parametrize("changes", [(DRIVE, ""), ('"200 rad/s"', "0")], ids=["no drive", "no speed"])
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


@pytest.mark.slow
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


def test_keys_are_read_with_their_units() -> None:
    read = [RunUp.from_table({"kind": "run-up", "until": until}) for until in ("1 minute", "settled", {"turns": 3})]
    assert [(q.until, q.turns) for q in read] == [(60.0, None), (None, None), (None, 3.0)]
    assert RunUp.from_table({"speed_limit": "3000 rpm"}).speed_limit == pytest.approx(100 * math.pi)
    assert RunUp.from_table({"start": {"p1": "0.3 rad"}}).start == {"p1": "0.3 rad"}


# --- numbers at the end ---


@pytest.mark.parametrize("until", [900.0, 901.0])
def test_the_amplitude_is_as_large_at_both_ends_as_it_should_be(until: float) -> None:
    """Wherever the end cuts the vibration along one direction; and from rest it begins at rest."""
    machine = load_machine("drozdetskaya-2020/table-3.1-carrier").with_values({"u": 2.0})
    amplitude = run(RunUp(until=until), machine).amplitude.values
    assert amplitude[-100:] == pytest.approx(4.6146, rel=1e-3)
    assert amplitude[0] < 1e-6 < amplitude[10]
    assert (np.diff(amplitude[:10]) > 0).all()


ROTOR_ALONE = {
    "carrier": {"stiffness": 1e5, "damping": 200.0},
    "bodies": [{"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.03}],
    "drive": {"kind": "linear", "slope": 0.04, "no_load_speed": 50.0},
}


@pytest.mark.parametrize(("tolerance", "is_warned"), [(1.5e-3, False), (1.6e-3, True)])
def test_an_energy_balance_that_closes_to_a_millionth_is_not_warned_of(tolerance: float, is_warned: bool) -> None:
    """Integrated ever less accurately: at 1.5e-3 the residual is 0.94e-6."""
    result = run(RunUp(until=0.5, tolerance=tolerance), machine_from(ROTOR_ALONE))
    assert (result.wucht.summary["energy_residual"] > 1e-6) is is_warned
    assert any("energy balance closes only to" in w for w in result.wucht.warnings) is is_warned
    assert any("study.tolerance" in w for w in result.wucht.warnings) is is_warned


ADDED_MASS, LENGTH, TIMES, UNBALANCES = 0.1, 0.1, [0.0, 2.0, 3.0], [0.02, 0.02, 0.008]
BALL = {"kind": "pendulum", "about": "drum", "mass": ADDED_MASS, "length": LENGTH, "damping": 0.01}
SCHEDULED = {
    "carrier": {"mass": 10.0, "directions": "xy", "stiffness": 1e5, "damping": 200.0},
    "bodies": [
        {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": UNBALANCES[0], "inertia": 0.05},
        *(BALL | {"name": name} for name in ("p1", "p2")),
    ],
    "drive": {"on": "drum", "kind": "constant-speed", "speed": 200.0},
    "schedules": [{"parameter": "drum.unbalance", "points": list(zip(TIMES, UNBALANCES, strict=True))}],
}  # fmt: skip


def test_it_follows_a_schedule_of_the_rotors_unbalance() -> None:
    result = run(RunUp(until=4.0, start={"p1": 2.0, "p2": -2.5}), machine_from(SCHEDULED))
    own = np.interp(result["time"].values, TIMES, UNBALANCES)
    angles = {name: result["angle"].sel(body=name).values for name in ("drum", "p1", "p2")}
    total = own + ADDED_MASS * LENGTH * sum(np.exp(1j * (angles[name] - angles["drum"])) for name in ("p1", "p2"))
    np.testing.assert_allclose(result["residual_unbalance"], np.abs(total) / own, atol=1e-12)
    assert own.max() > 2 * own.min()


@pytest.mark.parametrize(("gravity", "sense"), [(0.0, -1), (9.81, 1)])
def test_the_ripple_within_a_turn_is_no_modulation(gravity: float, sense: int) -> None:
    """A rotor at w beside a vibration x0 cos(W t) beats: its torque U x0 W^2 sin(phi) cos(W t) has a slow part of half that.

    J s' = -D s + (U x0 W^2/2) sin((w - W) t), whose speed s, averaged over a turn, is sinc((w - W)/w) times as large. Gravity
    adds a ripple of U g/(J w^2), here seventeen times the modulation.
    """
    inertia, unbalance, slope, drive, frequency, amplitude = 3e-4, 1e-2, 3e-4, 60.0, 54.0, 4e-5
    machine = machine_from({
        "carrier": {"directions": "x", "gravity": gravity,
                    "motion": {"direction": "x", "amplitude": amplitude, "frequency": frequency}},
        "bodies": [{"kind": "rotor", "name": "r", "mass": 1.0, "unbalance": unbalance, "inertia": inertia}],
        "drive": {"kind": "linear", "slope": slope, "no_load_speed": sense * drive},
    })  # fmt: skip
    result = run(RunUp(until=40.0, start={"r": {"speed": sense * drive}}), machine)
    summary = result.wucht.summary
    speed = sense * summary["final_speed"]
    beat = speed - frequency
    swing = unbalance * amplitude * frequency**2 / 2 / inertia / math.hypot(beat, slope / inertia) * np.sinc(beat / speed)
    assert summary["modulation_period"] == pytest.approx(2 * math.pi / beat, rel=2e-3)
    assert summary["modulation_depth"] == pytest.approx(swing / speed, rel=0.01)
    within = (summary["max_speed"] - summary["min_speed"]) / (2 * speed)
    assert within - summary["modulation_depth"] == pytest.approx(unbalance * gravity / inertia / speed**2, abs=1e-3)
    assert summary["min_speed"] < summary["final_speed"] < summary["max_speed"]
    assert any(f"+-{100 * summary['modulation_depth']:.2g} %" in line for line in report(result) if "modulation" in line)
