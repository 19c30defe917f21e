"""A linear carrier, taken from the energies of its machine: M, C, K and its coupling to the bodies.

With q the carrier's coordinates and phi the bodies' angles,
T = q'^T M q'/2 + q'^T sum gamma_i(phi_i) phi_i' + (terms without q'),  R and V give C and K.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import WuchtError
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate


@dataclass(frozen=True)
class LinearCarrier:
    """Symbolic M, C, K (m x m), the couplings gamma_i (m x 1, one a body) and the constant load on the carrier (m x 1).

    ``excitation`` holds U_i e_i = -2 i <gamma_i exp(-i phi_i)> (m x 1, complex): a body that turns steadily at w excites the
    carrier with Re[U_i e_i w^2 exp(i phi_i)].
    """

    mass: sp.ImmutableMatrix
    damping: sp.ImmutableMatrix
    stiffness: sp.ImmutableMatrix
    coupling: tuple[sp.ImmutableMatrix, ...]
    excitation: tuple[sp.ImmutableMatrix, ...]
    load: sp.ImmutableMatrix


@derived_once
def linear_carrier(
    parts: Sequence[Energies], carrier: Sequence[Coordinate], bodies: Sequence[Coordinate], at_rest: Sequence[Coordinate] = ()
) -> LinearCarrier:
    """Read the carrier's matrices off the energies.

    carrier: m coordinates; bodies: the turning ones; at_rest: all others, set to zero. Raises ``WuchtError`` where the
    carrier is not linear, or a coupling is not a first harmonic of the body's angle plus a constant.
    """
    still = {s: sp.S.Zero for c in at_rest for s in (c.position, c.velocity)}
    q, v = [c.position for c in carrier], [c.velocity for c in carrier]
    names = ("kinetic", "potential", "dissipation")
    T, V, R = (sp.Add(*(getattr(p, name).xreplace(still) for p in parts)) for name in names)
    momenta, forces = [sp.diff(T, x) for x in v], [sp.diff(V, x) for x in q]
    mass, stiffness = _slopes(momenta, v), _slopes(forces, q)
    damping = _slopes([sp.diff(R, x) for x in v], v)
    turning = {b.position for b in bodies} | {b.velocity for b in bodies}
    for name, matrix in (("mass", mass), ("damping", damping), ("stiffness", stiffness)):
        if matrix.free_symbols & (set(q) | set(v) | turning):
            raise WuchtError(
                f"the carrier's {name} matrix is not constant: it has no harmonic influence coefficients", code="not-constant"
            )
    origin = dict.fromkeys(q, sp.S.Zero)
    load = sp.ImmutableMatrix(len(q), 1, [-f.xreplace(origin) for f in forces])
    # Only the parts of a body have its velocity: their number, not that of all parts, counts for each body.
    kinetic = [(p.kinetic.xreplace(still), p.kinetic.free_symbols) for p in parts]
    turning_parts = {b.velocity: [energy for energy, symbols in kinetic if b.velocity in symbols] for b in bodies}
    coupling = tuple(
        sp.ImmutableMatrix(len(v), 1, [sp.Add(*(sp.diff(energy, x, speed) for energy in energies)) for x in v])
        for speed, energies in turning_parts.items()
    )
    excitation = tuple(
        g.applyfunc(lambda e, b=b: first_harmonic(e - _mean(e, b.position), b.position))
        for g, b in zip(coupling, bodies, strict=True)
    )
    return LinearCarrier(mass, damping, stiffness, coupling, excitation, load)


def _slopes(gradient: Sequence[sp.Expr], symbols: Sequence[sp.Symbol]) -> sp.ImmutableMatrix:
    """The second derivatives of a function with this gradient: a symmetric matrix."""
    size = len(symbols)
    return sp.ImmutableMatrix(size, size, lambda i, j: sp.diff(gradient[min(i, j)], symbols[max(i, j)]))


def _mean(coupling: sp.Expr, angle: sp.Symbol) -> sp.Expr:
    """The part of a coupling that does not depend on the angle: it does not excite in steady rotation."""
    return sp.expand(coupling.xreplace({angle: sp.S.Zero}) + coupling.xreplace({angle: sp.pi})) / 2


def first_harmonic(coupling: sp.Expr, angle: sp.Symbol) -> sp.Expr:
    """``-2 i <coupling exp(-i angle)>`` for ``coupling = a cos(angle) + b sin(angle)``: -i a - b.

    Raises ``WuchtError`` for any other coupling.
    """
    cosine = coupling.xreplace({angle: sp.S.Zero})
    sine = sp.expand(sp.expand_trig(coupling.xreplace({angle: sp.pi / 2})))
    rest = sp.expand(coupling - cosine * sp.cos(angle) - sine * sp.sin(angle))
    if rest != 0 and sp.simplify(rest) != 0:
        raise WuchtError(
            f"the coupling {coupling} is not a first harmonic of {angle}: it has no excitation at the speed of rotation"
        )
    return sp.expand(-sp.I * cosine - sine)
