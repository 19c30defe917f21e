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


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.4, "0.4 s"), (9.0, "9.0 s"), (89.0, "89 s"), (91.0, "1.5 min"), (252.0, "4.2 min"), (5399.0, "90 min"),
        (5401.0, "1.5 h"), (129_000.0, "36 h"), (130_000.0, "1.5 days"), (3e7, "347 days"),
    ],
)  # fmt: skip
def test_a_duration_has_the_unit_that_suits_it(seconds: float, words: str) -> None:
    assert progress.duration_in_words(seconds) == words


@pytest.mark.parametrize(("share", "remaining"), [(0.033, None), (0.032, 60.5)])
def test_a_run_of_more_than_a_minute_is_announced(share: float, remaining: float | None) -> None:
    """After two seconds of its pace: 3.3 % of them are a minute in all."""
    forecast = progress.Forecast()
    assert forecast.remaining(1.0, 0.0) is None
    assert forecast.remaining(2.9, share) is None, "too early"
    assert forecast.remaining(3.0, share) == (None if remaining is None else pytest.approx(remaining, rel=1e-2))


@pytest.mark.parametrize(("share", "is_news"), [(0.0408, False), (0.0402, True)])
def test_a_run_is_announced_again_if_it_takes_twice_as_long(share: float, is_news: bool) -> None:
    """98 s to go after 2 s are 94 s after 6 s: 188 s are twice as much, at a pace of 0.0204 in 4 s."""
    forecast = progress.Forecast()
    assert forecast.remaining(0.0, 0.0) is None
    assert forecast.remaining(2.0, 0.02) == pytest.approx(98.0)
    assert forecast.remaining(5.9, share) is None, "too early: twice as long as the first time"
    assert (forecast.remaining(6.0, share) is not None) == is_news


def test_a_share_that_falls_begins_anew() -> None:
    forecast = progress.Forecast()
    assert forecast.remaining(0.0, 0.5) is None
    assert forecast.remaining(10.0, 0.1) is None
    assert forecast.remaining(12.0, 0.11) == pytest.approx(178.0)


def test_what_a_run_will_take_is_a_line_of_its_own(monkeypatch: pytest.MonkeyPatch) -> None:
    made, written = shown(monkeypatch, 1.0)
    with made:
        made.update(0.0, "1 of 9")
        now = progress.time.perf_counter() + 2.0
        monkeypatch.setattr(progress.time, "perf_counter", lambda: now)
        made.update(0.01, "1 of 9")
        made.announce("its equations take 12 s")
    made.announce("nothing more")
    assert written.getvalue() == (
        "running fan.toml ...\nfan.toml: up to about 3.3 min to go, at the pace so far\nfan.toml: its equations take 12 s\n"
    )


def test_on_a_terminal_it_stays_above_the_line_that_moves(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("COLUMNS", "200")
    with progress.Progress("a[/b].toml") as made:
        made.announce("its equations take [12] s")
    assert "a[/b].toml: its equations take [12] s" in terminal.getvalue()
