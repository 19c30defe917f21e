"""Equations of the members of an ensemble, and what is observed of them: in the frame that turns with the main rotor
where the machine allows it, else in the fixed one; or the averaged equations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
import sympy as sp

from wucht.analysis.averaged_equations import AveragedEquations
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.analysis.time_constants import runaway_limit
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.member_quantities import MemberQuantities, full_motion
from wucht.dynamics.verdicts.locking import is_locking
from wucht.dynamics.verdicts.observation import weights_of
from wucht.errors import InputError
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed, sense_of
from wucht.machines.parts.base import Drive, Load
from wucht.machines.tree import RotatingBody
from wucht.numerics.flow.compiled_batch import Quantities
from wucht.system import System


def batching_obstacle(question: EnsembleQuestion) -> str | None:
    """Return the reason why the members cannot be integrated in batches, and are run up one by one; None if they can."""
    machine, slow = question.machine, question.model == "slow"
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None]
    reasons = {
        "a rotor without a drive turns as it does at the start": slow and not all(free_speed(machine, r) for r in free),
        "nothing but a limit ends the run-up": runaway_limit(machine) is not None,
        "bodies are released on the way": bool(release_events(machine)),
    }
    return next((reason for reason, holds in reasons.items() if holds), None)


def is_screened(machine: Machine) -> bool:
    """True if the main rotor's speed and unbalance alone decide most members, once its drive and its loads change no more."""
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None]
    shaft_parts = [part.path for part in machine.parts if isinstance(part, Drive | Load)]
    return (
        len(free) <= 1
        and not machine.tracks
        and not is_locking(machine)
        and machine.shaken_coordinate is None
        and all(s.parameter.rpartition(".")[0] in shaft_parts for s in machine.schedules)
    )


def needs_scalar_run(question: EnsembleQuestion, variants: Variants) -> np.ndarray:
    """Mask (M,) of the members that turn, or are driven, in another way than the machine of the question: its equations are
    not theirs, and they are run up one by one."""
    reference = _run_kind(question, question.machine)
    return np.asarray(np.array([_run_kind(question, m) != reference for m in variants.machines])[variants.machine_index])


def _run_kind(question: EnsembleQuestion, machine: Machine) -> tuple[object, ...]:
    """Return a key: whether only a limit ends the run-up; for the averaged equations, each rotor's sense and whether it has a
    drive."""
    slow = question.model == "slow"
    senses = [(sense_of(machine, r), bool(free_speed(machine, r))) for r in machine.rotors if slow]
    return runaway_limit(machine) is not None, *senses


@dataclass(frozen=True)
class Variants:
    """The machines of M members. machines: those that differ; machine_index: that of each member (M,)."""

    machines: tuple[Machine, ...]
    machine_index: np.ndarray

    @classmethod
    def from_values(cls, machine: Machine, values: Mapping[str, np.ndarray], count: int) -> Variants:
        """Vary a machine by values (M,) of some parameters. Raises ``InputError`` for one that a part does not allow."""
        if not values:
            return cls((machine,), np.zeros(count, int))
        rows, machine_index = np.unique(np.stack(list(values.values()), axis=1), axis=0, return_inverse=True)
        return cls(
            tuple(machine.with_values(dict(zip(values, row.tolist(), strict=True))) for row in rows), machine_index.reshape(-1)
        )

    def select(self, members: np.ndarray) -> Variants:
        """Select some of the members, by their numbers."""
        return Variants(self.machines, self.machine_index[members])

    @property
    def compact(self) -> Variants:
        """The same without machines that no member has."""
        machine_numbers, machine_index = np.unique(self.machine_index, return_inverse=True)
        return Variants(tuple(self.machines[i] for i in machine_numbers), machine_index.reshape(-1))

    def groups(self) -> Iterator[tuple[Machine, np.ndarray | slice]]:
        """Yield each machine with its members."""
        if len(self.machines) == 1:
            yield self.machines[0], slice(None)
            return
        order = np.argsort(self.machine_index, kind="stable")
        for members in np.split(order, np.flatnonzero(np.diff(self.machine_index[order])) + 1):
            yield self.machines[self.machine_index[members[0]]], members


