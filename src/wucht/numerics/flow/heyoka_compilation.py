"""Equations in heyoka's expressions -> an integrator in machine code, kept on disk for the next process.

heyoka's own files of machine code are not authenticated: they are neither read nor written.
"""

from __future__ import annotations

import pickle
import platform
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager, suppress
from dataclasses import dataclass, field
from functools import cache
from pathlib import Path
from threading import Lock
from typing import Any

import numpy as np
import sympy as sp

from wucht.disk_cache import derived_once
from wucht.errors import RunError
from wucht.numerics.flow.events import Event, Hit
from wucht.numerics.flow.program import Assignments, Program
from wucht.numerics.flow.step_sizes import ignore_event, sentinels
from wucht.system import TIME

# Above this many lines (five pendulums) LLVM's whole-function optimisation takes seconds; compact mode compiles loops instead,
# five times faster to compile and half as fast to run.
COMPACT_ABOVE = 80
_COMPILING = Lock()  # heyoka's settings are those of the process
_PROCESSOR_FACTS = ("vendor_id", "cpu family", "model", "model name", "stepping", "flags", "Features", "CPU part")


class Translator:
    """SymPy expressions to heyoka's. Integer powers become products: ``x**n`` with n >= 3 gives NaN at x = 0 in heyoka."""

    def __init__(self, symbols: dict[sp.Symbol, Any]) -> None:
        import heyoka as hy

        self.hy = hy
        self.memo: dict[sp.Basic, Any] = dict(symbols)
        self.functions: dict[Any, Callable[..., Any]] = {
            sp.sin: hy.sin, sp.cos: hy.cos, sp.tan: hy.tan, sp.exp: hy.exp, sp.log: hy.log, sp.sinh: hy.sinh,
            sp.cosh: hy.cosh, sp.tanh: hy.tanh, sp.atan: hy.atan, sp.asin: hy.asin, sp.acos: hy.acos, sp.atan2: hy.atan2,
        }  # fmt: skip

    def __call__(self, e: sp.Expr) -> Any:
        """Translate an expression. Raises ``RunError`` for a function that heyoka does not have."""
        if e not in self.memo:
            self.memo[e] = self._translate(e)
        return self.memo[e]

    def program(self, lines: Assignments, results: Sequence[sp.Expr]) -> list[Any]:
        """Translate results that use lines before them."""
        for symbol, expression in lines:
            self.memo[symbol] = self(expression)
        return [self(r) for r in results]

    def _translate(self, e: sp.Expr) -> Any:
        if e.is_number:
            return self.hy.expression(float(e))
        if isinstance(e, sp.Add):
            return self.hy.sum([self(a) for a in e.args])
        if isinstance(e, sp.Mul):
            above, below = e.as_numer_denom() if any(a.is_Pow and a.exp.is_negative for a in e.args) else (e, sp.S.One)
            top = self.hy.prod([self(a) for a in above.args]) if isinstance(above, sp.Mul) else self(above)
            return top if below is sp.S.One else top / self(below)
        if isinstance(e, sp.Pow):
            return self._power(e)
        if e.func in self.functions:
            return self.functions[e.func](*(self(a) for a in e.args))
        raise RunError(f"heyoka has no function {e.func.__name__!r}; use the SciPy engine", code="no-function")

    def _power(self, e: sp.Pow) -> Any:
        base, exponent = self(e.base), e.exp
        if exponent == 2 and isinstance(e.base, sp.cos):  # the square of the sine occurs in most equations
            sine = self(sp.sin(e.base.args[0]))
            return 1.0 - sine * sine
        if exponent.is_Integer:
            product, square, n = None, base, int(abs(exponent))
            while n:
                if n & 1:
                    product = square if product is None else product * square
                square = square * square if n > 1 else square
                n >>= 1
            return product if exponent.is_positive else self.hy.expression(1.0) / product
        return self.hy.sqrt(base) if exponent == sp.Rational(1, 2) else base ** self(exponent)


def translation(program: Program, first: int = 0, units: np.ndarray | None = None) -> tuple[list[Any], Translator]:
    """Return heyoka's variables for a program's states, and the translator; constants are the parameters from ``first`` on.

    units: of the states (n,) in these variables; None: 1 each.
    """
    import heyoka as hy

    variables = [hy.make_vars(f"s{i}") for i in range(len(program.states))]
    unit_values = [1.0] * len(variables) if units is None else units.tolist()
    scaled_states = [v if unit == 1 else unit * v for v, unit in zip(variables, unit_values, strict=True)]
    symbols: dict[sp.Symbol, Any] = dict(zip(program.states, scaled_states, strict=True)) | {TIME: hy.time}
    return variables, Translator(symbols | {s: hy.par[first + i] for i, (s, _) in enumerate(program.constants)})


