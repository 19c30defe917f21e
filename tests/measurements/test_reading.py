"""Which file is read how."""

import importlib
import os

import pytest
from tests.refusals import refused

from wucht.measurements.reading import read_recording


@pytest.mark.parametrize("ending", ["csv", "TXT", "tsv", "asc"])
def test_text(tmp_path, ending):
    path = tmp_path / f"r.{ending}"
    path.write_text("0 1\n1 2\n")
    assert read_recording(path).channel("2").values.tolist() == [1, 2]


def test_an_unknown_ending(tmp_path):
    with refused("", code="unknown-ending", file="r.xlsx"):
        read_recording(tmp_path / "r.xlsx")


@pytest.mark.parametrize("ending", [".csv", ".wav", ".uff", ".tdms", ".mf4"])
def test_no_file(tmp_path, ending):
    with refused("", code="no-file", file=f"none{ending}"):
        read_recording(tmp_path / f"none{ending}")
    (tmp_path / f"folder{ending}").mkdir()
    with refused("", "folder", code="no-file", file=f"folder{ending}"):
        read_recording(tmp_path / f"folder{ending}")
    os.mkfifo(tmp_path / f"pipe{ending}")
    with refused("", "pipe", code="no-file", file=f"pipe{ending}"):
        read_recording(tmp_path / f"pipe{ending}")


def test_of_thousands_of_columns_some_are_named(tmp_path):
    path = tmp_path / "r.csv"
    names = [f"c{k}" for k in range(20_000)]
    path.write_text("\n".join(",".join(row) for row in (["time", *names], ["0"] * 20_001, ["1"] * 20_001)))
    with refused("r.csv", "19800", given="force") as caught:
        read_recording(path).channel("force")
    assert len(str(caught.value)) < 2500


@pytest.mark.parametrize(
    ("ending", "refusal"),
    [
        (".wav", refused("r.wav", code="unreadable")),
        (".tdms", refused("r.tdms", "TDMS", code="unreadable")),
        (".mf4", refused("r.mf4", "MDF", code="unreadable")),
    ],
)
def test_a_file_of_another_kind(tmp_path, ending, refusal):
    path = tmp_path / f"r{ending}"
    path.write_text("    -1\n    58\nthis is something else\n")
    with refusal:
        read_recording(path)


def test_a_universal_file_of_nothing(tmp_path):
    path = tmp_path / "r.uff"
    path.write_text("this is something else\n")
    with refused("r.uff", code="no-signal"):
        read_recording(path)
    path.write_text("    -1\n    58\nthis is something else\n    -1\n")
    with refused("r.uff", code="unreadable"):
        read_recording(path)


@pytest.mark.parametrize("ending", [".uff", ".tdms", ".mf4"])
def test_a_library_that_is_not_there(tmp_path, monkeypatch, ending):
    path = tmp_path / f"r{ending}"
    path.write_text("")

    def none(name):
        raise ImportError(name)

    monkeypatch.setattr(importlib, "import_module", none)
    with refused(f"r{ending}", "wucht[measure]", given=None):
        read_recording(path)
