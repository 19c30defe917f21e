"""Schedules: a parameter that changes over time, with exact breakpoints.

A parameter that changes carries energy in or out of the machine: masses are added and removed with the velocity of their
place, so the velocities do not jump, and the work of the schedule is the change of stored energy at the current state.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import InputError, nearest
from wucht.machines.limits import check_values, first_fault
from wucht.machines.parts.base import Part
from wucht.piecewise import Pieces, PiecewiseCubic, interpolated_pieces
from wucht.schema import Parameter, Unit, choice, is_pairs, read_quantity, refuse_unknown
from wucht.system import TIME, Output, System

SCHEDULE_WORK = "schedule_work"
_KEYS = ("parameter", "points", "interpolation", "voltage", "boost")
_INTERPOLATIONS = ("linear", "steps", "smooth")
_MOMENTS = (".locked", ".release.time", ".release.speed")


def proportional_voltage(name: str, frequency: Pieces, rated_point: tuple[float, float], boost: float) -> Pieces:
    """Return the voltage over time that belongs to a frequency over time.

    It rises in a straight line from ``boost`` at 0 Hz to the rated voltage at the rated frequency, which holds above it, where
    the field is weakened. rated_point: frequency in Hz and voltage in V. The corner is a breakpoint.
    """
    limit, full = rated_point
    slope = (full - boost) / limit
    places = sorted({*frequency.breakpoints, *_crossings(frequency, limit)})
    inside = [(0.5 * (a + b), a) for a, b in pairwise(places)]
    samples = [(places[0] - 1.0, places[0]), *inside, (places[-1] + 1.0, places[-1])]
    coefficients = []
    for within, origin in samples:
        piece = int(np.searchsorted(frequency.breakpoints, within, side="right"))
        cubic = _cubic_about(frequency, piece, origin)
        below = frequency(within) < limit
        coefficients.append((boost + slope * cubic[0], *(slope * c for c in cubic[1:])) if below else (full, 0.0, 0.0, 0.0))
    return Pieces(name, places, coefficients)


def _cubic_about(pieces: Pieces, piece: int, origin: float) -> tuple[float, float, float, float]:
    """Return the cubic of a piece as a polynomial in the distance from another origin."""
    c0, c1, c2, c3 = pieces.coefficients[piece]
    s = origin - pieces.origins[piece]
    return c0 + s * (c1 + s * (c2 + s * c3)), c1 + s * (2 * c2 + 3 * s * c3), c2 + 3 * s * c3, c3


def _crossings(pieces: Pieces, limit: float) -> list[float]:
    """Return the times at which the function passes a limit between its breakpoints."""
    crossings = []
    for k, (low, high) in enumerate(pairwise(pieces.breakpoints), 1):
        c0, c1, c2, c3 = pieces.coefficients[k]
        roots = np.polynomial.Polynomial([c0 - limit, c1, c2, c3]).trim().roots()
        real = low + roots[np.abs(roots.imag) < 1e-12].real
        margin = 1e-9 * (high - low)  # closer to a breakpoint it is that one
        crossings += real[(real > low + margin) & (real < high - margin)].tolist()
    return crossings


@dataclass(frozen=True)
class Schedule:
    """A parameter over time. pieces: its value as a function of time, constant before the first point and after the last."""

    parameter: str
    pieces: Pieces

    @property
    def symbol(self) -> sp.Symbol:
        """The parameter's symbol."""
        return sp.Symbol(self.parameter, real=True)

    @property
    def expression(self) -> sp.Expr:
        """The value over time."""
        return PiecewiseCubic(TIME, self.pieces)

    def holds_since(self, time: float) -> float:
        """Return the time of the first or last point at a time outside of the points; between them the time itself."""
        return min(max(time, self.pieces.breakpoints[0]), self.pieces.breakpoints[-1])


def schedules_of(tables: Any, parameters: Mapping[str, Parameter], parts: Sequence[Part], time: str) -> tuple[Schedule, ...]:
    """Return the schedules of tables with the keys ``parameter``, ``points``, ``interpolation``, or of another machine.

    With ``voltage = "proportional"``, and a ``boost``, a motor's voltage follows its frequency: two schedules from one table.

    Interpolations: see ``piecewise.interpolated``; ``"smooth"`` is the cubic 3 s^2 - 2 s^3 from value to value. time: the unit
    of time. Raises ``InputError``, located from ``schedules`` on, also for values that the parts do not allow.
    """
    if not isinstance(tables, list | tuple) or not all(isinstance(t, Mapping | Schedule) for t in tables):
        raise InputError("schedules", tables, "must be tables: [[machine.schedules]]")
    schedules: dict[str, Schedule] = {}
    table_of: dict[str, int] = {}
    for i, table in enumerate(tables):
        is_schedule = isinstance(table, Schedule)
        for schedule in (table,) if is_schedule else _schedules(table, parameters, time, f"schedules[{i}]"):
            if schedule.parameter in schedules:
                raise InputError(f"schedules[{i}].parameter", schedule.parameter, "this parameter has a schedule already")
            schedules[schedule.parameter], table_of[schedule.parameter] = schedule, i
    times = np.unique(np.concatenate([[], *(s.pieces.breakpoints for s in schedules.values())]))
    values = {path: s.pieces(times) for path, s in schedules.items()}
    if (k := first_fault(parts, values)) is not None:
        places = {
            path: f"schedules[{i}].points (t = {schedules[path].holds_since(times[k]):g})" for path, i in table_of.items()
        }
        check_values(parts, {path: float(v[k]) for path, v in values.items()}, places)
    return tuple(schedules.values())


