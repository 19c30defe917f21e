"""Maps of basins: of machines whose borders are known in closed form, and against run-ups one by one."""

from __future__ import annotations

import math
from functools import cache
from typing import Any

import numpy as np
import pytest
import xarray as xr
from benchmarks.verdicts import MACHINES
from tests.refusals import refused

from known_borders import border, machine, rail
from wucht import Basin, RunUp
from wucht.dynamics.sampling.label_maps import border_cells
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.results.spreadsheets import save_csv
from wucht.studies.runner import draw, load, report
from wucht.studies.runner import run as ask
from wucht.studies.study_file import read_study

SPEEDS, SLOPES = [97.0, 107.0], [0.004, 0.007]
TURN = [0.0, 2 * math.pi]
AXES = {"drum.speed": [*SPEEDS, 2], "drive.slope": [*SLOPES, 2]}


@cache
def rotor(across: int = 16, up: int = 12, **keys: Any) -> xr.Dataset:
    """Which of two steady speeds is reached: columns are start speeds, rows slopes of the motor."""
    axes = {"drum.speed": [*SPEEDS, across], "drive.slope": [*SLOPES, up]}
    return ask(Basin(**{"axes": axes, "model": "slow", "until": 100.0} | keys), machine())


@cache
def balls(across: int = 7, up: int = 6, refine: int = 0) -> xr.Dataset:
    """Balls of one track, which overlap in a band across both seams; the others have no verdict in so short a time."""
    return ask(Basin(axes={"b1": [*TURN, across], "b2": [*TURN, up]}, until=0.002, refine=refine), rail())


def words(result: xr.Dataset, name: str = "outcome") -> np.ndarray:
    """The outcome of each cell, by its flags."""
    flags = dict(zip(result[name].flag_values.tolist(), result[name].flag_meanings.split(), strict=True))
    return np.asarray(np.vectorize(flags.get)(result[name].values))


def overlap(b1: Any, b2: Any) -> np.ndarray:
    one, other = np.meshgrid(b1, b2)
    return np.asarray(np.abs(np.remainder(one - other + math.pi, 2 * math.pi) - math.pi) < math.pi / 3)


def test_the_map_has_each_cell_where_it_belongs() -> None:
    """Columns are over x, rows over y, at the centres of the cells; the border is known to 0.3 rad/s, half a cell."""
    result = rotor()
    speeds, slopes = 97 + (np.arange(16) + 0.5) * 10 / 16, 0.004 + (np.arange(12) + 0.5) * 0.003 / 12
    assert np.allclose(result["drum.speed"], speeds) and np.allclose(result["drive.slope"], slopes)
    assert result.outcome.dims == ("drive.slope", "drum.speed")
    beyond = speeds - np.array([[border(slope)] for slope in slopes])
    passed = words(result) == "passed"
    assert passed[beyond > 0.3].all() and not passed[beyond < -0.3].any()
    assert set(words(result).ravel()) == {"passed", "captured"}
    assert np.isfinite(result.settling_time).all() and (result.settling_time <= result.end_time).all()
    assert (result.end_time > 1).all() and (result.end_time <= 100.0).all() and (result.peak_amplitude > 0).all()
    s = result.wucht.summary
    assert s["fractions"] == {"passed": pytest.approx(passed.mean()), "captured": pytest.approx(1 - passed.mean())}
    assert (s["runs"], s["runs_of_dense_map"], s["missing"], s["failures"], s["until"]) == (192, 192, 0, 0, 100.0)
    assert s["axes"]["drum.speed"] == {"range": SPEEDS, "cells": 16, "unit": "rad/s", "periodic": False}
    for name in ("passed", "captured"):
        ends = result.end_time.values[words(result) == name]
        assert s["followed"][name] == [ends.min(), ends.max()]
    assert result.peak_amplitude.attrs == {"long_name": "peak amplitude, without ripple", "units": "m"}


