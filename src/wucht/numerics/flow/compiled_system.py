"""System -> compiled System: immutable, made once per structure and shared; each run has a separate integrator."""

from __future__ import annotations

from dataclasses import dataclass, field, replace
from functools import lru_cache
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.coincidences import Coincidences
from wucht.numerics.flow.events import Event, LegResult
from wucht.numerics.flow.program import Evaluator, Numbers, PointValues, Program, lower
from wucht.numerics.flow.segments import Place, Segmentations, SegmentLocator, compile_place
from wucht.system import System as System  # noqa: PLC0414 - re-exported

DEFAULT_TOLERANCE = 1e-12
ENGINES = ("heyoka", "compiled", "scipy", "scipy-radau")
_PACKAGES = {"heyoka": "heyoka", "compiled": "llvmlite"}  # needed by engines
# heyoka's steps are accurate relative to the largest state: a work of microjoules is accumulated in a unit of that size.
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


class Engine(Protocol):
    """Compiled code. Each of its integrators is acquired by one run at a time, in any thread."""

    @property
    def name(self) -> str: ...  # noqa: D102
    @property
    def program(self) -> Program: ...  # noqa: D102
    @property
    def rates(self) -> PointValues: ...  # noqa: D102
    def acquire(self) -> Integrator: ...  # noqa: D102
    def release(self, integrator: Any) -> None: ...  # noqa: D102


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
        The compiled code, which lends an integrator to each run.
    outputs : Evaluator
        Evaluates the System's outputs over arrays.
    locator : SegmentLocator, optional
        Locates the segments of piecewise functions in use; None where there are none.
    jumps : callable, optional
        Computes the gains of the quadratures where a piecewise function jumps; None if there are none.
    coincidences : Coincidences, optional
        Decides which of the requested events happen together with an interruption; None where none are requested.

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
    jumps: Place | None = field(default=None, compare=False)
    coincidences: Coincidences | None = field(default=None, compare=False)

    @property
    def is_error_by_largest_state(self) -> bool:
        """True if a step's allowed error is a share of the largest state, as heyoka's; else of each state, at least of 0.01."""
        return self.engine_name == "heyoka"


def available_engine(is_interrupted: bool = False) -> str:
    """Choose the engine that a System is compiled for by default.

    Parameters
    ----------
    is_interrupted : bool
        True if breakpoints, contacts, releases or terminal events interrupt the run. heyoka loses events that coincide with
        an interruption, or with each other.

    Returns
    -------
    str
        ``"heyoka"`` where it is installed and nothing interrupts the run, else ``"compiled"`` where LLVM is, else what is
        installed; ``"scipy"`` needs no further package.
    """
    engines = ("compiled", "heyoka") if is_interrupted else ("heyoka", "compiled")
    return next((engine for engine in engines if missing_package(engine) is None), "scipy")


def missing_package(engine: str) -> str | None:
    """Return the name of the package that an engine needs, if it is not installed."""
    package = _PACKAGES.get(engine)
    return package if package is not None and find_spec(package) is None else None


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
        Relative and absolute error allowed per step (heyoka: compiled in).
    events : tuple of Event
    engine : {"heyoka", "compiled", "scipy", "scipy-radau"}, optional
        Taylor's method, Dormand-Prince 8(5,3) in machine code or interpreted, or Radau (stiff); None for
        ``available_engine``, by whether breakpoints or events interrupt the run.

    Returns
    -------
    CompiledSystem

    Raises
    ------
    WuchtError
        For an unknown engine, or one whose package is not installed.
    """
    if engine is not None and engine not in ENGINES:
        raise WuchtError(f"unknown engine {engine!r}; known: {', '.join(ENGINES)}", code="unknown-engine")
    if engine is not None and (package := missing_package(engine)) is not None:
        raise WuchtError(f"the engine {engine!r} needs the package {package}, which is not installed", code="unknown-engine")
    expressions = [*system.derivatives, *(e for _, e in system.definitions), *(e.expression for e in events)]
    expressions += [e for q in system.quadratures for e in (q.expression, q.jump)]
    segmentations = Segmentations.of([sp.sympify(e) for e in expressions])
    chosen = engine or available_engine(bool(segmentations) or any(e.interrupts for e in events))
    smooth = _smooth(system, segmentations)
    program = lower(smooth, smooth.derivatives)
    all_events = (*events, *segmentations.events())
    event_program = lower(smooth, tuple(segmentations.smooth(e.expression) for e in all_events))
    code: Engine
    if chosen == "heyoka":
        from wucht.numerics.flow.heyoka_engine import HeyokaEngine, state_units

        code = HeyokaEngine(program, state_units(smooth), all_events, event_program, tolerance)
    elif chosen == "compiled":
        from wucht.numerics.flow.compiled_engine import CompiledEngine

        code = CompiledEngine(program, all_events, event_program, tolerance, smooth)
    else:
        from wucht.numerics.flow.scipy_engine import ScipyEngine

        method = "Radau" if chosen == "scipy-radau" else "DOP853"
        code = ScipyEngine(program, all_events, event_program, tolerance, method)
    jumps = None
    if segmentations and any(q.jump != 0 for q in system.quadratures):
        gains = [segmentations.smooth(sp.sympify(q.jump)) for q in system.quadratures]
        jumps = compile_place(smooth, gains)
    return CompiledSystem(
        system,
        all_events,
        tolerance,
        chosen,
        code,
        Evaluator.of_outputs(system),
        SegmentLocator.of(segmentations, smooth, code.rates) if segmentations else None,
        jumps,
        Coincidences.of(smooth, [segmentations.smooth(e.expression) for e in events], code.rates) if events else None,
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
