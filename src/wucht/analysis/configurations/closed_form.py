"""Steady phase configurations in closed form: all balancing bodies of one rotor, and any two bodies.

Bodies that excite the carrier alike (E_i = c_i e, f_i = |c_i|) and have no torques of their own stay where Im[exp(i alpha_i)
conj(a S)] = 0 with a = e^H H e = |a| exp(i eta) and S = sum f_k exp(i alpha_k): either S = 0 (the unbalances compensate each
other), or every one lies at beta or opposite, S = f_0 + g exp(i beta), g = sum +-f_i, and

    sin(beta - eta) = (g/f_0) sin(eta):

two beta for each choice of signs, where there are any. No other phases stay, whatever the number of bodies. Without damping
(eta = 0 or pi) this is 000 (43)-(48) and 001, table 1; for two equal bodies 002 (5.5)-(5.15). Two bodies of which the second
has a torque tau_1 of its own have one phase, and |a_10| sin(alpha - arg a_10) = 2 tau_1/w^4 + Im a_11: 001 (35).
"""

from __future__ import annotations

import itertools
import math
from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from wucht.analysis.configurations.force_balance import EVEN, compensating
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.errors import InputError
from wucht.numerics.zeros import crossings

_CLOSE = np.geomspace(1e-13, 0.3, 60)  # of a range of speeds: how near its ends the torques are looked at
_ZOOM, _LEVELS = 41, 8  # points and number of the looks at an extremum that comes near zero
_OFF_THE_CORNER = 1e-6  # of a speed
_BESIDE = 1e-9  # of a speed: whether a torque is zero there too


@dataclass(frozen=True)
class State:
    """Constant phases (n,) to the main rotor (its own is 0) at a speed, in the bodies' own senses.

    dimension: of the family it stands for, 0 for an isolated state. multiplicity: how many states it is, equal bodies being
    exchanged. beside: 0 or 1 for bodies that are in line, by the side they are on; empty for others. indifferent: from this
    speed on no torque is left, so that all greater speeds are as good.
    """

    speed: float
    phases: np.ndarray
    dimension: int = 0
    multiplicity: int = 1
    beside: tuple[int, ...] = ()
    indifferent: bool = False

    @property
    def neutral(self) -> int:
        """In how many directions a neighbour of it is as good: along its family, and to greater speeds."""
        return self.dimension + int(self.indifferent)

    @property
    def inside(self) -> State:
        """The same, but where greater speeds are as good a little faster: off the corner of the characteristic."""
        return replace(self, speed=self.speed * (1 + _OFF_THE_CORNER)) if self.indifferent else self


@dataclass(frozen=True)
class Branch:
    """Constant phases over the speed: beta = eta + arcsin(q), or the other angle with this sine, plus each body's ``shift``.

    level: eta and q (N,) at speeds (N,); states exist where |q| <= 1. shift: (n,), that of the main rotor is not used.
    """

    level: Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]
    other: bool
    shift: np.ndarray
    multiplicity: int = 1
    beside: tuple[int, ...] = ()

    def phases(self, speeds: np.ndarray) -> np.ndarray:
        """alpha (n, N), not a number where there is no such state."""
        eta, q = self.level(np.atleast_1d(np.asarray(speeds, float)))
        inside = np.abs(q) <= 1 + 1e-14
        angle = np.arcsin(np.where(inside, np.clip(q, -1, 1), np.nan))
        found: np.ndarray = self.shift[:, None] + (eta + (np.pi - angle if self.other else angle))[None]
        found[0] = np.where(inside, 0.0, np.nan)
        return found

    def margin(self, speeds: np.ndarray) -> np.ndarray:
        """1 - |q| (N,): negative where there is no such state."""
        return np.asarray(1 - np.abs(self.level(speeds)[1]))

    def state(self, speed: float) -> State | None:
        """The state at a speed."""
        phases = self.phases(np.array([speed]))[:, 0]
        if not np.isfinite(phases).all():
            return None
        return State(speed, phases % (2 * math.pi), 0, self.multiplicity, self.beside)


