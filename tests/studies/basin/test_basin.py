"""Maps of basins: of machines whose borders are known in closed form, and against run-ups one by one."""

from __future__ import annotations

import json
import math
from functools import cache
from itertools import combinations
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from tests.hand_made import with_answer
from tests.refusals import refused

from known_borders import border, machine, rail
from wucht import Basin, RunUp
from wucht.dynamics.sampling.label_maps import border_cells
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
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
def balls(across: int = 9, up: int = 8, refine: int = 0) -> xr.Dataset:
    """Balls of one track, which overlap in a band across both seams; the others have no verdict in so short a time."""
    return ask(Basin(axes={"b1": [*TURN, across], "b2": [*TURN, up]}, until=0.02, refine=refine), rail())


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
    names = ("x_axis", "x_low", "x_high", "x_is_angle", "y_axis", "y_low", "y_high", "y_is_angle")
    assert [result.attrs[n] for n in names] == ["drum.speed", *SPEEDS, 0, "drive.slope", *SLOPES, 0]
    assert result.peak_amplitude.attrs == {"long_name": "peak amplitude, without ripple", "units": "m"}
    assert result.settling_time.attrs["units"] == result.end_time.attrs["units"] == "s"
    assert (s["time_unit"], s["amplitude_unit"]) == ("s", "m")
    full = ask(Basin(axes={"drum.speed": [110.0, 120.0, 2], "drive.slope": [0.005, 0.006, 2]}, until=1.0), machine())
    assert full.peak_amplitude.attrs["long_name"] == "peak amplitude"


def test_its_report() -> None:
    s = rotor().wucht.summary
    lines = report(rotor())
    most, least = ((name, s["fractions"][name], s["uncertainty"][name]) for name in ("captured", "passed"))
    assert most[1] > least[1]
    clauses = (f"{name} {100 * share:.1f} % ± {100 * off:.1f} %" for name, share, off in (most, least))
    assert lines[1] == f"verdict: {', '.join(clauses)}"
    bound = 100 * max(s["bound"].values())
    assert lines[2:-1] == [
        "  map          16 x 12 cells over drum.speed and drive.slope",
        "  runs         192",
        f"  shares       ± holds in 19 of 20 cases; the error is at most {bound:.2g} % if the map resolves the borders",
        "  integrated   members are integrated in batches",
    ]


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
    lines = report(refined)
    assert "  map          16 x 12 cells over drum.speed and drive.slope, at the borders halved to those of 64 x 48" in lines
    assert f"  runs         {s['runs']}, instead of 3072 with one in each cell of the finest map" in lines
    shares = ", ".join(f"{100 * level['fractions']['passed']:.4g} %" for level in s["levels"])
    assert f"  by level     passed {shares}" in lines


def test_a_border_across_the_seams() -> None:
    """Bodies that would overlap are no start: these cells are labelled so, and the others are run. Whole turns are periodic:
    the refined map has the band whole there, too."""
    result, refined, dense = balls(), balls(refine=1), balls(18, 16)
    assert np.array_equal(words(result) == "failed", overlap(result.b1, result.b2))
    assert np.array_equal(words(dense) == "failed", overlap(dense.b1, dense.b2))
    assert np.array_equal(refined.refined_outcome.values, dense.outcome.values)
    assert refined.refined_level.values[border_cells(dense.outcome.values, (True, True))].min() == 1
    s = refined.wucht.summary
    assert s["uncertainty"] == dense.wucht.summary["uncertainty"]
    assert s["axes"]["b1"]["periodic"] is s["axes"]["b2"]["periodic"] is True
    failed = int(overlap(result.b1, result.b2).sum())
    first = "the run at b1 = 0.349066, b2 = 0.392699 failed: "
    assert any(w.startswith(f"{first}'b") and "of the track 'ring' overlap" in w for w in result.wucht.warnings)
    assert result.wucht.warnings[-1] == f"{failed - 3} more runs failed"
    assert f"  failed       {failed} runs: see the warnings" in report(result)
    axes = draw(refined).axes
    assert [t.get_text() for t in axes[0].get_xticklabels()] == ["0", "π/2", "π", "3π/2", "2π"]


def test_a_tongue_is_followed_out_of_the_halved_cells() -> None:
    """A band of overlaps narrower than a coarse cell, along the diagonal: it is run also where it leaves the halved cells."""
    close = {"b1": [0.9, 2.9, 5], "b2": [-0.1, 1.9, 5]}
    refined, dense = (
        ask(Basin(axes={name: (low, high, n * k) for name, (low, high, n) in close.items()}, until=0.02, refine=r), rail())
        for k, r in ((1, 2), (4, 0))
    )
    assert np.array_equal(refined.refined_outcome.values, dense.outcome.values)
    assert np.array_equal(words(dense) == "failed", overlap(dense.b1, dense.b2))


