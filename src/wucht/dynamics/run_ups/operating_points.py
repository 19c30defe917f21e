"""The operating points of a machine: speeds at which the torques balance, with the bodies where they are then."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.configuration import FULL_UNDECIDED, Configuration, ConfigurationDescriber
from wucht.analysis.configurations.search import StateSearch, all_states
from wucht.analysis.configurations.steady_branches import labels_of
from wucht.analysis.foundation_forces import SteadyFoundation
from wucht.analysis.throw import Throw, steady_throw
from wucht.analysis.time_constants import highest_speed
from wucht.analysis.vibration import ForcedVibration
from wucht.analysis.working_points import TorqueCurves, WorkingPoint
from wucht.dynamics.run_ups.steady_phases import SteadyPhases, configuration_labels
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import LOWEST, free_speed, natural_frequencies, net_torque, sense_of
from wucht.machines.tree import RotatingBody

_FAR, _POINTS = 20.0, 1200  # times the highest natural frequency; speeds in the search for operating points


@dataclass(frozen=True)
class SteadyState:
    """A steady state that may be reached.

    speed: of a rotor, in magnitude. phases: of the other rotors to the main one, in rad, each in its sense. share: the residual
    unbalance of the main rotor, as a share of its own; None where that does not matter. reach: share by which the speed that is
    reached may differ, as averaged equations do from the full ones.
    """

    speed: float
    phases: Mapping[str, float] = field(default_factory=dict)
    share: float | None = None
    reach: float = 0.01


def steady_state(machine: Machine, c: Configuration) -> SteadyState:
    """Return the state of a machine in a configuration."""
    other_rotors = [r.name for r in machine.rotors[1:]]
    return SteadyState(abs(c.speed), {name: c.phases[name] for name in other_rotors}, None if other_rotors else c.share)


@dataclass(frozen=True)
class OperatingPoints:
    """The operating points on one shaft, the slowest first.

    configurations, labels: of the bodies at each point, empty where bodies are held. search: record of the search for them.
    """

    points: tuple[WorkingPoint, ...]
    configurations: tuple[Configuration, ...] = ()
    labels: tuple[str, ...] = ()
    search: StateSearch | None = None

    @classmethod
    def of(
        cls, steady: SteadyPhases, curves: Sequence[TorqueCurves], speeds: tuple[float, float], watch: Callable[[], None] | None
    ) -> OperatingPoints:
        """The operating points: crossings of the curve of held bodies, else all configurations in which the torques balance.

        Parameters
        ----------
        steady : SteadyPhases
        curves : sequence of TorqueCurves
            Of the shaft, one for each branch, or that of the held bodies.
        speeds : (float, float)
            Lowest and highest speed, in the sense of the shaft where bodies are in steady phases, else signed.
        watch : callable or None
            Called often; an exception from it ends the search.
        """
        base = curves[0]
        if steady.torques is None:
            return cls(tuple(base.working_points))
        if steady.configurations is not None:
            sense = sense_of(steady.machine, base.rotor)
            configurations = tuple(c for c in steady.configurations if speeds[0] <= abs(c.speed) <= speeds[1])
            points = tuple(base.point(sense * abs(c.speed), c.slow.stable is True) for c in configurations)
            return cls(points, configurations, tuple(configuration_labels(configurations)))
        search = all_states(steady.torques, *speeds, watch, prove=False)
        describer = ConfigurationDescriber(AveragedStability(steady.torques, averaged_equations_of(steady.torques.machine)))
        configurations = tuple(sorted((describer.describe(s, FULL_UNDECIDED) for s in search.states), key=lambda c: c.speed))
        labels = (labels_of(steady.torques, c.state.sides, c.state.phases[:, None])[0] for c in configurations)
        points = tuple(base.point(c.speed, c.slow.stable is True) for c in configurations)
        return cls(points, configurations, tuple(map(str, labels)), search)

    def states(self, machine: Machine) -> list[SteadyState]:
        """Return the steady state at each point."""
        if not self.configurations:
            return [SteadyState(abs(p.speed)) for p in self.points]
        return [steady_state(machine, c) for c in self.configurations]

    def stable_states(self, machine: Machine) -> list[SteadyState]:
        """Return the states of those that are stable and possible."""
        return [state for state, possible in zip(self.states(machine), self.possible, strict=True) if possible]

    @property
    def possible(self) -> list[bool]:
        """True for each point that is stable and without overlapping bodies."""
        return [p.stable and not over for p, over in zip(self.points, self.overlapping, strict=True)]

    @property
    def overlapping(self) -> list[bool]:
        """True for each point at which bodies of a track would overlap."""
        return [c.overlapping for c in self.configurations] or [False] * len(self.points)


@dataclass(frozen=True)
class Operation:
    """The vibration at a stable operating point. label: of the configuration, empty for held bodies. foundation: the forces on
    it, None without supports."""

    speed: float
    amplitude: float
    label: str
    throw: Throw | None
    state: SteadyState
    foundation: SteadyFoundation | None = None


def vibration_in_operation(steady: SteadyPhases, watch: Callable[[], None] | None = None) -> tuple[Operation, ...]:
    """Return the vibration at each stable operating point of the main rotor, none where nothing drives it by a torque."""
    machine, rotor = steady.machine, steady.machine.rotor
    if rotor.coordinate.prescribed_velocity is not None or not (free_speed(machine, rotor) or net_torque(machine, rotor)(0.0)):
        return ()
    speeds = shaft_speed_range(steady, rotor)
    curves = [TorqueCurves(machine, rotor, vibration, speeds, _POINTS) for vibration in steady.curves]
    in_sense = speeds if steady.torques is None else speeds_in_sense(steady, rotor, speeds)
    operating = OperatingPoints.of(steady, curves, in_sense, watch)
    states = operating.states(machine)
    if steady.torques is not None:
        rows = zip(operating.points, operating.configurations, operating.labels, states, operating.possible, strict=True)
        return tuple(
            Operation(p.speed, c.amplitude, n, c.throw, s, SteadyFoundation.of(machine, _vibration_in(machine, c), p.speed))
            for p, c, n, s, possible in rows
            if possible
        )
    at = steady.forced_vibration
    return tuple(
        Operation(
            p.speed, float(at.amplitude(np.array([abs(p.speed)]))[0][0]), "", steady_throw(machine, at, p.speed), s,
            SteadyFoundation.of(machine, at, p.speed),
        )
        for p, s in zip(operating.points, states, strict=True)
        if p.stable
    )  # fmt: skip


def _vibration_in(machine: Machine, c: Configuration) -> ForcedVibration:
    """The vibration with the bodies in a configuration."""
    angles = {machine.rotor.name: 0.0}
    for body in machine.outward:
        if body is not machine.rotor:
            head = (
                sense_of(machine, body) * c.phases[body.name]
                if body.about is None
                else angles[body.about] + c.phases[body.name]
            )
            angles[body.name] = head
    return ForcedVibration.of(machine, np.array([angles[b.name] for b in machine.bodies]))


def speeds_in_sense(steady: SteadyPhases, rotor: RotatingBody, speeds: tuple[float, float]) -> tuple[float, float]:
    """Return the part of a signed range of speeds in which a rotor turns as driven.

    Raises ``InputError`` if there is none.
    """
    sense = sense_of(steady.machine, rotor)
    low, high = sorted(sense * w for w in speeds)
    if low < 0 or not high > 0:
        requirement = "must be speeds in the sense in which the drive turns; with study.bodies = 'held' any speeds are allowed"
        raise InputError("study.range", list(speeds), requirement)
    return max(low, LOWEST * high), high


def shaft_speed_range(steady: SteadyPhases, rotor: RotatingBody) -> tuple[float, float]:
    """Return the speeds of a shaft in operation, signed: up to 1.2 times the speed of the drive.

    If that is out of reach, up to all operating points.
    """
    machine = steady.machine
    free, torque = free_speed(machine, rotor), net_torque(machine, rotor)(0.0)
    natural = max([f for f in natural_frequencies(machine).values() if f > 0], default=100.0)
    reach = min(highest_speed(machine), _FAR * natural) if machine.dimensionless else highest_speed(machine)
    if free and abs(free) <= reach:
        end = 1.2 * free
    else:  # the vibration may limit the speed far beyond all resonances
        sense = math.copysign(1.0, free or torque)
        limits = (0.0, reach) if sense > 0 else (-reach, 0.0)
        points = TorqueCurves(machine, rotor, steady.forced_vibration, limits, _POINTS).working_points
        end = sense * max([3 * natural, *(1.2 * abs(p.speed) for p in points)])
    return min(0.0, end), max(0.0, end)
