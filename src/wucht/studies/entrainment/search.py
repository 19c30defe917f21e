"""The search of the study ``entrainment``: equilibria of the slow equations, runs from the start, periodic motions."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Protocol

import numpy as np

from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.vibration import sense_of
from wucht.studies.entrainment.along import DETUNING, MOTION, Along, along_of, no_load_speed, widest
from wucht.studies.entrainment.branches import Branch, Interval, Path
from wucht.studies.entrainment.orbits import OrbitAt, Orbits
from wucht.studies.entrainment.runs import Band, RunAt, Runs, band_from_start
from wucht.studies.entrainment.slow import Slow
from wucht.studies.locking import frequency_of
from wucht.studies.run_up.study import RunUp, prepared

if TYPE_CHECKING:
    from wucht.studies.entrainment.study import Entrainment

_RESOLUTION = 1e-5  # of the range
_MARGIN = 0.2  # of the band of existence: how far beyond it is looked
_FIRST, _LARGEST = 0.5, 3.0  # of the threshold, times it or the machine's own amplitude: where more only helps
_ORBITS = 8  # to each side of the seed
_BISECTIONS = 70  # expected, for the progress
_DOUBLINGS = 8


class Steps(Protocol):
    """Told of every step that is done."""

    def __call__(self) -> None: ...  # noqa: D102
    def watch(self) -> None: ...  # noqa: D102
    def to(self, done: int) -> None: ...  # noqa: D102
    def end(self) -> None: ...  # noqa: D102


def expected_steps(points: int) -> int:
    """How many steps a search with so many runs from the start has."""
    return 3 + points + _BISECTIONS + 2 * _ORBITS


@dataclass
class Record:
    """What has been found so far. chosen: the stable stretch of the slow equations that the question is about.

    runs: from the start, own the one with the machine's own value. orbits: periodic motions, own_orbit likewise. ends: where
    those end below and above, None where beyond the range. threshold: the least amplitude of the vibration.
    """

    range: tuple[float, float] | None = None
    own: RunAt | None = None
    slow: Slow | None = None
    branches: list[Branch] = field(default_factory=list)
    intervals: list[Interval] = field(default_factory=list)
    chosen: Interval | None = None
    equilibrium: np.ndarray | None = None
    runs: list[RunAt] = field(default_factory=list)
    band: Band | None = None
    orbits: list[OrbitAt] = field(default_factory=list)
    names: list[str] = field(default_factory=list)
    own_orbit: OrbitAt | None = None
    ends: tuple[float | None, float | None] = (None, None)
    threshold: float | None = None
    resolution: float = 0.0
    warnings: list[str] = field(default_factory=list)
    failure: str | None = None
    interrupted: bool = False


def search(
    machine: Machine,
    question: Entrainment,
    along: Along,
    asked: RunUp,
    record: Record,
    steps: Steps,
    known: Sequence[RunAt] = (),
) -> None:
    """Find it all, step by step, into ``record``. known: runs that need not be made again.

    Raises ``InputError`` where the range cannot be chosen.
    """
    runs = Runs(machine, along, asked, steps.watch, known)
    record.own = runs(along.own)
    steps()
    if record.own.failure is not None:
        record.failure = record.own.failure
        return
    senses = runs.senses = _senses(machine, record.own, question)
    limits = question.range or widest(machine, along)
    assert limits is not None
    limits = min(limits[0], along.own), max(limits[1], along.own)
    _slow_side(machine, along, senses, limits, question, record)
    steps()
    if record.slow is None and question.range is None:
        raise InputError("study.range", None, f"this key is missing, and cannot be chosen: {record.warnings[-1]}")
    record.range = question.range or _shown(along, record, limits)
    record.resolution = question.resolution or _RESOLUTION * (record.range[1] - record.range[0])
    if record.slow is not None and record.equilibrium is not None:
        runs.rate = -float(record.slow.eigenvalues(record.equilibrium, _near(along.own, record.chosen)).real.max())
        if runs.until > 1.5 * record.own.end_time:
            record.own = runs(along.own)

    def note(run: RunAt) -> None:
        record.runs = sorted([*record.runs, run], key=lambda r: r.value)
        if run.failure is not None:
            record.warnings.append(f"at {along.name} = {run.value:.6g}: {run.failure}")
        steps()

    for value in np.linspace(*record.range, question.points):
        note(record.own if value == along.own else runs(float(value)))
    if not any(r.value == along.own for r in record.runs):
        note(record.own)
    record.band = band_from_start(runs, list(record.runs), along.own, record.resolution, note)
    steps.to(3 + question.points + _BISECTIONS)
    _full_side(machine, along, senses, record, steps)
    if machine.shaken is not None and along.name != MOTION:
        record.threshold = _threshold(machine, senses, record)
    elif along.name == MOTION and record.chosen is not None and record.chosen.low.kind != "range":
        record.threshold = record.chosen.low.value
    steps.end()


def _senses(machine: Machine, own: RunAt, question: Entrainment) -> dict[str, float]:
    """In which sense the bodies turn: as in the run that is taken along, as they start, or as they are driven."""
    _, start = prepared(machine, RunUp(start=question.start))
    found: dict[str, float] = {}
    for rotor in machine.rotors:
        speed = own.speeds[rotor.name] if own.taken else 0.0
        speed = speed or float(start[machine.state_names.index(rotor.coordinate.velocity.name)])
        found[rotor.name] = math.copysign(1.0, speed) if speed else sense_of(machine, rotor)
    by_name = {b.name: b for b in machine.bodies}
    for body in machine.bodies:
        root = body
        while root.about is not None:
            root = by_name[root.about]
        found[body.name] = found[root.name]
    return found


def _slow_side(
    machine: Machine,
    along: Along,
    senses: Mapping[str, float],
    limits: tuple[float, float],
    question: Entrainment,
    record: Record,
) -> None:
    steady = replace(machine.at(machine.corners[-1]), schedules=())
    try:
        slow = record.slow = Slow(steady, along, senses, limits)
        record.warnings += [w for w in slow.slow.warnings if w not in record.warnings]
    except InputError as error:
        record.warnings.append(f"the slow equations are left out: {error.allowed}")
        return
    path = Path(slow)
    more = None
    if record.own is not None and record.own.taken:
        names = {b.coordinate.position.name: b.name for b in machine.bodies}
        angles = {names[n]: float(x) for n, x in zip(machine.state_names, record.own.end_state, strict=True) if n in names}
        if machine.shaken is not None:  # the phase to the vibration counts from where that is now
            turned = record.own.end_time * slow.pace
            angles = {n: a - senses[n] * turned for n, a in angles.items()}
        speeds = dict.fromkeys(angles, abs(record.own.mean_speed))
        speeds = {n: senses[n] * w for n, w in speeds.items()}
        more = slow.slow.state(angles, speeds)[:, None]
    record.branches = path.branches(_values(machine, along, senses, limits, question), more)
    record.intervals = path.intervals(record.branches)
    record.chosen = _chosen(record, along.own, more)
    if record.chosen is None:
        return
    b, points = record.branches[record.chosen.branch], record.chosen.points
    nearest = int(points[np.abs(b.values[points] - along.own).argmin()])
    value = _near(along.own, record.chosen)
    found = [s for s in slow.equilibria(value, b.states[:, [nearest]]) if slow.stable(s, value)]
    record.equilibrium = min(found, key=lambda s: slow.distance(s, b.states[:, nearest]), default=b.states[:, nearest])


def _near(value: float, chosen: Interval | None) -> float:
    """A value, or the nearest one well inside the stretch."""
    if chosen is None or chosen.low.value < value < chosen.high.value:
        return value
    width = chosen.high.value - chosen.low.value
    return float(np.clip(value, chosen.low.value + 0.1 * width, chosen.high.value - 0.1 * width))


def _values(
    machine: Machine, along: Along, senses: Mapping[str, float], limits: tuple[float, float], question: Entrainment
) -> np.ndarray:
    """Where equilibria are looked for: at the machine's own value, and where nothing must be taken along by force."""
    found = [along.own]
    if along.name == DETUNING:
        found.append(0.0)
    elif along.name == MOTION:
        found += [along.own * 2.0**k for k in range(1, 4)]
    elif along.name.endswith(".no_load_speed"):
        frequency = frequency_of(machine)
        mine = (
            next(r for r in machine.rotors if no_load_speed(machine, r) == along.name) if frequency is None else machine.rotor
        )
        paths = [no_load_speed(machine, r) for r in machine.rotors if r is not mine]
        others = [abs(machine.values[p]) for p in paths if p is not None]
        equal = frequency or (float(np.mean(others)) if others else abs(along.own))
        found.append(senses[mine.name] * equal)
    if question.range is not None:
        found += np.linspace(*limits, 9).tolist()
    return np.array([v for v in dict.fromkeys(found) if limits[0] <= v <= limits[1]])


