"""Orbits over a parameter: steady states, first orbits, the branches through them both ways, and single orbits on these.

The exponents of single orbits are those of integrated variational equations.
"""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field, replace
from functools import partial
from typing import Any

import numpy as np

from wucht.dynamics.branches.bifurcation_diagram import BranchCase, follow_branches
from wucht.dynamics.branches.equilibrium_branches import EquilibriumBranch
from wucht.dynamics.branches.first_orbits import SeedOrbit, SettlingRun, cycles_of, orbit_of_run, orbits_of_hopf_points
from wucht.dynamics.branches.orbit_branches import (
    PeriodicBranch,
    StoredOrbit,
    half_branch,
    orbit_extremes,
    stored_orbit,
)
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.dynamics.branches.plane_regions import Range
from wucht.dynamics.work import Work, result_or_reason, with_result
from wucht.errors import InputError, RunError
from wucht.machines.subject import Subject
from wucht.numerics.periodic.cycle import FOLD, Cycle
from wucht.numerics.periodic.cycle_starts import cycle_from_nodes, cycles_with
from wucht.numerics.periodic.cycles import Cycles
from wucht.numerics.periodic.floquet import integrated_maps, logarithms, transverse_maps

MOST_BRANCHES = 20
_REPORTS = 10  # along each branch, by default
_RUN_SHARES = (0.5, 0.25, 0.75, 0.1, 0.9)  # of the range: where runs search a first orbit
_SEARCHES = 3  # values at which steady states are searched, besides the ends of the range
_STEADY, _FIRST, _BRANCHES = 0.15, 0.25, 0.8  # shares of the work at which these are done
_PLACES = 400  # of a period, at which an orbit is drawn
_STEPS_THERE, _FIRST_STEP = 100, 0.1  # from a stored orbit, that is near


@dataclass(frozen=True, eq=False)
class OrbitCase:
    """Definition of an orbit diagram; ``OrbitCase.of`` makes it of a machine or of user equations.

    Attributes
    ----------
    problem : OrbitProblem
    run_values : tuple of float or None
        Where runs search a first orbit; None: at several values, until there is one.
    values : tuple of float or None
        Of orbits that are reported, None: evenly along each branch.
    until : float or None
        The longest time of such a run.
    longest : float or None
        The period up to which a branch is followed; None: a multiple of that of its first orbit.
    switch : bool
        True to follow other branches from branch points and period doublings.
    steady : BranchCase or None
        The steady states.
    no_steady_reason : str
        Why there are none.
    """

    problem: OrbitProblem
    run_values: tuple[float, ...] | None
    values: tuple[float, ...] | None
    until: float | None
    longest: float | None
    switch: bool
    steady: BranchCase | None
    no_steady_reason: str

    @classmethod
    def of(
        cls, subject: Subject, path: str, bounds: Range, start: Mapping[str, Any] | None = None,
        run_values: tuple[float, ...] | None = None, values: tuple[float, ...] | None = None, until: float | None = None,
        longest: float | None = None, switch: bool = False, together: bool = False, show: str | None = None,
        ranges: Mapping[str, Range] | None = None, inertia: bool | None = None,
    ) -> OrbitCase:  # fmt: skip
        """Set up the orbits of a machine, or of user equations, over the parameter of a path.

        Parameters
        ----------
        subject : Machine or UserSystem
        path : str
            Of the parameter, such as ``"drive.slope"``.
        bounds : (float, float)
            Its range, in SI.
        start : mapping, optional
            The state from which a run searches a first orbit.
        run_values, values : tuple of float, optional
        until, longest : float, optional
        switch : bool
            See ``OrbitCase``.
        together : bool
            Equal balancing bodies keep equal phases.
        show : str, optional
            The state of user equations that is drawn.
        ranges : mapping of str to (float, float), optional
            Of their states, in which equilibria are searched.
        inertia : bool, optional
            Of a machine's balancing bodies in the averaged equations; None: as is usual for the machine.

        Returns
        -------
        OrbitCase

        Raises
        ------
        InputError
            Where one of these does not fit the subject, or it has no averaged equations.
        """
        problem = OrbitProblem.of(subject, path, bounds, start, together, show, ranges, inertia)
        steady, no_steady_reason = _steady(subject, problem, together, ranges)
        return cls(problem, run_values, values, until, longest, switch, steady, no_steady_reason)


