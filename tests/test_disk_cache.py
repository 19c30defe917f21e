"""What is derived once: read back by its inputs and in another process; what this user's processes did not write is not loaded.

Authentication codes are computed here a second time, by RFC 2104 as written: H(K ^ opad, H(K ^ ipad, text)).
"""

import hashlib
import json
import os
import subprocess
import sys
import warnings
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path
from shutil import copytree

import pytest
import sympy as sp

from wucht import disk_cache
from wucht.disk_cache import derived as derived_module
from wucht.machines.parts.base import Release
from wucht.system import Output, System

calls: list[object] = []
x, v = sp.symbols("x v", real=True)
NOT_WINDOWS = pytest.mark.skipif(os.name == "nt", reason="Windows has no such modes")


def squared(output: Output, factor: float, release: Release | None = None) -> Output:
    calls.append(output)
    if factor < 0:
        raise ValueError("negative")
    return Output(output.name, factor * output.expression**2, output.unit, output.long_name)


def same(system: System) -> System:
    calls.append(system)
    return system


derived, derived_system = disk_cache.derived_once(squared), disk_cache.derived_once(same)


def question(expression: sp.Expr = x) -> Output:
    return Output("y", expression)


def answer(expression: sp.Expr = x, factor: float = 1.0) -> Output:
    return Output("y", factor * expression**2)


@pytest.fixture(autouse=True)
def folder(tmp_path, monkeypatch):
    calls.clear()
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path / "cache"))
    monkeypatch.setenv("XDG_STATE_HOME", str(tmp_path / "state"))
    return tmp_path / "cache"


@pytest.fixture
def key(tmp_path):
    """The file of the key; made."""
    derived(question(), 1.0)
    calls.clear()
    return tmp_path / "state/wucht/cache-key"


def files_in(folder: Path) -> list[Path]:
    return sorted(p for p in folder.rglob("*") if p.is_file())


def the_file(folder: Path) -> Path:
    (file,) = files_in(folder)
    return file


def entry(key: bytes, name: str, content: bytes) -> bytes:
    """An entry, by RFC 2104."""

    def keyed(pad: int) -> bytes:
        return bytes(b ^ pad for b in key.ljust(64, b"\0"))

    inner = hashlib.sha256(keyed(0x36) + name.encode() + b"\0" + content).digest()
    return hashlib.sha256(keyed(0x5C) + inner).digest() + content


# What is kept


def test_it_is_derived_once_for_equal_inputs():
    release = Release(time=1.0)
    first = derived(question(x + 1), 2.0, release)
    assert derived(question(1 + x), 2.0, Release(time=1.0)) == first == answer(x + 1, 2.0)
    assert len(calls) == 1
    for other in ((question(x + 2), 2.0, release), (question(x + 1), 2.0), (question(x + 1), 2.5, release)):
        assert derived(*other) == squared(*other)
    assert len(calls) == 1 + 2 * 3


@pytest.mark.parametrize(
    "expression",
    [
        sp.Float(0.1),
        sp.Float("0.1", 50),
        sp.oo,
        sp.Mul(2, x + v, evaluate=False),
        sp.Add(x, x, evaluate=False),
        sp.sin(2 * x) ** 2 / sp.sqrt(v),
        sp.atan2(x, v) + sp.Abs(x) * sp.sign(v),
        sp.Piecewise((x, x > 0), (v, True)),
        sp.ImmutableMatrix([[x, 1], [sp.pi, v]]),
        sp.Symbol("c", positive=True),
        sp.Derivative(sp.sin(x) * v, x),
        10**30 * x,
    ],
    ids=str,
)
def test_an_expression_is_read_as_it_was(expression):
    """To the last argument, also what SymPy would now evaluate."""
    whole = System((x,), (expression if isinstance(expression, sp.Expr) and expression.free_symbols <= {x} else x,))
    for value in (whole, Output("y", expression)):
        first, again = disk_cache.derived_once(same)(value), disk_cache.derived_once(same)(value)
        assert again == first == value
        assert sp.srepr(getattr(again, "expression", None)) == sp.srepr(getattr(value, "expression", None))
    assert len(calls) == 2


