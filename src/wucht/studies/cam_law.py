"""The motion law of a cam drive: synthesised, standard or given, with its derivatives and its spectrum."""

from __future__ import annotations

import math
from collections.abc import Iterator
from typing import TYPE_CHECKING

import numpy as np
from pydantic import Field

from wucht.cams.drive import CamDrive
from wucht.cams.laws.synthesis import Band, Cap, Restriction
from wucht.cams.tables.motion_law import MotionLaw
from wucht.dynamics.work import Work
from wucht.numerics.fourier_series import FourierSeries
from wucht.plots.cam_drawings import LAW_NAMES, PER_ANGLE, draw_motion, order_scale
from wucht.plots.scales import travel_unit, turn_scale
from wucht.plots.sheet import labelled_handles, legend_below, new_grid
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import number_text, with_unit
from wucht.results.report import answer_in_print
from wucht.studies.answer import Answer
from wucht.studies.cam_answers import state_law, warn_of_jumps
from wucht.studies.key_types import Whole
from wucht.studies.next_question import NextQuestion
from wucht.studies.study import Study

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_BINDS = 1e-5  # of its bound: distance below which a restriction is binding
_SHORT = 2.0  # degrees: shorter arcs are drawn as points


class CamLaw(Study):
    """Motion of the output of a cam drive over the cam angle."""

    kind = "cam-law"
    next_questions = (NextQuestion("the cam that does it, checked and ready to mill", {"study.kind": "cam-contour"}),)
    solves = "motion over the cam angle: no speed is assumed"
    subject = "wucht.studies.cam_drives:CAM_DRIVE"
    curves = (("cam_angle", "position"), ("cam_angle", "acceleration"))

    points: Whole = Field(
        default=720, ge=16, le=1_000_000, description="number of cam angles of the law, evenly spaced over a turn"
    )
    orders: Whole = Field(default=20, ge=1, le=500, description="number of harmonics shown of a law with infinitely many")

    def prepare(self, drive: CamDrive) -> MotionLaw:
        """Return the law. Raises ``InputError`` if there is none, with the restriction to be relaxed and by how much."""
        return drive.motion_law

    def solve(self, drive: CamDrive, law: MotionLaw, work: Work) -> Iterator[Answer]:
        """Evaluate the law in one step: it takes milliseconds."""
        work.report(0.0, "motion law")
        a, restriction_count = Answer(), len(law.restrictions)
        a.sentence = "a motion given by points or pieces"
        if law.count is not None:
            a.sentence = f"a motion of {law.count} harmonic{'s' if law.count > 1 else ''}"
        if restriction_count:
            a.sentence += f" meets {restriction_count} restriction{'s' if restriction_count > 1 else ''}"
        angles = np.linspace(0, 2 * np.pi, self.points + 1)
        a.curve("cam_angle", angles, "cam angle", "rad")
        state_law(a, law.function, angles, "motion of the output", law.unit)
        complete_series, orders = law.fourier_series(), law.count or self.orders
        series = FourierSeries(complete_series.mean, complete_series.cosine[:orders], complete_series.sine[:orders])
        _state_series(a, law, series)
        attained_ranges = np.array([_attained_range(r, law, series) for r in law.restrictions]).reshape(-1, 2)
        _state_sizes(a, law, attained_ranges)
        _state_restrictions(a, law, attained_ranges)
        yield a

    def draw(self, result: xr.Dataset) -> Figure:
        """Draw four panels over the cam angle, and the orders of motion and acceleration."""
        fig, axes = new_grid(6, result.attrs["title"], answer_in_print(result))
        for order, axis in enumerate(axes[:4]):
            _draw_derivative(axis, result, order)
        _draw_spectrum(axes[4], result, 0, "position")
        _draw_spectrum(axes[5], result, 2, "acceleration")
        legend_below(fig, labelled_handles(axes))
        return fig


