"""Question and machine -> plan: the machine as it turns in step, its equations, and the speeds to be searched."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.analysis.averaged import AveragedMachine, averaged_machine
from wucht.analysis.configurations.closed_form import pattern_count
from wucht.analysis.configurations.search import in_closed_form
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import damped, free_speed, natural_frequencies, net_torque, sense_of
from wucht.studies.synchronous_states.spec import SynchronousStates

MOST_BODIES = 11
_MOST_PATTERNS = 64  # ways to be in line, of a map
_LOWEST = 1e-3  # of the highest speed: where a search begins
_ABOVE = 1 + 1e-4  # of the highest speed without vibration: where it ends
_SLOWER, _FASTER = 1e-3, 1e3  # of the lowest and the highest speed of the machine: beyond, nothing is left to be computed
_RUNAWAY = 3  # times the highest natural frequency: how far is searched where the drive has no speed of its own
_UNKNOWN = 100.0  # rad/s, where the machine has neither natural frequencies nor speeds of its own
_SAMPLES = 1001


@dataclass(frozen=True)
class Plan:
    """machine: as it was given; that of the torques turns in step.

    speeds: lowest and highest one to be searched, in the main rotor's own sense, None where the speed is given. chosen: whether
    the highest is the program's choice. map: the centres of the cells of a stability map: speeds (N,), likewise, and ratios
    (M,).
    """

    spec: SynchronousStates
    machine: Machine
    slow: AveragedMachine
    torques: SteadyTorques
    speeds: tuple[float, float] | None
    chosen: bool
    map: tuple[np.ndarray, np.ndarray] | None


def prepare(spec: SynchronousStates, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the machine has no phases, or is outside the class of the averaged equations."""
    if len(machine.bodies) < 2:
        _refuse_single(machine)
    if len(machine.bodies) > MOST_BODIES:
        raise InputError("machine.bodies", len(machine.bodies), f"there must be at most {MOST_BODIES}, the main rotor included")
    if spec.range is not None and machine.rotor.coordinate.prescribed is not None:
        raise InputError("study.range", list(spec.range), "not allowed where the speed of the main rotor is given")
    steady, unheld = turning(machine, spec.speed), turning(machine, None)
    if not spec.inertia and not damped(steady):
        raise InputError("study.inertia", False, "must be true: a balancing body is not damped against its rotor")
    slow = averaged_machine(steady, spec.inertia)
    torques, speeds, chosen = SteadyTorques.from_slow(slow), None, False
    if torques.given is None:
        speeds, chosen = _searched(steady, spec.range)
    else:
        _check_speed(spec, unheld, torques, torques.given)
    in_closed_form(torques, *speeds or (0.0, 0.0))
    return Plan(spec, machine, slow, torques, speeds, chosen, _map(spec, unheld, torques))


def turning(machine: Machine, speed: float | None) -> Machine:
    """The machine with its schedules done, all bodies released, and the main rotor at a given speed (signed)."""
    steady = machine.at(machine.breakpoints[-1]).changed(schedules=())
    bodies = [replace(b, release=None) for b in steady.bodies]
    if speed is not None:
        main = next(i for i, b in enumerate(bodies) if b.name == machine.rotor.name)
        bodies[main] = replace(bodies[main], coordinate=replace(bodies[main].coordinate, prescribed=sp.Float(speed)))
    return steady.changed(bodies=tuple(bodies))


def _refuse_single(machine: Machine) -> None:
    """Why a machine with one body that turns has no phases. Raises ``InputError``."""
    rotor, single = machine.rotor, "a single body has no phases"
    if machine.shaken is not None:
        why = f"{single}; whether the carrier's motion entrains it is study.kind = 'entrainment'"
        raise InputError("machine.carrier.motion", None, why)
    if machine.sliders:
        why = f"{machine.sliders[0].name!r} slides in a guide that turns with it, and has no phase of its own"
        advice = "study.kind = 'run-up' shows its motion"
        raise InputError("machine.bodies", None, f"only {rotor.name!r} turns freely: {why}; {advice}")
    advice = "at which speeds it can turn is study.kind = 'torque-balance'"
    if not machine.drives or rotor.coordinate.prescribed is not None:
        advice = "how it makes the carrier vibrate is study.kind = 'response'"
    raise InputError("machine.bodies", None, f"{single}; {advice}")


