"""What the vibration at the end of a run is to the machine and to what lies on it: force, stroke, acceleration, throw."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from wucht.analysis.throw import NUMBERS, Throw, largest_of
from wucht.machines.machine import Machine
from wucht.results.quantities import Quantity

if TYPE_CHECKING:
    import xarray as xr

_FEWEST = 8  # samples


def vibration_at_the_end(machine: Machine, result: xr.Dataset, inside: np.ndarray, deck: float | None) -> list[Quantity]:
    """Quantities of the samples inside (N,) of the carrier's centre of mass; none where it has no units, or only turns."""
    ways = [d for d in "xy" if d in machine.labels]
    if not ways or machine.dimensionless or np.count_nonzero(inside) < _FEWEST:
        return []
    shown = result.isel(time=inside)
    place, velocity = (_plane(shown[name], "direction") for name in ("displacement", "velocity"))
    throw = Throw.sampled(shown.time.values, place, velocity, deck)
    force = largest_of(_plane(shown.bearing_force, "direction"))
    quantities = [
        Quantity("bearing_force", force, "largest force of all bodies together on the carrier", "N"),
        *(Quantity(n, x, *NUMBERS[n], headline=n == "machine_number") for n, x in throw.numbers.items()),
    ]
    if "rotor_bearing_force" in shown:
        each = {str(name): shown.rotor_bearing_force.sel(rotor=name) for name in shown.rotor.values}
        forces = {name: largest_of(_plane(force, "plane")) for name, force in each.items()}
        quantities.append(Quantity("bearing_forces", forces, "largest force of each rotor on the carrier", "N"))
    if deck is not None:
        quantities += [
            Quantity("deck", deck, "inclination of the deck", "rad"),
            Quantity("throw_number", throw.throw_number(deck), "largest acceleration normal to the deck over that of gravity"),
        ]
    return quantities


def _plane(of: xr.DataArray, ways: str) -> np.ndarray:
    """Its components in x and y (2, N), zero where the carrier cannot move. ways: the dimension of its directions."""
    there = [str(d) for d in of[ways].values]
    zero = np.zeros(of.sizes["time"])
    return np.array([of.values[there.index(d)] if d in there else zero for d in "xy"])
