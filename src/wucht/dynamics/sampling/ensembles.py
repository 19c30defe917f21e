"""An ensemble: the question about its members, the states in which they start, and their outcomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any, Literal

import numpy as np

from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.initial_state import angles_in, initial_state
from wucht.dynamics.run_ups.run_up import prepare_start
from wucht.dynamics.run_ups.run_up_models import slow_model
from wucht.dynamics.run_ups.run_variations import VariedQuantity, with_states
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.dynamics.work import TaskReport
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.tracks import check_gaps


def subprogress(report: TaskReport, begin: float, share: float) -> TaskReport:
    """Return the report of a part of the work, which begins when a share is done and is as large a share of all."""
    return lambda done: report(begin + share * done)


@dataclass(frozen=True)
class EnsembleQuestion:
    """Settings with which each member of an ensemble of one machine is run up and classified.

    Parameters
    ----------
    machine : Machine
    varied_paths : tuple of str, optional
        Of the parameters that differ from member to member.
    model : {"full", "slow"}
    inertia : bool, optional
    order : {1, 2}
        Model, inertia and order are as of a run-up.
    until : float, optional
        The end time of each member; None: until it has settled, at most ``longest`` turns.
    longest : float
        In turns of the main rotor.
    tolerance : float
        Of the integration.
    """

    machine: Machine
    varied_paths: tuple[str, ...] = ()
    model: Literal["full", "slow"] = "full"
    inertia: bool | None = None
    order: Literal[1, 2] = 1
    until: float | None = None
    longest: float = 25_000.0
    tolerance: float = 1e-6


_ARRAYS = ("outcome", "settling_time", "peak_amplitude", "end_time")


@dataclass(frozen=True)
class MemberOutcomes:
    """Outcomes of M members; ``counts`` has the number of each.

    Attributes
    ----------
    outcome : numpy.ndarray of int, (M,)
        Its place in ``tuple(Outcome)``.
    settling_time : numpy.ndarray, (M,)
        nan where the member has not settled.
    peak_amplitude : numpy.ndarray, (M,)
        The largest distance of the main rotor's axis from its rest position.
    end_time : numpy.ndarray, (M,)
        Of the member's motion.
    failures : tuple of (int, str)
        A sentence for each member that failed, by its index.
    """

    outcome: np.ndarray
    settling_time: np.ndarray
    peak_amplitude: np.ndarray
    end_time: np.ndarray
    failures: tuple[tuple[int, str], ...] = ()

    @classmethod
    def join(cls, parts: Sequence[MemberOutcomes]) -> MemberOutcomes:
        """Join the outcomes of several ensembles in a row."""
        begins = np.cumsum([0, *(len(p.outcome) for p in parts)])
        failures = tuple((int(begin) + i, reason) for begin, p in zip(begins, parts, strict=False) for i, reason in p.failures)
        return cls(**{name: np.concatenate([getattr(p, name) for p in parts]) for name in _ARRAYS}, failures=failures)

    @classmethod
    def join_in_order(cls, parts: Sequence[MemberOutcomes], numbers: Sequence[np.ndarray]) -> MemberOutcomes:
        """Join the outcomes of parts of an ensemble, in the order of the numbers that the members of each have in it."""
        return cls.join(parts).select(np.argsort(np.concatenate(numbers)))

    def with_failures(self, failures: Mapping[int, str]) -> MemberOutcomes:
        """Return the outcomes with the sentences of those that failed, by their index."""
        return replace(self, failures=tuple(sorted(failures.items())))

    def with_outcomes(self, members: np.ndarray, outcomes: MemberOutcomes) -> MemberOutcomes:
        """Return the outcomes with new ones for some members (k,), by their numbers."""
        arrays = {name: getattr(self, name).copy() for name in _ARRAYS}
        for name, values in arrays.items():
            values[members] = getattr(outcomes, name)
        failures = dict(self.failures) | {int(members[i]): reason for i, reason in outcomes.failures}
        return MemberOutcomes(**arrays, failures=tuple(sorted(failures.items())))

    def select(self, members: np.ndarray) -> MemberOutcomes:
        """Select the outcomes of some members, by their numbers (k,)."""
        place = {int(member): i for i, member in enumerate(members)} if self.failures else {}
        failures = sorted((place[i], reason) for i, reason in self.failures if i in place)
        return MemberOutcomes(**{name: getattr(self, name)[members] for name in _ARRAYS}, failures=tuple(failures))

    @property
    def is_impossible(self) -> np.ndarray:
        """Mask (M,) of the members that cannot be run: they have failed at their start."""
        return np.asarray(self.has_outcome((Outcome.FAILED,)) & (self.end_time == 0.0))

    def has_outcome(self, outcomes: Sequence[str]) -> np.ndarray:
        """Mask (M,) of the members with one of some outcomes."""
        return np.isin(self.outcome, [k for k, outcome in enumerate(OUTCOMES) if outcome in outcomes])

    def counts(self) -> dict[Outcome, int]:
        """Return the number of members with each outcome that occurs, in the order of ``OUTCOMES``."""
        numbers = np.bincount(self.outcome, minlength=len(OUTCOMES))
        return {o: int(k) for o, k in zip(OUTCOMES, numbers, strict=True) if k}


Runs = Callable[[np.ndarray, Mapping[str, np.ndarray]], MemberOutcomes]
Start = Mapping[str, Any]


def initial_states(
    machine: Machine, start: Start, quantities: Sequence[VariedQuantity], places: np.ndarray, location: str
) -> tuple[np.ndarray, dict[str, np.ndarray]]:
    """Return the states (n, M) in which members begin, and the values (M,) of each parameter that differs among them.

    places: the values (q, M) of the varied quantities. start: the rest of the start. Raises ``InputError`` at ``location`` for
    a value that the machine does not allow.
    """
    values = {v.name: row for v, row in zip(quantities, places, strict=True) if v.state is None}
    if not values and not any(v.state.is_limited for v in quantities if v.state is not None):
        return _linear_initial_states(machine, start, quantities, places, location), values
    machines: dict[tuple[float, ...], Machine] = {}
    starts = np.empty((len(machine.state_names), places.shape[1]))
    for m, place in enumerate(places.T.tolist()):
        parameters = tuple(x for v, x in zip(quantities, place, strict=True) if v.state is None)
        if parameters not in machines:  # the rest position of the carrier depends on the parameters
            machines[parameters] = machine_at(machine, quantities, place, location)
        member = with_default_start(machines[parameters], start_at(start, quantities, place))
        starts[:, m] = initial_state(machines[parameters], member, location)
    return starts, values


def _linear_initial_states(
    machine: Machine, start: Start, quantities: Sequence[VariedQuantity], places: np.ndarray, location: str
) -> np.ndarray:
    """Return the states (n, M) of one machine: a state is a linear function of the values in its start."""
    origin = np.zeros(len(quantities))
    first = initial_state(machine, start_at(start, quantities, origin.tolist()), location)
    starts = np.repeat(first[:, None], places.shape[1], axis=1)
    for unit, row in zip(np.eye(len(quantities)), places, strict=True):
        starts += (initial_state(machine, start_at(start, quantities, unit.tolist()), location) - first)[:, None] * row
    return starts


def machine_at(machine: Machine, quantities: Sequence[VariedQuantity], place: Sequence[float], location: str) -> Machine:
    """Return the machine with its parameters at a place (q,). Raises ``InputError``."""
    parameters = {v.name: x for v, x in zip(quantities, place, strict=True) if v.state is None}
    try:
        return machine.with_values(parameters) if parameters else machine
    except InputError as error:
        raise error.with_prefix(location) from None


def start_at(start: Start, quantities: Sequence[VariedQuantity], place: Sequence[float]) -> dict[str, Any]:
    """Return the start at a place (q,), as in a study file."""
    return with_states(start, [(v.state, x) for v, x in zip(quantities, place, strict=True) if v.state is not None])


def unrunnable_members(machine: Machine, starts: np.ndarray, values: Mapping[str, np.ndarray]) -> dict[int, str]:
    """Return the reasons why members with these starts (n, M) and values (M,) of parameters cannot be run, by their index.

    The bodies of a track overlap there.
    """
    reasons: dict[int, str] = {}
    for m, start in enumerate(starts.T if machine.tracks else ()):
        parameters = {name: float(row[m]) for name, row in values.items()}
        try:
            member = machine.with_values(parameters) if parameters else machine
            check_gaps(member, angles_in(member, start), "study.start")
        except InputError as error:
            reasons[m] = error.explanation
    return reasons


def omission_warnings(
    question: EnsembleQuestion, start: Start, quantities: Sequence[VariedQuantity], place: Sequence[float]
) -> tuple[str, ...]:
    """Return warnings of what the averaged equations, if requested, omit of the member at a place (q,).

    Raises ``InputError`` if there are no such equations, and if nothing would turn.
    """
    machine = machine_at(question.machine, quantities, place, "study")
    machine, initial = prepare_start(machine, start_at(start, quantities, place), question.until or 0.0)
    return () if question.model == "full" else slow_model(machine, initial, question.inertia, question.order).warnings


def omissions_among(
    question: EnsembleQuestion, start: Start, quantities: Sequence[VariedQuantity], places: np.ndarray, location: str
) -> tuple[str, ...]:
    """Return ``omission_warnings`` of the first of the members at places (q, M) that can be run.

    Raises ``InputError`` at ``location`` for a value that the machine does not allow, too.
    """
    impossible = unrunnable_members(question.machine, *initial_states(question.machine, start, quantities, places, location))
    first = next((m for m in range(places.shape[1]) if m not in impossible), 0)
    return omission_warnings(question, start, quantities, places[:, first].tolist())


def refused_members(
    machine: Machine, start: Start, quantities: Sequence[VariedQuantity], places: np.ndarray, location: str
) -> dict[int, str]:
    """Return the reasons why the machine does not allow the values of members at places (q, M), by their index."""
    try:
        initial_states(machine, start, quantities, places, location)
    except InputError as error:
        if places.shape[1] == 1:
            return {0: error.explanation}
        alone = (refused_members(machine, start, quantities, place[:, None], location) for place in places.T)
        return {m: reasons[0] for m, reasons in enumerate(alone) if reasons}
    return {}


def outcomes_of_rest(count: int, reasons: Mapping[int, str], run: Callable[[np.ndarray], MemberOutcomes]) -> MemberOutcomes:
    """Return the outcomes of members: those with a reason, by their index, have failed at their start.

    run: returns the outcomes of the other ones, by their numbers.
    """
    outcome, unknown = np.full(count, OUTCOMES.index(Outcome.FAILED), np.int8), np.full(count, np.nan)
    members = MemberOutcomes(outcome, unknown, unknown, np.zeros(count), tuple(sorted(reasons.items())))
    possible = np.array([m for m in range(count) if m not in reasons], int)
    return members.with_outcomes(possible, run(possible)) if len(possible) else members


def run_possible(run: Runs, machine: Machine, starts: np.ndarray, values: Mapping[str, np.ndarray]) -> MemberOutcomes:
    """Run members with starts (n, M) and values (M,) of parameters; those that cannot be run have failed.

    run: returns the outcomes of those that can.
    """
    reasons, count = unrunnable_members(machine, starts, values), starts.shape[1]
    if not reasons:
        return run(starts, values)

    def run_some(members: np.ndarray) -> MemberOutcomes:
        return run(starts[:, members], {name: row[members] for name, row in values.items()})

    return outcomes_of_rest(count, reasons, run_some)
