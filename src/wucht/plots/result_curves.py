"""A curve of a result as it is compared with that of others: one variable over another, of all its parts."""

from __future__ import annotations

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.curves import thin_curve
from wucht.plots.time_courses import shown_until

if TYPE_CHECKING:
    import xarray as xr

CurveKind = tuple[str, str, str, str]  # labels of x and y, and their units: curves of one kind are drawn in one panel
Curve = tuple[np.ndarray, np.ndarray]  # x and y (N,), NaN between its parts


def _stable_values(result: xr.Dataset, of: xr.DataArray) -> xr.DataArray:
    """Return the values of steady configurations that are stable and without overlapping bodies."""
    if "configuration" not in of.dims or "stable" not in result:
        return of
    stable = of.where((result["stable"] == 1) & (result.get("overlapping", 0) == 0))
    return stable if bool(stable.notnull().any()) else of


def _drawn_state(result: xr.Dataset, of: xr.DataArray, summary: Mapping[str, Any]) -> xr.DataArray:
    """Return a variable of states of equations for the one that is drawn, by default the first."""
    names = [str(name) for name in result["state_name" if "state_name" in result.coords else "state"].values]
    name = str(summary.get("show") or names[0])
    of = of.isel(state=names.index(name))
    long_name = str(of.attrs["long_name"])
    return of.assign_attrs(long_name=long_name.replace("the state", name) if "the state" in long_name else name)


def result_curve(result: xr.Dataset, x: str, y: str, summary: Mapping[str, Any]) -> tuple[CurveKind, Curve] | None:
    """Return a variable over another, and its kind; None where the result lacks one of them.

    Of several bodies, cams or runs the first is taken. Several directions, or steady configurations (the stable ones, if any
    is), follow each other like the branches of a curve. summary: of the result; until its settling time a run has its detail.
    """
    if x not in result or y not in result or "case" in result[y].dims:
        return None
    at, of = result[x], _stable_values(result, result[y])
    if "state" in of.dims:
        of = _drawn_state(result, of, summary)
    if "configuration" in of.dims:
        at = at.expand_dims(configuration=of.sizes["configuration"])
    if not at.size or not of.size or not set(at.dims) <= set(of.dims):
        return None
    of = of.isel(dict.fromkeys(set(of.dims) - set(at.dims), 0)).transpose(*at.dims)
    rows = np.atleast_2d(at.values.astype(float)), np.atleast_2d(of.values.astype(float))
    if "branch" in result and result["branch"].dims == at.dims:
        ends = np.flatnonzero(np.diff(result["branch"].values)) + 1
        parts = list(zip(*(np.split(row[0], ends) for row in rows), strict=True))
    else:
        parts = list(zip(*rows, strict=True))
    until = shown_until([summary], float(np.nanmax(at.values))) if x == "time" else np.inf
    thinned_parts = [_thin_both(part[0], part[1], until) for part in parts]
    xs, ys = (np.concatenate([piece for pair in thinned_parts for piece in (pair[k], [np.nan])])[:-1] for k in range(2))
    labels = str(at.attrs.get("long_name", x)), str(of.attrs.get("long_name", y))
    return (*labels, str(at.attrs.get("units", "")), str(of.attrs.get("units", ""))), (xs, ys)


def _thin_both(x: np.ndarray, y: np.ndarray, until: float) -> tuple[np.ndarray, np.ndarray]:
    """Thin a curve up to an abscissa, and beyond: the part that is drawn keeps its detail."""
    k = int(np.count_nonzero(x <= until))
    pieces = [thin_curve(x[part], y[part]) for part in (slice(k), slice(k, None)) if len(x[part])]
    return np.concatenate([piece[0] for piece in pieces]), np.concatenate([piece[1] for piece in pieces])
