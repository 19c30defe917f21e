"""The study ``voltage-dip``: its answers, in numbers and sentences; what it refuses; stopped and resumed."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import quad
from scipy.optimize import brentq
from tests.refusals import check_refusal, refused

import wucht
from interrupting import assert_same, stop_at, stopped_at_once
from wucht import Machine, VoltageDip, draw, load_machine, report, run
from wucht.files.building import machine_from

J, U = 0.05, 230.0
MOTOR = {
    "on": "rotor", "kind": "induction", "voltage": U, "frequency": 50.0, "pole_pairs": 2, "stator_resistance": 2.0,
    "rotor_resistance": 1.5, "stator_reactance": 3.0, "rotor_reactance": 3.0,
}  # fmt: skip


def loaded_motor(load: float, **parts: Any) -> Machine:
    """An induction motor on a fixed axis against a constant torque, without vibration."""
    body = {"kind": "rotor", "name": "rotor", "mass": 5.0, "eccentricity": 0.0, "inertia": J}
    loads = [{"on": "rotor", "kind": "coulomb", "torque": load}]
    return machine_from({"carrier": {"directions": "fixed"}, "bodies": [body], "drive": MOTOR, "loads": loads} | parts)


def critical_by_quadrature(load: float, depth: float) -> float:
    """The time from the working point to the unstable crossing of torque and load, at the low voltage."""
    synchronous = math.pi * 50

    def torque(speed: float, voltage: float) -> float:
        d = synchronous - speed
        return 4.5 * voltage**2 * d / ((2 * d + 1.5 * synchronous) ** 2 + (6 * d) ** 2)

    pull_out = synchronous * (1 - 1.5 / math.hypot(2, 6))
    stable, unstable = (brentq(lambda w: torque(w, U) - load, *e) for e in ((pull_out, synchronous), (1.0, pull_out)))
    return quad(lambda w: J / (torque(w, (1 - depth) * U) - load), stable, unstable)[0]


@pytest.fixture(scope="module")
def answer() -> xr.Dataset:
    return run(VoltageDip(depth=0.6, points=4), loaded_motor(40.0))


def test_the_critical_duration(answer: xr.Dataset) -> None:
    s = answer.wucht.summary
    assert s["critical_duration"] == pytest.approx(critical_by_quadrature(40.0, 0.6), rel=0.01)
    assert s["critical_duration"] <= critical_by_quadrature(40.0, 0.6) < s["beyond"]["duration"]
    assert s["outcome"] == s["beyond"]["outcome"] == s["lasting"]["outcome"] == "stopped"
    assert s["beyond"]["returns"] is False and s["dip"] is None
    assert s["operating_speed"] == pytest.approx(144.79, rel=1e-4) and s["operating_outcome"] == "passed"
    assert s["voltages"] == {"drive": U} and s["dip_voltages"] == {"drive": pytest.approx(0.4 * U)}
    assert answer.attrs["sentence"].startswith(
        "with 60 % of the voltage lost, the machine returns by itself after dips of up to"
    )
    assert answer.attrs["sentence"].endswith(": stopped") and answer.attrs["finished"] == 1
    assert answer.wucht.warnings == []
    assert "has settled at its stable working point, 144.79 rad/s" in "; ".join(answer.wucht.assumed)


def test_its_dips_and_courses(answer: xr.Dataset) -> None:
    s = answer.wucht.summary
    assert np.all(np.diff(answer.dip_duration) > 0) and len(s["dips"]) == answer.sizes["dip"]
    returns = answer.dip_duration.values <= s["critical_duration"]
    np.testing.assert_array_equal(answer.dip_returns, returns)
    assert list(answer.course.values) == ["longest dip with a return", "shortest dip without"]
    assert answer.time.attrs["units"] == "s" and float(answer.time[0, 0]) < 0
    at = int(np.nanargmin(np.abs(answer.time[1].values - s["beyond"]["duration"])))
    assert float(answer.speed[1, 0, at]) == pytest.approx(s["beyond"]["speed_at_recovery"], rel=0.02)
    assert float(np.nanmax(answer.amplitude)) == 0.0


def test_courses_are_drawn_from_before_the_dip_with_all_rotors() -> None:
    """Speeds in magnitude. One drive loses half of its voltage for a few turns; nothing has settled at that voltage."""
    result = run(VoltageDip(depth=0.5, duration=(0.05, 0.1), points=1, on="e1"), load_machine("practice/screen"))
    s = result.wucht.summary
    assert s["voltages"] == {"drives.e1": 230.0} and s["dip_voltages"] == {"drives.e1": 115.0}
    assert (s["lasting"]["settled"], s["lasting"]["time"], s["beyond"]) == (False, 0.1, None)
    assert [row["duration"] for row in s["dips"]] == [0.05, 0.1]
    assert result.rotor.values.tolist() == ["e1", "e2"]
    assert result.course.values.tolist() == ["longest dip with a return"] and result.course_duration.values.tolist() == [0.1]
    (time,), (speeds,), (amplitude,) = result.time.values, result.speed.values, result.amplitude.values
    assert time[0] < 0 and time[-1] > 0.1 and np.all(np.diff(time) >= 0)
    assert speeds[:, time < 0] == pytest.approx(np.full((2, int((time < 0).sum())), s["operating_speed"]), rel=0.02)
    assert 0 < speeds.min() < 0.99 * s["operating_speed"]
    assert amplitude.max() <= s["dips"][1]["peak_amplitude"] and s["operating_amplitude"] > 0
    assert any(line.startswith("  low voltage  ") and "not settled after 0.1 s" in line for line in report(result))
    assert [axis.get_title() for axis in draw(result).axes if axis.get_title()][1] == "vibration"


def test_a_given_duration_on_both_sides() -> None:
    expected, machine = critical_by_quadrature(50.0, 1.0), loaded_motor(50.0)
    for share, outcome in ((0.98, "passed"), (1.02, "stopped")):
        result = run(VoltageDip(depth=1.0, duration=share * expected, points=2), machine)
        s, durations = result.wucht.summary, result.course_duration.values
        assert (str(result.course.values[0]), durations[0]) == ("dip of the given duration", share * expected)
        assert len(set(durations)) == len(durations) and share * expected in result.dip_duration.values
        (line,) = (line for line in report(result) if line.startswith("  dip  "))
        assert (": returns, from" in line, ": does not return: stopped, 0 rad/s" in line) == (share < 1, share > 1)
        assert s["outcome"] == s["dip"]["outcome"] == outcome
        assert s["dip"]["returns"] is (share < 1)
        assert s["critical_duration"] == pytest.approx(expected, rel=0.01)


def test_a_range() -> None:
    expected, machine = critical_by_quadrature(50.0, 1.0), loaded_motor(50.0)
    inside = run(VoltageDip(depth=1.0, duration=(0.5 * expected, 2 * expected), points=2), machine).wucht.summary
    assert inside["critical_duration"] == pytest.approx(expected, rel=0.01)
    assert min(d["duration"] for d in inside["dips"]) == 0.5 * expected
    for ends, outcome, words in (
        ((0.2 * expected, 0.9 * expected), "passed", "after every dip of 0.01194 to 0.05371 s"),
        (
            (1.1 * expected, 5.0),
            "stopped",
            "returns by itself after none of the dips that were tried; after 0.06565 s: stopped",
        ),
    ):
        result = run(VoltageDip(depth=1.0, duration=ends, points=2), machine)
        s = result.wucht.summary
        assert s["critical_duration"] is None and s["outcome"] == outcome and words in result.attrs["sentence"]


@pytest.mark.parametrize(
    ("depth", "words"),
    [
        (1.0, "however long: it stops, and starts again"),
        (0.2, "however long: it settles at 148.3 rad/s, and returns from there"),
    ],
)
def test_it_always_returns(depth: float, words: str) -> None:
    result = run(VoltageDip(depth=depth, points=2), loaded_motor(20.0))
    assert result.wucht.summary["critical_duration"] is None
    assert result.wucht.summary["outcome"] == "passed"
    assert result.attrs["sentence"].endswith(words)
    assert ("settled after a run-up" in "; ".join(result.wucht.assumed)) is True


def test_a_machine_that_does_not_run() -> None:
    """No working point is left: the load exceeds the breakdown torque."""
    result = run(VoltageDip(depth=0.5), loaded_motor(80.0))
    s = result.wucht.summary
    assert s["outcome"] == s["operating_outcome"] == "not-started" and s["critical_duration"] is None and s["dips"] == []
    assert s["load_torque"] == {"rotor": pytest.approx(80.0)} and s["starts_from_rest"] == {"rotor": False}
    assert "does not reach a state of operation" in result.attrs["sentence"]
    assert any("the load takes 80 N m" in warning for warning in result.wucht.warnings)
    assert report(result) and draw(result)


# --- stopped and resumed ---


def test_stopped_and_resumed(tmp_path: Path, answer: xr.Dataset) -> None:
    machine, question = loaded_motor(40.0), VoltageDip(depth=0.6, points=4)
    part = run(question, machine, folder=tmp_path, progress=stop_at(3, "dip of"))
    assert not part.attrs["finished"] and 0 < part.sizes["dip"] < answer.sizes["dip"]
    assert part.wucht.summary["critical_duration"] is None and part.wucht.summary["critical_speed"] is None
    shares = list[float]()
    again = run(question, machine, folder=tmp_path, resume=True, progress=lambda share, _: shares.append(share))
    assert_same(again, answer)
    assert max(np.diff(shares)) < 0.5 and min(np.diff(shares)) > -1e-9


def test_stopped_before_the_border_is_known() -> None:
    part = run(VoltageDip(depth=0.6, points=4), loaded_motor(40.0), progress=stop_at(1, "dip of"))
    assert part.attrs["sentence"] == "not determined yet"
    assert (part.sizes["dip"], part.course.values.tolist()) == (0, ["operation"])
    assert report(part) and draw(part)
    part = run(VoltageDip(depth=0.6, points=4), loaded_motor(40.0), progress=stop_at(8, "dip of"))
    assert "the machine returns by itself after a dip of " in part.attrs["sentence"]
    assert part.wucht.summary["critical_duration"] is None and part.wucht.summary["beyond"] is not None


def test_stopped_before_the_machine_is_in_operation(tmp_path: Path, answer: xr.Dataset) -> None:
    assert_same(stopped_at_once(VoltageDip(depth=0.6, points=4), loaded_motor(40.0), tmp_path, 2), answer)


# --- refused ---

QUESTIONS: dict[str, dict[str, Any]] = {
    "no depth": {},
    "no loss": {"depth": 0.0},
    "more than all": {"depth": 1.1},
    "a voltage": {"depth": "100 V"},
    "no time": {"depth": 0.5, "duration": 0.0},
    "a mass": {"depth": 0.5, "duration": "1 kg"},
    "a word": {"depth": 0.5, "duration": "long"},
    "three": {"depth": 0.5, "duration": [1.0, 2.0, 3.0]},
    "the wrong way round": {"depth": 0.5, "duration": [2.0, 1.0]},
    "negative": {"depth": 0.5, "duration": [-1.0, 1.0]},
    "no points": {"depth": 0.5, "points": 0},
    "until": {"depth": 0.5, "until": 1.0},
}


@pytest.mark.parametrize("name", QUESTIONS)
def test_questions_that_are_refused(name: str) -> None:
    check_refusal(f"voltage-dip: {name}", lambda: VoltageDip(**QUESTIONS[name]))


def test_machines_that_are_refused() -> None:
    with refused("machine.drive", "drum", "induction", given="linear", code="no-voltage"):
        run(VoltageDip(depth=0.5), load_machine("drozdetskaya-2020/r1"))
    with refused("machine.model", code="no-voltage"):
        run(VoltageDip(depth=0.5), load_machine("drozdetskaya-2020/table-a.1"))
    with refused("study.on", "rotor", given="roter", code="unknown-name"):
        run(VoltageDip(depth=0.5, on="roter"), loaded_motor(20.0))
    with refused("study.duration", "turns", given=1e6, code="limits"):
        run(VoltageDip(depth=0.5, duration=1e6), loaded_motor(20.0))
    with refused("study.start.drum", "rotor", given=1.0, code="unknown-key"):
        run(VoltageDip(depth=0.5, start={"drum": 1.0}), loaded_motor(20.0))
    motion = {"direction": "x", "amplitude": 1e-3, "frequency": 10.0}
    shaken = loaded_motor(20.0, carrier={"directions": "x", "motion": motion})
    with refused("machine.carrier.motion", code="prescribed"):
        run(VoltageDip(depth=0.5), shaken)


def test_units_of_a_duration() -> None:
    assert VoltageDip(depth="50 %", duration="200 ms").duration == 0.2
    assert VoltageDip(depth=0.5, duration=["50 ms", "2 s"]).limits == (0.05, 2.0)
    assert VoltageDip(depth=0.5, duration=["50 ms", "2 s"]).single_duration is None
    assert wucht.VoltageDip is VoltageDip
