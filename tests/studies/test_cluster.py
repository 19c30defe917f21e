"""Tiles on the workers of a scheduler on the loopback: the same result as of one process, whoever dies meanwhile."""

from __future__ import annotations

import os
import shutil
import socket
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import pytest
from tests import refusals
from tests.refusals import check_refusal, failed
from tiled_squares import TiledSquares, marks

import wucht
from interrupting import assert_same
from known_borders import rail
from wucht import Basin, Response, load_machine
from wucht import run as ask
from wucht.studies.study_file import read_comparison

HERE = Path(__file__).parent
pytestmark = pytest.mark.skipif(os.name != "posix", reason="signals of POSIX")


@pytest.fixture(autouse=True)
def _study() -> Iterator[None]:
    """The study has a name while these tests run: others list those of the package."""
    TiledSquares.kind = "tiled-squares"
    yield
    TiledSquares.kind = ""


def free_port() -> int:
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return int(probe.getsockname()[1])


@dataclass
class Loopback:
    """A scheduler and its workers, processes of this machine. modules: a folder in which they look for modules first."""

    log: Path
    modules: Path = HERE
    port: int = field(default_factory=free_port)
    workers: list[subprocess.Popen[bytes]] = field(default_factory=list)

    def __post_init__(self) -> None:
        self.scheduler = self._process("scheduler", "--host", "127.0.0.1", "--port", str(self.port), "--no-dashboard")

    @property
    def address(self) -> str:
        return f"tcp://127.0.0.1:{self.port}"

    def add_worker(self) -> None:
        self.workers.append(self._process("worker", self.address, "--nthreads", "1", "--no-nanny", "--no-dashboard"))

    def _process(self, what: str, *options: str) -> subprocess.Popen[bytes]:
        environment = os.environ | {
            "PYTHONPATH": os.pathsep.join([str(self.modules), str(HERE), os.environ.get("PYTHONPATH", "")])
        }
        with self.log.open("ab") as log:
            command = [sys.executable, "-m", "dask", what, *options]
            return subprocess.Popen(command, env=environment, cwd=self.log.parent, stdout=log, stderr=log)

    def close(self) -> None:
        for process in (*self.workers, self.scheduler):
            process.kill()
            process.wait()


@pytest.fixture(scope="module")
def loopback(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Loopback]:
    """A scheduler, and always two workers."""
    made = Loopback(tmp_path_factory.mktemp("loopback") / "log")
    try:
        yield made
    finally:
        made.close()


@pytest.fixture
def two(loopback: Loopback) -> Loopback:
    """With two workers that are there."""
    from distributed import Client

    loopback.workers = [w for w in loopback.workers if w.poll() is None]
    while len(loopback.workers) < 2:
        loopback.add_worker()
    with Client(loopback.address, timeout=60, set_as_default=False) as client:
        client.wait_for_workers(2, timeout=60)
    return loopback


@pytest.fixture(scope="module")
def inside() -> Iterator[str]:
    """The address of a scheduler and a worker in this process."""
    distributed = pytest.importorskip("distributed")
    options = {"protocol": "tcp", "host": "127.0.0.1", "n_workers": 1, "threads_per_worker": 1, "dashboard_address": None}
    with distributed.LocalCluster(processes=False, **options) as made:
        yield made.scheduler_address


@pytest.fixture
def marked(tmp_path: Path) -> Path:
    folder = tmp_path / "marks"
    folder.mkdir()
    return folder


def when(holds: Callable[[float, str], bool], do: Callable[[], Any]) -> Callable[[float, str], None]:
    """A progress report that does something once, when something holds."""
    done: list[bool] = []

    def report(share: float, what: str) -> None:
        if not done and holds(share, what):
            done.append(True)
            do()

    return report


def stop() -> None:
    raise KeyboardInterrupt


def until(holds: Callable[[], Any], seconds: float = 60.0) -> None:
    end = time.monotonic() + seconds
    while not holds():
        assert time.monotonic() < end
        time.sleep(0.02)


