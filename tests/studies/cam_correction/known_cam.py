"""A shaft whose motion is known, and records of it as a logger writes them: uneven steps, 7.4 turns, noise, an index pulse."""

import math

import numpy as np

from wucht.cams.correction import MotionOverTime
from wucht.cams.laws.synthesis import equiripple
from wucht.cams.shaft_motion import ShaftMotion
from wucht.numerics.fourier_series import FourierSeries

OMEGA = 500 * math.pi / 30
SHAFT = ShaftMotion(FourierSeries.of(OMEGA, [0, 2.4, 1, 0.5, 0.3], [0, 1, -1.3, 0.2, 0.4]))  # that of the template
LAW = equiripple(5, math.radians(120), math.radians(24))
ZERO = 0.013  # s: when the cam angle is zero


def acceleration(law, tau):
    """In rad/s^2."""
    return OMEGA**2 * MotionOverTime(law, SHAFT)(tau, 2)


def write(path, law=LAW, noise=0.0, turns=7.4, count=6000, heading="time [s],speed [rad/s],index [V],acceleration [rad/s^2]"):
    """time, speed, index, acceleration of the output as a cam for the law makes it. noise: of the speed in rad/s; of the
    acceleration a thousand times that in rad/s^2."""
    rng = np.random.default_rng(5)
    time = np.cumsum(rng.uniform(0.5, 1.6, count))
    time *= turns * 2 * math.pi / OMEGA / time[-1]
    tau = OMEGA * (time - ZERO)
    speed = SHAFT.speed(tau) + noise * rng.standard_normal(count)
    output = acceleration(law, tau) + 1e3 * noise * rng.standard_normal(count)
    index = 5.0 * (np.mod(tau, 2 * math.pi) < 0.1)
    table = np.column_stack([time, speed, index, output])
    np.savetxt(path, table, delimiter=",", header=heading, comments="", fmt="%.12g")
    return table
