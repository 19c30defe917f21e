"""What is compared of the result of a variant: the attributes of its Dataset, and its curves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

import numpy as np

from wucht.plots.curves import thin_curve
from wucht.plots.time_courses import shown_until
from wucht.results.accessor import ResultAccessor
from wucht.studies.registry import study_of

if TYPE_CHECKING:
    import xarray as xr

_ATTRIBUTES = ("summary", "quantities", "sentence", "warnings", "assumed", "failure")
CurveKind = tuple[str, str, str, str]  # labels of x and y, and their units: curves of one kind are drawn in one panel
Curve = tuple[np.ndarray, np.ndarray]  # x and y (N,), NaN between its parts


@dataclass(frozen=True)
class ComparedResult:
    """What is compared of the result of a variant: attributes of its Dataset, and its curves by kind."""

    attributes: Mapping[str, Any]
    curves: Mapping[CurveKind, Curve] = field(default_factory=dict)

    @classmethod
    def from_dataset(cls, result: xr.Dataset, kind: str) -> Self:
        """Return it from the Dataset of a study of this kind."""
        study, curves = study_of(kind).study, dict[CurveKind, Curve]()
        for x, y in study.curves_of_equations if result.attrs.get("subject") == "system" else study.curves:
            if (curve := _curve(result, x, y, result.wucht.summary)) is not None:
                curves.setdefault(*curve)
        return cls({name: result.attrs[name] for name in _ATTRIBUTES if name in result.attrs}, curves)

    @classmethod
    def from_failure(cls, reason: str) -> Self:
        """Return that of a variant whose study failed."""
        return cls({"summary": "{}", "sentence": reason, "warnings": "[]", "failure": reason})

    @cached_property
    def wucht(self) -> ResultAccessor:
        """The result as an object."""
        import xarray as xr_

        return ResultAccessor(xr_.Dataset(attrs=dict(self.attributes)))

    @cached_property
    def numbers(self) -> dict[str, float]:
        """The numbers of its summary by path; lists are not compared."""
        return dict(_numbers_by_path(self.wucht.summary))

    @property
    def outcome(self) -> str:
        """The outcome; empty where the study has none."""
        return str(self.wucht.summary.get("outcome") or ("failed" if self.wucht.failure else ""))


def _numbers_by_path(summary: Mapping[str, Any], prefix: str = "") -> Iterator[tuple[str, float]]:
    for key, value in summary.items():
        if isinstance(value, Mapping):
            yield from _numbers_by_path(value, f"{prefix}{key}.")
        elif isinstance(value, int | float):
            yield prefix + key, float(value)


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


def _curve(result: xr.Dataset, x: str, y: str, summary: Mapping[str, Any]) -> tuple[CurveKind, Curve] | None:
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
