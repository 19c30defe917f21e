"""The averaged equations of a machine where equal bodies keep equal phases, in the machine's conventions and names."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import AveragedEquations
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.machines.structure import SPEED
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.phase_plane.plane import jacobian_of
from wucht.system import System

PSI, OMEGA = "psi", "speed"
_INVARIANT = 1e-9  # of the largest rate: rate allowed out of an invariant section
_PLACES = 64  # at which that is evaluated
_LOWEST, _HIGHEST = 0.02, 1.15  # of the speed without vibration: the default of the range


@dataclass(frozen=True, eq=False)
class Axis:
    """A state of a section: its name, long name, unit and default range; low and high of an angle are a turn."""

    name: str
    long_name: str
    unit: str
    low: float = math.nan
    high: float = math.nan


@dataclass(frozen=True, eq=False)
class Section:
    """The k states that remain of n averaged ones, in the machine's conventions of angles and speeds.

    system: of these k, and values of its parameters. whole: the averaged System. embedding: (n, k), the states of the whole
    from these. turning: the index of the main rotor's speed, -1 where that is fixed at ``speed``. inertia, order: of the
    averaged equations.
    """

    system: System
    values: Mapping[str, float]
    axes: tuple[Axis, ...]
    whole: System
    embedding: np.ndarray
    turning: int
    speed: float | None
    inertia: bool
    order: int
    warnings: tuple[str, ...]

    def transverse(self, state: np.ndarray) -> np.ndarray:
        """The eigenvalues (n - k,) of a fixed point in the directions that lead out of the section, the largest first."""
        matrix = jacobian_of(replace(self.whole, outputs=(), quadratures=())).values_at(
            self.embedding @ state, self.whole.values(self.values)
        )[1]
        out = np.linalg.qr(self.embedding, mode="complete")[0][:, self.embedding.shape[1] :]
        values = np.linalg.eigvals(out.T @ matrix @ out).astype(complex) if out.shape[1] else np.empty(0, complex)
        return values[np.lexsort((-values.imag, -values.real))]

    def rotor_speed(self, state: np.ndarray) -> np.ndarray:
        """Speed of the main rotor at states (k, ...)."""
        return np.asarray(state[self.turning] if self.turning >= 0 else np.full(np.shape(state)[1:], self.speed))


def section_of(
    averaged_equations: AveragedEquations, together: bool | Sequence[str] | None, speed: float | None = None
) -> Section:
    """The states that remain where bodies keep equal phases.

    Parameters
    ----------
    averaged_equations : AveragedEquations
    together : bool, sequence of str, or None
        True for all balancing bodies, names of some, None for none: then all states remain.
    speed : float, optional
        Speed of the main rotor, signed, where ``averaged_equations`` fix it.

    Raises
    ------
    InputError
        At ``study.together``: for an unknown name, and where motions that begin with equal phases do not keep them.
    """
    machine = averaged_equations.machine
    values = dict(machine.values) | (
        {} if speed is None else {SPEED.name: averaged_equations.senses[machine.rotor.name] * speed}
    )
    groups = _groups(together, averaged_equations)
    system, axes = _section_system(averaged_equations, machine, groups)
    embedding = np.zeros((len(averaged_equations.system.states), len(groups)))
    for k, group in enumerate(groups):
        for i in group:
            embedding[i, k] = _sense(averaged_equations, i)
    main = f"{machine.rotor.name}.speed"
    turning = next((k for k, g in enumerate(groups) if averaged_equations.system.state_names[g[0]] == main), -1)
    section_values = {name: values[name] for name in averaged_equations.system.parameter_names}
    coordinate = machine.rotor.coordinate
    if speed is None and coordinate.prescribed_velocity is not None:
        speed = float(machine.prescribed_speed(coordinate, 0.0)[0])
    section = Section(
        system,
        section_values,
        axes,
        averaged_equations.system,
        embedding,
        turning,
        speed,
        averaged_equations.inertia,
        averaged_equations.order,
        averaged_equations.warnings,
    )
    _refuse_leaving_curves(section, groups, averaged_equations)
    return section


def _groups(together: bool | Sequence[str] | None, averaged_equations: AveragedEquations) -> list[list[int]]:
    """The states of the averaged equations, by their indices: those that stay equal are one group."""
    names, machine = averaged_equations.system.state_names, averaged_equations.machine
    if not together:
        return [[i] for i in range(len(names))]
    bodies = [b.name for b in machine.bodies if b.about is not None]
    chosen = bodies if together is True else list(together)
    for name in chosen:
        if name not in bodies:
            raise InputError("study.together", name, f"must be bodies that turn about a rotor; {nearest(name, bodies)}")
    if len(chosen) < 2:
        raise InputError("study.together", together, f"must be at least two of the bodies that turn about a rotor: {bodies}")
    groups: dict[str, list[int]] = {}
    for i, name in enumerate(names):
        body, _, quantity = name.rpartition(".")
        groups.setdefault(f"together.{quantity}" if body in chosen else name, []).append(i)
    return list(groups.values())


def _sense(averaged_equations: AveragedEquations, index: int) -> int:
    """The sign between a state of the averaged equations and the machine's convention of it."""
    body, _, quantity = averaged_equations.system.state_names[index].rpartition(".")
    rotor = averaged_equations.machine.body(body).about is None
    return 1 if quantity == "phase" and rotor else averaged_equations.senses[body]


