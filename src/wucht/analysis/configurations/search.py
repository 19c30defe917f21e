"""All steady phase configurations of a machine, in closed form or by a search, with the evidence that they are all.

There is no closed form for several rotors and for bodies with shaft torques. Up to four bodies the torus of the phases, with
the speed where the drive decides it, is searched completely by subdivision. With more, Newton's method starts from many
places: then completeness is not proved.
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
from wucht.analysis.configurations.torus import TorusProblem, has_slope_bounds
from wucht.analysis.vibration import ForcedVibration
from wucht.analysis.working_points import TorqueCurves
from wucht.numerics.subdivision import Zeros, all_zeros

_MOST_PROVED = 4  # bodies, of whose states completeness is proved by subdivision
_FEW_BODIES = 3  # whose states are searched by subdivision within seconds
_SMALLEST = 1e-6  # of the ranges: smaller boxes are along a family, or around a state at a fold
_BOXES = {1: 200_000, 2: 200_000, 3: 1_000_000, 4: 3_000_000}
_STARTS, _ROUNDS, _STEPS = 600, 8, 80
_AGAIN = 6  # rounds of all starts, when their indices show that a state is missing
_SAME = 1e-6  # rad, and share of the speed: two ends of Newton's method that are one state
_LEAST_STEP = 1e-13  # step of Newton's method, of the longest one allowed: what follows is rounding
_CONVERGENCE = 1e-10  # of the largest torque: where Newton's method has arrived
_PATTERNS = 64  # ways to be in line for which completeness of the speeds is proved
_EQUAL_SPEEDS = 1e-6  # relative
_POINTS = 1200  # of the grid of speeds
_PROBES = 50  # speeds at which bodies must be without shaft torques

CancelCheck = Callable[[], None] | None  # called often; an exception from it ends the search


@dataclass(frozen=True)
class StateSearch:
    """States, completeness, and the evidence for it or the reason why it is not proved."""

    states: list[State]
    complete: bool
    evidence: str


def all_states(torques: SteadyTorques, low: float, high: float, watch: CancelCheck = None, prove: bool = True) -> StateSearch:
    """All states, each verified; the speed between low and high, in the main rotor's sense, where it is not fixed.

    watch: called often; an exception from it ends the search. prove: try to prove that closed forms miss no speed, and that
    four bodies have no other states.
    """
    if not has_closed_form(torques, low, high):
        result = search(torques, low, high, watch, prove)
    elif torques.fixed_speed is not None:
        states = closed_form.fixed_speed_states(torques, torques.fixed_speed)
        result = StateSearch(states, True, "closed form: there are no other steady phases")
    else:
        result = _free_speed_states(torques, low, high, watch, prove)
    verified_states = [s for s in result.states if torques.is_balanced(s.speed, s.phases)]
    if rejected_count := len(result.states) - len(verified_states):
        return StateSearch(
            verified_states, False, f"{result.evidence}; {rejected_count} more do not satisfy the torque balance"
        )
    return result


def has_closed_form(torques: SteadyTorques, low: float, high: float) -> bool:
    """True if the phases are known in closed form at these speeds.

    Raises ``InputError`` where a body has no unbalance, so that nothing fixes its phase.
    """
    at = np.array([torques.fixed_speed]) if torques.fixed_speed is not None else np.linspace(low, high, _PROBES)
    is_solvable = torques.size == 2 or (torques.size > 2 and torques.coefficients is not None and torques.has_idle_bodies(at))
    if is_solvable:
        closed_form.branches(torques, at)
    return is_solvable


def _free_speed_states(torques: SteadyTorques, low: float, high: float, watch: CancelCheck, prove: bool) -> StateSearch:
    """States in closed form over the speed; the speeds are compared with those from subdivision."""
    machine, sense = torques.machine, float(torques.senses[0])
    ends = (min(sense * low, sense * high), max(sense * low, sense * high))
    curves = TorqueCurves(machine, machine.rotor, ForcedVibration.of(machine, np.zeros(torques.size)), ends, _POINTS)
    grid, states = np.sort(sense * curves.grid), list[State]()  # speeds that resolve resonances and the drive's characteristic
    for a, b in torques.speed_intervals(low, high):
        states += closed_form.free_speed_states(torques, np.unique([a, *grid[(grid > a) & (grid < b)], b]))
    line_speeds = sorted(s.speed for s in states if s.sides or torques.size == 2)
    speeds, proved_speeds = speeds_in_words(torques, low, high), _proved_speeds(torques, low, high, watch) if prove else None
    if (
        proved_speeds is None
        or len(proved_speeds) != len(line_speeds)
        or not np.allclose(proved_speeds, line_speeds, rtol=_EQUAL_SPEEDS)
    ):
        return StateSearch(states, False, f"phases in closed form; {speeds} on a grid: completeness is not proved")
    return StateSearch(states, True, f"phases in closed form; {speeds} by subdivision with bounds on the Jacobian")


def _proved_speeds(torques: SteadyTorques, low: float, high: float, watch: CancelCheck) -> list[float] | None:
    """The speeds of all states in line, by subdivision; None where completeness is not proved."""
    if torques.size == 2:
        result = search_by_subdivision(torques, low, high, watch=watch)
        return sorted(s.speed for s in result.states) if result.complete else None
    provable = torques.classes and closed_form.pattern_count(torques) <= _PATTERNS
    return speeds_in_line(torques, low, high, watch) if provable else None


def search(torques: SteadyTorques, low: float, high: float, watch: CancelCheck = None, prove: bool = True) -> StateSearch:
    """All states, the speed between low and high where it is not fixed. prove: by subdivision, also of four bodies."""
    if torques.size <= (_MOST_PROVED if prove else _FEW_BODIES):
        result = search_by_subdivision(torques, low, high, watch=watch)
        if result.complete:
            return result
        if torques.size == 1:
            return StateSearch(_working_points(torques, low, high), False, result.evidence)
        return StateSearch(search_from_many_starts(torques, low, high, result.states, watch=watch), False, result.evidence)
    states, has_fixed_speed = list[State](), torques.fixed_speed is not None
    for rounds in range(1, _AGAIN + 1):
        states = search_from_many_starts(torques, low, high, states, rounds - 1, watch)
        total = index(torques, states) if has_fixed_speed else 0
        if not total:
            break
    evidence = f"Newton's method from {_STARTS * _ROUNDS * rounds} starts: completeness is not proved"
    if has_fixed_speed and total:
        evidence += f"; their indices add up to {total} and not to 0: at least one is missing"
    elif has_fixed_speed:
        evidence += ", but their indices add up to 0, as they must"
    return StateSearch(states, False, evidence)


def _working_points(torques: SteadyTorques, low: float, high: float) -> list[State]:
    """The steady speeds of a single rotor on a grid."""
    machine, sense = torques.machine, float(torques.senses[0])
    ends = (min(sense * low, sense * high), max(sense * low, sense * high))
    curves = TorqueCurves(machine, machine.rotor, ForcedVibration.of(machine, np.zeros(1)), ends, _POINTS)
    return [State(w, np.zeros(1)) for w in sorted(sense * p.speed for p in curves.working_points) if low <= w <= high]


def index(torques: SteadyTorques, states: Sequence[State]) -> int:
    """The sum of the signs of det(df/dx): 0 if these are all states at a given speed (Poincare and Hopf, on the torus)."""
    if not states:
        return 0
    matrices = np.moveaxis(TorusProblem(torques).jacobian(np.array([s.phases[1:] for s in states]).T), -1, 0)
    return int(sum(s.multiplicity * np.sign(np.linalg.det(m)) for s, m in zip(states, matrices, strict=True)))


def search_by_subdivision(
    torques: SteadyTorques, low: float, high: float, most_boxes: int | None = None, watch: CancelCheck = None
) -> StateSearch:
    """All states by subdivision alone, for up to four bodies. most_boxes: limit of their number, millions by default."""
    if not has_slope_bounds(torques):
        return StateSearch([], False, "a drive or load has a characteristic that jumps: completeness is not proved")
    zero_sets = _zeros(torques, low, high, most_boxes or _BOXES[torques.size], watch)
    speeds, phases = TorusProblem(torques).speeds_and_phases(np.concatenate([zeros.points for zeros in zero_sets], axis=1))
    states = _distinct_states(torques, [State(w, at) for w, at in zip(speeds.tolist(), phases.T, strict=True)])
    subject = "the phases" if torques.fixed_speed is not None else f"the phases and {speeds_in_words(torques, low, high)}"
    boxes = sum(zeros.boxes for zeros in zero_sets)
    if all(zeros.complete for zeros in zero_sets):
        return StateSearch(states, True, f"{subject} were searched by subdivision, {boxes} boxes, with bounds on the Jacobian")
    undecided_count = sum(zeros.undecided_boxes[0].shape[1] for zeros in zero_sets)
    return StateSearch(
        states, False, f"{subject} were searched by subdivision, but {undecided_count} of {boxes} boxes remain undecided"
    )


def _zeros(torques: SteadyTorques, low: float, high: float, most_boxes: int, watch: CancelCheck) -> list[Zeros]:
    """The states of each part of the range of speeds, or of the fixed speed."""
    problem, n = TorusProblem(torques), torques.size
    speeds = [([a], [b]) for a, b in torques.speed_intervals(low, high)] if torques.fixed_speed is None else [([], [])]
    return [
        all_zeros(
            problem.function, problem.jacobian, problem.spread, [0.0] * (n - 1) + a, [2 * math.pi] * (n - 1) + b,
            periodic=[True] * (n - 1) + [False] * len(a), smallest=_SMALLEST, most_boxes=most_boxes, check=watch,
        )
        for a, b in speeds
    ]  # fmt: skip


def speeds_in_words(torques: SteadyTorques, low: float, high: float) -> str:
    """The range of speeds searched, as text."""
    speed_range = f"speeds from {low:.4g} to {high:.4g} {torques.machine.units.speed}".rstrip()
    poles = ", ".join(f"{at:.5g}" for at in torques.poles(low, high))
    return f"{speed_range} (except {poles}, where the undamped vibration is infinite)" if poles else speed_range


def speeds_in_line(torques: SteadyTorques, low: float, high: float, watch: CancelCheck = None) -> list[float] | None:
    """The speeds of all states of each of ``patterns``, by subdivision over the speed and the angle of the line.

    The bodies in line are replaced by one that excites with their sum and responds like the first. None where something
    remains undecided.
    """
    if not has_slope_bounds(torques):
        return None
    rotor, unit = torques.vibration.excitation[0], torques.vibration.excitation[1] / np.abs(torques.coefficients[1])  # type: ignore[index]
    every: list[float] = []
    for _, g, _, twice in closed_form.patterns(torques):
        line = replace(
            torques, names=(*torques.names[:1], "line"), heads=(0, 0), senses=torques.senses[:2],
            inertia=torques.inertia[:2, :2], relative=torques.relative[:2, :2],
            vibration=replace(torques.vibration, excitation=np.array([rotor, g * unit])),
            shaft_torques=(sum(torques.shaft_torques, sp.S.Zero), sp.S.Zero), reaction_shapes=np.array([rotor, unit]),
            share=np.array([1.0, g]),
        )  # fmt: skip
        zero_sets = _zeros(line, low, high, _BOXES[2], watch)
        if not all(zeros.complete for zeros in zero_sets):
            return None
        speeds = np.sort(np.concatenate([zeros.points[-1] for zeros in zero_sets]))
        every += speeds[:: 2 if twice else 1].tolist()
    return sorted(every)


def search_from_many_starts(
    torques: SteadyTorques, low: float, high: float, known_states: Sequence[State], seed: int = 0, watch: CancelCheck = None
) -> list[State]:
    """The known states and those to which Newton's method converges. Other seeds give other starts."""
    problem, draw, n, states = TorusProblem(torques), np.random.default_rng(seed), torques.size, list(known_states)
    for _ in range(_ROUNDS):
        if watch is not None:
            watch()
        x = draw.uniform(0, 2 * np.pi, (n - 1, _STARTS))
        if torques.fixed_speed is None:
            x = np.concatenate([x, draw.uniform(low, high, (1, _STARTS))])
        speeds, phases = problem.speeds_and_phases(_newton(problem, x, low, high))
        for state in (State(w, at) for w, at in zip(speeds.tolist(), phases.T, strict=True)):
            if not any(is_same_state(torques, state, s) for s in states) and torques.is_balanced(state.speed, state.phases):
                states.append(state)
    return _distinct_states(torques, states)


