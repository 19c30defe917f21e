"""Forced vibration at a steady speed in closed form: 002 (2.74)-(2.79) for any linear carrier.

All bodies turn with the speed w, each in its sense: phi_k = sigma_k (w t + alpha_k), at fixed phases or at those that belong to
the speed.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.vibration import Vibration, WithSlope
from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of

UNDAMPED = 1e-10  # damping ratio below which a resonance counts as undamped
Placed = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray | None]]
_EQUAL = 1e-9  # relative difference of poles that are one, as those of x and y on an isotropic carrier


@dataclass(frozen=True)
class Forced:
    """The vibration of a machine at phases alpha_k.

    placed: these (n, N) and their derivatives as a function of speeds (N,), not numbers where there are none; or the same (n,)
    at all speeds. axis: (2, m), x and y of the main rotor's axis for each free coordinate of the carrier (of a carrier that
    only turns its angle and nothing). sense: of the main rotor. Functions of the speed take (N,) and return values with their
    slopes.
    """

    vibration: Vibration
    placed: Placed | np.ndarray
    axis: np.ndarray
    sense: float

    @classmethod
    def of(cls, machine: Machine, angles: np.ndarray) -> Forced:
        """The vibration with the bodies at absolute angles (n,). Raises ``InputError`` where the carrier is not linear."""
        if machine.nonlinear:
            why = f"has no steady vibration in closed form: {machine.nonlinear} is not linear"
            raise InputError("machine", None, f"{why}; study.kind = 'run-up' or 'sweep' runs it", code="not-linear")
        try:
            vibration = Vibration.of(machine)
        except WuchtError as error:
            raise InputError("machine", None, str(error), code=error.code) from None
        senses = np.array([sense_of(machine, b) for b in machine.bodies])
        shape = machine.structure.orbit_shape
        axis, main = np.array(machine.evaluate(*shape), float).reshape(shape.shape), machine.bodies.index(machine.rotor)
        return cls(vibration, senses * angles, axis, float(senses[main]))

    def phases(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """alpha (n,) or (n, N), and by what they change with the speed."""
        return (self.placed, None) if isinstance(self.placed, np.ndarray) else self.placed(speeds)

    def force(self, speeds: np.ndarray) -> np.ndarray:
        """F (N, m), zero where the bodies' unbalances cancel."""
        force = self.vibration.force(self.phases(speeds)[0])
        return np.broadcast_to(force, (len(speeds), force.shape[-1]))

    def displacement(self, speeds: np.ndarray) -> WithSlope:
        """z (N, m), complex."""
        return self.vibration.response(speeds, *self.phases(speeds))

    def _circles(self, z: np.ndarray, offset: np.ndarray | float = 0.0) -> np.ndarray:
        """The circles (2, N) of an orbit x, y = axis z + offset: run through counter-clockwise, and clockwise."""
        x, y = (z @ self.axis.T + offset).T
        return np.array([x + 1j * y, x - 1j * y]) / 2

    def amplitude(self, speeds: np.ndarray) -> WithSlope:
        """The semi-major axis of the orbit of the main rotor's axis: 002 (2.78)."""
        circles, slopes = map(self._circles, self.displacement(speeds))
        size: np.ndarray = np.abs(circles)
        slope = np.divide((circles.conj() * slopes).real, size, out=np.zeros_like(size), where=size > 0)
        return size.sum(axis=0), slope.sum(axis=0)

    def minor(self, speeds: np.ndarray) -> np.ndarray:
        """The semi-minor axis of that orbit (N,), negative where it runs against the rotor's sense of rotation."""
        forward, backward = np.abs(self._circles(self.displacement(speeds)[0]))
        return np.asarray(self.sense * (forward - backward))

    def centre(self, speeds: np.ndarray, eccentricity: float, angle: float) -> np.ndarray:
        """The largest distance (N,) of a centre of mass from the axis' static position: 002 figure 2.18.

        It is carried by the main rotor at an eccentricity; angle: of the main rotor, absolute.
        """
        arm = eccentricity * np.exp(1j * self.sense * angle)
        offset = np.array([arm, -1j * self.sense * arm])
        return np.asarray(np.abs(self._circles(self.displacement(speeds)[0], offset)).sum(axis=0))

    def torque(self, speeds: np.ndarray) -> WithSlope:
        """The vibration torque on all bodies together, positive where it brakes."""
        return self.vibration.torque(speeds, *self.phases(speeds))

    def torque_on(self, speeds: np.ndarray, members: Sequence[int]) -> WithSlope:
        """That on some of the bodies, positive where it brakes: -w^2/2 sum Im[conj(U_i e_i exp(i alpha_i)) z]."""
        e = self.vibration.excitation
        if not np.delete(e, list(members), axis=0).any():
            return self.torque(speeds)  # the same, without the difference of large numbers
        w, (z, dz), (phases, turning) = np.asarray(speeds, float), self.displacement(speeds), self.phases(speeds)
        own, at = self.vibration.only(members), list(members)
        conjugate = own.force(phases[at]).conj()
        work, slope = (z * conjugate).sum(axis=-1).imag, (dz * conjugate).sum(axis=-1).imag
        if turning is not None:
            slope = slope + (z * own.turned(phases[at], turning[at]).conj()).sum(axis=-1).imag
        return -(w**2) / 2 * work, -w * work - w**2 / 2 * slope

    @cached_property
    def poles(self) -> np.ndarray:
        """The poles of the carrier that vibrate, in the upper half plane: damping and frequency, equal ones once."""
        every, distinct = self.vibration.poles, list[complex]()
        for pole in every[every.imag > UNDAMPED * np.abs(every).max(initial=0.0)]:
            if not any(abs(pole - other) < _EQUAL * abs(pole) for other in distinct):
                distinct.append(complex(pole))
        return np.array(distinct)

    def grid(self, low: float, high: float, points: int) -> np.ndarray:
        """Speeds (N,) from low to high, evenly spaced and denser at the resonances, as their widths ask for."""
        pieces = [np.linspace(low, high, points)]
        for pole in self.poles:
            frequency = abs(pole)
            width = max(-pole.real, 1e-4 * frequency)
            away = np.geomspace(0.02 * width, max(0.5 * frequency, width), 80)
            pieces += [frequency - away, np.array([frequency]), frequency + away]
        speeds = np.unique(np.concatenate(pieces))
        return speeds[(speeds >= low) & (speeds <= high)]

    def undamped(self, low: float, high: float) -> list[float]:
        """The resonances without damping that the unbalance excites, in a range of speeds: there the amplitude is infinite."""
        resonances = [abs(pole) for pole in self.poles if -pole.real < UNDAMPED * abs(pole)]
        return sorted(w for w in resonances if low <= w <= high and self.grows(self.displacement, w))

    @staticmethod
    def grows(curve: Callable[[np.ndarray], WithSlope], speed: float) -> bool:
        """Whether the magnitude of a curve grows without bound towards a speed."""
        near, far = np.abs(curve(speed * np.array([1 + 1e-7, 1 + 1e-4]))[0])
        return bool((near > 100 * far).any())