def _section_system(
    averaged_equations: AveragedEquations, machine: Machine, groups: Sequence[Sequence[int]]
) -> tuple[System, tuple[Axis, ...]]:
    s, units = averaged_equations.system, machine.units
    first = [s.state_names[g[0]] for g in groups]
    phases, main = sum(name.endswith(".phase") for name in first), f"{machine.rotor.name}.speed"
    axes = []
    for group, name in zip(groups, first, strict=True):
        body, _, quantity = name.rpartition(".")
        if quantity == "speed":
            axis_name = OMEGA if name == main else name
            free = free_speed(machine, machine.body(body))
            ends = sorted((_LOWEST * free, _HIGHEST * free)) if free else (math.nan, math.nan)
            axes.append(Axis(axis_name, f"speed of {body}", units.speed, *ends))
        else:
            bodies = ", ".join(s.state_names[i].rpartition(".")[0] for i in group)
            axis_name = PSI if phases == 1 else body
            axes.append(Axis(axis_name, f"phase of {bodies}", "rad", 0.0, 2 * math.pi))
    senses = tuple(_sense(averaged_equations, g[0]) for g in groups)
    return _reduced_system(s, tuple(map(tuple, groups)), tuple(a.name for a in axes), senses), tuple(axes)


@lru_cache(maxsize=16)
def _reduced_system(s: System, groups: tuple[tuple[int, ...], ...], names: tuple[str, ...], senses: tuple[int, ...]) -> System:
    """The System of the first of each group, all states of which are equal, with other names and senses."""
    symbols = tuple(sp.Symbol(name, real=True) for name in names)
    replacements = {s.states[i]: sign * x for group, x, sign in zip(groups, symbols, senses, strict=True) for i in group}
    return System(
        symbols,
        tuple(sign * sp.sympify(s.derivatives[g[0]]).xreplace(replacements) for g, sign in zip(groups, senses, strict=True)),
        s.parameters,
        tuple((symbol, sp.sympify(e).xreplace(replacements)) for symbol, e in s.definitions),
        angles=frozenset(x for x, g in zip(symbols, groups, strict=True) if s.states[g[0]] in s.angles),
    )


def _refuse_leaving_curves(section: Section, groups: Sequence[Sequence[int]], averaged_equations: AveragedEquations) -> None:
    """Raises ``InputError`` where curves that begin in the section leave it."""
    low, high = np.array([[a.low, a.high] for a in section.axes]).T
    if section.embedding.shape[0] == section.embedding.shape[1]:
        return
    low, high = np.where(np.isfinite(low), low, 0.5), np.where(np.isfinite(high), high, 1.5)
    x = np.random.default_rng(0).uniform(low[:, None], high[:, None], (len(low), _PLACES))
    with np.errstate(all="ignore"):
        rates = Evaluator.of_rates(section.whole).array(
            np.zeros(_PLACES), section.embedding @ x, section.whole.values(section.values)
        )
    out = np.linalg.qr(section.embedding, mode="complete")[0][:, section.embedding.shape[1] :]
    fine = np.isfinite(rates).all(axis=0)
    if not fine.any() or np.abs(out.T @ rates[:, fine]).max(initial=0.0) <= _INVARIANT * np.abs(rates[:, fine]).max():
        return
    names = next([averaged_equations.system.state_names[i] for i in g] for g in groups if len(g) > 1)
    bodies = " and ".join(n.rpartition(".")[0] for n in names)
    raise InputError(
        "study.together",
        None,
        f"{bodies} do not keep equal phases: must be bodies with equal properties",
        code="phases-part",
    )
