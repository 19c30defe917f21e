"""Events during a run: a function of state and time passes zero."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.errors import RunError

NOT_FINITE = ("the state ceases to be finite", "Look for a parameter that is off by a factor of thousands")
Action = Callable[[float, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Event:
    """Event of a run: an expression passes zero.

    Parameters
    ----------
    name : str
        By which its hits, and a run that it stops, are labelled.
    expression : sympy.Expr
        In the System's states, parameters, definitions and time.
    direction : {0, 1, -1}
        +1 rising, -1 falling, 0 both.
    terminal : bool
        True if the run stops there.
    action : callable, optional
        Called with time, state (n,) and parameters (copies); returns the state and parameters with which the run continues (a
        body is released).
    switch : tuple of int, optional
        At a breakpoint: the number of the segmentation and the direction. Such events are not reported as hits.
    """

    name: str
    expression: sp.Expr
    direction: int = 0
    terminal: bool = False
    action: Action | None = None
    switch: tuple[int, int] | None = None

    @property
    def interrupts(self) -> bool:
        """True if the integrator must stop at the event."""
        return self.terminal or self.action is not None or self.switch is not None


@dataclass(frozen=True)
class Hit:
    """An occurrence of an event.

    Attributes
    ----------
    name : str
        The event's name.
    time : float
        To the accuracy of the integration.
    state : ndarray, (n,)
        Just before any action.
    """

    name: str
    time: float
    state: np.ndarray


@dataclass(frozen=True)
class LegResult:
    """Result of one leg: samples up to the end or the interrupting event, whichever came first.

    segments: values of the additional parameters at its end, lowest_arguments: see ``Trajectory``; None from an integrator that
    neither changes nor observes them.
    """

    states: np.ndarray
    time: float
    state: np.ndarray
    hits: tuple[Hit, ...]
    stopped_by: int | None
    segments: np.ndarray | None = None
    lowest_arguments: np.ndarray | None = None


class LegError(RunError):
    """Error of an integrator that could not continue. ``samples`` (n, m): those before; ``remedy``: a sentence with advice.

    step: the mean step size, where the number of steps was exhausted.
    """

    def __init__(self, reason: str, remedy: str, samples: np.ndarray, step: float | None = None) -> None:
        super().__init__(reason)
        self.samples, self.remedy, self.step = samples, remedy, step

    def __reduce__(self) -> tuple[type[LegError], tuple[str, str, np.ndarray, float | None]]:
        """Support pickling, so that the error can be raised in another process."""
        return LegError, (str(self), self.remedy, self.samples, self.step)

    def sentence(self, time: float, names: Sequence[str], state: np.ndarray) -> str:
        """Compose the sentence for the user. time: reached; state (n,): sampled last, its numbers by these names."""
        largest = sorted(zip(names, state, strict=False), key=lambda p: -abs(p[1]))[:4]
        listing = ", ".join(f"{name} = {value:.4g}" for name, value in largest)
        return f"the integration failed at t = {time:.6g}: {self} (largest states of the last sample: {listing}). {self.remedy}"


class SlidingError(LegError):
    """Error of a motion that slides along a jump of the equations, which have no solution beyond."""

    def __init__(self, samples: np.ndarray) -> None:
        reason = "the motion slides along a jump of the equations, which switch to and fro there while time stands still"
        super().__init__(reason, "Replace sign(v) by a steep tanh(v/0.001)", samples)

    def __reduce__(self) -> tuple[type[SlidingError], tuple[np.ndarray]]:  # type: ignore[override]
        """Support pickling, so that the error can be raised in another process."""
        return SlidingError, (self.samples,)
