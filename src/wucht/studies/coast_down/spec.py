"""The question of a coast-down."""

from __future__ import annotations

from typing import ClassVar

from pydantic import Field

from wucht.fields import si
from wucht.studies.spec import DEFAULT_TOLERANCE, FULL, Engine, Spec, Start, Tolerance


class CoastDown(Spec):
    """Let the machine run without its drives; loads, bearings and dampers stay.

    until: a time; None: until it has stopped, swings, or turns at a hundredth of its speed. start: the initial state; rotors
    for which it gives no speed start with the speed that their drive reaches, and the bodies about them turn along. tolerance:
    of the integration. engine: see ``RunUp``.
    """

    kind: ClassVar[str] = "coast-down"
    solves: ClassVar[str] = FULL

    until: float | None = si("s", "time", default=None, gt=0)
    start: Start = Field(default_factory=dict)
    tolerance: Tolerance = DEFAULT_TOLERANCE
    engine: Engine | None = None

    def turning(self) -> str:
        """See ``Spec``."""
        return "without its drives"
