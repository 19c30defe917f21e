"""Whatever a command is started in: streams that are closed or of another alphabet, readers that leave, others' settings."""

from __future__ import annotations

import json
import os
import shlex
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
from tests.robustness import children

from wucht.cli import surroundings
from wucht.environment import set_threads

Refused = Callable[..., str]
Study = Callable[..., Path]
SHORT = ('until = "0.5 s"', 'until = "0.02 s"')
FILES = {"result.nc", "run-up.png", "summary.json"}


def in_a_shell(words: str, **environment: str) -> subprocess.CompletedProcess[bytes]:
    """A line of a shell, in which ``wucht`` is this one."""
    wucht = f'wucht() {{ {shlex.quote(sys.executable)} -m wucht "$@"; }}; set -o pipefail; '
    return subprocess.run(
        ["bash", "-c", wucht + words], capture_output=True, check=False, timeout=120, env={**os.environ, **environment}
    )


@pytest.mark.parametrize("closed", [*(pytest.param(each, marks=pytest.mark.slow) for each in (">&-", "2>&-")), "<&- >&- 2>&-"])
def test_closed_streams(study: Study, closed: str) -> None:
    """All is computed and written all the same, and nothing of the output gets into a file."""
    done = in_a_shell(f"wucht run {study(*SHORT)} -o out {closed}")
    assert done.returncode == 0, done.stderr
    assert {p.name for p in Path("out").iterdir()} == FILES
    assert Path("out/result.nc").read_bytes().startswith(b"\x89HDF")


def test_an_error_that_nobody_hears(here: Path) -> None:
    assert in_a_shell("wucht run nothing.toml >&- 2>&-").returncode == 2


def test_a_reader_that_leaves(here: Path) -> None:
    done = in_a_shell("wucht list | head -1")
    assert (done.returncode, done.stdout, done.stderr) == (0, b"carriers:    x, y, xy, fixed, r, xyr\n", b"")
    assert in_a_shell("wucht --help | true").returncode == 0


@pytest.mark.parametrize("encoding", ["latin-1", "shift_jis", pytest.param("euc_jp", marks=pytest.mark.slow)])
def test_an_alphabet_without_the_letters(study: Study, encoding: str) -> None:
    file = study('"A drum with two pendulums"', '"\u8f6c\u5b50\u03a9\u00b2"')
    done = in_a_shell(f"wucht equations {file}", PYTHONIOENCODING=encoding)
    assert done.returncode == 0, done.stderr
    assert "?" in done.stdout.decode(encoding).splitlines()[0]


@pytest.mark.slow
@pytest.mark.parametrize(
    "matplotlibrc",
    [b"text.usetex: True\n", b"font.size: \xff\n"],
    ids=["TeX", "no text"],
)
@pytest.mark.usefixtures("no_figures")
def test_settings_of_matplotlib_that_are_not_ours(wucht: Callable[..., Any], study: Study, matplotlibrc: bytes) -> None:
    assert wucht("run", study(*SHORT), "-o", "out").code == 0
    blank = Path("out/run-up.png").read_bytes()
    Path("matplotlibrc").write_bytes(matplotlibrc)
    done = in_a_shell("wucht plot out", MPLBACKEND="nonsense")
    assert (done.returncode, done.stdout) == (0, b"out/run-up.png\n"), done.stderr
    assert len(Path("out/run-up.png").read_bytes()) > 10 * len(blank)


@pytest.mark.parametrize("given", ["", "abc", "-5", "1e3", 30 * "9", 30 * "0" + 30 * "9"])
def test_a_date_that_libraries_cannot_read(refused: Refused, study: Study, monkeypatch: pytest.MonkeyPatch, given: str) -> None:
    """Said before anything is computed: they would fail when the figure is written."""
    monkeypatch.setenv("SOURCE_DATE_EPOCH", given)
    refused("run", study(), "-o", "out", "--json", says=(f"SOURCE_DATE_EPOCH: given {given!r}; ", "seconds since 1970"))
    assert not Path("out").exists()


def test_names_that_are_no_text(study: Study) -> None:
    """Neither is the title, which is made of the name of the study file."""
    name = os.fsdecode(b"dr\xffum.toml")
    study('title = "A drum with two pendulums"\n', "", *SHORT, name=name)
    out = os.fsdecode(b"\xffout")
    children.load_everything()
    done = children.call(children.entry_point("run", name, "-o", out), Path())
    assert done.code == 0, done.err
    assert done.out.startswith("dr?um\n")
    assert {p.name for p in Path(out).iterdir()} == FILES
    assert "?out/result.nc" in json.loads((Path(out) / "summary.json").read_text(encoding="utf-8"))["files"]


