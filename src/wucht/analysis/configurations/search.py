"""Steady phase configurations that have no closed form: of several rotors, or of bodies with torques of their own.

Up to four bodies the torus of the phases, with the speed where the drive decides it, is searched completely by subdivision.
With more bodies Newton's method starts from many places: then it is not shown that no state is missing.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.analysis.configurations.closed_form import State, patterns, signed
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.configurations.torus import OnTheTorus, bounded
from wucht.numerics.subdivision import Zeros, all_zeros

MOST_BODIES = 4
_SMALLEST = 1e-6  # of the ranges: smaller boxes are along a family, or around a state at a fold
_BOXES = {2: 200_000, 3: 1_000_000, 4: 3_000_000}
_STARTS, _ROUNDS, _STEPS = 600, 8, 80
_AGAIN = 6  # times that all starts, when their indices show that a state is missing
_SAME = 1e-6  # rad, and share of the speed: two ends of Newton's method that are one state
_SETTLED = 1e-10  # of the largest torque: where Newton's method has arrived


Watch = Callable[[], None] | None  # called often; what it raises ends the search


@dataclass(frozen=True)
class Search:
    """States, whether they are all, and how that was shown or why not."""

    states: list[State]
    complete: bool
    shown: str


def search(torques: SteadyTorques, low: float, high: float, watch: Watch = None) -> Search:
    """All states, the speed between low and high where it is not given."""
    if torques.size <= MOST_BODIES:
        found = by_subdivision(torques, low, high, watch=watch)
        if found.complete:
            return found
        more = from_many_starts(torques, low, high, found.states, watch=watch)
        return Search(more, False, found.shown)
    states, rounds = from_many_starts(torques, low, high, [], watch=watch), 1
    while torques.given is not None and index(torques, states) != 0 and rounds < _AGAIN:
        states, rounds = from_many_starts(torques, low, high, states, rounds, watch), rounds + 1
    shown = f"Newton's method from {_STARTS * _ROUNDS * rounds} starts: it is not shown that no state is missing"
    if torques.given is not None:
        total = index(torques, states)
        must = ", but their indices add up to 0, as they must"
        shown += must if total == 0 else f"; their indices add up to {total} and not to 0: at least one is missing"
    return Search(states, False, shown)


def index(torques: SteadyTorques, states: Sequence[State]) -> int:
    """The sum of the signs of det(df/dx): 0 if these are all states at a given speed (Poincare and Hopf, on the torus)."""
    if not states:
        return 0
    phases = np.array([s.phases[1:] for s in states]).T
    matrices = np.moveaxis(OnTheTorus(torques).jacobian(phases), -1, 0)
    return int(sum(s.multiplicity * np.sign(np.linalg.det(m)) for s, m in zip(states, matrices, strict=True)))


def by_subdivision(
    torques: SteadyTorques, low: float, high: float, most_boxes: int | None = None, watch: Watch = None
) -> Search:
    """The same by subdivision alone, for up to four bodies. most_boxes: that are looked at, by default up to millions."""
    if not bounded(torques):
        return Search([], False, "a drive or load has a characteristic that jumps: it is not shown that no state is missing")
    searched = _zeros(torques, low, high, most_boxes or _BOXES[torques.size], watch)
    speeds, phases = OnTheTorus(torques).parted(np.concatenate([zeros.points for zeros in searched], axis=1))
    states = _grouped(torques, [(float(w), phases[:, k]) for k, w in enumerate(speeds)])
    what = "the phases" if torques.given is not None else f"the phases and {speeds_said(torques, low, high)}"
    boxes = sum(zeros.boxes for zeros in searched)
    if all(zeros.complete for zeros in searched):
        return Search(states, True, f"{what} were searched by subdivision, {boxes} boxes, with bounds on the Jacobian")
    left = sum(zeros.undecided[0].shape[1] for zeros in searched)
    return Search(states, False, f"{what} were searched by subdivision, but {left} of {boxes} boxes were not decided")


def _zeros(torques: SteadyTorques, low: float, high: float, most_boxes: int, watch: Watch) -> list[Zeros]:
    """The states of each part of the range of speeds, or of the speed that is given."""
    problem, n = OnTheTorus(torques), torques.size
    bottom, top, around = [0.0] * (n - 1), [2 * math.pi] * (n - 1), [True] * (n - 1)
    parts: list[tuple[list[float], list[float]]] = [([], [])]
    if torques.given is None:
        parts, around = [([a], [b]) for a, b in torques.parts(low, high)], [*around, False]
    return [
        all_zeros(
            problem.function, problem.jacobian, problem.spread, bottom + a, top + b, periodic=around, smallest=_SMALLEST,
            most_boxes=most_boxes, watch=watch,
        )
        for a, b in parts
    ]  # fmt: skip


def speeds_said(torques: SteadyTorques, low: float, high: float) -> str:
    """The speeds that are searched, in words."""
    said = f"speeds from {low:.4g} to {high:.4g} {torques.unit}".rstrip()
    poles = ", ".join(f"{at:.5g}" for at in torques.poles(low, high))
    return f"{said} (but for {poles}, where the undamped vibration is infinite)" if poles else said


def speeds_in_line(torques: SteadyTorques, low: float, high: float, watch: Watch = None) -> list[tuple[float, ...]] | None:
    """The speeds of all states of each of ``patterns``, by subdivision over the speed and the angle of the line.

    The bodies in line are taken for one that excites with their sum and feels like the first. None where something stays
    undecided.
    """
    v, found = torques.vibration, []
    if not bounded(torques):
        return None
    for side, _, twice in patterns(torques):
        unit = v.excitation[1] / np.abs(torques.coefficients[1])  # type: ignore[index]
        line = replace(
            torques, names=(*torques.names[:1], "line"), heads=(0, 0), senses=torques.senses[:2],
            inertia=torques.inertia[:2, :2],
            vibration=replace(v, excitation=np.array([v.excitation[0], signed(torques, side) * unit])),
            relative=torques.relative[:2, :2], own=(sum(torques.own, sp.S.Zero), sp.S.Zero),
            pickup=np.array([v.excitation[0], unit]), weights=np.array([1.0, signed(torques, side)]),
        )  # fmt: skip
        searched = _zeros(line, low, high, _BOXES[2], watch)
        if not all(zeros.complete for zeros in searched):
            return None
        speeds = np.sort(np.concatenate([zeros.points[-1] for zeros in searched]))
        found.append(tuple(speeds[::2].tolist() if twice else speeds.tolist()))
    return found


def from_many_starts(
    torques: SteadyTorques, low: float, high: float, known: Sequence[State], seed: int = 0, watch: Watch = None
) -> list[State]:
    """The states that Newton's method finds, with those that are known. Other seeds give other starts."""
    problem, draw, n = OnTheTorus(torques), np.random.default_rng(seed), torques.size
    found = [(s.speed, s.phases) for s in known]
    for _ in range(_ROUNDS):
        if watch is not None:
            watch()
        x = draw.uniform(0, 2 * np.pi, (n - 1, _STARTS))
        if torques.given is None:
            x = np.concatenate([x, draw.uniform(low, high, (1, _STARTS))])
        arrived = _newton(problem, x, low, high)
        speeds, phases = problem.parted(arrived)
        for k, w in enumerate(speeds):
            new = not any(_same(torques, (float(w), phases[:, k]), other) for other in found)
            if new and torques.balanced(float(w), phases[:, k]):
                found.append((float(w), phases[:, k]))
    return _grouped(torques, found)


