"""Breakpoints met exactly: a piecewise cubic is one polynomial at a time, whose coefficients change between two steps.

All piecewise functions of one argument share a segmentation: the breakpoints of all of them in order, and the segment in use.
Its ends are events, at which the coefficients are changed and the run continues. So an integrator of any order integrates
smooth functions only, and no step crosses a breakpoint.
"""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol, TypeVar

import numpy as np
import sympy as sp

from wucht.numerics.flow.events import NOT_FINITE, Event, LegError
from wucht.numerics.flow.program import Numbers, PointValues, lower
from wucht.piecewise import Pieces, PiecewiseCubic
from wucht.system import TIME, System

_ENDS = 4
LOOKAHEAD = (1e-9, 1e-5)  # relative to the time: how far ahead where an argument lies on a breakpoint; the second from rest
END_MARGIN = 2e-15  # of the largest number that occurs: smallest distance of a segment's end beyond its argument
ROUNDING = (
    1000 * np.finfo(float).eps
)  # of the largest number that occurs, and of the time: a nearer argument is on its breakpoint

Place = Callable[[float, np.ndarray, Numbers], list[float]]
Result = TypeVar("Result", list[float], tuple[list[float], list[float]])


class Lookahead(Protocol):
    """Values of expressions at a time and state, and a little later; direction -1: a little earlier."""

    def __call__(  # noqa: D102
        self, time: float, state: np.ndarray, parameter_values: Numbers, direction: int = 1
    ) -> tuple[list[float], list[float]]: ...


@dataclass(frozen=True)
class Segmentation:
    """The piecewise functions of one argument.

    symbols: the segment's ends (0 where it has none), flags of their existence (1, 0), then origin and coefficients of each
    function.
    """

    argument: sp.Expr
    functions: tuple[Pieces, ...]
    breakpoints: np.ndarray
    symbols: tuple[sp.Symbol, ...]

    @classmethod
    def of(cls, index: int, argument: sp.Expr, functions: Sequence[Pieces]) -> Segmentation:
        """Create a segmentation with distinct symbols."""
        breakpoints = np.unique(np.concatenate([f.breakpoints for f in functions]))
        names = [f"_segment{index}.{n}" for n in ("low", "high", "has_low", "has_high")]
        for k, f in enumerate(functions):
            names += [f"_segment{index}.{k}.origin", *(f"_segment{index}.{k}.c{d}" for d in range(f.degree + 1))]
        return cls(argument, tuple(functions), breakpoints, tuple(sp.Symbol(n, real=True) for n in names))

    @property
    def polynomial_symbols(self) -> tuple[sp.Symbol, ...]:
        """Those of origins and coefficients."""
        return self.symbols[_ENDS:]

    def polynomials(self) -> list[sp.Expr]:
        """Return each function as the polynomial of the segment in use, in the argument."""
        polynomials, symbols = [], iter(self.polynomial_symbols)
        for f in self.functions:
            origin, *c, value = itertools.islice(symbols, 2 + f.degree)
            for coefficient in reversed(c):
                value = coefficient + (self.argument - origin) * value
            polynomials.append(value)
        return polynomials

    @cached_property
    def scale(self) -> float:
        """Size of the breakpoints."""
        return max(float(np.ptp(self.breakpoints)), float(np.abs(self.breakpoints).max())) or 1.0

    @cached_property
    def _rows(self) -> tuple[tuple[float, ...], ...]:
        """Values of the symbols on each segment: its ends, their flags, and origin and coefficients of each function."""
        lows, highs = np.append(-np.inf, self.breakpoints), np.append(self.breakpoints, np.inf)
        columns = [np.where(np.isfinite(x), x, 0.0) for x in (lows, highs)]
        columns += [np.isfinite(x).astype(float) for x in (lows, highs)]
        for f in self.functions:
            # The piece that holds on a segment is the one that holds at its beginning.
            piece = np.searchsorted(f.breakpoints, lows, side="right")
            columns += [np.array(f.origins)[piece], *np.array(f.coefficients)[piece, : f.degree + 1].T]
        return tuple(map(tuple, np.stack(columns, axis=1).tolist()))

    def locate(self, value: float, ahead: float, size: float) -> int:
        """Return the segment of an argument; on a breakpoint that to which it moves. size: of the numbers in its formula.

        It is on a breakpoint within the rounding of these numbers, or of the time at which it comes there.
        """
        nearest = self.nearest(value)
        near = self._places[nearest]
        rounding = ROUNDING * max(self.scale, size, abs(ahead - value) / LOOKAHEAD[0])
        if abs(value - near) <= rounding and ahead != value:
            return nearest + 1 if ahead > value else nearest
        return bisect_right(self._places, value)

    def nearest(self, value: float) -> int:
        """Return the number of the breakpoint nearest to an argument."""
        above = bisect_right(self._places, value)
        if above in (0, len(self._places)):
            return max(above - 1, 0)
        return above if self._places[above] - value < value - self._places[above - 1] else above - 1

    @cached_property
    def _places(self) -> list[float]:
        """The breakpoints as numbers, which are searched faster than a short array."""
        places: list[float] = self.breakpoints.tolist()
        return places

    def end_functions(self) -> tuple[sp.Expr, sp.Expr]:
        """Return functions that rise through zero at the upper end of the segment, and fall through zero at the lower one.

        They are of order one, so that rounding and cool-downs mean the same for every argument.
        """
        low, high, has_low, has_high = self.symbols[:_ENDS]
        above = has_high * (self.argument - high) / self.scale - (1 - has_high)
        return above, has_low * (self.argument - low) / self.scale + (1 - has_low)

    def polynomial_values(self, index: int) -> list[float]:
        """Return the values of origins and coefficients on a segment."""
        return list(self._rows[index][_ENDS:])

    def segment(self, index: int, value: float | None = None, size: float = 1.0) -> list[float]:
        """Return the values of the symbols on a segment; segment i begins at breakpoint i - 1. value: of the argument.

        An event whose function begins a step at zero, or beyond it, would be missed: so the ends are set a few roundings beyond
        an argument that lies on them.
        """
        low, high, has_low, has_high, *rest = self._rows[index]
        if value is not None:
            behind = END_MARGIN * max(self.scale, size)
            low = min(low, value - behind) if has_low else low
            high = max(high, value + behind) if has_high else high
        return [low, high, has_low, has_high, *rest]


