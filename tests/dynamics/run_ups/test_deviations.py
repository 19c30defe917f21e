"""How far two runs are apart, at equal angle and at equal mean phase, on curves whose difference is known on paper."""

from __future__ import annotations

import numpy as np
import pytest

from wucht.dynamics.run_ups.deviations import ComparedMotion, Deviations, deviations_by_angle, deviations_by_phase

ANGLE = np.linspace(0.0, 100.0, 1001)


def course(angle: np.ndarray, phase: np.ndarray | None = None, speed: float = 2.0) -> ComparedMotion:
    """speed = ``speed`` + angle/100, radius = angle/50."""
    return ComparedMotion(angle, (speed + angle / 100)[None], angle / 50, phase)


def largest(apart: Deviations | None) -> tuple[float, float]:
    assert apart is not None
    return apart.largest


def test_signs_and_sizes() -> None:
    apart = deviations_by_angle(course(ANGLE, speed=1.5), course(ANGLE[::7]))
    assert apart is not None
    # Straight lines: linear interpolation between coarser samples is exact to round-off.
    assert apart.speed == pytest.approx(np.full(len(apart.abscissa), -0.5), abs=1e-13)
    assert apart.radius == pytest.approx(np.zeros(len(apart.abscissa)), abs=1e-13)
    assert apart.largest == pytest.approx((0.5, 0.0), abs=1e-13)


def test_equal_angle_does_not_see_a_delay_in_time() -> None:
    late = np.interp(np.linspace(0, 1, 800) ** 2, np.linspace(0, 1, 1001), ANGLE)  # another course in time, the same curve
    assert largest(deviations_by_angle(course(ANGLE), course(late))) == pytest.approx((0.0, 0.0), abs=1e-13)


def test_a_rotor_that_turns_back_is_compared_where_it_is_new() -> None:
    to_and_fro = np.concatenate([ANGLE[:300], ANGLE[200:299][::-1], ANGLE[200:]])
    full = ComparedMotion(to_and_fro, np.r_[np.zeros(300), np.full(99, 9.0), np.zeros(801)][None], 0 * to_and_fro)
    apart = deviations_by_angle(full, ComparedMotion(ANGLE, 0 * ANGLE[None], 0 * ANGLE))
    assert (np.diff(apart.abscissa) > 0).all()  # type: ignore[union-attr]
    assert largest(apart) == (0.0, 0.0), "what happens at an angle passed before does not count"


@pytest.mark.parametrize("sense", [1, -1])
def test_equal_phase(sense: int) -> None:
    full = ComparedMotion(ANGLE, np.cos(ANGLE)[None], ANGLE, sense * ANGLE / 5)
    slower = ComparedMotion(
        ANGLE, np.cos(ANGLE / 2)[None], ANGLE / 2, sense * ANGLE / 10
    )  # the same curve over the phase, run through slower
    apart = deviations_by_phase(full, slower)
    assert apart is not None
    assert sense * apart.abscissa[-1] == pytest.approx(10.0)
    # Linear interpolation: (1/8) 0.1^2 max |cos''| in the finer half of the samples.
    assert apart.largest[0] < 2e-3
    assert apart.largest[1] < 1e-12


def test_equal_phase_needs_a_turn_of_lag() -> None:
    assert deviations_by_phase(course(ANGLE, ANGLE / 20), course(ANGLE, ANGLE / 20)) is None, "5 rad are less than a turn"
    assert deviations_by_phase(course(ANGLE, ANGLE / 10), course(ANGLE, -ANGLE / 10)) is None, "they lag in opposite senses"
    assert deviations_by_phase(course(ANGLE), course(ANGLE)) is None, "no bodies"
    assert deviations_by_phase(course(ANGLE, 0 * ANGLE), course(ANGLE, 0 * ANGLE)) is None, "no lag"


@pytest.mark.parametrize("sense", [1, -1])
def test_a_lag_that_starts_elsewhere_is_compared_in_its_sense(sense: int) -> None:
    """The phase goes from 30 rad on, up or down by 20 rad; where the slow run is 0.25 faster at each phase."""
    full = ComparedMotion(ANGLE, (ANGLE / 100)[None], ANGLE, 30.0 + sense * ANGLE / 5)
    slow = ComparedMotion(ANGLE, (ANGLE / 100 + 0.25)[None], ANGLE, 30.0 + sense * ANGLE / 5)
    apart = deviations_by_phase(full, slow)
    assert apart is not None and apart.speed == pytest.approx(-0.25)
    assert (apart.abscissa[0], apart.abscissa[-1]) == pytest.approx((30.0, 30.0 + sense * 20.0))
