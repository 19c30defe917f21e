"""A cam that goes round its shaft, with layouts whose centres are known by heart."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any

import pytest

from wucht.cams.laws.cone_programme import InfeasibleError
from wucht.cams.sizing.smallest_cam import LEAST_DISTANCE, _centre_around_shaft
from wucht.errors import RunError


@dataclass(frozen=True)
class Guide:
    """Its distance from a centre is what is beside the real axis."""

    def distance_from(self, centre: complex) -> float:
        return centre.imag


@dataclass(frozen=True)
class Layout:
    """A lever that swings by 0.5 rad. The near end of its pitch curve is at 0."""

    tangents: tuple[float, float] = (0.75, 1.5)
    swing: float = 0.5
    ends: tuple[complex, complex] = (0j, 1 + 0j)
    guide: Guide = field(default_factory=Guide)


LEAST = math.tan(0.25) / 0.75  # share of the tangents at which a cam is infinitely large


def centre(base: float, beside: float = 1.0) -> Any:
    """A centre whose base circle grows as the permitted tangents fall."""

    def of(layout: Layout) -> complex:
        share = layout.tangents[0] / 0.75
        assert layout.tangents[1] == pytest.approx(1.5 * share), "both tangents are changed alike"
        if share <= LEAST * (1 + 1e-6):
            raise InfeasibleError("none")
        return complex(0.0, 0.0) + (base / (share - LEAST)) * (1 - 0j) + 1j * beside / share

    return of


def test_a_cam_that_goes_round_its_shaft_is_taken_as_it_is() -> None:
    far = 3 + 4j
    assert _centre_around_shaft(Layout(), far, 5.0, centre(1.0)) == far  # type: ignore[arg-type]
    assert _centre_around_shaft(Layout(), 3 + 1j * LEAST_DISTANCE, 3.0, centre(1.0)) == 3 + 1j * LEAST_DISTANCE  # type: ignore[arg-type]


def test_else_that_with_the_largest_pressure_angle_that_does() -> None:
    """Its base circle is as large as it must be, or a little larger."""
    of = centre(0.5, beside=0.01)
    found = _centre_around_shaft(Layout(), of(Layout()), 4.0, of)  # type: ignore[arg-type]
    assert abs(found) == pytest.approx(4.0, rel=1e-7) and abs(found) >= 4.0


def test_the_distance_of_a_rod_must_be_greater_than_zero_too() -> None:
    """Large as the base circle is, the cam is made larger until it is not on the rod's line."""

    def of(layout: Layout) -> complex:
        share = layout.tangents[0] / 0.75
        return 10 + 1j * (0.75 - share)

    found = _centre_around_shaft(Layout(), of(Layout()), 4.0, of)  # type: ignore[arg-type]
    assert found.imag == pytest.approx(LEAST_DISTANCE, rel=1e-2) and found.imag >= LEAST_DISTANCE


def test_a_shaft_that_no_cam_goes_round_is_refused() -> None:
    of = centre(0.5)
    with pytest.raises(RunError, match="no cam round a shaft of that radius was found") as raised:
        _centre_around_shaft(Layout(), of(Layout()), 1e9, of)  # type: ignore[arg-type]
    assert raised.value.code == "no-cam"