def has_closed_form(torques: SteadyTorques, speeds: np.ndarray) -> bool:
    """Whether the phases are known in closed form at these speeds."""
    return torques.size == 2 or (torques.coefficients is not None and torques.idle(speeds))


def branches(torques: SteadyTorques, speeds: np.ndarray) -> list[Branch]:
    """All branches of bodies in line, or of two bodies. speeds: at which they will be asked for."""
    if torques.coefficients is None or not torques.idle(speeds):
        return _of_two(torques)
    c = torques.coefficients
    sizes = np.abs(c)
    if sizes[1:].min() <= EVEN * sizes.max():
        name = torques.names[1 + int(sizes[1:].argmin())]
        raise InputError("machine", None, f"{name} has no unbalance: nothing fixes its phase")
    if sizes[0] <= EVEN * sizes.max():
        return []  # in line behind a balanced rotor they would be dragged: only what compensates stays
    found = []
    for side, many, twice in patterns(torques):
        shift, level = np.pi * side - np.angle(c), _in_line(torques, signed(torques, side) / sizes[0])
        found += [
            Branch(level, other, shift, many, tuple(side[1:].tolist())) for other in ((False,) if twice else (False, True))
        ]
    return found


def patterns(torques: SteadyTorques) -> list[tuple[np.ndarray, int, bool]]:
    """All ways to put bodies in line: the side of each (n,), how many it stands for, and whether it is its own opposite.

    Equal bodies are not told apart. Turning the line by half a turn exchanges the sides: of both ways one is given.
    """
    lengths = [len(members) for members in torques.classes]
    found = []
    for plus in itertools.product(*(range(length + 1) for length in lengths)):
        opposite = tuple(length - k for length, k in zip(lengths, plus, strict=True))
        if plus < opposite:
            continue
        side = np.zeros(torques.size, int)
        for count, members in zip(plus, torques.classes, strict=True):
            side[list(members[count:])] = 1
        many = math.prod(math.comb(length, k) for k, length in zip(plus, lengths, strict=True))
        found.append((side, many, plus == opposite))
    return found


def pattern_count(torques: SteadyTorques) -> int:
    """In how many ways bodies can be in line, equal ones not told apart; both sides of the line counted."""
    return math.prod(len(members) + 1 for members in torques.classes)


def signed(torques: SteadyTorques, side: np.ndarray) -> float:
    """g = sum +-f_i of the bodies other than the main rotor, by the side (n,) they are on."""
    assert torques.coefficients is not None
    return float((np.abs(torques.coefficients[1:]) * np.where(side[1:], -1, 1)).sum())