def _schedules(table: Mapping[str, Any], parameters: Mapping[str, Parameter], time: str, location: str) -> tuple[Schedule, ...]:
    """Return the schedule of a table, and that of the voltage which follows the frequency of a motor."""
    frequency = _schedule(table, parameters, time, location)
    if "voltage" not in table:
        if "boost" in table:
            raise InputError(
                f"{location}.boost", table["boost"], 'allowed only with voltage = "proportional"', code="not-allowed"
            )
        return (frequency,)
    choice(table, "voltage", location, ("proportional",))
    drive, _, key = frequency.parameter.rpartition(".")
    voltage, rated_key = f"{drive}.voltage", f"{drive}.rated_frequency"
    if key != "frequency" or voltage not in parameters or rated_key not in parameters:
        requirement = (
            "allowed only for the frequency of a motor that has a voltage and a rated_frequency, such as an induction motor"
        )
        raise InputError(f"{location}.voltage", table["voltage"], requirement)
    full = parameters[voltage].value
    boost = read_quantity(Unit("V", "boost, the voltage at 0 Hz"), table.get("boost", 0.0), f"{location}.boost")
    if not 0 <= boost <= full:
        raise InputError(
            f"{location}.boost", table["boost"], f"must be a voltage of a phase from 0 to {full:.6g} V", code="limits"
        )
    pieces = proportional_voltage(voltage, frequency.pieces, (parameters[rated_key].value, full), boost)
    return frequency, Schedule(voltage, pieces)


def _schedule(table: Mapping[str, Any], parameters: Mapping[str, Parameter], time: str, location: str) -> Schedule:
    refuse_unknown(table, _KEYS, location)
    path = table.get("parameter")
    at = f"{location}.parameter"
    if not isinstance(path, str) or path not in parameters:
        raise InputError(
            at, path, f"must be a parameter of the machine; {nearest(str(path), parameters)}", code="unknown-parameter"
        )
    if path.endswith(_MOMENTS) or (path.startswith(("drive.", "drives.")) and path.endswith(".angle")):
        raise InputError(
            at, path, "not allowed: this parameter applies at one moment, and does not change over time", code="one-moment"
        )
    if ".bearing." in path:
        raise InputError(at, path, "not allowed: the rating of a bearing does not change over time", code="rating")
    if path.startswith("carrier.motion."):
        sentence = "not allowed: the phase of a prescribed motion would drift; give it as a table of displacements over time"
        raise InputError(at, path, sentence, code="prescribed")
    points = table.get("points")
    if not points or not is_pairs(points):
        sentence = 'must be a list of pairs [time, value], such as [["0 s", 0], ["5 s", 1]]'
        raise InputError(f"{location}.points", points, sentence, code="pairs")
    units = (Unit(time, "time"), Unit(parameters[path].unit, parameters[path].long_name))
    numbers = [
        [read_quantity(u, x, f"{location}.points[{k}][{j}]") for j, (u, x) in enumerate(zip(units, point, strict=True))]
        for k, point in enumerate(points)
    ]
    times, values = zip(*numbers, strict=True)
    if any(b <= a for a, b in pairwise(times)):
        raise InputError(f"{location}.points", points, "must be points whose times increase", code="not-increasing")
    kind = choice({"interpolation": "linear"} | dict(table), "interpolation", location, _INTERPOLATIONS)
    return Schedule(path, interpolated_pieces(path, times, values, kind))


def with_schedules(system: System, schedules: Sequence[Schedule], stored_energy: sp.Expr, unit: str) -> System:
    """Return the System with scheduled parameters as functions of time, and their work as quadrature ``schedule_work``."""
    if not schedules:
        return system
    rates = [sp.diff(stored_energy, s.symbol) * sp.diff(s.expression, TIME) for s in schedules]
    work = Output(SCHEDULE_WORK, sp.Add(*rates), unit, "work of the schedules", jump=stored_energy)
    symbols = {s.symbol for s in schedules}
    parameters = tuple(p for p in system.parameters if p not in symbols)
    definitions = (*((s.symbol, s.expression) for s in schedules), *system.definitions)
    return replace(system, parameters=parameters, definitions=definitions, quadratures=(*system.quadratures, work))
