"""System -> compiled System: immutable, made once per structure and shared; each run has an integrator of its own."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.events import Event, LegResult
from wucht.numerics.flow.program import Evaluator, Numbers, Program, lower
from wucht.numerics.flow.segments import Lookahead, Segmentations, SegmentLocator, compile_lookahead
from wucht.system import System

DEFAULT_TOLERANCE = 1e-12
ENGINES = ("heyoka", "scipy", "scipy-radau")
# heyoka's steps are accurate relative to the largest state: a work of microjoules is accumulated in a unit of its own size.
_PER_UNIT = sp.Symbol("_per_unit", real=True)


class Integrator(Protocol):
    """What advances a run, leg by leg. It belongs to that run, and its thread, until it is given back."""

    @property
    def time(self) -> float: ...  # noqa: D102
    @property
    def state(self) -> np.ndarray: ...  # noqa: D102
    def forget_events(self) -> None: ...  # noqa: D102
    def start(self, time: float, state: np.ndarray, parameters: Numbers) -> None: ...  # noqa: D102
    def leg(self, grid: np.ndarray) -> LegResult: ...  # noqa: D102


class Engine(Protocol):
    """Compiled code. Its integrators are lent, each to one run at a time: any thread may ask for one."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def program(self) -> Program: ...  # noqa: D102
    def lend(self) -> Integrator: ...  # noqa: D102
    def give_back(self, integrator: Any) -> None: ...  # noqa: D102


@dataclass(frozen=True)
class CompiledSystem:
    """A compiled System with its events: immutable, hashable, shared by all runs and threads.

    Attributes
    ----------
    system : System
    events : tuple of Event
        Those asked for, then those at breakpoints.
    tolerance : float
        Relative and absolute error allowed per step.
    engine_name : str
    engine : Engine
        The compiled code, which lends an integrator to each run.
    outputs : Evaluator
        Of the System's outputs, over arrays.
    locator : SegmentLocator, optional
        Which segments of piecewise functions are in use; None where there are none.
    jumps : Evaluator, optional
        What the quadratures gain where a piecewise function jumps; None if nothing can.
    interrupting : tuple of int
        The indices of the requested events that stop the integrator.
    lookahead : callable, optional
        The values of their functions now and a little later, because two may happen together.

    Notes
    -----
    Two are equal that were compiled from the same System, events, tolerance and engine.
    """

    system: System
    events: tuple[Event, ...]
    tolerance: float
    engine_name: str
    engine: Engine = field(compare=False)
    outputs: Evaluator = field(compare=False)
    locator: SegmentLocator | None = field(default=None, compare=False)
    jumps: Evaluator | None = field(default=None, compare=False)
    interrupting: tuple[int, ...] = field(default=(), compare=False)
    lookahead: Lookahead | None = field(default=None, compare=False)


def available_engine() -> str:
    """``"heyoka"`` where it is installed, else ``"scipy"``."""
    return "heyoka" if find_spec("heyoka") else "scipy"


@lru_cache(maxsize=64)
def compile_system(
    system: System, tolerance: float = DEFAULT_TOLERANCE, events: tuple[Event, ...] = (), engine: str | None = None
) -> CompiledSystem:
    """Compile a System; an equal System, whatever its parameter values, gets the same compiled one back.

    Parameters
    ----------
    system : System
        The integrals of its quadratures are computed along, with the same accuracy.
    tolerance : float
        Relative and absolute error allowed per step (heyoka: compiled in).
    events : tuple of Event
    engine : {"heyoka", "scipy", "scipy-radau"}, optional
        Taylor's method, Dormand-Prince 8(5,3), or Radau (stiff); None for the best that is installed.

    Returns
    -------
    CompiledSystem

    Raises
    ------
    WuchtError
        For an unknown engine.
    """
    chosen = engine or available_engine()
    if chosen not in ENGINES:
        raise WuchtError(f"unknown engine {chosen!r}; known: {', '.join(ENGINES)}", code="unknown-engine")
    used = [*system.derivatives, *(e for _, e in system.definitions), *(e.expression for e in events)]
    used += [e for q in system.quadratures for e in (q.expression, q.jump)]
    segmentations = Segmentations.of([sp.sympify(e) for e in used])
    smooth = _smooth(system, segmentations)
    program = lower(smooth, smooth.derivatives)
    watched = (*events, *segmentations.events())
    event_program = lower(smooth, tuple(segmentations.smooth(e.expression) for e in watched))
    compiled: Engine
    if chosen == "heyoka":
        from wucht.numerics.flow.heyoka_engine import HeyokaEngine, state_units

        compiled = HeyokaEngine(program, state_units(smooth), watched, event_program, tolerance)
    else:
        from wucht.numerics.flow.scipy_engine import ScipyEngine

        method = "Radau" if chosen == "scipy-radau" else "DOP853"
        compiled = ScipyEngine(program, watched, event_program, tolerance, method)
    interrupting, jumps = tuple(i for i, e in enumerate(events) if e.interrupts), None
    if segmentations and any(q.jump != 0 for q in system.quadratures):
        gains = [segmentations.smooth(sp.sympify(q.jump)) for q in system.quadratures]
        jumps = Evaluator.of(smooth, gains, [q.name for q in system.quadratures])
    return CompiledSystem(
        system,
        watched,
        tolerance,
        chosen,
        compiled,
        Evaluator.of_outputs(system),
        SegmentLocator.of(segmentations, smooth) if segmentations else None,
        jumps,
        interrupting,
        compile_lookahead(smooth, [segmentations.smooth(events[i].expression) for i in interrupting]) if interrupting else None,
    )


def _smooth(system: System, segmentations: Segmentations) -> System:
    """The System that is integrated: quadratures are states, piecewise functions the polynomials of the segments in use."""
    rates = [_PER_UNIT * sp.sympify(q.expression) for q in system.quadratures]
    return System(
        (*system.states, *(sp.Symbol(f"integral of {q.name}", real=True) for q in system.quadratures)),
        tuple(segmentations.smooth(sp.sympify(e)) for e in (*system.derivatives, *rates)),
        (*system.parameters, _PER_UNIT, *segmentations.symbols),
        tuple((s, segmentations.smooth(e)) for s, e in system.definitions),
        angles=system.angles,
    )
