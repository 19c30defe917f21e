"""Legs of a sweep: how long they are held, where they are sampled, what they carry on; and how a jump is closed in."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.sweeps import moving
from wucht.dynamics.sweeps.jumps import _Search, candidates
from wucht.dynamics.sweeps.moving import IntegrationError, Mover, Place, SweepLeg, is_too_fast
from wucht.dynamics.verdicts.outcomes import MODULATION_THRESHOLD
from wucht.numerics.observers.energy_balance import EnergyBalance

TURN = 2 * math.pi


class Held(Mover):
    """A machine that is held, with given speeds and amplitudes of its legs, the last ones for ever."""

    def leg(self, place: Any, duration: float, to: float | None = None) -> Any:
        speeds, windows = self.moved_machine.compiled_system  # type: ignore[misc]
        speed, amplitude = speeds[min(len(windows), len(speeds) - 1)]
        windows.append(duration)
        return SimpleNamespace(place=place + 1, speed=speed, amplitude=amplitude, modulation=self.report)


def settled(
    *speeds: tuple[float, float], largest: tuple[float, float] = (0.0, 0.0), modulation: float = 0.0, response_time: float = 3.0
) -> tuple[Any, bool, list[float]]:
    windows = list[float]()
    moved: Any = SimpleNamespace(pace=SimpleNamespace(response_time=response_time, turn=1.0))
    moved.compiled_system = speeds, windows
    leg, steady = Held(moved, modulation).settle(0, largest)  # type: ignore[arg-type]
    return leg, steady, windows


def test_it_is_held_until_two_windows_in_a_row_change_nothing() -> None:
    """Of five response times, eight turns at least."""
    leg, steady, windows = settled((10.0, 0.1))
    assert steady and windows == [15.0] * 3 and leg.place == 3
    assert settled((10.0, 0.1), response_time=1.0)[2] == [8.0] * 3
    assert len(settled((10.0, 0.1), (10.0, 0.1), (11.0, 0.1))[2]) == 5, "two in a row"


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_what_is_no_change(sense: float) -> None:
    """A millionth of the largest speed so far, and a hundred-thousandth of the largest amplitude."""
    for change, count in ((0.9e-4, 3), (1.1e-4, 4)):
        assert len(settled((sense * 100.0, 0.1), (sense * (100.0 - change), 0.1))[2]) == count
        assert len(settled((0.0, 0.1), (sense * change, 0.1), largest=(100.0, 0.0))[2]) == count, "also at a standstill"
    for change, count in ((0.9e-6, 3), (1.1e-6, 4)):
        assert len(settled((sense * 100.0, 0.1), (sense * 100.0, 0.1 - change))[2]) == count
        assert len(settled((sense * 100.0, 0.0), (sense * 100.0, change), largest=(0.0, 0.1))[2]) == count
    falling = [(100.0, 0.1), (1.0, 0.1), (1.00009, 0.1)]
    assert len(settled(*falling)[2]) == 4, "the largest speed of all windows counts"


@pytest.mark.parametrize("share", [0.99, 1.01])
def test_what_never_rests_is_modulated_or_not_steady(share: float) -> None:
    never = [(float(k), 0.1) for k in range(100)]
    leg, steady, windows = settled(*never, modulation=share * MODULATION_THRESHOLD)
    assert len(windows) == 61 and leg.speed == 60.0 and steady is (share > 1)


def mover(monkeypatch: pytest.MonkeyPatch, run: Any) -> Mover:
    """A rotor at 10 rad/s, and a pendulum about it; one quadrature."""
    names = ("phi", "omega", "psi")
    phi, omega, psi = (SimpleNamespace(name=name) for name in names)
    rotor, ball = (SimpleNamespace(coordinate=SimpleNamespace(position=p, velocity=omega)) for p in (phi, psi))
    machine = SimpleNamespace(
        rotor=rotor,
        rotors=(rotor,),
        group=lambda _: (rotor, ball),
        with_unchecked_values=lambda _: None,
        values={"c": 4.0, "k": 7.0},
    )
    system = SimpleNamespace(
        state_names=names, states=(phi, omega, psi), quadratures=(SimpleNamespace(name="w"),),
        parameter_names=("k", "base", "rate", "origin"),
    )  # fmt: skip
    moved = SimpleNamespace(machine=machine, path="c", pace=SimpleNamespace(fastest=10.0), energy=2.0, initial=np.arange(3.0))
    moved.compiled_system = SimpleNamespace(system=system)
    monkeypatch.setattr(Mover, "_run", run)
    monkeypatch.setattr(
        moving,
        "rows_of",
        lambda _, t: {"phi": 10 * t.time, "omega": np.full(len(t.time), 10.0), "stored_energy": np.zeros(len(t.time))},
    )
    monkeypatch.setattr(moving, "axis_at_rest", lambda _: None)
    monkeypatch.setattr(moving.AxisMotion, "of", lambda *_: SimpleNamespace(peaks=np.array([0.25])))
    return Mover(moved, lambda _: None)  # type: ignore[arg-type]


def grids_of(monkeypatch: pytest.MonkeyPatch, duration: float, to: float | None = None) -> tuple[Any, list[Any], list[Any]]:
    grids, parameters, works = list[np.ndarray](), list[list[float]](), list[float]()

    def run(_: Any, grid: np.ndarray, state: np.ndarray, given: np.ndarray) -> Any:
        grids.append(grid)
        parameters.append(given.tolist())
        assert state[3] == (0.0 if len(grids) == 1 else works[-1]), "each piece goes on from the one before"
        works.append(state[3] + 1.5)
        end = np.array([*state[:3], works[-1]])
        return SimpleNamespace(
            time=grid, end_state=end, final_parameter_values=given, quadratures={"w": np.full(len(grid), works[-1])}
        )

    seen = list[dict[str, np.ndarray]]()
    monkeypatch.setattr(
        moving, "advance_balance", lambda balance, stored, given: (seen.append(given), (balance, np.zeros(len(stored))))[1]
    )
    at = Place(5.0, 100.0, (3 * TURN + 0.5, 10.0, 2.0, 40.0), (7.0,), EnergyBalance())
    leg = mover(monkeypatch, run).leg(at, duration, to)
    assert seen[0]["w"].tolist() == [40.0 + works[-1]] * len(grids[-1]), "works since the beginning"
    assert leg.place.state == pytest.approx((0.5, 10.0, 2.0 - 3 * TURN, 40.0 + works[-1]))
    assert leg.place.parameter_values == (7.0,)
    return leg, grids, parameters


def test_a_short_leg_is_sampled_throughout(monkeypatch: pytest.MonkeyPatch) -> None:
    """32 samples a turn at the fastest speed, eight at least."""
    leg, (grid,), (given,) = grids_of(monkeypatch, 2.0, 110.0)
    assert (grid[0], grid[-1], len(grid)) == (5.0, 7.0, 1 + 102)
    assert given == [7.0, 100.0, 5.0, 5.0], "other parameters, base, rate and origin of the ramp"
    assert (leg.place.time, leg.place.value) == (7.0, 110.0)
    _, (grid,), (given,) = grids_of(monkeypatch, 0.1)
    assert len(grid) == 9 and given == [7.0, 100.0, 0.0, 5.0]


def test_of_a_long_leg_the_last_two_hundred_turns_are_sampled(monkeypatch: pytest.MonkeyPatch) -> None:
    """Before them there are checks for interruption after two hundred turns each at most."""
    leg, (*pieces, last), _ = grids_of(monkeypatch, 1000.0)
    assert (last[-1] - last[0], last[-1], len(last)) == (pytest.approx(200 * TURN / 10), 1005.0, pytest.approx(6401, abs=1))
    edges = [piece.tolist() for piece in pieces]
    assert len(edges) == math.ceil((1000.0 - 20 * TURN) / (20 * TURN)) == 7 and all(len(piece) == 2 for piece in edges)
    assert edges[0][0] == 5.0 and edges[-1][1] == pytest.approx(last[0])
    assert [b for _, b in edges[:-1]] == [a for a, _ in edges[1:]] and np.ptp([b - a for a, b in edges]) < 1e-9
    assert leg.place.value == 100.0 and leg.speed == pytest.approx(10.0)


def test_where_a_sweep_begins(monkeypatch: pytest.MonkeyPatch) -> None:
    place = mover(monkeypatch, None).begin()
    assert (place.time, place.value, place.state, place.parameter_values) == (0.0, 4.0, (0.0, 1.0, 2.0, 0.0), (7.0,))


@pytest.mark.parametrize(
    ("angle", "turns"), [(TURN + 0.5, 1), (-TURN - 0.5, -1), (0.45 * TURN, 0), (0.55 * TURN, 1), (-4.0, -1)]
)
def test_whole_turns_of_a_rotor_are_taken_off_all_that_turns_with_it(
    monkeypatch: pytest.MonkeyPatch, angle: float, turns: int
) -> None:
    of = mover(monkeypatch, None)
    state = of._without_turns(Place(0.0, 1.0, (angle, 10.0, 2.0, 9.0), (), EnergyBalance()))
    assert state == pytest.approx([angle - turns * TURN, 10.0, 2.0 - turns * TURN, 0.0])


def test_a_leg_that_breaks_off(monkeypatch: pytest.MonkeyPatch) -> None:
    of = Mover(SimpleNamespace(energy=2.0, compiled_system=None), None)  # type: ignore[arg-type]
    for failure in ("it burst", None):
        result = SimpleNamespace(failure=failure)
        monkeypatch.setattr(moving, "integrate", lambda *_, result=result: SimpleNamespace(reraise_interrupt=lambda: result))
        if failure is None:
            assert of._run(np.zeros(1), np.zeros(1), np.zeros(1)) is result
        else:
            with pytest.raises(IntegrationError, match="it burst"):
                of._run(np.zeros(1), np.zeros(1), np.zeros(1))


class Signals:
    def signal(self, leg: float) -> float:
        return leg


def test_what_a_branch_rises_by_itself_is_no_part_of_a_jump() -> None:
    """A slope of 1 over 60 legs; beyond it a jump has more than 2 % of the whole range."""
    for step, jumps in ((2.15, []), (2.3, [(20, 21)])):
        legs = [float(k) + (step - 1 if k > 20 else 0.0) for k in range(61)]
        assert candidates(Signals(), legs) == jumps  # type: ignore[arg-type]


FOLD, LOW, HIGH = 120.0, 10.0, 20.0


class Bracket(_Search):
    """A machine that stays up to the fold, from below if the sense is 1; each wait is kept."""

    sense = 1.0

    def _hold(self, place: Any, value: float, before: float, wait: float) -> Any:
        assert before == LOW
        waits.append((value, wait))
        stays = self.sense * value <= self.sense * FOLD
        return SimpleNamespace(place=SimpleNamespace(value=value), speed=LOW, amplitude=1.0), None if stays else 7.0

    def overlap(self, first: Any, second: Any) -> bool:
        return overlapping

    def _vertex(self, low: Any, high: float) -> Any:
        return None


waits, overlapping = list[tuple[float, float]](), False


@pytest.mark.parametrize("sense", [1.0, -1.0])
def test_a_jump_is_bracketed_by_halving(monkeypatch: pytest.MonkeyPatch, sense: float) -> None:
    """Beyond the fold the branch was left after 7 s: three times that, the longer the nearer, is waited from then on."""
    waits.clear()
    monkeypatch.setattr(Bracket, "sense", sense)

    def settle(place: Any) -> tuple[Any, bool]:
        return SimpleNamespace(place=place, speed=HIGH, amplitude=2.0), True

    pace = SimpleNamespace(rate=1.0, samples=100, step=1.0)
    of: Any = SimpleNamespace(signal=lambda leg: leg.speed, settle=settle, moved_machine=SimpleNamespace(pace=pace))
    low = SimpleNamespace(place=SimpleNamespace(value=FOLD - sense * 3.0), speed=LOW, amplitude=1.0)
    search, beyond = Bracket(of, HIGH, 1e-3), SimpleNamespace(value=FOLD + sense * 5.0)
    jump = search.close_in(low, beyond, 10.0)  # type: ignore[arg-type]
    assert jump is not None and jump.bracket[0] <= FOLD <= jump.bracket[1]
    assert jump.bracket[1] - jump.bracket[0] == pytest.approx(8.0 / 128) and 8.0 / 64 > 1e-3 * 120
    assert (jump.from_speed, jump.to_speed, jump.to_amplitude) == (LOW, HIGH, 2.0)
    assert (jump.direction, jump.fold, jump.only_seen) == ("up" if sense > 0 else "down", False, False)
    assert waits[0] == (FOLD + sense, math.inf)
    assert waits[1][1] == pytest.approx(3 * 7.0 * math.sqrt(4.0 / (1e-3 * (FOLD + sense))))
    assert search.close_in(low, beyond, 50.1) is None, "a fifth of the change is left at least"  # type: ignore[arg-type]
    assert search.close_in(low, beyond, 49.9) is not None  # type: ignore[arg-type]
    monkeypatch.setitem(globals(), "overlapping", True)
    assert search.close_in(low, beyond, 10.0) is None  # type: ignore[arg-type]


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
