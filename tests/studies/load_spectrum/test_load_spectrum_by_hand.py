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
    s = result.wucht.summary
    damage = DAMAGES.sum()
    expected = {
        "cycles": 3.0, "largest_range": 12.0, "min": -2.0, "max": 10.0, "turning_points": 7, "begin": 2.0, "half": 7.0,
        "end": 12.0, "unit": "N", "signal": "force of the rod", "class_width": None, "outcome": None,
        "counting": "rainflow", "residue": "half-cycles",
    }  # fmt: skip
    assert {key: s[key] for key in expected} == expected
    assert s["damage"] == pytest.approx(damage) and s["damage_of_half"] == pytest.approx(DAMAGE_OF_HALF)
    assert (s["repetitions"], s["life"]) == (pytest.approx(1 / damage), pytest.approx(10.0 / damage))
    assert s["convergence"] == {
        "spectrum": pytest.approx(0.5 / 3.0),
        "largest_range": pytest.approx(10 / 12),
        "damage": pytest.approx(2 * DAMAGE_OF_HALF / damage - 1),
    }
    assert s["spectrum"][1] == {"range": 8.0, "mean": 2.0, "count": 0.5}
    assert [float(result[f"woehler_{key}"]) for key in ("k", "ND", "SD", "k2")] == [2.0, 100.0, 5.0, 4.0]
    assert s["sentence"] == f"3 cycles, the largest of range 12 N; damage {damage:.4g}"
    assert result.wucht.warnings == [], "how far a record repeats itself is not a doubt about it"


def test_the_lines_of_the_report(result: xr.Dataset, tmp_path: Path) -> None:
    damage, of_half = DAMAGES.sum(), 2 * DAMAGE_OF_HALF / DAMAGES.sum() - 1
    assert wucht.report(result)[2:] == [
        "  signal       Force of the rod, from 2 to 12 s",
        "  counting     rainflow; the residue counts as half cycles",
        "  between      -2 and 10 N",
        "  range        12 N, mean 4 N: 0.5",
        "               10 N, mean 5 N: 0.5",
        "               8 N, mean 2 N: 0.5",
        "               6 N, mean 4.3333 N: 1.5",
        f"  damage       {damage:.5g}",
        f"  life         {1 / damage:.5g} repetitions, {10 / damage:.5g} s ({10 / damage / 3600:.4g} h)",
        f"  convergence  doubling the first half changes the counts by 16.67 % of all cycles, and the damage by "
        f"{100 * abs(of_half):.2f} %",
    ]
    growing = np.array([0.0, 1.0, -1.0, 2.0, -2.0, 3.0, -3.0, 4.0, -4.0])
    many = wucht.report(counted(tmp_path, np.arange(9.0), growing, "x", residue="repeat"))
    assert many[3:5] == [
        "  counting     rainflow; the history is repeated, so that all cycles close",
        "  between      -4 and 4",
    ]
    assert not [line for line in many if "damage" in line or "machine" in line or "smaller" in line]
    assert wucht.report(counted(tmp_path, np.arange(9.0), growing, "x"))[-2] == "               and 2 smaller ones"


def test_without_a_line_a_start_or_a_cycle(tmp_path: Path) -> None:
    s = counted(tmp_path, TIME + 1.0, VALUES).wucht.summary
    assert (s["begin"], s["half"], s["max"]) == (1.0, 7.0, 100.0), "from the first sample on"
    assert [s[key] for key in ("damage", "repetitions", "life")] == [None] * 3 and "damage_of_half" not in s
    empty = counted(tmp_path, np.append(TIME, 13.0), np.append(VALUES, 0.0), after=12.5)
    s = empty.wucht.summary
    assert (s["cycles"], s["largest_range"], s["min"], s["max"], s["turning_points"]) == (0.0, 0.0, None, None, 0)
    assert s["sentence"] == "there is no cycle to count"
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


