"""The periodic speed of a camshaft without a measurement: from the inertia it moves, its drive and its loads.

The shaft and all that turns with it have the inertia J0, what moves with the output J1 (kg m^2, or kg where the output slides).
Energy changes by what the torque T(phi') of the drive, less that of the loads, does. Solved by Fourier collocation and Newton's
method; without a torque it is the eigenmotion, of constant energy, in closed form.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial

import numpy as np

from wucht.cams.correction import MotionOverTime, Purity, orders
from wucht.cams.demands import require_not_negative, require_positive
from wucht.cams.laws import Law
from wucht.cams.shaft_motion import ShaftMotion, shaft_motion_over_time
from wucht.errors import RunError
from wucht.numerics.fourier_series import FourierSeries, differentiation, even_angles

Torque = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]  # speeds (N,) in rad/s -> torque in N m, its derivative by speed

_FEWEST, _MOST = 256, 2048  # collocation points; doubled until the highest orders are rounding
_TAIL, _ROUNDING = 0.25, 1e-10  # share of the orders that are the highest ones, and of the mean speed
_MOST_STEPS, _MOST_HALVINGS = 40, 30
_ROUNDING_FLOOR = 1e-9  # of the mean speed: below it no fraction of a step improves the residual
_SMALL = 1e-8  # of the largest value: a last step of Newton's method, whose next one would be its square
_NEGLIGIBLE = 1e-14  # of the mean speed: the highest orders below are rounding


@dataclass(frozen=True, eq=False)
class CamShaft:
    """inertia: J0. output_inertia: J1. torque: of the drive less the loads; None: none acts, the eigenmotion. mean_speed: in
    rad/s; with a torque the expected one, without a torque the exact one."""

    inertia: float
    output_inertia: float
    mean_speed: float
    torque: Torque | None = None

    def __post_init__(self) -> None:
        require_positive("shaft.inertia", self.inertia)
        require_positive("shaft.mean_speed", self.mean_speed)
        require_not_negative("shaft.output_inertia", self.output_inertia)

    def inertia_ratio(self, law: Law) -> float:
        """J1 max psi'^2/J0: beyond ``most_inertia_ratio`` there may be no periodic motion with the corrected cam."""
        return float(self.output_inertia * (law(even_angles(_MOST), 1) ** 2).max() / self.inertia)

    @staticmethod
    def most_inertia_ratio(law: Law) -> float:
        """Return the largest ratio with a corrected cam for the eigenmotion: 1/mean(sqrt(1 - psi'^2/max psi'^2))^2, at least 1.

        There the shaft would come to rest where the output is fastest; above it no energy gives the mean speed.
        """
        square = law(even_angles(_MOST), 1) ** 2
        return float(1 / np.sqrt(1 - square / square.max()).mean() ** 2)

    def motion_with_cam(self, law: Law) -> ShaftMotion:
        """The motion of the shaft with a cam whose output moves by a law over the cam angle.

        With E = J phi'^2/2 and J = J0 + J1 psi'(phi)^2 it is dE/dphi = T. Raises ``RunError`` where there is no such motion.
        """

        def attempt(count: int, coarser: FourierSeries | None) -> FourierSeries:
            reduced_inertia = self.inertia + self.output_inertia * law(even_angles(count), 1) ** 2
            root = np.sqrt(reduced_inertia / 2)
            energy = np.full(count, (self.mean_speed * root.mean()) ** 2)
            if self.torque is not None:
                energy = energy if coarser is None else _positive(coarser, count, self.mean_speed) ** 2 * root**2
                balance = partial(energy_balance, reduced_inertia, differentiation(count), self.torque)
                energy = _newton(balance, energy, partial(self.remedy, law))
            return FourierSeries.from_samples(np.sqrt(energy) / root)

        speed = _resolved_speed(attempt)
        return ShaftMotion(shaft_motion_over_time(speed, speed.count).speed.without_rounding(_NEGLIGIBLE))

    def motion_with_corrected_cam(self, law: Law) -> ShaftMotion:
        """Return the motion of the shaft with the cam that makes the output move by a law over the time of a turn.

        With E = J0 phi'^2/2 + J1 (omega psi'(tau))^2/2 it is omega dE/dtau = T phi', omega being the mean of phi'. Raises
        ``RunError`` where there is no such motion.
        """

        def attempt(count: int, coarser: FourierSeries | None) -> FourierSeries:
            output_energy = self.output_inertia * law(even_angles(count), 1) ** 2 / 2
            if self.torque is None:
                return FourierSeries.from_samples(self._eigenmotion(output_energy, law))
            balance = partial(power_balance, self.inertia, output_energy, differentiation(count), self.torque)
            start = np.full(count, self.mean_speed) if coarser is None else _positive(coarser, count, self.mean_speed)
            return FourierSeries.from_samples(_newton(balance, start, partial(self.remedy, law)))

        return ShaftMotion(_resolved_speed(attempt).without_rounding(_NEGLIGIBLE))

    def _eigenmotion(self, output_energy: np.ndarray, law: Law) -> np.ndarray:
        """Return phi' of constant energy: omega sqrt(x - 2 E1/J0), of mean omega; output_energy: E1 = J1 psi'(tau)^2/2."""
        energy_ratio = 2 * output_energy / self.inertia
        low, high = float(energy_ratio.max()), float(energy_ratio.max()) + 2.0
        if np.sqrt(low - energy_ratio).mean() >= 1:
            raise RunError(
                f"without a torque the shaft would come to rest in each turn: {self.remedy(law)}", code="comes-to-rest"
            )
        for _ in range(200):
            x = (low + high) / 2
            low, high = (x, high) if np.sqrt(x - energy_ratio).mean() < 1 else (low, x)
        return np.asarray(self.mean_speed * np.sqrt(high - energy_ratio))

    def without_torque(self, mean_speed: float) -> CamShaft:
        """Return the shaft without a torque: its motion is the eigenmotion, of constant energy, at a mean speed in rad/s."""
        return CamShaft(self.inertia, self.output_inertia, mean_speed)

    def energy(self, cam: Law, motion: ShaftMotion) -> float:
        """Return the energy in J of shaft and output with a cam on a motion of the shaft, at the cam angle zero."""
        reduced_inertia = self.inertia + self.output_inertia * float(cam(0.0, 1)) ** 2
        return float(reduced_inertia * motion.speed(0.0) ** 2 / 2)

    def remedy(self, law: Law) -> str:
        """Return the inertia ratio and the permitted one, and possible remedies, as text."""
        ratio, most = self.inertia_ratio(law), self.most_inertia_ratio(law)
        explanation = f"the inertia ratio J1 max psi'^2/J0 is {ratio:.3g}; without a drive this law allows up to {most:.3g}"
        return f"{explanation}; give a larger flywheel or a smaller stroke"

    def power_at_constant_speed(self, law: Law, count: int = _MOST) -> np.ndarray:
        """The power in W over tau (evenly spaced) that the output takes from a shaft that turns evenly at the mean speed."""
        tau = even_angles(count)
        return np.asarray(self.output_inertia * self.mean_speed**3 * law(tau, 1) * law(tau, 2))

    def residual_with_cam(self, cam: Law, purity: Purity) -> tuple[float, ShaftMotion]:
        """Return how far the orders of the output are from the law's with a cam, and the motion of the shaft with it."""
        shaft = self.motion_with_cam(cam)
        return purity.share(orders(MotionOverTime(cam, shaft))), shaft


