"""Forced vibration at a steady speed in closed form, and its effect on the rotation: harmonic influence coefficients.

With D(w) = K - w^2 M + i w C and the force F = sum_k U_k e_k exp(i alpha_k) the carrier moves by q = Re[z exp(i w t)],
D z = w^2 F; then D z' = 2 w F - D' z. It takes the power w^2 z^H C z / 2 out of the rotation: the vibration torque is
w z^H C z / 2. For one rotor on an isotropic carrier this is the second term of 002 (3.67).

Forced vibration: 002 (2.74)-(2.79) for any linear carrier.
All bodies turn with the speed w, each in its sense: phi_k = sigma_k (w t + alpha_k), at fixed phases or at phases that
depend on the speed.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import sympy as sp

from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import sense_of
from wucht.machines.parts.base import Body
from wucht.machines.tree import RotatingBody
from wucht.numerics.zeros_and_peaks import crossings
from wucht.system import TIME

CANCELLATION = 1e-12  # share of the bodies' unbalances that remains where they cancel
_BEYOND = 10.0  # times the highest natural frequency: there are no maxima above
WithSlope = tuple[np.ndarray, np.ndarray]  # a function of the speed, and its derivative
UNDAMPED_RATIO = 1e-10  # damping ratio below which a resonance counts as undamped
PhaseLaw = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray | None]]
_ROUNDING = 1e-14  # of the sum of magnitudes
_EQUAL = 1e-9  # relative difference of poles that are one, as those of x and y on an isotropic carrier


@dataclass(frozen=True)
class Vibration:
    """M, C, K (m x m) of the free carrier and ``excitation`` U_i e_i (n x m, complex), in the machine's units.

    A body of sense sigma turns by phi_i = sigma (w t + alpha_i): those that turn clockwise excite with conj(U_i e_i).
    """

    mass: np.ndarray
    damping: np.ndarray
    stiffness: np.ndarray
    excitation: np.ndarray

    @classmethod
    def of(cls, machine: Machine) -> Vibration:
        """The vibration of a machine at its parameter values."""
        shapes = machine.linear_carrier.excitation
        e = np.array(machine.evaluate(*(x for a in shapes for x in a)), complex).reshape(len(shapes), -1)
        clockwise = np.array([[sense_of(machine, body) < 0] for body in machine.bodies])
        return cls(*machine.matrices, np.where(clockwise, e.conj(), e))

    def select_bodies(self, index: Sequence[int]) -> Vibration:
        """The vibration that some of the bodies excite."""
        return replace(self, excitation=self.excitation[list(index)])

    def dynamic_stiffness(self, w: np.ndarray) -> np.ndarray:
        """K - w^2 M + i w C (N, m, m) at speeds (N, 1, 1)."""
        # A trace of damping keeps the matrix regular at the natural frequency of an undamped direction.
        trace = 1e-14j * (np.abs(self.stiffness).max(initial=0.0) or 1.0) * np.eye(len(self.mass))
        return np.asarray(self.stiffness - w**2 * self.mass + 1j * w * self.damping + trace)

    @cached_property
    def poles(self) -> np.ndarray:
        """The poles (2m,) of the free vibration: lambda^2 M + lambda C + K is singular."""
        size = len(self.mass)
        if not size:
            return np.empty(0, complex)
        below = -np.linalg.solve(self.mass, np.hstack([self.stiffness, self.damping]))
        return np.linalg.eigvals(np.vstack([np.eye(size, 2 * size, size), below]))

    def displacement(self, w: np.ndarray, right: np.ndarray) -> np.ndarray:
        """z (N, m, k) with D(w) z = right at speeds (N, 1, 1)."""
        return np.linalg.solve(self.dynamic_stiffness(w), right)

    def solve(self, w: np.ndarray, right: np.ndarray, rise: np.ndarray | float = 0.0) -> WithSlope:
        """z (N, m, k) with D(w) z = right at speeds (N, 1, 1), and dz/dw. rise: d right/dw."""
        dynamic = self.dynamic_stiffness(w)
        z = np.linalg.solve(dynamic, right)
        return z, np.linalg.solve(dynamic, rise - (1j * self.damping - 2 * w * self.mass) @ z)

    def force(self, phases: np.ndarray) -> np.ndarray:
        """F (m,) or (N, m) with the bodies at phases (n,) or (n, N), zero where their unbalances cancel."""
        forces = np.moveaxis(self._pushing(phases), 0, -2)
        total = forces.sum(axis=-2)
        return np.asarray(np.where(np.abs(total) > CANCELLATION * np.abs(forces).sum(axis=-2), total, 0.0))

    def _pushing(self, phases: np.ndarray) -> np.ndarray:
        """The force of each body (n, m) or (n, N, m)."""
        shapes = self.excitation if phases.ndim == 1 else self.excitation[:, None]
        return np.asarray(shapes * np.exp(1j * phases)[..., None])

    def force_slope(self, phases: np.ndarray, turning: np.ndarray) -> np.ndarray:
        """The derivative of F (N, m) where phases (n, N) change by ``turning`` (n, N)."""
        return np.asarray((1j * turning[..., None] * self._pushing(phases)).sum(axis=0))

    def response(self, speeds: np.ndarray, phases: np.ndarray, turning: np.ndarray | None = None) -> WithSlope:
        """The complex displacements z (N, m) at speeds (N,) with the bodies at phases (n,) or (n, N): q = Re[z exp(i w t)].

        turning: the derivatives (n, N) of the phases by the speed, if they change with it.
        """
        w, force = np.reshape(np.asarray(speeds, float), (-1, 1, 1)), self.force(phases)[..., None]
        rise = 2 * w * force
        if turning is not None:
            rise = rise + w**2 * self.force_slope(phases, turning)[..., None]
        z, slope = self.solve(w, w**2 * force, rise)
        return z[..., 0], slope[..., 0]

    def instant_motion(self, speeds: np.ndarray, phases: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Displacements and velocities (m,) of the steady vibration at one moment.

        speeds, phases: of the bodies (n,) at that moment, positive in their senses; speeds may differ.
        """
        responses = np.array([self.select_bodies([k]).response(speeds[[k]], phases[[k]])[0][0] for k in range(len(phases))])
        return responses.sum(axis=0).real, (1j * speeds @ responses).real

    def torque(self, speeds: np.ndarray, phases: np.ndarray, turning: np.ndarray | None = None) -> WithSlope:
        """The vibration torque on all bodies together, positive where it brakes, w z^H C z/2: 002 (2.79) with its factor M."""
        w, (z, dz) = np.asarray(speeds, float), self.response(speeds, phases, turning)
        square, cross = (np.einsum("ni,ij,nj->n", z.conj(), self.damping, amplitude).real for amplitude in (z, dz))
        return w * square / 2, square / 2 + w * cross

    def last_maximum(self, below: float | None, phases: np.ndarray) -> float | None:
        """The speed of the last maximum of the vibration torque below a speed (None: of all), None if there is none."""
        if not len(self.mass):
            return None
        natural = np.sqrt(np.abs(np.linalg.eigvals(np.linalg.solve(self.mass, self.stiffness))))
        below = _BEYOND * float(natural.max()) if below is None else abs(below)
        near = 1 + np.concatenate([-np.geomspace(1e-6, 0.5, 60), [0.0], np.geomspace(1e-6, 0.5, 60)])
        grid = np.concatenate([np.linspace(below * 1e-3, below, 400), *(w * near for w in natural)])
        grid = np.unique(grid[(grid > 0) & (grid <= below)])
        maxima = crossings(lambda w: self.torque(w, phases)[1], grid, -1) if len(grid) else grid
        return float(maxima[-1]) if len(maxima) else None


