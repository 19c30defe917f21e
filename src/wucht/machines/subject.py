"""The subject of a study: equations of motion with names, values and units of their parameters."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Protocol, Self

from wucht.machines.schedules import Schedule
from wucht.machines.structure import Units
from wucht.schema import Parameter
from wucht.system import System


class Subject(Protocol):
    """What a study is about: a ``Machine``, or a ``UserSystem``, the equations of a table [system]."""

    @property
    def title(self) -> str:
        """Its name for people."""
        ...

    @property
    def system(self) -> System:
        """The equations of motion."""
        ...

    @property
    def parameters(self) -> Mapping[str, Parameter]:
        """The parameters by path, each with its name in words and its unit."""
        ...

    @property
    def values(self) -> Mapping[str, float]:
        """Their values by path."""
        ...

    @property
    def units(self) -> Units:
        """The units of quantities, empty where it is dimensionless."""
        ...

    @property
    def schedules(self) -> tuple[Schedule, ...]:
        """Parameters that change over time by themselves."""
        ...

    def with_values(self, values: Mapping[str, float]) -> Self:
        """Return the subject with other values of some parameters. Raises ``WuchtError`` for one that it does not have."""
        ...

    def check_values(self, values: Mapping[str, float], location: str | Mapping[str, str] | None = None) -> None:
        """Raise ``InputError`` if it does not allow these values. location: of the error, or the locations by path."""
        ...
