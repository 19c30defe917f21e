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

from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.studies.runner import draw, run
from wucht.studies.torque_balance import TorqueBalance

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
