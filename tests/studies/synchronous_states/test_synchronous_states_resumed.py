"""Units of work of ``synchronous-states``: a study that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
from test_synchronous_states import MOTOR, machine

from interrupting import assert_same, stop_at
from wucht import SynchronousStates, draw, report, run

AXES = {"speed": (20.0, 130.0, 100), "ratio": (0.2, 3.2, 81)}  # three units of work: 40 rows, 40 rows and 1
QUESTION = SynchronousStates(axes=AXES)


@pytest.mark.slow
@pytest.mark.parametrize("unbalances", [(0.012, 0.008), (0.006, 0.006, 0.006)], ids=["pair", "family"])
def test_resumed_is_uninterrupted(unbalances: tuple[float, ...], tmp_path: Path) -> None:
    """Stopped again and again; states that were found are not searched again. What is not known yet says so."""
    m, reports = machine(*unbalances, drive=MOTOR), list[tuple[float, str]]()
    whole = run(QUESTION, m, progress=lambda *one: reports.append(one))
    shares = [share for share, _ in reports]
    assert whole.attrs["finished"] == 1 and shares == sorted(shares) and reports[0][1] == "searching"
    first = run(QUESTION, m, folder=tmp_path, progress=stop_at(3, "multipliers of"))
    states, found = first.wucht.summary["states"], whole.wucht.summary["states"]
    assert 0 < sum(state["stable_full"] is None for state in states) < len(states) == len(found)
    for state, other in zip(states, found, strict=True):
        assert (state["phases"], state["growth_slow"]) == (other["phases"], other["growth_slow"])
        assert state["stable_full"] in (None, other["stable_full"])
    draw(first)
    assert any("not computed yet" in line for line in report(first))
    for call, rows in ((1, 0), (2, 40), (3, 80)):
        words, stop = list[str](), stop_at(call, "the map")

        def note(share: float, what: str, words: list[str] = words, stop: Any = stop) -> None:
            words.append(what)
            stop(share, what)

        result = run(QUESTION, m, folder=tmp_path, resume=True, progress=note)
        assert not result.attrs["finished"] and "searching" not in words and (tmp_path / "units").exists()
        assert f"{rows} of 81 rows of the map are computed" in result.wucht.warnings
        if rows:
            assert np.array_equal(result.map_stable.values, whole.map_stable.values[:, :rows])
            assert np.array_equal(result.map_ratio.values, whole.map_ratio.values[:rows])
        draw(result)
    assert_same(whole, run(QUESTION, m, folder=tmp_path, resume=True))
    assert not (tmp_path / "units").exists()


@pytest.mark.parametrize("count", [1, 5])
def test_stopped_while_searching(count: int, tmp_path: Path) -> None:
    """Nothing is known then: there is no result, and what is resumed searches anew."""
    m, question = machine(0.012, 0.008, drive=MOTOR), SynchronousStates(full=False)
    with pytest.raises(KeyboardInterrupt):
        run(question, m, folder=tmp_path, progress=stop_at(count))
    assert_same(run(question, m), run(question, m, folder=tmp_path, resume=True))


@pytest.mark.slow
def test_units_join_to_the_whole_map() -> None:
    """Each third row of three units is a row of a map that is one unit."""
    m = machine(0.004, 0.004, 0.004, drive=MOTOR)
    cut = run(SynchronousStates(axes=AXES, full=False), m)
    whole = run(SynchronousStates(axes=AXES | {"ratio": (0.2, 3.2, 27)}, full=False), m)
    assert whole.map_stable.values.any() and cut.map_ratio.values[1::3] == pytest.approx(whole.map_ratio.values)
    for name in ("map_stable", "map_exists"):
        assert np.array_equal(cut[name].values[:, 1::3], whole[name].values), name