def _steady(
    subject: Subject, problem: OrbitProblem, together: bool, ranges: Mapping[str, Range] | None
) -> tuple[BranchCase | None, str]:
    """Return the case of the steady states, or why they are not searched."""
    labels, only = problem.labels, ("together",) if together else None
    if labels.of_equations and ranges is None:
        return None, "equilibria are searched only if ranges = { STATE = [low, high] } is given"
    try:
        case = BranchCase.of(
            subject, problem.path, problem.bounds, _SEARCHES, only, labels.state, ranges=ranges, inertia=labels.inertia
        )
    except InputError as error:
        if labels.of_equations:
            raise
        return None, f"steady states are not searched: {error.explanation}"
    return case, ""


@dataclass(frozen=True)
class OrbitFindings:
    """Orbits and their branches computed so far.

    Attributes
    ----------
    steady : tuple of EquilibriumBranch
        Branches of steady states.
    runs : tuple of SettlingRun
        That searched a first orbit.
    branches : tuple of PeriodicBranch
    orbits : tuple of (int, ReportedOrbit)
        Reported ones, with the number of their branch.
    omissions : tuple of str
        Sentences on what is missing.
    complete : bool
        True where nothing is left to do.
    """

    steady: tuple[EquilibriumBranch, ...] = ()
    runs: tuple[SettlingRun, ...] = ()
    branches: tuple[PeriodicBranch, ...] = ()
    orbits: tuple[tuple[int, ReportedOrbit], ...] = ()
    omissions: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False


Stage = Generator[OrbitFindings, None, OrbitFindings]


def follow_orbits(case: OrbitCase, work: Work) -> Iterator[OrbitFindings]:
    """Search first periodic orbits and follow their branches.

    Parameters
    ----------
    case : OrbitCase
    work : Work

    Yields
    ------
    OrbitFindings
        After each step; the last ones are complete.
    """
    findings = OrbitFindings()
    if case.steady is not None:
        for steady in follow_branches(case.steady, work.part("steady", 0.0, _STEADY)):
            findings = replace(findings, steady=steady.branches)
            yield findings
    findings = yield from _first_orbits(case, findings, work)
    findings = yield from _report_orbits(case, findings, work)
    work.report(1.0)
    yield replace(findings, complete=True)


def _first_orbits(case: OrbitCase, findings: OrbitFindings, work: Work) -> Stage:
    """Search first orbits, and follow at once each that lies on no known branch."""
    problem = case.problem
    run_values = case.run_values or tuple(float(problem.bounds[0] + share * np.ptp(problem.bounds)) for share in _RUN_SHARES)
    for i, value in enumerate(run_values):
        share = _STEADY + (_FIRST - _STEADY) * i / len(run_values)
        work.report(share, f"a run at {problem.path} = {value:.5g}")
        report = partial(work.report, share, "a run until it settles")
        run_there = partial(orbit_of_run, problem, value, case.until, case.longest, report)
        run = work.unit(f"run at {value!r}", run_there)
        findings = with_result(findings, "runs", run)
        yield findings
        if run.orbit is not None:
            findings = yield from _follow_branch(case, run.orbit, findings, work)
            if case.run_values is None:
                return findings
    sizes = None if case.steady is None else case.steady.steady_states.equilibria.equations.scale[:-1]
    if not findings.branches and sizes is not None and len(sizes) == len(problem.turning):
        seeds = work.unit("hopf points", partial(orbits_of_hopf_points, problem, findings.steady, sizes, case.longest))
        findings, hopf_orbits = _split(findings, seeds)
        for seed in hopf_orbits:
            findings = yield from _follow_branch(case, seed, findings, work)
    return findings


def _follow_branch(case: OrbitCase, first: SeedOrbit, findings: OrbitFindings, work: Work) -> Stage:
    """Follow the branch through an orbit, and, where other branches are followed, those that cross it."""
    pending = [first]
    while pending and len(findings.branches) < MOST_BRANCHES:
        seed, k = pending.pop(0), len(findings.branches)
        if any(branch.passes(seed.value, seed.period) for branch in findings.branches) and not len(seed.towards):
            continue
        new_branch: PeriodicBranch | None = None
        for onward in (True, False) if not len(seed.towards) else (True,):
            name = f"branch {k} {'onward' if onward else 'backward'} from {seed.origin}"
            part = work.part(name, _FIRST, _BRANCHES)
            half = part.unit("", partial(result_or_reason, _half_branch, case, seed, onward, part))
            if isinstance(half, str):
                findings = with_result(findings, "branches", half, f"the branch from {seed.origin} is not followed: ")
                break
            new_branch = half if new_branch is None else new_branch.with_backward(half)
            if half.is_closed:
                break
        if new_branch is None:
            yield findings
            continue
        if len(seed.towards) and any(branch.is_same_branch(new_branch) for branch in findings.branches):
            continue
        findings = with_result(findings, "branches", new_branch)
        findings, more = _split(findings, new_branch.offshoots)
        yield findings
        pending += more
    return findings


