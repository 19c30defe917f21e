"""A linear carrier, taken from the energies of its machine: M, C, K and its coupling to the bodies.

With q the carrier's coordinates and phi the bodies' angles,
T = q'^T M q'/2 + q'^T sum gamma_i(phi_i) phi_i' + (terms without q'),  R and V give C and K.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

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


def linear_carrier(
    parts: Sequence[Energies],
    carrier: Sequence[Coordinate],
    bodies: Sequence[Coordinate],
    at_rest: Sequence[Coordinate] = (),
) -> LinearCarrier:
    """Read the carrier's matrices off the energies.

    carrier: m coordinates; bodies: the turning ones; at_rest: all others, taken as zero. Raises ``WuchtError`` where the
    carrier is not linear, or a coupling is no first harmonic of the body's angle.
    """
    still = {s: sp.S.Zero for c in at_rest for s in (c.position, c.velocity)}
    if still:
        parts = [Energies(*(e.xreplace(still) for e in (p.kinetic, p.potential, p.dissipation))) for p in parts]
    q, v = [c.position for c in carrier], [c.velocity for c in carrier]
    momenta = [_slopes(p.kinetic, v) for p in parts]
    mass = _matrix(momenta, v)
    damping = _matrix([_slopes(p.dissipation, v) for p in parts], v)
    forces = [_slopes(p.potential, q) for p in parts]
    stiffness = _matrix(forces, q)
    turning = {b.position for b in bodies} | {b.velocity for b in bodies}
    for name, matrix in (("mass", mass), ("damping", damping), ("stiffness", stiffness)):
        if matrix.free_symbols & (set(q) | set(v) | turning):
            raise WuchtError(f"the carrier's {name} matrix is not constant: it has no harmonic influence coefficients")
    origin = dict.fromkeys(q, sp.S.Zero)
    load = sp.ImmutableMatrix(len(q), 1, [-sp.Add(*(f[i].xreplace(origin) for f in forces if i in f)) for i in range(len(q))])
    coupling = tuple(
        sp.ImmutableMatrix(len(v), 1, [sp.Add(*(_diff(p[i], b.velocity) for p in momenta if i in p)) for i in range(len(v))])
        for b in bodies
    )
    excitation = tuple(g.applyfunc(lambda e, b=b: first_harmonic(e, b.position)) for g, b in zip(coupling, bodies, strict=True))
    return LinearCarrier(mass, damping, stiffness, coupling, excitation, load)


def _slopes(function: sp.Expr, symbols: Sequence[sp.Symbol]) -> dict[int, sp.Expr]:
    """The derivatives of a part's function by those symbols that occur in it."""
    return {i: sp.diff(function, s) for i, s in enumerate(symbols) if function.has(s)}


def _matrix(slopes: Sequence[dict[int, sp.Expr]], symbols: Sequence[sp.Symbol]) -> sp.ImmutableMatrix:
    """The second derivatives of a sum of functions with these first ones."""
    size = len(symbols)
    upper = {(i, j): sp.Add(*(_diff(f[i], symbols[j]) for f in slopes if i in f)) for i in range(size) for j in range(i, size)}
    return sp.ImmutableMatrix(size, size, lambda i, j: upper[min(i, j), max(i, j)])


def _diff(function: sp.Expr, symbol: sp.Symbol) -> sp.Expr:
    return sp.diff(function, symbol) if function.has(symbol) else sp.S.Zero


def first_harmonic(coupling: sp.Expr, angle: sp.Symbol) -> sp.Expr:
    """``-2 i <coupling exp(-i angle)>`` for ``coupling = a cos(angle) + b sin(angle)``: -i a - b.

    Raises ``WuchtError`` where the coupling is something else.
    """
    cosine = coupling.xreplace({angle: sp.S.Zero})
    sine = sp.expand(sp.expand_trig(coupling.xreplace({angle: sp.pi / 2})))
    rest = sp.expand(coupling - cosine * sp.cos(angle) - sine * sp.sin(angle))
    if rest != 0 and sp.simplify(rest) != 0:
        raise WuchtError(
            f"the coupling {coupling} is no first harmonic of {angle}: it has no excitation at the speed of rotation"
        )
    return sp.expand(-sp.I * cosine - sine)
