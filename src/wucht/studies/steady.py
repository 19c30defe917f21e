"""What the studies of a steady speed have in common: the phases of the bodies, and what a linear carrier leaves out."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from wucht.machines.contact import arranged
from wucht.machines.forced import Forced
from wucht.machines.machine import Machine
from wucht.studies.keys import whole
from wucht.studies.start import angles_in, start_state

_MOST_POINTS = 100_000


def read_points(table: Mapping[str, Any], default: int) -> int:
    """The number of points. Raises ``InputError``."""
    return whole(table, "points", default, 2, _MOST_POINTS)


def angles_of(machine: Machine, start: Mapping[str, Any]) -> np.ndarray:
    """The absolute angles (n,) of the bodies at their start. Raises ``InputError``, also where bodies of a track overlap."""
    angles = angles_in(machine, start_state(machine, start))
    arranged(machine, angles)
    return np.array(list(angles.values()))


def forced(machine: Machine, start: Mapping[str, Any]) -> Forced:
    """The vibration with the bodies at their start. Raises ``InputError``."""
    return Forced.of(machine, angles_of(machine, start))


def left_out(machine: Machine) -> list[str]:
    """Sentences about what is not in the steady vibration of a linear carrier."""
    said = []
    if machine.shaken is not None:
        said.append("the prescribed motion of the carrier is left out: only what the unbalance causes is computed")
    if machine.sliders:
        said.append("sliders are taken where their springs are free of force: their unbalance does not grow with the speed")
    return said
