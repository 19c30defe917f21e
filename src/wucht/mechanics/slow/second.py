"""The next order of the slow equations: what the carrier remembers, and what the fluctuation at twice the speed does.

While speeds and phases change slowly, the acceleration of the carrier follows the moments with (proven by expanding the
convolution with H about the present)

    Z = G F - i G' F' - (i/2) G'' w' F,   G = -w^2 H(w),   F = sum E_k (phi_k'^2 - i phi_k'') exp(i alpha_k),

a prime at G meaning d/dw, at F and w d/dt. The fluctuation psi_k = Re[P_k exp(2 i theta)] changes the moments by
dS = -(i/2) sum conj(E_k exp(i alpha_k)) P_k and the mean torque by -(1/2) Im[T_i conj(P_i)]. The error of the slow motion is
then O(epsilon^2) over times 1/epsilon, where it starts with its own fast part.
"""

from __future__ import annotations

from collections.abc import Sequence

import sympy as sp

from wucht.mechanics.phasors import Lines, Phasor, total
from wucht.mechanics.slow.bodies import RotatingBodies
from wucht.mechanics.slow.closed import Closed, with_inertia, without_inertia
from wucht.mechanics.slow.field import Field
from wucht.mechanics.slow.ripple import Ripple


def second_order(
    bodies: RotatingBodies,
    field: Field,
    motion: Sequence[Phasor],
    pulsing: Ripple,
    first: Closed,
    inertia: bool,
) -> tuple[list[Phasor], list[sp.Expr], Closed]:
    """Displacement amplitudes, vibration torques and the closed equations of the next order, from those of the first."""
    n, w, lines = len(bodies.names), bodies.frequency, field.lines
    speeds, rates = list(first.speeds), list(first.accelerations)
    slips = slip_rates = None
    if not inertia:
        slips = [speeds[i] - bodies.speed(bodies.heads[i]) for i in range(n)]
        slip_rates = [lines.name(r, f"nu'[{bodies.names[i]}]") for i, r in enumerate(_changing(bodies, lines, first, slips))]
        rates = [rates[bodies.heads[i]] + slip_rates[i] for i in range(n)]
    own = _pulled(field, speeds, rates)
    turning = [speeds[i] - w for i in range(n)]
    force = lines.phasors([total(f) for f in own], "F", _names(field))
    change = lines.phasors(_change(field, speeds, rates, turning), "F'", _names(field))
    shifted = _shifted(bodies, field, pulsing.twice)
    if shifted is not None:
        force = lines.phasors([f + s.scaled(w**2) for f, s in zip(force, shifted, strict=True)], "F+", _names(field))
    acceleration, displacement = _remembered(field, force, change, rates[0] if bodies.shaking is None else sp.S.Zero)
    torques = field.torques(displacement, "2", acceleration)
    torques = [v + m for v, m in zip(torques, _rectified(pulsing), strict=True)]
    closed = (
        with_inertia(bodies, lines, torques, "2")
        if inertia
        else without_inertia(bodies, lines, torques, "2", slips, slip_rates)
    )
    return displacement, torques, closed


def _rectified(pulsing: Ripple) -> list[sp.Expr]:
    """The mean torques of the fluctuation in what causes it: -Im[T conj(P)]/2 and, of gravity, -Im[W conj(G)]/2."""
    twice = [(t * p.conj).im for t, p in zip(pulsing.alternating, pulsing.twice, strict=True)]
    once = [(g * p.conj).im for g, p in zip(pulsing.weight, pulsing.once, strict=True)]
    return [-(a + b) / 2 for a, b in zip(twice, once, strict=True)]


def _names(field: Field) -> list[str]:
    return [field.bodies.labels[d] for d in field.free]


def _changing(bodies: RotatingBodies, lines: Lines, first: Closed, slips: Sequence[sp.Expr]) -> list[sp.Expr]:
    """nu' of the first order: the rate of nu along its own solution."""
    given = dict[sp.Symbol, sp.Expr]()
    for i in bodies.rotors:
        if i or bodies.given is None:
            given[bodies.speed(i)] = first.accelerations[i]
    for i, phase in enumerate(bodies.phases):
        if phase is not None:
            reference = bodies.heads[i] if bodies.heads[i] != i else 0
            given[phase] = first.speeds[i] - (first.speeds[reference] if i else bodies.frequency)
    return lines.rates(given, list(slips), "'")


