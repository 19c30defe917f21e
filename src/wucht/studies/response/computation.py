"""Question and machine -> plan -> findings: the phases of bodies, the vibration over the speed, and its maxima."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.throw import Throw, steady_throw
from wucht.analysis.vibration import ForcedVibration, WithSlope
from wucht.analysis.working_points import curves
from wucht.dynamics.run_ups.operating_points import Operation, vibration_in_operation
from wucht.dynamics.run_ups.settled_from_rest import FromRest
from wucht.dynamics.run_ups.steady_phases import SteadyPhases
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, natural_frequencies, sense_of, shaft_torques
from wucht.numerics.zeros_and_peaks import crossings
from wucht.studies.response.spec import Response


@dataclass(frozen=True)
class Plan:
    """The plan of a response over the speed.

    range: lowest and highest speed in rad/s. points: evenly spaced over it. machine: with its schedules, as it starts.
    """

    steady: SteadyPhases
    range: tuple[float, float]
    points: int
    machine: Machine


def prepare(spec: Response, machine: Machine, watch: Callable[[], None] | None = None) -> Plan:
    """Return the plan. Raises ``InputError`` where the start does not fit the machine, or nothing is free to vibrate.

    watch: called often during the search for the configurations of several rotors.
    """
    if not machine.free_carrier:
        requirement = "nothing is free to vibrate: a response needs a carrier on springs, and this one is"
        carrier_state, code = ("fixed", "fixed") if machine.shaken_coordinate is None else ("moved as prescribed", "prescribed")
        raise InputError("machine.carrier", None, f"{requirement} {carrier_state}", code=code)
    steady = SteadyPhases.of(machine, spec.start, spec.bodies, watch)
    return Plan(steady, spec.range or _speed_range(steady.machine), spec.points, machine)


def _speed_range(machine: Machine) -> tuple[float, float]:
    """Return the default of ``range``."""
    natural = [f for f in natural_frequencies(machine).values() if f > 0]
    free = abs(free_speed(machine, machine.rotor) or 0.0)
    top = max([*natural, 0.0]) or free or 1.0
    return min(0.02 * top, 0.3 * min([*natural, top])), max(3 * top, 1.5 * free)


_NO_MOTION = 1e-9  # of the largest displacement: a smaller one has no phase


@dataclass(frozen=True)
class Peaks:
    """The maxima of one curve. peaks, torque_peaks: speeds of local maxima of the amplitude and of the vibration torque.

    undamped_resonances: those in the range.
    """

    peaks: np.ndarray
    torque_peaks: np.ndarray
    undamped_resonances: tuple[float, ...]


@dataclass(frozen=True)
class Findings:
    """The decisive speeds of a response.

    speeds: (N,), the maxima among them, without those at which the amplitude is infinite. curves: as of ``SteadyPhases``.
    operation: the vibration at each stable operating point. from_rest: the ends of run-ups from rest, None before it and where
    there is no such point that it could reach.
    """

    speeds: np.ndarray
    curves: tuple[Peaks, ...]
    operation: tuple[Operation, ...] = ()
    from_rest: FromRest | None = None

    def answers(self, rotor: str) -> list[bool | None]:
        """Return for each operating point of a rotor whether it is reached from rest."""
        states = [o.state for o in self.operation]
        return [None] * len(states) if self.from_rest is None else self.from_rest.is_reached(rotor, states)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Yield the decisive speeds, and then with the state that is reached from rest."""
    watch = partial(work.report, 0.0, "steady vibration")
    watch()
    operation = work.unit("operation", partial(vibration_in_operation, plan.steady, watch))
    grid = plan.steady.grid(plan.steady.forced_vibration.grid(*plan.range, plan.points))
    curves = tuple(_peaks(vibration, grid, plan.range) for vibration in plan.steady.curves)
    speeds = np.unique(np.concatenate([grid, *(x for c in curves for x in (c.peaks, c.torque_peaks))]))
    for infinite in {w for c in curves for w in c.undamped_resonances}:
        speeds = speeds[np.abs(speeds - infinite) > 1e-9 * infinite]
    findings = Findings(speeds, curves, operation)
    yield findings
    if operation and plan.steady.is_free:
        yield replace(
            findings, from_rest=FromRest.of(plan.machine, plan.machine.rotor.name, [o.state for o in operation], work)
        )