def unbalances(machine: Machine) -> np.ndarray:
    """The unbalance of each turning body (n,), complex in the body's frame, in kg m; of a couple unbalance in kg m^2.

    The unbalance of a single body is real; pivots off the axis and sliders add to that of the body they turn with. What is left
    by rounding of contributions that cancel is zero.
    """
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    if not parts:  # a dimensionless machine
        return np.asarray(np.abs(Vibration.of(machine).excitation).max(axis=1).astype(complex))
    moments = _moments(machine, parts)
    values = np.array(machine.evaluate(*itertools.chain.from_iterable(moments)), complex)
    return _sums(values, moments)


def unbalances_over_time(machine: Machine, time: np.ndarray) -> np.ndarray:
    """The unbalances (n, N), as of ``unbalances``, with the values that schedules give the parameters at times (N,)."""
    symbols, parts = (
        {s.symbol: s.expression for s in machine.schedules},
        {p.name: p for p in machine.parts if isinstance(p, Body)},
    )
    moments = [[sp.sympify(x) for x in of_body] for of_body in _moments(machine, parts)] if parts else []
    flat = list(itertools.chain.from_iterable(moments))
    if not symbols.keys() & set().union(*(x.free_symbols for x in flat)):
        return np.repeat(unbalances(machine.at(float(time[-1])))[:, None], len(time), axis=1)
    values = machine.function(*(x.subs(symbols) for x in flat), of=TIME)(time)
    return _sums(np.array([np.broadcast_to(x, len(time)) for x in values], complex), moments)


