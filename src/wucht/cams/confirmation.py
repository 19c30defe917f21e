"""Confirmation of a prediction: shaft and output simulated in time from the predicted state, by independent equations."""

from __future__ import annotations

from bisect import bisect_right
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from scipy.integrate import DOP853

from wucht.cams.laws import Law
from wucht.cams.prediction import CamShaft, Torque
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries, even_angles

_TURN = 2 * np.pi
_PER_TURN = 2048  # as many as sample the predicted orders: both alias equally
_TOLERANCE = 1e-13
_LONGEST = 1 / 64  # of a turn: the largest step; a longer one may miss sharp parts of the cam unnoticed
_TABLE = 8192  # times of a turn at whose cam angles the cam is tabulated: dense where the shaft is slow, and its cam sharp
_INTERVALS, _HALVINGS = 64, 40  # of the torque's table: first ones, and how often each may be halved
_ABOUT = (0.5, 1.5)  # times the least and the greatest predicted speed: where the torque is tabulated
_TORQUE_ERROR = 1e-12  # of the largest torque
_MOST_CALLS = 50_000  # of the right-hand side for a turn; 1500 to 3000 are usual
_REPORT_STEPS = 32  # steps between two reports


@dataclass(frozen=True, eq=False)
class Confirmation:
    """Outcome of a confirming simulation.

    deviation: the largest difference of speed, as a share of the mean; NaN where the simulation fails. acceleration: of the
    output in the last turn, by orders, over the mean speed squared. failure: reason of a failed simulation, else empty.
    speed: in the last turn, over tau, in rad/s.
    """

    deviation: float
    acceleration: FourierSeries
    failure: str
    speed: FourierSeries


def confirmation(
    camshaft: CamShaft,
    cam: Law,
    prediction: ShaftMotion,
    turns: int,
    report: Callable[[float], None],
    most_calls: int = _MOST_CALLS,
) -> Confirmation:
    """Integrate J phi'' = T - dJ/dphi phi'^2/2 with J = J0 + J1 psi'(phi)^2 over a number of turns.

    report: receives the completed share, and may raise to stop. most_calls: of the right-hand side for a turn.
    """
    omega, tau = prediction.mean, np.linspace(0, _TURN * turns, _PER_TURN * turns + 1)
    begin = [float(prediction.angle(0.0)), float(prediction.speed(0.0))]
    low, high = prediction.speed.bounds
    torque = _tabulated_torque(camshaft.torque or _no_torque, _ABOUT[0] * low, _ABOUT[1] * high)
    slope = _slope(camshaft, _tabulated_cam(cam, prediction), torque)
    tolerance = {"rtol": _TOLERANCE, "atol": _TOLERANCE * omega}
    solver = DOP853(slope, 0.0, begin, tau[-1] / omega, max_step=_LONGEST * _TURN / omega, **tolerance)
    solution, sample_count, steps, no_orders = np.empty((2, len(tau))), 0, 0, FourierSeries.of(0.0)
    while solver.status == "running":
        fault = solver.step()
        elapsed_turns = solver.t * omega / _TURN
        if fault or solver.nfev > most_calls * (1 + elapsed_turns):
            reason = fault or f"a turn takes more than {most_calls} evaluations: the torque changes too fast with the speed"
            return Confirmation(np.nan, no_orders, f"fails in turn {int(elapsed_turns) + 1} of {turns}: {reason}", no_orders)
        last = len(tau) if solver.status == "finished" else int(np.searchsorted(tau, solver.t * omega))
        if last > sample_count:
            solution[:, sample_count:last], sample_count = solver.dense_output()(tau[sample_count:last] / omega), last
        if (steps := steps + 1) % _REPORT_STEPS == 0:
            report(elapsed_turns / turns)
    deviation = np.abs(solution[1] - prediction.speed(np.mod(tau, _TURN))).max() / omega
    phi, v = solution[:, -_PER_TURN - 1 : -1]
    a = _acceleration(camshaft, cam(phi, 1), cam(phi, 2), v)
    acceleration = FourierSeries.from_samples((cam(phi, 2) * v**2 + cam(phi, 1) * a) / omega**2)
    return Confirmation(float(deviation), acceleration, "", FourierSeries.from_samples(v))


