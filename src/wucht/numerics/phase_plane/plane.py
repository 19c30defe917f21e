"""A System of two states with values of its parameters, in a window of its phase plane (a cylinder or torus: angles)."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import WuchtError
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.jacobian import Jacobian, variational_system
from wucht.system import Output, System

TURN = 2 * math.pi
PASSED_TIME = "passed_time"  # the quadrature of ``_length_system``
_GRID = 41


@dataclass(frozen=True, eq=False)
class Plane:
    """An autonomous planar System and a window of its phase plane.

    Parameters
    ----------
    system : System
        Of two states, without the time.
    values : mapping of str to float
        Of its parameters.
    low, high : ndarray, (2,)
        The window; of an angle one turn, low to low + 2 pi.

    Raises
    ------
    WuchtError
        For another number of states, equations that depend on time, an empty window.
    """

    system: System
    values: Mapping[str, float]
    low: np.ndarray
    high: np.ndarray

    def __post_init__(self) -> None:
        s = self.system
        if len(s.states) != 2:
            names = ", ".join(s.state_names)
            raise WuchtError(
                f"a phase plane has two states, not {len(s.states)} ({names}): its curves would not be separatrices",
                code="two-states",
            )
        if s.depends_on_time:
            raise WuchtError("these equations depend on time: they have no phase plane", code="time-dependent")
        if not (np.isfinite([self.low, self.high]).all() and (self.low < self.high).all()):
            raise WuchtError(f"the window from {self.low} to {self.high} is empty: low must be below high")

    @cached_property
    def turns(self) -> np.ndarray:
        """2 pi of states that are angles, 0 of others (2,)."""
        return np.array([TURN if s in self.system.angles else 0.0 for s in self.system.states])

    @cached_property
    def scale(self) -> np.ndarray:
        """Sides of the window (2,): the units of all lengths in it."""
        return np.asarray(self.high - self.low, float)

    @cached_property
    def numbers(self) -> tuple[float, ...]:
        """Parameter values in the System's order."""
        return self.system.values(self.values)

    @cached_property
    def _jacobian(self) -> Jacobian:
        return jacobian_of(replace(self.system, outputs=(), quadratures=()))

    def rates(self, x: np.ndarray) -> np.ndarray:
        """Evaluate dx/dt at states (2, N), of the same shape; not a number where it cannot be computed."""
        return self._jacobian(x, self.numbers)[0]

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """Evaluate d(dx/dt)/dx (2, 2, N) at states (2, N)."""
        return self._jacobian(x, self.numbers)[1]

    @property
    def lowered_jacobian(self) -> Jacobian:
        """Jacobian with its program, behind ``rates`` and ``jacobian``."""
        return self._jacobian

    def curvature(self, x: np.ndarray, v: np.ndarray) -> np.ndarray:
        """Return d^2/ds^2 of dx/dt along x + s v (2,), exact: from the Jacobian of the variational equations."""
        variational_jacobian = _second_derivatives(replace(self.system, outputs=(), quadratures=()))
        return np.asarray(variational_jacobian.values_at(np.concatenate([x, v]), self.numbers)[1][2:, :2] @ v)

    def difference(self, x: np.ndarray, y: np.ndarray) -> np.ndarray:
        """Return x - y (2, ...) in units of the window, angles within half a turn."""
        extra = (1,) * (np.ndim(x - y) - 1)
        turns, scale = self.turns.reshape(2, *extra), self.scale.reshape(2, *extra)
        away = x - y
        whole = np.round(np.divide(away, turns, out=np.zeros_like(away), where=turns > 0))
        return np.asarray((away - turns * whole) / scale)

    def length(self, x: np.ndarray) -> float:
        """Return the length of the line through states (2, N), in units of the window."""
        return float(np.hypot(*np.diff(x / self.scale[:, None], axis=1)).sum())

    def wrap_to_window(self, x: np.ndarray) -> np.ndarray:
        """Return states (2, ...) with angles wrapped into the window."""
        extra = (1,) * (np.ndim(x) - 1)
        turns, low = self.turns.reshape(2, *extra), self.low.reshape(2, *extra)
        away = x - low
        return np.asarray(x - turns * np.floor(np.divide(away, turns, out=np.zeros_like(away), where=turns > 0)))

    @cached_property
    def usual_speed(self) -> float:
        """Median of |dx/dt| over the window, in windows per unit of time."""
        axes = [np.linspace(a, b, _GRID) for a, b in zip(self.low, self.high, strict=True)]
        x = np.array(np.meshgrid(*axes)).reshape(2, -1)
        speeds = np.hypot(*(self.rates(x) / self.scale[:, None]))
        finite = speeds[np.isfinite(speeds) & (speeds > 0)]
        if not len(finite):
            raise WuchtError("all states in this window are at rest, or the equations cannot be evaluated there")
        return float(np.median(finite))

    @property
    def compiled_length_system(self) -> CompiledSystem:
        """Compiled System of the same curves along their length in units of the window: see ``_length_system``."""
        return compile_system(_length_system(replace(self.system, outputs=(), quadratures=())))

    def length_numbers(self, forwards: bool, rest: float) -> np.ndarray:
        """Return parameter values of ``compiled_length_system``.

        rest: the speed, a share of the usual one, below which the curve is parametrised by time, not length.
        """
        return np.array([*self.numbers, 1.0 if forwards else -1.0, *self.scale, rest * self.usual_speed])


@lru_cache(maxsize=64)
@derived_once
def jacobian_of(system: System) -> Jacobian:
    """Return the Jacobian of a System, made once."""
    return Jacobian.of(system)


@lru_cache(maxsize=64)
@derived_once
def _second_derivatives(system: System) -> Jacobian:
    """Return the Jacobian of the variational equations."""
    return Jacobian.of(variational_system(system))


@lru_cache(maxsize=64)
def _length_system(system: System) -> System:
    """Return dx/ds = +-f/sqrt(rest^2 + |f|^2): the curves of dx/dt = f along their length s; near fixed points along the time.

    Its quadrature is the elapsed time, positive both ways.
    """
    way, *sizes, rest = (sp.Symbol(f"_{n}", real=True) for n in ("way", "size_1", "size_2", "rest"))
    rates = [sp.Symbol(f"_rate_{s.name}", real=True) for s in system.states]
    per = sp.Symbol("_time_per_length", real=True)
    squares = sp.Add(rest**2, *((r / size) ** 2 for r, size in zip(rates, sizes, strict=True)))
    definitions = [
        *system.definitions,
        *zip(rates, map(sp.sympify, system.derivatives), strict=True),
        (per, 1 / sp.sqrt(squares)),
    ]
    return System(
        system.states,
        tuple(way * per * r for r in rates),
        (*system.parameters, way, *sizes, rest),
        tuple(definitions),
        quadratures=(Output(PASSED_TIME, per),),
        angles=system.angles,
    )
