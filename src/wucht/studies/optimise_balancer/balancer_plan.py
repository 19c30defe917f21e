"""Question and machine -> plan: the variables, the candidates, and the dampings of the curve."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.averaged_equations import keeps_inertia
from wucht.dynamics.balancers.candidates import BalancerTrials, TrialSettings, with_bodies
from wucht.dynamics.balancers.recommendation import CHECK_SAMPLES
from wucht.dynamics.run_ups.initial_state import initial_state
from wucht.dynamics.sampling.ensemble_equations import batching_obstacle
from wucht.dynamics.sampling.ensemble_run import integration_note
from wucht.dynamics.sampling.ensembles import omission_warnings
from wucht.dynamics.sampling.searches import Variable, balancer_names, require_pymoo, variables_of
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.studies.optimise_balancer.spec import OBJECTIVES, Objective, OptimiseBalancer
from wucht.system import TIME

AS_IT_IS, CURVE = "as it is", "damping"  # groups of candidates beside those of each number of bodies
_CURVE = 25  # dampings
_DECADES = 1.5  # on either side of the machine's damping, where the question does not vary it
_SLOW_PEAK = (
    "the peaks of the search are those of averaged equations, in which the vibration follows the speed at once: they are too "
    "high where a resonance is passed fast; the check has those of the full equations"
)


@dataclass(frozen=True)
class Plan:
    """The plan of a search for the best balancer.

    objectives: the requested ones. trials: by the number of bodies; ``as_it_is``: of the machine as given. numbers: its
    values of the variables (k,). generations: of each number of bodies. curve: trials of the damping alone, and the
    dampings. way: the integration of the runs, as a phrase; one_by_one: True if each run is integrated separately.
    """

    spec: OptimiseBalancer
    machine: Machine
    objectives: tuple[Objective, ...]
    trials: dict[int, BalancerTrials]
    as_it_is: BalancerTrials
    numbers: np.ndarray
    generations: int
    curve: tuple[BalancerTrials, np.ndarray] | None
    way: str
    one_by_one: bool
    warnings: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Return the variables of the machine as given."""
        return self.as_it_is.variables

    @property
    def objective_columns(self) -> list[int]:
        """Return the columns of the requested objectives."""
        return [k for k, o in enumerate(OBJECTIVES) if o in self.objectives]

    @property
    def runs(self) -> int:
        """Return the number of runs before the recommendation, at most: of the machine as it is, the curve, the search, and the
        points of the front."""
        curve = 0 if self.curve is None else len(self.curve[1])
        candidates = len(self.trials) * self.generations * self.spec.population
        check_count = CHECK_SAMPLES * (1 + min(self.spec.points, candidates))
        return self.spec.samples * (1 + curve + candidates + check_count)

    @property
    def groups(self) -> dict[str, BalancerTrials]:
        """Trials by the groups of the candidates of a recommendation."""
        curve = {} if self.curve is None else {CURVE: self.curve[0]}
        return {AS_IT_IS: replace(self.as_it_is, variables=()), **curve} | {str(n): t for n, t in self.trials.items()}


def prepare(spec: OptimiseBalancer, machine: Machine) -> Plan:
    """Return the plan. Raises ``InputError`` where the question does not fit the machine."""
    require_pymoo(spec.kind)
    if not any(isinstance(p, Body) for p in machine.parts):
        raise InputError("machine.model", None, "not allowed: bodies, [[machine.bodies]], are needed, whose numbers are varied")
    balancing_bodies = balancer_names(machine)
    if not balancing_bodies:
        raise InputError("machine.bodies", None, f"there are no balancing bodies about {machine.rotor.name!r}")
    path, factor = _unbalance(machine)
    unbalance_range = spec.unbalance or (machine.values[path] / factor,) * 2
    if not unbalance_range[0] > 0:
        raise InputError(path, machine.values[path], "must be greater than 0, or study.unbalance = [low, high] must be given")
    inertia = keeps_inertia(machine, True if spec.inertia is None else spec.inertia)
    _check_start(spec, machine)

    settings = TrialSettings(spec.samples, spec.seed, spec.start, spec.until, spec.order, spec.tolerance)

    def trials(of: Machine) -> BalancerTrials:
        variables = variables_of(of, spec.vary, spec.bodies is not None)
        if path in {p for v in variables for p in v.paths}:
            raise InputError(f"study.vary.{path}", None, "not allowed: the unbalance is given by study.unbalance")
        if any(p == f"{machine.rotor.name}.mass" for v in variables for p in v.paths) and factor != 1.0:
            raise InputError(
                "study.vary", f"{machine.rotor.name}.mass", "allowed only where the rotor's unbalance itself is given"
            )
        return BalancerTrials(
            settings, of, variables, path, (unbalance_range[0] * factor, unbalance_range[1] * factor), inertia
        )

    as_it_is, objectives = trials(machine), _objectives(spec, machine)
    _check_ends(as_it_is)
    question = as_it_is.question(spec.model)
    warnings = omission_warnings(question, spec.start, (), ())
    counts = spec.bodies or (len(balancing_bodies),)
    by_count = {n: trials(with_bodies(machine, n)) for n in counts}
    for n in counts:
        initial_state(by_count[n].machine, spec.start)
    curve = _curve(as_it_is) if spec.damping_curve else None
    if spec.damping_curve and curve is None:
        warnings = (*warnings, "there is no damping curve: some balancing body has no damping that could be varied")
    if spec.model == "slow" and "peak" in objectives:
        warnings = (*warnings, _SLOW_PEAK)
    numbers = np.array([machine.values[v.paths[0]] for v in as_it_is.variables])
    generations, alone = spec.evaluations // (len(counts) * spec.population), batching_obstacle(question) is not None
    return Plan(
        spec, machine, objectives, by_count, as_it_is, numbers, generations, curve, integration_note(question), alone, warnings
    )  # fmt: skip


