"""The motion law of a cam drive: synthesised, standard or given, with its derivatives and its spectrum."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING, ClassVar

import numpy as np
from pydantic import Field

from wucht.cams.drive import CamDrive
from wucht.cams.laws.synthesis import Band, Cap, Restriction
from wucht.cams.tables.motion_law import MotionLaw
from wucht.dynamics.work import Work
from wucht.numerics.fourier_series import FourierSeries
from wucht.plots.cam_drawings import draw_motion, order_scale
from wucht.plots.scales import travel_unit, turn_scale
from wucht.plots.sheet import labelled_handles, legend_below, new_grid
from wucht.plots.style import COLOURS, GREY
from wucht.results.formatting import ReportLines, with_unit
from wucht.results.quantities import Quantity, result_dataset
from wucht.studies.next_question import NextQuestion
from wucht.studies.spec import Spec, Whole

if TYPE_CHECKING:
    import xarray as xr
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure


class CamLaw(Spec):
    """Motion of the output of a cam drive over the cam angle."""

    kind: ClassVar[str] = "cam-law"
    next_questions: ClassVar[tuple[NextQuestion, ...]] = (
        NextQuestion("the cam that does it, checked and ready to mill", {"study.kind": "cam-contour"}),
    )
    solves: ClassVar[str] = "motion over the cam angle: no speed is assumed"
    subject: ClassVar[str] = "wucht.studies.cam_drives:CAM_DRIVE"
    curves: ClassVar[tuple[tuple[str, str], ...]] = (("cam_angle", "position"), ("cam_angle", "acceleration"))

    points: Whole = Field(
        default=720, ge=16, le=1_000_000, description="number of cam angles of the law, evenly spaced over a turn"
    )
    orders: Whole = Field(default=20, ge=1, le=500, description="number of harmonics shown of a law with infinitely many")


@dataclass(frozen=True, eq=False)
class Plan:
    """The motion law, the number of its cam angles, and the number of its harmonics."""

    motion_law: MotionLaw
    points: int
    orders: int


def prepare(spec: CamLaw, drive: CamDrive) -> Plan:
    """The plan. Raises ``InputError`` if no such law exists, with the restriction to be relaxed and by how much."""
    return Plan(drive.motion_law, spec.points, drive.motion_law.count or spec.orders)


@dataclass(frozen=True, eq=False)
class Findings:
    """angles (N,). derivatives (4, N): of orders 0 to 3. harmonics: of the motion. least, greatest: of the motion. peaks (4,):
    the largest magnitude of each derivative. attained_ranges: least and greatest value under each restriction (R, 2). jump:
    the largest of the acceleration; rise (3,): Cv, Ca and Cj of a standard law, None for others."""

    angles: np.ndarray
    derivatives: np.ndarray
    fourier_series: FourierSeries
    least: float
    greatest: float
    peaks: np.ndarray
    attained_ranges: np.ndarray
    jump: float
    rise: np.ndarray | None


def run(plan: Plan, work: Work) -> Iterator[Findings]:
    """Evaluate the law in one step: it takes milliseconds."""
    work.report(0.0, "motion law")
    motion_law = plan.motion_law
    angles = np.linspace(0, 2 * np.pi, plan.points + 1)
    derivatives = np.array([motion_law.function(angles, order) for order in range(4)])
    complete_series = motion_law.fourier_series()
    series = FourierSeries(complete_series.mean, complete_series.cosine[: plan.orders], complete_series.sine[: plan.orders])
    least, greatest = motion_law.bounds(0)
    peaks = np.array([max(-least, greatest), *(motion_law.peak(order) for order in (1, 2, 3))])
    attained_ranges = np.array([_attained_range(r, motion_law, series) for r in motion_law.restrictions]).reshape(-1, 2)
    yield Findings(angles, derivatives, series, least, greatest, peaks, attained_ranges, motion_law.jump, motion_law.rise)


def _attained_range(restriction: Restriction, motion_law: MotionLaw, series: FourierSeries) -> tuple[float, float]:
    """Least and greatest value of the restricted quantity."""
    if isinstance(restriction, Cap):
        return 0.0, float(series.amplitudes[restriction.harmonic - 1])
    return motion_law.extremes(restriction)


_NAMES = ("position", "velocity", "acceleration", "jerk")


def dataset(plan: Plan, findings: Findings) -> xr.Dataset:
    """Build the Dataset of a motion law."""
    quantities = [
        *_motion_quantities(plan, findings),
        *_restriction_quantities(plan, findings),
        *_summary_quantities(plan, findings),
    ]
    return result_dataset(quantities, _sentence(plan), _warnings(findings))


def _motion_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    """The motion and its derivatives over the cam angle, and its harmonics."""
    unit = plan.motion_law.unit
    long_names = ["motion of the output", *(f"{name} with respect to the cam angle" for name in _NAMES[1:])]
    derivatives = zip(_NAMES, f.derivatives, long_names, _units(plan), strict=True)
    return [
        Quantity("cam_angle", f.angles, "cam angle", "rad", "cam_angle"),
        *(Quantity(name, values, long_name, per, "cam_angle") for name, values, long_name, per in derivatives),
        Quantity("mean", f.fourier_series.mean, "mean of the motion", unit, ""),
        Quantity("order", np.arange(1, f.fourier_series.count + 1), "order", "", "order"),
        Quantity("cosine", f.fourier_series.cosine, "cosine coefficient", unit, "order"),
        Quantity("sine", f.fourier_series.sine, "sine coefficient", unit, "order"),
        Quantity("amplitude", f.fourier_series.amplitudes, "amplitude", unit, "order"),
    ]


def _units(plan: Plan) -> list[str]:
    """Units of the motion and its derivatives by the cam angle."""
    return [f"{plan.motion_law.unit}{per}" for per in ("", "/rad", "/rad^2", "/rad^3")]


def _restriction_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    """The restrictions with their arcs, and the values of the motion there."""
    restrictions = plan.motion_law.restrictions
    bands = [r if isinstance(r, Band) else Band(r.name, -1, math.nan, math.nan, 0.0, r.size) for r in restrictions]
    capped_harmonics = [0 if isinstance(r, Band) else r.harmonic for r in restrictions]
    along = "restriction"
    return [
        Quantity("restriction", [r.name for r in restrictions], "restriction", "", along),
        Quantity("restricted", [b.order for b in bands], "restricted derivative, -1: a harmonic is capped", "", along),
        Quantity("harmonic", capped_harmonics, "capped harmonic", "", along),
        Quantity("begin", [b.begin for b in bands], "start of the arc", "rad", along),
        Quantity("end", [b.end for b in bands], "end of the arc", "rad", along),
        Quantity("low", [b.low for b in bands], "least value allowed", "", along),
        Quantity("high", [b.high for b in bands], "greatest value allowed", "", along),
        Quantity("least", f.attained_ranges[:, 0], "least value", "", along),
        Quantity("greatest", f.attained_ranges[:, 1], "greatest value", "", along),
    ]


def _summary_quantities(plan: Plan, f: Findings) -> list[Quantity]:
    """Further quantities of the summary."""
    unit, units, series = plan.motion_law.unit, _units(plan), f.fourier_series
    peaks = {name: (f"largest {name}", per) for name, per in zip(_NAMES, units, strict=True)}
    rise = None if f.rise is None else dict(zip(_NAMES[1:], f.rise.tolist(), strict=True))
    coefficients = {"mean": series.mean, "cosine": series.cosine.tolist(), "sine": series.sine.tolist()}
    return [
        Quantity("unit", unit, "unit of the motion"),
        Quantity("stroke", f.greatest - f.least, "stroke", unit),
        Quantity("harmonics", plan.motion_law.count, "number of harmonics"),
        Quantity("ripple", _ripple(plan, f), "largest deviation from the restrictions in dwells", unit, headline=True),
        Quantity("peaks", dict(zip(_NAMES, f.peaks.tolist(), strict=True)), "largest values", parts=peaks, headline=_NAMES[1:]),
        Quantity("acceleration_jumps", f.jump, "largest jump of the acceleration", units[2]),
        Quantity("rise", rise, "largest values of a rise of 1 over an arc of 1"),
        Quantity("coefficients", coefficients, "coefficients of the harmonics", unit),
    ]


def _warnings(f: Findings) -> list[str]:
    """Warn of a jump of the acceleration, which is a shock."""
    if not f.jump:
        return []
    ends = "the acceleration jumps where the rise and the return begin or end, and the jerk has no bound there"
    return [f"{ends}: suitable for slow shafts only; polynomial and sine laws have no jumps"]


def _ripple(plan: Plan, f: Findings) -> float | None:
    """Largest deviation from the restrictions on the arcs to be held as tightly as possible, or else in the dwells."""
    restrictions = plan.motion_law.restrictions
    tight_names = {r.name for r in restrictions if r.is_widened} or {band.name for band in plan.motion_law.dwells}
    pairs = zip(restrictions, f.attained_ranges, strict=True)
    off = [
        np.abs(attained_range - (r.low + r.high) / 2).max()
        for r, attained_range in pairs
        if isinstance(r, Band) and r.name in tight_names
    ]
    return float(max(off)) if off else None


def _sentence(plan: Plan) -> str:
    count, restriction_count = plan.motion_law.count, len(plan.motion_law.restrictions)
    motion_text = (
        "a motion given by points or pieces" if count is None else f"a motion of {count} harmonic{'s' if count > 1 else ''}"
    )
    return motion_text + (
        f" meets {restriction_count} restriction{'s' if restriction_count > 1 else ''}" if restriction_count else ""
    )


_BINDS = 1e-5  # of its bound: distance below which a restriction is binding


def report(result: xr.Dataset) -> list[str]:
    """The lines that ``wucht run`` prints for a motion law."""
    lines = ReportLines(result)
    lines.add("stroke", "{stroke}")
    lines.add("dwell", "within {ripple} of the restrictions")
    for name in _NAMES[1:]:
        lines.add(name, f"at most {{peaks.{name}}}")
    lines.add("rise", "of 1 over an arc of 1: Cv = {rise.velocity:.5g}, Ca = {rise.acceleration:.5g}, Cj = {rise.jerk:.5g}")
    for i in range(result.sizes["restriction"]):
        lines.add("" if i else "restricted", "{restriction}", restriction=_restriction_in_words(result, lines, i))
    return lines.report(result.attrs["sentence"])


def _restriction_in_words(result: xr.Dataset, lines: ReportLines, i: int) -> str:
    """Attained values under a restriction, with a note if it is binding."""
    order = int(result.restricted.values[i])
    low, high, least, greatest = (float(result[n].values[i]) for n in ("low", "high", "least", "greatest"))
    of = result[_NAMES[max(order, 0)]]
    value_texts = [
        lines.format_value(value, of.units) for value in ((greatest,) if order < 0 or least == greatest else (least, greatest))
    ]
    size = max(abs(limit) for limit in (low, high) if math.isfinite(limit))
    binds = low < high and (greatest > high - _BINDS * size or (order >= 0 and least < low + _BINDS * size))
    name, quantity = str(result.restriction.values[i]).removeprefix("law."), "amplitude" if order < 0 else of.name
    return f"{name}: {quantity} {' to '.join(map(str, value_texts))}" + (" (binding)" if binds else "")


_PER = ("", "/rad", "/rad²", "/rad³")
_SHORT = 2.0  # degrees: shorter arcs are drawn as points


def figure(result: xr.Dataset) -> Figure:
    """Draw four panels over the cam angle, and the orders of motion and acceleration."""
    fig, axes = new_grid(6, result.attrs["title"], result.attrs["sentence"])
    for order, axis in enumerate(axes[:4]):
        _draw_derivative(axis, result, order)
    _draw_spectrum(axes[4], result, 0, "position")
    _draw_spectrum(axes[5], result, 2, "acceleration")
    legend_below(fig, labelled_handles(axes))
    return fig


def _draw_derivative(axis: Axes, result: xr.Dataset, order: int) -> None:
    look = {"color": COLOURS[0], "linewidth": 1.3, "label": "motion law"}
    unit = draw_motion(axis, result, _NAMES[order], _PER[order], **look)
    low, high = axis.get_ylim()
    for i in np.flatnonzero(result.restricted.values == order).tolist():
        _draw_restriction(axis, result, i, travel_unit(result.position)[0])
    if order:
        axis.set_ylim(low, high)
    turn_scale(axis)
    axis.set_ylabel(with_unit(_NAMES[order], unit))


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
    axis.set_ylabel(with_unit(f"{name}, amplitude", f"{unit}{_PER[power]}"))
    order_scale(axis, k)
    for i in np.flatnonzero(result.harmonic.values).tolist():
        cap, at = scale * result.high.values[i], float(result.harmonic.values[i])
        axis.plot([at - 0.5, at + 0.5], [at**power * cap] * 2, color=COLOURS[1], linewidth=2, label="cap of a harmonic")
