"""Rows, halving times and starts of a coast-down, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.run_ups import coasting
from wucht.dynamics.run_ups.coasting import (
    ROW,
    CarrierStart,
    Record,
    _crossing,
    _halving_time,
    _points_around,
    _thin_rows,
    carrier_start,
    driving_machine,
    phases_of_bodies,
    place_bodies,
    reduce_leg,
    state_at_start,
    with_steady_vibration,
    without_drives,
)
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.errors import InputError
from wucht.files.building import machine_from
from wucht.machines.machine import DISSIPATED_WORK
from wucht.numerics.flow.trajectory import Trajectory

MASS, UNBALANCE, STIFFNESS, DAMPING, SPEED = 10.0, 9e-3, 1e5, 400.0, 80.0


def machine(**more: Any) -> Any:
    rotor = {"kind": "rotor", "name": "d", "mass": MASS - 1.5, "unbalance": UNBALANCE, "inertia": 0.1}
    ball = {"kind": "pendulum", "name": "p", "about": "d", "mass": 0.5, "length": 0.1, "damping": 0.01}
    return machine_from(
        {
            "carrier": {"mass": 1.0, "directions": "x", "stiffness": STIFFNESS, "damping": DAMPING},
            "bodies": [rotor, ball],
            "drive": {"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": SPEED},
        }
        | more
    )


def test_each_two_rows_after_the_first_become_one() -> None:
    """With the extremes of both; of other columns the second stays, and an odd one out at the end."""
    rows = np.array([5.0, 1.0, 4.0, 7.0, 2.0])
    assert {name: _thin_rows(name, rows).tolist() for name in ROW} == {
        "time": [5.0, 4.0, 2.0], "angle": [5.0, 4.0, 2.0], "speed": [5.0, 4.0, 2.0], "min_speed": [5.0, 1.0, 2.0],
        "max_speed": [5.0, 4.0, 7.0], "amplitude": [5.0, 4.0, 7.0], "energy_residual": [5.0, 4.0, 2.0],
        "dissipated_work": [5.0, 4.0, 2.0],
    }  # fmt: skip
    assert _thin_rows("max_speed", np.append(rows, 3.0)).tolist() == [5.0, 4.0, 7.0, 3.0]
    assert _thin_rows("time", rows[:1]).tolist() == [5.0]


def test_a_record_grows_leg_by_leg() -> None:
    def leg(*values: float, **more: Any) -> Record:
        return Record(start_speed=-60.0, stride=0.5, end=None, rows={name: np.array(values) for name in ROW}, **more)  # type: ignore[arg-type]

    record = Record(end=None, start_speed=-60.0, stride=0.5)  # type: ignore[arg-type]
    turns, points = np.array([[1.0], [50.0]]), np.array([[2.0, 3.0], [-35.0, -25.0]])
    record = record.update(leg(1.0, 2.0, turns=turns, reversals=(4.0,))).update(
        leg(3.0, turns=2 * turns, reversals=(6.0,), halving=points)
    )
    assert record.rows["speed"].tolist() == [1.0, 2.0, 3.0] and record.turns.tolist() == [[1.0, 2.0], [50.0, 100.0]]
    assert (record.reversals, record.legs, record.stride) == ((4.0, 6.0), 2, 0.5)
    assert record.half_time == pytest.approx(2.5), "at half of 60, whichever way it turns"
    many = record.update(leg(*np.arange(7998.0).tolist()))
    assert many.stride == 1.0 and len(many.rows["time"]) == 1 + 4000
    most = record.update(leg(*np.arange(7997.0).tolist()))
    assert most.stride == 0.5 and len(most.rows["time"]) == 8000


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_time_of_half_the_speed(sense: float) -> None:
    """Of a cubic it is exact, through four points; of fewer it is that of a straight line."""

    def speed(t: np.ndarray) -> np.ndarray:
        return sense * (100 - 20 * t + 3 * t**2 - 0.5 * t**3)

    time = np.array([1.0, 2.0, 3.0, 4.0])
    exact = next(r.real for r in np.roots([-0.5, 3, -20, 50]) if abs(r.imag) < 1e-9)
    assert _halving_time(time, speed(time), 50.0) == pytest.approx(exact, abs=1e-9)
    assert _crossing(speed(time), 50.0) == int(exact) - 1
    assert _halving_time(np.array([2.0, 4.0]), sense * np.array([60.0, 20.0]), 50.0) == pytest.approx(2.5)
    assert _halving_time(time, speed(time), 1.0) is None and _crossing(speed(time), 90.0) is None
    assert _crossing(sense * np.array([60.0, 50.0, 40.0]), 50.0) == 0, "where it is reached"


def test_of_several_roots_the_one_near_the_straight_line_counts() -> None:
    """A cubic with zeros at 0.5, 2.25 and 6, of which only the middle one is a fall."""
    time = np.array([1.0, 2.0, 2.5, 4.0])
    excess = -(time - 0.5) * (time - 2.25) * (time - 6.0) * -1
    assert excess[1] * excess[2] < 0
    found = _halving_time(time, 50 + excess * np.sign(excess[1]), 50.0)
    assert found == pytest.approx(2.25)


def test_points_around_the_half() -> None:
    points = np.array([np.arange(10.0), 100 - 10 * np.arange(10.0)])
    assert _points_around(points, 45.0, 2)[0].tolist() == [4.0, 5.0, 6.0, 7.0]
    assert _points_around(points, 85.0, 3)[0].tolist() == [0.0, 1.0, 2.0, 3.0, 4.0]
    assert _points_around(points, 5.0, 4)[0].tolist() == [6.0, 7.0, 8.0, 9.0], "else the last ones"


def test_bodies_are_placed_from_the_rotor_outwards() -> None:
    of = machine()
    state = initial_state(of, {"d": {"angle": 0.5, "speed": 3.0}, "p": {"angle": 0.25, "speed": 3.0}})
    assert phases_of_bodies(of, state) == {"p": pytest.approx(0.25)}
    placed = place_bodies(of, state, {"p": -1.25})
    assert phases_of_bodies(of, placed) == {"p": pytest.approx(-1.25)}
    assert placed[of.row(of.rotor.coordinate.position)] == 0.5 and phases_of_bodies(of, state)["p"] == pytest.approx(0.25)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_it_starts_at_the_speed_of_its_drive_with_its_bodies(sense: float) -> None:
    of = machine(drive={"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": sense * SPEED})
    undriven = without_drives(of)

    def speeds(start: dict[str, Any]) -> list[float]:
        state = state_at_start(of, undriven, start)
        return [float(state[undriven.row(b.coordinate.velocity)]) for b in undriven.bodies]

    assert speeds({}) == pytest.approx([sense * SPEED] * 2)
    assert speeds({"d": {"speed": 30.0}}) == [30.0, 30.0]
    assert speeds({"d": {"speed": 30.0}, "p": {"speed": 20.0}}) == [30.0, 20.0]
    with pytest.raises(InputError) as raised:
        state_at_start(undriven, undriven, {})
    assert raised.value.location == "study.start"


def test_after_schedules_it_starts_at_the_speed_at_which_they_last_drive_it() -> None:
    """The no-load speed falls from 80 through 60 to 0 rad/s."""
    ramp = {"parameter": "drive.no_load_speed", "points": [[0.0, 80.0], [1.0, 60.0], [2.0, 0.0]]}
    of = machine(schedules=[ramp])
    undriven = without_drives(of)
    state = state_at_start(of, undriven, {})
    assert state[undriven.row(undriven.rotor.coordinate.velocity)] == pytest.approx(60.0)


def test_the_angle_of_a_drive_that_enforces_a_speed_is_that_of_the_start() -> None:
    of = machine(drive={"on": "d", "kind": "constant-speed", "speed": -SPEED, "angle": 0.75})
    undriven = without_drives(of)
    for start, angle in (({}, 0.75), ({"d": {"angle": 0.25}}, 0.25), ({"d": {"speed": -30.0}}, 0.75)):
        state = state_at_start(of, undriven, start)
        assert state[undriven.row(undriven.rotor.coordinate.position)] == angle


def test_schedules_of_drives_end_with_them() -> None:
    ramps = [
        {"parameter": path, "points": [[0.0, 80.0], [1.0, 60.0], [2.0, 0.0]]}
        for path in ("drive.no_load_speed", "d.bearing_damping")
    ]
    of = machine(schedules=ramps)
    assert [s.parameter for s in without_drives(of).schedules] == ["d.bearing_damping"]
    assert driving_machine(machine(schedules=ramps[:1])).values["drive.no_load_speed"] == 60.0


@pytest.mark.parametrize("driven", [1.0, -1.0])
@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("angle", [0.0, 0.75])
def test_the_steady_vibration_at_the_start(sense: float, angle: float, driven: float) -> None:
    """x = Re u W^2 e^(i sigma phi)/(c - M W^2 + i d W) of all unbalances u, and its velocity, beside the rest position."""
    of = machine(drive={"on": "d", "kind": "linear", "slope": 0.1, "no_load_speed": driven * SPEED})
    state = initial_state(
        of, {"d": {"angle": sense * angle, "speed": sense * 90.0}, "p": {"angle": 2.0, "speed": sense * 90.0}}
    )
    found = with_steady_vibration(of, state)
    unbalance = UNBALANCE + 0.5 * 0.1 * np.exp(1j * sense * 2.0)
    amplitude = unbalance * 90.0**2 * np.exp(1j * angle) / (STIFFNESS - MASS * 90.0**2 + 1j * DAMPING * 90.0)
    (x,) = of.free_carrier
    assert found[of.row(x.position)] - state[of.row(x.position)] == pytest.approx(amplitude.real, rel=1e-9)
    assert found[of.row(x.velocity)] == pytest.approx((1j * 90.0 * amplitude).real, rel=1e-9)
    others = [i for i in range(len(state)) if i not in (of.row(x.position), of.row(x.velocity))]
    assert found[others].tolist() == state[others].tolist()


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_at_an_undamped_resonance_there_is_none(sense: float) -> None:
    carrier = {"mass": 1.0, "directions": "x", "stiffness": STIFFNESS, "damping": 0.0}
    of, resonance = machine(carrier=carrier), math.sqrt(STIFFNESS / MASS)
    for share, refused in ((1 + 0.9e-6, True), (1 - 0.9e-6, True), (1 + 3e-6, False)):
        speed = sense * share * resonance
        state = initial_state(of, {"d": {"speed": speed}, "p": {"speed": speed}})
        if refused:
            with pytest.raises(InputError) as raised:
                with_steady_vibration(of, state)
            assert raised.value.location == "study.vibration"
        else:
            assert np.isfinite(with_steady_vibration(of, state)).all()


def test_how_the_carrier_starts() -> None:
    of, fixed = machine(), machine(carrier={"directions": "fixed"})
    assert carrier_start(fixed, {"carrier": {}}, None) == (CarrierStart.FIXED, "")
    assert carrier_start(of, {"carrier": {"x": 1.0}}, None) == (CarrierStart.GIVEN, "")
    assert carrier_start(of, {}, None) == carrier_start(of, {}, "steady") == (CarrierStart.STEADY, "")
    assert carrier_start(of, {}, "none") == (CarrierStart.REST, "")


def reduced(monkeypatch: pytest.MonkeyPatch, time: np.ndarray, speed: np.ndarray, before: Record, stored: Any = 0.0) -> Record:
    """A leg whose axis has the peaks 1, 2, 3, ..., and whose losses are ten times the time."""
    coordinate = SimpleNamespace(position=SimpleNamespace(name="phi"), velocity=SimpleNamespace(name="omega"))
    rotor = SimpleNamespace(coordinate=coordinate)
    other = SimpleNamespace(name="e2", coordinate=SimpleNamespace(position=SimpleNamespace(name="phi2")))
    of: Any = SimpleNamespace(rotor=rotor, rotors=(rotor, other))
    angle = np.concatenate([[0.0], np.cumsum((speed[1:] + speed[:-1]) / 2 * np.diff(time))])
    rows = {"phi": angle, "phi2": -3 * angle, "omega": speed, "stored_energy": stored + 0 * time}
    monkeypatch.setattr(coasting, "rows_of", lambda *_: rows)
    monkeypatch.setattr(coasting, "advance_balance", lambda balance, *_: (balance, 1e-9 * time))
    peaks = SimpleNamespace(peaks=1.0 + np.arange(len(time)))
    monkeypatch.setattr(coasting.AxisMotion, "of", lambda *_: peaks)
    hits = tuple(SimpleNamespace(name=name, time=t) for name, t in (("reversal", 1.5), ("other", 1.6)))
    trajectory: Any = SimpleNamespace(time=time, quadratures={DISSIPATED_WORK: 10 * time}, hits=hits)
    end = Trajectory(time[-1:], np.zeros((1, 1)), {}, np.zeros(0), float(time[-1]), np.zeros(1))
    trajectory.tail = lambda count: end
    return reduce_leg(of, {}, None, before, trajectory)  # type: ignore[arg-type]


@pytest.mark.parametrize("legs", [0, 1])
def test_rows_end_with_each_stride_and_the_leg(monkeypatch: pytest.MonkeyPatch, legs: int) -> None:
    """A row covers the samples since the row before, both ends included; the very first sample is a row of the first leg."""
    time = np.arange(8.0)
    speed = np.array([-9.0, 7.0, -3.0, 5.0, 2.0, 8.0, -1.0, 4.0])
    before = Record(end=None, start_speed=1e6, stride=3.0, legs=legs)  # type: ignore[arg-type]
    leg = reduced(monkeypatch, time, speed, before)
    first = slice(1 if legs else 0, None)
    assert (
        leg.rows["time"].tolist() == [0.0, 3.0, 6.0, 7.0][first] and leg.rows["speed"].tolist() == [-9.0, 5.0, -1.0, 4.0][first]
    )
    assert leg.rows["min_speed"].tolist() == [-9.0, -9.0, -1.0, -1.0][first]
    assert leg.rows["max_speed"].tolist() == [-9.0, 7.0, 8.0, 4.0][first]
    assert leg.rows["amplitude"].tolist() == [1.0, 4.0, 7.0, 8.0][first]
    assert leg.rows["dissipated_work"].tolist() == [0.0, 30.0, 60.0, 70.0][first]
    assert leg.rows["energy_residual"] == pytest.approx(np.array([0.0, 3e-9, 6e-9, 7e-9])[first])
    assert leg.rows["angle[e2]"] == pytest.approx(-3 * leg.rows["angle"]), "of the second rotor too"
    assert leg.reversals == (1.5,)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_speed_averaged_over_turns_and_its_half(monkeypatch: pytest.MonkeyPatch, sense: float) -> None:
    """From 100 rad/s it falls by 10 rad/s a second: to half after 5 s."""
    time = np.linspace(0.0, 8.0, 4001)
    leg = reduced(monkeypatch, time, sense * (100 - 10 * time), Record(end=None, start_speed=sense * 100.0, stride=1.0))  # type: ignore[arg-type]
    assert leg.turns[1] == pytest.approx(sense * (100 - 10 * leg.turns[0]), rel=1e-6)
    turns = (100 * 8 - 5 * 8**2) / (2 * math.pi)
    assert leg.turns.shape[1] == int(turns), "one each turn"
    record = Record(end=None, start_speed=sense * 100.0, stride=1.0).update(leg)  # type: ignore[arg-type]
    assert record.half_time == pytest.approx(5.0, abs=1e-6)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_without_a_turn_the_speed_itself_halves(monkeypatch: pytest.MonkeyPatch, sense: float) -> None:
    time = np.linspace(0.0, 1.0, 101)
    before = Record(end=None, start_speed=sense, stride=1.0)  # type: ignore[arg-type]
    record = before.update(reduced(monkeypatch, time, sense * np.exp(-time), before))
    assert record.half_time == pytest.approx(math.log(2.0), abs=1e-6)
    later = before.update(reduced(monkeypatch, time, sense * np.exp(-time / 9), before))
    assert later.half_time is None and later.halving.shape == (2, 2)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_ripple_within_a_turn_does_not_halve_the_speed(monkeypatch: pytest.MonkeyPatch, sense: float) -> None:
    """It falls from 100 to 60 rad/s, but within each turn to 20 rad/s at last."""
    time = np.linspace(0.0, 4.0, 8001)
    speed = 100 - 10 * time
    angle = 100 * time - 5 * time**2
    before = Record(end=None, start_speed=sense * 100.0, stride=1.0)  # type: ignore[arg-type]
    record = before.update(reduced(monkeypatch, time, sense * (speed - 0.65 * speed * np.cos(angle)), before))
    assert record.averages > 8 and record.half_time is None
