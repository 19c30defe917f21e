"""Modulated motions and steady states at any values of a plane's parameters, and the motions that runs reach."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from typing import Any

import numpy as np

from wucht.dynamics.branches.first_orbits import SeedOrbit, orbit_near
from wucht.dynamics.branches.orbit_problem import OrbitProblem
from wucht.dynamics.branches.plane_regions import Range
from wucht.dynamics.branches.steady_states import Heartbeat, SteadyStates, SystemEquilibria
from wucht.errors import InputError, RunError
from wucht.machines.subject import Subject
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.deflation import disconnected_branches, random_starts
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import FOLD, HOPF, Branch, Equilibrium, EquilibriumContinuation

_STARTS = 24  # of Newton's method
_SEARCH_SHARES, _DECADE = (0.001, 0.1, 0.3, 0.6, 0.999), 10.0  # shares of the range, of its logarithm where it is that wide
_STEPS = Steps(first=0.01, most=0.05, turn=0.1)
_BEYOND = 0.3  # of a state's range: how far beyond it branches are followed
_LOWEST, _HIGHEST = 0.02, 1.15  # of the fastest speed of steady states: between these they are searched
_RUNS = 6  # at each place: from the given start, and from others spread evenly over the states' ranges
_BESIDE = 1e-3  # of the ranges of the starts
_SAME = 1e-3  # relative: periods of one orbit


@dataclass(frozen=True, eq=False)
class ModulatedMotion:
    """Orbits and steady states of one problem. subject: the equations in which orbits are followed. whole: all equations, where
    the first are those of bodies that keep together, else the same. box: ranges (2, n) in which steady states are searched.
    """

    subject: OrbitProblem
    whole: OrbitProblem
    box: np.ndarray

    @classmethod
    def of(
        cls, subject: Subject, path: str, bounds: Range, steady_states: SteadyStates, together: bool = False,
        ranges: Mapping[str, Range] | None = None, inertia: bool | None = None, start: Mapping[str, Any] | None = None,
    ) -> ModulatedMotion:  # fmt: skip
        """Set up the motions of a machine, or of user equations, along a parameter within bounds.

        together, ranges, inertia, start: see ``OrbitProblem.of``.

        Raises ``InputError`` where one of them does not fit the subject.
        """
        part = OrbitProblem.of(subject, path, bounds, start, together, ranges=ranges, inertia=inertia)
        whole = OrbitProblem.of(subject, path, bounds, start, ranges=ranges, inertia=inertia) if together else part
        return cls(part, whole, _box(part, steady_states))

    def refuse_idle(self, paths: Mapping[str, str]) -> None:
        """Raise ``InputError`` at the key of a parameter on which the equations do not depend. paths: by key."""
        for key, path in paths.items():
            if path not in self.subject.system.parameter_names:
                raise InputError(f"study.{key}", path, "not allowed: the averaged equations do not depend on it")

    @property
    def is_partial(self) -> bool:
        """True if orbits are followed in a part of the equations, that of bodies that keep together."""
        return self.subject.embedding is not None

    def with_values(self, values: Mapping[str, float]) -> ModulatedMotion:
        """Return the same motion at other parameter values."""
        subject, whole = (replace(p, values={**p.values, **values}) for p in (self.subject, self.whole))
        return replace(self, subject=subject, whole=whole)

    def lift(self, seed: SeedOrbit) -> SeedOrbit:
        """Return an orbit of the part as one of all equations."""
        if (e := self.subject.embedding) is None:
            return seed
        winding = np.rint(e @ seed.winding).astype(int)
        scale = np.append(np.abs(e) @ seed.scale[:-1], seed.scale[-1])
        return replace(seed, states=seed.states @ e.T, winding=winding, scale=scale)

    def starts(self, count: int) -> np.ndarray:
        """Return states (count, n) of all equations, spread evenly over the ranges in which steady states are searched."""
        from scipy.stats import qmc

        box = self.box
        if self.is_partial:
            speeds = self.box[:, np.flatnonzero(~self.subject.turning)[0]]
            box = np.where(self.whole.turning, [[0.0], [2 * np.pi]], speeds[:, None])
        shares = qmc.Halton(box.shape[1], scramble=False).random(count + 1)[1:]  # without its first point, a corner
        return np.asarray(box[0] + (box[1] - box[0]) * shares)

    def sizes(self, widths: Mapping[str, float]) -> dict[str, float]:
        """Return typical changes of states and parameters, by name. widths: of the parameters' ranges."""
        names, turning = self.subject.system.state_names, self.subject.turning
        of_states = {n: 1.0 if t else float(w) for n, t, w in zip(names, turning, np.ptp(self.box, axis=0), strict=True)}
        return of_states | dict(widths)

    def equations(self, paths: Sequence[str], bounds: Sequence[Range]) -> EquilibriumEquations:
        """Return the equations whose zeros are steady states, with some parameters that vary between bounds."""
        sizes = self.sizes({path: high - low for path, (low, high) in zip(paths, bounds, strict=True)})
        return EquilibriumEquations.from_system(self.subject.system, paths, self.subject.fixed_values(*paths), sizes)

    @cached_property
    def equilibria(self) -> EquilibriumContinuation:
        """Continuation problem of the steady states along the parameter."""
        s = self.subject
        equations = self.equations([s.path], [s.bounds])
        low, high = self.box
        room = _BEYOND * (high - low)
        limits = {i: (low[i] - room[i], high[i] + room[i]) for i in np.flatnonzero(~s.turning).tolist()}
        return EquilibriumContinuation(equations, s.bounds, _STEPS, limits)

    def steady_branches(self) -> tuple[Branch, ...]:
        """Follow the branches of steady states along the parameter."""
        low, high = self.subject.bounds
        decades = 0 < _DECADE * low < high
        values = [low * (high / low) ** share if decades else low + share * (high - low) for share in _SEARCH_SHARES]
        return disconnected_branches(self.equilibria, values, random_starts(self.box[0], self.box[1], _STARTS))


