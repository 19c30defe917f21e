"""Constant phases that have no closed form: of several rotors, or of bodies with torques of their own.

Up to four bodies the torus of the phases, with the speed where the drive decides it, is searched completely by subdivision; the
bounds on the Jacobian follow from those of the harmonic influence coefficients over an interval of speeds (a Neumann series).
With more bodies Newton's method starts from many places: then it is not shown that no state is missing.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.errors import WuchtError
from wucht.machines.synchronous.closed import State, patterns, signed
from wucht.machines.synchronous.torques import SPEED, SteadyTorques
from wucht.numerics.intervals import enclosure
from wucht.numerics.subdivision import all_zeros
from wucht.piecewise import PiecewiseCubic

MOST_BODIES = 4
_SMALLEST = 1e-5  # of the ranges: smaller boxes are along a family, or around a state at a fold
_BOXES = {2: 200_000, 3: 1_000_000, 4: 3_000_000}
_STARTS, _ROUNDS, _STEPS = 600, 8, 80
_AGAIN = 6  # times that all starts, when their indices show that a state is missing
_SAME = 1e-6  # rad, and share of the speed: two ends of Newton's method that are one state
_SETTLED = 1e-10  # of the largest torque: where Newton's method has arrived


@dataclass(frozen=True)
class Search:
    """States, whether they are all, and how that was shown or why not."""

    states: list[State]
    complete: bool
    shown: str


@dataclass(frozen=True)
class OnTheTorus:
    """The torque balance as f(x) = 0, x = (alpha_1, ..., alpha_n-1), and the speed if it is not given: k unknowns."""

    torques: SteadyTorques

    def parted(self, x: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """Speeds (N,) and phases (n, N)."""
        n = self.torques.size
        phases = np.concatenate([np.zeros((1, x.shape[1])), x[: n - 1]])
        given = self.torques.given
        return (x[-1] if given is None else np.full(x.shape[1], given)), phases

    def function(self, x: np.ndarray) -> np.ndarray:
        """f (k, N)."""
        found: np.ndarray = self.torques.residual(*self.parted(x))[list(self.torques.free)]
        return found

    def jacobian(self, x: np.ndarray) -> np.ndarray:
        """df/dx (k, k, N)."""
        t, free = self.torques, list(self.torques.free)
        speeds, phases = self.parted(x)
        change, rate = t.slopes(speeds, phases)
        found: np.ndarray = change[free][:, 1:]
        if t.given is None:
            found = np.concatenate([found, (rate + t.alone(speeds)[1])[free][:, None]], axis=1)
        return found

    def spread(self, centre: np.ndarray, radius: np.ndarray) -> np.ndarray:
        """How much df/dx differs from that at the centre of a box, at most (k, k, N)."""
        t, free, n = self.torques, list(self.torques.free), self.torques.size
        speeds, phases = self.parted(centre)
        reach = np.concatenate([np.zeros((1, radius.shape[1])), radius[: n - 1]])
        apart, turn = phases[:, None] - phases[None], reach[:, None] + reach[None]
        wide = radius[-1] if t.given is None else np.zeros(centre.shape[1])
        influence, rate = (np.moveaxis(v, 0, -1) for v in t.influence(speeds))
        here, now = speeds**4 / 2 * influence, 2 * speeds**3 * influence + speeds**4 / 2 * rate
        slope, curve, own = (np.moveaxis(v, 0, -1) for v in self._bounds(speeds, wide))
        cosine = np.minimum(2.0, np.abs(np.sin(apart - np.angle(here))) * turn + turn**2 / 2)
        by_phase = np.abs(here) * cosine + slope * wide
        index = np.arange(n)
        by_phase[index, index] = 0.0
        by_phase[index, index] = by_phase.sum(axis=1)
        found: np.ndarray = by_phase[free][:, 1:]
        if t.given is None:
            by_speed = (np.abs(now) * np.minimum(2.0, turn) + curve * wide).sum(axis=1) + own
            found = np.concatenate([found, by_speed[free][:, None]], axis=1)
        return found

    def _bounds(self, speeds: np.ndarray, wide: np.ndarray) -> tuple[np.ndarray, ...]:
        """Bounds on |b'| and |b''| of b = w^4 a/2 (N, n, n), and on what tau' differs by (N, n), over intervals of speeds."""
        if not wide.any():
            none = np.zeros((len(speeds), self.torques.size, self.torques.size))
            return none, none, none[:, 0]
        pairs, where = np.unique(np.array([speeds, wide]), axis=1, return_inverse=True)
        found = _bounds_over(self.torques, pairs[0], pairs[1])
        return tuple(v[where.ravel()] for v in found)


def _bounds_over(t: SteadyTorques, w: np.ndarray, r: np.ndarray) -> tuple[np.ndarray, ...]:
    v, high = t.vibration, (w + r)[:, None, None]
    left, right = np.abs(t.felt), np.abs(v.excitation).T
    mass, damping = np.abs(v.mass), np.abs(v.damping)
    centre = np.linalg.inv(v.dynamic(w[:, None, None]))
    response = np.abs(centre)
    moved = (2 * w * r + r**2)[:, None, None] * mass + r[:, None, None] * damping
    ratio = moved @ response
    converges = np.abs(np.linalg.eigvals(ratio)).max(axis=-1, initial=0.0) < 0.95
    safe = np.where(converges[:, None, None], ratio, 0.0)
    bound = response @ np.linalg.inv(np.eye(len(v.mass)) - safe)
    first = bound @ (2 * high * mass + damping) @ bound
    second = 2 * first @ (2 * high * mass + damping) @ bound + bound @ (2 * mass) @ bound
    a, da, dda = (left @ x @ right for x in (bound, first, second))
    exact, slope = (np.abs(x) for x in t.influence(w))  # at the centre, where bodies' excitations may cancel
    da = np.minimum(da, slope + dda * r[:, None, None])
    a = np.minimum(a, exact + da * r[:, None, None])
    found = [2 * high**3 * a + high**4 / 2 * da, 6 * high**2 * a + 4 * high**3 * da + high**4 / 2 * dda]
    for x in found:
        x[~converges] = np.inf
    return (*found, _apart(t, w, r))


def bounded(torques: SteadyTorques) -> bool:
    """Whether bounds are known of the torques' slopes, where the speed is searched: not where a characteristic jumps."""
    at, nothing = np.ones(1), np.zeros(1)
    return torques.given is not None or bool(np.isfinite(_apart(torques, at, nothing)).all())


