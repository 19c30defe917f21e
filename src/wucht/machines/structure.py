"""What of a machine does not depend on its numbers: everything symbolic, derived once for all machines of one structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import sympy as sp

from wucht.machines.parts.base import Point
from wucht.machines.schedules import Schedule, with_schedules
from wucht.machines.tree import RotatingBody, SlidingBody
from wucht.machines.unit_names import Units
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
from wucht.system import Output, System

SUPPLIED, LOST, MISMATCH = "supplied_work", "dissipated_work", "damper_mismatch"


@dataclass(frozen=True)
class Structure:
    """Energies in named coordinates. See ``Machine`` for the fields they share.

    parameters: their paths. turning: the carrier's turning about the normal of the plane. axis: of the main rotor.
    """

    carrier: tuple[Coordinate, ...]
    labels: tuple[str, ...]
    bodies: tuple[RotatingBody, ...]
    sliders: tuple[SlidingBody, ...]
    energies: tuple[Energies, ...]
    parameters: tuple[str, ...]
    units: Units
    turning: Coordinate | None
    axis: Point | None
    depths: tuple[int, ...]
    schedules: tuple[Schedule, ...] = ()
    mismatch: sp.Expr | None = None

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.carrier, self.bodies, self.sliders, self.energies, self.parameters, self.schedules))

    @cached_property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The parameters' symbols."""
        return tuple(sp.Symbol(path, real=True) for path in self.parameters)

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates, then the bodies' angles, then the sliders' displacements."""
        return (*self.carrier, *(b.coordinate for b in self.bodies), *(s.coordinate for s in self.sliders))

    @cached_property
    def free_carrier(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates without those whose motion is prescribed."""
        return tuple(c for c in self.carrier if c.prescribed is None)

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
            list(self.symbols),
            tuple(self._outputs()),
            tuple(quadratures),
            self._locks(),
        )
        return with_schedules(found, self.schedules, self._stored(), self.units.energy)

    def _locks(self) -> list[Lock]:
        index = {b.name: len(self.carrier) + k for k, b in enumerate(self.bodies)}
        turning = self.carrier.index(self.turning) if self.turning is not None else None
        outermost_first = sorted(zip(self.depths, self.bodies, strict=True), key=lambda pair: -pair[0])
        return [
            Lock(index[b.name], turning if b.about is None else index[b.about], b.locked)
            for _, b in outermost_first
            if b.release is not None
        ]

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
        moving = {} if self.axis is None else {"x": (self.axis.x, self.axis.vx), "y": (self.axis.y, self.axis.vy)}
        return {n: (x, v) for n, (x, v) in moving.items() if x != 0}

    @cached_property
    def orbit_shape(self) -> sp.ImmutableMatrix:
        """By how much the axis moves with each free coordinate of the carrier (2, m): x and y, or its angle and nothing."""
        names = "r" if "r" in self.orbit else "xy"
        places = [self.orbit[n][0] if n in self.orbit else sp.S.Zero for n in names]
        free = [c.position for c in self.free_carrier]
        rows = [[sp.diff(place, q) for q in free] for place in (*places, sp.S.Zero)[:2]]
        return sp.ImmutableMatrix(2, len(free), [x for row in rows for x in row])

    @cached_property
    def kinetic_in_operation(self) -> sp.Expr:
        """The kinetic energy of the bodies that all turn with ``SPEED``, all else at rest."""
        rest = dict.fromkeys((s for c in self.coordinates for s in (c.position, c.velocity)), sp.S.Zero)
        speed = dict.fromkeys((b.coordinate.velocity for b in self.bodies), SPEED)
        return sp.sympify(sp.Add(*(e.kinetic for e in self.energies)).xreplace(rest | speed))

    def shaft_torques(self, velocities: Sequence[sp.Symbol]) -> tuple[sp.Expr, sp.Expr]:
        """What drives bodies of these velocities that turn with ``SPEED``, and what brakes them, the carrier at rest.

        Of all drives, in the direction of positive speeds; of loads and bearings, against it.
        """
        return _shaft_torques(self, tuple(velocities))


SPEED = sp.Symbol("speed", real=True)


@lru_cache(maxsize=256)
def shared(structure: Structure) -> Structure:
    """The first structure that is equal to this one: what has been derived from it is there."""
    return structure


@lru_cache(maxsize=256)
def _shaft_torques(structure: Structure, velocities: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, sp.Expr]:
    drive, losses = list[sp.Expr](), list[sp.Expr]()
    for v in velocities:
        for e in structure.energies:
            losses.append(sp.diff(e.dissipation, v))
            for a in e.applied:
                torque = a.force * sp.diff(a.rate, v)
                (drive if a.booked == "supplied" else losses).append(torque if a.booked == "supplied" else -torque)
    still = {
        s: sp.S.Zero for c in (*structure.carrier, *(x.coordinate for x in structure.sliders)) for s in (c.position, c.velocity)
    }
    still |= {b.coordinate.velocity: SPEED for b in structure.bodies}
    first, second = (sp.sympify(sp.Add(*f).xreplace(still)) for f in (drive, losses))
    return first, second