def _split(findings: OrbitFindings, seeds: Sequence[SeedOrbit | str]) -> tuple[OrbitFindings, list[SeedOrbit]]:
    """Return the findings with the sentences on missing orbits, and the orbits that exist."""
    sentences = [one for one in seeds if isinstance(one, str)]
    return replace(findings, omissions=(*findings.omissions, *sentences)), [one for one in seeds if not isinstance(one, str)]


def _half_branch(case: OrbitCase, seed: SeedOrbit, onward: bool, work: Work) -> PeriodicBranch:
    low, high = case.problem.bounds
    begin, to = seed.value, high if onward else low

    def report(value: float) -> None:
        done = abs(value - begin) / max(abs(to - begin), 1e-300)
        work.report(min(done, 1.0), f"orbits, {case.problem.path} = {value:.6g}")

    return half_branch(case.problem, seed, onward, case.switch, report)


def _report_orbits(case: OrbitCase, findings: OrbitFindings, work: Work) -> Stage:
    """Compute the orbits at the given values, and at special points."""
    targets = [(k, *target) for k, b in enumerate(findings.branches) for target in _values_to_report(case, b)]
    for i, (k, value, beside) in enumerate(targets):
        work.report(_BRANCHES + (1 - _BRANCHES) * i / len(targets), f"exponents at {case.problem.path} = {value:.6g}")
        seed = findings.branches[k].seed
        make = partial(result_or_reason, reported_orbit, case.problem, seed, beside, value)
        one = work.unit(f"orbit {i} of branch {k} at {value!r}", make)
        missing = f"the orbit at {case.problem.path} = {value:.6g} is not reported: "
        findings = with_result(findings, "orbits", one if isinstance(one, str) else (k, one), missing)
        yield findings
    return findings


def _values_to_report(case: OrbitCase, branch: PeriodicBranch) -> list[tuple[float, tuple[StoredOrbit, ...]]]:
    """Return values, and the stored orbits beside them."""
    values = branch.values
    inside = np.linspace(values.min(), values.max(), _REPORTS + 1)[:-1] + np.ptp(values) / (2 * _REPORTS)
    chosen_values = case.values if case.values is not None else tuple(inside.tolist())
    targets = [(value, beside) for value in chosen_values for beside in orbits_beside(branch.stored_orbits, value)]
    return sorted([*targets, *((o.value, (o,)) for o in branch.stored_orbits if o.kind)], key=lambda target: target[0])


@dataclass(frozen=True)
class ReportedOrbit:
    """Orbit as reported.

    ordinate, amplitude (P,), states (n, P): over a period, at the shares (P,) of it, which are dense where the orbit is fast;
    rotor_angle (P,): by then, nan for user equations.
    period_phi: the rotor's angle in a period. low, high: of the ordinate, least, largest: of the amplitude. exponents (n-1,):
    per unit of time, without the trivial one, the largest first. along: ln mu of the trivial one, as computed. kind: of a
    special orbit.
    """

    value: float
    period: float
    period_phi: float
    low: float
    high: float
    least: float
    largest: float
    exponents: np.ndarray
    along: float
    shares: np.ndarray
    ordinate: np.ndarray
    amplitude: np.ndarray
    rotor_angle: np.ndarray
    states: np.ndarray
    kind: str


def orbits_beside(stored_orbits: Sequence[StoredOrbit], value: float) -> list[tuple[StoredOrbit, ...]]:
    """Return, for each passage of a branch through a value, the regular orbits on either side of it, the nearest first.

    Beyond a fold beside it there is none: from there the branch leads to its other passage.
    """
    values = np.array([k.value for k in stored_orbits])
    passages = np.flatnonzero((values[:-1] - value) * (values[1:] - value) < 0).tolist()
    beside = [(_first_regular(stored_orbits[i::-1]), _first_regular(stored_orbits[i + 1 :])) for i in passages]
    pairs = [sorted((k for k in pair if k is not None), key=lambda k: abs(k.value - value)) for pair in beside]
    return [*((k,) for k in stored_orbits if k.value == value and not k.kind), *(tuple(pair) for pair in pairs if pair)]


