"""The law of a table [law] of a cam file: the motion of the output, which turns (rad) or slides (m)."""

from __future__ import annotations

import math
import re
from abc import ABC, abstractmethod
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
from pydantic import BeforeValidator

from wucht.cams.laws import Law
from wucht.cams.laws.cam_segments import RiseAndReturn, SegmentedMotion
from wucht.cams.laws.synthesis import Band, Restriction, band_extremes
from wucht.errors import InputError
from wucht.numerics.angles import valleys
from wucht.numerics.fourier_series import FourierSeries, even_angles
from wucht.schema import TableModel, Unit, article, read_quantity

GROUP = "wucht.cams"  # of entry points: modules with kinds of laws, followers and linkages
UNITS = {"rad": Unit("rad", "angle of the output"), "m": Unit("m", "displacement of the output")}
_BY_ANGLE = re.compile(r"\s*/\s*rad(?:\s*\^\s*([23]))?\s*$")  # a derivative by the cam angle: mm/rad^2
_COMPOUND_UNIT = re.compile(r"[^\W\d_]\s*[*/^\s]\s*[^\W_]")  # units: an angle has none, so that deg/rad^3 would be one too
_NARROW, _STROKE_SAMPLES = 0.1, 3600  # share of the stroke; cam angles at which that is sampled
_SAMPLES = 4096  # of a law with infinitely many harmonics
_FINE = 2000  # of an arc, on which the values of such a law are sampled


def _check_position(value: Any) -> Any:
    if isinstance(value, bool) or not isinstance(value, int | float | str):
        raise ValueError("must be a number, or a string with a unit of angle or length")
    return value


Position = Annotated[float | str, BeforeValidator(_check_position)]  # in the unit of the output


def read_output(unit: str, value: float | str, location: str, order: int = 0) -> float:
    """Return a position of the output in rad or m, or a derivative by the cam angle, whose unit may omit that angle.

    Raises ``InputError``.
    """
    bare, power = _without_angle(value)
    if power not in (0, order) or (isinstance(bare, str) and _COMPOUND_UNIT.search(bare)):
        by_angle = ("", ", or that per rad", ", or that per rad^2", ", or that per rad^3")[order]
        example = {"rad": "24 deg", "m": "10 mm"}[unit] + ("", "/rad", "/rad^2", "/rad^3")[order]
        raise InputError(location, value, f"must be {article(UNITS[unit].long_name)}{by_angle}, such as {example!r}")
    return read_quantity(UNITS[unit], bare, location)


def _without_angle(value: float | str) -> tuple[float | str, int]:
    """Return a quantity without the cam angle that it is divided by, and the power of that angle."""
    suffix = _BY_ANGLE.search(value) if isinstance(value, str) else None
    if suffix is None or not isinstance(value, str):
        return value, 0
    return value[: suffix.start()], int(suffix[1] or 1)


def unit_of_output(output_values: Iterable[tuple[str, float | str]], stated_unit: str | None) -> str:
    """Return ``rad`` or ``m``. quantities: with their locations. stated_unit: of the linkage or the follower.

    Raises ``InputError`` where a quantity has another unit. Bare numbers are in rad where no unit is stated.
    """
    unit = stated_unit
    for location, value in output_values:
        bare, _ = _without_angle(value)
        if unit is None and isinstance(bare, str):
            unit = next((u for u, definition in UNITS.items() if _is_readable(definition, bare)), None)
            if unit is None:
                raise InputError(location, value, "must be an angle or a length, such as '24 deg' or '10 mm'")
        if unit is not None:
            read_quantity(UNITS[unit], bare, location)
    return unit or "rad"


def _is_readable(unit: Unit, text: str) -> bool:
    return unit.accepts(text) and any(c.isalpha() or c == "°" for c in text)