def _pulled(field: Field, speeds: Sequence[sp.Expr], rates: Sequence[sp.Expr]) -> list[list[Phasor]]:
    """E_k (phi_k'^2 - i phi_k'') exp(i alpha_k) in each free direction, a body each."""
    b = field.bodies
    factors = [Phasor(v**2, -a) * c for v, a, c in zip(speeds, rates, field.direction, strict=True)]
    return [[e[d] * f for e, f in zip(b.excitation, factors, strict=True) if not e[d].is_zero] for d in field.free]


def _change(field: Field, speeds: Sequence[sp.Expr], rates: Sequence[sp.Expr], turning: Sequence[sp.Expr]) -> list[Phasor]:
    """F' = (2 phi' phi'' + i alpha' (phi'^2 - i phi'')) exp(i alpha): the third derivatives are of higher order."""
    b = field.bodies
    factors = [
        (Phasor(2 * v * a) + Phasor(v**2, -a).turned.scaled(s)) * c
        for v, a, s, c in zip(speeds, rates, turning, field.direction, strict=True)
    ]
    found = []
    for d in field.free:
        found.append(total([e[d] * f for e, f in zip(b.excitation, factors, strict=True) if not e[d].is_zero]))
    return found


def _shifted(bodies: RotatingBodies, field: Field, pulsing: Sequence[Phasor]) -> list[Phasor] | None:
    """dS in each free direction, None where nothing fluctuates."""
    if all(p.is_zero for p in pulsing):
        return None
    found = []
    for d in field.free:
        terms = [
            (e[d] * c).conj * p for e, c, p in zip(bodies.excitation, field.direction, pulsing, strict=True) if not e[d].is_zero
        ]
        found.append(total(terms).turned.scaled(-sp.S.Half))
    return found


def _remembered(
    field: Field, force: Sequence[Phasor], change: Sequence[Phasor], w_rate: sp.Expr
) -> tuple[list[Phasor], list[Phasor]]:
    """Accelerations Z and displacements z of all coordinates (m), with the slow changes of F and w.

    With D = K - w^2 M + i w C: H' F = -H D' H F and H'' F = H (2 D' H D' - D'') H F.
    """
    b, w = field.bodies, field.bodies.frequency
    size = range(len(field.free))

    def slope(z: Sequence[Phasor]) -> list[Phasor]:
        """D' z, D' = i C - 2 w M."""
        return [
            total([Phasor(-2 * w * b.mass[d, c], b.damping[d, c]) * z[k] for k, c in enumerate(field.free)]) for d in field.free
        ]

    def curved(z: Sequence[Phasor]) -> list[Phasor]:
        """D'' z = -2 M z."""
        return [total([z[k].scaled(-2 * b.mass[d, c]) for k, c in enumerate(field.free)]) for d in field.free]

    still = field.motion(force, "2")
    z = [still[d] for d in field.free]
    # A prescribed motion does not change: only the bodies' forces are remembered.
    own = z if b.shaking is None else field.response(force, "zF")
    first = [p.scaled(-sp.S.One) for p in field.response(slope(own), "H'F")]
    changing = field.response(change, "HF'")
    changed = [p.scaled(-sp.S.One) for p in field.response(slope(changing), "H'F'")]
    bent = [p.scaled(-2) for p in field.response(slope(first), "H2D")]
    bent = [p - q for p, q in zip(bent, field.response(curved(own), "H2F"), strict=True)]
    accelerations, displacements = list(still), list(still)
    for k, d in zip(size, field.free, strict=True):
        g1 = changing[k].scaled(-2 * w) + changed[k].scaled(-(w**2))  # G' F'
        g2 = own[k].scaled(-2) + first[k].scaled(-4 * w) + bent[k].scaled(-(w**2))  # G'' F
        memory = g1 + g2.scaled(w_rate / 2)
        accelerations[d] = still[d].scaled(-(w**2)) - memory.turned
        displacements[d] = z[k] - (changed[k] + bent[k].scaled(w_rate / 2)).turned
    if b.shaking is not None:
        accelerations[b.shaking.index] = still[b.shaking.index].scaled(-(w**2))
    named = [field.lines.phasor(a, f"Z[{label}]") for a, label in zip(accelerations, b.labels, strict=True)]
    moved = [field.lines.phasor(a, f"q[{label}]") for a, label in zip(displacements, b.labels, strict=True)]
    return named, moved
