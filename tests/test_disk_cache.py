"""What is derived once: found again by its inputs and in another process, derived anew where it is not there."""

import os
import pickle
import subprocess
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import Any, get_type_hints

import pytest
import sympy as sp

from wucht import disk_cache
from wucht.analysis import averaged_equations as averaged
from wucht.analysis import relative_equilibria
from wucht.machines import structure
from wucht.machines.parts.base import Release
from wucht.mechanics import linear_carrier
from wucht.numerics.continuation import equations
from wucht.numerics.flow import program
from wucht.numerics.phase_plane import plane

disk_cache._STABLE_PACKAGES.add(__name__)  # as if the classes here were the program's


@dataclass(frozen=True)
class Question:
    expression: sp.Expr
    release: Release | None = None
    label: str = field(default="", compare=False)

    @cached_property
    def own(self) -> str:
        return f"computed by process {os.getpid()}"


calls: list[object] = []
MODULES = (averaged, relative_equilibria, structure, linear_carrier, equations, program, plane)


def itself(question: Question) -> Question:
    return question


def squared(question: Question, factor: float) -> Question:
    calls.append(question)
    if factor < 0:
        raise ValueError("negative")
    return Question(factor * question.expression**2, label=question.label)


derived = disk_cache.derived_once(squared)
x = sp.Symbol("x", real=True)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    calls.clear()
    disk_cache._warn_once.cache_clear()
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path / "cache"))
    disk_cache._folder.cache_clear()
    yield tmp_path / "cache"
    disk_cache._folder.cache_clear()


def test_it_is_derived_once_for_equal_inputs():
    release = Release(time=1.0)
    first = derived(Question(x + 1, release, "a"), 2.0)
    assert derived(Question(1 + x, Release(time=1.0), "b"), 2.0) == first == Question(2.0 * (x + 1) ** 2)
    assert len(calls) == 1
    for other in ((Question(x + 2, release), 2.0), (Question(x + 1), 2.0), (Question(x + 1, release), 2.5)):
        assert derived(*other) == squared(*other)
    assert len(calls) == 1 + 2 * 3
    assert derived(Question(x + 1, release), 2.0).label == "a"  # the result of the first call, whole


def test_what_an_object_has_computed_of_itself_is_neither_key_nor_kept(folder):
    question = Question(x)
    derived(question, 1.0)
    assert question.own
    derived(question, 1.0)
    assert len(calls) == 1
    disk_cache.derived_once(itself)(question)
    assert "own" in vars(question)
    assert "own" not in vars(disk_cache.derived_once(itself)(question))
    assert all(b"computed by" not in file.read_bytes() for file in folder.rglob("*") if file.is_file())


def test_what_the_users_own_classes_make_of_it_is_not_kept(folder):
    """Their code may be another one in the next process, and those of a function cannot be pickled at all."""

    class Stiffening(sp.Function):
        pass

    for cls in (Stiffening, type("Elsewhere", (sp.Function,), {"__module__": "notebook"})):
        question = Question(cls(x))
        assert derived(question, 2.0) == derived(question, 2.0) == Question(2.0 * cls(x) ** 2)
    assert len(calls) == 4
    assert not [p for p in folder.rglob("*") if p.is_file()]


def test_an_error_is_not_kept(folder):
    for _ in range(2):
        with pytest.raises(ValueError, match="negative"):
            derived(Question(x), -1.0)
    assert len(calls) == 2
    assert not [p for p in folder.rglob("*") if p.is_file()]


