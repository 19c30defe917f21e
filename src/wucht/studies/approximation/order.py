"""The order of the averaged equations' error, measured on the machine itself: epsilon is made smaller, the rest stays.

With the coupling of rotation and vibration times sqrt(kappa), and the torques that depend on a body's own speed times kappa,
the bodies' equations become J theta'' + B theta' = kappa (L + V): epsilon and mu of 002 (4.8) are multiplied by kappa, and all
other dimensionless numbers stay.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
import sympy as sp

from wucht.dynamics.run_ups.deviations import watched
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up_models import SlowModel, slow_model
from wucht.dynamics.work import Work
from wucht.errors import WuchtError
from wucht.machines.machine import Machine
from wucht.machines.operation import damped, operating_speed
from wucht.mechanics.energies import Energies
from wucht.numerics.flow.compiled import CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.schema import Parameter
from wucht.studies.approximation.spec import Approximation

STRENGTH = "kappa"
FACTORS = (1.0, 0.5, 0.25, 0.125)
_SAMPLES = 2000
_TOLERANCE = 1e-13
_LONGEST = 20_000.0  # rad: the run at the smallest factor; all others are shorter in proportion
_DOUBLINGS = 8  # of the time, until the angle is reached: the rotor may start from rest, or stay below its drive's speed
Flows = tuple[CompiledSystem, CompiledSystem]  # of the slow and of the full equations


def weakened(machine: Machine, kappa: float) -> Machine:
    """The machine with epsilon times ``kappa``, which is a parameter of it: the structure is derived once for all values."""
    given = Parameter(STRENGTH, kappa, "", STRENGTH, "factor of epsilon")
    own = machine.without_contacts  # which stay as hard as they are
    energies = (*(_weakened(machine, e, sp.Symbol(given.path, real=True)) for e in own), *machine.energies[len(own) :])
    return machine.changed(energies=energies, parameters={**machine.parameters, STRENGTH: given}, mismatch=None)


def values_at(machine: Machine, kappa: float) -> dict[str, float]:
    """The values of ``weakened(machine, 1.0)`` for another ``kappa``.

    A prescribed motion turns a body by the coupling alone, once: its amplitude is multiplied by sqrt(kappa) too.
    """
    amplitudes = machine.shaking[:1] if machine.shaking is not None else ()
    return {STRENGTH: kappa} | {a.name: math.sqrt(kappa) * machine.numbers[a] for a in amplitudes}


def _weakened(machine: Machine, e: Energies, kappa: sp.Expr) -> Energies:
    every, angles = [b.coordinate.velocity for b in machine.bodies], {b.coordinate.position for b in machine.bodies}
    carried = [c.velocity for c in machine.carrier if e.kinetic.has(c.velocity)]
    turning = [v for v in every if e.kinetic.has(v)]
    kinetic, potential = e.kinetic, e.potential
    if carried and turning:
        alone = [kinetic.xreplace(dict.fromkeys(still, sp.S.Zero)) for still in (carried, turning)]
        kinetic = sp.Add(*alone, sp.sqrt(kappa) * sp.Add(*(v * w * sp.diff(kinetic, v, w) for v in carried for w in turning)))
    if potential.free_symbols & angles:
        terms = sp.Add.make_args(sp.expand(potential))
        potential = sp.Add(*(kappa * t if t.free_symbols & angles else t for t in terms))

    def weak(expression: sp.Expr) -> sp.Expr:
        """Times kappa what one body alone feels; dampers between two bodies, and those of the carrier, stay."""
        return expression * kappa if sum(expression.has(v) for v in every) == 1 else expression

    applied = (replace(a, force=a.force * kappa if a.booked == "supplied" else weak(a.force)) for a in e.applied)
    return Energies(kinetic, potential, weak(e.dissipation), tuple(applied))


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
        return float(np.log(self.speed[-2] / self.speed[-1]) / np.log(self.factors[-2] / self.factors[-1]))


def errors(spec: Approximation, machine: Machine, work: Work) -> Errors:
    """The errors at ``FACTORS`` of epsilon, a unit of work each.

    The slow motion starts as the run-up does, the full one on the motion that belongs to it: so what is measured is the error
    of the equations, not that of what the start leaves out. Over an angle phi/factor the slow motion is about the same.
    Raises ``UnmeasuredError`` where a run fails, the rotor does not turn far enough, or schedules go on.
    """
    if machine.schedules:
        raise UnmeasuredError("schedules have a time of their own, which does not become slower with epsilon")

    @cache
    def compiled() -> tuple[SlowModel, Flows]:
        """Derived and compiled once for all factors, and only where one is not read back."""
        full = weakened(machine, 1.0)
        slow = slow_model(full, initial_state(machine, spec.start), spec.inertia, spec.order)
        systems = slow.system, replace(full.system, quadratures=(), outputs=())
        of_slow, of_full = (compile_system(s, _TOLERANCE, (), spec.engine) for s in systems)
        return slow, (of_slow, of_full)

    def error(factor: float, part: Work) -> float:
        slow, flows = compiled()
        weak = slow.machine.with_values(values_at(slow.machine, factor))
        model = replace(slow, machine=weak, slow=replace(slow.slow, machine=weak))
        return _largest(model, flows, min(spec.until_phi, _LONGEST * FACTORS[-1]) / factor, part)

    speeds, lengths = list[float](), np.cumsum([0.0, *(1 / f for f in FACTORS)])
    for factor, (begin, end) in zip(FACTORS, pairwise((lengths / lengths[-1]).tolist()), strict=True):
        part = work.part(f"factor {factor:g}", begin, end)
        try:
            speeds.append(part.unit("error", partial(error, factor, part)))
        except UnmeasuredError as reason:
            raise UnmeasuredError(f"at {factor:g} epsilon {reason}", code="does-not-turn") from None
    return Errors(np.array(FACTORS), np.array(speeds), nominal(machine, spec.order))


def nominal(machine: Machine, order: int) -> float:
    """The power of epsilon with which the error falls.

    Bodies that nothing damps against each other librate with sqrt(epsilon), which is their small parameter: half the order.
    """
    free = [r for r in machine.rotors if r.coordinate.prescribed is None]
    return order if len(free) < 2 and damped(machine) else order / 2


def _largest(model: SlowModel, flows: Flows, until_phi: float, work: Work) -> float:
    """The largest error of the speeds that are ``watched``, up to an angle of the rotor. Raises ``UnmeasuredError``."""
    machine, initial = model.machine, model.initial
    rows = [machine.row(b.coordinate.velocity) for b in watched(machine) if b.coordinate.prescribed is None]
    if not rows:
        raise UnmeasuredError("all speeds are prescribed")
    span = until_phi / operating_speed(machine)
    for _ in range(_DOUBLINGS):
        slow = _complete("slow", flows[0], initial, model.values, np.linspace(0.0, span, _SAMPLES), work.part("", 0.0, 0.1))
        inside = slow.states[-1] - initial[-1] <= until_phi
        if not inside.all():
            break
        span *= 2
    else:
        raise UnmeasuredError(f"the rotor does not turn by {until_phi:.4g} rad")
    seen = model.seen(slow).states[:, inside]
    if not np.isfinite(seen).all():
        raise UnmeasuredError("the averaged equations have no finite motion")
    values, time = flows[1].system.values(machine.values), slow.time[inside]
    true = _complete("full", flows[1], seen[:, 0], values, time, work.part("", 0.1, 1.0))
    return float(np.abs(true.states[rows] - seen[rows]).max())


def _complete(
    which: str, flow: CompiledSystem, initial: np.ndarray, values: Sequence[float], time: np.ndarray, work: Work
) -> Trajectory:
    """A run over all times (N,). Raises ``UnmeasuredError`` where it fails; Ctrl-C, which it stores, is raised again."""
    run = integrate(flow, initial, values, time, lambda t: work.report(t / time[-1])).uninterrupted()
    if run.failure:
        raise UnmeasuredError(f"the {which} equations fail: {run.failure}")
    return run