def test_failures_are_named_by_their_places_on_each_level() -> None:
    """Two on the coarsest map; the next is the first of the finer one, whose cells are half as large."""
    axes = {"b1": [0.8, 1.6, 4], "b2": [-0.1, 0.1, 2]}
    result = ask(Basin(axes=axes, until=0.02, refine=1), rail())
    told = [w.partition(" failed: ")[0] for w in result.wucht.warnings if w.startswith("the run at ")]
    assert told == [f"the run at b1 = {b1}, b2 = {b2}" for b1, b2 in (("0.9", "-0.05"), ("0.9", "0.05"), ("0.85", "-0.075"))]
    single = ask(Basin(axes={"b1": [0.9, 1.3, 2], "b2": [-0.1, 0.1, 2]}, until=0.02), rail())
    assert single.wucht.summary["failures"] == 1 and "  failed       1 run: see the warnings" in report(single)


def test_uncertainty_covers_what_is_off() -> None:
    """On 8 x 8 to 32 x 32 cells the share that passes is as near to that of 128 x 128 as it is said to be."""
    true = rotor(128, 128).wucht.summary["fractions"]["passed"]
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
    part = f"{100 * share:.3g} % of the map"
    assert told == f"{part} are unidentified, integrated until 20 s; a longer study.until may identify them"
    assert f"  unidentified {part}, integrated until 20 s" in report(result)
    settling = draw(result).axes[1]
    assert settling.get_title() == "settling time (grey: not settled)"


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
    assert report(result)[2] == "  map          12 x 16 cells over drive.slope and carrier.x, with drum.speed at random"
    assert report(result)[4] == "  shares       ± holds in 19 of 20 cases"


def test_what_is_drawn_at_random_is_not_assumed() -> None:
    balls = load_machine("drozdetskaya-2020/r1")
    keys = {"axes": {"carrier.x": [0.0, 1e-3, 2], "drum.speed": [0.0, 1.0, 2]}, "model": "slow", "until": 0.1}
    with_p2, with_both = (
        ask(Basin(**keys, ranges=ranges), balls).wucht.assumed[-1] for ranges in ({"p2": TURN}, {"p1": TURN, "p2": TURN})
    )
    assert "p1" in with_p2 and "p2" not in with_p2
    assert "start at" not in with_both


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
    assert report(result)[1] == "verdict: passed 100 %"
    draw(result)


def test_written_and_read_back(tmp_path: Any) -> None:
    axes = {"drum.speed": [*SPEEDS, 4], "drive.slope": [*SLOPES, 4]}
    result = ask(Basin(axes=axes, model="slow", until=100.0, refine=1), machine(), folder=tmp_path)
    again = load(tmp_path / "result.nc")
    for name in result.variables:
        assert np.array_equal(again[name], result[name], equal_nan=again[name].dtype.kind == "f"), name
        assert again[name].dtype == result[name].dtype
    assert again.outcome.flag_meanings == result.outcome.flag_meanings
    assert again.outcome.flag_values.tolist() == result.outcome.flag_values.tolist()
    assert report(again) == report(result)
    draw(again)


