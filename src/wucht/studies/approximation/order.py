"""The order of the slow equations' error, measured on the machine itself: epsilon is made smaller, the rest stays."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np

from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.slow import damped
from wucht.machines.strength import values_at, weakened
from wucht.machines.vibration import operating_speed
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.studies.deviations import watched
from wucht.studies.run_up.model import SlowModel, slow_model
from wucht.studies.start import start_state

if TYPE_CHECKING:
    from wucht.studies.approximation.study import Approximation

FACTORS = (1.0, 0.5, 0.25, 0.125)
_SAMPLES = 2000
_TOLERANCE = 1e-13
_LONGEST = 20_000.0  # rad: the run at the smallest factor; all others are shorter in proportion
_DOUBLINGS = 8  # of the time, until the angle is reached: the rotor may start from rest, or stay below its drive's speed


class UnmeasuredError(WuchtError):
    """Why the order cannot be measured."""


@dataclass(frozen=True)
class Errors:
    """factors: of epsilon (n,). speed: the largest error of the speeds that are ``watched`` (n,), up to ``until_phi`` over it.

    nominal: the power of epsilon with which it should fall.
    """

    factors: np.ndarray
    speed: np.ndarray
    nominal: float

    @property
    def order(self) -> float:
        """The slope of log error over log epsilon between the two smallest; infinite where nothing differs."""
        if not self.speed[-1] > 0:
            return math.inf
        found = np.log(self.speed[-2] / self.speed[-1]) / np.log(self.factors[-2] / self.factors[-1])
        return float(found)


def errors(machine: Machine, question: Approximation) -> Errors:
    """The errors at ``FACTORS`` of epsilon.

    The slow motion starts as the run-up does, the full one on the motion that belongs to it: so what is measured is the error
    of the equations, not that of what the start leaves out. Over an angle phi/factor the slow motion is about the same.
    Raises ``UnmeasuredError`` where a run fails, the rotor does not turn far enough, or schedules go on.
    """
    if machine.schedules:
        raise UnmeasuredError("schedules have a time of their own, which does not become slower with epsilon")
    family, found = weakened(machine, 1.0), []
    model = slow_model(family, start_state(machine, question.start), question.inertia, question.order)
    full = replace(family.system, quadratures=(), outputs=())
    slow_flow, full_flow = (compile_system(s, _TOLERANCE, (), question.engine) for s in (model.system, full))
    for factor in FACTORS:
        weak = family.with_values(values_at(family, factor))
        mine = replace(model, machine=weak, slow=replace(model.slow, machine=weak))
        until = min(question.until_phi, _LONGEST * FACTORS[-1]) / factor
        try:
            found.append(_largest(mine, (slow_flow, full_flow), until))
        except UnmeasuredError as error:
            raise UnmeasuredError(f"at {factor:g} epsilon {error}") from None
    return Errors(np.array(FACTORS), np.array(found), nominal(machine, question.order))


def nominal(machine: Machine, order: int) -> float:
    """The power of epsilon with which the error falls.

    Bodies that nothing damps against each other librate with sqrt(epsilon), which is their small parameter: half the order.
    """
    free = [r for r in machine.rotors if r.coordinate.prescribed is None]
    return order if len(free) < 2 and damped(machine) else order / 2


def _largest(model: SlowModel, flows: tuple[CompiledSystem, CompiledSystem], until_phi: float) -> float:
    """The largest error of the speeds that are ``watched``, up to an angle of the rotor. Raises ``UnmeasuredError``."""
    machine, initial = model.machine, model.initial
    rows = [machine.state_names.index(b.coordinate.velocity.name) for b in watched(machine) if b.coordinate.prescribed is None]
    if not rows:
        raise UnmeasuredError("all speeds are prescribed")
    span = until_phi / operating_speed(machine)
    for _ in range(_DOUBLINGS):
        time = np.linspace(0.0, span, _SAMPLES)
        slow = _complete(integrate(flows[0], initial, model.values, time), "slow")
        inside = slow.states[-1] - initial[-1] <= until_phi
        if not inside.all():
            break
        span *= 2
    else:
        raise UnmeasuredError(f"the rotor does not turn by {until_phi:.4g} rad")
    seen = model.seen(slow).states[:, inside]
    if not np.isfinite(seen).all():
        raise UnmeasuredError("the slow equations have no finite motion")
    true = integrate(flows[1], seen[:, 0], flows[1].system.values(machine.values), time[inside])
    return float(np.abs(_complete(true, "full").states[rows] - seen[rows]).max())


def _complete(run: Trajectory, which: str) -> Trajectory:
    """The run, if it did not fail. Ctrl-C, which the integration keeps to itself, is raised again."""
    if run.interrupted:
        raise KeyboardInterrupt
    if run.failure:
        raise UnmeasuredError(f"the {which} equations fail: {run.failure}")
    return run
