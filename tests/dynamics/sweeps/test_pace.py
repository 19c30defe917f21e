"""How fast a parameter is swept, where a ramp is steep, and the averages of a leg, by hand."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from tests.refusals import refused

from wucht.dynamics.sweeps import moving
from wucht.dynamics.sweeps.jumps import _Search, candidates
from wucht.dynamics.sweeps.moving import Mover, Place, SweepLeg, _inertia, _response_time, moving_system, rate_unit, sweep_pace
from wucht.files.building import machine_from
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.numerics.observers.energy_balance import EnergyBalance

INERTIA, SLOPE, MASS = 0.1, 0.5, 4.0


def machine(speeds: tuple[float, ...] = (200.0,), damping: float = 400.0, slope: float = SLOPE, **more: Any) -> Any:
    """Rotors on motors of the slope k, the first one with a point mass of 0.5 kg at 0.2 m; c = 4e4 N/m."""
    names = "abc"[: len(speeds)]
    rotors = [{"kind": "rotor", "name": n, "mass": 1.0, "unbalance": 1e-3, "inertia": INERTIA} for n in names]
    ball = {"kind": "pendulum", "name": "p", "about": "a", "mass": 0.5, "length": 0.2, "damping": 0.01}
    drives = [{"on": n, "kind": "linear", "slope": slope, "no_load_speed": s} for n, s in zip(names, speeds, strict=True)]
    return machine_from({
        "carrier": {"mass": MASS - 1.5, "directions": "x", "stiffness": 4e4, "damping": damping},
        "bodies": [*rotors, ball], "drives": drives,
    } | more)  # fmt: skip


def pace(of: Any, low: float = 100.0, high: float = 300.0, rate: float | None = None, path: str = "drive.no_load_speed") -> Any:
    return sweep_pace(of, path, low, high, rate)


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_the_response_time_is_that_of_the_slowest_decay(sense: float) -> None:
    """Of the carrier 2 M/d, of a motor (J + m l^2)/k."""
    inertia = INERTIA + 0.5 * 0.2**2
    of = machine((sense * 200.0,), damping=4.0)
    assert _inertia(of, of.rotor) == pytest.approx(inertia, rel=1e-12)
    assert _response_time(of) == pytest.approx(2 * MASS / 4.0, rel=1e-6)
    assert _response_time(machine((sense * 200.0,), damping=4e2, slope=1e-2)) == pytest.approx(inertia / 1e-2, rel=1e-6)
    undamped = machine((sense * 200.0,), damping=0.0, slope=1e-2)
    assert _response_time(undamped) == pytest.approx(inertia / 1e-2, rel=1e-6), "what does not decay has no time"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_time_scales_of_a_sweep(sense: float) -> None:
    """The drive reaches 300 rad/s at most, the natural frequency is 100 rad/s, and the slowest speed 50 rad/s."""
    ends = sorted((sense * 50.0, sense * 300.0))
    of = pace(machine((sense * 200.0,), damping=4.0), *ends)
    assert (of.fastest, of.driven) == pytest.approx((300.0, 300.0))
    assert of.turn == pytest.approx(2 * math.pi / 50.0)
    assert of.response_time == pytest.approx(2.0, rel=1e-3) and of.rate == pytest.approx(250.0 / 2000.0, rel=1e-3)
    assert (of.samples, of.step * of.samples, of.rate_unit) == (400, pytest.approx(2000.0, rel=1e-3), "rad/s per s")
    slow = machine((sense * 200.0,), damping=4.0)
    quick = pace(slow, *ends, rate=100.0)
    assert quick.samples == max(8, int(2.5 / (3 * of.turn))) and quick.rate == 100.0 and not quick.warnings


def test_all_rotors_count() -> None:
    of = pace(machine((200.0, -700.0)), 150.0, 300.0, path="drives.a.no_load_speed")
    assert (of.fastest, of.driven) == pytest.approx((700.0, 700.0))
    of = pace(machine((200.0, -20.0)), 150.0, 300.0, path="drives.a.no_load_speed")
    assert of.turn == pytest.approx(2 * math.pi / 20.0)


def test_a_slow_machine_is_not_waited_for() -> None:
    """100,000 turns at the fastest speed."""
    of = pace(machine(damping=4e-2))
    assert len(of.warnings) == 1 and of.rate == pytest.approx(200.0 / (100_000 * 2 * math.pi / 300.0))


def test_the_bounds_of_a_rate() -> None:
    """A tenth of the shortest response time (here a turn at the natural frequency or less), and ten million turns."""
    of = machine(damping=4.0)
    lowest, highest = 200.0 / (1e7 * 2 * math.pi / 300.0), 200.0 / 0.2
    for rate in (1.05 * lowest, 0.95 * highest):
        assert pace(of, rate=rate).rate == pytest.approx(rate)
    for rate in (0.95 * lowest, 1.05 * highest):
        with refused("study.rate", given=rate):
            pace(of, rate=rate)


def test_the_unit_of_a_rate() -> None:
    units: Any = SimpleNamespace(parameters={"k": SimpleNamespace(unit="N/m")}, units=SimpleNamespace(time="s"))
    assert rate_unit(units, "k") == "N/m per s"
    units = SimpleNamespace(parameters={"k": SimpleNamespace(unit="")}, units=SimpleNamespace(time=""))
    assert rate_unit(units, "k") == "a unit of time"


@pytest.mark.parametrize("speed", [50.0, -50.0])
def test_a_modulation_is_a_share_of_the_speed_without_its_sign(speed: float) -> None:
    leg = SweepLeg(None, 1.0, speed, speed - 1.0, speed + 1.5, 0.1, 0.0)  # type: ignore[arg-type]
    assert leg.modulation == pytest.approx(0.05)
    assert SweepLeg(None, 1.0, 0.0, -1.0, 1.0, 0.1, 0.0).modulation == 0.0  # type: ignore[arg-type]


def test_the_work_of_a_changing_stiffness() -> None:
    """dV/dc dc/dt = x^2/2 times the rate; and the parameter is base + rate (t - origin)."""
    of = machine()
    system = moving_system(of, "carrier.stiffness")
    (work,) = [q for q in system.quadratures if q.name == SCHEDULE_WORK]
    symbols = {s.name: s for s in work.expression.free_symbols}
    x = of.free_carrier[0].position.name
    value = float(work.expression.subs({symbols[x]: 0.03, symbols["sweep.rate"]: 200.0}))
    assert value == pytest.approx(0.03**2 / 2 * 200.0)
    definition = dict(system.definitions)[next(s for s, _ in system.definitions if s.name == "carrier.stiffness")]
    at = {s: {"sweep.base": 5.0, "sweep.rate": 2.0, "sweep.origin": 3.0}.get(s.name, 7.0) for s in definition.free_symbols}
    assert float(definition.subs(at)) == 5.0 + 2.0 * (7.0 - 3.0)


def averaged(monkeypatch: pytest.MonkeyPatch, angle: Any, speed: Any) -> tuple[SweepLeg, list[dict[str, float]]]:
    """A leg of 12.3 s from 5 s on, whose value goes from 100 to 200, and the values for which the axis' rest is sought."""
    coordinate = SimpleNamespace(position=SimpleNamespace(name="phi"), velocity=SimpleNamespace(name="omega"))
    given = list[dict[str, float]]()
    machine = SimpleNamespace(rotor=SimpleNamespace(coordinate=coordinate), with_unchecked_values=given.append)
    moved: Any = SimpleNamespace(machine=machine, path="c", compiled_system=None)
    monkeypatch.setattr(moving, "axis_at_rest", lambda _: None)
    monkeypatch.setattr(moving.AxisMotion, "of", lambda *_: SimpleNamespace(peaks=np.array([0.1, 0.25, 0.2])))
    late = np.linspace(0.0, 12.3, 12 * 64 + 1)
    rows = {"phi": angle(late), "omega": speed(late)}
    place, end = (Place(t, v, (), (), EnergyBalance()) for t, v in ((5.0, 100.0), (17.3, 200.0)))
    trajectory: Any = SimpleNamespace(time=5.0 + late)
    leg = Mover(moved, lambda _: None)._average_turns(trajectory, rows, place, end, 100 / 12.3, 1e-9)
    assert (leg.amplitude, leg.energy_residual, leg.place) == (0.25, 1e-9, end)
    return leg, given


