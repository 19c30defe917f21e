"""The figure of a search: each point is there, with the mark of its number of bodies; objectives that vary, and the curve."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from searches import searched

from wucht import draw

COLUMNS = {"s": (0, 1.0), "g·mm": (1, 1e6), "mm": (2, 1e3), "%": (3, 100.0)}


def panels(result: xr.Dataset) -> list[Axes]:
    return [axes for axes in draw(result).axes if axes.lines]


def lines_of(axes: Axes) -> dict[str, np.ndarray]:
    """The points of each line by its label."""
    return {str(line.get_label()): np.asarray(line.get_xydata(), float) for line in axes.lines}


def in_print(axes: Axes, objectives: np.ndarray) -> np.ndarray:
    """The two columns of objectives (P, 4) that the labels name, in the units of these."""
    pairs = (COLUMNS[label[:-1].split("(")[1]] for label in (axes.get_xlabel(), axes.get_ylabel()))
    return np.stack([factor * np.atleast_2d(objectives)[:, column] for column, factor in pairs], axis=1)


@pytest.mark.parametrize("name", ["kept", "averaged"])
def test_each_pair_of_objectives_that_vary_has_a_panel_with_all_points(name: str) -> None:
    """The residual unbalance is zero throughout. Limits are about the front and the machine as it is, with its bar."""
    result = searched(name)
    axes_of_pairs = panels(result)
    assert len(axes_of_pairs) == 3
    front, checked, own = result.front_objective.values, result.front_checked.values, result.own_checked.values
    for axes in axes_of_pairs:
        assert "unbalance" not in axes.get_xlabel() + axes.get_ylabel()
        drawn = lines_of(axes)
        for label, values in (("by the search", front), ("checked", checked)):
            (line,) = [xy for name, xy in drawn.items() if name.endswith(label)]
            assert line == pytest.approx(in_print(axes, values), rel=1e-12)
        assert drawn["candidates"] == pytest.approx(in_print(axes, result.tried_objective.values), nan_ok=True)
        assert drawn["machine as it is"] == pytest.approx(in_print(axes, own))
        least = own - [0.0, 0.0, 0.0, result.wucht.summary["as_it_is"]["checked_undecided"]]
        points = in_print(axes, np.concatenate([front, checked, own[None], least[None]]))
        low, high = points.min(axis=0), points.max(axis=0)
        limits = np.array([axes.get_xlim(), axes.get_ylim()]).T
        assert limits == pytest.approx(np.array([low - 0.08 * (high - low), high + 0.16 * (high - low)]))


def test_runs_without_a_verdict_are_a_bar_along_the_capture_probability() -> None:
    result = searched("kept")
    (axes, *_) = [axes for axes in panels(result) if axes.get_ylabel() == "capture probability (%)"]
    own, undecided = in_print(axes, result.own_checked.values)[0], result.wucht.summary["as_it_is"]["checked_undecided"]
    bars = [np.asarray(line.get_xydata(), float) for line in axes.lines if len(np.atleast_1d(line.get_xdata())) == 2]
    assert any(bar == pytest.approx(np.array([own - [0.0, 100 * undecided], own])) for bar in bars)


def test_the_curve_shows_when_runs_settle_and_small_deviations_have_decayed() -> None:
    """To a hundredth, at the rate that is stated."""
    result = searched("held")
    axes = panels(result)[-1]
    lines, dampings, s = lines_of(axes), result.damping.values, result.wucht.summary
    assert lines["runs"] == pytest.approx(np.stack([dampings, result.settling_time.values], axis=1))
    assert lines["linearised, to 1 %"][:, 1] == pytest.approx(np.log(100) / result.decay_rate.values)
    best = [lines[name][0, 0] for name in ("best of the runs", "best linearised")]
    assert best == pytest.approx([s["damping"]["optimum"], s["damping"]["of_rates"]])
    rows = [row for row in s["compared"] if row["settling_time"] is not None and row["bodies"] == 2]
    assert {tuple(xy) for xy in lines["checked"].tolist()} >= {(r["parameters"]["damping"], r["settling_time"]) for r in rows}
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("damping of the bodies (N·m·s)", "median settling time (s)")
    assert (axes.get_xscale(), axes.get_yscale()) == ("log", "log")
    times = np.concatenate([result.settling_time.values, lines["linearised, to 1 %"][:, 1]])
    assert axes.get_ylim() == pytest.approx((times.min() / 1.5, 1.5 * times.max()))
    words = axes.xaxis.get_major_formatter()
    assert [words(x, 0) for x in (0.002, 0.01, 0.5, 20.0)] == ["2·10⁻³", "0.01", "0.5", "20"]
