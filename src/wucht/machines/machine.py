"""``Machine``: parts put together. From their energies everything else follows."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import sympy as sp

from wucht.checking import read_quantity
from wucht.errors import InputError, nearest
from wucht.fields import Parameter
from wucht.machines.assembly import assembled, with_tracks
from wucht.machines.display import as_table, in_words
from wucht.machines.limits import check_values
from wucht.machines.models import Model
from wucht.machines.parts.base import Body, Drive, Frame, Load, Part
from wucht.machines.parts.support import Support
from wucht.machines.parts.track import Track
from wucht.machines.schedules import Schedule
from wucht.machines.structure import LOST, MISMATCH, SUPPLIED, Structure, shared
from wucht.machines.tree import Bodies, RotatingBody, SlidingBody
from wucht.machines.unit_names import Units
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.linear_carrier import LinearCarrier
from wucht.numerics.flow.program import compiled_function, number_function
from wucht.quantities import Unit
from wucht.system import TIME, System

__all__ = ["LOST", "MISMATCH", "SUPPLIED", "Machine"]


@dataclass(frozen=True, init=False, repr=False)
class Machine(Bodies):
    """A machine: parts put together, their energies in named coordinates, with parameter values.

    Machines of one structure have equal ``system``s, whatever their values.

    Parameters
    ----------
    carrier
        What bears the bodies, such as ``parts.Carrier``; or a dimensionless machine, such as ``parts.LavalRotor``, alone.
    bodies, drives, loads
        The other parts. Quantities are numbers in SI or strings with a unit. A drive or load acts ``on`` the only rotor if it
        does not say otherwise; a body has one drive, and one load of each kind.
    schedules
        Tables ``{"parameter": PATH, "points": [[time, value], ...], "interpolation": "linear" | "steps" | "smooth"}``.
    tracks
        Tables ``{"contact_frequency": ...}`` by the name of a track that bodies share.
    title
        What the machine is called in results.
    where
        Places that errors name instead of the paths of parts, by path: a file's own.

    Attributes
    ----------
    carrier, labels
        The carrier's coordinates, and what they are called (x, y, r, foundation).
    bodies, sliders
        The bodies that turn, and those in guides, in the order given.
    parameters, values
        Its numbers by path (``p1.damping``): with unit, symbol and name; in SI alone.
    frame, energies, mismatch
        Where the bodies' axes are, and gravity; the parts' formulas: the carrier's first, those of contacts last; the power by
        which dampers that are not reciprocal violate action = reaction, or None.
    start_angles, start_positions
        At t = 0, in rad by body and in m (rad) by label, of what has a prescribed motion.
    warnings
        What runs but is doubtful.

    Raises
    ------
    InputError
        Where the parts do not fit together: the place, what was given and what is allowed.

    Examples
    --------
    >>> from wucht import Machine, parts
    >>> drum = parts.Rotor(name="drum", mass="9 kg", eccentricity="1 mm", inertia="0.03 kg m^2")
    >>> ball = parts.Pendulum(name="ball", about="drum", mass="125 g", length="104 mm", damping="0.17 N m s")
    >>> motor = parts.LinearDrive(slope="0.04 N m s", no_load_speed="200 rad/s")
    >>> Machine(parts.Carrier(mass="1 kg", stiffness="1e5 N/m"), [drum, ball], [motor], title="A drum")
    <Machine 'A drum'
     rotor drum, pendulum ball; drive linear on drum; 13 parameters>
    """

    title: str
    carrier: tuple[Coordinate, ...]
    bodies: tuple[RotatingBody, ...]
    energies: tuple[Energies, ...]
    parameters: Mapping[str, Parameter]
    parts: tuple[Part, ...]
    units: Units
    labels: tuple[str, ...]
    frame: Frame
    schedules: tuple[Schedule, ...]
    start_angles: Mapping[str, float]
    start_positions: Mapping[str, float]
    sliders: tuple[SlidingBody, ...] = ()
    tracks: tuple[Track, ...] = ()
    mismatch: sp.Expr | None = None
    warnings: tuple[str, ...] = ()

    def __init__(
        self,
        carrier: Support | Model,
        bodies: Sequence[Body] = (),
        drives: Sequence[Drive] = (),
        loads: Sequence[Load] = (),
        *,
        schedules: Sequence[Mapping[str, Any]] = (),
        tracks: Mapping[str, Mapping[str, Any]] | None = None,
        title: str = "",
        where: Mapping[str, str] | None = None,
    ) -> None:
        given, at = {} if tracks is None else tracks, where or {}
        # A frozen class sets its fields past its own lock.
        self.__dict__.update(assembled(carrier, bodies, drives, loads, schedules, given, title, at))
        self.__dict__.update(vars(with_tracks(self.changed().at(0.0), given, at)))

    def changed(self, **given: Any) -> Self:
        """The machine with other fields, such as ``energies``; what follows from them is derived anew."""
        own = {f.name: getattr(self, f.name) for f in fields(self)}
        assert given.keys() <= own.keys(), f"no field of a machine: {given.keys() - own.keys()}"
        made = object.__new__(type(self))
        made.__dict__.update(own | given)
        return made

    def __repr__(self) -> str:
        return in_words(self.title, (*self.bodies, *self.sliders), self.drives, self.parameters)

    def _repr_html_(self) -> str:
        return as_table(self.title, (*self.bodies, *self.sliders), self.drives, self.parameters)

    @cached_property
    def coordinates(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates, then the bodies' angles, then the sliders' displacements."""
        return (*self.carrier, *(b.coordinate for b in self.bodies), *(s.coordinate for s in self.sliders))

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """The names of the System's states, in order: positions, then the velocities that are free."""
        free = (c.velocity.name for c in self.coordinates if c.prescribed is None)
        return (*(c.position.name for c in self.coordinates), *free)

    @property
    def dimensionless(self) -> bool:
        """Whether times and lengths are numbers."""
        return not self.units.time

    @property
    def without_contacts(self) -> tuple[Energies, ...]:
        """The energies of the parts: those of contacts are the last."""
        return self.energies[: len(self.energies) - len(self.tracks)]

    @cached_property
    def values(self) -> dict[str, float]:
        """Parameter values by path."""
        return {path: p.value for path, p in self.parameters.items()}

    @cached_property
    def numbers(self) -> dict[sp.Symbol, float]:
        """Parameter values by symbol, to be put into expressions."""
        return {sp.Symbol(path, real=True): value for path, value in self.values.items()}

    @cached_property
    def drives(self) -> tuple[Drive, ...]:
        """The machine's drives."""
        return tuple(p for p in self.parts if isinstance(p, Drive))

    @cached_property
    def free_carrier(self) -> tuple[Coordinate, ...]:
        """The carrier's coordinates without those whose motion is prescribed."""
        return tuple(c for c in self.carrier if c.prescribed is None)

    @cached_property
    def free_labels(self) -> tuple[str, ...]:
        """What the free coordinates of the carrier are called."""
        return tuple(n for n, c in zip(self.labels, self.carrier, strict=True) if c.prescribed is None)

    @cached_property
    def shaken(self) -> Coordinate | None:
        """The carrier's coordinate whose motion is prescribed, if one is."""
        return next((c for c in self.carrier if c.prescribed is not None), None)

    @cached_property
    def shaking(self) -> tuple[sp.Symbol, sp.Symbol] | None:
        """Amplitude and angular frequency of the carrier's prescribed harmonic motion, None where it has none."""
        return next((s for p in self.parts if (s := p.shaking()) is not None), None)

    @property
    def shaking_frequency(self) -> float | None:
        """Its angular frequency at the parameter values."""
        return None if self.shaking is None else self.numbers[self.shaking[1]]

    @cached_property
    def turning(self) -> Coordinate | None:
        """The carrier's turning about the normal of the plane, with which a locked rotor turns; None where it does not turn."""
        return next((c for c in self.carrier if c.velocity == self.frame.rotation), None)

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        """The times of the points of all schedules, in order, at least t = 0."""
        return tuple(sorted({0.0, *(t for s in self.schedules for t in s.pieces.breakpoints)}))

    def row(self, state: sp.Symbol) -> int:
        """Where a position or a velocity stands in the state (n,). Raises ``ValueError`` for one that is no state."""
        return self.state_names.index(state.name)

    def with_values(self, values: Mapping[str, float]) -> Self:
        """The machine with other values of some parameters, by path, in SI or as text with a unit; its structure stays.

        Raises ``InputError``, located at the path, for an unknown one and for a value that the parts do not allow.
        """
        given = {path: self._read(path, value) for path, value in values.items()}
        check_values(self.parts, given, present=self.values)
        return self.with_unchecked(given)

    def _read(self, path: str, value: float) -> float:
        if path not in self.parameters:
            raise InputError(path, value, f"unknown parameter; {nearest(path, self.parameters)}")
        return read_quantity(Unit(self.parameters[path].unit, self.parameters[path].what), value, path)

    def with_unchecked(self, values: Mapping[str, float]) -> Self:
        """``with_values`` for values that are known to be allowed, such as those between the points of a schedule."""
        changed = {path: replace(self.parameters[path], value=float(value)) for path, value in values.items()}
        return self.changed(parameters=dict(self.parameters) | changed)

    def at(self, time: float) -> Self:
        """The machine with the values that its schedules give the parameters at a time."""
        if not self.schedules:
            return self
        return self.with_unchecked({s.parameter: float(s.pieces(time)) for s in self.schedules})

    def prescribed_speed(self, coordinate: Coordinate, time: np.ndarray | float) -> np.ndarray:
        """The prescribed velocity of a coordinate at times (N,), which may be a single one."""
        assert coordinate.prescribed is not None
        at = np.atleast_1d(np.asarray(time, float))
        value = self.function(coordinate.prescribed, of=TIME)(at)[0]
        return np.broadcast_to(np.asarray(value, float), at.shape)

    @cached_property
    def structure(self) -> Structure:
        """What does not depend on the numbers, shared by all machines that are alike but for these."""
        return shared(
            Structure(
                self.carrier, self.labels, self.bodies, self.sliders, self.energies, tuple(self.parameters), self.units,
                self.turning, self.frame.axes.get(self.rotor.name), tuple(len(self.tree.path(b.name)) for b in self.bodies),
                self.schedules, self.mismatch,
            )
        )  # fmt: skip

    @property
    def system(self) -> System:
        """The equations of motion, with outputs and with the quadratures of the energy balance."""
        return self.structure.system

    @property
    def linear_carrier(self) -> LinearCarrier:
        """M, C, K of the free carrier and its coupling to the bodies, symbolic; sliders in the middle of their guides."""
        return self.structure.linear_carrier

    @property
    def orbit(self) -> dict[str, tuple[sp.Expr, sp.Expr]]:
        """The motion whose amplitude is looked at: x, y of the main rotor's axis, or the angle of a carrier that only turns."""
        return self.structure.orbit

    def evaluate(self, *expressions: sp.Expr) -> list[Any]:
        """Expressions in the parameters at the machine's values, as floats or complex numbers; compiled once."""
        return number_function(expressions, self.structure.symbols)(self.values.values())

    def function(self, *expressions: sp.Expr, of: sp.Symbol, modules: str = "numpy") -> Callable[[Any], list[Any]]:
        """Expressions in the parameters and one symbol as a function of that, at the machine's values; compiled once.

        modules: ``"numpy"`` for arrays, ``"math"`` for numbers.
        """
        compiled, values = compiled_function(expressions, self.structure.symbols, of, modules), tuple(self.values.values())
        return lambda at: compiled(values, at)

    @cached_property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, C, K (m x m) of the free carrier at the parameter values."""
        c, size = self.linear_carrier, len(self.free_carrier)
        every = np.array(self.evaluate(*c.mass, *c.damping, *c.stiffness), float).reshape(3, size, size)
        return every[0], every[1], every[2]

    @property
    def orbit_unit(self) -> str:
        """The unit of the amplitude."""
        return "rad" if self.labels == ("r",) else self.units.length
