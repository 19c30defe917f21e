"""The averaged equations of a machine, and the way back from its slow motion to the full one."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import SPEED, relative_damping, sense_of
from wucht.machines.parts.base import Body
from wucht.machines.schedules import with_schedules
from wucht.machines.structure import Structure
from wucht.machines.tree import RotatingBody
from wucht.mechanics.averaged.averaged_system import AveragedSystem, averaged_equations
from wucht.mechanics.averaged.bodies import RotatingBodies, Shaking
from wucht.mechanics.linear_carrier import LinearCarrier, first_harmonic, linear_carrier
from wucht.mechanics.phasors import Phasor
from wucht.system import System


@dataclass(frozen=True)
class AveragedMachine:
    """A machine's averaged equations. senses: +1 or -1 a body. held: the main rotor turns at the parameter ``speed``."""

    machine: Machine
    equations: AveragedSystem
    senses: Mapping[str, int]
    inertia: bool
    order: int
    held: bool

    @cached_property
    def system(self) -> System:
        """The System, with the machine's parameters; scheduled ones follow their schedules."""
        system = self.equations.system
        return _with_parameters(system, self.machine.structure, self.held, system.output("stored_energy").expression)

    @cached_property
    def fast(self) -> System:
        """The bodies' fluctuation within a turn, in the same states and parameters: outputs alone."""
        return _with_parameters(self.equations.fast, self.machine.structure, self.held, sp.S.Zero)

    def values(self, speed: float | None = None) -> tuple[float, ...]:
        """Parameter values in order. speed: of the main rotor, where it is held, positive in its own sense."""
        return self.system.values(self.machine.values | ({} if speed is None else {SPEED.name: speed}))

    @property
    def warnings(self) -> tuple[str, ...]:
        """What these equations leave out."""
        tracks, released = self.machine.tracks, [b.name for b in self.machine.bodies if b.release is not None]
        contacts = [f"contacts on the track {t.name} are left out: this holds while its bodies do not touch" for t in tracks]
        return (*contacts, *(f"{name} is taken as released" for name in released))

    @cached_property
    def references(self) -> dict[str, str | None]:
        """The body to which the phase of each body counts; None for the main rotor."""
        b = self.equations.bodies
        return {name: None if i == 0 else b.names[b.heads[i] if b.heads[i] != i else 0] for i, name in enumerate(b.names)}

    def state(self, angles: Mapping[str, float], speeds: Mapping[str, float]) -> np.ndarray:
        """The slow state (n,) that follows from absolute angles and speeds of the bodies.

        Without inertia the bodies' slips have decayed: rotors have the speed that is left then, and phases have moved on, as
        002 (4.24), (4.30) say.
        """
        theta = {name: sense * angles[name] for name, sense in self.senses.items()}
        turning = {name: sense * speeds[name] for name, sense in self.senses.items()}
        if not self.inertia:
            theta, turning = self._landed(theta, turning)
        parts = [name.rpartition(".") for name in self.system.state_names]
        return np.array(
            [turning[b] if what == "speed" else theta[b] - theta.get(self.references[b] or "", 0.0) for b, _, what in parts]
        )

    def _landed(self, angles: dict[str, float], speeds: dict[str, float]) -> tuple[dict[str, float], dict[str, float]]:
        """Where J nu' + B nu = 0 ends: the speeds that are left, and the angles moved by the integral of nu."""
        b, numbers, n = self.equations.bodies, self.machine.numbers, len(self.equations.bodies.names)
        j, damping = (np.array(a.xreplace(numbers).tolist(), float).reshape(n, n) for a in (b.inertia, b.relative))
        angles, left = dict(angles), dict(speeds)
        for head in b.rotors:
            group = b.group(head)
            at = np.ix_(group, group)
            given = np.array([speeds[b.names[i]] for i in group])
            null = np.linalg.svd(damping[at].T)[2][-1]
            w = given[0] if head == 0 and b.given is not None else null @ j[at] @ given / (null @ j[at].sum(axis=1))
            moved = np.linalg.lstsq(damping[at], j[at] @ (given - w), rcond=None)[0]
            for k, i in enumerate(group):
                left[b.names[i]] = float(w)
                angles[b.names[i]] += float(moved[k] - moved[0])
        return angles, left


