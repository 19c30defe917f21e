"""The Dataset of a torque balance: torques over the speed, the working points, and the summary."""

from __future__ import annotations

import math
from dataclasses import asdict, dataclass
from functools import cached_property
from typing import TYPE_CHECKING

import numpy as np

from wucht.machines.dimensionless import natural_frequencies
from wucht.machines.forced import Forced
from wucht.machines.machine import Machine, Turning
from wucht.machines.parts.base import Drive
from wucht.machines.parts.induction import Induction
from wucht.machines.shaft import Shaft
from wucht.machines.vibration import free_speed, group, sense_of
from wucht.numerics.zeros import crossings
from wucht.results.conventions import variable
from wucht.studies.attributes import attributes
from wucht.studies.steady import left_out

if TYPE_CHECKING:
    import xarray as xr

    from wucht.studies.torque_balance.study import TorqueBalance

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
class Balance:
    """The torques on a rotor's shaft over its speed, signed; ``angles`` of all bodies are absolute."""

    machine: Machine
    rotor: Turning
    angles: np.ndarray
    range: tuple[float, float]
    points: int

    @cached_property
    def forced(self) -> Forced:
        """The vibration."""
        return Forced.of(self.machine, self.angles)

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
        names = {b.name for b in group(self.machine, self.rotor)}
        return [_present(d, self.machine) for d in self.machine.drives if d.on in names]

    def vibration(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """The torque (N,) of the vibration against positive speeds, and its slope."""
        if not self.machine.free_carrier:
            return np.zeros(len(speeds)), np.zeros(len(speeds))
        members = [self.machine.bodies.index(b) for b in group(self.machine, self.rotor)]
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
        found = [np.linspace(low, high, self.points), size * near, resonances, -resonances]
        for d in (d for d in self.drives if isinstance(d, Induction)):
            synchronous = d.synchronous_speed()
            found += [synchronous * (1 + d.breakdown()[0] * near * k) for k in (2, 20)]
        found_ = np.unique(np.concatenate(found))
        found_ = found_[(found_ >= low) & (found_ <= high)]
        return np.unique(np.concatenate([found_, crossings(lambda w: self.surplus(w)[1], found_)]))

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
        motor = next((d for d in self.drives if isinstance(d, Induction)), None)
        return WorkingPoint(
            speed,
            torque,
            surplus_slope < 0 and not tangential,
            tangential,
            -rise,
            speed - torque / rise if rise else math.copysign(math.inf, torque),
            None if motor is None else 1 - speed / motor.synchronous_speed(),
        )

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


def result(
    machine: Machine, question: TorqueBalance, rotor: Turning, angles: np.ndarray, range_: tuple[float, float], begun: float
) -> xr.Dataset:
    """Put a torque balance into a Dataset.

    Coordinates: speed (N), mode, point. Variables: drive_torque, load_torque, vibration_torque, surplus_torque, stable (speed:
    whether the slope of a working point there would be that of a stable one); point_speed, point_torque, point_stable (point);
    free_speed, natural_frequency (mode). begun: ``perf_counter()`` at the beginning.
    """
    import xarray as xr_

    found = Balance(machine, rotor, angles, range_, question.points)
    units, natural, grid = machine.units, natural_frequencies(machine), found.grid
    free, points = free_speed(machine, rotor), found.working_points
    surplus, slope = found.surplus(grid)
    coordinates = {
        "speed": variable("speed", grid, "speed", units.speed),
        "mode": variable("mode", list(natural) or np.empty(0, "U1"), "mode of vibration"),
    }
    data = {
        "drive_torque": variable("speed", found.shaft.drive(grid)[0], "torque of the drive", units.torque),
        "load_torque": variable("speed", found.shaft.losses(grid)[0], "torque of loads and bearings", units.torque),
        "vibration_torque": variable("speed", found.vibration(grid)[0], "torque of the vibration", units.torque),
        "surplus_torque": variable("speed", surplus, "drive less load and vibration", units.torque),
        "stable": variable("speed", (slope < 0).astype(np.int8), "slope of a stable working point"),
        "point_speed": variable("point", [p.speed for p in points], "speed of a working point", units.speed),
        "point_torque": variable("point", [p.torque for p in points], "torque of the drive there", units.torque),
        "point_stable": variable("point", np.array([p.stable for p in points], np.int8), "stable"),
        "free_speed": variable("", math.nan if free is None else free, "speed reached without vibration", units.speed),
        "natural_frequency": variable("mode", list(natural.values()), "natural frequency", units.speed),
    }
    dataset = xr_.Dataset(dict(data.items()), coords=coordinates)
    sentence = _sentence(found)
    summary = {
        "sentence": sentence,
        "on": rotor.name,
        "range": list(range_),
        "working_points": [asdict(p) for p in points],
        "free_speed": free,
        "breakdown": _breakdown(found),
        "runaway": found.runaway,
        "natural_frequencies": natural,
    }
    dataset.attrs |= attributes(machine, question, summary, sentence, _warnings(found), begun)
    return dataset


def _breakdown(found: Balance) -> dict[str, float] | None:
    motor = next((d for d in found.drives if isinstance(d, Induction)), None)
    return None if motor is None else dict(zip(("slip", "speed", "torque"), motor.breakdown(), strict=True))


def _sentence(found: Balance) -> str:
    points = found.working_points
    stable = sum(p.stable for p in points)
    count = f"{len(points)} working points, {stable} of them stable"
    if len(points) == 1:
        count = f"one working point, {'stable' if stable else 'not stable'}"
    if found.runaway:
        away = "without vibration the drive's torque never meets the load: the rotor would run away"
        return f"{away}; with it {'are' if len(points) > 1 else 'is'} {count}" if points else away
    return count if points else "drive, load and vibration meet nowhere in the range"


def _warnings(found: Balance) -> list[str]:
    said, machine = [], found.machine
    if any(p.tangential for p in found.working_points):
        said.append("at a working point the curves only touch: the least change makes two of it or none")
    if len(machine.rotors) > 1:
        said.append(f"all rotors are taken to turn as fast as {found.rotor.name!r}, in the phases of the start")
    return said + left_out(machine)
