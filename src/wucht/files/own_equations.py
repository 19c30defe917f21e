"""User equations: the table ``[system]`` of a study file -> a System with values of its parameters."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import Any

import numpy as np
import sympy as sp

from wucht.errors import InputError, WuchtError, nearest
from wucht.files.documents import Document, flatten, settings_in
from wucht.files.formulas import CONSTANTS, FUNCTIONS, formula
from wucht.numerics.flow.program import Evaluator
from wucht.schema import Parameter, Unit, read_quantity, refuse_unknown, table, text
from wucht.system import TIME, System

KEYS = ("title", "use", "set", "states", "angles", "parameters", "definitions")
_LONGEST_NAME = 64
_PLACES, _SAME = 32, 1e-8  # points at which equations are evaluated, and a turn further; tolerance between both


@dataclass(frozen=True)
class OwnEquations:
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

    def __post_init__(self) -> None:
        self.system.values(self.values)
        if unknown := [name for name in self.values if name not in self.system.parameter_names]:
            raise WuchtError(
                f"{unknown[0]} is not a parameter of these equations; {nearest(unknown[0], self.system.parameter_names)}",
                code="unknown-parameter",
            )

    @cached_property
    def parameters(self) -> dict[str, Parameter]:
        """The parameters by name."""
        return {name: Parameter(name, float(value), "", name, f"parameter {name}") for name, value in self.values.items()}

    def changed(self, values: Mapping[str, float]) -> OwnEquations:
        """The same equations with other values of some parameters. Raises ``WuchtError`` for one that they do not have."""
        return OwnEquations(self.system, {**self.values, **values}, self.title)


def equations_from(document: Document, title: str = "") -> OwnEquations:
    """The equations described by a table ``[system]`` (without ``use``, which the catalogue resolves).

    Raises ``InputError``, located from ``system`` on.
    """
    described = dict(document)
    settings = settings_in(described, "system")
    refuse_unknown(described, KEYS, "system")
    title = text(described, "title", "system") or title
    described.setdefault("parameters", {})
    values = with_values(described, settings)["parameters"]
    states = table(described, "states", "system.states")
    definitions = table({"definitions": {}} | described, "definitions", "system.definitions")
    if not states:
        raise InputError("system.states", None, 'must be a table of derivatives, such as { x = "mu*x - x^3", y = "-y" }')
    taken: dict[str, str] = {}
    for kind, names in (("state", states), ("parameter", values), ("definition", definitions)):
        for name in names:
            _check_name(name, kind, taken)
    symbols = {name: sp.Symbol(name, real=True) for name in taken}
    constant, known = frozenset(symbols[name] for name in values), {n: symbols[n] for n in (*states, *values)} | {"t": TIME}
    meanings: list[tuple[sp.Symbol, sp.Expr]] = []
    for name, given in definitions.items():
        where = f"system.definitions.{name}"
        later = [n for n in definitions if n not in known]
        meanings.append((symbols[name], _in_order(given, known, where, constant, later)))
        known[name] = symbols[name]
    rates = [formula(given, known, f"system.states.{name}", constant) for name, given in states.items()]
    turning = frozenset(symbols[name] for name in _angles(described, states))
    numbers = {
        n: read_quantity(Unit("", f"value of the parameter {n}"), v, f"system.parameters.{n}") for n, v in values.items()
    }
    system = System(
        tuple(symbols[n] for n in states), tuple(rates), tuple(symbols[n] for n in values), tuple(meanings), angles=turning
    )
    _refuse_other_periods(system, numbers)
    return OwnEquations(system, numbers, title)


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
            turned = x + 2 * np.pi * (np.arange(len(x)) == i)[:, None]
            further = rates.array(time, turned, values)
            apart = np.abs(further - at) > _SAME * (1 + np.abs(at) + np.abs(further))
            if apart.any():
                rate = system.states[int(apart.any(axis=1).argmax())]
                why = f"the derivative of {rate} differs after {state} has made a whole turn of 2*pi"
                raise InputError("system.angles", state.name, f"must be a state on a circle: {why}")


def with_values(described: Document, settings: Mapping[str, Any]) -> Document:
    """A copy of a table ``[system]`` with parameters set by name. Raises ``InputError`` for a name that is no parameter."""
    parameters = dict(table({"parameters": {}} | described, "parameters", "system.parameters"))
    for name, value in flatten(settings).items():
        if name not in parameters:
            raise InputError(f"system.set.{name}", value, f"unknown parameter; {nearest(name, parameters)}")
        parameters[name] = value
    return described | {"parameters": parameters}


def _in_order(
    given: object, known: Mapping[str, sp.Symbol], where: str, constant: frozenset[sp.Symbol], later: list[str]
) -> sp.Expr:
    """The meaning of a definition, which may use those before it."""
    try:
        return formula(given, known, where, constant)
    except InputError as error:
        used = next((n for n in later if f"unknown name {n!r};" in error.allowed), None)
        if used is None:
            raise
        why = "itself" if where.endswith(f".{used}") else f"{used}, which is defined only after it"
        raise InputError(
            where, given, f"uses {why}: a definition may use states, parameters and definitions before it"
        ) from None


def _check_name(name: str, kind: str, taken: dict[str, str]) -> None:
    """Register a name. Raises ``InputError`` for one that is already in use, or that no formula could use."""
    where = f"system.{kind}s.{name}"
    if not name.isidentifier() or len(name) > _LONGEST_NAME:
        raise InputError(
            where, name, f"must be a name of up to {_LONGEST_NAME} letters, digits and '_' that begins with a letter"
        )
    if name == TIME.name:
        raise InputError(where, name, f"{TIME} is the time: no state, parameter or definition may have that name")
    if name in FUNCTIONS or name in CONSTANTS:
        what = "function" if name in FUNCTIONS else "number"
        raise InputError(where, name, f"{name} is a {what} of formulas: the {kind} needs another name")
    if name in taken:
        raise InputError(where, name, f"{name} is a {taken[name]} already: the {kind} needs another name")
    taken[name] = kind


def _angles(described: Document, states: Mapping[str, Any]) -> list[str]:
    given = described.get("angles", [])
    if not isinstance(given, list) or not all(isinstance(name, str) for name in given):
        raise InputError("system.angles", given, 'must be a list of states, such as ["theta"]')
    for name in given:
        if name not in states:
            raise InputError("system.angles", name, f"unknown state; {nearest(name, states)}")
    return given
