"""The largest amplitudes and torques of a response: of bodies in steady phases those of each branch, where it is stable."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass

import numpy as np

from wucht.analysis.forced import Forced
from wucht.analysis.throw import Throw, steady_throw
from wucht.machines.operation import free_speed
from wucht.studies.response.computation import Findings, Plan, amplitude_at


@dataclass(frozen=True)
class Maximum:
    """A value at a speed. label: of the configuration, empty of held bodies. stable: whether it is stable there."""

    speed: float
    value: float
    label: str = ""
    stable: bool = True


@dataclass(frozen=True)
class Curve:
    """amplitude and torque (N,) over the speed, and where bodies are stable (N,)."""

    amplitude: np.ndarray
    torque: np.ndarray
    stable: np.ndarray


@dataclass(frozen=True)
class Maxima:
    """amplitudes, torques: local maxima. largest, hardest: the greatest of all where bodies are stable, None without such.

    at_free: at the speed that the drive reaches without vibration, of each stable configuration there. throw: of the carrier
    in that of them with the largest amplitude.
    """

    amplitudes: list[Maximum]
    torques: list[Maximum]
    largest: Maximum | None
    hardest: Maximum | None
    at_free: list[Maximum]
    throw: Throw | None


def found_maxima(plan: Plan, findings: Findings, curves_there: Sequence[Curve]) -> Maxima:
    """Those of all curves. curves_there: the values of each at the speeds of the findings."""
    machine, curves = plan.steady.machine, plan.steady.curves
    free = free_speed(machine, machine.rotor)
    amplitudes, torques = list[Maximum](), list[Maximum]()
    largest, hardest, at_free = list[Maximum](), list[Maximum](), list[tuple[Maximum, Forced]]()
    for k, (forced, peaks, curve) in enumerate(zip(curves, findings.curves, curves_there, strict=True)):
        judged = _judge(plan, k)
        amplitude = _amplitude(forced, peaks.undamped)
        amplitudes += judged(peaks.peaks, amplitude(peaks.peaks))
        torques += judged(peaks.torque_peaks, forced.torque(peaks.torque_peaks)[0])
        largest += _greatest(findings.speeds, curve.amplitude, curve.stable)
        hardest += _greatest(findings.speeds, curve.torque, curve.stable)
        at = np.array([] if free is None else [abs(free)])
        standing = (m for m in judged(at, amplitude(at)) if (m.stable and math.isfinite(m.value)) or math.isinf(m.value))
        at_free += [(m, forced) for m in standing]
    largest += [m for m in amplitudes if math.isinf(m.value) and m.stable]
    widest = max(at_free, key=lambda pair: pair[0].value, default=None)
    bounded = widest if widest is not None and math.isfinite(widest[0].value) else None
    throw = None if bounded is None else steady_throw(machine, bounded[1], bounded[0].speed)
    return Maxima(amplitudes, torques, _last_of(largest), _last_of(hardest), [m for m, _ in at_free], throw)


def _amplitude(forced: Forced, undamped: tuple[float, ...]) -> Callable[[np.ndarray], np.ndarray]:
    return lambda speeds: np.array([amplitude_at(forced, undamped, w) for w in speeds.tolist()])


def _judge(plan: Plan, k: int) -> Callable[[np.ndarray, np.ndarray], list[Maximum]]:
    """Values at speeds on the k-th curve, as far as they are numbers, with the configurations there."""

    def judged(speeds: np.ndarray, values: np.ndarray) -> list[Maximum]:
        labels, stable = np.full(len(speeds), ""), np.ones(len(speeds), bool)
        if plan.steady.branches:
            branch = plan.steady.branches[k]
            labels, stable = branch.labels(speeds), branch.stable(speeds) & (not branch.overlapping)
        each = zip(speeds.tolist(), values.tolist(), labels.tolist(), stable.tolist(), strict=True)
        return [Maximum(*at) for at in each if not math.isnan(at[1])]

    return judged


def _greatest(speeds: np.ndarray, values: np.ndarray, stable: np.ndarray) -> list[Maximum]:
    """The greatest value (N,) where bodies are stable, none without such."""
    allowed = np.where(stable & np.isfinite(values), values, -np.inf)
    at = int(allowed.argmax())
    return [Maximum(float(speeds[at]), float(values[at]))] if np.isfinite(allowed[at]) else []


def _last_of(found: list[Maximum]) -> Maximum | None:
    return max(reversed(found), key=lambda m: m.value, default=None)
