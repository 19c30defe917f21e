"""The order of the error of averaged equations: how it falls as the small parameter of a machine is made smaller."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp

from wucht.dynamics.run_ups.deviations import compared_bodies
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up_models import SlowModel, slow_model
from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import has_damped_balancers, operating_speed
from wucht.mechanics.energies import Energies
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.schema import Parameter

STRENGTH = "kappa"
FACTORS = (1.0, 0.5, 0.25, 0.125)
_SAMPLES = 2000
_TOLERANCE = 1e-13
_LONGEST = 20_000.0  # rad: length of the run at the smallest factor; the others are shorter in proportion
_DOUBLINGS = 8  # of the time until the angle is reached: the rotor may start from rest, or remain below its drive's speed
Flows = tuple[CompiledSystem, CompiledSystem]  # of the slow and of the full equations


def scale_epsilon(machine: Machine, kappa: float) -> Machine:
    """Scale epsilon of a machine by ``kappa``, which becomes a parameter: the equations are derived once for all values."""
    strength = Parameter(STRENGTH, kappa, "", STRENGTH, "factor of epsilon")
    free_energies = machine.without_contacts  # contacts remain as stiff as they are
    energies = (
        *(_scale_energies(machine, e, sp.Symbol(strength.path, real=True)) for e in free_energies),
        *machine.energies[len(free_energies) :],
    )
    return machine.with_fields(energies=energies, parameters={**machine.parameters, STRENGTH: strength}, mismatch=None)


def scaled_values(machine: Machine, kappa: float) -> dict[str, float]:
    """Parameter values of ``scale_epsilon(machine, 1.0)`` for another ``kappa``.

    A prescribed motion acts on a body once, by the coupling alone: its amplitude is multiplied by sqrt(kappa) too.
    """
    amplitudes = machine.shaking[:1] if machine.shaking is not None else ()
    return {STRENGTH: kappa} | {a.name: math.sqrt(kappa) * machine.numbers[a] for a in amplitudes}


def _scale_energies(machine: Machine, e: Energies, kappa: sp.Expr) -> Energies:
    every, angles = [b.coordinate.velocity for b in machine.bodies], {b.coordinate.position for b in machine.bodies}
    carrier_velocities = [c.velocity for c in machine.carrier if e.kinetic.has(c.velocity)]
    turning = [v for v in every if e.kinetic.has(v)]
    kinetic, potential = e.kinetic, e.potential
    if carrier_velocities and turning:
        alone = [kinetic.xreplace(dict.fromkeys(still, sp.S.Zero)) for still in (carrier_velocities, turning)]
        kinetic = sp.Add(
            *alone, sp.sqrt(kappa) * sp.Add(*(v * w * sp.diff(kinetic, v, w) for v in carrier_velocities for w in turning))
        )
    if potential.free_symbols & angles:
        terms = sp.Add.make_args(sp.expand(potential))
        potential = sp.Add(*(kappa * t if t.free_symbols & angles else t for t in terms))

    def weak(expression: sp.Expr) -> sp.Expr:
        """Multiply forces on a single body by kappa; dampers between two bodies, and those of the carrier, remain."""
        return expression * kappa if sum(expression.has(v) for v in every) == 1 else expression

    applied_forces = (
        replace(a, force=a.force * kappa if a.energy_side == "supplied" else weak(a.force)) for a in e.applied_forces
    )
    return Energies(kinetic, potential, weak(e.dissipation), tuple(applied_forces))


class UnmeasuredError(WuchtError):
    """The order cannot be measured, with the reason."""


@dataclass(frozen=True)
class Errors:
    """Errors. factors: of epsilon (n,). speed: largest error of the compared speeds (n,), up to ``until_phi`` over the factor.

    nominal: the power of epsilon with which the error should fall.
    """

    factors: np.ndarray
    speed: np.ndarray
    nominal: float

    @property
    def order(self) -> float:
        """The slope of log error over log epsilon between the two smallest factors; infinite without an error."""
        if not self.speed[-1] > 0:
            return math.inf
        return float(np.log(self.speed[-2] / self.speed[-1]) / np.log(self.factors[-2] / self.factors[-1]))


def measured_errors(machine: Machine, start: Mapping[str, Any], settings: RunSettings, until_phi: float, work: Work) -> Errors:
    """Compute the errors at ``FACTORS`` of epsilon up to an angle of the rotor, a unit of work each.

    The slow motion starts as the run-up does, the full one on the motion that corresponds to it: so the error is that of the
    equations, without the transient of the start. Over an angle phi/factor the slow motion is about the same.
    Raises ``UnmeasuredError`` if a run fails, the rotor does not turn far enough, or the machine has schedules.
    """
    if machine.schedules:
        raise UnmeasuredError("the times of schedules do not scale with epsilon")

    @cache
    def compile_flows() -> tuple[SlowModel, Flows]:
        """Derive and compile the equations once for all factors, and only if a result is not stored already."""
        full = scale_epsilon(machine, 1.0)
        slow = slow_model(full, initial_state(machine, with_default_start(machine, start)), settings.inertia, settings.order)
        systems = slow.system, replace(full.system, quadratures=(), outputs=())
        of_slow, of_full = (compile_system(s, _TOLERANCE, (), settings.engine) for s in systems)
        return slow, (of_slow, of_full)

    def error(factor: float, part: Work) -> float:
        slow, flows = compile_flows()
        weak = slow.machine.with_values(scaled_values(slow.machine, factor))
        model = replace(slow, machine=weak, averaged_equations=replace(slow.averaged_equations, machine=weak))
        return _largest_error(model, flows, min(until_phi, _LONGEST * FACTORS[-1]) / factor, part)

    speeds, lengths = list[float](), np.cumsum([0.0, *(1 / f for f in FACTORS)])
    for factor, (begin, end) in zip(FACTORS, pairwise((lengths / lengths[-1]).tolist()), strict=True):
        part = work.part(f"factor {factor:g}", begin, end)
        try:
            speeds.append(part.unit("error", partial(error, factor, part)))
        except UnmeasuredError as reason:
            raise UnmeasuredError(f"at {factor:g} epsilon {reason}", code="does-not-turn") from None
    return Errors(np.array(FACTORS), np.array(speeds), nominal_order(machine, settings.order))


def nominal_order(machine: Machine, order: int) -> float:
    """The power of epsilon with which the error should fall.

    Bodies without damping between them librate with sqrt(epsilon), which is their small parameter: half the order.
    """
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None]
    return order if len(free) < 2 and has_damped_balancers(machine) else order / 2


def _largest_error(model: SlowModel, flows: Flows, until_phi: float, work: Work) -> float:
    """The largest error of the compared speeds up to an angle of the rotor. Raises ``UnmeasuredError``."""
    machine, initial = model.machine, model.initial
    rows = [machine.row(b.coordinate.velocity) for b in compared_bodies(machine) if b.coordinate.prescribed_velocity is None]
    if not rows:
        raise UnmeasuredError("all speeds are prescribed")
    span = until_phi / operating_speed(machine)
    for _ in range(_DOUBLINGS):
        slow = _complete_run(
            "slow", flows[0], initial, model.parameter_values, np.linspace(0.0, span, _SAMPLES), work.part("", 0.0, 0.1)
        )
        inside = slow.states[-1] - initial[-1] <= until_phi
        if not inside.all():
            break
        span *= 2
    else:
        raise UnmeasuredError(f"the rotor does not turn through {until_phi:.4g} rad")
    slow_motion = model.machine_motion(slow).states[:, inside]
    if not np.isfinite(slow_motion).all():
        raise UnmeasuredError("the averaged equations have no finite motion")
    values, time = flows[1].system.values(machine.values), slow.time[inside]
    true = _complete_run("full", flows[1], slow_motion[:, 0], values, time, work.part("", 0.1, 1.0))
    return float(np.abs(true.states[rows] - slow_motion[rows]).max())


def _complete_run(
    model_name: str, flow: CompiledSystem, initial: np.ndarray, values: Sequence[float], time: np.ndarray, work: Work
) -> Trajectory:
    """Integrate over all times (N,). Raises ``UnmeasuredError`` if that fails; a stored Ctrl-C is raised again."""
    run = integrate(flow, initial, values, time, lambda t: work.report(t / time[-1])).reraise_interrupt()
    if run.failure:
        raise UnmeasuredError(f"the {model_name} equations fail: {run.failure}")
    return run