def test_the_dimensions_have_the_names_of_the_axes(tmp_path: Any) -> None:
    """Also a parameter's, with its dot: in the file, in CSV, and in figures of results that have them no more, x and y."""
    axes = {"carrier.stiffness": ["100 kN/m", "200 kN/m", 4], "drum.speed": ["0 rpm", "60 rpm", 2]}
    ask(Basin(axes=axes, until=0.1), machine(), folder=tmp_path)
    result = load(tmp_path / "result.nc")
    assert set(result.data_vars) == {"outcome", "settling_time", "peak_amplitude", "end_time"}
    for name in result.data_vars:
        assert result[name].dims == ("drum.speed", "carrier.stiffness")
    assert result["carrier.stiffness"].values.tolist() == [112500.0, 137500.0, 162500.0, 187500.0]
    assert result["carrier.stiffness"].attrs["units"] == "N/m"
    assert result["drum.speed"].attrs == {"long_name": "speed of drum at the start", "units": "rad/s"}
    here = {"carrier.stiffness": 162500.0, "drum.speed": result["drum.speed"].values[1]}
    assert result.peak_amplitude.sel(here).item() == result.peak_amplitude[1, 2].item()
    file = save_csv(result, tmp_path)[0]
    assert file.name == "basin-drum.speed-carrier.stiffness.csv"
    assert file.read_text().startswith("drum.speed [rad/s],carrier.stiffness [N/m],outcome,")
    earlier = result.rename({"carrier.stiffness": "x", "drum.speed": "y"})
    earlier.attrs["contents"] = json.dumps(list(map(str, earlier.variables)))
    labels = [[f(axis) for f in (Axes.get_xlabel, Axes.get_ylabel)] for axis in draw(result).axes]
    assert labels == [[f(axis) for f in (Axes.get_xlabel, Axes.get_ylabel)] for axis in draw(earlier).axes]
    assert labels[0] == ["stiffness of the carrier (N/m)", "speed of drum at the start (rad/s)"]


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
        assert axis.get_xlabel().replace("\n", " ") == "speed of drum at the start (rad/s)"
    kinds = result.refined_outcome.values
    present = np.unique(kinds).tolist()
    places = np.asarray(outcome.images[0].get_array())
    assert np.array_equal(places, np.searchsorted(present, kinds))
    assert np.array_equal(settling.images[0].get_array(), result.refined_settling_time)
    assert np.allclose(peak.images[0].get_array(), 1e3 * result.refined_peak_amplitude)
    for axis in (settling, peak):
        values = axis.images[0].get_array()
        assert axis.images[0].get_clim() == (values.min(), values.max()) and "grey" not in axis.get_title()
    legend = outcome.get_legend()
    assert [text.get_text().partition(":")[0] for text in legend.get_texts()] == ["captured", "passed"]
    tones = {str(OUTCOMES[k]): to_hex(outcome.images[0].cmap(i)) for i, k in enumerate(present)}
    assert [to_hex(patch.get_facecolor()) for patch in legend.get_patches()] == [tones["captured"], tones["passed"]]


def test_all_outcomes_can_be_told_apart_without_colour() -> None:
    """Any two differ in their hatch, or clearly in brightness (ITU-R BT.709)."""
    count = len(OUTCOMES)
    kinds = xr.zeros_like(rotor(count, 2).outcome) + np.arange(count, dtype=np.int8)
    numbers = {str(o): 1 / count for o in Outcome}
    wide = rotor(count, 2).assign(outcome=kinds.assign_attrs(rotor().outcome.attrs))
    every = with_answer(wide, fractions=numbers, uncertainty=numbers)
    looks = [(patch.get_facecolor(), patch.get_hatch()) for patch in draw(every).axes[0].get_legend().get_patches()]
    assert len(looks) == count

    def brightness(colour: tuple[float, ...]) -> float:
        return float(np.dot(colour[:3], [0.2126, 0.7152, 0.0722]))

    for (one, hatch), (other, other_hatch) in combinations(looks, 2):
        assert hatch != other_hatch or abs(brightness(one) - brightness(other)) > 0.2


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


@pytest.mark.slow
def test_figure_5_10_on_a_coarse_grid() -> None:
    """The share of compensation at u = 1 of cases.md is 0.0396 +- 0.002; 16 x 16 cells know it to what they say."""
    coarse = {"study.axes.psi": [0.0, 2 * math.pi, 16], "study.axes.delta": [0.0, math.pi, 16]}
    study = read_study("drozdetskaya-2020/figure-5.10", coarse)
    result = ask(study.spec, study.subject)
    s = result.wucht.summary
    assert set(s["fractions"]) == {"compensated", "captured"}
    assert abs(s["fractions"].get("compensated", 0.0) - 0.0396) < s["uncertainty"]["compensated"] + 0.002
    assert s["uncertainty"]["compensated"] < 0.04
    # By the text of 5.5 only starts near the compensating phases do: there delta is 2.3728.
    deltas = result.delta.values[(words(result) == "compensated").any(axis=1)]
    assert deltas.min() > 0.7
    assert deltas.max() < 2.9
    assert np.abs(deltas - 2.3728).min() < math.pi / 16


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


@pytest.mark.slow
def test_refined_as_the_dense_map_of_figure_5_10() -> None:
    """At u = 1, 16 x 16 cells halved three times are 128 x 128: the same map from far fewer runs."""
    grid = {"study.axes.psi": [0.0, 2 * math.pi, 16], "study.axes.delta": [0.0, math.pi, 16], "study.refine": 3}
    refined, dense = (
        ask(s.spec, s.subject)
        for s in (
            read_study("drozdetskaya-2020/figure-5.10", grid),
            read_study(
                "drozdetskaya-2020/figure-5.10",
                {"study.axes.psi": [0.0, 2 * math.pi, 128], "study.axes.delta": [0.0, math.pi, 128]},
            ),
        )
    )
    assert (refined.refined_outcome.values != dense.outcome.values).mean() < 1e-3
    assert refined.wucht.summary["runs"] < 0.2 * refined.wucht.summary["runs_of_dense_map"]
