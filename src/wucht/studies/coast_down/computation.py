"""Question and machine -> plan -> findings: the machine without its drives, where it starts, and how it runs down."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from enum import StrEnum
from functools import partial
from typing import Any

import numpy as np

from wucht.analysis.vibration import Forced
from wucht.analysis.working_points import energy_scale
from wucht.dynamics.run_ups.descent_record import REVERSAL, Descent, Record, reduced
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state, placed, speeds_in
from wucht.dynamics.run_ups.steady_phases import BodyPhases
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import axis_at_rest, free_speed, natural_frequencies, sense_of
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.integrate import integrate
from wucht.studies.coast_down.spec import CoastDown

SAMPLES_PER_TURN, _FEWEST_SAMPLES, _ROWS = 24, 64, 4000
_MOST_TURNS = 50_000
_RESONANT = 1e-6  # of an undamped resonance: so near it the steady vibration has no bound


class CarrierStart(StrEnum):
    """How the carrier of a coast-down starts."""

    FIXED = "fixed"  # it has no free coordinate
    STEADY = "steady"  # vibrating as at the speeds of the start
    REST = "rest"
    GIVEN = "given"  # as the user says


@dataclass(frozen=True)
class Plan:
    """What is to be integrated.

    machine: without its drives. initial: the state (n,) to start from. carrier: how it starts; why_at_rest: where nobody asked
    for that. bodies: how the balancing ones start; phases: where, to their rotor. start_speed: of the main rotor. limit: the
    latest end. step: between samples. stride: between rows of the result, at first. energy: the size of the works. at_rest:
    where the axis rests. events: the rotor turns back, and locked bodies are released.
    """

    spec: CoastDown
    machine: Machine
    initial: np.ndarray
    carrier: CarrierStart
    why_at_rest: str
    bodies: BodyPhases
    phases: Mapping[str, float]
    start_speed: float
    limit: float
    step: float
    stride: float
    energy: float
    at_rest: Mapping[str, float]
    events: tuple[Event, ...]


def prepare(spec: CoastDown, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the start does not fit the machine, or where nothing would turn."""
    coasting = _without_drives(machine)
    initial = _initial(spec, machine, coasting)
    velocity = coasting.rotor.coordinate.velocity
    bodies = BodyPhases.of(coasting, spec.start, float(initial[coasting.row(velocity)]), spec.bodies)
    initial = _in_phase(coasting, initial, bodies.to_rotor)
    coasting = placed(coasting, initial)
    carrier, why = _carrier_start(spec, coasting)
    if carrier is CarrierStart.STEADY:
        initial = _vibrating(coasting, initial)
    start_speed = float(initial[coasting.row(velocity)])
    turn = 2 * math.pi / max([abs(start_speed), *(f for f in natural_frequencies(coasting).values() if f > 0)])
    limit = spec.until or _MOST_TURNS * turn
    step = limit / max(_FEWEST_SAMPLES, math.ceil(limit * SAMPLES_PER_TURN / turn))  # a whole number of them until the end
    stride, energy, at_rest = turn if spec.until is None else limit / _ROWS, energy_scale(coasting), axis_at_rest(coasting)
    events = (Event(REVERSAL, velocity, -1 if start_speed > 0 else 1), *release_events(coasting))
    phases = _phases(coasting, initial)
    return Plan(
        spec, coasting, initial, carrier, why, bodies, phases, start_speed, limit, step, stride, energy, at_rest, events
    )


def numbers(plan: Plan) -> float:
    """At most how many numbers are stored: time and mean speed of each turn, which are as many as at the start."""
    return 2 * plan.limit * abs(plan.start_speed) / (2 * math.pi)


def _without_drives(machine: Machine) -> Machine:
    """The machine with its drives switched off: no torque, no prescribed speed. What dampers and loads take stays.

    So does the inertia of a motor behind a gear, which without a torque of the motor loses nothing.
    """
    drives = machine.drives
    undriven = [tuple(a for a in e.applied if a.booked != "supplied" and not a.of_drive) for e in machine.energies]
    own = [e.internal if len(e.applied) == len(rest) else () for e, rest in zip(machine.energies, undriven, strict=True)]
    return machine.changed(
        bodies=tuple(replace(b, coordinate=replace(b.coordinate, prescribed=None)) for b in machine.bodies),
        energies=tuple(replace(e, applied=a, internal=x) for e, a, x in zip(machine.energies, undriven, own, strict=True)),
        parts=tuple(p for p in machine.parts if p not in drives),
        start_angles={},
        schedules=tuple(s for s in machine.schedules if not any(s.parameter.startswith(f"{d.path}.") for d in drives)),
    )


def _initial(spec: CoastDown, machine: Machine, coasting: Machine) -> np.ndarray:
    """The state (n,) of the machine without drives from which it starts. Raises ``InputError``."""
    state = initial_state(coasting, spec.start)
    for rotor in machine.rotors:
        row = coasting.row(rotor.coordinate.velocity)
        if rotor.name in machine.start_angles and not _gives(spec.start, rotor.name, "angle"):
            state[coasting.row(rotor.coordinate.position)] += machine.start_angles[rotor.name]
        if not _gives(spec.start, rotor.name, "speed") and rotor.release is None:
            state[row] = _driven_speed(machine, rotor)
        for body in machine.group(rotor)[1:]:
            if body.release is not None or not _gives(spec.start, body.name, "speed"):
                state[coasting.row(body.coordinate.velocity)] = state[row]
    if not state[coasting.row(machine.rotor.coordinate.velocity)]:
        raise InputError(
            "study.start", dict(spec.start) or None,
            f"nothing turns: the machine has no drive to give {machine.rotor.name} a speed; "
            f'needed is start = {{ {machine.rotor.name} = {{ speed = "100 rad/s" }} }}',
        )  # fmt: skip
    return state