def averaged_machine(
    machine: Machine, inertia: bool = True, order: int = 1, held: bool = False, turning: Mapping[str, int] | None = None
) -> AveragedMachine:
    """The averaged equations of a machine with a linear carrier: see ``mechanics.averaged``.

    inertia: of the bodies that turn about a rotor; without it they are strongly damped. order: 1 or 2. held: at a given speed
    of the main rotor, the parameter ``speed``, whatever its drive does. turning: the senses +1, -1 of rotors that do not turn
    as their drives would have them. Raises ``InputError`` for a machine outside the class, with the reason.
    """
    _refuse_others(machine)
    # The main rotor leads where the first body turns about another one.
    ordered = sorted(machine.bodies, key=lambda b: b is not machine.rotor) if machine.bodies[0].about else machine.bodies
    of_rotors = {r.name: int(sense_of(machine, r)) for r in machine.rotors} | dict(turning or {})
    senses = {b.name: of_rotors[r.name] for r in machine.rotors for b in machine.group(r)}
    signs, heads = tuple(senses[b.name] for b in ordered), tuple(machine.rotor_of(b).name for b in ordered)
    options = (len(machine.tracks), machine.shaking, inertia, order, held)
    try:
        equations = _equations(_Question(machine.structure, tuple(ordered), heads, signs, *options, machine))
    except WuchtError as error:
        raise InputError("machine", None, f"has no such averaged equations: {error}") from None
    return AveragedMachine(machine, equations, senses, inertia, order, held)


@dataclass(frozen=True)
class _Question:
    """What the averaged equations depend on: no number of the machine, which serves to look its structure up."""

    structure: Structure
    ordered: tuple[RotatingBody, ...]
    heads: tuple[str, ...]
    signs: tuple[int, ...]
    contacts: int
    shaking: tuple[sp.Symbol, sp.Symbol] | None
    inertia: bool
    order: int
    held: bool
    machine: Machine = field(compare=False)


@lru_cache(maxsize=64)
@derived_once
def _equations(q: _Question) -> AveragedSystem:
    senses = {b.name: sign for b, sign in zip(q.ordered, q.signs, strict=True)}
    return averaged_equations(_bodies(q.machine, q.ordered, senses, q.held), q.inertia, q.order)


@lru_cache(maxsize=64)
def _with_parameters(system: System, structure: Structure, held: bool, stored: sp.Expr) -> System:
    whole = replace(system, parameters=(*structure.symbols, *([SPEED] if held else [])))
    return with_schedules(whole, structure.schedules, stored, structure.units.energy)


def damped(machine: Machine) -> bool:
    """Whether every balancing body is damped against the body it turns about, so that its inertia may be left out."""
    dampers = [relative_damping(machine, b) for b in machine.bodies if b.about is not None]
    return all(not b.is_number or b > 0 for b in dampers)


def _refuse_others(machine: Machine) -> None:
    hung = [p.name for p in machine.parts if isinstance(p, Body) and not p.on_axis()]
    others = [r.name for r in machine.rotors[1:] if r.coordinate.prescribed is not None]
    shaken, prescribed = machine.shaken is not None, any(r.coordinate.prescribed is not None for r in machine.rotors)
    reasons = [
        *(f"{s.name} slides in a guide that turns: the carrier's mass then turns with it" for s in machine.sliders[:1]),
        *(f"the pivot of {name} turns with the rotor: its unbalance depends on its phase" for name in hung[:1]),
    ]
    if shaken and machine.shaking is None:
        reasons.append("the prescribed motion of the carrier is a table: it has no period to average over")
    if shaken and prescribed:
        reasons.append("the speed of a rotor and the motion of the carrier are both prescribed: there is no common speed")
    if others:
        reasons.append(f"the speed of {others[0]} is prescribed, which is not the main rotor: there is no common speed")
    if not machine.free_carrier and not shaken:
        reasons.append("nothing vibrates: the carrier is fixed")
    if reasons:
        raise InputError("machine", None, f"has no averaged equations: {reasons[0]}; run the full model instead")


def _bodies(machine: Machine, ordered: Sequence[RotatingBody], senses: Mapping[str, int], held: bool) -> RotatingBodies:
    names = tuple(b.name for b in ordered)
    carrier = _carrier(machine, ordered)
    unbalance, excitation = _excitation(carrier, ordered, senses)
    inertia, drive, losses = _rotation(machine, ordered)
    sign = [senses[n] for n in names]
    n, v = len(names), [b.coordinate.velocity for b in ordered]
    relative = sp.zeros(n, n)
    for i, loss in enumerate(losses):
        for k in (k for k in range(n) if k != i and loss.has(v[k])):
            relative[i, k] = sign[i] * sign[k] * sp.diff(loss, v[k])
            if relative[i, k].free_symbols & set(v):
                raise WuchtError(f"the damper between {names[i]} and {names[k]} is not linear")
        relative[i, i] = -sp.Add(*relative[i, :])

    def alone(torques: list[sp.Expr]) -> tuple[_Torque, ...]:
        """Torques that depend on the body's own speed: what is left when all turn alike."""
        own = [sign[i] * t.xreplace(dict.fromkeys(v, v[i])) for i, t in enumerate(torques)]
        return tuple(_Torque(t, v[i], sign[i]) for i, t in enumerate(own))

    given, shaking = ordered[0].coordinate.prescribed, None
    if machine.shaken is not None and machine.shaking is not None:
        shaking = Shaking(machine.carrier.index(machine.shaken), *machine.shaking)
    return RotatingBodies(
        names=names,
        heads=tuple(names.index(machine.rotor_of(b).name) for b in ordered),
        inertia=sp.ImmutableMatrix(n, n, lambda i, k: sign[i] * sign[k] * inertia[i, k]),
        relative=sp.ImmutableMatrix(relative),
        drive=alone(drive),
        losses=alone(losses),
        mass=carrier.mass,
        damping=carrier.damping,
        stiffness=carrier.stiffness,
        excitation=excitation,
        definitions=unbalance,
        labels=machine.labels,
        axis=_axis(machine),
        weight=tuple(_weight(machine, b, sign[i]) for i, b in enumerate(ordered)),
        given=SPEED if held else None if given is None else sign[0] * given,
        shaking=shaking,
    )


