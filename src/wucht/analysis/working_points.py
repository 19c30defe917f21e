"""Driving and braking torques of a rotor over its speed, and its steady speeds: 002 (3.51), figure 3.2b."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from typing import TypeVar

import numpy as np
import sympy as sp

from wucht.analysis.vibration import ForcedVibration, Vibration, unbalances
from wucht.machines.machine import Machine
from wucht.machines.operation import (
    free_speed,
    has_damped_balancers,
    net_torque,
    operating_speed,
    sense_of,
    shaft_torques,
    slopes,
)
from wucht.machines.parts.base import Drive, TableModel
from wucht.machines.parts.coulomb_load import CoulombLoad
from wucht.machines.parts.table_load import TableLoad
from wucht.machines.structure import SPEED
from wucht.machines.tree import RotatingBody
from wucht.numerics.zeros_and_peaks import crossings

_TRANSITIONS = 10.0  # times the speed of the transition of dry friction at standstill: slower rotors creep
_NO_DECAY = 1e-6  # of its frequency: a rate below it is rounding
Curve = Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
TableModelT = TypeVar("TableModelT", bound=TableModel)
TOUCHING = 1e-9  # of the torques: where the difference of drive and resistance has so small an extremum, they touch
_CROSSING = 1e-6  # of the torques: residual at a root; it is larger at a pole of the vibration
_AROUND = 1e-3  # of the largest speed: neighbourhood of a working point whose torques are the scale
_BESIDE = 1e-9  # of the largest speed: distance of samples from a jump of the drive's torque
_FAST = 1e9  # rad/s: a net torque at all speeds up to this means a runaway


def curves(machine: Machine, torques: Sequence[sp.Expr]) -> Curve:
    """Torques, expressions in ``SPEED`` and the parameters, as functions of the speeds (N,): values and slopes, (n, N) each."""
    function = machine.function(*torques, *slopes(tuple(torques)), of=SPEED)

    def values(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w = np.atleast_1d(np.asarray(speeds, float))
        every = np.empty((2 * len(torques), *w.shape))
        for row, value in zip(every, function(w), strict=True):
            row[:] = value  # which may be one number for all speeds
        return every[: len(torques)], every[len(torques) :]

    return values


def dry_friction(machine: Machine) -> tuple[float, float]:
    """Torque in N m of all dry friction loads at any speed, and the highest speed in rad/s of their smooth transitions."""
    table_loads = [(load.friction(), load.transition_speed) for load in machine.parts if isinstance(load, TableLoad)]
    dry = [(load.level, load.transition_speed) for load in machine.parts if isinstance(load, CoulombLoad)]
    friction_loads = [(torque, speed) for torque, speed in (*dry, *table_loads) if torque > 0]
    return sum(torque for torque, _ in friction_loads), max((speed for _, speed in friction_loads), default=0.0)


def creep_speed(machine: Machine) -> float:
    """The speed in rad/s below which a rotor under dry friction creeps, which is smooth about standstill; 0 without any."""
    return _TRANSITIONS * dry_friction(machine)[1]


def is_held_at_rest(machine: Machine) -> bool:
    """True if dry friction holds all rotors: their drives do not get them beyond the speed at which they creep."""
    speed, senses = creep_speed(machine), [(sense_of(machine, r), r) for r in machine.rotors]
    if not speed or any(r.coordinate.prescribed_velocity is not None for _, r in senses):
        return False
    return all(sense * net_torque(machine, r)(sense * speed) <= 0 for sense, r in senses)


def energy_scale(machine: Machine) -> float:
    """The kinetic energy of the bodies at operating speed, the size of the works in a run."""
    kinetic = machine.function(machine.structure.kinetic_in_operation, of=SPEED, modules="math")
    energy = float(kinetic(operating_speed(machine))[0])
    return energy if energy > 0 and math.isfinite(energy) else 1.0


def is_only_braked(machine: Machine, fastest: float) -> bool:
    """True if oscillations of all rotors with speeds up to ``fastest`` only lose energy: only constant torques drive them.

    The carrier is not shaken, no speed is prescribed, all free vibrations and balancing bodies are damped, and the torque on
    each shaft, less what it is at rest, acts against every speed.
    """
    is_driven = machine.shaken_coordinate is not None or any(
        r.coordinate.prescribed_velocity is not None for r in machine.rotors
    )
    poles = Vibration.of(machine).poles
    if is_driven or not has_damped_balancers(machine) or not (-poles.real > _NO_DECAY * np.abs(poles)).all():
        return False
    torques, speeds = [net_torque(machine, r) for r in machine.rotors], np.linspace(-fastest, fastest, 201)
    return all((torque(float(w)) - torque(0.0)) * w <= 0 for torque in torques for w in speeds)


def torque_surplus(machine: Machine, vibration: Vibration, phases: np.ndarray, speeds: np.ndarray) -> np.ndarray:
    """Excess (N,) of the torque on the main shaft over the vibration torque at steady speeds, positive in the drive's sense.

    phases: of the bodies that excite the vibration, (n,).
    """
    torque = net_torque(machine, machine.rotor)
    sense = math.copysign(1.0, torque(0.0))
    drive = np.array([sense * torque(sense * float(w)) for w in speeds])
    return np.asarray(drive - vibration.torque(speeds, phases)[0])


def swing_frequency(machine: Machine) -> float:
    """The angular frequency at which the unbalanced bodies oscillate together under gravity; 0 without gravity."""
    gravity = machine.values.get("carrier.gravity", 0.0)
    if not gravity:
        return 0.0
    kinetic = machine.function(machine.structure.kinetic_in_operation, of=SPEED, modules="math")
    square = abs(gravity) * float(np.abs(unbalances(machine)).sum()) / (2 * float(kinetic(1.0)[0]))
    return math.sqrt(square) if math.isfinite(square) else 0.0


@dataclass(frozen=True)
class WorkingPoint:
    """A steady speed. torque: of the drive there. slope, no_load_speed: of the straight line that replaces its characteristic.

    stable: the resistance grows faster with the speed than the drive's torque. tangential: they touch, and do not cross: from
    one side the speed leaves. slip: of an induction motor. At the set speed of a controlled drive the slope is infinite.
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

    forced_vibration: of all bodies turning as fast as the rotor, NaN where there is none. range: of the speed, in
    rad/s. points: evenly spaced over it.
    """

    machine: Machine
    rotor: RotatingBody
    forced_vibration: ForcedVibration
    range: tuple[float, float]
    points: int

    @cached_property
    def _shaft(self) -> Curve:
        """The torques of drives, and of loads and bearings, the carrier at rest."""
        return curves(self.machine, shaft_torques(self.machine, self.rotor))

    @cached_property
    def drives(self) -> list[Drive]:
        """Drives on the rotor and the bodies that turn with it, with the current parameter values."""
        names = {b.name for b in self.machine.group(self.rotor)}
        return [_with_current_values(d, d.path, self.machine.values) for d in self.machine.drives if d.on in names]

    def torques(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Torques of the drives, of loads and bearings, and of the vibration (3, N), and their slopes.

        The first is positive in the direction of positive speeds, the others against it.
        """
        sense = sense_of(self.machine, self.rotor)  # the vibration is that of all bodies turning in their senses
        members = [self.machine.bodies.index(b) for b in self.machine.group(self.rotor)]
        (shaft, shaft_slope), (vibration, slope) = self._shaft(speeds), self.forced_vibration.torque_on(sense * speeds, members)
        return np.vstack([shaft, sense * vibration]), np.vstack([shaft_slope, slope])

    def surplus(self, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Excess (N,) of the drive over load and vibration, in the direction of positive speeds, and its slope."""
        (d, x, v), (dd, dx, dv) = self.torques(speeds)
        return d - x - v, dd - dx - dv

    def _extremes(self, speeds: np.ndarray) -> np.ndarray:
        return crossings(lambda w: self.surplus(w)[1], speeds)

    @cached_property
    def grid(self) -> np.ndarray:
        """The speeds (N,): denser at standstill, resonances and where an induction motor pulls out; all extremes."""
        (low, high), size = self.range, max(map(abs, self.range))
        near = np.concatenate([-np.geomspace(0.5, 1e-5, 60), [0.0], np.geomspace(1e-5, 0.5, 60)])
        resonances = self.forced_vibration.grid(0.0, size, 2)
        pieces = [np.linspace(low, high, self.points), size * near, resonances, -resonances]
        for d in self.drives:
            synchronous, breakdown = d.reduced_synchronous_speed(), d.reduced_breakdown()
            if synchronous is not None and breakdown is not None:
                pieces += [synchronous * (1 + breakdown[0] * near * k) for k in (2, 20)]
        pieces += [self._speeds_beside(set_speed) for set_speed in self._set_speeds]
        speeds = np.unique(np.concatenate(pieces))
        speeds = speeds[(speeds >= low) & (speeds <= high)]
        return np.unique(np.concatenate([speeds, self._extremes(speeds)]))

    @property
    def _set_speeds(self) -> list[float]:
        """The speeds at which a controlled drive on the shaft gives any torque within its limits."""
        return [w for d in self.drives if (w := d.held_speed()) is not None]

    def _speeds_beside(self, speed: float) -> np.ndarray:
        """Speeds just below and above one at which the drive's torque jumps."""
        return speed + np.array([-_BESIDE, _BESIDE]) * max(map(abs, self.range))

    @cached_property
    def _held_speeds(self) -> list[float]:
        """The set speeds in the range at which the required torque is within the drive's limits."""
        low, high = self.range
        inside = [w for w in self._set_speeds if low < w < high]
        return [w for w in inside if (np.sign(self.surplus(self._speeds_beside(w))[0]) == (1, -1)).all()]

    @cached_property
    def working_points(self) -> list[WorkingPoint]:
        """All working points, in increasing order of the speed."""
        grid, ends = self.grid, self.grid[[0, -1]]
        roots = np.unique([*crossings(lambda w: self.surplus(w)[0], grid), *ends[self.surplus(ends)[0] == 0]])
        roots = roots[~np.isin(roots, self._set_speeds)]
        crossing, extremes = roots[self._share(roots) < _CROSSING], self._extremes(grid)
        touching = extremes[self._share(extremes) < TOUCHING]
        # Where the curves cross between an extremum's two neighbours on the grid they do not merely touch.
        at, last = np.searchsorted(grid, touching), len(grid) - 1
        low, high = grid[np.maximum(at - 2, 0)], grid[np.minimum(at + 2, last)]
        touching = touching[~((crossing >= low[:, None]) & (crossing <= high[:, None])).any(axis=1)]
        points = [*((w, False) for w in crossing.tolist()), *((w, True) for w in touching.tolist())]
        crossing_points = [self.point(w, float(self.surplus(np.array([w]))[1][0]) < 0, tangential) for w, tangential in points]
        return sorted([*crossing_points, *map(self._held_point, self._held_speeds)], key=lambda point: point.speed)

    def _share(self, speeds: np.ndarray) -> np.ndarray:
        """The magnitude (N,) of the surplus relative to the torques around, of which it is the difference."""
        around = speeds[:, None] + np.array([0.0, -_AROUND, _AROUND]) * max(map(abs, self.range))
        torques = self.torques(around.ravel())[0].reshape(3, *around.shape)
        surplus, scale = np.abs(self.surplus(speeds)[0]), np.abs(torques).max(axis=(0, 2))
        return np.asarray(np.divide(surplus, scale, out=np.zeros_like(surplus), where=scale > 0))

    def point(self, speed: float, stable: bool, tangential: bool = False) -> WorkingPoint:
        """The working point at a speed that is known to be steady."""
        torque, rise = (float(x[0, 0]) for x in self._shaft(np.array([speed])))
        synchronous = next((w for d in self.drives if (w := d.reduced_synchronous_speed()) is not None), None)
        no_load = speed - torque / rise if rise else math.copysign(math.inf, torque)
        slip = None if synchronous is None else 1 - speed / synchronous
        return WorkingPoint(speed, torque, stable and not tangential, tangential, -rise, no_load, slip)

    def _held_point(self, speed: float) -> WorkingPoint:
        """Working point at a set speed: the torque is that of load and vibration, and the characteristic is vertical."""
        _, load, vibration = self.torques(np.array([speed]))[0][:, 0].tolist()
        return WorkingPoint(speed, load + vibration, True, False, math.inf, speed, None)

    @property
    def breakdown(self) -> tuple[float, float, float] | None:
        """Slip, speed and torque of the breakdown of an induction motor on the shaft, None where there is none."""
        return next((b for d in self.drives if (b := d.reduced_breakdown()) is not None), None)

    @property
    def runaway(self) -> bool:
        """True if the drive's torque exceeds the load at every speed, without vibration: the series motor, 002 (2.105)."""
        fast = np.concatenate([[0.0], np.geomspace(1e-3, _FAST, 400)])
        torques = (sense * self._shaft(sense * fast)[0] for sense in (1, -1))
        exceeds = any(bool((drive - losses > 0).all()) for drive, losses in torques)
        return exceeds and free_speed(self.machine, self.rotor) is None


def _with_current_values(part: TableModelT, path: str, values: Mapping[str, float]) -> TableModelT:
    """A part, or a table in one, with the current values of its parameters."""
    pairs = [(key, f"{path}.{key}", value) for key, value in part]
    updates = {k: _with_current_values(x, p, values) if isinstance(x, TableModel) else values.get(p, x) for k, p, x in pairs}
    return part.model_copy(update=updates)
