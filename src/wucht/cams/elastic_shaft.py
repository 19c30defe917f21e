"""The shaft that twists between its flywheel and the cam: motion of the cam under the inertia of the output.

A spring and a damper stand between the flywheel, whose motion is given, and the cam; the cam moves the mass of the output
without play or give (004, section 4). Its periodic motion is solved over tau = omega t, the time of a turn as an angle, on even
points, with derivatives of the trigonometric polynomial through them: L. N. Trefethen, "Spectral Methods in MATLAB", SIAM
2000, chapter 3. All numbers are in SI; a dash is a derivative by tau.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from wucht.cams.demands import require_not_negative, require_positive
from wucht.cams.laws import Law
from wucht.errors import InputError, RunError
from wucht.numerics.fourier_series import FourierSeries, differentiation

_POINTS = 128
_MOST_STEPS = 40
_LAST_STEP = 1e-9  # rad: Newton's next one would be its square
_MOST_HALVINGS = 30
_SINGULAR = 1e13  # the condition of a Jacobian that leaves three digits of a solution


class OutputLoad(Protocol):
    """Load of the output on the cam."""

    def torque(self, tau: np.ndarray, phi: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """The torque over omega^2 and its derivatives by phi, v = phi' and a = phi'', stacked (4, n)."""
        ...

    def output(self, tau: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """The motion of the output (n,)."""
        ...


@dataclass(frozen=True, eq=False)
class OriginalCam:
    """A cam with a law over its angle, psi = law(phi); inertia J_o of the output, in kg m^2 or kg.

    Its torque is J_o psi_t psi_tt/phi_t = J_o (law'(phi)^2 phi_tt + law'(phi) law''(phi) phi_t^2). Raises ``InputError``
    (load.inertia).
    """

    law: Law
    inertia: float

    def __post_init__(self) -> None:
        require_not_negative("load.inertia", self.inertia)

    def torque(self, tau: np.ndarray, phi: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """See ``OutputLoad``."""
        p, q, r = (self.law(phi, order) for order in (1, 2, 3))
        by_phi = 2 * p * q * a + (q**2 + p * r) * v**2
        return np.asarray(self.inertia * np.stack([p**2 * a + p * q * v**2, by_phi, 2 * p * q * v, p**2]))

    def output(self, tau: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """See ``OutputLoad``."""
        return np.asarray(self.law(phi))


@dataclass(frozen=True, eq=False)
class CorrectedCam:
    """A cam corrected for the very motion of its shaft: psi = law(omega t), whatever that motion is; inertia J_o of the output.

    Its torque is J_o psi_t psi_tt/phi_t, without bound where the cam comes to a stop. Raises ``InputError`` (load.inertia).
    """

    law: Law
    inertia: float

    def __post_init__(self) -> None:
        require_not_negative("load.inertia", self.inertia)

    def torque(self, tau: np.ndarray, phi: np.ndarray, v: np.ndarray, a: np.ndarray) -> np.ndarray:
        """See ``OutputLoad``."""
        pull, zeros = self.inertia * self.law(tau, 1) * self.law(tau, 2), np.zeros(len(tau))
        if not (v > 0).all():
            return np.full((4, len(tau)), np.inf)
        return np.stack([pull / v, zeros, -pull / v**2, zeros])

    def output(self, tau: np.ndarray, phi: np.ndarray) -> np.ndarray:
        """See ``OutputLoad``."""
        return np.asarray(self.law(tau))


@dataclass(frozen=True)
class ElasticShaft:
    """inertia: J_c of the cam, in kg m^2. stiffness: c in N m/rad. damping: b in N m s/rad, between flywheel and cam.

    Raises ``InputError`` (shaft.inertia, shaft.stiffness, shaft.damping).
    """

    inertia: float
    stiffness: float
    damping: float = 0.0

    def __post_init__(self) -> None:
        require_positive("shaft.inertia", self.inertia)
        require_positive("shaft.stiffness", self.stiffness)
        require_not_negative("shaft.damping", self.damping)

    def periodic_motion(
        self, load: OutputLoad, drive: FourierSeries, omega: float, points: int = _POINTS
    ) -> ElasticShaftMotion:
        """Return the periodic motion of the cam under a load: J_c phi_tt + b (phi_t - phi_d,t) + c (phi - phi_d) + torque = 0.

        Its stability is not examined: it may be unstable where the inertia at the cam
        changes much within a turn and there is little damping.

        Parameters
        ----------
        load : OriginalCam or CorrectedCam
        drive : FourierSeries
            phi_d - tau of the flywheel, in rad.
        omega : float
            Mean speed, in rad/s.
        points : int
            Of a turn; even. Twice as many as the highest order that matters, at least; see ``ElasticShaftMotion.residual``.

        Raises
        ------
        InputError
            (omega) not positive, (points) odd, or too few for the drive, (drive) that stands still or turns back.
        RunError
            Where there is no such motion, it turns back, or an undamped resonance leaves it undetermined.
        """
        _check(drive, omega, points)
        balance = _Balance(self, load, drive, omega, points)
        u, iterations = balance.solve()
        fluctuation, output = (
            FourierSeries.from_samples(u),
            FourierSeries.from_samples(load.output(balance.tau, balance.tau + u)),
        )
        slope = fluctuation.derivative()
        speed = balance.require_forward(FourierSeries(omega, omega * slope.cosine, omega * slope.sine))
        return ElasticShaftMotion(
            self, load, drive, omega, fluctuation, speed, output, balance.midpoint_imbalance(fluctuation), iterations
        )


@dataclass(frozen=True, eq=False)
class ElasticShaftMotion:
    """A periodic motion of the cam over tau.

    fluctuation: phi - tau, in rad. speed: phi_t, in rad/s. output: psi, by as many orders. residual: in N m, the largest
    torque that is out of balance halfway between the points: what more points would improve. iterations: of Newton's method.
    """

    shaft: ElasticShaft
    load: OutputLoad
    drive: FourierSeries
    omega: float
    fluctuation: FourierSeries
    speed: FourierSeries
    output: FourierSeries
    residual: float
    iterations: int

    def angle(self, tau: np.ndarray | float) -> np.ndarray:
        """phi in rad at tau of any shape."""
        return np.asarray(tau + self.fluctuation(tau))

    def torque(self, tau: np.ndarray | float) -> np.ndarray:
        """Torque in the shaft, from the flywheel to the cam, in N m, at tau of any shape."""
        lag, rate = (self.drive(tau, order) - self.fluctuation(tau, order) for order in (0, 1))
        return np.asarray(self.shaft.stiffness * lag + self.shaft.damping * self.omega * rate)


@dataclass(frozen=True, eq=False)
class _Balance:
    """The equation over omega^2: J_c u'' + b/omega (u' - f') + c/omega^2 (u - f) + torque, with phi = tau + u, drive f."""

    shaft: ElasticShaft
    load: OutputLoad
    drive: FourierSeries
    omega: float
    points: int

    @property
    def tau(self) -> np.ndarray:
        """The points (n,)."""
        return np.asarray(2 * math.pi * np.arange(self.points) / self.points)

    @property
    def _coefficients(self) -> tuple[float, float]:
        """b/omega and c/omega^2."""
        return self.shaft.damping / self.omega, self.shaft.stiffness / self.omega**2

    def solve(self) -> tuple[np.ndarray, int]:
        """Return u at the points (n,) and the number of steps: Newton's, halved where they do not improve the balance."""
        D, DD = (differentiation(self.points, order) for order in (1, 2))
        u = self.drive(self.tau)
        off = self._imbalance(self.tau, u, D @ u, DD @ u)
        for iteration in range(1, _MOST_STEPS + 1):
            jacobian = self._jacobian(u, D, DD)
            if iteration == 1 and not np.linalg.cond(jacobian, 1) < _SINGULAR:
                raise RunError(
                    f"at {self.omega:.6g} rad/s the cam on its shaft is in undamped resonance: {self._remedy()}",
                    code="resonance",
                )
            step = -np.linalg.solve(jacobian, off)
            if np.abs(step).max() <= _LAST_STEP:
                return u + step, iteration
            size = np.abs(off).max()
            for _ in range(_MOST_HALVINGS):
                off = self._imbalance(self.tau, u + step, D @ (u + step), DD @ (u + step))
                if np.abs(off).max() < size:
                    break
                step = step / 2
            else:
                break
            u = u + step
        torque = float(size) * self.omega**2
        message = (
            f"no periodic motion of the cam was found at {self.omega:.6g} rad/s: after {iteration} steps of Newton's method"
        )
        raise RunError(
            f"{message} {torque:.3g} N m were out of balance, and there may be no such motion; {self._remedy()}",
            code="no-convergence",
        )

    def _imbalance(self, tau: np.ndarray, u: np.ndarray, slope: np.ndarray, bend: np.ndarray) -> np.ndarray:
        """Return the residual of the balance for given u, u' and u''."""
        b, c = self._coefficients
        torque = self.load.torque(tau, tau + u, 1 + slope, bend)[0]
        return np.asarray(self.shaft.inertia * bend + b * (slope - self.drive(tau, 1)) + c * (u - self.drive(tau)) + torque)

    def _jacobian(self, u: np.ndarray, D: np.ndarray, DD: np.ndarray) -> np.ndarray:
        """Return the derivative of the balance by u at all points (n, n)."""
        b, c = self._coefficients
        _, by_phi, by_v, by_a = self.load.torque(self.tau, self.tau + u, 1 + D @ u, DD @ u)
        return np.asarray((self.shaft.inertia + by_a)[:, None] * DD + (b + by_v)[:, None] * D + np.diag(c + by_phi))

    def midpoint_imbalance(self, fluctuation: FourierSeries) -> float:
        """The largest torque out of balance halfway between the points, in N m."""
        tau = self.tau + math.pi / self.points
        return float(self.omega**2 * np.abs(self._imbalance(tau, *(fluctuation(tau, order) for order in (0, 1, 2)))).max())

    def require_forward(self, speed: FourierSeries) -> FourierSeries:
        """Return the speed if it is positive. Raises ``RunError``."""
        least = speed.bounds[0]
        if not least > 0:
            message = (
                f"at {self.omega:.6g} rad/s the cam would have to stand still or turn back, its speed falling to {least:.4g}"
            )
            raise RunError(f"{message} rad/s: {self._remedy()}", code="stands-still")
        return speed

    def _remedy(self) -> str:
        """Return the ratio of the natural frequency to the speed, and possible remedies, as text."""
        zeros = np.zeros(self.points)
        reflected_inertia = float(np.mean(self.load.torque(self.tau, self.tau, 1 + zeros, zeros)[3]))
        ratio = math.sqrt(self.shaft.stiffness / (self.shaft.inertia + reflected_inertia)) / self.omega
        return (
            f"its natural frequency is {ratio:.3g} times the speed; give a stiffer shaft, more damping, less inertia at the "
            "output, or another speed"
        )


def _check(drive: FourierSeries, omega: float, points: int) -> None:
    if not (math.isfinite(omega) and omega > 0):
        raise InputError("omega", omega, "the mean speed must be a positive number of rad/s")
    if points % 2 or points <= 2 * drive.count or points < 4:
        least = max(2 * drive.count + 2, 4)
        raise InputError("points", points, f"must be an even number, at least {least} for a drive of {drive.count} orders")
    slowest = 1 + drive.derivative().bounds[0]
    if not slowest > 0:
        requirement = (
            f"the flywheel must not stand still or turn back: its speed falls to {slowest:.4g} times the mean; check that"
        )
        raise InputError("drive", None, f"{requirement} the coefficients are those of an angle in rad")
