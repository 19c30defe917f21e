"""Many run-ups in one result."""

from __future__ import annotations

import math
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import xarray as xr
from tests.hand_made import with_answer
from tests.refusals import check_refusal, refused

from interrupting import assert_same
from wucht import RunUp
from wucht.files.catalogue import load_machine
from wucht.studies.runner import draw, report, run

MACHINE = "drozdetskaya-2020/table-5.1"
STARTS = ({"psi": 0.0, "delta": 0.5}, {"psi": 1.0, "delta": 2.0})


def asked(**changes: Any) -> RunUp:
    return RunUp(**({"until": 60.0, "along": "u", "values": (1.0, 5.0), "starts": STARTS} | changes))


def test_each_case_is_what_it_is_alone() -> None:
    result = whole()
    cases = result.wucht.summary["cases"]
    assert result.sizes["case"] == 4
    assert [c["value"] for c in cases] == [1.0, 1.0, 5.0, 5.0]
    assert [c["start"] for c in cases] == [dict(s) for s in STARTS] * 2
    assert cases[0]["label"] == "u = 1; psi = 0, delta = 0.5"
    for k, case in enumerate(cases):
        alone = run(RunUp(until=60.0, start=case["start"]), load_machine(MACHINE, {"u": case["value"]}))
        own = {key: v for key, v in case.items() if key not in ("label", "start", "value")}
        assert own == alone.wucht.summary
        inside = np.isfinite(result.time.values[k])
        # The same grid, but that it is as dense as the fastest case needs.
        assert float(result.speed.values[k][0][inside][-1]) == float(alone.speed.values[0][-1])


@pytest.mark.parametrize(("over", "name"), [("time", "time"), ("phi", "angle of the rotor"), ("psi", "mean phase")])
def test_the_figure_has_a_line_a_case(over: str, name: str) -> None:
    drawn = draw(run(asked(over=over, until=50.0), load_machine(MACHINE)))
    speed, amplitude = drawn.axes
    assert len([line for line in speed.get_lines() if not str(line.get_label()).startswith("no-load")]) == 4
    assert name in amplitude.get_xlabel()


def test_an_interrupted_result_is_continued_and_comes_out_the_same(tmp_path: Path) -> None:
    """Within the third run; another question is not continued."""

    def stop(share: float, _what: str) -> None:
        if share > 0.6:
            raise KeyboardInterrupt

    machine = load_machine(MACHINE)
    partial = run(asked(), machine, folder=tmp_path, progress=stop)
    assert (partial.attrs["finished"], partial.sizes["case"]) == (0, 2)
    with refused("--resume", given=None, code="other-question"):
        run(asked(values=(1.0, 4.0)), machine, folder=tmp_path, resume=True)
    assert_same(run(asked(), machine, folder=tmp_path, resume=True), whole())


@pytest.mark.parametrize(
    "table",
    [
        {"values": [1.0]},
        {"along": "u"},
        {"along": "x", "values": [1.0]},
        {"along": "u", "values": ["1 kg"]},
        {"along": "u", "values": 1.0},
        {"starts": {"psi": 1}},
        {"starts": [{"psi": 1.0}], "start": {"psi": 1.0}},
        {"along": "u", "values": [1.0] * 501},
        {"over": "speed"},
    ],
)
def test_what_is_refused(table: dict[str, Any]) -> None:
    case = str(table) if len(str(table)) < 100 else "501 values"
    question = {"kind": "run-up", "until": 10.0} | table
    check_refusal(f"run-up, many: {case}", lambda: run(RunUp.from_table(question), load_machine(MACHINE)))


@cache
def whole() -> xr.Dataset:
    return run(asked(), load_machine(MACHINE))


@cache
def gathered() -> xr.Dataset:
    """Runs of ten turns: the stronger drive makes them in less time."""
    return run(RunUp(turns=10, start=STARTS[0], along="u", values=[0.5, 5.0]), load_machine(MACHINE))


def test_shorter_runs_are_padded_at_their_end() -> None:
    result = gathered()
    lengths = np.isfinite(result.time.values).sum(axis=1)
    assert lengths[0] != lengths[1] and max(lengths) == result.sizes["sample"]
    assert result.speed.dims == ("case", "body", "sample") and "radius" not in result
    for k, value in enumerate((0.5, 5.0)):
        alone = run(RunUp(turns=10, start=STARTS[0]), load_machine(MACHINE, {"u": value}))
        inside = np.isfinite(result.time.values[k])
        assert inside[: lengths[k]].all(), "at the end"
        assert np.isnan(result.speed.values[k][:, ~inside]).all() and np.isnan(result.amplitude.values[k][~inside]).all()
        assert result.time.values[k][inside][-1] == alone.time.values[-1]
    s = result.wucht.summary
    assert (s["outcome"], s["outcomes"]) == ("unidentified", {"unidentified": 2})
    assert result.attrs["outcome"] == "unidentified" and s["sentence"] == "2 unidentified"
    assert {w[:5] for w in result.wucht.warnings if "run at least" in w} == {"u = 0", "u = 5"}


