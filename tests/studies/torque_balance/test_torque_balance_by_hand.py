"""Scales, points, ranges and sentences of torque balances that are made by hand, in both senses of rotation."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.figure import Figure
from tests.hand_made import drawn

from wucht.analysis.working_points import WorkingPoint
from wucht.dynamics.run_ups.operating_points import OperatingPoints
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.studies import torque_balance
from wucht.studies.torque_balance import Findings

SPEED = np.linspace(0.0, 100.0, 5)


def balanced(
    drive: list[float],
    vibration: list[float],
    load: float = 0.0,
    points: tuple[tuple[float, float, int], ...] = (),
    sense: int = 1,
) -> xr.Dataset:
    """points: speed, torque of the drive and stability of each. sense: -1 for a drive that turns clockwise."""
    order = slice(None, None, sense)
    curves = {"drive_torque": drive, "load_torque": [load] * 5, "vibration_torque": vibration}
    variables = {
        n: ("speed", sense * np.array(v, float)[order], {"units": "N m", "long_name": "torque"}) for n, v in curves.items()
    }
    of_points = np.array(points, float).reshape(-1, 3).T * np.array([[sense], [sense], [1]])
    columns = dict(zip(("point_speed", "point_torque", "point_stable"), of_points, strict=True))
    result = xr.Dataset(
        {**variables, "stable": ("speed", [1, 1, 0, 0, 1][order]), "free_speed": ((), sense * 90.0, {"units": "rad/s"}),
         **{n: ("point", v, {"units": ""}) for n, v in columns.items()}, "natural_frequency": ("mode", [40.0])},
        coords={"speed": ("speed", sense * SPEED[order], {"units": "rad/s", "long_name": "speed"})},
    )  # fmt: skip
    summary = {"summary": "{}", "sentence": "as by hand", "warnings": "[]", "failure": ""}
    return result.assign_attrs(title="A machine", dimensionless=0, **summary)


def limits(result: xr.Dataset) -> tuple[float, float]:
    """The limits of the ordinate without the margins: 5 % of the height below, 8 % above."""
    axis = Figure().subplots()
    torque_balance._ordinate(axis, result)
    assert axis.get_ylabel() == "torque (N·m)"
    low, high = axis.get_ylim()
    height = (high - low) / 1.13
    return low + 0.05 * height, high - 0.08 * height


@pytest.mark.parametrize("sense", [1, -1])
@pytest.mark.parametrize(
    ("drive", "vibration", "points", "low", "high"),
    [
        # 2.5 times the drive's largest torque, however high the resonance
        ([10, 8, 5, 2, 0], [0, 1000, 20, 5, 1], [], 0.0, 25.0),
        # three times what opposes a motor that starts strongly
        ([500, 80, 5, 2, 0], [0, 4, 2, 1, 1], [], 0.0, 12.0),
        # half of it on the other side: a drive that brakes beyond its no-load speed
        ([10, 8, 5, 2, -30], [0, 20, 20, 5, 1], [], -5.0, 20.0),
        # all working points are inside
        ([500, 80, 5, 2, 0], [0, 4, 2, 1, 1], [3.0, -1.0], -1.0, 12.0),
        ([10, 8, 5, 2, 0], [0, 1000, 20, 5, 1], [30.0], 0.0, 30.0),
        # nothing opposes
        ([10, 8, 5, 2, 0], [0, 0, 0, 0, 0], [], 0.0, 10.0),
        # a resonance without an end
        ([10, 8, 5, 2, 0], [0, np.inf, 2, np.nan, 1], [], 0.0, 6.0),
    ],
)
def test_the_drive_is_visible_however_high_the_resonance(
    sense: int, drive: list[float], vibration: list[float], points: list[float], low: float, high: float
) -> None:
    """Clockwise the same upside down."""
    expected = (low, high) if sense > 0 else (-high, -low)
    assert limits(balanced(drive, vibration, points=tuple((50.0, p, 1) for p in points), sense=sense)) == pytest.approx(
        expected
    )


def test_working_points_are_drawn_at_the_torque_of_the_drive() -> None:
    points = ((12.5, 9.0, 1), (110.0, 3.0, 0))
    (axis,) = drawn("torque-balance", balanced([10, 8, 6, 4, 2], [0, 4, 2, 1, 1], 2.0, points)).axes
    of_name = {str(x.get_label()): x for x in axis.get_lines()}
    for name, point in zip(("stable", "unstable"), points, strict=True):
        line = of_name[f"{name} working point"]
        assert (np.asarray(line.get_xdata()).tolist(), np.asarray(line.get_ydata()).tolist()) == ([point[0]], [point[1]])
    heights = {name: np.asarray(x.get_ydata(), float) for name, x in of_name.items()}
    assert heights["load and vibration"] == pytest.approx([2.0, 6.0, np.nan, np.nan, 3.0], nan_ok=True)
    unstable = heights["no stable working point"]
    assert unstable == pytest.approx([np.nan, 6.0, 4.0, 3.0, 3.0], nan_ok=True)
    assert heights["load and bearings"].tolist() == [2.0] * 5 and heights["drive"].tolist() == [10, 8, 6, 4, 2]
    assert axis.get_xlim() == (0.0, 110.0), "a point beyond the range is shown"


def test_points_of_overlapping_bodies_are_crosses() -> None:
    made = balanced([10, 8, 6, 4, 2], [0, 4, 2, 1, 1], 0.0, ((10.0, 9.0, 1), (20.0, 8.0, 1), (30.0, 7.0, 0)))
    made["point_overlapping"] = "point", [0, 1, 0]
    (axis,) = drawn("torque-balance", made).axes
    at = {x.get_marker(): np.asarray(x.get_xdata()).tolist() for x in axis.get_lines() if x.get_marker() == "x"}
    circles = {str(x.get_label()): np.asarray(x.get_xdata()).tolist() for x in axis.get_lines() if x.get_marker() == "o"}
    assert at == {"x": [20.0]}
    assert circles == {"stable working point": [10.0], "unstable working point": [30.0]}
    assert "drive" in {str(x.get_label()) for x in axis.get_lines()}


def sentence(
    *points: bool, over: tuple[bool, ...] = (), names: tuple[str, ...] = (), runaway: bool = False, rotors: bool = False
) -> str:
    """over: of the configurations, those with overlapping bodies. rotors: configurations of several rotors."""
    made = tuple(WorkingPoint(1.0, 1.0, stable, False, 0.0, 0.0, None) for stable in points)
    configurations: Any = tuple(SimpleNamespace(overlapping=o) for o in over)
    anything: Any = object()
    torques = anything if over or names else None
    steady = SteadyPhases(anything, np.zeros(1), anything, torques, (), configurations if rotors else None)
    plan: Any = SimpleNamespace(steady=steady, curves=[SimpleNamespace(runaway=runaway)])
    return torque_balance._count_sentence(plan, OperatingPoints(made, configurations, names))


def test_sentences() -> None:
    away = "without vibration the drive's torque never meets the load: the rotor would run away"
    nowhere = "drive, load and vibration do not balance anywhere in the range"
    assert sentence(True) == "one working point, stable" and sentence(False) == "one working point, not stable"
    assert sentence(True, False, True) == "3 working points, 2 of them stable"
    assert sentence() == nowhere
    assert sentence(runaway=True) == away
    assert sentence(True, runaway=True) == f"{away}; with it is one working point, stable"
    assert sentence(True, False, runaway=True) == f"{away}; with it are 2 working points, 1 of them stable"
    steady = sentence(True, True, False, True, over=(False, True, False, False), names=("a", "b", "c", "a"))
    assert steady == "3 working points, 2 of them stable: a; 1 more with overlapping bodies of a track"
    assert sentence(True, over=(True,), names=("a",)) == f"{nowhere} in any steady phases of the balancing bodies"


def test_sentences_on_several_rotors() -> None:
    none_is_stable = "the rotors do not run synchronously: no synchronous configuration in the range is stable"
    assert sentence(rotors=True) == none_is_stable
    assert sentence(False, False, over=(False, True), names=("a", "b"), rotors=True) == f"{none_is_stable} (1 not stable)"
    assert sentence(True, False, over=(False, False), names=("a", "b"), rotors=True) == (
        "2 working points, 1 of them stable: a"
    )
    both = sentence(True, True, over=(False, False), names=("e2 1°, e3 2°", "e2 3°, e3 4°"), rotors=True)
    assert both == "2 working points, 2 of them stable: e2 1°, e3 2° or e2 3°, e3 4°"


def test_warnings_of_touching_curves_and_of_several_rotors() -> None:
    def told(rotors: int, *tangential: bool, configurations: Any = None) -> list[str]:
        made: Any = SimpleNamespace(
            steady=SimpleNamespace(machine=SimpleNamespace(rotors=[None] * rotors), configurations=configurations),
            curves=(SimpleNamespace(rotor=SimpleNamespace(name="second")),),
        )
        points = tuple(WorkingPoint(1.0, 1.0, False, t, 0.0, 0.0, None) for t in tangential)
        return torque_balance._warnings(made, Findings(OperatingPoints(points)))

    assert told(1, False) == told(1) == []
    (touching,) = told(1, False, True)
    assert "only touch" in touching
    assert told(2) == ["all rotors are assumed to turn as fast as 'second', in the phases of the start"]
    assert told(2, configurations=()) == []
