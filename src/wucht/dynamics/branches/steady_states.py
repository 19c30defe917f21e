"""What branches are made of: the steady states of a machine, or of equations, along a parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from wucht.analysis.averaged import AveragedMachine
from wucht.analysis.configurations.closed_form import State
from wucht.errors import InputError, RunError, nearest
from wucht.files.own_equations import OwnEquations
from wucht.machines.machine import Machine
from wucht.numerics.angles import wrapped
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.deflation import deflated, seeded
from wucht.numerics.continuation.equations import Equations
from wucht.numerics.continuation.equilibria import Equilibria

Watch = Callable[[], None]


@dataclass(frozen=True)
class BranchSettings:
    """Which steady states are searched and followed.

    points: values in the range, besides those near both ends, at which all states are searched. only: names of states that are
    followed, None for all. show: the state that is drawn; None: the main rotor's speed, of equations their first state.
    ranges: of the states of equations, in which equilibria are searched. inertia: of a machine's balancing bodies in the
    averaged equations; None: as is usual for the machine.
    """

    points: int = 5
    only: tuple[str, ...] | None = None
    show: str | None = None
    ranges: Mapping[str, tuple[float, float]] | None = None
    inertia: bool | None = None


@dataclass(frozen=True)
class StatesAtValue:
    """The states at a value of the parameter: points (n+1,) of isolated ones, and families. complete: whether they are shown
    to be all. shown: how, or why not. speeds: between which it was searched, None where the speed is given, or is none.
    """

    points: tuple[np.ndarray, ...]
    families: tuple[State, ...]
    complete: bool
    shown: str
    speeds: tuple[float, float] | None = None


@dataclass(frozen=True)
class Kind:
    """What a state is called. split: how many balancing bodies are on each side of the line they are in, the larger first."""

    name: str | None = None
    type: str | None = None
    split: tuple[int, int] | None = None
    multiplicity: int = 1


@dataclass(frozen=True)
class Ordinates:
    """What is drawn of points (N,): a quantity, by default the speed; and the amplitude, not a number where there is none."""

    speed: np.ndarray
    amplitude: np.ndarray


@dataclass(frozen=True)
class Words:
    """How results are written. shown: what is drawn, and its unit. state: its name, None where that is the main rotor's speed.
    inertia: whether the averaged equations have that of the balancing bodies, None where there are none. speed, time, length:
    units of speeds, of times and of the amplitude.
    """

    shown: str
    unit: str
    state: str | None
    inertia: bool | None = None
    speed: str = ""
    time: str = ""
    length: str = ""
    warnings: tuple[str, ...] = field(default_factory=tuple)

    @classmethod
    def of(cls, machine: Machine, averaged: AveragedMachine, inertia: bool, state: str | None = None) -> Words:
        """Of a machine. state: that is drawn; None: the main rotor's speed."""
        units = machine.units
        shown, unit = "speed of the main rotor", units.speed
        if state is not None and state.endswith(".phase"):
            shown, unit = f"phase of {state.removesuffix('.phase')}", "rad" if units.time else ""
        elif state is not None:
            shown = f"speed of {state.removesuffix('.speed')}"
        length = machine.orbit_unit if units.length else ""
        return cls(shown, unit, state, inertia, units.speed, units.time, length, averaged.warnings)

    @property
    def rate(self) -> str:
        """The unit of exponents."""
        return f"1/{self.time}" if self.time else ""


def in_words(speeds: tuple[float, float], unit: str) -> str:
    """``speeds from 0.2 to 200 rad/s``."""
    return f"speeds from {speeds[0]:.4g} to {speeds[1]:.4g} {unit}".rstrip()