def _moments(machine: Machine, parts: Mapping[str, Body]) -> list[list[sp.Expr]]:
    """The contributions to the unbalance of each turning body."""
    moments = {b.name: [parts[b.name].moment()] for b in machine.bodies}
    for part in parts.values():
        if (couple := part.couple()) is not None:
            moments[part.name] = [couple]
        if part.reference is not None:
            moments[part.reference].append(part.moment_on_reference())
    return list(moments.values())


def _sums(values: np.ndarray, moments: Sequence[Sequence[sp.Expr]]) -> np.ndarray:
    """The sum of the values (k,) or (k, N) of each body's contributions; zero where they cancel."""
    first = np.cumsum([0, *map(len, moments)][:-1])
    sums, sizes = np.add.reduceat(values, first), np.add.reduceat(np.abs(values), first)
    return np.where(np.abs(sums) <= _ROUNDING * sizes, 0.0, sums)


def moments_along_guides(machine: Machine) -> np.ndarray:
    """Derivative of the unbalance of each turning body (n,) by the displacement of the mass that slides in it, in kg."""
    parts = {p.name: p for p in machine.parts if isinstance(p, Body)}
    moments = [parts[b.name].moment_along_guide() if parts else sp.S.Zero for b in machine.bodies]
    return np.array(machine.evaluate(*moments), float)


def unbalance_scale(machine: Machine, rotor: RotatingBody) -> float:
    """Reference of unbalance shares: the rotor's unbalance; without it the largest that a body about it has, or can have."""
    body_unbalances, group = dict(zip(machine.bodies, unbalances(machine), strict=True)), machine.group(rotor)
    if body_unbalances[rotor]:
        return float(abs(body_unbalances[rotor]))
    names = [b.name for b in group]
    reachable = [p.largest_moment() for p in machine.parts if isinstance(p, Body) and p.name in names]
    return max([float(abs(body_unbalances[b])) for b in group] + [abs(complex(x)) for x in machine.evaluate(*reachable)]) or 1.0


