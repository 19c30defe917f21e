"""User equations: the table ``[system]`` of a study file -> a System with values of its parameters."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import InputError, WuchtError, nearest
from wucht.files.documents import Document, flatten, settings_in
from wucht.files.formulas import CONSTANTS, FUNCTIONS, formula
from wucht.machines.schedules import Schedule
from wucht.machines.structure import DIMENSIONLESS, Units
from wucht.numerics.flow.program import Evaluator
from wucht.schema import Parameter, Unit, read_quantity, refuse_unknown, require_table, text
from wucht.system import TIME, System

KEYS = ("title", "use", "set", "states", "angles", "parameters", "definitions")
_LONGEST_NAME = 64
_PLACES, _SAME = 32, 1e-8  # points at which equations are evaluated, and a turn further; tolerance between both


@dataclass(frozen=True)
class UserSystem:
    """Ordinary differential equations with values of their parameters: the subject of a study instead of a machine.

    Parameters
    ----------
    system : System
    values : mapping of str to float
        Values of all its parameters, by name, in the order in which they are printed.
    title : str

    Raises
    ------
    WuchtError
        For a parameter without a value, and a value without a parameter.
    """

    system: System
    values: Mapping[str, float] = field(default_factory=dict)
    title: str = ""

    @classmethod
    def from_formulas(
        cls,
        states: Mapping[str, str],
        parameters: Mapping[str, float] | None = None,
        *,
        definitions: Mapping[str, str] | None = None,
        angles: Sequence[str] = (),
        title: str = "",
    ) -> UserSystem:
        """Build the equations from formulas, as a table ``[system]`` of a study file gives them.

        Parameters
        ----------
        states : mapping of str to str
            The derivative of each state over the time ``t``.
        parameters : mapping of str to float, optional
        definitions : mapping of str to str, optional
            In order; used by states and by definitions after them.
        angles : sequence of str
            States that are periodic with 2 pi.
        title : str

        Raises
        ------
        InputError
            For a formula that cannot be read, or a name that is used twice or by formulas.

        Examples
        --------
        >>> import wucht
        >>> oscillator = wucht.UserSystem.from_formulas({"x": "v", "v": "-x - 2*d*v"}, {"d": 0.1})
        >>> wucht.run(wucht.RunUp(start={"x": 1.0}), oscillator).wucht.summary["outcome"]
        'equilibrium'
        """
        description = {"states": dict(states), "parameters": dict(parameters or {}), "definitions": dict(definitions or {})}
        return equations_from(description | {"angles": list(angles)}, title)

    @classmethod
    def from_function(
        cls,
        function: Callable[..., Any],
        states: Sequence[str],
        parameters: Mapping[str, float] | None = None,
        *,
        angles: Sequence[str] = (),
        title: str = "",
    ) -> UserSystem:
        """Write a Python function f(t, x, p) as formulas, see ``System.from_function``, with values of its parameters.

        Parameters
        ----------
        function, states, angles
            As there.
        parameters : mapping of str to float, optional
        title : str

        Raises
        ------
        InputError
            For a value that is no number, and a state in ``angles`` whose rates change by a whole turn.
        WuchtError
            As there, which tells of warnings too.

        Examples
        --------
        >>> import numpy as np, wucht
        >>> damped = wucht.UserSystem.from_function(lambda t, x, p: [x[1], -x[0] - 2 * p[0] * x[1]], ["x", "v"], {"d": 0.1})
        >>> wucht.run(wucht.RunUp(start={"x": 1.0}), damped).wucht.summary["outcome"]
        'equilibrium'
        """
        numbers = {n: _parameter_value(n, v, f"parameters.{n}") for n, v in (parameters or {}).items()}
        system = System.from_function(function, states, numbers, angles=angles)
        _refuse_other_periods(system, numbers)
        return cls(system, numbers, title)

    def __post_init__(self) -> None:
        self.system.values(self.values)
        if unknown := [name for name in self.values if name not in self.system.parameter_names]:
            raise WuchtError(
                f"{unknown[0]} is not a parameter of these equations; {nearest(unknown[0], self.system.parameter_names)}",
                code="unknown-parameter",
            )

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """The parameters by name, each with value and unit, as those of a machine."""
        return {name: Parameter(name, float(value), "", name, f"parameter {name}") for name, value in self.values.items()}

    @property
    def units(self) -> Units:
        """No units."""
        return DIMENSIONLESS

    @property
    def schedules(self) -> tuple[Schedule, ...]:
        """No schedules: what changes over time is in the equations."""
        return ()

    def with_values(self, values: Mapping[str, float]) -> UserSystem:
        """The same equations with other values of some parameters. Raises ``WuchtError`` for one that they do not have."""
        numbers = {name: _parameter_value(name, value, name) for name, value in values.items()}
        return UserSystem(self.system, {**self.values, **numbers}, self.title)

    def check_values(self, values: Mapping[str, float], location: str | Mapping[str, str] | None = None) -> None:
        """All values are allowed."""


def equations_from(document: Document, title: str = "") -> UserSystem:
    """The equations described by a table ``[system]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``system`` on.
    """
    description = dict(document)
    settings = settings_in(description, "system")
    refuse_unknown(description, KEYS, "system")
    title = text(description, "title", "system") or title
    description.setdefault("parameters", {})
    values = with_values(description, settings)["parameters"]
    states = require_table(description, "states", "system.states")
    definitions = require_table({"definitions": {}} | description, "definitions", "system.definitions")
    if not states:
        raise InputError("system.states", None, 'must be a table of derivatives, such as { x = "mu*x - x^3", y = "-y" }')
    kinds_by_name: dict[str, str] = {}
    for kind, names in (("state", states), ("parameter", values), ("definition", definitions)):
        for name in names:
            _check_name(name, kind, kinds_by_name)
    symbols = {name: sp.Symbol(name, real=True) for name in kinds_by_name}
    constant, known_symbols = (
        frozenset(symbols[name] for name in values),
        {n: symbols[n] for n in (*states, *values)} | {"t": TIME},
    )
    meanings: list[tuple[sp.Symbol, sp.Expr]] = []
    for name, formula_text in definitions.items():
        location = f"system.definitions.{name}"
        later = [n for n in definitions if n not in known_symbols]
        meanings.append((symbols[name], _read_definition(formula_text, known_symbols, location, constant, later)))
        known_symbols[name] = symbols[name]
    rates = [formula(formula_text, known_symbols, f"system.states.{name}", constant) for name, formula_text in states.items()]
    turning = frozenset(symbols[name] for name in _angles(description, states))
    numbers = {n: _parameter_value(n, v, f"system.parameters.{n}") for n, v in values.items()}
    system = System(
        tuple(symbols[n] for n in states), tuple(rates), tuple(symbols[n] for n in values), tuple(meanings), angles=turning
    )
    _refuse_other_periods(system, numbers)
    return UserSystem(system, numbers, title)


def _parameter_value(name: str, value: Any, location: str) -> float:
    return read_quantity(Unit("", f"value of the parameter {name}"), value, location)


def _refuse_other_periods(system: System, numbers: Mapping[str, float]) -> None:
    """Raises ``InputError`` for an angle whose rates change by a whole turn."""
    if not system.angles:
        return
    rates, random = Evaluator.of_rates(system), np.random.default_rng(0)
    x, time = random.uniform(-3, 3, (len(system.states), _PLACES)), random.uniform(0, 3, _PLACES)
    values = system.values(numbers)
    with np.errstate(all="ignore"):
        at = rates.array(time, x, values)
        for i, state in enumerate(system.states):
            if state not in system.angles:
                continue
            turned_states = x + 2 * np.pi * (np.arange(len(x)) == i)[:, None]
            rates_after_turn = rates.array(time, turned_states, values)
            apart = np.abs(rates_after_turn - at) > _SAME * (1 + np.abs(at) + np.abs(rates_after_turn))
            if apart.any():
                rate = system.states[int(apart.any(axis=1).argmax())]
                reason = f"the derivative of {rate} differs after {state} has made a whole turn of 2*pi"
                raise InputError("system.angles", state.name, f"must be an angle: {reason}")


def with_values(description: Document, settings: Mapping[str, Any]) -> Document:
    """A copy of a table ``[system]`` with parameters set by name. Raises ``InputError`` for a name that is no parameter."""
    parameters = dict(require_table({"parameters": {}} | description, "parameters", "system.parameters"))
    for name, value in flatten(settings).items():
        if name not in parameters:
            raise InputError(f"system.set.{name}", value, f"unknown parameter; {nearest(name, parameters)}")
        parameters[name] = value
    return description | {"parameters": parameters}


def _read_definition(
    formula_text: object,
    known_symbols: Mapping[str, sp.Symbol],
    location: str,
    constant: frozenset[sp.Symbol],
    later: list[str],
) -> sp.Expr:
    """The meaning of a definition, which may use those before it."""
    try:
        return formula(formula_text, known_symbols, location, constant)
    except InputError as error:
        later_name = next((n for n in later if f"unknown name {n!r};" in error.explanation), None)
        if later_name is None:
            raise
        culprit = "itself" if location.endswith(f".{later_name}") else f"{later_name}, which is defined only after it"
        raise InputError(
            location, formula_text, f"uses {culprit}: a definition may use states, parameters and definitions before it"
        ) from None


def _check_name(name: str, kind: str, kinds_by_name: dict[str, str]) -> None:
    """Register a name. Raises ``InputError`` for one that is already in use, or that no formula could use."""
    location = f"system.{kind}s.{name}"
    if not name.isidentifier() or len(name) > _LONGEST_NAME:
        raise InputError(
            location, name, f"must be a name of up to {_LONGEST_NAME} letters, digits and '_' that begins with a letter"
        )
    if name == TIME.name:
        raise InputError(location, name, f"{TIME} is the time: no state, parameter or definition may have that name")
    if name in FUNCTIONS or name in CONSTANTS:
        category = "function" if name in FUNCTIONS else "number"
        raise InputError(location, name, f"{name} is a {category} of formulas: the {kind} needs another name")
    if name in kinds_by_name:
        raise InputError(location, name, f"{name} is a {kinds_by_name[name]} already: the {kind} needs another name")
    kinds_by_name[name] = kind


def _angles(description: Document, states: Mapping[str, Any]) -> list[str]:
    angle_names = description.get("angles", [])
    if not isinstance(angle_names, list) or not all(isinstance(name, str) for name in angle_names):
        raise InputError("system.angles", angle_names, 'must be a list of states, such as ["theta"]')
    for name in angle_names:
        if name not in states:
            raise InputError("system.angles", name, f"unknown state; {nearest(name, states)}")
    return angle_names