class SteadyStates(Protocol):
    """Of points u (n+1,): states and the parameter's value."""

    @property
    def bounds(self) -> tuple[float, float]: ...  # noqa: D102

    @property
    def path(self) -> str:
        """Of the parameter."""

    @property
    def nominal_value(self) -> float:
        """The parameter's value of the machine, or of the equations, as they are."""

    @property
    def names(self) -> tuple[str, ...]:
        """Of the states (n)."""

    @property
    def equilibria(self) -> Equilibria:
        """As they are followed."""

    def equations_with(self, second: str, width: float) -> Equations:
        """The equations with another parameter that varies, by the width of its range."""

    @property
    def size_of_shown(self) -> float:
        """By how much what is drawn changes when it changes much."""

    @property
    def words(self) -> Words:
        """How results are written."""

    def states_at(self, value: float, watch: Watch | None = None) -> StatesAtValue:
        """All states at a value. Raises ``InputError`` where they cannot be searched."""

    def same(self, u: np.ndarray, v: np.ndarray) -> bool:
        """Whether points at one value are one state."""

    def kind(self, u: np.ndarray) -> Kind:
        """What the state at a point is called."""

    def ordinates(self, u: np.ndarray) -> Ordinates:
        """Of points (n+1, N)."""

    def stated(self, u: np.ndarray) -> Mapping[str, float]:
        """The state at a point by names."""

    def end(self, u: np.ndarray) -> str:
        """Why a branch ends at a point at which a state leaves its limits."""


_STEPS = Steps(first=0.01, most=0.05, turn=0.06, points=4000)
_STARTS = 64
_SAME = 1e-6  # in units of scale
_SINGULAR = 1e-12  # of the largest: a singular value that is zero
_AROUND = 1.0  # of an interval of a state: how far beyond it branches are followed


