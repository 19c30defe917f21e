"""Questions to machines of the catalogue that go through as much of the program as they can in a few seconds.

Each machine was asked every question, and those remain that come to lines which none of the others comes to. Where a number
here is right, is shown elsewhere: tests of studies, and tests/validation.
"""

from __future__ import annotations

import pytest
from tests import stated

from wucht import draw, run
from wucht.studies.study_file import read_study

QUESTIONS = {
    "drozdetskaya-2020/failure-of-the-specimen": (
        "failure-detection", "load-spectrum", "response", "run-up", "start-stop", "synchronous-states",
    ),
    "drozdetskaya-2020/figure-2.13": ("phase-portrait",),
    "drozdetskaya-2020/figure-2.5": ("phase-portrait",),
    "drozdetskaya-2020/figure-5.10": ("response",),
    "drozdetskaya-2020/figure-5.14": ("coast-down", "run-up"),
    "drozdetskaya-2020/figure-6.2": ("activation",),
    "drozdetskaya-2020/figure-6.7a": ("approximation", "load-spectrum", "start-stop"),
    "drozdetskaya-2020/table-3.1-carrier": ("coast-down", "response"),
    "kaltofen-cam/dwell-and-return": ("cam-contour", "cam-law", "cam-prediction"),
    "practice/balls-at-resonance-thick-oil": ("run-up", "synchronous-states"),
    "practice/exciter-design": ("run-up",),
    "practice/exciter": ("synchronous-states",),
    "practice/fan-on-belt": ("torque-balance",),
    "practice/fan-on-inverter": ("run-up",),
    "practice/screen": ("coast-down", "torque-balance"),
    "practice/screen-loaded": ("drive-failure",),
    "practice/screen-unsynchronised": ("coast-down", "run-up", "start-stop"),
    "sperling-rollers/figure-10": ("synchronous-states",),
    "sperling-rollers/figure-7": ("load-spectrum",),
    "sperling-rollers/figure-8": ("start-stop",),
    "sperling-rollers/stability-map": ("synchronous-states",),
    "sperling-rollers/table-2": ("response",),
    "sperling-vibration/against-the-drive": ("phase-portrait",),
    "sperling-vibration/entrainment-band": ("approximation",),
    "sperling-vibration/figure-2a": ("approximation", "coast-down", "phase-portrait", "torque-balance"),
    "sperling-vibration/figure-2b": ("load-spectrum",),
}  # fmt: skip
SHORT = {"run-up": {"study.until": 0.5}}
QUICK = {  # a second or less
    ("drozdetskaya-2020/failure-of-the-specimen", "run-up"), ("drozdetskaya-2020/figure-2.5", "phase-portrait"),
    ("drozdetskaya-2020/figure-5.14", "run-up"), ("drozdetskaya-2020/figure-6.7a", "load-spectrum"),
    ("kaltofen-cam/dwell-and-return", "cam-law"), ("practice/exciter-design", "run-up"),
    ("practice/exciter", "synchronous-states"), ("practice/fan-on-inverter", "run-up"), ("practice/screen", "coast-down"),
    ("practice/screen", "torque-balance"), ("practice/screen-unsynchronised", "coast-down"),
    ("practice/screen-unsynchronised", "run-up"), ("sperling-vibration/figure-2a", "approximation"),
    ("sperling-vibration/figure-2a", "torque-balance"), ("sperling-vibration/figure-2b", "load-spectrum"),
}  # fmt: skip


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        pytest.param(name, kind, marks=() if (name, kind) in QUICK else pytest.mark.slow)
        for name, kinds in QUESTIONS.items()
        for kind in kinds
    ],
)
def test_all_of_a_result_is_as_stated(name: str, kind: str) -> None:
    study = read_study(name, {"study.kind": kind} | SHORT.get(kind, {}))
    result = run(study.spec, study.subject)
    stated.check(f"{name}-{kind}", result, draw(result))
