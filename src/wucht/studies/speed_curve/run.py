"""Plan -> findings: the search at some values, the branches, and the states at the machine's own value."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.analysis.configurations.closed_form import State
from wucht.dynamics.work import Work
from wucht.errors import RunError, WuchtError
from wucht.studies.speed_curve.family_curve import FamilyCurve
from wucht.studies.speed_curve.following import FollowedBranch, Stability, exact, followed, known, of_share, repeats, stability
from wucht.studies.speed_curve.prepare import Plan
from wucht.studies.speed_curve.second_parameter import FollowedCurve, SecondParameter, curve_through, passes, starts
from wucht.studies.speed_curve.steady_states import Found, SteadyStates

MOST_BRANCHES = 100  # of one value of the second parameter
_SEARCHING = 0.9  # share of the work


@dataclass(frozen=True)
class SearchedAt:
    """A value at which all states were searched, and between which speeds. failure: why they could not be."""

    value: float
    second: float | None
    states: int
    complete: bool
    shown: str
    speeds: tuple[float, float] | None = None
    failure: str | None = None


@dataclass(frozen=True)
class OwnState:
    """A state at the machine's own value: u (n+1,), exponents (k,), the number of its branch, and of a family the share of its
    members that are stable.
    """

    u: np.ndarray
    exponents: np.ndarray
    branch: int
    share: float | None = None

    @property
    def stability(self) -> Stability:
        """Of the state, or of the family's members."""
        return Stability(int(stability(self.exponents[:, None])[0])) if self.share is None else of_share(self.share)


@dataclass(frozen=True)
class Findings:
    """So far. curves: of folds and Hopf points in two parameters. lost: sentences on what could not be followed. complete:
    nothing is left to do.
    """

    searched: tuple[SearchedAt, ...] = ()
    branches: tuple[FollowedBranch, ...] = ()
    own: tuple[OwnState, ...] = ()
    curves: tuple[FollowedCurve, ...] = ()
    lost: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False


Stage = Generator[Findings, None, Findings]  # each more complete than that before; the last is returned


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Search and follow; the findings after each branch."""
    findings, share = Findings(), (1.0 if plan.plane is None else 0.5) / len(plan.curves)
    for k, ((second, states), family) in enumerate(zip(plan.curves, plan.families, strict=True)):
        part = work.part("branches" if second is None else f"{second!r}", k * share, (k + 1) * share)
        findings = yield from _one(_Done(plan, second, findings), states, family, part)
    if plan.plane is not None:
        findings = yield from _curves(plan.curves[0][1], plan.plane, findings, work)
    work.report(1.0)
    yield replace(findings, complete=True)


def _one(done: _Done, states: SteadyStates, family: FamilyCurve | None, work: Work) -> Stage:
    """With one value of the second parameter."""
    searched = done.plan.searched
    for i, value in enumerate(searched):
        share = _SEARCHING * i / len(searched)
        work.report(share, f"searching at {states.path} = {value:.5g}")
        watch = partial(work.report, share, "searching")
        found = work.unit(f"states at {value!r}", partial(_searched, states, value, watch))
        yield done.add_search(value, found)
        if isinstance(found, str):
            continue
        for state in found.families if done.wanted("compensating") else ():
            if not done.full and family is not None and not any(family.same(b, state, value) for b in done.families):
                unit = work.unit(f"family {len(done.branches)}", partial(_family, family, state, value))
                yield done.add(unit, states.path, value)
        for u in found.points:
            if done.full or not done.wanted(states.kind(u).name) or known(states, done.branches, u):
                continue
            branch = work.unit(f"branch from {u.tolist()!r}", partial(_from, states, u, None))
            # A state that is a special point itself may belong to a known branch and yet not be recognised on it.
            if isinstance(branch, str):
                yield done.add(branch, states.path, value)
            elif not repeats(states, done.branches, branch):
                yield done.add(branch, states.path, value)
                yield from _offshoots(states, done, branch, work)
    own = states.own_value
    if done.second is None and states.bounds[0] <= own <= states.bounds[1]:
        work.report(_SEARCHING, "the machine's own value")
        yield done.add_own(work.unit("own", partial(_own, states, family, tuple(done.branches), own)))
    return done.findings


def _curves(states: SteadyStates, second: SecondParameter, findings: Findings, work: Work) -> Stage:
    """The curves through all folds and Hopf points, each once."""
    special = starts(findings.branches)
    for k, (of, kind, u) in enumerate(special):
        work.report(0.5 + 0.5 * k / len(special), f"{of}s in two parameters")
        if any(passes(states, second, c, of, u) for c in findings.curves):
            continue
        curve = work.unit(f"curve {k}", partial(curve_through, states, second, of, kind, u))
        if isinstance(curve, str):
            sentence = f"the {of} at {states.path} = {u[-1]:.6g} is not followed as {second.path} changes: {curve}"
            findings = replace(findings, lost=(*findings.lost, sentence))
        else:
            findings = replace(findings, curves=(*findings.curves, curve))
        yield findings
    return findings


class _Done:
    """What has been found with one value of the second parameter, beside the findings before it."""

    def __init__(self, plan: Plan, second: float | None, before: Findings) -> None:
        self.plan, self.second, self.findings = plan, second, before
        self.branches: list[FollowedBranch] = []

    @property
    def families(self) -> list[FollowedBranch]:
        """Those branches that stand for families."""
        return [b for b in self.branches if b.dimension]

    @property
    def full(self) -> bool:
        """Whether no more branches are followed."""
        return len(self.branches) >= MOST_BRANCHES

    def wanted(self, name: str | None) -> bool:
        """Whether states of this name were asked for."""
        return self.plan.spec.only is None or name in self.plan.spec.only

    def add_search(self, value: float, found: Found | str) -> Findings:
        """With one more value at which it was searched."""
        if isinstance(found, str):
            made = SearchedAt(value, self.second, 0, False, "", failure=found)
        else:
            count = len(found.points) + len(found.families)
            made = SearchedAt(value, self.second, count, found.complete, found.shown, found.speeds)
        self.findings = replace(self.findings, searched=(*self.findings.searched, made))
        return self.findings

    def add(self, branch: FollowedBranch | str, path: str, value: float) -> Findings:
        """With one more branch, or the sentence why it cannot be followed."""
        if isinstance(branch, str):
            sentence = f"a state at {path} = {value:.6g} is not followed: {branch}"
            self.findings = replace(self.findings, lost=tuple(dict.fromkeys((*self.findings.lost, sentence))))
        else:
            self.branches.append(replace(branch, second=self.second))
            self.findings = replace(self.findings, branches=(*self.findings.branches, self.branches[-1]))
            if self.full:
                sentence = f"more than {MOST_BRANCHES} branches: the others are left out; study.only restricts them"
                self.findings = replace(self.findings, lost=(*self.findings.lost, sentence))
        return self.findings

    def add_own(self, states: Sequence[OwnState]) -> Findings:
        """With the states at the machine's own value."""
        self.findings = replace(self.findings, own=tuple(states))
        return self.findings


