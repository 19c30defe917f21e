"""The equations of motion in a frame that turns with the main rotor: its angle drops out, steady rotation is an equilibrium.

A mechanism whose energies do not change when all of it is turned about the normal of the plane obeys the same equations in
every frame. In the one that is momentarily aligned with the main rotor its angle phi is zero, and with w = phi' and a for
absolute accelerations

    x' = vx + w y,   y' = vy - w x,   vx' = ax + w vy,   vy' = ay - w vx,   alpha_i' = phi_i' - w,   alpha_i = phi_i - phi,

where x + i y = exp(-i phi) (x + i y)_fixed, and vx + i vy likewise: a relative equilibrium of a mechanism with a cyclic
coordinate. J. E. Marsden, T. S. Ratiu, "Introduction to Mechanics and Symmetry", Springer 1999, section 8.9.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.zero_testing import is_identically_zero
from wucht.system import TIME, System, needed_definitions

ALONG, ACROSS = "along", "across"


@dataclass(frozen=True)
class Turning:
    """Coordinates that change when a mechanism is turned as a whole.

    plane: the carrier's displacements in x and in y, none where its axis does not move. angles: of all bodies, the main
    rotor's first. All other coordinates are displacements within bodies and do not change.
    """

    plane: tuple[Coordinate, ...]
    angles: tuple[Coordinate, ...]

    def change(self, e: sp.Expr) -> sp.Expr:
        """d/dc of an expression whose mechanism is turned by a small angle c: zero if it is invariant."""
        terms = [sp.diff(e, c.position) for c in self.angles]
        for x, y in zip(self._longitudinal, self._transverse, strict=True):
            terms += [x * sp.diff(e, y), -y * sp.diff(e, x)]
        return sp.expand(sp.Add(*terms))

    @property
    def _longitudinal(self) -> list[sp.Symbol]:
        return [self.plane[0].position, self.plane[0].velocity] if self.plane else []

    @property
    def _transverse(self) -> list[sp.Symbol]:
        return [self.plane[1].position, self.plane[1].velocity] if self.plane else []

    @property
    def frame_symbols(self) -> dict[sp.Symbol, sp.Symbol]:
        """Symbols in the turning frame by those at rest: along the main rotor and normal to it, and phases relative to it."""
        names = dict(zip(self._longitudinal, (f"carrier.{ALONG}", f"carrier.v{ALONG}"), strict=False))
        names |= dict(zip(self._transverse, (f"carrier.{ACROSS}", f"carrier.v{ACROSS}"), strict=False))
        names |= {c.position: f"{c.position.name.removesuffix('.angle')}.phase" for c in self.angles[1:]}
        return {symbol: sp.Symbol(name, real=True) for symbol, name in names.items()}


def refuse_oriented(parts: Sequence[Energies], turning: Turning, zero: Sequence[sp.Symbol] = ()) -> None:
    """Check that a mechanism is invariant under rotation: then its equations of motion are, too.

    zero: parameters whose value is zero. Raises ``WuchtError`` with the formula that changes and the parameters in its
    change.
    """
    nothing = dict.fromkeys(zero, sp.S.Zero)
    if len(turning.plane) == 1:
        raise WuchtError(f"the carrier moves in one direction alone ({turning.plane[0].position})")
    for c in turning.plane:
        if c.prescribed_velocity is not None:
            raise WuchtError(f"the motion of {c.position} is prescribed")
    if turning.angles[0].prescribed_velocity is not None and TIME in turning.angles[0].prescribed_velocity.free_symbols:
        raise WuchtError(f"the prescribed speed {turning.angles[0].velocity} changes over time")
    for part in parts:
        formulas = [("kinetic energy", part.kinetic), ("potential energy", part.potential), ("dissipation", part.dissipation)]
        formulas += [("applied force", e) for a in part.applied_forces for e in (a.force, a.rate)]
        for formula_name, formula in formulas:
            change = turning.change(sp.sympify(formula).xreplace(nothing))
            if not is_identically_zero(change):
                moving = {s for c in (*turning.plane, *turning.angles) for s in (c.position, c.velocity)}
                by = ", ".join(sorted(s.name for s in change.free_symbols - moving)) or "no parameter"
                raise WuchtError(
                    f"the {formula_name} changes when the machine is turned as a whole (with {by})", code="not-symmetric"
                )


def corotating(system: System, turning: Turning, zero: Sequence[sp.Symbol] = ()) -> System:
    """The System in the turning frame: one state less, no outputs; valid where ``refuse_oriented`` raises nothing.

    States in the order of the given ones, without the main rotor's angle: ``carrier.along``, ``carrier.across`` for x and y
    (along the main rotor's angle, and a right angle ahead of it), ``carrier.valong``, ``carrier.vacross`` the absolute
    velocity in that frame, ``BODY.phase`` the angle to the main rotor's, and speeds, absolute as before. zero: parameters whose
    value is zero, which are removed.
    """
    main, names = turning.angles[0], turning.frame_symbols
    short: dict[sp.Symbol, sp.Expr] = {**names, main.position: sp.S.Zero, **dict.fromkeys(zero, sp.S.Zero)}
    definitions = list[tuple[sp.Symbol, sp.Expr]]()
    for symbol, meaning in system.definitions:
        here = sp.sympify(meaning).xreplace(short)
        if here.is_Atom:  # zeros and states of this frame are substituted: the program gets shorter
            short[symbol] = here
        else:
            definitions.append((symbol, here))
    rates = _frame_rates(dict(zip(system.states, system.derivatives, strict=True)), turning)
    frame_states = [s for s in system.states if s != main.position]
    derivatives = tuple(sp.sympify(rates[s]).xreplace(short) for s in frame_states)
    return replace(
        system,
        states=tuple(names.get(s, s) for s in frame_states),
        derivatives=derivatives,
        parameters=tuple(p for p in system.parameters if p not in zero),
        definitions=tuple(needed_definitions(definitions, derivatives)),
        outputs=(),
        quadratures=(),
        angles=frozenset(names[c.position] for c in turning.angles[1:]),
        second_order=None,
    )


def _frame_rates(rates: Mapping[sp.Symbol, sp.Expr], turning: Turning) -> dict[sp.Symbol, sp.Expr]:
    """The rates of the states in the turning frame."""
    main = turning.angles[0].velocity
    turned_rates = {c.position: rates[c.position] - main for c in turning.angles[1:]}
    if turning.plane:
        x, y = turning.plane
        turned_rates |= {x.position: x.velocity + main * y.position, y.position: y.velocity - main * x.position}
        turned_rates |= {x.velocity: rates[x.velocity] + main * y.velocity, y.velocity: rates[y.velocity] - main * x.velocity}
    return {**rates, **turned_rates}
