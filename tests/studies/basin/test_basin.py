"""Maps of basins: with known borders in the place of the engine, and by the engine against run-ups one by one."""

from __future__ import annotations

import json
import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from matplotlib.axes import Axes
from tests.refusals import refused

from known_basins import MACHINE, TURN, Region, engine, share_of, spiral
from wucht.dynamics.sampling.label_maps import border_cells
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.machines.machine import Machine
from wucht.results.spreadsheets import save_csv
from wucht.studies.basin import computation as running
from wucht.studies.basin.computation import VARIABLES, prepare
from wucht.studies.basin.spec import Basin
from wucht.studies.run_up.study import RunUp
from wucht.studies.runner import draw, load, report
from wucht.studies.runner import run as ask
from wucht.studies.study_file import read_study

CYCLIC = (False, True)  # rows of delta up to pi do not close, columns of psi do


def asked(monkeypatch: pytest.MonkeyPatch, inside: Region = spiral, fail: Region | None = None, **more: Any) -> xr.Dataset:
    monkeypatch.setattr(running, "outcomes_of", engine(inside, fail=fail))
    return ask(Basin(**{"axes": TURN, "model": "slow"} | more), MACHINE)


def words(result: xr.Dataset, name: str = "outcome") -> np.ndarray:
    """The outcome of each cell, by its flags."""
    flags = dict(zip(result[name].flag_values.tolist(), result[name].flag_meanings.split(), strict=True))
    return np.asarray(np.vectorize(flags.get)(result[name].values))


def test_the_map_has_each_cell_where_it_belongs(monkeypatch: pytest.MonkeyPatch) -> None:
    result = asked(monkeypatch)
    psi, delta = np.meshgrid((np.arange(32) + 0.5) * math.pi / 16, (np.arange(16) + 0.5) * math.pi / 16)
    assert np.allclose(result.psi, psi[0])
    assert np.allclose(result.delta, delta[:, 0])
    assert np.array_equal(words(result) == "compensated", spiral(psi, delta))
    assert np.allclose(result.settling_time, 100 + psi + delta)
    assert np.allclose(result.peak_amplitude, psi)
    s = result.wucht.summary
    assert s["fractions"] == {
        "compensated": pytest.approx(spiral(psi, delta).mean()),
        "captured": pytest.approx(1 - share_of(s)),
    }
    assert s["runs"] == s["runs_of_dense_map"] == 512
    assert s["missing"] == 0
    assert result.psi.attrs == {"long_name": "mean phase of p1 and p2 at the start", "units": ""}
    assert all({"long_name", "units"} <= set(result[name].attrs) for name in result.variables)


def test_refined_borders_are_those_of_the_dense_map(monkeypatch: pytest.MonkeyPatch) -> None:
    """The arms of the spiral end thinner than a coarse cell and lie over the seam: each cell is as in the dense map."""
    refined = asked(monkeypatch, refine=3)
    fine = {"psi": [*TURN["psi"][:2], 256], "delta": [*TURN["delta"][:2], 128]}
    dense = asked(monkeypatch, axes=fine)
    assert np.array_equal(refined.refined_outcome.values, dense.outcome.values)
    assert np.array_equal(refined.refined_psi, dense.psi)
    assert np.array_equal(refined.outcome, asked(monkeypatch).outcome)
    s, of_dense = refined.wucht.summary, dense.wucht.summary
    assert s["fractions"] == of_dense["fractions"]
    assert s["uncertainty"] == of_dense["uncertainty"]
    assert s["runs"] < 0.25 * s["runs_of_dense_map"]
    assert s["runs"] == sum(level["runs"] for level in s["levels"])
    # Each cell at a border was run itself, and says what its own run gave.
    run_here = refined.refined_level.values == 3
    assert run_here[border_cells(refined.refined_outcome.values, CYCLIC)].all()
    assert np.array_equal(refined.refined_settling_time.values[run_here], dense.settling_time.values[run_here])
    assert np.unique(refined.refined_level).tolist() == [0, 1, 2, 3]