@pytest.mark.slow
def test_refined_borders_are_those_of_the_dense_map() -> None:
    """Each cell is as in the dense map, from far fewer runs; cells that are not run have what the coarser cell has."""
    refined, dense, coarse = rotor(refine=2), rotor(64, 48), rotor()
    assert np.array_equal(refined.refined_outcome.values, dense.outcome.values)
    for name in ("drum.speed", "drive.slope"):
        assert np.array_equal(refined[f"refined_{name}"], dense[name])
    assert refined.refined_outcome.dims == ("refined_drive.slope", "refined_drum.speed")
    assert np.array_equal(refined.outcome, coarse.outcome)
    s, of_dense = refined.wucht.summary, dense.wucht.summary
    assert s["fractions"] == of_dense["fractions"] and s["uncertainty"] == of_dense["uncertainty"]
    assert s["runs"] < 0.3 * s["runs_of_dense_map"] == 0.3 * 64 * 48
    assert s["runs"] == sum(level["runs"] for level in s["levels"])
    assert [level["cells"] for level in s["levels"]] == [[16, 12], [32, 24], [64, 48]]
    levels, outcome = refined.refined_level.values, dense.outcome.values
    assert levels[border_cells(outcome, (False, False))].tolist().count(2) == border_cells(outcome, (False, False)).sum()
    assert np.unique(levels).tolist() == [0, 1, 2]
    for name in ("settling_time", "peak_amplitude", "end_time"):
        values = refined[f"refined_{name}"].values
        assert np.array_equal(values[levels == 2], dense[name].values[levels == 2])
        assert np.array_equal(values[levels == 0], np.kron(coarse[name].values, np.ones((4, 4)))[levels == 0])


@pytest.mark.slow
def test_a_border_across_the_seams() -> None:
    """Bodies that would overlap are no start: these cells are labelled so, and the others are run. Whole turns are periodic:
    the refined map has the band whole there, too."""
    result, refined, dense = balls(), balls(refine=1), balls(14, 12)
    assert np.array_equal(words(result) == "failed", overlap(result.b1, result.b2))
    assert np.array_equal(words(dense) == "failed", overlap(dense.b1, dense.b2))
    assert np.array_equal(refined.refined_outcome.values, dense.outcome.values)
    assert refined.refined_level.values[border_cells(dense.outcome.values, (True, True))].min() == 1
    s = refined.wucht.summary
    assert s["uncertainty"] == dense.wucht.summary["uncertainty"]
    assert s["axes"]["b1"]["periodic"] is s["axes"]["b2"]["periodic"] is True
    failed = int(overlap(result.b1, result.b2).sum())
    assert any(w.startswith("the run at b1 = 0.448799, b2 = 0.523599 failed: ") for w in result.wucht.warnings)
    assert result.wucht.warnings[-1] == f"{failed - 3} more runs failed"
    assert report(result) and draw(refined).axes


@pytest.mark.slow
def test_a_tongue_is_followed_out_of_the_halved_cells() -> None:
    """A band of overlaps narrower than a coarse cell, along the diagonal: it is run also where it leaves the halved cells."""
    close = {"b1": [0.9, 2.9, 5], "b2": [-0.1, 1.9, 5]}
    refined, dense = (
        ask(Basin(axes={name: (low, high, n * k) for name, (low, high, n) in close.items()}, until=0.002, refine=r), rail())
        for k, r in ((1, 2), (4, 0))
    )
    assert np.array_equal(refined.refined_outcome.values, dense.outcome.values)
    assert np.array_equal(words(dense) == "failed", overlap(dense.b1, dense.b2))


def test_uncertainty_covers_what_is_off() -> None:
    """On 8 x 8 to 32 x 32 cells the share that passes is as near to that of 64 x 48 as it is said to be."""
    true = rotor(64, 48).wucht.summary["fractions"]["passed"]
    off, said = [], []
    for cells in (8, 16, 32):
        s = rotor(cells, cells).wucht.summary
        off.append(abs(s["fractions"]["passed"] - true))
        said.append(s["uncertainty"]["passed"])
        assert s["bound"]["passed"] > said[-1]
    assert all(a < b for a, b in zip(off, said, strict=True))
    assert said[2] < 0.6 * said[1] < 0.36 * said[0]


def test_what_has_no_verdict_is_told() -> None:
    result = rotor(until=20.0)
    share = result.wucht.summary["fractions"]["unidentified"]
    assert 0.05 < share < 0.6
    (told,) = result.wucht.warnings
    assert told.startswith(f"{100 * share:.3g} % of the map are unidentified, integrated until 20 s")
    assert report(result) and draw(result).axes


