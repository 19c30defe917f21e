"""What the vibration at the end of a run is to the machine and to what lies on it: force, stroke, acceleration, throw."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.analysis.throw import Throw, largest_of
from wucht.machines.machine import Machine

if TYPE_CHECKING:
    import xarray as xr

_FEWEST = 8  # samples


def felt(machine: Machine, result: xr.Dataset, inside: np.ndarray, deck: float | None) -> dict[str, Any]:
    """Numbers for a summary, of the samples inside (N,); of a carrier with units that translates, else none.

    bearing_force: the largest that the bodies together exert on the carrier; bearing_forces: that of each rotor, where there
    are several. stroke (peak to peak), throw_direction, throw_ratio (the motion across over that along), acceleration,
    machine_number, and with a deck throw_number: of the carrier's centre of mass.
    """
    ways = [d for d in "xy" if d in machine.labels]
    if not ways or machine.dimensionless or np.count_nonzero(inside) < _FEWEST:
        return {}
    shown = result.isel(time=inside)
    place, velocity = (_plane(shown[name], "direction") for name in ("displacement", "velocity"))
    throw = Throw.sampled(shown.time.values, place, velocity, deck)
    numbers: dict[str, Any] = {"bearing_force": largest_of(_plane(shown.bearing_force, "direction"))} | throw.numbers
    if "rotor_bearing_force" in shown:
        each = {str(name): shown.rotor_bearing_force.sel(rotor=name) for name in shown.rotor.values}
        numbers["bearing_forces"] = {name: largest_of(_plane(force, "plane")) for name, force in each.items()}
    return numbers if deck is None else numbers | {"deck": deck, "throw_number": throw.throw_number(deck)}


def _plane(of: xr.DataArray, ways: str) -> np.ndarray:
    """Its components in x and y (2, N), zero where the carrier cannot move. ways: the dimension of its directions."""
    there = [str(d) for d in of[ways].values]
    zero = np.zeros(of.sizes["time"])
    return np.array([of.values[there.index(d)] if d in there else zero for d in "xy"])
