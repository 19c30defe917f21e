"""The steady speeds of a shaft: where the drive's torque equals that of load and vibration. 002 (3.51), figure 3.2b."""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from wucht.analysis.forced import Forced
from wucht.analysis.shaft import Shaft
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, sense_of
from wucht.machines.parts.base import Drive
from wucht.machines.tree import RotatingBody
from wucht.numerics.zeros import crossings

TOUCHING = 1e-9  # of the torques: where the difference of drive and resistance has an extremum so small, they touch
_AROUND = 1e-3  # of the largest speed: how far around a working point torques are compared with
_FAST = 1e9  # rad/s: a torque left at all speeds up to this meets no load


@dataclass(frozen=True)
class WorkingPoint:
    """A steady speed. torque: of the drive there. slope, no_load_speed: of the straight line that replaces its characteristic.

    stable: the resistance grows faster with the speed than the drive's torque. tangential: they touch, and do not cross: from
    one side the speed leaves. slip: of an induction motor.
    """

    speed: float
    torque: float
    stable: bool
    tangential: bool
    slope: float
    no_load_speed: float
    slip: float | None


@dataclass(frozen=True)
class TorqueCurves:
    """The torques on a rotor's shaft over its speed, signed.

    forced: the vibration, of all bodies turning as fast as the rotor. range: of the speed, in rad/s. points: evenly spaced
    over it.
    """

    machine: Machine
    rotor: RotatingBody
    forced: Forced
    range: tuple[float, float]
    points: int

    @cached_property
    def shaft(self) -> Shaft:
        """Drive and losses."""
        return Shaft.of(self.machine, self.rotor)

    @cached_property
    def sense(self) -> float:
        """Of the rotor in operation: its vibration is that of all bodies turning in their senses."""
        return sense_of(self.machine, self.rotor)

    @cached_property
    def drives(self) -> list[Drive]:
        """On the rotor and what turns with it, with the parameters' present values."""
        names = {b.name for b in self.machine.group(self.rotor)}
        return [_present(d, self.machine) for d in self.machine.drives if d.on in names]

    def vibration(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The torque (N,) of the vibration against positive speeds, and its slope."""
        if not self.machine.free_carrier:
            return np.zeros(len(speeds)), np.zeros(len(speeds))
        members = [self.machine.bodies.index(b) for b in self.machine.group(self.rotor)]
        torque, slope = self.forced.torque_on(self.sense * speeds, members)
        return self.sense * torque, slope

    def surplus(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What drive leaves over load and vibration (N,), in the direction of positive speeds, and its slope."""
        (d, dd), (x, dx), (v, dv) = self.shaft.drive(speeds), self.shaft.losses(speeds), self.vibration(speeds)
        return d - x - v, dd - dx - dv

    @cached_property
    def grid(self) -> np.ndarray:
        """The speeds (N,): denser at standstill, resonances and where an induction motor pulls out; all extremes."""
        (low, high), size = self.range, max(map(abs, self.range))
        near = np.concatenate([-np.geomspace(0.5, 1e-5, 60), [0.0], np.geomspace(1e-5, 0.5, 60)])
        resonances = self.forced.grid(0.0, size, 2) if self.machine.free_carrier else np.empty(0)
        pieces = [np.linspace(low, high, self.points), size * near, resonances, -resonances]
        for d in self.drives:
            synchronous, breakdown = d.synchronous_speed(), d.breakdown()
            if synchronous is not None and breakdown is not None:
                pieces += [synchronous * (1 + breakdown[0] * near * k) for k in (2, 20)]
        speeds = np.unique(np.concatenate(pieces))
        speeds = speeds[(speeds >= low) & (speeds <= high)]
        return np.unique(np.concatenate([speeds, crossings(lambda w: self.surplus(w)[1], speeds)]))

    @cached_property
    def working_points(self) -> list[WorkingPoint]:
        """All of them, in increasing order of the speed."""
        grid = self.grid
        value, _ = self.surplus(grid)
        roots = crossings(lambda w: self.surplus(w)[0], grid)
        ends = [float(grid[i]) for i in (0, -1) if value[i] == 0]
        crossing = [float(w) for w in np.unique([*roots, *ends]) if abs(self._share(float(w))) < 1e-6]
        extremes = crossings(lambda w: self.surplus(w)[1], grid)
        touching = [float(w) for w in extremes if abs(self._share(float(w))) < TOUCHING and not self._beside(w, crossing)]
        return sorted((self._point(w, w in touching) for w in [*crossing, *touching]), key=lambda p: p.speed)

    def _beside(self, speed: float, crossing: list[float]) -> bool:
        """Whether the curves cross between an extremum's two neighbours on the grid, so that they do not merely touch."""
        i, last = int(np.searchsorted(self.grid, speed)), len(self.grid) - 1
        low, high = self.grid[max(i - 2, 0)], self.grid[min(i + 2, last)]
        return any(low <= c <= high for c in crossing)

    def _share(self, speed: float) -> float:
        """The surplus, of the torques around there of which it is the difference."""
        at = speed + np.array([0.0, -_AROUND, _AROUND]) * max(map(abs, self.range))
        parts = (self.shaft.drive(at)[0], self.shaft.losses(at)[0], self.vibration(at)[0])
        scale = float(np.abs(parts).max())
        return float(self.surplus(at)[0][0]) / scale if scale else 0.0

    def _point(self, speed: float, tangential: bool) -> WorkingPoint:
        at = np.array([speed])
        (torque, rise), surplus_slope = (float(x[0]) for x in self.shaft.drive(at)), float(self.surplus(at)[1][0])
        synchronous = next((w for d in self.drives if (w := d.synchronous_speed()) is not None), None)
        return WorkingPoint(
            speed,
            torque,
            surplus_slope < 0 and not tangential,
            tangential,
            -rise,
            speed - torque / rise if rise else math.copysign(math.inf, torque),
            None if synchronous is None else 1 - speed / synchronous,
        )

    @cached_property
    def breakdown(self) -> tuple[float, float, float] | None:
        """Slip, speed and torque of the breakdown of an induction motor on the shaft, None where there is none."""
        return next((b for d in self.drives if (b := d.breakdown()) is not None), None)

    @cached_property
    def runaway(self) -> bool:
        """Whether the drive's torque exceeds the load at every speed, without vibration: the series motor, 002 (2.105)."""
        if free_speed(self.machine, self.rotor) is not None:
            return False
        fast = np.concatenate([[0.0], np.geomspace(1e-3, _FAST, 400)])
        left = [sense * (self.shaft.drive(sense * fast)[0] - self.shaft.losses(sense * fast)[0]) for sense in (1, -1)]
        return any(bool((x > 0).all()) for x in left)


def _present(drive: Drive, machine: Machine) -> Drive:
    given = {p.path.removeprefix(f"{drive.path}."): machine.values[p.path] for p in drive.parameters()}
    return drive.model_copy(update={k: v for k, v in given.items() if k in type(drive).model_fields})
