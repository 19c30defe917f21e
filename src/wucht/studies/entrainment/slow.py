"""Constant phases of the slow equations at a value of a parameter, and their stability.

001 (22)-(24) for a rotor on a vibrating axis, (37)-(40) for exciters on a common carrier, here for any number of them: found by
Newton's method from many starts at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping
from dataclasses import replace
from functools import cached_property

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.slow import SlowMachine, slow_machine
from wucht.machines.vibration import free_speed, operating_speed
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.orbits import variational
from wucht.studies.entrainment.along import Along
from wucht.system import System

_SMALL = 1e-11  # of what is left open, each equation by its own size
_SAME = 1e-5  # of two equilibria that are one
_STABLE = 1e-9  # of the fastest rate: growth below this is rounding


class Slow:
    """The slow equations of a machine along a parameter. senses: of all bodies in the motion that is looked at.

    States are the phases in rad, then the speeds. Raises ``InputError`` where the machine has no slow equations.
    """

    def __init__(self, machine: Machine, along: Along, senses: Mapping[str, float], limits: tuple[float, float]) -> None:
        self.machine, self.along, self.limits = machine, along, limits
        self.slow = slow_machine(machine, turning={name: int(sense) for name, sense in senses.items()})
        system = self.slow.system
        self.names = system.state_names
        self.n = len(self.names)
        self.phases = np.array([n.endswith(".phase") for n in self.names])
        both = variational(_bare(self.slow))
        self._evaluate = Evaluator.of_rates(both)
        self.width = limits[1] - limits[0]
        self.pace = machine.values.get("carrier.motion.frequency") or operating_speed(machine)
        self.sizes = np.where(self.phases, 1.0, self.pace)
        # The parameter's size is that of the machine's own value, or the pace of speeds: limits may lie far beyond any band.
        self.unit = min(self.width, max(abs(along.own), *map(abs, along.middles)) or self.width)

    def pars(self, value: float) -> tuple[float, ...]:
        """The System's parameters."""
        return self.slow.system.values(self.machine.values | self.along.values(value))

    def rates(self, states: np.ndarray, value: float) -> tuple[np.ndarray, np.ndarray]:
        """dx/dt (n, N) at states (n, N), each by its size, and their derivatives (N, n, n) by the states in their sizes."""
        n, count = states.shape
        directions = np.tile(np.diag(self.sizes), (1, count))
        found = self._evaluate(np.zeros(n * count), np.vstack([np.repeat(states, n, axis=1), directions]), self.pars(value))
        rows = np.array(list(found.values()))
        scale = self.pace * self.sizes[:, None]
        rate = rows[:n, ::n] / scale
        jacobian = (rows[n:] / scale).reshape(n, count, n).transpose(1, 0, 2)
        return rate, jacobian

    def eigenvalues(self, state: np.ndarray, value: float) -> np.ndarray:
        """Of the linearised slow equations (n,), in 1/time."""
        _, jacobian = self.rates(state[:, None], value)
        found: np.ndarray = np.linalg.eigvals(jacobian[0]) * self.pace
        return found

    def stable(self, state: np.ndarray, value: float) -> bool:
        """Whether all disturbances decay."""
        found = self.eigenvalues(state, value)
        return bool(found.real.max() < -_STABLE * np.abs(found).max())

    def equilibria(self, value: float, more: np.ndarray | None = None) -> list[np.ndarray]:
        """Those found from many starts, and from the states ``more`` (n, N)."""
        x = self.starts() if more is None else np.hstack([more, self.starts()])
        with np.errstate(all="ignore"):
            for _ in range(40):
                rate, jacobian = self.rates(x, value)
                good = np.isfinite(rate).all(axis=0) & np.isfinite(jacobian).all(axis=(1, 2))
                x, rate, jacobian = x[:, good], rate[:, good], jacobian[good]
                regular = jacobian + 1e-14 * np.eye(self.n)
                step = np.linalg.solve(regular, -rate.T[..., None])[..., 0].T
                step *= np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=0), 1e-300))
                x = x + step * self.sizes[:, None]
            rate, _ = self.rates(x, value)
        found: list[np.ndarray] = []
        for k in np.flatnonzero(np.abs(rate).max(axis=0) < _SMALL) if x.size else ():
            state = self.wrapped(x[:, k])
            if (state[~self.phases] > 0).all() and not any(self.distance(state, other) < _SAME for other in found):
                found.append(state)
        return found

    def wrapped(self, state: np.ndarray) -> np.ndarray:
        """The state with phases in (-pi, pi]."""
        found: np.ndarray = np.where(self.phases, math.pi - np.remainder(math.pi - state, 2 * math.pi), state)
        return found

    def distance(self, one: np.ndarray, other: np.ndarray) -> float:
        """Between two states, in their sizes, turns of phases aside."""
        away = (one - other) / self.sizes
        away = np.where(self.phases, np.abs(np.remainder(away + math.pi, 2 * math.pi) - math.pi), np.abs(away))
        return float(away.max())

    def starts(self) -> np.ndarray:
        """Phases all around the circle, all rotors at one speed: that of the vibration, or of any motor and below."""
        k, m = int(self.phases.sum()), self.machine
        if k <= 2:
            around = np.arange(12 if k == 1 else 8) / (12 if k == 1 else 8) * 2 * math.pi + 0.1
            grid = np.array(list(itertools.product(around, repeat=k)))
        else:
            root = 2 ** (-1 / np.arange(1, k + 1))  # an additive recurrence fills the cube of phases evenly
            grid = np.remainder(np.outer(np.arange(1, 65), root), 1.0) * 2 * math.pi
        if m.shaken is not None:
            speeds = np.array([self.pace])
        else:
            free = [abs(f) for f in (free_speed(m, r) for r in m.rotors) if f]
            high = max(free, default=self.pace)
            speeds = np.append(np.linspace(0.3, 1.1, 9) * high, np.mean(free or [high]))
        found = [np.concatenate([np.tile(g, (len(speeds), 1)).T, np.tile(speeds, (self.n - k, 1))]) for g in grid]
        return np.hstack(found)

    @cached_property
    def phase_names(self) -> list[str]:
        """The bodies that have a phase."""
        return [n.removesuffix(".phase") for n in self.names if n.endswith(".phase")]

    def speed(self, states: np.ndarray) -> np.ndarray:
        """The common speed (N,) in the main rotor's sense: of the vibration, or of the main rotor."""
        name = f"{self.machine.rotor.name}.speed"
        if name in self.names:
            found: np.ndarray = states[self.names.index(name)]
            return found
        return np.full(states.shape[1], self.pace)


def _bare(slow: SlowMachine) -> System:
    return replace(slow.system, outputs=(), quadratures=())