def _in_line(torques: SteadyTorques, ratio: float) -> Callable[[np.ndarray], tuple[np.ndarray, np.ndarray]]:
    def level(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        a = torques.axis_influence(speeds)
        return np.angle(a), ratio * a.imag / np.abs(a)

    return level


def _of_two(torques: SteadyTorques) -> list[Branch]:
    def level(speeds: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        w = np.atleast_1d(np.asarray(speeds, float))
        a = torques.influence(w)[0]
        with np.errstate(divide="ignore", invalid="ignore"):
            q = (2 * torques.alone(w)[0][1] / w**4 + a[:, 1, 1].imag) / np.abs(a[:, 1, 0])
        return np.angle(a[:, 1, 0]), np.where(np.isfinite(q), q, np.inf)

    return [Branch(level, other, np.zeros(2)) for other in (False, True)]


def at_speed(torques: SteadyTorques, speed: float) -> list[State]:
    """All states at a given speed; one entry for each family, and for states in which equal bodies are exchanged."""
    speeds = np.array([speed])
    found = [s for b in branches(torques, speeds) if (s := b.state(speed)) is not None]
    if torques.coefficients is not None and torques.idle(speeds):
        found = [State(speed, at, d, many) for at, d, many in compensating(torques)] + found
    return found


def over_speeds(torques: SteadyTorques, grid: np.ndarray) -> list[State]:
    """All states whose speed the drive decides, with speeds within a grid (N,) that resolves the resonances."""
    found = []
    all_, several = branches(torques, grid), compensating(torques) if torques.idle(grid) else []
    if several:
        ends = resting_speeds(torques, grid)
        found += [State(w, at, d, many, indifferent=beyond) for w, beyond in ends for at, d, many in several]
    for branch in all_:
        found += [s for w in _speeds_of(torques, branch, grid) if (s := branch.state(w)) is not None]
    return found


def resting_speeds(torques: SteadyTorques, grid: np.ndarray) -> list[tuple[float, bool]]:
    """The speeds on a grid (N,) at which the bodies' own torques are in balance, and whether they still are beyond it.

    Of an interval without torque its lower end, the speed that is reached.
    """

    def left(w: np.ndarray) -> np.ndarray:
        found: np.ndarray = torques.alone(w)[0].sum(axis=0)
        return found

    touched = grid[left(grid) == 0]
    beside = np.concatenate([touched * (1 - _BESIDE), touched * (1 + _BESIDE)])
    grid = np.unique(np.concatenate([grid, beside[(beside > grid[0]) & (beside < grid[-1])]]))
    none = left(grid) == 0
    begins = np.flatnonzero(none[:-1] & none[1:] & ~np.concatenate([[True], none[:-2]]))
    found = [(_first_zero(left, float(grid[i - 1]), float(grid[i])), True) for i in begins]
    inside = [
        (w * (1 - _BESIDE), float(grid[i:][~none[i:]].min(initial=np.inf))) for (w, _), i in zip(found, begins, strict=True)
    ]
    single = [float(w) for w in zeros_of(left, grid) if not any(low <= w <= high for low, high in inside)]
    return sorted([*found, *((w, False) for w in single)])


def _first_zero(function: Callable[[np.ndarray], np.ndarray], low: float, high: float) -> float:
    """The lowest speed between two from which on a function is zero, to the last bit."""
    while (middle := (low + high) / 2) not in (low, high):
        low, high = (low, middle) if function(np.array([middle]))[0] == 0 else (middle, high)
    return high


def _speeds_of(torques: SteadyTorques, branch: Branch, grid: np.ndarray) -> list[float]:
    """Where the main rotor's own torque balances too."""

    def left(w: np.ndarray) -> np.ndarray:
        found: np.ndarray = torques.residual(w, branch.phases(w))[0]
        return found

    edges = zeros_of(branch.margin, grid)
    inside = np.unique(np.concatenate([grid, edges, (edges[1:] + edges[:-1]) / 2]))
    found: list[float] = []
    for low, high in itertools.pairwise(np.unique(np.concatenate([grid[[0, -1]], edges]))):
        points = low + (high - low) * np.concatenate([_CLOSE, 1 - _CLOSE])
        points = np.unique(np.concatenate([points, inside[(inside > low) & (inside < high)]]))
        points = points[branch.margin(points) >= 0]
        if len(points):
            found += [float(w) for w in zeros_of(left, points)]
    return found


def zeros_of(function: Callable[[np.ndarray], np.ndarray], grid: np.ndarray) -> np.ndarray:
    """The zeros of a function on a grid (N,): where its sign changes, also between two samples at an extremum."""
    fine, values = grid, function(grid)
    size = np.abs(values)
    lowest = (size[1:-1] <= size[:-2]) & (size[1:-1] <= size[2:]) & (values[:-2] * values[2:] > 0)
    # Between three samples a smooth curve goes less below the lowest than the others stand above it.
    dips = np.flatnonzero(lowest & (2 * size[1:-1] <= np.maximum(size[:-2], size[2:]))) + 1
    extra = []
    for i in dips:
        low, high = float(grid[i - 1]), float(grid[i + 1])
        for _ in range(_LEVELS):
            near = np.linspace(low, high, _ZOOM)
            there = np.sign(values[i]) * function(near)
            best = int(np.nanargmin(there))
            extra.append(near)
            if there[best] < 0:
                break
            low, high = float(near[max(best - 1, 0)]), float(near[min(best + 1, _ZOOM - 1)])
    if extra:
        fine = np.unique(np.concatenate([grid, *extra]))
    ends = [w for w in fine[[0, -1]] if function(np.array([w]))[0] == 0]
    return np.unique(np.concatenate([crossings(function, fine), ends]))
