"""Bifurcation diagram of steady states: the search at some values of a parameter, and the branches through these states."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.dynamics.branches.averaged_equilibria import AveragedEquilibria
from wucht.dynamics.branches.equilibrium_branches import (
    EquilibriumBranch,
    StabilityLevel,
    branch_through,
    is_duplicate,
    lies_on,
    points_with_value,
    stability_from_fraction,
    stability_levels,
)
from wucht.dynamics.branches.family_curve import FamilyCurve
from wucht.dynamics.branches.plane_regions import Range
from wucht.dynamics.branches.second_parameter import (
    BifurcationCurve,
    SecondParameter,
    curve_starts,
    curve_through,
    lies_on_curve,
)
from wucht.dynamics.branches.steady_states import (
    StatesAtValue,
    SteadyStates,
    SystemEquilibria,
    speed_range_text,
)
from wucht.dynamics.parameters import checked_range, parameter_of
from wucht.dynamics.work import Work, result_or_reason, with_result
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject

MOST_BRANCHES = 100  # at one value of the second parameter
_SEARCHING = 0.9  # share of the work
_NEAR_AN_END = 1e-3  # of the range
_DECADE = 10.0


@dataclass(frozen=True)
class BranchCase:
    """Definition of a bifurcation diagram of steady states; ``BranchCase.of`` makes it of a machine or of user equations.

    Attributes
    ----------
    states_by_second_value : mapping of float or None to SteadyStates
        The steady states along the parameter, for each value of a second one (None where there are no such values).
    plane : SecondParameter or None
        The second parameter where it has a range.
    values : tuple of float
        Of the parameter, at which all states are searched.
    only : tuple of str or None
        The names of states that are followed, None for all.
    """

    states_by_second_value: Mapping[float | None, SteadyStates]
    plane: SecondParameter | None
    values: tuple[float, ...]
    only: tuple[str, ...] | None

    @classmethod
    def of(
        cls, subject: Subject, path: str, bounds: Range, points: int = 5, only: tuple[str, ...] | None = None,
        show: str | None = None, ranges: Mapping[str, Range] | None = None, inertia: bool | None = None,
        plane: SecondParameter | None = None, second: tuple[str, tuple[float, ...]] | None = None,
    ) -> BranchCase:  # fmt: skip
        """Set up the states of a machine, or of user equations, over a parameter.

        Parameters
        ----------
        subject : Machine or UserSystem
        path : str
            Of the parameter, such as ``"drive.slope"``.
        bounds : (float, float)
            Its range, in SI.
        points : int
            Values in the range, besides those near both ends, at which all states are searched.
        only : tuple of str, optional
            Names of states of a machine that are followed, None for all.
        show : str, optional
            The state that is drawn; None: the main rotor's speed, of user equations their first state.
        ranges : mapping of str to (float, float), optional
            Of the states of user equations, in which equilibria are searched.
        inertia : bool, optional
            Of a machine's balancing bodies in the averaged equations; None: as is usual for the machine.
        plane : SecondParameter, optional
            A second parameter with its range: folds and Hopf points are followed in both.
        second : (str, tuple of float), optional
            Another parameter and its values: a diagram for each.

        Returns
        -------
        BranchCase

        Raises
        ------
        InputError
            Where one of these does not fit the subject, or it has no averaged equations.
        """
        bounds = checked_range(subject, parameter_of(subject, path), bounds)
        subjects: dict[float | None, Subject] = {None: subject} if second is None else {
            value: subject.with_values({second[0]: value}) for value in second[1]
        }  # fmt: skip
        for key, value in (("only", only), ("inertia", inertia)) if not isinstance(subject, Machine) else ():
            if value is not None:
                raise InputError(f"study.{key}", value, "allowed for a machine only")
        states_by_second_value = {v: _states(there, path, bounds, show, ranges, inertia) for v, there in subjects.items()}
        return cls(states_by_second_value, plane, _searched_values(bounds, points), only)

    def includes(self, name: str | None) -> bool:
        """True if states of a name are followed."""
        return self.only is None or name in self.only

    @property
    def steady_states(self) -> SteadyStates:
        """States along the parameter, at the first value of the second one."""
        return next(iter(self.states_by_second_value.values()))


def _states(
    subject: Subject, path: str, bounds: Range, show: str | None, ranges: Mapping[str, Range] | None, inertia: bool | None
) -> SteadyStates:
    if not isinstance(subject, Machine):
        return SystemEquilibria.of(subject, path, bounds, ranges, show)
    if ranges is not None:
        raise InputError("study.ranges", dict(ranges), "allowed for a table [system] only")
    return AveragedEquilibria.of(subject, path, bounds, show, inertia)


def _searched_values(bounds: Range, points: int) -> tuple[float, ...]:
    """Return values over a range, evenly or, over decades, in a constant ratio, and one near each end."""
    (low, high), between = bounds, (np.arange(points) + 0.5) / points
    inside = low * (high / low) ** between if low > 0 and high > _DECADE * low else low + (high - low) * between
    near = _NEAR_AN_END * (high - low)
    return (low + near, *inside.tolist(), high - near)


@dataclass(frozen=True)
class NominalState:
    """State at the parameter's nominal value: unknowns (n+1,), exponents (k,), the number of its branch, and for a family the
    share of its members that are stable.
    """

    unknowns: np.ndarray
    exponents: np.ndarray
    branch: int
    share: float | None = None

    @property
    def stability(self) -> StabilityLevel:
        """Stability of the state, or of the family's members."""
        return (
            StabilityLevel(int(stability_levels(self.exponents[:, None])[0]))
            if self.share is None
            else stability_from_fraction(self.share)
        )

    @property
    def fastest_exponents(self) -> np.ndarray:
        """The exponents that there are, from the fastest growth on."""
        exponents = self.exponents[np.isfinite(self.exponents)]
        return np.asarray(exponents[np.argsort(-exponents.real, kind="stable")])


