"""Beats of the averaged equations, and their load spectrum."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Literal

import numpy as np

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, states_with_fast_parts
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state, speeds_in
from wucht.dynamics.run_ups.machine_signals import MachineSignal, machine_signal
from wucht.fatigue.counted_cycles import LoadCycles
from wucht.machines.machine import Machine
from wucht.machines.operation import natural_frequencies
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.recurrence import Recurrence, is_at_rest, recurrence

Motion = Literal["modulated", "steady", "unsettled", "failed", "not-allowed"]
MOTIONS: tuple[Motion, ...] = ("modulated", "steady", "unsettled", "failed", "not-allowed")
_FIRST_TURNS, _RUNS = 30.0, 12  # of the slowest free vibration, in the first run; runs, each twice as long
_SAMPLES = 4001  # of each run
_REPEATS = 8  # least number of passages, in a run, of a beat in which no angle turns
_SETTLING, _PER_BEAT = 6, 600  # beats after the motion repeats itself, and samples in each
_PLACES, _FINE = 240, 2400  # of a beat, at which the signal is evaluated; and at which it is interpolated by splines
_TURN = 8  # angles of the rotor at each of them
_BEATS = 1e-6  # relative: an amplitude that changes by less does not beat


@dataclass(frozen=True, eq=False)
class Beat:
    """Motion of a machine in the averaged equations from a start.

    motion: one of ``MOTIONS``. begin: the time after which it repeats itself. period: of a beat. time, amplitude, rate (n,): in
    the middle of equal parts of it, the amplitude of the signal's first harmonic and its cycles per unit of time. reason: why
    there is no beat.
    """

    motion: Motion
    begin: float = 0.0
    period: float = np.nan
    time: np.ndarray = field(default_factory=lambda: np.empty(0))
    amplitude: np.ndarray = field(default_factory=lambda: np.empty(0))
    rate: np.ndarray = field(default_factory=lambda: np.empty(0))
    reason: str = ""

    @property
    def cycles(self) -> LoadCycles:
        """Cycles of one beat: the signal is a vibration with slowly changing amplitude, so each period of it is a cycle."""
        counts = self.rate * self.period / max(len(self.rate), 1)
        return LoadCycles(2 * self.amplitude, np.zeros(len(counts)), counts)

    @property
    def upper(self) -> float:
        """Largest amplitude; nan where there is no beat."""
        return float(self.amplitude.max(initial=-np.inf)) if len(self.amplitude) else np.nan

    @property
    def ratio(self) -> float:
        """Ratio of the smallest amplitude to the largest."""
        return float(self.amplitude.min()) / self.upper if len(self.amplitude) else np.nan

    @property
    def fullness(self) -> float:
        """Position of the mean amplitude of the cycles between the smallest (0) and the largest (1)."""
        if not len(self.amplitude):
            return np.nan
        low, high = float(self.amplitude.min()), self.upper
        return (float(np.average(self.amplitude, weights=self.rate)) - low) / (high - low)


def beat_of(
    machine: Machine, signal: str, direction: str | None, start: Mapping[str, Any], inertia: bool, tolerance: float
) -> Beat:
    """Return the beat of a signal of an exciter, from a start. Raises ``InputError`` without averaged equations, or the signal.

    inertia: True if averaged equations keep that of the bodies. tolerance: of their integration.
    """
    state = initial_state(machine, with_default_start(machine, start))
    averaged_equations = averaged_equations_of(machine, inertia)
    initial = averaged_equations.state(angles_in(machine, state), speeds_in(machine, state))
    result = _find_repetition(averaged_equations, initial, tolerance)
    if isinstance(result, Beat):
        return result
    return _harmonic_beat(averaged_equations, machine_signal(averaged_equations.machine, signal, direction), *result)


def _find_repetition(
    averaged_equations: AveragedEquations, state: np.ndarray, tolerance: float
) -> Beat | tuple[float, float, Trajectory]:
    """Run until the motion repeats itself: time, period, and one period of it at the middles of equal parts."""
    system, parameters = averaged_equations.system, averaged_equations.values()
    compiled_system = compile_system(system, tolerance)
    turning = np.array(system.is_angle)
    slowest = min(f for f in natural_frequencies(averaged_equations.machine).values() if f > 0)
    span, done = _FIRST_TURNS * 2 * np.pi / slowest, 0.0
    for _ in range(_RUNS):
        run = integrate(compiled_system, state, parameters, np.linspace(0.0, span, _SAMPLES)).reraise_interrupt()
        if run.failure is not None:
            return Beat("failed", done, reason=run.failure)
        if is_at_rest(run.states[:, _SAMPLES // 2 :]):
            return Beat("steady", done + span)
        done, state = done + span, _unwound(run.states[:, -1], turning)
        span *= 2
        repetition = recurrence(run.time, run.states, turning)
        if repetition is None or not (repetition.turns.any() or repetition.period < span / _REPEATS):
            continue
        last_period = _settled_period(averaged_equations, state, repetition, turning, tolerance)
        if last_period is not None:
            return done, *last_period
    return Beat("unsettled", done, reason=f"after {done:.4g} the motion neither rests nor repeats itself")


def _settled_period(
    averaged_equations: AveragedEquations, state: np.ndarray, repetition: Recurrence, turning: np.ndarray, tolerance: float
) -> tuple[float, Trajectory] | None:
    """Return the period, and the motion over it, some beats later; None where it does not repeat itself then."""
    compiled_system, parameters = compile_system(averaged_equations.system, tolerance), averaged_equations.values()
    grid = np.linspace(0.0, _SETTLING * repetition.period, _SETTLING * _PER_BEAT + 1)
    run = integrate(compiled_system, state, parameters, grid).reraise_interrupt()
    again = None if run.failure is not None else recurrence(run.time, run.states, turning)
    if again is None or (again.turns != repetition.turns).any():
        return None
    middles = np.concatenate([[0.0], again.period * (np.arange(_PLACES) + 0.5) / _PLACES])
    last = integrate(compiled_system, _unwound(run.states[:, -1], turning), parameters, middles).reraise_interrupt()
    return None if last.failure is not None else (again.period, last)


def _harmonic_beat(
    averaged_equations: AveragedEquations, signal: MachineSignal, begin: float, period: float, motion: Trajectory
) -> Beat:
    """Return the beat from the first harmonic of the signal over the main rotor's angle, at each place of the beat."""
    machine, time, states = averaged_equations.machine, motion.time[1:], motion.states[:, 1:]
    parameters = np.array(machine.system.values(machine.values))
    angles = 2 * np.pi * np.arange(_TURN) / _TURN
    harmonic = np.zeros(_PLACES, complex)
    for angle in angles.tolist():
        whole = states_with_fast_parts(averaged_equations, time, states, np.full(_PLACES, angle))
        there = replace(motion, time=time, states=whole, final_parameter_values=parameters)
        harmonic += 2 / _TURN * signal(there) * np.exp(-1j * angle)
    amplitude = np.abs(harmonic)
    if not np.ptp(amplitude) > _BEATS * amplitude.max(initial=0.0):
        return Beat("steady", begin, reason="the amplitude does not beat")
    # The vibration turns with the rotor's angle plus its phase, which gains what the shaking force loses in a beat.
    names = averaged_equations.system.output(f"speed[{averaged_equations.averaged_system.bodies.names[0]}]").expression
    speed = Evaluator.of(averaged_equations.system, [names], ["speed"])(time, states, motion.final_parameter_values)["speed"]
    step = period / _PLACES
    phase = np.unwrap(np.angle(harmonic))
    phase_gain = 2 * np.pi * np.round((phase[-1] - phase[0] + (phase[1] - phase[0])) / (2 * np.pi))
    around = np.concatenate([[phase[-1] - phase_gain], phase, [phase[0] + phase_gain]])
    rate = np.abs(speed + (around[2:] - around[:-2]) / (2 * step)) / (2 * np.pi)
    middles = period * (np.arange(_FINE) + 0.5) / _FINE
    amplitude, rate = (_interpolate(time, curve, middles, period) for curve in (amplitude, rate))
    return Beat("modulated", begin, period, middles, amplitude, rate)


def _interpolate(time: np.ndarray, values: np.ndarray, at: np.ndarray, period: float) -> np.ndarray:
    """Interpolate a periodic function, known at times (n,), at other times (k,), by a periodic cubic spline."""
    from scipy.interpolate import CubicSpline

    closed_curve = np.append(time, time[0] + period), np.append(values, values[0])
    return np.asarray(CubicSpline(*closed_curve, bc_type="periodic")(at))


def _unwound(state: np.ndarray, turning: np.ndarray) -> np.ndarray:
    return np.asarray(state - np.where(turning, 2 * np.pi * np.round(state / (2 * np.pi)), 0.0))
