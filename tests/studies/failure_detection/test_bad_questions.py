"""What can be asked wrongly of a failure: one sentence with key, what was given and what is allowed."""

from __future__ import annotations

from typing import Any

import pytest
from test_failing_machine import LINE, SENSOR, START, WHOLE, exciter
from tests.refusals import check_refusal, refused

import wucht

FAILURE = {"remaining": 0.8, "direction": "x", "woehler": LINE}
ASKED = {"until": 8.0, "start": START, "sensor": SENSOR, "after": 0.5, "failure": FAILURE}
FALLS = exciter((4.0, WHOLE), (4.5, 0.8 * WHOLE), interpolation="linear")
STAYS = exciter((4.0, WHOLE), (4.5, WHOLE))

QUESTIONS: dict[str, dict[str, Any]] = {
    "no sensor": {"sensor": None}, "sensor misspelt": {"sensor": SENSOR | {"intervall": 1}},
    "no noise": {"sensor": {"interval": 0.1, "false_alarm_every": 60.0}}, "silent": {"sensor": SENSOR | {"noise": 0}},
    "alarms": {"sensor": SENSOR | {"false_alarm_every": 0.5}}, "too fast": {"sensor": SENSOR | {"interval": 1e-4}},
    "a unit": {"sensor": SENSOR | {"interval": "1 m"}}, "law": {"failure": FAILURE | {"law": "sudden"}},
    "grows": {"failure": FAILURE | {"remaining": 1.0}}, "no line": {"failure": {"remaining": 0.8}},
    "line": {"failure": FAILURE | {"woehler": LINE | {"k2": 9, "miner": "haibach"}}},
    "interval": {"failure": FAILURE | {"interval": 0.07}}, "gradual": {"failure": FAILURE | {"law": "linear"}},
    "a number": {"failure": 0.8}, "late": {"after": 9.0}, "no range": {"along": "drive.slope"},
    "second alone": {"second": "drive.slope", "second_range": [1, 2]},
    "second twice": {"along": "drive.slope", "range": [1, 2], "second": "drive.slope", "second_range": [1, 2]},
    "one point": {"along": "drive.slope", "range": [1, 2], "points": 1},
}  # fmt: skip


@pytest.mark.parametrize("name", QUESTIONS)
def test_questions_that_are_refused(name: str) -> None:
    check_refusal(f"failure-detection: {name}", lambda: wucht.FailureDetection(**ASKED | QUESTIONS[name]))


NONE = {"failure": None}
MACHINES: dict[str, tuple[wucht.Machine, dict[str, Any]]] = {
    "no failure": (exciter(), NONE), "both": (FALLS, {}), "stays": (STAYS, NONE), "ends early": (FALLS, NONE | {"until": 4.2}),
    "learns late": (FALLS, NONE | {"after": 3.5, "learning": 1.0}),
    "slow sensor": (FALLS, NONE | {"sensor": SENSOR | {"interval": 0.3}}),
    "few readings": (exciter(), {"sensor": SENSOR | {"interval": 1.0}}),
    "not a stiffness": (exciter(), {"failure": FAILURE | {"parameter": "carrier.damping"}}),
    "unknown": (exciter(), {"failure": FAILURE | {"parameter": "carrier.stifness"}}),
    "direction": (exciter(), {"failure": FAILURE | {"direction": "r"}}),
    "knee": (exciter(), {"failure": FAILURE | {"woehler": LINE | {"SD": "8 N"}}}),
    "varies what fails": (exciter(), {"along": "carrier.stiffness", "range": [1e4, 2e5]}),
    "along a schedule": (FALLS, NONE | {"along": "carrier.stiffness", "range": [1, 2]}),
    "range": (exciter(), {"along": "p1.mass", "range": [-1, 2]}), "no such start": (exciter(), {"start": {"p3": 1.0}}),
}  # fmt: skip


@pytest.mark.parametrize("name", MACHINES)
def test_questions_that_do_not_fit_the_machine(name: str) -> None:
    machine, changed = MACHINES[name]
    check_refusal(
        f"failure-detection of a machine: {name}", lambda: wucht.run(wucht.FailureDetection(**ASKED | changed), machine)
    )


def test_a_prescribed_speed_is_refused():
    p = wucht.parts
    drum = p.Rotor(name="drum", mass=9.75, eccentricity=1e-3, inertia=9.75e-4)
    held = wucht.Machine(p.Carrier(stiffness=WHOLE, damping=200.0), [drum], [p.ConstantSpeed(speed=90.0)])
    with refused("machine.drive", given=None):
        wucht.run(wucht.FailureDetection(**ASKED | {"start": {}}), held)
