"""The study ``run-up``: start the machine and see what becomes of it."""

from __future__ import annotations

import time as clock
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import lru_cache, partial
from typing import TYPE_CHECKING, Any, ClassVar

import numpy as np
import sympy as sp

from wucht.documents import refuse_unknown
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.vibration import free_speed
from wucht.numerics.flow.compiled import DEFAULT_TOLERANCE, CompiledSystem, compile_system
from wucht.numerics.flow.integrate import integrate
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory
from wucht.quantities import Unit
from wucht.results.outcomes import Outcome
from wucht.studies.keeper import SAVE_EVERY_S, Keeper
from wucht.studies.keys import engine_of, positive, start_of, tolerance_of
from wucht.studies.kinds import Checkpoint, Progress
from wucht.studies.release import placed
from wucht.studies.run_up.cases import read_cases
from wucht.studies.run_up.model import FullModel, Model, slow_model
from wucht.studies.run_up.plan import Plan
from wucht.studies.run_up.verdict import Verdict, judge
from wucht.studies.start import start_state
from wucht.system import System

if TYPE_CHECKING:
    import xarray as xr

ABSCISSAE = ("time", "phi", "psi")
MODELS = ("full", "slow", "both")
_SETTLED_TOLERANCE = 1e-5
_NO_ACCELERATION = 1e-12
_JUDGED_IF_COARSE = 10_000  # samples: no outcome comes of them, only phases and the like


@dataclass(frozen=True)
class RunUp:
    """Start the machine and see what becomes of it.

    It runs ``until`` a time, for ``turns`` of the main rotor, or, without either, until it has settled. start: see
    ``start_state``. starts: many of them, or ``values`` of the parameter ``along``: a run each, in one result. over: the
    abscissa of the figure, ``"time"``, ``"phi"`` (the rotor's angle) or ``"psi"`` (mean phase of its bodies). model: the
    ``"full"`` equations, the ``"slow"`` ones, or ``"both"``; inertia: whether the slow ones keep that of the balancing bodies
    (None: where one of them is not damped), order: theirs, 1 or 2. tolerance: of the integration. speed_limit: beyond it the
    run ends as ``runaway``. engine: ``"heyoka"``, ``"scipy"``, ``"scipy-radau"`` or None for the best installed.
    """

    until: float | None = None
    turns: float | None = None
    start: Mapping[str, Any] = field(default_factory=dict)
    starts: tuple[Mapping[str, Any], ...] = ()
    along: str | None = None
    values: tuple[float, ...] = ()
    over: str = "time"
    model: str = "full"
    inertia: bool | None = None
    order: int = 1
    tolerance: float = DEFAULT_TOLERANCE
    speed_limit: float | None = None
    engine: str | None = None

    kind: ClassVar[str] = "run-up"
    keys: ClassVar[tuple[str, ...]] = (
        "kind",
        "until",
        "turns",
        "settled",
        "start",
        "starts",
        "along",
        "values",
        "over",
        "model",
        "inertia",
        "order",
        "tolerance",
        "speed_limit",
        "engine",
    )

    @classmethod
    def read(cls, table: Mapping[str, Any], machine: Machine) -> RunUp:
        """From the table ``[study]``. Raises ``InputError``, located from ``study`` on."""
        refuse_unknown(table, cls.keys, "study")
        model, inertia, order = read_model(table)
        over = table.get("over", "time")
        if over not in ABSCISSAE:
            raise InputError("study.over", over, f"allowed is {', '.join(ABSCISSAE)}")
        if over == "psi" and not any(b.about == machine.rotor.name for b in machine.bodies):
            raise InputError("study.over", over, "allowed is 'time' or 'phi': no body turns about the rotor")
        starts, along, values = read_cases(table, machine)
        until, turns = _extent(table, Unit(machine.units.time, "time"))
        return cls(
            over=over,
            model=model,
            inertia=inertia,
            order=order,
            starts=starts,
            along=along,
            values=values,
            until=until,
            turns=turns,
            start=start_of(table),
            tolerance=tolerance_of(table),
            speed_limit=positive(table, "speed_limit", Unit(machine.units.speed, "speed")),
            engine=engine_of(table),
        )

    def check(self, machine: Machine) -> None:
        """Raises ``InputError`` where the start does not fit the machine, or where nothing would turn."""
        for case in self.cases():
            case_machine = machine if case.along is None else machine.with_values({case.along: case.values[0]})
            placed_machine, initial = prepared(case_machine, case)
            if case.model != "full":
                slow_model(placed_machine, initial, case.inertia, case.order)

    def cases(self) -> list[RunUp]:
        """The runs that are asked for: one with a start and a value each."""
        starts = self.starts or (self.start,)
        values: list[tuple[float, ...]] = [(v,) for v in self.values] or [()]
        return [replace(self, start=s, starts=(), values=v) for v in values for s in starts]


