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
    dataset.attrs |= {
        "summary": to_json(dict(summary), indent=None),
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


def summary_of(result: xr.Dataset) -> dict[str, Any]:
    """The summary of a result, as in the contract."""
    summary: dict[str, Any] = result.wucht.summary
    return summary