@dataclass(frozen=True)
class Segmentations:
    """All segmentations of a System: the System without piecewise functions, and the events at their breakpoints.

    polynomials: those that replace the piecewise functions.
    """

    segmentations: tuple[Segmentation, ...]
    polynomials: Mapping[sp.Expr, sp.Expr]

    @classmethod
    def of(cls, expressions: Iterable[sp.Expr]) -> Segmentations:
        """Collect the segmentations of all piecewise functions in these expressions, the inner ones first."""
        segmentations: list[Segmentation] = []
        polynomials: dict[sp.Expr, sp.Expr] = {}
        rest = set().union(*(e.atoms(PiecewiseCubic) for e in expressions))
        while rest:
            ready = {p for p in rest if not p.args[0].atoms(PiecewiseCubic) - set(polynomials)}
            arguments = sorted({p.args[0] for p in ready}, key=sp.default_sort_key)
            for argument in arguments:
                group = sorted((p for p in ready if p.args[0] == argument), key=lambda p: (p.args[1].name, hash(p.args[1])))
                segmentation = Segmentation.of(len(segmentations), argument.xreplace(polynomials), [p.args[1] for p in group])
                segmentations.append(segmentation)
                polynomials |= dict(zip(group, segmentation.polynomials(), strict=True))
            rest -= ready
        return cls(tuple(segmentations), polynomials)

    def __bool__(self) -> bool:
        return bool(self.segmentations)

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """Additional parameters, in order."""
        return tuple(s for segmentation in self.segmentations for s in segmentation.symbols)

    def smooth(self, expression: sp.Expr) -> sp.Expr:
        """Replace piecewise functions in an expression by the polynomials of the segments in use."""
        return expression.xreplace(self.polynomials) if self.polynomials else expression

    def smooth_system(self, system: System) -> System:
        """Build the System that is integrated: the symbols of the segments are additional parameters."""
        return System(
            system.states,
            tuple(self.smooth(sp.sympify(e)) for e in system.derivatives),
            (*system.parameters, *self.symbols),
            tuple((s, self.smooth(e)) for s, e in system.definitions),
            angles=system.angles,
        )

    def events(self) -> tuple[Event, ...]:
        """Return two events for each segmentation: the argument leaves its segment upwards, downwards."""
        return tuple(
            Event(f"segmentation {i} {way}", function, direction, switch=(i, direction))
            for i, segmentation in enumerate(self.segmentations)
            for way, direction, function in zip(("up", "down"), (+1, -1), segmentation.end_functions(), strict=True)
        )


