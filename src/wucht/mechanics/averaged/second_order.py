"""Second order of the averaged equations: the memory of the carrier, and the effect of the fluctuation within a turn.

While speeds and phases change slowly, the acceleration of the carrier follows the moments with (the convolution with H expanded
about the present)

    Z = G F - i G' F' - (i/2) G'' w' F,   G = -w^2 H(w),   F = sum E_k (phi_k'^2 - i phi_k'') exp(i alpha_k),

a prime at G meaning d/dw, at F and w d/dt: linear in the slips s_k = phi_k' - w and the accelerations a_k = phi_k'', which are
taken implicitly, so that what is steady in the first order stays steady. The fluctuation psi_k = Re[P_k exp(2 i theta)] changes
the moments by dS = -(i/2) sum conj(E_k exp(i alpha_k)) P_k and the mean torque by -Im[T_k conj(P_k)]/2. The error of the slow
motion is O(epsilon^2) over times 1/epsilon, where the full motion starts with the fast part that belongs to it. Rotors that are
not damped against each other librate with sqrt(epsilon): in their phases the small parameter is that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import sympy as sp

from wucht.mechanics.averaged.bodies import RotatingBodies, absolute, rate_of_given
from wucht.mechanics.averaged.coupling import Coupling
from wucht.mechanics.averaged.explicit_form import ExplicitForm, Solution
from wucht.mechanics.averaged.ripple import Ripple
from wucht.mechanics.elimination import solve_general
from wucht.mechanics.phasors import Phasor, total

Amplitudes = list[Phasor]


@dataclass(frozen=True)
class Contributions:
    """What a steady motion (``base``), each slip and each acceleration contribute to displacements (m) and torques (n)."""

    base: tuple[Amplitudes, list[sp.Expr]]
    slip: list[tuple[Amplitudes, list[sp.Expr]]]
    acceleration: list[tuple[Amplitudes, list[sp.Expr]]]


def second_order(bodies: RotatingBodies, coupling: Coupling, first: Solution, pulsing: Ripple) -> Solution:
    """The solution of the next order, from that of the first and the fluctuation within a turn."""
    n, w, lines, every = len(bodies.names), bodies.frequency, coupling.lines, range(len(bodies.names))
    contributions = _contributions(bodies, coupling, first.motion, pulsing)
    solve = _inert if first.inertia else _damped
    speeds, accelerations = solve(bodies, coupling, contributions, first.explicit)
    slips = [lines.name(speeds[k] - w, f"s[{bodies.names[k]}]") for k in every]
    rates = [lines.name(a, f"a[{bodies.names[k]}]") for k, a in enumerate(accelerations)]
    torques = [
        lines.name(
            contributions.base[1][i]
            + sp.Add(*(contributions.slip[k][1][i] * slips[k] + contributions.acceleration[k][1][i] * rates[k] for k in every)),
            f"V2[{bodies.names[i]}]",
        )
        for i in range(n)
    ]
    moved = [
        total(
            [
                z,
                *(
                    contributions.slip[k][0][d].scaled(slips[k]) + contributions.acceleration[k][0][d].scaled(rates[k])
                    for k in every
                ),
            ]
        )
        for d, z in enumerate(contributions.base[0])
    ]
    rows = tuple((left, _renewed(right, torques, bodies)) for left, right in first.explicit.rows)
    return Solution(moved, torques, ExplicitForm(list(speeds), list(accelerations), rows), first.inertia)


def _renewed(right: sp.Expr, torques: Sequence[sp.Expr], bodies: RotatingBodies) -> sp.Expr:
    """A row with the torques of the next order in place of the first."""
    old = [sp.Symbol(f"V[{name}]", real=True) for name in bodies.names]
    return right.xreplace(dict(zip(old, torques, strict=True)))


def _inert(
    bodies: RotatingBodies, coupling: Coupling, contributions: Contributions, first: ExplicitForm
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """(J - A) a = L + V - B theta': speeds and accelerations (n)."""
    n, w, j, every = len(bodies.names), bodies.frequency, bodies.inertia, range(len(bodies.names))
    speeds, given = first.speeds, rate_of_given(bodies)
    free = [i for i in every if i or bodies.given is None]
    right, left = [], []
    for i in free:
        known = contributions.base[1][i] + sp.Add(*(contributions.slip[k][1][i] * (speeds[k] - w) for k in every))
        inner = sp.Add(*(bodies.relative[i, k] * speeds[k] for k in every))
        effective = [j[i, k] - contributions.acceleration[k][1][i] for k in every]
        prescribed = effective[0] * given if bodies.given is not None else 0
        right.append(absolute(bodies, i, speeds[i]) - inner + known - prescribed)
        left.append([effective[k] for k in free])
    names = [bodies.names[i] for i in free]
    solution = dict(zip(free, solve_general(left, right, names, coupling.lines.name, "theta''2"), strict=True))
    return list(speeds), [solution.get(i, given) for i in range(n)]


