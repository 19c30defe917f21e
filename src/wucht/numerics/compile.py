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
from wucht.numerics.program import Evaluator, Numbers, lower
from wucht.system import System

DEFAULT_TOLERANCE = 1e-12


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
    """A compiled System with its events. Not to be shared by threads: take one a thread (``compile_system`` is cheap then)."""

    system: System
    events: tuple[Event, ...]
    tolerance: float
    engine: Engine
    outputs: Evaluator


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
    states = (*system.states, *(_accumulator(q.name) for q in system.quadratures))
    flow = System(
        states,
        (*system.derivatives, *(q.expression for q in system.quadratures)),
        system.parameters,
        system.definitions,
    )
    program = lower(flow, flow.derivatives)
    event_program = lower(flow, tuple(e.expression for e in events))
    chosen = engine or available_engine()
    compiled: Engine
    if chosen == "heyoka":
        from wucht.numerics.heyoka_engine import HeyokaEngine

        compiled = HeyokaEngine(program, events, event_program, tolerance)
    elif chosen in ("scipy", "scipy-radau"):
        from wucht.numerics.scipy_engine import ScipyEngine

        method = "Radau" if chosen == "scipy-radau" else "DOP853"
        compiled = ScipyEngine(program, events, event_program, tolerance, method)
    else:
        raise WuchtError(f"unknown engine {chosen!r}; known: heyoka, scipy, scipy-radau")
    outputs = Evaluator.of(system, [o.expression for o in system.outputs], [o.name for o in system.outputs])
    return Flow(system, tuple(events), tolerance, compiled, outputs)


def _accumulator(name: str) -> sp.Symbol:
    return sp.Symbol(f"integral of {name}", real=True)
