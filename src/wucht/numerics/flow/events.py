"""What can happen during a run: a function of state and time goes through zero."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.errors import RunError

Action = Callable[[float, np.ndarray, np.ndarray], tuple[np.ndarray, np.ndarray]]


@dataclass(frozen=True)
class Event:
    """An event happens where ``expression`` (in the System's states, parameters and time) goes through zero.

    direction: +1 rising, -1 falling, 0 both. terminal: the run stops there. action: called with time, state and parameters
    (copies), returns the state and parameters with which the run continues (a body is released). switch: at a breakpoint, the
    number of the segmentation and the direction; such events are not reported as hits.
    """

    name: str
    expression: sp.Expr
    direction: int = 0
    terminal: bool = False
    action: Action | None = None
    switch: tuple[int, int] | None = None

    @property
    def interrupts(self) -> bool:
        """Whether the integrator must stop at the event."""
        return self.terminal or self.action is not None or self.switch is not None


@dataclass(frozen=True)
class Hit:
    """An event that happened: its name, the exact time and the state (n,) just before any action."""

    name: str
    time: float
    state: np.ndarray


@dataclass(frozen=True)
class Leg:
    """What an engine returns of one leg: samples up to the end or the interrupting event, whichever came first."""

    states: np.ndarray
    time: float
    state: np.ndarray
    hits: tuple[Hit, ...]
    stopped_by: int | None


class LegError(RunError):
    """An engine could not go on. ``samples`` (n, m) are those it still reached; ``remedy`` is what to try."""

    def __init__(self, reason: str, samples: np.ndarray, remedy: str) -> None:
        super().__init__(reason)
        self.samples, self.remedy = samples, remedy
