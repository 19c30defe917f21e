"""How the states of many members are seen: the speed of the main rotor, the bodies about it, the distance of its axis.

All is computed element by element: what is seen of a member does not depend on those beside it.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.flow.program import Evaluator

_STEP = 1e-4  # of the unit of time: over which the amplitude's change is taken


@dataclass(frozen=True)
class View:
    """Samples (K, M) of M members. speed: of the main rotor. phases: of the bodies about it (b, K, M), as they turn. square,
    rate: of the distance of its axis from where it rests, its square and the derivative of that."""

    speed: np.ndarray
    phases: np.ndarray
    square: np.ndarray
    rate: np.ndarray


@dataclass(frozen=True)
class Bound:
    """Expressions with the constants (c, V) of each of V variants: evaluated for all members at once, element by element, so
    that what comes of one does not depend on those beside it."""

    evaluator: Evaluator
    constants: np.ndarray

    @classmethod
    def of(cls, evaluator: Evaluator, values: Iterable[Sequence[float]]) -> Bound:
        """values: the System's parameters of each variant."""
        return cls(evaluator, np.array([evaluator.program.constant_values(v) for v in values]).T)

    def __call__(self, states: Sequence[np.ndarray], of: np.ndarray) -> list[np.ndarray]:
        """Arrays (K, M) of states (K, M) each, of members of these variants (M,)."""
        one = self.constants.shape[1] == 1
        constants = self.constants[:, 0] if one else self.constants[:, of]
        values = self._function(tuple(states), 0.0, constants)
        return [np.broadcast_to(np.asarray(v, float), states[0].shape) for v in values]

    @cached_property
    def _function(self) -> Callable[..., Sequence[np.ndarray]]:
        return self.evaluator.program.function()


@dataclass(frozen=True)
class FullView:
    """How states of the full equations are seen.

    rows: where each state of the machine's System is among those integrated; None: the main rotor's angle in its own frame,
    zero. prescribed: the main rotor's speed (V,), None: a state. at_rest: of the axis (m, V). orbit: its place and velocity, in
    turn.
    """

    machine: Machine
    rows: tuple[int | None, ...]
    prescribed: np.ndarray | None
    at_rest: np.ndarray
    orbit: Bound

    def seen(self, samples: np.ndarray, of: np.ndarray) -> View:
        """Samples (K, k, M) of members of these variants (M,)."""
        zero = np.zeros(samples[:, 0].shape)
        whole = [zero if i is None else samples[:, i] for i in self.rows]
        machine, row = self.machine, self.machine.row
        rotor, about = machine.rotor.coordinate, machine.group(machine.rotor)[1:]
        phases = np.empty((len(about), *zero.shape))
        for i, body in enumerate(about):
            phases[i] = whole[row(body.coordinate.position)] - whole[row(rotor.position)]
        speed = whole[row(rotor.velocity)] if self.prescribed is None else self.prescribed[of] + zero
        values, square, change = self.orbit(whole, of), zero, zero
        for rest, place, velocity in zip(self.at_rest, values[::2], values[1::2], strict=True):
            offset = place - rest[of]
            square = square + offset * offset
            change = change + 2 * offset * velocity
        return View(speed, phases, square, change)


@dataclass(frozen=True)
class SlowView:
    """How states of the averaged equations are seen. sense: of the main rotor; about: rows of the phases to it. rates: of the
    states; outputs: the main rotor's speed and the amplitude."""

    sense: int
    about: tuple[int, ...]
    rates: Bound
    outputs: Bound

    def seen(self, samples: np.ndarray, of: np.ndarray) -> View:
        """Samples (K, k, M) of members of these variants (M,)."""
        states = [samples[:, i] for i in range(samples.shape[1])]
        speed, amplitude = self.outputs(states, of)
        rates = self.rates(states, of)
        later, before = (
            self.outputs([x + way * _STEP * r for x, r in zip(states, rates, strict=True)], of)[1] for way in (1, -1)
        )
        change = amplitude * (later - before) / _STEP
        phases = self.sense * np.moveaxis(samples[:, list(self.about)], 1, 0)
        return View(self.sense * speed, phases, amplitude * amplitude, change)