# What is read


def test_an_entry_has_the_code_of_its_name_and_content(folder, key):
    """The witness of all that follows: what is signed with the key is read, whatever it is."""
    file = the_file(folder)
    name, whole = file.relative_to(folder).as_posix(), file.read_bytes()
    assert whole == entry(key.read_bytes(), name, whole[32:])
    file.write_bytes(entry(key.read_bytes(), name, whole[32:].replace(b'"y"', b'"z"')))
    assert derived(question(), 1.0).name == "z"
    assert calls == []


def test_a_changed_byte_is_noticed_and_said_once(folder, key):
    """Each of them, and a file that is cut off, empty or longer: derived anew and stored again."""
    file = the_file(folder)
    whole = file.read_bytes()
    flipped = [whole[:at] + bytes([whole[at] ^ 1 << at % 8]) + whole[at + 1 :] for at in range(len(whole))]
    changed = [*flipped, b"", whole[:20], whole[:-1], whole + b" "]
    with pytest.warns(RuntimeWarning, match="not written with your key") as notes:
        for damaged in changed:
            file.write_bytes(damaged)
            assert derived(question(), 1.0) == answer()
            assert file.read_bytes() == whole
    assert len(calls) == len(changed) > 100
    assert len(notes) == 1


def test_entries_cannot_be_exchanged_moved_or_rolled_back(folder, key):
    """Neither for another question, nor between functions, nor from the folder of an older program."""
    first = the_file(folder)
    derived(question(x + 1), 1.0)
    (second,) = set(files_in(folder)) - {first}
    contents = first.read_bytes(), second.read_bytes()
    calls.clear()
    with pytest.warns(RuntimeWarning, match="not written with your key"):
        first.write_bytes(contents[1])
        second.write_bytes(contents[0])
        assert derived(question(), 1.0) == answer()
        assert derived(question(x + 1), 1.0) == answer(x + 1)
    assert len(calls) == 2
    older = entry(key.read_bytes(), f"derived-0123456789abcdef/{first.name}", contents[0][32:])
    for moved in (older, entry(key.read_bytes(), first.name, contents[0][32:])):
        first.write_bytes(moved)
        assert derived(question(), 1.0) == answer()
    assert len(calls) == 4


def test_only_classes_of_expressions_are_made_of_what_is_read(folder, key, tmp_path):
    """Even of an entry with the right code."""
    file = the_file(folder)
    for of in ("os:system", "subprocess:Popen", "wucht.os:system", "builtins:eval"):
        content = b"j" + json.dumps([0, [["expression", of, {}, f"touch {tmp_path}/written"]]]).encode()
        file.write_bytes(entry(key.read_bytes(), file.relative_to(folder).as_posix(), content))
        assert derived(question(), 1.0) == answer()
    assert len(calls) == 4
    assert not (tmp_path / "written").exists()


@NOT_WINDOWS
def test_what_is_no_file_is_not_read(folder, key, tmp_path):
    """An archive can hold links, pipes, and files that are larger than the memory: none is waited for."""
    file = the_file(folder)
    whole = file.read_bytes()
    elsewhere = tmp_path / "elsewhere"
    elsewhere.write_bytes(whole)
    kinds = {
        "a link": lambda: file.symlink_to(elsewhere),
        "a pipe": lambda: os.mkfifo(file),
        "a folder": file.mkdir,
        "a file of a terabyte": lambda: os.truncate(os.open(file, os.O_CREAT | os.O_WRONLY), 2**40),
    }
    for make in kinds.values():
        file.unlink()
        make()
        assert derived(question(), 1.0) == answer()
        if file.is_dir():
            file.rmdir()
            file.touch()
    assert len(calls) == 4
    assert elsewhere.read_bytes() == whole


# The key


def test_the_key_is_made_once_outside_the_cache(folder, key):
    assert len(key.read_bytes()) == 32
    assert not key.is_relative_to(folder)
    if os.name != "nt":
        assert [p.stat().st_mode & 0o777 for p in (key, key.parent, folder, the_file(folder))] == [0o600, 0o700, 0o700, 0o600]
    assert [p.name for p in key.parent.iterdir()] == ["cache-key"], "nothing else is left there"


