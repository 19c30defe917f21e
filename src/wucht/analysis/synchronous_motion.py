"""Motions with steady phases in the full equations, and what grows or decays about them.

Where a machine does not feel being turned as a whole they are equilibria in the frame that turns with the main rotor: exact,
and cheap. Elsewhere (anisotropic carriers, gravity, rotors that turn against each other) they are periodic: in one turn each
angle winds once round and all else repeats. Both are found from a start nearby, as the averaged equations give it.
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
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.orbits import PeriodicOrbit, periodic_orbit


@dataclass(frozen=True)
class SynchronousMotion:
    """A motion with steady phases.

    Attributes
    ----------
    state : ndarray, (n,)
        Of the machine's equations, at the moment when the main rotor's angle is that of the start.
    period : float
        Of one turn, in the unit of time.
    exponents : ndarray of complex, (k,)
        Growth rates per unit of time, the fastest growing first: what belongs to the phase of the rotation itself, and to a
        family, is left out. The imaginary parts are within half a frequency of the rotation, as seen once a turn.
    equilibrium : RelativeEquilibrium, optional
        In the turning frame, where it is one.
    orbit : PeriodicOrbit, optional
        Where it is none.
    """

    state: np.ndarray
    period: float
    exponents: np.ndarray
    equilibrium: RelativeEquilibrium | None = None
    orbit: PeriodicOrbit | None = None


@dataclass(frozen=True)
class SynchronousMotions:
    """Those of a machine at its parameter values, contacts on tracks left out, all bodies released.

    senses: +1 or -1 of each body by name. relative: its relative equilibria, None where they are none; outside: why not.
    """

    machine: Machine
    senses: Mapping[str, float]
    relative: RelativeEquilibria | None
    outside: str

    @classmethod
    def of(cls, machine: Machine, senses: Mapping[str, float] | None = None) -> SynchronousMotions:
        """Those of a machine; senses: by default as its drives would have them."""
        turn = {b.name: sense_of(machine, b) for b in machine.bodies} if senses is None else dict(senses)
        try:
            return cls(without_contacts(machine), turn, RelativeEquilibria.of(machine, turn), "")
        except InputError as error:
            return cls(without_contacts(machine), turn, None, error.allowed)

    @cached_property
    def flow(self) -> CompiledSystem:
        """The equations of motion, compiled."""
        return compile_system(replace(self.machine.system, outputs=(), quadratures=()))

    def near(self, start: np.ndarray, speed: float, neutral: int = 0, left_open: int = 0) -> SynchronousMotion:
        """The motion near a state (n,) of the machine's equations at a speed of the main rotor, in its own sense.

        neutral: in how many directions there are others of a family. left_open: along how many of them an orbit may creep,
        where something small breaks the family. Raises ``WuchtError`` where none is found.
        """
        if self.relative is None:
            orbit = self.orbit(start, speed, left_open)
            with np.errstate(divide="ignore"):
                exponents = np.log(orbit.nontrivial(1 + neutral).astype(complex)) / orbit.period
            return SynchronousMotion(orbit.state, orbit.period, _in_order(exponents), orbit=orbit)
        found = self.relative.near(self.relative.turned(start), neutral)
        turn = abs(found.speed)
        if not turn:
            raise RunError("no steady rotation was found: the nearest equilibrium is one at rest")
        exponents = found.exponents - 1j * turn * np.round(found.exponents.imag / turn)
        angle = float(start[self.machine.row(self.machine.rotor.coordinate.position)])
        state = self.relative.fixed(found.state, angle)
        return SynchronousMotion(state, 2 * np.pi / turn, _in_order(exponents), equilibrium=found)

    def orbit(self, start: np.ndarray, speed: float, left_open: int = 0) -> PeriodicOrbit:
        """The same as a periodic orbit of the machine's own equations, whatever the machine: all angles wind once round."""
        rows = {b.name: self.machine.row(b.coordinate.position) for b in self.machine.bodies}
        advance = np.zeros(len(self.machine.state_names))
        for name, row in rows.items():
            advance[row] = 2 * np.pi * self.senses[name]
        main = self.machine.rotor
        return periodic_orbit(
            self.flow, self.machine.values, start, 2 * np.pi / speed, advance,
            free_period=main.coordinate.prescribed is None, phase_state=rows[main.name], left_open=left_open,
        )  # fmt: skip


def _in_order(exponents: np.ndarray) -> np.ndarray:
    return np.asarray(exponents[np.argsort(-exponents.real, kind="stable")])
