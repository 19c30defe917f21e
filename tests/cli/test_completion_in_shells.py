"""Completion where Tab is pressed: in zsh, at a terminal, and in fish, where these are installed."""

from __future__ import annotations

import os
import pty
import select
import shutil
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

Study = Callable[..., Path]
R1 = "wucht run drozdetskaya-2020/r1"
LINES = {
    f"{R1} --set dri": ["drive.no_load_speed=", "drive.slope="],
    f"{R1} --set=dri": ["--set=drive.no_load_speed=", "--set=drive.slope="],
    f'{R1} --set "dri': ["drive.no_load_speed=", "drive.slope="],
    "~/wucht run practice/scr": ["practice/screen", "practice/screen-loaded", "practice/screen-unsynchronised"],
}
PROGRAM = Path(sys.executable).with_name("wucht")
_WAIT = 30.0  # seconds
_NO_LINE = "\x15"  # Ctrl-U


def _environment(here: Path) -> dict[str, str]:
    (here / "wucht").symlink_to(PROGRAM)
    return {**os.environ, "HOME": str(here), "PATH": f"{PROGRAM.parent}:{os.environ['PATH']}", "TERM": "dumb", "COLUMNS": "200"}


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("fish") is None, reason="fish is not installed")
def test_in_fish(here: Path, study: Study) -> None:
    environment = _environment(here)
    study(name="my study.toml")
    ask = "wucht completion fish | source; complete -C $argv[1]"
    for line, expected in (LINES | {"wucht run my\\ st": ["my study.toml"]}).items():
        done = subprocess.run(["fish", "-c", ask, line], capture_output=True, text=True, check=True, env=environment)
        assert done.stdout.splitlines() == expected, line


@pytest.mark.slow
@pytest.mark.skipif(shutil.which("zsh") is None, reason="zsh is not installed")
def test_in_zsh(here: Path, study: Study) -> None:
    environment = _environment(here)
    study(name="my study.toml")
    begin = "unset zle_bracketed_paste; autoload -Uz compinit; compinit -D -u"
    with _Terminal(["zsh", "-f", "-i"], environment) as terminal:
        terminal.type(f'{begin}; eval "$(wucht completion zsh)"; echo set"-"up\n', "set-up")
        for line, expected in LINES.items():
            shown = terminal.type(f"{_NO_LINE}{line}\t\t", expected[-1])
            assert all(word in shown for word in expected), line
        shown = terminal.type(f"{_NO_LINE}wucht run my\\ st\t", ".toml")
        assert "my\\ study.toml" in shown, "quoted as the shell reads it"


class _Terminal:
    """A shell at a terminal of its own."""

    def __init__(self, command: list[str], environment: dict[str, str]) -> None:
        ours, theirs = pty.openpty()
        self._shell = subprocess.Popen(
            command, stdin=theirs, stdout=theirs, stderr=theirs, env=environment, start_new_session=True
        )
        os.close(theirs)
        self._terminal = ours

    def __enter__(self) -> _Terminal:
        return self

    def __exit__(self, *_: object) -> None:
        self._shell.kill()
        self._shell.wait()
        os.close(self._terminal)

    def type(self, keys: str, until: str) -> str:
        """Press keys; what is shown, as soon as a text is among it. Fails where it does not come."""
        os.write(self._terminal, keys.encode())
        shown, end = "", time.monotonic() + _WAIT
        while until not in shown and time.monotonic() < end:
            if select.select([self._terminal], [], [], 0.1)[0]:
                shown += os.read(self._terminal, 65536).decode(errors="replace")
        assert until in shown, f"{keys!r}: {shown!r}"
        return shown