def test_one_outcome_of_all_runs_counts_only_when_all_are_there() -> None:
    """The first run is shown while it is under way; the others when they are complete, else they would count as finished."""
    for share, finished in ((0.3, 0), (0.6, 1)):

        def stop(done: float, _what: str, share: float = share) -> None:
            if done > share:
                raise KeyboardInterrupt

        part = run(RunUp(until=50.0, along="u", values=[0.5, 5.0]), load_machine(MACHINE), progress=stop)
        s = part.wucht.summary
        assert (s["outcome"], part.attrs["outcome"], len(s["cases"])) == (None, "several", 1)
        assert f"{finished} of 2 runs are finished" in part.wucht.warnings


@pytest.mark.parametrize("over", ["phi", "psi"])
def test_the_abscissa_is_that_of_each_model(over: str) -> None:
    """The angle of the rotor, or the mean angle of its bodies to it."""
    machine = load_machine(MACHINE)
    result = run(RunUp(until=20.0, starts=STARTS, over=over, model="both"), machine)
    alone = run(RunUp(until=20.0, start=STARTS[1], model="both"), machine)
    for model in ("", "slow_"):
        angle = alone[f"{model}angle"].values
        expected = angle[0] - angle[0, 0] if over == "phi" else angle[1:].mean(axis=0) - angle[0]
        found = result[f"{model}abscissa"].values[1]
        assert found[np.isfinite(found)][-1] == pytest.approx(expected[-1], rel=1e-9)


def test_a_long_run_is_stored_with_as_many_samples_as_a_figure_shows() -> None:
    machine = load_machine(MACHINE)
    alone = run(RunUp(until=5000.0, start=STARTS[0]), machine)
    every = math.ceil(alone.sizes["time"] / 20_000)
    assert every > 1
    result = run(RunUp(until=5000.0, starts=STARTS[:1]), machine)
    assert result.time.values[0].tolist() == alone.time.values[::every].tolist()


def test_deviations_are_full_less_slow() -> None:
    """At equal angle of the rotor, by interpolation between the samples of both."""
    result = run(RunUp(until=200.0, start=STARTS[0], model="both"), load_machine(MACHINE))
    at, angle, slow = result.compared.values, result.angle.values[0], result.slow_angle.values[0]
    for name, values, of_slow in (
        ("speed", result.speed.values[0], result.slow_speed.values[0]),
        ("radius", result.radius.values, result.slow_radius.values),
    ):
        expected = np.interp(at, angle, values) - np.interp(at, slow[np.isfinite(slow)], of_slow[np.isfinite(slow)])
        assert result[f"{name}_deviation"].values == pytest.approx(expected, abs=0.02 * np.ptp(values))
    largest = result.wucht.summary["deviations"]["at_equal_angle"]
    assert largest["speed"] == pytest.approx(float(np.abs(result.speed_deviation).max()), rel=1e-6)
    told = f"  deviation    speed {largest['speed']:.5g}, amplitude {largest['amplitude']:.5g} at most, at equal angle"
    assert told in report(result)


def test_amplitudes_that_are_small_early_have_a_shorter_time() -> None:
    """The speeds settle in 100 s, amplitudes are small after 4 s: drawn until 6 s, and the whole runs below."""
    made = run(asked(until=50.0, starts=(), start=STARTS[0]), load_machine(MACHINE))
    time = np.linspace(0.0, 400.0, made.sizes["sample"])
    made["time"] = (made.time.dims, np.broadcast_to(time, made.time.shape).copy(), made.time.attrs)
    made["amplitude"] = (made.amplitude.dims, np.where(made.time.values <= 4.0, 1.0, 0.04), made.amplitude.attrs)
    cases = [case | {"settling_time": 100.0, "amplitude_settling_time": None} for case in made.wucht.summary["cases"]]
    axes = draw(with_answer(made, cases=cases)).axes
    last = float(time[time <= 4.0][-1])
    assert [axis.get_xlim()[1] for axis in axes] == pytest.approx([150.0, 1.5 * last, 400.0], rel=0.2)