def _searched(states: SteadyStates, value: float, watch: partial[None]) -> Found | str:
    """All states at a value, or why they cannot be found there."""
    try:
        return states.found(value, watch)
    except WuchtError as error:
        return str(error)


def _from(states: SteadyStates, u: np.ndarray, towards: np.ndarray | None) -> FollowedBranch | str:
    """The branch through a point near u, in a direction where one is given; or why there is none."""
    problem = states.equilibria
    try:
        return followed(states, problem.start(u[:-1], u[-1]) if towards is None else problem.curve.start(u, towards))
    except RunError as error:
        return str(error)


def _family(family: FamilyCurve, state: State, value: float) -> FollowedBranch | str:
    try:
        return family.branch(state, value)
    except RunError as error:
        return str(error)


def _offshoots(states: SteadyStates, done: _Done, first: FollowedBranch, work: Work) -> Iterator[Findings]:
    """The branches that cross one, and those that cross them."""
    pending = [*first.offshoots]
    while pending and not done.full:
        u, towards = pending.pop(0)
        if known(states, done.branches, u) or not done.wanted(states.kind(u).name):
            continue
        # Near the branch point where they cross, two branches are not yet told apart: the whole one is.
        branch = work.unit(f"offshoot {u.tolist()!r}", partial(_from, states, u, towards))
        if isinstance(branch, str):
            yield done.add(branch, states.path, float(u[-1]))
        elif not repeats(states, done.branches, branch):
            yield done.add(branch, states.path, float(u[-1]))
            pending += branch.offshoots


def _own(
    states: SteadyStates, family: FamilyCurve | None, branches: Sequence[FollowedBranch], own: float
) -> tuple[OwnState, ...]:
    found: list[OwnState] = []
    for k, branch in enumerate(branches):
        if not branch.dimension:
            found += [OwnState(p.u, states.equilibria.seen(p).eigenvalues, k) for p in exact(states, branch, own)]
        elif family is not None:
            found += [OwnState(u, exponents, k, share) for u, exponents, share in family.at(branch, own)]
    return tuple(found)
