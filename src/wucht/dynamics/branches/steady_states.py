"""Steady states of a machine, or of user equations, along a parameter."""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Protocol

import numpy as np

from wucht.analysis.averaged_equations import AveragedEquations
from wucht.analysis.configurations.closed_form import State
from wucht.errors import InputError, RunError, nearest
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.numerics.angles import wrap_angle
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.deflation import deflated_solutions, random_starts
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation

Heartbeat = Callable[[], None]
NO_LABEL = "steady states"  # of states without a name


@dataclass(frozen=True)
class StatesAtValue:
    """States at a value of the parameter: points (n+1,) of isolated ones, and families. complete: True if proved to be all.
    evidence: for that, or why not. speeds: between which states were searched, None where the speed is given, or is none.
    failure: why the search was impossible.
    """

    value: float
    points: tuple[np.ndarray, ...] = ()
    families: tuple[State, ...] = ()
    complete: bool = False
    evidence: str = ""
    speeds: tuple[float, float] | None = None
    failure: str | None = None


@dataclass(frozen=True)
class Kind:
    """Name and type of a state. split: numbers of balancing bodies on each side of their line, the larger first."""

    name: str | None = None
    type: str | None = None
    split: tuple[int, int] | None = None
    multiplicity: int = 1

    @property
    def label(self) -> str:
        """The states in a legend: ``type II: together``, ``opposed 3 : 1``."""
        if self.name is None:
            return NO_LABEL
        split = self.split
        apart = f" {split[0]} : {split[1]}" if split is not None and self.name == "opposed" and sum(split) > 2 else ""
        return f"type {self.type}: {self.name}" if self.type else f"{self.name}{apart}"


MODULATED_MOTION, PERIODIC_ORBIT = "modulated motion", "periodic orbit"  # of a machine, and of user equations


@dataclass(frozen=True)
class Labels:
    """Names and units in results. ordinate: the quantity that is drawn, and its unit. state: its name, None for the main
    rotor's speed. inertia: True if the averaged equations have that of the balancing bodies, None where there are none. speed,
    time, length: units of speeds, of times and of the amplitude. of_equations: True for user equations, which have states
    alone, no speed and no amplitude.
    """

    ordinate: str
    unit: str
    state: str | None
    inertia: bool | None = None
    speed: str = ""
    time: str = ""
    length: str = ""
    warnings: tuple[str, ...] = field(default_factory=tuple)
    of_equations: bool = False

    @classmethod
    def from_machine(
        cls, machine: Machine, averaged_equations: AveragedEquations, inertia: bool, state: str | None = None
    ) -> Labels:
        """Return the labels of a machine. state: that is drawn; None: the main rotor's speed."""
        units = machine.units
        ordinate, unit = "speed of the main rotor", units.speed
        if state is not None and state.endswith(".phase"):
            ordinate, unit = f"phase of {state.removesuffix('.phase')}", "rad" if units.time else ""
        elif state is not None:
            ordinate = f"speed of {state.removesuffix('.speed')}"
        length = machine.orbit_unit if units.length else ""
        return cls(ordinate, unit, state, inertia, units.speed, units.time, length, averaged_equations.warnings)

    @property
    def orbit(self) -> str:
        """Name of a motion that is periodic but not steady."""
        return PERIODIC_ORBIT if self.of_equations else MODULATED_MOTION

    @property
    def rate(self) -> str:
        """Unit of exponents."""
        return f"1/{self.time}" if self.time else ""


def speed_range_text(speeds: tuple[float, float], unit: str) -> str:
    """Return a range as text: ``speeds from 0.2 to 200 rad/s``."""
    return f"speeds from {speeds[0]:.4g} to {speeds[1]:.4g} {unit}".rstrip()


