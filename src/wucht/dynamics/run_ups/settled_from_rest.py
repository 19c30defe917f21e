"""Which of its steady states a machine reaches from rest: a run-up from its default start, until it has settled.

Steady states and their stability are those of the averaged equations. Where several are stable, or the motor does not start, a
stable one need not be reached: only a motion decides that.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import partial

import numpy as np

from wucht.dynamics.run_ups.coasting import driving_machine
from wucht.dynamics.run_ups.horizon import RunSettings
from wucht.dynamics.run_ups.operating_points import SteadyState
from wucht.dynamics.run_ups.run_up import Motion, RunUpCase, prepare_start, run_up
from wucht.dynamics.verdicts.outcomes import OPEN_OUTCOMES, PHASE_TOLERANCE, Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed
from wucht.numerics.angles import wrap_to_pi

_LONGEST = 20_000  # turns, or vibrations, at the highest speed expected: a longer run is not worth its time here
_APART = 0.01  # rad, between bodies at the start
_STANDSTILL = 1e-6  # of the largest speed
_UNBALANCE = 0.1  # share of the rotor's unbalance by which averaged and full equations differ at most
_ALIKE = 1e-3  # difference of distances: states that are mirrored, or in which equal bodies are exchanged
_AT_REST = (Outcome.STOPPED, Outcome.OSCILLATING, Outcome.NOT_STARTED)
_STEADY = (Outcome.COMPENSATED, Outcome.PASSED, Outcome.CAPTURED, Outcome.SYNCHRONISED)


@dataclass(frozen=True)
class SettledFromRest:
    """The end of a run-up from rest.

    outcome: None where there is no such run. sentence: on the end, or why it is not known. speeds: of the rotors, by name, in
    magnitude. phases, share: as of ``SteadyState``. end_time: of the run.
    """

    outcome: str | None
    sentence: str
    speeds: Mapping[str, float] = field(default_factory=dict)
    phases: Mapping[str, float] = field(default_factory=dict)
    share: float | None = None
    end_time: float | None = None

    @classmethod
    def of(cls, motion: Motion) -> SettledFromRest:
        """Return the end of a run-up."""
        machine, verdict, end_time = motion.case.machine, motion.verdict, motion.trajectory.end_time
        if verdict.outcome in OPEN_OUTCOMES:
            reason = motion.trajectory.failure or verdict.advice or verdict.sentence
            return cls(str(verdict.outcome), reason, end_time=end_time)
        sentence = verdict.sentence
        speeds, phases = {machine.rotor.name: abs(verdict.speed)}, dict[str, float]()
        if verdict.locking is not None:
            speeds = {name: abs(speed) for name, speed in verdict.locking.final_speeds.items()}
            phases = {name: phase for name, phase in verdict.locking.phases.items() if name in speeds}
        if verdict.outcome not in _AT_REST:
            unit, several = f" {machine.units.speed}".rstrip(), len(speeds) > 1
            magnitudes = {n: w if w > _STANDSTILL * max(speeds.values()) else 0.0 for n, w in speeds.items()}
            by_rotor = ", ".join(f"{name} {speed:.4g}" if several else f"{speed:.4g}" for name, speed in magnitudes.items())
            sentence += f" ({by_rotor}{unit})"
        return cls(str(verdict.outcome), sentence, speeds, phases, verdict.residual, end_time)

    def is_reached(self, rotor: str, states: Sequence[SteadyState]) -> list[bool | None]:
        """Return for each steady state, whose speeds are of a rotor, whether it is this end; None: it is not known.

        It is the nearest one within the reach of its speed, a tenth of the unbalance, and a tenth of a turn of the phases.
        """
        if self.outcome is None or self.outcome in OPEN_OUTCOMES or (self.speeds and rotor not in self.speeds):
            return [None] * len(states)
        if self.outcome not in _STEADY:
            return [False] * len(states)
        distances = [self._distance(rotor, state) for state in states]
        nearest = min(distances, default=0.0)
        return [distance <= min(1.0, nearest + _ALIKE) for distance in distances]

    def _distance(self, rotor: str, state: SteadyState) -> float:
        """Return how far a state is from this end: the largest of its differences, as a share of what is allowed."""
        differences = [abs(self.speeds[rotor] - state.speed) / (state.reach * state.speed)]
        differences += [
            abs(float(wrap_to_pi(phase - self.phases[name]))) / PHASE_TOLERANCE
            for name, phase in state.phases.items()
            if name in self.phases
        ]
        if state.share is not None and self.share is not None:
            differences.append(abs(state.share - self.share) / _UNBALANCE)
        return max(differences)


@dataclass(frozen=True)
class FromRest:
    """The ends of run-ups of a machine from rest: a unit of work."""

    ends: tuple[SettledFromRest, ...]

    @classmethod
    def of(cls, machine: Machine, rotor: str, states: Sequence[SteadyState], work: Work) -> FromRest:
        """Run a machine up from its default start, its bodies a little apart, until it has settled.

        states: steady states, whose speeds are of a rotor. If some of them are not reached, a second run has these differences
        reversed, unless the first is undecided: without a side that the machine prefers, they decide between states.
        """
        return work.unit("from rest", partial(cls._run, machine, rotor, states, work))

    @classmethod
    def _run(cls, machine: Machine, rotor: str, states: Sequence[SteadyState], work: Work) -> FromRest:
        last = machine.at(machine.breakpoints[-1])
        if machine.schedules and not free_speed(last, last.rotor) and free_speed(driving_machine(machine), last.rotor):
            return cls((SettledFromRest(None, "the schedules switch the drive off again"),))
        try:
            machine, initial = prepare_start(machine, {})
        except InputError as error:
            return cls((SettledFromRest(None, error.explanation),))
        first = cls((_run_up(machine, _apart(machine, initial, 1), work.part("", 0.0, 0.5)),))
        answers = first.is_reached(rotor, states)
        if len(machine.bodies) == 1 or first.is_standing or None in answers or all(answers):
            return first
        return cls((*first.ends, _run_up(machine, _apart(machine, initial, -1), work.part("", 0.5, 1.0))))

    def is_reached(self, rotor: str, states: Sequence[SteadyState]) -> list[bool | None]:
        """Return for each steady state whether a run ends in it; None: that is not known. See ``SettledFromRest``."""
        answers = zip(*(end.is_reached(rotor, states) for end in self.ends), strict=True)
        return [True if True in of_state else None if None in of_state else False for of_state in answers]

    def sentence(self, answers: Sequence[bool | None], labels: Sequence[str], with_reason: bool = True) -> str:
        """Return a clause on the stable states that are reached from rest, by ``is_reached``, with their labels.

        with_reason: also why not, where none is.
        """
        names = dict.fromkeys(label for label, yes in zip(labels, answers, strict=True) if yes)
        one_of_each = {end.outcome: end.sentence for end in reversed(self.ends)}
        ends = f": {'; or '.join(reversed(one_of_each.values()))}" if with_reason else ""
        if len(answers) == 1 and names:
            return "reached from rest"
        if names:
            return f"from rest it reaches {' or '.join(names)}"
        if None in answers:
            subject = "it is" if len(answers) == 1 else "one of them is"
            return f"whether {subject} reached from rest is not known{ends}"
        return f"{'not' if len(answers) == 1 else 'none of them is'} reached from rest{ends}"

    @property
    def is_standing(self) -> bool:
        """True if the drive does not start the machine."""
        return all(end.outcome == Outcome.NOT_STARTED for end in self.ends)


def _run_up(machine: Machine, start: np.ndarray, work: Work) -> SettledFromRest:
    """Run a machine up from a state (n,) until it has settled, or for a long time."""
    case = RunUpCase.from_state(machine, start, RunSettings())
    longest = _LONGEST * case.horizon.span
    for (motion,) in run_up(case, Work()):
        end_time = motion.trajectory.end_time
        work.report(end_time / longest, "run-up from rest")
        if end_time >= longest:
            break
    return SettledFromRest.of(motion)


def _apart(machine: Machine, initial: np.ndarray, sense: int) -> np.ndarray:
    """Return a state (n,) in which bodies are a little apart: equal ones at the same place would stay together for ever."""
    on_tracks = {b.name for track in machine.tracks for b in track.bodies}
    free = [b for b in machine.bodies if b is not machine.rotor and b.release is None and b.name not in on_tracks]
    state = initial.copy()
    for k, body in enumerate(free, 1):
        state[machine.row(body.coordinate.position)] += sense * k * _APART
    return state
