"""A machine run up from an initial state: integrated leg by leg, observed, and judged."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from functools import cached_property, partial
from typing import Any

import numpy as np

from wucht.dynamics.run_ups.hanging_start import with_default_start
from wucht.dynamics.run_ups.horizon import SPEED_LIMIT, Grid, Horizon, RunSettings
from wucht.dynamics.run_ups.initial_state import initial_state, machine_in_state
from wucht.dynamics.run_ups.observed_integration import Leg, ObservedIntegration
from wucht.dynamics.run_ups.run_up_models import FullModel, slow_model
from wucht.dynamics.verdicts.certificate import MotionEnd, certified_verdict
from wucht.dynamics.verdicts.judging import judge
from wucht.dynamics.verdicts.noise import Noise
from wucht.dynamics.verdicts.observation import MotionObserver, Observation, Rows
from wucht.dynamics.verdicts.verdict import Verdict
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.machine import Machine
from wucht.machines.operation import free_speed_from, net_torque
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.events import Event
from wucht.numerics.flow.program import Evaluator
from wucht.numerics.flow.trajectory import Trajectory

_SAMPLES_A_LEG = 2048
_FULL_SHARE = 0.9  # of the time that a run of both models takes
_NO_ACCELERATION = 1e-12


@dataclass(frozen=True)
class RunUpCase:
    """Definition of one run of a machine; ``RunUpCase.of`` makes it from a start and settings.

    Attributes
    ----------
    machine : Machine
    horizon : Horizon
        Legs and end of the run.
    models : tuple of FullModel
        The equations to integrate, the full ones first, each with its initial state.
    settings : RunSettings
    """

    machine: Machine
    horizon: Horizon
    models: tuple[FullModel, ...]
    settings: RunSettings

    @classmethod
    def of(cls, machine: Machine, start: Mapping[str, Any], settings: RunSettings, location: str = "study.start") -> RunUpCase:
        """Return the run of a machine from a start, as a study file states it.

        Parameters
        ----------
        machine : Machine
        start : mapping
            As for ``initial_state``; empty for a start at rest, hanging under gravity: ``hanging_start``.
        settings : RunSettings
        location : str
            Of the start, for messages.

        Returns
        -------
        RunUpCase

        Raises
        ------
        InputError
            Where start and settings do not fit the machine, or it has no averaged equations.
        """
        machine, initial = prepare_start(machine, start, settings.until or 0.0, settings.speed_limit, location)
        return cls.from_state(machine, initial, settings)

    @classmethod
    def from_state(cls, machine: Machine, initial: np.ndarray, settings: RunSettings) -> RunUpCase:
        """Return the run of a machine from a state (n,) at t = 0; see ``of``."""
        models = () if settings.model == "slow" else (FullModel(machine, initial),)
        if settings.model != "full":
            models = (*models, slow_model(machine, initial, settings.inertia, settings.order))
        return cls(machine, Horizon.of(machine, settings, initial), models, settings)

    @property
    def observer(self) -> MotionObserver:
        """The observer of the motion."""
        return MotionObserver(self.machine, self.horizon.span, Noise.of(self.horizon.tolerance))


@dataclass(frozen=True)
class Motion:
    """The motion of one model.

    Attributes
    ----------
    case : RunUpCase
    model : FullModel
        The integrated equations.
    integration : ObservedIntegration
    trajectory : Trajectory
        The stored samples, of the model's System; ``machine_motion`` is the machine's.
    last : Leg
        The last leg.
    """

    case: RunUpCase
    model: FullModel
    integration: ObservedIntegration[Observation]
    trajectory: Trajectory
    last: Leg[Observation]

    @cached_property
    def machine_motion(self) -> Trajectory:
        """The machine's motion."""
        return self.model.machine_motion(self.trajectory)

    @property
    def rows(self) -> Rows:
        """The states and outputs (N,) of the machine's motion, by name: computed anew, larger than what is stored."""
        return self.model.rows(self.trajectory, self.machine_motion)

    @property
    def compiled_system(self) -> CompiledSystem:
        """The equations that are integrated."""
        return self.integration.compiled_system

    @cached_property
    def observation(self) -> Observation:
        """The record of the motion until its end."""
        return self.integration.observation(self.last)

    @cached_property
    def verdict(self) -> Verdict:
        """The outcome, and the numbers behind it."""
        return verdict_at_end(self.case.machine, self.observation, self.trajectory, self.compiled_system)


def verdict_at_end(
    machine: Machine, observation: Observation, motion: Trajectory, compiled_system: CompiledSystem | None = None
) -> Verdict:
    """Judge a motion that was observed until its end. compiled_system: its equations, with which the verdict is certified."""
    free = free_speed_at_end(machine, observation, motion.end_time)
    verdict = judge(machine, observation, free, motion.failure, motion.stopped_by == SPEED_LIMIT)
    if compiled_system is None:
        return verdict
    end = motion.final_parameter_values, motion.end_state, motion.end_time
    return certified_verdict(machine, verdict, MotionEnd(compiled_system.system, lambda: compiled_system, *end))


def free_speed_at_end(machine: Machine, observation: Observation, end: float) -> float | None:
    """Return the speed that the drive reaches without vibration from that at the end of a motion: ``free_speed_from``."""
    last = observation.main.sample
    speed = 0.0 if last is None else float(last.speeds[0, -1])
    return free_speed_from(machine.at(end), machine.rotor, speed, end)


