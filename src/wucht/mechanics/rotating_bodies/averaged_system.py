"""Averaged equations of rotating bodies on a linear carrier, for any number of both, to first or second order.

With q the carrier's coordinates, theta_i = sigma_i phi_i the bodies' angles in their sense and E_i = U_i e_i their
excitation (``linear_carrier``), body i drives the carrier with the moment Re[E_i exp(i theta_i)], and is turned back with the
torque -q''^T d/dtheta_i Re[E_i exp(i theta_i)]. At the common speed w, theta_i = theta + alpha_i, q = Re[z exp(i theta)]:

    z = H(w) F,  F = w^2 sum E_k exp(i alpha_k),  H(w) = (K - w^2 M + i w C)^-1,  Z = -w^2 z (the acceleration),
    V_i = (1/2) Im[exp(i alpha_i) conj(E_i^H Z)]      (the vibration torque; 000 (31), 001 (20), (34), (46), (59)),

and J theta'' + B theta' = L + V: 000 (32)-(33), 001 (33), (47 corrected), (60). Without the inertia of the bodies that are
damped against their rotor: theta' = w + nu with B nu = L + V - J 1 w', which is 002 (4.60)-(4.62) in time.

Second order includes the memory of the carrier, and the effect of the fluctuation within a turn.
While speeds and phases change slowly, the acceleration of the carrier follows the moments with (the convolution with H expanded
about the present)

    Z = G F - i G' F' - (i/2) G'' w' F,   G = -w^2 H(w),   F = sum E_k (phi_k'^2 - i phi_k'') exp(i alpha_k),

a prime at G meaning d/dw, at F and w d/dt: linear in the slips s_k = phi_k' - w and the accelerations a_k = phi_k'', which are
treated implicitly, so that steady states of the first order remain steady. The fluctuation psi_k = Re[P_k exp(2 i theta)]
changes the moments by dS = -(i/2) sum conj(E_k exp(i alpha_k)) P_k and the mean torque by -Im[T_k conj(P_k)]/2. The error of
the slow motion is O(epsilon^2) over times 1/epsilon, where the full motion starts with the corresponding fast part. Rotors that
are not damped against each other librate with sqrt(epsilon): in their phases the small parameter is that.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.mechanics.elimination import solve_by_elimination
from wucht.mechanics.phasors import IMAGINARY_UNIT, Lines, Phasor
from wucht.mechanics.rotating_bodies.bodies import (
    RotatingBodies,
    absolute_torque,
    absolute_torque_slope,
    body_symbol,
    fixed_speed_rate,
)
from wucht.mechanics.rotating_bodies.coupling import Coupling, Ripple, ripple
from wucht.mechanics.rotating_bodies.solution import (
    AveragedSolution,
    complex_outputs,
    outputs_of,
    with_inertia,
    without_inertia,
)
from wucht.mechanics.slow_time import refuse_other_orders
from wucht.system import TIME, System

Effect = tuple[np.ndarray, sp.Matrix]
"""Displacement amplitudes (m), and torques on the bodies (n x 1); of each body that causes them, a row and a column."""


def second_order(bodies: RotatingBodies, coupling: Coupling, first: AveragedSolution, pulsing: Ripple) -> AveragedSolution:
    """The solution of the next order, from that of the first and the fluctuation within a turn."""
    names, w, lines = bodies.names, bodies.frequency, coupling.lines
    base = _steady_effect(bodies, coupling, first.motion, pulsing)
    slip, acceleration = _change_effects(bodies, coupling, base[0])
    speeds, accelerations = _solve_implicitly(bodies, coupling, (base[1], slip[1], acceleration[1]), first)
    slips = [lines.name(v - w, f"s[{n}]") for v, n in zip(speeds, names, strict=True)]
    rates = [lines.name(a, f"a[{n}]") for a, n in zip(accelerations, names, strict=True)]
    total_torques = base[1] + slip[1] * sp.Matrix(slips) + acceleration[1] * sp.Matrix(rates)
    torques = [lines.name(v, f"V2[{n}]") for v, n in zip(total_torques, names, strict=True)]
    total_amplitudes = base[0] + slip[0].T @ np.array(slips, object) + acceleration[0].T @ np.array(rates, object)
    torque_symbols = {sp.Symbol(f"V[{n}]", real=True): v for n, v in zip(names, torques, strict=True)}
    rows = tuple((lhs, rhs.xreplace(torque_symbols)) for lhs, rhs in first.rows)
    return AveragedSolution(list(total_amplitudes), torques, speeds, accelerations, rows, first.inertia)


def _solve_implicitly(
    bodies: RotatingBodies, coupling: Coupling, torques: tuple[sp.Matrix, sp.Matrix, sp.Matrix], first: AveragedSolution
) -> tuple[list[sp.Expr], list[sp.Expr]]:
    """Speeds and accelerations theta'' = T y + c (n) from (J - A) theta'' + B theta' = L + V + S (theta' - w).

    torques: V, and of each slip and acceleration S and A. y: the accelerations of all bodies; without inertia the w' of the
    rotors and the nu of their bodies, nu' being the rate of the first order's nu.
    """
    V, S, A = torques
    n, w, inertia = len(bodies.names), bodies.frequency, first.inertia
    unknown = bodies.free
    follows = range(n) if inertia else bodies.heads
    turning = sp.Matrix([bodies.speed(i) for i in follows])
    T = sp.Matrix(n, len(unknown), lambda k, q: int(unknown[q] == follows[k]))
    c = sp.Matrix([0 if i in unknown else fixed_speed_rate(bodies) for i in follows])
    if not inertia:
        slopes, constant = _slip_rates(bodies, coupling, first.speeds, unknown)
        T, c = T + slopes, c + constant
    effective = bodies.inertia - A
    rhs = sp.Matrix([absolute_torque(bodies, i, v) for i, v in enumerate(turning)]) + V + S * turning.applyfunc(lambda v: v - w)
    rhs -= effective * c + (bodies.relative * turning if inertia else sp.zeros(n, 1))
    lhs = sp.Matrix(effective * T)
    for q, i in enumerate(unknown):
        if not inertia and i not in bodies.rotors:
            lhs[:, q] += (bodies.relative - S)[:, i]
            lhs[i, q] -= absolute_torque_slope(bodies, i, turning[i])
    square = lhs.extract(unknown, list(range(len(unknown))))
    names, prefix = [bodies.names[i] for i in unknown], "theta''2 " if inertia else "y' "
    y = solve_by_elimination(square, [rhs[i] for i in unknown], names, coupling.lines, prefix, symmetric=False)
    if not inertia:
        turning += sp.Matrix([y[unknown.index(i)] if i not in bodies.rotors else 0 for i in range(n)])
    return list(turning), list(T * sp.Matrix(y) + c)


def _slip_rates(
    bodies: RotatingBodies, coupling: Coupling, speeds: Sequence[sp.Expr], unknown: Sequence[int]
) -> tuple[sp.Matrix, sp.Matrix]:
    """nu_k' = sum slope_kq y_q + constant_k: y_q is the rate of rotor q's speed or of body q's phase, all else is known."""
    lines, before = coupling.lines, list(coupling.lines.pairs)
    nu = [v - bodies.speed(h) for v, h in zip(speeds, bodies.heads, strict=True)]
    slopes = sp.zeros(len(nu), len(unknown))
    for q, i in enumerate(unknown):
        variable = bodies.speed(i) if i in bodies.rotors else bodies.phases[i]
        for k, slope in enumerate(lines.rates({variable: sp.S.One}, nu, f"/{variable}", before)):
            slopes[k, q] = lines.name(slope, f"dnu[{bodies.names[k]}]/{variable}")
    rates = {
        phase: bodies.speed(i) - (bodies.speed(0) if i else bodies.frequency)
        for i, phase in enumerate(bodies.phases)
        if phase is not None and i in bodies.rotors
    }
    return slopes, sp.Matrix(lines.rates(rates, nu, "'", before))


