"""Verdicts on whole runs, each on a machine made to end that way."""

import cmath
import math
import tomllib
from typing import Any

import pytest
from scipy.optimize import brentq

from wucht import RunUp
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.studies.registry import studies
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


def test_rollers_in_thin_oil_are_captured_at_the_resonance() -> None:
    """000, section 7: damping of the vibration holds the rollers at a critical speed while the rotor turns at 300 rad/s."""
    machine = machine_from(ROLLERS | {"set": {"a.damping": 2e-7, "b.damping": 2e-7}})
    start = {"a": {"angle": 0.3, "speed": 0.0}, "b": {"angle": -0.3, "speed": 0.0}}
    result = run(RunUp(until=100.0, start=start), machine)
    assert result.attrs["outcome"] == "balancer-captured"
    last = result.speed.isel(time=slice(-2000, None)).mean("time").values
    assert last[0] == pytest.approx(300.0)
    assert 50 < last[1] < 70  # at omega_x = 62.5
    assert 100 < last[2] < 130  # at omega_y = 125.1


def test_the_same_rollers_in_thick_oil_compensate() -> None:
    result = run(RunUp(start={"a": 0.3, "b": -0.2}), machine_from(ROLLERS))
    assert result.attrs["outcome"] == "compensated"


def test_bodies_that_increase_the_unbalance_are_named_with_the_factor() -> None:
    """Below the resonance they tend to the heavy side, so that all add up; beyond it too weak ones reduce it."""
    rotor, *bodies = ROLLERS["bodies"]
    shares = [b["mass"] * (b["track_radius"] - b["radius"]) / rotor["unbalance"] for b in bodies]
    start = {"a": 0.3, "b": -0.2}
    below = run(RunUp(start=start), machine_from(ROLLERS | {"set": {"drive.speed": 40.0}}))
    assert below.attrs["outcome"] == "passed" and "no resonance lies below" in below.attrs["sentence"]
    phases = below.wucht.summary["final_phases"]
    factor = abs(1 + sum(u * cmath.exp(1j * phases[b["name"]]) for u, b in zip(shares, bodies, strict=True)))
    # that of the window, not of its mean phases
    assert below.wucht.summary["unbalance_factor"] == pytest.approx(factor, rel=1e-4) and factor == pytest.approx(3.0, rel=2e-3)
    assert "the bodies increase it, to 3 times that of the rotor alone" in below.attrs["sentence"]
    weak = {f"{b['name']}.mass": 0.3 / u * b["mass"] for u, b in zip(shares, bodies, strict=True)}
    beyond = run(RunUp(start=start), machine_from(ROLLERS | {"set": weak}))
    assert beyond.attrs["outcome"] == "passed"
    assert beyond.wucht.summary["final_residual_unbalance"] == pytest.approx(1 - 0.6, rel=1e-3)
    assert "unbalance_factor" not in beyond.wucht.summary and "increase" not in beyond.attrs["sentence"]


