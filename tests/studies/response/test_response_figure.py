"""The figure of ``response``: panels, labels, lines; drawn from the Dataset alone."""

from __future__ import annotations

import io
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from tests.refusals import refused

from wucht import Response, draw, load_machine, run
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


def answered(**carrier: Any) -> xr.Dataset:
    return run(Response(), machine_from({"carrier": CARRIER | carrier, "bodies": [ROTOR], "drive": LINEAR}))


@pytest.fixture(scope="module")
def response() -> xr.Dataset:
    return answered()


def test_response_panels(response: xr.Dataset) -> None:
    figure = draw(response)
    assert [a.get_ylabel() for a in figure.axes] == [
        "amplitude of the axis (mm)", "phase lag (\u00b0)", "distance from rest (mm)", "torque required (N·m)",
    ]  # fmt: skip
    assert figure.axes[-1].get_xlabel() == "speed (rad/s)"
    amplitude, phase, centre, torque = figure.axes
    assert labels(amplitude) == ["axis", "carrier x", "carrier y", "critical speeds", "speed of the drive"]
    assert labels(phase) == ["x", "y"]
    assert labels(centre) == ["centre of mass", "axis", "eccentricity"]
    assert labels(torque) == ["vibration"]
    assert response.attrs["sentence"] in figure.get_suptitle()


def test_response_lines(response: xr.Dataset) -> None:
    amplitude, phase, _, torque = draw(response).axes
    assert line(amplitude, "axis").get_ydata().max() == pytest.approx(1e3 * float(response.peak_amplitude.max()))
    marked = [float(x.get_xdata()[0]) for x in amplitude.get_lines() if x.get_linestyle() == ":" and len(x.get_xdata()) == 2]
    assert marked == pytest.approx([math.sqrt(2e4 / 5), math.sqrt(6e4 / 5)])
    assert line(amplitude, "speed of the drive").get_xdata()[0] == 250.0
    assert phase.get_ylim() == (-10, 190)
    assert line(torque, "vibration").get_ydata().max() == pytest.approx(float(response.vibration_torque.max()))


def test_an_isotropic_carrier_has_one_line_a_panel() -> None:
    amplitude, phase, *_ = draw(run(Response(), load_machine("drozdetskaya-2020/table-3.1-laval"))).axes
    assert labels(amplitude) == ["axis", "critical speed", "speed of the drive"]
    assert labels(phase) == ["x and y"]
    assert amplitude.get_ylabel() == "amplitude of the axis"


def test_an_infinite_amplitude_is_cut() -> None:
    figure = draw(answered(stiffness=2e4, damping=0.0))
    top = figure.axes[0].get_ylim()[1]
    assert 5 < top < 200  # mm; the samples by the resonance reach metres


@pytest.mark.slow
def test_losses_are_drawn_apart() -> None:
    rotor = ROTOR | {"bearing_damping": 0.1}
    figure = draw(run(Response(), machine_from({"carrier": CARRIER, "bodies": [rotor], "drive": LINEAR})))
    assert labels(figure.axes[-1]) == ["with losses", "loads and bearings", "vibration"]


def test_a_carrier_that_turns_has_no_centre_of_mass_panel() -> None:
    rotor = {k: v for k, v in ROTOR.items() if k != "eccentricity"} | {"couple_unbalance": 1e-3}
    carrier = {"directions": "r", "inertia": 0.5, "rotation_stiffness": 2e3, "rotation_damping": 2.0}
    figure = draw(run(Response(), machine_from({"carrier": carrier, "bodies": [rotor], "drive": LINEAR})))
    assert len(figure.axes) == 3
    assert " ".join(figure.axes[0].get_ylabel().split()) == "amplitude of the axis (rad)"


def test_an_exciter_does_not_centre_itself() -> None:
    """Its eccentricity is far larger than the motion of its axis, where the carrier is heavy; and two have no common centre."""
    labels_of = [[a.get_ylabel() for a in draw(answered(mass=mass)).axes] for mass in (3.0, 30.0)]
    assert [any(text.startswith("distance from rest") for text in texts) for texts in labels_of] == [True, False]
    two = [ROTOR | {"name": f"e{k}", "position": [0.1 * k, 0.0]} for k in (1, 2)]
    carrier = {"mass": 3.0, "inertia": 0.1, "directions": "xyr", "mounts": [{"at": [0.1, 0.0], "stiffness": [2e4, 6e4]}]}
    m = machine_from({"carrier": carrier, "bodies": two, "drives": [LINEAR | {"on": f"e{k}"} for k in (1, 2)]})
    result = run(Response(bodies="held"), m)
    assert np.isfinite(result.centre_distance.values).any() and len(draw(result).axes) == 3


def test_a_name_is_in_one_legend() -> None:
    """The configurations of two balls are lines in every panel; those with another look or name are added."""
    figure = draw(run(Response(points=60), load_machine("drozdetskaya-2020/r1")))
    amplitude, phase, centre, _ = figure.axes
    assert {"critical speed", "speed of the drive", "not stable"} < set(labels(amplitude))
    assert phase.get_legend() is None
    assert labels(centre) == ["eccentricity"]
    names = [name for axis in figure.axes if axis.get_legend() is not None for name in labels(axis)]
    assert len(names) == len(set(names))


@pytest.mark.parametrize("ending", ["png", "pdf", "svg"])
@pytest.mark.filterwarnings("error")
def test_every_format_of_the_response_figure(response: xr.Dataset, ending: str) -> None:
    file = io.BytesIO()
    draw(response).savefig(file, format=ending)
    assert file.getbuffer().nbytes > 5000


@pytest.mark.filterwarnings("error")
def test_a_response_of_nothing_can_be_drawn() -> None:
    m = machine_from({"carrier": CARRIER, "bodies": [ROTOR | {"eccentricity": 0.0}], "drive": LINEAR})
    drawn: Figure = draw(run(Response(), m))
    drawn.savefig(io.BytesIO(), format="png")
    assert drawn.get_suptitle().endswith("\nnothing excites the carrier: the unbalances are zero or cancel")
    amplitude, phase, torque = drawn.axes
    assert labels(amplitude) == ["axis", "critical speeds", "speed of the drive"]
    assert not np.any(line(amplitude, "axis").get_ydata())
    assert not np.any(line(torque, "vibration").get_ydata())
    assert phase.get_legend() is None, "what does not vibrate has no phase"
    for axis in drawn.axes:
        assert axis.get_ylim()[0] < axis.get_ylim()[1] < math.inf


def test_a_dataset_that_is_no_response_is_refused(response: xr.Dataset) -> None:
    with refused("response", given=None):
        draw(response.drop_vars("amplitude"))
