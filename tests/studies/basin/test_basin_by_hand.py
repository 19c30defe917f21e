"""Maps of basins that are made by hand: each cell's numbers, finer cells, shares, sentences, and where the figure has them."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import drawn, titled, warnings_of

from known_basins import MACHINE
from wucht.dynamics.sampling.ensembles import MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES
from wucht.dynamics.work import Work
from wucht.files.building import machine_from
from wucht.files.catalogue import load_machine
from wucht.studies.basin import computation
from wucht.studies.basin.computation import Findings, Level, Plan, TileOutcomes, prepare
from wucht.studies.basin.dataset import dataset
from wucht.studies.basin.figure import _LOOKS
from wucht.studies.basin.spec import Basin

NUMBER = {str(o): k for k, o in enumerate(OUTCOMES)}


@pytest.fixture(scope="module")
def plan() -> Plan:
    """Three cells over psi, two over delta."""
    asked = {"psi": [0.0, 2 * math.pi, 3], "delta": [-1.0, 1.0, 2]}
    return prepare(Basin(axes=asked, model="slow", refine=1, until=900.0), MACHINE)


def members(names: list[str], first: float, failures: tuple[tuple[int, str], ...] = ()) -> MemberOutcomes:
    """Settling times, peaks and ends are unlike, and count on from a number."""
    at = first + np.arange(len(names))
    return MemberOutcomes(np.array([NUMBER[n] for n in names], np.int8), 10 + at, 1e-3 * at, 500 + at, failures)


def coarse(*tiles: TileOutcomes) -> Level:
    return Level(0, (2, 3), None, np.arange(6), tiles)


FIRST = ["captured", "compensated", "passed", "compensated", "compensated", "unidentified"]


@pytest.fixture(scope="module")
def base() -> Level:
    """In two tiles, the second cells first."""
    return coarse(
        TileOutcomes(np.array([3, 4, 5]), members(FIRST[3:], 3.0)), TileOutcomes(np.array([0, 1, 2]), members(FIRST[:3], 0.0))
    )


def finer(base: Level, cells: list[int], names: list[str], requested: list[int] | None = None, **other: Any) -> Level:
    tile = TileOutcomes(np.array(cells), members(names, 20.0, **other))
    return Level(1, (4, 6), base, np.array(cells if requested is None else requested), (tile,))


# --- cells ---


def test_each_cell_has_the_numbers_of_its_run(plan: Plan, base: Level) -> None:
    result = titled(dataset(replace(plan, spec=plan.spec.model_copy(update={"refine": 0})), Findings(base)))
    grid = np.arange(6.0).reshape(2, 3)
    assert result.outcome.dims == ("delta", "psi")
    assert result.outcome.values.ravel().tolist() == [NUMBER[n] for n in FIRST]
    assert result.settling_time.values == pytest.approx(10 + grid) and result.peak_amplitude.values == pytest.approx(
        1e-3 * grid
    )
    assert result.end_time.values == pytest.approx(500 + grid)
    assert result.psi.values == pytest.approx([math.pi / 3, math.pi, 5 * math.pi / 3])
    assert result.delta.values == pytest.approx([-0.5, 0.5])
    flags = dict(zip(result.outcome.flag_values.tolist(), result.outcome.flag_meanings.split(), strict=True))
    assert flags[-1] == "not-computed" and {flags[k] for k in result.outcome.values.ravel()} == set(FIRST)
    names = ("x_axis", "x_low", "x_high", "x_is_angle", "y_axis", "y_low", "y_high", "y_is_angle")
    assert [result.attrs[n] for n in names] == ["psi", 0.0, pytest.approx(2 * math.pi), 1, "delta", -1.0, 1.0, 1]
    s = result.wucht.summary
    assert s["fractions"] == {name: pytest.approx(FIRST.count(name) / 6) for name in set(FIRST)}
    assert (s["runs"], s["runs_of_dense_map"], s["missing"], s["failures"], s["until"]) == (6, 6, 0.0, 0, 900.0)
    assert s["axes"]["psi"] == {"range": [0.0, pytest.approx(2 * math.pi)], "cells": 3, "unit": "", "periodic": True}
    assert s["axes"]["delta"] == {"range": [-1.0, 1.0], "cells": 2, "unit": "", "periodic": False}
    assert s["followed"]["compensated"] == [501.0, 504.0] and s["followed"]["captured"] == [500.0, 500.0]
    assert result.attrs["sentence"].startswith("compensated 50")
    assert result.peak_amplitude.attrs["long_name"] == "peak amplitude, without ripple"


def test_an_amplitude_of_the_full_equations_has_its_ripple(base: Level) -> None:
    full = prepare(Basin(axes={"p1": [0.0, 1.0, 3], "p2": [0.0, 1.0, 2]}), load_machine("drozdetskaya-2020/r1"))
    result = dataset(full, Findings(base))
    assert result.peak_amplitude.attrs == {"long_name": "peak amplitude", "units": "m"}
    assert result.settling_time.attrs["units"] == result.end_time.attrs["units"] == "s"
    assert (result.wucht.summary["time_unit"], result.wucht.summary["amplitude_unit"]) == ("s", "m")


def test_finer_cells_inherit_what_is_not_run(plan: Plan, base: Level) -> None:
    """Of the fine map 4 x 6 only the cells 7 and 16 are run; the others have what the coarse cell has."""
    result = titled(dataset(plan, Findings(finer(base, [7, 16], ["passed", "captured"]))))
    expected = np.kron(np.arange(6.0).reshape(2, 3), np.ones((2, 2))).ravel()
    expected[[7, 16]] = [20.0, 21.0]
    assert result.refined_settling_time.values.ravel() == pytest.approx(10 + expected)
    assert result.refined_peak_amplitude.values.ravel() == pytest.approx(1e-3 * expected)
    assert result.refined_end_time.values.ravel() == pytest.approx(500 + expected)
    levels = np.zeros(24, int)
    levels[[7, 16]] = 1
    assert result.refined_level.values.ravel().tolist() == levels.tolist()
    kinds = np.kron(np.array([NUMBER[n] for n in FIRST]).reshape(2, 3), np.ones((2, 2), int)).ravel()
    kinds[[7, 16]] = NUMBER["passed"], NUMBER["captured"]
    assert result.refined_outcome.values.ravel().tolist() == kinds.tolist()
    assert result.refined_outcome.dims == ("refined_delta", "refined_psi") and result.outcome.shape == (2, 3)
    assert result.refined_psi.values == pytest.approx((np.arange(6) + 0.5) * math.pi / 3)
    assert result.refined_delta.values == pytest.approx([-0.75, -0.25, 0.25, 0.75])
    s = result.wucht.summary
    assert (s["runs"], s["runs_of_dense_map"]) == (8, 24) and [level["runs"] for level in s["levels"]] == [6, 2]
    assert [level["cells"] for level in s["levels"]] == [[3, 2], [6, 4]]
    assert s["levels"][0]["fractions"]["passed"] == pytest.approx(1 / 6)
    assert s["levels"][1]["fractions"]["passed"] == pytest.approx(5 / 24) == s["fractions"]["passed"]
    assert s["followed"]["compensated"] == [501.0, 504.0] and s["followed"]["passed"] == [502.0, 520.0]


def test_starts_are_at_the_centres_row_by_row(plan: Plan) -> None:
    assert plan.place(0) == pytest.approx((math.pi / 3, -0.5)) and plan.place(5) == pytest.approx((5 * math.pi / 3, 0.5))
    assert plan.place(3) == pytest.approx((math.pi / 3, 0.5)), "the second row"
    assert plan.place(7, 1) == pytest.approx((math.pi / 2, -0.25))
    assert plan.periodic == (False, True), "rows are those of delta" and plan.shape(1) == (4, 6)


def test_each_level_has_its_share_of_the_work() -> None:
    assert computation._shares(0) == [(0.0, 1.0)]
    assert computation._shares(2) == pytest.approx(np.array([(0.0, 0.4), (0.4, 0.6), (0.6, 1.0)]))


# --- words ---


def test_what_is_missing(plan: Plan, base: Level) -> None:
    part = replace(base, tiles=base.tiles[:1])
    result = titled(dataset(plan, Findings(part)))
    assert warnings_of(result)[0] == "3 of the 6 cells of the map are not computed; the shares are of all cells"
    assert result.attrs["sentence"].endswith(", 50 % not computed yet") and result.wucht.summary["missing"] == 0.5
    assert np.isnan(result.end_time.values[0]).all() and result.outcome.values[0].tolist() == [-1, -1, -1]
    assert dataset(plan, Findings(finer(base, [7], ["passed"], [7, 8]))).refined_level.values.ravel()[7:9].tolist() == [1, -1]
    coarser = warnings_of(dataset(plan, Findings(base)))
    assert coarser[0] == "the borders are refined 0 of 1 times"
    assert not any("refined" in w for w in warnings_of(dataset(plan, Findings(finer(base, [7], ["passed"])))))


def test_what_is_unidentified(plan: Plan, base: Level) -> None:
    """Of one cell of six; of two that ended at different times; without a time that could be longer."""
    told = [w for w in warnings_of(dataset(plan, Findings(base))) if "unidentified" in w]
    assert told == [
        "16.7 % of the map are unidentified, integrated until 505; a longer study.until may identify them",
    ]  # fmt: skip
    names = ["unidentified", "captured", "captured", "unidentified", "captured", "captured"]
    two = coarse(TileOutcomes(np.arange(6), members(names, 0.0)))
    free = replace(plan, spec=plan.spec.model_copy(update={"until": None}))
    told = [w for w in warnings_of(dataset(free, Findings(two))) if "unidentified" in w]
    assert told == ["33.3 % of the map are unidentified, integrated until 500 to 503"]


def test_which_runs_failed(plan: Plan, base: Level) -> None:
    """On both levels, named by their places; three of them, and how many more."""
    failures = ((0, "it burst"), (2, "it melted"))
    first = coarse(TileOutcomes(np.array([3, 4, 5, 0, 1, 2]), members(["failed"] * 6, 0.0, failures)))
    level = finer(first, [7, 16], ["failed", "failed"], failures=((1, "it froze"),))
    told = [w for w in warnings_of(dataset(plan, Findings(level))) if "failed" in w]
    assert told == [
        "the run at psi = 1.0472, delta = 0.5 failed: it burst", "the run at psi = 5.23599, delta = 0.5 failed: it melted",
        f"the run at psi = {4.5 * math.pi / 3:.6g}, delta = 0.25 failed: it froze",
    ]  # fmt: skip
    assert dataset(plan, Findings(level)).wucht.summary["failures"] == 3
    more = finer(first, [7, 16], ["failed", "failed"], failures=((0, "it froze"), (1, "it froze")))
    assert warnings_of(dataset(plan, Findings(more)))[-1] == "1 more runs failed"


# --- the figure ---


def test_cells_are_drawn_where_they_are(plan: Plan, base: Level) -> None:
    """Of the finer map, the smallest numbers at the lower left; what has not settled is left out."""
    level = finer(base, [7, 16], ["passed", "captured"])
    result: xr.Dataset = titled(dataset(plan, Findings(level)))
    result["refined_settling_time"].values[0, 0] = np.nan
    outcome, settling, peak = [a for a in drawn("basin", result).axes if a.images]
    for axis in (outcome, settling, peak):
        assert axis.images[0].get_extent() == pytest.approx([0.0, 2 * math.pi, -1.0, 1.0])
        assert axis.images[0].origin == "lower"
    kinds = result.refined_outcome.values
    present = sorted(set(kinds.ravel().tolist()))
    assert outcome.images[0].get_array().tolist() == [[present.index(k) for k in row] for row in kinds.tolist()]
    colours = [tuple(round(255 * c) for c in outcome.images[0].cmap(k)[:3]) for k in range(len(present))]
    assert colours == [tuple(int(_LOOKS[str(OUTCOMES[k])][0][i : i + 2], 16) for i in (1, 3, 5)) for k in present]
    assert np.ma.filled(settling.images[0].get_array(), -1.0)[0, :2].tolist() == [-1.0, 10.0]
    assert settling.images[0].get_clim() == (10.0, 31.0) and settling.get_title().endswith("(grey: not settled)")
    assert peak.images[0].get_clim() == pytest.approx((0.0, 0.021)) and "grey" not in peak.get_title()
    legend = [t.get_text().partition(":")[0] for t in outcome.get_legend().get_texts()]
    shares = result.wucht.summary["fractions"]
    assert set(legend) == set(shares) and [shares[n] for n in legend] == sorted(shares.values(), reverse=True)
    assert outcome.get_xlabel().endswith("mean phase of p1 and p2 at the start")
    assert outcome.get_ylabel().endswith(str(result.delta.attrs["long_name"]))


def test_cells_that_are_not_computed_are_named(plan: Plan, base: Level) -> None:
    result = titled(dataset(plan, Findings(replace(base, tiles=base.tiles[:1]))))
    outcome = next(a for a in drawn("basin", result).axes if a.images)
    names = [t.get_text() for t in outcome.get_legend().get_texts()]
    assert names[-1] == "not computed" and names[0].startswith("compensated: 33")
    assert outcome.images[0].get_array().tolist()[0] == [0, 0, 0]


def test_what_takes_long_is_stored_in_small_units() -> None:
    """Bodies that touch are each followed to the end: 272 runs are two units; the last step states the whole map."""
    ball = {
        "kind": "pendulum", "about": "drum", "mass": 0.05, "length": 0.1, "damping": 0.02, "track": "ring", "diameter": 0.01,
    }  # fmt: skip
    drum = {"kind": "rotor", "name": "drum", "mass": 2.0, "eccentricity": 1e-3, "inertia": 0.03}
    machine = machine_from(
        {
            "carrier": {"mass": 9.0, "stiffness": 1e5, "damping": 200.0},
            "bodies": [drum, ball | {"name": "a"}, ball | {"name": "b"}],
            "drive": {"on": "drum", "kind": "linear", "slope": 0.05, "no_load_speed": 60.0},
        }
    )
    plan = prepare(Basin(axes={"a": [0.0, 1.0, 16], "b": [2.0, 4.0, 17]}, until=0.1, refine=0), machine)
    found = list(computation.run(plan, Work()))
    assert len(found) == 3 and found[-1].last.is_complete
