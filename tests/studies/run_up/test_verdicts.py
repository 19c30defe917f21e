"""Verdicts on whole runs, each on a machine made to end that way."""

import json

import pytest

from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.results.conventions import summary_of
from wucht.studies.run_up.spec import RunUp
from wucht.studies.runner import run

ROLLERS = {  # the rotor of source 000, section 6: 62.5 and 125.1 rad/s, total mass 1 kg; rollers and dampers are ours
    "carrier": {"mass": 0.9, "stiffness": [3906.25, 15650.0], "damping": 5.0},
    "bodies": [
        {"kind": "rotor", "name": "d", "mass": 0.08, "unbalance": 1e-4, "inertia": 0.01},
        {"kind": "roller", "name": "a", "about": "d", "mass": 0.012, "track_radius": 0.015, "radius": 0.005, "damping": 2e-4},
        {"kind": "roller", "name": "b", "about": "d", "mass": 0.008, "track_radius": 0.015, "radius": 0.005, "damping": 2e-4},
    ],
    "drive": {"on": "d", "kind": "constant-speed", "speed": 300.0},
}
ALONE = {
    "carrier": {"stiffness": 1e5, "damping": 200.0},
    "bodies": [{"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.03, "bearing_damping": 0.003}],
}


@pytest.mark.parametrize("until", [None, 100.0])
def test_rollers_in_thin_oil_are_captured_at_the_resonance(until: float | None) -> None:
    """000, section 7: damping of the vibration holds the rollers at a critical speed while the rotor turns at 300 rad/s."""
    machine = machine_from(ROLLERS | {"set": {"a.damping": 2e-7, "b.damping": 2e-7}})
    start = {"a": {"angle": 0.3, "speed": 0.0}, "b": {"angle": -0.3, "speed": 0.0}}
    result = run(RunUp(until=until, start=start), machine)
    assert result.attrs["outcome"] == "balancer-captured"
    last = result.speed.isel(time=slice(-2000, None)).mean("time").values
    assert last[0] == pytest.approx(300.0)
    assert 50 < last[1] < 70  # at omega_x = 62.5
    assert 100 < last[2] < 130  # at omega_y = 125.1


def test_the_same_rollers_in_thick_oil_compensate() -> None:
    result = run(RunUp(start={"a": 0.3, "b": -0.2}), machine_from(ROLLERS))
    assert result.attrs["outcome"] == "compensated"


def test_below_all_resonances_nothing_was_passed() -> None:
    result = run(RunUp(start={"a": 0.3, "b": -0.2}), machine_from(ROLLERS | {"set": {"drive.speed": 40.0}}))
    assert result.attrs["outcome"] == "passed"
    assert "no resonance lies below" in result.attrs["sentence"]


def test_the_end_of_the_captured_branch_is_reported() -> None:
    """Table 3.1 at u = 2.6, just before the fold at 2.6054: steady at 1.016, beyond the maximum of the torque at 1.0155."""
    result = run(RunUp(), load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": 2.6}))
    assert result.attrs["outcome"] == "passed"
    assert any("close to its end" in w for w in json.loads(result.attrs["warnings"]))
    beyond = run(RunUp(), load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": 2.65}))
    assert summary_of(beyond)["final_speed"] == pytest.approx(1.8644, abs=2e-4)
    assert json.loads(beyond.attrs["warnings"]) == []


def test_a_rotor_without_drive_runs_down() -> None:
    """w' = -b w/J far from the resonance; through it the carrier takes energy as well."""
    machine = machine_from(ALONE)
    start = {"d": {"speed": 30.0}}
    early = run(RunUp(until=5.0, start=start), machine)
    assert early.attrs["outcome"] == "unidentified"
    assert "run at least until" in summary_of(early)["advice"]
    late = run(RunUp(start=start), machine)
    assert late.attrs["outcome"] == "stopped"
    turns = run(RunUp(turns=1e4, start=start), machine)
    assert turns.attrs["outcome"] == "stopped"
    assert turns.attrs["end_time"] < 1e4


def test_a_rotor_that_its_motor_cannot_lift_swings() -> None:
    heavy = ALONE | {"set": {"carrier.gravity": 9.81, "d.unbalance": 0.2, "d.inertia": 0.1, "d.bearing_damping": 0.05}}
    machine = machine_from(heavy | {"drive": {"kind": "linear", "slope": 0.005, "no_load_speed": 100.0}})
    result = run(RunUp(until=10.0, start={"d": -0.5}), machine)
    assert result.attrs["outcome"] == "oscillating"


def test_beyond_the_speed_limit_it_is_a_runaway() -> None:
    result = run(RunUp(until=10.0, speed_limit=150.0), load_machine("drozdetskaya-2020/r1-u80"))
    assert result.attrs["outcome"] == "runaway"
    assert float(result.speed.sel(body="drum")[-1]) == pytest.approx(150.0, rel=0.05)
    assert result.attrs["end_time"] < 10.0
