"""Results with answers that are made by hand, for the words and the drawings that a cheap study does not come to."""

from __future__ import annotations

import json
from typing import Any

import xarray as xr
from matplotlib.figure import Figure

from wucht.studies.runner import draw


def with_answer(result: xr.Dataset, **answer: Any) -> xr.Dataset:
    """A copy of a result with other values of some keys of its summary."""
    return result.copy().assign_attrs(summary=json.dumps(result.wucht.summary | answer))


def titled(result: xr.Dataset, dimensionless: bool = False) -> xr.Dataset:
    """What the runner adds to the Dataset of a study, as far as reports and figures need it."""
    return result.assign_attrs(title="A machine", dimensionless=int(dimensionless))


def drawn(kind: str, result: xr.Dataset) -> Figure:
    """The figure of such a result, arranged on its page."""
    return draw(result.assign_attrs(study=kind, contents="[]"))


def warnings_of(result: xr.Dataset) -> list[str]:
    """The warnings of a Dataset that no runner has made."""
    warnings: list[str] = result.wucht.warnings
    return warnings
