"""The steady states in which the bodies of a balancer stand: what they leave of the unbalance, how fast they are reached."""

from __future__ import annotations

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.steady_machine import driven_speeds, turning
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.machines.machine import Machine
from wucht.studies.synchronous_states.configuration import Configuration, Describer

_SAME = 1e-9  # of the sum of all unbalances
_AT_SPEED = 0.02  # of the highest speed: states at lower ones are those of a captured rotor


def standing(machine: Machine, full: bool) -> Configuration | None:
    """The stable state of ``synchronous-states`` at the speed of the drive that leaves least unbalance; None: there is none.

    full: by the full equations, else by the averaged ones with the inertia of the bodies. Raises ``InputError`` for a machine
    without averaged equations.
    """
    steady = turning(machine, None)
    slow = averaged_machine(steady, True)
    torques = SteadyTorques.from_slow(slow)
    low, high = driven_speeds(steady)[0] if torques.given is None else (0.0, 0.0)
    describer = Describer(AveragedStability(torques, slow))
    judge = FullStability(torques, True)
    found = [s for s in all_states(torques, low, high).states if torques.given is not None or s.speed >= (1 - _AT_SPEED) * high]
    each = [(s, describer.described(s, describer.slow.stability(s))) for s in found]
    each = [(s, c) for s, c in each if c.residual is not None and c.slow.stable is not False]
    for state, configuration in sorted(each, key=lambda one: one[1].residual or 0.0):
        stable = (judge.stability(state) if full else configuration.slow).stable
        if stable:
            return configuration
    return None


def decay_rate(machine: Machine) -> float:
    """How fast small deviations from that state decay in the averaged equations: the slowest rate; nan where there is none."""
    state = standing(machine, full=False)
    return np.nan if state is None or state.slow.leading is None else -state.slow.leading.real
