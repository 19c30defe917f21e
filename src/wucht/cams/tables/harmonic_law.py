"""The table [law] of a motion of finitely many harmonics: restrictions, an objective, caps and a resonance; or coefficients."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Sequence
from typing import ClassVar, Literal

import numpy as np
from pydantic import Field

from wucht.cams.laws.cone_programme import InfeasibleError
from wucht.cams.laws.synthesis import Band, Cap, Restriction, Synthesis, single_relaxations, synthesise
from wucht.cams.tables.motion_law import LawTable, Position, SeriesMotionLaw, read_output
from wucht.errors import InputError, RunError
from wucht.numerics.fourier_series import FourierSeries
from wucht.numerics.zeros_and_peaks import fewest_where
from wucht.schema import SI, Composite, TableModel, composite, si

_ORDERS = ("position", "velocity", "acceleration", "jerk")
_TURN = 2 * math.pi
_MOST = 60  # harmonics
_MORE = 3  # times the harmonics, at most, that are tried where these are too few
_FLATTEST, _LEAST_PEAK, _LEAST_SQUARE = "flattest-dwell", "least-peak-acceleration", "least-mean-square-acceleration"


class RestrictionTable(TableModel):
    """Restriction of a derivative by the cam angle at an angle, on an arc, or (without either) everywhere."""

    of: Literal["position", "velocity", "acceleration", "jerk"] = Field(
        default="position", description="derivative with respect to the cam angle"
    )
    at: SI[float | None] = si("rad", "cam angle", default=None, help="cam angle at which it holds")
    on: SI[tuple[float, float] | None] = si("rad", "arc of the cam angle", default=None, help="arc on which it holds")
    equals: Position | None = Field(default=None, title="value", description="value that it must have")
    min: Position | None = Field(default=None, title="least value", description="least value that it may have")
    max: Position | None = Field(default=None, title="greatest value", description="greatest value that it may have")
    tolerance: Position | None = Field(default=None, description="tolerance of equals on an arc")

    def output_values(self, location: str) -> Iterator[tuple[str, float | str]]:
        """See ``LawTable``."""
        for key in ("equals", "min", "max", "tolerance"):
            value = getattr(self, key)
            if value is not None:
                yield f"{location}.{key}", value

    def band(self, location: str, unit: str, objective: str) -> Band:
        """Return it as a restriction of the synthesis. Raises ``InputError`` where keys are inconsistent."""
        order = _ORDERS.index(self.of)
        values = {w.rsplit(".", 1)[1]: read_output(unit, q, w, order) for w, q in self.output_values(location)}
        if self.at is not None and self.on is not None:
            raise InputError(f"{location}.on", list(self.on), "give either at or on")
        begin, end = (self.at, self.at) if self.at is not None else self.on or (0.0, _TURN)
        if end < begin:
            end = begin + math.remainder(end - begin - math.pi, _TURN) + math.pi
        if end - begin > _TURN * (1 + 1e-12):
            raise InputError(f"{location}.on", self.on and list(self.on), "must be an arc of at most one turn")
        low, high, is_widened = values.get("min", -math.inf), values.get("max", math.inf), False
        if "equals" in values:
            if "min" in values or "max" in values:
                raise InputError(f"{location}.equals", self.equals, "give either equals, or min and max")
            tolerance = values.get("tolerance", 0.0)
            if tolerance < 0:
                raise InputError(f"{location}.tolerance", self.tolerance, "must not be negative")
            is_widened = begin != end and "tolerance" not in values
            if is_widened and objective != _FLATTEST:
                requirement = (
                    "on an arc equals needs a tolerance: a motion of finitely many harmonics cannot be constant on an arc"
                )
                raise InputError(f"{location}.tolerance", None, f"{requirement}; or objective = {_FLATTEST!r}")
            low, high = values["equals"] - tolerance, values["equals"] + tolerance
        elif not values or "tolerance" in values:
            raise InputError(location, None, "give equals (on an arc with a tolerance), or min, max or both")
        if low > high:
            raise InputError(f"{location}.min", self.min, "must not be greater than max")
        return Band(location, order, begin, end, low, high, is_widened)


class CapTable(TableModel):
    """The largest amplitude of a harmonic."""

    harmonic: int = Field(ge=1, description="number of the harmonic")
    amplitude: Position = Field(title="largest amplitude", description="largest amplitude that the harmonic may have")


class Coefficients(TableModel):
    """A series that is known: mean + sum of cosine_k cos k phi + sine_k sin k phi, the first harmonic first."""

    mean: Position = Field(default=0.0, title="mean value", description="mean value of the motion")
    cosine: Composite[tuple[Position, ...]] = composite(
        default=(), title="cosine coefficients", description="cosines, the first harmonic first"
    )
    sine: Composite[tuple[Position, ...]] = composite(
        default=(), title="sine coefficients", description="sines, the first harmonic first"
    )

    def output_values(self) -> Iterator[tuple[str, float | str]]:
        """See ``LawTable``."""
        yield "law.coefficients.mean", self.mean
        for key in ("cosine", "sine"):
            yield from ((f"law.coefficients.{key}[{i}]", value) for i, value in enumerate(getattr(self, key)))


class Resonance(TableModel):
    """The resonance of the elastic output: orders near it weigh more."""

    frequency: SI[float] = si("rad/s", "natural frequency", gt=0, help="natural frequency of the elastic output")
    damping_ratio: SI[float] = si("", "damping ratio", default=0.02, gt=0, lt=1, help="damping ratio of the elastic output")
    speed: SI[float] = si("rad/s", "mean speed of the cam", gt=0)

    def magnification(self, count: int) -> np.ndarray:
        """|H| (N,) of orders 1 to N."""
        ratio = np.arange(1, count + 1) * self.speed / self.frequency
        return np.asarray(1 / np.abs(1 - ratio**2 + 2j * self.damping_ratio * ratio))


class HarmonicLawTable(LawTable):
    """A motion of finitely many harmonics, synthesised from restrictions or known by its coefficients."""

    kind: ClassVar[str] = "harmonic"

    harmonics: int | None = Field(default=None, ge=1, le=_MOST, description="number of harmonics")
    objective: Literal["flattest-dwell", "least-peak-acceleration", "least-mean-square-acceleration"] = Field(
        default="flattest-dwell", description="criterion by which a motion is chosen among those that keep the restrictions"
    )
    restrictions: Composite[tuple[RestrictionTable, ...]] = composite(
        default=(),
        title="restrictions",
        description="values or limits of the motion at angles or on arcs, tables: `[[law.restrictions]]`",
    )
    caps: Composite[tuple[CapTable, ...]] = composite(default=(), description="largest amplitudes of harmonics")
    resonance: Composite[Resonance | None] = composite(
        default=None, description="resonance near which orders weigh more, a table: `[law.resonance]`"
    )
    coefficients: Composite[Coefficients | None] = composite(
        default=None,
        description="coefficients of a motion that is known, instead of restrictions, a table: `[law.coefficients]`",
    )

    def output_values(self) -> Iterator[tuple[str, float | str]]:
        """See ``LawTable``."""
        if self.coefficients is not None:
            yield from self.coefficients.output_values()
        for i, restriction in enumerate(self.restrictions):
            yield from restriction.output_values(f"law.restrictions[{i}]")
        yield from ((f"law.caps[{i}].amplitude", cap.amplitude) for i, cap in enumerate(self.caps))

    def make_motion_law(self, unit: str) -> SeriesMotionLaw:
        """See ``LawTable``."""
        if self.coefficients is not None:
            if self.restrictions or self.caps or self.resonance:
                raise InputError("law.coefficients", None, "give either coefficients or restrictions")
            c = self.coefficients
            values = {w: read_output(unit, q, w) for w, q in c.output_values()}
            cosine, sine = ([v for w, v in values.items() if f".{key}[" in w] for key in ("cosine", "sine"))
            if not cosine and not sine:
                raise InputError("law.coefficients", None, "give cosine or sine coefficients, the first harmonic first")
            law = FourierSeries.of(values["law.coefficients.mean"], cosine, sine)
            return SeriesMotionLaw(law, unit, law.count)
        return self._synthesised_law(unit)

    def _synthesised_law(self, unit: str) -> SeriesMotionLaw:
        if not self.restrictions:
            raise InputError("law.restrictions", None, "give [[law.restrictions]], or coefficients")
        if self.harmonics is None:
            raise InputError("law.harmonics", None, "this key is missing; give the number of harmonics", code="missing")
        count, restrictions = self.harmonics, self._read_restrictions(unit)
        if self.resonance is not None and self.objective != _LEAST_SQUARE:
            raise InputError(
                "law.resonance", None, f"allowed only with objective = {_LEAST_SQUARE!r}, whose harmonics it weights"
            )
        if self.objective == _LEAST_PEAK:
            objective = Band("law.objective", 2, 0.0, _TURN, 0.0, 0.0, is_widened=True)
            synthesis = _checked_synthesis(count, restrictions, [objective], None, unit)
        else:
            if self.objective == _FLATTEST and not any(r.is_widened for r in restrictions):
                requirement = "the flattest dwell needs a restriction on an arc with equals, without a tolerance"
                raise InputError("law.objective", self.objective, requirement)
            synthesis = _checked_synthesis(count, restrictions, [], self._weights(count), unit)
        return SeriesMotionLaw(synthesis.law, unit, count, restrictions)

    def _weights(self, count: int) -> np.ndarray | None:
        """Return the weights of the harmonics in the objective."""
        if self.objective != _LEAST_SQUARE:
            return None
        plain = np.arange(1, count + 1) ** 2
        return plain if self.resonance is None else plain * self.resonance.magnification(count)

    def _read_restrictions(self, unit: str) -> tuple[Restriction, ...]:
        restrictions: list[Restriction] = []
        for i, restriction in enumerate(self.restrictions):
            restrictions.append(restriction.band(f"law.restrictions[{i}]", unit, self.objective))
        for i, cap in enumerate(self.caps):
            location = f"law.caps[{i}]"
            if cap.harmonic > (self.harmonics or 0):
                raise InputError(f"{location}.harmonic", cap.harmonic, f"the law has {self.harmonics} harmonics")
            size = read_output(unit, cap.amplitude, f"{location}.amplitude")
            if size < 0:
                raise InputError(f"{location}.amplitude", cap.amplitude, "must not be negative")
            restrictions.append(Cap(location, cap.harmonic, size))
        _refuse_points_in_dwells([r for r in restrictions if isinstance(r, Band)])
        return tuple(restrictions)


def _refuse_points_in_dwells(bands: Sequence[Band]) -> None:
    """Raise ``InputError`` where a precision point lies on a widened arc that prescribes another value."""
    for point, arc in itertools.product(bands, bands):
        on = (point.begin - arc.begin) % _TURN <= arc.end - arc.begin
        if point.is_exact and arc.is_widened and point.order == arc.order and on and point.low != arc.low:
            requirement = f"it lies on the arc of {arc.name}, which prescribes another value; an arc goes from begin up to end"
            raise InputError(point.name, None, requirement)


def _checked_synthesis(
    count: int, restrictions: Sequence[Restriction], objective: Sequence[Restriction], weights: np.ndarray | None, unit: str
) -> Synthesis:
    """Return the synthesis. Raises ``InputError`` with possible relaxations where restrictions contradict each other."""
    try:
        return synthesise(count, [*restrictions, *objective], weights)
    except InfeasibleError:
        raise _contradiction(count, restrictions, unit) from None


def _contradiction(count: int, restrictions: Sequence[Restriction], unit: str) -> InputError:
    """Return the error that names possible relaxations, their amounts, and a sufficient number of harmonics."""
    relaxations = single_relaxations(count, restrictions)
    remedies = [f"{restriction.name} alone by {_amount(restriction, by, unit)}" for restriction, by in relaxations]
    gives = f"relax {', or '.join(remedies)}" if remedies else "more than one of them must be relaxed"
    more = _enough_harmonics(count, restrictions)
    enough = f"; {more} harmonics are enough" if more else ""
    return InputError("law.restrictions", None, f"no motion of {count} harmonics satisfies them all; {gives}{enough}")


def _enough_harmonics(count: int, restrictions: Sequence[Restriction]) -> int | None:
    """Return the fewest harmonics that are enough; None where the largest number tried is too small."""
    most = min(_MORE * count, _MOST)
    if most <= count or not _is_feasible(most, restrictions):
        return None
    return fewest_where(lambda trial_count: _is_feasible(trial_count, restrictions), count, most)


def _is_feasible(count: int, restrictions: Sequence[Restriction]) -> bool:
    try:
        synthesise(count, [r for r in restrictions if not r.is_widened], np.arange(1, count + 1) ** 2)
    except (InfeasibleError, RunError):
        return False
    return True


def _amount(restriction: Restriction, by: float, unit: str) -> str:
    quantity, order = (math.degrees(by), "deg") if unit == "rad" else (1e3 * by, "mm"), 0
    if isinstance(restriction, Band):
        order = restriction.order
    by_angle = ("", "/rad", "/rad^2", "/rad^3")[order]
    return f"{quantity[0]:.3g} {quantity[1]}{by_angle}"