def _attained_range(restriction: Restriction, law: MotionLaw, series: FourierSeries) -> tuple[float, float]:
    """Return the least and greatest value of the restricted quantity."""
    if isinstance(restriction, Cap):
        return 0.0, float(series.amplitudes[restriction.harmonic - 1])
    return law.extremes(restriction)


def _state_series(a: Answer, law: MotionLaw, series: FourierSeries) -> None:
    a.curve("mean", series.mean, "mean of the motion", law.unit, "")
    a.curve("order", np.arange(1, series.count + 1), "order")
    a.curve("cosine", series.cosine, "cosine coefficient", law.unit, "order")
    a.curve("sine", series.sine, "sine coefficient", law.unit, "order")
    a.curve("amplitude", series.amplitudes, "amplitude", law.unit, "order")
    a.number("unit", law.unit, "unit of the motion")
    a.number("harmonics", law.count, "number of harmonics")
    a.number("coefficients", series.to_table(), "coefficients of the harmonics", law.unit)


def _state_sizes(a: Answer, law: MotionLaw, attained_ranges: np.ndarray) -> None:
    """State stroke, deviation from the dwells, and the largest values of the motion and its derivatives."""
    least, greatest = law.bounds(0)
    a.number("stroke", greatest - least, "stroke", law.unit)
    a.line("stroke", "{stroke}")
    ripple = _ripple(law, attained_ranges)
    a.number("ripple", ripple, "largest deviation from the restrictions in dwells", law.unit, headline=True)
    a.line("dwell", "within {ripple} of the restrictions")
    sizes = (max(-least, greatest), *(law.peak(order) for order in (1, 2, 3)))
    parts = {name: (f"largest {name}", f"{law.unit}{per}") for name, per in zip(LAW_NAMES, PER_ANGLE, strict=True)}
    a.number(
        "peaks", dict(zip(LAW_NAMES, map(float, sizes), strict=True)), "largest values", parts=parts, headline=LAW_NAMES[1:]
    )
    for name in LAW_NAMES[1:]:
        a.line(name, f"at most {{peaks.{name}}}")
    a.number("acceleration_jumps", law.jump, "largest jump of the acceleration", f"{law.unit}{PER_ANGLE[2]}")
    warn_of_jumps(a, law)
    rise = None if law.rise is None else dict(zip(LAW_NAMES[1:], law.rise.tolist(), strict=True))
    a.number("rise", rise, "largest values of a rise of 1 over an arc of 1")
    a.line("rise", "of 1 over an arc of 1: Cv = {rise.velocity:.5g}, Ca = {rise.acceleration:.5g}, Cj = {rise.jerk:.5g}")


def _ripple(law: MotionLaw, attained_ranges: np.ndarray) -> float | None:
    """Return the largest deviation from restrictions on the arcs to be held as tightly as possible, or else in the dwells."""
    tight_names = {r.name for r in law.restrictions if r.is_widened} or {band.name for band in law.dwells}
    off = [
        np.abs(attained_range - (r.low + r.high) / 2).max()
        for r, attained_range in zip(law.restrictions, attained_ranges, strict=True)
        if isinstance(r, Band) and r.name in tight_names
    ]
    return float(max(off)) if off else None


