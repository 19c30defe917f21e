"""Holding the swept parameter until the machine has settled."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from wucht.studies.sweep.moving import Leg, Mover, Place, Reading
from wucht.studies.sweep.pace import Pace

SETTLED = 1e-6
_BEATS = 2e-3  # range of the speed, relative


@dataclass(frozen=True)
class Scale:
    """The largest speed and amplitude seen so far: a change is small or large beside them, also at a standstill."""

    speed: float = 0.0
    amplitude: float = 0.0

    def with_(self, readings: Iterable[Reading]) -> Scale:
        """The scale after more readings."""
        known = [(self.speed, self.amplitude), *((abs(r.speed), r.amplitude) for r in readings)]
        return Scale(max(s for s, _ in known), max(a for _, a in known))


@dataclass(frozen=True)
class Settled:
    """How holding the parameter ended. steady: whether nothing changes any more; a steady beat counts as well."""

    leg: Leg
    steady: bool


def settle(mover: Mover, pace: Pace, place: Place, most: int = 60, scale: Scale | None = None) -> Settled:
    """Hold the parameter until nothing changes any more, for ``most`` windows.

    scale: of what was seen before; a speed that changes by less than a millionth of the largest has settled.
    """
    window = max(5 * pace.answer, 8 * pace.turn)
    last = mover.leg(place, window)
    scale, quiet = (scale or Scale()).with_([last.reading]), 0
    for _ in range(most):
        leg = mover.leg(last.place, window)
        before, here = last.reading, leg.reading
        scale = scale.with_([here])
        still = abs(here.speed - before.speed) <= SETTLED * scale.speed
        still = still and abs(here.amplitude - before.amplitude) <= 10 * SETTLED * scale.amplitude
        quiet, last = (quiet + 1 if still else 0), leg
        if quiet >= 2:
            return Settled(last, True)
    return Settled(last, last.reading.beating > _BEATS)