def test_further_quantities_are_drawn_at_random() -> None:
    """The speed at the start: of each slope as many starts get through as lie above its border."""
    axes = {"drive.slope": [*SLOPES, 12], "carrier.x": [-1e-4, 1e-4, 16]}
    result = ask(Basin(axes=axes, ranges={"drum.speed": SPEEDS}, seed=1, model="slow", until=100.0), machine())
    slopes = SLOPES[0] + (np.arange(12) + 0.5) * (SLOPES[1] - SLOPES[0]) / 12
    share = np.mean([(SPEEDS[1] - border(slope)) / (SPEEDS[1] - SPEEDS[0]) for slope in slopes])
    s = result.wucht.summary
    assert s["fractions"]["passed"] == pytest.approx(share, abs=3 * s["standard_errors"]["passed"])
    assert s["standard_errors"]["passed"] == pytest.approx(math.sqrt(share * (1 - share) / 192), rel=0.1)
    assert s["bound"] == {}, "there is no border"
    assert s["ranges"] == {"drum.speed": SPEEDS}
    assert report(result)


def test_random_starts_have_no_border_and_are_no_axis() -> None:
    with refused("study.refine", given=1):
        ask(Basin(axes=AXES, ranges={"carrier.x": [0.0, 1e-3]}, refine=1), machine())
    with refused("study.ranges.drum.speed", given="drum.speed", code="given-twice"):
        ask(Basin(axes=AXES, ranges={"drum.speed": SPEEDS}), machine())


def test_nothing_but_one_outcome() -> None:
    """No border: nothing is halved, and the share is certain."""
    axes = {"drum.speed": [110.0, 115.0, 6], "drive.slope": [*SLOPES, 4]}
    result = ask(Basin(axes=axes, model="slow", until=100.0, refine=3), machine())
    s = result.wucht.summary
    assert (s["runs"], s["fractions"], s["uncertainty"]) == (24, {"passed": 1.0}, {"passed": 0.0})
    assert result.refined_outcome.shape == (32, 48)
    assert report(result) and draw(result).axes


def test_the_dimensions_have_the_names_of_the_axes(tmp_path: Any) -> None:
    """Also a parameter's, with its dot: in the file, in CSV, and in figures of results that have them no more, x and y."""
    axes = {"carrier.stiffness": ["100 kN/m", "200 kN/m", 4], "drum.speed": ["0 rpm", "60 rpm", 2]}
    ask(Basin(axes=axes, until=0.1), machine(), folder=tmp_path)
    result = load(tmp_path / "result.nc")
    assert set(result.data_vars) == {"outcome", "settling_time", "peak_amplitude", "end_time"}
    for name in result.data_vars:
        assert result[name].dims == ("drum.speed", "carrier.stiffness")
    assert result["carrier.stiffness"].values.tolist() == [112500.0, 137500.0, 162500.0, 187500.0]
    here = {"carrier.stiffness": 162500.0, "drum.speed": result["drum.speed"].values[1]}
    assert result.peak_amplitude.sel(here).item() == result.peak_amplitude[1, 2].item()
    file = save_csv(result, tmp_path)[0]
    assert file.name == "basin-drum.speed-carrier.stiffness.csv"
    assert file.read_text().startswith("drum.speed [rad/s],carrier.stiffness [N/m],outcome,")


def test_an_axis_is_no_variable_of_the_map() -> None:
    body = {"kind": "pendulum", "name": "outcome", "about": "drum", "mass": 0.1, "length": 0.05, "damping": 0.01}
    of_that_name = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [{"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}, body],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
    })  # fmt: skip
    with refused("study.axes.outcome", given="outcome"):
        ask(Basin(axes={"outcome": [0.0, 1.0, 2], "drum": [0.0, 1.0, 2]}), of_that_name)


# The figure


def test_cells_are_drawn_where_they_are() -> None:
    """Of the finer map, the smallest numbers at the lower left."""
    result = rotor(refine=1)
    outcome, settling, peak = [axis for axis in draw(result).axes if axis.images]
    for axis in (outcome, settling, peak):
        assert axis.images[0].get_extent() == pytest.approx([*SPEEDS, *SLOPES])
        assert axis.images[0].origin == "lower"
    kinds = result.refined_outcome.values
    present = np.unique(kinds).tolist()
    places = np.asarray(outcome.images[0].get_array())
    assert np.array_equal(places, np.searchsorted(present, kinds))
    assert np.array_equal(settling.images[0].get_array(), result.refined_settling_time)
    assert np.allclose(peak.images[0].get_array(), 1e3 * result.refined_peak_amplitude)


