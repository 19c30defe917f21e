"""Units of work of ``capture-probability``: one that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

from pathlib import Path

import pytest

from interrupting import assert_same, stop_at
from known_borders import KEYS, SPEED, machine
from wucht import CaptureProbability, draw, report, run

RANDOM = {"drum": SPEED["drum"] | {"angle": {"uniform": [0.0, 6.0]}}}
QUESTION = CaptureProbability(
    **KEYS | {"range": [0.005, 0.02], "random": RANDOM}, probability=0.6, sensitivity=True, at=0.006, sensitivity_samples=64
)


@pytest.mark.slow
def test_resumed_is_uninterrupted(tmp_path: Path) -> None:
    """Stopped where the second and the third value begin, and in the search."""
    for begun in ("drive.slope = 0.0125", "drive.slope = 0.02", "drive.slope = 0.006"):
        part = run(QUESTION, machine(), folder=tmp_path, resume=True, progress=stop_at(1, during=begun))
        assert not part.attrs["finished"]
    whole = run(QUESTION, machine())
    assert whole.wucht.summary["searched"] > 3
    assert_same(whole, run(QUESTION, machine(), folder=tmp_path, resume=True))


def test_progress_is_by_the_number_of_runs() -> None:
    """192 at the values; the search, whose length is not known, two fifths of them; 256 of the sensitivity."""
    reports: list[tuple[float, str]] = []
    run(QUESTION, machine(), progress=lambda share, what: reports.append((share, what)))
    shares = [share for share, _ in reports]
    assert shares == sorted(shares) and shares[-1] == 1.0
    ends = {what: max(share for share, label in reports if label == what) for _, what in reports}
    total = 192 * 1.4 + 256
    assert ends["drive.slope = 0.005"] == pytest.approx(64 / total)
    assert ends["drive.slope = 0.02"] == pytest.approx(192 / total)
    assert min(share for share, what in reports if what == "drive.slope = 0.006") >= 192 * 1.4 / total - 1e-9


def test_stopped_on_the_way_nothing_is_called_the_smallest(tmp_path: Path) -> None:
    """After the second of three values."""
    result = run(QUESTION, machine(), folder=tmp_path, progress=stop_at(2, during="drive.slope = 0.02"))
    assert result.parameter.values.tolist() == [0.005, 0.0125]
    s = result.wucht.summary
    assert s["smallest"] is None
    assert (s["values"], s["searched"]) == ([2, 3], 0)
    assert any(w.startswith("1 of the 3 values of ") for w in result.wucht.warnings)
    assert report(result) and draw(result).axes
    reports: list[str] = []
    run(QUESTION, machine(), folder=tmp_path, resume=True, progress=lambda _, what: reports.append(what))
    assert reports.count("drive.slope = 0.0125") == 1 < reports.count("drive.slope = 0.02"), "what is complete is not run again"