def _steady_effect(bodies: RotatingBodies, coupling: Coupling, motion: Sequence[Phasor], pulsing: Ripple) -> Effect:
    """Contribution of the steady motion, with the fluctuation's effect on the moments and the torques."""
    w, names = bodies.frequency, [bodies.labels[d] for d in coupling.free]
    if not all(p.is_zero for p in pulsing.twice):
        ripple_moments = np.array(
            [(c.conj * p * IMAGINARY_UNIT) for c, p in zip(coupling.direction, pulsing.twice, strict=True)]
        )
        unbalance = np.array([[e.conj for e in row] for row in bodies.excitation])[:, coupling.free]
        force = (np.array(coupling.moments) - ripple_moments @ unbalance * sp.S.Half) * w**2
        motion = coupling.motion(coupling.lines.phasors(force, "F2", names), "2")
    # The mean torques of the fluctuation in what causes it: -Im[T conj(P)]/2 and, of gravity, -Im[W conj(G)]/2.
    causes = zip(pulsing.alternating, pulsing.twice, pulsing.weight, pulsing.once, strict=True)
    mean_torques = [-((t * p.conj).im + (g * o.conj).im) / 2 for t, p, g, o in causes]
    return np.array(motion), sp.Matrix(coupling.torques(motion, "0")) + sp.Matrix(mean_torques)


