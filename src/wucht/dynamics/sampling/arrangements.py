"""Arrangements of the bodies of a track, at random: uniform over all in which no two of them overlap.

The gaps between neighbours on a circle add up to what the bodies leave free. Where all angles of bodies that do not overlap are
equally likely, the first one is anywhere on the circle, the other ones are in any order, and the gaps are distributed as the
spacings of independent uniform points: R. Pyke, "Spacings", Journal of the Royal Statistical Society B 27 (1965) 395-449,
section 2; for bodies with a width L. Tonks, Physical Review 50 (1936) 955-963. So nothing is drawn in vain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from wucht.dynamics.run_ups.run_variations import VariedQuantity, varied_quantity
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.machines.parts.track import TrackBody
from wucht.machines.tracks import angular_width

PREFIX = "tracks."  # of the name of a track among random quantities
UNIFORM = "uniform"  # its definition
_LEAST_FREE = 1e-6  # rad


@dataclass(frozen=True)
class Arrangement:
    """Angles of the bodies of a track, drawn together.

    Attributes
    ----------
    widths : tuple of tuple of float
        Angle between the centres of each two bodies that touch, in rad.
    """

    widths: tuple[tuple[float, ...], ...]

    @property
    def dimensions(self) -> int:
        """See ``JointDistribution``."""
        return len(self.widths)

    def values(self, shares: np.ndarray) -> np.ndarray:
        """Angles (n, M) of the n bodies in rad, from the body turned about, at points (M, n) of the unit cube.

        The first coordinate is the place of the first body, as a share of the circle; the other ones are the places of the
        other bodies ahead of it, as shares of the free angle. Bodies that differ leave a free angle that depends on their
        order: each order is equally likely.
        """
        ahead = np.sort(shares[:, 1:], axis=1)
        order = np.concatenate([np.zeros((len(shares), 1), int), 1 + np.argsort(shares[:, 1:], axis=1)], axis=1)
        steps = np.array(self.widths)[order, np.roll(order, -1, axis=1)] if self.dimensions > 1 else np.zeros((len(shares), 1))
        free = 2 * math.pi - steps.sum(axis=1, keepdims=True)
        angles = np.empty(shares.shape)
        first = 2 * math.pi * shares[:, :1]
        places = np.concatenate([first, first + np.cumsum(steps[:, :-1], axis=1) + free * ahead], axis=1)
        np.put_along_axis(angles, order, places, axis=1)
        return angles.T


def _bodies(machine: Machine, name: str, location: str) -> list[TrackBody]:
    """Return the bodies of the track of a random quantity. Raises ``InputError`` at ``location`` if there is none."""
    by_track = dict[str, list[TrackBody]]()
    for part in machine.parts:
        if isinstance(part, TrackBody) and part.track is not None:
            by_track.setdefault(f"{PREFIX}{part.track}", []).append(part)
    if name not in by_track:
        hint = nearest(name, by_track) if by_track else "no body of the machine has a track"
        raise InputError(location, UNIFORM, f"{name!r} is not a track of the machine; {hint}", code="unknown-track")
    return by_track[name]


def arrangement_of(machine: Machine, name: str, location: str) -> Arrangement:
    """Return the arrangement of a track, ``tracks.NAME``. Raises ``InputError`` at ``location`` where nothing is free on it."""
    bodies = _bodies(machine, name, location)
    # Two unlike bodies that touch fill no more than half of what two pairs of like ones do: asin is convex.
    if len(bodies) > 1 and 2 * math.pi - sum(angular_width(b, b) for b in bodies) < _LEAST_FREE:
        requirement = f"the {len(bodies)} bodies of this track fill its circle, and nothing is free to be random"
        raise InputError(location, UNIFORM, requirement, code="full-track")
    return Arrangement(tuple(tuple(angular_width(a, b) for b in bodies) for a in bodies))


def arranged_quantities(machine: Machine, name: str) -> tuple[VariedQuantity, ...]:
    """Return the start angles of the bodies of a track, ``tracks.NAME``. Raises ``InputError`` where a drive prescribes one."""
    location = f"study.random.{name}"
    states = [varied_quantity(machine, b.name, f"random.{name}") for b in _bodies(machine, name, location)]
    return tuple(VariedQuantity(f"{name}.{v.name}", v.state, v.description, v.unit) for v in states)
