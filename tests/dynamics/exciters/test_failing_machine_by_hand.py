"""A stiffness that falls with the damage: what is booked, recorded, and judged, of motions made by hand."""

from __future__ import annotations

from dataclasses import dataclass, replace
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from wucht.dynamics.exciters import failing_machine as module
from wucht.dynamics.exciters.failing_machine import FailingMachine, FailureCourse, FallingStiffness, RunState
from wucht.dynamics.run_ups.observed_integration import Leg
from wucht.machines.machine import DISSIPATED_WORK, SUPPLIED_WORK
from wucht.machines.schedules import SCHEDULE_WORK
from wucht.numerics.flow.trajectory import Trajectory
from wucht.numerics.observers.energy_balance import EnergyBalance

WHOLE, PLACE = 50.0, 2.0


@dataclass(frozen=True)
class Waiting:
    parameters: np.ndarray


def motion(stiffness: float = WHOLE, time: tuple[float, ...] = (0.0, 0.5, 1.0), **works: Any) -> Trajectory:
    """At rest at a place x; the second parameter is the stiffness."""
    at = np.array(time)
    zero = {name: np.zeros(len(at)) for name in (SUPPLIED_WORK, DISSIPATED_WORK)}
    return Trajectory(
        at, np.full((1, len(at)), PLACE), zero | works, np.array([9.0, stiffness]), float(at[-1]), np.array([PLACE])
    )


def leg(of: Trajectory, points: tuple[tuple[float, ...], tuple[float, ...]] = ((), ())) -> Any:
    turning = SimpleNamespace(time=np.array(points[0]), values=np.array(points[1]))
    return Leg(of, SimpleNamespace(points=turning), (Waiting(of.parameter_values),))  # type: ignore[arg-type]


def machine(at_once: bool = True, begin: float | None = None, falling: bool = True) -> Any:
    """The energy is c x^2/2."""
    system = SimpleNamespace(parameter_names=("mass", "c"))

    def outputs(time: np.ndarray, states: np.ndarray, parameters: np.ndarray) -> dict[str, np.ndarray]:
        return {"stored_energy": parameters[1] * states[0] ** 2 / 2}

    compiled = SimpleNamespace(outputs=outputs)
    law = FallingStiffness("c", WHOLE, 0.4, at_once) if falling else None
    of = SimpleNamespace(system=system, rotor="rotor", with_unchecked_values=lambda values: values, at=Then)
    integration = SimpleNamespace(compiled_system=compiled, observation=lambda leg: SimpleNamespace(observation="seen"))
    return FailingMachine(
        of,
        integration,
        np.zeros(1),
        0.5,
        4,
        2,
        falling=law,
        begin=begin,
        schedule=lambda time: 1 - time / 4,  # type: ignore[arg-type]
    )


@dataclass(frozen=True)
class Then:
    time: float

    def with_fields(self, schedules: tuple[Any, ...]) -> tuple[str, float, int]:
        return "then", self.time, len(schedules)


def state(damage: float, **more: Any) -> RunState:
    of = SimpleNamespace(total=damage)
    return RunState(leg(motion()), EnergyBalance(), of, **more)  # type: ignore[arg-type]


def test_the_energy_that_a_spring_loses_is_booked() -> None:
    """A stiffness that falls from 50 to 20 N/m at 2 m: -60 J."""
    after = machine()._update_stiffness(state(1.25, jump_work=7.0))
    assert after.last.trajectory.parameter_values.tolist() == [9.0, 20.0] and after.last.pending[
        -1
    ].parameter_values.tolist() == [
        9.0,
        20.0,
    ]
    assert after.jump_work == pytest.approx(7.0 - 30.0 * PLACE**2 / 2)
    assert after.broken == 1.0 and after.onset is not None and after.onset.trajectory.parameter_values.tolist() == [9.0, WHOLE]
    again = machine()._update_stiffness(replace(after, last=leg(motion(20.0, (1.0, 2.0)))))
    assert (again.broken, again.jump_work, again.onset) == (1.0, after.jump_work, after.onset), "it breaks once"


def test_before_the_damage_is_one_nothing_falls_at_once() -> None:
    before = state(0.99)
    assert machine()._update_stiffness(before) == before
    part = machine(at_once=False)._update_stiffness(state(0.5))
    assert part.last.trajectory.parameter_values[1] == pytest.approx(WHOLE * 0.7) and part.broken is None
    assert part.onset is not None
    given = machine(begin=5.0)._update_stiffness(state(1.0))
    assert given.onset is None and given.broken == 1.0, "its begin is given"


def test_a_run_that_has_ended_keeps_its_stiffness() -> None:
    ended = replace(state(2.0), last=leg(replace(motion(), failure="it burst")))
    assert machine()._update_stiffness(ended) == ended


def test_time_series(monkeypatch: pytest.MonkeyPatch) -> None:
    """Each turning point belongs to the sample at its end; the work is that of a schedule and of all jumps."""
    monkeypatch.setattr(module, "motion_of", lambda machine, motion, rotor: (10 * motion.time, None))
    points = ((0.1, 0.2, 0.5, 0.6, 0.9), (3.0, -2.0, 5.0, -7.0, 1.0))
    works = {SCHEDULE_WORK: np.array([0.0, 1.0, 2.0]), DISSIPATED_WORK: np.array([0.0, 0.0, 3.0])}
    of = motion(25.0, **works)
    now = RunState(leg(of, points), EnergyBalance(), SimpleNamespace(total=0.25), jump_work=-4.0)  # type: ignore[arg-type]
    _, course = machine()._observe(now, of)
    assert course.highest == pytest.approx([np.nan, 5.0, 1.0], nan_ok=True)
    assert course.lowest == pytest.approx([np.nan, -2.0, -7.0], nan_ok=True)
    assert course.work.tolist() == [-4.0, -3.0, -2.0] and course.angle.tolist() == [0.0, 5.0, 10.0]
    assert course.stiffness.tolist() == [0.5] * 3 and course.damage.tolist() == [0.25] * 3
    _, scheduled = machine(falling=False)._observe(RunState(leg(of), EnergyBalance()), of)
    assert scheduled.stiffness.tolist() == [1.0, 0.875, 0.75] and np.isnan(scheduled.damage).all()
    joined = FailureCourse.join([course, scheduled])
    assert joined.work.tolist() == [-4.0, -3.0, -2.0, 0.0, 1.0, 2.0] and len(joined.lowest) == 6


def test_the_motion_before_is_judged_with_the_machine_as_it_was(monkeypatch: pytest.MonkeyPatch) -> None:
    judged = []
    monkeypatch.setattr(module, "verdict_at_end", lambda machine, seen, motion: judged.append((machine, motion.end_time)))
    course = FailureCourse(*(np.zeros(1) for _ in range(8)))
    now = replace(state(1.0), last=leg(motion(20.0, (1.0, 2.0))))
    run = machine()._assemble_run([course], now)
    assert run.verdict_before is None and judged == [({"c": 20.0}, 2.0)]
    machine()._assemble_run([course], replace(now, onset=leg(motion())))
    assert judged[1:] == [({"c": 20.0}, 2.0), (("then", 1.0, 0), 1.0)]
    of = machine(falling=False)
    of._assemble_run([course], now)
    assert judged[3] == (of.machine, 2.0)
