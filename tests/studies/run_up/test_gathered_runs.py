"""Several runs of unlike lengths in one result, and both models of one."""

from __future__ import annotations

import math

import numpy as np
import pytest
import xarray as xr
from tests.interrupting import stop_at

import wucht

MACHINE = "drozdetskaya-2020/table-5.1"
STARTS = ({"psi": 0.0, "delta": 0.5}, {"psi": 1.0, "delta": 2.0})


@pytest.fixture(scope="module")
def gathered() -> xr.Dataset:
    """Runs of ten turns: the stronger drive makes them in less time."""
    machine = wucht.load_machine(MACHINE)
    return wucht.run(wucht.RunUp(turns=10, start=STARTS[0], along="u", values=[0.5, 5.0]), machine)


def test_shorter_runs_are_padded_at_their_end(gathered: xr.Dataset) -> None:
    lengths = np.isfinite(gathered.time.values).sum(axis=1)
    assert lengths[0] != lengths[1] and max(lengths) == gathered.sizes["sample"]
    assert gathered.speed.dims == ("case", "body", "sample") and "radius" not in gathered
    for k, value in enumerate((0.5, 5.0)):
        alone = wucht.run(wucht.RunUp(turns=10, start=STARTS[0]), wucht.load_machine(MACHINE, {"u": value}))
        inside = np.isfinite(gathered.time.values[k])
        assert inside[: lengths[k]].all(), "at the end"
        assert np.isnan(gathered.speed.values[k][:, ~inside]).all() and np.isnan(gathered.amplitude.values[k][~inside]).all()
        assert gathered.time.values[k][inside][-1] == alone.time.values[-1]
    s = gathered.wucht.summary
    assert (s["outcome"], s["outcomes"]) == ("unidentified", {"unidentified": 2})
    assert gathered.attrs["outcome"] == "unidentified" and s["sentence"] == "2 unidentified"
    assert [(c["label"], c["value"]) for c in s["cases"]] == [("u = 0.5", 0.5), ("u = 5", 5.0)]
    assert {w[:5] for w in gathered.wucht.warnings if "run at least" in w} == {"u = 0", "u = 5"}


def test_a_line_of_the_report_for_each(gathered: xr.Dataset) -> None:
    _, verdict, *lines, _ = wucht.report(gathered)
    assert verdict == "verdict: 2 unidentified"
    assert lines == [
        f"  {c['label']:7}  unidentified         {c['final_speed']:.5g}, amplitude {c['final_amplitude']:.5g}"
        for c in gathered.wucht.summary["cases"]
    ]


def test_one_outcome_of_all_runs_counts_only_when_all_are_there() -> None:
    """The first run is shown while it is under way; the others when they are complete, else they would count as finished."""
    machine, question = wucht.load_machine(MACHINE), wucht.RunUp(until=50.0, along="u", values=[0.5, 5.0])
    for share, finished in ((0.3, 0), (0.6, 1)):

        def stop(done: float, _what: str, share: float = share) -> None:
            if done > share:
                raise KeyboardInterrupt

        part = wucht.run(question, machine, progress=stop)
        s = part.wucht.summary
        assert (s["outcome"], part.attrs["outcome"], len(s["cases"])) == (None, "several", 1)
        assert f"{finished} of 2 runs are finished" in part.wucht.warnings


def test_each_case_has_its_value_and_its_start() -> None:
    question = wucht.RunUp(until=5.0, along="u", values=(1.0, 5.0), starts=({"psi": 0.0}, {"psi": 1.0}))
    machine = wucht.load_machine(MACHINE)
    assert question.settings.runs == 4, "they share the memory"
    result = wucht.run(question, machine)
    cases = [(c["value"], c["start"], c["label"]) for c in result.wucht.summary["cases"]]
    assert cases == [(value, {"psi": psi}, f"u = {value:g}; psi = {psi:g}") for value in (1.0, 5.0) for psi in (0.0, 1.0)]
    single = wucht.RunUp(until=5.0, stored_samples=1000)
    both = single.model_copy(update={"model": "both"})
    numbers = [one.stored_numbers(one.prepare(machine)) for one in (single, both)]
    assert numbers[1] == 2 * numbers[0], "of all models"


@pytest.mark.parametrize("over", ["phi", "psi"])
def test_the_abscissa_is_that_of_each_model(over: str) -> None:
    """The angle of the rotor, or the mean angle of its bodies to it."""
    machine = wucht.load_machine(MACHINE)
    result = wucht.run(wucht.RunUp(until=20.0, starts=STARTS, over=over, model="both"), machine)
    alone = wucht.run(wucht.RunUp(until=20.0, start=STARTS[1], model="both"), machine)
    for model in ("", "slow_"):
        angle = alone[f"{model}angle"].values
        expected = angle[0] - angle[0, 0] if over == "phi" else angle[1:].mean(axis=0) - angle[0]
        found = result[f"{model}abscissa"].values[1]
        assert found[np.isfinite(found)][-1] == pytest.approx(expected[-1], rel=1e-9)
    assert "abscissa" not in wucht.run(wucht.RunUp(until=5.0, starts=STARTS), machine)


def test_a_long_run_is_stored_with_as_many_samples_as_a_figure_shows() -> None:
    machine, question = wucht.load_machine(MACHINE), {"until": 5000.0, "start": STARTS[0]}
    whole = wucht.run(wucht.RunUp(**question), machine)
    every = math.ceil(whole.sizes["time"] / 20_000)
    assert every > 1
    result = wucht.run(wucht.RunUp(until=5000.0, starts=STARTS[:1]), machine)
    assert result.time.values[0].tolist() == whole.time.values[::every].tolist()


def test_deviations_are_full_less_slow() -> None:
    """At equal angle of the rotor, by interpolation between the samples of both."""
    machine = wucht.load_machine(MACHINE)
    result = wucht.run(wucht.RunUp(until=200.0, start=STARTS[0], model="both"), machine)
    at, angle, slow = result.compared.values, result.angle.values[0], result.slow_angle.values[0]
    for name, values, of_slow in (
        ("speed", result.speed.values[0], result.slow_speed.values[0]),
        ("radius", result.radius.values, result.slow_radius.values),
    ):
        expected = np.interp(at, angle, values) - np.interp(at, slow[np.isfinite(slow)], of_slow[np.isfinite(slow)])
        size = np.ptp(values)
        assert result[f"{name}_deviation"].values == pytest.approx(expected, abs=0.02 * size)
    largest = result.wucht.summary["deviations"]["at_equal_angle"]
    assert largest["speed"] == pytest.approx(float(np.abs(result.speed_deviation).max()), rel=1e-6)
    assert (
        f"  deviation    speed {largest['speed']:.5g}, amplitude {largest['amplitude']:.5g} at most, at equal angle"
        in wucht.report(result)
    )
    assert any(line.startswith(f"  slow         {result.wucht.summary['slow']['outcome']}, ") for line in wucht.report(result))


def test_a_result_so_far_is_that_of_the_first_run() -> None:
    result = wucht.run(wucht.RunUp(until=50.0, starts=STARTS), wucht.load_machine(MACHINE), progress=stop_at(3))
    assert not result.attrs["finished"] and result.sizes["case"] == 1
