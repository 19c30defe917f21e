"""Equations of the members of an ensemble, and views of their states: in the frame that turns with the main rotor
where the machine allows it, else in the fixed one; or the averaged equations."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wucht.analysis.averaged_equations import AveragedEquations
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.analysis.time_constants import runaway_limit
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.dynamics.sampling.ensembles import EnsembleQuestion
from wucht.dynamics.sampling.member_views import FullView, SlowView, VariantFunction
from wucht.dynamics.verdicts.locking import is_locking
from wucht.errors import InputError
from wucht.machines.changes import laws_in_pieces, release_events
from wucht.machines.machine import Machine
from wucht.machines.operation import axis_at_rest, free_speed, sense_of
from wucht.machines.tree import RotatingBody
from wucht.numerics.ensembles.members import Members
from wucht.system import System


def batching_obstacle(question: EnsembleQuestion) -> str | None:
    """Return the reason why the members cannot be integrated in batches, and are run up one by one; None if they can."""
    machine, slow = question.machine, question.model == "slow"
    free = [r for r in machine.rotors if r.coordinate.prescribed_velocity is None]
    pieces = "; ".join(laws_in_pieces(machine))
    reasons = {
        "several rotors are free to turn, and may synchronise": len(free) > 1,
        "rotors may be entrained by the vibration of the carrier": is_locking(machine),
        "the carrier is shaken": machine.shaken_coordinate is not None,
        "a rotor without a drive turns as it does at the start": slow and not all(free_speed(machine, r) for r in free),
        "nothing but a limit ends the run-up": runaway_limit(machine) is not None,
        "bodies are released on the way": bool(release_events(machine)),
        f"each member must stop where a law changes ({pieces})": bool(pieces),
    }
    return next((reason for reason, holds in reasons.items() if holds), None)


def needs_scalar_run(question: EnsembleQuestion, variants: Variants) -> np.ndarray:
    """Mask (M,) of the members that turn, or are driven, in another way than the machine of the question: its equations are
    not theirs, and they are run up one by one."""
    reference = _run_kind(question, question.machine)
    return np.asarray(np.array([_run_kind(question, m) != reference for m in variants.machines])[variants.machine_index])


def _run_kind(question: EnsembleQuestion, machine: Machine) -> tuple[object, ...]:
    """True if only a limit ends the run-up; and for the averaged equations the sense of each rotor, if it is driven."""
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
class NumberedMembers(Members):
    """Members with their numbers (M,) in the ensemble."""

    numbers: np.ndarray

    def part(self, first: int, last: int) -> NumberedMembers:
        """Return the members from ``first`` on, before ``last``."""
        selection = slice(first, last)
        return NumberedMembers(self.starts[selection], self.parameter_values[selection], self.numbers[selection])


@dataclass(frozen=True)
class FullEquations:
    """The full equations. turning: in the frame of the main rotor, None in the fixed one."""

    machine: Machine
    turning: RelativeEquilibria | None

    @classmethod
    def of(cls, machine: Machine, varied_paths: Iterable[str] = ()) -> FullEquations:
        """Choose the frame that the machine allows, whatever values the varied parameters take."""
        try:
            turning = RelativeEquilibria.of(machine)
        except InputError:
            return cls(machine, None)
        left_out = set(machine.system.parameter_names) - set(turning.system.parameter_names)  # gravity that is zero
        return cls(machine, None if left_out & set(varied_paths) else turning)

    @property
    def system(self) -> System:
        """The integrated System."""
        return self.machine.system if self.turning is None else self.turning.system

    @property
    def isotropic(self) -> bool:
        """True if the machine is invariant under rotation: its vibration torque then has one shape, whatever the phases."""
        return self.turning is not None

    def starts(self, states: np.ndarray, variants: Variants) -> np.ndarray:
        """Convert states (n, M) of the machine's System into those (k, M) to start from."""
        return states if self.turning is None else self.turning.to_turning_frame(states)

    def view(self, variants: Variants) -> FullView:
        """Return the view of their states."""
        machine, rotor, count = self.machine, self.machine.rotor.coordinate, len(self.machine.state_names)
        rows: tuple[int | None, ...] = tuple(range(count))
        if self.turning is not None:
            main = machine.row(rotor.position)
            rows = (*range(main), None, *range(main, count - 1))
        prescribed_speed = None
        if rotor.prescribed_velocity is not None:
            prescribed_speed = np.array([m.prescribed_speed(rotor, 0.0)[0] for m in variants.machines])
        rests = [axis_at_rest(m) for m in variants.machines]
        at_rest = np.array([[rest[n] for rest in rests] for n in machine.orbit]).reshape(len(machine.orbit), len(rests))
        names = [f"orbit.{v}{n}" for n in machine.orbit for v in ("", "v")]
        expressions = [machine.system.output(n).expression for n in names]
        orbit = VariantFunction.of(machine.system, expressions, (machine.system.values(m.values) for m in variants.machines))
        return FullView(machine, rows, prescribed_speed, at_rest, orbit)


