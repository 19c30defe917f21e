"""What is written about a state, how its frame looks, and where the machine is on the map: of states made by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure

from wucht.plots.page import PRINT, page_context
from wucht.studies.synchronous_states import figure


def state(
    verdict: str = "stable",
    *,
    full: int = 1,
    slow: int = 1,
    over: int = 0,
    name: str = "opposite",
    phases: tuple[float, ...] = (30.0, -90.0),
    unit: str = "rad/s",
) -> xr.Dataset:
    """The second of two states; the first is another one."""
    bodies = (0.0, *phases)
    return xr.Dataset(
        {
            "name": ("state", ["other", name]), "verdict": ("state", ["not stable", verdict]),
            "stable_full": ("state", [-1, full]), "stable_slow": ("state", [0, slow]),
            "overlapping": ("state", [1 - over, over]),
            "phase": (("state", "body"), np.radians([[1.0] * len(bodies), bodies])),
            "speed": ("state", [1.0, 62.83185], {"units": unit}),
        }
    )  # fmt: skip


@pytest.mark.parametrize(
    ("made", "lines"),
    [
        (state(), ("opposite: stable", "30.0°, 270.0°", "at 62.832 rad/s")),
        (state(unit="", name=""), ("state: stable", "30.0°, 270.0°", "at speed 62.832")),
        (state(phases=(10.0, 20.0, 30.0)), ("opposite: stable", "10.0°, 20.0°, 30.0°", "at 62.832 rad/s")),
        (state(phases=(10.0, 20.0, 30.0, 40.0)), ("opposite: stable", "10.0°, 20.0°, ...", "at 62.832 rad/s")),
        (state(phases=(-0.04, 359.96)), ("opposite: stable", "0.0°, 0.0°", "at 62.832 rad/s")),
        (state(phases=()), ("opposite: stable", "at 62.832 rad/s")),
        (state(over=1), ("opposite: bodies overlap", "30.0°, 270.0°", "at 62.832 rad/s")),
        (state("not stable", full=0), ("opposite: averaged: stable, full: unstable", "30.0°, 270.0°", "at 62.832 rad/s")),
        (state("not stable", full=0, slow=0), ("opposite: not stable", "30.0°, 270.0°", "at 62.832 rad/s")),
        (
            state("stable in the averaged equations only", full=-1),
            ("opposite: stable (averaged)", "30.0°, 270.0°", "at 62.832 rad/s"),
        ),
    ],
)
def test_the_title_of_a_state(made: xr.Dataset, lines: tuple[str, ...]) -> None:
    assert figure._title(made, 1) == "\n".join(lines)


@pytest.mark.parametrize(
    ("made", "kind"),
    [
        (state(), "stable"),
        (state("stable in the averaged equations only", full=-1), "slow"),
        (state(over=1), "overlapping"),
        (state("not stable", over=1), "unstable"),
        (state("undecided"), "undecided"),
    ],
)
def test_the_frame_of_a_state(made: xr.Dataset, kind: str) -> None:
    assert figure._frame_kind(made, 1) == kind
    axis = Figure().subplots()
    figure._frame(axis, made, 1, np.array([0j, 4.0 + 1.0j, -2.0 + 3.0j]), 1.0)
    width = figure._FRAMES[kind][2]
    assert axis.spines["left"].get_linewidth() == width and axis.get_aspect() == 1.0
    # The points are between -2 and 4, 0 and 3: a square of a quarter more than the wider one about their middle.
    assert axis.get_xlim() == pytest.approx((1.0 - 3.75, 1.0 + 3.75)) and axis.get_ylim() == pytest.approx(
        (1.5 - 3.75, 1.5 + 3.75)
    )
    figure._frame(axis, made, 1, np.zeros(2, complex), 40.0)
    assert axis.get_xlim() == pytest.approx((-5.0, 5.0)), "not smaller than a fifth of all forces"


@pytest.mark.parametrize(
    ("arrow", "overlapping"),
    [
        ((0j, 10 + 0j), True),
        ((10 + 0j, 0j), True),
        ((5 + 0j, 15 + 0j), True),
        ((10 + 0j, 20 + 0j), False),  # one behind the other
        ((-10 + 0j, 0j), False),
        ((0.9j, 10 + 0.9j), False),  # beside each other
        ((0.7j, 10 + 0.7j), True),
        ((-0.7j, 10 - 0.7j), True),
        ((0j, 10j), False),
        ((5 + 0j, 5 + 0j), False),
    ],
)
def test_arrows_that_would_cover_each_other(arrow: tuple[complex, complex], overlapping: bool) -> None:
    turn = complex(np.exp(2.0j))
    for by in (1.0, turn):
        assert figure._arrows_overlap((by * arrow[0], by * arrow[1]), (0j, by * 10), 1.0) is overlapping


def test_an_arrow_is_moved_aside_to_its_right_until_it_is_free() -> None:
    arrows = [(0j, 10 + 0j)] * 3
    assert np.array(figure._separate_arrows(arrows, 1.0)) == pytest.approx(np.array([(0, 10), (-1j, 10 - 1j), (-2j, 10 - 2j)]))
    apart = [(0j, 10 + 0j), (10 + 0j, 20 + 0j)]
    assert figure._separate_arrows(apart, 1.0) == apart


@pytest.mark.parametrize(
    ("unbalances", "speeds", "shown"),
    [
        ((2.0, 1.0, 0.5), (20.0, -30.0, 35.0), [20.0, 30.0, 35.0]),
        ((2.0, 1.0, 0.5), (10.0, 40.0, 50.0), [10.0, 40.0]),
        ((2.0, 1.0, 0.5), (50.0, 5.0, 6.0), None),
        ((2.0, 3.0, 0.5), (20.0, 20.0, 20.0), None),
        ((0.0, 1.0, 0.5), (20.0, 20.0, 20.0), None),
    ],
)
def test_the_machine_is_on_the_map_where_it_is_in_its_range(
    unbalances: tuple[float, ...], speeds: tuple[float, ...], shown: list[float] | None
) -> None:
    """The bodies' unbalance over that of the rotor, 0.75 here, and the speeds without their sense."""
    axis = Figure().subplots()
    axis.set(xlim=(10.0, 40.0), ylim=(0.5, 1.5))
    drawn = figure._machine_point(axis, xr.Dataset({"unbalance": ("body", list(unbalances)), "speed": ("state", list(speeds))}))
    if shown is None:
        assert drawn == []
    else:
        (line,) = drawn
        assert np.asarray(line.get_xdata()).tolist() == shown and np.asarray(line.get_ydata()).tolist() == [0.75] * len(shown)


def test_a_force_balance_is_drawn_head_to_tail_and_its_resultant_from_the_axis() -> None:
    made = state(phases=(90.0, 180.0)).assign(
        unbalance=("body", [3.0, 2.0, 1.0]), force_angle=(("state", "body"), [[0.0] * 3, [0.0, math.pi / 2, math.pi]])
    )
    for comparable, count in ((1, 4), (0, 3)):
        with page_context(PRINT):
            axis = Figure().subplots()
            figure._force_balance(axis, made.assign_attrs(comparable=comparable), 1)
        arrows = [(*t.xyann, *t.xy) for t in axis.texts]  # type: ignore[attr-defined]
        assert np.array(arrows) == pytest.approx(np.array([[0, 0, 3, 0], [3, 0, 3, 2], [3, 2, 2, 2], [0, 0, 2, 2]][:count]))
