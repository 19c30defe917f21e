"""Steady phase configurations in closed form: all balancing bodies of one rotor, and any two bodies.

Bodies that excite the carrier alike (E_i = c_i e, f_i = |c_i|) and have no shaft torques are steady where Im[exp(i alpha_i)
conj(a S)] = 0 with a = e^H H e = |a| exp(i eta) and S = sum f_k exp(i alpha_k): either S = 0 (the unbalances compensate each
other), or each one is at beta or opposite, S = f_0 + g exp(i beta), g = sum +-f_i, and

    sin(beta - eta) = (g/f_0) sin(eta):

two beta for each choice of signs, where there are any. No other phases are steady, for any number of bodies. Without damping
(eta = 0 or pi) this is 000 (43)-(48) and 001, table 1; for two equal bodies 002 (5.5)-(5.15). Two bodies of which the second
has a shaft torque tau_1 have one phase, and |a_10| sin(alpha - arg a_10) = 2 tau_1/w^4 + Im a_11: 001 (35).

The force polygon closes, 000 (36)-(44): two bodies close a triangle with the rotor's unbalance; n bodies have n - 2
parameters left.
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import InputError
from wucht.numerics.zeros_and_peaks import RealFunction, crossings, first_where

EVEN = 1e-9  # relative: if the longest side equals all others together, there is no polygon
_REPELLING = 200  # steps in which bodies of a family move apart
_CLOSE = np.geomspace(1e-13, 0.3, 60)  # of a range of speeds: distances of samples from its ends
_ZOOM, _LEVELS = 41, 8  # points and number of refinements at an extremum near zero
_PAST_THE_BREAKPOINT = 1e-6  # of a speed
_BESIDE = 1e-9  # of a speed: distance of neighbours that tell an isolated zero


def compensating_phases(torques: SteadyTorques, spread: bool = True) -> list[tuple[np.ndarray, int, int]]:
    """Phases (n,) at which the unbalances compensate, S = 0: with the dimension of their family and their multiplicity.

    Two bodies: 000 (42)-(44), both triangles (one, if the bodies are equal). More: one member of the family. None where the
    polygon of the forces does not close, 000 (41). spread: choose a member with the bodies far apart.
    """
    c = torques.coefficients
    if c is None or torques.size < 3:
        return []
    sizes, angles = np.abs(c), np.angle(c)
    is_balanced = sizes[0] <= EVEN * sizes.max()
    rest = sizes.sum() - 2 * sizes.max()
    if rest <= EVEN * sizes.sum() and not (is_balanced and torques.size == 3 and abs(sizes[1] - sizes[2]) <= EVEN * sizes[1]):
        return []
    if is_balanced or torques.size > 3:
        at = _closed_polygon(sizes, _REPELLING if spread else 0) if torques.size > 3 else np.array([0.0, 0.0, np.pi])
        return [((at - angles) % (2 * np.pi), torques.size - 3 + (1 if is_balanced else 0), 1)]
    f0, f1, f2 = sizes
    first = math.acos(np.clip((f0**2 + f1**2 - f2**2) / (2 * f0 * f1), -1, 1))
    second = math.acos(np.clip((f0**2 - f1**2 + f2**2) / (2 * f0 * f2), -1, 1))
    mirror_pair = [np.array([0.0, np.pi - s * first, np.pi + s * second]) for s in (1, -1)]
    equal = len(torques.classes) == 1
    return [((at - angles) % (2 * np.pi), 0, 2 if equal else 1) for at in (mirror_pair[:1] if equal else mirror_pair)]


def _closed_polygon(sizes: np.ndarray, steps: int) -> np.ndarray:
    """Angles (n,) at which the sides close, the bodies apart from each other as far as they can be.

    From evenly spread ones; bodies repel each other along the family.
    """
    n = len(sizes)
    start = np.concatenate([[0.0], 2 * np.pi * (np.arange(n - 1) + 0.5) / (n - 1)])
    draw = np.random.default_rng(1)
    while (polygon := _close_polygon(sizes, start)) is None:
        start = np.concatenate([[0.0], draw.uniform(0, 2 * np.pi, n - 1)])
    at, rate = polygon, 0.1
    for _ in range(steps):
        apart = at[1:, None] - at[None, 1:]
        with np.errstate(divide="ignore", invalid="ignore"):
            push = np.nan_to_num(np.sin(apart) / (1 - np.cos(apart)) ** 2, posinf=0.0, neginf=0.0).sum(axis=1)
        sides = 1j * sizes[1:] * np.exp(1j * at[1:])
        normal = np.array([sides.real, sides.imag])
        along = push - normal.T @ np.linalg.lstsq(normal.T, push, rcond=1e-8)[0]
        largest = np.abs(along).max()
        if largest <= 1e-9:
            break
        candidate = _close_polygon(sizes, np.concatenate([[0.0], at[1:] + along * min(rate, rate / largest)]))
        if candidate is not None and _crowding(candidate) < _crowding(at):
            at = candidate
        else:
            rate /= 2
    return at


def _crowding(at: np.ndarray) -> float:
    apart = (at[1:, None] - at[None, 1:])[np.triu_indices(len(at) - 1, 1)]
    return float((1 / np.maximum(1 - np.cos(apart), 1e-12)).sum())


def _close_polygon(sizes: np.ndarray, at: np.ndarray) -> np.ndarray | None:
    """The angles (n,) near these at which the sides close, None where Newton's method does not converge."""
    polygons = _close_polygons(sizes, at[:, None])
    return polygons[:, 0] if polygons.size else None


