"""What the motion of a machine shows: the orbit of its axis, and the balance of its energy."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from wucht.machines.machine import LOST, SUPPLIED, Machine
from wucht.machines.operation import axis_at_rest
from wucht.machines.schedules import SCHEDULED
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.peaks import interval_peaks

_AT_REST = 1e-9  # of the largest: rounding
Rows = Mapping[str, np.ndarray]


def rows_of(compiled: CompiledSystem, t: Trajectory) -> dict[str, np.ndarray]:
    """The states and outputs (N,) of a trajectory, by name."""
    return dict(zip(compiled.system.state_names, t.states, strict=True)) | compiled.outputs(t.time, t.states, t.parameters)


@dataclass(frozen=True)
class Orbit:
    """The motion of the main rotor's axis about where it rests: offset and velocity (m, N), in the directions it has."""

    time: np.ndarray
    offset: np.ndarray
    velocity: np.ndarray

    @classmethod
    def of(cls, machine: Machine, time: np.ndarray, rows: Rows, at_rest: Mapping[str, float] | None = None) -> Orbit:
        """From the outputs of the machine's System. at_rest: where the axis rests, if that is known already."""
        rest, shape = at_rest or axis_at_rest(machine), (len(machine.orbit), len(time))
        offset = np.array([rows[f"orbit.{n}"] - rest[n] for n in machine.orbit]).reshape(shape)
        return cls(time, offset, np.array([rows[f"orbit.v{n}"] for n in machine.orbit]).reshape(shape))

    @property
    def distance(self) -> np.ndarray:
        """From where the axis rests (N,)."""
        return np.asarray(np.hypot.reduce(self.offset, axis=0))

    @property
    def square(self) -> np.ndarray:
        """Of the distance (N,)."""
        return np.asarray((self.offset * self.offset).sum(axis=0))

    @property
    def square_rate(self) -> np.ndarray:
        """Its derivative (N,)."""
        return np.asarray(2 * (self.offset * self.velocity).sum(axis=0))

    @property
    def begins_at_rest(self) -> bool:
        """Whether the axis rests in the first sample."""
        both = (self.offset, self.velocity)
        return all(bool((np.abs(x[:, 0]) <= _AT_REST * np.abs(x).max(initial=0.0)).all()) for x in both)

    @property
    def peaks(self) -> np.ndarray:
        """The largest distance (N,) between each sample and its neighbours."""
        return np.asarray(np.sqrt(np.maximum(interval_peaks(self.time, self.square, self.square_rate), 0.0)))


def balanced(before: EnergyBalance, stored: np.ndarray, works: Rows) -> tuple[EnergyBalance, np.ndarray]:
    """The energy balance of the contract after a part of the motion, and the residual (N,) over it.

    stored: energy (N,). works: since the start of the run, by quadrature; what a schedule carries in may be missing.
    """
    carried = works.get(SCHEDULED, np.zeros(len(stored)))
    return before.after(stored, np.array([works[SUPPLIED], carried]), works[LOST])