@dataclass(frozen=True)
class _Torque:
    """A torque as a function of the body's speed in its own sense."""

    expression: sp.Expr
    velocity: sp.Symbol
    sense: int

    def __call__(self, speed: sp.Expr) -> sp.Expr:
        return sp.sympify(self.expression.xreplace({self.velocity: self.sense * speed}))


def _carrier(machine: Machine, ordered: Sequence[RotatingBody]) -> LinearCarrier:
    """M, C, K of all coordinates of the carrier, prescribed ones included, and the excitation of the bodies."""
    if machine.shaken is None and machine.bodies == tuple(ordered):
        return machine.linear_carrier
    return linear_carrier(machine.without_contacts, machine.carrier, [b.coordinate for b in ordered])


def _axis(machine: Machine) -> sp.ImmutableMatrix:
    """The place of the main rotor's axis in the carrier's coordinates: a row each for x and y, or for the angle."""
    rows = [[sp.diff(place, c.position) for c in machine.carrier] for place, _ in machine.orbit.values()]
    return sp.ImmutableMatrix(len(rows), len(machine.carrier), [e for row in rows for e in row])


def _weight(machine: Machine, body: RotatingBody, sense: int) -> Phasor:
    """Gravity on a body: the torque Re[weight exp(i theta)] in its own sense."""
    angle = body.coordinate.position
    slope = sp.Add(*(sp.diff(e.potential, angle) for e in machine.without_contacts if e.potential.has(angle)))
    if slope == 0:
        return Phasor()
    weight = Phasor.of(first_harmonic(slope, angle)).turned.scaled(-sp.S.One)
    return weight if sense > 0 else weight.conj.scaled(-sp.S.One)


def _rotation(machine: Machine, ordered: Sequence[RotatingBody]) -> tuple[sp.Matrix, list[sp.Expr], list[sp.Expr]]:
    """Inertia (n x n), and on each body the torques of the drives and the losses against it, the carrier at rest."""
    still = {s: sp.S.Zero for c in machine.carrier for s in (c.position, c.velocity)}
    v, n = [b.coordinate.velocity for b in ordered], len(ordered)
    inertia, drive, losses = sp.zeros(n, n), [sp.S.Zero] * n, [sp.S.Zero] * n
    for e in machine.without_contacts:
        kinetic, dissipation = e.kinetic.xreplace(still), e.dissipation.xreplace(still)
        for i in (i for i in range(n) if kinetic.has(v[i]) or dissipation.has(v[i])):
            momentum = sp.diff(kinetic, v[i])
            for k in (k for k in range(n) if momentum.has(v[k])):
                inertia[i, k] += sp.diff(momentum, v[k])
            losses[i] += sp.diff(dissipation, v[i])
        for a in e.applied:
            force, rate = a.force.xreplace(still), a.rate.xreplace(still)
            for i in (i for i in range(n) if rate.has(v[i])):
                torque = force * sp.diff(rate, v[i])
                if a.booked == "supplied":
                    drive[i] += torque
                else:
                    losses[i] -= torque
    turning = {s for b in ordered for s in (b.coordinate.position, b.coordinate.velocity)}
    if any(e.free_symbols & turning for e in inertia):
        raise WuchtError("the inertia of the bodies depends on their angles")
    return inertia, drive, losses


def _excitation(
    carrier: LinearCarrier, ordered: Sequence[RotatingBody], senses: Mapping[str, int]
) -> tuple[tuple[tuple[sp.Symbol, sp.Expr], ...], tuple[tuple[Phasor, ...], ...]]:
    """E_i of each body in its own sense, its unbalance as a symbol with a definition."""
    definitions, excitation = [], []
    for b, column in zip(ordered, carrier.excitation, strict=True):
        own = [p if senses[b.name] > 0 else p.conj for p in map(Phasor.of, column)]
        size = next((sp.expand(x) for p in own for x in (p.re, p.im) if x != 0), sp.S.Zero)
        if not size.is_Atom:
            symbol = sp.Symbol(f"U[{b.name}]", real=True)
            definitions.append((symbol, size))
            short = {size: symbol, sp.expand(-size): -symbol}
            own = [Phasor(short.get(sp.expand(p.re), p.re), short.get(sp.expand(p.im), p.im)) for p in own]
        excitation.append(tuple(own))
    return tuple(definitions), tuple(excitation)
