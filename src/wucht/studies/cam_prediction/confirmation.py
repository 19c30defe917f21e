"""The prediction confirmed: the shaft and its output simulated in time, from the predicted state, without what found it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.integrate import solve_ivp
from scipy.interpolate import CubicHermiteSpline

from wucht.cams.laws.law import Law
from wucht.cams.prediction import CamShaft
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.harmonics import Harmonics

_PER_TURN = 512
_TOLERANCE = 1e-12
_TABLE = 8192  # angles of a turn at which the cam is tabulated: of order 20 the table is 1e-10 off between them


@dataclass(frozen=True, eq=False)
class Confirmation:
    """deviation: the largest difference of speed, as a share of the mean; NaN where the simulation fails. acceleration: of the
    output in the last turn, by orders, over the mean speed squared."""

    deviation: float
    acceleration: Harmonics


def confirmation(camshaft: CamShaft, cam: Law, predicted: ShaftMotion, turns: int) -> Confirmation:
    """J phi'' = T - dJ/dphi phi'^2/2 with J = J0 + J1 psi'(phi)^2, over so many turns."""
    J0, J1, omega, table = camshaft.inertia, camshaft.output_inertia, predicted.mean, _table(cam)

    def moved(phi: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """psi', psi'' and the acceleration of the shaft."""
        p, q = table(np.mod(phi, 2 * np.pi)).T
        torque = 0.0 if camshaft.torque is None else camshaft.torque(v)[0]
        return p, q, (torque - J1 * p * q * v**2) / (J0 + J1 * p**2)

    def slope(_t: float, y: np.ndarray) -> list[float]:
        return [y[1], float(moved(y[:1], y[1:])[2][0])]

    tau = np.linspace(0, 2 * np.pi * turns, _PER_TURN * turns + 1)
    begin = [float(predicted.angle(0.0)), float(predicted.speed(0.0))]
    times = tau / omega
    run = solve_ivp(slope, (0.0, times[-1]), begin, "DOP853", t_eval=times, rtol=_TOLERANCE, atol=_TOLERANCE * omega)
    if not run.success:
        return Confirmation(float("nan"), Harmonics.of(0.0))
    phi, v = run.y
    off = np.abs(v - predicted.speed(np.mod(tau, 2 * np.pi))).max() / omega
    phi, v = phi[-_PER_TURN - 1 : -1], v[-_PER_TURN - 1 : -1]
    p, q, a = moved(phi, v)
    return Confirmation(float(off), Harmonics.sampled((q * v**2 + p * a) / omega**2))


def _table(cam: Law) -> CubicHermiteSpline:
    """psi' and psi'' by cam angles of a turn: asked for at single angles many thousands of times."""
    phi = np.linspace(0, 2 * np.pi, _TABLE + 1)
    first, second, third = (cam(phi, order) for order in (1, 2, 3))
    return CubicHermiteSpline(phi, np.column_stack([first, second]), np.column_stack([second, third]))
