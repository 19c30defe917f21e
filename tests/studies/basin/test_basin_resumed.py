"""Units of work of ``basin``: a study that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from pathlib import Path

import numpy as np
import pytest
import xarray as xr

from interrupting import assert_same
from known_borders import machine, rail
from wucht import Basin
from wucht.studies.runner import draw, report, run

TURN = [0.0, "360 deg"]
QUESTION = Basin(axes={"b1": [*TURN, 17], "b2": [*TURN, 16]}, until=0.002, refine=1)  # 256 runs are a unit


def stop_beyond(share: float) -> Callable[[float, str], None]:
    """A progress report that interrupts a study when more than a share is done."""

    def report(done: float, _what: str) -> None:
        if done > share + 1e-9:
            raise KeyboardInterrupt

    return report


@cache
def whole() -> xr.Dataset:
    return run(QUESTION, rail())


@pytest.mark.slow
def test_resumed_is_uninterrupted(tmp_path: Path) -> None:
    """Stopped in each unit of both levels: what is not computed is missing, what is complete is not run again."""

    def stopped(share: float) -> xr.Dataset:
        result = run(QUESTION, rail(), folder=tmp_path, resume=True, progress=stop_beyond(share))
        assert not result.attrs["finished"] and report(result)
        return result

    # After the first of two units of the coarsest map, which has two thirds of the work.
    result = stopped(1 / 3)
    known = result.outcome.values >= 0
    assert known.ravel()[:256].all() and not known.ravel()[256:].any()
    assert np.array_equal(result.outcome.values[known], whole().outcome.values[known])
    assert np.isnan(result.settling_time.values[~known]).all() and np.isnan(result.end_time.values[~known]).all()
    s = result.wucht.summary
    assert s["missing"] == pytest.approx(16 / 272) and s["runs"] == 256
    assert sum(s["fractions"].values()) == pytest.approx(256 / 272)
    assert result.wucht.warnings[0].startswith("16 of the 272 cells of the map are not computed")
    # Before the first unit of the finer level; then on it: what was not halved stands, what was to be run is missing.
    result = stopped(2 / 3)
    assert result.wucht.warnings[0] == "the borders are refined 0 of 1 times" and "refined_level" not in result
    assert np.array_equal(result.outcome.values, whole().outcome.values)
    result = stopped(0.9)
    assert draw(result).axes
    refined, levels = result.refined_outcome.values, result.refined_level.values
    assert 0 < (refined < 0).sum() < refined.size / 2 and np.array_equal(refined < 0, levels < 0)
    assert np.array_equal(refined[refined >= 0], whole().refined_outcome.values[refined >= 0])
    assert np.array_equal(result.outcome.values, whole().outcome.values)
    assert not any("refined" in w for w in result.wucht.warnings + whole().wucht.warnings)
    reports: list[float] = []
    assert_same(whole(), run(QUESTION, rail(), folder=tmp_path, resume=True, progress=lambda share, _: reports.append(share)))
    assert reports[0] == pytest.approx(1 / 3) and not (tmp_path / "units").exists()


def test_each_level_has_its_share_of_the_work() -> None:
    """A border that is halved twice has twice as many cells as one that is halved once."""
    reports: list[tuple[float, str]] = []
    axes = {"drum.speed": [97.0, 107.0, 6], "drive.slope": [0.004, 0.007, 4]}
    question = Basin(axes=axes, model="slow", until=100.0, refine=2)
    run(question, machine(), progress=lambda share, what: reports.append((share, what)))
    shares = [share for share, _ in reports]
    assert shares == sorted(shares) and shares[-1] == 1.0
    begin = {what: min(share for share, label in reports if label == what) for _, what in reports}
    assert begin["borders, level 1 of 2"] == pytest.approx(0.4) and begin["borders, level 2 of 2"] == pytest.approx(0.6)