def test_the_end_of_the_captured_branch_is_reported() -> None:
    """Table 3.1 at u = 2.6, just before the fold at 2.6054: steady at 1.016, beyond the maximum of the torque at 1.0155."""
    result = run(RunUp(), load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": 2.6}))
    assert result.attrs["outcome"] == "passed"
    assert any("close to its end" in w for w in result.wucht.warnings)
    beyond = run(RunUp(), load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": 2.65}))
    assert beyond.wucht.summary["final_speed"] == pytest.approx(1.8644, abs=2e-4)
    assert beyond.wucht.warnings == []


def test_a_rotor_that_its_motor_cannot_lift_comes_to_rest() -> None:
    """Its swing can only lose energy: so it comes to rest, as soon as it is seen to be too small to turn over again."""
    heavy = ALONE | {"set": {"carrier.gravity": 9.81, "d.unbalance": 0.2, "d.inertia": 0.1, "d.bearing_damping": 0.05}}
    machine = machine_from(heavy | {"drive": {"kind": "linear", "slope": 0.005, "no_load_speed": 100.0}})
    assert _advised(machine, 2.0, {"d": -0.5}) == ["unidentified", "not-started"]


def test_a_rotor_without_losses_swings_for_ever() -> None:
    free = {"carrier": {"directions": "fixed", "gravity": 9.81},
            "bodies": [{"kind": "rotor", "name": "d", "mass": 2.0, "unbalance": 0.05, "inertia": 0.01}]}  # fmt: skip
    result = run(RunUp(until=30.0, start={"d": 0.5}), machine_from(free))
    assert result.attrs["outcome"] == "oscillating"
    assert result.wucht.summary["final_speed"] == pytest.approx(0.0, abs=0.3)


# --- machine T: a rotor of large unbalance on a light carrier, its torque does not depend on its speed ---

T = {
    "carrier": {"mass": 1.3608, "directions": "x", "stiffness": 186.3, "damping": 0.659},
    "bodies": [{"kind": "rotor", "name": "r", "mass": 0.096, "eccentricity": 0.0592, "inertia": 5.5394e-4}],
    "drive": {"kind": "constant-torque", "torque": 6.4e-3},
}
DOWN = {"r": -math.pi / 2}


def _advised(machine: Machine, until: float, start: dict[str, Any], most: int = 5) -> list[str]:
    """The outcomes of a run and of those that follow its advice."""
    outcomes: list[str] = []
    while len(outcomes) < most:
        summary = run(RunUp(until=until, start=start), machine).wucht.summary
        outcomes.append(summary["outcome"])
        if summary["advised_time"] is None:
            break
        until = summary["advised_time"]
    return outcomes


def _bearing(damping: float) -> dict[str, Any]:
    return T | {"bodies": [T["bodies"][0] | {"bearing_damping": damping}]}


def test_a_drive_without_a_no_load_speed_is_captured_too() -> None:
    summary = run(RunUp(start=DOWN), machine_from(T)).wucht.summary
    assert summary["outcome"] == "captured"
    assert summary["final_speed"] == pytest.approx(10.883, abs=1e-3)
    assert summary["resonance_speed"] == pytest.approx(11.315, abs=1e-3)


def test_a_beat_that_dies_out_is_not_called_modulated() -> None:
    outcomes = _advised(machine_from(_bearing(5e-5)), 15.0, DOWN)
    assert outcomes == [*["unidentified"] * (len(outcomes) - 1), "captured"]


def test_the_advice_on_a_beat_that_dies_out_follows_its_decay() -> None:
    """Its range falls by the factor e in 37 s: to a thousandth of the speed in 190 s."""
    advised = run(RunUp(until=60.0, start=DOWN), machine_from(T)).wucht.summary["advised_time"]
    assert 190 < advised < 1.5 * 190


def test_a_run_until_settled_waits_for_its_end() -> None:
    assert run(RunUp(start=DOWN), machine_from(_bearing(5e-5))).attrs["outcome"] == "captured"


def test_following_the_advice_decides() -> None:
    outcomes = _advised(load_machine("drozdetskaya-2020/r1-u1"), 1.0, {"p1": 0.3, "p2": -0.5})
    assert outcomes == [*["unidentified"] * (len(outcomes) - 1), "captured"]
    assert len(outcomes) <= 3


@pytest.mark.parametrize("until", [3600.0, 5000.0])
def test_a_modulation_is_known_after_five_of_its_periods(until: float) -> None:
    start = {"psi": 0.0, "delta": 0.5}
    summary = run(RunUp(until=until, start=start), load_machine("drozdetskaya-2020/table-5.1", {"u": 2.75})).wucht.summary
    assert summary["outcome"] == "captured-modulated"
    assert summary["modulation_period"] == pytest.approx(682.576, abs=0.01)


# --- what is stored does not matter ---

FAST = {
    "carrier": {"directions": "xy", "stiffness": 1e5, "damping": 300.0},
    "bodies": [{"kind": "rotor", "name": "d", "mass": 10.0, "unbalance": 0.01, "inertia": 0.003}],
    "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 1289.0},
}


def test_a_steady_run_that_is_stored_coarsely_does_not_beat() -> None:
    """At 3.7 samples a turn they beat by aliasing."""
    fine = run(RunUp(until=4.0), machine_from(FAST)).wucht.summary
    few = round(3.7 * 4.0 * 1269.7 / (2 * math.pi))
    result = run(RunUp(until=4.0, stored_samples=few), machine_from(FAST))
    coarse = result.wucht.summary
    assert result.sizes["time"] < 3100
    assert any("3.7 samples a turn" in w for w in result.wucht.warnings)
    assert (coarse["outcome"], coarse["modulation_period"]) == ("passed", None)
    for name in ("final_speed", "settling_time", "final_residual_unbalance"):
        assert coarse[name] == pytest.approx(fine[name], rel=1e-6)


@pytest.mark.parametrize("until", [20.0, 20.07])
def test_the_final_speed_is_a_mean_over_whole_turns(until: float) -> None:
    """Gravity: the speed varies by 8 % within a turn."""
    carrier = {"mass": 1.0, "directions": "x", "stiffness": 1e4, "damping": 5.0, "gravity": 9.81}
    body = {"kind": "rotor", "name": "r", "mass": 1.0, "unbalance": 5e-3, "inertia": 1e-3}
    drive = {"kind": "linear", "slope": 2e-2, "no_load_speed": 30.0}
    machine = machine_from({"carrier": carrier, "bodies": [body], "drive": drive})
    assert run(RunUp(until=until), machine).wucht.summary["final_speed"] == pytest.approx(29.9690086768, rel=1e-8)


@pytest.mark.parametrize(("amplitude", "speed"), [(1e-3, 4.0), (1e-2, 20.0), (1e-3, 60.0)])
def test_the_amplitude_of_a_prescribed_motion_is_its_amplitude(amplitude: float, speed: float) -> None:
    motion = {"direction": "x", "amplitude": amplitude, "frequency": 6.2832}
    body = {"kind": "rotor", "name": "r", "mass": 1.0, "unbalance": 1e-3, "inertia": 1e-3}
    drive = {"kind": "linear", "slope": 1e-3, "no_load_speed": speed}
    machine = machine_from({"carrier": {"mass": 1.0, "directions": "x", "motion": motion}, "bodies": [body], "drive": drive})
    assert run(RunUp(until=50.0), machine).wucht.summary["final_amplitude"] == pytest.approx(amplitude, rel=1e-4)


def test_exciters_that_hang_at_the_resonance_are_synchronised_and_captured() -> None:
    bodies = [
        {"kind": "rotor", "name": n, "mass": 1.0, "unbalance": 0.02, "inertia": 0.01, "bearing_damping": 1e-4} for n in "ab"
    ]
    drives = [{"on": n, "kind": "linear", "slope": 1e-3, "no_load_speed": w} for n, w in (("a", 100.5), ("b", 101.0))]
    carrier = {"mass": 8.0, "directions": "x", "stiffness": 3500.0, "damping": 20.0}
    machine = machine_from({"carrier": carrier, "bodies": bodies, "drives": drives})
    result = run(RunUp(until=200.0, start={"a": 0.3}), machine)
    summary = result.wucht.summary
    assert summary["outcome"] == "synchronised"
    assert summary["rotor_outcomes"] == {"a": "captured", "b": "captured"}
    assert "captured at the resonance: a, b" in result.attrs["sentence"]
    assert summary["final_speed"] == pytest.approx(18.05, abs=0.01)  # of 18.71
    faster = machine_from({"carrier": carrier, "bodies": bodies, "drives": [d | {"slope": 4e-3} for d in drives]})
    assert run(RunUp(until=60.0, start={"a": 0.3}), faster).wucht.summary["rotor_outcomes"] == {"a": "passed", "b": "passed"}


@pytest.mark.slow
def test_exciters_on_a_soft_mounting_are_captured_while_they_still_swing_against_each_other() -> None:
    """Each swings by 0.24 % of its speed, which decays in 200 s. The speed is that of the averaged equations, by hand."""
    bodies = [{"kind": "rotor", "name": n, "mass": 5.0, "unbalance": 0.05, "inertia": 0.02} for n in ("e1", "e2")]
    drives = [{"on": n, "kind": "linear", "slope": 2e-4, "no_load_speed": w} for n, w in (("e1", 100.5), ("e2", 99.5))]
    carrier = {"mass": 90.0, "directions": "x", "stiffness": 4e4, "damping": 80.0}
    machine = machine_from({"carrier": carrier, "bodies": bodies, "drives": drives})
    summary = run(RunUp(until=400.0, start={"e2": 0.2}), machine).wucht.summary
    assert summary["outcome"] == "synchronised"
    assert summary["rotor_outcomes"] == {"e1": "captured", "e2": "captured"}
    both = "captured at the resonance: e1, e2, at 19 % of the speed without vibration"
    assert summary["sentence"] == f"the rotors turn at the same mean speed; {both}"

    def surplus(w: float) -> float:
        """Of both drives over the vibration torque of both in phase on 100 kg."""
        return 2e-4 * (200 - 2 * w) - 80 * w**5 * 0.1**2 / 2 / ((4e4 - 100 * w**2) ** 2 + (80 * w) ** 2)

    assert surplus(15.0) > 0 > surplus(20.0)
    assert summary["final_speed"] == pytest.approx(brentq(surplus, 15.0, 20.0), rel=2e-4)
    assert summary["final_speed"] < summary["resonance_speed"] == pytest.approx(20.012, abs=1e-3)


# --- mirror images, units, time scale ---


def _mirrored(document: dict[str, Any]) -> dict[str, Any]:
    drive = document["drive"]
    key = "torque" if "torque" in drive else "no_load_speed"
    return document | {"drive": drive | {key: -drive[key]}}


@pytest.mark.parametrize(("document", "until"), [(_bearing(5e-5), 120.0), (FAST, 4.0), (T, 60.0)])
def test_a_mirror_image_has_the_mirrored_verdict(document: dict[str, Any], until: float) -> None:
    """x -> -x: angles a -> pi - a, speeds change their sign."""
    name = document["bodies"][0]["name"]
    one, other = (
        run(RunUp(until=until, start={name: start}), machine_from(d)).wucht.summary
        for d, start in ((document, 0.4), (_mirrored(document), math.pi - 0.4))
    )
    assert one["outcome"] == other["outcome"]
    assert one["final_speed"] == pytest.approx(-other["final_speed"], rel=1e-9)
    for key in ("resonance_speed", "settling_time", "final_residual_unbalance"):
        assert one[key] == (None if other[key] is None else pytest.approx(other[key], rel=1e-6))


def test_a_slower_time_scale_slows_the_verdict_down() -> None:
    """Stiffness over 100, damping, torque slope and speeds over 10, time times 10."""
    slow = {
        "carrier": {"directions": "xy", "stiffness": 1e3, "damping": 30.0},
        "bodies": FAST["bodies"],
        "drive": {"kind": "linear", "slope": 0.002, "no_load_speed": 128.9},
    }
    one, other = (run(RunUp(until=t), machine_from(d)).wucht.summary for d, t in ((FAST, 4.0), (slow, 40.0)))
    assert one["outcome"] == other["outcome"]
    assert other["settling_time"] == pytest.approx(10 * one["settling_time"], rel=1e-6)
    assert other["final_speed"] == pytest.approx(one["final_speed"] / 10, rel=1e-9)


def test_a_modulation_is_known_again_in_a_longer_run() -> None:
    """From cycle to cycle the lag of the pendulums changes by some millionths, which is how well cycles are told apart."""
    machine = load_machine("drozdetskaya-2020/table-5.1").with_values({"u": 3.15})
    summary = run(RunUp(until=10_000.0, start={"psi": 3.241, "delta": 0.364}), machine).wucht.summary
    assert summary["outcome"] == "captured-modulated"
    assert summary["advice"] is None


CRUSHER = tomllib.loads(str(studies()["voltage-dip"].template))["machine"]


@pytest.mark.parametrize(
    ("speed", "outcome", "final"), [(120.0, "passed", 144.65), (30.0, "stopped", 0.0), (0.0, "not-started", 0.0)]
)
def test_a_machine_that_does_not_start_by_itself(speed: float, outcome: str, final: float) -> None:
    """It has passed its resonance at 70.7 rad/s where it holds its speed, and has stopped where dry friction lets it creep.

    From rest it does not start, which a run from another start says too.
    """
    result = run(RunUp(start={"drum": {"speed": speed}}), machine_from(CRUSHER))
    s = result.wucht.summary
    assert s["outcome"] == outcome
    assert s["final_speed"] == pytest.approx(final, abs=0.2)
    assert s["free_speed"] == pytest.approx(final, abs=0.2)
    assert s["resonance_speed"] == (pytest.approx(70.7, rel=0.02) if final else None)
    assert result.time[-1] < 60.0
    assert ["the load takes 40 N m" in warning for warning in result.wucht.warnings] == [True] * (speed > 0)