def _check_speed(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques, speed: float) -> None:
    """Raises ``InputError`` for a given speed at which nothing can be computed."""
    if speed <= 0:
        raise InputError("machine.drive", None, "the main rotor stands still: there is no vibration that could place bodies")
    if spec.speed is not None:
        low, high = _limits(unheld)
        if not low <= abs(spec.speed) <= high:
            raise InputError("study.speed", spec.speed, f"must be a speed {_between(unheld, low, high)}")
    if torques.poles(speed, speed):
        where = "machine.drive" if spec.speed is None else "study.speed"
        why = "this is the natural frequency of a vibration without damping, which is infinite there"
        raise InputError(where, speed, f"must be another speed: {why}")


def _searched(machine: Machine, given: tuple[float, float] | None) -> tuple[tuple[float, float], bool]:
    """The range of speeds to search, and whether its end is chosen.

    Raises ``InputError`` where nothing drives the machine, or the given range does not fit.
    """
    speeds, chosen = driven_speeds(machine)
    if given is not None:
        low, high = sorted(sense_of(machine, machine.rotor) * w for w in given)
        if low < 0:
            raise InputError("study.range", list(given), "must be speeds in the sense in which the drive turns")
        least, most = _limits(machine)
        if not least < high <= most:
            raise InputError("study.range", list(given), f"must be speeds {_between(machine, least, most)}")
        speeds, chosen = (max(low, min(least, _LOWEST * high)), high), False
    at, rotors = np.linspace(*speeds, _SAMPLES), [(net_torque(machine, r), sense_of(machine, r)) for r in machine.rotors]
    if not at.any() or not any(torque(sense * float(w)) for torque, sense in rotors for w in at):
        where = "" if given is None else " at these speeds"
        raise InputError("study.speed", None, f"nothing drives the machine{where}: needed is the speed of the main rotor")
    return speeds, chosen


def _limits(machine: Machine) -> tuple[float, float]:
    """The lowest and the highest speed at which anything can be computed, by the machine's natural frequencies and drives."""
    own = [*natural_frequencies(machine).values(), *(abs(free_speed(machine, r) or 0.0) for r in machine.rotors)]
    own = [w for w in own if w > 0 and math.isfinite(w)] or [_UNKNOWN]
    return _SLOWER * min(own), _FASTER * max(own)


def driven_speeds(machine: Machine) -> tuple[tuple[float, float], bool]:
    """Up to the highest speed without vibration, and whether a drive runs away without load: then there is no such speed."""
    free = {r: free_speed(machine, r) for r in machine.rotors}
    top = max((abs(w) for w in free.values() if w is not None), default=0.0)
    runaway = any(w is None and net_torque(machine, r)(0.0) for r, w in free.items())
    if runaway:
        top = max(top, _RUNAWAY * max((f for f in natural_frequencies(machine).values() if f > 0), default=_UNKNOWN))
    return (_LOWEST * top, top if runaway else _ABOVE * top), runaway


def _between(machine: Machine, low: float, high: float) -> str:
    speeds = f"from {low:.3g} to {high:.3g} {machine.units.speed}".rstrip()
    return f"{speeds}, a thousandth of the lowest to a thousand times the highest natural frequency or speed of a drive"


def _map(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques) -> tuple[np.ndarray, np.ndarray] | None:
    """The map, if one is asked for.

    Raises ``InputError`` where there is no ratio of unbalances, or no closed form, or speeds are out of reach.
    """
    if spec.axes is None:
        return None
    unit, c = unheld.units.speed, torques.coefficients
    axes, highest = spec.axes_in(unit), _limits(unheld)[1]
    if c is None or torques.size < 3 or any(h != 0 for h in torques.heads):
        allowed = "allowed for a rotor with at least two balancing bodies and nothing else that turns"
        raise InputError("study.axes", None, allowed)
    if not abs(c[0]):
        raise InputError("study.axes", None, "the rotor has no unbalance, so there is no ratio to it")
    if (patterns := pattern_count(torques)) > _MOST_PATTERNS:
        raise InputError("study.axes", None, f"must be bodies with up to {_MOST_PATTERNS} ways to be in line, not {patterns}")
    if axes["speed"][1] > highest:
        raise InputError("study.axes.speed", list(axes["speed"]), f"must be speeds up to {highest:.3g} {unit}".rstrip())
    edges = [np.linspace(low, high, cells + 1) for low, high, cells in (axes["speed"], axes["ratio"])]
    speeds, ratios = ((e[1:] + e[:-1]) / 2 for e in edges)
    if not torques.idle(speeds):
        raise InputError("study.axes", None, "balancing bodies have torques of their own, so that none of these states stays")
    return speeds, ratios
