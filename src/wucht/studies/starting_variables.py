"""Starting from rest in a result: the torques of drives at standstill, of weight and of loads, and what does not start."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise
from typing import Any

import numpy as np

from wucht.analysis.starting import has_weight_or_load, starts_from_rest
from wucht.dynamics.run_ups.hanging_start import is_at_rest
from wucht.machines.machine import Machine
from wucht.results.formatting import ReportLines
from wucht.results.quantities import Quantity

_BETWEEN = 8  # times between two breakpoints of schedules at which a start is tried


def starting_quantities(machine: Machine) -> list[Quantity]:
    """Return the torques that decide whether rotors start from rest, by rotor; none where there is nothing to lift."""
    rows = starts_from_rest(machine) if has_weight_or_load(machine) else {}
    rows = {name: start for name, start in rows.items() if start.weight > 0 or start.load > 0}
    if not rows:
        return []
    unit = machine.units.torque
    torques, weights, loads, starts = (
        {name: getattr(start, key) for name, start in rows.items()} for key in ("torque", "weight", "load", "starts")
    )
    return [
        Quantity("starting_torque", torques, "torque of the drives of each rotor at standstill", unit),
        Quantity("weight_moment", weights, "largest moment of the weight of each rotor over a turn", unit),
        Quantity("load_torque", loads, "torque of loads and bearings of each rotor at standstill", unit),
        Quantity("starts_from_rest", starts, "whether its drive takes it over the top in the first swing from rest"),
    ]


def add_starting_line(lines: ReportLines, summary: Mapping[str, Any]) -> None:
    """Add the line on these torques, where the summary has them."""
    if "starting_torque" in summary:
        lines.add("from rest", "{starting_torque} at standstill; weight at most {weight_moment}; load {load_torque}")


def start_warnings(machine: Machine, initial: np.ndarray, turning: Iterable[str]) -> list[str]:
    """Return warnings of rotors that turn in a run from a state (n,), but that their drives do not start from rest.

    turning: the names of the rotors that turn.
    """
    if is_at_rest(machine, initial):
        return []
    statements = _statements_by_rotor(machine).items()
    return [f"{statement}; it turns here from the given start" for name, statement in statements if name in turning]


def statements_not_started(machine: Machine) -> list[str]:
    """Return a statement for each rotor with a drive that does not start it from rest at any time of the schedules."""
    return list(_statements_by_rotor(machine).values())


def _statements_by_rotor(machine: Machine) -> dict[str, str]:
    if not has_weight_or_load(machine):
        return {}
    driven = {n: s for n, s in starts_from_rest(machine.at(machine.breakpoints[-1])).items() if s.torque > 0}
    return {
        n: f"from rest{', hanging,' if s.weight > 0 else ''} {n!r} does not start: {s.reason}"
        for n, s in driven.items()
        if not _ever_starts(machine, n)
    }


def _ever_starts(machine: Machine, name: str) -> bool:
    """True if a rotor starts at some time of the schedules."""
    points = np.array(machine.breakpoints)
    between = [np.linspace(a, b, _BETWEEN + 1)[1:-1] for a, b in pairwise(points)]
    return any(starts_from_rest(machine.at(float(t)))[name].starts for t in np.concatenate([points[::-1], *between]))