@dataclass(frozen=True)
class FullEquations:
    """The full equations. turning_frame: that of the main rotor; None in the fixed one."""

    machine: Machine
    turning_frame: RelativeEquilibria | None

    @classmethod
    def of(cls, machine: Machine, varied_paths: Iterable[str] = ()) -> FullEquations:
        """Choose the frame that the machine allows, whatever values the varied parameters take; with contacts the fixed one."""
        if machine.tracks:
            return cls(machine, None)
        try:
            turning_frame = RelativeEquilibria.of(machine)
        except InputError:
            return cls(machine, None)
        omitted_names = set(machine.system.parameter_names) - set(turning_frame.system.parameter_names)  # zero gravity
        return cls(machine, None if omitted_names & set(varied_paths) else turning_frame)

    @property
    def system(self) -> System:
        """The integrated System."""
        return self.machine.system if self.turning_frame is None else self.turning_frame.system

    def starts(self, states: np.ndarray, variants: Variants) -> np.ndarray:
        """Convert states (n, M) of the machine's System into those (k, M) to start from."""
        return states if self.turning_frame is None else self.turning_frame.to_turning_frame(states)

    def quantities(self, variants: Variants, with_states: bool = False) -> MemberQuantities:
        """Return the equations with what is observed; with_states: states, too."""
        frame = {} if self.turning_frame is None else self.turning_frame.frame_symbols
        motion, extra_parameters = full_motion(self.machine, frame, variants.machines)
        return _member_quantities(self.machine, self.system, variants, motion, extra_parameters, with_states)


@dataclass(frozen=True)
class SlowEquations:
    """The averaged equations."""

    averaged_equations: AveragedEquations

    @property
    def system(self) -> System:
        """The integrated System."""
        return self.averaged_equations.system

    def starts(self, states: np.ndarray, variants: Variants) -> np.ndarray:
        """Convert states (n, M) of the machine's System into those (k, M) to start from."""
        initial = np.empty((len(self.system.states), states.shape[1]))
        for machine, members in variants.groups():
            equations = replace(self.averaged_equations, machine=machine)
            angles = {b.name: states[machine.row(b.coordinate.position), members] for b in machine.bodies}
            speeds = {b.name: _speeds(machine, b, states[:, members]) for b in machine.bodies}
            initial[:, members] = equations.state(angles, speeds)
        return initial

    def quantities(self, variants: Variants, with_states: bool = False) -> MemberQuantities:
        """Return the equations with what is observed; with_states: states, too."""
        system, machine = self.system, self.averaged_equations.machine
        main, states = machine.rotor.name, {s.name: s for s in self.system.states}
        sense = sp.Integer(self.averaged_equations.senses[main])
        phases = tuple(sense * states[f"{b.name}.phase"] for b in machine.group(machine.rotor)[1:])
        speed, amplitude = (system.output(name).expression for name in (f"speed[{main}]", "amplitude"))
        motion = Quantities((sense * speed, *phases), (amplitude**2,))
        return _member_quantities(machine, system, variants, motion, [], with_states)


Equations = FullEquations | SlowEquations


def member_equations(question: EnsembleQuestion, state: np.ndarray) -> Equations:
    """Return the equations of members of which one starts in a state (n,). Raises ``InputError`` for a machine without
    averaged equations, if these are requested."""
    if question.model == "full":
        return FullEquations.of(question.machine, question.varied_paths)
    return SlowEquations(slow_model(question.machine, state, question.inertia, question.order).averaged_equations)


def _member_quantities(
    machine: Machine,
    system: System,
    variants: Variants,
    motion: Quantities,
    extra_parameters: Sequence[tuple[sp.Symbol, np.ndarray]],
    with_states: bool,
) -> MemberQuantities:
    weights = np.array([_weights(m) for m in variants.machines])
    return MemberQuantities.of(system, _variant_values(system, variants), motion, weights, extra_parameters, with_states)


def _weights(machine: Machine) -> tuple[complex, ...]:
    """Return the unbalances of the main rotor and of the bodies about it, as shares of the rotor's."""
    weights, other_bodies = weights_of(machine, machine.rotor), [b for b in machine.bodies if b is not machine.rotor]
    return (weights[0], *(weights[1 + other_bodies.index(b)] for b in machine.group(machine.rotor)[1:]))


def parameters_of(system: System, variants: Variants) -> np.ndarray:
    """Return the parameters (M, p) of members, in a System's order."""
    return np.asarray(_variant_values(system, variants)[variants.machine_index])


def _variant_values(system: System, variants: Variants) -> np.ndarray:
    """Return the parameters (V, p) of each machine, in a System's order."""
    return np.array([system.values({name: m.values[name] for name in system.parameter_names}) for m in variants.machines])


def _speeds(machine: Machine, body: RotatingBody, states: np.ndarray) -> np.ndarray:
    c = body.coordinate
    if c.prescribed_velocity is None:
        return np.asarray(states[machine.row(c.velocity)])
    return np.full(states.shape[1], machine.prescribed_speed(c, 0.0)[0])