@dataclass(frozen=True)
class BranchFindings:
    """Branches and curves computed so far.

    Attributes
    ----------
    searches : tuple of StatesAtValue
        Values at which all states were searched, with these.
    branches : tuple of EquilibriumBranch
    nominal : tuple of NominalState
        States at the parameter's nominal value.
    curves : tuple of BifurcationCurve
        Of folds and Hopf points in two parameters.
    omissions : tuple of str
        Sentences on what could not be followed.
    complete : bool
        True where nothing is left to do.
    """

    searches: tuple[StatesAtValue, ...] = ()
    branches: tuple[EquilibriumBranch, ...] = ()
    nominal: tuple[NominalState, ...] = ()
    curves: tuple[BifurcationCurve, ...] = ()
    omissions: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False

    @property
    def knows_all_states(self) -> bool:
        """True if all states are known at the values at which they were searched."""
        return bool(self.searches) and all(s.complete for s in self.searches)

    def evidence(self, speed_unit: str) -> str:
        """Return the evidence for that, or the reason why not, for all values at which states were searched."""
        first_evidence = self.searches[0].evidence if self.searches else ""
        sentence = next((s.evidence for s in self.searches if not s.complete and s.evidence), first_evidence)
        speeds = [s.speeds for s in self.searches if s.speeds is not None]
        if not speeds:
            return sentence
        widest = min(low for low, _ in speeds), max(high for _, high in speeds)
        return f"{sentence}; over all of them {speed_range_text(widest, speed_unit)}"

    def branches_at(self, second: float | None) -> list[EquilibriumBranch]:
        """Return the branches at a value of the second parameter."""
        return [b for b in self.branches if b.second == second]

    def is_full(self, second: float | None) -> bool:
        """True if no more branches are followed at a value of the second parameter."""
        return len(self.branches_at(second)) >= MOST_BRANCHES

    def with_branch(self, branch: EquilibriumBranch | str, at: str, second: float | None) -> BranchFindings:
        """Add a branch, or the sentence why it cannot be followed. at: the place of its first state, as text."""
        if isinstance(branch, str):
            return replace(
                self, omissions=tuple(dict.fromkeys((*self.omissions, f"a state at {at} is not followed: {branch}")))
            )
        more = replace(self, branches=(*self.branches, replace(branch, second=second)))
        sentence = f"more than {MOST_BRANCHES} branches: the others are left out; study.only restricts them"
        return replace(more, omissions=(*self.omissions, sentence)) if more.is_full(second) else more


Stage = Generator[BranchFindings, None, BranchFindings]  # each more complete than the one before; the last is returned


def follow_branches(case: BranchCase, work: Work) -> Iterator[BranchFindings]:
    """Search all steady states and follow their branches.

    Parameters
    ----------
    case : BranchCase
    work : Work

    Yields
    ------
    BranchFindings
        After each branch; the last ones are complete.

    Examples
    --------
    >>> import wucht
    >>> from wucht.dynamics import BranchCase, Work, follow_branches
    >>> machine = wucht.load_machine("drozdetskaya-2020/table-3.1-carrier")
    >>> case = BranchCase.of(machine, "u", (0.0, 5.0), points=1)
    >>> *_, findings = follow_branches(case, Work())
    >>> for branch in findings.branches:
    ...     print([f"{kind} at u = {u:.4f}" for kind, u in zip(branch.kinds, branch.parameter_values) if kind])
    ['fold at u = 2.6054', 'fold at u = 0.8937']
    """
    findings, share = BranchFindings(), (1.0 if case.plane is None else 0.5) / len(case.states_by_second_value)
    for k, (second, steady_states) in enumerate(case.states_by_second_value.items()):
        part = work.part("branches" if second is None else f"{second!r}", k * share, (k + 1) * share)
        findings = yield from _follow_at_second(case, findings, second, steady_states, part)
    if case.plane is not None:
        findings = yield from _curves(case.steady_states, case.plane, findings, work)
    work.report(1.0)
    yield replace(findings, complete=True)


