"""The figure of ``torque-balance``: panels, labels, markers; drawn from the Dataset alone."""

from __future__ import annotations

import io
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tests.refusals import refused

from wucht import TorqueBalance, draw, load_machine, run
from wucht.files.building import machine_from

ROTOR = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 0.01, "inertia": 0.05}
CARRIER = {"mass": 3.0, "stiffness": [2e4, 6e4], "damping": 40.0}
LINEAR = {"kind": "linear", "slope": 0.05, "no_load_speed": 250.0}


def labels(axis: Axes) -> list[str]:
    legend = axis.get_legend()
    assert legend is not None
    return [text.get_text() for text in legend.get_texts()]


def line(axis: Axes, name: str) -> Any:
    return next(drawn for drawn in axis.get_lines() if drawn.get_label() == name)


@pytest.fixture(scope="module")
def balance() -> xr.Dataset:
    return run(TorqueBalance(), load_machine("drozdetskaya-2020/table-3.1-carrier", {"u": 2}))


SPEED = np.linspace(0.0, 100.0, 5)


def changed(
    result: xr.Dataset,
    drive: list[float],
    vibration: list[float],
    load: float = 0.0,
    points: tuple[tuple[float, float, int], ...] = (),
    sense: int = 1,
) -> xr.Dataset:
    """A torque balance with other torques. points: speed, torque of the drive and stability of each. sense: -1: clockwise."""
    order = slice(None, None, sense)
    curves = {"drive_torque": drive, "load_torque": [load] * 5, "vibration_torque": vibration}
    torques = {n: ("speed", sense * np.array(v, float)[order], result[n].attrs) for n, v in curves.items()}
    of_points = np.array(points, float).reshape(-1, 3).T * np.array([[sense], [sense], [1]])
    columns = zip(("point_speed", "point_torque", "point_stable"), of_points, strict=True)
    by_point = {n: ("point", v, result[n].attrs) for n, v in columns}
    return (
        result.drop_dims("point")
        .isel(speed=slice(5))
        .assign_coords(speed=("speed", sense * SPEED[order], result.speed.attrs))
        .assign(stable=("speed", [1, 1, 0, 0, 1][order]), **torques, **by_point)
    )


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
    balance: xr.Dataset, sense: int, drive: list[float], vibration: list[float], points: list[float], low: float, high: float
) -> None:
    """The limits without the margins: 5 % of the height below, 8 % above. Clockwise the same upside down."""
    (axis,) = draw(changed(balance, drive, vibration, points=tuple((50.0, p, 1) for p in points), sense=sense)).axes
    bottom, top = axis.get_ylim()
    height = (top - bottom) / 1.13
    expected = (low, high) if sense > 0 else (-high, -low)
    assert (bottom + 0.05 * height, top - 0.08 * height) == pytest.approx(expected)


def test_working_points_are_drawn_at_the_torque_of_the_drive(balance: xr.Dataset) -> None:
    points = ((12.5, 9.0, 1), (110.0, 3.0, 0))
    (axis,) = draw(changed(balance, [10, 8, 6, 4, 2], [0, 4, 2, 1, 1], 2.0, points)).axes
    for name, point in zip(("stable", "unstable"), points, strict=True):
        drawn = line(axis, f"{name} working point")
        assert (drawn.get_xdata().tolist(), drawn.get_ydata().tolist()) == ([point[0]], [point[1]])
    heights = {str(x.get_label()): np.asarray(x.get_ydata(), float) for x in axis.get_lines()}
    assert heights["load and vibration"] == pytest.approx([2.0, 6.0, np.nan, np.nan, 3.0], nan_ok=True)
    assert heights["no stable working point"] == pytest.approx([np.nan, 6.0, 4.0, 3.0, 3.0], nan_ok=True)
    assert heights["load and bearings"].tolist() == [2.0] * 5 and heights["drive"].tolist() == [10, 8, 6, 4, 2]
    assert axis.get_xlim() == (0.0, 110.0), "a point beyond the range is shown"


