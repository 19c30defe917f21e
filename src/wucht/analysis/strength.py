"""A machine whose small parameter is made smaller: the family over which the error of the averaged equations is measured.

With the coupling of rotation and vibration times sqrt(kappa), and the torques that depend on a body's own speed times kappa,
the bodies' equations become J theta'' + B theta' = kappa (L + V): epsilon and mu of 002 (4.8) are multiplied by kappa, and all
other dimensionless numbers stay.
"""

from __future__ import annotations

import math

import sympy as sp

from wucht.fields import Parameter
from wucht.machines.machine import Machine
from wucht.mechanics.energies import Applied, Energies

STRENGTH = "kappa"


def weakened(machine: Machine, kappa: float) -> Machine:
    """The machine with epsilon times ``kappa``, which is a parameter of it: the structure is derived once for all values."""
    factor = sp.Symbol(STRENGTH, real=True)
    given = Parameter(STRENGTH, kappa, "", STRENGTH, "factor of epsilon")
    own = machine.without_contacts  # which stay as hard as they are
    energies = (*(_weakened(machine, e, factor) for e in own), *machine.energies[len(own) :])
    return machine.changed(energies=energies, parameters={**machine.parameters, STRENGTH: given}, mismatch=None)


def values_at(machine: Machine, kappa: float) -> dict[str, float]:
    """The values of ``weakened(machine, 1.0)`` for another ``kappa``.

    A prescribed motion turns a body by the coupling alone, once: its amplitude is multiplied by sqrt(kappa) too.
    """
    amplitudes = machine.shaking[:1] if machine.shaking is not None else ()
    return {STRENGTH: kappa} | {a.name: math.sqrt(kappa) * machine.numbers[a] for a in amplitudes}


def _weakened(machine: Machine, e: Energies, kappa: sp.Expr) -> Energies:
    carried = [c.velocity for c in machine.carrier if e.kinetic.has(c.velocity)]
    every = [b.coordinate.velocity for b in machine.bodies]
    turning = [v for v in every if e.kinetic.has(v)]
    alone = e.kinetic.xreplace(dict.fromkeys(carried, sp.S.Zero))
    if carried and turning:
        alone += e.kinetic.xreplace(dict.fromkeys(turning, sp.S.Zero))
    elif not turning:
        alone = e.kinetic
    coupling = sp.Add(*(v * w * sp.diff(e.kinetic, v, w) for v in carried for w in turning))
    return Energies(
        kinetic=alone + sp.sqrt(kappa) * coupling,
        potential=_weight(machine, e.potential, kappa),
        dissipation=e.dissipation * _factor(e.dissipation, every, kappa),
        applied=tuple(
            Applied(a.force * (kappa if a.booked == "supplied" else _factor(a.force, every, kappa)), a.rate, a.name, a.booked)
            for a in e.applied
        ),
    )


def _weight(machine: Machine, potential: sp.Expr, kappa: sp.Expr) -> sp.Expr:
    """The potential with what depends on the bodies' angles times kappa."""
    angles = {b.coordinate.position for b in machine.bodies}
    if not potential.free_symbols & angles:
        return potential
    return sp.Add(*(kappa * t if t.free_symbols & angles else t for t in sp.Add.make_args(sp.expand(potential))))


def _factor(expression: sp.Expr, turning: list[sp.Symbol], kappa: sp.Expr) -> sp.Expr:
    """kappa for what one body alone feels; dampers between two bodies, and those of the carrier, stay."""
    return kappa if sum(expression.has(v) for v in turning) == 1 else sp.S.One
