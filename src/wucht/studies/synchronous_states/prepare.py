"""Question and machine -> plan: the machine as it turns in step, its equations, and the speeds to be searched."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.analysis.averaged import SlowMachine, damped, slow_machine
from wucht.analysis.configurations.all_states import in_closed_form
from wucht.analysis.configurations.closed_form import pattern_count
from wucht.analysis.configurations.speeds import LOWEST, SpeedRange, driven, speed_limits, speeds_of_drives
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.studies.synchronous_states.spec import SynchronousStates

MOST_BODIES = 11
_MOST_PATTERNS = 64  # ways to be in line, of a map


@dataclass(frozen=True)
class Map:
    """The cells of a stability map, by their centres: speeds (N,) in the main rotor's own sense, and ratios (M,)."""

    speeds: np.ndarray
    ratios: np.ndarray


@dataclass(frozen=True)
class Plan:
    """machine: as it was given. steady: as it turns in step. speeds: to be searched, None where the speed is given."""

    spec: SynchronousStates
    machine: Machine
    steady: Machine
    slow: SlowMachine
    torques: SteadyTorques
    speeds: SpeedRange | None
    map: Map | None


def prepare(spec: SynchronousStates, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the machine has no phases, or is outside the class of the slow equations."""
    if not machine.units.time:
        spec.refuse_units()
    if len(machine.bodies) < 2:
        _refuse_single(machine)
    if len(machine.bodies) > MOST_BODIES:
        raise InputError("machine.bodies", len(machine.bodies), f"allowed are up to {MOST_BODIES}, the main rotor included")
    if spec.range is not None and machine.rotor.coordinate.prescribed is not None:
        raise InputError("study.range", list(spec.range), "not allowed where the speed of the main rotor is given")
    steady, unheld = turning(machine, spec.speed), turning(machine, None)
    if not spec.inertia and not damped(steady):
        raise InputError("study.inertia", False, "allowed is true: a balancing body is not damped against its rotor")
    slow = slow_machine(steady, spec.inertia)
    torques = SteadyTorques.from_slow(slow)
    speeds = _searched(steady, spec.range) if torques.given is None else None
    if speeds is None:
        _check_speed(spec, unheld, torques)
    in_closed_form(torques, *((0.0, 0.0) if speeds is None else (speeds.low, speeds.high)))
    return Plan(spec, machine, steady, slow, torques, speeds, _map(spec, unheld, torques))


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
    rotor = machine.rotor
    if machine.shaken is not None:
        raise InputError(
            "machine.carrier.motion", None, "a single body has no phases; whether the carrier's motion takes it along is "
            "study.kind = 'entrainment'",
        )  # fmt: skip
    if machine.sliders:
        raise InputError(
            "machine.bodies", None, f"only {rotor.name!r} turns freely: {machine.sliders[0].name!r} slides in a guide that "
            "turns with it, and has no phase of its own; study.kind = 'run-up' shows its motion",
        )  # fmt: skip
    advice = "at which speeds it can turn is study.kind = 'torque-balance'"
    if not machine.drives or rotor.coordinate.prescribed is not None:
        advice = "how it makes the carrier vibrate is study.kind = 'response'"
    raise InputError("machine.bodies", None, f"a single body has no phases; {advice}")


def _check_speed(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques) -> None:
    """Raises ``InputError`` for a given speed at which nothing can be computed."""
    assert torques.given is not None
    if torques.given <= 0:
        raise InputError("machine.drive", None, "the main rotor stands still: there is no vibration that could place bodies")
    if spec.speed is not None:
        low, high = speed_limits(unheld)
        if not low <= abs(spec.speed) <= high:
            raise InputError("study.speed", spec.speed, f"allowed are speeds {_between(unheld, low, high)}")
    if torques.poles(torques.given, torques.given):
        raise InputError(
            "machine.drive" if spec.speed is None else "study.speed", torques.given, "allowed is another speed: this is "
            "the natural frequency of a vibration without damping, which is infinite there",
        )  # fmt: skip


def _searched(machine: Machine, given: tuple[float, float] | None) -> SpeedRange:
    """The range of speeds to search. Raises ``InputError`` where nothing drives the machine, or the given one does not fit."""
    speeds = speeds_of_drives(machine) if given is None else _range(machine, given)
    if speeds is None or not driven(machine, speeds):
        where = "" if given is None else " at these speeds"
        raise InputError("study.speed", None, f"nothing drives the machine{where}: needed is the speed of the main rotor")
    return speeds


def _range(machine: Machine, given: tuple[float, float]) -> SpeedRange:
    sense = sense_of(machine, machine.rotor)
    low, high = sorted(sense * w for w in given)
    if low < 0:
        raise InputError("study.range", list(given), "allowed are speeds in the sense in which the drive turns")
    least, most = speed_limits(machine)
    if not least < high <= most:
        raise InputError("study.range", list(given), f"allowed are speeds {_between(machine, least, most)}")
    return SpeedRange(max(low, min(least, LOWEST * high)), high)


def _between(machine: Machine, low: float, high: float) -> str:
    return (
        f"from {low:.3g} to {high:.3g} {machine.units.speed}".rstrip()
        + ", a thousandth of the lowest to a thousand times the highest natural frequency or speed of a drive"
    )


def _map(spec: SynchronousStates, unheld: Machine, torques: SteadyTorques) -> Map | None:
    """The map, if one is asked for.

    Raises ``InputError`` where there is no ratio of unbalances, or no closed form, or speeds are out of reach.
    """
    if spec.axes is None:
        return None
    axes, c, unit = spec.axes_in(unheld.units.speed), torques.coefficients, unheld.units.speed
    if c is None or torques.size < 3 or any(h != 0 for h in torques.heads):
        raise InputError(
            "study.axes", None, "allowed for a rotor with at least two balancing bodies and nothing else that turns"
        )
    if not abs(c[0]):
        raise InputError("study.axes", None, "the rotor has no unbalance, so there is no ratio to it")
    if (patterns := pattern_count(torques)) > _MOST_PATTERNS:
        raise InputError(
            "study.axes", None, f"allowed are bodies with up to {_MOST_PATTERNS} ways to be in line, not {patterns}"
        )
    highest = speed_limits(unheld)[1]
    if axes["speed"][1] > highest:
        raise InputError("study.axes.speed", list(axes["speed"]), f"allowed are speeds up to {highest:.3g} {unit}".rstrip())
    cells = Map(_centres(*axes["speed"]), _centres(*axes["ratio"]))
    if not torques.idle(cells.speeds):
        raise InputError("study.axes", None, "balancing bodies have torques of their own, so that none of these states stays")
    return cells


def _centres(low: float, high: float, cells: int) -> np.ndarray:
    edges = np.linspace(low, high, cells + 1)
    centres: np.ndarray = (edges[1:] + edges[:-1]) / 2
    return centres
