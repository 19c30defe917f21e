"""The study from the command line: its template, a real front, and its refusals."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from tests.refusals import check_file, check_refusal

from wucht import run as ask
from wucht import run_file
from wucht.cli.options import parse_settings
from wucht.dynamics.balancers.candidates import evaluate_batch
from wucht.dynamics.sampling.choice import Scores
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.studies.registry import study_of
from wucht.studies.study_file import read_study

pytestmark = pytest.mark.usefixtures("no_figures")


WRONG = [
    "vary={}", "vary.damping=[1]", "vary.damping=[2e-4, 1e-4]", 'vary.damping=["1 mm", 1]', "vary.damping=[-1, 1]",
    'vary={"dampin": [1, 2]}', 'vary={"length": {"of": ["p3"], "range": [1, 2]}}', 'vary={"drum.unbalance": [1e-4, 2e-4]}',
    'vary={"mass": [1e-3, 2e-3], "p1.mass": [1e-3, 2e-3]}', 'objectives=["settling"]', 'objectives=["peak", "peak"]',
    "objectives=[]", "bodies=[0]", "bodies=[2, 2]", "unbalance=[0, 1e-4]", "evaluations=4", "samples=1", "model=both",
    "inertia=true", 'start={"psi": 1}', 'start={"drum": 1, "p3": 1}', "evaluation=9",
]  # fmt: skip


@pytest.mark.parametrize("setting", WRONG)
def test_bad_input_is_one_sentence(setting: str, here: Path) -> None:
    check_file("optimise-balancer", str(study_of("optimise-balancer").template), {}, parse_settings([f"study.{setting}"]))


@pytest.mark.parametrize(
    ("name", "more"), [("drozdetskaya-2020/figure-5.4", {"study.model": "slow"}), ("practice/screen", dict[str, str]())]
)
def test_machines_without_balancing_bodies(name: str, more: dict[str, str]) -> None:
    asked = {"study.kind": "optimise-balancer", "study.vary": {"damping": [1, 2]}} | more
    check_refusal(f"optimise-balancer of {name}", lambda: run_file(name, asked))


@pytest.mark.slow
def test_the_file_of_the_catalogue_gives_what_its_notes_say() -> None:
    """And 256 other runs of each candidate that it was compared with leave the recommended one the best, but for chance."""
    study = read_study("sperling-rollers/damping-optimum")
    s = ask(study.spec, study.subject).wucht.summary
    own, recommended = s["as_it_is"]["checked"], s["recommended"]
    assert recommended["settling_time"] < 0.65 * own["settling-time"] and recommended["fails"] == 0
    assert 0.9e-4 < recommended["parameters"]["damping"] < 1.6e-4
    assert s["front"][recommended["point"]]["holds"]
    assert {"as it is", "damping curve", "neighbour"} <= {r["what"] for r in s["compared"]}
    assert s["damping"]["of_rates"] == pytest.approx(1.34e-4, rel=0.03)
    assert 1.05e-4 < s["damping"]["optimum"] < 1.35e-4
    assert any(p["objectives"]["residual"] == 0 for p in s["front"])
    trials = study.spec.prepare(study.subject)[0].as_it_is
    fresh = replace(trials, samples=256, stream=77)
    rows = [r for r in s["compared"] if r["fails"] == 0]
    numbers = np.array([[r["parameters"][v.name] for v in trials.variables] for r in rows])
    runs = evaluate_batch(fresh, "full", numbers, lambda _share: None)
    scores = Scores(runs.times, runs.outcome != OUTCOMES.index(Outcome.COMPENSATED))
    k = next(i for i, r in enumerate(rows) if r["parameters"] == recommended["parameters"])
    assert scores.medians[k] == pytest.approx(recommended["settling_time"], abs=3 * recommended["error"])
    assert scores.medians[k] < scores.medians.min() + 2 * recommended["error"]