@dataclass(frozen=True)
class SlowEquations:
    """The averaged equations."""

    averaged_equations: AveragedEquations

    @property
    def system(self) -> System:
        """The integrated System."""
        return self.averaged_equations.system

    @cached_property
    def isotropic(self) -> bool:
        """True if the machine is invariant under rotation: see ``FullEquations``."""
        return FullEquations.of(self.averaged_equations.machine).isotropic

    def starts(self, states: np.ndarray, variants: Variants) -> np.ndarray:
        """Convert states (n, M) of the machine's System into those (k, M) to start from."""
        initial = np.empty((len(self.system.states), states.shape[1]))
        for machine, members in variants.groups():
            one = replace(self.averaged_equations, machine=machine)
            angles = {b.name: states[machine.row(b.coordinate.position), members] for b in machine.bodies}
            initial[:, members] = one.state(angles, {b.name: _speeds(machine, b, states[:, members]) for b in machine.bodies})
        return initial

    def view(self, variants: Variants) -> SlowView:
        """Return the view of their states."""
        s, machine = self.system, self.averaged_equations.machine
        main = machine.rotor.name
        about = tuple(s.state_names.index(f"{b.name}.phase") for b in machine.group(machine.rotor)[1:])
        names = (f"speed[{main}]", "amplitude")
        values = [replace(self.averaged_equations, machine=m).values() for m in variants.machines]
        rates, outputs = (VariantFunction.of(s, e, values) for e in (s.derivatives, [s.output(n).expression for n in names]))
        return SlowView(self.averaged_equations.senses[main], about, rates, outputs)


Equations = FullEquations | SlowEquations


def member_equations(question: EnsembleQuestion, state: np.ndarray) -> Equations:
    """Return the equations of members of which one starts in a state (n,). Raises ``InputError`` for a machine without
    averaged equations, if these are requested."""
    if question.model == "full":
        return FullEquations.of(question.machine, question.varied_paths)
    return SlowEquations(slow_model(question.machine, state, question.inertia, question.order).averaged_equations)


def embedded_states(system: System, samples: np.ndarray) -> np.ndarray:
    """Embed samples (K, k, M) as (K, M, d): the states, with cosine and sine in place of each angle."""
    columns = list[np.ndarray]()
    for i, state in enumerate(system.states):
        columns += [np.cos(samples[:, i]), np.sin(samples[:, i])] if state in system.angles else [samples[:, i]]
    return np.stack(columns, axis=-1)


def parameters_of(system: System, variants: Variants) -> np.ndarray:
    """Return the parameters (M, p) of members, in a System's order."""
    rows = [system.values({name: m.values[name] for name in system.parameter_names}) for m in variants.machines]
    return np.asarray(np.array(rows)[variants.machine_index])


def _speeds(machine: Machine, body: RotatingBody, states: np.ndarray) -> np.ndarray:
    c = body.coordinate
    if c.prescribed_velocity is None:
        return np.asarray(states[machine.row(c.velocity)])
    return np.full(states.shape[1], machine.prescribed_speed(c, 0.0)[0])
