"""Where the carrier and the main rotor's axis rest."""

from __future__ import annotations

import numpy as np

from wucht.machines.machine import Machine
from wucht.numerics.flow.program import number_function


def static_position(machine: Machine) -> np.ndarray:
    """Where the carrier rests under its load (m,)."""
    return machine.rest


def axis_at_rest(machine: Machine) -> dict[str, float]:
    """Where the coordinates of ``machine.orbit`` are while the carrier rests."""
    positions = tuple(x for x, _ in machine.orbit.values())
    symbols = (*(c.position for c in machine.carrier), *machine.structure.symbols)
    resting = number_function(positions, symbols)((*static_position(machine).tolist(), *machine.values.values()))
    return dict(zip(machine.orbit, map(float, resting), strict=True))