# By the engine, against run-ups

# The last: how far peaks may differ. That of averaged equations is without the ripple of a few per cent that a run-up adds.
CASES = [
    pytest.param(
        "drozdetskaya-2020/table-5.1",
        {"u": 2.5},
        {"psi": [0.0, 2 * math.pi, 3], "delta": [0.0, math.pi, 2]},
        "slow",
        0.06,
        marks=pytest.mark.slow,
    ),
    ("drozdetskaya-2020/r1", {}, {"drive.slope": [0.0, 0.1, 2], "p1": [0.0, 3.0, 2]}, "full", 1e-3),
]


@pytest.mark.parametrize(("name", "changed", "axes", "model", "near"), CASES, ids=["slow", "full"])
def test_each_cell_ends_as_its_run_up(
    name: str, changed: dict[str, float], axes: dict[str, Any], model: Any, near: float
) -> None:
    """By the study ``run-up``, whose equations are integrated by themselves to 1e-10."""
    machine = load_machine(name).with_values(changed)
    result = ask(Basin(axes=axes, model=model), machine)
    found = words(result)
    for row, column in np.ndindex(*found.shape):
        place = {n: float(result[n][k]) for n, k in zip(axes, (column, row), strict=True)}
        values = {n: v for n, v in place.items() if n in machine.parameters}
        start = {n: v for n, v in place.items() if n not in values}
        alone = ask(RunUp(start=start, model=model, tolerance=1e-10), machine.with_values(values)).wucht.summary
        assert found[row, column] == alone["outcome"], place
        assert float(result.peak_amplitude[row, column]) == pytest.approx(alone["peak_amplitude"], rel=near), place


def test_members_that_need_it_are_run_one_by_one_and_that_is_told(wucht: Any, no_figures: None) -> None:
    axes = 'study.axes={"b1" = [0, 3, 2], "b2" = [0, 3, 2]}'
    settings = ("study.kind=basin", "study.until=0.5 s", "study.start={}", axes)
    done = wucht("run", "sperling-vibration/figure-4", *(word for setting in settings for word in ("--set", setting)))
    assert done.code == 0, done.err
    assert "one by one" in done.out and "bodies are released on the way" in done.out


@pytest.mark.parametrize(
    ("of", "until", "cells"),
    [(0, 240.0, 2), *(pytest.param(of, until, 6, marks=pytest.mark.slow) for of in (1, 2) for until in (None, 240.0))],
)
def test_settled_members_are_not_called_unidentified(of: int, until: float | None, cells: int) -> None:
    """However long the run: of ``benchmarks.verdicts``. All starts compensate; 12 x 12 of the series motor were integrated
    independently."""
    turn = ["0 deg", "360 deg", cells]
    basin = Basin(axes={"p1": turn, "p2": turn}, until=until)
    assert basin.tolerance == 1e-6
    assert ask(basin, MACHINES[of].machine()).wucht.summary["fractions"] == {"compensated": 1.0}


@pytest.mark.slow
@pytest.mark.parametrize(("u", "share"), [(1.0, 0.0396), (2.5, 0.2488), (3.0, 0.6326)])
def test_shares_of_figure_5_10(u: float, share: float) -> None:
    """On 64 x 64 cells, averaged equations."""
    study = read_study("drozdetskaya-2020/figure-5.10", {"u": u})
    s = ask(study.spec, study.subject).wucht.summary
    assert s["fractions"].get("compensated", 0.0) == pytest.approx(share, abs=0.002)


@pytest.mark.slow
@pytest.mark.parametrize(("u", "share"), [(1.0, 0.045), (2.5, 0.255)])
def test_shares_in_the_full_equations(u: float, share: float) -> None:
    """On 32 x 32 cells; the last digit printed, half a cell at the border of two dozen cells."""
    grid = {"study.axes.psi": [0.0, 2 * math.pi, 32], "study.axes.delta": [0.0, math.pi, 32], "study.model": "full"}
    study = read_study("drozdetskaya-2020/figure-5.10", grid | {"u": u})
    assert ask(study.spec, study.subject).wucht.summary["fractions"]["compensated"] == pytest.approx(share, abs=0.002)