@dataclass(frozen=True)
class ForcedVibration:
    """The vibration of a machine at phases alpha_k.

    phase_law: alpha (n, N) and its derivatives as a function of speeds (N,), NaN where there are none; or constant alpha
    (n,). axis: (2, m), x and y of the main rotor's axis for each free coordinate of the carrier (of a carrier that
    only rotates, its angle and zero). sense: of the main rotor. Functions of the speed take (N,) and return values with
    their slopes.
    """

    vibration: Vibration
    phase_law: PhaseLaw | np.ndarray
    axis: np.ndarray
    sense: float

    @classmethod
    def of(cls, machine: Machine, angles: np.ndarray) -> ForcedVibration:
        """The vibration with the bodies at absolute angles (n,). Raises ``InputError`` where the carrier is not linear."""
        if machine.nonlinear:
            reason = f"there is no steady vibration in closed form: {machine.nonlinear} is not linear"
            raise InputError("machine", None, f"{reason}; run it with study.kind = 'run-up' or 'sweep'", code="not-linear")
        try:
            vibration = Vibration.of(machine)
        except WuchtError as error:
            raise InputError("machine", None, str(error), code=error.code) from None
        senses = np.array([sense_of(machine, b) for b in machine.bodies])
        shape = machine.structure.orbit_shape
        axis, main = np.array(machine.evaluate(*shape), float).reshape(shape.shape), machine.bodies.index(machine.rotor)
        return cls(vibration, senses * angles, axis, float(senses[main]))

    def phases(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray | None]:
        """alpha (n,) or (n, N), and their derivatives by the speed."""
        return (self.phase_law, None) if isinstance(self.phase_law, np.ndarray) else self.phase_law(speeds)

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

    def minor_amplitude(self, speeds: np.ndarray) -> np.ndarray:
        """The semi-minor axis of that orbit (N,), negative where it runs against the rotor's sense of rotation."""
        forward, backward = np.abs(self._circles(self.displacement(speeds)[0]))
        return np.asarray(self.sense * (forward - backward))

    def centre_distance(self, speeds: np.ndarray, eccentricity: float, angle: float) -> np.ndarray:
        """The largest distance (N,) of a centre of mass from the axis' static position: 002 figure 2.18.

        The centre of mass is on the main rotor at an eccentricity; angle: of the main rotor, absolute.
        """
        arm = eccentricity * np.exp(1j * self.sense * angle)
        offset = np.array([arm, -1j * self.sense * arm])
        return np.asarray(np.abs(self._circles(self.displacement(speeds)[0], offset)).sum(axis=0))

    def torque(self, speeds: np.ndarray) -> WithSlope:
        """The vibration torque on all bodies together, positive where it brakes."""
        return self.vibration.torque(speeds, *self.phases(speeds))

    def torque_on(self, speeds: np.ndarray, members: Sequence[int]) -> WithSlope:
        """The vibration torque on some bodies, positive where it brakes: -w^2/2 sum Im[conj(U_i e_i exp(i alpha_i)) z]."""
        e = self.vibration.excitation
        if not np.delete(e, list(members), axis=0).any():
            return self.torque(speeds)  # the same, without cancellation
        w, (z, dz), (phases, turning) = np.asarray(speeds, float), self.displacement(speeds), self.phases(speeds)
        member_vibration, at = self.vibration.select_bodies(members), list(members)
        conjugate = member_vibration.force(phases[at]).conj()
        work, slope = (z * conjugate).sum(axis=-1).imag, (dz * conjugate).sum(axis=-1).imag
        if turning is not None:
            slope = slope + (z * member_vibration.force_slope(phases[at], turning[at]).conj()).sum(axis=-1).imag
        return -(w**2) / 2 * work, -w * work - w**2 / 2 * slope

    @cached_property
    def poles(self) -> np.ndarray:
        """The oscillatory poles of the carrier, in the upper half plane: damping and frequency, equal ones once."""
        every, distinct = self.vibration.poles, list[complex]()
        for pole in every[every.imag > UNDAMPED_RATIO * np.abs(every).max(initial=0.0)]:
            if not any(abs(pole - known_pole) < _EQUAL * abs(pole) for known_pole in distinct):
                distinct.append(complex(pole))
        return np.array(distinct)

    def grid(self, low: float, high: float, points: int) -> np.ndarray:
        """Speeds (N,) from low to high, evenly spaced and denser at the resonances, according to their widths."""
        pieces = [np.linspace(low, high, points)]
        for pole in self.poles:
            frequency = abs(pole)
            width = max(-pole.real, 1e-4 * frequency)
            away = np.geomspace(0.02 * width, max(0.5 * frequency, width), 80)
            pieces += [frequency - away, np.array([frequency]), frequency + away]
        speeds = np.unique(np.concatenate(pieces))
        return speeds[(speeds >= low) & (speeds <= high)]

    def undamped_resonances(self, low: float, high: float) -> list[float]:
        """The resonances without damping that the unbalance excites, in a range of speeds: there the amplitude is infinite."""
        resonances = [abs(pole) for pole in self.poles if -pole.real < UNDAMPED_RATIO * abs(pole)]
        return sorted(w for w in resonances if low <= w <= high and self.grows_unbounded(self.displacement, w))

    @staticmethod
    def grows_unbounded(curve: Callable[[np.ndarray], WithSlope], speed: float) -> bool:
        """True if the magnitude of a curve grows without bound towards a speed."""
        near, far = np.abs(curve(speed * np.array([1 + 1e-7, 1 + 1e-4]))[0])
        return bool((near > 100 * far).any())