def test_a_tongue_is_followed_out_of_the_halved_cells(monkeypatch: pytest.MonkeyPatch) -> None:
    """A tongue of a tenth of a coarse cell's width, as long as six cells, between the centres of all of them."""

    def tongue(psi: np.ndarray, delta: np.ndarray) -> np.ndarray:
        return np.asarray((delta < 0.6) | ((np.abs(psi - 3.2) < 0.02) & (delta < 1.8)))

    coarse, refined = asked(monkeypatch, tongue), asked(monkeypatch, tongue, refine=4)
    assert not (words(coarse) == "compensated")[4:].any()
    found = words(refined, "refined_outcome") == "compensated"
    psi, delta = np.meshgrid(refined.refined_psi, refined.refined_delta)
    assert np.array_equal(found, tongue(psi, delta))
    assert found[refined.refined_delta.values > 1.7].any()


def test_uncertainty_covers_what_is_off(monkeypatch: pytest.MonkeyPatch) -> None:
    """On 16 x 16 to 64 x 64 cells the share of a spiral is as near to that of 512 x 512 as it is said to be."""
    at = (np.arange(512) + 0.5) / 512
    true = spiral(*np.meshgrid(2 * math.pi * at, math.pi * at)).mean()
    off, said = [], []
    for cells in (16, 32, 64):
        s = asked(monkeypatch, axes={"psi": [0.0, 2 * math.pi, cells], "delta": [0.0, math.pi, cells]}).wucht.summary
        off.append(abs(share_of(s) - true))
        said.append(s["uncertainty"]["compensated"])
        assert s["bound"]["compensated"] > said[-1]
    assert all(a < b for a, b in zip(off, said, strict=True))
    assert said[2] < 0.6 * said[1] < 0.36 * said[0]


def test_it_is_told_and_drawn(monkeypatch: pytest.MonkeyPatch) -> None:
    result = asked(monkeypatch, fail=lambda psi, delta: (psi < 0.3) & (delta > 2.9), refine=1)
    lines = report(result)
    assert lines[1].startswith("verdict: captured ")
    assert "±" in lines[1]
    assert any("32 x 16 cells over psi and delta, at the borders halved to those of 64 x 32" in line for line in lines)
    warnings = result.wucht.warnings
    assert any("the run at psi = 0.0981748, delta = 3.04342 failed: it is a test" in w for w in warnings)
    drawn = draw(result)
    labels = [t.get_text() for t in drawn.axes[0].get_xticklabels()]
    assert labels == ["0", "π/2", "π", "3π/2", "2π"]
    legend = drawn.axes[0].get_legend()
    assert legend is not None
    names = [t.get_text() for t in legend.get_texts()]
    assert [n.split(":")[0] for n in names] == ["captured", "compensated", "failed"]
    hatches = [p.get_hatch() for p in legend.get_patches()]
    assert len(set(hatches)) == 3, "outcomes differ without colour"


