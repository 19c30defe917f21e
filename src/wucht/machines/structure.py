"""The symbolic part of a machine, which does not depend on its numbers: derived once for all machines of one structure."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property, lru_cache

import sympy as sp

from wucht.disk_cache import derived_once
from wucht.machines.schedules import Schedule, with_schedules
from wucht.machines.tree import Bodies, RotatingBody
from wucht.mechanics import lagrange
from wucht.mechanics.energies import Energies
from wucht.mechanics.linear_carrier import LinearCarrier, linear_carrier
from wucht.system import Output, System

SUPPLIED_WORK, DISSIPATED_WORK, MISMATCH = "supplied_work", "dissipated_work", "damper_mismatch"


SPEED = sp.Symbol("speed", real=True)


@dataclass(frozen=True)
class Units:
    """The units of time, length, torque, power, energy, force and speed, all empty for a dimensionless machine."""

    time: str = "s"
    length: str = "m"
    torque: str = "N m"
    power: str = "W"
    energy: str = "J"
    force: str = "N"
    speed: str = "rad/s"


DIMENSIONLESS = Units(*[""] * 7)


@dataclass(frozen=True)
class Structure(Bodies):
    """Energies in named coordinates. See ``Machine`` for the fields they share; parameter_paths: of the parameters."""

    parameter_paths: tuple[str, ...]
    units: Units
    schedules: tuple[Schedule, ...]
    mismatch: sp.Expr | None

    def __hash__(self) -> int:
        return self._hash

    @cached_property
    def _hash(self) -> int:
        return hash((self.carrier, self.bodies, self.sliders, self.energies, self.parameter_paths, self.schedules))

    @cached_property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The parameters' symbols."""
        return tuple(sp.Symbol(path, real=True) for path in self.parameter_paths)

    @cached_property
    def linear_carrier(self) -> LinearCarrier:
        """M, C, K of the free carrier and its coupling to the bodies, symbolic; sliders in the middle of their guides.

        Parts whose forces on the carrier are not linear are left out.
        """
        still = [s.coordinate for s in self.sliders] + [c for c in self.carrier if c.prescribed_velocity is not None]
        linear = tuple(e for e in self.energies if not e.nonlinear)
        return linear_carrier(linear, self.free_carrier, [b.coordinate for b in self.bodies], still)

    @cached_property
    @derived_once
    def system(self) -> System:
        """The equations of motion, with outputs and with the quadratures of the energy balance."""
        energies, coordinates, unit = self.energies, self.coordinates, self.units.energy
        quadratures = [
            Output(SUPPLIED_WORK, lagrange.supplied_power(energies, coordinates), unit, "work of the drives"),
            Output(DISSIPATED_WORK, lagrange.dissipated_power(energies, coordinates), unit, "energy dissipated"),
        ]
        if self.mismatch is not None:
            quadratures.append(Output(MISMATCH, self.mismatch, unit, "work created by dampers that are not reciprocal"))
        motion = lagrange.equations_of_motion(energies, coordinates)
        system = lagrange.first_order(
            motion, coordinates, self.symbols, self.outputs(), quadratures, self.locks(), self.internal
        )
        return with_schedules(system, self.schedules, self.stored_energy, unit)

    def locks(self) -> list[lagrange.Lock]:
        """Return the locks, the outermost first."""
        index = {b.name: len(self.carrier) + k for k, b in enumerate(self.bodies)}
        turning = None if self.rotation_coordinate is None else self.carrier.index(self.rotation_coordinate)
        locked_bodies = sorted((b for b in self.bodies if b.release), key=lambda b: -len(self.tree.path(b.name)))
        return [
            lagrange.Lock(index[b.name], turning if b.about is None else index[b.about], b.lock_symbol) for b in locked_bodies
        ]

    @property
    def stored_energy(self) -> sp.Expr:
        """The stored energy, kinetic and potential."""
        return sp.Add(*(e.kinetic for e in self.energies), *(e.potential for e in self.energies))

    @property
    def transmission_loss(self) -> sp.Expr:
        """The torque that the transmissions between motors and their bodies take, at the speed of the bodies."""
        return -sp.Add(*(a.force for e in self.energies for a in e.applied_forces if a.of_drive))

    def outputs(self) -> list[Output]:
        """Return energy, torques and power, prescribed speeds, bearing forces and the orbit of the axis."""
        u = self.units
        driven = [b.coordinate for b in self.bodies if b.coordinate.prescribed_velocity is not None]
        motors = [a.force for e in self.energies for a in e.applied_forces if a.energy_side == "supplied"]
        motor = sp.Add(*motors, *map(lagrange.reaction, driven))
        outputs = [
            Output("stored_energy", self.stored_energy, u.energy, "stored energy"),
            Output("motor_torque", motor, u.torque, "motor torque before the loss of a transmission"),
            Output("drive_torque", motor - self.transmission_loss, u.torque, "torque of the drive on the rotor"),
            Output("motor_power", lagrange.supplied_power(self.energies, self.coordinates), u.power, "motor power"),
            *(
                Output(c.velocity.name, c.velocity, u.speed, "speed")
                for c in self.coordinates
                if c.prescribed_velocity is not None
            ),
        ]
        turning = {s for c in self.coordinates[len(self.carrier) :] for s in (c.position, c.velocity)}
        alone = lagrange.equations_of_motion([e for e in self.energies if not e.symbols & turning], self.carrier)
        inertial = alone.mass * sp.Matrix([lagrange.acceleration(c) for c in self.carrier]) if self.carrier else []
        for label, inertia, force in zip(self.labels, inertial, alone.forces, strict=True):
            # The bodies load the carrier with the residual of its equation of motion without them.
            word, unit = ("moment", u.torque) if label == "r" else ("force", u.force)
            outputs.append(Output(f"bearing_force_{label}", inertia - force, unit, f"bearing {word} on the carrier in {label}"))
        if len(self.rotors) > 1:
            outputs += [output for rotor in self.rotors for output in (*self._bearing_of(rotor), self._motor_of(rotor))]
        for name, (position, velocity) in self.orbit.items():
            unit = "rad" if name == "r" else u.length
            outputs += [Output(f"orbit.{name}", position, unit), Output(f"orbit.v{name}", velocity, "")]
        return outputs

    def _motor_of(self, rotor: RotatingBody) -> Output:
        """Return the power of the motors of one rotor and of the bodies about it."""
        coordinates = [b.coordinate for b in self.group(rotor)]
        turning = {c.velocity for c in coordinates}
        motors = [a for e in self.energies for a in e.applied_forces if a.rate.free_symbols & turning]
        power = lagrange.supplied_power([Energies(applied_forces=tuple(motors))], coordinates)
        return Output(f"motor_power[{rotor.name}]", power, self.units.power, f"motor power of {rotor.name}")

    def _bearing_of(self, rotor: RotatingBody) -> list[Output]:
        """Return the force of one rotor, with the bodies about it, on the carrier, in the directions in which that translates.

        It is the residual of the equation of motion of these bodies alone in the carrier's coordinate: the bearing's force on
        them, with the sign changed.
        """
        coordinates = [b.coordinate for b in self.group(rotor)]
        turning = {s for c in coordinates for s in (c.position, c.velocity)}
        energies = [e for e in self.energies if e.symbols & turning]
        motion = lagrange.equations_of_motion(energies, self.coordinates)
        accelerations, outputs = sp.Matrix([lagrange.acceleration(c) for c in self.coordinates]), []
        for i, label in enumerate(self.labels):
            if label in ("x", "y"):
                force = motion.forces[i] - (motion.mass[i, :] * accelerations)[0]
                long_name = f"bearing force of {rotor.name} in {label}"
                outputs.append(Output(f"bearing_force[{rotor.name}]_{label}", force, self.units.force, long_name))
        return outputs

    @cached_property
    def orbit_shape(self) -> sp.ImmutableMatrix:
        """Derivatives of the axis position by the free coordinates of the carrier (2, m): x and y, or its angle and nothing."""
        names, free = ("r", "") if "r" in self.orbit else ("x", "y"), [c.position for c in self.free_carrier]
        places = [self.orbit[n][0] if n in self.orbit else sp.S.Zero for n in names]
        return sp.ImmutableMatrix(2, len(free), lambda i, k: sp.diff(places[i], free[k]))

    @cached_property
    def kinetic_in_operation(self) -> sp.Expr:
        """The kinetic energy of the bodies that all turn with ``SPEED``, all else at rest."""
        return self.kinetic_of(self.bodies)

    def kinetic_of(self, turning: Sequence[RotatingBody]) -> sp.Expr:
        """Return the kinetic energy of some bodies that turn with ``SPEED``, all else at rest."""
        rest = dict.fromkeys((s for c in self.coordinates for s in (c.position, c.velocity)), sp.S.Zero)
        speed = dict.fromkeys((b.coordinate.velocity for b in turning), SPEED)
        return sp.sympify(sp.Add(*(e.kinetic for e in self.energies)).xreplace(rest | speed))


