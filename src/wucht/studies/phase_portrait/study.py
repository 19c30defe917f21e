"""The question of a phase portrait, of two equations or of more that are projected on two states."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from functools import partial
from typing import TYPE_CHECKING, Annotated, Any

import numpy as np
from pydantic import BeforeValidator, Field

from wucht.analysis.planar_portraits import (
    PlanarPortrait,
    common_window,
    drawn_ranges,
    planar_section,
    spread_starts,
    system_axes,
)
from wucht.analysis.sections import Axis, Section
from wucht.dynamics.parameters import parameter_of, values_of
from wucht.dynamics.system_states import refuse_machine_keys, state_range, state_row, states_from
from wucht.dynamics.work import Work
from wucht.errors import InputError, WuchtError
from wucht.machines.machine import Machine
from wucht.machines.subject import Subject
from wucht.numerics.continuation.deflation import random_starts
from wucht.numerics.phase_plane.plane import TURN, Plane
from wucht.schema import SI, Composite, Unit, composite, read_quantity, refuse_unknown, si
from wucht.studies.answer import Answer
from wucht.studies.key_types import Inertia, Order, Path, TrueOrFalse, Value, Values, Whole
from wucht.studies.phase_portrait.answer import PortraitOf, state_portraits
from wucht.studies.phase_portrait.figure import figure
from wucht.studies.phase_portrait.state_projection import StateProjection, project_states
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.figure import Figure

MOST_PORTRAITS, MOST_TRAJECTORIES = 60, 400
_KEYS_OF_MACHINES, _KEYS_OF_THE_PLANE = ("together", "speed", "inertia", "order"), ("along", "values", "nullclines", "length")
_NARROWEST = 1e-6  # of a range: below, differences vanish in rounding

# The value of ``along``, the plane, and of a machine the section, for each portrait; the two states; their ranges (2, 2) in the
# figure; and the given starts of trajectories (2, k), None where the program chooses them.
Planar = tuple[list[tuple[float | None, Plane, Section | None]], tuple[Axis, ...], np.ndarray, np.ndarray | None]


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
Ranges = Annotated[dict[str, tuple[Value, Value]], BeforeValidator(_table)]
Together = Annotated[bool | tuple[str, ...], BeforeValidator(_together)]
Trajectories = Annotated[int | tuple[dict[str, Any], ...], BeforeValidator(_trajectories)]


class PhasePortrait(Study):
    """All fixed points of two equations with their kinds, the separatrices of the saddles with their ends, closed curves.

    For a table [system] of two states, or for the averaged equations of a machine, reduced to two states by bodies
    that keep equal phases. A table [system] of more states is projected on two.
    """

    kind = "phase-portrait"
    subject = "wucht.studies.subjects:MACHINE_OR_SYSTEM"
    meaning = (*Study.meaning, "show")

    ranges: Composite[Ranges] = composite(default_factory=dict, title="ranges of the states", description=(
        "ranges of the states, by name: the window; of an angle its range in the figure"
    ))  # fmt: skip
    together: Composite[Together | None] = composite(default=None, title="bodies that keep equal phases", description=(
        "true or names of bodies: they keep equal phases (Drozdetskaya (5.17)-(5.18): true); refused where they would not"
    ))  # fmt: skip
    speed: SI[float | None] = si("rad/s", "speed", default=None, help="speed at which the main rotor is held")
    inertia: Inertia | None = Field(default=None, description=(
        "whether the averaged equations keep the inertia of the balancing bodies, by default not of dimensionless machines, "
        "nor, with a warning, where more than two states would be left"
    ))  # fmt: skip
    order: Order = 1
    trajectories: Composite[Trajectories] = composite(
        default=24, title="trajectories", description="starts of trajectories, or their number, from places that the seed gives"
    )
    seed: Whole = Field(default=0, ge=0, title="seed of their starts", description="seed of the starts of trajectories")
    nullclines: TrueOrFalse = Field(default=False, description="whether nullclines are drawn")
    along: Path | None = Field(default=None, description="path of a parameter, for a portrait for each of its `values`")
    values: Composite[Values] = composite(default=(), description="values of the parameter `along`, a portrait for each")
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
        """See ``Study``."""
        return "" if self.speed is None else "the main rotor held at study.speed"

    def prepare(self, subject: Subject) -> Planar | StateProjection:
        """Return the portraits. Raises ``InputError`` where the subject has no two states, or a key does not fit it."""
        is_machine = isinstance(subject, Machine)
        if not is_machine and len(subject.system.states) > 2:
            return self._projection(subject)
        if self.show:
            raise InputError("study.show", list(self.show), "allowed for a table [system] of more than two states only")
        if not is_machine:
            refuse_machine_keys(self, _KEYS_OF_MACHINES, "allowed only for a machine: [system] states its two states")
        values: tuple[float | None, ...] = (None,)
        if self.along is not None:
            values = tuple(dict.fromkeys(values_of(subject, parameter_of(subject, self.along), self.values)))
        subjects = [subject if v is None else subject.with_values({self.along or "": v}) for v in values]
        sections = [self._section(s) if isinstance(s, Machine) else None for s in subjects]
        systems = [(s.system, s.values) for s in (section or one for section, one in zip(sections, subjects, strict=True))]
        first = sections[0]
        axes = first.axes if first is not None else system_axes(systems[0][0])
        ranges = self._read_ranges(axes)
        try:
            low, high = common_window(systems, axes, ranges)
            planes = [Plane(system, numbers, low, high) for system, numbers in systems]
        except InputError:
            raise
        except WuchtError as error:
            raise InputError("system" if first is None else "machine", None, str(error)) from None
        cases = list(zip(values, planes, sections, strict=True))
        return cases, axes, drawn_ranges(planes[0], axes, ranges), self._starts(planes[0], axes)

    def _projection(self, subject: Subject) -> StateProjection:
        """Return the projection. Raises ``InputError`` where a key does not fit, or a range is missing."""
        refuse_machine_keys(self, _KEYS_OF_MACHINES)
        refuse_machine_keys(self, _KEYS_OF_THE_PLANE, "allowed for two states only, not for a projection of more")
        system, names = subject.system, subject.system.state_names
        for name in (*self.ranges, *self.show):
            state_row(system, name, "study.ranges" if name in self.ranges else "study.show")
        pairs = {s.name: (0.0, TURN) for s in system.angles} | {
            n: state_range(n, pair, f"study.ranges.{n}") for n, pair in self.ranges.items()
        }
        for name in names:
            if name not in pairs:
                raise InputError(f"study.ranges.{name}", None, "this key is missing; give a pair [low, high]", code="missing")
        low, high = np.array([pairs[n] for n in names]).T
        shown_names = self.show or names[:2]
        if isinstance(self.trajectories, int):
            starts = random_starts(low, high, self.trajectories, self.seed) if self.trajectories else np.empty((len(names), 0))
        else:
            states = [states_from(system, start, f"study.trajectories[{k}]") for k, start in enumerate(self.trajectories)]
            starts = np.array(states).reshape(-1, len(names)).T
        return StateProjection((names.index(shown_names[0]), names.index(shown_names[1])), low, high, starts)

    def _section(self, machine: Machine) -> Section:
        return planar_section(machine, self.together, self.speed, self.inertia, self.order, self.kind)

    def _read_ranges(self, axes: tuple[Axis, ...]) -> dict[str, tuple[float, float]]:
        refuse_unknown(self.ranges, [a.name for a in axes], "study.ranges")
        ranges = {}
        for a in axes:
            if a.name in self.ranges:
                key = f"study.ranges.{a.name}"
                pair = self.ranges[a.name]
                low, high = (read_quantity(Unit(a.unit, a.long_name), v, key) for v in pair)
                if not low < high:
                    raise InputError(key, list(pair), "must be a pair [low, high] with low below high")
                if high - low < _NARROWEST * max(abs(low), abs(high)):
                    raise InputError(key, list(pair), "must be a pair [low, high] farther apart than rounding")
                ranges[a.name] = low, high
        return ranges

    def _starts(self, plane: Plane, axes: tuple[Axis, ...]) -> np.ndarray | None:
        """Return the given starts (2, k). Raises ``InputError`` for an unknown state, or one outside the window."""
        if isinstance(self.trajectories, int):
            return None
        starts = np.empty((2, len(self.trajectories)))
        for k, start in enumerate(self.trajectories):
            key = f"study.trajectories[{k}]"
            refuse_unknown(start, [a.name for a in axes], key)
            for i, a in enumerate(axes):
                if a.name not in start:
                    raise InputError(f"{key}.{a.name}", None, f"this key is missing; give the {a.long_name}", code="missing")
                starts[i, k] = read_quantity(Unit(a.unit, a.long_name), start[a.name], f"{key}.{a.name}")
                if not plane.turns[i] and not plane.low[i] <= starts[i, k] <= plane.high[i]:
                    requirement = f"must be within the range of {a.name}, {plane.low[i]:g} to {plane.high[i]:g}"
                    raise InputError(f"{key}.{a.name}", start[a.name], requirement)
        return starts

    def solve(self, subject: Subject, prepared: Planar | StateProjection, work: Work) -> Iterator[Answer]:
        """Compute one portrait after the other; of a projection one trajectory after the other."""
        if isinstance(prepared, StateProjection):
            yield from project_states(subject, prepared, work)
            return
        cases, axes, ranges, starts = prepared
        fill = partial(state_portraits, subject, self.along, axes, ranges, self.nullclines, self.length, len(cases))
        portraits = list[PortraitOf]()
        for k, (value, plane, section) in enumerate(cases):
            label = "" if value is None else f"{self.along} = {value:.6g}"
            part = work.part(f"portrait {k + 1}", k / len(cases), (k + 1) / len(cases))
            portrait = part.unit("curves", partial(self._portrait, plane, section, starts, label, part))
            portraits.append((label, value, plane, section, portrait))
            yield Answer(subject.units, partial(fill, tuple(portraits)))

    def _portrait(
        self, plane: Plane, section: Section | None, starts: np.ndarray | None, label: str, work: Work
    ) -> PlanarPortrait:
        work.report(0.0, f"fixed points {label}".strip())
        if starts is None:
            starts = spread_starts(plane, self.seed, self.trajectories if isinstance(self.trajectories, int) else 0)
        return PlanarPortrait.of(plane, section, starts, self.seed, self.length, work.report)

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw a panel for each portrait, or the projection."""
        return figure(result)
