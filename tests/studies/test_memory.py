"""Units of work that are kept: read back to the last bit, whatever was killed and whoever else writes there."""

from __future__ import annotations

import os
import random
import subprocess
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from tests.refusals import failed, refused, rejected

from wucht import InputError
from wucht.studies.memory import UnitMemory, stored_questions

QUESTION, OTHER = {"study": "x"}, {"study": "y"}


@dataclass(frozen=True)
class Unit:
    value: float
    numbers: np.ndarray


def unit(k: int, of: str = "x") -> Unit:
    return Unit(float(k), np.random.default_rng([k, ord(of)]).normal(size=20))


def kept(folder: Path, question: dict[str, Any], count: int) -> list[int]:
    """Which units a folder has of a question; they are the right ones."""
    memory = UnitMemory.resume(folder, question)
    numbers = [k for k in range(count) if memory.knows(f"u{k}")]
    for k in numbers:
        read, expected = memory.unit(f"u{k}", lambda: pytest.fail("it is known")), unit(k, question["study"])
        assert read.value == expected.value
        assert read.numbers.tobytes() == expected.numbers.tobytes()
    return numbers


def fill(folder: Path, numbers: range = range(3), question: dict[str, Any] = QUESTION) -> UnitMemory:
    memory = UnitMemory.start(folder, question)
    for k in numbers:
        memory.unit(f"u{k}", lambda k=k: unit(k, question["study"]))
        memory.flush()
    return memory


def test_in_which_order_a_question_has_its_keys_does_not_matter(tmp_path: Path) -> None:
    question = {"study": "x", "range": {"low": 1.0, "high": 2.0}, "points": 3}
    fill(tmp_path, question=question)
    turned = {"points": 3, "range": {"high": 2.0, "low": 1.0}, "study": "x"}
    assert kept(tmp_path, turned, 3) == [0, 1, 2]
    assert kept(tmp_path, turned | {"points": 4}, 3) == []


def test_what_was_flushed_survives_a_kill(tmp_path: Path) -> None:
    """What was cut off is computed again, whichever file it is."""
    fill(tmp_path)
    assert stored_questions(tmp_path) == [QUESTION]
    assert kept(tmp_path, QUESTION, 3) == [0, 1, 2]
    files = list((tmp_path / "units").iterdir())
    assert len(files) == 3
    files[0].write_bytes(files[0].read_bytes()[:-100])
    files[1].write_bytes(b"")
    left = kept(tmp_path, QUESTION, 3)
    assert len(left) == 1
    again, made = UnitMemory.resume(tmp_path, QUESTION), list[int]()
    for k in range(3):
        again.unit(f"u{k}", lambda k=k: made.append(k) or unit(k))
    assert sorted([*made, *left]) == [0, 1, 2]
    again.flush()
    assert kept(tmp_path, QUESTION, 3) == [0, 1, 2]


def test_another_question_is_begun_without_units_of_this_one(tmp_path: Path) -> None:
    fill(tmp_path)
    assert kept(tmp_path, OTHER, 3) == []
    fill(tmp_path, range(1), OTHER)
    assert stored_questions(tmp_path) == [OTHER]
    assert kept(tmp_path, QUESTION, 3) == []


def test_a_folder_of_the_user_that_has_its_name_keeps_its_files(tmp_path: Path) -> None:
    """``wucht run -o .`` beside a folder ``units`` of the user's: only units are removed, here those of the question before."""
    fill(tmp_path)
    own = tmp_path / "units" / "mine" / "list.txt"
    own.parent.mkdir()
    own.write_text("mm, kg", encoding="utf-8")
    fill(tmp_path, range(1), OTHER)
    assert stored_questions(tmp_path) == [OTHER]
    fill(tmp_path).forget()
    assert own.read_text(encoding="utf-8") == "mm, kg"
    assert [path.name for path in (tmp_path / "units").iterdir()] == ["mine"]


def test_a_file_in_the_place_of_the_units_is_kept(tmp_path: Path) -> None:
    (tmp_path / "units").write_text("mm, kg", encoding="utf-8")
    with pytest.raises(InputError, match="a file is in the place of the folder units"):
        UnitMemory.start(tmp_path, QUESTION)
    assert (tmp_path / "units").read_text(encoding="utf-8") == "mm, kg"


@pytest.mark.skipif(os.name != "posix", reason="links of POSIX")
def test_a_link_in_the_place_of_the_units_is_not_followed(tmp_path: Path) -> None:
    fill(tmp_path / "other")
    (tmp_path / "out").mkdir()
    (tmp_path / "out" / "units").symlink_to(tmp_path / "other" / "units")
    with refused("-o", "units", given=str(tmp_path / "out"), code="file"):
        UnitMemory.start(tmp_path / "out", OTHER)
    assert kept(tmp_path / "other", QUESTION, 3) == [0, 1, 2]


