"""A short load whose cycles are counted by hand: every number of its spectrum, its lines in a report, and its figure."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import answered, drawn, titled
from tests.refusals import refused

import wucht
from wucht.dynamics.run_ups.machine_signals import LoadHistory
from wucht.fatigue.damage import WoehlerLine
from wucht.studies.load_spectrum import computation, dataset
from wucht.studies.load_spectrum import figure as load_figure

TIME = np.array([0.0, 2.0, 3.0, 4.0, 6.0, 8.0, 9.0, 10.0])
VALUES = np.array([100.0, 0.0, 10.0, 2.0, 8.0, -2.0, 6.0, 0.0])  # counted from 2 s on; the first half ends at 7 s
CYCLES = {(6.0, 5.0): 1.0, (10.0, 5.0): 0.5, (12.0, 4.0): 0.5, (8.0, 2.0): 0.5, (6.0, 3.0): 0.5}  # range, mean: 2 to 8 closes
DAMAGES = 1e-2 * np.array([1.5 * 0.6**4, 0.5 * 0.8**4, 0.5, 0.5 * 1.2**2])  # slope 2, below the knee 4
DAMAGE_OF_HALF = 1e-2 * 0.5 * (0.6**4 + 0.8**4 + 1.0)


def plan(line: WoehlerLine | None = None, case: Any = None, **keys: Any) -> Any:
    spec = wucht.LoadSpectrum(signal={"file": "record.csv"}, **keys)
    signal: Any = SimpleNamespace(unit="N", name="force of the rod")
    return computation.Plan(spec, signal, case, None, None, line, ("a doubt",))


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    line = WoehlerLine(2.0, 100.0, 5.0, 4.0)
    return dataset.dataset(plan(line, after=2.0), LoadHistory(TIME, VALUES, 12.0))


def test_every_range_has_its_cycles_their_mean_and_damage(result: xr.Dataset) -> None:
    assert result.range.values.tolist() == [6.0, 8.0, 10.0, 12.0]
    assert result["mean"].values == pytest.approx([6.5 / 1.5, 2.0, 5.0, 4.0])
    assert result["count"].values.tolist() == [1.5, 0.5, 0.5, 0.5]
    assert result["cumulative"].values.tolist() == [3.0, 1.5, 1.0, 0.5]
    assert result.half_cumulative.values.tolist() == [3.0, 2.0, 1.0, 0.0], "0, 10, 2, 8 has half cycles of 10, 8 and 6"
    assert result.damage.values == pytest.approx(DAMAGES)
    assert [result.attrs["signal"], result.range.attrs["units"]] == ["Force of the rod", "N"]
    counts = result.matrix.transpose("range_class", "mean_class").values
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
    assert result.wucht.warnings == ["a doubt"], "how far a record repeats itself is not a doubt about it"


def test_without_a_line_a_start_or_a_cycle() -> None:
    s = dataset.dataset(plan(), LoadHistory(TIME + 1.0, VALUES, 12.0)).wucht.summary
    assert (s["begin"], s["half"], s["max"]) == (1.0, 6.5, 100.0), "from the first sample on"
    assert [s[key] for key in ("damage", "repetitions", "life")] == [None] * 3 and "damage_of_half" not in s
    empty = dataset.dataset(plan(after=11.0), LoadHistory(TIME, VALUES, 12.0))
    s = empty.wucht.summary
    assert (s["cycles"], s["largest_range"], s["min"], s["max"], s["turning_points"]) == (0.0, 0.0, None, None, 0)
    assert s["sentence"] == "there is no cycle to count"
    assert any("after study.after = 11" in w and "ends at 12" in w for w in empty.wucht.warnings)
    none = dataset.dataset(plan(), LoadHistory(np.empty(0), np.empty(0), 3.0))
    assert (none.wucht.summary["begin"], none.wucht.summary["end"]) == (0.0, 3.0)


@pytest.mark.parametrize(("of_machine", "unit"), [(None, "s"), ("s", "s"), ("", "")])
def test_the_time_of_the_course_has_the_unit_of_the_machine(of_machine: str | None, unit: str) -> None:
    """None where a machine is dimensionless; of a record it is in seconds."""
    case = None if of_machine is None else SimpleNamespace(machine=SimpleNamespace(units=SimpleNamespace(time=of_machine)))
    made = {q.name: q.unit for q in dataset._signal_quantities(plan(case=case), LoadHistory(TIME, VALUES, 12.0), VALUES)}
    assert (made["course_time"], made["counted_from"]) == (unit, unit)


def test_a_long_signal_is_drawn_with_the_least_and_greatest_value_of_each_of_200_intervals() -> None:
    time = np.sort(np.random.default_rng(1).uniform(5.0, 25.0, 2000))
    time[0] = 5.0
    values = np.random.default_rng(2).standard_normal(2000)
    values[time > 20.0] += 3.0
    result = xr.Dataset(
        {
            q.name: (q.dimensions.split(), q.value)
            for q in dataset._signal_quantities(plan(), LoadHistory(time, values, 25.0), values)
            if q.dimensions
        }
    )
    middles = 5.0 + 0.1 * (np.arange(200) + 0.5)
    inside = [values[(time >= m - 0.05) & (time < m + 0.05)] for m in middles]
    kept = [k for k, part in enumerate(inside) if len(part)]
    assert result.course_time.values == pytest.approx(middles[kept])
    assert result.lowest.values == pytest.approx([inside[k].min() for k in kept])
    assert result.highest.values == pytest.approx([inside[k].max() for k in kept])
    fine = 5.0 + 20.0 * (np.arange(400_000) + 0.5) / 400_000
    means = np.interp(fine, time, values).reshape(200, -1).mean(axis=1)
    assert result.average.values == pytest.approx(means[kept], abs=2e-3), "of straight lines through the turning points"


@pytest.mark.parametrize(
    ("spectrum", "damage", "doubted"),
    [(0.04, 0.04, False), (0.06, 0.0, True), (0.0, 0.06, True), (0.0, -0.06, True), (0.06, None, True), (0.04, None, False)],
)
def test_a_run_up_is_not_converged_where_its_second_half_changes_more_than_five_percent(
    spectrum: float, damage: float | None, doubted: bool
) -> None:
    load: Any = SimpleNamespace(cycles=SimpleNamespace(total=3.0), class_width=None)
    convergence = {"spectrum": spectrum, "damage": damage}
    run_up = LoadHistory(TIME, VALUES, 12.0, SimpleNamespace(advice="run longer"))  # type: ignore[arg-type]
    told = dataset._warnings(plan(), run_up, load, convergence)
    assert [w for w in told if "not converged" in w] == told[2:] and len(told[2:]) == doubted
    assert told[:2] == ["a doubt", "run longer"]
    if doubted and damage:
        assert f"change by {100 * spectrum:.1f} % of all cycles, and the damage by 6.0 %" in told[-1]
    assert dataset._warnings(plan(), LoadHistory(TIME, VALUES, 12.0), load, convergence) == ["a doubt"]


def test_warnings_of_the_run_up_are_passed_on_but_not_that_samples_are_few() -> None:
    case = SimpleNamespace(
        horizon=SimpleNamespace(warnings=("only 20 samples a turn are stored", "a long run")),
        models=[SimpleNamespace(warnings=("of the model",))],
    )
    load: Any = SimpleNamespace(cycles=SimpleNamespace(total=3.0), class_width=0.25)
    findings = LoadHistory(TIME, VALUES, 12.0, None, "it broke off")
    told = dataset._warnings(plan(case=case), findings, load, {"spectrum": 0.0, "damage": None})
    assert told[:4] == ["a doubt", "a long run", "of the model", "it broke off"]
    assert len(told) == 5 and "classes of 0.25 N" in told[4]
    levels = dataset._warnings(plan(counting="level-crossing"), findings, load, {"spectrum": 0.0, "damage": None})
    assert levels == ["a doubt", "it broke off"], "levels have a distance, which nobody is warned of"


def test_the_lines_of_the_report() -> None:
    rows = [{"range": float(k), "mean": k / 10, "count": k / 2} for k in range(1, 9)]
    given: dict[str, Any] = {
        "unit": "mm", "begin": 1.5, "end": 20.0, "outcome": "compensated", "counting": "peaks", "residue": "repeat",
        "cycles": 18.0, "min": -3.0, "max": 5.0, "spectrum": rows, "damage": 0.25, "life": 7200.0, "repetitions": 4.0,
        "convergence": {"spectrum": 0.125, "damage": -0.25},
    }  # fmt: skip

    def told(dimensionless: bool = False, **other: Any) -> list[str]:
        made = answered(xr.Dataset(), given | other, "as by hand", dimensionless=dimensionless).assign_attrs(signal="Force")
        return dataset.report(titled(made, dimensionless))[2:]

    assert told() == [
        "  signal       Force, from 1.5 to 20 s",
        "  machine      compensated",
        "  counting     peaks; the history is repeated, so that all cycles close",
        "  between      -3 and 5 mm",
        "  range        8 mm, mean 0.8 mm: 4",
        *(f"               {k} mm, mean 0.{k} mm: {k / 2:.10g}" for k in range(7, 2, -1)),
        "               and 2 smaller ones",
        "  damage       0.25",
        "  life         4 repetitions, 7200 s (2 h)",
        "  convergence  doubling the first half changes the counts by 12.50 % of all cycles, and the damage by 25.00 %",
    ]
    bare = told(
        True, unit="", outcome=None, spectrum=rows[:6], damage=None, life=7200.0, convergence={"spectrum": 0.5, "damage": None}
    )
    assert bare[0] == "  signal       Force, from 1.5 to 20" and bare[2] == "  between      -3 and 5"
    assert [line for line in bare if "life" in line] == ["  life         4 repetitions, 7200"]
    assert not [line for line in bare if "smaller" in line or "machine" in line or "damage" in line]
    assert [line.split()[0] for line in told(cycles=0.0)] == ["signal", "machine", "counting", "damage", "life"]


def test_classes_are_at_most_ten_thousand_of_the_whole_span() -> None:
    values = np.array([-30.0, 10.0, 70.0])
    computation.check_width(values, 0.01)
    computation.check_width(values, None)
    computation.check_width(np.empty(0), 1e-9)
    with refused("study.class_width", "0.01", "100", given=0.0099):
        computation.check_width(values, 0.0099)


def test_more_than_a_thousand_ranges_get_a_hundred_classes() -> None:
    def counted(number: int, width: float | None = None) -> Any:
        return computation.count_load(
            plan()
            if width is None
            else computation.Plan(
                plan().spec, SimpleNamespace(unit="N", name="f"), None, None, width, None, ()  # type: ignore[arg-type]
            ),
            np.repeat(np.arange(1, number + 2), 1) * np.resize([1.0, -1.0], number + 1),
        )  # fmt: skip

    few, many = counted(1000), counted(1001)
    assert few.class_width is None and len(few.rows.ranges) == 1000
    assert many.class_width == pytest.approx(2003 / 100) and len(many.rows.ranges) <= 101
    assert counted(1001, 400.0).class_width == 400.0 and len(counted(1001, 400.0).rows.ranges) == 6


def test_what_each_panel_shows(result: xr.Dataset) -> None:
    cumulative, matrix, course, bars = drawn("load-spectrum", titled(result)).axes[:4]
    counted, twice, woehler = cumulative.lines
    assert [x.get_label() for x in cumulative.lines] == ["counted", "twice the first half", "S-N curve"]
    assert np.asarray(counted.get_xdata()).tolist() == [0.25, 0.5, 1.0, 1.5, 3.0], "from half of the least number on"
    assert np.asarray(counted.get_ydata()).tolist() == [6.0, 5.0, 4.0, 3.0, 3.0]
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
    heights = [b.get_height() for b in bars.patches if b.get_height() > 0]
    assert heights == pytest.approx(DAMAGES / DAMAGES.sum())


@pytest.mark.parametrize("width", [0.5, 0.11])
def test_a_histogram_has_no_holes_beside_classes_that_have_cycles(width: float) -> None:
    """Amplitudes in every class from 3 to 11, of which 72 are too many for bars."""
    counted = np.arange(3.0, 11.0, width)
    edges = load_figure._amplitude_classes(counted, width)
    bars, _ = np.histogram(counted, edges)
    assert bars.sum() == len(counted) and (bars > 0).all() and len(bars) <= 40
    assert len(set(bars[:-1])) == 1, "each has as many classes"
    assert edges[0] == pytest.approx(3.0 - width / 2)
    assert len(load_figure._amplitude_classes(counted, None)) == 41


@pytest.mark.parametrize("cycles", [200, 2000])
def test_a_signal_of_many_cycles_is_drawn_as_its_mean_with_its_range(result: xr.Dataset, cycles: int) -> None:
    """Whether all turning points are known, or the least and greatest value of intervals: no dark block, and a line in it."""
    time = np.linspace(0.0, 10.0, 2 * cycles + 1)
    values = 3.0 + np.where(np.arange(len(time)) % 2, 2.0, -2.0)
    quantities = dataset._signal_quantities(plan(), LoadHistory(time, values, 10.0), values)
    course = {q.name: (q.dimensions, q.value) for q in quantities if q.dimensions}
    of_signal = {name: (dims, value, result[name].attrs) for name, (dims, value) in course.items()}
    made = result.drop_dims("part").assign(of_signal).assign_coords(course_time=of_signal.pop("course_time"))
    axis = drawn("load-spectrum", titled(made)).axes[2]
    mean, band = axis.lines[0], axis.collections[0]
    assert (mean.get_label(), band.get_label()) == ("mean", "least to greatest")
    assert np.asarray(mean.get_ydata()) == pytest.approx(3.0, abs=0.2)
    _, up = band.get_datalim(axis.transData).get_points().T
    assert up == pytest.approx([1.0, 5.0], abs=0.2) and band.get_alpha() < 0.5
    former = drawn("load-spectrum", titled(made.drop_vars("average"))).axes[2]
    assert former.collections[0].get_label() == "least to greatest", "of a result that was written without means"


def test_crossings_are_drawn_over_levels_instead_of_bars(result: xr.Dataset) -> None:
    made = result.assign(level=("level", [1.0, 2.0, 3.0]), crossings=("level", [10.0, 40.0, 20.0]))
    (line,) = drawn("load-spectrum", titled(made)).axes[3].lines
    assert (list(np.asarray(line.get_xdata())), list(np.asarray(line.get_ydata()))) == ([10.0, 40.0, 20.0], [1.0, 2.0, 3.0])


def test_levels_are_at_multiples_of_the_width_from_the_reference_or_in_the_middle_of_a_hundred_classes() -> None:
    values = np.array([-1.1, 2.4, 0.4])
    assert computation._levels(values, 0.5, None) == pytest.approx([-1.0, -0.5, 0.0, 0.5, 1.0, 1.5, 2.0])
    assert computation._levels(values, 1.0, 0.3) == pytest.approx([-0.7, 0.3, 1.3, 2.3])
    classes = computation._levels(np.array([1.0, 3.0]), None, 0.0)
    assert len(classes) == 100 and (classes[0], classes[-1]) == (pytest.approx(1.01), pytest.approx(2.99))


def test_the_scales_of_the_panels_are_named(result: xr.Dataset) -> None:
    names = {"cumulative spectrum": ("cumulative cycles", "amplitude"), "range-mean matrix": ("mean", "range")}
    axes = drawn("load-spectrum", titled(result)).axes
    for axis, (title, (x, y)) in zip(axes[:2], names.items(), strict=True):
        assert (axis.get_title(), axis.get_xlabel().split(" (")[0], axis.get_ylabel().split(" (")[0]) == (title, x, y)
    assert axes[2].get_ylabel().startswith("signal") and axes[3].get_xlabel().startswith("amplitude")
    assert (axes[3].get_title(), axes[3].get_ylabel()) == ("share of the damage, by amplitude", "share of the damage")
