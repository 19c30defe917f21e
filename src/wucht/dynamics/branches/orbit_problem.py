"""The equations whose orbits are followed, of a machine or of user equations, and the ordinate that is drawn of a state."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, keeps_inertia
from wucht.analysis.sections import Section, section_of
from wucht.dynamics.branches.plane_regions import Range
from wucht.dynamics.branches.steady_states import Labels
from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state, speeds_in
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.machines.operation import machine_at_speed as steady_machine
from wucht.machines.subject import Subject
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.periodic.branch_ends import significant_value
from wucht.system import System


@dataclass(frozen=True, eq=False)
class OrbitProblem:
    """Equations of orbits and the observables of their states.

    system: without outputs. values: of its parameters. path, bounds: of the one over which orbits are followed. initial: its
    value -> state (n,) to run from. observables: states (n, K) and its value -> the ordinate and the amplitude (2, K), the
    latter nan where there is none. labels: their names and units.
    embedding: (n_whole, n), where bodies are kept together, the states of all averaged equations from these.
    """

    system: System
    values: Mapping[str, float]
    path: str
    bounds: Range
    initial: Callable[[float], np.ndarray]
    observables: Callable[[np.ndarray, float], np.ndarray]
    labels: Labels
    embedding: np.ndarray | None = None

    @classmethod
    def of(
        cls, subject: Subject, path: str, bounds: Range, start: Mapping[str, Any] | None = None, together: bool = False,
        show: str | None = None, ranges: Mapping[str, Range] | None = None, inertia: bool | None = None,
    ) -> OrbitProblem:  # fmt: skip
        """Set up the equations along a parameter.

        start: the state from which a run searches a first orbit. together: equal balancing bodies keep equal phases. show: the
        state of user equations that is drawn. ranges: of their states, in which equilibria are searched. inertia: of a
        machine's balancing bodies in the averaged equations; None: as is usual for the machine.

        Raises ``InputError`` where a machine has no averaged equations, where user equations depend on time, or a key does not
        fit.
        """
        for key, value in (("show", show), ("ranges", ranges)) if isinstance(subject, Machine) else ():
            if value is not None:
                raise InputError(f"study.{key}", value, "allowed for a table [system] only", code="system-only")
        if isinstance(subject, Machine):
            return _machine_problem(subject, path, bounds, start or {}, together, inertia)
        for key, is_given in (("inertia", inertia), ("together", together)):
            if is_given:
                raise InputError(f"study.{key}", is_given, "allowed for a machine only", code="machine-only")
        return _equations_problem(subject, path, bounds, start or {}, show)

    @property
    def shows_rotor_speed(self) -> bool:
        """True if the main rotor's speed is drawn."""
        return self.labels.state is None

    @property
    def ordinate_name(self) -> str:
        """Name of what is drawn: ``speed`` of the main rotor, or the name of a state of user equations."""
        return self.labels.state or "speed"

    @property
    def turning(self) -> np.ndarray:
        """Mask of the states that are angles (n,)."""
        return np.array(self.system.is_angle)

    @property
    def width(self) -> float:
        """Width of the parameter's range."""
        return self.bounds[1] - self.bounds[0]

    def parameters_at(self, value: float) -> tuple[float, ...]:
        """Return the values of all parameters, in order, at a value of the one that changes."""
        return self.system.values({**self.values, self.path: value})

    def fixed_values(self, *paths: str) -> dict[str, float]:
        """Return the values of all parameters except some."""
        return {n: self.values[n] for n in self.system.parameter_names if n not in paths}

    def significant_range(self, low: float, high: float) -> list[float]:
        """Return the ends of a part of the parameter's range, without rounding errors of 0."""
        return [significant_value(float(end), self.bounds) for end in (low, high)]

    def turns(self, winding: np.ndarray) -> dict[str, int]:
        """Return the number of turns of angles in a period, by name, where it is not zero. winding (n,)."""
        return {n: int(w) for n, w in zip(self.system.state_names, winding, strict=True) if w}


def _machine_problem(
    machine: Machine, path: str, bounds: Range, start: Mapping[str, Any], together: bool, inertia: bool | None
) -> OrbitProblem:
    steady = steady_machine(machine, None)
    has_inertia = keeps_inertia(steady, inertia)
    averaged_equations = averaged_equations_of(steady, has_inertia)
    part = section_of(averaged_equations, True) if together else None
    system = _bare(averaged_equations.system if part is None else part.system)
    if path not in system.parameter_names:
        raise InputError("study.along", path, "not allowed: the averaged equations do not depend on it")

    def initial(value: float) -> np.ndarray:
        at = steady.with_unchecked_values({path: value})
        state = initial_state(at, with_default_start(at, start))
        averaged_equations = averaged_equations_of(at, has_inertia)
        whole = averaged_equations.state(angles_in(at, state), speeds_in(at, state))
        return whole if part is None else np.linalg.lstsq(part.embedding, whole, rcond=None)[0]

    observables, embedding = _observables(averaged_equations, part, path, steady), None if part is None else part.embedding
    labels = Labels.from_machine(steady, averaged_equations, has_inertia)
    return OrbitProblem(system, steady.values, path, bounds, initial, observables, labels, embedding)


def _bare(system: System) -> System:
    return System(system.states, system.derivatives, system.parameters, system.definitions, angles=system.angles)


def _observables(
    averaged_equations: AveragedEquations, part: Section | None, path: str, machine: Machine
) -> Callable[[np.ndarray, float], np.ndarray]:
    """Return a function for the main rotor's signed speed and the amplitude of the axis."""
    system, rotor = averaged_equations.system, machine.rotor.name
    outputs = [system.output(f"speed[{rotor}]").expression, system.output("amplitude").expression]
    evaluator, sense = Evaluator.of(system, outputs, ["speed", "amplitude"]), averaged_equations.senses[rotor]

    def observables(states: np.ndarray, value: float) -> np.ndarray:
        whole = states if part is None else part.embedding @ states
        output_values = evaluator(np.zeros(whole.shape[1]), whole, system.values({**machine.values, path: value}))
        return np.array([sense * output_values["speed"], output_values["amplitude"]])

    return observables


def _equations_problem(
    subject: Subject, path: str, bounds: Range, given_start: Mapping[str, Any], show: str | None
) -> OrbitProblem:
    system, names = _bare(subject.system), subject.system.state_names
    if system.depends_on_time:
        raise InputError("system", None, "these equations depend on the time t: give the phase of the forcing as a state")
    turning = {s.name for s in system.angles}
    show = show or next((n for n in names if n not in turning), names[0])
    for name, location in [(show, "study.show"), *((n, f"study.start.{n}") for n in given_start)]:
        if name not in names:
            raise InputError(location, name, f"unknown state; {nearest(name, names)}")
    start = np.array([_number(given_start.get(n, 0.0), f"study.start.{n}") for n in names])
    row, labels = names.index(show), Labels(f"state {show}", "", show, of_equations=True)

    def observables(states: np.ndarray, value: float) -> np.ndarray:
        return np.array([states[row], np.full(states.shape[1], np.nan)])

    return OrbitProblem(system, subject.values, path, bounds, lambda _: start, observables, labels)


def _number(value: object, location: str) -> float:
    if isinstance(value, bool) or not isinstance(value, int | float):
        raise InputError(location, value, "must be a number")
    return float(value)
