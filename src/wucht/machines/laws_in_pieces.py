"""What of a machine has a law in pieces, at whose ends an integration must stop."""

from __future__ import annotations

import sympy as sp

from wucht.machines.mechanism import Mechanism
from wucht.machines.parts.base import Drive, Load, OnShaft, Part
from wucht.machines.structure import SPEED
from wucht.mechanics.energies import Energies
from wucht.piecewise import PiecewiseCubic


def laws_in_pieces(machine: Mechanism) -> tuple[str, ...]:
    """What changes its law on the way, in words: schedules, bodies that touch each other, and parts."""
    schedules = (f"schedule of {s.parameter}" for s in machine.schedules)
    contacts = (f"contacts on the track {t.name}" for t in machine.tracks)
    parts = (_words(p, e) for p, e in zip(machine.parts, machine.without_contacts, strict=False) if _pieces(e))
    return (*schedules, *contacts, *parts)


def _pieces(energies: Energies) -> set[PiecewiseCubic]:
    """The piecewise functions in the formulas of a part."""
    rates = (own.rate for own in energies.internal)
    return set().union(*(sp.sympify(e).atoms(PiecewiseCubic) for e in (*energies.formulas, *rates)))


def _words(part: Part, energies: Energies) -> str:
    """A part by its kind and name, and where its law changes if that is easily said."""
    if not isinstance(part, OnShaft):
        return f"{part.kind} {part.path}"
    words = f"{part.kind} {part.group} on {part.on}"
    if isinstance(part, Load) and all(p.args[1].breakpoints == (0.0,) for p in _pieces(energies)):
        return f"{words}, at standstill"
    if isinstance(part, Drive) and not part.own_states and not sp.sympify(part.torque(SPEED)).has(PiecewiseCubic):
        return f"gear of the {words}, where its torque changes sign"
    return words