TURN = 2 * math.pi


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_averages_of_a_leg_over_its_whole_turns(monkeypatch: pytest.MonkeyPatch, sense: float) -> None:
    """The speed rises by 2 %. Averages over a turn end from 1 s on; the last 11 turns count, and the value in their middle."""
    rise = 0.02 / 12.3
    leg, given = averaged(monkeypatch, lambda t: sense * TURN * (t + rise * t**2 / 2), lambda t: sense * TURN * (1 + rise * t))
    assert leg.speed == pytest.approx(sense * TURN * (1 + rise * 6.8), rel=2e-4)
    ends = sorted((sense * TURN * (1 + rise * 0.5), sense * TURN * (1 + rise * 11.8)))
    assert (leg.low, leg.high) == pytest.approx(tuple(ends), rel=4e-4)
    assert leg.value == pytest.approx(100.0 + 100 / 12.3 * 6.8, abs=1.0) and given == [{"c": leg.value}]


def test_after_a_rotor_has_turned_back_its_turns_count_anew(monkeypatch: pytest.MonkeyPatch) -> None:
    leg, _ = averaged(monkeypatch, lambda t: TURN * np.minimum(t, 12.0 - t), lambda t: TURN * np.where(t < 6.0, 1.0, -1.0))
    assert leg.speed == pytest.approx(-TURN, rel=1e-6) and leg.high == pytest.approx(-TURN, rel=1e-2)


