"""The fold at which a branch ends: the vertex of the parabola through steady states beside it."""

from __future__ import annotations

import math
from types import SimpleNamespace
from typing import Any

import pytest

from wucht.dynamics.sweeps.jumps import _Search

FOLD, SPEED, WIDTH = 120.0, 80.0, 1e-2


class Branch:
    """A machine whose speed is SPEED - sense sqrt(sense (FOLD - value)/a) where it stays, with the amplitude 3 (speed - 70)."""

    def __init__(self, sense: float, bend: float) -> None:
        self.sense, self.bend = sense, bend
        pace = SimpleNamespace(response_time=1.0, turn=0.1, rate=1.0, samples=1, step=1.0)
        self.moved_machine = SimpleNamespace(pace=pace)

    def at(self, value: float) -> Any:
        speed = SPEED - math.sqrt(max(self.sense * (FOLD - value), 0.0) / self.bend)
        return SimpleNamespace(
            value=value, speed=speed, amplitude=3 * (speed - 70.0), place=SimpleNamespace(value=value, time=0.0)
        )

    def signal(self, leg: Any) -> float:
        return float(leg.speed)

    def leg(self, _: Any, __: float, value: float) -> Any:
        return self.at(value)

    def settle(self, place: Any) -> tuple[Any, bool]:
        return self.at(place.value), True


@pytest.mark.parametrize("sense", [1.0, -1.0])
@pytest.mark.parametrize("bend", [0.3, 2.0])
@pytest.mark.parametrize("share", [0.1, 0.5, 0.9])
def test_the_vertex_is_the_fold(sense: float, bend: float, share: float) -> None:
    """share: of the bracket, where the fold lies in it."""
    branch, gap = Branch(sense, bend), WIDTH
    low, high = branch.at(FOLD - sense * share * gap), FOLD + sense * (1 - share) * gap
    vertex = _Search(branch, after=200.0, tolerance=WIDTH / FOLD)._vertex(low, high)  # type: ignore[arg-type]
    assert vertex is not None
    value, speed, amplitude = vertex
    assert value == pytest.approx(FOLD, abs=1e-3 * WIDTH)
    assert speed == pytest.approx(SPEED, abs=3e-3)
    assert amplitude == pytest.approx(30.0, abs=1e-2)


def test_a_parabola_that_ends_elsewhere_is_no_fold() -> None:
    """The steady states end beyond the bracket: the branch loses its stability in another way."""
    branch = Branch(1.0, 1.0)
    low = branch.at(FOLD - 40 * WIDTH)
    assert _Search(branch, after=200.0, tolerance=WIDTH / FOLD)._vertex(low, low.value + WIDTH) is None  # type: ignore[arg-type]
