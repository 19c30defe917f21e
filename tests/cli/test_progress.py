"""The line that moves on a terminal."""

from __future__ import annotations

import io
import sys
import time

import pytest

from wucht.cli import progress
from wucht.dynamics.work import PREPARATION, LeastShare


def shown(monkeypatch: pytest.MonkeyPatch, passed: float) -> tuple[progress.Progress, io.StringIO]:
    """Progress of a run that began so many seconds ago, and what is written where nobody looks."""
    written = io.StringIO()
    monkeypatch.setattr(sys, "stderr", written)
    now = [100.0]
    monkeypatch.setattr(time, "perf_counter", lambda: now[0])
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


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (0.4, "0.4 s"),
        (89.0, "89 s"),
        (91.0, "1.5 min"),
        (5399.0, "90 min"),
        (5401.0, "1.5 h"),
        (130_000.0, "1.5 days"),
        (3e7, "347 days"),
    ],
)
def test_a_duration_has_the_unit_that_suits_it(seconds: float, words: str) -> None:
    assert progress.duration_in_words(seconds) == words


def first_remaining(forecast: progress.Forecast, *reports: tuple[float, float]) -> tuple[float, float] | None:
    """The time of the first report at which something is announced, and the remaining seconds."""
    answers = [(time, forecast.remaining(time, share)) for time, share in reports]
    return next(((time, remaining) for time, remaining in answers if remaining is not None), None)


@pytest.mark.parametrize(("step", "remaining"), [(0.0083, None), (0.008, 61.0)])
def test_a_run_of_more_than_a_minute_is_announced(step: float, remaining: float | None) -> None:
    """After one second of even steps of half a second: 1.66 % of them are a minute in all."""
    expected = None if remaining is None else (2.0, pytest.approx(remaining, rel=1e-2))
    assert first_remaining(progress.Forecast(), (1.0, 0.0), (1.5, step), (2.0, 2 * step), (2.5, 3 * step)) == expected


@pytest.mark.parametrize(("share", "is_news"), [(0.0406, False), (0.0401, True)])
def test_a_run_is_announced_again_if_it_takes_twice_as_long(share: float, is_news: bool) -> None:
    """98 s to go after 1 s are 96 s after 3 s: 192 s are twice as much, at a pace of 0.0204 in 4 s."""
    forecast = progress.Forecast()
    assert first_remaining(forecast, (0.0, 0.0), (0.5, 0.005), (1.0, 0.01)) == (1.0, pytest.approx(99.0))
    gain = share / 2 - 0.01
    again = first_remaining(forecast, (2.0, 0.01 + gain / 2), (2.9, 0.01 + 0.95 * gain), (3.0, 0.01 + gain))
    assert (again is not None and again[0] == 3.0) == is_news, "not before twice the time of the first part"


@pytest.mark.parametrize("slow", [0, 1, 2])
def test_what_is_done_but_once_is_not_taken_for_the_pace(slow: int) -> None:
    """A run of 6 s, one of whose first steps takes 2 s more, as on a slow computer that loads code: nothing is announced."""
    times = [0.0, 0.01, 0.02, 0.03, *(0.05 * k for k in range(1, 120))]
    reports = [(time + 2.0 * (k > slow), time / 6.0) for k, time in enumerate(times)]
    assert first_remaining(progress.Forecast(), *reports) is None


def test_a_false_alarm_is_corrected() -> None:
    """A first step of a minute is 0.1 % of a run that then takes 1 % in 0.05 s."""
    forecast = progress.Forecast()
    assert first_remaining(forecast, (0.0, 0.0), (60.0, 0.001)) == (60.0, pytest.approx(60 * 999.0))
    later = [(60.0 + 0.05 * k, 0.001 + 0.01 * k) for k in range(1, 60)]
    assert first_remaining(forecast, *later) == (62.0, pytest.approx(3.0, rel=0.01))


def short_study(slower: float = 1.0) -> list[tuple[float, float]]:
    """Reports of a study of 12 units of 0.8 s, whose equations take 5 s: within a unit shares are those of the longest runs."""
    reports, time = [(0.0, 0.0)], 5.0
    for k in range(12):
        reports += [(time + 0.1 * slower * j, LeastShare((k + 4e-5 * j) / 12)) for j in range(8)]
        time += 0.8 * slower
        reports.append((time, (k + 1) / 12))
    return reports


def test_a_short_study_is_not_announced_as_one_of_hours() -> None:
    assert first_remaining(progress.Forecast(), *short_study()) is None
    measured = [(time, float(share)) for time, share in short_study(1.0)]
    announced = first_remaining(progress.Forecast(), *measured)
    assert announced is not None and announced[1] > 3600, "as if what is done of a unit were its pace"


def test_a_long_study_is_announced_after_its_second_unit() -> None:
    """Units of 8 s: the first one takes 13 s, with its equations."""
    assert first_remaining(progress.Forecast(), *short_study(10.0)) == (21.0, pytest.approx(80.0))


@pytest.mark.parametrize(("label", "lines"), [(PREPARATION, 1), ("settling", 2)])
def test_a_preparation_is_shown_without_a_forecast(monkeypatch: pytest.MonkeyPatch, label: str, lines: int) -> None:
    made, written = shown(monkeypatch, 1.0)
    with made:
        begin = time.perf_counter()
        made.update(0.0, label)
        monkeypatch.setattr(time, "perf_counter", lambda: begin + 70.0)
        made.update(0.001, "settling")
    assert len(written.getvalue().splitlines()) == lines


class Terminal(io.StringIO):
    """A stream that says that someone looks."""

    def isatty(self) -> bool:
        return True


def test_names_are_shown_as_they_are(monkeypatch: pytest.MonkeyPatch) -> None:
    """Brackets are no markup, and what a name has of control characters does not reach the terminal."""
    terminal = Terminal()
    monkeypatch.setattr(sys, "stderr", terminal)
    monkeypatch.setenv("COLUMNS", "200")
    with progress.Progress("a[/b]\x1b[41m.toml") as made:
        time.sleep(0.6)
        made.update(0.5, "[red] 3 of 6")
        made.announce("its equations take [12] s")
    made.announce("nothing more")
    said = terminal.getvalue()
    assert "a[/b]?[41m.toml: [red] 3 of 6" in said and "a[/b]?[41m.toml: its equations take [12] s" in said
    assert "nothing more" not in said
