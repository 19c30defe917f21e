"""A run from a neighbouring start, where small differences grow: which numbers of a run are determined, and which are chance.

Bodies that tumble through a resonance amplify a difference of their starts, often a million times: then the last digit of the
start, or the tolerance of the integration, decides how and when they arrange themselves. What two neighbours have in common is
determined, the rest is one draw of many. The growth of a finite difference over a run is that of its largest
finite-time Lyapunov exponent: E. Ott, "Chaos in Dynamical Systems", Cambridge 2002, section 4.4.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import partial

import numpy as np

from wucht.dynamics.run_ups.run_up import Motion, run_up
from wucht.dynamics.work import Work
from wucht.numerics.flow.integration import integrate

DISPLACEMENT = 1e-6  # rad: nobody places a body more precisely
_GROWS = 1e3  # times: beyond, the numbers of neighbours are compared; a difference of less does not show in them
_PLACES = 1024  # of the run, at which neighbours are compared
_ANGLES = (".angle", ".phase")


@dataclass(frozen=True)
class Neighbour:
    """A run from a neighbouring start. growth: of the difference between both, as a factor."""

    motion: Motion
    growth: float


def neighbour_of(motion: Motion, work: Work) -> Neighbour | None:
    """Return a neighbour of a run that has ended; None where the difference does not grow, and all numbers are determined.

    The neighbour is followed without being observed at first, which takes a tenth of the time of the run; only where it
    leaves the run is it run up as well.
    """
    rows = _displaced_rows(motion)
    if not rows or motion.trajectory.failure or motion.trajectory.is_interrupted or len(motion.trajectory.time) < 2:
        return None
    start = motion.model.initial.copy()
    start[rows] += DISPLACEMENT / np.arange(1, len(rows) + 1)
    growth = work.unit("growth", partial(_growth, motion, start))
    if growth < _GROWS:
        return None
    case = replace(motion.case, models=(replace(motion.model, initial=start),))
    *_, (neighbour,) = run_up(case, work)
    return Neighbour(neighbour, growth)


def _displaced_rows(motion: Motion) -> list[int]:
    """Return the places of the angles of all bodies but the main rotor that move freely."""
    machine, names = motion.case.machine, motion.compiled_system.system.state_names
    bodies = [b for b in machine.bodies if b is not machine.rotor and b.coordinate.prescribed_velocity is None]
    return [names.index(f"{b.name}{angle}") for b in bodies for angle in _ANGLES if f"{b.name}{angle}" in names]


def _growth(motion: Motion, start: np.ndarray) -> float:
    """Return how far a neighbour leaves a run at most, in angles of its bodies and in displacements of the start."""
    names, reference = motion.compiled_system.system.state_names, motion.trajectory
    places = np.unique(np.linspace(0, len(reference.time) - 1, _PLACES).round().astype(int))
    neighbour = integrate(
        motion.compiled_system, start, motion.model.parameter_values, reference.time[places], None, motion.case.horizon.energy
    ).reraise_interrupt()
    angles = [i for i, name in enumerate(names) if name.endswith(_ANGLES)]
    count = len(neighbour.time)
    distances = np.abs(neighbour.states[angles] - reference.states[angles][:, places[:count]])
    return float(distances.max()) / DISPLACEMENT
