"""The averaged equations of a machine, and the way back from its slow motion to the full one.

The way back is the near-identity transformation 002 (3.2), 001 (14), (21):
theta_i = theta + alpha_i + Re[P_i exp(2 i theta)], q = Re[z exp(i theta)]: the fast parts 001 (26), (41), (54), (61).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import permutations

import numpy as np
import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import has_damped_balancers, natural_frequencies, sense_of
from wucht.machines.parts.base import Body
from wucht.machines.schedules import with_schedules
from wucht.machines.structure import SPEED, Structure, torques_on
from wucht.machines.tree import Tree
from wucht.mechanics.energies import Energies
from wucht.mechanics.linear_carrier import LinearCarrier, first_harmonic, linear_carrier
from wucht.mechanics.phasors import Phasor
from wucht.mechanics.rotating_bodies.averaged_system import AveragedSystem, derive_averaged_system
from wucht.mechanics.rotating_bodies.bodies import RotatingBodies, Shaking
from wucht.numerics.flow.program import Evaluator
from wucht.system import System

_STEP = 1e-4  # rad of the fastest free vibration: small against what a slow motion needs to change, large against rounding


@dataclass(frozen=True)
class AveragedEquations:
    """A machine's averaged equations.

    senses: +1 or -1 for each body. has_fixed_speed: the main rotor turns at the parameter ``speed``.
    """

    machine: Machine
    averaged_system: AveragedSystem
    senses: Mapping[str, int]
    inertia: bool
    order: int
    has_fixed_speed: bool

    @cached_property
    def system(self) -> System:
        """The System, with the machine's parameters; scheduled ones follow their schedules."""
        system = self.averaged_system.system
        return _with_parameters(system, self.machine.structure, self.has_fixed_speed, system.output("stored_energy").expression)

    @cached_property
    def fast(self) -> System:
        """The bodies' fluctuation within a turn, in the same states and parameters: outputs alone."""
        return _with_parameters(self.averaged_system.fast, self.machine.structure, self.has_fixed_speed, sp.S.Zero)

    def values(self, speed: float | None = None) -> tuple[float, ...]:
        """Parameter values in order. speed: of the main rotor, where it is fixed, positive in the rotor's sense."""
        return self.system.values(self.machine.values | ({} if speed is None else {SPEED.name: speed}))

    @property
    def warnings(self) -> tuple[str, ...]:
        """Sentences on what these equations neglect."""
        tracks, released_bodies = self.machine.tracks, [b.name for b in self.machine.bodies if b.release is not None]
        contacts = [f"contacts on the track {t.name} are left out: this holds while its bodies do not touch" for t in tracks]
        return (*contacts, *(f"{name} is taken as released" for name in released_bodies))

    @cached_property
    def references(self) -> dict[str, str | None]:
        """The body to which the phase of each body counts; None for the main rotor."""
        b = self.averaged_system.bodies
        return {name: b.names[b.reference(i)] if i else None for i, name in enumerate(b.names)}

    def state(self, angles: Mapping[str, float | np.ndarray], speeds: Mapping[str, float | np.ndarray]) -> np.ndarray:
        """The slow state (n,) that follows from absolute angles and speeds of the bodies; or states (n, M), from arrays (M,).

        Without inertia the bodies' slips have decayed: rotors have the speed that remains, and phases have moved on, see
        002 (4.24), (4.30).
        """
        names = self.averaged_system.bodies.names
        theta, speed_values = (np.array([self.senses[n] * by_body[n] for n in names]) for by_body in (angles, speeds))
        return self._state(*((theta, speed_values) if self.inertia else self._settle_slips(theta, speed_values)))

    def is_defined_at(self, state: np.ndarray) -> bool:
        """True if the equations have a value in a slow state (n,); those of second order have none at rest."""
        with np.errstate(all="ignore"):
            rates = Evaluator.of_rates(self.system).array(np.zeros(1), state[:, None], self.values())
        return bool(np.isfinite(rates).all())

    def steady_state(self, speed: float, phases: np.ndarray) -> np.ndarray:
        """The slow state (n,) of bodies that all turn at one speed, with phases in the order of the equations' bodies."""
        return self._state(phases, np.full(len(phases), speed))

    def _state(self, angles: np.ndarray, speeds: np.ndarray) -> np.ndarray:
        """The slow state from the bodies' angles and speeds, each in the body's sense."""
        values, b = dict[str, np.ndarray](), self.averaged_system.bodies
        for i, name in enumerate(b.names):
            values[f"{name}.phase"] = angles[i] - (angles[b.reference(i)] if i else 0.0)
            values[f"{name}.speed"] = speeds[i]
        return np.array([values[name] for name in self.system.state_names])

    def _settle_slips(self, angles: np.ndarray, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Limit of J nu' + B nu = 0: the angles moved by the integral of nu, and the speeds that remain."""
        b, numbers, settled_angles, settled_speeds = (
            self.averaged_system.bodies,
            self.machine.numbers,
            angles.copy(),
            speeds.copy(),
        )
        inertia, damping = (np.array(a.xreplace(numbers).tolist(), float).reshape(a.shape) for a in (b.inertia, b.relative))
        for head in b.rotors:
            group = b.group(head)
            j, d, group_speeds = inertia[np.ix_(group, group)], damping[np.ix_(group, group)], speeds[group]
            null = np.linalg.svd(d.T)[2][-1]
            w = group_speeds[0] if head == 0 and b.fixed_speed is not None else null @ j @ group_speeds / (null @ j.sum(axis=1))
            integral = np.linalg.lstsq(d, j @ (group_speeds - w), rcond=None)[0]
            settled_speeds[group] = w
            settled_angles[group] += integral - integral[0]
        return settled_angles, settled_speeds


def keeps_inertia(machine: Machine, requested_inertia: bool | None) -> bool:
    """True if averaged equations of steady and modulated operation keep the inertia of the balancing bodies.

    By default they do: it affects the stability, and the limit of strong damping is a special case of it. The dissertation's
    dimensionless machines are given by that limit, 002 (4.60)-(4.62), where all bodies are damped. Raises ``InputError`` where
    the inertia is to be neglected and a body is not damped.
    """
    limit = has_damped_balancers(machine)
    if requested_inertia is False and not limit:
        raise InputError("study.inertia", False, "must be true: a balancing body is not damped against its rotor")
    return not (machine.dimensionless and limit) if requested_inertia is None else requested_inertia


def averaged_equations_of(
    machine: Machine,
    inertia: bool = True,
    order: int = 1,
    has_fixed_speed: bool = False,
    turning: Mapping[str, int] | None = None,
) -> AveragedEquations:
    """The averaged equations of a machine with a linear carrier: see ``mechanics.rotating_bodies``.

    inertia: of the bodies that turn about a rotor; without it they are strongly damped. order: 1 or 2.
    has_fixed_speed: the main rotor turns at the parameter ``speed``, whatever its drive does. turning: the senses +1, -1 of
    rotors that do not turn as their drives would turn them. Raises ``InputError`` for other machines, with the reason.
    """
    _refuse_unsuitable(machine)
    senses_of = dict(turning or {})
    rotor_senses = senses_of | {r.name: int(sense_of(machine, r)) for r in machine.rotors if r.name not in senses_of}
    senses = {b.name: rotor_senses[r.name] for r in machine.rotors for b in machine.group(r)}
    signs = tuple(senses[b.name] for b in machine.bodies)
    try:
        equations = _equations(machine.structure, len(machine.tracks), machine.shaking, signs, inertia, order, has_fixed_speed)
    except WuchtError as error:
        raise InputError("machine", None, f"there are no such averaged equations: {error}", code=error.code) from None
    return AveragedEquations(machine, equations, senses, inertia, order, has_fixed_speed)


@lru_cache(maxsize=64)
def _with_parameters(system: System, structure: Structure, has_fixed_speed: bool, energy: sp.Expr) -> System:
    machine_system = replace(system, parameters=(*structure.symbols, *([SPEED] if has_fixed_speed else [])))
    return with_schedules(machine_system, structure.schedules, energy, structure.units.energy)


def _refuse_unsuitable(machine: Machine) -> None:
    off_axis_bodies = [p.name for p in machine.parts if isinstance(p, Body) and not p.is_on_axis()]
    other_rotors = [r.name for r in machine.rotors[1:] if r.coordinate.prescribed_velocity is not None]
    is_shaken, has_prescribed_rotor = (
        machine.shaken_coordinate is not None,
        any(r.coordinate.prescribed_velocity is not None for r in machine.rotors),
    )
    guide_clause = "slides in a guide that turns: the carrier's mass matrix then depends on the angle"
    reasons = [("slider", f"{s.words} {guide_clause}") for s in machine.sliders]
    reasons += [
        ("pivot", f"the pivot of {name} turns with the rotor: its unbalance depends on its phase") for name in off_axis_bodies
    ]
    if is_shaken and machine.shaking is None:
        reasons.append(("table", "the prescribed motion of the carrier is a table: it has no period to average over"))
    if is_shaken and has_prescribed_rotor:
        conflict = "the speed of a rotor and the motion of the carrier are both prescribed"
        reasons.append(("no-common-speed", f"{conflict}: there is no common speed"))
    if other_rotors:
        clause = f"the speed of {other_rotors[0]} is prescribed, which is not the main rotor"
        reasons.append(("no-common-speed", f"{clause}: there is no common speed"))
    if machine.nonlinear:
        reasons.append(("not-linear", f"{machine.nonlinear} is not linear, and the averaged equations need a linear carrier"))
    if machine.internal:
        state_name = machine.internal[0].state.name
        clause = "a drive of kind 'constant-speed' holds its speed exactly"
        reasons.append(
            ("controller", f"{state_name} is an internal state of a controller, and averaged equations have none: {clause}")
        )
    if not machine.free_carrier and not is_shaken:
        reasons.append(("still", "nothing vibrates: the carrier is fixed"))
    if reasons:
        code, reason = reasons[0]
        raise InputError("machine", None, f"there are no averaged equations: {reason}; run the full model instead", code=code)


@lru_cache(maxsize=64)
@derived_once
def _equations(
    structure: Structure, contacts: int, shaking: tuple[sp.Symbol, sp.Symbol] | None, senses: Sequence[int], inertia: bool,
    order: int, has_fixed_speed: bool,
) -> AveragedSystem:  # fmt: skip
    """Derive the equations. contacts: number of energies of tracks. shaking: amplitude and frequency. senses: of bodies."""
    energies = structure.energies[: len(structure.energies) - contacts]
    pairs = list(zip(structure.bodies, senses, strict=True))
    if structure.bodies[0].about:  # The main rotor leads where the first body turns about another one.
        pairs.sort(key=lambda pair: pair[0] is not structure.rotor)
    ordered_bodies, sign = zip(*pairs, strict=True)
    names, coordinates, n = [b.name for b in ordered_bodies], [b.coordinate for b in ordered_bodies], len(ordered_bodies)
    v, places = [c.velocity for c in coordinates], [place for place, _ in structure.orbit.values()]
    carrier = linear_carrier(energies, structure.carrier, coordinates)
    unbalance, excitation = _excitation(carrier, names, sign)
    still = {s: sp.S.Zero for c in structure.carrier for s in (c.position, c.velocity)}
    kinetic = sp.Add(*(e.kinetic.xreplace(still) for e in energies))
    momenta = [sp.diff(kinetic, w) for w in v]
    moments = sp.ImmutableMatrix(n, n, lambda i, k: sign[i] * sign[k] * sp.diff(momenta[i], v[k]))
    if moments.free_symbols & {*v, *(c.position for c in coordinates)}:
        raise WuchtError("the inertia of the bodies depends on their angles")
    drive, losses = zip(*([t.xreplace(still) for t in torques_on(energies, w)] for w in v), strict=True)
    relative = sp.zeros(n, n)
    for i, k in permutations(range(n), 2):
        relative[i, k] = sign[i] * sign[k] * sp.diff(losses[i], v[k])
        if relative[i, k].free_symbols & set(v):
            raise WuchtError(f"the damper between {names[i]} and {names[k]} is not linear")
    for i in range(n):
        relative[i, i] = -sp.Add(*relative[i, :])

    def torques_by_speed(torques: Sequence[sp.Expr]) -> tuple[sp.Lambda, ...]:
        """Torques as functions of the body's speed in its sense, all bodies turning at one speed."""
        return tuple(sp.Lambda(w, s * t.xreplace(dict.fromkeys(v, s * w))) for t, w, s in zip(torques, v, sign, strict=True))

    main_speed, shaken = coordinates[0].prescribed_velocity, structure.shaken_coordinate
    bodies = RotatingBodies(
        names=tuple(names),
        heads=tuple(names.index(structure.rotor_of(b).name) for b in ordered_bodies),
        inertia=moments,
        relative=sp.ImmutableMatrix(relative),
        drive=torques_by_speed(drive),
        losses=torques_by_speed(losses),
        mass=carrier.mass,
        damping=carrier.damping,
        stiffness=carrier.stiffness,
        excitation=excitation,
        definitions=unbalance,
        labels=structure.labels,
        axis=sp.ImmutableMatrix([[sp.diff(place, c.position) for c in structure.carrier] for place in places]),
        weight=tuple(_weight(energies, c.position, s) for c, s in zip(coordinates, sign, strict=True)),
        fixed_speed=SPEED if has_fixed_speed else None if main_speed is None else sign[0] * main_speed,
        shaking=Shaking(structure.carrier.index(shaken), *shaking) if shaken is not None and shaking is not None else None,
    )
    return derive_averaged_system(bodies, inertia, order)


def _weight(energies: Sequence[Energies], angle: sp.Symbol, sense: int) -> Phasor:
    """Gravity on a body at this angle: the torque Re[weight exp(i theta)] in its sense."""
    slope = sp.Add(*(sp.diff(e.potential, angle) for e in energies))
    weight = Phasor.of(first_harmonic(slope, angle)).times_i.scale(-sp.S.One)
    return weight if sense > 0 else weight.conj.scale(-sp.S.One)


def _excitation(
    carrier: LinearCarrier, names: Sequence[str], senses: Sequence[int]
) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[tuple[Phasor, ...], ...]]:
    """E_i of each body in its sense, its unbalance as a symbol with a definition."""
    definitions, excitation = [], []
    for name, sense, column in zip(names, senses, carrier.excitation, strict=True):
        phasors = [p if sense > 0 else p.conj for p in map(Phasor.of, column)]
        size = next((sp.expand(x) for p in phasors for x in (p.re, p.im) if x != 0), sp.S.Zero)
        if not size.is_Atom:
            symbol = sp.Symbol(f"U[{name}]", real=True)
            definitions.append((symbol, size))
            short = {size: symbol, sp.expand(-size): -symbol}
            phasors = [Phasor(short.get(sp.expand(p.re), p.re), short.get(sp.expand(p.im), p.im)) for p in phasors]
        excitation.append(tuple(phasors))
    return tuple(definitions), tuple(excitation)