def _acceleration(camshaft: CamShaft, p: np.ndarray, q: np.ndarray, v: np.ndarray) -> np.ndarray:
    """Return phi'' (N,) where the cam has psi' = p and psi'' = q, at speeds v."""
    torque = 0.0 if camshaft.torque is None else camshaft.torque(v)[0]
    J1 = camshaft.output_inertia
    return np.asarray((torque - J1 * p * q * v**2) / (camshaft.inertia + J1 * p**2))


def _slope(
    camshaft: CamShaft, table: Callable[[float], tuple[float, float]], torque: Callable[[float], float]
) -> Callable[[float, np.ndarray], list[float]]:
    """Return the function of phi' and phi'' by phi and phi', in scalars: arrays of length one take three times as long."""
    J0, J1 = camshaft.inertia, camshaft.output_inertia

    def slope(_t: float, y: np.ndarray) -> list[float]:
        phi, v = y.tolist()
        p, q = table(phi)
        return [v, (torque(v) - J1 * p * q * v * v) / (J0 + J1 * p * p)]

    return slope


def _no_torque(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    return np.zeros_like(speeds), np.zeros_like(speeds)


def _tabulated_torque(torque: Torque, low: float, high: float) -> Callable[[float], float]:
    """Return a torque by cubics between speeds: one by the formulas of a motor takes as long as a hundred of these.

    Intervals are halved where the torque at their middle is not that of the cubic. Beyond the table the torque itself is used.
    """
    at = np.linspace(low, high, _INTERVALS + 1)
    for _ in range(_HALVINGS):
        cubics, middle = _cubics(torque, at), (at[:-1] + at[1:]) / 2
        x = middle - at[:-1]
        off = np.abs(((cubics[:, 3] * x + cubics[:, 2]) * x + cubics[:, 1]) * x + cubics[:, 0] - torque(middle)[0])
        if not (rough := off > _TORQUE_ERROR * np.abs(cubics[:, 0]).max()).any():
            break
        at = np.sort(np.append(at, middle[rough]))
    speeds, coefficients = at.tolist(), _cubics(torque, at).tolist()

    def value(speed: float) -> float:
        if not speeds[0] <= speed < speeds[-1]:
            return float(torque(np.array([speed]))[0][0])
        i = bisect_right(speeds, speed) - 1
        x, (a, b, c, d) = speed - speeds[i], coefficients[i]
        return float(a + x * (b + x * (c + x * d)))

    return value


def _cubics(torque: Torque, at: np.ndarray) -> np.ndarray:
    """Return the coefficients (M, 4) of the cubics with the torques and slopes at speeds (M + 1,), the constant first."""
    values, slopes = torque(at)
    h, (a, b), (a1, b1) = np.diff(at), (values[:-1], slopes[:-1]), (values[1:], slopes[1:])
    rise = (a1 - a) / h
    return np.stack([a, b, (3 * rise - 2 * b - b1) / h, (b + b1 - 2 * rise) / h**2], axis=1)


def _tabulated_cam(cam: Law, prediction: ShaftMotion) -> Callable[[float], tuple[float, float]]:
    """Return psi' of a cam by quintics between cam angles, and psi'' as their exact derivative, which conserves energy.

    With a separate table of psi'' a shaft without a drive would gain or lose energy in each turn. A quintic has psi', psi'' and
    psi''' of the cam at the ends of its interval.
    """
    angles = np.append(prediction.angle(even_angles(_TABLE)), _TURN)
    values = [cam(angles, order) for order in (1, 2, 3)]
    h, (p, q, r), (p1, q1, r1) = np.diff(angles), (f[:-1] for f in values), (f[1:] for f in values)
    d, e, g = (p1 - p - q * h - r * h**2 / 2) / h**3, (q1 - q - r * h) / h**2, (r1 - r) / h
    higher = [10 * d - 4 * e + g / 2, (-15 * d + 7 * e - g) / h, (6 * d - 3 * e + g / 2) / h**2]
    at, quintics = angles[:-1].tolist(), np.stack([p, q, r / 2, *higher], axis=1).tolist()

    def slopes(phi: float) -> tuple[float, float]:
        phi %= _TURN
        i = bisect_right(at, phi) - 1
        x, (a, b, c, d, e, f) = phi - at[i], quintics[i]
        return a + x * (b + x * (c + x * (d + x * (e + x * f)))), b + x * (2 * c + x * (3 * d + x * (4 * e + x * 5 * f)))

    return slopes
