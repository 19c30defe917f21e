"""What the motion of a machine tends to at the end of a run: an equilibrium, a periodic orbit, a torus or a chaotic set."""

from __future__ import annotations

import math

import numpy as np

from wucht.dynamics.limit_sets.limit_set import forcing_period
from wucht.dynamics.limit_sets.long_run import Heartbeat, LongRun, long_run
from wucht.dynamics.run_ups.operating_state import machine_after_schedules
from wucht.dynamics.run_ups.run_up import Motion
from wucht.numerics.flow.compiled_system import compile_system
from wucht.numerics.flow.integration import integrate

_FIRST_TURNS, _FIRST_CYCLES = 4.0, 0.25  # in the first leg, of the main rotor and of a modulation
_LEGS = 9  # a torus is known after 500 turns in a leg
_TOLERANCE = 1e-9  # of the integration: multipliers and exponents need a finer one than a verdict


def limit_at_end(motion: Motion, report: Heartbeat | None = None) -> LongRun:
    """Follow the motion of a machine from the end of a run, after its schedules, until it is known what it tends to.

    Parameters
    ----------
    motion : Motion
        Of the full equations.
    report : callable, optional
        As of ``long_run``.

    Returns
    -------
    LongRun
        Its time is zero at the end of the run, or, where a forcing is periodic, at the end of the period begun there.
    """
    names, trajectory = motion.compiled_system.system.parameter_names, motion.trajectory
    end_values = dict(zip(names, trajectory.final_parameter_values.tolist(), strict=True))
    machine = machine_after_schedules(motion.case.machine, end_values)
    tolerance, engine = motion.compiled_system.tolerance, motion.case.settings.engine
    state = trajectory.end_state
    if period := forcing_period(machine.system, machine.values):
        compiled_system, begin = compile_system(machine.system, tolerance, (), engine), trajectory.end_time
        grid = np.array([begin, (math.floor(begin / period) + 1) * period])
        state = integrate(compiled_system, state, machine.system.values(machine.values), grid).reraise_interrupt().end_state
    speed, modulation = abs(motion.verdict.speed), motion.verdict.modulation
    first_leg = _FIRST_TURNS * 2 * math.pi / speed if speed else None
    if modulation is not None:
        first_leg = max(first_leg or 0.0, _FIRST_CYCLES * modulation.period)
    count = len(machine.state_names)
    return long_run(
        machine,
        state[:count],
        tolerance=min(tolerance, _TOLERANCE),
        engine=engine,
        first_leg=first_leg,
        legs=_LEGS,
        report=report,
        earlier_states=trajectory.states[:count],
    )
