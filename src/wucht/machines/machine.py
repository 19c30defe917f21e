"""``Machine``: parts put together. From their energies everything else follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.machines.contact import Track
from wucht.machines.parts.base import Drive, Part, Point
from wucht.machines.parts.fields import Parameter
from wucht.machines.parts.release import Release
from wucht.machines.schedules import Schedule, with_schedules
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import (
    Coordinate,
    Lock,
    acceleration,
    dissipated_power,
    equations_of_motion,
    first_order,
    reaction,
    supplied_power,
)
from wucht.mechanics.linear_carrier import LinearCarrier, linear_carrier
from wucht.system import TIME, Output, System

SUPPLIED, LOST, MISMATCH = "supplied_work", "dissipated_work", "damper_mismatch"


@dataclass(frozen=True)
class Turning:
    """A turning body as studies see it: name, kind, coordinate, what it turns about, and until when it is locked to that."""

    name: str
    kind: str
    coordinate: Coordinate
    about: str | None = None
    release: Release | None = None

    @property
    def locked(self) -> sp.Symbol:
        """The parameter that is 1 while the body is locked."""
        return sp.Symbol(f"{self.name}.locked", real=True)


@dataclass(frozen=True)
class Sliding:
    """A body in a guide: name, kind, coordinate (a displacement), and the body that guides it."""

    name: str
    kind: str
    coordinate: Coordinate
    about: str


@dataclass(frozen=True)
class Units:
    """The units of time, length, torque, power, energy, force and unbalance, all empty for a dimensionless machine."""

    time: str = "s"
    length: str = "m"
    torque: str = "N m"
    power: str = "W"
    energy: str = "J"
    force: str = "N"
    speed: str = "rad/s"


DIMENSIONLESS = Units("", "", "", "", "", "", "")


@dataclass(frozen=True)
class Machine:
    """A machine: energies in named coordinates, with parameter values.

    carrier: its coordinates, and ``labels`` what they are called (x, y, r, foundation). bodies: those that turn, in the order
    of the file; sliders: those in guides. axes: where the bodies' axes are. energies: of the parts, those of the carrier alone
    first, those of the contacts last. start_angles, start_positions: at t = 0, of what has a prescribed motion, by body and by
    label. mismatch: the power by which dampers that are not reciprocal violate action = reaction, or None.
    Two machines of one structure have equal ``system``s, whatever their values.
    """

    title: str
    carrier: tuple[Coordinate, ...]
    bodies: tuple[Turning, ...]
    energies: tuple[Energies, ...]
    parameters: Mapping[str, Parameter]
    parts: tuple[Part, ...] = ()
    units: Units = field(default_factory=Units)
    labels: tuple[str, ...] = ()
    sliders: tuple[Sliding, ...] = ()
    axes: Mapping[str, Point] = field(default_factory=dict)
    start_angles: Mapping[str, float] = field(default_factory=dict)
    start_positions: Mapping[str, float] = field(default_factory=dict)
    schedules: tuple[Schedule, ...] = ()
    tracks: tuple[Track, ...] = ()
    mismatch: sp.Expr | None = None
    warnings: tuple[str, ...] = ()

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates, then the bodies' angles, then the sliders' displacements."""
        return (*self.carrier, *(b.coordinate for b in self.bodies), *(s.coordinate for s in self.sliders))

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """The names of the System's states, in order: positions, then the velocities that are free."""
        free = (c.velocity.name for c in self.coordinates if c.prescribed is None)
        return (*(c.position.name for c in self.coordinates), *free)

    @cached_property
    def values(self) -> dict[str, float]:
        """Parameter values by path."""
        return {path: p.value for path, p in self.parameters.items()}

    @cached_property
    def numbers(self) -> dict[sp.Symbol, float]:
        """Parameter values by symbol, to be put into expressions."""
        return {sp.Symbol(path, real=True): value for path, value in self.values.items()}

    @cached_property
    def rotor(self) -> Turning:
        """The main rotor: the first body that turns about no other."""
        return self.rotors[0]

    @cached_property
    def rotors(self) -> tuple[Turning, ...]:
        """The bodies that turn about no other."""
        return tuple(b for b in self.bodies if b.about is None)

    @cached_property
    def drives(self) -> tuple[Drive, ...]:
        """The machine's drives."""
        return tuple(p for p in self.parts if isinstance(p, Drive))

    @cached_property
    def free_carrier(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates without those whose motion is prescribed."""
        return tuple(c for c in self.carrier if c.prescribed is None)

    @cached_property
    def free_labels(self) -> tuple[str, ...]:
        """What the free coordinates of the carrier are called."""
        return tuple(n for n, c in zip(self.labels, self.carrier, strict=True) if c.prescribed is None)

    @cached_property
    def shaken(self) -> Coordinate | None:
        """The carrier's coordinate whose motion is prescribed, if one is."""
        return next((c for c in self.carrier if c.prescribed is not None), None)

    @cached_property
    def turning(self) -> Coordinate | None:
        """The carrier's turning about the normal of the plane, with which a locked rotor turns; None where it does not turn."""
        tilting = any(getattr(p, "tilting", False) for p in self.parts)
        return None if tilting or "r" not in self.labels else self.carrier[self.labels.index("r")]

    @cached_property
    def corners(self) -> tuple[float, ...]:
        """The times of the points of all schedules, in order, at least t = 0."""
        return tuple(sorted({0.0, *(t for s in self.schedules for t in s.pieces.corners)}))

    def with_values(self, values: Mapping[str, float]) -> Machine:
        """The machine with other values of some parameters, by path; its structure stays."""
        changed = {path: replace(self.parameters[path], value=float(value)) for path, value in values.items()}
        found = replace(self, parameters=dict(self.parameters) | changed)
        for name in ("system", "linear_carrier"):  # of the structure alone: what has been derived is not derived again
            if name in self.__dict__:
                found.__dict__[name] = self.__dict__[name]
        return found

    def at(self, time: float) -> Machine:
        """The machine with the values that its schedules give the parameters at a time."""
        if not self.schedules:
            return self
        return self.with_values({s.parameter: float(s.pieces(time)) for s in self.schedules})

    def prescribed_speed(self, coordinate: Coordinate, time: np.ndarray | float) -> np.ndarray:
        """The prescribed velocity of a coordinate at times (N,), which may be a single one."""
        from wucht.numerics.flow.program import python_function

        assert coordinate.prescribed is not None
        at = np.atleast_1d(np.asarray(time, float))
        function = python_function((TIME,), (), (coordinate.prescribed.xreplace(self.numbers),))
        return np.broadcast_to(np.asarray(function(at)[0], float), at.shape)

    @cached_property
    def linear_carrier(self) -> LinearCarrier:
        """M, C, K of the free carrier and its coupling to the bodies, symbolic; sliders in the middle of their guides."""
        still = [s.coordinate for s in self.sliders] + [c for c in self.carrier if c.prescribed is not None]
        return linear_carrier(self.energies, self.free_carrier, [b.coordinate for b in self.bodies], still)

    @cached_property
    def system(self) -> System:
        """The equations of motion, with outputs and with the quadratures of the energy balance."""
        coordinates = self.coordinates
        quadratures = [
            Output(SUPPLIED, supplied_power(self.energies, coordinates), self.units.energy, "work of the drives"),
            Output(LOST, dissipated_power(self.energies, coordinates), self.units.energy, "energy dissipated"),
        ]
        if self.mismatch is not None:
            quadratures.append(
                Output(MISMATCH, self.mismatch, self.units.energy, "work created by dampers that are not reciprocal")
            )
        found = first_order(
            equations_of_motion(self.energies, coordinates),
            coordinates,
            [sp.Symbol(path, real=True) for path in self.parameters],
            tuple(self._outputs()),
            tuple(quadratures),
            self._locks(),
        )
        return with_schedules(found, self.schedules, self._stored(), self.units.energy)

    def _locks(self) -> list[Lock]:
        index = {b.name: len(self.carrier) + k for k, b in enumerate(self.bodies)}
        depth = {b.name: 0 for b in self.bodies}
        for b in self.bodies:
            above = b.about
            while above is not None:
                depth[b.name] += 1
                above = next(o.about for o in self.bodies if o.name == above)
        turning = self.carrier.index(self.turning) if self.turning is not None else None
        locked = sorted((b for b in self.bodies if b.release is not None), key=lambda b: -depth[b.name])
        return [Lock(index[b.name], turning if b.about is None else index[b.about], b.locked) for b in locked]

    def _stored(self) -> sp.Expr:
        return sp.Add(*(e.kinetic for e in self.energies), *(e.potential for e in self.energies))

    def _outputs(self) -> list[Output]:
        u = self.units
        found = [Output("stored_energy", self._stored(), u.energy, "stored energy")]
        applied = [a for e in self.energies for a in e.applied if a.booked == "supplied"]
        bodies = [b.coordinate for b in self.bodies]
        torque = sp.Add(*(a.force for a in applied), *(reaction(c) for c in bodies if c.prescribed is not None))
        found.append(Output("motor_torque", torque, u.torque, "motor torque"))
        found.append(Output("motor_power", supplied_power(self.energies, self.coordinates), u.power, "motor power"))
        for c in self.coordinates:
            if c.prescribed is not None:
                found.append(Output(c.velocity.name, c.velocity, u.speed, "speed"))
        alone = equations_of_motion(self.energies[:1], self.carrier)
        for i, label in enumerate(self.labels):
            # The bodies push the carrier with what its own equation of motion leaves open.
            inertial = sp.Add(*(alone.mass[i, k] * acceleration(other) for k, other in enumerate(self.carrier)))
            long_name = f"bearing moment in {label}" if label == "r" else f"bearing force in {label}"
            found.append(Output(f"bearing_force_{label}", inertial - alone.forces[i], u.force, long_name))
        for name, (position, velocity) in self.orbit.items():
            found += [Output(f"orbit.{name}", position, u.length), Output(f"orbit.v{name}", velocity, "")]
        return found

    @cached_property
    def orbit(self) -> dict[str, tuple[sp.Expr, sp.Expr]]:
        """The motion whose amplitude is looked at: x, y of the main rotor's axis, or the angle of a carrier that only turns."""
        if self.labels == ("r",):
            (c,) = self.carrier
            return {"r": (c.position, c.velocity)}
        at = self.axes.get(self.rotor.name)
        moving = {} if at is None else {"x": (at.x, at.vx), "y": (at.y, at.vy)}
        return {n: (x, v) for n, (x, v) in moving.items() if x != 0}

    @property
    def orbit_unit(self) -> str:
        """The unit of the amplitude."""
        return "rad" if self.labels == ("r",) else self.units.length
