"""Machine with one parameter that is moved or held while it runs, and its averages over whole turns.

The parameter is base + rate (t - origin), all three run-time values: holding it and ramping it is the same System,
compiled once.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache
from itertools import pairwise
from typing import Literal

import numpy as np
import sympy as sp

from wucht.analysis.vibration import Vibration
from wucht.dynamics.verdicts.observation import AxisMotion, advance_balance, rows_of
from wucht.dynamics.verdicts.outcomes import MODULATION_THRESHOLD
from wucht.errors import InputError, WuchtError
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import axis_at_rest, free_speed, natural_frequencies, net_torque
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.machines.subject import Subject
from wucht.machines.tree import RotatingBody
from wucht.mechanics.lagrange import Coordinate
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance
from wucht.numerics.observers.turns import MARKS_PER_TURN, Samples, TurnObserver
from wucht.schema import Parameter
from wucht.system import TIME, Output, System

RESPONSE_TIMES = 1000  # the default rate: the range takes a thousand response times of the machine
MOST_TURNS = 100_000  # of one ramp at the default rate
MOST_TURNS_AT_RATE = 10_000_000  # of one ramp at a requested rate
_LEAST = 0.1  # of the response time of the machine: least duration of a ramp
SAMPLES = 400  # of one ramp
_TURNS_A_SAMPLE = 3


@dataclass(frozen=True)
class SweepPace:
    """Time scales of a sweep. response_time: of the machine, the slowest decay of the machine's small motions, at least a turn.

    fastest, turn: the largest speed and the longest turn expected. driven: the largest speed that the drives reach.
    rate: of the swept parameter, in rate_unit. samples: of a ramp. step: duration of one. warnings: doubts.
    """

    response_time: float
    fastest: float
    turn: float
    driven: float
    rate: float
    rate_unit: str
    samples: int
    step: float
    warnings: tuple[str, ...]


def sweep_pace(machine: Machine, path: str, low: float, high: float, requested_rate: float | None = None) -> SweepPace:
    """Return the pace of a sweep at a requested rate; None: at one that lets the machine respond.

    Raises ``InputError`` for a rate at which a ramp would take too many turns, or too little time.
    """
    ends = [machine.with_unchecked_values({path: v}) for v in (low, (low + high) / 2, high)]
    speeds = [abs(free_speed(m, r) or 0.0) for m in ends for r in m.rotors]
    natural = [f for m in ends for f in natural_frequencies(m).values() if f > 0]
    fastest = max([*speeds, *natural, *(m.shaking_frequency or 0.0 for m in ends)]) or 1.0
    turn = 2 * math.pi / max(min([w for w in [*speeds, *natural] if w > 0], default=fastest), 0.02 * fastest)
    response_times = [max(turn, _response_time(m)) for m in ends]
    response_time, warnings, unit = max(response_times), tuple[str, ...](), rate_unit(machine, path)
    duration, most = RESPONSE_TIMES * response_time, MOST_TURNS * 2 * math.pi / fastest
    if requested_rate is not None:
        longest, shortest = MOST_TURNS_AT_RATE * 2 * math.pi / fastest, min(_LEAST * min(response_times), most)
        lowest, highest = (float(f"{(high - low) / time:.2g}") for time in (longest, shortest))
        if not lowest <= requested_rate <= highest:
            raise InputError(
                "study.rate", requested_rate,
                f"must be a rate from {lowest:g} to {highest:g} {unit}: a lower one takes more than "
                f"{MOST_TURNS_AT_RATE} turns a ramp, a higher one less than a tenth of the time in which the machine responds",
            )  # fmt: skip
        duration = (high - low) / requested_rate
    elif duration > most:
        duration, time = most, f"{response_time:.3g} {machine.units.time}".strip()
        warnings = (
            f"the machine responds slowly (in {time}): the default rate is limited to {MOST_TURNS} turns a ramp; "
            "give a lower rate to be sure that the sweep is quasi-static",
        )
    samples = max(8, min(SAMPLES, int(duration / (_TURNS_A_SAMPLE * turn))))
    driven, rate = max(speeds, default=0.0), (high - low) / duration
    return SweepPace(response_time, fastest, turn, driven, rate, unit, samples, duration / samples, warnings)


def rate_unit(subject: Subject, path: str) -> str:
    """Return the unit of a rate of a parameter: ``rad/s per s``."""
    unit, time = subject.parameters[path].unit, subject.units.time
    return f"{unit} {f'per {time}' if time else 'a unit of time'}".strip()


def _response_time(machine: Machine) -> float:
    """Return the time constant of the slowest decay of the carrier's vibration and the drives' speed; 0 if none decays."""
    poles = Vibration.of(machine).poles
    decays = -poles.real[-poles.real > 1e-9 * np.abs(poles).max(initial=0.0)]
    times = [0.0, *(1 / decays)]
    for rotor in machine.rotors:
        speed = free_speed(machine, rotor)
        if rotor.coordinate.prescribed_velocity is None and speed is not None:
            torque, h = net_torque(machine, rotor), 1e-3 * (abs(speed) or 1.0)
            slope = (torque(speed - h) - torque(speed + h)) / (2 * h)
            if slope > 0:
                times.append(_inertia(machine, rotor) / slope)
    return float(max(times))


def _inertia(machine: Machine, rotor: RotatingBody) -> float:
    """Return the inertia of a rotor with all bodies that turn with it."""
    at = dict.fromkeys((s for c in machine.coordinates for s in (c.velocity, c.position)), sp.S.Zero)
    at |= {b.coordinate.velocity: sp.S.One for b in machine.group(rotor)}
    return 2 * float(sp.Add(*(e.kinetic for e in machine.energies)).xreplace(at).xreplace(machine.numbers))


BASE, RATE, ORIGIN = _LINE = tuple(sp.Symbol(f"sweep.{n}", real=True) for n in ("base", "rate", "origin"))
_VALUE = BASE + RATE * (TIME - ORIGIN)
SAMPLES_PER_TURN = 32
_MOST_TURNS_SAMPLED = 200  # of a leg: its densely sampled end
_TURNS_UNSAMPLED = 200  # before that, between two checks for interruption
SETTLING_TOLERANCE = 1e-6  # relative change of the speed; ten times as much of the amplitude
_MOST_WINDOWS = 61
_TOO_FAST = 0.01  # greatest change of the speed after a ramp, relative to the largest speed of the sweep


class IntegrationError(WuchtError):
    """Failure to integrate a leg to its end."""


@dataclass(frozen=True)
class MovedMachine:
    """Machine of a sweep. machine: with the swept parameter at its first value. initial: the state (n,) to start from. path: of
    the parameter. energy: scale of the works. jump_tolerance: of the values of jumps, relative. tolerance, engine: of the
    integration."""

    machine: Machine
    initial: np.ndarray
    path: str
    pace: SweepPace
    energy: float
    jump_tolerance: float
    tolerance: float
    engine: Literal["compiled", "radau"] | None = None

    @cached_property
    def compiled_system(self) -> CompiledSystem:
        """Its equations with the moving parameter."""
        system = moving_system(self.machine, self.path)
        return compile_system(system, self.tolerance, release_events(self.machine), self.engine)


@dataclass(frozen=True)
class Place:
    """State of the machine between legs: all that a leg depends on.

    value: of the swept parameter. state: (n + m,), with the works done so far. parameter_values: the others, in the System's
    order. balance: of the energy so far.
    """

    time: float
    value: float
    state: tuple[float, ...]
    parameter_values: tuple[float, ...]
    balance: EnergyBalance


@dataclass(frozen=True)
class SweepLeg:
    """Part of the motion in which the swept parameter moved evenly or was held; averages over whole turns at its end.

    place: where it ended. value: of the swept parameter in the middle of these turns. speed: mean. low, high: of the mean over
    one turn. amplitude: largest. energy_residual: of the energy balance since the beginning, relative.
    """

    place: Place
    value: float
    speed: float
    low: float
    high: float
    amplitude: float
    energy_residual: float

    @property
    def modulation(self) -> float:
        """Range of the speed averaged over a turn, relative to its mean."""
        return (self.high - self.low) / abs(self.speed) if self.speed else 0.0


def is_too_fast(settled_leg: SweepLeg, legs: Sequence[SweepLeg]) -> bool:
    """True if the speed still changed after the last leg of a sweep, until it settled. legs: of all ramps so far.

    That of a modulated motion, which is at no time at its mean, tells nothing.
    """
    largest = max(abs(leg.speed) for leg in (settled_leg, *legs))
    return bool(legs) and legs[-1].modulation < _TOO_FAST and abs(settled_leg.speed - legs[-1].speed) > _TOO_FAST * largest


def moving_system(machine: Machine, path: str) -> System:
    """Return the machine's equations with the parameter linear in time, and the work done by its change."""
    symbol = sp.Symbol(path, real=True)

    def moving_coordinate(c: Coordinate) -> Coordinate:
        return replace(
            c, prescribed_velocity=None if c.prescribed_velocity is None else c.prescribed_velocity.xreplace({symbol: _VALUE})
        )

    line = {s.name: Parameter(s.name, 0.0, "", "", "") for s in _LINE}
    moving = machine.with_fields(
        bodies=tuple(replace(b, coordinate=moving_coordinate(b.coordinate)) for b in machine.bodies),
        carrier=tuple(moving_coordinate(c) for c in machine.carrier),
        parameters=dict(machine.parameters) | line,  # the last ones
    )
    return _with_ramp(moving.system, symbol, machine.units.energy)


