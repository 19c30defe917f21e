"""Views of the states of many members: the speed of the main rotor, the bodies about it, the distance of its axis.

All is computed element by element: the view of a member does not depend on the other members.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass

import numpy as np
import sympy as sp

from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import ArrayFunction
from wucht.numerics.flow.program import lower
from wucht.system import System

_ALL_SAMPLES = slice(None)
_STEP = 1e-4  # of the unit of time: over which the amplitude's change is computed


@dataclass(frozen=True)
class View:
    """The view of M members at K samples. square, rate (K, M): of the distance of the main rotor's axis from its rest position,
    its square and the derivative of that, None where it is costly. speed (k, M), phases (b, k, M): of the main rotor and of the
    bodies about it, as they turn, at k requested samples."""

    speed: np.ndarray
    phases: np.ndarray
    square: np.ndarray
    rate: np.ndarray | None


@dataclass(frozen=True)
class VariantFunction:
    """Expressions with the constants (c, V) of each of V variants, for all members at once."""

    function: ArrayFunction
    constants: np.ndarray

    @classmethod
    def of(cls, system: System, expressions: Sequence[sp.Expr], values: Iterable[Sequence[float]]) -> VariantFunction:
        """Compile expressions in a System's symbols. values: its parameters of each variant."""
        program = lower(system, expressions)
        return cls(ArrayFunction(program), np.array([program.constant_values(v) for v in values]).T)

    def __call__(self, states: Sequence[np.ndarray] | np.ndarray, variant_index: np.ndarray) -> np.ndarray:
        """Return arrays (r, K, M) from states (K, M) each, of members with these variants (M,)."""
        return self.function(states, self.constants if self.constants.shape[1] == 1 else self.constants[:, variant_index])


def member_residual_unbalance(weights: np.ndarray) -> VariantFunction:
    """Return the residual unbalance as a function of the phases of the bodies about the rotor. weights: complex unbalances of
    the rotor and of these bodies (V, 1 + b), of each variant."""
    bodies = range(1, weights.shape[1])
    phases = [sp.Symbol(f"alpha{i}", real=True) for i in bodies]
    parts = [sp.symbols(f"re{i} im{i}", real=True) for i in range(weights.shape[1])]
    (real, imaginary), *other_parts = parts
    for phase, (re, im) in zip(phases, other_parts, strict=True):
        real += re * sp.cos(phase) - im * sp.sin(phase)
        imaginary += re * sp.sin(phase) + im * sp.cos(phase)
    system = System(tuple(phases), (sp.S.Zero,) * len(phases), tuple(p for pair in parts for p in pair))
    return VariantFunction.of(system, [sp.sqrt(real**2 + imaginary**2)], weights.view(float))


@dataclass(frozen=True)
class FullView:
    """View of states of the full equations.

    rows: the row of each state of the machine's System among those integrated; None: the main rotor's angle in the frame that
    turns with it, zero. prescribed_speed: of the main rotor (V,), None: a state. at_rest: the axis' position (m, V). orbit: its
    position and velocity, in turn.
    """

    machine: Machine
    rows: tuple[int | None, ...]
    prescribed_speed: np.ndarray | None
    at_rest: np.ndarray
    orbit: VariantFunction

    def view(self, samples: np.ndarray, variant_index: np.ndarray, ends: slice | np.ndarray = _ALL_SAMPLES) -> View:
        """Return the view of samples (K, n, M) of members with these variants (M,). ends: those with speed and phases."""
        zero = np.zeros(samples[:, 0].shape)
        whole = [zero if i is None else samples[:, i] for i in self.rows]
        machine, row = self.machine, self.machine.row
        rotor, about = machine.rotor.coordinate, machine.group(machine.rotor)[1:]
        phases = np.empty((len(about), *zero[ends].shape))
        for i, body in enumerate(about):
            np.subtract(whole[row(body.coordinate.position)][ends], whole[row(rotor.position)][ends], out=phases[i])
        speed = (
            whole[row(rotor.velocity)][ends]
            if self.prescribed_speed is None
            else self.prescribed_speed[variant_index] + zero[ends]
        )
        values, square, change = self.orbit(whole, variant_index), zero, zero
        for rest, place, velocity in zip(self.at_rest, values[::2], values[1::2], strict=True):
            offset = place - rest[variant_index]
            square = square + offset * offset
            change = change + 2 * offset * velocity
        return View(speed, phases, square, change)


@dataclass(frozen=True)
class SlowView:
    """View of states of the averaged equations. sense: of the main rotor; about: rows of the phases to it. rates: of the
    states; outputs: the main rotor's speed and the amplitude."""

    sense: int
    about: tuple[int, ...]
    rates: VariantFunction
    outputs: VariantFunction

    def rate(self, samples: np.ndarray, variant_index: np.ndarray) -> np.ndarray:
        """Return the rate of a ``View`` at samples (K, k, M) of members with these variants (M,)."""
        states = np.moveaxis(samples, 1, 0)
        rates = self.rates(states, variant_index)
        later, before = (self.outputs(states + way * _STEP * rates, variant_index)[1] for way in (1, -1))
        return np.asarray((later + before) * (later - before) / (2 * _STEP))

    def view(self, samples: np.ndarray, variant_index: np.ndarray, ends: slice | np.ndarray = _ALL_SAMPLES) -> View:
        """Return the view of samples (K, n, M) of members with these variants (M,). ends: those with speed and phases."""
        speed, amplitude = self.outputs(np.moveaxis(samples, 1, 0), variant_index)
        phases = np.empty((len(self.about), *speed[ends].shape))
        for phase, row in zip(phases, self.about, strict=True):
            np.multiply(samples[ends, row], self.sense, out=phase)
        return View(self.sense * speed[ends], phases, amplitude * amplitude, None)
