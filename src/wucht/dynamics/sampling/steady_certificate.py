"""Certificate of the steady states on which members of an ensemble end: once for each state, not for each member."""

from __future__ import annotations

from functools import partial
from typing import Any

import numpy as np

from wucht.dynamics.sampling.ensemble_equations import Variants
from wucht.dynamics.sampling.member_quantities import MemberQuantities
from wucht.dynamics.verdicts.certificate import TOGETHER, TOLERANCE, MotionEnd, like_pairs, parting_pair, steady_time
from wucht.dynamics.verdicts.outcomes import OUTCOMES, Outcome
from wucht.machines.operation import free_speed
from wucht.numerics.ensembles.members import EnsembleResult
from wucht.numerics.flow.compiled_system import compile_system

_STEADY = [OUTCOMES.index(o) for o in (Outcome.COMPENSATED, Outcome.PASSED, Outcome.CAPTURED)]
_SPEED = 0.01  # share by which the speeds of one state differ at most


def parting_members(
    variants: Variants, quantities: MemberQuantities, outcomes: np.ndarray, ends: EnsembleResult[Any]
) -> np.ndarray:
    """Return the members that have come to a steady state in which like bodies are together, but which they leave.

    Parameters
    ----------
    variants : Variants
        The machines of M members.
    quantities : MemberQuantities
        Their equations.
    outcomes : ndarray of int, (M,)
        Places in ``OUTCOMES``.
    ends : EnsembleResult
        States and times at which they end.

    Returns
    -------
    ndarray of int
        Their numbers.
    """
    system, states = quantities.system, ends.states
    machine, names, index = variants.machines[0], system.state_names, variants.machine_index
    pairs = like_pairs(machine, names)
    if not pairs:
        return np.zeros(0, int)
    differences = np.abs([pair.difference(states.T) for pair in pairs])
    members = np.flatnonzero((differences <= TOGETHER).any(axis=0) & np.isin(outcomes, _STEADY))
    speeds = _main_speeds(variants, names, states)[members]
    with np.errstate(divide="ignore"):
        sizes = np.vstack([differences[:, members] / TOGETHER, np.log(np.abs(speeds)) / _SPEED])
    keys = np.vstack([index[members], outcomes[members], np.round(sizes)])
    _, first, state_of = np.unique(keys, axis=1, return_index=True, return_inverse=True)
    is_left = np.zeros(len(first), bool)
    for k, i in enumerate(first.tolist()):
        member, speed = members[i], float(speeds[i])
        equations, values = partial(compile_system, system, TOLERANCE), quantities.parameter_values[index[member]]
        end = MotionEnd(system, equations, values, states[member], float(ends.times[member]))
        is_left[k] = bool(speed) and parting_pair(machine, end, steady_time(speed), is_steady=True) is not None
    return np.asarray(members[is_left[state_of.reshape(-1)]])


def _main_speeds(variants: Variants, names: tuple[str, ...], states: np.ndarray) -> np.ndarray:
    """Return the speed of the main rotor (M,): a state, or that of its drive."""
    name = f"{variants.machines[0].rotor.name}.speed"
    if name in names:
        return np.asarray(states[:, names.index(name)])
    return np.asarray(np.array([free_speed(m, m.rotor) or 0.0 for m in variants.machines])[variants.machine_index])
