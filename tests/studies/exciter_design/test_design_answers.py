"""The numbers and lines of a small design, each computed again from its variables; warnings; targets that are read."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.refusals import refused

import wucht
from wucht.files.building import machine_from

METRICS = ("amplitude", "cumulative", "damage")
TARGET = [["0.7 mm", 2e6], ["1.0 mm", 1.4e6], ["1.4 mm", 6e5], ["1.7 mm", 2.5e5], ["1.9 mm", 4e4]]
TINY: dict[str, Any] = {
    "target": TARGET, "vary": {"p1.mass": ["0.3 kg", "3 kg"]}, "signal": "displacement", "direction": "x", "reach": 4,
    "evaluations": 4, "population": 4, "candidates": 1, "polish": 0, "beats": 2, "samples": 0,
}  # fmt: skip
SMALL = TINY | {"polish": 12, "corrections": 1, "beats": 8, "samples": 8}
NOWHERE = {"vary": {"drive.slope": [4e-3, 8e-3]}}  # the motor passes the resonance: it takes a moment


def designed(machine: wucht.Machine | None = None, **keys: Any) -> xr.Dataset:
    return wucht.run(wucht.ExciterDesign(**TINY | keys), machine or wucht.load_machine("practice/exciter"))


@pytest.fixture(scope="module")
def result() -> xr.Dataset:
    return designed(**SMALL)


@pytest.fixture(scope="module", params=METRICS)
def of_metric(request: pytest.FixtureRequest) -> xr.Dataset:
    return designed(metric=request.param)


def distances(result: xr.Dataset, name: str, slope: float = 5.0) -> dict[str, float]:
    """Of two curves of amplitudes over the share of the cycles: areas between them, and the largest difference of shares."""
    weight = np.diff(result.share.values, prepend=0.0)
    wanted, ours = result.amplitude_wanted.values, result[name].values
    levels = np.linspace(0.0, 1.01 * max(wanted.max(), ours.max()), 2000)

    def above(amplitudes: np.ndarray, of: np.ndarray) -> np.ndarray:
        return np.array([of[amplitudes >= level].sum() for level in levels])

    damage = [above(x, weight * x**slope) for x in (ours, wanted)]
    return {
        "amplitude": float((weight * np.abs(ours - wanted)).sum() / wanted.max()),
        "cumulative": float(np.abs(above(ours, weight) - above(wanted, weight)).max()),
        "damage": float(np.abs(damage[0] - damage[1]).max() / damage[1].max()),
    }


@pytest.mark.slow
def test_the_distances_are_those_of_the_curves(result: xr.Dataset) -> None:
    s = result.wucht.summary
    for of, name in (("full", "amplitude_full"), ("slow", "amplitude_slow")):
        assert s["distances"][of] == pytest.approx(distances(result, name), rel=0.03, abs=0.004)
    assert s["distances"]["full"]["amplitude"] == s["distance"]
    assert abs(s["distances"]["full"]["amplitude"] / s["distances"]["slow"]["amplitude"] - 1) > 0.05, "they differ"


def test_each_metric_has_its_own_column(of_metric: xr.Dataset) -> None:
    """Without a local search the best candidate is run itself."""
    s = of_metric.wucht.summary
    metric = s["metric"]
    assert s["distance"] == s["distances"]["full"][metric] and s["compared"][0]["distance"] == s["distance"]
    (run,), (polished,) = s["runs"], s["polished"]
    assert run["slow"] == polished["distance"] == of_metric.run_slow.values[0] == np.nanmin(of_metric.tried_distance)
    assert run["parameters"]["p1.mass"] == polished["p1.mass"] == of_metric.run_value.values[0, 0]
    assert polished["p1.mass"] == of_metric.tried_value.values[np.nanargmin(of_metric.tried_distance), 0]
    assert run["full"] == of_metric.run_full.values[0] and run["full"] != run["slow"]
    assert run["outcome"] == "captured-modulated" and of_metric.run_beats.values.tolist() == [1]
    assert wucht.draw(of_metric).axes and wucht.report(of_metric)


def test_the_spectrum_beside_that_of_the_target(result: xr.Dataset) -> None:
    s = result.wucht.summary
    ranges, counts = (np.array([row[key] for row in s["spectrum"]]) for key in ("range", "count"))
    assert counts.sum() == pytest.approx(2e6) and s["upper"] == pytest.approx(ranges.max() / 2, rel=0.02)
    above = np.interp(s["upper"], result.amplitude_wanted.values[::-1], 2e6 * result.share.values[::-1])
    assert s["beyond"] == pytest.approx(above, rel=0.02)
    weight = np.diff(result.share.values, prepend=0.0)
    ours, theirs = ((weight * result[f"amplitude_{name}"].values ** 5).sum() for name in ("full", "wanted"))
    assert s["damage_ratio"] == pytest.approx(ours / theirs, rel=0.02)
    assert s["duration"] == pytest.approx(2e6 * s["beat"] / s["cycles_per_beat"], rel=0.05)
    assert s["cycles_per_beat"] == pytest.approx(result.beat_rate.values.mean() * s["beat"], rel=0.01)
    target = {name: float(result[f"wanted_{name}"]) for name in ("upper", "ratio", "fullness", "cycles")}
    assert s["target"] == target and target["upper"] == pytest.approx(1.9e-3) and target["ratio"] == pytest.approx(0.7 / 1.9)
    wanted = result.amplitude_wanted.values
    mean = (weight * wanted).sum()
    assert target["fullness"] == pytest.approx((mean - 0.7e-3) / 1.2e-3, rel=0.01)


def test_no_neighbour_that_is_shown_is_nearer(result: xr.Dataset) -> None:
    s = result.wucht.summary
    rows = {what: [r["distance"] for r in s["compared"] if r["what"] == what] for what in ("design", "neighbour", "as it is")}
    assert rows["design"] == [s["distance"]] and len(rows["neighbour"]) == 2 and len(rows["as it is"]) == 1
    assert s["distance"] <= min(r["distance"] for r in s["compared"] if r["distance"] is not None)
    masses = sorted(r["parameters"]["p1.mass"] for r in s["compared"] if r["what"] == "neighbour")
    assert masses == pytest.approx([s["parameters"]["p1.mass"] / 1.02, s["parameters"]["p1.mass"] * 1.02], rel=1e-5)


def test_its_distance_is_that_of_later_beats(result: xr.Dataset) -> None:
    """Beats 9 to 16 of an own run, counted by the study of load spectra, against the amplitudes that are wanted."""
    s = result.wucht.summary
    machine = wucht.load_machine("practice/exciter").with_values(s["parameters"])
    shown = result.turning_value.values
    assert np.abs(shown).max() == pytest.approx(s["upper"], rel=0.02), "the beat is one of the full equations"
    assert np.abs(shown).max() < 0.97 * result.beat_amplitude.values.max(), "those of the averaged ones are larger"
    assert result.turning_time.values[-1] <= s["beat"] and len(shown) == pytest.approx(2 * s["cycles_per_beat"], abs=4)
    run = wucht.run(wucht.LoadSpectrum(signal="displacement", direction="x", until=40 * s["beat"]), machine).wucht.summary
    largest = max(row["range"] for row in run["spectrum"]) / 2
    assert largest == pytest.approx(s["upper"], rel=0.05)


def test_exciters_within_tolerances(result: xr.Dataset) -> None:
    s, far = result.wucht.summary, np.sort(result.tolerance_distance.values)
    t = s["tolerances"]
    assert (t["q05"], t["median"], t["q95"], t["modulated"], t["spread"]) == (far[1], far[4], far[7], 1.0, 0.02)
    about = result.tolerance_value.values / s["parameters"]["p1.mass"] - 1
    assert 0.01 < np.abs(about).max() <= 0.02 and (about > 0).any() and (about < 0).any()
    assert t["median"] == pytest.approx(s["distance"], rel=0.1), "corrected by the deviation of the full equations"


# --- warnings ---


def test_a_design_at_the_end_of_its_range() -> None:
    """Or beyond it: the exciter as it is is better than all of the range."""
    result = designed(vary={"p1.mass": ["1.2 kg", "3 kg"]}, polish=12, corrections=0, beats=8)
    assert result.wucht.summary["parameters"]["p1.mass"] == result.wucht.summary["as_it_is"]["p1.mass"] < 1.2
    assert "p1.mass lies at an end of the range: a wider one may do better" in result.wucht.warnings


def test_a_candidate_that_does_not_beat_in_the_full_equations() -> None:
    """At least not within two beats."""
    result = designed(vary={"p1.mass": ["1.5 kg", "3 kg"]})
    assert result.wucht.warnings == [
        "1 of 1 candidates do not beat in the full equations: unidentified",
        "no candidate beats: 8 modulated; try other ranges, a pendulum whose unbalance is not that of the rotor, or a weaker "
        "motor",
    ]
    assert result.wucht.summary["distance"] is None and result.run_beats.values.tolist() == [0]


def test_a_design_that_is_farther_off_in_the_full_equations_and_exciters_that_do_not_beat() -> None:
    """A wide spread, within which the pendulum may be too light."""
    result = designed(samples=16, spread=0.9)
    s, warnings = result.wucht.summary, result.wucht.warnings
    slow, full, t = s["distances"]["slow"]["amplitude"], s["distances"]["full"]["amplitude"], s["tolerances"]
    assert full > 1.5 * slow and 0 < t["modulated"] < 0.9 and t["q95"] is None and t["median"] is not None
    assert warnings[0].startswith(f"the full equations are farther from the target than the averaged ones, {100 * full:.2f} %")
    assert warnings[-1] == f"{100 * (1 - t['modulated']):.0f} % of the exciters within tolerances of 90.0 % do not beat"
    assert wucht.report(result) and wucht.draw(result).axes


def test_what_is_known_of_an_interrupted_design() -> None:
    def stop(share: float, _: str) -> None:
        if share > 0.2:
            raise KeyboardInterrupt

    question, machine = wucht.ExciterDesign(**TINY), wucht.load_machine("practice/exciter")
    part = wucht.run(question, machine, progress=stop)
    assert part.wucht.sentence == "no exciter that beats so far" and part.wucht.summary["distance"] is None
    assert wucht.report(part) and wucht.draw(part).axes


# --- targets ---


def wanted(**target: Any) -> xr.Dataset:
    """The result of a search where nothing beats, which has the target."""
    return designed(target=target, **NOWHERE)


def test_a_table_may_have_its_rows_in_any_order_and_other_units() -> None:
    ordered = wanted(table=[["1 mm", 1e6], ["1.5 mm", 1e4], ["2 mm", 1e3]])
    mixed = wanted(table=[["0.2 cm", "1e3 cycles"], ["1 mm", 1e6], ["1.5 mm", 1e4]])
    assert float(mixed.wanted_cycles) == pytest.approx(1e6)
    assert np.array_equal(mixed.amplitude_wanted.values, ordered.amplitude_wanted.values)


@pytest.mark.parametrize(("ratio", "least"), [(None, 0.0), (0.25, 0.5e-3)])
def test_a_shape_from_the_largest_amplitude_to_the_lowest(ratio: float | None, least: float) -> None:
    form = wanted(shape="straight-line", largest="2 mm", cycles=1e6, ratio=ratio).wucht.summary["target"]
    assert (form["upper"], form["upper"] * form["ratio"]) == pytest.approx((2e-3, least), abs=2e-5)
    assert form["cycles"] == pytest.approx(1e6)


def test_targets_on_the_border() -> None:
    assert wanted(table=[["0 mm", 1e3], ["1 mm", 1e3]]).wucht.summary["target"]["upper"] == pytest.approx(1e-3)
    one = wanted(table=[["2 mm", 1e6]], stepped=True).wucht.summary["target"]
    assert one == {"upper": 2e-3, "ratio": pytest.approx(1.0), "fullness": None, "cycles": pytest.approx(1e6)}
    assert wanted(table=[["1 mm", 1.01], ["2 mm", 1.0]]).wucht.summary["target"]["cycles"] == pytest.approx(1.01)
    with refused("study.target.largest", given="0 mm"):
        wanted(shape="normal", largest="0 mm", cycles=1e6)
    with refused("study.target.ratio"):
        wanted(table=TARGET, ratio=0.5)


@pytest.mark.parametrize(("rows", "stepped", "words"), [
    ([], True, "two rows"), ([["-1 mm", 1e6], ["2 mm", 1e3]], False, "none below 0"),
    ([["0 mm", 1e6]], True, "different amplitudes"), ([["1 mm", 1.0], ["2 mm", 1.0]], False, "more than one cycle"),
    ([["1 mm", 1e3], ["2 mm", 0.0]], False, "greater than 0"),
])  # fmt: skip
def test_tables_that_are_no_spectra(rows: list[Any], stepped: bool, words: str) -> None:
    with refused("study.target.table", words):
        wanted(table=rows, stepped=stepped)


def test_a_changed_file_is_another_question(here: Path) -> None:
    text = '[machine]\nuse = "practice/exciter"\n[study]\nkind = "exciter-design"\ntarget = { file = "t.csv" }\n'
    keys = {k: v for k, v in (TINY | NOWHERE).items() if k != "target"}
    (here / "design.toml").write_text(text + "vary = { drive.slope = [4e-3, 8e-3] }\n", encoding="utf-8")
    contents = []
    for amplitude in (1, 1.5, 1):
        (here / "t.csv").write_text(f"amplitude [mm], cycles\n{amplitude}, 1e5\n2, 2e4\n", encoding="utf-8")
        result = wucht.run_file("design.toml", {f"study.{key}": value for key, value in keys.items() if key != "vary"})
        contents.append(result.wucht.spec["target"]["contents"])
    assert contents[0] == contents[2] != contents[1]


# --- machines ---


def test_a_machine_without_a_pendulum_or_with_a_schedule() -> None:
    rotor = {"kind": "rotor", "name": "drum", "mass": 3.0, "unbalance": 1e-2, "inertia": 1.5e-2}
    drive = {"kind": "linear", "slope": 1e-3, "no_load_speed": 100.0}
    alone = machine_from({"carrier": {"stiffness": 1e4, "damping": 20.0}, "bodies": [rotor], "drive": drive})
    with refused("machine.bodies", "drum", given=None):
        designed(alone, **NOWHERE)
    p = wucht.parts
    pendulum = p.Pendulum(name="p1", about="drum", mass=0.5, length=0.1, damping=0.1)
    schedule = {"parameter": "carrier.stiffness", "points": [(1.0, 1e4), (2.0, 9e3)]}
    drum, motor = p.Rotor(**{k: v for k, v in rotor.items() if k != "kind"}), p.LinearDrive(slope=1e-3, no_load_speed=100.0)
    scheduled = wucht.Machine(p.Carrier(stiffness=1e4, damping=20.0), [drum, pendulum], [motor], schedules=[schedule])
    with refused("machine.schedules", given=None):
        designed(scheduled, **NOWHERE)


@pytest.mark.parametrize(("path", "low", "high", "bad"), [
    ("rotor.inertia", 1e-9, 1.0, 1e-9), ("rotor.unbalance", 1e-3, 1e3, 1e3),
])  # fmt: skip
def test_both_ends_of_a_range_must_be_allowed(path: str, low: float, high: float, bad: float) -> None:
    with refused(f"study.vary.{path}", given=bad):
        designed(vary={path: [low, high]})