def states_with_fast_parts(
    averaged_equations: AveragedEquations,
    time: np.ndarray,
    states: np.ndarray,
    rotor_angle: np.ndarray,
    speed: float | None = None,
) -> np.ndarray:
    """States (N_full, N) of ``machine.system`` that belong to slow states (n, N) at times (N,).

    rotor_angle: (N,), the integral of the main rotor's speed in its sense. speed: where it is fixed.
    """
    machine, parameters = averaged_equations.machine, averaged_equations.values(speed)
    frequency, steady_outputs = machine.shaking_frequency, _steady_outputs(averaged_equations)
    outputs = steady_outputs(time, states, parameters)
    fluctuations = Evaluator.of_outputs(averaged_equations.fast)(time, states, parameters)
    # theta is the angle of the prescribed motion, else of the main rotor.
    theta = np.asarray(rotor_angle, float) if frequency is None else frequency * time
    turning, main = np.exp(1j * theta), _main_speed(averaged_equations, outputs)
    w = main if frequency is None else frequency + 0 * theta
    values = dict[str, np.ndarray]()
    for b in machine.bodies:
        sense = averaged_equations.senses[b.name]
        once, twice = (_complex(fluctuations, x, b.name, main) for x in ("gravity", "ripple"))
        fluctuation, rate = once * turning + twice * turning**2, 1j * w * (once * turning + 2 * twice * turning**2)
        phase = _total_phase(averaged_equations, states, b.name)
        values[b.coordinate.position.name] = sense * (theta + phase + fluctuation.real)
        values[b.coordinate.velocity.name] = sense * (outputs[f"speed[{b.name}]"] + rate.real)
    z = _amplitudes(averaged_equations, outputs)
    # The rates of the amplitudes along the slow motion, by central differences over a small part of a turn; one step for all
    # samples: the result for one does not depend on the others.
    fastest = max((f for f in natural_frequencies(machine).values() if f > 0), default=0.0)
    fastest = fastest or float(np.abs(w).max(initial=0.0)) or 1.0
    slow_rate, step = Evaluator.of_rates(averaged_equations.system).array(time, states, parameters), _STEP / fastest
    after, before = (
        _amplitudes(averaged_equations, steady_outputs(time + h, states + h * slow_rate, parameters)) for h in (step, -step)
    )
    amplitude_rates = np.where(w == 0, 0.0, (after - before) / (2 * step))
    for c, rest, amplitude, rate in zip(machine.carrier, machine.rest, z, amplitude_rates, strict=True):
        values[c.position.name] = rest + (amplitude * turning).real
        values[c.velocity.name] = ((1j * w * amplitude + rate) * turning).real
    return np.array([values[name] for name in machine.state_names])


