"""Steady phases in the averaged equations at a value of a parameter, and their stability.

001 (22)-(24) for a rotor on a vibrating axis, (37)-(40) for exciters on a common carrier, here for any number of them: solved
by Newton's method from many starts at once.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Mapping

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import averaged_equations_of
from wucht.dynamics.entrainment.entrainment_case import SweptParameter
from wucht.dynamics.run_ups.initial_state import angles_in
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, operating_speed
from wucht.numerics.angles import wrap_to_pi
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.system import System

_NEWTON_STEPS, _FAR_STEPS = 40, 60
_LONGEST_STEP = 0.5  # of Newton's method, in the states' sizes
_REGULAR = 1e-14  # added to the Jacobian, so that a singular one does not end the search from other starts
_SMALL = 1e-11  # of the residual, each equation scaled by its size
_SAME = 1e-5  # of two equilibria that are the same
_STABLE = 1e-9  # of the fastest rate: growth below this is rounding


class EntrainmentEquations:
    """Averaged equations of a machine along a parameter, within limits of it. Immutable after its construction.

    States (n) are the phases in rad, then the speeds; phases (n,): mask of the phases; phase_rows: index of a body's phase.
    pace, sizes (n,), unit: scales of speeds, of the states and of the parameter. equations: as they are followed.
    """

    def __init__(
        self, machine: Machine, parameter: SweptParameter, senses: Mapping[str, float], limits: tuple[float, float]
    ) -> None:
        """Derive the equations. senses: +-1 per body. Raises ``InputError`` where the machine has no averaged equations."""
        self.averaged_equations = averaged_equations_of(machine, turning={name: int(sense) for name, sense in senses.items()})
        self.machine, self.parameter, self.limits = machine, parameter, limits
        self.names = self.averaged_equations.system.state_names
        self.n = len(self.names)
        self.phase_rows = {n.removesuffix(".phase"): i for i, n in enumerate(self.names) if n.endswith(".phase")}
        self.phases = np.array([n.endswith(".phase") for n in self.names])
        self.pace = machine.shaking_frequency or operating_speed(machine)
        self.sizes = np.where(self.phases, 1.0, self.pace)
        # The parameter's scale is that of its nominal value: limits may lie far beyond any band.
        width = limits[1] - limits[0]
        self.unit = min(width, parameter.size or width)
        self.equations = self._equations()

    def _equations(self) -> EquilibriumEquations:
        """Return the equations with the swept parameter varied, and those that follow from it as definitions."""
        system, name = self.averaged_equations.system, self.parameter.name
        scale = dict(zip(self.names, self.sizes.tolist(), strict=True)) | {name: self.unit}
        if self.parameter.shares.keys() != {name}:
            symbol, symbols = sp.Symbol(name, real=True), dict(zip(system.parameter_names, system.parameters, strict=True))
            follows = [(symbols[path], mean + share * symbol) for path, (mean, share) in self.parameter.shares.items()]
            parameters = tuple(p for p in system.parameters if p not in dict(follows))
            definitions = (*follows, *system.definitions)
            system = System(system.states, system.derivatives, (*parameters, symbol), definitions, angles=system.angles)
        return EquilibriumEquations.from_system(system, [name], self.machine.values, scale)

    def rates(self, states: np.ndarray, value: float) -> tuple[np.ndarray, np.ndarray]:
        """Return dx/dt (n, N) at states (n, N), scaled, and the derivatives (N, n, n) by the scaled states."""
        rate, jacobian, _ = self._linearisation(states, np.full(states.shape[1], value))
        return rate, jacobian

    def _linearisation(self, states: np.ndarray, values: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return ``rates`` at values (N,) of the parameter, and the derivatives (N, n) by the scaled parameter."""
        f, derivatives = self.equations.values(np.vstack([states, values]))
        scale = self.pace * self.sizes[:, None]
        jacobian = derivatives[:, :-1] * self.sizes[None, :, None] / scale[:, :, None]
        return f / scale, np.moveaxis(jacobian, -1, 0), (derivatives[:, -1] * self.unit / scale).T

    def eigenvalues(self, state: np.ndarray, value: float) -> np.ndarray:
        """Return eigenvalues of the linearised averaged equations (n,), in 1/time."""
        _, jacobian = self.rates(state[:, None], value)
        return np.asarray(np.linalg.eigvals(jacobian[0]) * self.pace)

    def is_stable(self, state: np.ndarray, value: float) -> bool:
        """True if all disturbances decay."""
        values = self.eigenvalues(state, value)
        return bool(values.real.max() < -_STABLE * np.abs(values).max())

    @np.errstate(all="ignore")  # a start from which Newton's method diverges is left out
    def equilibria(self, value: float, more: np.ndarray | None = None) -> list[np.ndarray]:
        """Return all equilibria that Newton's method reaches from many starts, and from the states ``more`` (n, N)."""
        x = self.starts() if more is None else np.hstack([more, self.starts()])
        for _ in range(_NEWTON_STEPS):
            rate, jacobian = self.rates(x, value)
            good = np.isfinite(rate).all(axis=0) & np.isfinite(jacobian).all(axis=(1, 2))
            x, rate, jacobian = x[:, good], rate[:, good], jacobian[good]
            step = np.linalg.solve(jacobian + _REGULAR * np.eye(self.n), -rate.T[..., None])[..., 0].T
            step *= np.minimum(1.0, _LONGEST_STEP / np.maximum(np.abs(step).max(axis=0), 1e-300))
            x = x + step * self.sizes[:, None]
        rate, _ = self.rates(x, value)
        distinct: list[np.ndarray] = []
        for k in np.flatnonzero(np.abs(rate).max(axis=0) < _SMALL) if x.size else ():
            state = self.wrap_phases(x[:, k])
            if self.is_turning(state) and not any(self.distance(state, previous) < _SAME for previous in distinct):
                distinct.append(state)
        return distinct

    @np.errstate(all="ignore")  # a start from which Newton's method diverges is left out
    def with_fixed_phase(self, states: np.ndarray, value: float) -> tuple[np.ndarray, np.ndarray]:
        """Return equilibria (n, k) from starts (n, N) whose first phase stays, and the parameter values (k,) they need."""
        free = np.delete(np.arange(self.n), int(self.phases.argmax()))
        x, values = states.copy(), np.full(states.shape[1], value)
        for _ in range(_FAR_STEPS):
            rate, jacobian, by_value = self._linearisation(x, values)
            matrix = np.concatenate([jacobian[:, :, free], by_value[:, :, None]], axis=2)
            good = np.isfinite(rate).all(axis=0) & np.isfinite(matrix).all(axis=(1, 2)) & (np.linalg.det(matrix) != 0)
            x, values, rate, matrix = x[:, good], values[good], rate[:, good], matrix[good]
            step = np.linalg.solve(matrix, -rate.T[..., None])[..., 0].T
            step *= np.minimum(1.0, _LONGEST_STEP / np.maximum(np.abs(step).max(axis=0), 1e-300))
            x[free] += step[:-1] * self.sizes[free, None]
            values = values + step[-1] * self.unit
        has_converged = np.abs(self._linearisation(x, values)[0]).max(axis=0, initial=0.0) < _SMALL
        return x[:, has_converged], values[has_converged]

    def is_turning(self, state: np.ndarray) -> bool:
        """True if all rotors turn in their senses."""
        return bool((state[~self.phases] > 0).all())

    def wrap_phases(self, state: np.ndarray) -> np.ndarray:
        """Return the state with phases in (-pi, pi]."""
        return np.where(self.phases, math.pi - np.remainder(math.pi - state, 2 * math.pi), state)

    def distance(self, states: np.ndarray, reference: np.ndarray) -> np.ndarray:
        """Return the distance between states (..., n) and a reference (n,), scaled, up to whole turns of phases."""
        away = (states - reference) / self.sizes
        return np.asarray(np.abs(np.where(self.phases, wrap_to_pi(away), away)).max(axis=-1))

    def starts(self) -> np.ndarray:
        """Return starts with phases around the circle, all rotors at one speed: of the vibration, or up to that of a motor."""
        k, machine = int(self.phases.sum()), self.machine
        if k <= 2:
            count = 12 if k == 1 else 8
            grid = np.array(list(itertools.product(np.arange(count) / count * 2 * math.pi + 0.1, repeat=k)))
        else:
            root = 2 ** (-1 / np.arange(1, k + 1))  # an additive recurrence fills the cube of phases evenly
            grid = np.remainder(np.outer(np.arange(1, 65), root), 1.0) * 2 * math.pi
        speeds = np.array([self.pace])
        if machine.shaken_coordinate is None:
            free = [abs(f) for f in (free_speed(machine, r) for r in machine.rotors) if f] or [self.pace]
            speeds = np.append(np.linspace(0.3, 1.1, 9) * max(free), np.mean(free))
        return np.vstack([np.repeat(grid, len(speeds), axis=0).T, np.tile(speeds, (self.n - k, len(grid)))])

    def state_at(self, machine: Machine, time: float, state: np.ndarray, speed: float) -> np.ndarray:
        """Return the averaged state (n,) of a state (m,) of the full machine at a time, all rotors at one absolute speed."""
        angles, senses = angles_in(machine, state), self.averaged_equations.senses
        if machine.shaken_coordinate is not None:  # the phase is relative to that of the vibration at this time
            angles = {n: a - senses[n] * time * self.pace for n, a in angles.items()}
        return self.averaged_equations.state(angles, {n: senses[n] * speed for n in angles})

    def speed(self, states: np.ndarray) -> np.ndarray:
        """Return the common speed (N,) in the main rotor's sense: of the vibration, or of the main rotor."""
        name = f"{self.machine.rotor.name}.speed"
        return states[self.names.index(name)] if name in self.names else np.full(states.shape[1], self.pace)
