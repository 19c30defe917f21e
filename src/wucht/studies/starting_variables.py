"""Starting from rest in a result: the torques of drives at standstill, of weight and of loads, and what does not start."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import pairwise

import numpy as np

from wucht.analysis.starting import StartFromRest, has_weight_or_load, not_started_in_words, starts_from_rest
from wucht.dynamics.run_ups.hanging_start import is_resting_state
from wucht.machines.machine import Machine
from wucht.studies.answer import Answer

_BETWEEN = 8  # times between two breakpoints of schedules at which a start is tried


def state_starting_torques(a: Answer, machine: Machine) -> None:
    """State the torques that decide whether rotors start from rest, by rotor; none where there is nothing to lift.

    A line says them where a drive does not start its rotor from rest.
    """
    rows = starts_from_rest(machine) if has_weight_or_load(machine) else {}
    rows = {name: start for name, start in rows.items() if start.weight > 0 or start.load > 0}
    if not rows:
        return
    torques, weights, loads, starts = (
        {name: getattr(start, key) for name, start in rows.items()} for key in ("torque", "weight", "load", "starts")
    )
    a.number("starting_torque", torques, "torque of the drives of each rotor at standstill", "torque")
    a.number("weight_moment", weights, "largest moment of the weight of each rotor over a turn", "torque")
    a.number("load_torque", loads, "torque of loads and bearings of each rotor at standstill", "torque")
    a.number("starts_from_rest", starts, "whether its drive takes it over the top in the first swing from rest")
    if any(start.torque > 0 and not start.starts for start in rows.values()):
        a.line("from rest", "{starting_torque} at standstill; weight at most {weight_moment}; load {load_torque}")


def start_warnings(machine: Machine, initial: np.ndarray, turning: Iterable[str]) -> list[str]:
    """Return a warning of rotors that turn in a run from a state (n,), but that their drives do not start from rest.

    turning: the names of the rotors that turn.
    """
    starts = {} if is_resting_state(machine, initial) else _never_starting(machine)
    rotors = set(turning)
    starts = {name: start for name, start in starts.items() if name in rotors}
    return [f"{_from_rest(starts)}; here the given start sets {'them' if len(starts) > 1 else 'it'} turning"] if starts else []


def not_started_statement(machine: Machine) -> str:
    """Return a sentence on the rotors that their drives do not start from rest at any time of the schedules; else nothing."""
    return _from_rest(_never_starting(machine))


def _from_rest(starts: Mapping[str, StartFromRest]) -> str:
    hanging = " hanging," if any(s.weight > 0 for s in starts.values()) else ""
    return f"from rest,{hanging} {not_started_in_words(starts)}" if starts else ""


def _never_starting(machine: Machine) -> dict[str, StartFromRest]:
    if not has_weight_or_load(machine):
        return {}
    driven = {n: s for n, s in starts_from_rest(machine.at(machine.breakpoints[-1])).items() if s.torque > 0}
    return {n: s for n, s in driven.items() if not _ever_starts(machine, n)}


def _ever_starts(machine: Machine, name: str) -> bool:
    """True if a rotor starts at some time of the schedules."""
    points = np.array(machine.breakpoints)
    between = [np.linspace(a, b, _BETWEEN + 1)[1:-1] for a, b in pairwise(points)]
    return any(starts_from_rest(machine.at(float(t)))[name].starts for t in np.concatenate([points[::-1], *between]))