@lru_cache(maxsize=64)
def _with_ramp(system: System, symbol: sp.Symbol, energy_unit: str) -> System:
    power = sp.diff(system.output("stored_energy").expression, symbol) * RATE
    return replace(
        system,
        parameters=tuple(p for p in system.parameters if p != symbol),
        definitions=((symbol, _VALUE), *system.definitions),
        quadratures=(*system.quadratures, Output(SCHEDULE_WORK, power, energy_unit, "work of the parameter's change")),
    )


@dataclass(frozen=True)
class Mover:
    """Integration of a machine leg by leg.

    report: called often, with the time reached; it may raise ``KeyboardInterrupt``.
    """

    moved_machine: MovedMachine
    report: Callable[[float], None]

    def begin(self) -> Place:
        """Return the place at time 0."""
        system, values = self.moved_machine.compiled_system.system, self.moved_machine.machine.values
        state = (*self.moved_machine.initial.tolist(), *(0.0 for _ in system.quadratures))
        parameters = tuple(values[name] for name in system.parameter_names[: -len(_LINE)])
        return Place(0.0, values[self.moved_machine.path], state, parameters, EnergyBalance())

    def signal(self, leg: SweepLeg) -> float:
        """Return the quantity that jumps: the speed; where that is prescribed, the amplitude."""
        return leg.speed if self.moved_machine.machine.rotor.coordinate.prescribed_velocity is None else leg.amplitude

    @property
    def window(self) -> float:
        """The time after which a machine with a held parameter is compared with the one before."""
        return max(5 * self.moved_machine.pace.response_time, 8 * self.moved_machine.pace.turn)

    @property
    def longest_settling(self) -> float:
        """The time after which a machine with a held parameter is not waited for any longer."""
        return _MOST_WINDOWS * self.window

    def settle(self, place: Place, largest: tuple[float, float] = (0.0, 0.0)) -> tuple[SweepLeg, bool]:
        """Hold the parameter until nothing changes any more; return the last leg, and True if it is steady or modulated.

        largest: speed and amplitude so far; a speed that changes by less than a millionth of the largest has settled,
        also at a standstill.
        """
        window, quiet = self.window, 0
        motion, scale = np.full(2, np.inf), np.array(largest)
        for _ in range(_MOST_WINDOWS):
            leg, before = self.leg(place, window), motion
            place, motion = leg.place, np.array([leg.speed, leg.amplitude])
            scale = np.maximum(scale, np.abs(motion))
            still = (np.abs(motion - before) <= np.array([SETTLING_TOLERANCE, 10 * SETTLING_TOLERANCE]) * scale).all()
            quiet = quiet + 1 if still else 0
            if quiet == 2:
                return leg, True
        return leg, leg.modulation > MODULATION_THRESHOLD

    def leg(self, place: Place, duration: float, to: float | None = None) -> SweepLeg:
        """Move the parameter evenly to a value (None: hold it) for a time.

        Raises ``IntegrationError``, and ``KeyboardInterrupt`` where the user stops it.
        """
        rate = 0.0 if to is None else (to - place.value) / duration
        parameters = np.array([*place.parameter_values, place.value, rate, place.time])  # those of the ramp come last
        state, end, fastest = self._without_turns(place), place.time + duration, self.moved_machine.pace.fastest
        sampled_time = min(duration, _MOST_TURNS_SAMPLED * 2 * math.pi / fastest)
        grids = [
            np.linspace(
                end - sampled_time, end, 1 + max(8, math.ceil(sampled_time * fastest / (2 * math.pi) * SAMPLES_PER_TURN))
            )
        ]
        if sampled_time < duration:  # in pieces: between them the user may stop the run
            count = 1 + math.ceil((end - sampled_time - place.time) * fastest / (2 * math.pi * _TURNS_UNSAMPLED))
            grids = [*map(np.array, pairwise(np.linspace(place.time, end - sampled_time, count))), *grids]
        for grid in grids:
            t = self._run(grid, state, parameters)
            state, parameters = t.end_state, t.final_parameter_values
        rows, system = rows_of(self.moved_machine.compiled_system, t), self.moved_machine.compiled_system.system
        n, done = len(system.states), np.array(place.state)
        done[:n] = 0.0
        works = {q.name: w + t.quadratures[q.name] for q, w in zip(system.quadratures, done[n:], strict=True)}
        balance, residual = advance_balance(place.balance, rows["stored_energy"], works)
        end_state, other_parameters = tuple((state + done).tolist()), tuple(parameters[: -len(_LINE)].tolist())
        end_place = Place(end, place.value if to is None else to, end_state, other_parameters, balance)
        return self._average_turns(t, rows, place, end_place, rate, float(residual[-1]))

    def legs(self, place: Place, duration: float, values: Sequence[float]) -> tuple[tuple[SweepLeg, ...], str | None]:
        """Move the parameter to one value after the other, as far as possible; return the legs with the failure, if any."""
        legs = list[SweepLeg]()
        for value in values:
            try:
                legs.append(self.leg(place, duration, value))
            except IntegrationError as error:
                return tuple(legs), str(error)
            place = legs[-1].place
        return tuple(legs), None

    def _without_turns(self, place: Place) -> np.ndarray:
        """Return the state (n + m,) without whole turns of each rotor and its bodies, and with no work done yet.

        Rounding of an angle grows with its size, and would show in the averages after many turns.
        """
        names, state = self.moved_machine.compiled_system.system.state_names, np.array(place.state)
        for rotor in self.moved_machine.machine.rotors:
            whole_turns = 2 * math.pi * np.round(state[names.index(rotor.coordinate.position.name)] / (2 * math.pi))
            for body in self.moved_machine.machine.group(rotor):
                state[names.index(body.coordinate.position.name)] -= whole_turns
        state[len(names) :] = 0.0
        return state

    def _run(self, grid: np.ndarray, state: np.ndarray, parameter_values: np.ndarray) -> Trajectory:
        t = integrate(
            self.moved_machine.compiled_system, state, parameter_values, grid, self.report, self.moved_machine.energy
        ).reraise_interrupt()
        if t.failure:
            raise IntegrationError(t.failure)
        return t

    def _average_turns(
        self, t: Trajectory, rows: dict[str, np.ndarray], place: Place, end_place: Place, rate: float, residual: float
    ) -> SweepLeg:
        """Return the averages over the whole turns at the end of a leg from one place to another."""
        machine, rotor = self.moved_machine.machine, self.moved_machine.machine.rotor.coordinate
        time, angle = t.time, rows[rotor.position.name]
        _, averages = TurnObserver().update(Samples.of(time, (angle, rows[rotor.velocity.name])))
        averages = averages.part(averages.passage == averages.passage.max(initial=0))
        whole = (len(averages.time) - 1) // MARKS_PER_TURN * MARKS_PER_TURN
        if whole > 0:
            time, angle = averages.time[-1 - whole :], averages.angle[-1 - whole :]
        mean = (angle[-1] - angle[0]) / (time[-1] - time[0])
        speeds = averages.speed if whole > 0 else np.array([mean])
        value = float(place.value + rate * ((time[0] + time[-1]) / 2 - place.time))
        at_rest = axis_at_rest(machine.with_unchecked_values({self.moved_machine.path: value}))
        amplitude = float(AxisMotion.of(machine, t.time, rows, at_rest).peaks.max())
        return SweepLeg(end_place, value, float(mean), float(speeds.min()), float(speeds.max()), amplitude, residual)
