"""Corners taken exactly: a piecewise cubic becomes one polynomial whose coefficients change, at a corner, between two steps.

All piecewise functions of one argument share a ladder: the corners of all of them in order, and the rung that is in use. Its
ends are watched as events; there the coefficients are changed and the run goes on. So an integrator of any order sees smooth
functions only, and a step is never taken across a corner.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.numerics.events import Event, LegError
from wucht.numerics.program import Numbers, lower, python_function
from wucht.piecewise import Pieces, PiecewiseCubic
from wucht.system import TIME, System

_ENDS = 4
_SOON = (1e-9, 1e-5)  # relative to the time: how far to look ahead where an argument lies on a corner; the second from rest
BEHIND = 2e-15  # of the largest number that occurs: how far beyond its argument a rung's end is watched at least
ROUNDING = 1000 * np.finfo(float).eps  # of the largest number that occurs: so near an argument is on its corner

Look = Callable[[float, np.ndarray, Numbers], tuple[list[float], list[float]]]


@dataclass(frozen=True)
class Ladder:
    """The piecewise functions of one argument.

    symbols: the rung's ends (0 where it has none) and whether it has them (1, 0), then of each function its origin and
    coefficients.
    """

    argument: sp.Expr
    functions: tuple[Pieces, ...]
    corners: np.ndarray
    symbols: tuple[sp.Symbol, ...]

    @classmethod
    def of(cls, index: int, argument: sp.Expr, functions: Iterable[Pieces]) -> Ladder:
        """A ladder with symbols of its own."""
        listed = tuple(functions)
        corners = np.unique(np.concatenate([f.corners for f in listed]))
        names = [f"_ladder{index}.{n}" for n in ("low", "high", "has_low", "has_high")]
        for k, f in enumerate(listed):
            names += [f"_ladder{index}.{k}.origin", *(f"_ladder{index}.{k}.c{d}" for d in range(f.degree + 1))]
        return cls(argument, listed, corners, tuple(sp.Symbol(n, real=True) for n in names))

    def polynomials(self) -> list[sp.Expr]:
        """Each function as the polynomial of the rung in use, in the argument."""
        found, at = [], _ENDS
        for f in self.functions:
            origin, *c = self.symbols[at : at + 2 + f.degree]
            value: sp.Expr = sp.S.Zero
            for coefficient in reversed(c):
                value = coefficient + (self.argument - origin) * value if value != 0 else coefficient
            found.append(value)
            at += 2 + f.degree
        return found

    def ends(self, index: int) -> tuple[float, float]:
        """Where a rung begins and ends, infinite for the first and the last."""
        low = self.corners[index - 1] if index > 0 else -np.inf
        return float(low), float(self.corners[index]) if index < len(self.corners) else np.inf

    @property
    def scale(self) -> float:
        """The size of the corners."""
        return max(float(np.ptp(self.corners)), float(np.abs(self.corners).max())) or 1.0

    def place(self, here: float, ahead: float, size: float) -> int:
        """The rung of an argument; of one on a corner that to which it moves. size: of the numbers it is computed from."""
        near = float(self.corners[np.abs(self.corners - here).argmin()])
        if abs(here - near) <= ROUNDING * max(self.scale, size) and ahead != here:
            return int(np.searchsorted(self.corners, near, side="right" if ahead > here else "left"))
        return int(np.searchsorted(self.corners, here, side="right"))

    def watched(self) -> tuple[sp.Expr, sp.Expr]:
        """What rises through zero at the upper end of the rung, and falls through zero at the lower one.

        heyoka's steps are accurate relative to the largest of all states and watched functions: so these stay of order one.
        """
        low, high, has_low, has_high = self.symbols[:_ENDS]
        scale = self.scale
        return has_high * (self.argument - high) / scale - (1 - has_high), has_low * (self.argument - low) / scale + (
            1 - has_low
        )

    def rung(self, index: int, here: float | None = None, size: float = 1.0) -> list[float]:
        """The values of the symbols on a rung; rung i begins at corner i - 1. here: where the argument is.

        heyoka does not see an event whose function begins a step at exactly zero and passes zero again in that step, nor one
        that begins beyond it: so the ends are watched a few roundings beyond an argument that lies on them.
        """
        low, high = self.ends(index)
        behind = BEHIND * max(self.scale, size)
        bottom = low if here is None else min(low, here - behind)
        top = high if here is None else max(high, here + behind)
        values = [bottom if np.isfinite(low) else 0.0, top if np.isfinite(high) else 0.0]
        values += [float(np.isfinite(low)), float(np.isfinite(high))]
        for f in self.functions:
            # The piece that holds on a rung is the one that holds at its beginning.
            piece = int(np.searchsorted(f.corners, low, side="right"))
            values += [f.origins[piece], *f.coefficients[piece][: f.degree + 1]]
        return values


class Ladders:
    """All ladders of a System: the System without piecewise functions, the events at their corners, and which rung holds."""

    def __init__(self, ladders: Sequence[Ladder], polynomials: dict[sp.Expr, sp.Expr]) -> None:
        self.ladders, self._polynomials = tuple(ladders), polynomials
        self._look: Look | None = None
        self._used: list[list[int]] = []

    @classmethod
    def of(cls, expressions: Iterable[sp.Expr]) -> Ladders:
        """The ladders of all piecewise functions in these expressions, the inner ones first."""
        ladders: list[Ladder] = []
        polynomials: dict[sp.Expr, sp.Expr] = {}
        rest = set().union(*(e.atoms(PiecewiseCubic) for e in expressions))
        while rest:
            ready = {p for p in rest if not p.args[0].atoms(PiecewiseCubic) - set(polynomials)}
            arguments = sorted({p.args[0] for p in ready}, key=sp.default_sort_key)
            for argument in arguments:
                mine = sorted((p for p in ready if p.args[0] == argument), key=lambda p: (p.args[1].name, hash(p.args[1])))
                ladder = Ladder.of(len(ladders), argument.xreplace(polynomials), [p.args[1] for p in mine])
                ladders.append(ladder)
                polynomials |= dict(zip(mine, ladder.polynomials(), strict=True))
            rest -= ready
        return cls(ladders, polynomials)

    def __bool__(self) -> bool:
        return bool(self.ladders)

    @property
    def symbols(self) -> tuple[sp.Symbol, ...]:
        """The additional parameters, in order."""
        return tuple(s for ladder in self.ladders for s in ladder.symbols)

    def smooth(self, expression: sp.Expr) -> sp.Expr:
        """An expression with the polynomials of the rungs in use."""
        return expression.xreplace(self._polynomials) if self._polynomials else expression

    def events(self) -> tuple[Event, ...]:
        """Two events a ladder: the argument leaves its rung upwards, downwards."""
        found = []
        for i, ladder in enumerate(self.ladders):
            above, below = ladder.watched()
            found.append(Event(f"ladder {i} up", above, +1, switch=(i, +1)))
            found.append(Event(f"ladder {i} down", below, -1, switch=(i, -1)))
        return tuple(found)

    def prepare(self, smooth: System) -> None:
        """Compile what tells where the arguments are, and where they go, from the smooth System."""
        arguments = [ladder.argument for ladder in self.ladders]
        self._look, numbers = looking(smooth, arguments), (*smooth.states, TIME)
        for argument in map(smooth.explicit, arguments):
            self._used.append([i for i, s in enumerate(numbers) if s in argument.free_symbols])

    def start(self, time: float, state: np.ndarray, parameters: np.ndarray) -> np.ndarray:
        """The values of the additional parameters at the beginning of a run. parameters: the System's own."""
        rungs = [0] * len(self.ladders)
        for _ in range(len(self.ladders) + 1):  # an argument may depend on another ladder's rung
            values = self._values(rungs)
            here, ahead = self._looked(time, state, np.concatenate([parameters, values]))
            sizes = self._sizes(time, state)
            rungs = [ladder.place(h, a, n) for ladder, h, a, n in zip(self.ladders, here, ahead, sizes, strict=True)]
        return self._values(rungs, here, sizes)

    def moved(
        self, time: float, state: np.ndarray, parameters: np.ndarray, values: np.ndarray, fired: tuple[int, int] | None
    ) -> np.ndarray:
        """The values after an event. fired: the ladder that reached an end of its rung and the direction, if one did.

        Where two arguments reach a corner together only one event may be told, and an argument that has just passed its corner
        may by rounding lie before it: so every other ladder is placed by where its argument is and where it goes.
        """
        rungs = self._rungs(values)
        if fired is not None:
            rungs[fired[0]] += fired[1]
        here, ahead = self._looked(time, state, np.concatenate([parameters, self._values(rungs)]))
        sizes = self._sizes(time, state)
        for i, ladder in enumerate(self.ladders):
            if fired is None or i != fired[0]:
                rungs[i] = ladder.place(here[i], ahead[i], sizes[i])
        return self._values(rungs, here, sizes)

    def seen(self, time: float, state: np.ndarray, parameters: np.ndarray, values: np.ndarray) -> np.ndarray:
        """The values on the rungs on which the arguments are, as outputs see them: from the right of each corner."""
        here, _ = self._looked(time, state, np.concatenate([parameters, values]))
        return self._values([int(np.searchsorted(x.corners, h, side="right")) for x, h in zip(self.ladders, here, strict=True)])

    def _looked(self, time: float, state: np.ndarray, parameters: np.ndarray) -> tuple[list[float], list[float]]:
        assert self._look is not None
        try:
            return self._look(time, state, parameters)
        except (OverflowError, ValueError, ZeroDivisionError):
            nothing = np.empty((len(state), 0))
            remedy = "Look for a parameter that is off by a factor of thousands"
            raise LegError("the state ceases to be finite", nothing, remedy) from None

    def _sizes(self, time: float, state: np.ndarray) -> list[float]:
        """The largest number from which each argument is computed: its rounding is a few units of that."""
        values = np.append(np.abs(state), abs(time))
        return [float(values[index].max(initial=0.0)) for index in self._used]

    def _values(
        self, rungs: Sequence[int], here: Sequence[float] | None = None, sizes: Sequence[float] | None = None
    ) -> np.ndarray:
        at: Sequence[float | None] = here if here is not None else [None] * len(rungs)
        n = sizes if sizes is not None else [1.0] * len(rungs)
        found = (x.rung(r, h, size) for x, r, h, size in zip(self.ladders, rungs, at, n, strict=True))
        return np.array([v for rung in found for v in rung])

    def _rungs(self, values: np.ndarray) -> list[int]:
        found, at = [], 0
        for ladder in self.ladders:
            low, _, has_low, _ = values[at : at + _ENDS]
            found.append(int(np.abs(ladder.corners - low).argmin()) + 1 if has_low else 0)
            at += len(ladder.symbols)
        return found


def looking(smooth: System, expressions: Sequence[sp.Expr]) -> Look:
    """A function of time, state and parameters: the values of expressions here, and a little ahead of here."""
    position, rates = lower(smooth, expressions), lower(smooth, smooth.derivatives)
    where, rate = (
        python_function((p.states, TIME, tuple(s for s, _ in p.constants)), p.lines, p.results, "math")
        for p in (position, rates)
    )

    def look(time: float, state: np.ndarray, parameters: Numbers) -> tuple[list[float], list[float]]:
        fixed, moving = position.constant_values(parameters).tolist(), rates.constant_values(parameters).tolist()
        here = list(where(state.tolist(), time, fixed))
        ahead = list(here)
        for step in (s * max(1.0, abs(time)) for s in _SOON):
            half = state + step / 2 * np.array(rate(state.tolist(), time, moving))
            then = state + step * np.array(rate(half.tolist(), time + step / 2, moving))
            found = where(then.tolist(), time + step, fixed)
            ahead = [f if a == h else a for a, h, f in zip(ahead, here, found, strict=True)]
        return here, ahead

    return look