def _peaks(vibration: ForcedVibration, grid: np.ndarray, speed_range: tuple[float, float]) -> Peaks:
    return Peaks(
        _maximum_speeds(vibration.amplitude, grid),
        _maximum_speeds(vibration.torque, grid),
        tuple(vibration.undamped_resonances(*speed_range)),
    )


def _maximum_speeds(curve: Callable[[np.ndarray], WithSlope], grid: np.ndarray) -> np.ndarray:
    speeds = crossings(lambda w: curve(w)[1], grid, -1)
    return speeds[np.isfinite(curve(speeds)[0])] if len(speeds) else speeds  # not beyond the end of a branch


def _amplitude_at(vibration: ForcedVibration, undamped_resonances: tuple[float, ...], speed: float) -> float:
    """Return the amplitude of the axis at a speed, infinite at an undamped resonance that moves it."""
    if any(math.isclose(speed, w, rel_tol=1e-9) for w in undamped_resonances) and vibration.grows_unbounded(
        vibration.amplitude, speed
    ):
        return math.inf
    return float(vibration.amplitude(np.array([speed]))[0][0])


def phase_lags(machine: Machine, vibration: ForcedVibration, speeds: np.ndarray, z: np.ndarray) -> np.ndarray:
    """Return the lag (m, N) at speeds (N,) of each displacement (m, N) behind the force of the unbalance in its direction.

    That of a foundation, on which no unbalance acts, is behind the force on the direction that it carries; anywhere else the
    reference is the main rotor's angle if the unbalances exert no force. NaN without motion.
    """
    at = machine.bodies.index(machine.rotor)
    main = np.exp(1j * np.broadcast_to(vibration.phases(speeds)[0][at], speeds.shape))
    force = dict(zip(machine.free_labels, vibration.force(speeds).T, strict=True))
    for label, above in (pair for p in machine.parts for pair in p.supported_directions().items()):
        force[label] = force.get(above, np.zeros_like(main))
    excitation = np.array([np.where(force[label] != 0, force[label], main) for label in machine.free_labels])
    lag: np.ndarray = np.mod(-np.angle(z / excitation), 2 * math.pi)
    lag[lag > 2 * math.pi - 1e-9] = 0.0
    size = np.nan_to_num(np.abs(z)).max(axis=1, initial=0.0)
    lag[size <= _NO_MOTION * size.max(initial=0.0)] = math.nan
    return lag


def eccentricity_of(machine: Machine) -> float:
    """Return the main rotor's eccentricity; NaN where the axis does not move in the rotor's plane, or no part states it."""
    arms = (p.arms().get(machine.rotor.name) for p in machine.parts if machine.labels != ("r",))
    return next((float(arm.xreplace(machine.numbers)) for arm in arms if arm is not None), math.nan)


def centre_distance(steady: SteadyPhases, vibration: ForcedVibration, eccentricity: float, speeds: np.ndarray) -> np.ndarray:
    """Return the distance (N,) of the main rotor's centre of mass from the axis' static position, NaN without one."""
    main = steady.machine.bodies.index(steady.machine.rotor)
    return vibration.centre_distance(speeds, eccentricity, float(steady.angles[main]))


def self_centring_speed(steady: SteadyPhases, eccentricity: float, speeds: np.ndarray) -> float | None:
    """Return the speed from which the centre of mass stays nearer to the static position than the axis does.

    002, below (2.78). None where it never does, where nothing is eccentric, and for bodies in steady phases: the answer
    depends on the branch.
    """
    if steady.branches:
        return None

    def outside(w: np.ndarray) -> np.ndarray:
        return np.asarray(
            centre_distance(steady, steady.forced_vibration, eccentricity, w) - steady.forced_vibration.amplitude(w)[0]
        )

    if not eccentricity > 0 or not outside(speeds[-1:])[0] < 0:
        return None
    return max(crossings(outside, speeds).tolist(), default=None)


def losses_of(machine: Machine, speeds: np.ndarray) -> np.ndarray:
    """Return the torque (N,) of loads and bearings on all shafts together, positive where it brakes."""
    losses = np.zeros(len(speeds))
    for rotor in machine.rotors:
        sense, brakes = sense_of(machine, rotor), curves(machine, shaft_torques(machine, rotor)[1:])
        losses += sense * brakes(sense * speeds)[0][0]
    return losses