def energy_balance(
    reduced_inertia: np.ndarray, derivative: np.ndarray, torque_of: Torque, energy: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return dE/dphi - T(phi') at even phi (n,), and its Jacobian (n, n).

    reduced_inertia: J (n,). derivative: the matrix (n, n) of d/dphi. energy: E (n,).
    """
    speed = np.sqrt(2 * energy / reduced_inertia)
    torque, slope = torque_of(speed)
    return derivative @ energy - torque, derivative - np.diag(slope / (reduced_inertia * speed))


def power_balance(
    inertia: float, output_energy: np.ndarray, derivative: np.ndarray, torque_of: Torque, speed: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return omega dE/dtau - T phi' at even tau (n,), and its Jacobian (n, n). output_energy: J1 psi'^2/2 (n,)."""
    omega, (torque, slope) = float(speed.mean()), torque_of(speed)
    turning, moving = derivative @ (inertia * speed**2 / 2), derivative @ output_energy
    by_mean = (turning + 3 * omega**2 * moving)[:, None] / len(speed)
    by_each = omega * inertia * derivative * speed - np.diag(slope * speed + torque)
    return omega * turning + omega**3 * moving - torque * speed, by_each + by_mean


def _newton(
    balance: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]], start: np.ndarray, remedy: Callable[[], str]
) -> np.ndarray:
    """Return the root of a balance of positive unknowns: Newton's steps, halved where they do not help."""
    x, (off, jacobian) = start, balance(start)
    for _ in range(_MOST_STEPS):
        try:
            step = whole = -np.linalg.solve(jacobian, off)
        except np.linalg.LinAlgError:  # the torque is the same at all speeds
            break
        if np.abs(step).max() <= _SMALL * np.abs(x).max():
            return np.asarray(x + step)
        for _ in range(_MOST_HALVINGS):
            if (x + step > 0).all():
                new_off, new_jacobian = balance(x + step)
                if np.linalg.norm(new_off) < np.linalg.norm(off):
                    break
            step = step / 2
        else:
            # Rounding hides the residual: the whole step measures how far the solution still is.
            if np.abs(whole).max() <= _ROUNDING_FLOOR * np.abs(x).max():
                return np.asarray(x)
            break
        x, off, jacobian = x + step, new_off, new_jacobian
    raise RunError(
        f"no periodic motion of the shaft was found: {remedy()}, or a drive that holds the mean speed", code="no-convergence"
    )


def _positive(speed: FourierSeries, count: int, fallback: float) -> np.ndarray:
    """Return a speed at even points (n,), the fallback where it is not above zero: with too few orders it may fall below."""
    values = speed(even_angles(count))
    return np.where(values > 0, values, fallback)


def _resolved_speed(attempt: Callable[[int, FourierSeries | None], FourierSeries]) -> FourierSeries:
    """Return the speed with so many points that its highest orders are rounding, or the most: see ``unresolved_share``.

    attempt: from a number of points and the speed computed with fewer, None at first.
    """
    count, speed = _FEWEST, None
    while True:
        speed = attempt(count, speed)
        if _highest(speed) <= _ROUNDING * speed.mean or count >= _MOST:
            return speed
        count *= 2


def _highest(speed: FourierSeries) -> float:
    return float(speed.amplitudes[-round(_TAIL * speed.count) :].max())


def unresolved_share(motion: ShaftMotion) -> float:
    """Return the largest of the highest orders of a predicted speed over its mean, where the number of points is largest.

    A law whose acceleration jumps has infinitely many orders, and a shaft that nearly stands still within a turn very many.
    """
    amplitudes = motion.speed.amplitudes[round((1 - _TAIL) * _MOST / 2) :]
    return float(amplitudes.max(initial=0.0) / motion.mean)
