"""Who can connect to a scheduler and its workers that are started as the page on several machines says."""

from __future__ import annotations

import re
import shlex
import shutil
import subprocess
import sys
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager
from importlib.util import find_spec
from pathlib import Path

import pytest
from tests.refusals import refused
from tests.studies.test_cluster import free_port, until

from wucht.studies.cluster import cluster_at

pytestmark = [
    pytest.mark.skipif(find_spec("distributed") is None, reason="distributed is not installed"),
    pytest.mark.skipif(sys.platform != "linux", reason="sockets of a process are read from /proc"),
]
PAGE = Path(__file__).parents[2] / "docs" / "several-machines.md"
LOOPBACK = {"0100007F", "0" * 24 + "01000000"}  # 127.0.0.1 and ::1, as the kernel prints them
TLS = {name: f"DASK_DISTRIBUTED__COMM__TLS__{name}" for name in ("CA_FILE", "CLIENT__CERT", "CLIENT__KEY")}


def documented(beginning: str) -> list[str]:
    """The words of the one command of the page that begins so."""
    (line,) = re.findall(rf"^{re.escape(beginning)}.*$", PAGE.read_text(encoding="utf-8"), re.MULTILINE)
    return shlex.split(line, comments=True)


@contextmanager
def started(folder: Path, words: list[str], *, replaced: dict[str, str]) -> Iterator[subprocess.Popen[bytes]]:
    """A command of Dask while the block lasts, with other words, as ports of this machine may be in use."""
    changed = [_replaced(word, replaced) for word in words]
    with (folder / "log").open("ab") as log:
        process = subprocess.Popen([sys.executable, "-m", *changed], cwd=folder, stdout=log, stderr=log)
    try:
        yield process
    finally:
        process.kill()
        process.wait()


def _replaced(text: str, changes: dict[str, str]) -> str:
    for before, after in changes.items():
        text = text.replace(before, after)
    return text


def listening(process: int) -> set[str]:
    """The addresses at which a process listens, as the kernel prints them."""
    sockets = {str(link.readlink()) for link in Path(f"/proc/{process}/fd").iterdir() if link.is_symlink()}
    rows = [row.split() for name in ("tcp", "tcp6") for row in Path(f"/proc/{process}/net/{name}").read_text().splitlines()[1:]]
    return {row[1].partition(":")[0] for row in rows if row[3] == "0A" and f"socket:[{row[9]}]" in sockets}


def threads(address: str) -> int:
    """Threads of the workers of a scheduler; 0 if it does not answer yet."""
    from distributed import Client

    try:
        with Client(address, timeout=2, set_as_default=False) as client:
            return sum(client.nthreads().values())
    except OSError:
        return 0


@pytest.mark.slow
def test_on_one_machine_only_programs_of_this_machine_can_connect(tmp_path: Path) -> None:
    port = {"8786": str(free_port()), "8787": str(free_port())}
    address, beginnings = f"tcp://127.0.0.1:{port['8786']}", ("dask scheduler --host 127", "dask worker tcp://127")
    with ExitStack() as stack:
        scheduler_words, worker_words = map(documented, beginnings)
        scheduler = stack.enter_context(started(tmp_path, [*scheduler_words, "--port", port["8786"]], replaced=port))
        worker = stack.enter_context(started(tmp_path, worker_words, replaced=port))
        until(lambda: threads(address) == 1)
        assert listening(scheduler.pid)
        assert listening(worker.pid)
        assert listening(scheduler.pid) | listening(worker.pid) <= LOOPBACK
        open_worker = stack.enter_context(started(tmp_path, ["dask", "worker", address, "--no-nanny"], replaced={}))
        until(
            lambda: listening(open_worker.pid) - LOOPBACK
        )  # without those options it listens everywhere: so the test can fail


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("openssl") is None, reason="certificates are made by OpenSSL")
def test_by_tls_nobody_connects_without_a_certificate(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Neither without one, nor without encryption, nor with one of another authority; with the right one it computes."""
    for name in (".", "other"):
        (tmp_path / name).mkdir(exist_ok=True)
        subprocess.run(documented("openssl req"), cwd=tmp_path / name, check=True, capture_output=True)
    assert (tmp_path / "key.pem").stat().st_mode & 0o077 == 0
    port = str(free_port())
    place = {"tls://0.0.0.0": "tls://127.0.0.1", "tls://host:8786": f"tls://127.0.0.1:{port}", "8787": str(free_port())}
    address, plain = f"tls://127.0.0.1:{port}", f"tcp://127.0.0.1:{port}"

    def certify(folder: Path) -> None:
        import dask

        files = dict(zip(TLS, ("cert.pem", "cert.pem", "key.pem"), strict=True))
        for name, file in files.items():
            monkeypatch.setenv(TLS[name], str(folder / file))
        dask.config.refresh()

    with ExitStack() as stack:
        words = [*documented("dask scheduler --host tls"), "--port", port]
        stack.enter_context(started(tmp_path, words, replaced=place))
        words = [*documented("dask worker tls"), "--host", "127.0.0.1"]
        stack.enter_context(started(tmp_path, words, replaced=place))
        certify(tmp_path)
        until(lambda: threads(address) == 1)
        with cluster_at(address) as cluster:
            assert cluster is not None
            assert dict(cluster.compute({"a": callable}, lambda _share, _text: None)) == {"a": True}
        with refused("--scheduler", "no scheduler answers there", given=plain, code="no-answer"), cluster_at(plain):
            pass
        certify(tmp_path / "other")
        with refused("--scheduler", "no scheduler answers there", given=address, code="no-answer"), cluster_at(address):
            pass
        for name in TLS.values():
            monkeypatch.delenv(name)
        import dask

        dask.config.refresh()
        with refused("--scheduler", "not configured here", given=address, code="unsupported"), cluster_at(address):
            pass