@dataclass(frozen=True)
class Maximum:
    """A value at a speed. label: of the configuration, empty for held bodies. stable: True if it is stable there."""

    speed: float
    value: float
    label: str = ""
    stable: bool = True


@dataclass(frozen=True)
class ResponseCurve:
    """The amplitude and the torque (N,) over the speed, and a mask (N,) of stable bodies."""

    amplitude: np.ndarray
    torque: np.ndarray
    stable: np.ndarray


@dataclass(frozen=True)
class Maxima:
    """The maxima of all curves.

    amplitudes, torques: local maxima. largest, hardest: the greatest of all where bodies are stable, None without such.

    at_free: at the speed that the drive reaches without vibration, of each stable configuration there. throw: of the carrier
    in that of them with the largest amplitude.
    """

    amplitudes: list[Maximum]
    torques: list[Maximum]
    largest: Maximum | None
    hardest: Maximum | None
    at_free: list[Maximum]
    throw: Throw | None


def collect_maxima(plan: Plan, findings: Findings, curves_there: Sequence[ResponseCurve]) -> Maxima:
    """Collect the maxima of all curves. curves_there: their values at the speeds of the findings."""
    machine, curves = plan.steady.machine, plan.steady.curves
    free = free_speed(machine, machine.rotor)
    amplitudes, torques = list[Maximum](), list[Maximum]()
    largest, hardest, at_free = list[Maximum](), list[Maximum](), list[tuple[Maximum, ForcedVibration]]()
    for k, (vibration, peaks, curve) in enumerate(zip(curves, findings.curves, curves_there, strict=True)):
        maxima_at = _maxima_on_curve(plan, k)
        amplitude = _amplitude(vibration, peaks.undamped_resonances)
        amplitudes += maxima_at(peaks.peaks, amplitude(peaks.peaks))
        torques += maxima_at(peaks.torque_peaks, vibration.torque(peaks.torque_peaks)[0])
        largest += _greatest_value(findings.speeds, curve.amplitude, curve.stable)
        hardest += _greatest_value(findings.speeds, curve.torque, curve.stable)
        at = np.array([] if free is None else [abs(free)])
        free_maxima = (m for m in maxima_at(at, amplitude(at)) if (m.stable and math.isfinite(m.value)) or math.isinf(m.value))
        at_free += [(m, vibration) for m in free_maxima]
    largest += [m for m in amplitudes if math.isinf(m.value) and m.stable]
    widest = max(at_free, key=lambda pair: pair[0].value, default=None)
    finite_maximum = widest if widest is not None and math.isfinite(widest[0].value) else None
    throw = None if finite_maximum is None else steady_throw(machine, finite_maximum[1], finite_maximum[0].speed)
    return Maxima(amplitudes, torques, _largest_maximum(largest), _largest_maximum(hardest), [m for m, _ in at_free], throw)


def _amplitude(vibration: ForcedVibration, undamped_resonances: tuple[float, ...]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda speeds: np.array([_amplitude_at(vibration, undamped_resonances, w) for w in speeds.tolist()])


def _maxima_on_curve(plan: Plan, k: int) -> Callable[[np.ndarray, np.ndarray], list[Maximum]]:
    """Return a function of speeds and values on the k-th curve, for the maxima with their configurations; NaN is left out."""

    def maxima_at(speeds: np.ndarray, values: np.ndarray) -> list[Maximum]:
        labels, stable = np.full(len(speeds), ""), np.ones(len(speeds), bool)
        if plan.steady.branches:
            branch = plan.steady.branches[k]
            labels, stable = branch.labels(speeds), branch.stable(speeds) & (not branch.overlapping)
        rows = zip(speeds.tolist(), values.tolist(), labels.tolist(), stable.tolist(), strict=True)
        return [Maximum(*at) for at in rows if not math.isnan(at[1])]

    return maxima_at


def _greatest_value(speeds: np.ndarray, values: np.ndarray, stable: np.ndarray) -> list[Maximum]:
    """Return the greatest value of (N,) where bodies are stable, if there is one."""
    stable_values = np.where(stable & np.isfinite(values), values, -np.inf)
    at = int(stable_values.argmax())
    return [Maximum(float(speeds[at]), float(values[at]))] if np.isfinite(stable_values[at]) else []


def _largest_maximum(maxima: list[Maximum]) -> Maximum | None:
    return max(reversed(maxima), key=lambda m: m.value, default=None)
