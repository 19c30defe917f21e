"""What the designer of a machine asks: for each purpose its questions, the quick ones first.

A setting may name facts of the machine, such as ``{rotor}``: see ``facts_of_machine``. A question about what a machine has not
does not follow.
"""

from __future__ import annotations

from collections.abc import Mapping

from wucht.machines.purpose import Purpose
from wucht.studies.next_question import NextQuestion

_START = NextQuestion("does it start, and in which state does it end?", {"study.kind": "run-up"})
_BALANCE = NextQuestion("at which speeds do motor, load and vibration balance?", {"study.kind": "torque-balance"})
_RESPONSE = NextQuestion("how does it vibrate over the speed?", {"study.kind": "response"})
_RESPONSE_HELD = NextQuestion(  # of balancers that compensate it there would be none
    "how would it vibrate over the speed if its balancers did not move?", {"study.kind": "response", "study.bodies": "held"}
)
_CYCLE = NextQuestion("what does a start and stop cost?", {"study.kind": "start-stop"})
_STATES = NextQuestion("in which phases can it run?", {"study.kind": "synchronous-states"})
_DIP = NextQuestion("which power failure does it survive?", {"study.kind": "voltage-dip", "study.depth": "1"})

QUESTIONS: Mapping[Purpose, tuple[NextQuestion, ...]] = {
    Purpose.SCREEN: (
        _START, _STATES, _BALANCE, _RESPONSE, _CYCLE,
        NextQuestion("does it run on when a motor fails?", {"study.kind": "drive-failure"}),
        _DIP,
    ),
    Purpose.DRUM: (
        _START, _BALANCE, _RESPONSE_HELD, _STATES, _CYCLE,
        NextQuestion(
            "how likely do its balancers compensate, from any angle at the start?",
            {
                "study.kind": "capture-probability", "study.along": "{unbalance}",
                "study.range": "[{unbalance_half}, {unbalance_whole}]", "study.points": "2", "study.samples": "64",
                "study.outcome": '["compensated"]',
                "study.random": '{{ "{rotor}" = {{ uniform = ["0 deg", "360 deg"] }} }}',
            },
        ),
    ),
    Purpose.FAN: (_START, _BALANCE, _RESPONSE, _CYCLE, _DIP),
    Purpose.RIG: (
        _START, _BALANCE, _RESPONSE,
        NextQuestion(
            "how fast does it turn steadily, over the size of the motor?",
            {"study.kind": "speed-curve", "study.along": "{motor}", "study.range": "[{motor_low}, {motor_high}]"},
        ),
        NextQuestion(
            "how does it beat, over the size of the motor?",
            {"study.kind": "orbit-branch", "study.along": "{motor}", "study.range": "[{motor_low}, {motor_high}]"},
        ),
        NextQuestion("which cycles does the specimen see?", {"study.kind": "load-spectrum"}),
        _CYCLE,
    ),
}  # fmt: skip
