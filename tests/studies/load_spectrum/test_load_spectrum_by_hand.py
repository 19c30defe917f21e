"""A short load whose cycles are counted by hand: every number of its spectrum, its lines in a report, and its figure."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

import wucht

TIME = np.array([0.0, 2.0, 3.0, 4.0, 6.0, 8.0, 9.0, 12.0])
VALUES = np.array([100.0, 0.0, 10.0, 2.0, 8.0, -2.0, 6.0, 0.0])  # counted from 2 s on; the first half ends at 7 s
CYCLES = {(6.0, 5.0): 1.0, (10.0, 5.0): 0.5, (12.0, 4.0): 0.5, (8.0, 2.0): 0.5, (6.0, 3.0): 0.5}  # range, mean: 2 to 8 closes
DAMAGES = 1e-2 * np.array([1.5 * 0.6**4, 0.5 * 0.8**4, 0.5, 0.5 * 1.2**2])  # slope 2, below the knee 4
DAMAGE_OF_HALF = 1e-2 * 0.5 * (0.6**4 + 0.8**4 + 1.0)


def counted(
    folder: Path, time: np.ndarray, values: np.ndarray, heading: str = "force of the rod [N]", **keys: Any
) -> xr.Dataset:
    rows = "\n".join(f"{t!r},{x!r}" for t, x in zip(time.tolist(), values.tolist(), strict=True))
    (folder / "record.csv").write_text(f"time [s],{heading}\n{rows}\n", encoding="utf-8")
    return wucht.run(wucht.LoadSpectrum(signal={"file": "record.csv"}, **keys), wucht.Records(folder))


@pytest.fixture(scope="module")
def result(tmp_path_factory: pytest.TempPathFactory) -> xr.Dataset:
    line = {"k": 2.0, "ND": 100.0, "SD": 5.0, "k2": 4.0}
    return counted(tmp_path_factory.mktemp("record"), TIME, VALUES, after=2.0, woehler=line)


def test_every_range_has_its_cycles_their_mean_and_damage(result: xr.Dataset) -> None:
    assert result.range.values.tolist() == [6.0, 8.0, 10.0, 12.0]
    assert result["mean"].values == pytest.approx([6.5 / 1.5, 2.0, 5.0, 4.0])
    assert result["count"].values.tolist() == [1.5, 0.5, 0.5, 0.5]
    assert result["cumulative"].values.tolist() == [3.0, 1.5, 1.0, 0.5]
    assert result.half_cumulative.values.tolist() == [3.0, 2.0, 1.0, 0.0], "0, 10, 2, 8 has half cycles of 10, 8 and 6"
    assert result.damage.values == pytest.approx(DAMAGES)
    assert [result.attrs["signal"], result.range.attrs["units"]] == ["Force of the rod", "N"]
    assert result.course_time.attrs["units"] == result.counted_from.attrs["units"] == "s"
    counts = result["matrix"].transpose("range_class", "mean_class").values
    at = {
        (float(result.range_class[i]), float(result.mean_class[j])): counts[i, j]
        for i, j in zip(*np.nonzero(counts), strict=True)
    }
    for (size, mean), count in CYCLES.items():  # classes are 0.3 wide in range, 0.075 in mean
        near = [n for (r, m), n in at.items() if abs(r - size) <= 0.1501 and abs(m - mean) <= 0.0376]
        assert near == [count], (size, mean)
    assert len(at) == len(CYCLES)


def test_the_summary(result: xr.Dataset) -> None:
    s, damage = result.wucht.summary, DAMAGES.sum()
    expected = {
        "cycles": 3.0, "largest_range": 12.0, "min": -2.0, "max": 10.0, "turning_points": 7, "begin": 2.0, "half": 7.0,
        "end": 12.0, "unit": "N", "class_width": None, "outcome": None, "counting": "rainflow", "residue": "half-cycles",
    }  # fmt: skip
    assert {key: s[key] for key in expected} == expected
    assert s["damage"] == pytest.approx(damage) and s["damage_of_half"] == pytest.approx(DAMAGE_OF_HALF)
    assert (s["repetitions"], s["life"]) == (pytest.approx(1 / damage), pytest.approx(10.0 / damage))
    converged = {"spectrum": 0.5 / 3.0, "largest_range": 10 / 12, "damage": 2 * DAMAGE_OF_HALF / damage - 1}
    assert s["convergence"] == {key: pytest.approx(share) for key, share in converged.items()}
    assert s["spectrum"][1] == {"range": 8.0, "mean": 2.0, "count": 0.5}
    assert [float(result[f"woehler_{key}"]) for key in ("k", "ND", "SD", "k2")] == [2.0, 100.0, 5.0, 4.0]
    assert result.wucht.warnings == [], "how far a record repeats itself is not a doubt about it"
    assert f"  life         {1 / damage:.5g} repetitions, {10 / damage:.5g} s ({10 / damage / 3600:.4g} h)" in wucht.report(
        result
    )


def test_without_a_line_a_start_or_a_cycle(tmp_path: Path) -> None:
    s = counted(tmp_path, TIME + 1.0, VALUES).wucht.summary
    assert (s["begin"], s["half"], s["max"]) == (1.0, 7.0, 100.0), "from the first sample on"
    assert [s[key] for key in ("damage", "repetitions", "life")] == [None] * 3 and "damage_of_half" not in s
    empty = counted(tmp_path, np.append(TIME, 13.0), np.append(VALUES, 0.0), after=12.5)
    s = empty.wucht.summary
    assert (s["cycles"], s["largest_range"], s["min"], s["max"], s["turning_points"]) == (0.0, 0.0, None, None, 0)
    assert any("after study.after = 12.5" in w and "ends at 13" in w for w in empty.wucht.warnings)
    assert [line.split()[0] for line in wucht.report(empty)[2:]] == ["signal", "counting"]


@pytest.mark.parametrize(
    ("keys", "doubt"),
    [
        ({"until": 5.0, "after": 2.0}, None),
        ({"until": 8.0, "after": 2.0}, "counts change by 6.7 % of all cycles; run longer"),
        ({"until": 5.0, "after": 2.0, "woehler": {"k": 4, "ND": 1e6, "SD": "1 mm"}}, None),
        (
            {"until": 5.0, "after": 2.0, "woehler": {"k": 80, "ND": 1e6, "SD": "1 mm"}},
            "4.4 % of all cycles, and the damage by ",
        ),
    ],
)
def test_a_run_up_is_not_converged_where_its_second_half_changes_more_than_five_percent(
    keys: dict[str, Any], doubt: str | None
) -> None:
    """Its counts, by 4.4 % and 6.7 %, or its damage."""
    machine = wucht.load_machine("drozdetskaya-2020/r1")
    result = wucht.run(wucht.LoadSpectrum(start={"p1": 0.3, "p2": -0.5}, **keys), machine)
    told = [w for w in result.wucht.warnings if "not converged" in w]
    assert len(told) == (doubt is not None) and all(doubt in w for w in told if doubt)


def test_classes_are_at_most_ten_thousand_of_the_whole_span(tmp_path: Path) -> None:
    time, values = np.arange(3.0), np.array([-30.0, 70.0, 10.0])
    assert counted(tmp_path, time, values, class_width=0.01).wucht.summary["class_width"] == 0.01
    with refused("study.class_width", "0.01", "100", given=0.0099):
        counted(tmp_path, time, values, class_width=0.0099)


@pytest.mark.parametrize(("samples", "is_doubted"), [(8, True), (15, False), (40, False)])
def test_how_many_samples_a_cycle_has(tmp_path: Path, samples: int, is_doubted: bool) -> None:
    """Extremes fall between the samples of a record with 8 samples a cycle, not of one with 15."""
    result = counted(tmp_path, np.arange(800.0), np.sin(2 * np.pi * np.arange(800) / samples + 0.1))
    assert ["the record has 8.0 samples a cycle" in w for w in result.wucht.warnings] == [True] * is_doubted


def test_a_histogram_has_no_holes_beside_classes_that_have_cycles(tmp_path: Path) -> None:
    """Amplitudes in every class from 3 to 11, of which 72 are too many for bars."""
    amplitudes = np.arange(3.0, 11.0, 0.11)
    values = np.repeat(amplitudes, 2) * np.resize([1.0, -1.0], 2 * len(amplitudes))
    result = counted(tmp_path, np.arange(float(len(values))), values, counting="range-pair", class_width=0.22)
    bars = [bar.get_height() for bar in wucht.draw(result).axes[3].patches]
    assert sum(bars) == result.wucht.summary["cycles"] and min(bars) > 0 and len(bars) <= 40
    assert len(set(bars[:-1])) == 1, "each has as many classes"


@pytest.mark.parametrize("cycles", [200, 2000])
def test_a_signal_of_many_cycles_is_drawn_as_its_mean_with_its_range(tmp_path: Path, cycles: int) -> None:
    """Whether all turning points are known, or the least and greatest value of intervals: no dark block, and a line in it."""
    time = np.linspace(0.0, 10.0, 2 * cycles + 1)
    result = counted(tmp_path, time, 3.0 + np.where(np.arange(len(time)) % 2, 2.0, -2.0))
    axis = wucht.draw(result).axes[2]
    assert np.asarray(axis.lines[0].get_ydata()) == pytest.approx(3.0, abs=0.2)
    _, up = axis.collections[0].get_datalim(axis.transData).get_points().T
    assert up == pytest.approx([1.0, 5.0], abs=0.2)
    former = wucht.draw(result.drop_vars("average").assign_attrs(contents="[]")).axes[2]
    assert former.collections[0].get_label() == "least to greatest", "of a result that was written without means"