def run_up(case: RunUpCase, work: Work) -> Iterator[tuple[Motion, ...]]:
    """Yield the motions of one run, after each leg; a second model goes as far as the first did.

    Parameters
    ----------
    case : RunUpCase
    work : Work
        ``Work()`` computes everything in this process.

    Yields
    ------
    tuple of Motion
        One for each model, the last ones until the end.
    """
    first, *further_models = case.models
    share = _FULL_SHARE if further_models else 1.0
    for motion in _motions(case, first, case.horizon.events, None, work.part(first.name, 0.0, share)):
        yield (motion,)
    time = motion.trajectory.time
    if motion.trajectory.failure or len(time) < 2:
        return
    for further_model in further_models:
        for second in _motions(case, further_model, (), time, work.part(further_model.name, share, 1.0)):
            yield motion, second


def run_to_end(machine: Machine, start: Mapping[str, Any], settings: RunSettings | None = None) -> Motion:
    """Run a machine up with one model until its end, and judge it.

    Parameters
    ----------
    machine : Machine
    start : mapping
        Angles and speeds as in ``[study] start`` of a file, in SI: ``{"p1": 0.3}``; empty: at rest, hanging under gravity.
    settings : RunSettings, optional
        By default the full equations until the machine has settled.

    Returns
    -------
    Motion
        Its ``verdict`` has the outcome and the numbers behind it, its ``rows`` the states and outputs over time.

    Raises
    ------
    InputError
        Where the start does not fit the machine.
    """
    *_, (motion, *_) = run_up(RunUpCase.of(machine, start, settings or RunSettings()), Work())
    return motion


def _motions(
    case: RunUpCase, model: FullModel, events: tuple[Event, ...], sample_times: np.ndarray | None, work: Work
) -> Iterator[Motion]:
    """Yield a model's motion after each leg, until the legs, an event, or the verdict end it. sample_times: samples (N,) to
    store; None: as the motion needs."""
    compiled_system = compile_system(model.system, case.settings.tolerance, model.events(events), case.settings.engine)

    integration = ObservedIntegration(
        case.observer, compiled_system, model.machine_motion, case.horizon.vibration, case.horizon.energy
    )
    last = integration.begin(model.initial, model.parameter_values)
    motion = Motion(case, model, integration, last.trajectory, last)
    yield motion
    if last.trajectory.has_ended:
        return

    def rate() -> float:
        return integration.rate(last)

    work = work.open_ended if case.horizon.until_settled else work
    for count, grid in enumerate(case.horizon.legs(rate) if sample_times is None else _legs_on_samples(sample_times), 1):
        report, closest = partial(_report, work, grid.end), grid.closest if sample_times is None else None
        last = work.unit(f"leg {count}", partial(integration.leg, last, grid.samples, report, closest))
        motion = Motion(case, model, integration, motion.trajectory.join(last.trajectory), last)
        yield motion
        if last.trajectory.has_ended or (grid.is_judged and case.horizon.is_decided(motion.verdict)):
            return


def _legs_on_samples(time: np.ndarray) -> Iterator[Grid]:
    """Yield legs over given samples (N,)."""
    for i in range(0, len(time) - 1, _SAMPLES_A_LEG):
        yield Grid(time[i : i + _SAMPLES_A_LEG + 1], 0.0, time[-1], False)


def _report(work: Work, end: float, time: float) -> None:
    work.report(time / end)


def prepare_start(
    machine: Machine,
    start: Mapping[str, Any],
    end: float = 0.0,
    speed_limit: float | None = None,
    location: str = "study.start",
) -> tuple[Machine, np.ndarray]:
    """Return the machine with the bodies of its tracks in the order of the start, and the state (n,) to start from.

    end: of the run. location: of the start, for messages. Raises ``InputError`` where the start does not fit the machine, or
    where nothing would turn.
    """
    initial = initial_state(machine, with_default_start(machine, start), location)
    machine = machine_in_state(machine, initial, location)
    prescribed_coordinates, at = (
        [b.coordinate for b in machine.bodies if b.coordinate.prescribed_velocity is not None],
        np.linspace(0.0, end, 100),
    )
    fastest = max((float(np.abs(machine.prescribed_speed(c, at)).max()) for c in prescribed_coordinates), default=0.0)
    if speed_limit is not None and fastest > speed_limit:
        raise InputError("study.speed_limit", speed_limit, "must be more than the speed that the drive prescribes")
    if not fastest and machine.shaken_coordinate is None and not machine.schedules and _is_at_rest(machine, initial):
        reason = "the machine has neither a drive nor an initial speed: nothing would turn"
        requirement = f"give [machine.drive] or a speed in {location}"
        raise InputError("machine.drive", None, f"{reason}; {requirement}", code="nothing-turns")
    return machine, initial


def _is_at_rest(machine: Machine, initial: np.ndarray) -> bool:
    """True if no body turns, and none begins to."""
    free = [machine.row(b.coordinate.velocity) for b in machine.bodies if b.coordinate.prescribed_velocity is None]
    if initial[free].any() or any(
        net_torque(machine, r)(0.0) for r in machine.rotors if r.coordinate.prescribed_velocity is None
    ):
        return False
    system, names = machine.system, machine.state_names
    accelerations = Evaluator.of(system, [system.derivatives[i] for i in free], [names[i] for i in free])
    with np.errstate(all="ignore"):
        rates = accelerations(np.zeros(1), initial[:, None], system.values(machine.values))
    return all(abs(float(a[0])) < _NO_ACCELERATION for a in rates.values())
