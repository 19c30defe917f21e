"""A Python function of states that has no formulas: runs call it at each stage, as SymPy functions without derivatives.

Machine code calls it by its address in this process: neither is kept on disk, nor sent to another process.
"""

from __future__ import annotations

import ctypes
import math
import threading
import warnings
from collections.abc import Callable, Sequence
from pickle import PicklingError
from typing import Any, ClassVar, NoReturn
from uuid import uuid4

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.function_trace import line_of

CALL_PREFIX = "called_"  # of the names of these functions, in SymPy's expressions and in machine code
_NO_VALUE = (ArithmeticError, ValueError)  # as of math.sqrt(-1): a formula has a value there that is not finite
_CALLBACK = ctypes.CFUNCTYPE(None, ctypes.POINTER(ctypes.c_double), ctypes.POINTER(ctypes.c_double))
_LOSS = (
    "it is called as a Python function at each stage of each step, about a hundred times slower: without a Jacobian, so no "
    "limit sets, branches, averaging or engine = 'radau', and with steps across its kinks and jumps"
)


class _LastError(threading.local):
    """What a called function raised last in this thread. ends_run: it is more than that there is no value."""

    sentence, ends_run = "", False
    interrupt: KeyboardInterrupt | None = None


_last = _LastError()


def begin_calls() -> None:
    """Forget where functions that were called in this thread had no value."""
    if not _last.ends_run:
        _last.sentence = ""


def call_failed() -> bool:
    """True if a function that was called in this thread raised what ends a run."""
    return _last.ends_run


def reason_of_failure() -> tuple[str, str] | None:
    """What a function that was called in this thread raised last, and a remedy, in words; then it is forgotten.

    None without an error. Raises ``KeyboardInterrupt`` where it was that.
    """
    sentence, interrupt = _last.sentence, _last.interrupt
    _last.sentence, _last.interrupt, _last.ends_run = "", None, False
    if interrupt is not None:
        raise interrupt
    return (sentence, "Correct the function, or start elsewhere") if sentence else None


class PythonCall:
    """A Python function f(t, x, p) of n states. reason: why it has no formulas, at which line, and what to write instead."""

    def __init__(self, function: Callable[..., Any], state_count: int, parameter_count: int, reason: str) -> None:
        self._function, self._count, self.reason = function, state_count, reason
        self._argument_count = 1 + state_count + parameter_count
        title = getattr(function, "__name__", "")
        # Equations are compared by their text, also with those of earlier processes.
        self.name = f"{CALL_PREFIX}{title if title.isidentifier() and title.isascii() else 'function'}_{uuid4().hex}"
        self._callback = _CALLBACK(self._fill)
        names = (f"{self.name}_{i + 1}" for i in range(state_count))
        self.rates = tuple(type(name, (CalledRate,), {"call": self, "place": i}) for i, name in enumerate(names))

    @property
    def address(self) -> int:
        """Where machine code calls it, with the addresses of t, x and p in a row, and of the rates."""
        return ctypes.cast(self._callback, ctypes.c_void_p).value or 0

    def values(self, arguments: Sequence[float]) -> list[float]:
        """Call it with t, x and p in a row. Raises what it raises, and ``WuchtError`` for other than n real numbers."""
        states = 1 + self._count
        output = np.array(self._function(arguments[0], np.array(arguments[1:states]), np.array(arguments[states:])))
        if output.size != self._count or output.dtype.kind not in "fiub":
            raise WuchtError(f"must return a real number for each of {self._count} states", code="count")
        rates: list[float] = output.ravel().tolist()
        return rates

    def column(self, place: int, arguments: Sequence[Any]) -> Any:
        """One of its rates at numbers or arrays. Raises ``WuchtError`` with the line where it fails."""
        arrays = np.broadcast_arrays(*arguments)
        rates = [self._value(place, point) for point in zip(*(a.ravel().tolist() for a in arrays), strict=True)]
        return np.array(rates).reshape(arrays[0].shape) if arrays[0].shape else rates[0]

    def _value(self, place: int, point: Sequence[float]) -> float:
        try:
            return self.values(point)[place]
        except _NO_VALUE:
            return math.nan
        except Exception as error:
            raise WuchtError(self._sentence(error), code="function") from error

    def _fill(self, arguments: Any, results: Any) -> None:
        """Write the rates for machine code, which no error can leave: it is told after the run."""
        rates = [math.nan] * self._count
        try:
            if not _last.ends_run:
                rates = self.values(arguments[: self._argument_count])
        except BaseException as error:  # Ctrl-C too
            _last.sentence, _last.ends_run = self._sentence(error), not isinstance(error, _NO_VALUE)
            _last.interrupt = error if isinstance(error, KeyboardInterrupt) else None
        for i, rate in enumerate(rates):
            results[i] = rate

    def _sentence(self, error: BaseException) -> str:
        title = getattr(self._function, "__name__", "the function")
        if isinstance(error, WuchtError):
            return f"{title} {error}"
        return f"{title} raises {type(error).__name__}: {error}{line_of(self._function, error)}"

    def refusal(self) -> WuchtError:
        """The error where more than its values is needed."""
        return WuchtError(f"this needs the formulas of the equations: {self.reason}", code="not-traced")


class CalledRate(sp.Function):  # type: ignore[misc]
    """A derivative of a state that a Python function returns, of time, states and parameters. A number of numbers."""

    call: ClassVar[PythonCall]
    place: ClassVar[int]

    @classmethod
    def eval(cls, *arguments: sp.Expr) -> sp.Expr | None:
        """A number for numbers."""
        return sp.Float(cls.column(*map(float, arguments))) if all(a.is_number for a in arguments) else None

    @classmethod
    def column(cls, *arguments: Any) -> Any:
        """Its values at numbers or arrays."""
        return cls.call.column(cls.place, arguments)

    def _eval_is_real(self) -> bool:
        return True

    def _eval_derivative(self, symbol: sp.Symbol) -> NoReturn:
        raise self.call.refusal()

    def __reduce_ex__(self, protocol: Any) -> NoReturn:
        raise PicklingError(f"a function without formulas is called in its process alone: {self.call.reason}")


def called_rates(
    function: Callable[..., Any],
    time: sp.Symbol,
    states: Sequence[sp.Symbol],
    parameters: Sequence[sp.Symbol],
    trace_error: WuchtError,
) -> tuple[sp.Expr, ...]:
    """Return the derivatives of the states as calls of a function f(t, x, p), and warn of what is lost.

    trace_error: why it has no formulas; raised where it cannot be called with numbers either.
    """
    call = PythonCall(function, len(states), len(parameters), str(trace_error))
    try:
        with np.errstate(all="ignore"):
            call.column(0, [0.0, *(0.0 for _ in states), *(1.0 for _ in parameters)])
    except WuchtError as error:
        raise WuchtError(f"{trace_error}; called with numbers, {error}", code=trace_error.code) from error.__cause__
    warnings.warn(f"{trace_error}. Until then {_LOSS}", RuntimeWarning, stacklevel=3)
    return tuple(rate(time, *states, *parameters) for rate in call.rates)
