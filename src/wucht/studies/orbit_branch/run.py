"""Plan -> findings: steady states, first orbits, the branches through them both ways, and orbits that are reported."""

from __future__ import annotations

from collections.abc import Generator, Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import partial

import numpy as np

from wucht.dynamics.work import Work
from wucht.errors import RunError
from wucht.numerics.periodic.branch_ends import CLOSED
from wucht.numerics.periodic.cycle import Hidden
from wucht.studies.orbit_branch.first_orbits import SeedOrbit, Tried, orbit_of_run, orbits_of_hopf_points
from wucht.studies.orbit_branch.orbit_walk import KeptOrbit, WalkedOrbits, walked
from wucht.studies.orbit_branch.prepare import Plan
from wucht.studies.orbit_branch.single_orbits import ReportedOrbit, near, reported
from wucht.studies.speed_curve.following import FollowedBranch
from wucht.studies.speed_curve.run import run as run_curve

MOST_BRANCHES = 20
_REPORTED = 10  # along each branch, by default
_SAME = 1e-2  # relative: an orbit that lies on a branch, by period and range of what is drawn between neighbours
_STEADY, _FIRST, _BRANCHES = 0.15, 0.25, 0.8  # shares of the work, by which these are done


@dataclass(frozen=True)
class OrbitBranchFound:
    """A branch: backward and onward from its first orbit; backward is None where it begins there, or is closed."""

    seed: SeedOrbit
    backward: WalkedOrbits | None
    onward: WalkedOrbits

    @property
    def parts(self) -> tuple[WalkedOrbits, ...]:
        """Those there are, in order."""
        return (self.onward,) if self.backward is None else (self.backward, self.onward)

    def joined(self, name: str) -> np.ndarray:
        """An array (..., N) over the whole branch, the backward part turned round and the first orbit once."""
        onward = getattr(self.onward, name)
        if self.backward is None:
            return np.asarray(onward)
        return np.concatenate([getattr(self.backward, name)[..., :0:-1], onward], axis=-1)

    @property
    def kinds(self) -> tuple[str, ...]:
        """Of all orbits."""
        return (() if self.backward is None else self.backward.kinds[:0:-1]) + self.onward.kinds

    @property
    def hidden(self) -> tuple[Hidden | None, ...]:
        """Of all orbits."""
        return (() if self.backward is None else self.backward.hidden[:0:-1]) + self.onward.hidden

    @property
    def kept(self) -> tuple[KeptOrbit, ...]:
        """In order."""
        return (() if self.backward is None else self.backward.kept[:0:-1]) + self.onward.kept


@dataclass(frozen=True)
class Findings:
    """So far.

    steady: branches of steady states. tried: runs. reported: orbits, with the number of their branch. lost: sentences on what
    was not found. complete: nothing is left to do.
    """

    steady: tuple[FollowedBranch, ...] = ()
    tried: tuple[Tried, ...] = ()
    branches: tuple[OrbitBranchFound, ...] = ()
    reported: tuple[tuple[int, ReportedOrbit], ...] = ()
    lost: tuple[str, ...] = field(default_factory=tuple)
    complete: bool = False


