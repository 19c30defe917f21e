"""A value at which no run has a verdict has no probability: the others have theirs, and it says how long a run must be."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
import xarray as xr
from scipy.integrate import solve_ivp

from known_basins import MACHINE, engine
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up import run_to_end
from wucht.dynamics.sampling.ensemble_run import RunAdvice, member_advice
from wucht.dynamics.sampling.ensembles import EnsembleQuestion, MemberOutcomes
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.files.building import machine_from
from wucht.studies.capture_probability import computation as running
from wucht.studies.capture_probability.spec import CaptureProbability
from wucht.studies.runner import draw, report
from wucht.studies.runner import run as ask

ASKED: dict[str, Any] = {
    "along": "u", "range": [1.0, 3.0], "points": 3, "random": {"psi": {"uniform": [0.0, 2 * math.pi]}}, "samples": 64,
}  # fmt: skip
ADVICE = RunAdvice("the motion is still transient: run at least until 500 s", 500.0)
UNIDENTIFIED = OUTCOMES.index(Outcome.UNIDENTIFIED)


class Undecided:
    """Runs without a verdict but for some, at some values of u; members: how many were made."""

    def __init__(self, decided: int = 0, at: tuple[float, ...] = (1.0,)) -> None:
        self.decided, self.at, self.members = decided, at, 0

    def __call__(self, question: Any, starts: np.ndarray, values: Any, report: Any = None) -> MemberOutcomes:
        outcomes = engine(lambda psi, _: psi > 1.0)(question, starts, values, report)
        if question.machine.values["u"] in self.at:
            outcomes.outcome[: max(0, len(outcomes.outcome) - self.decided)] = UNIDENTIFIED
        self.members += starts.shape[1]
        return outcomes


def asked(monkeypatch: pytest.MonkeyPatch, runs: Undecided, one_by_one: bool = False, **more: Any) -> xr.Dataset:
    monkeypatch.setattr(running, "outcomes_of", runs)
    monkeypatch.setattr(running, "member_advice", lambda *_: ADVICE)
    monkeypatch.setattr(running, "batching_obstacle", lambda _: "it is a test" if one_by_one else None)
    return ask(CaptureProbability(**ASKED | more), MACHINE)


@pytest.mark.parametrize("undecided", [1.0, 2.0, 3.0])
@pytest.mark.parametrize(("one_by_one", "runs"), [(False, 64), (True, 16)])
def test_each_value_is_tried(monkeypatch: pytest.MonkeyPatch, one_by_one: bool, runs: int, undecided: float) -> None:
    """Those with a verdict have their probability, wherever the one without is: there, where each run takes long, one run of
    each of the 16 replicates is made."""
    made = Undecided(at=(undecided,))
    result = asked(monkeypatch, made, one_by_one, until=20.0)
    s = result.wucht.summary
    assert made.members == s["runs"] == 2 * 64 + runs
    assert result.attrs["finished"] == 1 and s["values"] == [3, 3]
    whole = asked(monkeypatch, Undecided(at=()), one_by_one)
    for one, other in zip(s["probability"], whole.wucht.summary["probability"], strict=True):
        if one["u"] == undecided:
            assert (one["estimate"], one["low"], one["high"], one["not_identified"]) == (None, 0.0, 1.0, 1.0)
            assert (one["advice"], one["advised_time"]) == (ADVICE.sentence, 500.0)
        else:
            assert one == other and "advice" not in one
    assert (s["advised_time"], s["advice"]) == (500.0, ADVICE.sentence)
    assert s["sentence"].endswith("; no probability at 1 of 3 values") and "0 to 100 %" not in s["sentence"]
    (warning,) = [w for w in result.wucht.warnings if "verdict" in w]
    assert warning.startswith(f"there is no probability at u = {undecided:g}: no run there has a verdict (the motion is still")
    assert warning.endswith("; give a longer study.until than 20, as 500")
    assert draw(result).get_axes()


@pytest.mark.parametrize(("one_by_one", "runs"), [(False, 3 * 64), (True, 3 * 16)])
def test_where_no_value_has_a_probability(monkeypatch: pytest.MonkeyPatch, one_by_one: bool, runs: int) -> None:
    """The answer says so, and how long a run must be; nothing is searched."""
    made = Undecided(at=(1.0, 2.0, 3.0))
    result = asked(monkeypatch, made, one_by_one, until=20.0, probability=0.5)
    s = result.wucht.summary
    assert made.members == s["runs"] == runs and s["searched"] == 0
    assert s["sentence"] == f"there is no probability: none of {runs} runs at 3 values of u has a verdict"
    assert any("at u = 1, 2, 3: no run there" in w and "run at least until 500 s" in w for w in result.wucht.warnings)
    assert "; fewer at 3 of them" in "\n".join(report(result)) or not one_by_one
    assert draw(result).get_axes()


@pytest.mark.parametrize(
    ("undecided", "sentence"),
    [
        (1.0, "at least 0.5 of the starts end as compensated or passed from u = 1.0"),
        (3.0, "whether 0.5 is reached is not known"),
    ],
)
def test_a_target_beside_a_value_without_a_probability(
    monkeypatch: pytest.MonkeyPatch, undecided: float, sentence: str
) -> None:
    """Five in six pass: the search comes down to the undecided value; where the last one is, nothing can be said."""
    result = asked(monkeypatch, Undecided(at=(undecided,)), probability=0.5)
    assert sentence in result.wucht.summary["sentence"]


@pytest.mark.parametrize("decided", [0, 64])
def test_a_single_value_has_a_bar_in_the_figure(monkeypatch: pytest.MonkeyPatch, decided: int) -> None:
    """A band over one value has no width. Without an estimate nothing is named one; no mark is cut off at the rim."""
    result = asked(monkeypatch, Undecided(decided), until=20.0).isel(parameter=[0])
    figure = draw(result)
    (axis,) = figure.get_axes()
    bars = [band.get_paths()[0].get_extents() for band in axis.collections]
    assert len(bars) == 1 + (not decided), "the band, and the share without a verdict"
    low, high = axis.get_xlim()
    for bar in bars:
        assert bar.width > 0.005 * (high - low) and low < bar.x0 < 1.0 < bar.x1 < high
    assert bars[0].y0 == result.low.values[0] and bars[0].y1 == result.high.values[0]
    names = [text.get_text() for text in axis.get_legend().get_texts()]
    assert ("estimate" in names) is bool(decided)


@pytest.mark.parametrize("one_by_one", [False, True])
def test_one_verdict_is_enough_to_go_on(monkeypatch: pytest.MonkeyPatch, one_by_one: bool) -> None:
    made = Undecided(decided=1)
    result = asked(monkeypatch, made, one_by_one)
    s = result.wucht.summary
    assert made.members == s["runs"] == 3 * 64
    assert s["advice"] is s["advised_time"] is None
    assert result.not_identified.values[0] == pytest.approx(1 - (2 if one_by_one else 1) / 64)


def test_runs_one_by_one_are_those_of_batches(monkeypatch: pytest.MonkeyPatch) -> None:
    """The first of each replicate are made first, and put back into their places."""
    together, alone = (asked(monkeypatch, Undecided(decided=10**6), one_by_one) for one_by_one in (False, True))
    for name in ("estimate", "low", "high", "not_identified"):
        assert np.array_equal(together[name], alone[name])


def test_failed_runs_are_named_by_their_samples(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(running, "outcomes_of", engine(lambda psi, _: psi > 1.0, fail=lambda psi, _: psi > -10.0))
    monkeypatch.setattr(running, "member_advice", lambda *_: RunAdvice(None, None))
    monkeypatch.setattr(running, "batching_obstacle", lambda _: "it is a test")
    spec = CaptureProbability(**ASKED)
    result = ask(spec, MACHINE)
    psi = running.prepare(spec, MACHINE).samples[0, [0, 4, 8]]
    failures = [w for w in result.wucht.warnings if "failed: it is a test" in w]
    assert [f"psi = {x:.6g} failed" in w for x, w in zip(psi, failures, strict=True)] == [True] * 3
    assert result.wucht.warnings[-1] == "45 more runs failed"
    assert "; give study.until" in "\n".join(result.wucht.warnings)


def final_speeds(unbalances: np.ndarray, slope: float, end: float) -> np.ndarray:
    """Final speeds (N,) of a rotor with each of some unbalances, 10 kg on springs of 1e5 N/m, run up from rest, by SciPy."""
    mass, inertia, stiffness, damping, count = 10.0, 0.02, 1e5, 60.0, len(unbalances)

    def rates(_t: float, s: np.ndarray) -> np.ndarray:
        x, y, u, v, angle, speed = s.reshape(6, count)
        sine, cosine = np.sin(angle), np.cos(angle)
        fx = unbalances * speed**2 * cosine - damping * u - stiffness * x
        fy = unbalances * speed**2 * sine - damping * v - stiffness * y
        torque = slope * (150.0 - speed) + unbalances / mass * (fx * sine - fy * cosine)
        change = torque / (inertia - unbalances**2 / mass)
        accelerations = (fx + unbalances * sine * change) / mass, (fy - unbalances * cosine * change) / mass
        return np.concatenate([u, v, *accelerations, speed, change])

    run = solve_ivp(rates, (0.0, end), np.zeros(6 * count), "DOP853", t_eval=[end], rtol=1e-8, atol=1e-9)
    return np.asarray(run.y[5 * count :, -1])


def test_a_machine_whose_first_value_is_undecided() -> None:
    """Its weak motor still accelerates, a tenth of the way, when the runs end. The other one passes with the small unbalances,
    of those from 2 to 12 g m, which an integration of our own finds."""
    body = {"kind": "rotor", "name": "drum", "mass": 5.0, "unbalance": 5e-3, "inertia": 0.02}
    machine = machine_from({
        "carrier": {"mass": 5.0, "directions": "xy", "stiffness": 1e5, "damping": 60.0}, "bodies": [body],
        "drive": {"kind": "linear", "on": "drum", "slope": 0.01, "no_load_speed": 150.0},
    })  # fmt: skip
    keys: dict[str, Any] = {
        "along": "drive.slope", "range": [1e-4, 0.01], "points": 2, "samples": 64, "until": 20.0,
        "random": {"drum.unbalance": {"uniform": [2e-3, 12e-3]}},
    }  # fmt: skip
    first, second = ask(CaptureProbability(**keys), machine).wucht.summary["probability"]
    unbalances = np.linspace(2e-3, 12e-3, 51)
    assert np.ptp(final_speeds(unbalances, 1e-4, 20.0)) < 1.0, "nowhere near the resonance at 100 rad/s"
    assert first["estimate"] is None and first["not_identified"] == 1.0 and first["advised_time"] > 20.0
    passes = final_speeds(unbalances, 0.01, 20.0) > 110.0
    assert passes[: passes.sum()].all(), "one limit"
    known = (unbalances[passes.sum()] - 2e-3) / 10e-3
    assert 0.3 < known < 0.5 and second["low"] < known < second["high"] < second["low"] + 0.2
    assert second["not_identified"] == 0.0
    assert second["estimate"] == pytest.approx(known, abs=2 / 64 + 0.02), "samples that are spread evenly, and a step"


def test_the_advice_is_that_of_the_run_up() -> None:
    """Of the same start, for as long: its verdict says how long it must run."""
    machine, start = MACHINE.with_values({"u": 1.5}), {"psi": 1.0, "delta": 0.5}
    question = EnsembleQuestion(MACHINE, ("u",), until=40.0)
    advice = member_advice(question, initial_state(machine, start), {"u": 1.5})
    verdict = run_to_end(machine, start, RunSettings(until=40.0, tolerance=question.tolerance)).verdict
    assert verdict.outcome is Outcome.UNIDENTIFIED
    assert advice == RunAdvice(verdict.advice, verdict.needed_time) and advice.needed_time is not None
