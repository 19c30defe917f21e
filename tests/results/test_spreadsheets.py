"""Tables of a result as CSV and XLSX, read back by pandas, by openpyxl and by LibreOffice."""

from __future__ import annotations

import csv
import re
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Any

import numpy as np
import openpyxl
import pandas as pd
import pytest
import xarray as xr
from tests.hand_made import variable
from tests.refusals import refused

from wucht.extending_0_1 import result_dataset
from wucht.results.quantities import Quantity, table
from wucht.results.spreadsheets import save_csv, save_xlsx

SUMMARY = [
    Quantity("outcome", "captured", "outcome"),
    Quantity("final_phases", {"p, 1": 1.5}, "phases at the end", "rad"),
    Quantity("formula", "=HYPERLINK(1)", "a formula"),
    Quantity("advice", None, "advice"),
    *table("jumps", [{"from_speed": 1e-300, "fold": True}, {"from_speed": None, "fold": False}], "jumps",
           {"from_speed": ("speed before", "rad/s"), "fold": ("a fold", "")}),
]  # fmt: skip
SPEED = np.array([[0.1, 1 / 3], [np.nan, 1e-300]])


def made(data: dict[str, Any] | None = None, coordinates: dict[str, Any] | None = None, study: str = "run-up") -> xr.Dataset:
    base = xr.Dataset(
        data or {"speed": variable("body time", SPEED, "speed", "rad/s"),
                 "power": variable("time", [1.0, -np.inf], "power", "W"),
                 "word": variable("time", ["-1+2", "a;b, \"c\""], "word")},
        coordinates or {"time": variable("time", [0.0, -0.5], "time", "s"), "body": variable("body", ["drum", "p, 1"], "body")},
    )  # fmt: skip
    return base.assign_attrs(result_dataset(SUMMARY, "it is captured").attrs, study=study)


def rows(path: Path, **options: Any) -> list[list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file, **options))


def test_each_file_runs_over_one_thing(tmp_path: Path) -> None:
    data = {
        "speed": variable("body time", SPEED, "speed", "rad/s"),
        "phase": variable("body time", [[np.nan, np.nan], [0.0, 1.0]], "phase", "rad"),
        "power": variable("time", [1.0, -np.inf], "power", "W"),
        "outcome": variable("y x", np.array([["a", "b", "c"]]), "outcome"),
        "mass": variable("body", [9.0, 0.125], "mass", "kg"),
        "state": variable("state x", [[1, 2, 3]], "state"),
        "free": variable("", 200.0, "no-load speed", "rad/s"),
    }
    coordinates = {
        "time": variable("time", [0.0, 0.5], "time", "s"),
        "body": variable("body", ["drum", "p, 1"], "body"),
        "x": variable("x", [1.0, 2.0, 3.0], "slope", "N m s"),
        "kind": variable("body", ["rotor", "ball"], "kind"),
    }
    written = save_csv(made(data, coordinates), tmp_path)
    names = ["time", "y-x", "body", "state-x", "jumps", "numbers"]
    assert [path.name for path in written] == [f"run-up-{name}.csv" for name in names]
    over_time, over_both, by_body, states, jumps, numbers = map(rows, written)
    assert over_time[0] == ["time [s]", "speed drum [rad/s]", "speed p, 1 [rad/s]", "phase p, 1 [rad]", "power [W]"]
    assert over_time[1:] == [["0.0", "0.1", "", "0.0", "1.0"], ["0.5", repr(1 / 3), "1e-300", "1.0", "-inf"]]
    assert over_both == [["y", "x [N m s]", "outcome"], ["0", "1.0", "a"], ["0", "2.0", "b"], ["0", "3.0", "c"]]
    assert by_body == [["body", "kind", "mass [kg]"], ["drum", "rotor", "9.0"], ["p, 1", "ball", "0.125"]]
    assert states == [["state index", "x [N m s]", "state"], ["0", "1.0", "1"], ["0", "2.0", "2"], ["0", "3.0", "3"]]
    assert jumps == [["from_speed [rad/s]", "fold"], ["1e-300", "1"], ["", "0"]]
    assert numbers == [
        ["name", "value", "unit", "description"],
        ["sentence", "it is captured", "", "verdict"],
        ["outcome", "captured", "", "outcome"],
        ["final_phases.p, 1", "1.5", "rad", "phases at the end"],
        ["formula", "'=HYPERLINK(1)", "", "a formula"],
        ["advice", "", "", "advice"],
        ["jumps", "2", "", "jumps: number of rows of the table jumps"],
        ["free", "200.0", "rad/s", "no-load speed"],
    ]