ODD: dict[str, dict[str, str | None]] = {
    "no home": {"HOME": None, "XDG_CACHE_HOME": None, "XDG_CONFIG_HOME": None, "WUCHT_CACHE_DIR": None},
    "a home that is none": {"HOME": "/nowhere/at/all", "WUCHT_CACHE_DIR": None, "XDG_CACHE_HOME": None},
    "a home that is a file": {"HOME": "/dev/null", "WUCHT_CACHE_DIR": None, "XDG_CACHE_HOME": None},
    "a cache that is a file": {"WUCHT_CACHE_DIR": "/dev/null/x"},
    "no folder for what is temporary": {"TMPDIR": "/nowhere"},
    "a language that is none": {"LC_ALL": "xx_YY.nonsense", "LANG": "nonsense"},
    "plain C": {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"},
    "Turkish": {"LC_ALL": "tr_TR.UTF-8", "LANG": "tr_TR.UTF-8"},
    "a narrow terminal": {"COLUMNS": "1", "LINES": "1", "TERM": "nonsense", "FORCE_COLOR": "1"},
    "a width that is none": {"COLUMNS": "abc"},
    "a zone that is none": {"TZ": "Nowhere/At_All"},
    "numbers of threads that are none": {"OPENBLAS_NUM_THREADS": "abc", "OMP_NUM_THREADS": "4;2", "NUMEXPR_MAX_THREADS": "x"},
    "threads of nested levels": {"OMP_NUM_THREADS": "4,2"},
    "all warnings": {"PYTHONWARNINGS": "always", "PYTHONDEVMODE": "1"},
}


@pytest.mark.slow
@pytest.mark.parametrize("names", [[*ODD][:-1], *([name] for name in ODD)], ids=str)
def test_odd_environments(study: Study, names: list[str]) -> None:
    """First all at once, as far as they do not contradict each other; the last one says more than is wrong."""
    given = {key: value for name in reversed(names) for key, value in ODD[name].items()}
    absent = " ".join(f"-u {key}" for key, value in given.items() if value is None)
    present = " ".join(f"{key}={shlex.quote(value)}" for key, value in given.items() if value is not None)
    command = shlex.join([sys.executable, "-m", "wucht", "run", str(study(*SHORT)), "-o", "out"])
    done = in_a_shell(f"env {absent} {present} {command}")
    assert done.returncode == 0, done.stderr
    assert b"Traceback" not in done.stderr
    assert {p.name for p in Path("out").iterdir()} == FILES


@pytest.mark.slow
def test_a_working_directory_that_is_gone(study: Study, tmp_path: Path) -> None:
    """There is nothing to write to, and a relative name leads nowhere: that is said."""
    done = in_a_shell("mkdir gone; cd gone; rmdir ../gone; wucht run x.toml")
    assert done.returncode in (1, 2)
    assert done.stderr.count(b"\n") == 1
    assert done.stderr.startswith(b"wucht: ")
    file, words = tmp_path / study(*SHORT), ("-o", str(tmp_path / "out"))

    def from_nowhere() -> int:
        Path("gone").mkdir()
        os.chdir("gone")
        Path("../gone").rmdir()
        return children.entry_point("run", str(file), *words)()

    children.load_everything()
    ended = children.call(from_nowhere, tmp_path)
    assert ended.code == 0, ended.err
    assert {p.name for p in (tmp_path / "out").iterdir()} == FILES


@pytest.mark.parametrize(
    ("given", "expected"),
    [
        ({}, "1"),
        ({"OPENBLAS_NUM_THREADS": "3"}, "3"),
        ({"OMP_NUM_THREADS": "4"}, None),
        ({"OMP_NUM_THREADS": "4,2"}, None),
        ({"OMP_NUM_THREADS": ""}, "1"),
        ({"OPENBLAS_NUM_THREADS": " 2 , 1 "}, "2"),
    ],
)
def test_one_thread_unless_the_user_sets_another_number(
    given: dict[str, str], expected: str | None, monkeypatch: pytest.MonkeyPatch
) -> None:
    for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.delenv(name, raising=False)
    for name, number in given.items():
        monkeypatch.setenv(name, number)
    set_threads()
    assert os.environ.get("OPENBLAS_NUM_THREADS") == expected
    assert os.environ.get("OMP_NUM_THREADS") in (None, "4")
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "1")  # so that the end of the test removes what it has set


THREADS_OF_A_RUN = """
import scipy.linalg
from threadpoolctl import threadpool_info, threadpool_limits

import wucht
from wucht.extending import Answer, Study


def threads():
    return sorted({library["num_threads"] for library in threadpool_info() if library["user_api"] == "blas"})


class Threads(Study):
    '''The threads of linear algebra.'''

    kind = "threads"
    depth: int = 1

    def prepare(self, machine):
        return machine

    def solve(self, machine, prepared, work):
        if self.depth:
            wucht.run(Threads(depth=0), machine)
        a = Answer(machine.units)
        a.number("threads", threads(), "threads")
        yield a

    def draw(self, result):
        pass


machine = wucht.load_machine("drozdetskaya-2020/r1")
threadpool_limits(3, user_api="blas")
print(wucht.run(Threads(), machine).wucht.summary["threads"], threads())
"""