def whole(count: int, folder: Path) -> Any:
    """The result of one process; without its marks."""
    result = ask(TiledSquares(count=count, lasts=0.0), folder)
    for file in folder.iterdir():
        file.unlink()
    return result


def under_way(folder: Path, process: int) -> list[int]:
    """The tiles that a process has begun and not done."""
    done = marks(folder, "done")
    return [number for number, own in marks(folder, "begun") if own == process and (number, own) not in done]


def test_a_worker_finds_what_one_process_finds(inside: str, marked: Path) -> None:
    told: list[tuple[float, str]] = []
    expected = whole(4, marked)
    assert_same(expected, ask(TiledSquares(count=4), marked, scheduler=f"{inside}/", progress=lambda *one: told.append(one)))
    shares = [share for share, _ in told]
    assert shares == sorted(shares) and {what for _, what in told} >= {"squares, 1 worker"}


def test_variants_of_a_comparison_are_tiles(inside: str) -> None:
    of = ["drozdetskaya-2020/r1"], {"study.until": 1.0}, {"drive.slope": [0.0195, 0.039, -1.0]}
    compared = read_comparison(*of)
    assert_same(wucht.compare(*of), ask(compared.spec, compared.subject, scheduler=inside))


def test_after_an_interrupt_another_run_goes_on(inside: str, marked: Path, tmp_path: Path) -> None:
    expected, spec = whole(6, marked), TiledSquares(count=6, lasts=0.05)
    part = ask(spec, marked, folder=tmp_path / "out", scheduler=inside, progress=when(lambda share, _: share > 0.3, stop))
    assert not part.attrs["finished"] and 0 < part.wucht.summary["count"] < 6
    assert_same(expected, ask(spec, marked, folder=tmp_path / "out", resume=True))


@pytest.mark.slow
def test_a_worker_is_killed_in_the_middle(two: Loopback, marked: Path) -> None:
    """What it had under way is computed by the other, and the result is that of one process, to the last bit.

    Tiles from the seventh on wait until the worker is dead: it has one of them under way, and cannot end it.
    """
    expected, victims, lost = whole(14, marked), list[subprocess.Popen[bytes]](), list[int]()
    held = [marked / f"hold {number}" for number in range(6, 14)]
    for hold in held:
        hold.touch()

    def kill() -> None:
        until(lambda: victims.extend(w for w in two.workers if set(under_way(marked, w.pid)) & {*range(6, 14)}) or victims)
        victims[0].kill()
        victims[0].wait()
        lost.extend(under_way(marked, victims[0].pid))
        for hold in held:
            hold.unlink()

    result = ask(TiledSquares(count=14), marked, scheduler=two.address, progress=when(lambda share, _: share > 0.3, kill))
    assert_same(expected, result)
    begun, victim = marks(marked, "begun"), victims[0].pid
    (other,) = (worker.pid for worker in two.workers if worker.pid != victim)
    assert {process for _, process in begun} == {victim, other}, "both have computed"
    assert len(lost) == 1
    times = {number: [p for n, p in begun if n == number] for number in range(14)}
    assert times[lost[0]] == [victim, other]
    assert all(len(t) == 1 for n, t in times.items() if (n, victim) not in begun), "no other's work is done twice"


@pytest.mark.slow
def test_interrupted_the_workers_stop_and_another_run_goes_on(two: Loopback, marked: Path, tmp_path: Path) -> None:
    """Ctrl-C: what is pending is not begun, what is under way is given up; one process computes the rest."""
    expected = whole(12, marked)
    spec = TiledSquares(count=12, lasts=0.3)
    pressed = when(lambda share, _: share > 0.3, stop)
    part = ask(spec, marked, folder=tmp_path / "out", scheduler=two.address, progress=pressed)
    assert not part.attrs["finished"]
    until(lambda: len(marks(marked, "begun")) == len(marks(marked, "done")) + len(marks(marked, "given-up")))
    assert marks(marked, "given-up")
    known, begun = part.wucht.summary["count"], len(marks(marked, "begun"))
    assert 0 < known < 12
    time.sleep(0.5)
    assert len(marks(marked, "begun")) == begun
    result = ask(spec, marked, folder=tmp_path / "out", resume=True)
    assert_same(expected, result)
    assert len(marks(marked, "begun")) == begun + 12 - known
    assert sorted(p.name for p in (tmp_path / "out").iterdir()) == ["result.nc"]


