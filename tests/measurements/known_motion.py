"""Motions of a shaft whose orders are known, and records of them."""

import numpy as np

from wucht.measurements.recording import Channel
from wucht.measurements.shaft_signal import angle_signal, pulse_signal, speed_signal
from wucht.numerics.fourier_series import FourierSeries

OMEGA = 52.36
ORDERS = (1, 2, 3, 5)
SPEED = FourierSeries.of(OMEGA, [0.3, 2.4, -0.7, 0.0, 0.25], [-0.2, 1.1, 0.4, 0.0, -0.6])  # rad/s
TURN = 2 * np.pi
PERIOD = TURN / OMEGA


def speed_at(t, motion=SPEED):
    return motion(motion.mean * t)


def angle_at(t, motion=SPEED):
    """The integral of the speed, with C = 0: written out, as in errata.md on paper 004."""
    j, omega = np.arange(1, motion.count + 1), motion.mean
    x = np.multiply.outer(np.asarray(t), j * omega)
    return omega * t + (np.sin(x) * motion.cosine - np.cos(x) * motion.sine) @ (1 / (j * omega))


def times_of(angles, motion=SPEED):
    """When the shaft stands at increasing angles."""
    t = angles / motion.mean
    for _ in range(50):
        t = t - (angle_at(t, motion) - angles) / speed_at(t, motion)
    return t


def uneven(turns, count, seed=0):
    """Times from 0 s to so many turns, in steps that differ by more than a factor of three."""
    steps = np.random.default_rng(seed).uniform(0.5, 1.6, count)
    t = np.cumsum(steps)
    return (t - t[0]) / (t[-1] - t[0]) * turns * PERIOD


def channel(t, values, unit="rad/s", name="speed"):
    return Channel("r.csv", name, unit, t, values)


def speed_record(t, noise=0.0, seed=1, motion=SPEED):
    return speed_signal(channel(t, speed_at(t, motion) + noise * np.random.default_rng(seed).standard_normal(len(t))))


def angle_record(t, noise=0.0, seed=2, motion=SPEED):
    values = angle_at(t, motion) + noise * np.random.default_rng(seed).standard_normal(len(t))
    return angle_signal(channel(t, values, "rad", "angle"))


def pulse_record(turns, per_turn=64, noise=0.0, seed=3, motion=SPEED):
    """noise: in s, of the instants."""
    t = times_of(TURN / per_turn * np.arange(1, int(turns * per_turn)), motion)
    t = t + noise * np.random.default_rng(seed).standard_normal(len(t))
    return pulse_signal(channel(t, t, "s", "pulses"), per_turn)


def coefficients(fit):
    return np.concatenate([[fit.speed.mean], fit.cosine, fit.sine])


def truth(orders=ORDERS, motion=SPEED):
    j = np.array(orders) - 1
    return np.concatenate([[motion.mean], motion.cosine[j], motion.sine[j]])
