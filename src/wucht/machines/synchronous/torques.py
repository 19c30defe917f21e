"""Constant phases, in numbers: the mean torques on bodies that all turn at one speed, and their derivatives.

Body i turns by theta_i = theta + alpha_i in its own sense, at the speed w of all. With E_i = U_i e_i (``machines.vibration``),
a_ik = E_i^H H(w) E_k and tau_i(w) the torque of its own drive, load and bearing, the phases stay where

    tau_i(w) + V_i = 0,   V_i = -(w^4/2) sum_k [Re a_ik sin(alpha_i - alpha_k) - Im a_ik cos(alpha_i - alpha_k)]

for every body whose speed is not given: 000 (34), (35), 001 (48), 002 (5.1)-(5.3).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.slow import SlowMachine, slow_machine
from wucht.machines.vibration import Vibration
from wucht.mechanics.slow.bodies import absolute
from wucht.numerics.program import python_function

_PARALLEL = 1e-12  # relative: below it the excitation of a body has the shape of another's
_NOTHING = 1e-13  # of the largest torque coefficient: below it a torque counts as none
SPEED = sp.Symbol("speed", real=True)

WithSlope = tuple[np.ndarray, np.ndarray]


@dataclass(frozen=True)
class SteadyTorques:
    """n bodies, the main rotor first, on a carrier with m coordinates; angles and speeds in the bodies' own senses.

    heads: the index of the rotor that each body turns about. senses: +1 or -1. inertia, relative: J and the dampers between
    the bodies of a rotor (n x n). own: tau_i, expressions in ``SPEED``. given: the main rotor's speed where it is prescribed.
    pickup: the shapes (n x m) by which the carrier turns the bodies, where they are not those by which they excite it: of a
    body that stands for others.
    """

    names: tuple[str, ...]
    heads: tuple[int, ...]
    senses: np.ndarray
    vibration: Vibration
    inertia: np.ndarray
    relative: np.ndarray
    own: tuple[sp.Expr, ...]
    given: float | None
    pickup: np.ndarray | None = None

    @classmethod
    def of(cls, machine: Machine) -> SteadyTorques:
        """The torques of a machine of the slow class. Raises ``InputError`` for others, with the reason."""
        return cls.from_slow(slow_machine(machine))

    @classmethod
    def from_slow(cls, slow: SlowMachine) -> SteadyTorques:
        """The same from slow equations that are there."""
        b, numbers = slow.equations.bodies, slow.machine.numbers
        if b.shaking is not None:
            raise InputError(
                "machine.carrier.motion", None, "the carrier's motion is prescribed: whether it takes the rotor along is "
                "study.kind = 'entrainment'",
            )  # fmt: skip

        def matrix(m: sp.ImmutableMatrix) -> np.ndarray:
            return np.array(m.xreplace(numbers).tolist(), float).reshape(m.shape)

        order = [x.name for x in slow.machine.bodies]
        vibration = Vibration.of(slow.machine).only([order.index(name) for name in b.names])
        own = tuple(sp.sympify(absolute(b, i, SPEED)).xreplace(numbers) for i in range(len(b.names)))
        given = None if b.given is None else float(sp.sympify(b.given).xreplace(numbers))
        return cls(
            names=b.names,
            heads=b.heads,
            senses=np.array([float(slow.senses[name]) for name in b.names]),
            vibration=vibration,
            inertia=matrix(b.inertia),
            relative=matrix(b.relative),
            own=own,
            given=given,
        )

    def held(self, speed: float) -> SteadyTorques:
        """The same with the main rotor at a given speed."""
        return replace(self, given=speed)

    @cached_property
    def alone(self) -> Callable[[np.ndarray], WithSlope]:
        """tau (n, N) and its slope as a function of speeds (N,)."""
        return _curves(list(self.own))

    @property
    def size(self) -> int:
        """The number of bodies."""
        return len(self.names)

    @cached_property
    def free(self) -> tuple[int, ...]:
        """The bodies whose torques must balance: all but a main rotor whose speed is given."""
        return tuple(range(1 if self.given is not None else 0, self.size))

    @property
    def felt(self) -> np.ndarray:
        """The shapes (n x m) by which the carrier turns the bodies."""
        return self.vibration.excitation if self.pickup is None else self.pickup

    def influence(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """a_ik (N, n, n) at speeds (N,), and da/dw."""
        v, w = self.vibration, np.atleast_1d(np.asarray(speeds, float))[:, None, None]
        e, left = v.excitation, self.felt.conj()
        response = np.linalg.solve(v.dynamic(w), np.broadcast_to(e.T, (len(w), *e.T.shape)))
        slope = np.linalg.solve(v.dynamic(w), (2 * w * v.mass - 1j * v.damping) @ response)
        return left @ response, left @ slope

    def torque(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """V (n, N) at speeds (N,) and phases (n, N)."""
        influence, _ = self.influence(speeds)
        return _vibration_torque(influence, np.asarray(speeds, float) ** 4 / 2, phases)

    def residual(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """tau + V (n, N)."""
        found: np.ndarray = self.alone(speeds)[0] + self.torque(speeds, phases)
        return found

    def slopes(self, speeds: np.ndarray, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """dV/dalpha (n, n, N), and dV/dw (n, N): what V changes by with the speed of all."""
        w = np.asarray(speeds, float)
        influence, slope = self.influence(w)
        apart = phases[:, None] - phases[None]
        pull = np.moveaxis(influence, 0, -1) * np.exp(-1j * apart)
        change = w**4 / 2 * pull.real
        index = np.arange(self.size)
        change[index, index] = 0.0
        change[index, index] = -change.sum(axis=1)
        rate = _vibration_torque(slope, w**4 / 2, phases) + _vibration_torque(influence, 2 * w**3, phases)
        return change, rate

    @cached_property
    def coefficients(self) -> np.ndarray | None:
        """c (n,) complex where all bodies excite the carrier alike, E_i = c_i e with |e| = 1, and c_0 > 0; None where not.

        So it is with the bodies of one rotor, and with rotors in a carrier of one coordinate.
        """
        e = self.vibration.excitation
        largest = int(np.abs(e).sum(axis=1).argmax())
        shape = e[largest] / (np.linalg.norm(e[largest]) or 1.0)
        found = e @ shape.conj()
        rest = np.abs(e - found[:, None] * shape).max(initial=0.0)
        if rest > _PARALLEL * np.abs(e).max(initial=0.0):
            return None
        turned: np.ndarray = found * np.exp(-1j * np.angle(found[0])) if found[0] else found
        return turned

    def axis_influence(self, speeds: np.ndarray) -> np.ndarray:
        """a (N,) = e^H H e for bodies that excite the carrier alike: a_ik = conj(c_i) c_k a."""
        c = self.coefficients
        assert c is not None
        i = int(np.abs(c).argmax())
        found: np.ndarray = self.influence(speeds)[0][:, i, i] / np.abs(c[i]) ** 2
        return found

    def idle(self, speeds: np.ndarray) -> bool:
        """Whether no body but the main rotor has a torque of its own at these speeds: then vibration alone places them."""
        own = self.alone(np.atleast_1d(speeds))[0]
        scale = np.abs(
            self.torque(np.atleast_1d(speeds), np.zeros((self.size, np.size(speeds))) + np.arange(self.size)[:, None])
        )
        return bool((np.abs(own[1:]) <= _NOTHING * max(float(scale.max()), float(np.abs(own).max()))).all())

    @cached_property
    def classes(self) -> tuple[tuple[int, ...], ...]:
        """The bodies other than the main rotor, equal ones together: exchanging them changes no torque, inertia or damper."""
        found: list[list[int]] = []
        for i in range(1, self.size):
            alike = next((members for members in found if self._alike(members[0], i)), None)
            if alike is None:
                found.append([i])
            else:
                alike.append(i)
        return tuple(tuple(members) for members in found)

    def _alike(self, i: int, k: int) -> bool:
        if self.heads[i] != self.heads[k] or self.heads[i] == i or self.senses[i] != self.senses[k]:
            return False
        order = np.arange(self.size)
        order[[i, k]] = k, i
        e, probes = self.vibration.excitation, np.array([0.3, 1.0, 7.0, 100.0])
        own = self.alone(probes)[0]
        pairs = [(e[i], e[k]), (own[i], own[k])]
        pairs += [(m[np.ix_(order, order)], m) for m in (self.inertia, self.relative)]
        return all(np.allclose(a, b, rtol=1e-12, atol=1e-14 * np.abs(b).max(initial=0.0)) for a, b in pairs)


def _vibration_torque(influence: np.ndarray, factor: np.ndarray, phases: np.ndarray) -> np.ndarray:
    turning = np.exp(1j * phases)
    field = np.einsum("Nik,kN->iN", influence, turning)
    found: np.ndarray = -factor * (turning * field.conj()).imag
    return found


def _curves(torques: list[sp.Expr]) -> Callable[[np.ndarray], WithSlope]:
    function = python_function((SPEED,), (), (*torques, *(sp.diff(t, SPEED) for t in torques)))

    def curves(speeds: np.ndarray) -> WithSlope:
        w = np.atleast_1d(np.asarray(speeds, float))
        values = np.array([np.broadcast_to(np.asarray(v, float), w.shape) for v in function(w)])
        return values[: len(torques)], values[len(torques) :]

    return curves
