"""The tables of a result as DataFrames: each of its own size, with units, and the size of all together is their sum."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pandas as pd
import xarray as xr
from tests.refusals import refused

from wucht.extending_0_1 import result_dataset
from wucht.results.quantities import Quantity, table

ORBITS = [
    {"drive.slope": 0.02, "period": 3.0, "stable": True, "kind": None, "exponents": [[-1.0, 0.5], [-2.0, 0.0]]},
    {"drive.slope": 0.03, "period": None, "stable": False, "kind": "fold", "exponents": [[-1.5, 0.0]]},
]
PARTS = {
    "drive.slope": ("slope", "N m s"), "period": ("period", "s"), "stable": ("stable", ""), "kind": ("kind", ""),
    "exponents": ("exponents", "1/s"),
}  # fmt: skip
LONG = 1000


def branched(study: str = "orbit-branch") -> xr.Dataset:
    """A result whose dimensions do not belong together: all combinations of their values would be 10^13 rows."""
    quantities = [
        Quantity("speed", np.arange(2.0 * LONG).reshape(2, LONG), "speed", "rad/s", "body point"),
        Quantity("body", ["drum", "ball"], "body", "", "body"),
        Quantity("branch", np.repeat([0, 1], LONG // 2), "branch", "", "point", coordinate=True),
        Quantity("steady_value", np.arange(float(LONG)), "slope", "N m s", "steady"),
        Quantity("orbit_time", np.arange(4.0 * LONG).reshape(LONG, 4), "time", "s", "orbit place", coordinate=True),
        Quantity("end_value", np.arange(float(LONG)), "slope", "N m s", "end"),
        Quantity("free_speed", 200.0, "no-load speed", "rad/s", "", in_summary=True),
        Quantity("runs", 3.0, "number of runs", "", ""),
        Quantity("final_phases", {"ball": 1.5}, "phases at the end", "rad"),
        Quantity("range", [0.02, 0.03], "range of the slope", "N m s"),
        Quantity("advice", None, "advice"),
        *table("orbits", ORBITS, "orbits", PARTS),
        *table("ends", [], "ends", {"kind": ("kind of the end", ""), "period": ("period", "s")}),
        *table("point", [{"x": 1}], "points named as a dimension is", {"x": ("x", "m")}),
    ]
    return result_dataset(quantities, "two orbits").assign_attrs(study=study, title="A title", dimensionless=0, finished=1)


def test_variables_over_one_dimension_are_a_table_with_units() -> None:
    points = branched().wucht.table("point")
    assert list(points.columns) == ["branch", "speed drum [rad/s]", "speed ball [rad/s]"]
    assert points["speed ball [rad/s]"].tolist() == np.arange(LONG, 2.0 * LONG).tolist()
    assert points.attrs["units"] == {"branch": "", "speed drum [rad/s]": "rad/s", "speed ball [rad/s]": "rad/s"}
    assert branched().wucht.branches.equals(points)


def test_a_list_of_the_summary_is_a_table_with_a_column_for_each_number() -> None:
    orbits = branched().wucht.table("orbits")
    assert list(orbits.columns) == [
        "drive.slope [N m s]", "period [s]", "stable", "kind", "exponents[0][0] [1/s]", "exponents[0][1] [1/s]",
        "exponents[1][0] [1/s]", "exponents[1][1] [1/s]",
    ]  # fmt: skip
    assert orbits["drive.slope [N m s]"].tolist() == [0.02, 0.03]
    assert orbits["stable"].dtype == bool
    assert orbits["kind"].tolist()[1] == "fold"
    assert orbits.isna().to_numpy().tolist() == [[False] * 3 + [True] + [False] * 4, [False, True] + [False] * 4 + [True] * 2]
    assert list(branched().wucht.table("ends").columns) == ["kind", "period [s]"]
    assert len(branched().wucht.table("ends")) == 0


def test_the_summary_has_every_key_with_unit_and_words() -> None:
    numbers = branched().wucht.summary_table
    assert set(branched().wucht.summary) <= {name.partition(".")[0].partition("[")[0] for name in numbers.index}
    assert numbers.index.is_unique
    rows = {name: tuple(numbers.loc[name]) for name in numbers.index}
    assert rows["sentence"] == ("two orbits", "", "verdict")
    assert rows["free_speed"] == (200.0, "rad/s", "no-load speed")
    assert rows["runs"] == (3.0, "", "number of runs")
    assert rows["final_phases.ball"] == (1.5, "rad", "phases at the end")
    assert rows["range[1]"] == (0.03, "N m s", "range of the slope")
    assert rows["advice"] == (None, "", "advice")
    assert rows["orbits"] == (2, "", "orbits: number of rows of the table orbits")
    assert rows["point"][0::2] == (1, "points named as a dimension is: number of rows of the table point-summary")


def test_all_together_are_the_sum_of_the_tables() -> None:
    """Combining every value of each dimension with all others, as Dataset.to_dataframe does, would ask for terabytes."""
    result = branched()
    frame = result.wucht.to_dataframe()
    lengths = {name: len(result.wucht.table(name)) for name in result.wucht.tables}
    assert len(frame) == sum(lengths.values()) < 8 * LONG
    assert np.prod([float(n) for n in result.sizes.values()]) > 1e12
    assert {name: len(frame.loc[[name]]) for name, length in lengths.items() if length} == {
        n: k for n, k in lengths.items() if k
    }
    assert frame.loc["steady"]["steady_value [N m s]"].tolist() == result.steady_value.values.tolist()
    assert frame.attrs["units"]["steady_value [N m s]"] == "N m s"


def test_unknown_tables_are_refused_with_the_known_ones() -> None:
    with refused("table", "orbits", "orbit-place", "numbers", given="orbit"):
        branched().wucht.table("orbit")
    with refused("branches", "run-up", "orbits"):
        _ = branched("run-up").drop_vars("branch").wucht.branches


def test_tables_of_a_result_that_was_read(tmp_path: Path) -> None:
    """Without the facts about its summary, as results of earlier versions are, it has the same numbers."""
    branched().to_netcdf(tmp_path / "result.nc", engine="h5netcdf")
    stored = xr.load_dataset(tmp_path / "result.nc", engine="h5netcdf")
    for name in stored.wucht.tables:
        pd.testing.assert_frame_equal(stored.wucht.table(name), branched().wucht.table(name))
    del stored.attrs["quantities"]
    earlier = xr.Dataset(stored.data_vars, stored.coords, stored.attrs)
    assert earlier.wucht.table("orbits")["drive.slope"].tolist() == [0.02, 0.03]
    assert earlier.wucht.summary_table.loc["ends", "value"] is None
