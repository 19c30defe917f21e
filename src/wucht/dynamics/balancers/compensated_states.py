"""Steady states in which the bodies of a balancer compensate: what they leave of the unbalance, how fast they are reached."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from wucht.analysis.averaged import averaged_machine
from wucht.analysis.configurations.averaged_stability import AveragedStability
from wucht.analysis.configurations.closed_form import State
from wucht.analysis.configurations.configuration import Configuration, Describer
from wucht.analysis.configurations.full_stability import FullStability
from wucht.analysis.configurations.search import all_states
from wucht.analysis.configurations.steady_machine import driven_speeds, turning
from wucht.analysis.configurations.torques import SteadyTorques
from wucht.analysis.vibration import Vibration
from wucht.machines.machine import Machine


def states_at_speed(machine: Machine) -> tuple[State, ...]:
    """The steady states of ``synchronous-states`` beyond the resonance, or at the speed that is held, stable or not.

    Damping between the bodies and the rotor does not matter to them: nothing moves there. Raises ``InputError`` for a machine
    without averaged equations.
    """
    steady = turning(machine, None)
    torques = SteadyTorques.from_slow(averaged_machine(steady, True))
    low, high = driven_speeds(steady)[0] if torques.given is None else (0.0, 0.0)
    found = tuple(all_states(torques, low, high).states)
    if torques.given is not None:
        return found
    index = [steady.bodies.index(b) for b in steady.group(steady.rotor)]
    vibration = Vibration.of(steady).only(index)
    resonances = [vibration.last_maximum(high, s.phases[index]) for s in found]
    return tuple(s for s, resonance in zip(found, resonances, strict=True) if resonance is None or s.speed > resonance)


def compensated_state(machine: Machine, full: bool, states: Sequence[State] | None = None) -> Configuration | None:
    """The stable one of these states that leaves least unbalance; None: there is none.

    full: by the full equations, else by the averaged ones with the inertia of the bodies. states: where they are known. Raises
    ``InputError`` for a machine without averaged equations.
    """
    slow = averaged_machine(turning(machine, None), True)
    torques = SteadyTorques.from_slow(slow)
    describer = Describer(AveragedStability(torques, slow))
    judge = FullStability(torques, True)
    found = states_at_speed(machine) if states is None else states
    each = [(s, describer.described(s, describer.slow.stability(s))) for s in found]
    each = [(s, c) for s, c in each if c.residual is not None and c.slow.stable is not False]
    for state, configuration in sorted(each, key=lambda one: one[1].residual or 0.0):
        stable = (judge.stability(state) if full else configuration.slow).stable
        if stable:
            return configuration
    return None


def decay_rate(machine: Machine, states: Sequence[State] | None = None) -> float:
    """How fast small deviations from that state decay in the averaged equations: the slowest rate; nan where there is none."""
    state = compensated_state(machine, full=False, states=states)
    return np.nan if state is None or state.slow.leading is None else -state.slow.leading.real