def test_what_each_panel_shows(result: xr.Dataset) -> None:
    cumulative, matrix, course, bars = wucht.draw(result).axes[:4]
    counted_line, twice, woehler = cumulative.lines
    assert [x.get_label() for x in cumulative.lines] == ["counted", "twice the first half", "S-N curve"]
    assert np.asarray(counted_line.get_xdata()).tolist() == [0.25, 0.5, 1.0, 1.5, 3.0], "from half of the least number on"
    assert np.asarray(counted_line.get_ydata()).tolist() == [6.0, 5.0, 4.0, 3.0, 3.0]
    assert np.asarray(twice.get_xdata()).tolist() == [0.25, 0.25, 1.0, 2.0, 3.0]
    lives, amplitudes = np.asarray(woehler.get_xdata()), np.asarray(woehler.get_ydata())
    assert amplitudes[-1] == pytest.approx(7.5) and lives[0] == pytest.approx(1000.0, rel=0.1), "to ten times the knee"
    assert lives == pytest.approx(np.where(amplitudes >= 5.0, 100 * (amplitudes / 5) ** -2, 100 * (amplitudes / 5) ** -4))
    across, up = matrix.collections[0].get_datalim(matrix.transData).get_points().T
    assert across == pytest.approx([2.0, 5.0]) and up == pytest.approx([0.0, 12.0])
    counts = result["matrix"].values
    for limits, name, along in ((matrix.get_xlim(), "mean_class", 0), (matrix.get_ylim(), "range_class", 1)):
        middles = result[name].values[counts.any(axis=along)]
        width = result[name].values[1] - result[name].values[0]
        assert limits == pytest.approx((middles[0] - 1.5 * width, middles[-1] + 1.5 * width)), "one empty class around them"
    assert np.asarray(course.lines[0].get_xdata()).tolist() == TIME.tolist()
    assert np.asarray(course.lines[0].get_ydata()).tolist() == VALUES.tolist()
    assert list(np.asarray(course.lines[-1].get_xdata())) == [2.0, 2.0]
    standing = [bar for bar in bars.patches if bar.get_height() > 0]
    assert [bar.get_height() for bar in standing] == pytest.approx(DAMAGES / DAMAGES.sum())
    for bar, amplitude in zip(standing, (3.0, 4.0, 5.0, 6.0), strict=True):
        assert bar.get_x() - 1e-9 <= amplitude <= bar.get_x() + bar.get_width() + 1e-9


def test_the_scales_of_the_panels_are_named(result: xr.Dataset, tmp_path: Path) -> None:
    names = {"cumulative spectrum": ("cumulative cycles", "amplitude"), "range-mean matrix": ("mean", "range")}
    axes = wucht.draw(result).axes
    for axis, (title, (x, y)) in zip(axes[:2], names.items(), strict=True):
        assert (axis.get_title(), axis.get_xlabel().split(" (")[0], axis.get_ylabel().split(" (")[0]) == (title, x, y)
    assert axes[2].get_ylabel().startswith("signal") and axes[3].get_xlabel().startswith("amplitude")
    assert (axes[3].get_title(), axes[3].get_ylabel()) == ("share of the damage, by amplitude", "share of the damage")
    undamaged = wucht.draw(counted(tmp_path, TIME, VALUES, after=2.0)).axes[3]
    assert (undamaged.get_title(), undamaged.get_ylabel()) == ("cycles, by amplitude", "cycles")
    assert sum(bar.get_height() for bar in undamaged.patches) == pytest.approx(3.0)
    assert len(undamaged.patches) == 40


@pytest.mark.parametrize("width", [0.5, 0.11])
def test_a_histogram_has_no_holes_beside_classes_that_have_cycles(tmp_path: Path, width: float) -> None:
    """Amplitudes in every class from 3 to 11, of which 72 are too many for bars."""
    amplitudes = np.arange(3.0, 11.0, width)
    values = np.repeat(amplitudes, 2) * np.resize([1.0, -1.0], 2 * len(amplitudes))
    result = counted(tmp_path, np.arange(float(len(values))), values, counting="range-pair", class_width=2 * width)
    bars = [bar.get_height() for bar in wucht.draw(result).axes[3].patches]
    assert sum(bars) == result.wucht.summary["cycles"] and min(bars) > 0 and len(bars) <= 40
    assert len(set(bars[:-1])) == 1, "each has as many classes"


@pytest.mark.parametrize("cycles", [200, 2000])
def test_a_signal_of_many_cycles_is_drawn_as_its_mean_with_its_range(tmp_path: Path, cycles: int) -> None:
    """Whether all turning points are known, or the least and greatest value of intervals: no dark block, and a line in it."""
    time = np.linspace(0.0, 10.0, 2 * cycles + 1)
    result = counted(tmp_path, time, 3.0 + np.where(np.arange(len(time)) % 2, 2.0, -2.0))
    axis = wucht.draw(result).axes[2]
    mean, band = axis.lines[0], axis.collections[0]
    assert (mean.get_label(), band.get_label()) == ("mean", "least to greatest")
    assert np.asarray(mean.get_ydata()) == pytest.approx(3.0, abs=0.2)
    _, up = band.get_datalim(axis.transData).get_points().T
    assert up == pytest.approx([1.0, 5.0], abs=0.2) and band.get_alpha() < 0.5
    former = wucht.draw(result.drop_vars("average").assign_attrs(contents="[]")).axes[2]
    assert former.collections[0].get_label() == "least to greatest", "of a result that was written without means"


def test_crossings_are_drawn_over_levels_instead_of_bars(tmp_path: Path) -> None:
    result = counted(tmp_path, TIME, VALUES, counting="level-crossing", class_width=1.0)
    (line,) = wucht.draw(result).axes[3].lines
    assert np.asarray(line.get_xdata()).tolist() == result.crossings.values.tolist()
    assert np.asarray(line.get_ydata()).tolist() == result.level.values.tolist()
    assert result.crossings.values.any() and "cycles, by amplitude" not in [a.get_title() for a in wucht.draw(result).axes]
