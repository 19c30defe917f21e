"""How fast a parameter is swept, where a ramp is steep, and when it was too fast."""

from __future__ import annotations

import math
from typing import Any

import pytest
from tests.refusals import refused

from wucht.dynamics.sweeps.jumps import Jump, candidates, hysteresis
from wucht.dynamics.sweeps.moving import SweepLeg, _inertia, _response_time, is_too_fast, moving_system, sweep_pace
from wucht.files.building import machine_from
from wucht.machines.schedules import SCHEDULE_WORK

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


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_sweep_is_too_fast_by_the_size_of_its_speeds(sense: float) -> None:
    """In either sense of rotation: where the speed changes by more than a hundredth of the largest one after the ramp."""

    def leg(speed: float, modulation: float = 0.0) -> SweepLeg:
        nowhere: Any = None
        low, high = (sense * speed * (1 + share * modulation) for share in (-0.5, 0.5))
        return SweepLeg(nowhere, 8.0, sense * speed, min(low, high), max(low, high), 1e-3, 0.0)

    settled_leg = leg(5.0)
    assert is_too_fast(settled_leg, [leg(5.06)]) and not is_too_fast(settled_leg, [leg(5.04)])
    assert not is_too_fast(settled_leg, [leg(5.1, 0.04)]), "what swings is at no time at its mean"
    assert not is_too_fast(settled_leg, [leg(600.0), leg(5.06)]), "small beside the largest speed"
    assert not is_too_fast(settled_leg, []), "before the first ramp"


def jump(value: float, direction: str) -> Jump:
    return Jump(value, 1.0, 2.0, direction, 0.1, 0.2, True, False, (value, value))


@pytest.mark.parametrize(
    ("up", "down", "expected"),
    [
        ((140.0,), (120.0,), [120.0, 140.0]),
        ((100.0, 140.0), (120.0, 130.0), [120.0, 140.0]),
        ((100.0, 140.0), (90.0, 150.0), [90.0, 140.0]),
        ((110.0,), (120.0,), None),
        ((110.0,), (), None),
        ((), (110.0,), None),
        ((), (), None),
    ],
)
def test_from_the_first_jump_down_to_the_last_one_up(
    up: tuple[float, ...], down: tuple[float, ...], expected: list[float] | None
) -> None:
    jumps = [*(jump(v, "up") for v in up), *(jump(v, "down") for v in down)]
    assert hysteresis(jumps) == expected
