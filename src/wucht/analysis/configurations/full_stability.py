"""Stability of steady phase configurations in the full equations: by eigenvalues in a turning frame, or by multipliers.

The motion with steady phases is an equilibrium in the frame that turns with the main rotor, or else a periodic orbit, whose
multipliers mu grow or decay by ln(mu)/T: ``synchronous_motion``. Perturbations along a family of states, along an interval of
speeds without torque, and in the phase of the rotation itself neither grow nor decay: they are omitted.
A small effect, as gravity, may break a family: then its members creep along it, and stability is judged across it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.analysis.configurations.averaged_stability import AveragedStability, Stability
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.torques import SteadyTorques, separation
from wucht.analysis.synchronous_motion import SynchronousMotions
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import CompiledSystem
from wucht.numerics.orbits import PeriodicOrbit

NEUTRAL = 1e-7  # ln|mu| of a multiplier on the unit circle: the accuracy of those that come from an integration
_ELSEWHERE = 0.5  # rad: a periodic motion whose phases are further away is another one
_REPEATS = 1e-10  # of the states' sizes: a motion that misses itself by more after a turn creeps
_SLOWER = 0.1  # of the slowest rate across a broken family: slower rates belong to the creeping along it
_NEXT_ORDER = 5  # bodies: with more it takes a minute to derive the averaged equations of the next order
_SAME_FREQUENCY = 0.05  # relative: a multiplier's frequency this near to that of the carrier's vibration belongs to it


@dataclass(frozen=True)
class FullStability:
    """The full equations of a machine, compiled once for all its states, and why averaged ones disagree with them.

    inertia: the averaged equations keep that of the balancing bodies. Contacts on tracks are neglected, as in those.
    """

    torques: SteadyTorques
    inertia: bool

    @cached_property
    def motions(self) -> SynchronousMotions:
        """The motions with steady phases."""
        senses = dict(zip(self.torques.names, self.torques.senses.tolist(), strict=True))
        return SynchronousMotions.of(self.torques.machine, senses)

    @property
    def machine(self) -> Machine:
        """The machine without contacts."""
        return self.motions.machine

    @property
    def flow(self) -> CompiledSystem:
        """The machine's equations of motion."""
        return self.motions.flow

    def stability(self, state: State) -> Stability:
        """Stability of the motion near a state of the averaged equations."""
        state = state.interior_state
        try:
            motion = self.motions.find_near(self.start(state), state.speed, state.neutral, state.dimension)
        except WuchtError as error:
            return Stability.without_verdict(str(error))
        angles = self._angles(motion.state)
        away = float(separation(angles - angles[0], state.phases).max())
        if away > _ELSEWHERE and not state.dimension:
            apart = f"phases up to {math.degrees(away):.0f} degrees away"
            return Stability.without_verdict(f"the nearest periodic motion of the full equations has {apart}")
        reason = "a multiplier lies on the unit circle"
        if (np.diag(self.machine.matrices[1]) == 0).any():
            reason = "the carrier is not damped: its free vibration neither grows nor decays"
        across = Stability.from_exponents(motion.exponents, NEUTRAL / motion.period, reason)
        orbit = motion.orbit
        return across if orbit is None or orbit.residual <= _REPEATS else self._creep_stability(orbit, state, across)

    def _creep_stability(self, orbit: PeriodicOrbit, state: State, across: Stability) -> Stability:
        """Stability of a member of a family that does not repeat exactly."""
        drift = self._angles(orbit.creep(1 + state.neutral))
        turn = math.degrees(float(np.abs(drift - drift[0]).max()))
        by = " by gravity" if sp.sympify(self.machine.frame.gravity).xreplace(self.machine.numbers) else ""
        creep = f"the family is broken{by}: bodies creep along it, here by up to {turn:.2g} degrees a turn"
        along = np.sort(np.abs(orbit.multipliers - 1))[: 1 + state.neutral].max()
        if along > _SLOWER * float(np.abs(1 - np.abs(orbit.nontrivial(1 + state.neutral))).min(initial=np.inf)):
            return Stability(None, across.exponents, f"{creep}, not much slower than perturbations decay across the family")
        return replace(across, reason=f"{creep}; stability is judged across the family") if not across.reason else across

    @cached_property
    def _rows(self) -> list[int]:
        """The places of the bodies' angles in the state, in the order of the torques."""
        return [self.machine.row(self.machine.body(name).coordinate.position) for name in self.torques.names]

    def _angles(self, state: np.ndarray) -> np.ndarray:
        """The angles (n,) of the bodies, each in its sense, in the order of the torques."""
        return np.asarray(self.torques.senses * state[self._rows])

    def orbit(self, state: State) -> PeriodicOrbit:
        """The periodic motion near a state, of a family as far as it repeats. Raises ``WuchtError`` where there is none."""
        return self.motions.orbit(self.start(state), state.speed, state.dimension)

    def start(self, state: State) -> np.ndarray:
        """The state of the full equations (n,) that the slow ones have, when the main rotor's angle is zero."""
        t, w = self.torques, state.speed
        z = t.vibration.response(np.array([w]), state.phases)[0][0]
        values: dict[str, float] = {}
        for c, x0, x in zip(self.machine.carrier, self.machine.rest, z, strict=True):
            values |= {c.position.name: float(x0) + x.real, c.velocity.name: float((1j * w * x).real)}
        for name, sense, phase in zip(t.names, t.senses, state.phases, strict=True):
            body = self.machine.body(name).coordinate
            values |= {body.position.name: sense * phase, body.velocity.name: sense * w}
        return np.array([values[name] for name in self.machine.state_names])

    @cached_property
    def _second_order(self) -> AveragedStability | None:
        """The averaged equations of the next order, None where they cannot be derived."""
        if self.torques.size > _NEXT_ORDER:
            return None
        try:
            return AveragedStability(self.torques, averaged_equations_of(self.torques.machine, self.inertia, 2))
        except WuchtError:
            return None

    def _agrees_in_second_order(self, state: State, full: Stability) -> bool:
        try:
            return self._second_order is not None and self._second_order.stability(state).stable == full.stable
        except WuchtError:
            return False

    def disagreement(self, state: State, slow: Stability, full: Stability) -> str | None:
        """Sentence on why the averaged and full equations disagree, None where they agree or one of them is undecided."""
        if full.stable is None or slow.stable is None or full.stable == slow.stable or full.leading is None:
            return None
        rate, frequency = full.leading.real, abs(full.leading.imag)
        of_time = "1/s" if self.torques.machine.units.speed else "per unit of time"
        if full.stable:
            exact = f"in the full equations all perturbations decay (the slowest at {-rate:.3g} {of_time})"
        else:
            pair = frequency > 1e-6 * state.speed
            subject = f"a pair of multipliers{self._multiplier_origin(state.speed, frequency)}" if pair else "a real multiplier"
            exact = f"{subject} leaves the unit circle (growth {rate:.3g} {of_time})"
        if self._agrees_in_second_order(state, full):
            return f"{exact}: the averaged equations assume a steady vibration of the carrier; those of second order agree"
        moving, slowest = float(np.abs(slow.exponents).max(initial=0.0)), float(-self.torques.vibration.poles.real.max())
        undamped_clause = "are not damped by anything outside the rotor"
        decay = f"decay at no more than {slowest:.3g} {of_time}" if slowest > 0 else undamped_clause
        return (
            f"{exact}: the averaged equations assume a steady vibration of the carrier, but its transients {decay}, while the "
            f"phases move at up to {moving:.3g} {of_time}"
        )

    def _multiplier_origin(self, speed: float, frequency: float) -> str:
        """Origin of multipliers: sampled once a turn, a frequency of the carrier appears minus multiples of the speed."""
        unit, frequencies = self.torques.machine.units.speed, np.abs(self.torques.vibration.poles.imag)
        alias_frequencies = np.abs(frequencies - speed * np.round(frequencies / speed))
        nearest = int(np.abs(alias_frequencies - frequency).argmin())
        if abs(alias_frequencies[nearest] - frequency) < _SAME_FREQUENCY * frequencies[nearest]:
            return f", those of the carrier's free vibration at about {frequencies[nearest]:.4g} {unit}".rstrip() + ","
        return f" with the frequency {frequency:.4g} {unit}".rstrip()