@pytest.mark.slow
@pytest.mark.parametrize(("given", "expected"), [({}, "[1] [3]"), ({"OMP_NUM_THREADS": "2"}, "[3] [3]")])
def test_a_run_from_python_has_one_thread_as_well(given: dict[str, str], expected: str) -> None:
    """Unless the user sets another number; after it, and after a run within it, all is as before."""
    environment = {name: value for name, value in os.environ.items() if not name.endswith("_NUM_THREADS")} | given
    command = [sys.executable, "-c", THREADS_OF_A_RUN]
    done = subprocess.run(command, capture_output=True, text=True, check=True, timeout=120, env=environment)
    assert done.stdout.strip() == expected


@pytest.mark.parametrize("name", ["OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "NUMEXPR_NUM_THREADS"])
@pytest.mark.parametrize("given", ["abc", "0", "-1", "4,", "4,0", "4;2", "2.5", "1e3", 5000 * "9", "\u0664"])
def test_a_number_of_threads_that_is_none(name: str, given: str, monkeypatch: pytest.MonkeyPatch) -> None:
    """It is named with what is allowed, and one thread is used."""
    for either in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS"):
        monkeypatch.delenv(either, raising=False)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "3")  # so that the end of the test restores it
    monkeypatch.delenv("OPENBLAS_NUM_THREADS")
    monkeypatch.setenv(name, given)
    with pytest.warns(UserWarning, match=f"^{name}: given .*; this environment variable must be a number of threads "):
        set_threads()
    assert os.environ["OPENBLAS_NUM_THREADS"] == "1"
    assert "OMP_NUM_THREADS" not in os.environ and "NUMEXPR_NUM_THREADS" not in os.environ


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is checked")
def test_an_address_space_that_is_too_small(study: Study) -> None:
    """OpenBLAS would try for ever to get its memory, and no signal but SIGKILL would end it."""
    done = in_a_shell(f"ulimit -v 700000; wucht run {study(*SHORT)}")
    assert done.returncode == 2
    assert done.stderr == b"wucht: ulimit -v: given '700000'; the address space must be at least 1300000 kB, or unlimited\n"
    assert in_a_shell("ulimit -v 700000; wucht list").returncode == 0


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is checked")
@pytest.mark.parametrize(
    ("kilobytes", "given", "expected"), [(1_300_000, "8", 1), (1_384_999, "8", 1), (1_385_000, "8", 2), (2_000_000, "3", 3)]
)
def test_so_many_threads_as_have_room(kilobytes: int, given: str, expected: int, monkeypatch: pytest.MonkeyPatch) -> None:
    import resource

    monkeypatch.setattr(resource, "getrlimit", lambda _: (kilobytes * 1024, kilobytes * 1024))
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", given)
    surroundings.fit_address_space()
    assert os.environ["OPENBLAS_NUM_THREADS"] == str(expected)


@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is checked")
@pytest.mark.parametrize(
    ("own", "general", "expected"), [("2", "5", "2"), ("abc", "5", "5"), ("5", "2", "5"), ("", "4,2", "4"), ("0", "x", "1")]
)
@pytest.mark.filterwarnings("ignore:O[A-Z]+_NUM_THREADS")
def test_of_two_settings_the_one_that_openblas_reads_first_counts(
    own: str, general: str, expected: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """OPENBLAS_NUM_THREADS before OMP_NUM_THREADS, which is for all programs; where there is room for all of them."""
    import resource

    monkeypatch.setattr(resource, "getrlimit", lambda _: (10**10, 10**10))
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", own)
    monkeypatch.setenv("OMP_NUM_THREADS", general)
    surroundings.fit_address_space()
    assert os.environ["OPENBLAS_NUM_THREADS"] == expected


@pytest.mark.slow
@pytest.mark.skipif(sys.platform != "linux", reason="elsewhere nothing is checked")
@pytest.mark.parametrize("name", ["drozdetskaya-2020/r1", "practice/laundry-drum", "orbit-branch.toml"])
def test_the_least_address_space_is_enough(here: Path, name: str) -> None:
    if name.endswith(".toml"):
        assert in_a_shell(f"wucht new {name.removesuffix('.toml')}").returncode == 0
    done = in_a_shell(f"ulimit -v 1300000; wucht run {name} -o out")
    assert done.returncode == 0, done.stderr