def test_what_is_forgotten_leaves_nothing(tmp_path: Path) -> None:
    fill(tmp_path).forget()
    assert list(tmp_path.iterdir()) == []
    UnitMemory(tmp_path, QUESTION).forget()


def test_what_a_killed_write_left_is_removed(tmp_path: Path) -> None:
    for remove in (lambda memory: memory.forget(), lambda _: UnitMemory.start(tmp_path, OTHER)):
        memory = fill(tmp_path)
        file = next((tmp_path / "units").iterdir())
        file.rename(file.with_name(f".{file.name}.0123.part"))
        assert len(kept(tmp_path, QUESTION, 3)) == 2
        remove(memory)
        assert list(tmp_path.iterdir()) == []


def test_one_that_finishes_leaves_the_units_of_others(tmp_path: Path) -> None:
    """Of two questions at once in one folder."""
    first, other = fill(tmp_path), UnitMemory(tmp_path, OTHER)
    other.keep("u1", unit(1, "y"))
    other.flush()
    assert stored_questions(tmp_path) in ([QUESTION, OTHER], [OTHER, QUESTION])
    first.forget()
    assert stored_questions(tmp_path) == [OTHER]
    assert kept(tmp_path, OTHER, 3) == [1]


def test_one_whose_store_was_removed_goes_on(tmp_path: Path) -> None:
    memory = fill(tmp_path)
    UnitMemory.start(tmp_path, OTHER)
    memory.unit("u3", lambda: unit(3))
    memory.flush()
    assert stored_questions(tmp_path) == [QUESTION]
    assert kept(tmp_path, QUESTION, 4) == [3]


def test_a_unit_that_cannot_be_kept_says_so(tmp_path: Path) -> None:
    memory = UnitMemory.start(tmp_path, {})
    memory.unit("a", object)
    with rejected("unit"):
        memory.flush()


@pytest.mark.skipif(os.name != "posix", reason="limits of POSIX")
def test_a_disk_that_is_full(tmp_path: Path) -> None:
    """The units stay in memory, and nothing half written on the disk."""
    import resource

    memory, limits = fill(tmp_path, range(1)), resource.getrlimit(resource.RLIMIT_FSIZE)
    memory.unit("u1", lambda: unit(1))
    resource.setrlimit(resource.RLIMIT_FSIZE, (300, limits[1]))
    try:
        with failed("not-written"):
            memory.flush()
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, limits)
    assert len(list((tmp_path / "units").iterdir())) == 1
    memory.flush()
    assert kept(tmp_path, QUESTION, 2) == [0, 1]


WRITER = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from test_memory import fill, unit
from wucht.studies.memory import UnitMemory
folder, question, rounds = Path(sys.argv[2]), {"study": sys.argv[3]}, int(sys.argv[4])
print("ready", flush=True)
sys.stdin.readline()
for _ in range(rounds):
    fill(folder, range(15), question)
if rounds == 0:
    memory = UnitMemory.resume(folder, question)
    for k in range(10**9):
        memory.unit(f"u{k}", lambda: unit(k, question["study"]))
        memory.flush()
"""


def writer(folder: Path, question: str, rounds: int) -> subprocess.Popen[str]:
    """A process that fills a folder, again and again from nothing; rounds = 0: once and on and on."""
    here = str(Path(__file__).parent)
    command = [sys.executable, "-c", WRITER, here, str(folder), question, str(rounds)]
    return subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)


def begin(*processes: subprocess.Popen[str]) -> None:
    """Let all go at once."""
    for process in processes:
        assert process.stdout is not None
        assert process.stdout.readline() == "ready\n"
    for process in processes:
        assert process.stdin is not None
        process.stdin.write("\n")
        process.stdin.flush()


@pytest.mark.slow
def test_several_at_once_in_one_folder(tmp_path: Path) -> None:
    """Two with one question and one with another, each of which removes, again and again, what the others have written."""
    writers = [writer(tmp_path, of, 4) for of in "xxy"]
    try:
        begin(*writers)
        while any(w.poll() is None for w in writers):
            for question in (QUESTION, OTHER):
                kept(tmp_path, question, 15)
        assert [w.wait() for w in writers] == [0, 0, 0]
    finally:
        for w in writers:
            w.kill()
            w.communicate()
    last = {of: kept(tmp_path, {"study": of}, 15) for of in "xy"}
    assert any(last.values())


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")
def test_killed_at_any_moment(tmp_path: Path) -> None:
    """kill -9 while it writes: what is read back is right, and never less than before."""
    moments, before = random.Random(1), 0
    writers = [writer(tmp_path, "x", 0) for _ in range(2)]
    try:
        for w in writers:
            begin(w)
            while len(kept(tmp_path, QUESTION, 10_000)) <= before:
                assert w.poll() is None
            time.sleep(0.1 * moments.random())
            w.kill()
            w.communicate()
            now = kept(tmp_path, QUESTION, 10_000)
            assert now == list(range(len(now)))
            before = len(now)
    finally:
        for w in writers:
            w.kill()
            w.communicate()
