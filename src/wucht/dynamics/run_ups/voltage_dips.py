"""Dips of the supply voltage: the machine in operation, its motion while the voltage is low, and what follows the recovery.

In a dip the voltages of the motors step to a part of their values, and back after its duration. The motors keep their steady
characteristics: what happens in their windings within some periods of the mains is left out.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from functools import cached_property, partial

import numpy as np

from wucht.analysis.working_points import is_held_at_rest
from wucht.dynamics.run_ups.horizon import Horizon, RunSettings
from wucht.dynamics.run_ups.motion_courses import MotionCourse
from wucht.dynamics.run_ups.settled_operation import (
    REST,
    EndState,
    SettledOperation,
    case_from_state,
    last_motion,
    rest_events,
)
from wucht.dynamics.verdicts.outcomes import Outcome
from wucht.dynamics.work import Work
from wucht.errors import InputError
from wucht.machines.changes import release_events
from wucht.machines.machine import Machine
from wucht.numerics.flow.compiled_system import CompiledSystem, compile_system
from wucht.numerics.flow.integration import integrate
from wucht.numerics.flow.trajectory import Trajectory

PRECISION = 0.01  # of the critical duration
_SAMPLES_A_LEG = 8192
_DIP_ROWS, _RECOVERY_ROWS = 300, 500  # of a course
_TAIL = 1.3  # times the settling time: what a course shows of the recovery
_SHORTEST = 1e-3  # of the shortest dip that was tried: below it no return is sought


def voltages_of_drives(machine: Machine, on: str | None) -> dict[str, float]:
    """Return the supply voltages that dip, by their paths: of all drives, or of that on a body.

    Raises ``InputError`` where there is no such drive, or one without a supply voltage: how its torque falls with the voltage
    is not stated by its data.
    """
    if machine.dimensionless:
        raise InputError("machine.model", None, "not allowed: a dimensionless machine has no supply voltage", code="no-voltage")
    drives = {d.on or machine.rotor.name: d for d in machine.drives}
    if not drives:
        raise InputError(
            "machine.drive", None, "nothing drives the machine: there is no supply that could dip", code="no-drive"
        )
    if on is not None and on not in drives:
        requirement = f"must be a body with a drive: {', '.join(drives)}"
        raise InputError("study.on", on, requirement, code="unknown-name")
    paths = dict[str, float]()
    for body, drive in drives.items():
        path = f"{drive.path}.voltage"
        if on in (None, body):
            if path not in machine.parameters:
                reason = f"the {drive.kind} drive on {body!r} has no supply voltage, and its torque states none"
                requirement = (
                    "must be a motor with a voltage (induction, dc, dc-separate, dc-series, dc-shunt)"
                    f"{'; study.on names one that has it' if on is None and len(drives) > 1 else ''}"
                )
                raise InputError(f"machine.{drive.path}", drive.kind, f"{requirement}: {reason}", code="no-voltage")
            paths[path] = machine.at(machine.breakpoints[-1]).values[path]
    return paths


@dataclass(frozen=True)
class Dip:
    """A dip and what follows it: a unit of work.

    speed_at_recovery: of the main rotor when the voltage returns. recovery_time: after which speed and vibration have
    settled, counted from there; None if they have not. peak_amplitude: of the axis, in the dip and after it. course: at times
    since the dip begins.
    """

    duration: float
    end: EndState
    is_return: bool
    speed_at_recovery: float
    recovery_time: float | None
    peak_amplitude: float
    course: MotionCourse
    failure: str | None = None


@dataclass(frozen=True)
class LastingDip:
    """The motion while the voltage stays low, until it has settled or to a given time: a unit of work.

    levels: times (N,) at which the slowest rotor, relative to its speed in operation, first has lost k/N of what it loses.
    """

    end: EndState
    is_settled: bool
    levels: np.ndarray
    course: MotionCourse
    failure: str | None = None


@dataclass(frozen=True)
class DippingSupply:
    """A machine in operation whose supply dips.

    machine: at full voltage. voltages: in operation, by path. depth: share that is lost.
    """

    machine: Machine
    operation: SettledOperation
    voltages: Mapping[str, float]
    depth: float
    settings: RunSettings

    @cached_property
    def dip_machine(self) -> Machine:
        """The machine while the voltage is low."""
        return self.machine.with_unchecked_values({path: (1 - self.depth) * u for path, u in self.voltages.items()})

    @cached_property
    def flow(self) -> CompiledSystem:
        """The equations, which are the same at any voltage."""
        events = (*release_events(self.machine), *rest_events(self.dip_machine))
        return compile_system(self.machine.system, self.settings.tolerance, events, self.settings.engine)

    def lasting_dip(self, until: float | None, count: int, work: Work) -> LastingDip:
        """Return the motion at the low voltage, until it has settled or to a time. count: of levels."""
        case = case_from_state(self.dip_machine, self.operation.state, replace(self.settings, until=until))
        motion = last_motion(case, work)
        course = MotionCourse.from_samples(self.dip_machine, motion.compiled_system, motion.trajectory)
        end = EndState.of(motion)
        is_rest = motion.trajectory.stopped_by == REST
        is_settled = is_rest or (until is None and case.horizon.is_decided(motion.verdict))
        levels = _level_times(course, np.array(self.operation.end.speeds), count)
        return LastingDip(end, is_settled, levels, course.thin(_DIP_ROWS), motion.trajectory.failure)

    def dip(self, duration: float, work: Work) -> Dip:
        """Return a dip of a duration, and the motion after it until it has settled."""
        low, during = self._motion_in_dip(duration, work.part("", 0.0, 0.3))
        speed = abs(float(during.speeds[0, -1]))
        if low.failure:
            end = EndState(str(Outcome.FAILED), (speed,), (), None, low.end_time)
            return Dip(duration, end, False, speed, None, float(during.amplitude.max()), during.thin(_DIP_ROWS), low.failure)
        names = self.flow.system.parameter_names
        values = dict(zip(names, low.final_parameter_values.tolist(), strict=True))
        machine = self.machine.with_unchecked_values({n: x for n, x in values.items() if n.endswith(".locked")})
        if low.stopped_by == REST and is_held_at_rest(machine):
            end = EndState.at_rest(machine, low.end_time)
            return Dip(duration, end, False, 0.0, 0.0, float(during.amplitude.max()), during.thin(_DIP_ROWS))
        case = case_from_state(machine, low.end_state[: len(machine.state_names)], self.settings)
        motion = last_motion(case, work.part("", 0.3, 1.0))
        settling_times = (motion.verdict.settling_time, motion.verdict.amplitude_settling_time)
        settling_time = max((t for t in settling_times if t is not None), default=None)
        end = EndState.of(motion)
        after = MotionCourse.from_samples(machine, motion.compiled_system, motion.trajectory)
        visible = after.within(0.0, motion.trajectory.end_time if settling_time is None else _TAIL * settling_time)
        course = MotionCourse.join([during.thin(_DIP_ROWS), visible.thin(_RECOVERY_ROWS).shift(duration)])
        peak = max(float(during.amplitude.max()), motion.observation.largest)
        failure = motion.trajectory.failure
        return Dip(duration, end, end.equals(self.operation.end), speed, settling_time, peak, course, failure)

    def _motion_in_dip(self, duration: float, work: Work) -> tuple[Trajectory, MotionCourse]:
        """Return the last leg of the motion at the low voltage, and its whole course."""
        machine, horizon = self.dip_machine, Horizon.of(self.dip_machine, self.settings, self.operation.state)
        count = max(2, int(np.ceil(duration / horizon.step)))
        grid = np.linspace(0.0, duration, count + 1)
        state, values, courses = self.operation.state, np.array(machine.system.values(machine.values)), list[MotionCourse]()
        for first in range(0, count, _SAMPLES_A_LEG):
            leg = grid[first : first + _SAMPLES_A_LEG + 1]
            motion = integrate(self.flow, state, values, leg, lambda _: work.report(0.0), horizon.energy).reraise_interrupt()
            courses.append(MotionCourse.from_samples(machine, self.flow, motion))
            state, values = motion.end_state, motion.final_parameter_values
            if motion.has_ended:
                break
        return motion, MotionCourse.join(courses)


def _level_times(course: MotionCourse, operating_speeds: np.ndarray, count: int) -> np.ndarray:
    """Return the times (K,) at which the slowest rotor first has lost k/N of what it loses; the last one is the end."""
    rotors = np.abs(course.speeds[: len(operating_speeds)])
    slowest = np.minimum.accumulate((rotors / operating_speeds[:, None]).min(axis=0))
    levels = slowest[0] + (slowest[-1] - slowest[0]) * np.arange(1, count) / count
    first = [int(np.argmax(slowest <= level)) for level in levels]
    times = np.append(course.time[first], course.time[-1])
    return np.unique(times[times > course.time[0]])


@dataclass(frozen=True)
class CriticalDip:
    """The dips that were tried, by their duration, and the border between those after which the machine returns, and not.

    longest_return, shortest_loss: either side of the border; None where no dip returned, or all did. is_complete: no further
    dip is tried.
    """

    dips: tuple[Dip, ...] = ()
    is_complete: bool = False

    def with_dip(self, dip: Dip) -> CriticalDip:
        """Return these dips with another one."""
        return CriticalDip(tuple(sorted((*self.dips, dip), key=lambda d: d.duration)))

    def dip_of(self, duration: float | None) -> Dip | None:
        """Return the dip of a duration, if it was tried."""
        return next((d for d in self.dips if d.duration == duration), None)

    @property
    def critical(self) -> Dip | None:
        """The longest dip after which the machine returns, once it is known that after a longer one it does not."""
        return self.longest_return if self.is_complete and self.shortest_loss is not None else None

    @property
    def shortest_loss(self) -> Dip | None:
        """The shortest dip after which the machine does not return."""
        return next((d for d in self.dips if not d.is_return), None)

    @property
    def longest_return(self) -> Dip | None:
        """The longest dip shorter than all after which the machine does not return."""
        loss = self.shortest_loss
        return next((d for d in reversed(self.dips) if d.is_return and (loss is None or d.duration < loss.duration)), None)

    @property
    def later_returns(self) -> tuple[Dip, ...]:
        """Longer dips after which it returns again."""
        loss = self.shortest_loss
        return tuple(d for d in self.dips if loss is not None and d.is_return and d.duration > loss.duration)


def critical_dip(
    dip: Callable[[float, Work], Dip], durations: list[float], shortest: float, earlier: CriticalDip, work: Work
) -> Iterator[CriticalDip]:
    """Yield the dips that were tried: at all durations, then by bisection to 1 % of the critical one; at last as complete.

    dip: computes one. shortest: of the range, 0 where every shorter dip counts as one after which the machine returns. earlier:
    dips that were computed before.
    """
    trial, scan = earlier, work.part("", 0.0, 0.6)
    for k, duration in enumerate(durations):
        trial = trial.with_dip(one_dip(dip, duration, scan.part("", k / len(durations), (k + 1) / len(durations))))
        yield trial
    bisection, first_loss = work.part("", 0.6, 1.0), trial.shortest_loss
    floor = shortest or (0.0 if first_loss is None else _SHORTEST * first_loss.duration)
    share = 0.0
    while (loss := trial.shortest_loss) is not None and loss.duration > floor:
        low = 0.0 if trial.longest_return is None else trial.longest_return.duration
        if (not low and shortest) or loss.duration - low <= PRECISION * low:
            break
        part = bisection.part("", share, share + (1 - share) / 4)
        trial, share = trial.with_dip(one_dip(dip, (low + loss.duration) / 2, part)), share + (1 - share) / 4
        yield trial
    yield replace(trial, is_complete=True)


def one_dip(dip: Callable[[float, Work], Dip], duration: float, work: Work) -> Dip:
    """Return a dip as a unit of work."""
    result = work.unit(f"dip of {duration!r}", partial(dip, duration, work.without_memory))
    work.report(1.0, f"dip of {duration:.4g}")
    return result