def _newton(problem: TorusProblem, starts: np.ndarray, low: float, high: float) -> np.ndarray:
    t, x = problem.torques, starts.copy()
    most = np.full((len(x), 1), 0.5)
    if t.fixed_speed is None:
        most[-1] = 0.05 * (high - low)
    moving = np.arange(x.shape[1])
    for _ in range(_STEPS):
        at = x[:, moving]
        matrix = np.moveaxis(problem.jacobian(at), -1, 0)
        matrix = matrix + 1e-14 * np.abs(matrix).max(axis=(1, 2), keepdims=True) * np.eye(len(x))
        step = np.nan_to_num(-np.linalg.solve(matrix, problem.function(at).T[..., None])[..., 0].T)
        at = at + step / np.maximum(1.0, np.abs(step / most).max(axis=0))
        if t.fixed_speed is None:
            at[-1] = np.clip(at[-1], low, high)
        x[:, moving] = at
        moving = moving[(np.abs(step) > _LEAST_STEP * most).any(axis=0)]
        if not len(moving):
            break
    scale = np.abs(problem.jacobian(x)[:, : t.size - 1]).sum(axis=1).max(axis=0)
    good = (np.abs(problem.function(x)).max(axis=0) <= _CONVERGENCE * scale) & np.isfinite(x).all(axis=0)
    return np.asarray(x[:, good])


