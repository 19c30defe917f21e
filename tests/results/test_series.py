"""A result as CSV files: which columns stand in which file, with which units, and that nothing is lost."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import xarray as xr
from tests.hand_made import variable

from wucht.results.series import save_csv


def rows(path: Path) -> list[list[str]]:
    with path.open(newline="", encoding="utf-8") as file:
        return list(csv.reader(file))


def test_each_file_runs_over_one_thing(tmp_path: Path) -> None:
    speed = np.array([[0.1, 1 / 3], [np.nan, 1e-300]])
    data = {
        "speed": variable("body time", speed, "speed", "rad/s"),
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
    result = xr.Dataset(data, coordinates, {"study": "run-up"})
    written = save_csv(result, tmp_path)
    names = ["run-up-time.csv", "run-up-y-x.csv", "run-up-body.csv", "run-up-state-x.csv", "run-up-numbers.csv"]
    assert [path.name for path in written] == names
    over_time, over_both, by_body, states, numbers = map(rows, written)
    assert over_time[0] == ["time [s]", "speed drum [rad/s]", "speed p, 1 [rad/s]", "phase p, 1 [rad]", "power [W]"]
    assert over_time[1:] == [["0.0", "0.1", "", "0.0", "1.0"], ["0.5", repr(1 / 3), "1e-300", "1.0", "-inf"]]
    assert over_both == [["y", "x [N m s]", "outcome"], ["0", "1.0", "a"], ["0", "2.0", "b"], ["0", "3.0", "c"]]
    assert by_body == [["body", "mass [kg]", "kind"], ["drum", "9.0", "rotor"], ["p, 1", "0.125", "ball"]]
    assert states == [["state index", "x [N m s]", "state"], ["0", "1.0", "1"], ["0", "2.0", "2"], ["0", "3.0", "3"]]
    assert numbers == [["name", "value", "unit"], ["free", "200.0", "rad/s"]]