def _state_restrictions(a: Answer, law: MotionLaw, attained_ranges: np.ndarray) -> None:
    """State the restrictions with their arcs, and the values of the motion there."""
    restrictions, along = law.restrictions, "restriction"
    bands = [r if isinstance(r, Band) else Band(r.name, -1, math.nan, math.nan, 0.0, r.size) for r in restrictions]
    a.curve("restriction", [r.name for r in restrictions], "restriction")
    a.curve("restricted", [b.order for b in bands], "restricted derivative, -1: a harmonic is capped", "", along)
    capped_harmonics = [0 if isinstance(r, Band) else r.harmonic for r in restrictions]
    a.curve("harmonic", capped_harmonics, "capped harmonic", "", along)
    a.curve("begin", [b.begin for b in bands], "start of the arc", "rad", along)
    a.curve("end", [b.end for b in bands], "end of the arc", "rad", along)
    a.curve("low", [b.low for b in bands], "least value allowed", "", along)
    a.curve("high", [b.high for b in bands], "greatest value allowed", "", along)
    a.curve("least", attained_ranges[:, 0], "least value", "", along)
    a.curve("greatest", attained_ranges[:, 1], "greatest value", "", along)
    for i, (band, (least, greatest)) in enumerate(zip(bands, attained_ranges.tolist(), strict=True)):
        quantity, unit = (
            ("amplitude", law.unit) if band.order < 0 else (LAW_NAMES[band.order], law.unit + PER_ANGLE[band.order])
        )
        values = (greatest,) if band.order < 0 or least == greatest else (least, greatest)
        value_text = " to ".join(str(number_text(value, unit)) for value in values)
        note = " (binding)" if _is_binding(band, least, greatest) else ""
        a.line("" if i else "restricted", f"{{name}}: {quantity} {value_text}{note}", name=band.name.removeprefix("law."))


def _is_binding(band: Band, least: float, greatest: float) -> bool:
    """Return whether the motion comes near a bound; of a capped harmonic, of the order -1, only the greatest value has one."""
    size = max(abs(limit) for limit in (band.low, band.high) if math.isfinite(limit))
    comes_near = greatest > band.high - _BINDS * size or (band.order >= 0 and least < band.low + _BINDS * size)
    return band.low < band.high and comes_near


def _draw_derivative(axis: Axes, result: xr.Dataset, order: int) -> None:
    look = {"color": COLOURS[0], "linewidth": 1.3, "label": "motion law"}
    unit = draw_motion(axis, result, LAW_NAMES[order], PER_ANGLE[order], **look)
    low, high = axis.get_ylim()
    for i in np.flatnonzero(result.restricted.values == order).tolist():
        _draw_restriction(axis, result, i, travel_unit(result.position)[0])
    if order:
        axis.set_ylim(low, high)
    turn_scale(axis)
    axis.set_ylabel(with_unit(LAW_NAMES[order], unit))


def _draw_restriction(axis: Axes, result: xr.Dataset, i: int, scale: float) -> None:
    """Draw bounds as lines over their arc, or as triangles at an angle, precision points as dots."""
    begin, end = np.degrees(result.begin.values[i]), np.degrees(result.end.values[i])
    low, high = float(result.low.values[i]), float(result.high.values[i])
    at = end - begin < _SHORT
    for limit, sign in {low: "^", high: "v"}.items():
        if np.isfinite(limit) and at:
            mark, name = ("o", "precision point") if low == high else (sign, "restriction")
            axis.plot([begin % 360], [scale * limit], mark, color=COLOURS[1], markersize=5, label=name, zorder=5)
        elif np.isfinite(limit):
            for turn in (-360.0, 0.0, 360.0):
                ends = [begin + turn, end + turn]
                axis.plot(ends, [scale * limit] * 2, "--", color=COLOURS[1], linewidth=1.2, label="restriction")


def _draw_spectrum(axis: Axes, result: xr.Dataset, power: int, name: str) -> None:
    scale, unit = travel_unit(result.position)
    k = result.order.values
    axis.bar(k, scale * k**power * result.amplitude.values, width=0.6, color=COLOURS[0], edgecolor=GREY, linewidth=0.4)
    axis.set_ylabel(with_unit(f"{name}, amplitude", f"{unit}{PER_ANGLE[power]}"))
    order_scale(axis, k)
    for i in np.flatnonzero(result.harmonic.values).tolist():
        cap, at = scale * result.high.values[i], float(result.harmonic.values[i])
        axis.plot([at - 0.5, at + 0.5], [at**power * cap] * 2, color=COLOURS[1], linewidth=2, label="cap of a harmonic")