def _change_effects(bodies: RotatingBodies, coupling: Coupling, base: np.ndarray) -> tuple[Effect, Effect]:
    """Contributions of each slip and each acceleration: row k of the displacements, column k of the torques."""
    w, free = bodies.frequency, coupling.free
    M, C = (np.array(a.tolist(), object)[np.ix_(free, free)] for a in (bodies.mass, bodies.damping))
    slope = M * Phasor(-2 * w) + C * IMAGINARY_UNIT  # D' = i C - 2 w M, D'' = -2 M
    slips, accelerations = [], []
    for k, (e, c, name) in enumerate(zip(bodies.excitation, coupling.direction, bodies.names, strict=True)):
        # G e = -w^2 h, G' e = -2 w h + w^2 hh with h = H e and hh = H D' H e; H' = -H D' H
        h = coupling.response([e[d] * c for d in free], f"h,{name}")
        hh = coupling.response(slope @ h, f"hh,{name}")
        slips.append(_effect(coupling, h * (2 * w) - hh * w**2, hh * w**4 - h * (4 * w**3), f"s,{name}"))
        free_displacements, free_accelerations = (
            (hh * (2 * w) - h) * IMAGINARY_UNIT,
            (h * (5 * w**2) - hh * (2 * w**3)) * IMAGINARY_UNIT,
        )
        if k == 0 and bodies.shaking is None:
            # For z = H F: H'' F = H (2 D' H D' - D'') z, and G'' F from it.
            z = base[free]
            once = coupling.response(slope @ z, "h'")
            twice = coupling.response(slope @ once * 2 + M @ z * 2, "h''")
            free_displacements = free_displacements - twice * (IMAGINARY_UNIT * sp.S.Half)
            free_accelerations = free_accelerations - (once * (4 * w) - z * 2 - twice * w**2) * (IMAGINARY_UNIT * sp.S.Half)
        accelerations.append(_effect(coupling, free_displacements, free_accelerations, f"a,{name}"))
    effect_pairs = [tuple(zip(*effects, strict=True)) for effects in (slips, accelerations)]
    slip, acceleration = ((np.array(displacements), sp.Matrix.hstack(*torques)) for displacements, torques in effect_pairs)
    return slip, acceleration


def _effect(
    coupling: Coupling, free_displacements: Sequence[Phasor], free_accelerations: Sequence[Phasor], mark: str
) -> Effect:
    """Displacements and torques of all coordinates and bodies for the displacements and accelerations of the free ones."""
    labels = coupling.bodies.labels
    amplitudes = np.full((2, len(labels)), Phasor())
    for d, z, Z in zip(coupling.free, free_displacements, free_accelerations, strict=True):
        amplitudes[:, d] = [coupling.lines.phasor(a, f"{letter}{mark}[{labels[d]}]") for a, letter in ((z, "z"), (Z, "Z"))]
    return amplitudes[0], sp.Matrix(coupling.torques(amplitudes[1], f",{mark}", -sp.S.Half))


