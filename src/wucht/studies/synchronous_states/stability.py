"""Whether constant phases are stable: from the slow equations, and from the Floquet multipliers of the full ones.

Slow: J theta'' + B theta' = tau(theta') + V(theta_0', alpha), linearised about equal speeds and constant phases; or the
equations without the inertia of the balancing bodies. Full: the motion with these phases is periodic; its multipliers mu grow
or decay by ln(mu)/T. What belongs to a family of states, to an interval of speeds without torque, and to the phase of the
rotation itself, neither grows nor decays and is left out. Something small, as gravity, may break a family: then its members
creep along it, and it is judged across it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.slow import SlowMachine, slow_machine
from wucht.machines.static import static_position
from wucht.machines.synchronous.closed import State
from wucht.machines.synchronous.torques import SteadyTorques
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.jacobian import Jacobian
from wucht.numerics.orbits import Orbit, periodic_orbit

NEUTRAL = 1e-9  # of the fastest rate: an exponent whose real part is smaller neither grows nor decays
NEUTRAL_FULL = 1e-7  # the same for ln|mu|, the accuracy of multipliers that come from an integration
_NEXT_ORDER = 5  # bodies: with more it takes a minute to write the slow equations of the next order
_OWN = 0.05  # relative: a multiplier's frequency this near to that of the carrier's vibration belongs to it
_ELSEWHERE = 0.5  # rad: a periodic motion whose phases are further away is another one
_REPEATS = 1e-10  # of the states' sizes: a motion that misses itself by more after a turn creeps
_SLOWER = 0.1  # of the slowest rate across a broken family: what is slower belongs to the creeping along it


@dataclass(frozen=True)
class Judgement:
    """stable: None where it cannot be decided. exponents: (k,), complex, the fastest growing first. reason: why it cannot be
    decided, or what is to be known beside.
    """

    stable: bool | None
    exponents: np.ndarray
    reason: str = ""

    @property
    def leading(self) -> complex | None:
        """The exponent that grows fastest."""
        return complex(self.exponents[0]) if len(self.exponents) else None


def slow_matrices(torques: SteadyTorques, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """The linearised slow equations (N, k, k) at speeds (N,) and phases (n, N).

    Unknowns: the phases of all bodies to the main rotor, then the speeds of those whose speed is not given.
    """
    n, free = torques.size, list(torques.free)
    change, rate = torques.slopes(speeds, phases)
    brake = torques.alone(speeds)[1]
    by_speed = np.repeat(-torques.relative[:, :, None], len(speeds), axis=2)
    by_speed[np.arange(n), np.arange(n)] += brake
    by_speed[:, 0] += rate
    inverse = np.linalg.inv(torques.inertia[np.ix_(free, free)])
    k = n - 1 + len(free)
    found = np.zeros((len(speeds), k, k))
    for row, i in enumerate(range(1, n)):
        for column, f in enumerate(free):
            found[:, row, n - 1 + column] = float(f == i) - float(f == 0)
    found[:, n - 1 :, : n - 1] = np.einsum("ij,jkN->Nik", inverse, change[free][:, 1:])
    found[:, n - 1 :, n - 1 :] = np.einsum("ij,jkN->Nik", inverse, by_speed[np.ix_(free, free)])
    return found


def transverse(eigenvalues: np.ndarray, dimension: int) -> np.ndarray:
    """Eigenvalues (N, k) without the ``dimension`` smallest, the fastest growing first."""
    order = np.argsort(np.abs(eigenvalues), axis=-1)[..., dimension:]
    kept = np.take_along_axis(eigenvalues, order, -1)
    found: np.ndarray = np.take_along_axis(kept, np.argsort(-kept.real, axis=-1, kind="stable"), -1)
    return found


def slow_judgement(torques: SteadyTorques, slow: SlowMachine, state: State) -> Judgement:
    """Stability from the slow equations, with or without inertia as they come."""
    exponents = slow_exponents(torques, slow, state, state.phases[:, None])[0]
    return _judged(exponents, NEUTRAL * float(np.abs(exponents).max(initial=0.0)), "neither grows nor decays")


def slow_exponents(torques: SteadyTorques, slow: SlowMachine, state: State, phases: np.ndarray) -> np.ndarray:
    """The exponents (N, k) of members (n, N) of a state's family, transverse to it, the fastest growing first.

    Not numbers where the equations are singular.
    """
    state = state.inside
    if slow.inertia:
        matrices = slow_matrices(torques, np.full(phases.shape[1], state.speed), phases)
    else:
        states = np.array([slow_state(slow, replace(state, phases=at)) for at in phases.T]).T
        matrices = np.moveaxis(Jacobian.of(slow.system)(states, slow.values())[1], -1, 0)
    regular = np.isfinite(matrices).all(axis=(1, 2))
    found = np.full(matrices.shape[:2], np.nan, complex)
    found[regular] = np.linalg.eigvals(matrices[regular])
    return transverse(found, state.neutral)


def slow_state(slow: SlowMachine, state: State) -> np.ndarray:
    """The state (k,) of the slow equations."""
    alpha = dict(zip(slow.equations.bodies.names, state.phases, strict=True))
    found = []
    for symbol in slow.system.states:
        body, _, what = symbol.name.rpartition(".")
        reference = slow.references[body]
        found.append(state.speed if what == "speed" else alpha[body] - (alpha[reference] if reference else 0.0))
    return np.array(found)


def _judged(exponents: np.ndarray, neutral: float, why: str) -> Judgement:
    if not len(exponents):
        return Judgement(True, exponents)
    if not np.isfinite(exponents).all():
        return Judgement(None, exponents, "it cannot be computed here")
    largest = float(exponents[0].real)
    if abs(largest) <= neutral:
        return Judgement(None, exponents, why)
    return Judgement(largest < 0, exponents)


@dataclass(frozen=True)
class FullEquations:
    """The full equations of a machine, compiled once for all its states."""

    machine: Machine
    torques: SteadyTorques
    flow: CompiledSystem

    @classmethod
    def of(cls, machine: Machine, torques: SteadyTorques) -> FullEquations:
        """Contacts on tracks are left out, as in the slow equations."""
        bare = replace(machine, energies=machine.energies[: len(machine.energies) - len(machine.tracks)], tracks=())
        return cls(bare, torques, compile_system(replace(bare.system, outputs=(), quadratures=())))

    def judgement(self, state: State) -> Judgement:
        """Stability from the multipliers of the periodic motion near a state of the slow equations."""
        state = state.inside
        try:
            orbit = self.orbit(state)
        except WuchtError as error:
            return Judgement(None, np.empty(0, complex), f"{error}")
        away = self._away(orbit, state)
        if away > _ELSEWHERE and not state.dimension:
            reason = f"the nearest periodic motion of the full equations has phases up to {math.degrees(away):.0f} degrees away"
            return Judgement(None, np.empty(0, complex), reason)
        multipliers = orbit.rest(1 + state.neutral)
        with np.errstate(divide="ignore"):
            exponents = np.log(multipliers.astype(complex)) / orbit.period
        exponents = exponents[np.argsort(-exponents.real, kind="stable")]
        found = _judged(exponents, NEUTRAL_FULL / orbit.period, _neutral(self.machine))
        return self._creeping(orbit, state, found) if orbit.residual > _REPEATS else found

    def _creeping(self, orbit: Orbit, state: State, across: Judgement) -> Judgement:
        """What is said of a member of a family that does not repeat exactly."""
        names, drift = self.flow.system.state_names, orbit.drift(1 + state.neutral)
        moved = np.array([self._sense(b.name) * drift[names.index(b.coordinate.position.name)] for b in self.machine.bodies])
        turn = math.degrees(float(np.abs(moved - moved[self.machine.bodies.index(self.machine.rotor)]).max()))
        by = " by gravity" if self.machine.values.get("carrier.gravity", 0.0) else ""
        said = f"the family is broken{by}: bodies creep along it, here by up to {turn:.2g} degrees a turn"
        along = np.sort(np.abs(orbit.multipliers - 1))[: 1 + state.neutral].max()
        if along > _SLOWER * float(np.abs(1 - np.abs(orbit.rest(1 + state.neutral))).min(initial=np.inf)):
            return Judgement(None, across.exponents, f"{said}, not much slower than what decays across it")
        return replace(across, reason=f"{said}; judged is what grows or decays across it") if not across.reason else across

    def orbit(self, state: State) -> Orbit:
        """The periodic motion near a state, of a family as far as it repeats. Raises ``WuchtError`` where none is found."""
        names, turning = self.flow.system.state_names, {b.coordinate.position.name for b in self.machine.bodies}
        main = names.index(self.machine.rotor.coordinate.position.name)
        signs = {b.coordinate.position.name: self._sense(b.name) for b in self.machine.bodies}
        advance = np.array([2 * np.pi * signs[name] if name in turning else 0.0 for name in names])
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
        return np.array([values[name] for name in self.flow.system.state_names])

    def _sense(self, name: str) -> float:
        return float(self.torques.senses[self.torques.names.index(name)])

    def _away(self, orbit: Orbit, state: State) -> float:
        names = self.flow.system.state_names
        angle = {
            b.name: self._sense(b.name) * orbit.state[names.index(b.coordinate.position.name)] for b in self.machine.bodies
        }
        found = np.array([angle[name] - angle[self.torques.names[0]] for name in self.torques.names]) - state.phases
        return float(np.abs((found + np.pi) % (2 * np.pi) - np.pi).max())


def _neutral(machine: Machine) -> str:
    damping = machine.linear_carrier.damping.xreplace(machine.numbers)
    if any(sp.sympify(damping[i, i]) == 0 for i in range(damping.rows)):
        return "the carrier is not damped: its own vibration neither grows nor decays"
    return "a multiplier lies on the unit circle"


def second_order(machine: Machine, state: State, inertia: bool) -> Judgement | None:
    """Stability from the slow equations of the next order, None where they are not to be had."""
    try:
        slow = slow_machine(machine, inertia, 2)
        matrix = Jacobian.of(slow.system).at(slow_state(slow, state), slow.values())[1]
    except WuchtError:
        return None
    if not np.isfinite(matrix).all():
        return None
    exponents = transverse(np.linalg.eigvals(matrix), state.neutral)
    return _judged(exponents, NEUTRAL * float(np.abs(exponents).max(initial=0.0)), "neither grows nor decays")


def why_they_differ(machine: Machine, state: State, slow: Judgement, full: Judgement, inertia: bool, unit: str) -> str | None:
    """A sentence on why the slow and the full equations disagree, None where they agree."""
    if full.stable is None or slow.stable is None or full.stable == slow.stable or full.leading is None:
        return None
    rate, frequency = full.leading.real, abs(full.leading.imag)
    what = "a real multiplier"
    if frequency > 1e-6 * state.speed:
        what = f"a pair of multipliers{_whose(machine, state.speed, frequency, unit)}"
    unit_rate = "1/s" if unit else "a unit of time"
    if not full.stable:
        said = f"{what} leaves the unit circle (growth {rate:.3g} {unit_rate})"
    else:
        said = f"in the full equations all perturbations decay (the slowest with {-rate:.3g} {unit_rate})"
    next_order = second_order(machine, state, inertia) if len(machine.bodies) <= _NEXT_ORDER else None
    if next_order is not None and next_order.stable == full.stable:
        return f"{said}: the slow equations take the carrier's vibration as steady; those of second order agree"
    moving, slowest = float(np.abs(slow.exponents).max(initial=0.0)), _slowest_of_carrier(machine)
    decay = (
        f"decay with no more than {slowest:.3g} {unit_rate}" if slowest > 0 else "are not damped by anything outside the rotor"
    )
    return (
        f"{said}: the slow equations take the carrier's vibration as steady, but its own transients {decay}, while the phases "
        f"move with up to {moving:.3g} {unit_rate}"
    )


def _whose(machine: Machine, speed: float, frequency: float, unit: str) -> str:
    """Whose multipliers they are: once a turn a frequency of the carrier is seen less whole multiples of the speed."""
    own = np.abs(_carrier_poles(machine).imag)
    seen = np.abs(own - speed * np.round(own / speed))
    nearest = int(np.abs(seen - frequency).argmin())
    if abs(seen[nearest] - frequency) < _OWN * own[nearest]:
        return f", those of the carrier's own vibration at about {own[nearest]:.4g} {unit}".rstrip() + ","
    return f" with the frequency {frequency:.4g} {unit}".rstrip()


def _slowest_of_carrier(machine: Machine) -> float:
    return float(-_carrier_poles(machine).real.max())


def _carrier_poles(machine: Machine) -> np.ndarray:
    c, numbers = machine.linear_carrier, machine.numbers
    mass, damping, stiffness = (np.array(a.xreplace(numbers).tolist(), float) for a in (c.mass, c.damping, c.stiffness))
    size = len(mass)
    below = -np.linalg.solve(mass, np.hstack([stiffness, damping]))
    found: np.ndarray = np.linalg.eigvals(np.vstack([np.hstack([np.zeros((size, size)), np.eye(size)]), below]))
    return found
