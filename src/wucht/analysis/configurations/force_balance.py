"""Phases in which the centrifugal forces compensate each other: the force polygon closes, 000 (36)-(44).

Two bodies close a triangle with the rotor's unbalance; n bodies have n - 2 parameters left.
"""

from __future__ import annotations

import math

import numpy as np

from wucht.analysis.configurations.torques import SteadyTorques

EVEN = 1e-9  # relative: sides of the force polygon of which the longest is all others together leave no polygon
_REPELLING = 200  # steps in which bodies of a family move apart


def compensating(torques: SteadyTorques, spread: bool = True) -> list[tuple[np.ndarray, int, int]]:
    """Phases (n,) that compensate, S = 0: with the dimension of their family and their multiplicity.

    Two bodies: 000 (42)-(44), both triangles (one, if the bodies are equal). More: one member of the family. None where the
    polygon of the forces does not close, 000 (41). spread: whether that member is one with the bodies far apart.
    """
    c = torques.coefficients
    if c is None or torques.size < 3:
        return []
    sizes, angles = np.abs(c), np.angle(c)
    balanced = sizes[0] <= EVEN * sizes.max()
    rest = sizes.sum() - 2 * sizes.max()
    if rest <= EVEN * sizes.sum() and not (balanced and torques.size == 3 and abs(sizes[1] - sizes[2]) <= EVEN * sizes[1]):
        return []
    if balanced or torques.size > 3:
        at = _closed_polygon(sizes, _REPELLING if spread else 0) if torques.size > 3 else np.array([0.0, 0.0, np.pi])
        return [((at - angles) % (2 * np.pi), torques.size - 3 + (1 if balanced else 0), 1)]
    f0, f1, f2 = sizes
    first = math.acos(np.clip((f0**2 + f1**2 - f2**2) / (2 * f0 * f1), -1, 1))
    second = math.acos(np.clip((f0**2 - f1**2 + f2**2) / (2 * f0 * f2), -1, 1))
    both = [np.array([0.0, np.pi - s * first, np.pi + s * second]) for s in (1, -1)]
    equal = len(torques.classes) == 1
    return [((at - angles) % (2 * np.pi), 0, 2 if equal else 1) for at in (both[:1] if equal else both)]


def _closed_polygon(sizes: np.ndarray, steps: int) -> np.ndarray:
    """Angles (n,) at which the sides close, the bodies apart from each other as far as they can be.

    From evenly spread ones; bodies repel each other along the family.
    """
    n = len(sizes)
    start = np.concatenate([[0.0], 2 * np.pi * (np.arange(n - 1) + 0.5) / (n - 1)])
    draw = np.random.default_rng(1)
    while (closed := _closing(sizes, start)) is None:
        start = np.concatenate([[0.0], draw.uniform(0, 2 * np.pi, n - 1)])
    at, rate = closed, 0.1
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
        moved = _closing(sizes, np.concatenate([[0.0], at[1:] + along * min(rate, rate / largest)]))
        if moved is not None and _crowding(moved) < _crowding(at):
            at = moved
        else:
            rate /= 2
    return at


def _crowding(at: np.ndarray) -> float:
    apart = (at[1:, None] - at[None, 1:])[np.triu_indices(len(at) - 1, 1)]
    return float((1 / np.maximum(1 - np.cos(apart), 1e-12)).sum())


def _closing(sizes: np.ndarray, at: np.ndarray) -> np.ndarray | None:
    """The angles (n,) near these at which the sides close, None where Newton's steps do not get to any."""
    closed = _closed(sizes, at[:, None])
    return closed[:, 0] if closed.size else None


def _closed(sizes: np.ndarray, starts: np.ndarray) -> np.ndarray:
    """The angles (n, k) near some of these (n, N) at which the sides close, by Newton's shortest steps."""
    at, sizes = starts.copy(), sizes[:, None]
    for _ in range(60):
        left = (sizes * np.exp(1j * at)).sum(axis=0)
        if (np.abs(left) <= 1e-15 * sizes.sum()).all():
            break
        sides = (1j * sizes * np.exp(1j * at))[1:]
        rows = np.array([sides.real, sides.imag]).transpose(2, 0, 1)
        step = (np.linalg.pinv(rows, rcond=1e-8) @ -np.array([left.real, left.imag]).T[..., None])[..., 0].T
        at[1:] += step * np.minimum(1.0, 0.5 / np.maximum(np.abs(step).max(axis=0), 1e-300))
    return np.asarray(at[:, np.abs((sizes * np.exp(1j * at)).sum(axis=0)) <= 1e-12 * sizes.sum()])


def members(torques: SteadyTorques, count: int) -> np.ndarray:
    """Phases (n, k) of up to ``count`` members of the family that compensates, from evenly distributed starts."""
    c = torques.coefficients
    assert c is not None
    starts = np.random.default_rng(2).uniform(0, 2 * np.pi, (len(c), count))
    starts[0] = 0.0
    return np.asarray((_closed(np.abs(c), starts) - np.angle(c)[:, None]) % (2 * np.pi))