def taylor_equations(
    program: Program, variables: Sequence[Any], translate: Translator, units: np.ndarray
) -> list[tuple[Any, Any]]:
    """Pair each variable with its rate, in units (n,), as heyoka integrates them."""
    rates = translate.program(program.lines, program.results)
    return [(v, r if unit == 1 else r / unit) for v, r, unit in zip(variables, rates, units.tolist(), strict=True)]


@dataclass
class Recorder:
    """Recorder of an event that does not interrupt. A copy of an integrator has a copy of it: nothing is shared.

    index, name, direction: of the event. hits: in its direction. ways: +1, -1 of all crossings of the leg, as heyoka reports
    them.
    """

    index: int
    name: str
    direction: int
    units: np.ndarray
    hits: list[Hit] = field(default_factory=list)
    ways: list[tuple[float, int]] = field(default_factory=list)

    def __call__(self, integrator: Any, time: float, way: int) -> None:
        """Record a crossing: heyoka calls this."""
        self.ways.append((time, way))
        if self.direction in (0, way):
            integrator.update_d_output(time)
            self.hits.append(Hit(self.name, time, self.units * integrator.d_output))


@dataclass(frozen=True)
class EventKind:
    """What is compiled of an event besides its function."""

    name: str
    direction: int
    interrupts: bool
    is_breakpoint: bool

    @classmethod
    def of(cls, event: Event) -> EventKind:
        """Describe an event."""
        return cls(event.name, event.direction, event.interrupts, event.switch is not None)


def constant_events(event_program: Program) -> set[int]:
    """Events whose function is constant: it never passes zero, and heyoka refuses it."""
    constants = {symbol for symbol, _ in event_program.constants}
    return {i for i, result in enumerate(event_program.results) if result.free_symbols <= constants}


@derived_once
def compiled_integrator(
    program: Program, unit_values: tuple[float, ...], kinds: tuple[EventKind, ...], event_program: Program, tolerance: float,
    target: tuple[str, str],
) -> bytes:  # fmt: skip
    """Compile an integrator, as heyoka pickles it: with its machine code. target: heyoka's version, and the processor.

    It is pickle that heyoka offers, so only authenticated bytes, which could be any machine code, are read.
    """
    import heyoka as hy

    units, constant = np.array(unit_values), constant_events(event_program)
    variables, translate = translation(program, units=units)
    _, translate_events = translation(event_program, len(program.constants), units)
    system = taylor_equations(program, variables, translate, units)
    functions = translate_events.program(event_program.lines, event_program.results)
    direction = {1: hy.event_direction.positive, -1: hy.event_direction.negative, 0: hy.event_direction.any}
    terminal, passing = [], []
    for i, (kind, function) in enumerate(zip(kinds, functions, strict=True)):
        if i in constant:
            continue
        if kind.interrupts:
            # Beyond a breakpoint the event function is another: a second event may follow at once, as when a ball bounces.
            rest = {"cooldown": 0.0} if kind.is_breakpoint else {}
            terminal.append(hy.t_event(function, direction=direction[kind.direction], **rest))
        else:
            passing.append(hy.nt_event(function, callback=Recorder(i, kind.name, kind.direction, units)))
    passing += [hy.nt_event(f, callback=ignore_event) for f in sentinels(program, variables, translate)]
    extra = {"t_events": terminal} if terminal else {}
    extra |= {"nt_events": passing} if passing else {}
    compact = len(program.lines) > COMPACT_ABOVE
    with _no_cache_of_heyoka(hy):
        integrator = hy.taylor_adaptive(system, [0.0] * len(variables), tol=tolerance, compact_mode=compact, **extra)
    return pickle.dumps(integrator)


@contextmanager
def _no_cache_of_heyoka(hy: Any) -> Iterator[None]:
    """Compile without heyoka's files, whose machine code is not authenticated, while the block lasts."""
    states = hy.llvm_state
    with _COMPILING:
        was_enabled = states.get_diskcache_enabled()
        states.set_diskcache_enabled(False)
        try:
            yield
        finally:
            states.set_diskcache_enabled(was_enabled)


@cache
def processor() -> str:
    """Describe the processor that machine code is compiled for."""
    with suppress(OSError):  # not on Linux
        first, _, _ = Path("/proc/cpuinfo").read_text(encoding="utf-8").partition("\n\n")
        return "\n".join(line for line in first.splitlines() if line.split("\t")[0] in _PROCESSOR_FACTS)
    return repr(platform.uname())
