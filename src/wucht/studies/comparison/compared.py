"""What is kept of a result that is compared: its outcome, the numbers of its summary, and its curves."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any

import numpy as np

from wucht.plots.curves import thinned
from wucht.studies.comparison.variants import Variant
from wucht.studies.registry import study_of

if TYPE_CHECKING:
    import xarray as xr


@dataclass(frozen=True)
class Curve:
    """y over x (N,), both with what they are and their unit; not a number between the parts of one."""

    what: tuple[str, str]
    unit: tuple[str, str]
    x: np.ndarray
    y: np.ndarray

    @property
    def kind(self) -> tuple[str, ...]:
        """Curves of one kind are drawn in one panel."""
        return (*self.what, *self.unit)


@dataclass(frozen=True)
class Compared:
    """Of one variant. numbers, units: of its summary, those in tables by path. shown: those that are looked at first."""

    study: str
    machine: str
    outcome: str
    sentence: str
    failure: str
    summary: Mapping[str, Any] = field(default_factory=dict)
    numbers: Mapping[str, float] = field(default_factory=dict)
    units: Mapping[str, str] = field(default_factory=dict)
    shown: tuple[str, ...] = ()
    warnings: tuple[str, ...] = ()
    assumed: tuple[str, ...] = ()
    curves: tuple[Curve, ...] = ()


def refused(variant: Variant, failure: str) -> Compared:
    """Of a variant that could not be answered."""
    kind = "" if variant.asked is None else variant.asked.spec.kind
    return Compared(kind, variant.title, "failed", failure, failure)


def compared(variant: Variant, result: xr.Dataset) -> Compared:
    """Of a result."""
    kind = str(result.attrs["study"]) if variant.asked is None else variant.asked.spec.kind
    spec, summary, failure = study_of(kind).spec, result.wucht.summary, str(result.attrs["failure"])
    outcome = str(summary.get("outcome") or ("failed" if failure else ""))
    numbers = _numbers(summary)
    units = {path: result.wucht.unit_at(path) for path in numbers} if result.wucht.quantities else {}
    pairs = [c for x, y in spec.curves if (c := _curve(result, x, y)) is not None]
    shown = tuple(result.wucht.headlines)
    return Compared(
        kind, variant.title, outcome, str(result.attrs["sentence"]), failure, summary, numbers, units, shown,
        tuple(result.wucht.warnings), tuple(result.wucht.assumed), tuple(pairs),
    )  # fmt: skip


def _numbers(summary: Mapping[str, Any], prefix: str = "") -> dict[str, float]:
    """The numbers by path; lists are no numbers to compare."""
    found: dict[str, float] = {}
    for key, value in summary.items():
        if isinstance(value, Mapping):
            found |= _numbers(value, f"{prefix}{key}.")
        elif isinstance(value, int | float):
            found[prefix + key] = float(value)
    return found


def _where_stable(result: xr.Dataset, of: xr.DataArray) -> xr.DataArray:
    """Values of steady configurations where they are stable, and of no bodies that would stand in each other's place."""
    if "configuration" not in of.dims or "stable" not in result:
        return of
    stable = of.where((result["stable"] == 1) & (result.get("overlapping", 0) == 0))
    return stable if bool(stable.notnull().any()) else of


def _curve(result: xr.Dataset, x: str, y: str) -> Curve | None:
    """A variable over another, None where the result has them not.

    Of several bodies, cams or runs the first. What is given for several directions, or steady configurations (as far as these
    are stable, if any is), follows each other, as the branches of a curve do.
    """
    if x not in result or y not in result or "case" in result[y].dims:
        return None
    at, of = result[x], _where_stable(result, result[y])
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
    drawn = [thinned(*part) for part in parts]
    joined = [np.concatenate([piece for pair in drawn for piece in (pair[k], [np.nan])])[:-1] for k in range(2)]
    words = [(str(a.get("long_name", n)), str(a.get("units", ""))) for n, a in ((x, at.attrs), (y, of.attrs))]
    return Curve((words[0][0], words[1][0]), (words[0][1], words[1][1]), *joined)