def test_a_damaged_file_is_derived_again(folder):
    derived(Question(x), 1.0)
    file = the_file(folder)
    whole = file.read_bytes()
    for damaged in (b"", whole[: len(whole) // 2], b"no pickle"):
        file.write_bytes(damaged)
        assert derived(Question(x), 1.0) == Question(x**2 * 1.0)
        assert file.read_bytes() == whole
    assert len(calls) == 4


def test_a_flipped_bit_is_noticed(folder):
    """In each byte: a pickle has no digest of its own, and most flips make another expression of it."""
    derived(Question(x), 1.0)
    file = the_file(folder)
    whole = file.read_bytes()
    for at in range(len(whole)):
        damaged = bytearray(whole)
        damaged[at] ^= 1 << at % 8
        file.write_bytes(damaged)
        with pytest.raises(ValueError):
            disk_cache.read_stored(file)


def test_a_whole_file_of_another_type_or_another_name_is_derived_again(folder):
    derived(Question(x), 1.0)
    file = the_file(folder)
    whole = file.read_bytes()
    disk_cache.store(file, pickle.dumps(None))
    assert derived(Question(x), 1.0) == Question(x**2 * 1.0)
    derived(Question(x + 1), 1.0)
    (other,) = (p for p in file.parent.iterdir() if p != file)
    other.write_bytes(whole)
    assert derived(Question(x + 1), 1.0) == Question((x + 1) ** 2 * 1.0)
    assert len(calls) == 4


def the_file(folder: Path) -> Path:
    (file,) = (p for p in folder.rglob("*") if p.is_file())
    return file


def was_unpickled() -> None:
    calls.append("unpickled")


class Evil:
    def __reduce__(self):
        return was_unpickled, ()


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")
def test_only_what_nobody_else_can_write_is_read(folder):
    derived(Question(x), 1.0)
    file = the_file(folder)
    assert file.stat().st_mode & 0o777 == 0o600
    assert file.parent.stat().st_mode & 0o777 == 0o700
    disk_cache.store(file, pickle.dumps(Evil()))
    for mode in (0o620, 0o602, 0o666):
        file.chmod(mode)
        derived(Question(x), 1.0)
        disk_cache.store(file, pickle.dumps(Evil()))
    assert calls.count("unpickled") == 0
    assert len(calls) == 4
    for mode in (0o720, 0o702, 0o777):
        file.parent.chmod(mode)
        disk_cache._warn_once.cache_clear()
        with pytest.warns(RuntimeWarning, match="is not yours alone") as said:
            derived(Question(x), 1.0)
            derived(Question(x), 1.0)
        assert len(said) == 1, "once"
    assert calls.count("unpickled") == 0
    file.parent.chmod(0o755)
    derived(Question(x), 1.0)
    assert calls.count("unpickled") == 1, "a folder of one's own that others may read is used: the test above can fail"


@pytest.mark.skipif(os.name == "nt", reason="Windows has no such owners")
def test_a_folder_of_another_user_or_behind_a_link_is_not_used(folder, tmp_path, monkeypatch):
    place = disk_cache._folder()
    place.rename(tmp_path / "elsewhere")
    place.symlink_to(tmp_path / "elsewhere")
    with pytest.warns(RuntimeWarning, match="not used"):
        derived(Question(x), 1.0)
    assert list((tmp_path / "elsewhere").iterdir()) == []
    place.unlink()
    place.mkdir(mode=0o700)
    monkeypatch.setattr(os, "geteuid", lambda: place.stat().st_uid + 1)
    disk_cache._warn_once.cache_clear()
    with pytest.warns(RuntimeWarning, match="not used"):
        derived(Question(x), 1.0)
    assert list(place.iterdir()) == []


def test_on_windows_it_is_used_below_the_profile_alone(folder, tmp_path, monkeypatch):
    monkeypatch.setattr(disk_cache, "_WINDOWS", True)
    monkeypatch.setattr(Path, "home", lambda: tmp_path)
    derived(Question(x), 1.0)
    derived(Question(x), 1.0)
    assert len(calls) == 1
    monkeypatch.setattr(Path, "home", lambda: tmp_path / "somebody")
    with pytest.warns(RuntimeWarning, match="not in your profile folder"):
        derived(Question(x), 1.0)
    assert len(calls) == 2


def test_the_type_that_each_function_returns_is_known():
    """So that what is read can be compared with it; where it were not, all would be derived again and again."""
    functions = [f for place in (*MODULES, structure.Structure) for value in vars(place).values() for f in kept_by(value)]
    assert len({f.__qualname__ for f in functions}) > 8
    for function in functions:
        assert "return" in get_type_hints(function), function


def kept_by(value: Any) -> Iterator[Any]:
    """The function whose results are kept, below a property or a memory of this process."""
    value = getattr(value, "func", value)
    while value is not None:
        if getattr(getattr(value, "__code__", None), "co_qualname", "") == "derived_once.<locals>.cached_function":
            yield value.__wrapped__
        value = getattr(value, "__wrapped__", None)


def test_without_a_place_to_write_it_is_derived_each_time(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path / "file"))
    disk_cache._folder.cache_clear()
    assert derived(Question(x), 3.0) == derived(Question(x), 3.0)
    assert len(calls) == 2


def test_a_changed_program_derives_anew_and_only_the_last_are_kept(folder, tmp_path, monkeypatch):
    folder.mkdir()
    (folder / "mine").mkdir()  # what is not ours stays
    for change in range(6):
        program = tmp_path / "program" / "disk_cache.py"
        program.parent.mkdir(exist_ok=True)
        program.write_text(f"change = {change}")
        os.utime(program, (1, 1))  # as where a build sets all times alike
        monkeypatch.setattr(disk_cache, "__file__", str(program))
        disk_cache._folder.cache_clear()
        derived(Question(x), 1.0)
        derived(Question(x), 1.0)
    assert len(calls) == 6
    assert len(list(folder.glob("derived-*"))) == disk_cache._PROGRAMS
    assert (folder / "mine").is_dir()


RUN = """
import sys, sympy
import wucht.mechanics.lagrange, wucht.mechanics.rotating_bodies.averaged_system, wucht.analysis.averaged_equations
def symbolic(*a, **k): raise AssertionError("symbolic work in a second process")
if sys.argv[1] == "second":
    sympy.lambdify = wucht.mechanics.lagrange.equations_of_motion = symbolic
    wucht.analysis.averaged_equations.averaged_equations = symbolic
import wucht
run = wucht.run_file("drozdetskaya-2020/r1", {"study.until": 2.0, "study.model": "both"})
print(run.wucht.summary["outcome"], repr(float(run.speed[0, -1])), repr(float(run.slow_speed[0, -1])))
"""


@pytest.mark.slow
def test_a_second_process_derives_nothing_and_computes_the_same(folder):
    """Whatever order its sets have: another hash seed in each process."""
    said = []
    for seed, which in ((1, "first"), (2, "second"), (77, "second")):
        environment = os.environ | {"PYTHONHASHSEED": str(seed), "WUCHT_CACHE_DIR": str(folder)}
        run = subprocess.run([sys.executable, "-c", RUN, which], capture_output=True, text=True, env=environment, check=False)
        assert run.returncode == 0, run.stderr
        said.append(run.stdout)
    assert said[0]
    assert said[1:] == said[:1] * 2


def test_by_default_it_lies_in_the_users_cache_folder(monkeypatch):
    monkeypatch.delenv("WUCHT_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(Path("/somewhere")))
    assert disk_cache.cache_folder().name == "wucht"
