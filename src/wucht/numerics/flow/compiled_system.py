"""System -> compiled System: immutable, made once per structure and shared; each run has a separate integrator."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import Protocol

import numpy as np
import sympy as sp

from wucht.earlier_names import present_engine
from wucht.errors import WuchtError
from wucht.numerics.flow.events import Event, LegResult
from wucht.numerics.flow.explicit_integrator import ExplicitIntegrator
from wucht.numerics.flow.implicit_integrator import ImplicitIntegrator
from wucht.numerics.flow.jacobian import Jacobian
from wucht.numerics.flow.program import Evaluator, Numbers
from wucht.numerics.flow.segment_locator import SegmentLocator
from wucht.numerics.flow.segments import Segmentations
from wucht.numerics.flow.system_code import SystemCode
from wucht.system import System as System  # noqa: PLC0414 - re-exported

DEFAULT_TOLERANCE = 1e-12
DEFAULT_ENGINE, RADAU = "compiled", "radau"
ENGINES = (DEFAULT_ENGINE, RADAU)
_IDLE = 16  # idle integrators kept: more than threads that integrate the same equations at once
# Errors are measured against at least a hundredth: a work of microjoules is accumulated in a unit of its size.
_PER_UNIT = sp.Symbol("_per_unit", real=True)


class Integrator(Protocol):
    """Integrator of a run, leg by leg. It belongs to that run, and its thread, until it is given back."""

    @property
    def time(self) -> float: ...  # noqa: D102
    @property
    def state(self) -> np.ndarray: ...  # noqa: D102
    def forget_events(self) -> None: ...  # noqa: D102
    def start(self, time: float, state: np.ndarray, parameter_values: Numbers) -> None: ...  # noqa: D102
    def leg(self, grid: np.ndarray) -> LegResult: ...  # noqa: D102


class Engine:
    """Machine code of a System, and the integrators that it lends: to one run at a time, in any thread."""

    def __init__(self, code: SystemCode, new_integrator: Callable[[], Integrator]) -> None:
        self.code = code
        self._new_integrator, self._idle = new_integrator, deque[Integrator](maxlen=_IDLE)

    def acquire(self) -> Integrator:
        """Lend an integrator to one run alone."""
        try:
            return self._idle.pop()
        except IndexError:
            return self._new_integrator()

    def release(self, integrator: Integrator) -> None:
        """Take an integrator back for the next run. ``start`` and ``forget_events`` clear the previous run."""
        self._idle.append(integrator)


@dataclass(frozen=True)
class CompiledSystem:
    """A compiled System with its events: immutable, hashable, shared by all runs and threads.

    Attributes
    ----------
    system : System
    events : tuple of Event
        The requested ones, then those at breakpoints.
    tolerance : float
        Relative and absolute error allowed per step.
    engine_name : str
    engine : Engine
        The machine code, which lends an integrator to each run.
    outputs : Evaluator
        Evaluates the System's outputs over arrays.
    locator : SegmentLocator, optional
        Locates the segments of piecewise functions in use; None where there are none.

    Notes
    -----
    Two compiled Systems are equal if made from the same System, events, tolerance and engine.
    """

    system: System
    events: tuple[Event, ...]
    tolerance: float
    engine_name: str
    engine: Engine = field(compare=False)
    outputs: Evaluator = field(compare=False)
    locator: SegmentLocator | None = field(default=None, compare=False)


def known_engine(name: str | None) -> str:
    """Return the engine of a name, of none the default. Raises ``WuchtError`` for an unknown one."""
    present = DEFAULT_ENGINE if name is None else present_engine(name)
    if present not in ENGINES:
        raise WuchtError(f"unknown engine {name!r}; known: {', '.join(ENGINES)}", code="unknown-engine")
    return present


@lru_cache(maxsize=64)
def compile_system(
    system: System, tolerance: float = DEFAULT_TOLERANCE, events: tuple[Event, ...] = (), engine: str | None = None
) -> CompiledSystem:
    """Compile a System; an equal System, whatever its parameter values, gets the same compiled one back.

    Parameters
    ----------
    system : System
        The integrals of its quadratures are computed with it, with the same accuracy.
    tolerance : float
        Relative and absolute error allowed per step.
    events : tuple of Event
    engine : {"compiled", "radau"}, optional
        Dormand-Prince 8(5,3), the default, or Radau's implicit method for stiff equations.

    Returns
    -------
    CompiledSystem

    Raises
    ------
    WuchtError
        For an unknown engine.
    """
    engine = known_engine(engine)
    expressions = [*system.derivatives, *(e for _, e in system.definitions), *(e.expression for e in events)]
    expressions += [e for q in system.quadratures for e in (q.expression, q.jump)]
    segmentations = Segmentations.of([sp.sympify(e) for e in expressions])
    smooth = _smooth(system, segmentations)
    jumps = [q.jump for q in system.quadratures] if segmentations and any(q.jump != 0 for q in system.quadratures) else []
    code = SystemCode.of(smooth, segmentations, events, [_PER_UNIT * segmentations.smooth(sp.sympify(jump)) for jump in jumps])
    locator = SegmentLocator.of(code, smooth) if segmentations else None
    if engine == RADAU:
        new_integrator: Callable[[], Integrator] = partial(ImplicitIntegrator, code, Jacobian.of(smooth), tolerance)
    else:
        new_integrator = partial(ExplicitIntegrator, code, locator, tolerance)
    return CompiledSystem(
        system, code.events, tolerance, engine, Engine(code, new_integrator), Evaluator.of_outputs(system), locator
    )


def _smooth(system: System, segmentations: Segmentations) -> System:
    """Build the System that is integrated: quadratures are states, piecewise functions the polynomials of segments in use."""
    rates = [_PER_UNIT * sp.sympify(q.expression) for q in system.quadratures]
    states = (*system.states, *(sp.Symbol(f"integral of {q.name}", real=True) for q in system.quadratures))
    with_integrals = replace(
        system,
        states=states,
        derivatives=(*system.derivatives, *rates),
        parameters=(*system.parameters, _PER_UNIT),
        quadratures=(),
    )
    return segmentations.smooth_system(with_integrals)
