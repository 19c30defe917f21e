"""What branches are made of: the steady states of a machine, or of equations, along a parameter."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np

from wucht.analysis.averaged import AveragedMachine
from wucht.analysis.configurations.closed_form import State
from wucht.machines.machine import Machine
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
