"""Sobol' indices of indicators that are known in closed form."""

from __future__ import annotations

import numpy as np
import pytest
import xarray as xr
from matplotlib.container import BarContainer
from tests.refusals import refused

from wucht.plots.sheet import new_grid
from wucht.studies.capture_probability import distributions
from wucht.studies.capture_probability import figure as probability_figure
from wucht.studies.capture_probability.distributions import cross_samples, indices, library


def test_what_does_not_enter_does_not_matter() -> None:
    """Of x1 + 0 x2 > c the first has all, alone and with the second."""
    at = cross_samples(512, 2, seed=1)
    found = indices(at[:, 0] > 0.3, np.zeros(len(at), bool), 2, 0.95, seed=1)
    assert found.first[0] == pytest.approx(1.0, abs=0.05)
    assert found.total[0] == pytest.approx(1.0, abs=0.05)
    assert found.first[1] == found.total[1] == found.total_off[1] == 0.0
    assert found.first_off[0] > 0


def test_a_corner() -> None:
    """Of x1 < a and x2 < b, x3 idle: with p = a b, S1 = b (1 - a)/(1 - p), T1 = (1 - a)/(1 - p), and so for the second."""
    a, b = 0.7, 0.4
    at = cross_samples(1024, 3, seed=2)
    found = indices((at[:, 0] < a) & (at[:, 1] < b), np.zeros(len(at), bool), 3, 0.95, seed=2)
    first = np.array([b * (1 - a), a * (1 - b), 0.0]) / (1 - a * b)
    total = np.array([1 - a, 1 - b, 0.0]) / (1 - a * b)
    assert np.abs(found.first - first) == pytest.approx(0.0, abs=0.06)
    assert np.abs(found.total - total) == pytest.approx(0.0, abs=0.06)
    assert (np.abs(found.first - first) <= found.first_off).all()
    assert (np.abs(found.total - total) <= found.total_off).all()
    assert (found.used_points, found.count) == (1024, 1024)


def test_its_intervals_hold() -> None:
    """Resampled as if the points were independent, they are too wide rather than too narrow."""
    a, b, held = 0.6, 0.5, []
    for seed in range(12):
        at = cross_samples(128, 2, seed)
        found = indices((at[:, 0] < a) & (at[:, 1] < b), np.zeros(len(at), bool), 2, 0.95, seed)
        held.append(abs(found.first[0] - b * (1 - a) / (1 - a * b)) <= found.first_off[0])
        held.append(abs(found.total[1] - (1 - b) / (1 - a * b)) <= found.total_off[1])
    assert np.mean(held) >= 0.9


def test_points_with_an_open_run_are_left_out() -> None:
    at = cross_samples(256, 2, seed=4)
    open_ = np.zeros(len(at), bool)
    open_[[1, 2, 4 * 7 + 3]] = True
    found = indices(at[:, 0] > 0.5, open_, 2, 0.95, seed=4)
    assert (found.used_points, found.count) == (254, 256)
    changed = at[:, 0] > 0.5
    changed[open_] = ~changed[open_]
    again = indices(changed, open_, 2, 0.95, seed=4)
    assert np.array_equal(again.first, found.first)
    assert np.array_equal(again.total_off, found.total_off)


@pytest.mark.parametrize("inside", [np.zeros(64 * 4, bool), np.ones(64 * 4, bool)])
def test_where_all_end_alike_there_are_none(inside: np.ndarray) -> None:
    found = indices(inside, np.zeros(len(inside), bool), 2, 0.95, seed=0)
    assert np.isnan(found.first).all()
    assert np.isnan(found.total).all()
    none_known = indices(inside, np.ones(len(inside), bool), 2, 0.95, seed=0)
    assert none_known.used_points == 0
    assert np.isnan(none_known.total).all()


def test_the_same_again() -> None:
    at = cross_samples(64, 3, seed=0)
    assert np.array_equal(at, cross_samples(64, 3, seed=0))
    inside, known = at.sum(axis=1) > 1.4, np.zeros(len(at), bool)
    one, other = (indices(inside, known, 3, 0.95, seed=0) for _ in range(2))
    assert np.array_equal(one.first_off, other.first_off)