def copied(key: Path, to: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """The same key elsewhere: which of its users it was is remembered by a process."""
    copytree(key.parent.parent, to)
    monkeypatch.setenv("XDG_STATE_HOME", str(to))
    return to / "wucht/cache-key"


@NOT_WINDOWS
@pytest.mark.parametrize("mode", [0o400, 0o640, 0o602, 0o666])
def test_a_key_that_others_can_read_or_write_is_refused(key, tmp_path, monkeypatch, mode):
    copied(key, tmp_path / "other", monkeypatch).chmod(mode)
    if mode in (0o600, 0o400):
        derived(question(), 1.0)
        assert calls == []
        return
    with pytest.warns(
        RuntimeWarning, match=r"cache-key, (can be read by other accounts|is not yours alone).*not used"
    ) as notes:
        assert derived(question(), 1.0) == derived(question(), 1.0) == answer()
    assert len(calls) == 2
    assert len(notes) == 1


@NOT_WINDOWS
def test_a_key_that_is_somebody_elses_or_damaged_is_refused(key, tmp_path, monkeypatch):
    nobody = 65534
    changes = {
        "a link": lambda file: (file.rename(file.with_name("real")), file.symlink_to(file.with_name("real"))),
        "no file of 32 bytes.*; remove this file": lambda file: file.write_bytes(b""),
        "no file of 32 bytes ": lambda file: file.write_bytes(bytes(33)),
        "no file of 32 bytes  ": lambda file: (file.unlink(), os.mkfifo(file)),
        "a folder that is not yours alone.*; that folder must be yours": lambda file: file.parent.chmod(0o777),
    }
    if os.geteuid() == 0:
        changes |= {
            "not yours alone": lambda file: os.chown(file, nobody, -1),
            "a folder that is not yours alone ": lambda file: os.chown(file.parent, nobody, -1),
        }
    for number, (expected, change) in enumerate(changes.items()):
        change(copied(key, tmp_path / f"other-{number}", monkeypatch))
        with pytest.warns(RuntimeWarning, match=expected.strip()) as notes:
            derived(question(), 1.0)
        assert len(notes) == 1
    assert len(calls) == len(changes)


def test_without_its_key_all_is_derived_anew_with_one_note(folder, key, tmp_path):
    """In the next process, which makes another key; and the one after it reads what that has stored."""
    derived(question(x + 1), 1.0)
    key.unlink()
    first, second = child("x", "x + 1"), child("x", "x + 1")
    assert first.stdout.split() == ["2"]
    assert first.stderr.count("not written with your key") == 1
    assert (second.stdout.split(), second.stderr) == (["0"], "")


@pytest.mark.parametrize("variables", [{"XDG_STATE_HOME": "/dev/null/x"}, {"XDG_STATE_HOME": None, "HOME": "/nowhere/at/all"}])
def test_where_no_key_can_be_kept_the_cache_is_not_used(folder, variables, monkeypatch):
    """Without a word: in a container that is usual."""
    for name, value in variables.items():
        monkeypatch.setenv(name, value) if value else monkeypatch.delenv(name)
    if os.name != "nt" and os.geteuid() == 0 and variables.get("HOME"):
        monkeypatch.setenv("HOME", "/dev/null/x")  # root could make the other one
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert derived(question(), 3.0) == derived(question(), 3.0) == answer(factor=3.0)
    assert len(calls) == 2
    assert not folder.exists()


@pytest.mark.slow
def test_processes_that_begin_at_once_have_one_key(folder, tmp_path):
    """Each derives something else; afterwards all of it is read, without a note."""
    expressions = [f"x + {k}" for k in range(6)]
    with ThreadPoolExecutor(len(expressions)) as pool:
        done = list(pool.map(child, expressions))
    assert [(d.stdout.split(), d.stderr) for d in done] == [(["1"], "")] * len(expressions)
    assert [p.name for p in (tmp_path / "state/wucht").iterdir()] == ["cache-key"]
    again = child(*expressions)
    assert (again.stdout.split(), again.stderr) == (["0"], "")


CHILD = """
import sys, sympy as sp
from wucht.disk_cache import derived_once
from wucht.system import Output
calls = []
def squared(output, factor):
    calls.append(output)
    return Output(output.name, factor * output.expression**2, output.unit, output.long_name)
squared.__module__ = sys.argv.pop(1)
derived, x = derived_once(squared), sp.Symbol("x", real=True)
for text in sys.argv[1:]:
    expression = x + int(text.partition("+")[2] or 0)
    assert derived(Output("y", expression), 1.0) == Output("y", 1.0 * expression**2)
print(len(calls))
"""


def child(*expressions: str) -> subprocess.CompletedProcess[str]:
    """A process that derives these: how often it had to, and what it said."""
    return subprocess.run([sys.executable, "-c", CHILD, __name__, *expressions], capture_output=True, text=True, check=True)


# The folder


@NOT_WINDOWS
def test_a_folder_that_others_can_write_is_not_used(folder, key):
    place = the_file(folder).parent
    with pytest.warns(RuntimeWarning, match="is not yours alone .*not used; see WUCHT_CACHE_DIR") as notes:
        for mode in (0o720, 0o702, 0o777):
            place.chmod(mode)
            derived(question(), 1.0)
    assert len(notes) == 1
    assert len(calls) == 3
    place.chmod(0o755)
    derived(question(), 1.0)
    assert len(calls) == 3


def test_a_changed_program_derives_anew_and_only_the_last_are_kept(folder, tmp_path, monkeypatch):
    folder.mkdir()
    theirs = [folder / name for name in ("mine", "derived-results", "derived-2024", "derived-0123456789abcdef0")]
    for other in theirs:  # what is not the cache's stays, in a folder with work of the user, too
        other.mkdir()
        os.utime(other, (1, 1))
    for change in range(6):
        program = tmp_path / "program/disk_cache/derived.py"
        program.parent.mkdir(exist_ok=True, parents=True)
        program.write_text(f"change = {change}")
        os.utime(program, (1, 1))  # as where a build sets all times alike
        monkeypatch.setattr(derived_module, "__file__", str(program))
        derived_module._program_folder.cache_clear()
        derived(question(), 1.0)
        derived(question(), 1.0)
    assert len(calls) == 6
    assert all(other.is_dir() for other in theirs)
    assert len(list(folder.iterdir())) == 4 + len(theirs)


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


def test_what_the_users_own_classes_make_of_it_is_not_kept(folder):
    """Their code may be another one in the next process, and those of a function cannot be stored at all."""

    class Stiffening(sp.Function):
        pass

    for cls in (Stiffening, type("Elsewhere", (sp.Function,), {"__module__": "notebook"}), sp.Function("f")):
        assert derived(question(cls(x)), 2.0) == derived(question(cls(x)), 2.0) == answer(cls(x), 2.0)
    assert len(calls) == 6
    assert files_in(folder) == []


def test_a_key_in_the_cache_itself_is_refused(folder, monkeypatch):
    """Who has a copy of the cache would have it as well."""
    monkeypatch.setenv("XDG_STATE_HOME", str(folder / "state"))
    with pytest.warns(RuntimeWarning, match="lies in the cache itself.*; give another folder by WUCHT_CACHE_DIR"):
        derived(question(), 1.0)
    assert not folder.exists()


def test_without_a_place_to_write_it_is_derived_each_time(tmp_path, monkeypatch):
    (tmp_path / "file").write_text("no folder")
    monkeypatch.setenv("WUCHT_CACHE_DIR", str(tmp_path / "file"))
    assert derived(question(), 3.0) == derived(question(), 3.0)
    assert len(calls) == 2


def test_by_default_it_lies_in_the_users_cache_folder(monkeypatch):
    monkeypatch.delenv("WUCHT_CACHE_DIR")
    monkeypatch.setenv("XDG_CACHE_HOME", str(Path("/somewhere")))
    assert disk_cache.cache_folder().name == "wucht"
