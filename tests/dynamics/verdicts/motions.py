"""Synthetic motions: angles given as formulas, of bodies of machines whose rotor ``d`` makes a turn a second."""

import math
from functools import cache

import numpy as np
import pytest

from wucht.dynamics.verdicts.evidence import assess_rotor
from wucht.dynamics.verdicts.judging import judge
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver
from wucht.dynamics.verdicts.outcomes import Fact
from wucht.files.building import machine_from
from wucht.numerics.observers.turns import Samples

NOISE = Noise.of()  # of formulas: rounding alone
W = 2 * np.pi  # rad/s
END = 101.0  # s: a run of eight hundred averages over a turn, whose tenths are ten turns
UNBALANCE = 0.01  # kg m, of the rotor and of each ball
FIXED = {"directions": "fixed"}
ROTOR = {"kind": "rotor", "name": "d", "mass": 4.0, "unbalance": UNBALANCE, "inertia": 0.1}
# How long a run is advised to be: times the run at least, a run-up, a decay.
LONGER, RUN_UPS, DECAYS = 2.5, 2.0, 12.0
_MASS = 10.0  # kg, of all together


def truth(fact: Fact) -> bool | None:
    """Of one motion; None: it is not known."""
    return True if fact.yes else False if fact.no else None


def carrier(natural, decay=10.0):
    """Of such a natural frequency (rad/s) with all bodies on it; its free vibrations fall by the factor e in a time."""
    return {"mass": _MASS - 4, "stiffness": _MASS * natural**2, "damping": 2 * _MASS / decay}


def with_balls(*names):
    """The rotor and balls each of which can compensate its unbalance, of the same mass together."""
    ball = {"kind": "pendulum", "about": "d", "mass": 0.5, "length": UNBALANCE / 0.5, "damping": 1e-3}
    return ROTOR | {"mass": 4.0 - 0.5 * len(names)}, *(ball | {"name": name} for name in names)


def linear(free, slope=0.1):
    return {"on": "d", "kind": "linear", "slope": slope, "no_load_speed": free}


def machine(carrier, bodies, drive=None, **more):
    return machine_from({"carrier": carrier, "bodies": list(bodies)} | ({"drive": drive} if drive else {}) | more)


@cache
def beyond():
    """A rotor alone that its drive turns once a second, beyond its resonance at half of that."""
    return machine(carrier(W / 2), [ROTOR], linear(W))


@cache
def before():
    """A rotor alone that its drive could turn twice a second, and its resonance at 1.2 turns a second."""
    return machine(carrier(1.2 * W), [ROTOR], linear(2 * W))


@cache
def with_ball(decay=10.0):
    """As ``beyond``, with a ball."""
    return machine(carrier(W / 2, decay), with_balls("a"), linear(W))


@cache
def rigid():
    """A rotor with a ball that nothing turns to where it compensates."""
    return machine(FIXED, with_balls("a"), linear(W))


def steady(t):
    return W * t


def tenth(t):
    """Time from the end of a run until ``END`` in tenths of its turns: averages over turns belong to their middle."""
    return (t - END + 0.5) / 10


def modulated(share, period, drift=0.0):
    """A speed that goes to and fro by a share, and rises from tenth to tenth by another. share: a number or over time."""
    of = share if callable(share) else lambda t: share
    return lambda t: W * (t - of(t) * period / (4 * np.pi) * np.cos(2 * np.pi * t / period) + 5 * drift * tenth(t) ** 2)


def growing(change, rate=0.2):
    """What grows exponentially: its mean over the last tenth by such a change, ever faster."""
    return lambda t: change * rate / (1 - np.exp(-rate)) ** 2 * np.exp(rate * tenth(t))


def about(place, slip):
    """A body that is ahead of the steady rotor by an angle and by what a function adds to it."""
    return lambda t: W * t + place + slip(t)


def approaching(limit, off, time=60.0):
    """A speed that rises to a share of W, of which its mean in the last tenth is off by a share, and comes ever nearer."""
    height = off / (time / 10 * (math.exp(10 / time) - 1))
    return lambda t: W * (limit * t + height * time * np.exp(-10 * tenth(t) / time))


def swinging_between(least, greatest):
    """A ball that swings about its place so that the residual unbalance goes to and fro between these."""
    middle, height = (greatest + least) / 2, (greatest - least) / 2
    return lambda t: W * t + 2 * np.arccos((middle + height * np.sin(2 * np.pi * t / 8)) / 2)


def knocking(seed, residual, scatter):
    """A ball that moves irregularly about its place, at up to half the rotor's speed: a residual unbalance and its scatter."""
    rng = np.random.default_rng(seed)
    rates, phases, sizes = rng.uniform(0.02, 0.5, 40), rng.uniform(0, 2 * np.pi, 40), rng.normal(size=40)
    sizes *= scatter / np.sqrt(np.sum(sizes**2) / 2)
    waves = list(zip(rates, phases, sizes, strict=True))
    return lambda t: W * t + 2 * np.arccos((residual + sum(a * np.sin(W * r * t + p) for r, p, a in waves)) / 2)


def just_over(time):
    """A time that is rounded up to three digits."""
    return pytest.approx(1.005 * time, rel=0.0051)


def seen(machine, until, *angles, step=1 / 24, noise=NOISE):
    """What is seen of bodies with such angles as functions of time; their speeds by a step in the imaginary direction."""
    time = np.linspace(0, until, round(until / step) + 1)
    moved = [angle(time + 1e-30j) + 0j for angle in angles]
    watch = MotionObserver(machine, 1.0, noise)
    return watch.update_from_samples(watch.begin(), Samples.of(time, *((m.real, m.imag * 1e30) for m in moved)))


def stands(machine, *angles, until=END, free=W, end=None, noise=NOISE):
    """Where the rotor stands after that. end: of a run of which its turns are only the last part."""
    record = seen(machine, until, *angles).rotors["d"]
    return assess_rotor(machine, machine.rotor, record, free, until if end is None else end, noise)


def judged(machine, *angles, until=END, free=W, step=1 / 24):
    """The verdict on it."""
    return judge(machine, seen(machine, until, *angles, step=step), free)
