"""Question and machine -> plan: the variables, and for each number of bodies how candidates are tried."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from wucht.analysis.averaged import keeps_inertia
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.parts.base import Body
from wucht.studies.ensembles.ensemble_run import way_of
from wucht.studies.optimise_balancer.balancer_variables import Variable, balancing, variables_of, with_bodies
from wucht.studies.optimise_balancer.candidates import Trials
from wucht.studies.optimise_balancer.pareto_search import needed
from wucht.studies.optimise_balancer.spec import OBJECTIVES, OptimiseBalancer
from wucht.studies.run_up.model import slow_model
from wucht.studies.run_up.prepare import placed_at_start

_CURVE = 25  # dampings
_DECADES = 1.5  # on either side of the machine's own damping, where the question does not vary it


@dataclass(frozen=True)
class Plan:
    """trials: by the number of bodies; ``as_it_is``: of the machine as it was given. numbers: its own values of the variables
    (k,). generations: of each number of bodies. curve: trials of the damping alone, and the dampings."""

    spec: OptimiseBalancer
    machine: Machine
    model: Literal["full", "slow"]
    trials: dict[int, Trials]
    as_it_is: Trials
    numbers: np.ndarray
    generations: int
    curve: tuple[Trials, np.ndarray] | None
    way: str
    warnings: tuple[str, ...] = ()

    @property
    def variables(self) -> tuple[Variable, ...]:
        """Those of the machine as it was given."""
        return self.as_it_is.variables

    @property
    def asked(self) -> list[int]:
        """The columns of the objectives that count."""
        return [k for k, o in enumerate(OBJECTIVES) if o in self.spec.objectives]


def prepare(spec: OptimiseBalancer, machine: Machine) -> Plan:
    """The plan. Raises ``InputError`` where the question does not fit the machine."""
    needed()
    if not any(isinstance(p, Body) for p in machine.parts):
        raise InputError("machine.model", None, "not allowed: needed are bodies, [[machine.bodies]], whose numbers are varied")
    own = balancing(machine)
    if not own:
        raise InputError("machine.bodies", None, f"needed are balancing bodies about {machine.rotor.name!r}")
    path, factor = _unbalance(machine)
    given = spec.unbalance or (machine.values[path] / factor,) * 2
    if not given[0] > 0:
        raise InputError(path, machine.values[path], "must be greater than 0, or study.unbalance = [low, high] must be given")
    inertia = keeps_inertia(machine, True if spec.inertia is None else spec.inertia)

    def trials(of: Machine) -> Trials:
        variables = variables_of(of, spec.vary, spec.bodies is not None)
        if path in {p for v in variables for p in v.paths}:
            raise InputError(f"study.vary.{path}", None, "not allowed: the unbalance is given by study.unbalance")
        if any(p == f"{machine.rotor.name}.mass" for v in variables for p in v.paths) and factor != 1.0:
            raise InputError(
                "study.vary", f"{machine.rotor.name}.mass", "allowed only where the rotor's unbalance is given itself"
            )
        ends = given[0] * factor, given[1] * factor
        return Trials(
            of, variables, path, ends, spec.samples, spec.seed, inertia, spec.order, spec.until, spec.tolerance
        )  # fmt: skip

    as_it_is = trials(machine)
    _check_ends(as_it_is)
    placed_at_start(machine, {}, spec.until or 0.0)
    model, warnings = _model(spec, as_it_is)
    counts = spec.bodies or (len(own),)
    by_count = {n: trials(with_bodies(machine, n)) for n in counts}
    curve = _curve(as_it_is) if spec.damping_curve else None
    if spec.damping_curve and curve is None:
        warnings = (*warnings, "there is no damping curve: some balancing body has no damping that could be varied")
    numbers = np.array([machine.values[v.paths[0]] for v in as_it_is.variables])
    return Plan(
        spec, machine, model, by_count, as_it_is, numbers, spec.evaluations // (len(counts) * spec.population), curve,
        way_of(as_it_is.question(model)), warnings,
    )  # fmt: skip


def _unbalance(machine: Machine) -> tuple[str, float]:
    """The path of the rotor's unbalance, and what it is for 1 kg m. Raises ``InputError``."""
    name, values = machine.rotor.name, machine.values
    if f"{name}.unbalance" in values:
        return f"{name}.unbalance", 1.0
    if f"{name}.eccentricity" in values:
        return f"{name}.eccentricity", 1 / values[f"{name}.mass"]
    raise InputError("machine.bodies", name, "needed is a main rotor with an unbalance or an eccentricity")


def _check_ends(trials: Trials) -> None:
    """Raises ``InputError`` for an end of a range that the parts do not allow, the rest being as it is."""
    for k, v in enumerate(trials.variables):
        for end in (v.low, v.high):
            numbers = [trials.machine.values[u.paths[0]] for u in trials.variables]
            numbers[k] = end
            alone = replace(trials, variables=(v,))
            try:
                alone.of([end])
            except InputError as error:
                raise InputError(f"study.vary.{v.name}", end, error.allowed) from None


def _model(spec: OptimiseBalancer, trials: Trials) -> tuple[Literal["full", "slow"], tuple[str, ...]]:
    """The equations of the search, and what is to be known of them. Raises ``InputError``."""
    if spec.model == "full":
        return "full", ()
    machine, start = placed_at_start(trials.machine, {}, spec.until or 0.0)
    try:
        return "slow", slow_model(machine, start, trials.inertia, spec.order).warnings
    except InputError as error:
        if spec.model == "slow":
            raise
        return "full", (f"the search is made with the full equations: the machine has no averaged ones ({error.allowed})",)


def _curve(trials: Trials) -> tuple[Trials, np.ndarray] | None:
    """Trials with the damping of all bodies as the only variable, and the dampings (N,)."""
    machine, names = trials.machine, balancing(trials.machine)
    if any(f"{b}.damping" not in machine.values for b in names):
        return None
    asked = next((v for v in trials.variables if v.key == "damping" and len(v.paths) == len(names)), None)
    own = max(machine.values[f"{b}.damping"] for b in names)
    if asked is None and not own > 0:
        return None
    low, high = (own * 10**-_DECADES, own * 10**_DECADES) if asked is None else (asked.low, asked.high)
    if not low > 0:
        low = high * 10 ** (-2 * _DECADES)
    parameter = machine.parameters[f"{names[0]}.damping"]
    only = Variable("damping", "damping", tuple(f"{b}.damping" for b in names), low, high, parameter.unit, parameter.what)
    return replace(trials, variables=(only,)), np.geomspace(low, high, _CURVE)
