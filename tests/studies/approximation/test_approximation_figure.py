"""The figure of the study approximation, from the Dataset alone."""

from __future__ import annotations

import json
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure

from wucht import Approximation, draw, load_machine, run

TABLE = "drozdetskaya-2020/table-5.1"


def answer(**keys: Any) -> xr.Dataset:
    machine = load_machine(TABLE)
    question = {"kind": "approximation", "start": {"psi": 0.0, "delta": 0.5}, "until": 300.0} | keys
    return run(Approximation.from_table(question), machine)


@pytest.fixture(scope="module")
def sigma() -> xr.Dataset:
    return answer(along="sigma", values=[0.01, 0.05, 0.2])


def inside(figure: Figure) -> bool:
    """Whether the heading lies on the page."""
    canvas = FigureCanvasAgg(figure)
    canvas.draw()
    box = figure._suptitle.get_window_extent(canvas.get_renderer())
    return box.x0 >= 0 and box.x1 <= figure.bbox.width and box.y1 <= figure.bbox.height


def test_labels_are_not_longer_than_their_panels(sigma: xr.Dataset) -> None:
    """Also those of bodies, which are the longest."""
    other = sigma.copy()
    for name in ("speed_over_angle", "speed_deviation", "error"):
        other[name].attrs["units"] = "rad/s"
    summary = other.wucht.summary | {"speeds_of": "the bodies"}
    other.attrs = other.attrs | {"summary": json.dumps(summary)}
    figure = draw(other)
    FigureCanvasAgg(figure).draw()
    for axis in figure.axes:
        assert axis.yaxis.label.get_window_extent().height <= 1.15 * axis.get_window_extent().height


def test_four_panels(sigma: xr.Dataset) -> None:
    figure = draw(sigma)
    speed, amplitude, along, order = figure.axes
    assert speed.get_ylabel() == "speeds of the rotor differ by"
    assert amplitude.get_ylabel() == "amplitudes differ by"
    assert (along.get_xlabel(), order.get_xlabel()) == ("$\\sigma$", "factor of $\\varepsilon$")
    assert [a.get_yscale() for a in figure.axes] == ["log"] * 4
    assert along.get_xscale() == order.get_xscale() == "log"
    [legend] = figure.legends
    assert [t.get_text() for t in legend.get_texts()] == [
        "0.01", "0.05", "0.2", "nominal", "limits of agreement: 5\N{NO-BREAK SPACE}% of the largest speed, "
        "25\N{NO-BREAK SPACE}% of the largest amplitude",
    ]  # fmt: skip


def test_what_is_drawn_is_what_was_computed(sigma: xr.Dataset) -> None:
    speed, _, along, order = draw(sigma).axes
    *curves, criterion = speed.get_lines()
    assert [np.asarray(line.get_ydata()) for line in curves] == [
        pytest.approx(values, nan_ok=True) for values in sigma.speed_over_angle.values
    ]
    reached = float(sigma.speed_deviation[-1] / sigma.relative_speed_deviation[-1])
    assert criterion.get_ydata()[0] == pytest.approx(0.05 * reached)
    line = along.get_lines()[0]
    assert line.get_xdata() == pytest.approx([0.01, 0.05, 0.2])
    assert line.get_ydata() == pytest.approx(sigma.speed_deviation.values[:-1])
    measured, nominal = order.get_lines()
    assert measured.get_ydata() == pytest.approx(sigma.error.values)
    slope = np.diff(np.log(nominal.get_ydata())) / np.diff(np.log(nominal.get_xdata()))
    assert slope == pytest.approx(np.ones(3)), "the dashed line has the nominal order"


def test_the_heading_stays_on_the_page(sigma: xr.Dataset) -> None:
    """The reasons why the equations are not trusted are long."""
    assert len(sigma.attrs["sentence"]) > 100
    assert inside(draw(sigma))


def test_points_that_end_differently_are_open(sigma: xr.Dataset) -> None:
    shown = sigma.copy(deep=True)
    shown["same_outcome"].values[:] = [0, 1, -1, 1]
    along = draw(shown).axes[2]
    faces = {line.get_label(): line.get_markerfacecolor() for line in along.get_lines()[1:-1]}
    assert set(faces) == {"outcomes differ", "same outcome", "no outcome yet"}
    assert faces["outcomes differ"] == "white"
    assert len(set(faces.values())) == 3
    assert len({line.get_marker() for line in along.get_lines()[1:-1]}) == 3, "read in grey, too"


def test_no_parameter_and_no_order() -> None:
    result = answer().isel(factor=slice(0, 0))
    summary = result.wucht.summary | {"order_of_error": None}
    assert len(draw(result.assign_attrs(summary=json.dumps(summary))).axes) == 2, "no panels of what there is not"


def test_a_run_without_deviations(sigma: xr.Dataset) -> None:
    gap = sigma.copy(deep=True)
    gap["speed_over_angle"].values[0] = np.nan
    gap["amplitude_over_angle"].values[:] = np.nan
    gap["speed_deviation"].values[0] = np.nan
    assert inside(draw(gap))


def test_millimetres() -> None:
    machine = load_machine("drozdetskaya-2020/r2-u80")
    keys = {"kind": "approximation", "start": {"p1": 0.3, "p2": -0.5}, "until": 1.0, "until_phi": 50.0}
    result = run(Approximation.from_table(keys), machine)
    amplitude = draw(result).axes[1]
    assert amplitude.get_ylabel() == "amplitudes differ by (mm)"
    *_, curve, criterion = amplitude.get_lines()
    assert curve.get_ydata() == pytest.approx(1e3 * result.amplitude_over_angle.values[0], nan_ok=True)
    reached = float(result.amplitude_deviation[-1] / result.relative_amplitude_deviation[-1])
    assert criterion.get_ydata()[0] == pytest.approx(1e3 * 0.25 * reached), "a quarter of the largest amplitude is trusted"
