"""Several runs of unlike lengths that are made by hand, gathered in one result."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import xarray as xr

from wucht.results.quantities import Quantity, StudyResult
from wucht.studies.run_up import combined_runs


def one(
    outcome: str, count: int, warnings: tuple[str, ...] = (), failure: str | None = None, slow: bool = False
) -> StudyResult:
    """A run with the speed 10 t, the amplitude 1 - t and a variable that is not stored."""
    time = np.arange(float(count))
    quantities = [
        Quantity("outcome", outcome, "outcome"),
        Quantity("final_speed", 10.0 * time[-1], "final speed", "rad/s"),
        Quantity("time", time, "time", "s", "time"),
        Quantity("speed", [10.0 * time], "speed", "rad/s", "body time"),
        Quantity("amplitude", 1.0 - time, "amplitude", "m", "time"),
        Quantity("radius", time, "radius", "m", "time"),
    ]
    if slow:
        quantities += [Quantity(f"slow_{n}", [time], n, "rad", "body time") for n in ("angle", "speed")]
    return StudyResult(quantities, outcome, warnings, (), failure)


def gathered(*answers: StudyResult, finished: int | None = None, over: str = "time", planned: int = 3) -> xr.Dataset:
    cases = [SimpleNamespace(label=f"u = {k}", start={"p1": k / 10}, value=float(k)) for k in range(planned)]
    plan: Any = SimpleNamespace(
        cases=cases, spec=SimpleNamespace(over=over, along="u"), machine=SimpleNamespace(units=SimpleNamespace(time="s"))
    )
    return combined_runs.gather_runs(plan, answers, len(answers) if finished is None else finished)


def test_shorter_runs_are_padded_at_their_end() -> None:
    made = gathered(one("passed", 4), one("captured", 2, ("slowly",)), one("passed", 3))
    nan = float("nan")
    assert made.time.values == pytest.approx(np.array([[0, 1, 2, 3], [0, 1, nan, nan], [0, 1, 2, nan]]), nan_ok=True)
    assert made.speed.values[:, 0] == pytest.approx(10.0 * made.time.values, nan_ok=True)
    assert made.amplitude.values == pytest.approx(1.0 - made.time.values, nan_ok=True)
    assert made.speed.dims == ("case", "body", "sample") and "radius" not in made
    assert made.case.values.tolist() == ["u = 0", "u = 1", "u = 2"] and made.time.attrs["units"] == "s"
    s = made.wucht.summary
    assert s["outcomes"] == {"passed": 2, "captured": 1} and s["outcome"] is None and made.attrs["outcome"] == "several"
    assert s["sentence"] == "2 passed, 1 captured" and made.wucht.warnings == ["u = 1: slowly"]
    assert [(c["label"], c["start"], c["value"], c["final_speed"]) for c in s["cases"]] == [
        ("u = 0", {"p1": 0.0}, 0.0, 30.0), ("u = 1", {"p1": 0.1}, 1.0, 10.0), ("u = 2", {"p1": 0.2}, 2.0, 20.0),
    ]  # fmt: skip
    assert made.wucht.unit_at("cases[1].final_speed") == "rad/s"


def test_one_outcome_of_all_runs_counts_only_when_all_are_there() -> None:
    same = (one("passed", 2), one("passed", 3))
    whole = gathered(*same, planned=2)
    assert (whole.wucht.summary["outcome"], whole.attrs["outcome"], whole.wucht.warnings) == ("passed", "passed", [])
    part = gathered(*same)
    assert part.wucht.summary["outcome"] is None and part.wucht.warnings == ["2 of 3 runs are finished"]
    begun = gathered(*same, finished=1, planned=2)
    assert begun.attrs["outcome"] == "several" and begun.wucht.warnings == ["1 of 2 runs are finished"]
    assert gathered(one("passed", 2), one("failed", 2, (), "it burst")).wucht.failure == "it burst"


@pytest.mark.parametrize(("over", "expected"), [("phi", 100.0), ("psi", 200.0)])
def test_the_abscissa_is_that_of_each_model(over: str, expected: float, monkeypatch: pytest.MonkeyPatch) -> None:
    for name, at in (("rotor_angle", 100.0), ("mean_phase", 200.0)):
        values = lambda run, model, at=at: np.full(run.sizes["time"], at + (1.0 if model == "slow_" else 0.0))  # noqa: E731
        monkeypatch.setattr(combined_runs, name, values)
    made = gathered(one("passed", 3, slow=True), over=over, planned=1)
    assert made.abscissa.values.tolist() == [[expected] * 3] and made.slow_abscissa.values.tolist() == [[expected + 1.0] * 3]
    assert "slow_abscissa" not in gathered(one("passed", 3), over=over, planned=1)
    assert "abscissa" not in gathered(one("passed", 3), planned=1)


def test_a_long_run_is_stored_with_as_many_samples_as_a_figure_shows(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(combined_runs, "_MOST_SAMPLES", 4)
    for count, kept in ((4, [0, 1, 2, 3]), (5, [0, 2, 4]), (9, [0, 3, 6])):
        assert gathered(one("passed", count), planned=1).time.values.tolist() == [kept]