def read_model(table: Mapping[str, Any]) -> tuple[str, bool | None, int]:
    """``model``, ``inertia`` and ``order``. Raises ``InputError``."""
    model, inertia, order = table.get("model", "full"), table.get("inertia"), table.get("order", 1)
    if model not in MODELS:
        raise InputError("study.model", model, f"allowed is {', '.join(map(repr, MODELS))}")
    if inertia is not None and not isinstance(inertia, bool):
        raise InputError("study.inertia", inertia, "allowed is true or false: whether the slow equations keep it")
    if order not in (1, 2) or isinstance(order, bool):
        raise InputError("study.order", order, "allowed is 1 or 2: the order of the slow equations")
    if model == "full" and (inertia is not None or "order" in table):
        given = "inertia" if inertia is not None else "order"
        raise InputError(f"study.{given}", table[given], "allowed only with model = 'slow' or 'both'")
    return model, inertia, int(order)


def _extent(table: Mapping[str, Any], time: Unit) -> tuple[float | None, float | None]:
    """``until`` and ``turns``: one of them, or neither to run until settled. Raises ``InputError``."""
    until, turns, settled = table.get("until"), table.get("turns"), table.get("settled")
    if isinstance(until, Mapping):
        refuse_unknown(until, ("turns", "settled"), "study.until")
        if not until:
            raise InputError("study.until", {}, "allowed is a time, { turns = NUMBER } or { settled = true }")
        turns, settled = until.get("turns", turns), until.get("settled", settled)
        until = None
    if until == "settled":
        until, settled = None, True
    if settled is not None and not isinstance(settled, bool):
        raise InputError("study.settled", settled, "allowed is true or false")
    if sum(x is not None for x in (until, turns, settled or None)) > 1:
        raise InputError("study.until", None, "allowed is one of until, turns and settled")
    if settled is False and until is None and turns is None:
        raise InputError("study.settled", False, "needed is until = a time or turns = a number, if not settled = true")
    return positive({"until": until}, "until", time), positive({"turns": turns}, "turns", Unit("", "number of turns"))