def _follow_at_second(
    case: BranchCase, findings: BranchFindings, second: float | None, steady_states: SteadyStates, work: Work
) -> Stage:
    """Search and follow the branches at one value of the second parameter."""
    family = FamilyCurve(steady_states) if isinstance(steady_states, AveragedEquilibria) else None
    for i, value in enumerate(case.values):
        share, at = _SEARCHING * i / len(case.values), f"{steady_states.path} = {value:.6g}"
        work.report(share, f"searching at {steady_states.path} = {value:.5g}")
        report = partial(work.report, share, "searching")
        search = work.unit(f"states at {value!r}", partial(result_or_reason, steady_states.find_equilibria, value, report))
        if isinstance(search, str):
            search = StatesAtValue(value, failure=search)
        findings = with_result(findings, "searches", search)
        yield findings
        for state in search.families if case.includes("compensating") else ():
            known_branches = findings.branches_at(second)
            if findings.is_full(second) or family is None:
                continue
            if not any(family.is_same_family(b, state, value) for b in known_branches if b.dimension):
                branch = work.unit(
                    f"family {len(known_branches)}", partial(result_or_reason, family.follow_branch, state, value)
                )
                findings = findings.with_branch(branch, at, second)
                yield findings
        for unknowns in search.points:
            findings = yield from _follow_state(case, findings, second, steady_states, unknowns, work)
    nominal = steady_states.nominal_value
    if second is None and steady_states.bounds[0] <= nominal <= steady_states.bounds[1]:
        work.report(_SEARCHING, "the nominal value")
        at_value = work.unit("own", partial(_nominal, steady_states, family, findings.branches, nominal))
        findings = replace(findings, nominal=at_value)
        yield findings
    return findings


def _follow_state(
    case: BranchCase, findings: BranchFindings, second: float | None, steady_states: SteadyStates, first: np.ndarray, work: Work
) -> Stage:
    """Follow the branch through a state, the branches that cross it, and those that cross them."""
    pending: list[tuple[np.ndarray, np.ndarray | None]] = [(first, None)]
    while pending and not findings.is_full(second):
        unknowns, towards = pending.pop(0)
        known_branches = findings.branches_at(second)
        if not case.includes(steady_states.kind(unknowns).name) or lies_on(steady_states, known_branches, unknowns):
            continue
        name = "branch from" if towards is None else "offshoot"
        follow = partial(result_or_reason, _branch_from, steady_states, unknowns, towards)
        branch = work.unit(f"{name} {unknowns.tolist()!r}", follow)
        # A special point may belong to a known branch and yet not be recognised on it; and near the branch point where they
        # cross, two branches cannot be distinguished: compare the whole branch.
        if isinstance(branch, str) or not is_duplicate(steady_states, known_branches, branch):
            findings = findings.with_branch(branch, f"{steady_states.path} = {float(unknowns[-1]):.6g}", second)
            yield findings
            pending += [] if isinstance(branch, str) else branch.offshoots
    return findings


def _curves(steady_states: SteadyStates, second: SecondParameter, findings: BranchFindings, work: Work) -> Stage:
    """Follow the curves through all folds and Hopf points, each once."""
    special = curve_starts(findings.branches)
    for k, (bifurcation, kind, unknowns) in enumerate(special):
        work.report(0.5 + 0.5 * k / len(special), f"{bifurcation}s in two parameters")
        if any(lies_on_curve(steady_states, second, c, bifurcation, unknowns) for c in findings.curves):
            continue
        curve = work.unit(
            f"curve {k}", partial(result_or_reason, curve_through, steady_states, second, bifurcation, kind, unknowns)
        )
        missing = f"the {bifurcation} at {steady_states.path} = {unknowns[-1]:.6g} is not followed as {second.path} changes: "
        findings = with_result(findings, "curves", curve, missing)
        yield findings
    return findings


def _branch_from(steady_states: SteadyStates, unknowns: np.ndarray, towards: np.ndarray | None) -> EquilibriumBranch:
    """Follow the branch through a point near given unknowns, in a direction if any. Raises ``RunError`` where there is none."""
    problem = steady_states.equilibria
    return branch_through(
        steady_states, problem.start(unknowns[:-1], unknowns[-1]) if towards is None else problem.curve.start(unknowns, towards)
    )


def _nominal(
    steady_states: SteadyStates, family: FamilyCurve | None, branches: Sequence[EquilibriumBranch], value: float
) -> tuple[NominalState, ...]:
    nominal_states: list[NominalState] = []
    for k, branch in enumerate(branches):
        if not branch.dimension:
            nominal_states += [
                NominalState(p.unknowns, steady_states.equilibria.evaluate(p).eigenvalues, k)
                for p in points_with_value(steady_states, branch, value)
            ]
        elif family is not None:
            nominal_states += [
                NominalState(unknowns, exponents, k, share) for unknowns, exponents, share in family.states_at(branch, value)
            ]
    return tuple(nominal_states)
