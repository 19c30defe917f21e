"""The mean speed before and after a failure by the averaged equations: an independent look at the full ones."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.steady_machine import driven_speeds, turning
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.observers.records import smooth_weights

STEADY, UNSTABLE, BEATING = "steady state", "unstable steady state", "beating motion"
_SAMPLES = 2000


@dataclass(frozen=True)
class AveragedSpeed:
    """speed: of the main rotor, signed. kind: the steady state that is nearest, stable or not, or the mean of a beating motion.
    reason: why there is none. next_stable: the speed of the nearest stable steady state, where it is another one."""

    speed: float | None
    kind: str = ""
    reason: str = ""
    next_stable: float | None = None


def averaged_speed(
    machine: Machine,
    near: float,
    beats: bool,
    start: np.ndarray,
    span: tuple[float, float],
    tolerance: float,
    engine: str | None,
) -> AveragedSpeed:
    """What the averaged equations give instead of a mean speed.

    machine: as it is then. near: the mean speed of the full equations. beats: whether that is one of a beating motion; then the
    averaged equations run from ``start``, a state (n,) of the machine on that motion, for a time, and the mean is taken over
    the end of it. span: these two times.
    """
    steady = turning(machine, None)
    try:
        return _beating(steady, start, span, tolerance, engine) if beats else _nearest(steady, near)
    except InputError as error:
        return AveragedSpeed(None, reason=str(error))


def _nearest(machine: Machine, near: float) -> AveragedSpeed:
    slow = averaged_machine(machine, True)
    torques = SteadyTorques.from_slow(slow)
    if torques.given is not None:
        return AveragedSpeed(None, reason="the drive prescribes the speed")
    stability, sense = AveragedStability(torques, slow), slow.senses[machine.rotor.name]
    found = all_states(torques, *driven_speeds(machine)[0]).states
    if not found:
        return AveragedSpeed(None, reason="the averaged equations have no steady state")
    each = sorted(found, key=lambda state: abs(sense * state.speed - near))
    stable = [s for s in each if stability.stability(s).stable is not False]
    if stable[:1] == each[:1]:
        return AveragedSpeed(sense * each[0].speed, STEADY)
    return AveragedSpeed(sense * each[0].speed, UNSTABLE, next_stable=sense * stable[0].speed if stable else None)


def _beating(
    machine: Machine, start: np.ndarray, span: tuple[float, float], tolerance: float, engine: str | None
) -> AveragedSpeed:
    model = slow_model(machine, start, None, 1)
    compiled = compile_system(model.system, tolerance, (), engine)
    whole, part = span
    grid = np.append(0.0, np.linspace(whole - part, whole, _SAMPLES)) if whole > part else np.linspace(0.0, whole, _SAMPLES)
    motion = integrate(compiled, model.initial, model.values, grid)
    if motion.failure:
        return AveragedSpeed(None, reason=motion.failure)
    name = machine.rotor.name
    output = model.slow.system.output(f"speed[{name}]").expression
    speeds = Evaluator.of(model.system, [output], [name])(motion.time, motion.states, motion.parameters)[name][-_SAMPLES:]
    mean = float(np.average(speeds, weights=smooth_weights(len(speeds))))
    return AveragedSpeed(model.slow.senses[name] * mean, BEATING)
