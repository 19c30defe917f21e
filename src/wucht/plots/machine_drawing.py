"""A machine drawn from the numbers of its result: carrier on springs, rotors with their unbalance, tracks and bodies.

Bodies of a rotor are spread evenly, whatever their angles at the start are.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING, Any

from wucht.machine_shape import MachineShape, MountShape, RotorShape, machine_shape
from wucht.plots.page import REPORT, page_context
from wucht.plots.style import COLOURS, GREY

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

    from wucht.results.accessor import ResultAccessor

__all__ = ["MachineShape", "draw_machine", "shape_in_result"]

_LARGEST_HEIGHT, _INCHES = 3.3, 6.2  # of the drawing
_FIRST_BODY = math.radians(60)  # the angle of the first body of a rotor: neither the unbalance nor the name is there
_BACKGROUND = {"facecolor": "white", "edgecolor": "none", "pad": 0.6, "alpha": 0.85}  # of names
_AT_CENTRE: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": REPORT.small}
_LINE: dict[str, Any] = {"color": "black", "linewidth": 0.9, "solid_capstyle": "round"}


def shape_in_result(result: ResultAccessor) -> MachineShape | None:
    """The shape of the machine of a result, None for a result of another subject, or of a version that recorded no parts."""
    bodies = result.machine.get("bodies")
    if not bodies or not result.parts:
        return None
    values = {path: value for path, value in result.machine["parameters"].items() if isinstance(value, int | float)}
    return machine_shape(bodies, values, result.parts, dimensionless=result.dimensionless)


def draw_machine(result: Any) -> Figure | None:
    """Draw the machine of a result.

    Parameters
    ----------
    result : xarray.Dataset

    Returns
    -------
    matplotlib.figure.Figure or None
        None where the result has no machine, or was written by a version that did not record its parts.
    """
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    shape = shape_in_result(result.wucht)
    if shape is None:
        return None
    with page_context(REPORT):
        figure = Figure(figsize=(_INCHES, _LARGEST_HEIGHT), dpi=REPORT.dpi)
        FigureCanvasAgg(figure)
        axis = figure.add_axes((0.0, 0.0, 1.0, 1.0))
        axis.set_aspect("equal", adjustable="box")
        axis.set_axis_off()
        _draw(axis, shape)
        x, y = axis.dataLim.intervalx, axis.dataLim.intervaly
        scale = min(_INCHES / (x[1] - x[0]), _LARGEST_HEIGHT / (y[1] - y[0]))
        figure.set_size_inches(max((x[1] - x[0]) * scale, 1.0), max((y[1] - y[0]) * scale, 1.0))
        axis.set(xlim=x, ylim=y)
    return figure


def _draw(axis: Axes, shape: MachineShape) -> None:
    from matplotlib.patches import FancyBboxPatch

    left, bottom, right, top = shape.box
    unit = shape.size
    rounding = 0.05 * unit
    box = FancyBboxPatch(
        (left + rounding, bottom + rounding), right - left - 2 * rounding, top - bottom - 2 * rounding,
        boxstyle=f"round,pad={rounding}", facecolor="#F1F3F5", edgecolor="black", linewidth=1.1, zorder=1,
    )  # fmt: skip
    axis.add_patch(box)
    for mount in shape.mounts:
        _draw_mount(axis, mount, 0.3 * unit, 0.055 * unit, foundation=shape.foundation and mount.dy < 0)
    if shape.pivot:
        _draw_pivot(axis, 0.0, bottom, 0.12 * unit)
    if shape.is_fixed:
        _draw_ground(axis, (left + right) / 2, bottom, 0.0, -1.0, 0.45 * unit)
    for rotor in shape.rotors:
        _draw_rotor(axis, rotor, unit)
    for part in shape.attachments:
        if part.x is not None and part.y is not None:
            axis.plot([part.x], [part.y], marker="s", markersize=5, color=COLOURS[1], zorder=6)
            label = f"{part.name} ({part.kind})"
            axis.annotate(label, (part.x, part.y), (0, -9), textcoords="offset points", **_AT_CENTRE, zorder=8)
    lines = [f"{part.name} ({part.kind})" for part in shape.attachments if part.x is None]
    lines += ["prescribed motion"] * shape.is_shaken
    for k, line in enumerate(reversed(lines)):
        axis.text((left + right) / 2, top + (0.05 + 0.08 * k) * unit, line, **_AT_CENTRE)
        axis.update_datalim([(left, top + (0.1 + 0.08 * k) * unit)])
    _draw_scale(axis, shape)


def _draw_mount(axis: Axes, mount: MountShape, length: float, width: float, *, foundation: bool) -> None:
    """A spring, beside it a damper where there is damping, and the ground."""
    along, across = (mount.dx, mount.dy), (-mount.dy, mount.dx)

    def at(s: float, t: float) -> tuple[float, float]:
        return mount.x + s * along[0] + t * across[0], mount.y + s * along[1] + t * across[1]

    def line(points: list[tuple[float, float]], **look: Any) -> None:
        axis.plot(*zip(*(at(s, t) for s, t in points), strict=True), **_LINE | look, zorder=3)

    spring = -width if mount.has_damper else 0.0
    turns = [(length * (0.2 + 0.6 * k / 12), spring + width * 0.6 * (-1) ** k * (0 < k < 12)) for k in range(13)]
    line([(0.0, spring), (0.2 * length, spring), *turns, (length, spring)])
    if mount.has_damper:
        line([(0.0, width), (0.5 * length, width)])
        line([(0.5 * length, 0.45 * width), (0.5 * length, 1.55 * width)])
        line(
            [
                (0.38 * length, 0.3 * width),
                (0.65 * length, 0.3 * width),
                (0.65 * length, 1.7 * width),
                (0.38 * length, 1.7 * width),
            ]
        )
        line([(0.65 * length, width), (length, width)])
    x, y = at(length, 0.0)
    if foundation:
        from matplotlib.patches import Rectangle

        half = 5 * width
        axis.add_patch(
            Rectangle((x - half, y - 2 * width), 2 * half, 2 * width, facecolor="#DADDE0", edgecolor="black", zorder=2)
        )
        axis.text(x, y - width, "foundation", **_AT_CENTRE, zorder=7)
        below = MountShape(x, y - 2 * width, 0.0, -1.0, mount.has_damper)
        _draw_mount(axis, below, length, width, foundation=False)
        return
    _draw_ground(axis, x, y, *along, 5 * width)
    if mount.name:
        axis.text(*at(length * 1.3, 0.0), f"mount {mount.name}", **_AT_CENTRE, zorder=7)


def _draw_ground(axis: Axes, x: float, y: float, dx: float, dy: float, width: float) -> None:
    """A hatched line across a direction."""
    count, depth = 6, 0.16 * width
    axis.plot([x + dy * width / 2, x - dy * width / 2], [y - dx * width / 2, y + dx * width / 2], **_LINE, zorder=3)
    for k in range(count):
        t = width * ((k + 0.8) / count - 0.5)
        x0, y0 = x - dy * t, y + dx * t
        axis.plot([x0, x0 + depth * (dx + dy)], [y0, y0 + depth * (dy - dx)], **_LINE | {"linewidth": 0.6}, zorder=3)


def _draw_pivot(axis: Axes, x: float, y: float, size: float) -> None:
    axis.plot([x, x - size / 2, x + size / 2, x], [y, y - size, y - size, y], **_LINE, zorder=3)
    _draw_ground(axis, x, y - size, 0.0, -1.0, 2 * size)


def _draw_rotor(axis: Axes, rotor: RotorShape, unit: float) -> None:
    from matplotlib.patches import Circle, FancyArrowPatch

    x, y, r = rotor.x, rotor.y, rotor.radius
    axis.add_patch(Circle((x, y), r, facecolor="white", edgecolor="black", linewidth=1.1, zorder=2))
    for track in sorted({b.track for b in rotor.bodies if b.track}):
        axis.add_patch(Circle((x, y), track, facecolor="none", edgecolor=GREY, linewidth=0.8, zorder=2.5))
    axis.plot([x], [y], marker="+", markersize=7, color="black", markeredgewidth=0.9, zorder=5)
    axis.plot([x + 0.5 * r], [y], marker="o", markersize=5, color="black", zorder=5)
    axis.plot([x, x + 0.5 * r], [y, y], **_LINE | {"linewidth": 0.6}, zorder=4)
    if rotor.sense:
        ends = [(x + 0.3 * r * math.cos(a), y + 0.3 * r * math.sin(a)) for a in (math.radians(35), math.radians(145))]
        start, end = ends if rotor.sense > 0 else reversed(ends)
        bend = 0.5 * rotor.sense
        axis.add_patch(FancyArrowPatch(
            start, end, connectionstyle=f"arc3,rad={bend}", arrowstyle="-|>", mutation_scale=7, linewidth=0.9,
            color=COLOURS[1], zorder=5,
        ))  # fmt: skip
    _draw_bodies(axis, rotor, unit)
    axis.text(x, y - r - 0.05 * unit, rotor.name, **_AT_CENTRE, zorder=8)


def _draw_bodies(axis: Axes, rotor: RotorShape, unit: float) -> None:
    from matplotlib.patches import Circle

    x, y, count = rotor.x, rotor.y, len(rotor.bodies)
    for k, body in enumerate(rotor.bodies):
        angle = _FIRST_BODY + 2 * math.pi * k / count
        bx, by = x + body.reach * math.cos(angle), y + body.reach * math.sin(angle)
        if not body.track:
            axis.plot([x, bx], [y, by], color=COLOURS[0], linewidth=1.4, zorder=3)
        size = body.size or 0.035 * unit
        axis.add_patch(Circle((bx, by), size, facecolor=COLOURS[0], edgecolor="black", linewidth=0.6, zorder=6))
        inward = body.reach > 0.45 * rotor.radius
        at = body.reach - size - 0.055 * unit if inward else body.reach + size + 0.055 * unit
        axis.text(
            x + at * math.cos(angle), y + at * math.sin(angle), body.name, **_AT_CENTRE, zorder=7, bbox=_BACKGROUND,
        )  # fmt: skip


def _draw_scale(axis: Axes, shape: MachineShape) -> None:
    """A length to compare with, below the machine on the right; and room around everything."""
    axis.autoscale_view()
    x, y = axis.dataLim.intervalx, axis.dataLim.intervaly
    pad = 0.05 * max(x[1] - x[0], y[1] - y[0])
    if shape.to_scale:
        length = _round_length(0.3 * shape.size)
        right, low = x[1] + 0.4 * length, y[0] + pad
        axis.plot([right, right + length], [low, low], **_LINE | {"linewidth": 1.6}, zorder=3)
        for end in (right, right + length):
            axis.plot([end, end], [low - 0.25 * pad, low + 0.25 * pad], **_LINE, zorder=3)
        text = f"{length * 1e3:g} mm" if length < 1.0 else f"{length:g} m"
        axis.text(right + length / 2, low + 0.5 * pad, text, ha="center", va="bottom", fontsize=REPORT.small)
        x = (x[0], max(x[1], right + length))
    axis.update_datalim([(x[0] - pad, y[0] - 1.2 * pad), (x[1] + pad, y[1] + pad)])


def _round_length(length: float) -> float:
    """The largest of 1, 2, 5 times a power of ten that is no more than a length."""
    power = 10.0 ** math.floor(math.log10(length))
    return max(n * power for n in (1.0, 2.0, 5.0) if n * power <= length * (1 + 1e-9))