@dataclass(frozen=True)
class SystemEquilibria:
    """Equilibria of equations. path: of the parameter. bounds: of it. ranges: of states, in which equilibria are searched.

    show: the state that is drawn. Points u (n+1,) are states and the parameter's value.
    """

    subject: OwnEquations
    path: str
    bounds: tuple[float, float]
    ranges: Mapping[str, tuple[float, float]]
    show: str

    @classmethod
    def of(
        cls, subject: OwnEquations, path: str, bounds: tuple[float, float], settings: BranchSettings
    ) -> SystemEquilibria:  # fmt: skip
        """Raises ``InputError`` where a setting does not fit the equations, or they depend on time."""
        names, turning = subject.system.state_names, {s.name for s in subject.system.angles}
        for key, given in (("only", settings.only), ("inertia", settings.inertia)):
            if given is not None:
                raise InputError(f"study.{key}", given, "allowed for a machine only")
        if subject.system.depends_on_time:
            raise InputError("system", None, "these equations depend on the time t: they have no equilibria")
        show = settings.show or names[0]
        if show not in names:
            raise InputError("study.show", show, f"unknown state; {nearest(show, names)}")
        ranges = dict.fromkeys(turning, (0.0, 2 * np.pi)) | dict(settings.ranges or {})
        for name in ranges:
            if name not in names:
                raise InputError(f"study.ranges.{name}", list(ranges[name]), f"unknown state; {nearest(name, names)}")
        for name in names:
            if name not in ranges:
                needed = f"needed is a pair [low, high] for {name}: ranges = {{ {name} = [low, high] }}"
                raise InputError(
                    "study.ranges", None, f"this key is missing; {needed}, in which equilibria are searched", code="missing"
                )
        return cls(subject, path, bounds, {n: ranges[n] for n in names}, show)

    @property
    def names(self) -> tuple[str, ...]:
        """Of the states (n)."""
        return self.subject.system.state_names

    @property
    def nominal_value(self) -> float:
        """See ``SteadyStates``."""
        return float(self.subject.values[self.path])

    @cached_property
    def equilibria(self) -> Equilibria:
        """As they are followed: states and parameter by the widths of their ranges, angles by a radian."""
        limits = {
            i: (low - _AROUND * (high - low), high + _AROUND * (high - low))
            for i, (n, (low, high)) in enumerate(self.ranges.items())
            if n not in self._turning
        }
        equations = Equations.of(self.subject.system, [self.path], self.subject.values, self._scale)
        return Equilibria(equations, self.bounds, _STEPS, limits)

    @property
    def _turning(self) -> set[str]:
        return {s.name for s in self.subject.system.angles}

    @property
    def _scale(self) -> dict[str, float]:
        sizes = {n: high - low for n, (low, high) in self.ranges.items() if n not in self._turning}
        return sizes | {self.path: self.bounds[1] - self.bounds[0]}

    def equations_with(self, second: str, width: float) -> Equations:
        """See ``SteadyStates``."""
        return Equations.of(self.subject.system, [self.path, second], self.subject.values, self._scale | {second: width})

    @property
    def size_of_shown(self) -> float:
        """See ``SteadyStates``."""
        return self._scale.get(self.show, 1.0)

    @property
    def words(self) -> Words:
        """See ``SteadyStates``."""
        return Words(f"state {self.show}", "", self.show)

    def states_at(self, value: float, watch: Watch | None = None) -> StatesAtValue:
        """See ``SteadyStates``: by Newton's method from many starts within the ranges, known states being divided out."""
        if watch is not None:
            watch()
        low, high = np.array([self.ranges[n] for n in self.names]).T
        starts, equations = seeded(low, high, _STARTS), self.equilibria.equations
        if _singular(equations, starts, value):
            raise RunError(
                "the equations are singular at every start: their equilibria, if there are any, are no isolated points"
            )
        solutions = deflated(equations, [value], starts).points.T
        width, turning = equations.scale[:-1], equations.turns[:-1] > 0
        inside = [x for x in solutions if ((x >= low - width) & (x <= high + width) | turning).all()]
        shown = f"deflated Newton's method from {_STARTS} starts within the ranges of the states: no proof that none is missing"
        return StatesAtValue(tuple(np.append(x, value) for x in inside), (), False, shown)

    def same(self, u: np.ndarray, v: np.ndarray) -> bool:
        """See ``SteadyStates``: but for whole turns of angles."""
        e = self.equilibria.equations
        away = u - v
        turns = np.where(e.turns > 0, e.turns, 1.0)
        away = np.where(e.turns > 0, away - turns * np.round(away / turns), away)
        return bool((np.abs(away / e.scale) < _SAME).all())

    def kind(self, u: np.ndarray) -> Kind:
        """See ``SteadyStates``: they have no names."""
        return Kind()

    def ordinates(self, u: np.ndarray) -> Ordinates:
        """See ``SteadyStates``."""
        return Ordinates(u[self.names.index(self.show)], np.full(u.shape[1], math.nan))

    def stated(self, u: np.ndarray) -> dict[str, float]:
        """See ``SteadyStates``."""
        return {n: float(wrapped(x) if n in self._turning else x) for n, x in zip(self.names, u[:-1], strict=True)}

    def end(self, u: np.ndarray) -> str:
        """See ``SteadyStates``."""
        for i, (low, high) in self.equilibria.limits.items():
            if not low < u[i] < high:
                return f"{self.names[i]} passes {u[i]:.5g}, far outside the range in which equilibria were searched"
        return "a state leaves its limits"


def _singular(equations: Equations, starts: np.ndarray, value: float) -> bool:
    """Whether df/dx is singular at all starts (N, n), so that Newton's method makes no step anywhere."""
    states = np.asarray(starts).reshape(-1, equations.n).T
    with np.errstate(all="ignore"):
        matrices = equations.values(np.vstack([states, np.full(states.shape[1], value)]))[1][:, :-1]
    matrices = np.moveaxis(matrices * equations.scale[:-1, None], -1, 0)
    finite = matrices[np.isfinite(matrices).all(axis=(1, 2))]
    sizes = np.linalg.svd(finite, compute_uv=False)
    return bool(len(sizes)) and bool((sizes[:, -1] <= _SINGULAR * sizes[:, 0]).all())