Stage = Generator[Findings, None, Findings]


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Search and follow; the findings after each step."""
    findings = Findings()
    if plan.curve is not None:
        for found in run_curve(plan.curve, work.part("steady", 0.0, _STEADY)):
            findings = replace(findings, steady=found.branches)
            yield findings
    findings = yield from _first(plan, findings, work)
    findings = yield from _reported(plan, findings, work)
    work.report(1.0)
    yield replace(findings, complete=True)


def _first(plan: Plan, findings: Findings, work: Work) -> Stage:
    """First orbits, each of which that is on no known branch is followed at once."""
    spec, of = plan.spec, (plan.subject, plan.bounds)
    for i, value in enumerate(plan.at):
        share = _STEADY + (_FIRST - _STEADY) * i / len(plan.at)
        work.report(share, f"a run at {plan.along.path} = {value:.5g}")
        watch = partial(work.report, share, "a run until it settles")
        run_there = partial(orbit_of_run, *of, value, spec.until, spec.longest, watch)
        tried = work.unit(f"run at {value!r}", run_there)
        findings = replace(findings, tried=(*findings.tried, tried))
        yield findings
        if tried.orbit is not None:
            findings = yield from _followed(plan, tried.orbit, findings, work)
            if spec.at is None:
                return findings
    sizes = None if plan.curve is None else plan.curve.curves[0][1].equilibria.equations.scale[:-1]
    if not findings.branches and sizes is not None and len(sizes) == len(plan.subject.turning):
        seeds = work.unit("hopf points", partial(orbits_of_hopf_points, *of, findings.steady, sizes, spec.longest))
        findings, begun = _told(findings, seeds)
        for seed in begun:
            findings = yield from _followed(plan, seed, findings, work)
    return findings


def _followed(plan: Plan, first: SeedOrbit, findings: Findings, work: Work) -> Stage:
    """The branch through an orbit, and, where that is asked for, those that cross it."""
    pending = [first]
    while pending and len(findings.branches) < MOST_BRANCHES:
        seed, k = pending.pop(0), len(findings.branches)
        if any(_on(branch, seed) for branch in findings.branches) and not len(seed.towards):
            continue
        halves = list[WalkedOrbits]()
        for onward in (True, False) if not len(seed.towards) else (True,):
            name = f"branch {k} {'onward' if onward else 'backward'} from {seed.begun}"
            part = work.part(name, _FIRST, _BRANCHES)
            half = part.unit("", partial(_walked, plan, seed, onward, part))
            if isinstance(half, str):
                findings = replace(findings, lost=(*findings.lost, half))
                break
            halves.append(half)
            if half.end.kind == CLOSED:
                break
        if not halves:
            yield findings
            continue
        found = OrbitBranchFound(seed, halves[1] if len(halves) > 1 else None, halves[0])
        if len(seed.towards) and any(_repeats(branch, found) for branch in findings.branches):
            continue
        findings = replace(findings, branches=(*findings.branches, found))
        findings, more = _told(findings, [o for half in halves for o in half.offshoots])
        yield findings
        pending += more
    return findings


def _told(findings: Findings, found: Sequence[SeedOrbit | str]) -> tuple[Findings, list[SeedOrbit]]:
    """The orbits among those found, and the findings with the sentences on those that were not."""
    lost = [one for one in found if isinstance(one, str)]
    return replace(findings, lost=(*findings.lost, *lost)), [one for one in found if not isinstance(one, str)]


def _walked(plan: Plan, seed: SeedOrbit, onward: bool, work: Work) -> WalkedOrbits | str:
    low, high = plan.bounds
    begin, to = seed.value, high if onward else low

    def watch(value: float) -> None:
        done = abs(value - begin) / max(abs(to - begin), 1e-300)
        work.report(min(done, 1.0), f"orbits, {plan.along.path} = {value:.6g}")

    try:
        return walked(plan.subject, plan.bounds, seed, onward, plan.spec.switch, watch)
    except RunError as error:
        return f"the branch from {seed.begun} is not followed: {error}"


def _on(branch: OrbitBranchFound, seed: SeedOrbit) -> bool:
    """Whether an orbit lies on a branch: with the same period between neighbours at its value."""
    return _passes(branch, seed.value, seed.period)


def _passes(branch: OrbitBranchFound, value: float, period: float) -> bool:
    values, periods = branch.joined("values"), branch.joined("periods")
    for i in np.flatnonzero((values[:-1] - value) * (values[1:] - value) <= 0).tolist():
        width = values[i + 1] - values[i]
        share = (value - values[i]) / width if width else 0.0
        if abs((periods[i] + share * (periods[i + 1] - periods[i])) / period - 1) < _SAME:
            return True
    return False


def _repeats(branch: OrbitBranchFound, other: OrbitBranchFound) -> bool:
    """Whether a branch is a known one, seen from another of its special points: its orbits in the middle lie on that."""
    values, periods = other.joined("values"), other.joined("periods")
    low, high, own_low, own_high = branch.joined("low"), branch.joined("high"), other.joined("low"), other.joined("high")
    k = len(values) // 2
    known = branch.joined("values")
    i = int(np.abs((known - values[k]) / np.ptp(known).clip(1e-300)).argmin())
    alike = abs(low[i] - own_low[k]) + abs(high[i] - own_high[k]) < _SAME * max(own_high[k] - own_low[k], 1e-300)
    return alike and _passes(branch, float(values[k]), float(periods[k]))


def _reported(plan: Plan, findings: Findings, work: Work) -> Stage:
    """The orbits at the values that were asked for, and at special points."""
    wanted = [(k, *each) for k, b in enumerate(findings.branches) for each in _wanted(plan, b)]
    for i, (k, value, beside) in enumerate(wanted):
        work.report(_BRANCHES + (1 - _BRANCHES) * i / len(wanted), f"exponents at {plan.along.path} = {value:.6g}")
        seed = findings.branches[k].seed
        one = work.unit(
            f"orbit {i} of branch {k} at {value!r}", partial(reported, plan.subject, plan.bounds, seed, beside, value)
        )
        if isinstance(one, str):
            findings = replace(findings, lost=(*findings.lost, one))
        else:
            findings = replace(findings, reported=(*findings.reported, (k, one)))
        yield findings
    return findings


def _wanted(plan: Plan, branch: OrbitBranchFound) -> list[tuple[float, tuple[KeptOrbit, ...]]]:
    """Values, and the orbits beside them."""
    values = branch.joined("values")
    inside = np.linspace(values.min(), values.max(), _REPORTED + 1)[:-1] + np.ptp(values) / (2 * _REPORTED)
    asked = plan.values if plan.values is not None else tuple(inside.tolist())
    regular = [orbit for orbit in branch.kept if not orbit.kind]
    wanted = [(value, beside) for value in asked for beside in near(regular, value)]
    return sorted([*wanted, *((o.value, (o,)) for o in branch.kept if o.kind)], key=lambda each: each[0])
