"""The order of the slow equations' error, measured on the machine itself: epsilon is made smaller, the rest stays."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wucht.machines.machine import Machine
from wucht.machines.strength import values_at, weakened
from wucht.machines.vibration import operating_speed
from wucht.numerics.compile import Flow, compile_system
from wucht.numerics.integrate import integrate
from wucht.numerics.trajectory import Trajectory
from wucht.studies.run_up.model import SlowModel, slow_model
from wucht.studies.start import start_state

if TYPE_CHECKING:
    from wucht.studies.approximation.study import Approximation

FACTORS = (1.0, 0.5, 0.25, 0.125)
_SAMPLES = 2000
_TOLERANCE = 1e-13
_LONGEST = 20_000.0  # rad: the run at the smallest factor; all others are shorter in proportion
_DOUBLINGS = 8  # of the time, until the angle is reached: the rotor may start from rest, or stay below its drive's speed


@dataclass(frozen=True)
class Errors:
    """factors: of epsilon (n,). speed: the largest error of the rotor's speed (n,), up to ``until_phi`` over the factor."""

    factors: np.ndarray
    speed: np.ndarray

    @property
    def order(self) -> float:
        """The slope of log error over log epsilon between the two smallest."""
        found = np.log(self.speed[-2] / self.speed[-1]) / np.log(self.factors[-2] / self.factors[-1])
        return float(found)


def errors(machine: Machine, question: Approximation) -> Errors | None:
    """The errors at ``FACTORS`` of epsilon, None where a run fails, the rotor does not turn far enough, or schedules go on.

    The slow motion starts as the run-up does, the full one on the motion that belongs to it: so what is measured is the error
    of the equations, not that of what the start leaves out. Over an angle phi/factor the slow motion is about the same.
    """
    if machine.schedules:  # they have a time of their own, which does not become slower with epsilon
        return None
    family, found = weakened(machine, 1.0), []
    model = slow_model(family, start_state(machine, question.start), question.inertia, question.order)
    full = replace(family.system, quadratures=(), outputs=())
    slow_flow, full_flow = (compile_system(s, _TOLERANCE, (), question.engine) for s in (model.system, full))
    for factor in FACTORS:
        weak = family.with_values(values_at(family, factor))
        mine = replace(model, machine=weak, slow=replace(model.slow, machine=weak))
        error = _largest(mine, (slow_flow, full_flow), min(question.until_phi, _LONGEST * FACTORS[-1]) / factor)
        if error is None or not error > 0:
            return None
        found.append(error)
    return Errors(np.array(FACTORS), np.array(found))


def _largest(model: SlowModel, flows: tuple[Flow, Flow], until_phi: float) -> float | None:
    """The largest error of the rotor's speed, or where it is prescribed of its bodies', up to an angle; None if not reached."""
    machine, initial = model.machine, model.initial
    span = until_phi / operating_speed(machine)
    for _ in range(_DOUBLINGS):
        time = np.linspace(0.0, span, _SAMPLES)
        slow = integrate(flows[0], initial, model.values, time)
        if not _complete(slow):
            return None
        inside = slow.states[-1] - initial[-1] <= until_phi
        if not inside.all():
            break
        span *= 2
    else:
        return None
    seen = model.seen(slow).states[:, inside]
    if not np.isfinite(seen).all():
        return None
    true = integrate(flows[1], seen[:, 0], flows[1].system.values(machine.values), time[inside])
    if not _complete(true):
        return None
    watched = [machine.rotor] if machine.rotor.coordinate.prescribed is None else machine.bodies
    rows = [machine.state_names.index(b.coordinate.velocity.name) for b in watched if b.coordinate.prescribed is None]
    return float(np.abs(true.states[rows] - seen[rows]).max()) if rows else None


def _complete(run: Trajectory) -> bool:
    """Whether it did not fail. Ctrl-C, which the integration keeps to itself, is raised again."""
    if run.interrupted:
        raise KeyboardInterrupt
    return not run.failure