def test_without_the_library_that_is_said(monkeypatch: pytest.MonkeyPatch) -> None:
    def missing(name: str) -> None:
        raise ImportError(name)

    monkeypatch.setattr(distributions, "import_module", missing)
    with refused("study.sensitivity", "wucht[sensitivity]", given=True) as raised:
        library()
    assert raised.value.location == "study.sensitivity"


def test_bars_of_indices_the_one_that_matters_most_at_the_top() -> None:
    result = xr.Dataset(
        {
            "total": ("quantity", [0.2, 0.7]), "total_off": ("quantity", [0.02, 0.07]), "first_order": ("quantity", [0.1, 0.6]),
            "first_order_off": ("quantity", [0.01, 0.06]),
        },
        {"quantity": ["mass", "damping"]},
    )  # fmt: skip
    _, (axis,) = new_grid(1, "title")
    probability_figure._draw_indices(axis, result, {"sensitivity": {"at": 3.0}, "unit": "W"})
    assert [text.get_text() for text in axis.get_yticklabels()] == ["damping", "mass"]
    assert axis.get_ylim()[0] > axis.get_ylim()[1], "downwards"
    first, total = (c for c in axis.containers if isinstance(c, BarContainer))
    for bars, widths, side in ((first, [0.6, 0.1], -0.18), (total, [0.7, 0.2], 0.18)):
        assert [b.get_width() for b in bars] == widths
        assert [b.get_y() + b.get_height() / 2 for b in bars] == pytest.approx([side, 1 + side])
        assert bars.errorbar is not None and bars.errorbar.has_xerr and not bars.errorbar.has_yerr
    assert axis.get_title() == "sensitivity at 3 W"


def test_the_curve_of_a_probability_its_band_and_where_it_is_reached() -> None:
    """Without a verdict for one value; the last estimate is of the search."""
    columns = {
        "estimate": [0.1, 0.5, 0.9], "low": [0.0, 0.4, 0.8], "high": [0.2, 0.7, 1.0], "not_identified": [0.0, 0.2, 0.0],
        "searched": [False, False, True],
    }  # fmt: skip
    result = xr.Dataset({name: ("parameter", v) for name, v in columns.items()}, {"parameter": ("parameter", [1.0, 2.0, 3.0])})
    result["parameter"].attrs["long_name"] = "power"
    summary = {
        "confidence": 0.95, "wanted": 0.8, "smallest": 2.5, "along": "drive.power", "unit": "W", "outcome": ["passage"],
        "range": [0.5, 3.5],
    }  # fmt: skip
    _, (axis,) = new_grid(1, "title")
    probability_figure._draw_probability(axis, result, summary)
    band, open_ = (c.get_paths()[0].vertices for c in axis.collections[:2])
    assert {tuple(v) for v in band} >= {(1.0, 0.0), (1.0, 0.2), (2.0, 0.4), (2.0, 0.7), (3.0, 0.8), (3.0, 1.0)}
    assert {tuple(v) for v in open_.round(9)} >= {(2.0, 0.4), (2.0, 0.6), (1.0, 0.1), (3.0, 0.9)}
    lines = {str(line.get_label()): line.get_xydata() for line in axis.get_lines()}
    assert lines["target: 0.8"][:, 1].tolist() == [0.8, 0.8] and lines["reached at 2.5 W"][:, 0].tolist() == [2.5, 2.5]
    assert lines["estimate"].tolist() == [[1.0, 0.1], [2.0, 0.5]] and lines["of the search"].tolist() == [[3.0, 0.9]]
    narrow = result.assign(not_identified=("parameter", [0.0, 1e-3, 0.0]))
    _, (beside,) = new_grid(1, "title")
    probability_figure._draw_probability(beside, narrow, summary)
    names = [axis.get_legend_handles_labels()[1] for axis in (axis, beside)]
    assert set(names[0]) - set(names[1]) == {"no verdict"}, "what cannot be seen has no name"
    assert axis.get_xlim() == pytest.approx((0.455, 3.545)) and axis.get_legend_handles_labels()[1][0] == "95 % confidence"
