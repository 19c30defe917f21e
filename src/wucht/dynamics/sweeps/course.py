"""The course of a sweep: what is known of it while a parameter is moved through a range and back."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any, Self

Ends = tuple[float, float]  # first and last value of the parameter on a way


@dataclass(frozen=True)
class SweepCourse:
    """A sweep as far as it has come.

    ways: what is recorded on each way, ``"up"`` and ``"down"``, in their order: legs of ramps, or a ``Way`` in steps. jumps: in
    the order in which they occur, each a ``Jump`` or a ``StateJump``. hysteresis: range of the parameter in which the state
    depends on the way. rate, span: of the parameter, and the time for each of its values. failure: why it ended early.
    """

    ways: Mapping[str, Any] = field(default_factory=dict)
    jumps: tuple[Any, ...] = ()
    hysteresis: list[float] | None = None
    rate: float | None = None
    span: float | None = None
    doubts: tuple[str, ...] = ()
    failure: str | None = None
    is_complete: bool = False

    def with_doubts(self, *doubts: str) -> Self:
        """Return the course with more doubts."""
        return replace(self, doubts=(*self.doubts, *doubts))
