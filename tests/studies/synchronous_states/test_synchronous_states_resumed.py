"""Units of work of ``synchronous-states``: a study that is stopped and resumed ends as one that was not, to the last bit."""

from __future__ import annotations

import math
from collections import Counter
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from interrupting import assert_same, stop_at
from wucht import Machine, SynchronousStates, draw, report
from wucht import run as ask
from wucht.analysis.configurations.full_stability import FullStability
from wucht.files.building import machine_from
from wucht.studies.synchronous_states import study as running

AXES = {"speed": (20.0, 130.0, 12), "ratio": (0.2, 3.2, 9)}
QUESTION = SynchronousStates(axes=AXES)


def machine(*unbalances: float) -> Machine:
    ball = {"kind": "pendulum", "about": "drum", "length": 0.5, "damping": 0.02}
    return machine_from({
        "carrier": {"mass": 2.0, "stiffness": [1e4, 2e4], "damping": [40.0, 60.0]},
        "bodies": [
            {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2},
            *(ball | {"name": f"b{k}", "mass": u / 0.5} for k, u in enumerate(unbalances)),
        ],
        "drive": {"kind": "linear", "slope": 0.5, "no_load_speed": 110.0},
    })  # fmt: skip


@pytest.fixture
def small_tiles(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "_CELLS", 12)


@pytest.fixture
def computed(monkeypatch: pytest.MonkeyPatch) -> Counter[str]:
    """How often each kind of work is done."""
    count: Counter[str] = Counter()

    def counting(owner: Any, name: str) -> None:
        function = getattr(owner, name)

        def counted(*values: Any) -> Any:
            count[name] += 1
            return function(*values)

        monkeypatch.setattr(owner, name, counted)

    counting(running, "all_states")
    counting(running, "regions")
    counting(FullStability, "stability")
    return count


@pytest.mark.slow
@pytest.mark.usefixtures("small_tiles")
@pytest.mark.parametrize(
    "unbalances", [pytest.param((0.012, 0.008), marks=pytest.mark.slow), (0.006, 0.006, 0.006)], ids=["pair", "family"]
)
def test_resumed_is_uninterrupted(unbalances: tuple[float, ...], tmp_path: Path, computed: Counter[str]) -> None:
    """Stopped again and again, a few reports further each time; no unit that was finished is computed twice."""
    m, reports = machine(*unbalances), list[tuple[float, str]]()
    whole = ask(QUESTION, m, progress=lambda share, what: reports.append((share, what)))
    assert whole.attrs["finished"] == 1
    shares, searching = [s for s, _ in reports], sum(what == "searching" for _, what in reports)
    assert shares == sorted(shares)
    assert searching > 1
    once = dict(computed)
    assert once["regions"] == 5
    computed.clear()
    result = ask(QUESTION, m, folder=tmp_path, progress=stop_at(searching + 2))
    assert not result.attrs["finished"]
    for count in range(4, len(shares) - searching + 5, 3):
        result = ask(QUESTION, m, folder=tmp_path, resume=True, progress=stop_at(count))
        if result.attrs["finished"]:
            break
        assert "interrupted" in result.attrs["warnings"]
        assert (tmp_path / "units").exists()
    assert result.attrs["finished"]
    assert_same(whole, result)
    assert not (tmp_path / "units").exists()
    assert computed == once


@pytest.mark.slow
def test_states_that_are_not_computed_yet_say_so(tmp_path: Path) -> None:
    """After two of six states: all stand in the result, as the averaged equations have them."""
    m = machine(0.012, 0.008)
    whole = ask(SynchronousStates(), m).wucht.summary["states"]
    result = ask(SynchronousStates(), m, folder=tmp_path, progress=stop_at(3, "multipliers"))
    assert result.attrs["finished"] == 0
    states = result.wucht.summary["states"]
    assert len(states) == len(whole)
    waiting = [s for s in states if s["stable_full"] is None]
    assert len(waiting) == len(states) - 2
    assert {s["why"] for s in waiting} == {"its multipliers are not computed yet"}
    for state, other in zip(states, whole, strict=True):
        assert state["phases"] == other["phases"]
        assert state["growth_slow"] == other["growth_slow"]
        assert state["stable_full"] in (None, other["stable_full"])
    draw(result)
    assert any("not computed yet" in line for line in report(result))


@pytest.mark.slow
@pytest.mark.usefixtures("small_tiles")
def test_a_map_that_is_not_complete_says_so(tmp_path: Path) -> None:
    """Its lower rows are those of the whole map, and can be drawn."""
    m, question = machine(0.012, 0.008), SynchronousStates(axes=AXES, full=False)
    whole = ask(question, m)
    result = ask(question, m, folder=tmp_path, progress=stop_at(3, "the map"))
    assert "4 of 9 rows of the map are computed" in result.wucht.warnings
    assert np.array_equal(result.map_stable.values, whole.map_stable.values[:, :4])
    assert np.array_equal(result.map_ratio.values, whole.map_ratio.values[:4])
    draw(result)
    none = ask(question, m, folder=tmp_path, progress=stop_at(1, "the map"))
    assert "0 of 9 rows of the map are computed" in none.wucht.warnings
    assert "map_stable" not in none
    draw(none)


@pytest.mark.parametrize("count", [1, 5])
def test_stopped_while_searching(count: int, tmp_path: Path) -> None:
    """Nothing is known then: there is no result, and what is resumed searches anew."""
    m, question = machine(0.012, 0.008), SynchronousStates(full=False)
    with pytest.raises(KeyboardInterrupt):
        ask(question, m, folder=tmp_path, progress=stop_at(count))
    assert_same(ask(question, m), ask(question, m, folder=tmp_path, resume=True))


def test_tiles_join_to_the_whole_map(monkeypatch: pytest.MonkeyPatch, computed: Counter[str]) -> None:
    """However the rows are cut."""
    m, question = machine(0.004, 0.004, 0.004), SynchronousStates(axes=AXES, full=False)
    whole = ask(question, m)
    assert whole.map_stable.values.any()
    monkeypatch.setattr(running, "_CELLS", 1)
    cut, rows = ask(question, m), AXES["ratio"][2]
    assert computed["regions"] == 1 + math.ceil(rows / 2), "one tile, then one for every two rows, the fewest"
    for name in ("map_stable", "map_exists", "map_speed", "map_ratio"):
        assert np.array_equal(cut[name].values, whole[name].values), name
    assert_same(whole, cut)
