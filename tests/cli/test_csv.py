"""``--csv`` of every study, and ``wucht export --csv`` of what is stored."""

from __future__ import annotations

import csv
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import pytest

from wucht import load
from wucht.measurements.reading import read_recording
from wucht.studies.registry import studies

Command = Callable[..., Any]
Study = Callable[..., Path]
QUICK = ("cam-law", "torque-balance", "response")


def columns(path: Path) -> dict[str, list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        header, *lines = csv.reader(file)
    assert len(set(header)) == len(header)
    assert all(len(line) == len(header) for line in lines)
    return {name: [line[k] for line in lines] for k, name in enumerate(header)}


@pytest.mark.usefixtures("no_figures")
def test_the_files_stand_beside_the_result(wucht: Command, study: Study) -> None:
    import xarray as xr

    done = wucht("run", study('"0.5 s"', '"0.05 s"'), "-o", "out", "--csv", "--json").document
    assert [Path(f).name for f in done["files"][3:]] == ["run-up-time.csv", "run-up-numbers.csv"]
    table, stored = columns(Path("out/run-up-time.csv")), xr.load_dataset("out/result.nc", engine="h5netcdf")
    assert np.array_equal(np.array(table["speed p1 [rad/s]"], float), stored.speed.sel(body="p1").values)
    assert np.array_equal(np.array(table["time [s]"], float), stored.time.values)
    wucht("export", "out", "--csv", "-o", "again")
    assert {p.name: p.read_bytes() for p in Path("again").iterdir()} == {
        p.name: p.read_bytes() for p in Path("out").glob("*.csv")
    }
    read = read_recording(Path("out/run-up-time.csv")).channel("speed drum")
    assert np.array_equal(read.values, stored.speed.sel(body="drum").values)
    assert "phase drum [rad]" not in table, "the drum turns about no other body"
    numbers = columns(Path("out/run-up-numbers.csv"))
    values = dict(zip(numbers["name"], numbers["value"], strict=True))
    assert {name.partition(".")[0].partition("[")[0] for name in values} >= set(done["summary"])
    assert (values["outcome"], values["sentence"]) == (done["summary"]["outcome"], done["summary"]["sentence"])
    assert dict(zip(numbers["name"], numbers["unit"], strict=True))["final_speed"] == "rad/s"
    assert all(numbers["description"])


@pytest.mark.usefixtures("no_figures")
def test_exported_tables_go_with_their_result(wucht: Command, study: Study) -> None:
    """The next result beside them has other numbers; what is in another folder stays, and what was changed since."""
    question = study('"0.5 s"', '"0.05 s"')
    wucht("run", question, "-o", "out")
    wucht("export", "out", "--csv", "--xlsx")
    wucht("export", "out", "--csv", "-o", "kept")
    changed = Path("out/run-up-numbers.csv")
    changed.write_text("with notes of my own", encoding="utf-8")
    wucht("run", question, "-o", "out", "--set", "study.until=0.4")
    assert {path.name for path in Path("out").iterdir()} >= {"result.nc", "summary.json", changed.name}
    assert not {"run-up-time.csv", "run-up.xlsx"} & {path.name for path in Path("out").iterdir()}
    assert {path.name for path in Path("kept").iterdir()} == {"run-up-time.csv", "run-up-numbers.csv"}


@pytest.mark.usefixtures("no_figures")
def test_other_forms_of_a_result(wucht: Command, refused: Callable[..., str], study: Study) -> None:
    """A decimal comma in CSV, of a run and of its result; a workbook beside it, which pandas reads; with neither refused."""
    refused(
        "run",
        study('"0.5 s"', '"0.01 s"'),
        "--csv",
        "--decimal",
        "dot",
        "-o",
        "out",
        says=("--decimal", "dot", "'point', 'comma'"),
    )
    refused("run", study(), "--decimal", "comma", "-o", "out", says=("--decimal", "comma", "--csv"))
    assert (
        wucht("run", "study.toml", "-o", "out", "--csv", "--decimal", "comma", "--set", "study.until=0.01", "--json").code == 0
    )
    done = wucht("export", "out", "--csv", "--decimal", "comma", "--xlsx", "--all", "-o", "again")
    assert done.out.splitlines() == [f"again/run-up{end}" for end in ("-time.csv", "-numbers.csv", ".xlsx")]
    options = {"sep": ";", "decimal": ","}
    over_time = pd.read_csv("again/run-up-time.csv", **options)
    stored = load("out").wucht.table("time")
    pd.testing.assert_frame_equal(over_time, stored, check_exact=True)
    pd.testing.assert_frame_equal(pd.read_csv("out/run-up-time.csv", **options), stored, check_exact=True)
    samples = pd.read_excel("again/run-up.xlsx", sheet_name="all samples")
    pd.testing.assert_frame_equal(samples, stored, check_dtype=False, rtol=1e-15)
    assert wucht("export", "out", "--xlsx", "-o", "brief").code == 0
    assert pd.ExcelFile("brief/run-up.xlsx").sheet_names == ["answers", "over time", "numbers"]
    refused("export", "out", "--all", says=("--all", "--xlsx"))
    refused("export", "out", "--csv", "--all", says=("--all", "--xlsx"))
    refused("export", "out", says=("out/result.nc: run-up", "cannot be exported", "wucht export out --csv, or --xlsx"))
    refused("export", "out", "--xlsx", "--decimal", "comma", says=("--decimal", "comma", "--csv"))
    refused("compare", "study.toml", "study.toml", "--decimal", "comma", says=("--decimal", "comma", "--csv"))


@pytest.mark.usefixtures("no_figures")
@pytest.mark.parametrize(
    "kind", [pytest.param(k, marks=() if k in QUICK else pytest.mark.slow) for k in studies() if k != "compare"]
)
def test_every_study_has_them(wucht: Command, kind: str) -> None:
    import xarray as xr

    assert wucht("new", kind).code == 0
    done = wucht("run", f"{kind}.toml", "-o", "out", "--csv", "--json")
    assert done.code == 0, done.err
    tables = [columns(path) for path in Path("out").glob("*.csv")]
    stored = xr.load_dataset("out/result.nc", engine="h5netcdf")
    there = {name.split(" ")[0] for table in tables for name in table} | {n for t in tables for n in t.get("name", ())}
    assert {str(n) for n in stored.data_vars} <= there