def is_same_state(torques: SteadyTorques, state: State, second: State) -> bool:
    """True if two states are the same, equal bodies being exchanged."""
    if abs(state.speed - second.speed) > _SAME * abs(state.speed):
        return False
    for members in torques.classes:
        remaining_phases = second.phases[list(members)]
        for i in members:
            apart = separation(remaining_phases, state.phases[i])
            if apart.min() > _SAME:
                return False
            remaining_phases = np.delete(remaining_phases, apart.argmin())
    return True


def multiplicity(torques: SteadyTorques, state: State) -> int:
    """Number of states that exchanging equal bodies makes of one."""
    many = 1
    for members in torques.classes:
        angles = state.phases[list(members)]
        near = np.unique(separation(angles[:, None], angles) < _SAME, axis=0, return_counts=True)[1]
        many *= math.factorial(len(members)) // math.prod(math.factorial(k) for k in near.tolist())
    return many


def _distinct_states(torques: SteadyTorques, states: Sequence[State]) -> list[State]:
    """Distinct states, each with the number of those that exchanging equal bodies makes of it."""
    distinct: list[State] = []
    for state in states:
        if any(is_same_state(torques, state, s) for s in distinct):
            continue
        phases = state.phases % (2 * math.pi)
        for members in torques.classes:
            phases[list(members)] = np.sort(phases[list(members)])
        distinct.append(State(state.speed, phases, 0, multiplicity(torques, state)))
    return sorted(distinct, key=lambda s: (s.speed, s.phases.tolist()))
