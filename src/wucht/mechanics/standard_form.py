"""Changes of variables that bring a System to the standard form x' = epsilon X(x, t) of averaging, 002 (3.1)."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import sympy as sp

from wucht.errors import WuchtError
from wucht.mechanics.averaging import substituted_output
from wucht.mechanics.zero_testing import is_identically_zero
from wucht.system import TIME, Output, System

ELAPSED_TIME = "time"


def with_angle_as_time(system: System, angle: sp.Symbol) -> System:
    """The System with one of its states, an angle, as the independent variable: 002 (3.47)-(3.49).

    Parameters
    ----------
    system : System
        phi' = w(x), x' = epsilon f(x, phi), without time itself.
    angle : sympy.Symbol
        The state phi.

    Returns
    -------
    System
        dx/dphi = epsilon f/w, in which ``TIME`` is the angle; a quadrature ``time`` is the elapsed time. It holds while the
        angle turns one way.

    Raises
    ------
    WuchtError
        Where the symbol is no state, does not turn, the System depends on time itself, or has an output ``time`` already.
    """
    if angle not in system.states:
        raise WuchtError(f"{angle} is not a state; known: {', '.join(system.state_names)}", code="no-state")
    all_outputs = (*system.outputs, *system.quadratures)
    everything = (
        *system.derivatives,
        *(e for _, e in system.definitions),
        *(e for o in all_outputs for e in (o.expression, o.jump)),
    )
    if any(TIME in sp.sympify(e).free_symbols for e in everything):
        raise WuchtError(
            f"the System depends on {TIME} itself: make that a state before {angle} becomes the independent variable",
            code="time-dependent",
        )
    _refuse_taken_outputs(system, [ELAPSED_TIME])
    at = {angle: TIME}
    rate = dict(zip(system.states, system.derivatives, strict=True))
    speed = sp.sympify(rate.pop(angle)).xreplace(at)
    if speed == 0:
        raise WuchtError(f"{angle} does not turn: it cannot be the independent variable", code="does-not-turn")
    return replace(
        system,
        states=tuple(rate),
        derivatives=tuple(sp.sympify(f).xreplace(at) / speed for f in rate.values()),
        definitions=tuple((s, e.xreplace(at)) for s, e in system.definitions),
        outputs=tuple(substituted_output(at, o) for o in system.outputs),
        quadratures=(
            *(substituted_output(at, q, 1 / speed) for q in system.quadratures),
            Output(ELAPSED_TIME, 1 / speed, long_name="time passed"),
        ),
        angles=system.angles - {angle},
        second_order=None,
    )


def with_amplitude_and_phase(
    system: System, position: sp.Symbol, velocity: sp.Symbol, frequency: sp.Expr, amplitude: sp.Symbol, phase: sp.Symbol
) -> System:
    """The System with x = r cos(w t + psi), x' = -w r sin(w t + psi) in the place of a position and its velocity.

    Parameters
    ----------
    system : System
    position, velocity : sympy.Symbol
        The states x and v, which become outputs of these names.
    frequency : sympy.Expr
        w, of parameters alone.
    amplitude, phase : sympy.Symbol
        The new states r and psi.

    Returns
    -------
    System
        The departure from the harmonic oscillation, g = x' - v and f = v' + w^2 x, gives r' = g cos - (f/w) sin and
        r psi' = -g sin - (f/w) cos.

    Raises
    ------
    WuchtError
        Where a symbol is no state, a new one or a new output's name is known already, or the frequency is zero or depends on
        more than parameters.
    """
    missing = [s.name for s in (position, velocity) if s not in system.states]
    if missing:
        raise WuchtError(f"{', '.join(missing)} is not a state; known: {', '.join(system.state_names)}", code="no-state")
    unknown = sp.sympify(frequency).free_symbols - set(system.parameters)
    if unknown:
        raise WuchtError(
            f"the frequency {frequency} depends on {', '.join(sorted(map(str, unknown)))}: only parameters may be in it",
            code="frequency-varies",
        )
    if is_identically_zero(sp.sympify(frequency)):
        raise WuchtError(
            f"the frequency {frequency} is zero: what does not oscillate has no amplitude and phase", code="zero-frequency"
        )
    known_names = {s.name for s in (*system.states, *system.parameters, *(d for d, _ in system.definitions), TIME)}
    taken_names = sorted({s.name for s in (amplitude, phase)} & known_names)
    if taken_names:
        raise WuchtError(f"{', '.join(taken_names)} is in the System already: give another symbol", code="name-taken")
    if amplitude.name == phase.name:
        raise WuchtError(f"amplitude and phase are both called {phase}: give two symbols", code="name-twice")
    if position == velocity:
        raise WuchtError(f"{position} is given as position and as velocity: two states are allowed", code="state-twice")
    _refuse_taken_outputs(system, [position.name, velocity.name])
    total_phase = frequency * TIME + phase
    at = {position: amplitude * sp.cos(total_phase), velocity: -frequency * amplitude * sp.sin(total_phase)}
    rate = {s: sp.sympify(f).xreplace(at) for s, f in zip(system.states, system.derivatives, strict=True)}
    g = sp.expand(rate[position] - at[velocity])
    f = sp.expand(rate[velocity] + frequency**2 * at[position]) / frequency
    rate[position] = g * sp.cos(total_phase) - f * sp.sin(total_phase)
    rate[velocity] = -(g * sp.sin(total_phase) + f * sp.cos(total_phase)) / amplitude
    new_symbols = {position: amplitude, velocity: phase}
    return replace(
        system,
        states=tuple(new_symbols.get(s, s) for s in system.states),
        derivatives=tuple(rate.values()),
        definitions=tuple((s, e.xreplace(at)) for s, e in system.definitions),
        outputs=(*(Output(s.name, e) for s, e in at.items()), *(substituted_output(at, o) for o in system.outputs)),
        quadratures=tuple(substituted_output(at, q) for q in system.quadratures),
        angles=(system.angles - {position, velocity}) | {phase},
        second_order=None,
    )


def _refuse_taken_outputs(system: System, new: Sequence[str]) -> None:
    taken_names = sorted({o.name for o in (*system.outputs, *system.quadratures)} & {*new})
    if taken_names:
        raise WuchtError(
            f"the System has an output {', '.join(taken_names)} already, and the new System adds one: rename the old one",
            code="output-taken",
        )