@dataclass(frozen=True)
class SegmentLocator:
    """Locator of the segments in use at a time and state. place: values of the arguments. lookahead: these, and a little later.
    state_indices: for each argument, the indices of the states (the time last) from which it is computed."""

    segmentations: tuple[Segmentation, ...]
    place: Place
    lookahead: Lookahead
    state_indices: tuple[tuple[int, ...], ...]

    @classmethod
    def of(cls, segmentations: Segmentations, smooth: System, rates: PointValues | None = None) -> SegmentLocator:
        """Compile the locator from the smooth System. rates: see ``compile_lookahead``."""
        arguments = [s.argument for s in segmentations.segmentations]
        return cls(
            segmentations.segmentations,
            compile_place(smooth, arguments),
            compile_lookahead(smooth, arguments, rates),
            indices_in(arguments, smooth),
        )

    def start(self, time: float, state: np.ndarray, parameter_values: np.ndarray) -> np.ndarray:
        """Return the values of the additional parameters at the start of a run. parameter_values: those of the System."""
        segments, sizes = [0] * len(self.segmentations), self._sizes(time, state)
        for _ in self.segmentations:  # an argument may depend on another one's segment; rates may be infinite on wrong ones
            arguments = self._finite(self.place, time, state, np.concatenate([parameter_values, self._values(segments)]))
            segments = [x.locate(h, h, size) for x, h, size in zip(self.segmentations, arguments, sizes, strict=True)]
        for _ in range(len(self.segmentations) + 1):
            arguments, ahead = self._lookahead(time, state, np.concatenate([parameter_values, self._values(segments)]))
            segments = [x.locate(*at) for x, *at in zip(self.segmentations, arguments, ahead, sizes, strict=True)]
        return self._values(segments, arguments, sizes)

    def values_after_event(
        self, time: float, state: np.ndarray, parameter_values: np.ndarray, values: np.ndarray, event: tuple[int, int] | None
    ) -> np.ndarray:
        """Return the values after an event: the segmentation that reached an end of its segment and the direction, or None.

        Where two arguments reach a breakpoint together only one event may be reported, and an argument that has just passed a
        breakpoint may by rounding lie before it: so the other segments are located from their arguments now and a little later.
        """
        segments = self._segments(values)
        if event is not None:
            segments[event[0]] += event[1]
        arguments, ahead = self._lookahead(time, state, np.concatenate([parameter_values, self._values(segments)]))
        sizes = self._sizes(time, state)
        for i, segmentation in enumerate(self.segmentations):
            if event is None or i != event[0]:
                segments[i] = segmentation.locate(arguments[i], ahead[i], sizes[i])
        return self._values(segments, arguments, sizes)

    def right_values(self, time: float, state: np.ndarray, parameter_values: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the values on the arguments' segments as outputs use them: on the right of each breakpoint."""
        arguments, _ = self._lookahead(time, state, np.concatenate([parameter_values, values]))
        return self._values(
            [int(np.searchsorted(x.breakpoints, h, side="right")) for x, h in zip(self.segmentations, arguments, strict=True)]
        )

    def lowest_arguments(self, lowest: np.ndarray, values: np.ndarray) -> np.ndarray:
        """Return the lowest value of each argument in a leg; infinite on segments without an upper end.

        lowest: of the event functions, of which those at the ends of the segments are the last. values: of the additional
        parameters.
        """
        upper = lowest[-2 * len(self.segmentations) :: 2]
        highs, has_high = values[self._starts + 1], values[self._starts + 3]
        return np.where(has_high > 0, upper * self._scales + highs, np.inf)

    @cached_property
    def _starts(self) -> np.ndarray:
        """The place of the first additional parameter of each segmentation."""
        return np.cumsum([0, *(len(x.symbols) for x in self.segmentations[:-1])])

    @cached_property
    def _scales(self) -> np.ndarray:
        return np.array([x.scale for x in self.segmentations])

    def _lookahead(self, time: float, state: np.ndarray, parameter_values: np.ndarray) -> tuple[list[float], list[float]]:
        return self._finite(self.lookahead, time, state, parameter_values)

    @staticmethod
    def _finite(function: Callable[..., Result], time: float, state: np.ndarray, parameter_values: np.ndarray) -> Result:
        try:
            result = function(time, state, parameter_values)
        except (OverflowError, ValueError, ZeroDivisionError):
            raise LegError(*NOT_FINITE, np.empty((len(state), 0))) from None
        if not np.isfinite(result).all():
            raise LegError(*NOT_FINITE, np.empty((len(state), 0)))
        return result

    def _sizes(self, time: float, state: np.ndarray) -> list[float]:
        """Return the largest number from which each argument is computed: its rounding is a few units of that."""
        values = np.append(np.abs(state), abs(time))
        return [float(values[list(index)].max(initial=0.0)) for index in self.state_indices]

    def _values(
        self, segments: Sequence[int], arguments: Sequence[float] | None = None, sizes: Sequence[float] | None = None
    ) -> np.ndarray:
        at, n = arguments or itertools.repeat(None), sizes or itertools.repeat(1.0)
        blocks = (x.segment(r, h, size) for x, r, h, size in zip(self.segmentations, segments, at, n, strict=False))
        return np.array([v for segment in blocks for v in segment])

    def _segments(self, values: np.ndarray) -> list[int]:
        segments, at, numbers = [], 0, values.tolist()
        for segmentation in self.segmentations:
            low, has_low = numbers[at], numbers[at + 2]
            segments.append(segmentation.nearest(low) + 1 if has_low else 0)
            at += len(segmentation.symbols)
        return segments


def indices_in(expressions: Sequence[sp.Expr], system: System) -> tuple[tuple[int, ...], ...]:
    """Return, for each expression, the indices of the states (the time last) from which it is computed."""
    explicit, numbers = [system.explicit(e) for e in expressions], (*system.states, TIME)
    return tuple(tuple(i for i, s in enumerate(numbers) if s in e.free_symbols) for e in explicit)


def compile_place(smooth: System, expressions: Sequence[sp.Expr]) -> Place:
    """Compile a function of time, state and parameters that returns the values of expressions."""
    position = lower(smooth, expressions)
    evaluate = position.at_point()
    return lambda time, state, parameters: list(evaluate(state, time, position.constant_values(parameters)))


def compile_lookahead(smooth: System, expressions: Sequence[sp.Expr], rates: PointValues | None = None) -> Lookahead:
    """Compile a function of time, state and parameters that returns the values of expressions, now and a little later.

    rates: those of the System, if they are compiled.
    """
    position, program = lower(smooth, expressions), lower(smooth, smooth.derivatives)
    evaluate, rate = position.at_point(), rates or program.at_point()

    def lookahead(
        time: float, state: np.ndarray, parameter_values: Numbers, direction: int = 1
    ) -> tuple[list[float], list[float]]:
        position_constants, rate_constants = (p.constant_values(parameter_values) for p in (position, program))
        values = list(evaluate(state, time, position_constants))
        ahead = list(values)
        for step in (direction * s * max(1.0, abs(time)) for s in LOOKAHEAD):
            half = state + step / 2 * np.array(rate(state, time, rate_constants))
            then = state + step * np.array(rate(half, time + step / 2, rate_constants))
            later = evaluate(then, time + step, position_constants)
            ahead = [f if a == h else a for a, h, f in zip(ahead, values, later, strict=True)]
        return values, ahead

    return lookahead
