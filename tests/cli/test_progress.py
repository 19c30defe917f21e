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


def shown(monkeypatch: pytest.MonkeyPatch, passed: float, silence: float = 60.0) -> tuple[progress.Progress, io.StringIO]:
    """Progress of a run that began so many seconds ago, and what is written where nobody looks."""
    written = io.StringIO()
    monkeypatch.setattr(sys, "stderr", written)
    monkeypatch.setattr(progress, "_SILENCE_S", silence)
    monkeypatch.setattr(progress, "_PATIENCE_S", 0.5)
    now = [100.0]
    monkeypatch.setattr(progress.time, "perf_counter", lambda: now[0])
    made = progress.Progress("fan.toml")
    now[0] += passed
    return made, written


@pytest.mark.parametrize(("passed", "lines"), [(0.4, ""), (0.6, "running fan.toml ...\n")])
def test_a_run_of_a_moment_says_nothing_and_a_longer_one_a_single_line(
    monkeypatch: pytest.MonkeyPatch, passed: float, lines: str
) -> None:
    made, written = shown(monkeypatch, passed)
    with made:
        made.update(0.1, "1 of 9")
        made.update(0.2, "2 of 9")
    made.update(1.0, "9 of 9")
    assert written.getvalue() == lines


def test_a_run_without_anything_to_report_gives_a_sign_of_life(monkeypatch: pytest.MonkeyPatch) -> None:
    made, written = shown(monkeypatch, 0.0, silence=0.01)
    with made:
        made._alarm.join(5.0)
    assert written.getvalue() == "running fan.toml ...\n"


def test_nothing_is_said_after_the_end(monkeypatch: pytest.MonkeyPatch) -> None:
    made, written = shown(monkeypatch, 9.0)
    with made:
        pass
    made.update(1.0, "9 of 9")
    assert written.getvalue() == ""
