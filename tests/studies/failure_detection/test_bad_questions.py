"""What can be asked wrongly of a failure: one sentence with key, what was given and what is allowed."""

from __future__ import annotations

import pytest
from test_failing_machine import LINE, SENSOR, START, WHOLE, exciter
from tests.refusals import refused

import wucht
from wucht import InputError

FAILURE = {"remaining": 0.8, "direction": "x", "woehler": LINE}
ASKED = {"until": 8.0, "start": START, "sensor": SENSOR, "after": 0.5, "failure": FAILURE}
FALLS = exciter((4.0, WHOLE), (4.5, 0.8 * WHOLE), interpolation="linear")
STAYS = exciter((4.0, WHOLE), (4.5, WHOLE))

QUESTIONS = {
    "no sensor": ({"sensor": None}, "study.sensor", "must be a table"),
    "sensor misspelt": ({"sensor": SENSOR | {"intervall": 1}}, "study.sensor.intervall", "did you mean 'interval'"),
    "no noise": ({"sensor": {"interval": 0.1, "false_alarm_every": 60.0}}, "study.sensor.noise", "missing"),
    "silent": ({"sensor": SENSOR | {"noise": 0}}, "study.sensor.noise", "greater than 0"),
    "alarms": ({"sensor": SENSOR | {"false_alarm_every": 0.5}}, "study.sensor.false_alarm_every", "at least ten readings, 1"),
    "too fast": ({"sensor": SENSOR | {"interval": 1e-4}}, "study.sensor.interval", "study.until/20000"),
    "a unit": ({"sensor": SENSOR | {"interval": "1 m"}}, "study.sensor.interval", "1 m"),
    "law": ({"failure": FAILURE | {"law": "sudden"}}, "study.failure.law", "drop"),
    "grows": ({"failure": FAILURE | {"remaining": 1.0}}, "study.failure.remaining", "less than 1"),
    "no line": ({"failure": {"remaining": 0.8}}, "study.failure.woehler", "missing"),
    "line": ({"failure": FAILURE | {"woehler": LINE | {"k2": 9, "miner": "haibach"}}}, "study.failure.woehler.k2", "either"),
    "interval": ({"failure": FAILURE | {"interval": 0.07}}, "study.failure.interval", "multiple of study.sensor.interval"),
    "gradual": ({"failure": FAILURE | {"law": "linear"}}, "study.learning", "study.after and study.learning say"),
    "a number": ({"failure": 0.8}, "study.failure", "must be a table"),
    "late": ({"after": 9.0}, "study.after", "must be before study.until, 8"),
    "no range": ({"along": "drive.slope"}, "study.range", "missing"),
    "second alone": ({"second": "drive.slope", "second_range": [1, 2]}, "study.along", "missing"),
    "second twice": (
        {"along": "drive.slope", "range": [1, 2], "second": "drive.slope", "second_range": [1, 2]},
        "study.second",
        "another parameter",
    ),
    "one point": ({"along": "drive.slope", "range": [1, 2], "points": 1}, "study.points", "from 2 to 200"),
}


@pytest.mark.parametrize("case", QUESTIONS.values(), ids=QUESTIONS.keys())
def test_questions_that_are_refused(case):
    changed, where, says = case
    with pytest.raises(InputError) as caught:
        wucht.FailureDetection(**ASKED | changed)
    assert caught.value.location == where
    assert says in str(caught.value)


MACHINES = {
    "no failure": (exciter(), {"failure": None}, "study.failure", "or a schedule of the carrier's stiffness"),
    "both": (FALLS, {}, "study.failure", "give one of them"),
    "stays": (STAYS, {"failure": None}, "machine.schedules", "must change the stiffness"),
    "ends early": (FALLS, {"failure": None, "until": 4.2}, "study.until", "from 4 to 4.5"),
    "learns late": (FALLS, {"failure": None, "after": 3.5, "learning": 1.0}, "study.after", "at which the stiffness falls, 4"),
    "slow sensor": (
        FALLS,
        {"failure": None, "sensor": SENSOR | {"interval": 0.3}},
        "study.sensor.interval",
        "in the second half of the time after the fall of the stiffness: at most 0.175",
    ),
    "few readings": (exciter(), {"sensor": SENSOR | {"interval": 1.0}}, "study.sensor.interval", "at most study.until/20"),
    "not a stiffness": (
        exciter(), {"failure": FAILURE | {"parameter": "carrier.damping"}}, "study.failure.parameter", "carrier.stiffness",
    ),
    "unknown": (
        exciter(), {"failure": FAILURE | {"parameter": "carrier.stifness"}}, "study.failure.parameter", "'carrier.stiffness'",
    ),
    "direction": (exciter(), {"failure": FAILURE | {"direction": "r"}}, "study.failure.direction", "must be one of x, y"),
    "knee": (exciter(), {"failure": FAILURE | {"woehler": LINE | {"SD": "8 N"}}}, "study.failure.woehler.SD", "8 N"),
    "varies what fails": (
        exciter(), {"along": "carrier.stiffness", "range": [1e4, 2e5]}, "study.along", "this parameter falls with the failure",
    ),
    "along a schedule": (
        FALLS, {"failure": None, "along": "carrier.stiffness", "range": [1, 2]}, "study.along", "follows a schedule",
    ),
    "range": (exciter(), {"along": "p1.mass", "range": [-1, 2]}, "study.range[0]", "-1"),
    "no such start": (exciter(), {"start": {"p3": 1.0}}, "study.start.p3", "did you mean"),
}  # fmt: skip


@pytest.mark.parametrize("case", MACHINES.values(), ids=MACHINES.keys())
def test_questions_that_do_not_fit_the_machine(case):
    machine, changed, where, says = case
    with pytest.raises(InputError) as caught:
        wucht.run(wucht.FailureDetection(**ASKED | changed), machine)
    assert caught.value.location == where
    assert says in str(caught.value)


def test_a_prescribed_speed_is_refused():
    p = wucht.parts
    drum = p.Rotor(name="drum", mass=9.75, eccentricity=1e-3, inertia=9.75e-4)
    held = wucht.Machine(p.Carrier(stiffness=WHOLE, damping=200.0), [drum], [p.ConstantSpeed(speed=90.0)])
    with refused("machine.drive", given=None):
        wucht.run(wucht.FailureDetection(**ASKED | {"start": {}}), held)