def test_written_and_read_back(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    monkeypatch.setattr(running, "outcomes_of", engine(spiral))
    result = ask(Basin(axes=TURN, model="slow", refine=1), MACHINE, folder=tmp_path)
    again = load(tmp_path / "result.nc")
    for name in result.variables:
        assert np.array_equal(again[name], result[name], equal_nan=again[name].dtype.kind == "f"), name
        assert again[name].dtype == result[name].dtype
    assert again.outcome.flag_meanings == result.outcome.flag_meanings
    assert again.outcome.flag_values.tolist() == result.outcome.flag_values.tolist()
    assert report(again) == report(result)
    draw(again)


def test_the_dimensions_have_the_names_of_the_axes(monkeypatch: pytest.MonkeyPatch, tmp_path: Any) -> None:
    """Also a parameter's, with its dot: in the file, in CSV, and in figures of results that have them no more, x and y."""
    axes = {"carrier.stiffness": ["1 kN/m", "2 kN/m", 4], "drum.speed": ["0 rpm", "60 rpm", 2]}
    monkeypatch.setattr(running, "outcomes_of", engine(lambda a, b: a > 0, read=lambda starts, machine: (starts[0], starts[1])))
    ask(Basin(axes=axes), rail(), folder=tmp_path)
    result = load(tmp_path / "result.nc")
    assert set(result.data_vars) == set(VARIABLES) - {"level"}
    for name in result.data_vars:
        assert result[name].dims == ("drum.speed", "carrier.stiffness")
    assert result["carrier.stiffness"].values.tolist() == [1125.0, 1375.0, 1625.0, 1875.0]
    assert result["carrier.stiffness"].attrs["units"] == "N/m"
    assert result["drum.speed"].attrs == {"long_name": "speed of drum at the start", "units": "rad/s"}
    here = {"carrier.stiffness": 1625.0, "drum.speed": result["drum.speed"].values[1]}
    assert result.outcome.sel(here).item() == result.outcome[1, 2].item()
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
    machine = machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [{"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2}, body],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
    })  # fmt: skip
    with refused("study.axes.outcome", given="outcome"):
        prepare(Basin(axes={"outcome": [0.0, 1.0, 2], "drum": [0.0, 1.0, 2]}), machine)


def test_nothing_but_one_outcome(monkeypatch: pytest.MonkeyPatch) -> None:
    """No border: nothing is halved, and the share is certain."""
    result = asked(monkeypatch, lambda psi, delta: psi > 100, refine=3)
    s = result.wucht.summary
    assert (s["runs"], s["fractions"], s["uncertainty"]) == (512, {"captured": 1.0}, {"captured": 0.0})
    assert result.refined_outcome.shape == (128, 256)
    assert "captured 100 %" in report(result)[1]
    draw(result)


def rail(**more: Any) -> Machine:
    """Two balls in one track of a drum, each a sixth of a turn wide."""
    ball = {"kind": "roller", "about": "drum", "mass": 0.1, "track_radius": 0.06, "radius": 0.02, "shape_factor": 0.4}
    return machine_from({
        "carrier": {"mass": 1.0, "stiffness": 1e4, "damping": 20.0},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 1e-2},
            *(ball | {"name": name, "damping": 0.01, "track": "ring", "restitution": 0.6} for name in ("b1", "b2")),
        ],
        "drive": {"kind": "linear", "slope": 0.02, "no_load_speed": 150.0},
        **more,
    })  # fmt: skip


def test_bodies_that_would_overlap_are_no_start(monkeypatch: pytest.MonkeyPatch) -> None:
    """They are labelled so, and the other cells are run."""
    seen: list[float] = []

    def angles(starts: np.ndarray, machine: Machine) -> tuple[np.ndarray, np.ndarray]:
        b1, b2 = (starts[machine.row(machine.body(n).coordinate.position)] for n in ("b1", "b2"))
        seen.append(float(between(b1, b2).min()))
        return b1, b2

    def between(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return np.abs(np.remainder(a - b + math.pi, 2 * math.pi) - math.pi)

    monkeypatch.setattr(running, "outcomes_of", engine(lambda b1, b2: b1 > b2, read=angles))
    turn, width = [0.0, 2 * math.pi, 13], 2 * math.asin(0.02 / 0.04)
    result = ask(Basin(axes={"b1": turn, "b2": turn}), rail())
    apart = between(*np.meshgrid(result.b1, result.b2))
    assert np.array_equal(words(result) == "failed", apart < width)
    assert min(seen) >= width
    warnings = result.wucht.warnings
    assert any("failed: 'b1' and 'b2' of the track 'ring' overlap" in w for w in warnings)
    assert any(f"{(apart < width).sum() - 3} more runs failed" in w for w in warnings)


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
    assert abs(share_of(s) - 0.0396) < s["uncertainty"]["compensated"] + 0.002
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
    assert share_of(s) == pytest.approx(share, abs=0.002)


@pytest.mark.slow
@pytest.mark.parametrize(("u", "share"), [(1.0, 0.045), (2.5, 0.255)])
def test_shares_in_the_full_equations(u: float, share: float) -> None:
    """On 32 x 32 cells; the last digit printed, half a cell at the border of two dozen cells."""
    grid = {"study.axes.psi": [0.0, 2 * math.pi, 32], "study.axes.delta": [0.0, math.pi, 32], "study.model": "full"}
    study = read_study("drozdetskaya-2020/figure-5.10", grid | {"u": u})
    assert share_of(ask(study.spec, study.subject).wucht.summary) == pytest.approx(share, abs=0.002)


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
