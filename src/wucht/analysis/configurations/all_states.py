"""All steady phase configurations of a machine: in closed form where there is one, else searched; and how that is shown."""

from __future__ import annotations

import numpy as np

from wucht.analysis.configurations.closed_form import State, at_speed, branches, has_closed_form, over_speeds, pattern_count
from wucht.analysis.configurations.search import Search, Watch, by_subdivision, search, speeds_in_line, speeds_said
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.forced import Forced
from wucht.analysis.working_points import TorqueCurves

_PATTERNS = 64  # ways to be in line for which the speeds are proved complete
_EQUAL_SPEEDS = 1e-6  # relative
_POINTS = 1200  # of the grid of speeds
_PROBES = 50  # speeds at which bodies must be without torques of their own


def all_states(torques: SteadyTorques, low: float, high: float, watch: Watch = None) -> Search:
    """All states, each verified; the speed between low and high, in the main rotor's own sense, where it is not given.

    watch: called often; what it raises ends the search.
    """
    if not in_closed_form(torques, low, high):
        searched = search(torques, low, high, watch)
    elif torques.given is not None:
        searched = Search(at_speed(torques, torques.given), True, "closed form: other phases than these do not stay")
    else:
        searched = _over_speeds(torques, low, high, watch)
    verified = [s for s in searched.states if torques.balanced(s.speed, s.phases)]
    missed = len(searched.states) - len(verified)
    if not missed:
        return searched
    return Search(verified, False, f"{searched.shown}; {missed} more do not fulfil the balance of the torques")


def in_closed_form(torques: SteadyTorques, low: float, high: float) -> bool:
    """Whether the phases are known in closed form at these speeds.

    Raises ``InputError`` where a body has no unbalance, so that nothing fixes its phase.
    """
    at = np.array([torques.given]) if torques.given is not None else np.linspace(low, high, _PROBES)
    known = has_closed_form(torques, at)
    if known:
        branches(torques, at)
    return known


def _over_speeds(torques: SteadyTorques, low: float, high: float, watch: Watch) -> Search:
    """In closed form over the speed; the speeds compared with those that subdivision finds."""
    states, grid = list[State](), _grid(torques, low, high)
    for a, b in torques.parts(low, high):
        states += over_speeds(torques, np.unique([a, *grid[(grid > a) & (grid < b)], b]))
    closed = sorted(s.speed for s in states if s.beside or torques.size == 2)
    where, proved = speeds_said(torques, low, high), _proved_speeds(torques, low, high, watch)
    if proved is None or len(proved) != len(closed) or not np.allclose(proved, closed, rtol=_EQUAL_SPEEDS):
        return Search(states, False, f"phases in closed form; {where} on a grid: it is not shown that no state is missing")
    return Search(states, True, f"phases in closed form; {where} by subdivision with bounds on the Jacobian")


def _grid(torques: SteadyTorques, low: float, high: float) -> np.ndarray:
    """Speeds (N,) that resolve the resonances and the characteristic of the drive."""
    machine, sense = torques.machine, float(torques.senses[0])
    ends = (sense * low, sense * high)
    forced = Forced.of(machine, np.zeros(torques.size))
    curves = TorqueCurves(machine, machine.rotor, forced, (min(ends), max(ends)), _POINTS)
    grid: np.ndarray = np.sort(sense * curves.grid)
    return grid


def _proved_speeds(torques: SteadyTorques, low: float, high: float, watch: Watch) -> list[float] | None:
    """The speeds of all states in line, by subdivision; None where it is not shown that these are all."""
    if torques.size == 2:
        searched = by_subdivision(torques, low, high, watch=watch)
        return sorted(s.speed for s in searched.states) if searched.complete else None
    if not torques.classes or pattern_count(torques) > _PATTERNS:
        return None
    each = speeds_in_line(torques, low, high, watch)
    return None if each is None else sorted(w for speeds in each for w in speeds)