MAIN = """
import sys
from pathlib import Path
sys.path.insert(0, sys.argv[1])
from tiled_squares import TiledSquares
from wucht.studies import memory, runner
TiledSquares.kind, memory._EVERY_S = "tiled-squares", 0.0
spec = TiledSquares(count=12, lasts=float(sys.argv[5]))
runner.run(spec, Path(sys.argv[2]), folder=Path(sys.argv[3]), scheduler=sys.argv[4] or None)
"""


def main(marked: Path, folder: Path, address: str, lasts: float) -> subprocess.Popen[bytes]:
    return subprocess.Popen([sys.executable, "-c", MAIN, str(HERE), str(marked), str(folder), address, str(lasts)])


@pytest.mark.slow
def test_the_main_process_is_killed(two: Loopback, marked: Path, tmp_path: Path) -> None:
    """kill -9: workers give up what nobody waits for, and what was kept is not computed again."""
    expected, out = whole(12, marked), tmp_path / "out"
    process = main(marked, out, two.address, 0.3)
    try:
        until(lambda: len(list(out.glob("units/*.npz"))) > 3)
    finally:
        process.kill()
        process.wait()
    until(lambda: len(marks(marked, "begun")) == len(marks(marked, "done")) + len(marks(marked, "given-up")))
    begun = len(marks(marked, "begun"))
    assert begun < 12
    result = ask(TiledSquares(count=12, lasts=0.3), marked, folder=out, resume=True, scheduler=two.address)
    assert_same(expected, result)
    assert len(marks(marked, "begun")) <= begun + 12 - 3


@pytest.mark.slow
def test_two_runs_at_once_in_one_folder(two: Loopback, marked: Path, tmp_path: Path) -> None:
    """One on the cluster, one in its own process, begun at about the same time; one of them is killed."""
    expected, out = whole(12, marked), tmp_path / "out"
    runs = [main(marked, out, two.address, 0.15), main(marked, out, "", 0.15)]
    try:
        until(lambda: any(p == runs[1].pid for _, p in marks(marked, "done")))
        runs[1].kill()
        assert runs[0].wait(60) == 0
    finally:
        for process in runs:
            process.kill()
            process.wait()
    assert_same(expected, ask(TiledSquares(count=12, lasts=0.15), marked, folder=out, resume=True))
    again = ask(TiledSquares(count=12, lasts=0.15), marked, folder=out)
    assert_same(expected, again)
    assert [p.name for p in out.iterdir()] == ["result.nc"]


# What goes wrong, in sentences


def test_an_error_of_a_task_is_that_error(inside: str, marked: Path) -> None:
    with refusals.refused("study.lasts", given=-1.0) as raised:
        ask(TiledSquares(lasts=-1.0), marked, scheduler=inside)
    assert raised.value.explanation == "must be a time"


