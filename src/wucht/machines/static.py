"""Where the carrier rests."""

from __future__ import annotations

import numpy as np

from wucht.machines.machine import Machine


def static_position(machine: Machine) -> np.ndarray:
    """Where the carrier rests under its load (m,): K x = load; zero where its motion is prescribed."""
    c, numbers, size = machine.linear_carrier, machine.numbers, len(machine.free_carrier)
    stiffness = np.array(c.stiffness.xreplace(numbers).tolist(), float).reshape(size, size)
    load = np.array(c.load.xreplace(numbers).tolist(), float).ravel()
    rest = iter(np.linalg.lstsq(stiffness, load, rcond=None)[0] if size else ())
    return np.array([0.0 if q.prescribed is not None else float(next(rest)) for q in machine.carrier])