def _objectives(spec: OptimiseBalancer, machine: Machine) -> tuple[Objective, ...]:
    """Return the objectives. Raises ``InputError`` for the peak of a rotor that does not pass its resonance."""
    prescribed_motion = machine.rotor.coordinate.prescribed_velocity
    is_held = prescribed_motion is not None and TIME not in prescribed_motion.free_symbols and not machine.schedules
    if is_held and "peak" in (spec.objectives or ()):
        reason = "the drive holds the rotor's speed from the beginning, so that it passes no resonance on the way"
        raise InputError("study.objectives", "peak", f"not allowed: {reason}")
    return spec.objectives or tuple(o for o in OBJECTIVES if not (is_held and o == "peak"))


def _check_start(spec: OptimiseBalancer, machine: Machine) -> None:
    """Refuse a start with phases of balancing bodies, which are random. Raises ``InputError``."""
    for name, value in spec.start.items():
        speed_alone = isinstance(value, Mapping) and "angle" not in value
        if name in ("psi", "delta") or (name in balancer_names(machine) and not speed_alone):
            raise InputError(f"study.start.{name}", value, "not allowed: the phases of balancing bodies are random")


def _unbalance(machine: Machine) -> tuple[str, float]:
    """Return the path of the rotor's unbalance, and its value for 1 kg m. Raises ``InputError``."""
    name, values = machine.rotor.name, machine.values
    if f"{name}.unbalance" in values:
        return f"{name}.unbalance", 1.0
    if f"{name}.eccentricity" in values:
        return f"{name}.eccentricity", 1 / values[f"{name}.mass"]
    raise InputError("machine.bodies", name, "a main rotor with an unbalance or an eccentricity is required")


def _check_ends(trials: BalancerTrials) -> None:
    """Refuse an end of a range that the parts do not allow, all else unchanged. Raises ``InputError``."""
    for v in trials.variables:
        for end in (v.low, v.high):
            alone = replace(trials, variables=(v,))
            try:
                alone.candidate_machine([end])
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.explanation) from None


def _curve(trials: BalancerTrials) -> tuple[BalancerTrials, np.ndarray] | None:
    """Return trials with the damping of all bodies as the only variable, and the dampings (N,)."""
    machine, names = trials.machine, balancer_names(trials.machine)
    if any(f"{b}.damping" not in machine.values for b in names):
        return None
    damping_variable = next((v for v in trials.variables if v.key == "damping" and len(v.paths) == len(names)), None)
    damping = max(machine.values[f"{b}.damping"] for b in names)
    if damping_variable is None and not damping > 0:
        return None
    low, high = (
        (damping * 10**-_DECADES, damping * 10**_DECADES)
        if damping_variable is None
        else (damping_variable.low, damping_variable.high)
    )
    if not low > 0:
        low = high * 10 ** (-2 * _DECADES)
    parameter = machine.parameters[f"{names[0]}.damping"]
    only = Variable("damping", "damping", tuple(f"{b}.damping" for b in names), low, high, parameter.unit, parameter.long_name)
    return replace(trials, variables=(only,)), np.geomspace(low, high, _CURVE)