def _close_polygons(sizes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """The angles (n, k) near these (n, N) at which the sides close, by shortest Newton steps, where they converge."""
    at, sizes = starts.copy(), sizes[:, None]
    for _ in range(60):
        gap = (sizes * np.exp(1j * at)).sum(axis=0)
        if (np.abs(gap) <= 1e-15 * sizes.sum()).all():
            break
        sides = (1j * sizes * np.exp(1j * at))[1:]
        rows = np.array([sides.real, sides.imag]).transpose(2, 0, 1)
        step = (np.linalg.pinv(rows, rcond=1e-8) @ -np.array([gap.real, gap.imag]).T[..., None])[..., 0].T
        at[1:] += step * np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=0), 1e-300))
    return np.asarray(at[:, np.abs((sizes * np.exp(1j * at)).sum(axis=0)) <= 1e-12 * sizes.sum()])


def family_members(torques: SteadyTorques, count: int) -> np.ndarray:
    """Phases (n, k) of up to ``count`` members of the family that compensates, from evenly distributed starts."""
    c = torques.coefficients
    assert c is not None
    starts = np.random.default_rng(2).uniform(0, 2 * np.pi, (len(c), count))
    starts[0] = 0.0
    return np.asarray((_close_polygons(np.abs(c), starts) - np.angle(c)[:, None]) % (2 * np.pi))


@dataclass(frozen=True)
class State:
    """Steady phases (n,) relative to the main rotor (whose phase is 0) at a speed, in the bodies' senses.

    dimension: of the family it represents, 0 for an isolated state. multiplicity: number of states it represents, equal bodies
    being exchanged. sides: 0 or 1 for bodies in line, by the side they are on; else empty. is_indifferent: from this speed on
    no torque acts, so that all greater speeds are steady too.
    """

    speed: float
    phases: np.ndarray
    dimension: int = 0
    multiplicity: int = 1
    sides: tuple[int, ...] = ()
    is_indifferent: bool = False

    @property
    def neutral(self) -> int:
        """Number of directions in which neighbours are steady too: along its family, and to greater speeds."""
        return self.dimension + int(self.is_indifferent)

    @property
    def interior_state(self) -> State:
        """The same state; if it is indifferent, a little faster: past the breakpoint of the characteristic."""
        return replace(self, speed=self.speed * (1 + _PAST_THE_BREAKPOINT)) if self.is_indifferent else self


@dataclass(frozen=True)
class PhaseBranch:
    """Steady phases over the speed: beta = eta + arcsin(q), or the other angle with this sine, plus each body's ``shift``.

    level: eta and q (N,) at speeds (N,); states exist where |q| <= 1. is_supplementary: the other angle with this sine.
    shift: (n,), that of the main rotor is not used.
    """

    level: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    is_supplementary: bool
    shift: np.ndarray
    multiplicity: int = 1
    sides: tuple[int, ...] = ()

    def phases(self, speeds: np.ndarray) -> np.ndarray:
        """alpha (n, N), NaN where there is no such state."""
        eta, q = self.level(speeds)
        angle = np.arcsin(np.where(np.abs(q) <= 1 + 1e-14, np.clip(q, -1, 1), np.nan))
        phases: np.ndarray = self.shift[:, None] + (eta + (np.pi - angle if self.is_supplementary else angle))[None]
        phases[0] = np.where(np.isfinite(angle), 0.0, np.nan)
        return phases

    def margin(self, speeds: np.ndarray) -> np.ndarray:
        """1 - |q| (N,): negative where there is no such state."""
        return np.asarray(1 - np.abs(self.level(speeds)[1]))

    def states(self, speeds: np.ndarray) -> list[State]:
        """States at those of the speeds at which the branch exists."""
        every = zip(speeds, self.phases(speeds).T % (2 * math.pi), strict=True)
        return [State(float(w), at, 0, self.multiplicity, self.sides) for w, at in every if np.isfinite(at).all()]


