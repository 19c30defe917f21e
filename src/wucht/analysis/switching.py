"""Switching speeds of switchable pendulums, in closed form; and the machine with rigid pendulums in their place, or none.

At a steady speed w on a fixed axis the forces on the moving mass are m_s w^2 (r_i + s) outward and F_0 + c s inward. Both are
linear in s: at the inner stop (s = 0) it leaves where w exceeds sqrt(F_0/(m_s r_i)), at the outer one (s = d) where w
falls below sqrt((F_0 + c d)/(m_s r_o)). With c r_i < F_0 the second is less: the mass snaps from stop to stop.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.machines.machine import Machine
from wucht.machines.parts.attachment import Attachment
from wucht.machines.parts.base import Body, Load
from wucht.machines.parts.pendulum import Pendulum
from wucht.machines.parts.rotor import Rotor
from wucht.machines.parts.support import Support
from wucht.machines.parts.switchable_pendulum import SwitchablePendulum


@dataclass(frozen=True)
class Switching:
    """Speeds of a pendulum in rad/s. opening, closing: at which its mass leaves the inner and the outer stop.

    open_speed: just after opening, as its angular momentum is conserved while the mass snaps. stroke: in m.
    """

    opening: float
    closing: float
    open_speed: float
    stroke: float

    @property
    def snaps(self) -> bool:
        """True if the mass snaps from stop to stop; else it moves out gradually between the two speeds."""
        return self.closing < self.opening

    @property
    def stays_open(self) -> bool:
        """True if the mass stays out although the pendulum has slowed down; else the damper has to speed it up first."""
        return self.open_speed > self.closing


def switchable(machine: Machine) -> tuple[SwitchablePendulum, ...]:
    """The switchable pendulums of a machine, in its order."""
    return tuple(p for p in machine.parts if isinstance(p, SwitchablePendulum))


def switching(machine: Machine, pendulum: SwitchablePendulum) -> Switching:
    """The switching speeds of a pendulum of a machine, at the machine's parameter values."""
    m, inner, outer, preload, c = pendulum.symbols("moving_mass", "inner_stop", "outer_stop", "preload", "stiffness")
    opening, closing = sp.sqrt(preload / (m * inner)), sp.sqrt((preload + c * (outer - inner)) / (m * outer))
    after = opening * pendulum.axis_inertia() / _opened_inertia(pendulum)
    return Switching(*map(float, machine.evaluate(opening, closing, after, outer - inner)))


def _opened_inertia(pendulum: SwitchablePendulum) -> sp.Expr:
    """The inertia about the axis with the mass at the outer stop."""
    moving, inner, outer = pendulum.symbols("moving_mass", "inner_stop", "outer_stop")
    return pendulum.axis_inertia() + moving * (outer**2 - inner**2)


def preload_for(machine: Machine, pendulum: SwitchablePendulum, opening: float) -> float:
    """The preload in N with which a pendulum opens at a speed in rad/s: m_s r_i w^2."""
    m, r = machine.evaluate(*pendulum.symbols("moving_mass", "inner_stop"))
    return float(m * r) * opening**2


def with_rigid_pendulums(machine: Machine) -> Machine:
    """The machine with each switchable pendulum rigid, its mass at the outer stop."""
    return _rebuild(machine, [_rigid(machine, b) if isinstance(b, SwitchablePendulum) else b for b in _bodies(machine)])


def without_pendulums(machine: Machine) -> Machine:
    """The machine without its switchable pendulums, their masses added to the rotors that carry them."""
    added_masses: dict[str, float] = {}
    for p in switchable(machine):
        root = machine.tree.root(p.name)
        added_masses[root] = added_masses.get(root, 0.0) + _mass(machine, p)
    remaining = [b for b in _bodies(machine) if not isinstance(b, SwitchablePendulum)]
    return _rebuild(machine, [_heavier(machine, b, added_masses[b.name]) if b.name in added_masses else b for b in remaining])


def _bodies(machine: Machine) -> list[Body]:
    return [p for p in machine.parts if isinstance(p, Body)]


def _mass(machine: Machine, pendulum: SwitchablePendulum) -> float:
    return float(sum(machine.evaluate(*pendulum.symbols("mass", "moving_mass"))))


def _rigid(machine: Machine, p: SwitchablePendulum) -> Pendulum:
    open_inertia, damping = _opened_inertia(p), p.symbol("damping")
    mass, (moment, inertia, b) = _mass(machine, p), map(float, machine.evaluate(p.largest_moment(), open_inertia, damping))
    return Pendulum(
        name=p.name, about=p.about, mass=mass, length=moment / mass, inertia=inertia, damping=b, release=p.release
    )  # fmt: skip


def _heavier(machine: Machine, rotor: Body, mass: float) -> Body:
    """A rotor with a balanced mass added."""
    assert isinstance(rotor, Rotor), "a body that turns on the carrier is a rotor"
    rotor_mass, moment = map(float, machine.evaluate(rotor.symbol("mass"), rotor.moment()))
    unbalance = None if rotor.couple_unbalance is not None else moment
    return rotor.model_copy(update={"mass": rotor_mass + mass, "eccentricity": None, "unbalance": unbalance})


def _rebuild(machine: Machine, bodies: Sequence[Body]) -> Machine:
    """A machine with other bodies, all else unchanged: parameter values and schedules too, of the remaining parts."""
    carrier = next(p for p in machine.parts if isinstance(p, Support))
    loads = [p for p in machine.parts if isinstance(p, Load)]
    before, same = {b.name: b for b in _bodies(machine)}, {b.name for b in bodies}
    changed_bodies = {b.name for b in bodies if before.get(b.name) is not b}
    affected_bodies = changed_bodies | (before.keys() - same)
    schedules = [s for s in machine.schedules if s.parameter.split(".")[0] not in affected_bodies]
    tracks = {t.name: {"contact_frequency": t.frequency} for t in machine.tracks if t.is_frequency_given}
    attachments = [p for p in machine.parts if isinstance(p, Attachment)]
    rebuilt_machine = Machine(
        carrier, bodies, machine.drives, loads, attachments=attachments, schedules=schedules, tracks=tracks, title=machine.title
    )
    return rebuilt_machine.with_unchecked_values(_shared_values(machine.values, rebuilt_machine.values, changed_bodies))


def _shared_values(old: Mapping[str, float], new: Iterable[str], changed_bodies: Iterable[str]) -> dict[str, float]:
    """The values of the parameters that both machines have, except those of changed bodies."""
    owners = set(changed_bodies)
    return {path: old[path] for path in new if path in old and path.split(".")[0] not in owners}
