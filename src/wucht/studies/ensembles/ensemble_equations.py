"""What is integrated for the members of an ensemble, and how their states are seen: in the frame that turns with the main rotor
where the machine allows it, else in the fixed one; or the averaged equations."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from wucht.analysis.averaged import AveragedMachine
from wucht.analysis.relative_equilibria import RelativeEquilibria
from wucht.analysis.time_constants import runaway_limit
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.machines.tree import RotatingBody
from wucht.numerics.ensembles.members import Members
from wucht.numerics.flow.compiled import compile_system
from wucht.numerics.flow.program import Evaluator
from wucht.studies.ensembles.ensemble_question import EnsembleQuestion
from wucht.studies.motion.locking import is_locking
from wucht.studies.observables import Orbit
from wucht.studies.release_events import release_events
from wucht.studies.run_up.model import slow_model
from wucht.system import System

_STEP = 1e-4  # of the unit of time: over which the amplitude's change is taken


def singly(question: EnsembleQuestion) -> str | None:
    """Why the members cannot be integrated in batches, and are run up one by one; None where they can."""
    machine, slow = question.machine, question.model == "slow"
    free = [r for r in machine.rotors if r.coordinate.prescribed is None]
    reasons = {
        "its rotors may be entrained": is_locking(machine),
        "its carrier is shaken": machine.shaken is not None,
        "a rotor without a drive turns as it does at the start": slow and not all(free_speed(machine, r) for r in free),
        "nothing but a limit ends its run-up": runaway_limit(machine) is not None,
        "bodies are released on the way": bool(release_events(machine)),
        "it has contacts, schedules or tables": compile_system(machine.system, question.tolerance).locator is not None,
    }
    return next((why for why, holds in reasons.items() if holds), None)


@dataclass(frozen=True)
class Variants:
    """The machines of M members. machines: those that differ; of: which of them each member is (M,)."""

    machines: tuple[Machine, ...]
    of: np.ndarray

    @classmethod
    def among(cls, machine: Machine, values: Mapping[str, np.ndarray], count: int) -> Variants:
        """Of a machine with values (M,) of some parameters. Raises ``InputError`` for one that a part does not allow."""
        if not values:
            return cls((machine,), np.zeros(count, int))
        rows, of = np.unique(np.stack(list(values.values()), axis=1), axis=0, return_inverse=True)
        return cls(tuple(machine.with_values(dict(zip(values, row.tolist(), strict=True))) for row in rows), of.reshape(-1))

    def taken(self, members: np.ndarray) -> Variants:
        """Of some of the members, by their numbers."""
        return Variants(self.machines, self.of[members])

    @property
    def compact(self) -> Variants:
        """Without machines that are none of the members'."""
        used, of = np.unique(self.of, return_inverse=True)
        return Variants(tuple(self.machines[i] for i in used), of.reshape(-1))

    def groups(self) -> Iterator[tuple[Machine, np.ndarray | slice]]:
        """Each machine with its members."""
        if len(self.machines) == 1:
            yield self.machines[0], slice(None)
            return
        order = np.argsort(self.of, kind="stable")
        for mine in np.split(order, np.flatnonzero(np.diff(self.of[order])) + 1):
            yield self.machines[self.of[mine[0]]], mine


@dataclass(frozen=True)
class Numbered(Members):
    """Members that know their numbers (M,)."""

    numbers: np.ndarray

    def part(self, first: int, last: int) -> Numbered:
        """Those from ``first`` on, before ``last``."""
        here = slice(first, last)
        return Numbered(self.starts[here], self.parameters[here], self.numbers[here])


@dataclass(frozen=True)
class Sight:
    """Samples (K, M) of M members. speed: of the main rotor. phases: of the bodies about it (b, K, M), as they turn. square,
    rate: of the distance of its axis from where it rests, its square and the derivative of that."""

    speed: np.ndarray
    phases: np.ndarray
    square: np.ndarray
    rate: np.ndarray


