"""The conventions of a result: every variable has a ``long_name`` and ``units``."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.results.accessor import register
from wucht.results.store import to_json

if TYPE_CHECKING:
    import xarray as xr

Variable = tuple[tuple[str, ...], Any, dict[str, str]]


# Of summaries whose study does not state its quantities: the units of numbers by the first step of their path.
_UNITS = {
    "rad/s": ("mean_speed", "natural_frequencies", "resonance_speed", "speed"),
    "s": ("end_time", "settling_time", "until"),
    "rad": ("max_pressure_angle",),
    "m": ("base_radius", "largest_radius", "min_curvature_radius", "min_hollow_radius"),
    "W": ("mean_power",),
}
_UNIT_OF = {name: unit for unit, names in _UNITS.items() for name in names}


def variable(dimensions: str, values: Any, long_name: str, units: str = "") -> Variable:
    """A Dataset variable: dimensions (names in one string), values (None: not a number), what it is, in which units."""
    return tuple(dimensions.split()), np.asarray(np.nan if values is None else values), {"long_name": long_name, "units": units}


def answered(
    dataset: xr.Dataset,
    summary: Mapping[str, Any],
    sentence: str,
    warnings: Sequence[str] = (),
    failure: str | None = None,
    **more: Any,
) -> xr.Dataset:
    """The Dataset with its answer as attributes. sentence: in words. failure: why it is incomplete. more: other ones."""
    register()
    stated = {name: {"what": name.replace("_", " "), "unit": _UNIT_OF.get(name, "")} for name in summary}
    dataset.attrs |= {
        "summary": to_json(dict(summary), indent=None),
        "quantities": to_json(stated, indent=None),
        "sentence": sentence,
        "warnings": to_json(list(warnings), indent=None),
        "failure": failure or "",
        **more,
    }
    return dataset


def assuming(result: xr.Dataset, statements: Sequence[str]) -> xr.Dataset:
    """The result with statements of what it assumes, beside those that it has."""
    result.attrs["assumed"] = to_json([*json.loads(result.attrs.get("assumed", "[]")), *statements], indent=None)
    return result
