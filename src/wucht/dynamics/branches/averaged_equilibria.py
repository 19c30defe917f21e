"""Steady states of a machine's averaged equations along a parameter: the equations, all states at a value, their names."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import cached_property, lru_cache

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import AveragedEquations, averaged_equations_of, keeps_inertia
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.configuration import name_of, residual_unbalance, type_of
from wucht.analysis.configurations.search import all_states, is_same_state, multiplicity
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import unbalances
from wucht.dynamics.branches.steady_states import (
    Heartbeat,
    Kind,
    Labels,
    StatesAtValue,
    speed_range_text,
)
from wucht.errors import InputError, nearest
from wucht.machines.machine import Machine
from wucht.machines.operation import MOST_BODIES, driven_speeds, machine_at_speed
from wucht.numerics.angles import wrap_angle, wrap_to_pi
from wucht.numerics.continuation.curve import Steps
from wucht.numerics.continuation.equations import EquilibriumEquations
from wucht.numerics.continuation.equilibria import EquilibriumContinuation
from wucht.numerics.flow.program import Evaluator
from wucht.system import System

_STEPS = Steps(first=0.01, most=0.04, turn=0.06, points=4000)
_LEAST = 1e-3  # of the fastest speed: slower rotors than that hardly turn, and are not followed
_ABOVE = 1.01  # of the fastest speed: no branch continues there
_IN_LINE = 1e-6  # sine of the angle between bodies that are in line
_ROUNDING = 1e-12  # of all unbalances over the moving mass: a smaller amplitude is zero
_SAMPLES = 5  # of the range: values at which the fastest speed is determined


@dataclass(frozen=True)
class AveragedEquilibria:
    """Equilibria of the averaged equations of a machine.

    machine: after its schedules. path, bounds: of the parameter. inertia: of the balancing bodies. show:
    the state that is drawn, None for the speed. The unknowns (n+1,) of a point
    are a state of the averaged equations, in each body's sense of rotation, and the parameter's value.
    """

    machine: Machine
    path: str
    bounds: tuple[float, float]
    inertia: bool
    show: str | None = None

    @classmethod
    def of(
        cls, machine: Machine, path: str, bounds: tuple[float, float], show: str | None = None, inertia: bool | None = None
    ) -> AveragedEquilibria:  # fmt: skip
        """Set up the equilibria. inertia: of the bodies in averaged equations; None: as is usual for the machine.

        Raises ``InputError`` where the state to be drawn does not exist, or there is nothing to follow.
        """
        if len(machine.bodies) > MOST_BODIES:
            most = f"there must be at most {MOST_BODIES}, the main rotor included"
            raise InputError("machine.bodies", len(machine.bodies), most)
        if machine.shaken_coordinate is not None:
            sentence = "the carrier's motion is prescribed: study.kind = 'entrainment' computes whether it entrains the rotor"
            raise InputError("machine.carrier.motion", None, sentence)
        steady = machine_at_speed(machine, None)
        equilibria = cls(steady, path, bounds, keeps_inertia(steady, inertia), show)
        if not equilibria.names:
            reason = "its speed is prescribed and nothing else turns: no state is left that could depend on a parameter"
            raise InputError("machine.drive", None, f"{reason}; study.kind = 'response' shows its vibration")
        if path not in equilibria.averaged_equations.system.parameter_names:
            raise InputError("study.along", path, "not allowed: the averaged equations do not depend on it")
        if show is not None and show not in equilibria.names:
            raise InputError("study.show", show, f"unknown state; {nearest(show, equilibria.names)}")
        if not equilibria.fastest > 0:
            raise InputError("study.range", list(bounds), "nothing drives the machine there: it has no steady operation")
        return equilibria

    @cached_property
    def averaged_equations(self) -> AveragedEquations:
        """Averaged equations at the machine's nominal values. Raises ``InputError`` where there are none."""
        return averaged_equations_of(self.machine, self.inertia)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the states (n)."""
        return self.averaged_equations.system.state_names

    @cached_property
    def model_at(self) -> Callable[[float], AveragedStability]:
        """Machine at a value of the parameter: its torques and averaged equations. Computed once for each value."""
        senses = {r.name: self.averaged_equations.senses[r.name] for r in self.machine.rotors}

        def model(value: float) -> AveragedStability:
            machine = self.machine.with_unchecked_values({self.path: value})
            averaged_equations = averaged_equations_of(machine, self.inertia, turning=senses)
            return AveragedStability(SteadyTorques.from_averaged_equations(averaged_equations), averaged_equations)

        return lru_cache(maxsize=512)(model)

    def driven_range(self, value: float) -> tuple[float, float]:
        """Return the speeds between which states are searched at a value."""
        return driven_speeds(self.machine.with_unchecked_values({self.path: value}))[0]

    @cached_property
    def fastest(self) -> float:
        """Highest speed that drives reach anywhere in the range; the prescribed one where there is one; 0 for none."""
        values = np.linspace(*self.bounds, _SAMPLES).tolist()
        prescribed_speed = self.model_at(sum(self.bounds) / 2).torques.fixed_speed
        return max(self.driven_range(v)[1] for v in values) if prescribed_speed is None else abs(prescribed_speed)

    @cached_property
    def limits(self) -> tuple[float, float]:
        """Speeds of rotors within which branches are followed."""
        return _LEAST * self.fastest, _ABOVE * self.fastest

    @cached_property
    def equilibria(self) -> EquilibriumContinuation:
        """Continuation problem: phases scaled by a radian, speeds by the fastest one, the parameter by its range."""
        equations = EquilibriumEquations.from_system(
            self.averaged_equations.system, [self.path], self.machine.values, self._scale
        )
        rotors = {f"{r.name}.speed" for r in self.machine.rotors}
        limits = {i: self.limits for i, name in enumerate(self.names) if name in rotors}
        return EquilibriumContinuation(equations, self.bounds, _STEPS, limits)

    @property
    def _scale(self) -> dict[str, float]:
        speeds = {n: self.fastest for n in self.names if n.endswith(".speed")}
        return speeds | {self.path: self.bounds[1] - self.bounds[0]}

    def equations_with(self, second: str, width: float) -> EquilibriumEquations:
        """See ``SteadyStates``."""
        return EquilibriumEquations.from_system(
            self.averaged_equations.system, [self.path, second], self.machine.values, self._scale | {second: width}
        )

    @property
    def ordinate_size(self) -> float:
        """See ``SteadyStates``."""
        return 1.0 if self.show is not None and self.show.endswith(".phase") else self.fastest

    def find_equilibria(self, value: float, report: Heartbeat | None = None) -> StatesAtValue:
        """See ``SteadyStates``: states that differ by an exchange of equal bodies, or belong to one family, count once."""
        torques, (low, high) = self.model_at(value).torques, self.driven_range(value)
        if torques.fixed_speed is None and not high > 0:
            return StatesAtValue(value, complete=True, evidence="nothing drives the machine there")
        search = all_states(torques, low, high, report)
        isolated_states, families = [s for s in search.states if not s.dimension], [s for s in search.states if s.dimension]
        points = tuple(self.point(s, value) for s in isolated_states)
        # The report states the speeds once for all searched values.
        evidence = search.evidence.replace(speed_range_text((low, high), self.machine.units.speed), "speeds")
        return StatesAtValue(
            value, points, tuple(families), search.complete, evidence, None if torques.fixed_speed is not None else (low, high)
        )

    def point(self, state: State, value: float) -> np.ndarray:
        """Return the unknowns (n+1,) of a state."""
        return np.append(self.averaged_equations.steady_state(state.speed, state.phases), value)

    def state(self, unknowns: np.ndarray) -> State:
        """Return the state at a point: phases relative to the main rotor, and which bodies are in line."""
        torques = self.model_at(float(unknowns[-1])).torques
        phases = np.array([self._phase(unknowns, name) for name in torques.names])
        speed = (
            torques.fixed_speed if torques.fixed_speed is not None else float(unknowns[self._rows[f"{torques.names[0]}.speed"]])
        )
        state = State(speed, phases % (2 * math.pi))
        beside = _sides_in_line(torques, state.phases)
        return replace(state, sides=beside, multiplicity=multiplicity(torques, state))

    def _phase(self, unknowns: np.ndarray, name: str) -> float:
        """Return the phase of a body relative to the main rotor."""
        reference = self.averaged_equations.references[name]
        return 0.0 if reference is None else float(unknowns[self._rows[f"{name}.phase"]]) + self._phase(unknowns, reference)

    @cached_property
    def _rows(self) -> dict[str, int]:
        return {name: i for i, name in enumerate(self.names)}

    def is_same(self, unknowns: np.ndarray, reference: np.ndarray) -> bool:
        """True if points at one value of the parameter are one state, up to an exchange of equal bodies."""
        return is_same_state(self.model_at(float(unknowns[-1])).torques, self.state(unknowns), self.state(reference))

    def kind(self, unknowns: np.ndarray) -> Kind:
        """See ``SteadyStates``: the names used by ``synchronous-states``."""
        torques, state = self.model_at(float(unknowns[-1])).torques, self.state(unknowns)
        if torques.size == 1:
            return Kind()
        order = [torques.names.index(b.name) for b in torques.machine.bodies]
        ordered_unbalances = unbalances(torques.machine)[np.argsort(order)]
        name, c = name_of(torques, state, residual_unbalance(torques, ordered_unbalances, state.phases)), sum(state.sides)
        split = (max(len(state.sides) - c, c), min(len(state.sides) - c, c)) if state.sides else None
        return Kind(name, type_of(torques, name), split, state.multiplicity)

    @cached_property
    def _observables(self) -> tuple[Evaluator, tuple[float, ...]]:
        system, symbol = self.averaged_equations.system, sp.Symbol(self.path, real=True)
        parameters = tuple(p for p in system.parameters if p != symbol)
        rates = (*system.derivatives, sp.S.Zero)
        extended_system = System((*system.states, symbol), rates, parameters, system.definitions)
        bodies = self.averaged_equations.averaged_system.bodies
        speed = system.output(f"speed[{bodies.names[0]}]").expression
        moments = sp.Add(*(sp.sqrt(sp.Add(*(x**2 for p in row for x in (p.re, p.im)))) for row in bodies.excitation))
        expressions = [system.output("amplitude").expression, speed, moments / bodies.mass.trace()]
        values = tuple(self.machine.values[p.name] for p in parameters)
        return Evaluator.of(extended_system, expressions, ["amplitude", "speed", "size"]), values

    def _outputs(self, unknowns: np.ndarray) -> dict[str, np.ndarray]:
        evaluator, values = self._observables
        return evaluator(np.zeros(unknowns.shape[1]), unknowns, values)

    def ordinate(self, unknowns: np.ndarray) -> np.ndarray:
        """See ``SteadyStates``: the main rotor's signed speed, or the chosen state."""
        if self.show is not None:
            return np.asarray(unknowns[self._rows[self.show]])
        return np.asarray(float(self.averaged_equations.senses[self.machine.rotor.name]) * self._outputs(unknowns)["speed"])

    def amplitude(self, unknowns: np.ndarray) -> np.ndarray:
        """See ``SteadyStates``: 0 where the unbalances compensate each other."""
        output_values = self._outputs(unknowns)
        amplitude = output_values["amplitude"]
        return np.where(amplitude < _ROUNDING * output_values["size"], 0.0, amplitude)

    def state_by_name(self, unknowns: np.ndarray) -> dict[str, float]:
        """See ``SteadyStates``: phases as in the contract, in each body's sense of rotation, speeds likewise; psi and delta of
        two bodies of one rotor.
        """
        angles = [n.endswith(".phase") for n in self.names]
        values = {
            n: float(wrap_angle(x) if angle else x) for n, x, angle in zip(self.names, unknowns[:-1], angles, strict=True)
        }
        about = [b.name for b in self.machine.bodies if b.about is not None]
        if len(self.machine.bodies) == 3 and len(about) == 2:
            first, second = (values[f"{name}.phase"] for name in about)
            delta = float(wrap_to_pi(first - second))
            equal = (
                len(self.model_at(float(unknowns[-1])).torques.classes) == 1
            )  # exchanging them changes delta's sign, and nothing else
            values |= {
                "psi": float(math.pi - wrap_angle(math.pi - second - delta / 2)),
                "delta": abs(delta) if equal else delta,
            }
        return values

    def end_reason(self, unknowns: np.ndarray) -> str:
        """See ``SteadyStates``."""
        return self.speed_limit_reason(any(unknowns[i] <= self.limits[0] for i in self.equilibria.limits))

    def speed_limit_reason(self, slow: bool) -> str:
        """Return why a branch ends where rotors are too slow, or too fast."""
        (low, high), unit = self.limits, self.machine.units.speed
        if slow:
            return f"below {low:.4g} {unit}".rstrip() + " a rotor hardly turns, and the averaged equations do not hold"
        return f"no drive can keep more than {high:.4g} {unit}".rstrip()

    @property
    def nominal_value(self) -> float:
        """See ``SteadyStates``."""
        return self.machine.values[self.path]

    @property
    def labels(self) -> Labels:
        """See ``SteadyStates``."""
        return Labels.from_machine(self.machine, self.averaged_equations, self.inertia, self.show)


def _sides_in_line(torques: SteadyTorques, phases: np.ndarray) -> tuple[int, ...]:
    """Return the side (0 or 1) of each balancing body; empty where they are not in line, or not on one axis."""
    c = torques.coefficients
    if torques.size < 3 or not torques.is_coaxial or c is None:
        return ()
    directions = np.exp(1j * (phases[1:] - phases[1])) * np.exp(1j * (np.angle(c[1:]) - np.angle(c[1])))
    return tuple((directions.real < 0).astype(int).tolist()) if np.abs(directions.imag).max() < _IN_LINE else ()
