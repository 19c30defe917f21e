"""``Machine``: parts put together. From their energies everything else follows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property

import sympy as sp

from wucht.machines.parts.base import Drive, Parameter, Part
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import (
    Coordinate,
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
class Turning:
    """A turning body as studies see it: name, kind, coordinate, the body it turns about, and the drives on it."""

    name: str
    kind: str
    coordinate: Coordinate
    about: str | None = None


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

    carrier: its translational coordinates. bodies: those that turn, in the order of the file. energies: of the parts, those
    of the carrier alone first. start_angles: of driven bodies whose motion is prescribed. mismatch: the power by which
    dampers that are not reciprocal violate action = reaction, or None.
    Two machines of one structure have equal ``system``s, whatever their values.
    """

    title: str
    carrier: tuple[Coordinate, ...]
    bodies: tuple[Turning, ...]
    energies: tuple[Energies, ...]
    parameters: Mapping[str, Parameter]
    parts: tuple[Part, ...] = ()
    units: Units = field(default_factory=Units)
    start_angles: Mapping[str, float] = field(default_factory=dict)
    mismatch: sp.Expr | None = None
    warnings: tuple[str, ...] = ()

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates, then the bodies' angles."""
        return (*self.carrier, *(b.coordinate for b in self.bodies))

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
        return next(b for b in self.bodies if b.about is None)

    @cached_property
    def drives(self) -> tuple[Drive, ...]:
        """The machine's drives."""
        return tuple(p for p in self.parts if isinstance(p, Drive))

    @cached_property
    def linear_carrier(self) -> LinearCarrier:
        """M, C, K of the carrier and its coupling to the bodies, symbolic."""
        return linear_carrier(self.energies, self.carrier, [b.coordinate for b in self.bodies])

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
        return first_order(
            equations_of_motion(self.energies, coordinates),
            coordinates,
            [sp.Symbol(path, real=True) for path in self.parameters],
            tuple(self._outputs()),
            tuple(quadratures),
        )

    def _outputs(self) -> list[Output]:
        u = self.units
        kinetic = sp.Add(*(e.kinetic for e in self.energies))
        potential = sp.Add(*(e.potential for e in self.energies))
        found = [Output("stored_energy", kinetic + potential, u.energy, "stored energy")]
        applied = [a for e in self.energies for a in e.applied if a.booked == "supplied"]
        enforced = [c for c in self.coordinates if c.prescribed is not None]
        torque = sp.Add(*(a.force for a in applied), *(reaction(c) for c in enforced))
        found.append(Output("motor_torque", torque, u.torque, "motor torque"))
        found.append(Output("motor_power", supplied_power(self.energies, self.coordinates), u.power, "motor power"))
        for c in self.coordinates:
            if c.prescribed is not None:
                found.append(Output(c.velocity.name, c.velocity, u.speed, "speed"))
        alone = equations_of_motion(self.energies[:1], self.carrier)
        for i, c in enumerate(self.carrier):
            # The bodies push the carrier with what its own equation of motion leaves open.
            inertial = sp.Add(*(alone.mass[i, k] * acceleration(other) for k, other in enumerate(self.carrier)))
            axis = c.position.name[-1]
            found.append(Output(f"bearing_force_{axis}", inertial - alone.forces[i], u.force, f"bearing force in {axis}"))
        return found