def _apart(t: SteadyTorques, w: np.ndarray, r: np.ndarray) -> np.ndarray:
    """How much the slopes of the torques tau on [w - r, w + r] differ from those at w, at most (N, n).

    At a kink both slopes count: a zero is unique if every matrix of slopes between them is regular (F. H. Clarke, Optimization
    and Nonsmooth Analysis, 1983, sections 2.6, 7.1).
    """
    found, slopes = np.zeros((len(w), t.size)), t.alone(w)[1]
    for i, torque in enumerate(t.own):
        slope, curvature = _derivatives(torque)
        if slope is None:
            found[:, i] = np.inf
        elif curvature is None:
            below, above = _enclosure(slope, w - r, w + r)
            found[:, i] = np.maximum(above - slopes[i], slopes[i] - below)
        else:
            below, above = _enclosure(curvature, w - r, w + r)
            found[:, i] = np.where(r > 0, np.maximum(np.abs(below), np.abs(above)) * r, 0.0)
    return found


@lru_cache(maxsize=64)
def _derivatives(torque: sp.Expr) -> tuple[sp.Expr | None, sp.Expr | None]:
    """The first and second derivative of a torque by ``SPEED``; None where it jumps, or has a kink."""
    pieces = [f.args[1] for f in torque.atoms(PiecewiseCubic)]
    if any(p.jumps() for p in pieces):
        return None, None
    slope = sp.diff(torque, SPEED)
    kinked = any(p.derivative.jumps() for p in pieces)
    return sp.together(slope), None if kinked else sp.together(sp.diff(slope, SPEED))


