"""One run at a time writes into a folder, and a run that was killed is no obstacle; what is the user's is never removed."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

from wucht.errors import InputError
from wucht.results.output_folder import CHECKSUMS, SUMMARY, checksum, claimed, note_figure, remove_earlier

CLAIM = """
import sys, time
from pathlib import Path
from wucht.results.output_folder import claimed
with claimed(Path(sys.argv[1])):
    print("claimed", flush=True)
    time.sleep(60)
"""


def test_a_folder_is_made_and_given_free_again(tmp_path: Path) -> None:
    folder = tmp_path / "a" / "b"
    with claimed(folder), claimed(folder):
        assert folder.is_dir()
        (folder / "result.nc").write_text("")
    assert [p.name for p in folder.iterdir()] == ["result.nc"]


def test_a_folder_that_stays_empty_is_not_left(tmp_path: Path) -> None:
    with pytest.raises(ZeroDivisionError), claimed(tmp_path / "a" / "b"):
        raise ZeroDivisionError
    assert list(tmp_path.iterdir()) == []
    with claimed(tmp_path):
        pass
    assert tmp_path.is_dir(), "it was there before"


def test_another_process_is_kept_out_until_it_is_killed(tmp_path: Path) -> None:
    other = subprocess.Popen([sys.executable, "-c", CLAIM, str(tmp_path)], stdout=subprocess.PIPE, text=True)
    try:
        assert other.stdout is not None
        assert other.stdout.readline() == "claimed\n"
        with pytest.raises(InputError, match="another run is writing a result there"), claimed(tmp_path):
            pytest.fail("two runs write into one folder")
    finally:
        other.kill()
        other.wait()
        if other.stdout is not None:
            other.stdout.close()
    assert list(tmp_path.iterdir()), "what it left behind"
    with claimed(tmp_path):
        pass
    assert list(tmp_path.iterdir()) == []


def test_only_what_is_noted_and_unchanged_is_removed(tmp_path: Path) -> None:
    figure, drawn_over, own = (tmp_path / name for name in ("run-up.png", "run-up.pdf", "basin.png"))
    for file in (figure, drawn_over, own):
        file.write_text(file.name)
    outside = tmp_path.parent / "outside.png"
    outside.write_text("outside")
    (tmp_path / SUMMARY).write_text(
        json.dumps({CHECKSUMS: {figure.name: checksum(figure), "../outside.png": checksum(outside)}})
    )
    note_figure(drawn_over)
    drawn_over.write_text("with an arrow")
    remove_earlier(tmp_path)
    assert sorted(p.name for p in tmp_path.iterdir()) == ["basin.png", "run-up.pdf"]
    assert outside.is_file()


@pytest.mark.parametrize("own", ["", "{", "[]", '{"checksums": 1}', '{"mine": true}'])
def test_a_summary_of_others_is_left_alone(tmp_path: Path, own: str) -> None:
    (tmp_path / SUMMARY).write_text(own)
    (tmp_path / "run-up.png").write_text("")
    note_figure(tmp_path / "run-up.png")
    remove_earlier(tmp_path)
    assert (tmp_path / SUMMARY).read_text() == own
    assert (tmp_path / "run-up.png").is_file()
