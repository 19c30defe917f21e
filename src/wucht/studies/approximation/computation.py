"""Question and machine -> plan -> findings: a run-up of both models at each value of the parameter, and their deviations."""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cache, partial
from itertools import pairwise

import numpy as np
import sympy as sp

from wucht.dynamics.parameters import parameter_of, range_of
from wucht.dynamics.run_ups.deviations import compared_bodies, compared_motion, deviations_by_angle
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.run_ups.run_up import RunUpCase, run_up
from wucht.dynamics.run_ups.run_up_models import SlowModel, slow_model
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.machines.limits import check_values
from wucht.machines.machine import Machine
from wucht.machines.operation import has_damped_balancers, operating_speed
from wucht.mechanics.energies import Energies
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory
from wucht.schema import Parameter, Unit, read_quantity
from wucht.studies.approximation.spec import Approximation

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


def errors(spec: Approximation, machine: Machine, work: Work) -> Errors:
    """Compute the errors at ``FACTORS`` of epsilon, a unit of work each.

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
        slow = slow_model(full, initial_state(machine, with_default_start(machine, spec.start)), spec.inertia, spec.order)
        systems = slow.system, replace(full.system, quadratures=(), outputs=())
        of_slow, of_full = (compile_system(s, _TOLERANCE, (), spec.engine) for s in systems)
        return slow, (of_slow, of_full)

    def error(factor: float, part: Work) -> float:
        slow, flows = compile_flows()
        weak = slow.machine.with_values(scaled_values(slow.machine, factor))
        model = replace(slow, machine=weak, averaged_equations=replace(slow.averaged_equations, machine=weak))
        return _largest_error(model, flows, min(spec.until_phi, _LONGEST * FACTORS[-1]) / factor, part)

    speeds, lengths = list[float](), np.cumsum([0.0, *(1 / f for f in FACTORS)])
    for factor, (begin, end) in zip(FACTORS, pairwise((lengths / lengths[-1]).tolist()), strict=True):
        part = work.part(f"factor {factor:g}", begin, end)
        try:
            speeds.append(part.unit("error", partial(error, factor, part)))
        except UnmeasuredError as reason:
            raise UnmeasuredError(f"at {factor:g} epsilon {reason}", code="does-not-turn") from None
    return Errors(np.array(FACTORS), np.array(speeds), nominal(machine, spec.order))


def nominal(machine: Machine, order: int) -> float:
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


NOMINAL_VALUE = math.nan  # in place of a value of the parameter: the nominal machine
_DECADE = 10.0


@dataclass(frozen=True)
class Plan:
    """The comparisons to be made. values: of the parameter, or the factor of several; the first is ``NOMINAL_VALUE``. cases: a
    run-up of both models at each of them."""

    spec: Approximation
    machine: Machine
    values: tuple[float, ...]
    cases: tuple[RunUpCase, ...]


def prepare(spec: Approximation, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine, or it has no averaged equations."""
    values = (NOMINAL_VALUE, *_values(spec, machine))
    location = "study.values" if spec.values else "study.range"
    changes = [changes_at(machine, spec.along, value) for value in values]
    for change in changes:
        check_values(machine.parts, change, location, machine.values)
    cases = tuple(RunUpCase.of(machine.with_unchecked_values(change), spec.start, spec.settings) for change in changes)
    return Plan(spec, machine, values, cases)


def changes_at(machine: Machine, along: Sequence[str], value: float) -> Mapping[str, float]:
    """Changed parameters by path: a single one has the value, several are multiplied by it."""
    if math.isnan(value):
        return {}
    return {path: value if len(along) == 1 else value * machine.values[path] for path in along}


def _values(spec: Approximation, machine: Machine) -> tuple[float, ...]:
    """The values in increasing order."""
    along = [parameter_of(machine, path) for path in spec.along]
    unit = Unit(along[0].unit, along[0].long_name) if len(along) == 1 else Unit("", "factor")
    if spec.values:
        return tuple(sorted({read_quantity(unit, raw, f"study.values[{i}]") for i, raw in enumerate(spec.values)}))
    if spec.range is None:
        return ()
    low, high = range_of(unit, spec.range)
    spacing = spec.spacing or ("log" if low > 0 and high / low >= _DECADE else "linear")
    if spacing == "log" and low <= 0:
        raise InputError("study.spacing", spacing, "must be 'linear' for a range that does not begin above 0")
    between = np.geomspace if spacing == "log" else np.linspace
    return tuple(map(float, between(low, high, spec.points)))


