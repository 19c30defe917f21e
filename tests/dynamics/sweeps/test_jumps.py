"""Whether a steep place of a ramp is a jump: what holding the parameter says about it, the legs being made by hand."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

from wucht.dynamics.sweeps import jumps
from wucht.dynamics.sweeps.jumps import find_jump

BEFORE, LANDED = 10.0, 20.0  # rad/s, before the jump and beyond it


def leg(value: float, speed: float, low: float | None = None, high: float | None = None) -> Any:
    low, high = (speed if end is None else end for end in (low, high))
    return SimpleNamespace(place=SimpleNamespace(value=value), speed=speed, amplitude=0.1 * speed, low=low, high=high)


class Mover:
    """One that lands at ``LANDED``."""

    moved_machine = SimpleNamespace(
        machine=SimpleNamespace(rotor=SimpleNamespace(coordinate=SimpleNamespace(prescribed_velocity=None)))
    )

    def signal(self, leg: Any) -> float:
        return float(leg.speed)

    def settle(self, place: Any) -> tuple[Any, bool]:
        return leg(place.value, LANDED), True


CLOSED_IN = object()


def answer(monkeypatch: pytest.MonkeyPatch, held: Any, left_after: float | None, seen: Any) -> Any:
    monkeypatch.setattr(jumps._Search, "last_steady", lambda *_: (held, left_after, seen))
    monkeypatch.setattr(jumps._Search, "close_in", lambda *_: CLOSED_IN)
    return find_jump(Mover(), [leg(1.0, BEFORE), leg(2.0, BEFORE), leg(3.0, LANDED)], 1, 2, 1e-4)  # type: ignore[arg-type]


@pytest.mark.parametrize("speed", [BEFORE, BEFORE + 3.0, BEFORE - 3.0])
def test_it_is_closed_in_if_the_machine_stays_in_the_state_before(monkeypatch: pytest.MonkeyPatch, speed: float) -> None:
    """Held, the signal changes by three tenths of the jump at most."""
    assert answer(monkeypatch, leg(2.0, speed), None, leg(2.0, BEFORE)) is CLOSED_IN


@pytest.mark.parametrize(("speed", "left_after"), [(BEFORE + 3.01, None), (BEFORE - 3.01, None), (BEFORE, 5.0)])
def test_it_is_only_seen_by_the_ramp_if_it_does_not_stay(
    monkeypatch: pytest.MonkeyPatch, speed: float, left_after: float | None
) -> None:
    """Or the ramp was in another state than the one in which it stays."""
    jump = answer(monkeypatch, leg(2.0, speed), left_after, leg(2.0, BEFORE))
    assert (jump.only_seen, jump.direction, jump.bracket) == (True, "up", (2.0, 3.0))
    assert (jump.value, jump.from_speed, jump.to_speed) == (2.5, BEFORE, LANDED)


def test_modulations_that_overlap_are_no_jump(monkeypatch: pytest.MonkeyPatch) -> None:
    """Of the state in which it stays, else of that which was seen, with where it lands."""
    wide = leg(2.0, BEFORE, 5.0, LANDED + 1.0)
    monkeypatch.setattr(Mover, "settle", lambda _, place: (leg(place.value, LANDED, LANDED - 1.0, LANDED + 2.0), True))
    assert answer(monkeypatch, wide, None, leg(2.0, BEFORE)) is None
    assert answer(monkeypatch, leg(2.0, BEFORE), None, wide) is CLOSED_IN
    assert answer(monkeypatch, leg(2.0, BEFORE), 5.0, wide) is None
    assert answer(monkeypatch, wide, 5.0, leg(2.0, BEFORE)).only_seen


@pytest.mark.parametrize(("ends", "way"), [((1.0, 2.0), "up"), ((2.0, 1.0), "down")])
def test_a_jump_lies_between_a_lower_and_an_upper_value_whichever_way_it_is_passed(ends: tuple[float, float], way: str) -> None:
    jump = jumps._jump(ends, leg(1.0, BEFORE), leg(2.0, LANDED))
    assert (jump.bracket, jump.direction, jump.value) == ((1.0, 2.0), way, 1.5)