def branches(torques: SteadyTorques, speeds: np.ndarray) -> list[PhaseBranch]:
    """All branches of bodies in line, or of two bodies. speeds: at which they will be evaluated."""
    if torques.coefficients is None or not torques.has_idle_bodies(speeds):
        level = partial(_level_of_two, torques)
        return [PhaseBranch(level, is_supplementary, np.zeros(2)) for is_supplementary in (False, True)]
    c = torques.coefficients
    sizes = np.abs(c)
    if sizes[1:].min() <= EVEN * sizes.max():
        name = torques.names[1 + int(sizes[1:].argmin())]
        raise InputError("machine", None, f"{name} has no unbalance: nothing fixes its phase", code="no-unbalance")
    if sizes[0] <= EVEN * sizes.max():
        return []  # in line on a balanced rotor they would be dragged: only compensating states are steady
    return [
        PhaseBranch(
            partial(_level_in_line, torques, g / sizes[0]),
            is_supplementary,
            np.pi * side - np.angle(c),
            many,
            tuple(side[1:].tolist()),
        )
        for side, g, many, twice in patterns(torques)
        for is_supplementary in ((False,) if twice else (False, True))
    ]


def patterns(torques: SteadyTorques) -> Iterator[tuple[np.ndarray, float, int, bool]]:
    """All ways to put bodies in line: the side of each (n,), g, its multiplicity, and True if it equals its opposite.

    Equal bodies are not distinguished. Turning the line by half a turn exchanges the sides: one of the two is given.
    """
    assert torques.coefficients is not None
    lengths = [len(members) for members in torques.classes]
    for plus in itertools.product(*(range(length + 1) for length in lengths)):
        opposite = tuple(length - k for length, k in zip(lengths, plus, strict=True))
        if plus >= opposite:
            side = np.zeros(torques.size, int)
            for count, members in zip(plus, torques.classes, strict=True):
                side[list(members[count:])] = 1
            g = float((np.abs(torques.coefficients[1:]) * np.where(side[1:], -1, 1)).sum())
            yield side, g, math.prod(map(math.comb, lengths, plus)), plus == opposite


def pattern_count(torques: SteadyTorques) -> int:
    """Number of ways in which bodies can be in line, equal ones not distinguished; both sides of the line counted."""
    return math.prod(len(members) + 1 for members in torques.classes)