@dataclass(frozen=True)
class Findings:
    """Comparisons so far. comparisons: of the nominal machine, then of each value in order. unmeasured_reason: why the order of
    the error is missing."""

    comparisons: tuple[ModelComparison, ...] = ()
    measured_errors: Errors | None = None
    unmeasured_reason: str = ""

    @property
    def is_complete(self) -> bool:
        """True if nothing is left to be computed."""
        return self.measured_errors is not None or bool(self.unmeasured_reason)


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Compare the models and measure the error; yield the findings after each comparison."""
    findings, count = Findings(), len(plan.cases) + 1
    yield findings
    for k in range(len(plan.cases)):
        part = work.part(f"comparison {k + 1}", k / count, (k + 1) / count)
        part.report(0.0)
        findings = Findings((*findings.comparisons, part.unit("both models", partial(compare_models, plan, k, part))))
        yield findings
    part = work.part("order", 1 - 1 / count, 1.0)
    part.report(0.0)
    try:
        yield replace(findings, measured_errors=errors(plan.spec, plan.machine, part))
    except UnmeasuredError as error:
        yield replace(findings, unmeasured_reason=str(error))


CURVE = 400  # samples of a curve over the rotor's angle


@dataclass(frozen=True)
class ModelComparison:
    """Comparison of the runs of both models. value: of the parameter, NaN for the nominal machine.

    largest: deviations of the compared speeds and of the amplitude up to ``until_phi``, NaN if the runs have no angle in
    common. relative: the same, relative to the largest speed and the largest distance of the axis of the full run up to there.
    curves (2, CURVE): their magnitudes over the rotor's angle. failure: a sentence, if one of the runs failed.
    """

    value: float
    outcome: str
    slow_outcome: str
    largest: tuple[float, float]
    relative: tuple[float, float]
    curves: np.ndarray
    failure: str = ""

    @property
    def same_outcome(self) -> bool | None:
        """True if both have the same outcome; None if a run was too short for one."""
        if Outcome.UNIDENTIFIED in (self.outcome, self.slow_outcome) and not self.failure:
            return None
        return self.outcome == self.slow_outcome and not self.failure


def angles(until_phi: float) -> np.ndarray:
    """The rotor's angles (CURVE,) at which the curves are stored."""
    return np.linspace(0.0, until_phi, CURVE)


def compare_models(plan: Plan, k: int, work: Work) -> ModelComparison:
    """Run both models of the k-th case. Raises ``KeyboardInterrupt`` if the user interrupts."""
    # Only the comparison is stored: the legs of its two runs would take some ten megabytes each time.
    [motions] = deque(run_up(plan.cases[k], work.without_memory), maxlen=1)
    failure = "; ".join(m.trajectory.failure for m in motions if m.trajectory.failure)
    outcome, slow_outcome, *_ = [*(str(m.verdict.outcome) for m in motions), str(Outcome.FAILED)]
    until, at, courses = plan.spec.until_phi, angles(plan.spec.until_phi), [compared_motion(m) for m in motions]
    deviations = deviations_by_angle(courses[0], courses[1], until) if len(courses) == 2 else None
    largest = relative = (math.nan, math.nan)
    curves = np.full((2, CURVE), np.nan)
    if deviations is not None:
        largest, inside = deviations.largest, courses[0].angle - courses[0].angle[0] <= until
        largest_values = (float(np.abs(y[..., inside]).max()) for y in (courses[0].speed, courses[0].radius))
        speed, radius = (d / of if of else math.nan if d else 0.0 for d, of in zip(largest, largest_values, strict=True))
        relative = speed, radius
        curves = np.array(
            [np.interp(at, deviations.abscissa, np.abs(y), np.nan, np.nan) for y in (deviations.speed, deviations.radius)]
        )
    return ModelComparison(plan.values[k], outcome, slow_outcome, largest, relative, curves, failure)
