"""Names of earlier versions: each works until 0.3.0, with a ``DeprecationWarning`` that says the present one.

The present names are those of ``docs/api/public.txt``. What is renamed or removed there gets an entry here.
"""

from __future__ import annotations

import sys
from importlib import import_module
from typing import Any, TypeVar
from warnings import warn

_Class = TypeVar("_Class", bound=type)

# What pages and examples of earlier versions used, by the place from which they imported it.
_NAMES = {
    "wucht.OwnEquations": "wucht.UserSystem",
    "wucht.cams.laws.standard_laws.of_polynomials": "wucht.cams.polynomial_law",
    "wucht.extending.Quantity": "wucht.extending_0_1.Quantity",
    "wucht.extending.ReportLines": "wucht.extending_0_1.ReportLines",
    "wucht.extending.Spec": "wucht.extending_0_1.Spec",
    "wucht.extending.answer": "wucht.extending_0_1.result_dataset",
    "wucht.extending.formats": "wucht.extending_0_1.formats",
    "wucht.extending.in_lines": "wucht.extending_0_1.report_lines",
    "wucht.extending.report_lines": "wucht.extending_0_1.report_lines",
    "wucht.extending.result_dataset": "wucht.extending_0_1.result_dataset",
    "wucht.extending.table": "wucht.extending_0_1.table",
    "wucht.mechanics.averaging.Averaged": "wucht.mechanics.Averaging",
    "wucht.mechanics.harmonics": "wucht.mechanics.trigonometric_polynomial",
    "wucht.numerics.collocation.boundary_values.at_begin": "wucht.numerics.periodic.start_value",
    "wucht.numerics.collocation.boundary_values.at_end": "wucht.numerics.periodic.end_value",
    "wucht.numerics.continuation.Equations": "wucht.numerics.continuation.EquilibriumEquations",
    "wucht.numerics.continuation.Equilibria": "wucht.numerics.continuation.EquilibriumContinuation",
    "wucht.numerics.continuation.equations.Equations": "wucht.numerics.continuation.EquilibriumEquations",
    "wucht.numerics.continuation.equations.Functions": "wucht.numerics.continuation.FunctionProblem",
    "wucht.numerics.continuation.equilibria.Equilibria": "wucht.numerics.continuation.EquilibriumContinuation",
    "wucht.numerics.flow.compiled.compile_system": "wucht.numerics.flow.compile_system",
    "wucht.numerics.periodic.connection_starts.of_excursion": "wucht.numerics.periodic.connection_from_excursion",
    "wucht.numerics.periodic.cycle_starts.doubled": "wucht.numerics.periodic.doubled_branch",
}
_ATTRIBUTES = {
    "Branch": {"u": "unknowns"},
    "CollocationSolution": {"at": "states_at"},  # Solution, Cycle, CurveCycle, Connection
    "Connection": {"parameters": "parameter_values"},
    "CurveCycle": {"parameters": "parameter_values"},
    "CurvePoint": {"u": "unknowns"},
    "Cycle": {"trusted": "is_trusted", "hidden": "hidden_point"},
    "EquilibriumContinuation": {"branch": "follow_branch", "switched": "switch_branch", "seen": "evaluate"},
    "EquilibriumEquations": {"of": "from_system", "by_hand": "from_function"},
    "Equilibrium": {"u": "unknowns"},
    "Solution": {"parameters": "parameter_values"},
    "SpecialCurve": {"u": "unknowns", "parameters": "parameter_values"},
    "SpecialCurves": {"branch": "follow_curve"},  # Folds, HopfPoints
    "SpecialEquilibrium": {"u": "unknowns", "parameters": "parameter_values"},  # Fold, HopfPoint
    "Trajectory": {"parameters": "final_parameter_values"},
}
_ENGINES = {"heyoka": "compiled", "scipy": "compiled", "scipy-radau": "radau"}


def _available_engine(is_interrupted: bool = False) -> str:
    return "compiled"


# What has no successor, and why.
_REMOVALS: dict[str, tuple[Any, str]] = {
    "wucht.numerics.flow.available_engine": (_available_engine, "there is one engine, 'compiled'"),
}


def present_engine(name: str) -> str:
    """Return the present name of an engine; an earlier one gives a warning, to users of files as well."""
    if name not in _ENGINES:
        return name
    _warn(f"the engine {name!r}", repr(_ENGINES[name]), FutureWarning)
    return _ENGINES[name]


def provide_earlier_names(module_name: str) -> None:
    """Give a module its earlier names. What it loads on demand by a ``__getattr__`` of its own stays as it is."""
    module = vars(sys.modules[module_name])
    present = module.get("__getattr__")

    def attribute(name: str) -> Any:
        earlier = f"{module_name}.{name}"
        if earlier in _NAMES:
            _warn(earlier, _NAMES[earlier])
            place, _, present_name = _NAMES[earlier].rpartition(".")
            return getattr(import_module(place), present_name)
        if earlier in _REMOVALS:
            value, reason = _REMOVALS[earlier]
            warn(f"{earlier} is no longer needed: {reason}; it will be gone in wucht 0.3.0", DeprecationWarning, stacklevel=2)
            return value
        if present is None:
            raise AttributeError(f"module {module_name!r} has no attribute {name!r}")
        return present(name)

    module["__getattr__"] = attribute


def with_earlier_names(cls: _Class) -> _Class:
    """Give a class its earlier attributes: a decorator."""
    for name, successor in _ATTRIBUTES[cls.__name__].items():
        setattr(cls, name, _EarlierAttribute(name, successor))
    return cls


class _EarlierAttribute:
    """An attribute of a class and of its instances that has another name now."""

    def __init__(self, name: str, successor: str) -> None:
        self._name, self._successor = name, successor

    def __get__(self, instance: object, owner: type) -> Any:
        _warn(f"{owner.__name__}.{self._name}", f"{owner.__name__}.{self._successor}")
        return getattr(owner if instance is None else instance, self._successor)


def _warn(name: str, successor: str, category: type[Warning] = DeprecationWarning) -> None:
    warn(f"{name} is now {successor}; the earlier name will be gone in wucht 0.3.0", category, stacklevel=3)
