"""Motions with steady phases in the full equations, and their growth rates.

Where a machine is invariant under rotation as a whole they are equilibria in the frame that turns with the main rotor: exact,
and cheap. Elsewhere (anisotropic carriers, gravity, rotors that turn against each other) they are periodic: in one turn each
angle winds once round and all else repeats. Both need a start nearby, such as the averaged equations give.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wucht.analysis.relative_equilibria import RelativeEquilibria, RelativeEquilibrium, without_contacts
from wucht.errors import InputError, RunError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.orbits import PeriodicOrbit, periodic_orbit
from wucht.numerics.periodic.cycle import Cycle
from wucht.numerics.periodic.cycle_starts import cycle_near
from wucht.numerics.periodic.cycles import Cycles

_SAMPLES = 200  # of an orbit


@dataclass(frozen=True)
class SynchronousMotion:
    """A motion with steady phases.

    Attributes
    ----------
    state : ndarray, (n,)
        State of the machine's equations, at the moment when the main rotor's angle is that of the start.
    period : float
        Period of one turn, in the unit of time.
    exponents : ndarray of complex, (k,)
        Growth rates per unit of time, the fastest growing first, without those of the phase of the rotation and of a
        family. The imaginary parts are within half a frequency of the rotation, as sampled once a turn.
    equilibrium : RelativeEquilibrium, optional
        The equilibrium in the turning frame, where it is one.
    orbit : PeriodicOrbit, optional
        The periodic orbit otherwise.
    """

    state: np.ndarray
    period: float
    exponents: np.ndarray
    equilibrium: RelativeEquilibrium | None = None
    orbit: PeriodicOrbit | None = None


@dataclass(frozen=True)
class SynchronousMotions:
    """Synchronous motions of a machine at its parameter values, contacts on tracks neglected, all bodies released.

    senses: +1 or -1 of each body by name. relative: its relative equilibria, None where it has none; outside_reason: why not.
    """

    machine: Machine
    senses: Mapping[str, float]
    relative: RelativeEquilibria | None
    outside_reason: str

    @classmethod
    def of(cls, machine: Machine, senses: Mapping[str, float] | None = None) -> SynchronousMotions:
        """Synchronous motions of a machine; senses: by default those of its drives."""
        turn = {b.name: sense_of(machine, b) for b in machine.bodies} if senses is None else dict(senses)
        try:
            return cls(without_contacts(machine), turn, RelativeEquilibria.of(machine, turn), "")
        except InputError as error:
            return cls(without_contacts(machine), turn, None, error.explanation)

    @cached_property
    def flow(self) -> CompiledSystem:
        """The equations of motion, compiled."""
        return compile_system(replace(self.machine.system, outputs=(), quadratures=()))

    def find_near(self, start: np.ndarray, speed: float, neutral: int = 0, left_open: int = 0) -> SynchronousMotion:
        """The motion near a state (n,) of the machine's equations at a speed of the main rotor, in its sense.

        neutral: dimension of the family. left_open: number of its directions along which an orbit may creep, where a small
        effect breaks the family. Raises ``WuchtError`` where there is none.
        """
        if self.relative is None:
            orbit = self.orbit(start, speed, left_open)
            exponents = orbit.nontrivial_logarithms(1 + neutral) / orbit.period
            return SynchronousMotion(orbit.state, orbit.period, _sort_by_growth(exponents), orbit=orbit)
        equilibrium = self.relative.find_near(self.relative.to_turning_frame(start), neutral)
        turn = abs(equilibrium.speed)
        if not turn:
            raise RunError("there is no steady rotation here: the nearest equilibrium is at rest")
        exponents = equilibrium.exponents - 1j * turn * np.round(equilibrium.exponents.imag / turn)
        angle = float(start[self.machine.row(self.machine.rotor.coordinate.position)])
        state = self.relative.to_fixed_frame(equilibrium.state, angle)
        return SynchronousMotion(state, 2 * np.pi / turn, _sort_by_growth(exponents), equilibrium=equilibrium)

    def orbit_branch(
        self, parameter: str, bounds: tuple[float, float], near: SynchronousMotion, steps: Steps | None = None
    ) -> tuple[Cycles, Cycle]:
        """The branch of synchronous motions as periodic orbits, over a parameter (its path), and its first orbit.

        bounds: lowest and highest value. near: one of the motions. For relative equilibria ``RelativeEquilibria.branches_over``
        is cheaper. Raises ``InputError`` for an unknown parameter or a prescribed period, ``RunError`` where there is no orbit.
        """
        machine, system = self.machine, replace(self.machine.system, outputs=(), quadratures=())
        if parameter not in system.parameter_names:
            raise InputError(
                "parameter", parameter, f"must be a parameter of the equations: {', '.join(system.parameter_names)}"
            )
        prescribed_rotors = [b.name for b in machine.rotors if b.coordinate.prescribed_velocity is not None]
        if prescribed_rotors:
            raise InputError(
                "machine", None, f"the speed of {prescribed_rotors[0]} is prescribed: the period is not an unknown"
            )
        run = integrate(self.flow, near.state, machine.values, np.linspace(0.0, near.period, _SAMPLES + 1)).reraise_interrupt()
        if run.failure is not None:
            raise RunError(f"the orbit cannot be computed: {run.failure}")
        turning = {system.state_names[machine.row(b.coordinate.position)]: round(self.senses[b.name]) for b in machine.bodies}
        sizes = np.ptp(run.states, axis=1)
        speed = 2 * np.pi / near.period
        for b in machine.bodies:
            sizes[machine.row(b.coordinate.position)], sizes[machine.row(b.coordinate.velocity)] = 1.0, speed
        scale = dict(zip(system.state_names, sizes.tolist(), strict=True)) | {parameter: bounds[1] - bounds[0]}
        fixed_values = {name: value for name, value in machine.values.items() if name != parameter}
        cycles = Cycles.of(system, parameter, fixed_values, bounds, winding=turning, scale=scale, steps=steps)
        return cycles, cycle_near(cycles, run.time, run.states, machine.values[parameter])

    def orbit(self, start: np.ndarray, speed: float, left_open: int = 0) -> PeriodicOrbit:
        """The motion as a periodic orbit of the machine's equations, for any machine: all angles wind once round."""
        rows = {b.name: self.machine.row(b.coordinate.position) for b in self.machine.bodies}
        advance = np.zeros(len(self.machine.state_names))
        for name, row in rows.items():
            advance[row] = 2 * np.pi * self.senses[name]
        main = self.machine.rotor
        return periodic_orbit(
            self.flow, self.machine.values, start, 2 * np.pi / speed, advance,
            free_period=main.coordinate.prescribed_velocity is None, phase_state=rows[main.name], left_open=left_open,
        )  # fmt: skip


def _sort_by_growth(exponents: np.ndarray) -> np.ndarray:
    return np.asarray(exponents[np.argsort(-exponents.real, kind="stable")])