def _chosen(record: Record, own: float, more: np.ndarray | None) -> Interval | None:
    """The stretch on which the machine is; else that which is nearest, and of several the widest."""
    slow = record.slow
    if slow is None:
        return None
    distance = slow.distance

    def order(i: Interval) -> tuple[float, float, float]:
        away = max(i.low.value - own, own - i.high.value, 0.0)
        b = record.branches[i.branch]
        nearest = int(i.points[np.abs(b.values[i.points] - own).argmin()])
        apart = distance(b.states[:, nearest], more[:, 0]) if more is not None else 0.0
        return away, round(apart, 3), i.low.value - i.high.value

    return min(record.intervals, key=order, default=None)


def _shown(along: Along, record: Record, limits: tuple[float, float]) -> tuple[float, float]:
    """The range: the band of existence and a margin, the machine's own value included."""
    low, high = (record.chosen.low, record.chosen.high) if record.chosen is not None else (None, None)
    if low is None or high is None:
        reach = max(abs(along.own), (limits[1] - limits[0]) / 100)
        return max(along.own - reach, limits[0]), min(along.own + reach, limits[1])
    if along.name == MOTION:
        return _FIRST * low.value, _LARGEST * max(along.own, low.value if low.kind != "range" else 0.0)
    ends = [low.value, high.value, along.own]
    margin = _MARGIN * (max(ends) - min(ends))
    return max(min(ends) - margin, limits[0]), min(max(ends) + margin, limits[1])


