"""The assembled parts of a machine with the numbers of its parameters, and the quantities derived from them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Any, Self

import numpy as np
import sympy as sp

from wucht.errors import InputError, nearest
from wucht.machines.limits import check_values
from wucht.machines.parts.base import Drive, Part
from wucht.machines.parts.track import Track
from wucht.machines.schedules import Schedule
from wucht.machines.structure import Structure, Units, canonical_structure
from wucht.machines.tree import Bodies
from wucht.mechanics.energies import Energies
from wucht.mechanics.lagrange import Coordinate
from wucht.mechanics.linear_carrier import LinearCarrier
from wucht.numerics.flow.program import number_function, variable_function
from wucht.schema import Parameter, Unit, read_quantity
from wucht.system import TIME, System


@dataclass(frozen=True, init=False, repr=False)
class Mechanism(Bodies):
    """A ``Machine`` without its constructor, as its operation, tracks and structure use it. See there for the fields."""

    title: str
    parameters: Mapping[str, Parameter]
    parts: tuple[Part, ...]
    units: Units
    schedules: tuple[Schedule, ...]
    start_angles: Mapping[str, float]
    start_positions: Mapping[str, float]
    tracks: tuple[Track, ...] = ()
    mismatch: sp.Expr | None = None
    warnings: tuple[str, ...] = ()
    notes: tuple[str, ...] = ()

    def with_fields(self, **new_fields: Any) -> Self:
        """Return the machine with other fields, such as ``title``; quantities that follow from them are derived anew.

        Raises ``InputError`` for a name that is no field: values of parameters are changed by ``with_values``.
        """
        old_fields = {f.name: getattr(self, f.name) for f in fields(self)}
        for name in new_fields.keys() - old_fields.keys():
            explanation = f"no field of a machine; values of parameters are changed by with_values; {nearest(name, old_fields)}"
            raise InputError(name, None, explanation)
        mechanism = object.__new__(type(self))
        mechanism.__dict__.update(old_fields | new_fields)
        return mechanism

    @cached_property
    def state_names(self) -> tuple[str, ...]:
        """Names of the System's states, in order: positions, then the free velocities, then the internal states of parts."""
        free = (c.velocity.name for c in self.coordinates if c.prescribed_velocity is None)
        return (*(c.position.name for c in self.coordinates), *free, *(x.state.name for x in self.internal))

    @property
    def dimensionless(self) -> bool:
        """True if times and lengths are numbers without units."""
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

    @property
    def nonlinear(self) -> str:
        """Name of the first part whose forces on the carrier are not linear; empty where there is none."""
        return next((e.nonlinear for e in self.energies if e.nonlinear), "")

    @cached_property
    def drives(self) -> tuple[Drive, ...]:
        """The machine's drives."""
        return tuple(p for p in self.parts if isinstance(p, Drive))

    @cached_property
    def free_labels(self) -> tuple[str, ...]:
        """Names of the free coordinates of the carrier."""
        return tuple(n for n, c in zip(self.labels, self.carrier, strict=True) if c.prescribed_velocity is None)

    @cached_property
    def shaking(self) -> tuple[sp.Symbol, sp.Symbol] | None:
        """Amplitude and angular frequency of the carrier's prescribed harmonic motion, None where it has none."""
        return next((s for p in self.parts if (s := p.shaking()) is not None), None)

    @property
    def shaking_frequency(self) -> float | None:
        """Its angular frequency at the parameter values."""
        return None if self.shaking is None else self.numbers[self.shaking[1]]

    @cached_property
    def breakpoints(self) -> tuple[float, ...]:
        """The times of the points of all schedules, in order, at least t = 0."""
        return tuple(sorted({0.0, *(t for s in self.schedules for t in s.pieces.breakpoints)}))

    def row(self, state: sp.Symbol) -> int:
        """Return the index of a position or a velocity in the state (n,). Raises ``ValueError`` for one that is not a state."""
        return self.state_names.index(state.name)

    def with_values(self, values: Mapping[str, float | str]) -> Self:
        """Return the machine with other values of some parameters; its structure and title stay.

        Parameters
        ----------
        values : mapping
            Numbers in SI or texts with a unit by path, one of ``parameters``: ``{"drum.eccentricity": "1.2 mm"}``.

        Returns
        -------
        Machine
            A new one: machines are not changed.

        Raises
        ------
        InputError
            Located at the path: for an unknown one, and for a value that the parts do not allow.

        Examples
        --------
        >>> from wucht import load_machine
        >>> machine = load_machine("drozdetskaya-2020/r1")
        >>> machine.with_values({"drive.slope": "0.04 N m s"}).values["drive.slope"]
        0.04
        """
        si_values = {}
        for path, value in values.items():
            if path not in self.parameters:
                raise InputError(path, value, f"unknown parameter; {nearest(path, self.parameters)}")
            si_values[path] = read_quantity(Unit(self.parameters[path].unit, self.parameters[path].long_name), value, path)
        self.check_values(si_values)
        machine = self.with_unchecked_values(si_values)
        return machine.with_fields(tracks=tuple(t.with_values(si_values) for t in self.tracks)) if self.tracks else machine

    def check_values(self, values: Mapping[str, float], location: str | Mapping[str, str] | None = None) -> None:
        """Raise ``InputError`` if the parts do not allow these values. location: of the error, or the locations by path."""
        check_values(self.parts, values, location, self.values)

    def with_unchecked_values(self, values: Mapping[str, float]) -> Self:
        """``with_values`` for values that are known to be allowed, such as those between the points of a schedule."""
        parameters = {path: replace(self.parameters[path], value=float(value)) for path, value in values.items()}
        return self.with_fields(parameters=dict(self.parameters) | parameters)

    def at(self, time: float) -> Self:
        """Return the machine with the values that its schedules give the parameters at a time."""
        if not self.schedules:
            return self
        return self.with_unchecked_values({s.parameter: float(s.pieces(time)) for s in self.schedules})

    def prescribed_speed(self, coordinate: Coordinate, time: np.ndarray | float) -> np.ndarray:
        """Return the prescribed velocity of a coordinate at times (N,), which may be a single one."""
        assert coordinate.prescribed_velocity is not None
        at = np.atleast_1d(np.asarray(time, float))
        value = self.function(coordinate.prescribed_velocity, of=TIME)(at)[0]
        return np.broadcast_to(np.asarray(value, float), at.shape)

    @cached_property
    def structure(self) -> Structure:
        """The part that does not depend on the numbers, shared by all machines that are alike but for these."""
        shared_fields = {f.name: getattr(self, f.name) for f in fields(Structure) if f.name != "parameter_paths"}
        return canonical_structure(Structure(**shared_fields, parameter_paths=tuple(self.parameters)))

    @property
    def system(self) -> System:
        """The equations of motion, with outputs and with the quadratures of the energy balance."""
        return self.structure.system

    @property
    def linear_carrier(self) -> LinearCarrier:
        """M, C, K of the free carrier and its coupling to the bodies, symbolic; see ``Structure``."""
        return self.structure.linear_carrier

    def evaluate(self, *expressions: sp.Expr) -> list[Any]:
        """Return expressions in the parameters at the machine's values, as floats or complex numbers; compiled once."""
        return number_function(expressions, self.structure.symbols)(self.values.values())

    def function(self, *expressions: sp.Expr, of: sp.Symbol, modules: str = "numpy") -> Callable[[Any], list[Any]]:
        """Return expressions in the parameters and one symbol as a function of that, at the machine's values; compiled once.

        modules: ``"numpy"`` for arrays, ``"math"`` for numbers.
        """
        numeric_function, values = (
            variable_function(expressions, self.structure.symbols, of, modules),
            tuple(self.values.values()),
        )
        return lambda at: numeric_function(values, at)

    @cached_property
    def matrices(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """M, C, K (m x m) of the free carrier at the parameter values."""
        c, size = self.linear_carrier, len(self.free_carrier)
        every = np.array(self.evaluate(*c.mass, *c.damping, *c.stiffness), float).reshape(3, size, size)
        return every[0], every[1], every[2]

    @cached_property
    def rest(self) -> np.ndarray:
        """Position of the carrier at rest under its load (m,): K x = load; zero where its motion is prescribed."""
        load = np.array(self.evaluate(*self.linear_carrier.load), float)
        free = iter(np.linalg.lstsq(self.matrices[2], load, rcond=None)[0] if load.any() else np.zeros(len(load)))
        return np.array([0.0 if q.prescribed_velocity is not None else float(next(free)) for q in self.carrier])

    @property
    def orbit_unit(self) -> str:
        """The unit of the amplitude."""
        return "rad" if self.labels == ("r",) else self.units.length
