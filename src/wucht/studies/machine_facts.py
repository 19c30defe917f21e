"""Facts of a machine that questions about it name: its main rotor, the size of its motor, motors that would start it."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.parts.base import Drive
from wucht.machines.parts.nameplate import InductionNameplate

# What makes a drive of each kind larger.
_SIZES = {
    "linear": "slope", "constant-torque": "torque", "inverter": "torque_limit", "induction": "voltage",
    "dc": "stall_torque", "dc-separate": "voltage", "dc-shunt": "voltage", "dc-series": "voltage",
}  # fmt: skip
_PROPORTIONAL = ("linear", "constant-torque", "inverter", "dc")  # kinds whose torque at standstill grows as their size
# Preferred rated powers of motors in kW, IEC 60072-1, table 7.
_POWERS = (
    0.06, 0.09, 0.12, 0.18, 0.25, 0.37, 0.55, 0.75, 1.1, 1.5, 2.2, 3.0, 4.0, 5.5, 7.5, 11.0, 15.0, 18.5, 22.0, 30.0, 37.0, 45.0,
    55.0, 75.0, 90.0, 110.0, 132.0, 160.0, 200.0, 250.0, 315.0, 355.0, 400.0, 500.0,
)  # fmt: skip
_ROUNDING = 1.005  # so that three digits are never less
_LOW, _HIGH = 0.5, 3.0  # of the range over the size of a motor


def facts_of_machine(subject: Any) -> dict[str, Any]:
    """Return the facts that a machine has; none of another subject.

    ``rotor``, the main rotor; ``unbalance``, the path of its unbalance, with ``unbalance_half`` and ``unbalance_whole``, half
    its value and all of it; ``motor``, the path of what makes its drive larger, with ``motor_low`` and ``motor_high``, the ends
    of a range around its value.
    """
    if not isinstance(subject, Machine):
        return {}
    rotor = next((body.name for body in subject.bodies if body.about is None), None)
    facts: dict[str, Any] = {} if rotor is None else {"rotor": rotor}
    for key in ("unbalance", "eccentricity"):
        if (value := subject.values.get(f"{rotor}.{key}", 0.0)) > 0:
            facts |= {"unbalance": f"{rotor}.{key}", "unbalance_half": 0.5 * value, "unbalance_whole": value}
    for drive in subject.drives:
        path = _size_of(drive)
        if drive.on == rotor and (value := subject.values.get(path, 0.0)) > 0:
            facts |= {"motor": path, "motor_low": _LOW * value, "motor_high": _HIGH * value}
    return facts


def motors_that_start(subject: Any, summary: Mapping[str, Any]) -> dict[str, str] | None:
    """Return values by path with which each drive lifts the weight and the load of its rotor in any position.

    Parameters
    ----------
    subject : Machine or other subject of a study
    summary : mapping
        With ``starting_torque``, ``weight_moment`` and ``load_torque`` by rotor.

    Returns
    -------
    dict of str to str, or None
        For a motor by its nameplate the next preferred power (IEC 60072-1) with the torques in proportion; where the nameplate
        does not state its starting torque, and the typical one is enough, that. None where every
        drive lifts them, or one of them cannot be made larger in this way.
    """
    torques, weights, loads = (summary.get(key) or {} for key in ("starting_torque", "weight_moment", "load_torque"))
    if not isinstance(subject, Machine) or not torques:
        return None
    settings: dict[str, str] = {}
    for drive in subject.drives:
        torque, needed = abs(torques.get(drive.on, 0.0)), weights.get(drive.on, 0.0) + loads.get(drive.on, 0.0)
        if needed <= torque:
            continue
        larger = _larger_motor(subject, drive, needed / torque) if torque > 0 else None
        if larger is None:
            return None
        settings |= larger
    return settings or None


def _larger_motor(machine: Machine, drive: Drive, factor: float) -> dict[str, str] | None:
    plate = getattr(drive, "nameplate", None)
    if isinstance(plate, InductionNameplate):
        typical_torque, standstill_torque = plate.typical.starting * plate.torque, abs(drive.number(drive.torque(sp.S.Zero)))
        if plate.starting_torque_ratio is None and typical_torque >= factor * standstill_torque:
            return {f"{drive.path}.nameplate.starting_torque_ratio": f"{plate.typical.starting:.2g}"}
        power = next((one for one in _POWERS if one * 1e3 >= factor * plate.power), None)
        return None if power is None else {f"{drive.path}.nameplate.power": f"{power:g} kW"}
    if drive.kind not in _PROPORTIONAL:
        return None
    path = _size_of(drive)
    return {path: f"{_ROUNDING * factor * machine.values[path]:.3g}"} if path in machine.values else None


def _size_of(drive: Drive) -> str:
    return f"{drive.path}.{_SIZES.get(drive.kind, '')}"