class SteadyStates(Protocol):
    """Steady states along a parameter. The unknowns (n+1,) of a point are the states and the parameter's value."""

    @property
    def bounds(self) -> tuple[float, float]: ...  # noqa: D102

    @property
    def path(self) -> str:
        """Path of the parameter."""

    @property
    def nominal_value(self) -> float:
        """Nominal value of the parameter, of the machine or of the equations."""

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states (n)."""

    @property
    def equilibria(self) -> EquilibriumContinuation:
        """Continuation problem of the states."""

    def equations_with(self, second: str, width: float) -> EquilibriumEquations:
        """Return the equations with another varied parameter, scaled by the width of its range."""

    @property
    def ordinate_size(self) -> float:
        """Typical change of the ordinate."""

    @property
    def labels(self) -> Labels:
        """Names and units in results."""

    def find_equilibria(self, value: float, report: Heartbeat | None = None) -> StatesAtValue:
        """Search all states at a value. Raises ``InputError`` where that is impossible."""

    def is_same(self, unknowns: np.ndarray, reference: np.ndarray) -> bool:
        """True if points at one value are one state."""

    def kind(self, unknowns: np.ndarray) -> Kind:
        """Return name and type of the state at a point."""

    def ordinate(self, unknowns: np.ndarray) -> np.ndarray:
        """Return the quantity that is drawn (N,), by default the speed, of points (n+1, N)."""

    def amplitude(self, unknowns: np.ndarray) -> np.ndarray:
        """Return the amplitude (N,) of points (n+1, N), nan where there is none."""

    def state_by_name(self, unknowns: np.ndarray) -> Mapping[str, float]:
        """Return the state at a point by names."""

    def end_reason(self, unknowns: np.ndarray) -> str:
        """Return why a branch ends at a point at which a state leaves its limits."""


_STEPS = Steps(first=0.01, most=0.05, turn=0.06, points=4000)
_STARTS = 64
_SAME = 1e-6  # in units of scale
_SINGULAR = 1e-12  # of the largest singular value: a smaller one is zero
_AROUND = 1.0  # of an interval of a state: margin beyond it within which branches are followed


@dataclass(frozen=True)
class SystemEquilibria:
    """Equilibria of user equations. path, bounds: of the parameter. ranges: of states, in which equilibria are searched.

    show: the state that is drawn. The unknowns (n+1,) of a point are the states and the parameter's value.
    """

    subject: Subject
    path: str
    bounds: tuple[float, float]
    ranges: Mapping[str, tuple[float, float]]
    show: str

    @classmethod
    def of(
        cls, subject: Subject, path: str, bounds: tuple[float, float], ranges: Mapping[str, tuple[float, float]] | None = None,
        show: str | None = None,
    ) -> SystemEquilibria:  # fmt: skip
        """Set up the equilibria. show: None: the first state.

        Raises ``InputError`` where that or the ranges do not fit the equations, or they depend on time.
        """
        names, turning = subject.system.state_names, {s.name for s in subject.system.angles}
        if subject.system.depends_on_time:
            raise InputError("system", None, "these equations depend on the time t: they have no equilibria")
        show = show or names[0]
        if show not in names:
            raise InputError("study.show", show, f"unknown state; {nearest(show, names)}")
        ranges = dict.fromkeys(turning, (0.0, 2 * np.pi)) | dict(ranges or {})
        for name in ranges:
            if name not in names:
                raise InputError(f"study.ranges.{name}", list(ranges[name]), f"unknown state; {nearest(name, names)}")
        for name in names:
            if name not in ranges:
                requirement = f"give a pair [low, high] for {name}: ranges = {{ {name} = [low, high] }}"
                raise InputError(
                    "study.ranges",
                    None,
                    f"this key is missing; {requirement}, in which equilibria are searched",
                    code="missing",
                )
        return cls(subject, path, bounds, {n: ranges[n] for n in names}, show)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states (n)."""
        return self.subject.system.state_names

    @property
    def nominal_value(self) -> float:
        """See ``SteadyStates``."""
        return float(self.subject.values[self.path])

    @cached_property
    def equilibria(self) -> EquilibriumContinuation:
        """Continuation problem: states and parameter scaled by the widths of their ranges, angles by a radian."""
        limits = {
            i: (low - _AROUND * (high - low), high + _AROUND * (high - low))
            for i, (n, (low, high)) in enumerate(self.ranges.items())
            if n not in self._turning
        }
        equations = EquilibriumEquations.from_system(self.subject.system, [self.path], self.subject.values, self._scale)
        return EquilibriumContinuation(equations, self.bounds, _STEPS, limits)

    @property
    def _turning(self) -> set[str]:
        return {s.name for s in self.subject.system.angles}

    @property
    def _scale(self) -> dict[str, float]:
        sizes = {n: high - low for n, (low, high) in self.ranges.items() if n not in self._turning}
        return sizes | {self.path: self.bounds[1] - self.bounds[0]}

    def equations_with(self, second: str, width: float) -> EquilibriumEquations:
        """See ``SteadyStates``."""
        return EquilibriumEquations.from_system(
            self.subject.system, [self.path, second], self.subject.values, self._scale | {second: width}
        )

    @property
    def ordinate_size(self) -> float:
        """See ``SteadyStates``."""
        return self._scale.get(self.show, 1.0)

    @property
    def labels(self) -> Labels:
        """See ``SteadyStates``."""
        return Labels(f"state {self.show}", "", self.show, of_equations=True)

    def find_equilibria(self, value: float, report: Heartbeat | None = None) -> StatesAtValue:
        """See ``SteadyStates``: by Newton's method from many starts within the ranges, with deflation of known states."""
        if report is not None:
            report()
        low, high = np.array([self.ranges[n] for n in self.names]).T
        starts, equations = random_starts(low, high, _STARTS), self.equilibria.equations
        if _singular(equations, starts, value):
            raise RunError("the equations are singular at every start: their equilibria, if there are any, are not isolated")
        solutions = deflated_solutions(equations, [value], starts).T
        width, turning = equations.scale[:-1], equations.turns[:-1] > 0
        inside = [x for x in solutions if ((x >= low - width) & (x <= high + width) | turning).all()]
        evidence = f"deflated Newton's method from {_STARTS} starts within the ranges of the states: completeness is not proved"
        return StatesAtValue(value, tuple(np.append(x, value) for x in inside), evidence=evidence)

    def is_same(self, unknowns: np.ndarray, reference: np.ndarray) -> bool:
        """See ``SteadyStates``: up to whole turns of angles."""
        e = self.equilibria.equations
        away = unknowns - reference
        turns = np.where(e.turns > 0, e.turns, 1.0)
        away = np.where(e.turns > 0, away - turns * np.round(away / turns), away)
        return bool((np.abs(away / e.scale) < _SAME).all())

    def kind(self, unknowns: np.ndarray) -> Kind:
        """See ``SteadyStates``: they have no names."""
        return Kind()

    def ordinate(self, unknowns: np.ndarray) -> np.ndarray:
        """See ``SteadyStates``."""
        return np.asarray(unknowns[self.names.index(self.show)])

    def amplitude(self, unknowns: np.ndarray) -> np.ndarray:
        """See ``SteadyStates``."""
        return np.full(unknowns.shape[1], math.nan)

    def state_by_name(self, unknowns: np.ndarray) -> dict[str, float]:
        """See ``SteadyStates``."""
        return {n: float(wrap_angle(x) if n in self._turning else x) for n, x in zip(self.names, unknowns[:-1], strict=True)}

    def end_reason(self, unknowns: np.ndarray) -> str:
        """See ``SteadyStates``."""
        for i, (low, high) in self.equilibria.limits.items():
            if not low < unknowns[i] < high:
                return f"{self.names[i]} passes {unknowns[i]:.5g}, far outside the range in which equilibria were searched"
        return "a state leaves its limits"


def _singular(equations: EquilibriumEquations, starts: np.ndarray, value: float) -> bool:
    """True if df/dx is singular at all starts (N, n), so that Newton's method makes no step anywhere."""
    states = np.asarray(starts).reshape(-1, equations.n).T
    with np.errstate(all="ignore"):
        matrices = equations.values(np.vstack([states, np.full(states.shape[1], value)]))[1][:, :-1]
    matrices = np.moveaxis(matrices * equations.scale[:-1, None], -1, 0)
    finite = matrices[np.isfinite(matrices).all(axis=(1, 2))]
    sizes = np.linalg.svd(finite, compute_uv=False)
    return bool(len(sizes)) and bool((sizes[:, -1] <= _SINGULAR * sizes[:, 0]).all())
