"""Results with numbers that are put in by hand, for drawings that a cheap study does not come to."""

from __future__ import annotations

import json
from collections.abc import Mapping
from typing import Any

import numpy as np
import xarray as xr

from wucht.results.accessor import register_accessor

register_accessor()  # for results that no study has made


def variable(dimensions: str, values: Any, long_name: str, units: str = "") -> tuple[tuple[str, ...], Any, dict[str, str]]:
    """A variable of such a Dataset."""
    return tuple(dimensions.split()), np.asarray(values), {"long_name": long_name, "units": units}


def with_answer(result: xr.Dataset, units: Mapping[str, Mapping[str, str]] | None = None, /, **answer: Any) -> xr.Dataset:
    """A copy of a result with other values of some keys of its summary. units: of the parts of such keys."""
    parts = {key: {"parts": {part: {"unit": unit} for part, unit in of.items()}} for key, of in (units or {}).items()}
    quantities = result.wucht.quantities | parts
    return result.copy().assign_attrs(summary=json.dumps(result.wucht.summary | answer), quantities=json.dumps(quantities))
