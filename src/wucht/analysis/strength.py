"""A machine whose small parameter is made smaller: the family over which the error of the averaged equations is measured.

With the coupling of rotation and vibration times sqrt(kappa), and the torques that depend on a body's own speed times kappa,
the bodies' equations become J theta'' + B theta' = kappa (L + V): epsilon and mu of 002 (4.8) are multiplied by kappa, and all
other dimensionless numbers stay.
"""

from __future__ import annotations

import math
from dataclasses import replace

import sympy as sp

from wucht.machines.machine import Machine
from wucht.mechanics.energies import Energies
from wucht.schema import Parameter

STRENGTH = "kappa"


def weakened(machine: Machine, kappa: float) -> Machine:
    """The machine with epsilon times ``kappa``, which is a parameter of it: the structure is derived once for all values."""
    given = Parameter(STRENGTH, kappa, "", STRENGTH, "factor of epsilon")
    own = machine.without_contacts  # which stay as hard as they are
    energies = (*(_weakened(machine, e, sp.Symbol(given.path, real=True)) for e in own), *machine.energies[len(own) :])
    return machine.changed(energies=energies, parameters={**machine.parameters, STRENGTH: given}, mismatch=None)


def values_at(machine: Machine, kappa: float) -> dict[str, float]:
    """The values of ``weakened(machine, 1.0)`` for another ``kappa``.

    A prescribed motion turns a body by the coupling alone, once: its amplitude is multiplied by sqrt(kappa) too.
    """
    amplitudes = machine.shaking[:1] if machine.shaking is not None else ()
    return {STRENGTH: kappa} | {a.name: math.sqrt(kappa) * machine.numbers[a] for a in amplitudes}


def _weakened(machine: Machine, e: Energies, kappa: sp.Expr) -> Energies:
    every, angles = [b.coordinate.velocity for b in machine.bodies], {b.coordinate.position for b in machine.bodies}
    carried = [c.velocity for c in machine.carrier if e.kinetic.has(c.velocity)]
    turning = [v for v in every if e.kinetic.has(v)]
    kinetic, potential = e.kinetic, e.potential
    if carried and turning:
        alone = [kinetic.xreplace(dict.fromkeys(still, sp.S.Zero)) for still in (carried, turning)]
        kinetic = sp.Add(*alone, sp.sqrt(kappa) * sp.Add(*(v * w * sp.diff(kinetic, v, w) for v in carried for w in turning)))
    if potential.free_symbols & angles:
        terms = sp.Add.make_args(sp.expand(potential))
        potential = sp.Add(*(kappa * t if t.free_symbols & angles else t for t in terms))

    def weak(expression: sp.Expr) -> sp.Expr:
        """Times kappa what one body alone feels; dampers between two bodies, and those of the carrier, stay."""
        return expression * kappa if sum(expression.has(v) for v in every) == 1 else expression

    applied = (replace(a, force=a.force * kappa if a.booked == "supplied" else weak(a.force)) for a in e.applied)
    return Energies(kinetic, potential, weak(e.dissipation), tuple(applied))
