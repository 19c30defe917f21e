"""What is kept of a coast-down: few rows of the whole run, the speed averaged over each turn, and when it had halved."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

import numpy as np

from wucht.machines.machine import LOST, SUPPLIED, Machine
from wucht.machines.schedules import SCHEDULED
from wucht.machines.static import static_position
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.peaks import interval_peaks
from wucht.numerics.turns import PER_TURN, turns

MOST_ROWS = 8000
ROW = ("time", "angle", "speed", "min_speed", "max_speed", "amplitude", "energy_residual", "dissipated_work")


@dataclass
class Record:
    """Reduces a run leg by leg.

    rows: (time, angle, speed, least and largest speed since the row before, largest amplitude since, energy residual, energy
    lost). turn_time, turn_speed: in the middle of each turn, up to the first reversal. half_time: when the speed averaged over
    a turn has fallen to half of ``start_speed``. tail: time, angle and speed (3, k) that are not in a whole turn yet. legs:
    how many whole ones. stored: the energy at the start; scale: the largest so far.
    """

    machine: Machine
    flow: CompiledSystem
    start_speed: float
    rows: dict[str, list[float]] = field(default_factory=lambda: {n: [] for n in ROW})
    turn_time: list[float] = field(default_factory=list)
    turn_speed: list[float] = field(default_factory=list)
    half_time: float | None = None
    reversal_time: float | None = None
    swings: int = 0
    legs: int = 0
    stride: float = 0.0
    tail: np.ndarray = field(default_factory=lambda: np.empty((3, 0)))
    stored: float = math.nan
    scale: float = 0.0

    def add(self, t: Trajectory) -> None:
        """Take in the next leg, which begins with the last sample of the one before."""
        row = dict(zip(self.flow.system.state_names, t.states, strict=True)) | self.flow.outputs(t.time, t.states, t.parameters)
        rotor = self.machine.rotor.coordinate
        angle, speed = row[rotor.position.name], row[rotor.velocity.name]
        self.legs += int(not t.interrupted)
        self.swings += len(t.hits)
        if self.reversal_time is None:
            if t.hits:
                self.reversal_time = t.hits[0].time
            self._average(np.array([t.time, angle, speed]))
        self._keep(t, row, angle, speed)

    def column(self, name: str) -> np.ndarray:
        """One column of the rows."""
        return np.array(self.rows[name])

    def _average(self, dense: np.ndarray) -> None:
        """Turn by turn, with what the leg before left over."""
        joined = np.concatenate([self.tail, dense[:, int(self.tail.shape[1] > 0) :]], axis=1)
        sense = math.copysign(1.0, self.start_speed)
        back = np.flatnonzero(sense * joined[2] <= 0)
        joined = joined[:, : back[0]] if len(back) else joined
        found = turns(joined[0], joined[1], joined[2], {})
        if not len(found.time):
            if self.half_time is None:
                self._halved(joined[0], joined[2], 2)
            self.tail = joined
            return
        if self.half_time is None:
            self._halved(found.time, found.speed, 2 * PER_TURN)
        last = self.turn_time[-1] if self.turn_time else -math.inf
        whole = found.time[::PER_TURN] > last + 0.5 * 2 * math.pi / np.abs(found.speed[::PER_TURN])
        self.turn_time += found.time[::PER_TURN][whole].tolist()
        self.turn_speed += found.speed[::PER_TURN][whole].tolist()
        kept = np.abs(joined[1, -1] - joined[1]) < 8 * math.pi
        self.tail = joined[:, kept]

    def _halved(self, time: np.ndarray, speed: np.ndarray, reach: int) -> None:
        """The root of the cubic through the points before and after the crossing, ``reach`` each.

        They are averages over a turn; before there is one whole turn, the speed itself.
        """
        over = np.abs(speed) - abs(self.start_speed) / 2
        below = np.flatnonzero((over[:-1] > 0) & (over[1:] <= 0))
        if not len(below):
            return
        near = slice(max(0, int(below[0]) - reach), int(below[0]) + reach + 2)
        t, y, i = time[near], over[near], int(below[0])
        straight = time[i] + over[i] / (over[i] - over[i + 1]) * (time[i + 1] - time[i])
        if len(t) < 4:
            self.half_time = float(straight)
            return
        roots = np.polynomial.Polynomial.fit(t, y, 3).roots()
        real = roots[np.abs(roots.imag) < 1e-9 * np.abs(roots).max()].real
        self.half_time = float(min(real, key=lambda r: abs(r - straight))) if len(real) else float(straight)

    def _keep(self, t: Trajectory, row: dict[str, np.ndarray], angle: np.ndarray, speed: np.ndarray) -> None:
        residual, amplitude = self._energy(t, row["stored_energy"]), self._amplitude(t, row)
        width = max(1, round(self.stride / (t.time[1] - t.time[0]))) if len(t.time) > 1 else 1
        first = int(bool(self.rows["time"]))
        ends = np.unique([*range(0 if not first else width, len(t.time), width), len(t.time) - 1])
        begin = 0
        for end in ends:
            part = slice(begin, end + 1)
            values = (
                t.time[end], angle[end], speed[end], speed[part].min(), speed[part].max(), amplitude[part].max(),
                residual[end], t.quadratures[LOST][end],
            )  # fmt: skip
            for name, value in zip(ROW, values, strict=True):
                self.rows[name].append(float(value))
            begin = end
        if len(self.rows["time"]) > MOST_ROWS:
            self._thin()

    def _thin(self) -> None:
        """Every second row; the extremes of both stay."""
        r = self.rows
        pick = {"min_speed": min, "max_speed": max, "amplitude": max}
        for name in ROW:
            rest = r[name][1:]
            pairs = zip(rest[0::2], rest[1::2], strict=False)
            odd = rest[-1:] if len(rest) % 2 else []
            r[name] = [r[name][0], *(pick[name](p) if name in pick else p[1] for p in pairs), *odd]
        self.stride *= 2

    def _amplitude(self, t: Trajectory, row: dict[str, np.ndarray]) -> np.ndarray:
        names = list(self.machine.orbit)
        if not names:
            return np.zeros(len(t.time))
        offset = np.array([row[f"orbit.{n}"] for n in names]) - np.array(self._rest)[:, None]
        rate = np.array([row[f"orbit.v{n}"] for n in names])
        peaks = interval_peaks(t.time, (offset**2).sum(axis=0), 2 * (offset * rate).sum(axis=0))
        found: np.ndarray = np.sqrt(np.maximum(peaks, 0.0))
        return found

    @property
    def _rest(self) -> list[float]:
        at = dict(zip((c.position for c in self.machine.carrier), static_position(self.machine), strict=True))
        known = at | self.machine.numbers
        return [float(x.xreplace(known)) for x, _ in self.machine.orbit.values()]

    def _energy(self, t: Trajectory, stored: np.ndarray) -> np.ndarray:
        supplied, lost = t.quadratures[SUPPLIED], t.quadratures[LOST]
        carried = t.quadratures.get(SCHEDULED, np.zeros(len(stored)))
        if math.isnan(self.stored):
            self.stored = float(stored[0])
        self.scale = max(self.scale, *(float(np.abs(x).max(initial=0.0)) for x in (stored, supplied, carried))) or 1.0
        found: np.ndarray = np.abs(supplied + carried - lost - (stored - self.stored)) / self.scale
        return found
