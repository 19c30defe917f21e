"""Portraits of equations of more than two states, projected on two."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from tests.refusals import check_refusal

import wucht
from wucht import UserSystem
from wucht.files.user_system import equations_from

WELLS = {"x": "v", "v": "-0.5*v + x - x^3", "z": "-z"}
RANGES = {"x": (-2.0, 2.0), "v": (-2.0, 2.0), "z": (-1.0, 1.0)}


def subject(states: dict[str, str] | None = None) -> UserSystem:
    return equations_from({"states": states or WELLS}, "two wells")


def test_equilibria_trajectories_and_attractors_of_two_wells() -> None:
    starts = [{"x": 0.5, "z": 1.0}, {"x": -0.5, "z": -1.0}]
    result = wucht.run(wucht.PhasePortrait(ranges=RANGES, show=["x", "z"], trajectories=starts), subject())
    s = result.wucht.summary
    points = {round(p["state"]["x"], 9) + 0.0: p for p in s["fixed_points"]}
    assert {x: p["kind"] for x, p in points.items()} == {-1.0: "stable", 0.0: "saddle", 1.0: "stable"}
    # At x = 0: lambda^2 + lambda/2 - 1 = 0, and -1 of z.
    growth = sorted(re for re, _ in points[0.0]["eigenvalues"])
    assert growth == pytest.approx(sorted([-0.25 + np.sqrt(1.0625), -0.25 - np.sqrt(1.0625), -1.0]))
    assert sorted(round(a["state"]["x"]) for a in s["attractors"]) == [-1, 1]
    assert result.trajectories.shape[:2] == (2, 3)
    assert (result.attrs["abscissa"], result.attrs["ordinate"]) == (0, 2)
    assert wucht.report(result)[1].startswith("verdict: equilibria: ")
    fig = wucht.draw(result)
    assert (fig.axes[0].get_xlabel(), fig.axes[0].get_ylabel()) == ("x", "z")


@pytest.mark.parametrize(
    "keys",
    [
        {"ranges": {"x": (-1.0, 1.0)}},
        {"ranges": RANGES | {"w": (0.0, 1.0)}},
        {"ranges": RANGES, "show": ["x", "w"]},
        {"ranges": RANGES, "nullclines": True},
    ],
)
def test_questions_that_do_not_fit_are_refused(keys: dict[str, Any]) -> None:
    check_refusal(f"phase-portrait of three equations: {keys}", lambda: wucht.run(wucht.PhasePortrait(**keys), subject()))


def test_two_states_need_no_projection() -> None:
    oscillator = subject({"x": "v", "v": "-x - v"})
    check_refusal("phase-portrait of two equations", lambda: wucht.run(wucht.PhasePortrait(show=["x", "v"]), oscillator))
