"""Throw of a vibrating carrier: stroke, direction, acceleration, and the characteristic numbers of vibratory machines.

The machine number K = a omega^2/g is the largest acceleration over that of gravity; the throw number Gamma is that normal to
the deck, over the component of gravity normal to it: where it exceeds 1, loose material leaves the deck.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.vibration import ForcedVibration
from wucht.machines.machine import Machine
from wucht.numerics.zeros_and_peaks import extremes, interval_maxima

_SHORT = 1e-2  # of the median step of samples
GRAVITY = 9.80665  # m/s^2, standard: 3rd CGPM (1901)


NUMBERS = {  # of ``Throw.numbers``: long name and unit of each
    "stroke": ("peak to peak in the direction of the largest motion", "m"),
    "throw_direction": ("direction of the largest motion, from +x", "rad"),
    "throw_ratio": ("motion across the direction of the largest motion over that along it", ""),
    "acceleration": ("largest acceleration", "m/s^2"),
    "machine_number": ("largest acceleration over that of gravity", ""),
}


@dataclass(frozen=True)
class Throw:
    """The motion of a point in its plane. SI.

    stroke: peak to peak in the direction of the largest motion; direction: its angle from +x, counter-clockwise, in (-pi/2,
    pi/2], None on a circle; across: peak to peak normal to it. acceleration: the largest. normal: the largest normal to a deck,
    or None.
    """

    stroke: float
    across: float
    direction: float | None
    acceleration: float
    normal: float | None = None

    @classmethod
    def from_harmonic(cls, z: np.ndarray, speed: float, deck: float | None = None) -> Throw:
        """Throw of the ellipse x, y = Re[z exp(i speed t)], z complex (2,). deck: its inclination to +x in rad."""
        forward, backward = (z[0] + 1j * z[1]) / 2, (z[0] - 1j * z[1]) / 2
        major, minor = abs(forward) + abs(backward), abs(abs(forward) - abs(backward))
        direction = (np.angle(forward) - np.angle(backward)) / 2
        normal = None if deck is None else float(abs(z @ _normal(deck))) * speed**2
        return cls(2 * float(major), 2 * float(minor), _line(float(direction)), float(major) * speed**2, normal)

    @classmethod
    def from_samples(cls, time: np.ndarray, place: np.ndarray, velocity: np.ndarray, deck: float | None = None) -> Throw:
        """Throw of a sampled motion: time (N,), at least three samples; place and velocity (2, N).

        Between samples it is interpolated to the fourth order of their distance.
        """
        time, place, velocity = _without_short_steps(time, place, velocity)
        along = _main_axis(place)
        acceleration, jerk = _second_and_third_derivatives(time, place, velocity)
        inner = time[1:-1]
        largest = max(_largest_magnitude(inner, way @ acceleration, way @ jerk) for way in _directions(acceleration))
        normal = None
        if deck is not None:
            normal = _largest_magnitude(inner, _normal(deck) @ acceleration, _normal(deck) @ jerk)
        stroke, across = (_span(time, way @ place, way @ velocity) for way in (along, np.array([-along[1], along[0]])))
        return cls(stroke, across, _line(math.atan2(along[1], along[0])), largest, normal)

    def beyond(self, noise: float) -> Throw:
        """The throw without what is noise: strokes that are no longer than it. At rest all is zero; a circle within the noise
        has no direction."""
        if self.stroke <= noise:
            return Throw(0.0, 0.0, None, 0.0, None if self.normal is None else 0.0)
        is_circle = abs(self.stroke - self.across) <= noise
        across = self.across if self.across > noise else 0.0
        return replace(self, across=across, direction=None if is_circle else self.direction)

    @property
    def machine_number(self) -> float:
        """K, the largest acceleration over that of gravity."""
        return self.acceleration / GRAVITY

    @property
    def ratio(self) -> float | None:
        """The motion across over that along: 0 on a line, 1 on a circle, None at rest."""
        return self.across / self.stroke if self.stroke else None

    @property
    def numbers(self) -> dict[str, float | None]:
        """Numbers of the summary, by key."""
        return {
            "stroke": self.stroke,
            "throw_direction": self.direction if self.stroke else None,
            "throw_ratio": self.ratio,
            "acceleration": self.acceleration,
            "machine_number": self.machine_number,
        }

    def throw_number(self, deck: float) -> float | None:
        """Gamma, the largest acceleration normal to the deck over the component of gravity normal to it."""
        return None if self.normal is None else self.normal / (GRAVITY * math.cos(deck))


def _normal(deck: float) -> np.ndarray:
    return np.array([-math.sin(deck), math.cos(deck)])


def _line(angle: float) -> float:
    """The angle of a line, which has no sense, in (-pi/2, pi/2]."""
    return math.pi / 2 - (math.pi / 2 - angle) % math.pi


def steady_throw(machine: Machine, vibration: ForcedVibration, speed: float) -> Throw | None:
    """Throw of the carrier's centre of mass in the forced vibration at a speed; None for a carrier without units or one that
    does not translate, and at an undamped resonance."""
    if machine.dimensionless or not {"x", "y"} & set(machine.free_labels):
        return None
    with np.errstate(all="ignore"):
        z = dict(zip(machine.free_labels, vibration.displacement(np.array([abs(speed)]))[0][0], strict=True))
        plane = np.array([z.get(d, 0.0) for d in "xy"])
    return Throw.from_harmonic(plane, abs(speed)) if np.isfinite(plane).all() else None


def largest_kinetic_energy(machine: Machine, velocities: np.ndarray) -> float:
    """The largest kinetic energy v^T M v/2 of the carrier with the bodies on it; velocities (m, N): of its free coordinates."""
    return extremes(np.einsum("iN,ij,jN->N", velocities, machine.matrices[0], velocities) / 2)[1]


def largest_of(vector: np.ndarray) -> float:
    """The largest magnitude of a vector (2, N) that is sampled evenly, between samples too."""
    return max(extremes(sign * (way @ vector))[1] for way in _directions(vector) for sign in (1.0, -1.0))


def _directions(vector: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Directions along which a vector (2, N) is the largest: its main axis, and that of the largest sample.

    Its components there oscillate half as fast as its magnitude, so that they are better resolved by the samples.
    """
    most = vector[:, int((vector**2).sum(axis=0).argmax())]
    size = float(np.hypot(*most))
    return _main_axis(vector), most / size if size else np.array([1.0, 0.0])


