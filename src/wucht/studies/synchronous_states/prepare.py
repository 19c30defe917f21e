"""Question and machine -> plan: the machine as it turns in step, its equations, and the speeds to be searched."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged import AveragedMachine, averaged_machine, keeps_inertia
from wucht.analysis.configurations.closed_form import pattern_count
from wucht.analysis.configurations.search import in_closed_form
from wucht.analysis.configurations.steady_machine import LOWEST, MOST_BODIES, UNKNOWN, driven_speeds, turning
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, net_torque, sense_of
from wucht.studies.synchronous_states.spec import SynchronousStates

_MOST_PATTERNS = 64  # ways to be in line, of a map
_SLOWER, _FASTER = 1e-3, 1e3  # of the lowest and the highest speed of the machine: beyond, nothing is left to be computed
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
        raise InputError(
            "study.range", list(spec.range), "not allowed where the speed of the main rotor is given", code="prescribed"
        )
    steady, unheld = turning(machine, spec.speed), turning(machine, None)
    slow = averaged_machine(steady, keeps_inertia(steady, spec.inertia))
    torques, speeds, chosen = SteadyTorques.from_slow(slow), None, False
    if torques.given is None:
        speeds, chosen = _searched(steady, spec.range)
    else:
        _check_speed(spec, unheld, torques, torques.given)
    in_closed_form(torques, *speeds or (0.0, 0.0))
    return Plan(spec, machine, slow, torques, speeds, chosen, _map(spec, unheld, torques))


def _refuse_single(machine: Machine) -> None:
    """Why a machine with one body that turns has no phases. Raises ``InputError``."""
    rotor, single = machine.rotor, "a single body has no phases"
    if machine.shaken is not None:
        why = f"{single}; whether the carrier's motion entrains it is study.kind = 'entrainment'"
        raise InputError("machine.carrier.motion", None, why, code="single-body")
    if machine.sliders:
        why = f"{machine.sliders[0].name!r} slides in a guide that turns with it, and has no phase of its own"
        advice = "study.kind = 'run-up' shows its motion"
        raise InputError("machine.bodies", None, f"only {rotor.name!r} turns freely: {why}; {advice}", code="slider")
    advice = "at which speeds it can turn is study.kind = 'torque-balance'"
    if not machine.drives or rotor.coordinate.prescribed is not None:
        advice = "how it makes the carrier vibrate is study.kind = 'response'"
    raise InputError("machine.bodies", None, f"{single}; {advice}", code="single-body")


def _check_speed(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques, speed: float) -> None:
    """Raises ``InputError`` for a given speed at which nothing can be computed."""
    if speed <= 0:
        raise InputError(
            "machine.drive",
            None,
            "the main rotor stands still: there is no vibration that could place bodies",
            code="stands-still",
        )
    if spec.speed is not None:
        low, high = _limits(unheld)
        if not low <= abs(spec.speed) <= high:
            raise InputError("study.speed", spec.speed, f"must be a speed {_between(unheld, low, high)}")
    if torques.poles(speed, speed):
        where = "machine.drive" if spec.speed is None else "study.speed"
        why = "this is the natural frequency of a vibration without damping, which is infinite there"
        raise InputError(where, speed, f"must be another speed: {why}", code="resonance")


def _searched(machine: Machine, given: tuple[float, float] | None) -> tuple[tuple[float, float], bool]:
    """The range of speeds to search, and whether its end is chosen.

    Raises ``InputError`` where nothing drives the machine, or the given range does not fit.
    """
    speeds, chosen = driven_speeds(machine)
    if given is not None:
        low, high = sorted(sense_of(machine, machine.rotor) * w for w in given)
        if low < 0:
            raise InputError(
                "study.range", list(given), "must be speeds in the sense in which the drive turns", code="other-sense"
            )
        least, most = _limits(machine)
        if not least < high <= most:
            raise InputError("study.range", list(given), f"must be speeds {_between(machine, least, most)}", code="limits")
        speeds, chosen = (max(low, min(least, LOWEST * high)), high), False
    at, rotors = np.linspace(*speeds, _SAMPLES), [(net_torque(machine, r), sense_of(machine, r)) for r in machine.rotors]
    if not at.any() or not any(torque(sense * float(w)) for torque, sense in rotors for w in at):
        where, code = ("", "missing") if given is None else (" at these speeds", "not-driven")
        why = f"nothing drives the machine{where}: needed is the speed of the main rotor"
        raise InputError("study.speed", None, why, code=code)
    return speeds, chosen


def _limits(machine: Machine) -> tuple[float, float]:
    """The lowest and the highest speed at which anything can be computed, by the machine's natural frequencies and drives."""
    own = [*natural_frequencies(machine).values(), *(abs(free_speed(machine, r) or 0.0) for r in machine.rotors)]
    own = [w for w in own if w > 0 and math.isfinite(w)] or [UNKNOWN]
    return _SLOWER * min(own), _FASTER * max(own)


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
        raise InputError("study.axes", None, allowed, code="no-bodies")
    if not abs(c[0]):
        raise InputError("study.axes", None, "the rotor has no unbalance, so there is no ratio to it")
    if (patterns := pattern_count(torques)) > _MOST_PATTERNS:
        raise InputError("study.axes", None, f"must be bodies with up to {_MOST_PATTERNS} ways to be in line, not {patterns}")
    if axes["speed"][1] > highest:
        raise InputError("study.axes.speed", list(axes["speed"]), f"must be speeds up to {highest:.3g} {unit}".rstrip())
    edges = [np.linspace(low, high, cells + 1) for low, high, cells in (axes["speed"], axes["ratio"])]
    speeds, ratios = ((e[1:] + e[:-1]) / 2 for e in edges)
    if not torques.idle(speeds):
        raise InputError(
            "study.axes",
            None,
            "balancing bodies have torques of their own, so that none of these states stays",
            code="own-torques",
        )
    return speeds, ratios
