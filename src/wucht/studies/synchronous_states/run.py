"""Plan -> findings: the search for states, the stability of each in the full equations, and the tiles of the map."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.configurations.averaged_stability import AveragedStability, Regions, Stability, regions
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.configuration import Configuration, Describer
from wucht.analysis.configurations.force_balance import members
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import Search, all_states
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.dynamics.work import Work
from wucht.studies.synchronous_states.prepare import Plan

MOST_FULL = 64  # states whose multipliers are computed
_SAMPLES = 7  # members of a family, besides the one that stands for it
_CELLS = 4000  # of a tile of the map
_SEARCHED, _JUDGED = 0.1, 0.8  # shares of the work after the search, and before the map
_NOT_ASKED = Stability.undecided("the multipliers were not asked for")
_TOO_MANY = Stability.undecided(f"multipliers are computed of {MOST_FULL} states at most")
_NOT_YET = Stability.undecided("its multipliers are not computed yet")


@dataclass(frozen=True)
class Findings:
    """The states that were searched, each described in their order, and the map as far as it is computed."""

    search: Search
    configurations: tuple[Configuration, ...]
    map: Regions | None = None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """The states as the averaged equations have them, then one by one as the full ones have them, then the map."""
    search = work.unit("search", partial(_searched, plan, work))
    describer = Describer(AveragedStability(plan.torques, plan.slow))
    full = [_NOT_ASKED if not plan.spec.full else _NOT_YET if k < MOST_FULL else _TOO_MANY for k in range(len(search.states))]
    each = [describer.described(state, known) for state, known in zip(search.states, full, strict=True)]
    yield Findings(search, tuple(each))
    if plan.spec.full and search.states:
        part = work.part("state", _SEARCHED, _JUDGED if plan.map is not None else 1.0)
        for k, judged in enumerate(_in_full_equations(plan, tuple(each[:MOST_FULL]), part)):
            each[k] = judged
            yield Findings(search, tuple(each))
    if plan.map is not None:
        for tiles in _tiles(plan.torques, *plan.map, work.part("map", _JUDGED, 1.0)):
            yield Findings(search, tuple(each), tiles)


def _searched(plan: Plan, work: Work) -> Search:
    """All states."""
    work.report(0.0, "searching")
    search = all_states(plan.torques, *plan.speeds or (0.0, 0.0), partial(work.report, 0.0, "searching"))
    if not plan.chosen:
        return search
    which = "these are all in this range, but its" if search.complete else "the"
    end = "upper end is the program's choice, as the drive runs away without load: study.range sets another"
    return Search(search.states, False, f"{search.shown}; {which} {end}")


def _in_full_equations(plan: Plan, states: Sequence[Configuration], work: Work) -> Iterator[Configuration]:
    """Each state with its stability in the full equations, and why the slow ones disagree."""
    full, count = FullStability(plan.torques, plan.spec.inertia), len(states)
    for k, c in enumerate(states):
        part = work.part(f"{k + 1}", k / count, (k + 1) / count)
        stability = _stability(plan, full, c.state, part)
        why = part.unit("disagreement", partial(full.why, c.state, c.slow, stability))
        yield replace(c, full=stability, disagreement=why)


def _stability(plan: Plan, full: FullStability, state: State, work: Work) -> Stability:
    """Of a state; of a family, along which the multipliers differ, as far as some of its members agree."""
    work.report(0.0, "multipliers of the full equations")
    stability = work.unit("multipliers", partial(full.stability, state))
    if not state.dimension:
        return stability
    others, verdicts = members(plan.torques, _SAMPLES).T, [stability.stable]
    for i, phases in enumerate(others):
        work.report((i + 1) / (len(others) + 1), "multipliers along a family")
        member = replace(state, phases=phases)
        verdicts.append(work.unit(f"member {i + 1}", partial(full.stability, member)).stable)
    decided = [stable for stable in verdicts if stable is not None]
    if stability.stable is None or len(set(decided)) < 2:
        return stability
    this = "stable" if stability.stable else "not stable"
    reason = f"stable at {sum(decided)} of {len(decided)} members of the family that were looked at, {this} at this one"
    return Stability(None, stability.exponents, reason)


def _tiles(torques: SteadyTorques, speeds: np.ndarray, ratios: np.ndarray, work: Work) -> Iterator[Regions]:
    """The map as far as it is computed: some rows, of one ratio each, at a time."""
    rows, tiles = max(_CELLS // len(speeds), 2), list[Regions]()
    for begin in range(0, len(ratios), rows):
        work.report(begin / len(ratios), "the map")
        tiles.append(work.unit(f"rows from {begin}", partial(regions, torques, speeds, ratios[begin : begin + rows])))
        yield Regions.joined(tiles)
