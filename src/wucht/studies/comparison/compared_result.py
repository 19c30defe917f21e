"""What is compared of the result of a variant: the attributes of its Dataset, and its curves."""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from typing import TYPE_CHECKING, Any, Self

from wucht.plots.result_curves import Curve, CurveKind, result_curve
from wucht.results.accessor import ResultAccessor
from wucht.studies.registry import study_of

if TYPE_CHECKING:
    import xarray as xr

_ATTRIBUTES = ("summary", "quantities", "sentence", "warnings", "assumed", "failure")


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
            if (curve := result_curve(result, x, y, result.wucht.summary)) is not None:
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