def test_less_than_a_turn_has_one_mean_speed(monkeypatch: pytest.MonkeyPatch) -> None:
    leg, _ = averaged(monkeypatch, lambda t: 0.1 * t + 0.01 * t**2, lambda t: 0.1 + 0.02 * t)
    assert leg.speed == leg.low == leg.high == pytest.approx(0.1 + 0.123)
    assert leg.value == pytest.approx(150.0)


class Signals:
    """A ramp whose legs are their signals."""

    def signal(self, leg: float) -> float:
        return leg


def steep(*jumps: tuple[int, float], count: int = 60, slope: float = 0.1) -> list[float]:
    """A line of a slope a leg, with jumps after some legs."""
    return [slope * k + sum(size for at, size in jumps if k > at) for k in range(count)]


@pytest.mark.parametrize("way", [1.0, -1.0])
def test_the_legs_before_and_after_a_steep_place(way: float) -> None:
    mover: Any = Signals()

    def found(*jumps: tuple[int, float]) -> list[tuple[int, int]]:
        return candidates(mover, [way * y for y in steep(*jumps)])  # type: ignore[misc]

    assert found((20, 5.0)) == [(20, 21)]
    assert found((40, 5.0), (20, -3.0)) == [(20, 21), (40, 41)], "in the order of the ramp"
    assert found((20, 5.0), (21, 4.0)) == [(20, 22)], "what changes over two legs is one"
    assert found((20, 5.0), (21, 1.0)) == [(20, 21)], "a fifth of the change belongs to the branch"
    assert found((20, 5.0), (23, 4.0)) == [(20, 24)] and found((20, 5.0), (24, 4.0)) == [(20, 21), (24, 25)]
    assert found() == [] and candidates(mover, [1.0, 9.0, 9.0]) == []  # type: ignore[list-item]
    assert len(found(*((5 * k, 3.0 + k) for k in range(1, 11)))) == 8 and found(*((5 * k, 3.0 + k) for k in range(1, 11)))[
        0
    ] == (15, 16), "the eight largest"


