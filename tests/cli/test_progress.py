"""The line that moves on a terminal."""

from __future__ import annotations

import io
import sys

import pytest

from wucht.cli import progress


class Terminal(io.StringIO):
    """A stream that says that someone looks."""

    def isatty(self) -> bool:
        return True


def test_names_are_shown_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Brackets are no markup, and what a name has of control characters does not reach the terminal."""
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setattr(progress, "_PATIENCE_S", 0.0)
    monkeypatch.setenv("COLUMNS", "200")
    with progress.Progress("a[/b]\x1b[41m.toml") as shown:
        shown.update(0.5, "[red] 3 of 6")
    said = terminal.getvalue()
    assert "a[/b]?[41m.toml" in said
    assert "a[/b]?[41m.toml: [red] 3 of 6" in said