def _enclosure(expression: sp.Expr, low: np.ndarray, high: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    try:
        return enclosure(expression, SPEED, low, high)
    except WuchtError:
        return np.full_like(low, -np.inf), np.full_like(low, np.inf)


def search(torques: SteadyTorques, low: float, high: float) -> Search:
    """All states, the speed between low and high where it is not given."""
    if torques.size <= MOST_BODIES:
        found = by_subdivision(torques, low, high)
        if found.complete:
            return found
        more = from_many_starts(torques, low, high, found.states)
        return Search(more, False, found.shown)
    states, rounds = from_many_starts(torques, low, high, []), 1
    while torques.given is not None and index(torques, states) != 0 and rounds < _AGAIN:
        states, rounds = from_many_starts(torques, low, high, states, rounds), rounds + 1
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


def by_subdivision(torques: SteadyTorques, low: float, high: float, most_boxes: int | None = None) -> Search:
    """The same by subdivision alone, for up to four bodies. most_boxes: that are looked at, by default up to millions."""
    if not bounded(torques):
        return Search([], False, "a drive or load has a characteristic that jumps: it is not shown that no state is missing")
    problem, n = OnTheTorus(torques), torques.size
    bottom, top, around = [0.0] * (n - 1), [2 * math.pi] * (n - 1), [True] * (n - 1)
    if torques.given is None:
        bottom, top, around = [*bottom, low], [*top, high], [*around, False]
    zeros = all_zeros(
        problem.function, problem.jacobian, problem.spread, bottom, top, periodic=around, smallest=_SMALLEST,
        most_boxes=most_boxes or _BOXES[n],
    )  # fmt: skip
    speeds, phases = problem.parted(zeros.points)
    states = _grouped(torques, [(float(w), phases[:, k]) for k, w in enumerate(speeds)])
    what = "the phases" if torques.given is not None else f"the phases and speeds from {low:.4g} to {high:.4g}"
    if zeros.complete:
        return Search(states, True, f"{what} were searched by subdivision, {zeros.boxes} boxes, with bounds on the Jacobian")
    left = zeros.undecided[0].shape[1]
    return Search(states, False, f"{what} were searched by subdivision, but {left} of {zeros.boxes} boxes were not decided")


def speeds_in_line(torques: SteadyTorques, low: float, high: float) -> list[tuple[float, ...]] | None:
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
            pickup=np.array([v.excitation[0], unit]),
        )  # fmt: skip
        problem = OnTheTorus(line)
        zeros = all_zeros(
            problem.function, problem.jacobian, problem.spread, [0.0, low], [2 * math.pi, high], periodic=[True, False],
            smallest=_SMALLEST, most_boxes=_BOXES[2],
        )  # fmt: skip
        if not zeros.complete:
            return None
        speeds = np.sort(zeros.points[-1])
        found.append(tuple(speeds[::2].tolist() if twice else speeds.tolist()))
    return found


def from_many_starts(torques: SteadyTorques, low: float, high: float, known: Sequence[State], seed: int = 0) -> list[State]:
    """The states that Newton's method finds, with those that are known. Other seeds give other starts."""
    problem, draw, n = OnTheTorus(torques), np.random.default_rng(seed), torques.size
    found = [(s.speed, s.phases) for s in known]
    for _ in range(_ROUNDS):
        x = draw.uniform(0, 2 * np.pi, (n - 1, _STARTS))
        if torques.given is None:
            x = np.concatenate([x, draw.uniform(low, high, (1, _STARTS))])
        arrived = _newton(problem, x, low, high)
        speeds, phases = problem.parted(arrived)
        for k, w in enumerate(speeds):
            if not any(_same(torques, (float(w), phases[:, k]), other) for other in found):
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