@dataclass(frozen=True, eq=False)
class MotionLaw:
    """Motion law of the output.

    function: of the cam angle, in ``unit`` (rad or m). count: of its harmonics, None where they are infinitely many.
    restrictions: of its synthesis.
    """

    function: Law
    unit: str
    count: int | None = None
    restrictions: tuple[Restriction, ...] = ()

    @property
    def dwells(self) -> tuple[Band, ...]:
        """Restrictions by which the output rests on an arc: those whose band is narrow against the stroke."""
        narrow = _NARROW * float(np.ptp(self.function(even_angles(_STROKE_SAMPLES))))
        arcs = [r for r in self.restrictions if isinstance(r, Band) and r.order == 0 and r.end > r.begin]
        return tuple(band for band in arcs if band.high - band.low <= narrow)

    @property
    def series(self) -> FourierSeries | None:
        """The law where it is a finite series of harmonics, else None."""
        return None

    @property
    def jump(self) -> float:
        """The largest jump of the acceleration by the cam angle, in the unit of the output."""
        return 0.0

    @property
    def jump_places(self) -> str:
        """Where the acceleration jumps, in words."""
        return "where the rise and the return begin or end"

    @property
    def rise(self) -> np.ndarray | None:
        """The largest velocity, acceleration and jerk (3,) of a rise of 1 over an arc of 1: Cv, Ca, Cj; None of other laws."""
        return None

    def fourier_series(self) -> FourierSeries:
        """Return the law as a series; of a law with infinitely many harmonics as many as the samples resolve."""
        return self.series or FourierSeries.from_samples(self.function(even_angles(_SAMPLES)))

    def bounds(self, order: int) -> tuple[float, float]:
        """Return the least and the greatest value of a derivative, refined between the sampled angles."""
        lowest, highest = valleys(lambda phi: self.function(phi, order))[1], valleys(lambda phi: -self.function(phi, order))[1]
        return float(lowest.min()), float(-highest.min())

    def peak(self, order: int) -> float:
        """Return the largest magnitude of a derivative of an order from 1 to 3."""
        least, greatest = self.bounds(order)
        return max(-least, greatest)

    def extremes(self, band: Band) -> tuple[float, float]:
        """Return the least and the greatest value of the restricted derivative, on the arc of the restriction."""
        at = np.linspace(band.begin, band.end, _FINE if band.end > band.begin else 1)
        values = self.function(at, band.order)
        return float(values.min()), float(values.max())


@dataclass(frozen=True, eq=False)
class SeriesMotionLaw(MotionLaw):
    """A motion of finitely many harmonics."""

    function: FourierSeries

    @property
    def series(self) -> FourierSeries:
        """See ``MotionLaw``."""
        return self.function

    def bounds(self, order: int) -> tuple[float, float]:
        """See ``MotionLaw``."""
        return self.function.derivative(order).bounds

    def extremes(self, band: Band) -> tuple[float, float]:
        """See ``MotionLaw``."""
        return band_extremes(band, self.function)


@dataclass(frozen=True, eq=False)
class SegmentedMotionLaw(MotionLaw):
    """A motion in segments, each with a law of its own."""

    function: SegmentedMotion

    @property
    def jump(self) -> float:
        """See ``MotionLaw``."""
        return max(self.function.jumps(2).values(), default=0.0)

    @property
    def jump_places(self) -> str:
        """See ``MotionLaw``."""
        angles = sorted(math.degrees(angle) % 360 for angle in self.function.jumps(2))
        return f"at {', '.join(f'{angle:.4g}°' for angle in angles)}"

    def peak(self, order: int) -> float:
        """See ``MotionLaw``: exactly."""
        return self.function.largest(order)


@dataclass(frozen=True, eq=False)
class RiseMotionLaw(MotionLaw):
    """A motion that rises, rests and returns."""

    function: RiseAndReturn

    @property
    def jump(self) -> float:
        """See ``MotionLaw``."""
        return self.function.jump

    @property
    def jump_places(self) -> str:
        """See ``MotionLaw``."""
        return f"{super().jump_places}{', and within them' if len(self.function.law.inner_jumps(2)) else ''}"

    @property
    def rise(self) -> np.ndarray:
        """See ``MotionLaw``."""
        return np.array([self.function.law.Cv, self.function.law.Ca, self.function.law.Cj])

    def peak(self, order: int) -> float:
        """See ``MotionLaw``: exactly."""
        return self.function.largest(order)


class LawTable(TableModel, ABC):
    """A law of some kind: the table [law]."""

    @classmethod
    def error_location(cls) -> str:
        """Return its path in a file."""
        return "law"

    @classmethod
    def with_file_contents(cls, entries: Mapping[str, Any], folder: Path, unit: str | None) -> Mapping[str, Any]:
        """Return the entries of the table with the content of its files. unit: of the output, None where unknown.

        Raises ``InputError``.
        """
        return entries

    @property
    def stated_unit(self) -> str | None:
        """The unit of the output, if the table itself states it."""
        return None

    def output_values(self) -> Iterator[tuple[str, float | str]]:
        """Yield the location and the value of each position."""
        yield from ()

    @abstractmethod
    def make_motion_law(self, unit: str) -> MotionLaw:
        """Return the law of an output whose positions are in rad or m. Raises ``InputError``."""