def _steady_outputs(averaged_equations: AveragedEquations) -> Evaluator:
    """Speeds and amplitudes: no other output of the averaged equations is needed."""
    system, bodies = averaged_equations.system, averaged_equations.averaged_system.bodies.names
    names = [f"speed[{n}]" for n in bodies]
    names += [f"amplitude.{part}[{d}]" for d in averaged_equations.machine.labels for part in ("re", "im")]
    return Evaluator.of(system, [system.output(n).expression for n in names], names)


def _total_phase(averaged_equations: AveragedEquations, states: np.ndarray, name: str) -> np.ndarray:
    """alpha of a body to the reference (N,)."""
    names = averaged_equations.system.state_names
    phases = [f"{body}.phase" for body in Tree(averaged_equations.references).path(name)]
    return np.asarray(sum((states[names.index(p)] for p in phases if p in names), np.zeros(states.shape[1])))


def _main_speed(averaged_equations: AveragedEquations, outputs: Mapping[str, np.ndarray]) -> np.ndarray:
    return outputs[f"speed[{averaged_equations.averaged_system.bodies.names[0]}]"]


def _amplitudes(averaged_equations: AveragedEquations, outputs: Mapping[str, np.ndarray]) -> np.ndarray:
    """z (m, N)."""
    main = _main_speed(averaged_equations, outputs)
    return np.array([_complex(outputs, "amplitude", d, main) for d in averaged_equations.machine.labels])


def _complex(outputs: Mapping[str, np.ndarray], quantity: str, name: str, main: np.ndarray) -> np.ndarray:
    """A complex output (N,). main: the main rotor's speed: at rest nothing is fast, and 0/0 not a number."""
    return np.where(main == 0, 0.0, outputs[f"{quantity}.re[{name}]"] + 1j * outputs[f"{quantity}.im[{name}]"])
