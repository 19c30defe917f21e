"""All steady phase configurations of a machine, in closed form where there is one, else searched; and how that is shown.

There is none for several rotors and for bodies with torques of their own. Up to four bodies the torus of the phases, with the
speed where the drive decides it, is searched completely by subdivision. With more Newton's method starts from many places: then
it is not shown that no state is missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.analysis.configurations import closed_form
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.torques import SteadyTorques, separation
from wucht.analysis.configurations.torus import OnTheTorus, bounded
from wucht.analysis.vibration import Forced
from wucht.analysis.working_points import TorqueCurves
from wucht.numerics.subdivision import Zeros, all_zeros

MOST_BODIES = 4
_SMALLEST = 1e-6  # of the ranges: smaller boxes are along a family, or around a state at a fold
_BOXES = {1: 200_000, 2: 200_000, 3: 1_000_000, 4: 3_000_000}
_STARTS, _ROUNDS, _STEPS = 600, 8, 80
_AGAIN = 6  # times that all starts, when their indices show that a state is missing
_SAME = 1e-6  # rad, and share of the speed: two ends of Newton's method that are one state
_SETTLED = 1e-10  # of the largest torque: where Newton's method has arrived
_PATTERNS = 64  # ways to be in line for which the speeds are proved complete
_EQUAL_SPEEDS = 1e-6  # relative
_POINTS = 1200  # of the grid of speeds
_PROBES = 50  # speeds at which bodies must be without torques of their own

Watch = Callable[[], None] | None  # called often; what it raises ends the search


@dataclass(frozen=True)
class Search:
    """States, whether they are all, and how that was shown or why not."""

    states: list[State]
    complete: bool
    shown: str


def all_states(torques: SteadyTorques, low: float, high: float, watch: Watch = None, prove: bool = True) -> Search:
    """All states, each verified; the speed between low and high, in the main rotor's own sense, where it is not given.

    watch: called often; what it raises ends the search. prove: whether it is tried to show that closed forms miss no speed.
    """
    if not in_closed_form(torques, low, high):
        searched = search(torques, low, high, watch)
    elif torques.given is not None:
        states = closed_form.at_speed(torques, torques.given)
        searched = Search(states, True, "closed form: other phases than these do not stay")
    else:
        searched = _over_speeds(torques, low, high, watch, prove)
    verified = [s for s in searched.states if torques.balanced(s.speed, s.phases)]
    if missed := len(searched.states) - len(verified):
        return Search(verified, False, f"{searched.shown}; {missed} more do not fulfil the balance of the torques")
    return searched


def in_closed_form(torques: SteadyTorques, low: float, high: float) -> bool:
    """Whether the phases are known in closed form at these speeds.

    Raises ``InputError`` where a body has no unbalance, so that nothing fixes its phase.
    """
    at = np.array([torques.given]) if torques.given is not None else np.linspace(low, high, _PROBES)
    known = torques.size == 2 or (torques.size > 2 and torques.coefficients is not None and torques.idle(at))
    if known:
        closed_form.branches(torques, at)
    return known


def _over_speeds(torques: SteadyTorques, low: float, high: float, watch: Watch, prove: bool) -> Search:
    """In closed form over the speed; the speeds compared with those that subdivision finds."""
    machine, sense = torques.machine, float(torques.senses[0])
    ends = (min(sense * low, sense * high), max(sense * low, sense * high))
    curves = TorqueCurves(machine, machine.rotor, Forced.of(machine, np.zeros(torques.size)), ends, _POINTS)
    grid, states = np.sort(sense * curves.grid), list[State]()  # speeds that resolve resonances and the drive's characteristic
    for a, b in torques.parts(low, high):
        states += closed_form.over_speeds(torques, np.unique([a, *grid[(grid > a) & (grid < b)], b]))
    closed = sorted(s.speed for s in states if s.beside or torques.size == 2)
    speeds, proved = speeds_in_words(torques, low, high), _proved_speeds(torques, low, high, watch) if prove else None
    if proved is None or len(proved) != len(closed) or not np.allclose(proved, closed, rtol=_EQUAL_SPEEDS):
        return Search(states, False, f"phases in closed form; {speeds} on a grid: it is not shown that no state is missing")
    return Search(states, True, f"phases in closed form; {speeds} by subdivision with bounds on the Jacobian")


def _proved_speeds(torques: SteadyTorques, low: float, high: float, watch: Watch) -> list[float] | None:
    """The speeds of all states in line, by subdivision; None where it is not shown that these are all."""
    if torques.size == 2:
        searched = by_subdivision(torques, low, high, watch=watch)
        return sorted(s.speed for s in searched.states) if searched.complete else None
    provable = torques.classes and closed_form.pattern_count(torques) <= _PATTERNS
    return speeds_in_line(torques, low, high, watch) if provable else None


def search(torques: SteadyTorques, low: float, high: float, watch: Watch = None) -> Search:
    """All states, the speed between low and high where it is not given."""
    if torques.size <= MOST_BODIES:
        searched = by_subdivision(torques, low, high, watch=watch)
        if searched.complete:
            return searched
        if torques.size == 1:
            return Search(_working_points(torques, low, high), False, searched.shown)
        return Search(from_many_starts(torques, low, high, searched.states, watch=watch), False, searched.shown)
    states, given = list[State](), torques.given is not None
    for rounds in range(1, _AGAIN + 1):
        states = from_many_starts(torques, low, high, states, rounds - 1, watch)
        total = index(torques, states) if given else 0
        if not total:
            break
    shown = f"Newton's method from {_STARTS * _ROUNDS * rounds} starts: it is not shown that no state is missing"
    if given and total:
        shown += f"; their indices add up to {total} and not to 0: at least one is missing"
    elif given:
        shown += ", but their indices add up to 0, as they must"
    return Search(states, False, shown)


def _working_points(torques: SteadyTorques, low: float, high: float) -> list[State]:
    """The steady speeds of a single rotor on a grid."""
    machine, sense = torques.machine, float(torques.senses[0])
    ends = (min(sense * low, sense * high), max(sense * low, sense * high))
    curves = TorqueCurves(machine, machine.rotor, Forced.of(machine, np.zeros(1)), ends, _POINTS)
    return [State(w, np.zeros(1)) for w in sorted(sense * p.speed for p in curves.working_points) if low <= w <= high]


def index(torques: SteadyTorques, states: Sequence[State]) -> int:
    """The sum of the signs of det(df/dx): 0 if these are all states at a given speed (Poincare and Hopf, on the torus)."""
    if not states:
        return 0
    matrices = np.moveaxis(OnTheTorus(torques).jacobian(np.array([s.phases[1:] for s in states]).T), -1, 0)
    return int(sum(s.multiplicity * np.sign(np.linalg.det(m)) for s, m in zip(states, matrices, strict=True)))


def by_subdivision(
    torques: SteadyTorques, low: float, high: float, most_boxes: int | None = None, watch: Watch = None
) -> Search:
    """The same by subdivision alone, for up to four bodies. most_boxes: that are looked at, by default up to millions."""
    if not bounded(torques):
        return Search([], False, "a drive or load has a characteristic that jumps: it is not shown that no state is missing")
    searched = _zeros(torques, low, high, most_boxes or _BOXES[torques.size], watch)
    speeds, phases = OnTheTorus(torques).parted(np.concatenate([zeros.points for zeros in searched], axis=1))
    states = _grouped(torques, [State(w, at) for w, at in zip(speeds.tolist(), phases.T, strict=True)])
    what = "the phases" if torques.given is not None else f"the phases and {speeds_in_words(torques, low, high)}"
    boxes = sum(zeros.boxes for zeros in searched)
    if all(zeros.complete for zeros in searched):
        return Search(states, True, f"{what} were searched by subdivision, {boxes} boxes, with bounds on the Jacobian")
    left = sum(zeros.undecided[0].shape[1] for zeros in searched)
    return Search(states, False, f"{what} were searched by subdivision, but {left} of {boxes} boxes were not decided")


def _zeros(torques: SteadyTorques, low: float, high: float, most_boxes: int, watch: Watch) -> list[Zeros]:
    """The states of each part of the range of speeds, or of the speed that is given."""
    problem, n = OnTheTorus(torques), torques.size
    speeds = [([a], [b]) for a, b in torques.parts(low, high)] if torques.given is None else [([], [])]
    return [
        all_zeros(
            problem.function, problem.jacobian, problem.spread, [0.0] * (n - 1) + a, [2 * math.pi] * (n - 1) + b,
            periodic=[True] * (n - 1) + [False] * len(a), smallest=_SMALLEST, most_boxes=most_boxes, watch=watch,
        )
        for a, b in speeds
    ]  # fmt: skip


def speeds_in_words(torques: SteadyTorques, low: float, high: float) -> str:
    """The speeds that are searched."""
    searched = f"speeds from {low:.4g} to {high:.4g} {torques.machine.units.speed}".rstrip()
    poles = ", ".join(f"{at:.5g}" for at in torques.poles(low, high))
    return f"{searched} (but for {poles}, where the undamped vibration is infinite)" if poles else searched


def speeds_in_line(torques: SteadyTorques, low: float, high: float, watch: Watch = None) -> list[float] | None:
    """The speeds of all states of each of ``patterns``, by subdivision over the speed and the angle of the line.

    The bodies in line are taken for one that excites with their sum and feels like the first. None where something stays
    undecided.
    """
    if not bounded(torques):
        return None
    rotor, unit = torques.vibration.excitation[0], torques.vibration.excitation[1] / np.abs(torques.coefficients[1])  # type: ignore[index]
    every: list[float] = []
    for _, g, _, twice in closed_form.patterns(torques):
        line = replace(
            torques, names=(*torques.names[:1], "line"), heads=(0, 0), senses=torques.senses[:2],
            inertia=torques.inertia[:2, :2], relative=torques.relative[:2, :2],
            vibration=replace(torques.vibration, excitation=np.array([rotor, g * unit])),
            own=(sum(torques.own, sp.S.Zero), sp.S.Zero), felt=np.array([rotor, unit]), share=np.array([1.0, g]),
        )  # fmt: skip
        searched = _zeros(line, low, high, _BOXES[2], watch)
        if not all(zeros.complete for zeros in searched):
            return None
        speeds = np.sort(np.concatenate([zeros.points[-1] for zeros in searched]))
        every += speeds[:: 2 if twice else 1].tolist()
    return sorted(every)


def from_many_starts(
    torques: SteadyTorques, low: float, high: float, known: Sequence[State], seed: int = 0, watch: Watch = None
) -> list[State]:
    """The states that Newton's method finds, with those that are known. Other seeds give other starts."""
    problem, draw, n, states = OnTheTorus(torques), np.random.default_rng(seed), torques.size, list(known)
    for _ in range(_ROUNDS):
        if watch is not None:
            watch()
        x = draw.uniform(0, 2 * np.pi, (n - 1, _STARTS))
        if torques.given is None:
            x = np.concatenate([x, draw.uniform(low, high, (1, _STARTS))])
        speeds, phases = problem.parted(_newton(problem, x, low, high))
        for state in (State(w, at) for w, at in zip(speeds.tolist(), phases.T, strict=True)):
            if not any(same_state(torques, state, s) for s in states) and torques.balanced(state.speed, state.phases):
                states.append(state)
    return _grouped(torques, states)