@dataclass(frozen=True)
class FullEquations:
    """The full equations. turning: in the frame of the main rotor, None in the fixed one."""

    machine: Machine
    turning: RelativeEquilibria | None

    @classmethod
    def of(cls, machine: Machine) -> FullEquations:
        """In the frame that the machine allows."""
        try:
            return cls(machine, RelativeEquilibria.of(machine))
        except InputError:
            return cls(machine, None)

    @property
    def system(self) -> System:
        """What is integrated."""
        return self.machine.system if self.turning is None else self.turning.system

    @property
    def recurs(self) -> bool:
        """Whether a motion that goes on comes near the same states again: in the fixed frame angles grow and grow."""
        return self.turning is not None

    @property
    def isotropic(self) -> bool:
        """Whether the machine does not feel being turned: its vibration torque then has one shape, whatever the phases."""
        return self.turning is not None

    def starts(self, states: np.ndarray, variants: Variants) -> np.ndarray:
        """From states (n, M) of the machine's System those (k, M) to start from."""
        return states if self.turning is None else self.turning.turned(states)

    def seen(self, states: np.ndarray, variants: Variants) -> Sight:
        """Samples (K, k, M) of members."""
        count, size, members = states.shape
        flat = np.moveaxis(states, 1, 0).reshape(size, -1)
        whole = flat if self.turning is None else self.turning.fixed(flat, 0.0)
        machine, row = self.machine, self.machine.row
        rotor, about = machine.rotor.coordinate, [b.coordinate for b in machine.group(machine.rotor)[1:]]
        phases = whole[[row(c.position) for c in about]] - whole[row(rotor.position)]
        whole = whole.reshape(-1, count, members)
        if rotor.prescribed is None:
            speed = whole[row(rotor.velocity)]
        else:
            speed = np.tile([m.prescribed_speed(rotor, 0.0)[0] for m in variants.machines], (count, 1))[:, variants.of]
        square, rate = np.empty((2, count, members))
        for machine, mine in variants.groups():
            part = whole[:, :, mine].reshape(len(whole), -1)
            time = np.zeros(part.shape[1])
            orbit = Orbit.of(machine, time, self._orbit(time, part, machine.system.values(machine.values)))
            square[:, mine], rate[:, mine] = (x.reshape(count, -1) for x in (orbit.square, orbit.square_rate))
        return Sight(speed, phases.reshape(-1, count, members), square, rate)

    @cached_property
    def _orbit(self) -> Evaluator:
        names = [f"orbit.{v}{n}" for n in self.machine.orbit for v in ("", "v")]
        system = self.machine.system
        return Evaluator.of(system, [system.output(n).expression for n in names], names)


@dataclass(frozen=True)
class SlowEquations:
    """The averaged equations."""

    slow: AveragedMachine

    @property
    def system(self) -> System:
        """What is integrated."""
        return self.slow.system

    @property
    def recurs(self) -> bool:
        """See ``FullEquations``."""
        return True

    @cached_property
    def isotropic(self) -> bool:
        """See ``FullEquations``."""
        return FullEquations.of(self.slow.machine).isotropic

    def starts(self, states: np.ndarray, variants: Variants) -> np.ndarray:
        """From states (n, M) of the machine's System those (k, M) to start from."""
        begun = np.empty((len(self.system.states), states.shape[1]))
        for machine, mine in variants.groups():
            one = replace(self.slow, machine=machine)
            angles = {b.name: states[machine.row(b.coordinate.position), mine] for b in machine.bodies}
            begun[:, mine] = one.state(angles, {b.name: _speeds(machine, b, states[:, mine]) for b in machine.bodies})
        return begun

    def seen(self, states: np.ndarray, variants: Variants) -> Sight:
        """Samples (K, k, M) of members."""
        (count, size, members), machine = states.shape, self.slow.machine
        sense, main = self.slow.senses[machine.rotor.name], f"speed[{machine.rotor.name}]"
        about = [self.system.state_names.index(f"{b.name}.phase") for b in machine.group(machine.rotor)[1:]]
        speed, square, rate = np.empty((3, count, members))
        for variant, mine in variants.groups():
            part = np.moveaxis(states[:, :, mine], 1, 0).reshape(size, -1)
            values, time = replace(self.slow, machine=variant).values(), np.zeros(part.shape[1])
            rows, change = self._outputs(time, part, values), _STEP * Evaluator.of_rates(self.system).array(time, part, values)
            speed[:, mine], amplitude = rows[main].reshape(count, -1), rows["amplitude"]
            later, before = (self._outputs(time, part + way * change, values)["amplitude"] for way in (1, -1))
            square[:, mine] = (amplitude**2).reshape(count, -1)
            rate[:, mine] = (amplitude * (later - before) / _STEP).reshape(count, -1)
        return Sight(sense * speed, sense * np.moveaxis(states[:, about], 1, 0), square, rate)

    @cached_property
    def _outputs(self) -> Evaluator:
        s, main = self.system, f"speed[{self.slow.machine.rotor.name}]"
        return Evaluator.of(s, [s.output(n).expression for n in (main, "amplitude")], (main, "amplitude"))


Equations = FullEquations | SlowEquations


def equations_of(question: EnsembleQuestion, state: np.ndarray) -> Equations:
    """What is integrated for members of which one starts in a state (n,). Raises ``InputError`` for a machine without averaged
    equations, if these are asked for."""
    if question.model == "full":
        return FullEquations.of(question.machine)
    return SlowEquations(slow_model(question.machine, state, question.inertia, question.order).slow)


def places(system: System, samples: np.ndarray) -> np.ndarray:
    """Where samples (K, k, M) are (K, M, d): the states, and cosine and sine in place of each angle."""
    columns = list[np.ndarray]()
    for i, state in enumerate(system.states):
        columns += [np.cos(samples[:, i]), np.sin(samples[:, i])] if state in system.angles else [samples[:, i]]
    return np.stack(columns, axis=-1)


def parameters_of(system: System, variants: Variants) -> np.ndarray:
    """The parameters (M, p) of members, in a System's order."""
    rows = [system.values({name: m.values[name] for name in system.parameter_names}) for m in variants.machines]
    return np.asarray(np.array(rows)[variants.of])


def _speeds(machine: Machine, body: RotatingBody, states: np.ndarray) -> np.ndarray:
    c = body.coordinate
    if c.prescribed is None:
        return np.asarray(states[machine.row(c.velocity)])
    return np.full(states.shape[1], machine.prescribed_speed(c, 0.0)[0])
