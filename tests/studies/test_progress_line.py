"""The line that shows progress in a notebook: it changes, is gone at the end, and is nowhere else."""

from __future__ import annotations

import io
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path

import pytest
from IPython.core.displaypub import CapturingDisplayPublisher
from IPython.core.interactiveshell import InteractiveShell
from tests.studies.tiled_squares import TiledSquares

import wucht


@pytest.fixture
def shell() -> Iterator[InteractiveShell]:
    instance = InteractiveShell.instance()
    instance.display_pub = CapturingDisplayPublisher()
    yield instance
    InteractiveShell.clear_instance()


def test_a_notebook_shows_one_line_that_is_gone_at_the_end(shell: InteractiveShell, tmp_path: Path) -> None:
    shell.kernel = object()
    wucht.run(TiledSquares(count=8, lasts=0.2), tmp_path)
    outputs = shell.display_pub.outputs
    texts = [output["data"]["text/plain"] for output in outputs]
    assert len({output["transient"]["display_id"] for output in outputs}) == 1
    assert [bool(output["update"]) for output in outputs] == [False] + [True] * (len(outputs) - 1)
    assert texts[-1] == "" and len(texts) > 4 and all(": " in text and " %, squares, " in text for text in texts[:-1])
    shares = [float(text.split()[1]) for text in texts[:-1]]
    assert shares == sorted(shares) and 0 < shares[0] < shares[-1] <= 100


def test_what_is_over_in_a_moment_shows_nothing(shell: InteractiveShell, tmp_path: Path) -> None:
    shell.kernel = object()
    wucht.run(TiledSquares(count=2, lasts=0.0), tmp_path)
    assert shell.display_pub.outputs == []


def test_ipython_on_a_terminal_writes_over_its_line(
    shell: InteractiveShell, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    terminal = io.StringIO()
    monkeypatch.setattr(terminal, "isatty", lambda: True)
    monkeypatch.setattr(sys, "stderr", terminal)
    wucht.run(TiledSquares(count=6, lasts=0.2), tmp_path)
    first, *lines = terminal.getvalue().split("\r\033[K")
    assert first == lines[-1] == "" and len(lines) > 2 and shell.display_pub.outputs == []


def test_nothing_is_shown_elsewhere(shell: InteractiveShell, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    wucht.run(TiledSquares(count=4, lasts=0.3), tmp_path)  # IPython whose output is a file
    assert capsys.readouterr() == ("", "")
    script = "import wucht; wucht.run(wucht.RunUp(until=10.0), 'drozdetskaya-2020/r1')"
    assert subprocess.run([sys.executable, "-c", script], capture_output=True, check=True).stderr == b""
