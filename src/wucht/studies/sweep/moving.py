"""A machine with one parameter that is moved or held while it runs, and what is read off it turn by turn.

The parameter is base + rate (t - origin), all three run-time values: holding it and ramping it is one and the same System,
compiled once.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
import sympy as sp

from wucht.analysis.shaft import energy_scale
from wucht.analysis.static import axis_at_rest
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.schedules import SCHEDULED
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.flow.compiled import CompiledSystem, Integrator
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.turns import PER_TURN, turns
from wucht.studies.observables import EnergyBalance, Orbit, rows_of
from wucht.system import TIME, Output, System

BASE, RATE, ORIGIN = _LINE = tuple(sp.Symbol(f"sweep.{n}", real=True) for n in ("base", "rate", "origin"))
SAMPLES_PER_TURN = 32
_MOST_TURNS_SEEN = 200  # of a leg: what is sampled densely, at its end
_TURNS_UNSEEN = 200  # before that, between two questions whether to stop


class IntegrationError(WuchtError):
    """A leg could not be integrated to its end."""


@dataclass(frozen=True)
class Place:
    """Where the machine is: all that a leg needs to know of those before it.

    value: of the swept parameter. state: (n,). works: done so far (m,). parameters: the other run-time ones, in the System's
    order. balance: of the energy so far.
    """

    time: float
    value: float
    state: tuple[float, ...]
    works: tuple[float, ...]
    parameters: tuple[float, ...]
    balance: EnergyBalance


@dataclass(frozen=True)
class Reading:
    """What a leg shows, averaged over whole turns at its end.

    value: of the swept parameter in the middle of these turns. speed: mean. low, high: of the mean over one turn. amplitude:
    largest. energy_residual: of the energy balance since the beginning, relative.
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


@dataclass(frozen=True)
class Leg:
    """A part of the motion in which the swept parameter moved evenly or was held. place: where it ended."""

    place: Place
    reading: Reading


def moving_system(machine: Machine, swept: str) -> System:
    """The machine's equations with the parameter as a straight line over time, and the work that its change carries in."""
    symbol = sp.Symbol(swept, real=True)
    line = BASE + RATE * (TIME - ORIGIN)

    def moved(c: Coordinate) -> Coordinate:
        return replace(c, prescribed=None if c.prescribed is None else c.prescribed.xreplace({symbol: line}))

    bodies = tuple(replace(b, coordinate=moved(b.coordinate)) for b in machine.bodies)
    system = machine.changed(bodies=bodies, carrier=tuple(moved(c) for c in machine.carrier)).system
    return _along_the_line(system, symbol, machine.units.energy)


@lru_cache(maxsize=64)
def _along_the_line(system: System, symbol: sp.Symbol, energy_unit: str) -> System:
    line = BASE + RATE * (TIME - ORIGIN)
    stored = next(o.expression for o in system.outputs if o.name == "stored_energy")
    work = Output(SCHEDULED, sp.diff(stored, symbol) * RATE, energy_unit, "work of the parameter's change")
    return replace(
        system,
        parameters=(*(p for p in system.parameters if p != symbol), *_LINE),
        definitions=((symbol, line), *system.definitions),
        quadratures=(*system.quadratures, work),
    )


