"""Breakpoints met exactly: a piecewise cubic is one polynomial at a time, whose coefficients change between two steps.

All piecewise functions of one argument share a segmentation: the breakpoints of all of them in order, and the segment in use.
Its ends are events, at which the coefficients are changed and the run continues. So an integrator of any order integrates
smooth functions only, and no step crosses a breakpoint.
"""

from __future__ import annotations

import itertools
from bisect import bisect_right
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.numerics.flow.compiled.segment_changes import AHEAD, END_MARGIN, ROUNDING
from wucht.numerics.flow.events import Event
from wucht.piecewise import Pieces, PiecewiseCubic
from wucht.system import TIME, System

_ENDS = 4


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
    def rows(self) -> np.ndarray:
        """Values of the symbols on each segment (k + 1, s): its ends, their flags, and origin and coefficients of functions."""
        lows, highs = np.append(-np.inf, self.breakpoints), np.append(self.breakpoints, np.inf)
        columns = [np.where(np.isfinite(x), x, 0.0) for x in (lows, highs)]
        columns += [np.isfinite(x).astype(float) for x in (lows, highs)]
        for f in self.functions:
            # The piece that holds on a segment is the one that holds at its beginning.
            piece = np.searchsorted(f.breakpoints, lows, side="right")
            columns += [np.array(f.origins)[piece], *np.array(f.coefficients)[piece, : f.degree + 1].T]
        return np.stack(columns, axis=1)

    @cached_property
    def _numbers(self) -> list[list[float]]:
        """The rows as numbers, which are read faster than a short array."""
        numbers: list[list[float]] = self.rows.tolist()
        return numbers

    def locate(self, value: float, ahead: float, size: float) -> int:
        """Return the segment of an argument; on a breakpoint that to which it moves. size: of the numbers in its formula.

        It is on a breakpoint within the rounding of these numbers, or of the time at which it comes there.
        """
        nearest = self.nearest(value)
        near = self._places[nearest]
        rounding = ROUNDING * max(self.scale, size, abs(ahead - value) / AHEAD)
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
        return list(self._numbers[index][_ENDS:])

    def segment(self, index: int, value: float | None = None, size: float = 1.0) -> list[float]:
        """Return the values of the symbols on a segment; segment i begins at breakpoint i - 1. value: of the argument.

        An event whose function begins a step at zero, or beyond it, would be missed: so the ends are set a few roundings beyond
        an argument that lies on them.
        """
        low, high, has_low, has_high, *rest = self._numbers[index]
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


def indices_in(expressions: Sequence[sp.Expr], system: System) -> tuple[tuple[int, ...], ...]:
    """Return, for each expression, the indices of the states (the time last) from which it is computed."""
    explicit, numbers = [system.explicit(e) for e in expressions], (*system.states, TIME)
    return tuple(tuple(i for i, s in enumerate(numbers) if s in e.free_symbols) for e in explicit)