@np.errstate(all="ignore")  # a run that fails says so in a sentence, not by warnings about overflow
def run_up(
    machine: Machine,
    question: RunUp,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """Run the machine and judge what became of it.

    progress: called with the time reached and the time to reach. checkpoint: called now and then with the result so far, for
    saving. resume: an earlier, unfinished result of the same input, to continue. Returns the Dataset described in
    ``run_up.result``.
    Raises ``InputError`` for a start that does not fit the machine; a run that fails is recorded in the Dataset.
    """
    if question.starts or question.values:
        from wucht.studies.run_up.many import run_ups

        return run_ups(machine, question, progress, checkpoint, resume)
    return single_run_up(machine, question, progress, checkpoint, resume)


def single_run_up(
    machine: Machine,
    question: RunUp,
    progress: Progress | None = None,
    checkpoint: Checkpoint | None = None,
    resume: xr.Dataset | None = None,
) -> xr.Dataset:
    """A run from one start: see ``run_up``."""
    if question.model == "both":
        from wucht.studies.run_up.both import run_up_both

        return run_up_both(machine, question, progress, checkpoint, resume)
    from wucht.studies.run_up.result import restore, result

    begun = clock.perf_counter()
    machine, initial = prepared(machine, question)
    plan = Plan.of(machine, question, initial)
    slow = question.model == "slow"
    model: Model = slow_model(machine, initial, question.inertia, question.order) if slow else FullModel(machine, initial)
    flow = compile_system(model.system, question.tolerance, model.events(plan.events), question.engine)
    # A slow run is quick and keeps no full states that it could go on from: it begins again.
    trajectory = restore(machine, question, resume) if resume is not None and not slow else None

    def judged(t: Trajectory) -> Verdict:
        return judged_by(machine, plan, model.seen(t))

    def described(t: Trajectory) -> xr.Dataset:
        said = [*plan.warnings, *model.warnings, *(model.remedies if t.failure else ())]
        return result(machine, question, flow, model, t, judged(t), said, begun)

    keeper = Keeper(checkpoint)
    for goal in plan.goals():
        while trajectory is None or trajectory.end_time < goal - plan.step / 2:
            trajectory = _extend(model, flow, trajectory, goal, plan, progress)
            if trajectory.ended:
                break
            keeper(partial(described, trajectory))
        if trajectory.ended or (plan.open_ended and _decided(plan, judged(trajectory))):
            break
    assert trajectory is not None
    return described(trajectory)


def judged_by(machine: Machine, plan: Plan, trajectory: Trajectory) -> Verdict:
    """The verdict on a trajectory of the machine, none where it is sampled too coarsely."""
    end = trajectory.end_time
    free = free_speed(machine.at(end), machine.rotor, end)
    if not plan.too_coarse:
        return judge(machine, trajectory, free)
    verdict = judge(machine, trajectory.tail(_JUDGED_IF_COARSE), free)
    if verdict.outcome is Outcome.FAILED:
        return verdict
    return replace(verdict, outcome=Outcome.UNIDENTIFIED, advice="too few samples a turn are stored to tell")


def prepared(machine: Machine, question: RunUp) -> tuple[Machine, np.ndarray]:
    """The machine with the bodies of its tracks in the order of the start, and the state (n,) to start from.

    Raises ``InputError`` where the start does not fit the machine, or where nothing would turn.
    """
    initial = start_state(machine, question.start)
    machine = placed(machine, initial)
    end = question.until or 0.0
    prescribed = [
        float(np.abs(machine.prescribed_speed(b.coordinate, np.linspace(0.0, end, 100))).max())
        for b in machine.bodies
        if b.coordinate.prescribed is not None
    ]
    if question.speed_limit is not None and max(prescribed, default=0.0) > question.speed_limit:
        raise InputError("study.speed_limit", question.speed_limit, "allowed is more than the speed that the drive prescribes")
    if not any(prescribed) and machine.shaken is None and not machine.schedules and _at_rest(machine, initial):
        needed = "needed is [machine.drive] or a speed in study.start"
        raise InputError(
            "machine.drive", None, f"the machine has neither a drive nor an initial speed: nothing would turn; {needed}"
        )
    return machine, initial


def _at_rest(machine: Machine, initial: np.ndarray) -> bool:
    """Whether no body turns, and none begins to."""
    system = machine.system
    turning = [b.coordinate.velocity for b in machine.bodies if b.coordinate.prescribed is None]
    speeds = [initial[system.states.index(v)] for v in turning]
    if any(speeds):
        return False
    with np.errstate(all="ignore"):
        found = _accelerations(system, tuple(turning))(np.zeros(1), initial[:, None], system.values(machine.values))
    return all(abs(float(a[0])) < _NO_ACCELERATION for a in found.values())


@lru_cache(maxsize=16)  # asked when a file is read, and again when it is run
def _accelerations(system: System, velocities: tuple[sp.Symbol, ...]) -> Evaluator:
    rates = [system.derivatives[system.states.index(v)] for v in velocities]
    return Evaluator.of(system, rates, [v.name for v in velocities])


def _decided(plan: Plan, verdict: Verdict) -> bool:
    if plan.until_settled:
        return verdict.settled_within(_SETTLED_TOLERANCE)
    return verdict.outcome in (Outcome.STOPPED, Outcome.OSCILLATING)  # the turns asked for will never be made


def _extend(
    model: Model,
    flow: CompiledSystem,
    so_far: Trajectory | None,
    goal: float,
    plan: Plan,
    progress: Progress | None,
) -> Trajectory:
    begin = 0.0 if so_far is None else so_far.end_time
    state = model.initial if so_far is None else so_far.end_state
    values = model.values if so_far is None else so_far.parameters
    grid = np.linspace(begin, goal, max(1, round((goal - begin) / plan.step)) + 1)
    report = None if progress is None else lambda t: progress(t, max(plan.expected_end, goal))
    leg = integrate(flow, state, values, grid, report, SAVE_EVERY_S, plan.energy)
    return leg if so_far is None else so_far.joined(leg)


def summary(result: xr.Dataset) -> dict[str, Any]:
    """The summary of the contract from a result."""
    import json

    found: dict[str, Any] = json.loads(result.attrs["summary"])
    return found


__all__ = ["RunUp", "run_up", "summary"]