def _in_phase(machine: Machine, state: np.ndarray, to_rotor: Mapping[str, float]) -> np.ndarray:
    """A state (n,) with bodies at angles to the rotors that they turn about, from the inside outwards."""
    moved = state.copy()
    for body in machine.outward:
        if body.about is not None and body.name in to_rotor:
            head = moved[machine.row(machine.body(body.about).coordinate.position)]
            moved[machine.row(body.coordinate.position)] = head + to_rotor[body.name]
    return moved


def _phases(machine: Machine, state: np.ndarray) -> dict[str, float]:
    """The angles of the balancing bodies to their rotor in a state (n,), by name."""
    angles = angles_in(machine, state)
    return {b.name: angles[b.name] - angles[b.about] for b in machine.bodies if b.about is not None}


def _carrier_start(spec: CoastDown, machine: Machine) -> tuple[CarrierStart, str]:
    """How the carrier starts, and why it does so at rest where nobody asked for that."""
    if not machine.free_carrier:
        return CarrierStart.FIXED, ""
    if "carrier" in spec.start:
        return CarrierStart.GIVEN, ""
    if spec.vibration is None:
        at = machine.at(0.0)
        try:
            Forced.of(at, np.zeros(len(at.bodies)))
        except InputError as error:
            return CarrierStart.REST, error.allowed
    return (CarrierStart.REST if spec.vibration == "none" else CarrierStart.STEADY), ""


def _vibrating(machine: Machine, state: np.ndarray) -> np.ndarray:
    """A state (n,) in which the carrier rests, with its steady vibration. Raises ``InputError`` where that has no bound."""
    at = machine.at(0.0)
    senses = np.array([sense_of(at, body) for body in at.bodies])
    angles, speeds = (senses * np.array(list(of(at, state).values())) for of in (angles_in, speeds_in))
    forced = Forced.of(at, senses * angles)
    if any(math.isclose(w, abs(w0), rel_tol=_RESONANT) for w in forced.undamped(0.0, math.inf) for w0 in speeds):
        raise InputError(
            "study.vibration", None,
            "the machine starts at a resonance without damping, where its steady vibration has no bound; needed is another "
            "speed in study.start, damping, or vibration = 'none' to start with the carrier at rest",
        )  # fmt: skip
    displacements, velocities = forced.vibration.at_once(speeds, angles)
    moved = state.copy()
    for c, x, v in zip(at.free_carrier, displacements, velocities, strict=True):
        moved[at.row(c.position)] += x
        moved[at.row(c.velocity)] = v
    return moved


def _gives(start: Mapping[str, Any], body: str, key: str) -> bool:
    given = start.get(body)
    return key in given if isinstance(given, Mapping) else given is not None and key == "angle"


def _driven_speed(machine: Machine, rotor: RotatingBody) -> float:
    """The speed that a rotor's drive reaches, 0 if it has none; with schedules, when they are done, or last drive it."""
    driven = any(a.booked == "supplied" for e in machine.energies for a in e.applied) or rotor.coordinate.prescribed is not None
    times = reversed(machine.breakpoints) if driven else ()
    return next((speed for t in times if (speed := free_speed(machine.at(t), rotor))), 0.0)


SAMPLES_A_LEG = 20_480
SLOW = 0.01  # of the speed at the start: without `until` the run ends there
_STILL = 1e-4  # likewise, after it has turned back
_ENOUGH_SWINGS = 20

Findings = tuple[Record, CompiledSystem]  # the record so far, and what was integrated


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Integrate; what is recorded after each leg."""
    compiled = compile_system(plan.machine.system, plan.spec.tolerance, plan.events, plan.spec.engine)
    start = integrate(compiled, plan.initial, plan.machine.values, np.zeros(1))
    record = Record(start_speed=plan.start_speed, stride=plan.stride, end=start)
    yield record.after(reduced(plan.machine, plan.at_rest, compiled, record, start)), compiled
    while not _ended(plan, record):
        record = record.after(work.unit(f"leg {record.legs + 1}", partial(_leg, plan, compiled, record, work)))
        yield record, compiled


def _leg(plan: Plan, compiled: CompiledSystem, before: Record, work: Work) -> Descent:
    """The leg that begins where the one before ended."""
    last = before.end
    count = max(1, min(SAMPLES_A_LEG, round((plan.limit - last.end_time) / plan.step)))
    grid = last.end_time + plan.step * np.arange(count + 1)
    t = integrate(compiled, last.end_state, last.parameters, grid, lambda time: work.report(time / plan.limit), plan.energy)
    return reduced(plan.machine, plan.at_rest, compiled, before, t.uninterrupted())


def _ended(plan: Plan, record: Record) -> bool:
    """Whether the time is over, the run failed, or, without a time, the rotor has stopped, swung enough, or is slow."""
    if record.end.ended or record.end.end_time >= plan.limit * (1 - 1e-9):
        return True
    if plan.spec.until is not None:
        return False
    rows, start_speed = record.rows, abs(record.start_speed)
    if record.reversals:
        return len(record.reversals) >= _ENOUGH_SWINGS or abs(rows["max_speed"][-1]) < _STILL * start_speed
    return bool(record.turns.size) and abs(rows["speed"][-1]) < SLOW * start_speed