@pytest.mark.slow
@pytest.mark.parametrize("differs", ["wucht", "numpy", "code of wucht"])
def test_workers_with_something_else(marked: Path, tmp_path: Path, differs: str) -> None:
    """Another version of wucht, which the scheduler has too, or of a library, or wucht as of another checkout."""
    modules = tmp_path / "modules"
    if differs == "code of wucht":
        shutil.copytree(Path(str(wucht.__file__)).parent, modules / "wucht", ignore=shutil.ignore_patterns("__pycache__"))
        with (modules / "wucht" / "system.py").open("a", encoding="utf-8") as file:
            file.write("# changed\n")
    else:
        metadata = modules / f"{differs}-9.9.dist-info"
        metadata.mkdir(parents=True)
        (metadata / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {differs}\nVersion: 9.9\n", encoding="utf-8")
    made = Loopback(tmp_path / "log", modules)
    is_refused = refusals.refused("--scheduler", "9.9", given=made.address, code="other-version")
    try:
        made.add_worker()
        until(lambda: socket.socket().connect_ex(("127.0.0.1", made.port)) == 0)
        with is_refused if differs == "wucht" else failed("other-versions", differs):
            ask(TiledSquares(), marked, scheduler=made.address)
    finally:
        made.close()
    assert not marks(marked, "begun")


@pytest.mark.slow
def test_the_scheduler_goes_away(marked: Path, tmp_path: Path) -> None:
    """And before that, workers are waited for."""
    made, out = Loopback(tmp_path / "log"), tmp_path / "out"
    try:
        until(lambda: socket.socket().connect_ex(("127.0.0.1", made.port)) == 0)
        came = when(lambda _, what: what == f"squares, waiting for workers at {made.address}", made.add_worker)
        gone = when(lambda share, _: share > 0.3, made.scheduler.kill)

        def report(share: float, what: str) -> None:
            came(share, what)
            gone(share, what)

        with failed("scheduler-gone", made.address):
            ask(TiledSquares(), marked, folder=out, scheduler=made.address, progress=report)
    finally:
        made.close()
    begun = len(marks(marked, "begun"))
    ask(TiledSquares(), marked, folder=out, resume=True)
    assert len(marks(marked, "begun")) < begun + 10


@pytest.mark.parametrize(
    "address",
    ["localhost", "", "a b", "host:0", "http://x:1", "inproc://x", "tcp://:1", "tcp://host", "tcp://[::1", "tcp://host:99999",
     "tcp://host:1//", "tcp://fe80::1:8786"],
)  # fmt: skip
def test_where_no_scheduler_can_be(marked: Path, address: str) -> None:
    check_refusal(f"--scheduler {address}", lambda: ask(TiledSquares(), marked, folder=marked / "out", scheduler=address))
    assert not (marked / "out").exists()


@pytest.mark.parametrize(
    ("address", "code"),
    [("tls://127.0.0.1:1", "unsupported"), pytest.param("tcp://127.0.0.1:1", "no-answer", marks=pytest.mark.slow)],
)
def test_where_no_scheduler_answers(marked: Path, address: str, code: str) -> None:
    with refusals.refused("--scheduler", given=address, code=code):
        ask(TiledSquares(), marked, scheduler=address)


def test_without_dask(marked: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setitem(sys.modules, "distributed", None)
    with refusals.refused("--scheduler", "dask.distributed", "wucht[cluster]", given="tcp://127.0.0.1:1", code="no-extra"):
        ask(TiledSquares(), marked, scheduler="tcp://127.0.0.1:1")


def test_a_study_without_tiles() -> None:
    machine = load_machine("drozdetskaya-2020/r1")
    with refusals.refused("--scheduler", "response", "basin", given="tcp://127.0.0.1:1"):
        ask(Response(), machine, scheduler="tcp://127.0.0.1:1")


# The study that needs it


@pytest.mark.slow
def test_a_map_of_basins_is_the_same(two: Loopback) -> None:
    """With the engine, in two units of the first level and more of the second, by two processes and by one."""
    spec = Basin(axes={name: [0.0, "360 deg", cells] for name, cells in (("b1", 17), ("b2", 16))}, until=0.02, refine=1)
    result = ask(spec, rail())
    assert len(result.wucht.summary["fractions"]) == 2
    assert_same(result, ask(spec, rail(), scheduler=two.address))


def test_the_option_of_the_command(refused: Callable[..., str]) -> None:
    refused("run", "drozdetskaya-2020/figure-5.10", "--scheduler", "here", says=("--scheduler", "such as tcp://host:8786"))
    refused("run", "drozdetskaya-2020/r1", "--scheduler", "tcp://a:1", says=("run-up runs in one process", "basin"))