@pytest.mark.parametrize(("decimal_comma", "options"), [(False, {}), (True, {"sep": ";", "decimal": ","})])
def test_pandas_reads_every_table_as_it_is(tmp_path: Path, decimal_comma: bool, options: dict[str, str]) -> None:
    """To the last bit, the same from both: but for the cells that begin like a formula."""
    for path in save_csv(made(), tmp_path, decimal_comma):
        stored = pd.read_csv(path, keep_default_na=False, na_values=[""], **options)
        expected = made().wucht.table(path.stem.removeprefix("run-up-"))
        assert stored.columns.tolist() == expected.columns.tolist()
        if path.stem.endswith("numbers"):
            texts = dict(zip(stored["name"], stored["value"], strict=True))
            assert texts["final_phases.p, 1"] == ("1,5" if decimal_comma else "1.5")
            continue
        if "word" in stored:
            assert stored.pop("word").tolist() == ["'-1+2", 'a;b, "c"']
            expected = expected.drop(columns="word")
        expected = expected.astype({name: int for name in expected if expected[name].dtype == bool})
        pd.testing.assert_frame_equal(stored, expected, check_exact=True)


def test_no_cell_of_a_workbook_is_a_formula(tmp_path: Path) -> None:
    result = made(coordinates={"body": variable("body", ["=1+1", "+2\x07"], "body"), "time": variable("time", [0.0, 1.0], "t")})
    result.attrs["study"] = "../x"
    path = save_xlsx(result, tmp_path, everything=True)
    assert path.parent == tmp_path
    cells = [cell for sheet in openpyxl.load_workbook(path) for line in sheet.iter_rows() for cell in line]
    assert {cell.data_type for cell in cells} <= {"inlineStr", "s", "n"}
    texts = {cell.value for cell in cells if isinstance(cell.value, str)}
    assert {"'=HYPERLINK(1)", "'-1+2", "-inf", "speed +2? [rad/s]"} <= texts
    assert not {text for text in texts if text.startswith(("=", "+", "@"))}


def test_a_table_larger_than_a_sheet_is_refused(tmp_path: Path) -> None:
    time = np.arange(1_048_576.0)
    result = made({"speed": variable("time", time, "speed", "rad/s")}, {"time": variable("time", time, "time", "s")})
    with refused("--xlsx", "1048576 rows", "--csv", code="too-large"):
        save_xlsx(result, tmp_path, everything=True)
    assert list(tmp_path.iterdir()) == []


COURSE = {"time": variable("time", np.linspace(0.0, 10.0, 5001), "time", "s"), "body": variable("body", ["e1", "e2"], "body"),
          "direction": variable("direction", ["x", "r"], "direction")}  # fmt: skip


def course() -> xr.Dataset:
    """A run with 5001 samples: a speed that rises to 100 rad/s, a phase that turns on through 360 degrees, a vibration."""
    time = COURSE["time"][1]
    vibration = 2e-3 * np.sin(2 * np.pi * 50 * time)
    data = {
        "speed": variable("body time", [10 * time, -10 * time], "speed", "rad/s"),
        "phase": variable("body time", [np.full_like(time, np.nan), np.mod(6.2 + 0.01 * time, 2 * np.pi)], "phase", "rad"),
        "displacement": variable("direction time", [vibration, vibration], "displacement of the carrier (r: rad)", "m"),
        "torque": variable("time", np.where(time < 5, np.nan, 1500.0), "torque", "N m"),
    }
    return made(data, COURSE)


def sheets_of(path: Path) -> dict[str, list[tuple[Any, ...]]]:
    return {sheet.title: list(sheet.iter_rows(values_only=True)) for sheet in openpyxl.load_workbook(path)}


def test_the_course_over_time_has_means_and_limits_on_few_rows_in_the_units_of_the_trade(tmp_path: Path) -> None:
    sheets = sheets_of(save_xlsx(course(), tmp_path))
    assert list(sheets) == ["answers", "over time", "jumps", "numbers"]
    head, *rows = sheets["over time"]
    assert len(rows) == 500
    columns = {name: np.array([row[k] for row in rows], float) for k, name in enumerate(head)}
    time = columns["time, mean [s]"]
    np.testing.assert_allclose(columns["speed e1, mean [rpm]"], 10 * time * 30 / np.pi, rtol=1e-12)
    np.testing.assert_allclose(np.diff(time)[1:-1], 0.02, atol=1e-3)
    # one period of the vibration in each interval: amplitude 2 mm about zero, and of the turning 0.002 rad
    assert np.abs(columns["displacement x, mean [mm]"][1:-1]).max() < 0.05
    np.testing.assert_allclose(columns["displacement x, largest [mm]"], 2.0, rtol=0.06)
    np.testing.assert_allclose(columns["displacement x, least [mm]"], -2.0, rtol=0.06)
    np.testing.assert_allclose(columns["displacement r, largest [deg]"], np.degrees(2e-3), rtol=0.06)
    phases = np.degrees(6.2 + 0.01 * time) % 360
    np.testing.assert_allclose(columns["phase e2, mean [deg]"], phases, atol=1e-6)
    assert phases.max() > 355 and phases.min() < 5
    assert (columns["phase e2, largest [deg]"] - columns["phase e2, least [deg]"]).max() < 0.02, "no jump by a turn"
    torque = columns["torque, mean [kN m]"]
    assert np.isnan(torque[time < 4.97]).all()
    np.testing.assert_allclose(torque[time > 5.03], 1.5)


