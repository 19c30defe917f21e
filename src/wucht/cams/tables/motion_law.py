"""What a table [law] of a cam file makes: the motion of the output."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

from wucht.cams.laws.law import Law
from wucht.cams.laws.synthesis import Restriction
from wucht.fields import Described


@dataclass(frozen=True, eq=False)
class MotionLaw:
    """law: over the cam angle, in ``unit`` (rad or m). count: of its harmonics, None where it has no end of them. restrictions:
    what it was asked; widening: by how much those are widened that are to be as tight as they can be."""

    law: Law
    unit: str
    count: int | None = None
    restrictions: tuple[Restriction, ...] = ()
    widening: float | None = None


class LawTable(Described):
    """A law of some kind."""

    @classmethod
    def where(cls) -> str:
        """In a file."""
        return "law"

    @property
    def stated_unit(self) -> str | None:
        """The unit of the output, if the table itself says it."""
        return None

    def quantities(self) -> Iterator[tuple[str, float | str]]:
        """Where each position stands, and what is given there."""
        yield from ()

    @abstractmethod
    def motion(self, unit: str) -> MotionLaw:
        """The law of an output whose positions are in rad or m. Raises ``InputError``."""
