"""A machine with one parameter that is moved or held while it runs, and what is read off it turn by turn.

The parameter is base + rate (t - origin), all three run-time values: holding it and ramping it is one and the same System,
compiled once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise

import numpy as np
import sympy as sp

from wucht.machines.machine import LOST, SUPPLIED, Machine
from wucht.machines.schedules import SCHEDULED
from wucht.machines.vibration import energy_scale, group
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.flow.compiled import CompiledSystem
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.peaks import interval_peaks
from wucht.numerics.turns import PER_TURN, turns
from wucht.system import TIME, Output, System

BASE, RATE, ORIGIN = (sp.Symbol(f"sweep.{n}", real=True) for n in ("base", "rate", "origin"))
SAMPLES_PER_TURN = 32
_MOST_TURNS_SEEN = 200  # of a leg: what is sampled densely, at its end
_TURNS_UNSEEN = 200  # before that, between two questions whether to stop


class HaltError(Exception):
    """The user stopped the run, or it failed with a sentence."""

    def __init__(self, failure: str | None) -> None:
        super().__init__(failure or "interrupted")
        self.failure = failure


@dataclass(frozen=True)
class Place:
    """Where the run is: time, value of the parameter, state with the works done so far (n + m,), run-time parameters."""

    time: float
    value: float
    state: np.ndarray
    parameters: np.ndarray


@dataclass(frozen=True)
class Reading:
    """What a leg shows, averaged over whole turns at its end.

    value: of the parameter in the middle of these turns. speed: mean. low, high: of the mean over one turn. amplitude: largest.
    energy_residual: of the energy balance since the beginning, relative.
    """

    value: float
    speed: float
    low: float
    high: float
    amplitude: float
    energy_residual: float

    @property
    def beating(self) -> float:
        """The range of the speed averaged over a turn, relative to its mean."""
        return (self.high - self.low) / abs(self.speed) if self.speed else 0.0


def moving_system(machine: Machine, path: str) -> System:
    """The machine's equations with the parameter as a straight line over time, and the work that its change carries in."""
    symbol = sp.Symbol(path, real=True)
    line = BASE + RATE * (TIME - ORIGIN)

    def moved(c: Coordinate) -> Coordinate:
        return replace(c, prescribed=None if c.prescribed is None else c.prescribed.xreplace({symbol: line}))

    bodies = tuple(replace(b, coordinate=moved(b.coordinate)) for b in machine.bodies)
    system = replace(machine, bodies=bodies, carrier=tuple(moved(c) for c in machine.carrier)).system
    stored = next(o.expression for o in system.outputs if o.name == "stored_energy")
    work = Output(SCHEDULED, sp.diff(stored, symbol) * RATE, machine.units.energy, "work of the parameter's change")
    return replace(
        system,
        parameters=(*(p for p in system.parameters if p != symbol), BASE, RATE, ORIGIN),
        definitions=((symbol, line), *system.definitions),
        quadratures=(*system.quadratures, work),
    )


def with_value(machine: Machine, path: str, value: float) -> Machine:
    """The machine with another value of one parameter."""
    return replace(machine, parameters=dict(machine.parameters) | {path: replace(machine.parameters[path], value=value)})


