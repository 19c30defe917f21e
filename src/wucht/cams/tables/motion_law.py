"""What a table [law] of a cam file makes: the motion of the output."""

from __future__ import annotations

from abc import abstractmethod
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from wucht.cams.laws.law import Law
from wucht.cams.laws.synthesis import Band, Restriction
from wucht.fields import Described
from wucht.numerics.harmonics import even_angles

_NARROW, _LOOKED_AT = 0.1, 3600  # share of the stroke; cam angles at which that is looked for


@dataclass(frozen=True, eq=False)
class MotionLaw:
    """law: over the cam angle, in ``unit`` (rad or m). count: of its harmonics, None where it has no end of them. restrictions:
    what it was asked."""

    law: Law
    unit: str
    count: int | None = None
    restrictions: tuple[Restriction, ...] = ()

    @property
    def dwells(self) -> tuple[Band, ...]:
        """Those restrictions that ask the output to rest on an arc: in a band that is narrow against the stroke."""
        narrow = _NARROW * float(np.ptp(self.law(even_angles(_LOOKED_AT))))
        arcs = [r for r in self.restrictions if isinstance(r, Band) and r.order == 0 and r.end > r.begin]
        return tuple(band for band in arcs if band.high - band.low <= narrow)


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