@dataclass(frozen=True)
class AveragedSystem:
    """The averaged equations as a System, and its rows as written on paper: ``left = right``.

    System: states are the phases (angles), then the speeds; quadratures are ``rotor_angle``, the main rotor's angle, and works
    with which the energy of the slow motion balances. Outputs: ``amplitude``, the largest radius of the axis' orbit;
    ``amplitude.re[...]`` and ``.im``, the carrier's motion q = re cos(theta) - im sin(theta); ``vibration_torque[...]``;
    ``speed[...]``; ``motor_torque``; ``stored_energy``. row_definitions: the definitions that the rows use.
    """

    system: System
    rows: tuple[tuple[sp.Expr, sp.Expr], ...]
    row_definitions: tuple[tuple[sp.Symbol, sp.Expr], ...]
    bodies: RotatingBodies

    @cached_property
    def fast(self) -> System:
        """The bodies' fluctuation over the states of the averaged equations: a System of outputs only.

        ``gravity.re[...]`` and ``.im`` at the speed, ``ripple.re[...]`` and ``.im`` at twice the speed: see ``ripple``.
        """
        lines = Lines(list(self.bodies.definitions))
        coupling = Coupling(self.bodies, lines)
        fluctuation, names = ripple(self.bodies, coupling, steady_motion(coupling)), self.bodies.names
        outputs = [*complex_outputs("gravity", names, fluctuation.once), *complex_outputs("ripple", names, fluctuation.twice)]
        return System(
            states=self.system.states,
            derivatives=(sp.S.Zero,) * len(self.system.states),
            parameters=_parameters(self.bodies, lines, [o.expression for o in outputs]),
            definitions=tuple(lines.pairs),
            outputs=tuple(outputs),
        )


def steady_motion(coupling: Coupling) -> list[Phasor]:
    """The displacement amplitudes z (m) of bodies that turn steadily."""
    w, names = coupling.bodies.frequency, [coupling.bodies.labels[d] for d in coupling.free]
    force = [s * w**2 for s in coupling.moments]
    return coupling.motion(coupling.lines.phasors(force, "F", names) if len(coupling.direction) > 1 else force, "")


def averaged_system(bodies: RotatingBodies, inertia: bool = True, order: int = 1) -> AveragedSystem:
    """The averaged equations. inertia: keep that of the balancing bodies; else the strongly damped reduction 002 (3.24).

    order: 1, with an error O(epsilon) over times 1/epsilon, or 2 with an error O(epsilon^2): the carrier's response to
    changing speeds, and the bodies' fluctuation at twice the speed. Raises ``WuchtError`` where a body has no damper against
    its rotor, without inertia, and for an order other than these.
    """
    refuse_other_orders(order, "averaged equations")
    lines = Lines(list(bodies.definitions))
    coupling = Coupling(bodies, lines)
    motion = steady_motion(coupling)
    torques = coupling.torques(motion, "")
    explicit = with_inertia(bodies, lines, torques) if inertia else without_inertia(bodies, lines, torques)
    solution = AveragedSolution(motion, torques, *explicit, inertia)
    if order == 2:
        solution = second_order(bodies, coupling, solution, ripple(bodies, coupling, motion))
    return _assemble(bodies, lines, solution)


def _assemble(bodies: RotatingBodies, lines: Lines, solution: AveragedSolution) -> AveragedSystem:
    names, phases = bodies.names, {i: p for i, p in enumerate(bodies.phases) if p is not None}
    moving = [i for i in bodies.free if solution.inertia or i in bodies.rotors]

    def phase_rates(speeds: Sequence[sp.Expr]) -> dict[int, sp.Expr]:
        return {i: speeds[i] - (speeds[bodies.reference(i)] if i else bodies.frequency) for i in phases}

    rates = list(phase_rates(solution.speeds).values())
    row_definitions = tuple(lines.pairs)
    outputs, works = outputs_of(bodies, lines, solution)
    expressions = [*rates, *solution.accelerations, *(o.expression for o in (*outputs, *works))]
    system = System(
        states=(*phases.values(), *(bodies.speed(i) for i in moving)),
        derivatives=(*rates, *(solution.accelerations[i] for i in moving)),
        parameters=_parameters(bodies, lines, expressions),
        definitions=tuple(lines.pairs),
        outputs=tuple(outputs),
        quadratures=tuple(works),
        angles=frozenset(phases.values()),
    )
    phase_rows = [
        (body_symbol(names[i], "phase.rate"), rate if i in moving or i == 0 else body_symbol(names[i], "slip"))
        for i, rate in phase_rates([bodies.speed(i) for i in range(len(names))]).items()
    ]
    return AveragedSystem(system, (*phase_rows, *solution.rows), row_definitions, bodies)


def _parameters(bodies: RotatingBodies, lines: Lines, expressions: Sequence[sp.Expr]) -> tuple[sp.Symbol, ...]:
    symbols = set().union(*(sp.sympify(e).free_symbols for e in (*expressions, *(e for _, e in lines.pairs))))
    states = {*(p for p in bodies.phases if p is not None), *(body_symbol(name, "speed") for name in bodies.names)}
    return tuple(sorted(symbols - states - {s for s, _ in lines.pairs} - {TIME}, key=lambda s: s.name))
