"""What a sweep reads: speed and amplitude of a machine, with the drive's speed without vibration; the states of equations."""

from __future__ import annotations

import math
from collections.abc import Callable
from functools import lru_cache, partial
from typing import Any

import numpy as np

from wucht.dynamics.sweeps.course import Ends, SweepCourse
from wucht.dynamics.sweeps.moving import MovedMachine
from wucht.dynamics.sweeps.steps import MOST_MAXIMA, SteppedEquations
from wucht.machines.operation import free_speed
from wucht.schema import Parameter
from wucht.studies.answer import Answer
from wucht.studies.motion_variables import state_parameters
from wucht.studies.sweep.answer import Observables

_FREE_SPEEDS = 21


def machine_observables(moved_machine: MovedMachine, ends: Ends, is_rate_chosen: bool) -> Observables:
    """Return what is read of a machine. ends: lowest and highest value of the parameter."""
    length, chosen = moved_machine.machine.orbit_unit, " (chosen so that the machine follows)" if is_rate_chosen else ""
    return Observables(
        follower="machine",
        pace=f"at {{rate:.3g}}{chosen}",
        jump_parts={
            "from_speed": ("speed before the jump", "speed"), "to_speed": ("speed after the jump", "speed"),
            "from_amplitude": ("amplitude before the jump", length), "to_amplitude": ("amplitude after the jump", length),
            "fold": ("whether the branch ends in a fold there", ""),
            "only_seen": ("whether it is known from the ramp only", ""),
        },
        jump_columns={
            "value": "value", "from": "from_speed", "to": "to_speed", "from_amplitude": "from_amplitude",
            "to_amplitude": "to_amplitude",
        },
        jump_lines=("speed {from_speed} to {to_speed}", "amplitude {from_amplitude} to {to_amplitude}"),
        accuracy="{jump_tolerance:.0e} of these values, obtained with {along} held: independent of the rate",
        last_line=("energy", "balance closed to {energy_residual:.1e}"),
        state_ways=partial(_state_ramps, moved_machine, lru_cache(partial(_free_speeds, moved_machine, ends))),
    )  # fmt: skip


def _free_speeds(moved_machine: MovedMachine, ends: Ends) -> tuple[np.ndarray, np.ndarray]:
    """Values (21,) of the parameter, and the speeds of the main rotor without vibration there, NaN where there is none."""
    grid = np.linspace(*ends, _FREE_SPEEDS)
    machines = [moved_machine.machine.with_unchecked_values({moved_machine.path: float(v)}) for v in grid]
    return grid, np.array([free_speed(machine, machine.rotor) for machine in machines], float)


def _state_ramps(
    moved_machine: MovedMachine,
    free_speeds: Callable[[], tuple[np.ndarray, np.ndarray]],
    a: Answer,
    parameter: Parameter,
    course: SweepCourse,
) -> None:
    """State the readings of the ramps, NaN where one ended early."""
    machine, samples, (grid, free) = moved_machine.machine, moved_machine.pace.samples, free_speeds()
    ramps, length, over, speed = course.ways, machine.orbit_unit, "direction sample", a.unit("speed")

    def readings(key: str) -> np.ndarray:
        rows = [[getattr(leg, key) for leg in legs] for legs in ramps.values()]
        return np.array([row + [math.nan] * (samples - len(row)) for row in rows]).reshape(len(rows), samples)

    a.attribute(engine=moved_machine.compiled_system.engine_name)
    a.number("jump_tolerance", moved_machine.jump_tolerance, "relative tolerance of the values of jumps")
    a.curve("grid", grid, parameter.full_name, parameter.unit)
    a.curve("free_speed", free, "speed reached without vibration", "speed", "grid")
    state_parameters(a, machine)
    _state_direction(a, parameter, course, readings("value"), over, coordinate=True)
    a.curve("speed", readings("speed"), "mean speed", "speed", over)
    a.curve("min_speed", readings("low"), "least speed, mean over a turn", "speed", over)
    a.curve("max_speed", readings("high"), "largest speed, mean over a turn", "speed", over)
    a.curve("amplitude", readings("amplitude"), "amplitude of the axis", length, over)
    a.curve("energy_residual", readings("energy_residual"), "energy residual, relative", "", over)
    legs = [leg for of_ramp in ramps.values() for leg in of_ramp]
    peak, residual = (max((getattr(leg, key) for leg in legs), default=None) for key in ("amplitude", "energy_residual"))
    a.number("peak_amplitude", peak, "largest amplitude of the axis", length, headline=True)
    a.number("energy_residual", residual, "largest relative error of the energy balance")
    ends = {way: {"from_speed": r[0].speed, "to_speed": r[-1].speed} for way, r in ramps.items() if r}
    parts = {"from_speed": ("speed at its start", speed), "to_speed": ("speed at its end", speed)}
    a.number("ends", ends, "speeds at the ends of each ramp", parts=parts)
    for way in ends:
        a.line(way, "{from_speed} to {to_speed}", at=f"ends.{way}")


def state_observables(sweep: SteppedEquations) -> Observables:
    """Return what is read of equations."""
    return Observables(
        follower="motion",
        pace="in steps, a time of {span:.4g} at each",
        jump_parts={
            "state": ("state that jumps most", ""),
            "from": ("largest value of that state before the jump", ""),
            "to": ("largest value of that state after it", ""),
        },
        jump_columns={name: name for name in ("value", "state", "from", "to")},
        jump_lines=("{state} {from:.5g} to {to:.5g}",),
        accuracy="half a step of {along}: jumps lie between two of its values",
        last_line=None,
        state_ways=partial(_state_steps, sweep),
    )


def _state_steps(sweep: SteppedEquations, a: Answer, parameter: Parameter, course: SweepCourse) -> None:
    """State least, largest and mean value of each state at each value of the parameter, and its maxima."""
    system, shape = sweep.subject.system, (len(course.ways), len(sweep.start), sweep.points)

    def records(key: str, *shape: int) -> np.ndarray:
        return np.array([getattr(way, key) for way in course.ways.values()]).reshape(shape)

    a.attribute(subject="system")
    _state_direction(a, parameter, course, records("values", len(course.ways), sweep.points), "direction step")
    a.curve("state", list(system.state_names), "state")
    angles = list(map(int, system.is_angle))
    a.curve("is_angle", angles, "1 of an angle", "", "state", coordinate=True)
    for name, word in {"low": "least value", "high": "largest value", "mean": "mean value"}.items():
        a.curve(name, records(name, *shape), f"{word} of the state", "", "direction state step")
    a.curve("maxima", records("maxima", *shape, MOST_MAXIMA), "maximum of the state", "", "direction state step peak")


def _state_direction(a: Answer, parameter: Parameter, course: SweepCourse, values: np.ndarray, over: str, **facts: Any) -> None:
    """State the ways with the values of the parameter on them."""
    a.curve("direction", list(course.ways) or np.empty(0, "U4"), "direction of the sweep")
    a.curve("value", values, parameter.full_name, parameter.unit, over, **facts)