def _damped(
    bodies: RotatingBodies, coupling: Coupling, contributions: Contributions, first: ExplicitForm
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """J (w' 1 + nu') + B nu = L + V for w' of the rotors and nu of their bodies, nu' being the rate of the first order's nu."""
    n, w, j, every = len(bodies.names), bodies.frequency, bodies.inertia, range(len(bodies.names))
    unknown = [i for i in every if i or bodies.given is None]
    turning = [bodies.speed(h) for h in bodies.heads]
    nu = [first.speeds[i] - turning[i] for i in every]
    slopes, constant = _slip_rates(bodies, coupling, nu, unknown)
    rates_known = rate_of_given(bodies)
    right, left = [], []
    for i in unknown:
        head = bodies.heads[i]
        row = dict.fromkeys(unknown, sp.S.Zero)
        known = absolute(bodies, i, turning[i]) + contributions.base[1][i]
        for k in every:
            pulled, pushed = contributions.slip[k][1][i], contributions.acceleration[k][1][i]
            effective = (j[i, k] if bodies.heads[k] == head else sp.S.Zero) - pushed
            known += pulled * (turning[k] - w) - effective * constant[k]
            for q, slope in slopes[k].items():  # nu_k' = sum slope_q y_q' + constant
                row[q] += effective * slope
            if bodies.heads[k] in row:
                row[bodies.heads[k]] += effective  # w' of its rotor
            else:
                known -= effective * rates_known
            if k not in bodies.rotors:
                row[k] += (bodies.relative[i, k] if bodies.heads[k] == head else sp.S.Zero) - pulled
        if i not in bodies.rotors:
            v = sp.Dummy("v", real=True)
            row[i] -= sp.diff(absolute(bodies, i, v), v).xreplace({v: turning[i]})
        right.append(known)
        left.append([row[q] for q in unknown])
    names = [bodies.names[i] for i in unknown]
    solution = dict(zip(unknown, solve_general(left, right, names, coupling.lines.name, "y'"), strict=True))
    speeds = [turning[i] + (solution[i] if i not in bodies.rotors else sp.S.Zero) for i in range(n)]
    slip_rates = [constant[k] + sp.Add(*(s * solution[q] for q, s in slopes[k].items())) for k in every]
    return speeds, [solution.get(bodies.heads[k], rates_known) + slip_rates[k] for k in every]


def _slip_rates(
    bodies: RotatingBodies, coupling: Coupling, nu: Sequence[sp.Expr], unknown: Sequence[int]
) -> tuple[list[dict[int, sp.Expr]], list[sp.Expr]]:
    """nu_k' = sum slope_kq y_q' + constant_k: y_q is the speed of rotor q or the phase of body q, the rest is known."""
    slopes = [dict[int, sp.Expr]() for _ in nu]
    lines, before = coupling.lines, list(coupling.lines.pairs)
    for q in unknown:
        variable = bodies.speed(q) if q in bodies.rotors else bodies.phases[q]
        derivatives = lines.rates({variable: sp.S.One}, nu, f"/{variable}", before)
        for k, slope in enumerate(derivatives):
            if slope != 0:
                slopes[k][q] = lines.name(slope, f"dnu[{bodies.names[k]}]/{variable}")
    moving = {
        phase: bodies.speed(i) - (bodies.speed(0) if i else bodies.frequency)
        for i, phase in enumerate(bodies.phases)
        if phase is not None and i in bodies.rotors
    }
    constant = lines.rates(moving, nu, "'", before) if moving else [sp.S.Zero] * len(nu)
    return slopes, constant


def _contributions(bodies: RotatingBodies, coupling: Coupling, motion: Sequence[Phasor], pulsing: Ripple) -> Contributions:
    w, lines, names = bodies.frequency, coupling.lines, [bodies.labels[d] for d in coupling.free]
    shifted = _shifted(bodies, coupling, pulsing.twice)
    base = list(motion)
    if shifted is not None:
        force = [(s + d).scaled(w**2) for s, d in zip(coupling.moments, shifted, strict=True)]
        base = coupling.motion(lines.phasors(force, "F2", names), "2")
    torques = coupling.torques(base, "0")
    torques = [v + m for v, m in zip(torques, _rectified(pulsing), strict=True)]
    slip, acceleration = [], []
    for k, (e, c) in enumerate(zip(bodies.excitation, coupling.direction, strict=True)):
        own = [e[d] * c for d in coupling.free]
        h, bent = _twice(coupling, own, bodies.names[k])
        # G e = -w^2 h, G' e = -2 w h + w^2 bent with h = H e and bent = H D' H e
        slip.append(
            _effect(
                coupling,
                [a.scaled(2 * w) - b.scaled(w**2) for a, b in zip(h, bent, strict=True)],
                [b.scaled(w**4) - a.scaled(4 * w**3) for a, b in zip(h, bent, strict=True)],
                f"s,{bodies.names[k]}",
            )
        )
        displaced = [(b.scaled(2 * w) - a).turned for a, b in zip(h, bent, strict=True)]
        pulled = [(a.scaled(5 * w**2) - b.scaled(2 * w**3)).turned for a, b in zip(h, bent, strict=True)]
        if k == 0 and bodies.shaking is None:
            z2, g2 = _bent_twice(coupling, [base[d] for d in coupling.free])
            displaced = [a - b.turned.scaled(sp.S.Half) for a, b in zip(displaced, z2, strict=True)]
            pulled = [a - b.turned.scaled(sp.S.Half) for a, b in zip(pulled, g2, strict=True)]
        acceleration.append(_effect(coupling, displaced, pulled, f"a,{bodies.names[k]}"))
    return Contributions((base, torques), slip, acceleration)


def _effect(
    coupling: Coupling, displaced: Sequence[Phasor], pulled: Sequence[Phasor], mark: str
) -> tuple[Amplitudes, list[sp.Expr]]:
    """Displacements and torques of all coordinates and bodies for those of the free ones."""
    labels = coupling.bodies.labels
    displacements, accelerations = [Phasor()] * len(labels), [Phasor()] * len(labels)
    for d, z, g in zip(coupling.free, displaced, pulled, strict=True):
        displacements[d] = coupling.lines.phasor(z, f"z{mark}[{labels[d]}]")
        accelerations[d] = coupling.lines.phasor(g, f"Z{mark}[{labels[d]}]")
    return displacements, coupling.torques([], f",{mark}", accelerations)


def _slope(coupling: Coupling, z: Sequence[Phasor]) -> Amplitudes:
    """D' z, D' = i C - 2 w M."""
    b, w = coupling.bodies, coupling.bodies.frequency
    return [
        total([Phasor(-2 * w * b.mass[d, c], b.damping[d, c]) * z[k] for k, c in enumerate(coupling.free)])
        for d in coupling.free
    ]


def _twice(coupling: Coupling, force: Sequence[Phasor], mark: str) -> tuple[Amplitudes, Amplitudes]:
    """H F and H D' H F; H' F = -H D' H F."""
    h = coupling.response(force, f"h,{mark}")
    return h, coupling.response(_slope(coupling, h), f"hh,{mark}")


def _bent_twice(coupling: Coupling, z: Sequence[Phasor]) -> tuple[Amplitudes, Amplitudes]:
    """H'' F and G'' F for z = H F: H'' F = H (2 D' H D' - D'') z, D'' = -2 M."""
    b, w = coupling.bodies, coupling.bodies.frequency
    bent = coupling.response(_slope(coupling, z), "h'")
    curved = [total([z[k].scaled(2 * b.mass[d, c]) for k, c in enumerate(coupling.free)]) for d in coupling.free]
    force = [p.scaled(2) + q for p, q in zip(_slope(coupling, bent), curved, strict=True)]
    second = coupling.response(force, "h''")
    g2 = [y.scaled(4 * w) - x.scaled(2) - s.scaled(w**2) for x, y, s in zip(z, bent, second, strict=True)]
    return second, g2


def _rectified(pulsing: Ripple) -> list[sp.Expr]:
    """The mean torques of the fluctuation in what causes it: -Im[T conj(P)]/2 and, of gravity, -Im[W conj(G)]/2."""
    twice = [(t * p.conj).im for t, p in zip(pulsing.alternating, pulsing.twice, strict=True)]
    once = [(g * p.conj).im for g, p in zip(pulsing.weight, pulsing.once, strict=True)]
    return [-(a + b) / 2 for a, b in zip(twice, once, strict=True)]


def _shifted(bodies: RotatingBodies, coupling: Coupling, pulsing: Sequence[Phasor]) -> Amplitudes | None:
    """dS in each free direction, None where nothing fluctuates."""
    if all(p.is_zero for p in pulsing):
        return None
    shifts = []
    for d in coupling.free:
        terms = [(e[d] * c).conj * p for e, c, p in zip(bodies.excitation, coupling.direction, pulsing, strict=True)]
        shifts.append(total([t for t in terms if not t.is_zero]).turned.scaled(-sp.S.Half))
    return shifts
