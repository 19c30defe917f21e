"""Stability of steady phase configurations in the averaged equations.

J theta'' + B theta' = tau(theta') + V(theta_0', alpha), linearised about equal speeds and steady phases; or the equations
without the inertia of the balancing bodies. What belongs to a family of states, or to an interval of speeds without torque,
neither grows nor decays and is left out.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wucht.analysis.averaged import AveragedMachine
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.numerics.jacobian import Jacobian

NEUTRAL = 1e-9  # of the fastest rate: an exponent whose real part is smaller neither grows nor decays


@dataclass(frozen=True)
class Stability:
    """stable: None where it is undecided. exponents: (k,), complex, the fastest growing first. reason: why it is undecided, or
    what is to be known beside.
    """

    stable: bool | None
    exponents: np.ndarray
    reason: str = ""

    @classmethod
    def undecided(cls, reason: str) -> Stability:
        """Without exponents."""
        return cls(None, np.empty(0, complex), reason)

    @classmethod
    def of_exponents(cls, exponents: np.ndarray, neutral: float, reason: str) -> Stability:
        """By the largest real part. neutral: below it nothing grows or decays; reason: what is reported then."""
        if not len(exponents):
            return cls(True, exponents)
        if not np.isfinite(exponents).all():
            return cls(None, exponents, "it cannot be computed here")
        if abs(exponents[0].real) <= neutral:
            return cls(None, exponents, reason)
        return cls(bool(exponents[0].real < 0), exponents)

    @property
    def leading(self) -> complex | None:
        """The exponent that grows fastest."""
        return complex(self.exponents[0]) if len(self.exponents) else None


@dataclass(frozen=True)
class SlowStability:
    """The averaged equations of a machine, linearised about its steady phase configurations."""

    torques: SteadyTorques
    slow: AveragedMachine

    @cached_property
    def _linear(self) -> Jacobian:
        return Jacobian.of(self.slow.system)

    def stability(self, state: State) -> Stability:
        """Of a state, transverse to its family."""
        exponents = self.exponents(state, state.phases[:, None])[0]
        neutral = NEUTRAL * float(np.abs(exponents).max(initial=0.0))
        return Stability.of_exponents(exponents, neutral, "neither grows nor decays")

    def exponents(self, state: State, phases: np.ndarray) -> np.ndarray:
        """The exponents (N, k) of members (n, N) of a state's family, transverse to it, the fastest growing first.

        Not numbers where the equations are singular.
        """
        state = state.inside
        if self.slow.inertia and self.slow.order == 1:
            matrices = slow_matrices(self.torques, np.full(phases.shape[1], state.speed), phases)
        else:
            states = np.array([slow_state(self.slow, replace(state, phases=at)) for at in phases.T]).T
            matrices = np.moveaxis(self._linear(states, self.slow.values())[1], -1, 0)
        regular = np.isfinite(matrices).all(axis=(1, 2))
        exponents = np.full(matrices.shape[:2], np.nan, complex)
        exponents[regular] = np.linalg.eigvals(matrices[regular])
        return transverse(exponents, state.neutral)


def slow_matrices(torques: SteadyTorques, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
    """The linearised averaged equations (N, k, k) at speeds (N,) and phases (n, N).

    Unknowns: the phases of all bodies to the main rotor, then the speeds of those whose speed is not given.
    """
    n, free = torques.size, list(torques.free)
    change, rate = torques.slopes(speeds, phases)
    by_speed = np.repeat(-torques.relative[:, :, None], len(speeds), axis=2)
    by_speed[np.arange(n), np.arange(n)] += torques.alone(speeds)[1]
    by_speed[:, 0] += rate
    inverse = np.linalg.inv(torques.inertia[np.ix_(free, free)])
    matrices = np.zeros((len(speeds), n - 1 + len(free), n - 1 + len(free)))
    matrices[:, : n - 1, n - 1 :] = (np.eye(n) - np.eye(n)[0])[1:, free]
    matrices[:, n - 1 :, : n - 1] = np.einsum("ij,jkN->Nik", inverse, change[free][:, 1:])
    matrices[:, n - 1 :, n - 1 :] = np.einsum("ij,jkN->Nik", inverse, by_speed[np.ix_(free, free)])
    return matrices


def transverse(eigenvalues: np.ndarray, dimension: int) -> np.ndarray:
    """Eigenvalues (N, k) without the ``dimension`` smallest, the fastest growing first."""
    others = np.take_along_axis(eigenvalues, np.argsort(np.abs(eigenvalues), axis=-1)[..., dimension:], -1)
    return np.asarray(np.take_along_axis(others, np.argsort(-others.real, axis=-1, kind="stable"), -1))


def slow_state(slow: AveragedMachine, state: State) -> np.ndarray:
    """The state (k,) of the averaged equations."""
    alpha = dict(zip(slow.equations.bodies.names, state.phases, strict=True))
    values = []
    for symbol in slow.system.states:
        body, _, what = symbol.name.rpartition(".")
        reference = slow.references[body]
        values.append(state.speed if what == "speed" else alpha[body] - (alpha[reference] if reference else 0.0))
    return np.array(values)
