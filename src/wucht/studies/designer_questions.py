"""What the designer of a machine asks: for each purpose its questions, the quick ones first.

A setting may name facts of the machine: ``{rotor}``, the main rotor; ``{unbalance}``, the path of its unbalance, and
``{unbalance_half}``, ``{unbalance_whole}``, half its value and all of it; and
``{motor}``, the path of what makes the main drive larger, with ``{motor_low}``, ``{motor_high}``, half and twice its value. A
question about what a machine has not does not follow.
"""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

from wucht.machines.machine import Machine
from wucht.machines.purpose import Purpose
from wucht.studies.next_question import NextQuestion

_START = NextQuestion("does it start, and in which state does it end?", {"study.kind": "run-up"})
_BALANCE = NextQuestion("at which speeds do motor, load and vibration balance?", {"study.kind": "torque-balance"})
_RESPONSE = NextQuestion("how does it vibrate over the speed?", {"study.kind": "response"})
_CYCLE = NextQuestion("what does a start and stop cost?", {"study.kind": "start-stop"})
_COAST_DOWN = NextQuestion("what happens when it is switched off?", {"study.kind": "coast-down"})
_STATES = NextQuestion("in which phases can it run?", {"study.kind": "synchronous-states"})
_DIP = NextQuestion("which power failure does it survive?", {"study.kind": "voltage-dip", "study.depth": "1"})

QUESTIONS: Mapping[Purpose, tuple[NextQuestion, ...]] = {
    Purpose.SCREEN: (
        _START, _STATES, _BALANCE, _RESPONSE, _CYCLE,
        NextQuestion("does it run on when a motor fails?", {"study.kind": "drive-failure"}),
        _DIP,
    ),
    Purpose.DRUM: (
        _START, _BALANCE, _RESPONSE, _STATES, _CYCLE,
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
    Purpose.FAN: (_START, _BALANCE, _RESPONSE, _CYCLE, _COAST_DOWN, _DIP),
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

# What makes a drive of each kind larger.
_SIZES = {
    "linear": "slope", "constant-torque": "torque", "inverter": "torque_limit", "induction": "voltage",
    "dc-separate": "voltage", "dc-shunt": "voltage", "dc-series": "voltage",
}  # fmt: skip


def facts_of_machine(machine: Machine) -> dict[str, Any]:
    """Return what questions may name of a machine: those of its facts that it has."""
    rotor = next((body.name for body in machine.bodies if body.about is None), None)
    facts: dict[str, Any] = {} if rotor is None else {"rotor": rotor}
    for key in ("unbalance", "eccentricity"):
        if (value := machine.values.get(f"{rotor}.{key}", 0.0)) > 0:
            facts |= {"unbalance": f"{rotor}.{key}", "unbalance_half": 0.5 * value, "unbalance_whole": value}
    for drive in machine.drives:
        path = f"{drive.path}.{_SIZES.get(drive.kind, '')}"
        if drive.on == rotor and (value := machine.values.get(path, 0.0)) > 0:
            facts |= {"motor": path, "motor_low": 0.5 * value, "motor_high": 2.0 * value}
    return facts