class Settling:
    """A machine held at a value, whose signal comes to its end after some windows."""

    def __init__(self, signals: list[float], driven: bool = True) -> None:
        coordinate = SimpleNamespace(prescribed_velocity=None if driven else 1.0)
        self.moved_machine = SimpleNamespace(
            pace=SimpleNamespace(response_time=3.0, turn=1.0, rate=1.0, samples=100, step=2.0),
            machine=SimpleNamespace(rotor=SimpleNamespace(coordinate=coordinate)),
        )
        self.signals, self.windows = iter(signals), list[float]()

    def signal(self, leg: Any) -> float:
        return float(leg.speed)

    def leg(self, place: Any, duration: float, to: float | None = None) -> Any:
        self.windows.append(duration)
        value = place.value if to is None else to
        here = SimpleNamespace(time=place.time + duration, value=value)
        return SimpleNamespace(place=here, speed=next(self.signals), low=1.0, high=2.0)


def held(signals: list[float], wait: float = math.inf) -> tuple[Any, float | None, Any]:
    mover: Any = Settling(signals)
    leg, left = _Search(mover, after=20.0, tolerance=1e-4)._hold(SimpleNamespace(time=7.0, value=1.0), 2.0, 10.0, wait)
    return leg, left, mover


def test_a_machine_stays_where_two_windows_in_a_row_change_nothing() -> None:
    leg, left, mover = held([10.0, 10.1, 10.1, 10.2, 10.2, 10.2, 99.0])
    assert left is None and leg.speed == 10.2 and len(mover.windows) == 6 and set(mover.windows) == {6.0}
    assert leg.place.value == 2.0
    _, left, _ = held([10.0, 10.0, 15.1])
    assert left == pytest.approx(3 * 6.0), "nearer to the state after the jump, the time since it was moved"
    leg, left, mover = held([10.0 + 0.1 * k for k in range(40)], wait=70.0)
    assert left is None and len(mover.windows) == 12, "or it has stayed for longer than it is waited, eleven windows at least"


@pytest.mark.parametrize("driven", [True, False])
def test_modulations_overlap_in_the_speed_alone(driven: bool) -> None:
    search = _Search(Settling([], driven), after=20.0, tolerance=1e-4)  # type: ignore[arg-type]
    first, second, third = (SimpleNamespace(low=low, high=high) for low, high in ((1.0, 3.0), (2.9, 4.0), (3.1, 4.0)))
    assert search.overlap(first, second) is driven  # type: ignore[arg-type]
    assert search.overlap(second, first) is driven and not search.overlap(third, first)  # type: ignore[arg-type]


def test_the_width_of_a_bracket() -> None:
    """A share of the value, whichever sign it has, or of a thousandth of the range."""
    search = _Search(Settling([]), after=20.0, tolerance=1e-4)  # type: ignore[arg-type]
    assert [search._width(v) for v in (50.0, -50.0, 0.0, 0.1)] == pytest.approx([5e-3, 5e-3, 2e-5, 2e-5])


def test_the_last_leg_at_which_it_stays_is_sought_twice_as_far_back_each_time() -> None:
    legs = [SimpleNamespace(place=SimpleNamespace(value=float(k), time=0.0), speed=float(k)) for k in range(10)]

    class Search(_Search):
        def _hold(self, place: Any, value: float, before: float, wait: float) -> Any:
            assert (place.value, before, wait) == (value, value, math.inf)
            return f"held at {value}", None if value <= self.after else 5.0

    def last(stays: float) -> Any:
        return Search(Settling([]), stays, 1e-4).last_steady(legs)  # type: ignore[arg-type]

    assert last(9.0) == ("held at 9.0", None, legs[9]) and last(8.5) == ("held at 8.0", None, legs[8])
    assert last(7.9) == ("held at 6.0", None, legs[6]) and last(5.0) == ("held at 2.0", None, legs[2])
    assert last(0.0) == ("held at 0.0", None, legs[0]) and last(-1.0) == ("held at 0.0", 5.0, legs[9])


@pytest.mark.parametrize(("driven", "signal"), [(True, 5.0), (False, 0.25)])
def test_the_signal_is_the_speed_or_where_that_is_prescribed_the_amplitude(driven: bool, signal: float) -> None:
    moved: Any = Settling([], driven).moved_machine
    leg: Any = SimpleNamespace(speed=5.0, amplitude=0.25)
    assert Mover(moved, lambda _: None).signal(leg) == signal