def _main_axis(vector: np.ndarray) -> np.ndarray:
    """The direction (2,) in which a vector (2, N) varies the most."""
    x, y = vector - vector.mean(axis=1, keepdims=True)
    angle = math.atan2(2 * float(x @ y), float(x @ x - y @ y)) / 2
    return np.array([math.cos(angle), math.sin(angle)])


def _largest_magnitude(time: np.ndarray, signal: np.ndarray, rate: np.ndarray) -> float:
    return max(_largest(time, signal, rate), _largest(time, -signal, -rate))


def _span(time: np.ndarray, signal: np.ndarray, rate: np.ndarray) -> float:
    return _largest(time, signal, rate) + _largest(time, -signal, -rate)


def _largest(time: np.ndarray, signal: np.ndarray, rate: np.ndarray) -> float:
    return float(interval_maxima(time, signal, rate).max()) if len(time) > 1 else float(signal.max())


def _without_short_steps(
    time: np.ndarray, place: np.ndarray, velocity: np.ndarray
) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """Samples without those that repeat a time, as at the end of a leg: their difference is rounding."""
    steps = np.diff(time)
    keep = np.concatenate([[True], steps > _SHORT * np.median(steps)])
    return time[keep], place[:, keep], velocity[:, keep]


def _second_and_third_derivatives(time: np.ndarray, q: np.ndarray, v: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The second and third derivatives (n, N - 2) at the inner samples: of the polynomial of fifth degree that has the values
    and velocities of a sample and its neighbours."""
    before, after = time[:-2] - time[1:-1], time[2:] - time[1:-1]
    centre, rate = q[:, 1:-1], v[:, 1:-1]
    rows, differences = [], []
    for h, place, speed in ((before, q[:, :-2], v[:, :-2]), (after, q[:, 2:], v[:, 2:])):
        s = h / after  # of the order of 1, so that the equations are well scaled
        rows += [np.array([s**k for k in range(2, 6)]), np.array([k * s ** (k - 1) for k in range(2, 6)])]
        differences += [place - centre - rate * h, (speed - rate) * after]
    matrix, right = np.array(rows).transpose(2, 0, 1), np.array(differences).transpose(2, 0, 1)
    coefficients = np.linalg.solve(matrix, right)
    return 2 * coefficients[:, 0].T / after**2, 6 * coefficients[:, 1].T / after**3
