"""System -> compiled System: immutable, made once per structure and shared; each run has a separate integrator.

A Program is also compiled as a function of many points at once.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from functools import cached_property, lru_cache
from importlib.util import find_spec
from typing import Any, Protocol

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.numerics.flow.events import Event, LegResult
from wucht.numerics.flow.program import Evaluator, Numbers, Program, lower
from wucht.numerics.flow.segments import Lookahead, Segmentations, SegmentLocator, compile_lookahead
from wucht.piecewise import PiecewiseCubic
from wucht.system import System as System  # noqa: PLC0414 - re-exported

DEFAULT_TOLERANCE = 1e-12
ENGINES = ("heyoka", "compiled", "scipy", "scipy-radau")
_PACKAGES = (("heyoka", "heyoka"), ("compiled", "llvmlite"))  # needed by engines, the fastest first
# heyoka's steps are accurate relative to the largest state: a work of microjoules is accumulated in a unit of that size.
_PER_UNIT = sp.Symbol("_per_unit", real=True)
_POINTS = 8192  # at once: they stay in the processor's cache
_REGISTERS = 64  # numbers: a whole number of vector registers of any processor


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
    """Compiled code. Its integrators are lent, each to one run at a time, to any thread."""

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
    jumps : Evaluator, optional
        Gains of the quadratures where a piecewise function jumps; None if there are none.
    interrupting : tuple of int
        The indices of the requested events that stop the integrator.
    lookahead : callable, optional
        The values of their functions now and a little later, because two may happen together.

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
    jumps: Evaluator | None = field(default=None, compare=False)
    interrupting: tuple[int, ...] = field(default=(), compare=False)
    lookahead: Lookahead | None = field(default=None, compare=False)


def available_engine() -> str:
    """Choose the engine that a System is compiled for by default.

    Returns
    -------
    str
        ``"heyoka"`` where it is installed, else ``"compiled"`` where LLVM is, else ``"scipy"``.
    """
    return next((engine for engine, package in _PACKAGES if find_spec(package)), "scipy")


def missing_package(engine: str) -> str | None:
    """Return the name of the package that an engine needs, if it is not installed."""
    package = dict(_PACKAGES).get(engine)
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
        Taylor's method, Dormand-Prince 8(5,3) in machine code or interpreted, or Radau (stiff); None for the best one
        installed.

    Returns
    -------
    CompiledSystem

    Raises
    ------
    WuchtError
        For an unknown engine, or one whose package is not installed.
    """
    chosen = engine or available_engine()
    if chosen not in ENGINES:
        raise WuchtError(f"unknown engine {chosen!r}; known: {', '.join(ENGINES)}", code="unknown-engine")
    if (package := missing_package(chosen)) is not None:
        raise WuchtError(f"the engine {chosen!r} needs the package {package}, which is not installed", code="unknown-engine")
    expressions = [*system.derivatives, *(e for _, e in system.definitions), *(e.expression for e in events)]
    expressions += [e for q in system.quadratures for e in (q.expression, q.jump)]
    segmentations = Segmentations.of([sp.sympify(e) for e in expressions])
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
    interrupting, jumps = tuple(i for i, e in enumerate(events) if e.interrupts), None
    if segmentations and any(q.jump != 0 for q in system.quadratures):
        gains = [segmentations.smooth(sp.sympify(q.jump)) for q in system.quadratures]
        jumps = Evaluator.of(smooth, gains, [q.name for q in system.quadratures])
    return CompiledSystem(
        system,
        all_events,
        tolerance,
        chosen,
        code,
        Evaluator.of_outputs(system),
        SegmentLocator.of(segmentations, smooth) if segmentations else None,
        jumps,
        interrupting,
        compile_lookahead(smooth, [segmentations.smooth(events[i].expression) for i in interrupting]) if interrupting else None,
    )


def _smooth(system: System, segmentations: Segmentations) -> System:
    """Build the System that is integrated: quadratures are states, piecewise functions the polynomials of segments in use."""
    rates = [_PER_UNIT * sp.sympify(q.expression) for q in system.quadratures]
    return System(
        (*system.states, *(sp.Symbol(f"integral of {q.name}", real=True) for q in system.quadratures)),
        tuple(segmentations.smooth(sp.sympify(e)) for e in (*system.derivatives, *rates)),
        (*system.parameters, _PER_UNIT, *segmentations.symbols),
        tuple((s, segmentations.smooth(e)) for s, e in system.definitions),
        angles=system.angles,
    )


@lru_cache(maxsize=256)
def heyoka_function(program: Program) -> Any | None:
    """Compile heyoka's function of states, constants and time; None where heyoka is absent or lacks a function."""
    expressions = [*(e for _, e in program.lines), *program.results]
    if available_engine() != "heyoka" or any(e.has(PiecewiseCubic) for e in expressions):
        return None
    from wucht.numerics.flow.heyoka_engine import compiled_function

    return compiled_function(program)


@dataclass(frozen=True)
class ArrayFunction:
    """The results of a program that does not depend on time, at many points."""

    program: Program

    def __call__(self, states: Sequence[np.ndarray] | np.ndarray, constants: np.ndarray) -> np.ndarray:
        """Evaluate.

        Parameters
        ----------
        states : sequence of ndarray, (K, M)
            An array a state; without states an ndarray (0, K, M).
        constants : ndarray, (c, M) or (c, 1)
            The program's, of each column.

        Returns
        -------
        values : ndarray, (r, K, M)
            Not finite where the results cannot be evaluated.
        """
        if self._states is not None:  # nothing has to be computed
            return np.array([states[i] for i in self._states])
        shape = states.shape[1:] if isinstance(states, np.ndarray) else states[0].shape
        if self._heyoka_function is None:
            with np.errstate(all="ignore"):
                values = self._python_function(tuple(states), 0.0, constants)
            return np.array([np.broadcast_to(np.asarray(v, float), shape) for v in values])
        (count, members), results = shape, len(self.program.results)
        values, rows, buffer_points = np.empty((results, count, members)), max(1, _POINTS // members), 0
        for first in range(0, count, rows):
            part = slice(first, min(first + rows, count))
            block = (part.stop - part.start, members)
            points = block[0] * members
            if points != buffer_points:
                buffer_points, width = points, -(-points // _REGISTERS) * _REGISTERS
                x, constant_rows, outputs = (np.empty((n, width)) for n in (len(states), len(constants), results))
                x[:, points:] = constant_rows[:, points:] = 1.0
                constant_rows[:, :points].reshape(-1, *block)[:] = constants[:, None]
            for row, state in zip(x, states, strict=True):
                row[:points].reshape(block)[:] = state[part]
            # By one thread: blocks are small, and there are as many calling threads, each with its members, as processors.
            self._heyoka_function(x, pars=constant_rows, outputs=outputs, batch_parallel=False)
            values[:, part] = outputs[:, :points].reshape(results, *block)
        return values

    @cached_property
    def _states(self) -> list[int] | None:
        """Indices of the states that the results are; None where one is no state."""
        places = {s: i for i, s in enumerate(self.program.states)}
        return [places[r] for r in self.program.results] if set(self.program.results) <= places.keys() else None

    @cached_property
    def _heyoka_function(self) -> Any | None:
        return heyoka_function(self.program) if self.program.states else None

    @cached_property
    def _python_function(self) -> Callable[..., Any]:
        return self.program.function()
