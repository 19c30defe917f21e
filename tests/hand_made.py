"""Results with answers that are made by hand, for the words and the drawings that a cheap study does not come to."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
import xarray as xr

from wucht.extending_0_1 import result_dataset
from wucht.results.accessor import register_accessor
from wucht.results.quantities import Quantity

register_accessor()  # for results that no study has made
UNITS = {
    "rad/s": (
        "peak_speed", "peak_torque_speed", "self_centring_speed", "from_speed", "to_speed", "final_speed", "min_speed",
        "max_speed",
        "free_speed",
        "speed",
        "no_load_speed",
        "mean_speeds",
        "natural_frequencies",
    ),
    "m": (
        "final_amplitude", "peak_amplitude", "amplitude", "stroke", "amplitude_at_free_speed", "from_amplitude", "to_amplitude",
    ),
    "s": ("settling_time", "amplitude_settling_time", "modulation_period", "half_time", "reversal_time", "end_time"),
    "rad": ("final_phases", "rotor_phases", "throw_direction", "deck"),
    "N m": ("torque", "rate"),
    "N m s": ("slope",),
}  # fmt: skip
_UNIT_OF = {name: unit for unit, names in UNITS.items() for name in names}


def answered(
    result: xr.Dataset,
    summary: Mapping[str, Any],
    sentence: str = "",
    warnings: Sequence[str] = (),
    failure: str | None = None,
    dimensionless: bool = False,
    **others: str,
) -> xr.Dataset:
    """A Dataset with a summary made by hand, whose numbers have the units of keys of their names. others: units of keys."""
    units = {} if dimensionless else _UNIT_OF | others

    def stated(name: str, value: Any) -> Quantity:
        parts = {inner: (inner, unit) for inner, unit in units.items() if inner != name}
        return Quantity(name, value, name, units.get(name, ""), parts=parts)

    quantities = [stated(name, value) for name, value in summary.items() if name != "sentence"]
    made = result_dataset(quantities, sentence or summary.get("sentence", ""), warnings, (), failure)
    return result.drop_attrs(deep=False).assign_attrs(made.attrs)


def variable(dimensions: str, values: Any, long_name: str, units: str = "") -> tuple[tuple[str, ...], Any, dict[str, str]]:
    """A variable of such a Dataset."""
    return tuple(dimensions.split()), np.asarray(values), {"long_name": long_name, "units": units}


def with_answer(result: xr.Dataset, units: Mapping[str, Mapping[str, str]] | None = None, /, **answer: Any) -> xr.Dataset:
    """A copy of a result with other values of some keys of its summary. units: of the parts of such keys."""
    parts = {key: {"parts": {part: {"unit": unit} for part, unit in of.items()}} for key, of in (units or {}).items()}
    quantities = result.wucht.quantities | parts
    return result.copy().assign_attrs(summary=json.dumps(result.wucht.summary | answer), quantities=json.dumps(quantities))


def titled(result: xr.Dataset, dimensionless: bool = False) -> xr.Dataset:
    """What the runner adds to the Dataset of a study, as far as reports and figures need it."""
    return result.assign_attrs(title="A machine", dimensionless=int(dimensionless))
