"""Springs and dashpots in every direction, in a view that is turned: each is the one to the right, turned onto its line."""

from __future__ import annotations

from cmath import exp, pi

import numpy as np
import pytest
from tests.web.page_answers import answer, page_text

FROM, LENGTH, WIDTH = 0.2 + 0.1j, 0.3, 7.0
# The point 0.05 - 0.02 i is at the pixel 300 + 200 i, what has the direction of 0.4 rad to the right, at 800 px a metre.
CENTRE, PIXEL, TURN, SCALE = 0.05 - 0.02j, 300 + 200j, 0.4, 800.0
DIRECTIONS = 2 * pi * np.arange(24) / 24


def pixel(point: complex) -> complex:
    """Where a point is drawn: pixels count downwards."""
    return PIXEL + (SCALE * (point - CENTRE) * exp(-1j * TURN)).conjugate()


@pytest.fixture(scope="module")
def shapes(tmp_path_factory: pytest.TempPathFactory) -> list[tuple[np.ndarray, np.ndarray]]:
    """Spring and dashpot in each direction: shares of the way along the line, and i times those to the right of it."""
    ends = [FROM + LENGTH * exp(1j * direction) for direction in DIRECTIONS.tolist()]
    view = [CENTRE.real, CENTRE.imag, TURN, SCALE, PIXEL.real, PIXEL.imag]
    job = {"view": view, "from": [FROM.real, FROM.imag], "ends": [[end.real, end.imag] for end in ends], "width": WIDTH}
    drawn = answer(tmp_path_factory.mktemp("shapes"), page_text("drozdetskaya-2020/table-5.1"), "springs", **job)
    lines = [[np.array(points) @ [1, 1j] for points in both] for both in drawn]
    return [
        ((spring - pixel(FROM)) / (pixel(end) - pixel(FROM)), (dashpot - pixel(FROM)) / (pixel(end) - pixel(FROM)))
        for (spring, dashpot), end in zip(lines, ends, strict=True)
    ]


def test_the_coils_of_a_spring_stand_across_its_line_in_every_direction(shapes: list[tuple[np.ndarray, np.ndarray]]) -> None:
    """Equal steps along the line; to the right and to the left in turn, by the width that is asked for."""
    for spring, _ in shapes:
        assert spring[[0, -1]] == pytest.approx([0, 1], abs=1e-12), "from one end to the other"
        coils = spring[abs(spring.imag) > 1e-12]
        sides = (-1.0) ** np.arange(len(coils)) * np.sign(coils[0].imag)
        assert len(coils) > 5
        assert coils.imag == pytest.approx(sides * WIDTH / (SCALE * LENGTH), rel=1e-9)
        assert coils.real == pytest.approx(np.linspace(coils[0].real, coils[-1].real, len(coils)), rel=1e-9)
        assert coils[0].real + coils[-1].real == pytest.approx(1)


def test_a_dashpot_is_alike_on_both_sides_of_its_line_in_every_direction(
    shapes: list[tuple[np.ndarray, np.ndarray]],
) -> None:
    for _, dashpot in shapes:
        mirrored = dashpot.conj()
        assert all(abs(dashpot - point).min() < 1e-9 for point in mirrored)
        assert abs(dashpot.imag).max() == pytest.approx(WIDTH / (SCALE * LENGTH), rel=1e-9)


def test_springs_and_dashpots_of_all_directions_are_one_turned(shapes: list[tuple[np.ndarray, np.ndarray]]) -> None:
    for both in shapes:
        for shape, first in zip(both, shapes[0], strict=True):
            assert shape == pytest.approx(first, abs=1e-9)
