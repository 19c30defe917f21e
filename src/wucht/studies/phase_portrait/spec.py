"""The question of a phase portrait."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Annotated, Any, ClassVar

from pydantic import BeforeValidator, Field

from wucht.errors import InputError
from wucht.schema import SI, Composite, composite, si
from wucht.studies import spec as common

MOST_PORTRAITS, MOST_TRAJECTORIES = 60, 400


def _table(value: Any) -> Any:
    if not isinstance(value, Mapping):
        raise ValueError("must be a table: ranges = { STATE = [low, high], ... }")
    for name, pair in value.items():
        if not isinstance(pair, list | tuple) or len(pair) != 2:
            raise ValueError(f"must give a pair [low, high] for {name}")
    return {str(name): tuple(pair) for name, pair in value.items()}


def _together(value: Any) -> Any:
    if value is True:
        return True
    if isinstance(value, list | tuple) and len(value) > 1 and all(isinstance(name, str) for name in value):
        return tuple(value)
    raise ValueError('must be true, or the names of bodies: together = ["p1", "p2"]')


def _trajectories(value: Any) -> Any:
    if isinstance(value, list | tuple) and all(isinstance(start, Mapping) for start in value):
        return tuple(map(dict, value))
    if isinstance(value, bool) or not isinstance(value, int | float) or value != int(value) or value < 0:
        raise ValueError("must be a whole number of at least 0, or a list of starts: [{ STATE = VALUE, ... }, ...]")
    return int(value)


def _two_states(value: Any) -> Any:
    if isinstance(value, list | tuple) and len(value) == 2 and len(set(value)) == 2 and all(isinstance(n, str) for n in value):
        return tuple(value)
    if value == ():
        return value
    raise ValueError('must be two states: show = ["x", "z"]')


TwoStates = Annotated[tuple[str, ...], BeforeValidator(_two_states)]
Ranges = Annotated[dict[str, tuple[common.Value, common.Value]], BeforeValidator(_table)]
Together = Annotated[bool | tuple[str, ...], BeforeValidator(_together)]
Trajectories = Annotated[int | tuple[dict[str, Any], ...], BeforeValidator(_trajectories)]


class PhasePortrait(common.Spec):
    """All fixed points of two equations with their kinds, the separatrices of the saddles with their ends, closed curves.

    For a table [system] of two states, or for the averaged equations of a machine, reduced to two states by bodies
    that keep equal phases. A table [system] of more states is projected on two.
    """

    kind: ClassVar[str] = "phase-portrait"
    subject: ClassVar[str] = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    meaning: ClassVar[tuple[str, ...]] = (*common.Spec.meaning, "show")

    ranges: Composite[Ranges] = composite(default_factory=dict, title="ranges of the states", description=(
        "ranges of the states, by name: the window; of an angle its range in the figure"
    ))  # fmt: skip
    together: Composite[Together | None] = composite(default=None, title="bodies that keep equal phases", description=(
        "true or names of bodies: they keep equal phases (002 (5.17)-(5.18): true); refused where they would not"
    ))  # fmt: skip
    speed: SI[float | None] = si("rad/s", "speed", default=None, help="speed at which the main rotor is held")
    inertia: common.Inertia | None = Field(default=None, description=(
        "whether the averaged equations keep the inertia of the balancing bodies, by default not of dimensionless machines, "
        "nor, with a warning, where more than two states would be left"
    ))  # fmt: skip
    order: common.Order = 1
    trajectories: Composite[Trajectories] = composite(
        default=24, title="trajectories", description="starts of trajectories, or their number, from places that the seed gives"
    )
    seed: common.Whole = Field(default=0, ge=0, title="seed of their starts", description="seed of the starts of trajectories")
    nullclines: common.TrueOrFalse = Field(default=False, description="whether nullclines are drawn")
    along: common.Path | None = Field(default=None, description="path of a parameter, for a portrait for each of its `values`")
    values: Composite[common.Values] = composite(default=(), description="values of the parameter `along`, a portrait for each")
    show: Composite[TwoStates] = composite(default=(), title="states of the projection", description=(
        "two states on which a system of more than two is projected, by default the first two"
    ))  # fmt: skip
    length: SI[float] = si("", "length of a curve, in windows", default=40.0, gt=0, le=1000, help=(
        "length of a curve, in windows, at which it is stopped"
    ))  # fmt: skip

    def check(self) -> None:
        """Check that along and values come together, within their limits."""
        if bool(self.values) != (self.along is not None):
            missing = "values" if self.along is not None else "along"
            raise InputError(
                f"study.{missing}", None, "this key is missing; along = PATH and values = [...] belong together", code="missing"
            )
        if len(self.values) > MOST_PORTRAITS:
            raise InputError("study.values", len(self.values), f"there must be at most {MOST_PORTRAITS} portraits")
        many = self.trajectories if isinstance(self.trajectories, int) else len(self.trajectories)
        if many > MOST_TRAJECTORIES:
            raise InputError("study.trajectories", many, f"there must be at most {MOST_TRAJECTORIES}")

    def turning(self) -> str:
        """See ``Spec``."""
        return "" if self.speed is None else "the main rotor held at study.speed"
