"""Question and subject -> plan: the equations along the parameter, and the values at which states are searched."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged import keeps_inertia
from wucht.analysis.configurations.steady_machine import MOST_BODIES, turning
from wucht.dynamics.parameters import ends_of, parameter_of, values_of, with_parameters
from wucht.errors import InputError, nearest
from wucht.fields import Parameter
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.studies.speed_curve.family_curve import FamilyCurve
from wucht.studies.speed_curve.own_states import OwnStates
from wucht.studies.speed_curve.second_parameter import SecondParameter
from wucht.studies.speed_curve.slow_states import SlowStates
from wucht.studies.speed_curve.spec import SpeedCurve
from wucht.studies.speed_curve.steady_states import SteadyStates
from wucht.system import TIME

RESERVED = frozenset({  # keys of the summary, beside which stands the parameter's own name
    "kind", "speed", "state", "amplitude", "branch", "frequency", "type", "name", "label", "stable", "stable_speeds",
    "partly_stable", "partly_stable_speeds", "partly_stable_shares",
    "range", "second_range", "ends", "family_dimension", "multiplicity", "of",
    "coefficients", "special_points",
})  # fmt: skip
_NEAR_AN_END = 1e-3  # of the range
_DECADE = 10.0


@dataclass(frozen=True)
class Plan:
    """What is to be done.

    along, second: the parameters. curves: the states along the first, for each value of the second (None where there are no
    such values). families: those of each of these curves, None where the subject has none. plane: the second parameter where
    it has a range. searched: values at which all states are searched.
    """

    spec: SpeedCurve
    along: Parameter
    second: Parameter | None
    bounds: tuple[float, float]
    curves: tuple[tuple[float | None, SteadyStates], ...]
    families: tuple[FamilyCurve | None, ...]
    plane: SecondParameter | None
    searched: tuple[float, ...]


def prepare(spec: SpeedCurve, subject: Machine | OwnEquations) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the subject, or it has no averaged equations."""
    along = _parameter(subject, spec.along, "along")
    bounds = ends_of(subject, along, spec.range)
    second, plane, values = None, None, tuple[float | None, ...]([None])
    if spec.second is not None and spec.second_range is not None:
        second = _parameter(subject, spec.second, "second")
        limits = ends_of(subject, second, spec.second_range, "second_range")
        plane = SecondParameter(second.path, limits, second.value)
        if not limits[0] <= second.value <= limits[1]:
            needed = f"must contain the value {second.value:.6g} that {second.path} has: there the curves begin"
            raise InputError("study.second_range", list(spec.second_range), needed)
    elif spec.second is not None and spec.second_values is not None:
        second = _parameter(subject, spec.second, "second")
        values = tuple(dict.fromkeys(values_of(subject, second, spec.second_values, "second_values")))
    of = [(v, subject if v is None or second is None else with_parameters(subject, {second.path: v})) for v in values]
    made = [_states(spec, one, along, bounds) for _, one in of]
    curves = tuple((v, states) for (v, _), (states, _) in zip(of, made, strict=True))
    families = tuple(family for _, family in made)
    return Plan(spec, along, second, bounds, curves, families, plane, _searched(bounds, spec.points))


def _parameter(subject: Machine | OwnEquations, path: str, key: str) -> Parameter:
    found = parameter_of(subject, path, key)
    if isinstance(subject, OwnEquations) and path in RESERVED:
        raise InputError(f"study.{key}", path, "in the results this is the name of something else: rename the parameter")
    return found


def _states(
    spec: SpeedCurve, subject: Machine | OwnEquations, along: Parameter, bounds: tuple[float, float]
) -> tuple[SteadyStates, FamilyCurve | None]:
    if isinstance(subject, Machine):
        states = _of_machine(spec, subject, along, bounds)
        return states, FamilyCurve(states)
    return _of_equations(spec, subject, along, bounds), None


def _of_machine(spec: SpeedCurve, machine: Machine, along: Parameter, bounds: tuple[float, float]) -> SlowStates:
    if len(machine.bodies) > MOST_BODIES:
        raise InputError("machine.bodies", len(machine.bodies), f"there must be at most {MOST_BODIES}, the main rotor included")
    if spec.ranges is not None:
        raise InputError("study.ranges", dict(spec.ranges), "allowed for a table [system] only")
    if machine.shaken is not None:
        sentence = "the carrier's motion is prescribed: whether it entrains the rotor is study.kind = 'entrainment'"
        raise InputError("machine.carrier.motion", None, sentence)
    steady = turning(machine, None)
    inertia = keeps_inertia(steady, spec.inertia)
    states = SlowStates(steady, along.path, bounds, inertia, spec.show)
    if not states.names:
        why = "its speed is prescribed and nothing else turns: no state is left that could depend on a parameter"
        raise InputError("machine.drive", None, f"{why}; study.kind = 'response' shows its vibration")
    if along.path not in states.averaged.system.parameter_names:
        raise InputError("study.along", along.path, "not allowed: the averaged equations do not depend on it")
    if spec.show is not None and spec.show not in states.names:
        raise InputError("study.show", spec.show, f"unknown state; {nearest(spec.show, states.names)}")
    if not states.fastest > 0:
        raise InputError("study.range", list(bounds), "nothing drives the machine there: it has no steady operation")
    return states


def _of_equations(spec: SpeedCurve, own: OwnEquations, along: Parameter, bounds: tuple[float, float]) -> OwnStates:
    names, turning = own.system.state_names, {s.name for s in own.system.angles}
    for key, given in (("only", spec.only), ("inertia", spec.inertia)):
        if given is not None:
            raise InputError(f"study.{key}", given, "allowed for a machine only")
    if any(TIME in e.free_symbols for e in (*own.system.derivatives, *(e for _, e in own.system.definitions))):
        raise InputError("system", None, "these equations depend on the time t: they have no equilibria")
    show = spec.show or names[0]
    if show not in names:
        raise InputError("study.show", show, f"unknown state; {nearest(show, names)}")
    ranges = dict(spec.ranges or {}) | {n: (0.0, 2 * np.pi) for n in turning if n not in (spec.ranges or {})}
    for name in ranges:
        if name not in names:
            raise InputError(f"study.ranges.{name}", list(ranges[name]), f"unknown state; {nearest(name, names)}")
    for name in names:
        if name not in ranges:
            needed = f"needed is a pair [low, high] for {name}: ranges = {{ {name} = [low, high] }}"
            raise InputError("study.ranges", None, f"this key is missing; {needed}, in which equilibria are searched")
    return OwnStates(own, along.path, bounds, {n: ranges[n] for n in names}, show)


def _searched(bounds: tuple[float, float], points: int) -> tuple[float, ...]:
    """Values over a range, evenly or, over decades, in a constant ratio, and one near each end."""
    (low, high), between = bounds, (np.arange(points) + 0.5) / points
    inside = low * (high / low) ** between if low > 0 and high > _DECADE * low else low + (high - low) * between
    near = _NEAR_AN_END * (high - low)
    return (low + near, *inside.tolist(), high - near)