@dataclass(frozen=True)
class Mover:
    """Moves a machine along; it belongs to one run. compiled: its ``moving_system``. fastest: speed that sets the samples.

    report: called often, with the time reached; it may raise ``KeyboardInterrupt``. energy: the size of the works. at_rest:
    where the axis rests, None where that depends on the swept parameter.
    """

    machine: Machine
    swept: str
    compiled: CompiledSystem
    fastest: float
    report: Callable[[float], None]
    integrator: Integrator
    energy: float
    at_rest: dict[str, float] | None

    @classmethod
    def of(
        cls, machine: Machine, swept: str, compiled: CompiledSystem, fastest: float, report: Callable[[float], None]
    ) -> Mover:
        """With an integrator of its own."""
        load = machine.linear_carrier.load.xreplace(machine.numbers)
        at_rest = None if machine.orbit and any(x != 0 for x in load) else dict.fromkeys(machine.orbit, 0.0)
        return cls(machine, swept, compiled, fastest, report, compiled.engine.integrator(), energy_scale(machine), at_rest)

    def reporting(self, report: Callable[[float], None]) -> Mover:
        """The same, of which another part of the study hears."""
        return replace(self, report=report)

    def begin(self, value: float, initial: np.ndarray) -> Place:
        """The place at time 0, from a state (n,)."""
        given = {k: v for k, v in self.machine.values.items() if k != self.swept}
        system = self.compiled.system
        parameters = system.values(given | {s.name: 0.0 for s in _LINE})[: -len(_LINE)]
        return Place(0.0, value, _numbers(initial), (0.0,) * len(system.quadratures), _numbers(parameters), EnergyBalance())

    def leg(self, place: Place, duration: float, to: float | None = None) -> Leg:
        """Move the parameter evenly to a value (None: hold it) for a time.

        Raises ``IntegrationError``, and ``KeyboardInterrupt`` where the user stops it.
        """
        rate = 0.0 if to is None else (to - place.value) / duration
        parameters = np.array([*place.parameters, place.value, rate, place.time])  # those of the line come last
        state, end = self._small(place), place.time + duration
        seen = min(duration, _MOST_TURNS_SEEN * 2 * math.pi / self.fastest)
        if seen < duration:
            state, parameters = self._unseen(place.time, end - seen, state, parameters)
        count = max(8, math.ceil(seen * self.fastest / (2 * math.pi) * SAMPLES_PER_TURN))
        t = self._run(np.linspace(end - seen, end, count + 1), state, parameters)
        rows = rows_of(self.compiled, t)
        quadratures = self.compiled.system.quadratures
        works = {q.name: done + t.quadratures[q.name] for q, done in zip(quadratures, place.works, strict=True)}
        balance, residual = place.balance.after(rows["stored_energy"], works)
        there = Place(
            end,
            place.value if to is None else to,
            _numbers(t.end_state[: len(place.state)]),
            _numbers(t.end_state[len(place.state) :] + np.array(place.works)),
            _numbers(t.parameters[: -len(_LINE)]),
            balance,
        )
        return Leg(there, self._read(t, rows, place, rate, float(residual[-1])))

    def _unseen(self, begin: float, end: float, state: np.ndarray, parameters: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """State and parameters after a time of which nothing is kept, in pieces: between them the user may stop the run."""
        count = 1 + math.ceil((end - begin) * self.fastest / (2 * math.pi * _TURNS_UNSEEN))
        for piece in pairwise(np.linspace(begin, end, count)):
            t = self._run(np.array(piece), state, parameters)
            state, parameters = t.end_state, t.parameters
        return state, parameters

    def _small(self, place: Place) -> np.ndarray:
        """The state (n + m,) with whole turns of each rotor and its bodies taken away, and no work done yet.

        heyoka's steps are accurate relative to the largest number in the state: after many turns that would be an angle.
        """
        names, state = self.compiled.system.state_names, np.array(place.state)
        for rotor in self.machine.rotors:
            turned = 2 * math.pi * np.round(state[names.index(rotor.coordinate.position.name)] / (2 * math.pi))
            for body in self.machine.group(rotor):
                state[names.index(body.coordinate.position.name)] -= turned
        return np.concatenate([state, np.zeros(len(place.works))])

    def _run(self, grid: np.ndarray, state: np.ndarray, parameters: np.ndarray) -> Trajectory:
        t = integrate(self.compiled, state, parameters, grid, self.report, self.energy, self.integrator)
        if t.interrupted:
            raise KeyboardInterrupt
        if t.failure:
            raise IntegrationError(t.failure)
        return t

    def _read(self, t: Trajectory, rows: dict[str, np.ndarray], place: Place, rate: float, residual: float) -> Reading:
        rotor = self.machine.rotor.coordinate
        angle, speed = rows[rotor.position.name], rows[rotor.velocity.name]
        averaged = turns(t.time, angle, speed, {})
        whole = (len(averaged.time) - 1) // PER_TURN * PER_TURN
        if whole >= PER_TURN:
            a, b = len(averaged.time) - 1 - whole, len(averaged.time) - 1
            middle = (averaged.time[a] + averaged.time[b]) / 2
            mean = (averaged.angle[b] - averaged.angle[a]) / (averaged.time[b] - averaged.time[a])
            low, high = averaged.speed.min(), averaged.speed.max()
        else:
            middle = (t.time[0] + t.time[-1]) / 2
            mean = low = high = (angle[-1] - angle[0]) / (t.time[-1] - t.time[0])
        value = float(place.value + rate * (middle - place.time))
        orbit = Orbit.of(self.machine, t.time, rows, self._at_rest(value))
        return Reading(value, float(mean), float(low), float(high), float(orbit.peaks.max()), residual)

    def _at_rest(self, value: float) -> dict[str, float]:
        """Where the axis rests at a value of the swept parameter."""
        return axis_at_rest(self.machine.with_unchecked({self.swept: value})) if self.at_rest is None else self.at_rest


def _numbers(values: np.ndarray | tuple[float, ...]) -> tuple[float, ...]:
    return tuple(float(v) for v in values)