def _newton(problem: OnTheTorus, x: np.ndarray, low: float, high: float) -> np.ndarray:
    t = problem.torques
    most = np.full((len(x), 1), 0.5)
    if t.given is None:
        most[-1] = 0.05 * (high - low)
    for _ in range(_STEPS):
        matrix = np.moveaxis(problem.jacobian(x), -1, 0)
        matrix = matrix + 1e-14 * np.abs(matrix).max(axis=(1, 2), keepdims=True) * np.eye(len(x))
        step = -np.linalg.solve(matrix, problem.function(x).T[..., None])[..., 0].T
        step = np.nan_to_num(step)
        x = x + step / np.maximum(1.0, np.abs(step / most).max(axis=0))
        if t.given is None:
            x[-1] = np.clip(x[-1], low, high)
    scale = np.abs(problem.jacobian(x)[:, : t.size - 1]).sum(axis=1).max(axis=0)
    good = (np.abs(problem.function(x)).max(axis=0) <= _SETTLED * scale) & np.isfinite(x).all(axis=0)
    found: np.ndarray = x[:, good]
    return found


def _same(torques: SteadyTorques, one: tuple[float, np.ndarray], other: tuple[float, np.ndarray]) -> bool:
    """Whether two states are one, equal bodies being exchanged."""
    if abs(one[0] - other[0]) > _SAME * abs(one[0]):
        return False
    for members in torques.classes:
        left = [other[1][i] for i in members]
        for i in members:
            apart = [abs((one[1][i] - b + math.pi) % (2 * math.pi) - math.pi) for b in left]
            best = int(np.argmin(apart))
            if apart[best] > _SAME:
                return False
            left.pop(best)
    return True


def _grouped(torques: SteadyTorques, found: Sequence[tuple[float, np.ndarray]]) -> list[State]:
    kept: list[State] = []
    for w, phases in found:
        if any(_same(torques, (w, phases), (s.speed, s.phases)) for s in kept):
            continue
        ordered = phases % (2 * math.pi)
        for members in torques.classes:
            ordered[list(members)] = np.sort(ordered[list(members)])
        kept.append(State(w, ordered, 0, _arrangements(torques, ordered)))
    return sorted(kept, key=lambda s: (s.speed, s.phases.tolist()))


def _arrangements(torques: SteadyTorques, phases: np.ndarray) -> int:
    """How many states exchanging equal bodies makes of one."""
    found = 1
    for members in torques.classes:
        here = phases[list(members)]
        together: list[list[float]] = []
        for angle in here:
            near = next((g for g in together if abs((angle - g[0] + math.pi) % (2 * math.pi) - math.pi) < _SAME), None)
            if near is None:
                together.append([angle])
            else:
                near.append(angle)
        found *= math.factorial(len(members)) // math.prod(math.factorial(len(g)) for g in together)
    return found