@dataclass
class Mover:
    """Moves a machine along. fastest: speed that sets the samples. report: called with the time, for progress and Ctrl-C."""

    machine: Machine
    path: str
    flow: CompiledSystem
    fastest: float
    report: Callable[[float], None] | None = None
    scale: float = 0.0
    stored_at_start: float | None = None

    def begin(self, value: float, initial: np.ndarray) -> Place:
        """The place at time 0, from a state (n,)."""
        given = {k: v for k, v in self.machine.values.items() if k != self.path}
        pars = self.flow.system.values(given | {BASE.name: value, RATE.name: 0.0, ORIGIN.name: 0.0})
        works = np.zeros(len(self.flow.system.quadratures))
        return Place(0.0, value, np.concatenate([initial, works]), np.array(pars, float))

    def leg(self, place: Place, duration: float, to: float | None = None) -> tuple[Place, Reading]:
        """Move the parameter evenly to a value (None: hold it) for a time. Raises ``HaltError``."""
        rate = 0.0 if to is None else (to - place.value) / duration
        pars = place.parameters.copy()
        for symbol, number in ((BASE, place.value), (RATE, rate), (ORIGIN, place.time)):
            pars[self._index[symbol.name]] = number
        end = place.time + duration
        seen = min(duration, _MOST_TURNS_SEEN * 2 * math.pi / self.fastest)
        if seen < duration:
            state, pars = self._unseen(place.time, end - seen, self._small(place.state), pars)
        else:
            state = self._small(place.state)
        count = max(8, math.ceil(seen * self.fastest / (2 * math.pi) * SAMPLES_PER_TURN))
        found = self._run(np.linspace(end - seen, end, count + 1), state, pars)
        there = place.value if to is None else to
        works = place.state[len(self.flow.system.states) :]
        ended = found.end_state.copy()
        ended[len(self.flow.system.states) :] += works
        return Place(end, there, ended, found.parameters), self._read(found, place, rate)

    def _unseen(self, begin: float, end: float, state: np.ndarray, pars: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State and parameters after a time of which nothing is kept, in pieces: between them the user may stop the run."""
        count = 1 + math.ceil((end - begin) * self.fastest / (2 * math.pi * _TURNS_UNSEEN))
        for piece in pairwise(np.linspace(begin, end, count)):
            found = self._run(np.array(piece), state, pars)
            state, pars = found.end_state, found.parameters
        return state, pars

    def _small(self, state: np.ndarray) -> np.ndarray:
        """The state with whole turns of each rotor and its bodies taken away, and no work done yet.

        heyoka's steps are accurate relative to the largest number in the state: after many turns that would be an angle.
        """
        names, found = self.flow.system.state_names, state.copy()
        for rotor in self.machine.rotors:
            turned = 2 * math.pi * np.round(state[names.index(rotor.coordinate.position.name)] / (2 * math.pi))
            for body in group(self.machine, rotor):
                found[names.index(body.coordinate.position.name)] -= turned
        found[len(names) :] = 0.0
        return found

    @cached_property
    def _unit(self) -> float:
        return energy_scale(self.machine)

    @cached_property
    def _index(self) -> dict[str, int]:
        return {n: i for i, n in enumerate(self.flow.system.parameter_names)}

    def _run(self, grid: np.ndarray, state: np.ndarray, pars: np.ndarray) -> Trajectory:
        found = integrate(self.flow, state, pars.tolist(), grid, self.report, None, self._unit)
        if found.failure or found.interrupted:
            raise HaltError(found.failure)
        return found

    def _read(self, t: Trajectory, place: Place, rate: float) -> Reading:
        row = dict(zip(self.flow.system.state_names, t.states, strict=True)) | self.flow.outputs(t.time, t.states, t.parameters)
        rotor = self.machine.rotor.coordinate
        angle, speed = row[rotor.position.name], row[rotor.velocity.name]
        averaged = turns(t.time, angle, speed, {})
        whole = (len(averaged.time) - 1) // PER_TURN * PER_TURN
        if whole >= PER_TURN:
            a, b = len(averaged.time) - 1 - whole, len(averaged.time) - 1
            middle = (averaged.time[a] + averaged.time[b]) / 2
            mean = (averaged.angle[b] - averaged.angle[a]) / (averaged.time[b] - averaged.time[a])
            low, high = float(averaged.speed.min()), float(averaged.speed.max())
        else:
            middle = (t.time[0] + t.time[-1]) / 2
            mean = low = high = (angle[-1] - angle[0]) / (t.time[-1] - t.time[0])
        value = place.value + rate * (middle - place.time)
        return Reading(
            value, float(mean), float(low), float(high), self._amplitude(t, row, value), self._energy(t, row, place.state)
        )

    def _amplitude(self, t: Trajectory, row: dict[str, np.ndarray], value: float) -> float:
        names = list(self.machine.orbit)
        if not names:
            return 0.0
        rest = self._rest(value)
        offset = np.array([row[f"orbit.{n}"] - r for n, r in zip(names, rest, strict=True)])
        rate = np.array([row[f"orbit.v{n}"] for n in names])
        square = interval_peaks(t.time, (offset**2).sum(axis=0), 2 * (offset * rate).sum(axis=0))
        return math.sqrt(max(0.0, float(square.max())))

    def _rest(self, value: float) -> np.ndarray:
        """Where the axis rests at a value of the parameter: K x = load."""
        if self._weightless is not None:
            return self._weightless
        return _resting(self.machine, self.machine.numbers | {sp.Symbol(self.path, real=True): value})

    @cached_property
    def _weightless(self) -> np.ndarray | None:
        load = self.machine.linear_carrier.load.xreplace(self.machine.numbers)
        return np.zeros(len(self.machine.orbit)) if all(x == 0 for x in load) else None

    def _energy(self, t: Trajectory, row: dict[str, np.ndarray], before: np.ndarray) -> float:
        done = dict(zip((q.name for q in self.flow.system.quadratures), before[len(self.flow.system.states) :], strict=True))
        stored, works = row["stored_energy"], {name: done[name] + w for name, w in t.quadratures.items()}
        if self.stored_at_start is None:
            self.stored_at_start = float(stored[0] - works[SUPPLIED][0] + works[LOST][0] - works[SCHEDULED][0])
        self.scale = max(self.scale, *(float(np.abs(x).max()) for x in (stored, works[SUPPLIED], works[SCHEDULED])))
        gap = works[SUPPLIED][-1] - works[LOST][-1] + works[SCHEDULED][-1] - (stored[-1] - self.stored_at_start)
        return abs(float(gap)) / (self.scale or 1.0)


def _resting(machine: Machine, numbers: dict[sp.Symbol, float]) -> np.ndarray:
    c, size = machine.linear_carrier, len(machine.free_carrier)
    stiffness = np.array(c.stiffness.xreplace(numbers).tolist(), float).reshape(size, size)
    rest = np.linalg.lstsq(stiffness, np.array(c.load.xreplace(numbers).tolist(), float).ravel(), rcond=None)[0]
    at = {q.position: sp.Float(x) for q, x in zip(machine.free_carrier, rest, strict=True)}
    at |= {q.position: sp.S.Zero for q in machine.carrier if q.prescribed is not None}
    known = at | {s: sp.Float(v) for s, v in numbers.items()}
    return np.array([float(x.xreplace(known)) for x, _ in machine.orbit.values()])