@lru_cache(maxsize=256)
def canonical_structure(structure: Structure) -> Structure:
    """Return the first structure that is equal to this one: its derived expressions are in its caches."""
    return structure


def torques_on(energies: Sequence[Energies], velocity: sp.Symbol, arriving: bool = False) -> tuple[sp.Expr, sp.Expr]:
    """Return the torques of drives on a body of this velocity, and against them those of loads and dampers.

    arriving: the losses of gears between motor and body are the drive's, not the loads'.
    """
    every = [a for e in energies for a in e.applied_forces]
    torques = [(a.energy_side == "supplied" or (arriving and a.of_drive), a.force * sp.diff(a.rate, velocity)) for a in every]
    losses = [*(sp.diff(e.dissipation, velocity) for e in energies), *(-t for is_supplied, t in torques if not is_supplied)]
    return sp.Add(*(t for is_supplied, t in torques if is_supplied)), sp.Add(*losses)


@lru_cache(maxsize=256)
@derived_once
def steady_shaft_torques(structure: Structure, velocities: tuple[sp.Symbol, ...]) -> tuple[sp.Expr, sp.Expr]:
    """Return the driving and the braking torque of bodies that turn with ``SPEED``, the carrier at rest.

    Of all drives, in the direction of positive speeds, after their gears; of loads and bearings, against it.
    """
    resting = (*structure.carrier, *(x.coordinate for x in structure.sliders))
    still = dict.fromkeys((s for c in resting for s in (c.position, c.velocity)), sp.S.Zero)
    still |= {b.coordinate.velocity: SPEED for b in structure.bodies}
    steady = {state.state: state.steady for state in structure.internal}
    with_symbols = [(e, e.symbols) for e in structure.energies]
    of_bodies = [(v, [e for e, symbols in with_symbols if v in symbols]) for v in velocities]
    drive, losses = zip(*(torques_on(energies, v, arriving=True) for v, energies in of_bodies), strict=True)
    driving, braking = (sp.sympify(sp.Add(*torques).xreplace(steady).xreplace(still)) for torques in (drive, losses))
    return driving, braking
