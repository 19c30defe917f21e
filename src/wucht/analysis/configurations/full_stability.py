"""Stability of steady phase configurations in the full equations, by Floquet multipliers.

The motion with constant phases is periodic; its multipliers mu grow or decay by ln(mu)/T. What belongs to a family of states,
to an interval of speeds without torque, and to the phase of the rotation itself, neither grows nor decays and is left out.
Something small, as gravity, may break a family: then its members creep along it, and it is judged across it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.slow_stability import Stability
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.static import static_position
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.orbits import PeriodicOrbit, periodic_orbit

NEUTRAL = 1e-7  # ln|mu| of a multiplier on the unit circle: the accuracy of those that come from an integration
_ELSEWHERE = 0.5  # rad: a periodic motion whose phases are further away is another one
_REPEATS = 1e-10  # of the states' sizes: a motion that misses itself by more after a turn creeps
_SLOWER = 0.1  # of the slowest rate across a broken family: what is slower belongs to the creeping along it


@dataclass(frozen=True)
class FullStability:
    """The full equations of a machine, compiled once for all its states."""

    machine: Machine
    torques: SteadyTorques
    flow: CompiledSystem

    @classmethod
    def of(cls, machine: Machine, torques: SteadyTorques) -> FullStability:
        """Contacts on tracks are left out, as in the slow equations."""
        bare = machine.changed(energies=machine.without_contacts, tracks=())
        return cls(bare, torques, compile_system(replace(bare.system, outputs=(), quadratures=())))

    def stability(self, state: State) -> Stability:
        """Stability from the multipliers of the periodic motion near a state of the slow equations."""
        state = state.inside
        try:
            orbit = self.orbit(state)
        except WuchtError as error:
            return Stability.undecided(str(error))
        away = self._away(orbit, state)
        if away > _ELSEWHERE and not state.dimension:
            return Stability.undecided(
                f"the nearest periodic motion of the full equations has phases up to {math.degrees(away):.0f} degrees away"
            )
        multipliers = orbit.nontrivial(1 + state.neutral)
        with np.errstate(divide="ignore"):
            exponents = np.log(multipliers.astype(complex)) / orbit.period
        exponents = exponents[np.argsort(-exponents.real, kind="stable")]
        across = Stability.of_exponents(exponents, NEUTRAL / orbit.period, _on_the_unit_circle(self.machine))
        return self._creeping(orbit, state, across) if orbit.residual > _REPEATS else across

    def _creeping(self, orbit: PeriodicOrbit, state: State, across: Stability) -> Stability:
        """Of a member of a family that does not repeat exactly."""
        drift = orbit.creep(1 + state.neutral)
        moved = np.array([self._sense(b.name) * drift[self.machine.row(b.coordinate.position)] for b in self.machine.bodies])
        turn = math.degrees(float(np.abs(moved - moved[self.machine.bodies.index(self.machine.rotor)]).max()))
        by = " by gravity" if sp.sympify(self.machine.frame.gravity).xreplace(self.machine.numbers) else ""
        creep = f"the family is broken{by}: bodies creep along it, here by up to {turn:.2g} degrees a turn"
        along = np.sort(np.abs(orbit.multipliers - 1))[: 1 + state.neutral].max()
        if along > _SLOWER * float(np.abs(1 - np.abs(orbit.nontrivial(1 + state.neutral))).min(initial=np.inf)):
            return Stability(None, across.exponents, f"{creep}, not much slower than what decays across it")
        return replace(across, reason=f"{creep}; judged is what grows or decays across it") if not across.reason else across

    def orbit(self, state: State) -> PeriodicOrbit:
        """The periodic motion near a state, of a family as far as it repeats. Raises ``WuchtError`` where none is found."""
        main = self.machine.row(self.machine.rotor.coordinate.position)
        advance = np.zeros(len(self.machine.state_names))
        for b in self.machine.bodies:
            advance[self.machine.row(b.coordinate.position)] = 2 * np.pi * self._sense(b.name)
        return periodic_orbit(
            self.flow, self.machine.values, self.start(state), 2 * np.pi / state.speed, advance,
            free_period=self.torques.given is None, phase_state=main, left_open=state.dimension,
        )  # fmt: skip

    def start(self, state: State) -> np.ndarray:
        """The state of the full equations (n,) that the slow ones say, when the main rotor's own angle is zero."""
        w = state.speed
        z = self.torques.vibration.response(np.array([w]), state.phases)[0]
        rest = static_position(self.machine)
        values: dict[str, float] = {}
        for k, (c, x0) in enumerate(zip(self.machine.carrier, rest, strict=True)):
            values |= {c.position.name: float(x0) + z[k].real, c.velocity.name: float((1j * w * z[k]).real)}
        for b in self.machine.bodies:
            sense = self._sense(b.name)
            values[b.coordinate.position.name] = sense * state.phases[self.torques.names.index(b.name)]
            values[b.coordinate.velocity.name] = sense * w
        return np.array([values[name] for name in self.machine.state_names])

    def _sense(self, name: str) -> float:
        return float(self.torques.senses[self.torques.names.index(name)])

    def _away(self, orbit: PeriodicOrbit, state: State) -> float:
        """How far the phases of a periodic motion are from those of a state, at most."""
        m, names = self.machine, self.torques.names
        angle = {b.name: self._sense(b.name) * orbit.state[m.row(b.coordinate.position)] for b in m.bodies}
        apart = np.array([angle[name] - angle[names[0]] for name in names]) - state.phases
        return float(np.abs((apart + np.pi) % (2 * np.pi) - np.pi).max())


def _on_the_unit_circle(machine: Machine) -> str:
    if (np.diag(machine.matrices[1]) == 0).any():
        return "the carrier is not damped: its own vibration neither grows nor decays"
    return "a multiplier lies on the unit circle"