def _full_side(machine: Machine, along: Along, senses: dict[str, float], record: Record, steps: Steps) -> None:
    """Periodic motions of the full equations from the machine's own on, or from the run nearest to it that is taken along."""
    taken = [r for r in record.runs if r.taken]
    seed_run = min(taken, key=lambda r: abs(r.value - along.own), default=None)
    if seed_run is None or record.range is None:
        return
    orbits = Orbits(machine.at(seed_run.end_time), along, senses, seed_run.end_time, RunUp().tolerance)
    record.names = orbits.names
    try:
        seed = orbits(seed_run.value, seed_run.end_state, abs(seed_run.mean_speed))
    except WuchtError as error:
        record.warnings.append(f"at {along.name} = {seed_run.value:.6g}: {error}")
        return
    record.own_orbit = seed if seed.value == along.own else None

    def note(orbit: OrbitAt) -> None:
        record.orbits = sorted([*record.orbits, orbit], key=lambda o: o.value)
        steps()

    note(seed)
    ends: list[float | None] = []
    for end, edge in zip(record.range, _edges(record), strict=True):
        inside = np.linspace(seed.value, edge, _ORBITS + 1)[1:-1].tolist() if edge != seed.value else []
        goals = [*(v for v in inside if v not in (seed.value, end)), *([end] if end != seed.value else [])]
        ends.append(orbits.followed(seed, goals, record.resolution, note))
    record.ends = ends[0], ends[1]


def _edges(record: Record) -> tuple[float, float]:
    """Between which values periodic motions are expected: those of the slow equations, within the range."""
    assert record.range is not None
    low, high = record.range
    if record.chosen is None:
        return low, high
    return max(low, record.chosen.low.value), min(high, record.chosen.high.value)


def _threshold(machine: Machine, senses: Mapping[str, float], record: Record) -> float | None:
    """The least amplitude of the vibration that takes the main rotor along against its drive and its bearing: 001 (25)."""
    if record.slow is None:
        return None
    own = along_of(machine, MOTION)
    if not own.own > 0:
        return None
    steady = replace(machine.at(machine.corners[-1]), schedules=())
    for k in range(_DOUBLINGS):
        largest = own.own * 2.0**k
        path = Path(Slow(steady, own, senses, (0.0, largest * 1.001)))
        stable = [i for i in path.intervals(path.branches(np.array([largest]), None)) if i.high.kind == "range"]
        if stable:
            return min(i.low.value for i in stable)
    return None