def test_points_of_overlapping_bodies_are_crosses(balance: xr.Dataset) -> None:
    points = ((10.0, 9.0, 1), (20.0, 8.0, 1), (30.0, 7.0, 0))
    result = changed(balance, [10, 8, 6, 4, 2], [0, 4, 2, 1, 1], 0.0, points).assign(point_overlapping=("point", [0, 1, 0]))
    (axis,) = draw(result).axes
    assert [x.get_xdata().tolist() for x in axis.get_lines() if x.get_marker() == "x"] == [[20.0]]
    assert line(axis, "stable working point").get_xdata().tolist() == [10.0]
    assert line(axis, "unstable working point").get_xdata().tolist() == [30.0]


def test_torque_balance_marks_the_working_points(balance: xr.Dataset) -> None:
    (axis,) = draw(balance).axes
    stable, other = line(axis, "stable working point"), line(axis, "unstable working point")
    assert list(stable.get_xdata()) == pytest.approx([0.9686444, 1.8176384], abs=1e-7)
    assert list(other.get_xdata()) == pytest.approx([1.0937039], abs=1e-7)
    assert stable.get_markerfacecolor() != other.get_markerfacecolor() == "white"
    assert list(other.get_ydata()) == pytest.approx([2 * (2 - 1.0937039)], abs=1e-6)
    solid, dashed = line(axis, "vibration"), line(axis, "no stable working point")
    assert dashed.get_linestyle() == "--"
    inside = np.interp(1.0937039, dashed.get_xdata(), np.isfinite(dashed.get_ydata()).astype(float))
    assert inside == 1
    assert not np.isfinite(solid.get_ydata())[np.searchsorted(solid.get_xdata(), 1.0937039)]


def test_torque_balance_with_a_load() -> None:
    m = machine_from(
        {"carrier": CARRIER, "bodies": [ROTOR | {"bearing_damping": 0.01}], "drive": LINEAR,
         "loads": [{"kind": "quadratic", "coefficient": 1e-5}]}
    )  # fmt: skip
    figure = draw(run(TorqueBalance(), m))
    (axis,) = figure.axes
    assert axis.get_ylabel() == "torque (N·m)"
    assert [" ".join(text.split()) for text in labels(axis)] == [
        "drive", "load and bearings", "load and vibration", "no stable working point",
        "stable working point", "unstable working point", "natural frequencies", "speed without vibration",
    ]  # fmt: skip


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
@pytest.mark.filterwarnings("error")
def test_every_format_of_the_torque_balance_figure(balance: xr.Dataset, ending: str) -> None:
    file = io.BytesIO()
    draw(balance).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 5000


@pytest.mark.slow
@pytest.mark.filterwarnings("error")
def test_a_torque_balance_without_vibration_or_points_can_be_drawn() -> None:
    m = machine_from({"carrier": CARRIER, "bodies": [ROTOR | {"eccentricity": 0.0}], "drive": LINEAR})
    marks = ["stable working point", "natural frequencies", "speed without vibration"]
    for question, beside in ((TorqueBalance(), marks), (TorqueBalance((1.0, 2.0)), [])):
        result = run(question, m)
        drawn: Figure = draw(result)
        drawn.savefig(io.BytesIO(), format="png")
        assert drawn.get_suptitle().endswith(f"\n{result.attrs['sentence']}")
        [axis] = drawn.axes
        assert labels(axis) == ["drive", "vibration", *beside]
        assert not np.any(line(axis, "vibration").get_ydata())
        assert np.array_equal(line(axis, "drive").get_ydata(), result.drive_torque.values)
        assert axis.get_xlim() == (result.speed.values[0], result.speed.values[-1])


def test_a_dataset_that_is_no_torque_balance_is_refused(balance: xr.Dataset) -> None:
    with refused("torque-balance", given=None):
        draw(balance.drop_vars("drive_torque"))
