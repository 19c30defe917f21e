"""The equations f(x, p) = 0 of the equilibria of a System, with their derivatives, compiled once."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import WuchtError
from wucht.numerics.jacobian import Jacobian
from wucht.system import TIME, System

Values = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True, eq=False)
class Equations:
    """f of n states and of the m parameters that are varied.

    Attributes
    ----------
    values : callable
        u = (x, p) (n+m,) or (n+m, N) -> f (n,) or (n, N), df/du (n, n+m) or (n, n+m, N).
    states, parameters : tuple of str
        Their names, in order.
    turns : ndarray, (n+m,)
        2 pi of states that are angles, 0 of others.
    scale : ndarray, (n+m,)
        By how much each changes when it changes much.
    """

    values: Callable[[np.ndarray], Values]
    states: tuple[str, ...]
    parameters: tuple[str, ...]
    turns: np.ndarray
    scale: np.ndarray

    @classmethod
    def of(
        cls, system: System, varied: Sequence[str], fixed: Mapping[str, float], scale: Mapping[str, float] | None = None
    ) -> Equations:
        """Of a System.

        Parameters
        ----------
        system : System
            Its outputs and quadratures are left out.
        varied : sequence of str
            Names of the parameters that change along a branch.
        fixed : mapping
            Values of all others.
        scale : mapping, optional
            By how much states and varied parameters change when they change much, by name; 1 where it is silent.

        Raises
        ------
        WuchtError
            For a name that is no parameter, a parameter without a value, a time that occurs.
        """
        names, n, m = system.parameter_names, len(system.states), len(varied)
        for name in (*varied, *(scale or {})):
            if name not in names and not (name in system.state_names and name not in varied):
                raise WuchtError(f"{name} is none of the parameters: {', '.join(names)}")
        missing = [name for name in names if name not in varied and name not in fixed]
        if missing:
            raise WuchtError(f"the parameter {missing[0]} has no value: give one to each that is not varied")
        if any(TIME in sp.sympify(e).free_symbols for e in (*system.derivatives, *(e for _, e in system.definitions))):
            raise WuchtError("these equations depend on time: they have no equilibria, but periodic orbits")
        symbols = tuple(system.parameters[names.index(name)] for name in varied)
        kept = tuple(p for p in system.parameters if p not in symbols)
        # A varied parameter is a state that stays: one compiled function then gives f and all its derivatives.
        whole = System((*system.states, *symbols), (*system.derivatives, *(0,) * m), kept, system.definitions)
        both = _differentiated(whole).bound([fixed[p.name] for p in kept])

        def values(u: np.ndarray) -> Values:
            f, f_u = both(u)
            return f[:n], f_u[:n]

        turns = np.array([2 * math.pi if s in system.angles else 0.0 for s in system.states] + [0.0] * m)
        sizes = np.array([(scale or {}).get(name, 1.0) for name in (*system.state_names, *varied)])
        return cls(values, system.state_names, tuple(varied), turns, sizes)

    @classmethod
    def by_hand(
        cls,
        values: Callable[[np.ndarray], Values],
        states: Sequence[str],
        parameters: Sequence[str],
        scale: Mapping[str, float] | None = None,
        angles: Sequence[str] = (),
    ) -> Equations:
        """Of a function of one u = (x, p) (n+m,) that returns f (n,) and df/du (n, n+m).

        states, parameters, angles: names. scale: as of ``of``. Raises ``WuchtError`` for a name that is none of these.
        """
        names = (*states, *parameters)
        for name in (*(scale or {}), *angles):
            if name not in names:
                raise WuchtError(f"{name} is none of the states and parameters: {', '.join(names)}")

        def many(u: np.ndarray) -> Values:
            if u.ndim == 1:
                return values(u)
            f, f_u = zip(*map(values, u.T), strict=True)
            return np.stack(f, axis=-1), np.stack(f_u, axis=-1)

        turns = np.array([2 * math.pi if name in angles else 0.0 for name in names])
        sizes = np.array([(scale or {}).get(name, 1.0) for name in names])
        return cls(many, tuple(states), tuple(parameters), turns, sizes)

    def scaled(self, scale: np.ndarray) -> Equations:
        """The same, states and parameters (n+m,) being measured by other sizes."""
        return replace(self, scale=np.asarray(scale, float))

    @property
    def n(self) -> int:
        """How many states there are."""
        return len(self.states)


@lru_cache(maxsize=64)
@derived_once
def _differentiated(system: System) -> Jacobian:
    return Jacobian.of(system)
