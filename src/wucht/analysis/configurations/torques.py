"""Steady phase configurations, in numbers: the mean torques on bodies that all turn at one speed, and their derivatives.

Body i turns by theta_i = theta + alpha_i in its sense, at the common speed w. With E_i = U_i e_i (``analysis.vibration``),
a_ik = E_i^H H(w) E_k and tau_i(w) the torque of its drive, load and bearing, the phases are steady where

    tau_i(w) + V_i = 0,   V_i = -(w^4/2) sum_k [Re a_ik sin(alpha_i - alpha_k) - Im a_ik cos(alpha_i - alpha_k)]

for every body whose speed is not fixed: 000 (34), (35), 001 (48), 002 (5.1)-(5.3). All together the vibration brakes by what
the carrier dissipates, sum V_i = -(w^5/2) s^H G s with G = E^H H^H C H E and s_i = exp(i alpha_i): nothing without damping.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of
from wucht.analysis.vibration import UNDAMPED_RATIO, ForcedVibration, Vibration, WithSlope
from wucht.analysis.working_points import Curve, curves
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.structure import SPEED
from wucht.mechanics.rotating_bodies.bodies import absolute_torque
from wucht.numerics.angles import wrap_to_pi

_PARALLEL = 1e-12  # relative: below it the excitations of two bodies have one shape
_NOTHING = 1e-13  # of the largest torque coefficient: below it a torque counts as zero
_AT_THE_POLE = 1e-6  # relative: no state is searched this near to an undamped natural frequency
_BALANCE = 1e-7  # of the torques: residual allowed in a state


@dataclass(frozen=True)
class SteadyTorques:
    """n bodies, the main rotor first, on a carrier with m coordinates; angles and speeds in the bodies' senses.

    heads: the index of the rotor that each body turns about. senses: +1 or -1. inertia, relative: J and the dampers between
    the bodies of a rotor (n x n). shaft_torques: tau_i, in ``SPEED`` and the parameters. fixed_speed: of
    the main rotor, if prescribed. reaction_shapes: the shapes (n x m) by which the carrier turns the bodies: those by which
    they excite it, except for a body that represents others. share (n,): of how many bodies each represents.
    """

    machine: Machine
    names: tuple[str, ...]
    heads: tuple[int, ...]
    senses: np.ndarray
    vibration: Vibration
    inertia: np.ndarray
    relative: np.ndarray
    shaft_torques: tuple[sp.Expr, ...]
    fixed_speed: float | None
    reaction_shapes: np.ndarray
    share: np.ndarray

    @classmethod
    def of(cls, machine: Machine) -> SteadyTorques:
        """The torques of a machine that has averaged equations. Raises ``InputError`` for others, with the reason."""
        return cls.from_averaged_equations(averaged_equations_of(machine))

    @classmethod
    def from_averaged_equations(cls, averaged_equations: AveragedEquations) -> SteadyTorques:
        """The torques from averaged equations at hand."""
        b = averaged_equations.averaged_system.bodies
        if b.shaking is not None:
            sentence = "the carrier's motion is prescribed: study.kind = 'entrainment' computes whether it entrains the rotor"
            raise InputError("machine.carrier.motion", None, sentence, code="prescribed")

        def matrix(m: sp.ImmutableMatrix) -> np.ndarray:
            return np.array(averaged_equations.machine.evaluate(*m), float).reshape(m.shape)

        machine, senses = averaged_equations.machine, averaged_equations.senses
        order = [x.name for x in machine.bodies]
        vibration = Vibration.of(machine).select_bodies([order.index(name) for name in b.names])
        return cls(
            machine=machine, names=b.names, heads=b.heads, vibration=vibration, reaction_shapes=vibration.excitation,
            senses=np.array([float(senses[name]) for name in b.names]), share=np.ones(len(b.names)),
            inertia=matrix(b.inertia), relative=matrix(b.relative),
            shaft_torques=tuple(sp.sympify(absolute_torque(b, i, SPEED)) for i in range(len(b.names))),
            fixed_speed=None if b.fixed_speed is None else float(machine.evaluate(sp.sympify(b.fixed_speed))[0]),
        )  # fmt: skip

    def with_fixed_speed(self, speed: float) -> SteadyTorques:
        """The torques with the main rotor at a fixed speed."""
        return replace(self, fixed_speed=speed)

    def with_ratio(self, ratio: float) -> SteadyTorques:
        """The torques with another unbalance of the main rotor. ratio: of that of all other bodies together to it."""
        assert self.coefficients is not None
        excitation = self.vibration.excitation.copy()
        excitation[0] *= np.abs(self.coefficients[1:]).sum() / ratio / np.linalg.norm(excitation[0])
        return replace(self, vibration=replace(self.vibration, excitation=excitation), reaction_shapes=excitation)

    @cached_property
    def shaft_torque(self) -> Curve:
        """tau (n, N) and its slope as a function of speeds (N,)."""
        return curves(self.machine, self.shaft_torques)

    @property
    def size(self) -> int:
        """The number of bodies."""
        return len(self.names)

    @cached_property
    def free(self) -> tuple[int, ...]:
        """The bodies whose torques must balance: all but a main rotor whose speed is fixed."""
        return tuple(range(1 if self.fixed_speed is not None else 0, self.size))

    def influence(self, speeds: np.ndarray) -> np.ndarray:
        """a_ik (N, n, n) at speeds (N,)."""
        response = self.vibration.displacement(np.reshape(speeds, (-1, 1, 1)), self.vibration.excitation.T)
        return np.asarray(self.reaction_shapes.conj() @ response)

    def influence_with_slope(self, speeds: np.ndarray) -> WithSlope:
        """a_ik (N, n, n) at speeds (N,), and da/dw."""
        response, slope = self.vibration.solve(np.reshape(speeds, (-1, 1, 1)), self.vibration.excitation.T)
        return self.reaction_shapes.conj() @ response, self.reaction_shapes.conj() @ slope

    def brake(self, speeds: np.ndarray) -> WithSlope:
        """B_ik (N, n, n) = (w^5/2) (E^H H^H C H E)_ik at speeds (N,), and dB/dw: all V_i together are -s^H B s."""
        w = np.reshape(speeds, (-1, 1, 1))
        z, dz = self.vibration.solve(w, self.vibration.excitation.T)
        back, rate = (np.moveaxis(x, 1, 2).conj() @ self.vibration.damping for x in (z, dz))
        power = back @ z
        return w**5 / 2 * power, 5 * w**4 / 2 * power + w**5 / 2 * (rate @ z + back @ dz)

    def total(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """sum tau_i + V_i (N,), without cancellation of the large V_i near a resonance."""
        s = np.exp(1j * phases)
        power = np.einsum("iN,Nik,kN->N", s.conj(), self.brake(speeds)[0], s).real
        return np.asarray(self.share @ self.shaft_torque(speeds)[0] - power)

    def poles(self, low: float, high: float) -> list[float]:
        """The natural frequencies in a range of speeds at which the bodies' vibration is infinite: those without damping."""
        values = self.vibration.poles
        undamped_frequencies = np.unique(
            values.imag[(np.abs(values.real) < UNDAMPED_RATIO * np.abs(values)) & (values.imag > 0)]
        )
        poles: list[float] = []
        for at in undamped_frequencies[
            (undamped_frequencies >= low * (1 - _AT_THE_POLE)) & (undamped_frequencies <= high * (1 + _AT_THE_POLE))
        ]:
            if ForcedVibration.grows_unbounded(self.influence_with_slope, at) and not any(
                abs(at - pole) < _AT_THE_POLE * at for pole in poles
            ):
                poles.append(float(at))
        return poles

    def speed_intervals(self, low: float, high: float) -> list[tuple[float, float]]:
        """Intervals of a range of speeds without the surroundings of ``poles``, where the vibration is infinite."""
        ends = [low, *(at * (1 + side) for at in self.poles(low, high) for side in (-_AT_THE_POLE, _AT_THE_POLE)), high]
        return [(a, b) for a, b in zip(ends[::2], ends[1::2], strict=True) if a < b]

    def is_balanced(self, speed: float, phases: np.ndarray) -> bool:
        """True if the torques at phases (n,) balance, body by body and in sum: the proof of a state."""
        w, at = np.array([speed]), phases[:, None]
        torque_sizes, residuals = np.abs(self.shaft_torque(w)[0][:, 0]), self.residual(w, at)[:, 0]
        sizes = torque_sizes + speed**4 / 2 * np.abs(self.influence(w)[0]).sum(axis=1)
        are_zero = all(abs(residuals[i]) <= _BALANCE * sizes[i] for i in self.free)
        if self.fixed_speed is not None:
            return are_zero
        scale = torque_sizes.sum() + speed * np.abs(self.shaft_torque(w)[1]).sum() + np.abs(self.brake(w)[0]).sum()
        return are_zero and bool(abs(self.total(w, at)[0]) <= _BALANCE * scale)

    def torque(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """V (n, N) at speeds (N,) and phases (n, N)."""
        return _vibration_torque(self.influence(speeds), np.asarray(speeds, float) ** 4 / 2, phases)

    def residual(self, speeds: np.ndarray, phases: np.ndarray) -> np.ndarray:
        """tau + V (n, N)."""
        return np.asarray(self.shaft_torque(speeds)[0] + self.torque(speeds, phases))

    def slopes(self, speeds: np.ndarray, phases: np.ndarray) -> WithSlope:
        """dV/dalpha (n, n, N), and dV/dw (n, N), the derivative by the common speed."""
        w, index = np.asarray(speeds, float), np.arange(self.size)
        influence, slope = self.influence_with_slope(w)
        change = w**4 / 2 * (np.moveaxis(influence, 0, -1) * np.exp(-1j * (phases[:, None] - phases[None]))).real
        change[index, index] = 0.0
        change[index, index] = -change.sum(axis=1)
        return change, _vibration_torque(slope, w**4 / 2, phases) + _vibration_torque(influence, 2 * w**3, phases)

    @cached_property
    def coefficients(self) -> np.ndarray | None:
        """c (n,) complex where all bodies excite the carrier alike, E_i = c_i e with |e| = 1, and c_0 > 0; None where not.

        This holds for the bodies of one rotor, and with rotors in a carrier of one coordinate.
        """
        e = self.vibration.excitation
        largest = int(np.abs(e).sum(axis=1).argmax())
        shape = e[largest] / (np.linalg.norm(e[largest]) or 1.0)
        c = e @ shape.conj()
        if np.abs(e - c[:, None] * shape).max(initial=0.0) > _PARALLEL * np.abs(e).max(initial=0.0):
            return None
        return np.asarray(c * np.exp(-1j * np.angle(c[0])) if c[0] else c)

    @cached_property
    def is_coaxial(self) -> bool:
        """True if all bodies are on one axis and turn in one sense, so that their forces add up."""
        return self.coefficients is not None and bool((self.senses == self.senses[0]).all())

    def axis_influence(self, speeds: np.ndarray) -> np.ndarray:
        """a (N,) = e^H H e for bodies that excite the carrier alike: a_ik = conj(c_i) c_k a."""
        c = self.coefficients
        assert c is not None
        i = int(np.abs(c).argmax())
        return np.asarray(self.influence(speeds)[:, i, i] / np.abs(c[i]) ** 2)

    def has_idle_bodies(self, speeds: np.ndarray) -> bool:
        """True if only the main rotor has a shaft torque at these speeds: vibration alone positions the other bodies."""
        w = np.atleast_1d(speeds)
        torques, phases = self.shaft_torque(w)[0], np.broadcast_to(np.arange(float(self.size))[:, None], (self.size, len(w)))
        scale = max(float(np.abs(self.torque(w, phases)).max()), float(np.abs(torques).max()))
        return bool((np.abs(torques[1:]) <= _NOTHING * scale).all())

    @cached_property
    def classes(self) -> tuple[tuple[int, ...], ...]:
        """The bodies other than the main rotor, equal ones together: exchanging them changes no torque, inertia or damper."""
        classes: dict[int, list[int]] = {}
        for i in range(1, self.size):
            first = next((k for k in classes if self._are_equal(k, i)), i)
            classes.setdefault(first, []).append(i)
        return tuple(map(tuple, classes.values()))

    def _are_equal(self, i: int, k: int) -> bool:
        if self.heads[i] != self.heads[k] or self.heads[i] == i or self.senses[i] != self.senses[k]:
            return False
        order = np.arange(self.size)
        order[[i, k]] = k, i
        e, probes = self.vibration.excitation, np.array([0.3, 1.0, 7.0, 100.0])
        torques = self.shaft_torque(probes)[0]
        pairs = [(e[i], e[k]), (torques[i], torques[k])]
        pairs += [(m[np.ix_(order, order)], m) for m in (self.inertia, self.relative)]
        return all(np.allclose(a, b, rtol=1e-12, atol=1e-14 * np.abs(b).max(initial=0.0)) for a, b in pairs)


def separation(angles: np.ndarray, reference: np.ndarray | float) -> np.ndarray:
    """The angle between directions, at most pi."""
    return np.asarray(np.abs(wrap_to_pi(angles - reference)))


def _vibration_torque(influence: np.ndarray, factor: np.ndarray, phases: np.ndarray) -> np.ndarray:
    turning = np.exp(1j * phases)
    return np.asarray(-factor * (turning * np.einsum("Nik,kN->iN", influence, turning).conj()).imag)
