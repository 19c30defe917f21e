"""The horizon of a run-up: its duration, its legs, the density of samples, and the events that end it early."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Literal

import numpy as np

from wucht.analysis.time_constants import highest_speed, runaway_limit
from wucht.analysis.working_points import creep_speed, energy_scale, is_held_at_rest, swing_frequency
from wucht.dynamics.run_ups.initial_state import speeds_in
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, free_speed_from, natural_frequencies
from wucht.numerics.flow.compiled_system import DEFAULT_TOLERANCE
from wucht.numerics.flow.events import Event

SAMPLES_PER_TURN = 24
MOST_SAMPLES = 1_000_000  # that are stored of all runs together, of those without a given end five times as many
_MOST_NUMBERS = 30_000_000  # likewise: a quarter of a gigabyte, and several times that while it is put together
_THINNING = 5  # a run of which not all can be stored has so many times fewer
_FIRST_TURNS = 100  # until settled: the first leg, in turns at the highest speed expected; each next leg doubles the run
MOST_TURNS = 25_000  # likewise: of such a run, which ends with the leg in which it has made them
_MOST_DOUBLINGS = math.ceil(math.log2(MOST_TURNS / _FIRST_TURNS))
_FEWEST_SAMPLES = 2000
_FIRST_LEG, _LONG_LEG = 64, 2048  # samples
_SHARE_OF_ALL = 16  # a longer leg is at most this part of the run so far: legs are few, and each keeps the whole observation
_MUCH_SLOWER = 8  # times: where the motion is slower than that, fewer samples are stored
_SETTLED_TOLERANCE = 1e-5
_FASTEST = 10.0  # times the highest natural frequency: the most frequent observation of a body that does not turn
_ROUNDING = 1e-9  # of a time
_MOST_TIMES = 500  # points of schedules at which the machine's speeds are looked up
TURNS_DONE, SPEED_LIMIT = "the turns are done", "speed limit"


@dataclass(frozen=True)
class RunSettings:
    """Settings of a run-up: its duration, equations and accuracy.

    Parameters
    ----------
    until : float, optional
        The end time, in the unit of time of the machine.
    turns : float, optional
        Of the main rotor. Without turns and end time the machine runs until it has settled.
    model : {"full", "slow", "both"}
        The full equations, the averaged ones, or both.
    inertia : bool, optional
        Of the balancing bodies, in the averaged equations; None: as is usual for the machine.
    order : {1, 2}
        Of the averaged equations.
    tolerance : float
        Of the integration.
    speed_limit : float, optional
        The run ends beyond it, in the unit of speed of the machine.
    engine : str, optional
        None for the best that is installed.
    stored_samples : int, optional
        At most, of all ``runs`` together; None: as many as fit into memory.
    runs : int
        The number of runs that share the memory.
    """

    until: float | None = None
    turns: float | None = None
    model: Literal["full", "slow", "both"] = "full"
    inertia: bool | None = None
    order: Literal[1, 2] = 1
    tolerance: float = DEFAULT_TOLERANCE
    speed_limit: float | None = None
    engine: str | None = None
    stored_samples: int | None = None
    runs: int = 1


@dataclass(frozen=True)
class Grid:
    """A leg. samples: evenly, from the last of the leg before on. closest: the least time between stored samples. end: for the
    progress. is_judged: True if the motion is judged at its end."""

    samples: np.ndarray
    closest: float
    end: float
    is_judged: bool


@dataclass(frozen=True)
class Horizon:
    """Time scales and limits of a run.

    step: between samples at the highest speed expected. span: the time of a turn, or of a vibration, as it is expected.
    vibration: the highest frequency. first: the end of the first leg. expected_end: for the progress. samples_per_turn: at the
    highest speed expected. most: samples that are stored. until_settled: the verdict ends the run. energy: the size of the
    works. tolerance: of the integration. events: that end it. warnings: what is doubtful about the question."""

    step: float
    span: float
    vibration: float
    first: float
    expected_end: float
    samples_per_turn: float
    most: int
    until_settled: bool
    energy: float
    tolerance: float
    events: tuple[Event, ...]
    warnings: tuple[str, ...]

    @classmethod
    def of(cls, machine: Machine, settings: RunSettings, initial: np.ndarray) -> Horizon:
        """Return the horizon of a run from an initial state."""
        at = {t: machine.at(t) for t in distinctive_times(machine)}
        natural = [f for m in at.values() for f in (*natural_frequencies(m).values(), swing_frequency(m)) if f > 0]
        highest = {t: highest_speed(m) for t, m in at.items()}  # a balance of losses alone may lie far above what is reached
        free_speeds = [min(abs(free_speed(m, r, t) or 0.0), highest[t]) for t, m in at.items() for r in m.rotors]
        prescribed_coordinates = [b.coordinate for b in machine.bodies if b.coordinate.prescribed_velocity is not None]
        expected_speeds = [*speeds_in(machine, initial).values(), *free_speeds, machine.shaking_frequency or 0.0, *natural]
        expected_speeds += [
            w for c in prescribed_coordinates for w in machine.prescribed_speed(c, np.array(machine.breakpoints))
        ]
        fastest = float(max(map(abs, expected_speeds))) or 1.0
        speed, last = speeds_in(machine, initial)[machine.rotor.name], machine.breakpoints[-1]
        free = free_speed_from(at[last], machine.rotor, speed, last)
        if free and is_held_at_rest(at[last]) and abs(free) <= creep_speed(at[last]):
            free = 0.0  # a creep is no speed that is waited for
        slowest = max(min([abs(free or 0.0) or fastest, *natural]), 1e-3 * fastest)
        turn = 2 * math.pi / fastest
        if settings.until is not None:
            first = end = settings.until
        else:
            end, half_turns = (_FIRST_TURNS * turn, 40) if settings.turns is None else (settings.turns * turn, 8)
            first = max(end, half_turns * math.pi / slowest)
        most = _most_samples(machine, settings, first / turn * SAMPLES_PER_TURN)
        step = first / math.ceil(first / max(turn / SAMPLES_PER_TURN, first / most) * (1 - _ROUNDING))
        until_settled, events = settings.until is None and settings.turns is None, _events(machine, settings, initial)
        warnings = tuple(_warnings(machine, settings, free))
        vibration = max([*natural, machine.shaking_frequency or 0.0])
        span = 2 * math.pi / min(fastest, _FASTEST * max(natural)) if natural else turn
        energy = energy_scale(machine)
        return cls(
            step, span, vibration, first, end, turn / step, most, until_settled, energy, settings.tolerance, events, warnings
        )

    def legs(self, rate: Callable[[], float] | None = None) -> Iterator[Grid]:
        """Yield the legs of a run. rate: the highest frequency of the motion at the end of the leg before; None: as expected.

        Samples are even as long as the motion is not much slower than expected, else a power of two further apart. Without an
        end time the motion is judged each time its duration has doubled. Legs are short at first, and later a share of the
        run, so that an interrupted run loses little.
        """
        share = min(1.0, (1 + _ROUNDING) * self.samples_per_turn / SAMPLES_PER_TURN)  # of all samples, those that are stored
        open_ended = self.until_settled or any(e.name == TURNS_DONE for e in self.events)
        doublings = (math.ceil(self._doublings) if self.until_settled else _MOST_DOUBLINGS) if open_ended else 0
        expected_end = self.longest if self.until_settled else self.expected_end
        begin, size, long = 0.0, max(1, int(_FIRST_LEG * share)), max(1, int(_LONG_LEG * share))
        for goal in (self.first * 2**k for k in range(doublings + 1)):
            lower, last = 0, max(1, round((goal - begin) / self.step))
            step, closest = (goal - begin) / last, goal / self.most
            while lower < last:
                slower = 1.0 if rate is None else 2 * math.pi / (SAMPLES_PER_TURN * rate() * step)
                every = max(_power_of_two(slower) if slower >= _MUCH_SLOWER else 1, _power_of_two(closest / step))
                upper = min(lower + size * every, last)
                samples = begin + step * np.append(np.arange(lower, upper, every), upper)
                samples[-1] = goal if upper == last else samples[-1]
                yield Grid(samples, closest, max(expected_end, goal), open_ended and upper == last)
                lower, size = upper, min(2 * size, max(long, (round(begin / step) + upper) // _SHARE_OF_ALL))
            begin = goal

    @property
    def _doublings(self) -> float:
        """The number of doublings of the first leg after which a run until settled has made the most turns that it may make."""
        return max(0.0, math.log2(MOST_TURNS * self.span / self.first))

    @property
    def turn(self) -> float:
        """The time of a turn at the highest speed expected."""
        return self.step * self.samples_per_turn

    @property
    def longest(self) -> float:
        """The end of a run until settled that does not settle."""
        return self.first * float(2 ** math.ceil(self._doublings))

    @property
    def samples(self) -> float:
        """The approximate greatest number of stored samples."""
        doublings = self._doublings if self.until_settled else 0
        return min(self.first / self.step * 2**doublings, self.most * (1 + doublings / 2))

    def is_decided(self, verdict: Verdict) -> bool:
        """True if a run without an end time may end: it has settled, or never will, or will never make the requested turns."""
        if self.until_settled:
            return verdict.settled_within(_SETTLED_TOLERANCE) or verdict.never_parts
        return verdict.outcome in (Outcome.STOPPED, Outcome.OSCILLATING, Outcome.NOT_STARTED)

    def limit_warnings(self, end: float, verdict: Verdict, unit: str) -> tuple[str, ...]:
        """Return a sentence if a run until settled was ended at its limit without having settled. unit: of its end time."""
        if not self.until_settled or end < self.longest * (1 - _ROUNDING) or self.is_decided(verdict):
            return ()
        at, turns = f"{self.longest:.4g} {unit}".rstrip(), self.longest / self.span
        return (
            f"the machine had not settled when the run was ended at {at}, after {turns:.3g} turns or vibrations at its highest "
            f"frequency: without a given end it is not continued beyond {MOST_TURNS} of them; study.until gives another end",
        )


def _power_of_two(ratio: float) -> int:
    """The largest power of two that is not greater than a ratio, at least 1."""
    return int(2 ** max(0, math.floor(math.log2(ratio))))


def numbers_per_sample(machine: Machine) -> int:
    """The number of values stored per sample: states, works, outputs and what the Dataset derives from them."""
    system = machine.system
    return 2 * len(system.states) + len(system.quadratures) + len(system.outputs) + 8 * len(machine.bodies)


def distinctive_times(machine: Machine) -> list[float]:
    """Return the times at which the machine's speeds are looked up: those of all points of its schedules, or of many points
    those at which a parameter is least or greatest, and the others evenly."""
    times = np.array(machine.breakpoints)
    if len(times) <= _MOST_TIMES:
        return list(machine.breakpoints)
    values = [s.pieces(times) for s in machine.schedules]
    extremes = [find(v) for v in values for find in (np.argmin, np.argmax)]
    evenly = np.linspace(0, len(times) - 1, _MOST_TIMES).round().astype(int)
    return [machine.breakpoints[k] for k in np.unique([*evenly, *extremes])]


def _most_samples(machine: Machine, settings: RunSettings, count: float) -> int:
    """The number of stored samples of a run with which all runs of a study fit into memory. count: of its whole motion.

    A run whose motion cannot be shown by its samples has fewer: its limits are stored apart, and the file is no larger for it.
    """
    if settings.stored_samples is not None:
        return max(2, settings.stored_samples // settings.runs)
    most = min(MOST_SAMPLES, _MOST_NUMBERS // numbers_per_sample(machine)) // settings.runs
    return max(_FEWEST_SAMPLES, most // _THINNING if settings.runs == 1 and count > most else most)


def _events(machine: Machine, settings: RunSettings, initial: np.ndarray) -> tuple[Event, ...]:
    rotor, ends = machine.rotor.coordinate, {}
    if settings.turns is not None:
        turned_angle = rotor.position - initial[machine.row(rotor.position)]
        ends[TURNS_DONE] = turned_angle / (2 * math.pi * settings.turns)
    limit = settings.speed_limit or runaway_limit(machine)
    if limit is not None and rotor.prescribed_velocity is None:
        ends[SPEED_LIMIT] = rotor.velocity / limit
    return (*(Event(name, share**2 - 1, +1, terminal=True) for name, share in ends.items()), *release_events(machine))


def _warnings(machine: Machine, settings: RunSettings, free: float | None) -> list[str]:
    warnings, limit = [], runaway_limit(machine)
    if limit is not None and settings.speed_limit is None:
        warnings.append(
            "no load and no loss limits the drive: without vibration its speed would grow without limit, as that of a series "
            f"motor without load, Drozdetskaya (2.105); the run ends at {limit:.4g} rad/s, or at study.speed_limit"
        )
    unit = f" {machine.units.time}" if machine.units.time else ""
    if settings.until is not None and free and settings.until < 20 * math.pi / abs(free):
        warnings.append(
            f"the run of {settings.until:g}{unit} is shorter than ten turns at the speed that the drive would reach "
            f"({20 * math.pi / abs(free):.3g}{unit}): far too short for a verdict"
        )
    return warnings
