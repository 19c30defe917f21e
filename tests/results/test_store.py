"""Files that are replaced as a whole, by several processes too."""

from __future__ import annotations

import csv
import os
from pathlib import Path

import numpy as np
import xarray as xr
from tests.hand_made import variable
from tests.refusals import failed, refused

from wucht.results.store import prepare_folder, replace_file, save_csv


def test_two_at_once_do_not_mix(tmp_path: Path) -> None:
    """The second begins while the first is half way: each is whole in its turn."""
    file, seen = tmp_path / "a", list[str]()

    def slowly(beside: Path) -> None:
        beside.write_text("first, h")
        replace_file(file, lambda other: other.write_text("second"))
        seen.append(file.read_text())
        with beside.open("a") as rest:
            rest.write("alf and half")

    replace_file(file, slowly)
    assert seen == ["second"]
    assert file.read_text() == "first, half and half"
    assert list(tmp_path.iterdir()) == [file]


def test_what_cannot_be_written_leaves_what_was_there(tmp_path: Path) -> None:
    file = tmp_path / "a"
    replace_file(file, lambda beside: beside.write_text("whole"))

    def full(beside: Path) -> None:
        beside.write_text("ha")
        raise OSError(28, "No space left on device")

    with failed("not-written"):
        replace_file(file, full)
    assert file.read_text() == "whole"
    assert list(tmp_path.iterdir()) == [file]


def test_what_a_killed_process_left_is_removed_once_it_is_old(tmp_path: Path) -> None:
    old, fresh, others = (tmp_path / name for name in (".result.nc.0.part", ".result.nc.1.part", ".mine.0.part"))
    for file in (old, fresh, others):
        file.write_text("half")
    os.utime(old, (0, 0))
    os.utime(others, (0, 0))
    prepare_folder(tmp_path, ["result.nc"])
    assert sorted(tmp_path.iterdir()) == sorted([fresh, others])


def test_a_folder_in_the_place_of_a_file(tmp_path: Path) -> None:
    (tmp_path / "result.nc").mkdir()
    with refused("-o", "result.nc", code="folder"):
        prepare_folder(tmp_path, ["result.nc"])


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


def test_columns_of_two_dimensions_are_in_the_order_of_their_values(tmp_path: Path) -> None:
    force = np.arange(12.0).reshape(2, 2, 3)
    data = {"force": variable("time body way", force, "force", "N")}
    coordinates = {
        "time": variable("time", [0.0, 0.5], "time", "s"),
        "body": variable("body", ["a", "b"], "body"),
        "way": variable("way", ["x", "y", "z"], "direction"),
    }
    (path,) = save_csv(xr.Dataset(data, coordinates, {"study": "run-up"}), tmp_path)
    header, first, _ = rows(path)
    assert header == ["time [s]", *(f"force {body} {way} [N]" for body in "ab" for way in "xyz")]
    assert first == ["0.0", *map(str, force[0].ravel().tolist())]


def test_folders_that_cannot_be_made(tmp_path: Path) -> None:
    (tmp_path / "file").write_text("")
    with refused("-o", "nothing can be written there", given=str(tmp_path / "file" / "in")):
        prepare_folder(tmp_path / "file" / "in")
    with refused("-o", "this cannot be the name of a folder", given="a\0b"):
        prepare_folder(Path("a\0b"))
    (tmp_path / "out" / "result.nc").mkdir(parents=True)
    with refused("-o", "result.nc", given=str(tmp_path / "out"), code="folder"):
        prepare_folder(tmp_path / "out", ["result.nc"])