def _newton(problem: OnTheTorus, x: np.ndarray, low: float, high: float) -> np.ndarray:
    t = problem.torques
    most = np.full((len(x), 1), 0.5)
    if t.given is None:
        most[-1] = 0.05 * (high - low)
    for _ in range(_STEPS):
        matrix = np.moveaxis(problem.jacobian(x), -1, 0)
        matrix = matrix + 1e-14 * np.abs(matrix).max(axis=(1, 2), keepdims=True) * np.eye(len(x))
        step = np.nan_to_num(-np.linalg.solve(matrix, problem.function(x).T[..., None])[..., 0].T)
        x = x + step / np.maximum(1.0, np.abs(step / most).max(axis=0))
        if t.given is None:
            x[-1] = np.clip(x[-1], low, high)
    scale = np.abs(problem.jacobian(x)[:, : t.size - 1]).sum(axis=1).max(axis=0)
    good = (np.abs(problem.function(x)).max(axis=0) <= _SETTLED * scale) & np.isfinite(x).all(axis=0)
    return np.asarray(x[:, good])


def same_state(torques: SteadyTorques, state: State, other: State) -> bool:
    """Whether two states are one, equal bodies being exchanged."""
    if abs(state.speed - other.speed) > _SAME * abs(state.speed):
        return False
    for members in torques.classes:
        left = other.phases[list(members)]
        for i in members:
            apart = separation(left, state.phases[i])
            if apart.min() > _SAME:
                return False
            left = np.delete(left, apart.argmin())
    return True


def multiplicity(torques: SteadyTorques, state: State) -> int:
    """How many states exchanging equal bodies makes of one."""
    many = 1
    for members in torques.classes:
        angles = state.phases[list(members)]
        near = np.unique(separation(angles[:, None], angles) < _SAME, axis=0, return_counts=True)[1]
        many *= math.factorial(len(members)) // math.prod(math.factorial(k) for k in near.tolist())
    return many


def _grouped(torques: SteadyTorques, states: Sequence[State]) -> list[State]:
    """Each state once, with the number of those that exchanging equal bodies makes of it."""
    different: list[State] = []
    for state in states:
        if any(same_state(torques, state, s) for s in different):
            continue
        ordered = state.phases % (2 * math.pi)
        for members in torques.classes:
            ordered[list(members)] = np.sort(ordered[list(members)])
        different.append(State(state.speed, ordered, 0, multiplicity(torques, state)))
    return sorted(different, key=lambda s: (s.speed, s.phases.tolist()))
