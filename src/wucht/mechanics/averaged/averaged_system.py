"""Averaged equations of rotating bodies on a linear carrier, for any number of both.

With q the carrier's coordinates, theta_i = sigma_i phi_i the bodies' angles in their own sense and E_i = U_i e_i their
excitation (``linear_carrier``), body i moves the carrier like the moment Re[E_i exp(i theta_i)], and is turned back with the
torque -q''^T d/dtheta_i Re[E_i exp(i theta_i)]. At the common speed w, theta_i = theta + alpha_i, q = Re[z exp(i theta)]:

    z = H(w) F,  F = w^2 sum E_k exp(i alpha_k),  H(w) = (K - w^2 M + i w C)^-1,  Z = -w^2 z (the acceleration),
    V_i = (1/2) Im[exp(i alpha_i) conj(E_i^H Z)]      (the vibration torque; 000 (31), 001 (20), (34), (46), (59)),

and J theta'' + B theta' = L + V: 000 (32)-(33), 001 (33), (47 corrected), (60). Without the inertia of the bodies that are
damped against their rotor: theta' = w + nu with B nu = L + V - J 1 w', which is 002 (4.60)-(4.62) in time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import sympy as sp

from wucht.mechanics.averaged.bodies import RotatingBodies, named
from wucht.mechanics.averaged.coupling import Coupling
from wucht.mechanics.averaged.explicit_form import Solution, with_inertia, without_inertia
from wucht.mechanics.averaged.outputs import outputs_of, parts
from wucht.mechanics.averaged.ripple import ripple
from wucht.mechanics.averaged.second_order import second_order
from wucht.mechanics.phasors import Lines, Phasor
from wucht.mechanics.slow_time import refuse_other_orders
from wucht.system import TIME, System


@dataclass(frozen=True)
class AveragedSystem:
    """The averaged equations as a System, and its rows as they are written on paper: ``left = right``.

    System: states are the phases (angles), then the speeds; quadratures are ``rotor_angle``, the main rotor's angle, and works
    with which the energy of the slow motion balances. Outputs: ``amplitude``, the largest radius of the axis' orbit;
    ``amplitude.re[...]`` and ``.im``, the carrier's motion q = re cos(theta) - im sin(theta); ``vibration_torque[...]``;
    ``speed[...]``; ``motor_torque``; ``stored_energy``. shown: the definitions that the rows use.
    """

    system: System
    rows: tuple[tuple[sp.Expr, sp.Expr], ...]
    shown: tuple[tuple[sp.Symbol, sp.Expr], ...]
    bodies: RotatingBodies

    @cached_property
    def fast(self) -> System:
        """The bodies' fluctuation over the states of the averaged equations: a System that only has outputs.

        ``gravity.re[...]`` and ``.im`` at the speed, ``ripple.re[...]`` and ``.im`` at twice the speed: see ``ripple``.
        """
        lines = Lines(list(self.bodies.definitions))
        coupling = Coupling(self.bodies, lines)
        fluctuation, names = ripple(self.bodies, coupling, steady_motion(coupling)), self.bodies.names
        outputs = [*parts("gravity", names, fluctuation.once), *parts("ripple", names, fluctuation.twice)]
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


def averaged_equations(bodies: RotatingBodies, inertia: bool = True, order: int = 1) -> AveragedSystem:
    """The averaged equations. inertia: of the balancing bodies, else the strongly damped reduction 002 (3.24).

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
    solution = Solution(motion, torques, *explicit, inertia)
    if order == 2:
        solution = second_order(bodies, coupling, solution, ripple(bodies, coupling, motion))
    return _assembled(bodies, lines, solution)


def _assembled(bodies: RotatingBodies, lines: Lines, solution: Solution) -> AveragedSystem:
    names, phases = bodies.names, {i: p for i, p in enumerate(bodies.phases) if p is not None}
    moving = [i for i in bodies.free if solution.inertia or i in bodies.rotors]

    def phase_rates(speeds: Sequence[sp.Expr]) -> dict[int, sp.Expr]:
        return {i: speeds[i] - (speeds[bodies.reference(i)] if i else bodies.frequency) for i in phases}

    rates = list(phase_rates(solution.speeds).values())
    shown = tuple(lines.pairs)
    outputs, works = outputs_of(bodies, lines, solution)
    used = [*rates, *solution.accelerations, *(o.expression for o in (*outputs, *works))]
    system = System(
        states=(*phases.values(), *(bodies.speed(i) for i in moving)),
        derivatives=(*rates, *(solution.accelerations[i] for i in moving)),
        parameters=_parameters(bodies, lines, used),
        definitions=tuple(lines.pairs),
        outputs=tuple(outputs),
        quadratures=tuple(works),
        angles=frozenset(phases.values()),
    )
    written = [
        (named(names[i], "phase.rate"), rate if i in moving or i == 0 else named(names[i], "slip"))
        for i, rate in phase_rates([bodies.speed(i) for i in range(len(names))]).items()
    ]
    return AveragedSystem(system, (*written, *solution.rows), shown, bodies)


def _parameters(bodies: RotatingBodies, lines: Lines, expressions: Sequence[sp.Expr]) -> tuple[sp.Symbol, ...]:
    used = set().union(*(sp.sympify(e).free_symbols for e in (*expressions, *(e for _, e in lines.pairs))))
    states = {*(p for p in bodies.phases if p is not None), *(named(name, "speed") for name in bodies.names)}
    return tuple(sorted(used - states - {s for s, _ in lines.pairs} - {TIME}, key=lambda s: s.name))