def _first_regular(stored_orbits: Sequence[StoredOrbit]) -> StoredOrbit | None:
    """Return the first orbit that is not special, None where a fold comes first."""
    first = next((k for k in stored_orbits if k.kind in ("", FOLD)), None)
    return None if first is None or first.kind else first


def reported_orbit(subject: OrbitProblem, seed: SeedOrbit, beside: Sequence[StoredOrbit], value: float) -> ReportedOrbit:
    """Compute the orbit at a value from stored ones beside it. Raises ``RunError`` where that fails."""
    cycles = cycles_of(subject, seed.winding, seed.scale, 2 * seed.longest)
    # At a special orbit the equations are singular, and it was located as well as it can be.
    orbit = beside[0] if beside[0].kind else stored_orbit(_orbit_at(cycles, beside, value))
    values, along = _exponents(subject, orbit, value)
    mesh = orbit.mesh
    tau = mesh.spread(_PLACES)
    states = mesh.interpolate(orbit.states, tau).T
    ordinate, amplitude = subject.observables(states, value)
    low, high, least, largest = orbit_extremes(subject, mesh, orbit.states, value)
    speed = np.abs(ordinate) if subject.shows_rotor_speed else np.full(_PLACES, np.nan)
    # Multiplied by the first speed, the first angle is 0, too, or nan.
    rotor_angle = np.cumsum([0.0 * speed[0], *((speed[1:] + speed[:-1]) / 2 * np.diff(tau))]) * orbit.period
    pieces = mesh.pieces(subject.observables(orbit.states.T, value)[0][:, None])[..., 0]
    whole = (
        abs(float((mesh.weights * (pieces @ mesh.basis.values.T)).sum())) * orbit.period
        if subject.shows_rotor_speed
        else np.nan
    )
    return ReportedOrbit(
        value, orbit.period, whole, low, high, least, largest, values, along, tau, ordinate, amplitude, rotor_angle,
        states, orbit.kind,
    )  # fmt: skip


def _orbit_at(cycles: Cycles, beside: Sequence[StoredOrbit], value: float) -> Cycle:
    """Compute the orbit at a value by following the branch from a stored one: Newton's method alone may lead to another branch.

    Raises ``RunError``, also where the orbit is not as accurate as those of a branch have to be.
    """
    reason = "the branch does not lead to it from the orbits beside it"
    for orbit in beside:
        with suppress(RunError):
            cycle = _solve_by_newton(cycles, _followed_to(cycles, orbit, value), value)
            if cycle.is_accurate:
                return cycle
            reason = f"the finest mesh is too coarse for it: its states are known to {cycle.error:.1g} of their range only"
    raise RunError(reason)


def _solve_by_newton(cycles: Cycles, orbit: StoredOrbit, value: float) -> Cycle:
    return cycle_from_nodes(cycles, orbit.mesh, orbit.states, orbit.period, value)


def _followed_to(cycles: Cycles, orbit: StoredOrbit, value: float) -> StoredOrbit:
    """Return the first orbit with a value on the branch from another one, towards that value. Raises ``RunError``."""
    if orbit.value == value:
        return orbit
    cycles = replace(cycles, steps=replace(cycles.steps, first=_FIRST_STEP, points=_STEPS_THERE))
    here, up = _solve_by_newton(cycles, orbit, orbit.value), value > orbit.value
    for there in cycles.walk(here if (here.point.tangent[-1] > 0) == up else cycles.backwards(here)):
        for cycle in cycles_with(cycles, (here, there), value):
            return stored_orbit(cycle)
        here = there
    raise RunError("the branch does not lead there")


def _exponents(subject: OrbitProblem, orbit: StoredOrbit, value: float) -> tuple[np.ndarray, float]:
    """Return the exponents per unit of time, the largest first, and ln mu of the trivial multiplier."""
    parameters = {**subject.values, subject.path: value}
    at_edges = orbit.states[:: orbit.mesh.degree].T
    maps, flow = integrated_maps(subject.system, parameters, orbit.mesh.edges * orbit.period, at_edges)
    across, along = transverse_maps(maps, flow)
    values = logarithms(across)[0] / orbit.period
    return values[np.argsort(-values.real, kind="stable")], along
