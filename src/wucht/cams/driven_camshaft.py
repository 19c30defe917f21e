"""A camshaft with what drives it: its motion with the original and the corrected cam, torques, and cams cut by measurement."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.cams.correction import CorrectedLaw, Deviation, MotionOverTime, Purity, orders
from wucht.cams.laws import Law
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.cams.tables.camshaft import CamshaftDrive
from wucht.errors import RunError
from wucht.numerics.fourier_series import FourierSeries, even_angles

_AVERAGE_POINTS = 4096  # points of a turn, for means


@dataclass(frozen=True, eq=False)
class ShaftPrediction:
    """Predicted motion of the shaft with a cam.

    acceleration: of the output by orders, per s^2. deviation: of the output from its law over time. multiplier: of a
    disturbance of the energy over a turn: below 1 the motion is stable. drive (points + 1): torque of the drive over tau.
    eigenmotion: at the same mean speed with neither drive nor loads, None where there is none. energy: of it in J, constant.
    """

    shaft: ShaftMotion
    acceleration: FourierSeries
    deviation: Deviation
    multiplier: float
    drive: np.ndarray
    eigenmotion: ShaftMotion | None
    energy: float | None


@dataclass(frozen=True, eq=False)
class DrivenCamshaft:
    """A camshaft, its drive if there is one, and the law that its cam makes. purity: how the output is judged by the law."""

    law: Law
    shaft: CamShaft
    driving: CamshaftDrive | None
    purity: Purity

    @property
    def is_enforced(self) -> bool:
        """True if the drive holds the shaft's speed, whatever torque that takes."""
        return self.driving is not None and self.driving.is_enforced

    def motion(self, is_corrected: bool) -> ShaftMotion:
        """Return the motion of the shaft, uniform where the drive enforces its speed. Raises ``RunError``: there is none."""
        if self.is_enforced:
            return ShaftMotion(FourierSeries.of(self.shaft.mean_speed))
        solve = self.shaft.motion_with_corrected_cam if is_corrected else self.shaft.motion_with_cam
        motion = solve(self.law)
        if self.driving is not None and (stands := self.driving.stall_reason(motion.mean)):
            raise RunError(f"from the expected mean_speed the shaft comes to {motion.mean:.3g} rad/s: {stands}", code="stands")
        return motion

    def prediction(self, cam: Law, shaft: ShaftMotion, tau: np.ndarray, is_corrected: bool) -> ShaftPrediction:
        """Return what follows from a motion of the shaft with a cam, at times tau (N,)."""
        motion, omega = MotionOverTime(cam, shaft), shaft.mean
        spectrum = orders(motion)
        acceleration = FourierSeries(0.0, omega**2 * spectrum.cosine, omega**2 * spectrum.sine)
        multiplier, torque = self.energy_multiplier(cam, shaft), self.drive_torque(cam, shaft, tau)
        eigenmotion = self._eigenmotion(shaft, is_corrected)
        return ShaftPrediction(shaft, acceleration, self.purity.deviation(motion), multiplier, torque, *eigenmotion)

    def _eigenmotion(self, shaft: ShaftMotion, is_corrected: bool) -> tuple[ShaftMotion | None, float | None]:
        """Return the motion at the same mean speed with neither drive nor loads, and its energy, where there is one."""
        free = self.shaft.without_torque(shaft.mean)
        try:
            solve = free.motion_with_corrected_cam if is_corrected else free.motion_with_cam
            motion = shaft if self.driving is None else solve(self.law)
        except RunError:
            return None, None
        cam = CorrectedLaw(self.law, motion) if is_corrected else self.law
        return motion, free.energy(cam, motion)

    def energy_multiplier(self, cam: Law, shaft: ShaftMotion) -> float:
        """Return exp of the integral of dT/dphi'/J over the time of a turn: the Floquet multiplier of dE/dphi = T(phi')."""
        if self.shaft.torque is None:
            return math.nan if self.is_enforced else 1.0
        tau = even_angles(_AVERAGE_POINTS)
        inertia = self.shaft.inertia + self.shaft.output_inertia * cam(shaft.angle(tau), 1) ** 2
        slope = self.shaft.torque(shaft.speed(tau))[1]
        return float(np.exp(2 * math.pi / shaft.mean * (slope / inertia).mean()))

    def drive_torque(self, cam: Law, shaft: ShaftMotion, tau: np.ndarray) -> np.ndarray:
        """Return the torque of the drive at tau (N,); where it enforces the speed, the torque needed for that."""
        if self.driving is None:
            return np.zeros(len(tau))
        drive, load = self.driving.torques(shaft.speed(tau))[0]
        if not self.is_enforced:
            return np.asarray(drive)
        return np.asarray(load + self.shaft.output_inertia * shaft.mean**2 * cam(tau, 1) * cam(tau, 2))

    def constant_speed_power(self, omega: float, points: int) -> np.ndarray:
        """Return the power (points + 1,) that output and loads take over a turn from a shaft that turns evenly."""
        angles = even_angles(points)
        output = self.shaft.output_inertia * omega**3 * self.law(angles, 1) * self.law(angles, 2)
        load = 0.0 if self.driving is None else omega * float(self.driving.torques(np.array([omega]))[0][1][0])
        return np.append(output, output[0]) + load
