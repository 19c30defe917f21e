"""Systems in the form of boundary value problems of orbits: in units of a period, and without explicit time."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.continuation.equations import Equations, Values
from wucht.system import TIME, System

PERIOD = sp.Symbol("_period", real=True)
FORCING = "forcing.phase"


@lru_cache(maxsize=64)
def with_period_unit(system: System) -> System:
    """Return the System with a period as its unit of time, which is its first parameter; without outputs and quadratures.

    Raises ``WuchtError`` where the equations depend on time.
    """
    if system.depends_on_time:
        raise WuchtError(
            "these equations depend on time: use with_forcing_phase(system, frequency) to make them autonomous",
            code="time-dependent",
        )
    derivatives = tuple(PERIOD * d for d in system.derivatives)
    return System(system.states, derivatives, (PERIOD, *system.parameters), system.definitions, angles=system.angles)


def equilibrium_equations(orbits: Equations) -> Equations:
    """Return f(x, p) = 0 of the System whose orbits y' = T f(y, p) have these equations, with the period and one parameter."""
    n = orbits.n
    rows, keep = np.array([*range(n), n + 1]), np.delete(np.arange(n + 2), n)

    def values(unknowns: np.ndarray) -> Values:
        point = np.ones((n + 2, *unknowns.shape[1:]))
        point[rows] = unknowns  # the period is 1: then T f is f
        f, derivatives = orbits.values(point)
        return f, derivatives[:, keep]

    return Equations(values, orbits.state_names, orbits.parameter_names[1:], orbits.turns[keep], orbits.scale[keep])


def refuse_empty(name: str, bounds: tuple[float, float]) -> None:
    """Raise ``WuchtError`` where nothing lies between two bounds."""
    if not bounds[0] < bounds[1]:
        raise WuchtError(
            f"the bounds of {name} are ({bounds[0]:g}, {bounds[1]:g}): the first must be less than the second", code="order"
        )


def turns_of(system: System, winding: Mapping[str, int] | None) -> np.ndarray:
    """Return the turns of each state (n,) in a period, by the states' names. Raises ``WuchtError`` for one that is no angle."""
    turns = dict(winding or {})
    if wrong := [name for name in turns if name not in {s.name for s in system.angles}]:
        raise WuchtError(f"{wrong[0]} has a winding number but is not an angle of this System", code="no-angle")
    return np.array([turns.get(name, 0) for name in system.state_names])


def with_forcing_phase(system: System, frequency: str) -> System:
    """Return a periodically forced System, of period 2 pi/frequency, as an autonomous one: with a phase as its last state.

    The phase ``forcing.phase`` is an angle that grows by the frequency; orbits wind about it once or several times in their
    period, and have the multipliers of the forced System beside the trivial one.

    Parameters
    ----------
    system : System
        Outputs and quadratures are left out.
    frequency : str
        Name of its parameter that is the frequency of the forcing, rad per unit of time.

    Returns
    -------
    System

    Raises
    ------
    WuchtError
        Where there is no such parameter, or the equations do not repeat when the phase has gone round.
    """
    if frequency not in system.parameter_names:
        raise WuchtError(
            f"{frequency} is not a parameter of this System; known: {', '.join(system.parameter_names)}", code="no-parameter"
        )
    phase, omega = sp.Symbol(FORCING, real=True), system.parameters[system.parameter_names.index(frequency)]
    change = {TIME: phase / omega}
    definitions = tuple((s, sp.sympify(e).xreplace(change)) for s, e in system.definitions)
    rates = tuple(sp.sympify(d).xreplace(change) for d in system.derivatives)
    full_turn = {phase: phase + 2 * sp.pi}
    direct = [e for e in (*rates, *(e for _, e in definitions)) if phase in e.free_symbols]
    if any(sp.simplify(e - e.xreplace(full_turn)) != 0 for e in direct):
        raise WuchtError(f"these equations do not repeat after a time of 2 pi/{frequency}", code="other-period")
    angles = system.angles | {phase}
    bare = replace(system, outputs=(), quadratures=(), second_order=None)
    return replace(
        bare, states=(*system.states, phase), derivatives=(*rates, omega), definitions=definitions, angles=frozenset(angles)
    )
