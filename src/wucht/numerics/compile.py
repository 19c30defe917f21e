"""System -> Flow: compiled once per structure; parameters are run-time values."""

from __future__ import annotations

from dataclasses import dataclass
from functools import lru_cache
from importlib.util import find_spec
from typing import Protocol

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.events import Event, Leg
from wucht.numerics.ladders import Ladders, Look, looking
from wucht.numerics.program import Evaluator, Numbers, lower
from wucht.system import Output, System

DEFAULT_TOLERANCE = 1e-12
# heyoka's steps are accurate relative to the largest state, often an angle of thousands of radians: a work of microjoules is
# accumulated in a unit of its own size.
_PER_UNIT = sp.Symbol("_per_unit", real=True)


class Engine(Protocol):
    """An integrator placed at a time and state, which advances leg by leg."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def time(self) -> float: ...  # noqa: D102
    @property
    def state(self) -> np.ndarray: ...  # noqa: D102
    def start(self, time: float, state: np.ndarray, parameters: Numbers) -> None: ...  # noqa: D102
    def forget_events(self) -> None: ...  # noqa: D102
    def leg(self, grid: np.ndarray) -> Leg: ...  # noqa: D102


@dataclass(frozen=True)
class Flow:
    """A compiled System with its events. Not to be shared by threads: take one a thread (``compile_system`` is cheap then).

    events: those asked for, then those of the ladders. ladders: of the System's piecewise functions. jumps: what the
    quadratures gain where a piecewise function jumps, as a function of the state on a rung, or None if nothing can. acting: the
    events with an action or an end, and ``look``, which tells where their functions are, because two may happen together.
    """

    system: System
    events: tuple[Event, ...]
    tolerance: float
    engine: Engine
    outputs: Evaluator
    ladders: Ladders
    jumps: Evaluator | None
    acting: tuple[int, ...] = ()
    look: Look | None = None


def available_engine() -> str:
    """``"heyoka"`` where it is installed, else ``"scipy"``."""
    return "heyoka" if find_spec("heyoka") else "scipy"


@lru_cache(maxsize=64)
def compile_system(
    system: System,
    tolerance: float = DEFAULT_TOLERANCE,
    events: tuple[Event, ...] = (),
    engine: str | None = None,
) -> Flow:
    """Compile a System; an equal System, whatever its parameter values, gets the same Flow back.

    tolerance: relative and absolute error allowed a step (heyoka: compiled in). engine: ``"heyoka"``, ``"scipy"`` (Dormand-
    Prince), ``"scipy-radau"`` (stiff) or None for the best that is installed. The integrals of the System's quadratures are
    computed along, with the same accuracy. Raises ``WuchtError`` for an unknown engine.
    """
    ladders = _ladders(system, events)
    flow = _smooth(system, ladders)
    program = lower(flow, flow.derivatives)
    watched = (*events, *ladders.events())
    event_program = lower(flow, tuple(ladders.smooth(e.expression) for e in watched))
    if ladders:
        ladders.prepare(flow)
    chosen = engine or available_engine()
    compiled: Engine
    if chosen == "heyoka":
        from wucht.numerics.heyoka_engine import HeyokaEngine

        compiled = HeyokaEngine(program, watched, event_program, tolerance)
    elif chosen in ("scipy", "scipy-radau"):
        from wucht.numerics.scipy_engine import ScipyEngine

        method = "Radau" if chosen == "scipy-radau" else "DOP853"
        compiled = ScipyEngine(program, watched, event_program, tolerance, method)
    else:
        raise WuchtError(f"unknown engine {chosen!r}; known: heyoka, scipy, scipy-radau")
    outputs = Evaluator.of(system, [o.expression for o in system.outputs], [o.name for o in system.outputs])
    acting = tuple(i for i, e in enumerate(events) if e.interrupts)
    look = looking(flow, [ladders.smooth(events[i].expression) for i in acting]) if acting else None
    return Flow(system, watched, tolerance, compiled, outputs, ladders, _jumps(system, flow, ladders), acting, look)


def _ladders(system: System, events: tuple[Event, ...]) -> Ladders:
    used = [*system.derivatives, *(e for _, e in system.definitions), *(e.expression for e in events)]
    used += [e for q in system.quadratures for e in (q.expression, q.jump)]
    return Ladders.of([sp.sympify(e) for e in used])


def _smooth(system: System, ladders: Ladders) -> System:
    """The System that is integrated: quadratures are states, piecewise functions the polynomials of the rungs in use."""
    rates = [_PER_UNIT * sp.sympify(q.expression) for q in system.quadratures]
    return System(
        (*system.states, *(_accumulator(q) for q in system.quadratures)),
        tuple(ladders.smooth(sp.sympify(e)) for e in (*system.derivatives, *rates)),
        (*system.parameters, _PER_UNIT, *ladders.symbols),
        tuple((s, ladders.smooth(e)) for s, e in system.definitions),
    )


def _jumps(system: System, flow: System, ladders: Ladders) -> Evaluator | None:
    if not ladders or all(q.jump == 0 for q in system.quadratures):
        return None
    return Evaluator.of(
        flow, [ladders.smooth(sp.sympify(q.jump)) for q in system.quadratures], [q.name for q in system.quadratures]
    )


def _accumulator(quadrature: Output) -> sp.Symbol:
    return sp.Symbol(f"integral of {quadrature.name}", real=True)