def test_a_mean_is_weighted_with_the_time_for_which_a_sample_stands(tmp_path: Path) -> None:
    """A torque of 1 kN m for the first hundredth of each second, sampled a hundred times as densely."""
    time = np.concatenate([np.r_[k + np.linspace(0, 0.0099, 100), k + np.linspace(0.01, 0.99, 99)] for k in range(500)])
    torque = np.where(time % 1 < 0.00995, 1000.0, 0.0)
    result = made({"torque": variable("time", torque, "torque", "N m")}, {"time": variable("time", time, "time", "s")})
    head, *rows = sheets_of(save_xlsx(result, tmp_path))["over time"]
    assert head[1:] == ("torque, mean [kN m]", "torque, least [kN m]", "torque, largest [kN m]")
    means = np.array([row[1] for row in rows])
    np.testing.assert_allclose(means[1:-1], 0.01, rtol=0.6)
    assert torque.mean() > 500


def test_few_samples_are_written_as_they_are(tmp_path: Path) -> None:
    time = np.linspace(0.0, 1.0, 500)
    result = made({"speed": variable("time", 10 * time, "speed", "rad/s")}, {"time": variable("time", time, "time", "s")})
    head, *rows = sheets_of(save_xlsx(result, tmp_path))["over time"]
    assert head == ("time [s]", "speed [rpm]")
    assert len(rows) == 500
    assert rows[-1][1] == pytest.approx(10 * 30 / np.pi)
    time = np.linspace(0.0, 1.0, 501)
    result = made({"speed": variable("time", 10 * time, "speed", "rad/s")}, {"time": variable("time", time, "time", "s")})
    head, *rows = sheets_of(save_xlsx(result, tmp_path))["over time"]
    assert (len(head), len(rows)) == (4, 500)


def test_all_samples_only_where_they_are_asked_for(tmp_path: Path) -> None:
    assert "all samples" not in sheets_of(save_xlsx(course(), tmp_path))
    sheets = sheets_of(save_xlsx(course(), tmp_path, everything=True))
    assert list(sheets)[-1] == "all samples"
    assert len(sheets["all samples"]) == 5002
    assert sheets["all samples"][-1][:2] == (10.0, 100.0), "in SI, as in the CSV files"


def test_answers_have_names_and_units_as_they_are_printed(tmp_path: Path) -> None:
    numbers = [
        Quantity("speed", 155.88, "mean speed", "rad/s"), Quantity("stroke", 8.8035e-3, "peak to peak", "m"),
        Quantity("phases", {"e2": -1.556}, "mean phases", "rad"), Quantity("direction", -0.1, "direction from +x", "rad"),
        Quantity("force", 109300.0, "largest force", "N"), Quantity("steady", True, "whether it is steady"),
        Quantity("nothing", None, "what is missing", "m"),
    ]  # fmt: skip
    result = made().assign_attrs(result_dataset(numbers, "it turns").attrs, study="run-up")
    head, *rows = sheets_of(save_xlsx(result, tmp_path))["answers"]
    assert head == ("name", "value", "unit", "key")
    assert rows == [
        ("verdict", "it turns", None, "sentence"), ("mean speed", 1488.54, "rpm", "speed"),
        ("peak to peak", 8.8035, "mm", "stroke"), ("mean phases: e2", 270.848, "deg", "phases.e2"),
        ("direction from +x", -5.72958, "deg", "direction"), ("largest force", 109.3, "kN", "force"),
        ("whether it is steady", 1, None, "steady"),
    ]  # fmt: skip
    dimensionless = result.assign_attrs(dimensionless=1)
    assert sheets_of(save_xlsx(dimensionless, tmp_path))["over time"][0][:2] == ("time [s]", "speed drum [rad/s]")


OFFICE = shutil.which("soffice")
GERMAN, ENGLISH = 1031, 1033  # languages of LibreOffice