def _level_in_line(torques: SteadyTorques, ratio: float, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a = torques.axis_influence(speeds)
    return np.angle(a), ratio * a.imag / np.abs(a)


def _level_of_two(torques: SteadyTorques, speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    a = torques.influence(speeds)
    with np.errstate(divide="ignore", invalid="ignore"):
        q = (2 * torques.shaft_torque(speeds)[0][1] / speeds**4 + a[:, 1, 1].imag) / np.abs(a[:, 1, 0])
    return np.angle(a[:, 1, 0]), np.where(np.isfinite(q), q, np.inf)


def fixed_speed_states(torques: SteadyTorques, speed: float) -> list[State]:
    """All states at a given speed; one entry for each family, and for states in which equal bodies are exchanged."""
    speeds = np.array([speed])
    several = compensating_phases(torques) if torques.coefficients is not None and torques.has_idle_bodies(speeds) else []
    states = [State(speed, at, dimension, many) for at, dimension, many in several]
    return states + [s for branch in branches(torques, speeds) for s in branch.states(speeds)]


def free_speed_states(torques: SteadyTorques, grid: np.ndarray) -> list[State]:
    """All states whose speed the drive decides, with speeds within a grid (N,) that resolves the resonances."""
    several = compensating_phases(torques) if torques.has_idle_bodies(grid) else []
    ends = balance_speeds(torques, grid) if several else []
    states = [State(w, at, dimension, many, is_indifferent=beyond) for w, beyond in ends for at, dimension, many in several]
    return states + [s for branch in branches(torques, grid) for s in branch.states(_branch_speeds(torques, branch, grid))]


def balance_speeds(torques: SteadyTorques, grid: np.ndarray) -> list[tuple[float, bool]]:
    """The speeds on a grid (N,) at which the bodies' shaft torques balance, and True where they also do beyond it.

    For an interval without torque its lower end is returned, the speed that is reached.
    """

    def net_torque(w: np.ndarray) -> np.ndarray:
        return np.asarray(torques.shaft_torque(w)[0].sum(axis=0))

    def is_torque_free(w: float) -> bool:
        return bool(net_torque(np.array([w]))[0] == 0)

    exact_zeros = grid[net_torque(grid) == 0]
    beside = np.concatenate([exact_zeros * (1 - _BESIDE), exact_zeros * (1 + _BESIDE)])
    grid = np.unique(np.concatenate([grid, beside[(beside > grid[0]) & (beside < grid[-1])]]))
    zero = net_torque(grid) == 0
    begins = np.flatnonzero(zero[:-1] & zero[1:] & ~np.concatenate([[True], zero[:-2]]))
    intervals = [  # without torque: from the first speed on, to the next sample that has one
        (first_where(is_torque_free, float(grid[i - 1]), float(grid[i])), float(grid[i:][~zero[i:]].min(initial=np.inf)))
        for i in begins
    ]
    single = [w for w in zeros_of(net_torque, grid).tolist() if not any(a * (1 - _BESIDE) <= w <= b for a, b in intervals)]
    return sorted([*((w, True) for w, _ in intervals), *((w, False) for w in single)])


def _branch_speeds(torques: SteadyTorques, branch: PhaseBranch, grid: np.ndarray) -> np.ndarray:
    """Speeds of a branch at which the main rotor's torque balances too."""

    def residual_torque(w: np.ndarray) -> np.ndarray:
        return np.asarray(torques.residual(w, branch.phases(w))[0])

    edges = zeros_of(branch.margin, grid)
    inside = np.unique(np.concatenate([grid, edges, (edges[1:] + edges[:-1]) / 2]))
    speeds = [np.empty(0)]
    for low, high in itertools.pairwise(np.unique(np.concatenate([grid[[0, -1]], edges]))):
        points = low + (high - low) * np.concatenate([_CLOSE, 1 - _CLOSE])
        points = np.unique(np.concatenate([points, inside[(inside > low) & (inside < high)]]))
        points = points[branch.margin(points) >= 0]
        if len(points):
            speeds.append(zeros_of(residual_torque, points))
    return np.concatenate(speeds)


def zeros_of(function: RealFunction, grid: np.ndarray) -> np.ndarray:
    """The zeros of a function on a grid (N,): where its sign changes, also between two samples at an extremum."""
    values = function(grid)
    size = np.abs(values)
    lowest = (size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:]) & (values[:-2] * values[2:] > 0)
    # Between three samples a smooth curve falls less below the lowest than the others are above it.
    dips = np.flatnonzero(lowest & (2 * size[1:-1] <= np.maximum(size[:-2], size[2:]))) + 1
    points = np.unique(
        np.concatenate([grid, _samples_in_dips(function, np.sign(values[dips]), grid[dips - 1], grid[dips + 1])])
    )
    ends = [w for w in points[[0, -1]] if function(np.array([w]))[0] == 0]
    return np.unique(np.concatenate([crossings(function, points), ends]))


def _samples_in_dips(function: RealFunction, signs: np.ndarray, low: np.ndarray, high: np.ndarray) -> np.ndarray:
    """Samples (N,) of all dips at once, denser and denser around the lowest place of each until one is beyond zero.

    signs: of the function (k,) around the dips. low, high: the dips' ends (k,).
    """
    samples = [np.empty(0)]
    for _ in range(_LEVELS if len(signs) else 0):
        near = np.linspace(low, high, _ZOOM)
        samples.append(near.ravel())
        heights = signs * function(near.ravel()).reshape(near.shape)
        best, dip = np.where(np.isnan(heights), np.inf, heights).argmin(axis=0), np.arange(len(signs))
        rest = heights[best, dip] >= 0
        below, above = near[np.maximum(best - 1, 0), dip], near[np.minimum(best + 1, _ZOOM - 1), dip]
        signs, low, high = signs[rest], below[rest], above[rest]
    return np.concatenate(samples)