def _box(problem: OrbitProblem, steady_states: SteadyStates) -> np.ndarray:
    """Return ranges (2, n) of the states."""
    if isinstance(steady_states, SystemEquilibria):
        return np.array([steady_states.ranges[n] for n in steady_states.names]).T
    speeds = (_LOWEST * steady_states.ordinate_size, _HIGHEST * steady_states.ordinate_size)
    return np.array([(0.0, 2 * np.pi) if turns else speeds for turns in problem.turning]).T


def lost_states(branches: tuple[Branch, ...]) -> list[tuple[Equilibrium, int]]:
    """Return the points at which a stable steady state vanishes with another one (a fold), or becomes unstable (a Hopf point).

    Beside each stands the way: the sign of the parameter's change there. Those come first that are passed as it grows.
    """
    losses = list[tuple[Equilibrium, int]]()
    for branch in branches:
        for before, point, after in zip(branch.points, branch.points[1:], branch.points[2:], strict=False):
            if point.kind == HOPF:
                stable, unstable = sorted((before, after), key=lambda p: p.unstable)
                if (stable.unstable, unstable.unstable) == (0, 2) and unstable.parameter != stable.parameter:
                    losses.append((point, 1 if unstable.parameter > stable.parameter else -1))
            elif point.kind == FOLD:
                beside = [p for p in (before, after) if not p.kind]
                if any(p.unstable == 0 for p in beside):
                    losses.append((point, 1 if beside[0].parameter < point.parameter else -1))
    return sorted(losses, key=lambda loss: (-loss[1], loss[0].parameter))


def nearest_fold(motion: ModulatedMotion, x: np.ndarray, value: float) -> Equilibrium:
    """Return the fold of a saddle's branch nearest to a value of the parameter. Raises ``RunError`` where it has none."""
    branch = motion.equilibria.follow_branch(motion.equilibria.start(x, value))
    folds = [p for p in branch.special if p.kind == FOLD]
    if not folds:
        raise RunError(f"the saddle has no fold over {motion.subject.path}")
    return min(folds, key=lambda p: abs(p.parameter - value))


@dataclass(frozen=True)
class ReachedMotions:
    """Results of the runs at a place (x, y). runs: their number. steady: number that settled in a steady state.

    orbits: those on which runs settled, each once. unsettled_runs: number that did neither.
    """

    x: float
    y: float
    runs: int
    steady: int
    orbits: tuple[SeedOrbit, ...]
    unsettled_runs: int


def reached_motions(
    motion: ModulatedMotion, values: Sequence[float], second: float, report: Heartbeat
) -> tuple[ReachedMotions, ...]:
    """Return the motions that runs reach at values of the first parameter. motion: at the value of the second one."""
    spread, all_motions = motion.starts(_RUNS - 1), list[ReachedMotions]()
    beside = _BESIDE * np.ptp(spread, axis=0)  # the given start may be an unstable steady state
    for value in values:
        starts = [np.asarray(motion.whole.initial(value), float) + beside, *spread]
        runs, orbits = [orbit_near(motion.whole, value, start, report) for start in starts], list[SeedOrbit]()
        for orbit in (run.orbit for run in runs if run.orbit is not None):
            if not any(is_same_orbit(orbit, known_orbit) for known_orbit in orbits):
                orbits.append(orbit)
        steady, unsettled_runs = sum(r.is_steady for r in runs), sum(r.orbit is None and not r.is_steady for r in runs)
        all_motions.append(ReachedMotions(value, second, len(runs), steady, tuple(orbits), unsettled_runs))
    return tuple(all_motions)


def is_same_orbit(a: SeedOrbit, b: SeedOrbit) -> bool:
    """True if two orbits at one place are the same: of equal winding and period."""
    return bool((a.winding == b.winding).all()) and abs(a.period - b.period) <= _SAME * b.period