@pytest.mark.slow
@pytest.mark.skipif(OFFICE is None, reason="LibreOffice (soffice) is not installed")
@pytest.mark.parametrize("form", ["xlsx", "point", "comma"])
def test_libreoffice_reads_numbers_as_numbers(tmp_path: Path, form: str) -> None:
    """In a language with the same decimal sign; what it reads is written as XLSX and read by openpyxl."""
    result, separator, language = made(), *((";", GERMAN) if form == "comma" else (",", ENGLISH))
    files = [save_xlsx(result, tmp_path, everything=True)] if form == "xlsx" else save_csv(result, tmp_path, form == "comma")
    options = [f"--infilter=CSV:{ord(separator)},34,76,1,,{language},false,true"] if form != "xlsx" else []
    command = [str(OFFICE), "--headless", f"-env:UserInstallation={(tmp_path / 'profile').as_uri()}", *options]
    subprocess.run(
        [*command, "--convert-to", "xlsx", "--outdir", str(tmp_path / "read"), *map(str, files)], check=True, timeout=300,
        capture_output=True,
    )  # fmt: skip
    books = [openpyxl.load_workbook(path) for path in sorted((tmp_path / "read").iterdir())]
    sheets = {sheet.title.removeprefix("run-up-"): list(sheet.iter_rows(values_only=True)) for book in books for sheet in book}
    if form == "xlsx":
        sheets["time"] = sheets.pop("all samples")
        assert sheets.pop("answers")[3] == ("phases at the end: p, 1", pytest.approx(85.9437), "deg", "final_phases.p, 1")
        assert sheets.pop("over time")[0][:2] == ("time [s]", "speed drum [rpm]")
    assert set(sheets) == {"numbers", "time", "jumps"}
    assert sheets["time"][0] == ("time [s]", "speed drum [rad/s]", "speed p, 1 [rad/s]", "power [W]", "word")
    assert sheets["time"][1] == (0, 0.1, None, 1, "'-1+2")
    assert sheets["time"][2][:3] == pytest.approx((-0.5, 1 / 3, 1e-300), rel=1e-14)
    assert sheets["time"][2][4] == 'a;b, "c"'
    assert [line[1] for line in sheets["jumps"]] == ["fold", 1, 0]
    numbers = {line[0]: line[1:3] for line in sheets["numbers"]}
    assert numbers["final_phases.p, 1"] == (1.5, "rad")
    assert numbers["outcome"][0] == "captured"
    assert numbers["formula"][0] == "'=HYPERLINK(1)"


BLANKS = ["", " ", "\n", "\r\n", *"\t\x0b\x0c\x1f\x7f\x85\u00a0\u2028\u3000\u200b\ufeff\u202e"]


@pytest.mark.parametrize("decimal_comma", [False, True])
def test_no_cell_of_text_begins_like_a_formula(tmp_path: Path, decimal_comma: bool) -> None:
    """Also where white space comes first, which a spreadsheet removes; numbers that are texts stay numbers."""
    formulas = [f"{blank}{sign}cmd|' /C calc'!A0" for blank in BLANKS for sign in "=+-@\uff1d\uff0b\uff0d\uff20"]
    formulas += ["\nx", "\tx", "\rx", "-", "--1", "- 1", "+A1", "-1+2"]
    others = ["-1.5", " -1.5", "+2", "-1e-300", "-inf", "", "x=1", "a-b", "\u2212 5", "*", "'=1", '"=1"', "(=1)", "\x01"]
    words = [*formulas, *others]
    times = variable("time", np.arange(float(len(words))), "time", "s")
    path, *_ = save_csv(made({"word": variable("time", words, "word")}, {"time": times}), tmp_path, decimal_comma)
    cells = [row[1] for row in rows(path, delimiter=";" if decimal_comma else ",")][1:]
    assert cells == [*("'" + re.sub(r"\r\n?", "\n", word) for word in formulas), *others]


def test_a_carriage_return_ends_no_row(tmp_path: Path) -> None:
    """Of the writer of Python's csv it would, as it is no part of its line ends: the next row would begin like a formula."""
    times = variable("time", [0.0, 1.0], "time", "s")
    path, *_ = save_csv(made({"word": variable("time", ["a\r=1+1", "b\r\n=2"], "word")}, {"time": times}), tmp_path)
    assert rows(path)[1:] == [["0.0", "a\n=1+1"], ["1.0", "b\n=2"]]


def test_without_openpyxl_the_extra_is_named(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "openpyxl", None)
    with refused("--xlsx", "wucht[xlsx]", code="extra"):
        save_xlsx(made(), tmp_path)
